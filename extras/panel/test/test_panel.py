"""The operator's page: who is in command, alarms, what is drawn, who may open it, and the thread behind it."""

import asyncio
import math
import socket
import time

import pytest
from heave_bringup.cli import main
from heave_bringup.operate.requests import Answer, WinchLimits, request_limits
from heave_bringup.operate.situation import ControllerStatus, RunStatus, Situation, Trouble, WinchStatus
from heave_bringup.operate.tasks import EmergencyStop
from heave_node.interface.alarm import Severity
from heave_panel.alarm_list import AlarmList, alarms_of
from heave_panel.command_post import CommandPost
from heave_panel.guard import COOKIE, Guard, is_loopback
from heave_panel.history import LENGTH, LINES, History
from heave_panel.operator_commands import COMMANDS, inject
from heave_panel.run_worker import RunWorker
from heave_panel.server import LARGEST_WAITING, leave_oldest
from hypothesis import given
from hypothesis import strategies as st
from rcl_interfaces.msg import ParameterType, ParameterValue

from bringup.test.operate_fakes import FakeLink, Given

# who is in command


def test_the_command_is_free_to_take_or_taken_over_and_lost_with_who_leaves():
    post = CommandPost()
    first, second = post.join(), post.join()
    assert post.commander is None
    assert post.take(first) is None
    assert post.take(second) == first
    assert not post.release(first), "only who has the command can lay it down"
    assert post.commander == second
    assert "viewer 2 is in command" in post.words(first)
    assert "you are in command; 2 watching" in post.words(second)
    assert not post.leave(first)
    assert post.leave(second)
    assert post.commander is None


def test_a_page_that_is_loaded_again_is_the_same_viewer_and_keeps_the_command():
    post = CommandPost()
    first = post.join("tab")
    post.take(first)
    assert post.join("tab") == first
    assert not post.leave(first), "the page of before is gone, the one of now is not"
    assert post.commander == first
    assert post.leave(first)
    assert post.join("tab") != first, "who comes back later begins anew"


@given(st.lists(st.tuples(st.sampled_from(["join", "leave", "take", "release"]), st.integers(1, 5))))
def test_whatever_viewers_do_at_most_one_of_those_present_is_in_command(steps):
    post = CommandPost()
    for step, viewer in steps:
        if step == "join":
            post.join()
        elif step == "leave":
            post.leave(viewer)
        elif step == "take":
            post.take(viewer)
        else:
            post.release(viewer)
        assert {post.commander} - {None} <= set(post.viewers)


# alarms


FROZEN = Trouble(
    "winch_controller: sensor mru",
    "SENSOR_LOST, MRU (high): readings do not change. Compensation fades out. Restart the sensor and its driver.",
    is_error=True,
)
KEY = "winch_controller SENSOR_LOST, MRU"


def test_an_alarm_has_severity_time_text_and_action():
    alarms = AlarmList()
    alarms.note(10.0, {FROZEN.part: FROZEN})
    (alarm,) = alarms.alarms
    assert (alarm.key, alarm.title, alarm.severity, alarm.since) == (KEY, "SENSOR_LOST, MRU", Severity.HIGH, 10.0)
    assert alarm.action == "Restart the sensor and its driver"
    assert alarm.text == "readings do not change. Compensation fades out."


def test_an_alarm_that_was_there_before_the_page_is_not_dated_at_the_time_of_the_page():
    alarms = AlarmList()
    alarms.note(223.7, {FROZEN.part: FROZEN})
    (alarm,) = alarms.alarms
    assert (alarm.since, alarm.is_older) == (223.7, True)
    alarms.note(224.7, {})
    alarms.note(230.0, {FROZEN.part: FROZEN})
    assert (alarms.alarms[0].since, alarms.alarms[0].is_older) == (230.0, False), "it was not there before"


def test_an_alarm_that_has_passed_stays_until_it_is_acknowledged():
    alarms = AlarmList()
    alarms.note(10.0, {FROZEN.part: FROZEN})
    alarms.note(20.0, {})
    (alarm,) = alarms.alarms
    assert (alarm.since, alarm.is_active, alarm.is_acknowledged) == (10.0, False, False)
    alarms.acknowledge(KEY)
    assert alarms.alarms == ()


