"""The loop in real time with the winch behind a PLC by each of three ways, beside the loop with the virtual winch."""

import json
from pathlib import Path

import pytest
from domain_coordinator import domain_id

from tests.loop_runs import HAS_RUN, adapting, give
from tests.plc import KINDS, SPOILT, emulated

OPTIONS = ["--pacing", "realtime", "--duration", "180", "--set", "all.transient=80", "--set", "wave_vessel.ramp=20"]
KPIS = ("unit_sigma_m", "significant_residual_m", "uncompensated_sigma_m", "winch_speed_max_mps")
CLOSE = 0.2
"""The drive of the PLC is that of benchmark B2 but for its cycle and the way there, which add 10 to 40 ms of delay."""


def figures(domain: int, folder: Path, *more: str) -> dict[str, float]:
    """Return the figures of merit of a run in real time."""
    path = folder / "kpi.json"
    arguments = ["b2_calm_300", "--bag", str(folder / "run"), "--no-report", "--json", str(path), *OPTIONS, *more]
    run = give(domain, "run", *arguments, timeout=400.0)
    assert run.returncode in HAS_RUN, run.stdout + run.stderr
    found = json.loads(path.read_text())
    return {name: found[name] for name in KPIS}


@pytest.fixture(scope="module")
def virtual(tmp_path_factory):
    with domain_id() as domain:
        return figures(domain, tmp_path_factory.mktemp("virtual"))


@pytest.mark.long
@pytest.mark.parametrize("kind", [*KINDS, "spoilt udp"])
def test_b2_in_real_time_is_as_good_with_the_winch_behind_a_plc(kind, virtual, tmp_path):
    way, options = kind.split()[-1], SPOILT if kind.startswith("spoilt") else ()
    with emulated(way, *options) as plc, domain_id() as domain:
        path = tmp_path / "winch.yaml"
        path.write_text(plc.text_of_map())
        with adapting(domain, str(path)) as ended:
            found = figures(domain, tmp_path, "--replace", "virtual_winch=external")
    assert ended[0].returncode == 0, ended[0].err
    for name in KPIS:
        assert found[name] == pytest.approx(virtual[name], rel=CLOSE), name
