"""The live line: an estimate that is called one, no efficiency of a law that is off, and each loss once."""

from types import SimpleNamespace

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from heave_bags.analyse.events import ALARMS_PART, MODE_PART
from heave_bringup.run.live_figures import LiveFigures
from heave_bringup.run.monitor import Monitor
from std_msgs.msg import Header


def test_a_load_or_winch_from_a_bag_has_no_figures_of_this_run():
    live = LiveFigures(is_open_loop=True)
    live.note_mode(0.0, "compensating", "")
    assert live.words(1.0, 0.5) == "compensating, open loop: load and winch as recorded"


def test_a_law_that_is_off_has_no_efficiency():
    live = LiveFigures()
    live.note_mode(0.0, "off", "")
    assert live.words(0.1, 0.447, 60.0) == "law off, load 10.00 cm rms (estimated over 60 s)"


def test_the_estimate_is_called_one():
    live = LiveFigures()
    live.note_mode(1.0, "compensating", "")
    assert live.words(0.01, 0.9, 60.0) == "compensating, load 1.00 cm rms, efficiency 90.0 % (estimated over 60 s)"


def diagnosed(mode: str, time: float, changes: dict[str, str], level: bytes = DiagnosticStatus.OK) -> DiagnosticArray:
    """Return what the controller publishes of its mode, with the `changes` since it did so last."""
    values = [KeyValue(key=key, value=value) for key, value in {"authority": "1.00", **changes}.items()]
    part = DiagnosticStatus(level=level, name=MODE_PART, message=mode, values=values)
    seconds = int(time)
    header = Header(stamp=Time(sec=seconds, nanosec=round(1e9 * (time - seconds))))
    return DiagnosticArray(header=header, status=[part])


def listener() -> SimpleNamespace:
    return SimpleNamespace(live=LiveFigures(), _news=[], _errors={}, _taken={}, strangers={})


def test_a_loss_is_told_with_the_time_of_the_change_and_the_stop_that_follows_is_no_other():
    monitor = listener()
    for message in (
        diagnosed("compensating", 61.05, {}),
        diagnosed("fade_out: mru stale", 62.05, {"t = 61.90 s": "fade_out: mru stale"}, DiagnosticStatus.WARN),
        diagnosed("stopped: mru stale", 72.05, {"t = 71.90 s": "stopping: mru stale"}, DiagnosticStatus.ERROR),
    ):
        Monitor._on_diagnostics(monitor, message)
    assert monitor._news == ["t = 61.90 s: COMPENSATION_LOST (high): mode fade_out: mru stale"]


def test_a_loss_between_two_diagnostics_is_told_though_compensation_has_come_back():
    monitor = listener()
    Monitor._on_diagnostics(monitor, diagnosed("compensating", 10.0, {}))
    changes = {"t = 10.20 s": "fade_out: mru stale", "t = 10.80 s": "compensating: mru is back"}
    Monitor._on_diagnostics(monitor, diagnosed("compensating: mru is back", 11.0, changes))
    assert monitor._news == ["t = 10.20 s: COMPENSATION_LOST (high): mode fade_out: mru stale"]


def test_a_stop_for_another_reason_than_the_loss_is_told_as_well():
    monitor = listener()
    Monitor._on_diagnostics(monitor, diagnosed("compensating", 61.05, {}))
    loss = {"t = 61.90 s": "fade_out: mru stale"}
    Monitor._on_diagnostics(monitor, diagnosed("fade_out: mru stale", 62.05, loss))
    stop = {"t = 62.50 s": "emergency_stop: emergency stop requested"}
    Monitor._on_diagnostics(
        monitor, diagnosed("emergency_stop: emergency stop requested", 63.05, stop, DiagnosticStatus.ERROR)
    )
    assert monitor._news[-1] == "t = 62.50 s: winch_controller: mode: emergency_stop: emergency stop requested"


def test_a_lost_sensor_is_told_once_by_the_controllers_alarms():
    """The part of the sensor says the same, up to a second later."""
    lost, monitor = "SENSOR_LOST, MRU (high): readings do not change. Compensation fades out.", listener()
    sensor = DiagnosticStatus(level=DiagnosticStatus.ERROR, name="winch_controller: sensor mru", message=lost)
    told = KeyValue(key="t = 9.80 s", value=lost)
    alarms = DiagnosticStatus(level=DiagnosticStatus.WARN, name=ALARMS_PART, message="1", values=[told])
    header = Header(stamp=Time(sec=10))
    Monitor._on_diagnostics(monitor, DiagnosticArray(header=header, status=[sensor, alarms]))
    assert monitor._news == [f"t = 9.80 s: {lost}"]


def test_what_happened_is_told_in_order_an_alarm_before_the_loss_that_it_causes():
    """Parts of diagnostics come mode first, and hold what happened in a second: the cause stood after its effect."""
    cause = "DRUM_NOT_HELD (critical): drum turns at -0.20 m/s. Nothing holds the load."
    reason = "fade_out: DRUM_NOT_HELD: drum turns at -0.20 m/s"
    mode = diagnosed(reason, 10.0, {"t = 9.80 s": reason}).status[0]
    values = [
        KeyValue(key="t = 9.80 s", value=cause),
        KeyValue(key="t = 9.90 s", value="CABLE_SLACK (medium): tension 1 kN."),
    ]
    alarms = DiagnosticStatus(level=DiagnosticStatus.WARN, name=ALARMS_PART, message="2", values=values)
    monitor = listener()
    Monitor._on_diagnostics(monitor, diagnosed("compensating", 9.0, {}))
    Monitor._on_diagnostics(monitor, DiagnosticArray(header=Header(stamp=Time(sec=10)), status=[mode, alarms]))
    assert [line.split(" (")[0] for line in monitor._news] == [
        "t = 9.80 s: DRUM_NOT_HELD",
        "t = 9.80 s: COMPENSATION_LOST",
        "t = 9.90 s: CABLE_SLACK",
    ]


def test_an_alarm_is_printed_once_where_a_slow_tick_was_sent_and_answered_again():
    limited, monitor = "AUTHORITY_LIMITED (medium): authority limited to 30 %.", listener()
    values = [KeyValue(key="t = 9.80 s", value=limited)]
    alarms = DiagnosticStatus(level=DiagnosticStatus.WARN, name=ALARMS_PART, message=limited, values=values)
    other = DiagnosticStatus(name="winch_adviser: node", message="ok")
    for status in (alarms, other, alarms):
        Monitor._on_diagnostics(monitor, DiagnosticArray(header=Header(stamp=Time(sec=10)), status=[status]))
    assert monitor._news == [f"t = 9.80 s: {limited}"]


def test_a_loss_is_told_once_and_a_request_is_none():
    live = LiveFigures()
    assert live.note_mode(1.0, "compensating", "") == ""
    assert (
        live.note_mode(2.0, "stopping", "mru frozen")
        == "t = 2.00 s: COMPENSATION_LOST (high): mode stopping: mru frozen"
    )
    assert live.note_mode(3.0, "stopped", "mru frozen") == ""
    live.note_mode(4.0, "compensating", "")
    assert live.note_mode(5.0, "fade_out", "standby requested") == ""