def test_an_acknowledged_alarm_stays_while_it_holds_and_comes_back_unacknowledged():
    alarms = AlarmList()
    alarms.note(10.0, {FROZEN.part: FROZEN})
    alarms.acknowledge(KEY)
    alarms.note(11.0, {FROZEN.part: FROZEN})
    assert alarms.alarms[0].is_acknowledged
    alarms.note(12.0, {})
    assert alarms.alarms == ()
    alarms.note(13.0, {FROZEN.part: FROZEN})
    assert not alarms.alarms[0].is_acknowledged


def test_what_two_parts_report_is_one_alarm_and_an_event_is_none():
    message = (
        f"WINCH_MODEL_UPDATED (event): time constant 0.2 s.; {FROZEN.message}; CABLE_SLACK (medium): tension 0.1 kN."
    )
    told = Trouble("winch_controller: alarms", message, is_error=False)
    alarms = AlarmList()
    alarms.note(10.0, {told.part: told, FROZEN.part: FROZEN})
    assert [alarm.title for alarm in alarms.alarms] == ["SENSOR_LOST, MRU", "CABLE_SLACK"]
    alarms.note(11.0, {FROZEN.part: FROZEN})
    assert [alarm.is_active for alarm in alarms.alarms] == [True, False]


def test_an_action_is_shown_with_the_values_of_its_alarm():
    message = (
        "CABLE_SLACK (medium): tension 8.0 kN, 4 % of static. A snap load may follow. {}, or wait for calmer seas."
    )
    for remedy in ("Lower more slowly", "Compensate"):
        (alarm,) = alarms_of(Trouble("winch_controller: alarms", message.format(remedy), is_error=False))
        assert alarm.text == "tension 8.0 kN, 4 % of static. A snap load may follow."
        assert alarm.action == f"{remedy}, or wait for calmer seas"


def test_a_warning_without_a_code_that_becomes_an_error_is_to_be_acknowledged_again_and_comes_first():
    alarms = AlarmList()
    alarms.note(1.0, {"a": Trouble("a", "slow", is_error=False)})
    alarms.acknowledge("a")
    alarms.note(2.0, {"a": Trouble("a", "slow", is_error=False), "b": Trouble("b", "late", is_error=True)})
    alarms.note(3.0, {"a": Trouble("a", "lost", is_error=True), "b": Trouble("b", "late", is_error=True)})
    assert [(one.key, one.is_acknowledged) for one in alarms.alarms] == [("a", False), ("b", False)]


# what is drawn


def test_the_history_keeps_the_last_minute_and_begins_anew_with_a_run():
    history = History()
    for tick in range(2400):
        controller = ControllerStatus(0.05 * tick, "compensating", boom_tip_heave=0.5, mean_payout=2.0)
        winch = WinchStatus(0.05 * tick, payout=2.4)
        history.note(Situation(RunStatus(1, time=0.05 * tick), controller, winch))
    residual = next(number for number, line in enumerate(LINES) if line.name.startswith("rope"))
    points = history.series(residual)
    assert len(points) == LENGTH
    assert history.span == (points[0][0], points[-1][0]), "the axis of time is that of the data"
    assert points[-1][1] == pytest.approx(10.0)  # 0.5 m of the boom tip less 0.4 m of the winch
    history.note(Situation(RunStatus(1, time=1.0)))
    assert history.series(residual) == [[1.0, None]]


def test_the_limits_of_the_winch_are_those_that_the_controller_believes():
    taken = []
    request = request_limits(taken.append)
    response = type("Response", (), {})()
    kind = ParameterType.PARAMETER_DOUBLE
    response.values = [ParameterValue(type=kind, double_value=value) for value in (2.0, 1.5, -50.0, 60.0)]
    assert not request.judge(response).is_refused
    assert taken == [WinchLimits(2.0, 1.5, -50.0, 60.0)]
    response.values = []
    request.judge(response)
    assert str(taken[-1].speed) == "nan"


# who may open it


def ask(guard: Guard, **headers: str) -> list[dict]:
    """Ask a guard for the page, with `query` as the query string and `kind` as the scope's type; return its answer."""
    query, kind, sent = headers.pop("query", ""), headers.pop("kind", "http"), []

    async def send(message):
        sent.append(message)

    given = [(name.encode(), value.encode()) for name, value in headers.items()]
    asyncio.run(guard({"type": kind, "headers": given, "query_string": query.encode()}, None, send))
    return sent


