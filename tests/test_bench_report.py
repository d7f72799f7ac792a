"""What `make bench` prints of its measurements."""

import math

from benchmarks.bench.report import HOW_TO_GET_THE_PEER, tables

PEERS = {
    "RK2": {"ms_per_simulated_s": 22.0, "error_percent": 0.06},
    "RK4": {"ms_per_simulated_s": 30.0, "error_percent": 0.05},
}
ROW = {"segments": 20, "ms_per_simulated_s": 2.0, "error_percent": 0.05, "peers": PEERS, "ratio_to_moordyn": 11.0}


def test_without_the_peer_one_line_says_what_to_install():
    (_, line) = tables({"plant": [{**ROW, "peers": {}, "ratio_to_moordyn": math.nan}]})
    assert line == HOW_TO_GET_THE_PEER.format("MoorDyn")
    assert "--extra bench" in line
    assert "\n" not in line
    (table,) = tables({"plant": [ROW]})
    assert [str(column.header) for column in table.columns].count("error %") == 3


def test_statics_stand_beside_their_peer_where_it_is():
    row = {"cable": "slack", "ms": 0.1, "peer_ms": 0.2, "ratio_to_moorpy": 2.0, "difference_percent": 1e-9}
    (table,) = tables({"statics": [row]})
    assert len(table.columns) == 5
    (alone, line) = tables({"statics": [{**row, "peer_ms": math.nan, "ratio_to_moorpy": math.nan}]})
    assert len(alone.columns) == 2
    assert line == HOW_TO_GET_THE_PEER.format("MoorPy")


def test_the_processes_of_the_loop_bound_its_speed():
    loop = {
        "processes": 2,
        "ticks_per_s": 400.0,
        "real_time_factor": 20.0,
        "loop_age_p50_s": 1e-3,
        "loop_age_p99_s": 2e-3,
        "cpu_ms_per_tick": {"a": 1.0, "b": 3.0},
    }
    head, table, bound = tables({"loop": loop})
    assert head.startswith("loop over ROS, 2 processes, recorded: 400 ticks/s, 20.0 x real time")
    assert table.row_count == 3
    assert bound.startswith("that allows at most ")


def test_real_time_stands_beside_the_stalls_of_the_machine():
    figures = {"p50_s": 1e-4, "p99_s": 2e-3, "max_s": 0.02}
    row = {
        "rate_hz": 100.0,
        "duration_s": 600.0,
        "composed": False,
        **{f"loop_age_{name}": value for name, value in figures.items()},
        "missed_deadlines": 3,
        "load": 0.4,
        "cpu_ms_per_tick": {"cable_sim": 0.5},
        "histograms_ms": {"cable_sim: loop age": {"2": 590, "more": 10}},
        "stalls": {**figures, "histogram_ms": {"0.5": 600}},
    }
    head, ages, histograms, _ = tables({"realtime": [row]})
    assert head == "real time, 100 Hz for 600 s, 1 processes, recorded: 3 deadlines missed; load of the machine 0.4"
    assert ages.row_count == 2
    assert [str(column.header) for column in histograms.columns] == ["count up to [ms]", "0.5", "2", "more"]