async def application(scope, receive, send):
    await send({"type": "passed"})


@pytest.mark.parametrize("host", ["localhost:8080", "127.0.0.1:8080", "[::1]:8080"])
def test_on_this_machine_a_page_of_its_own_passes(host):
    assert ask(Guard(application), host=host, origin=f"http://{host}") == [{"type": "passed"}]
    for site in ("none", "same-origin"):
        assert ask(Guard(application), **{"host": host, "sec-fetch-site": site}) == [{"type": "passed"}]


@pytest.mark.parametrize("kind", ["http", "websocket"])
@pytest.mark.parametrize(
    "headers",
    [
        {"host": "evil.example"},
        {"host": "localhost:8080", "origin": "http://evil.example"},
        {"host": "localhost:8080", "sec-fetch-site": "cross-site"},
        {"host": "localhost:8080", "sec-fetch-site": "same-site"},
        {},
    ],
)
def test_no_other_site_speaks_through_the_browser_of_this_machine(kind, headers):
    (first, *_) = ask(Guard(application), kind=kind, **headers)
    assert first["type"] != "passed"


def test_from_elsewhere_the_token_is_needed_once_and_then_its_cookie():
    guard = Guard(application, "secret")
    assert ask(guard, host="ship:8080")[0]["status"] == 403
    assert ask(guard, host="ship:8080", query="token=guess")[0]["status"] == 403
    given = ask(guard, host="ship:8080", query="token=secret")[0]
    assert given["status"] == 303
    assert any(b"HttpOnly" in value for _, value in given["headers"])
    assert ask(guard, host="ship:8080", cookie=f"{COOKIE}=secret")[0]["type"] == "passed"
    assert ask(guard, host="ship:8080", kind="websocket", query="token=secret")[0]["type"] == "websocket.close"


@pytest.mark.parametrize("headers", [{"host": "["}, {"host": "localhost:8080", "origin": "http://[::1"}])
def test_an_address_that_is_none_is_refused(headers):
    assert ask(Guard(application), **headers)[0]["status"] == 403
    assert ask(Guard(application, "secret"), host="ship:8080", cookie="a b\x00[=;;")[0]["status"] == 403


async def page_of_its_own(scope, receive, send):
    await send({"type": "http.response.start", "status": 200, "headers": [(b"X-Frame-Options", b"SAMEORIGIN")]})


@pytest.mark.parametrize("host", ["localhost:8080", "evil.example"])
def test_no_answer_may_be_shown_in_the_frame_of_another_site(host):
    (start, *_) = ask(Guard(page_of_its_own), host=host)
    given = [(name.decode().lower(), value.decode()) for name, value in start["headers"]]
    headers = dict(given)
    assert len([name for name, _ in given if name == "x-frame-options"]) == 1
    assert "frame-ancestors 'none'" in headers["content-security-policy"]
    assert headers["x-frame-options"] == "DENY"
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["referrer-policy"] == "no-referrer"


def test_which_hosts_are_this_machine():
    assert all(is_loopback(host) for host in ("localhost", "127.0.0.1", "::1", "127.1.2.3"))
    assert not any(is_loopback(host) for host in ("0.0.0.0", "192.168.0.2", "::", "ship", "localhost.evil.example"))


# its thread


class ThreadLink(FakeLink):
    """A link that a thread listens to."""

    heard_at = 0.0

    def spin(self, seconds: float) -> None:
        time.sleep(min(seconds, 0.002))
        self.wall_time += 0.1

    def close(self) -> None:
        self.is_closed = True


def until(condition) -> None:
    deadline = time.monotonic() + 20.0
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.005)


def test_what_is_requested_is_begun_and_its_answer_is_told():
    link = ThreadLink(lambda request: Answer("taken") if "set_mode" in request.service else None)
    worker = RunWorker(link)
    worker.start()
    asked, waits = Given(Answer("done")), Given()
    worker.begin("one", lambda _: asked)
    worker.begin("two", lambda _: waits)
    worker.begin("three", lambda _: int("no number"))
    worker.begin("EMERGENCY STOP", EmergencyStop)
    until(lambda: len(worker.picture.log) == 2)
    assert {entry.text.split(":")[0] for entry in worker.picture.log} == {"one", "three"}
    assert set(worker.picture.under_way) == {"two", "EMERGENCY STOP"}
    assert link.requests[-1].message.mode == "emergency_stop"
    worker.close()
    assert link.is_closed


def test_a_speed_ends_with_the_viewer_who_asked_for_it_and_a_move_goes_on():
    worker = RunWorker(link := ThreadLink())
    worker.start()
    move, speed = Given(), Given()
    del speed.progress
    worker.begin("move", lambda _: move, viewer=1)
    worker.begin("lower", lambda _: speed, viewer=1)
    until(lambda: len(worker.picture.under_way) == 2)
    worker.let_go(2)
    worker.let_go(1)
    until(lambda: speed.is_cancelled)
    assert not move.is_cancelled
    worker.close()
    assert link.is_closed


# the command


def test_a_port_that_is_taken_is_said_in_one_line_before_the_run_is_looked_for(capsys):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert main(["panel", "--port", str(port)]) == 1
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert f"127.0.0.1:{port}: cannot be served: Address already in use; see --host and --port" in said


def test_the_acceleration_of_the_winch_is_the_change_of_its_rate_and_unknown_until_there_are_two():
    first = WinchStatus(1.0, rate=0.2).since(None)
    assert math.isnan(first.acceleration)
    later = WinchStatus(1.5, rate=0.9).since(first)
    assert later.acceleration == pytest.approx(1.4)
    assert math.isnan(WinchStatus(1.5, rate=0.4).since(later).acceleration), "the same state again"
    assert math.isnan(WinchStatus(0.1, rate=0.4).since(later).acceleration), "a run that begins anew"


# hardware in the place of nodes


def test_tension_is_that_of_the_load_cell_where_the_winch_does_not_tell_it():
    (line,) = (line for line in LINES if line.name == "tension")
    situation = Situation(winch=WinchStatus(1.0, tension=math.nan), load_cell=35e3)
    assert line.value(situation) == 35.0
    situation.winch = WinchStatus(1.0, tension=30e3)
    assert line.value(situation) == 30.0


def test_what_is_typed_wrongly_is_refused_in_words():
    link, by_name = FakeLink(), {command.name: command for command in COMMANDS}
    assert len(by_name) == len(COMMANDS)
    for name, text, words in (
        ("factor", "two", "'two' is no number"),
        ("factor", "2", "2: must be from 0 to 1"),
        ("depth", "nan", "nan: must be from"),
    ):
        with pytest.raises(ValueError, match=words):
            by_name[name].begin(link, text)
    assert (link.requests, link.moves) == ([], [])


def test_faults_are_injected_into_and_cleared_from_what_is_simulated_alone():
    link, by_name = FakeLink(), {command.name: command for command in COMMANDS}
    inject(link, "mru", "jump", 10.0, 0.5)
    (request,) = link.requests
    assert (request.message.device, request.message.kind, request.message.duration) == ("mru", "jump", 10.0)
    link.situation.simulated = ("mru", "depth")
    with pytest.raises(ValueError, match="winch is not simulated in this run; what is: mru, depth"):
        inject(link, "winch", "drive", 0.0, 0.0)
    by_name["clear faults"].begin(link, "")
    assert link.asked[-2:] == ["wave_vessel/inject_fault", "cable_sim/inject_fault"]
    link.situation.simulated = ()
    with pytest.raises(ValueError, match="nothing is simulated"):
        by_name["clear faults"].begin(link, "")


def test_what_moves_the_winch_asks_first():
    moving = {"compensate", "standby", "tension", "manual", "redesign", "depth", "move by"}
    assert moving <= {command.name for command in COMMANDS if command.is_confirmed}


class Fetched:
    """A page that no browser has connected to."""

    def __init__(self):
        self.is_deleted = False

    def delete(self):
        self.is_deleted = True


def test_of_pages_that_are_fetched_and_never_connected_to_only_the_newest_are_kept():
    """Each keeps 0.5 MB: a program that fetches a thousand a minute would take all the memory."""
    waiting, pages = {}, [Fetched() for _ in range(100)]
    for number, page in enumerate(pages):
        leave_oldest(waiting)
        waiting[str(number)] = page
    assert [page.is_deleted for page in pages] == [True] * (100 - LARGEST_WAITING) + [False] * LARGEST_WAITING
    assert list(waiting.values()) == pages[-LARGEST_WAITING:]
