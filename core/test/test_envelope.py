"""Each part of the envelope beside another formulation, and what holds for any input.

The nominal drum stands beside scipy's integration of its equation, leaky integrals beside `scipy.signal.lfilter`, the
locked cable beside `scipy.signal.cont2discrete`, the window beside numpy on the readings themselves.
"""

import math

import numpy as np
import pytest
from heave_core.envelope_table import Bit, Cause, DriveState, Duty, MoveKind, Phase
from heave_core.library import READING_NAMES, Envelope
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.signal import cont2discrete, lfilter

DT = 0.05
WINCH = {
    "is_first_order": 0,
    "lag": 0.15,
    "delay": 0.2,
    "position_gain": 0.0,
    "gain": 1.0,
    "hauling_gain": 1.0,
    "creep": 0.0,
    "reach": 2.0,
    "speed": 2.0,
    "acceleration": 1.5,
    "power": 0.0,
}
CABLE = {
    "inertia": 0.12,
    "participation": 1.0,
    "damping": 0.02,
    "drag": 0.0,
    "stiffness": 52e3,
    "length": 300.0,
    "static_tension": 37e3,
}
BOUNDS = {
    "window": 60.0,
    "rate_factor": 1.5,
    "rate_margin": 0.25,
    "travel_factor": 1.5,
    "travel_margin": 0.3,
    "travel_time": 60.0,
    "early_factor": 2.0,
    "lost_factor": 0.8,
    "largest_heave": 15.0,
    "largest_rate": 6.0,
    "largest_acceleration": 20.0,
    "heave_step": 0.2,
    "mru_time": 2.0,
    "frozen_readings": 10,
    "count_time": 0.5,
    "count_step": 0.05,
    "frozen_travel": 0.1,
    "frozen_time": 0.4,
    "drum_margin": 0.1,
    "drum_share": 0.4,
    "drum_time": 1.0,
    "stroke_factor": 1.5,
    "stroke_margin": 0.02,
    "stroke_gain": 0.7,
    "stroke_late": 0.6,
    "stroke_soon": 0.1,
    "stroke_span": 0.3,
    "brake_margin": 0.008,
    "rest_speed": 0.02,
    "used_share": 0.9,
    "bound_time": 0.5,
    "bound_window": 12.0,
    "takeover_time": 10.0,
    "damping_time": 20.0,
    "damping_rate": 0.2,
    "fade_out_time": 45.0,
    "blind_time": 960.0,
    "unseen_time": 12.0,
    "stop_deceleration": 0.5,
    "stop_margin": 0.05,
    "stop_time": 1.0,
    "move_tolerance": 1.0,
    "harm_ratio": 1.3,
    "harm_margin": 0.01,
    "harm_time": 10.0,
    "harm_felt": 2.0,
    "load_step": 0.15,
    "load_taut": 0.5,
    "tension_travel": 3.0,
    "largest_load": 370e3,
    "highest_tension": 0.0,
    "jerk_time": 2.0,
}
AMPLITUDE, PERIOD = 0.5, 6.0
"""Of the boom tip [m], [s]."""
OMEGA = 2.0 * math.pi / PERIOD
QUIET = {
    "mru_heave": math.nan,
    "mru_rate": math.nan,
    "count": math.nan,
    "load": math.nan,
    "depth": math.nan,
    "held_tension": math.nan,
    "target": math.nan,
    "reference": math.nan,
    "duty": float(Duty.FOLLOW),
}


def envelope(winch=(), cable=(), bounds=()):
    return Envelope(
        {
            "tick_period": DT,
            "winch": WINCH | dict(winch),
            "cable": CABLE | dict(cable),
            "envelope": BOUNDS | dict(bounds),
        }
    )


def readings(**values):
    given = dict.fromkeys(READING_NAMES, 0.0) | QUIET | values
    return tuple(float(given[name]) for name in READING_NAMES)


def reached(box, order, *, lag=WINCH["lag"]):
    """Return the larger of the speeds about the asked move that the nominal drum has and reaches by `order` [m/s].

    A lag of first order for the time at a bound, v + (v_set - v)(1 - exp(-t/T)); one of 0 is at once.
    """
    now = box.state["drum"]["rate"][0] - order.move_rate
    share = 1.0 if lag == 0.0 else 1.0 - math.exp(-BOUNDS["bound_time"] / lag)
    about = order.speed - order.move_rate
    return abs(about) if lag == 0.0 else max(abs(now), abs(now + share * (about - now)))


class Rig:
    """An envelope in front of a winch that does what its nominal equation says, under a boom tip that heaves."""

    def __init__(self, *, amplitude=AMPLITUDE, winch=(), cable=(), bounds=()):
        self.envelope = envelope(winch, cable, bounds)
        self.winch = WINCH | dict(winch)
        self.amplitude, self.tick = amplitude, 0
        self.payout = self.rate = 0.0
        self.line = [(0.0, True)] * (round(self.winch["delay"] / DT) + 1)
        self.orders = []

    @property
    def tip(self):
        phase = OMEGA * self.tick * DT
        return self.amplitude * math.sin(phase), self.amplitude * OMEGA * math.cos(phase)

    def step(self, rate=None, *, brake=False, **values):
        """Do a tick in which the controller orders a `rate`; None: that of the boom tip."""
        heave, tip_rate = self.tip
        ordered = tip_rate if rate is None else rate
        seen = {"mru_heave": heave, "mru_rate": tip_rate, "count": self.payout, "load": 37e3}
        seen |= {"drive": DriveState.DRIVE_RESTS if self.line[0][1] else DriveState.DRIVE_FREE} | values
        order = self.envelope.step(readings(rate=ordered, brake=brake, **seen))
        self.orders.append(order)
        self.line.append((order.rate, bool(order.brake)))
        sent, braked = self.line.pop(0)
        self._move(sent, braked=braked)
        self.tick += 1
        return order

    def _move(self, sent, *, braked):
        before, step = self.rate, self.winch["acceleration"] * DT
        if braked:
            self.rate = math.copysign(max(abs(before) - 0.5 * DT, 0.0), before)
        else:
            reached = -math.expm1(-DT / self.winch["lag"])
            gain = self.winch["gain"] * (self.winch["hauling_gain"] if sent < 0.0 else 1.0)
            wanted = min(max(gain * sent + self.winch["creep"], -self.winch["speed"]), self.winch["speed"])
            self.rate = before + min(max((wanted - before) * reached, -step), step)
        self.payout += 0.5 * (before + self.rate) * DT

    def run(self, time, rate=None, **values):
        for _ in range(round(time / DT)):
            order = self.step(rate, **values)
        return order

    def settled(self):
        """Stand braked, then follow the boom tip for a window; return the rig."""
        self.run(20.0, 0.0, brake=True, duty=float(Duty.OPERATE))
        self.run(62.0)
        assert self.orders[-1].cause == Cause.NOTHING
        return self


def test_an_order_inside_the_bounds_leaves_with_the_bits_it_came_with():
    rig = Rig().settled()
    for order in rig.orders:
        assert order.bits in (0, int(Bit.COUNT_LOST))
    for _ in range(200):
        rate = rig.tip[1] * 0.97 + 0.013
        order = rig.step(rate)
        assert (order.rate, order.payout, order.brake) == (rate, 0.0, 0.0)


def test_the_nominal_drum_is_that_of_its_equation():
    """Orders inside the acceleration limit, and a delay that ends within a tick: v' = (v_set - v)/T by scipy."""
    delay = 0.17
    box = envelope({"delay": delay, "acceleration": 50.0}, bounds={"rate_margin": 10.0, "travel_margin": 100.0})
    random = np.random.default_rng(3)
    orders = np.repeat(random.uniform(-0.5, 0.5, 30), 4)
    payouts = []
    for rate in orders:
        box.step(readings(rate=rate, mru_heave=0.0, mru_rate=0.0, duty=Duty.OPERATE))
        payouts.append(float(box.state["drum"]["payout"][0]))

    def sent(time):
        tick = math.floor((time - delay) / DT + 1e-9)
        return orders[min(max(tick, 0), len(orders) - 1)] if time >= delay else 0.0

    payout, rate, found = 0.0, 0.0, [0.0]
    for tick in range(1, len(orders)):
        for begin, end in (((tick - 1) * DT, (tick - 1) * DT + 0.02), ((tick - 1) * DT + 0.02, tick * DT)):
            held = sent(0.5 * (begin + end))
            part = solve_ivp(lambda _, x, v=held: (x[1], (v - x[1]) / 0.15), (begin, end), (payout, rate), rtol=1e-10)
            payout, rate = part.y[:, -1]
        found.append(payout)
    # the drum's way over a part of a tick is by the trapezoidal rule
    assert np.max(np.abs(np.array(payouts) - found)) < 2e-3


def test_travel_is_a_leaky_integral_of_the_drum_about_the_move():
    rig = Rig(amplitude=0.3).settled()
    rig.envelope.state["travel_sent"] = rig.envelope.state["travel_count"] = 0.0
    drum, travel, count = [float(rig.envelope.state["drum"]["payout"][0])], [], []
    for _ in range(400):
        rig.step()
        drum.append(float(rig.envelope.state["drum"]["payout"][0]))
        travel.append(float(rig.envelope.state["travel_sent"][0]))
        count.append(float(rig.envelope.state["travel_count"][0]))
    # it goes with the count's within the bound_window of 12 s
    kept, taken = 1.0 - DT / 12.0, DT / 12.0
    expected = lfilter([1.0], [1.0, -kept * (1.0 - DT / 60.0)], kept * np.diff(drum) + taken * np.array(count))
    assert np.allclose(travel, expected, atol=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_the_window_is_that_of_the_last_minute(seed):
    random = np.random.default_rng(seed)
    box, heaves, rates = envelope(), [], []
    for tick in range(3000):
        swell = 1.0 + math.sin(0.01 * tick)
        heave = swell * math.sin(1.1 * tick * DT) + 0.01 * random.standard_normal()
        rate = swell * 1.1 * math.cos(1.1 * tick * DT)
        heaves.append(heave)
        rates.append(abs(rate))
        order = box.step(readings(mru_heave=heave, mru_rate=rate, brake=1.0, count=0.0))
        if tick < 1300:
            continue
        bound = (order.rate_bound - 0.25) / 1.5
        # the oldest second goes as a whole
        assert max(rates[-1175:]) - 1e-9 <= bound <= max(rates[-1222:]) + 1e-9
        travel = (order.travel_bound - 0.3) / 1.5
        least, most = (
            max(np.max(last - mean), np.max(mean - last))
            for last, mean in ((np.array(heaves[-n:]), np.mean(heaves[-n:])) for n in (1175, 1222))
        )
        # about its own mean, which a second changes by some centimetres
        assert travel == pytest.approx(0.5 * (least + most), abs=0.06)


def test_the_load_under_a_locked_winch_is_that_of_the_two_state_cable():
    """By the trapezoidal rule, as `cont2discrete` samples a x'' + b x' + x = x_0 with the input held."""
    a, b = CABLE["inertia"], CABLE["damping"]
    A, B, *_ = cont2discrete(
        (np.array([[0.0, 1.0], [-1.0 / a, -b / a]]), np.array([[0.0], [1.0 / a]]), np.eye(2), np.zeros((2, 1))),
        DT,
        method="bilinear",
    )
    box, x = envelope(), np.zeros(2)
    # cont2discrete's bilinear state is x - (dt/2) B' u: here the input is held over the tick, and the state is whole
    M = np.linalg.inv(np.eye(2) - 0.5 * DT * np.array([[0.0, 1.0], [-1.0 / a, -b / a]]))
    for tick in range(400):
        heave = 0.4 * math.sin(1.3 * tick * DT) * min(tick * DT / 5.0, 1.0)
        rate = 0.4 * 1.3 * math.cos(1.3 * tick * DT)
        box.step(readings(mru_heave=heave, mru_rate=rate, brake=1.0, count=0.0))
        x = A @ x + M @ np.array([0.0, DT / a]) * heave
        assert box.state["unit_heave"][0] == pytest.approx(x[0], abs=1e-9)
    assert B.shape == (2, 1)


def test_an_order_far_outside_is_bounded_at_once_and_replaced_within_a_quarter_of_a_second():
    rig = Rig().settled()
    bounded = rig.step(5.0)
    assert Bit.AT_RATE in Bit(int(bounded.bits))
    now = rig.envelope.state["drum"]["rate"][0]
    assert now + (1.0 - math.exp(-0.5 / 0.15)) * (bounded.rate - now) <= bounded.rate_bound + 1e-12
    taken = rig.run(0.25, 5.0)
    assert (taken.phase, taken.cause) == (Phase.TAKEN, Cause.RATE)
    start = rig.payout
    ended = rig.run(34.0, 5.0)
    assert (ended.phase, ended.brake) == (Phase.HELD, 1.0)
    assert abs(rig.payout - start) < 2.0 * AMPLITUDE


@pytest.mark.parametrize("lag", [0.15, 0.5, 1.0])
def test_a_winch_with_a_lag_may_be_ordered_ahead_of_its_speed(lag):
    """v_set = v + T v' moves a drum of lag T with the boom tip: up to sqrt(1 + (w T)^2) times its speed.

    The first two waves, in which it comes into step, are not looked at.
    """
    rig = Rig(winch={"lag": lag, "acceleration": 10.0}).settled()
    for tick in range(round(60.0 / DT)):
        phase = OMEGA * (rig.tick * DT + rig.winch["delay"])
        order = rig.step(AMPLITUDE * OMEGA * (math.cos(phase) - OMEGA * lag * math.sin(phase)))
        assert tick * DT < 2.0 * PERIOD or not Bit(int(order.bits)) & (Bit.AT_RATE | Bit.AT_TRAVEL)
    assert order.phase == Phase.FREE


def test_the_travel_that_is_stated_is_what_exceeded_its_bound():
    """The drum's at entry was stated, 1.67 m of 1.79 m, where the order leads beyond it within the delay and lag."""
    rig = Rig().settled()
    order = rig.orders[-1]
    while order.cause == Cause.NOTHING:
        order = rig.step(0.9 * order.rate_bound)
    assert order.cause == Cause.TRAVEL
    assert order.limit == order.travel_bound
    furthest = max(order.travel_sent, order.travel_count) + order.rate_bound * (WINCH["lag"] + WINCH["delay"])
    assert order.limit < order.value < furthest


def test_a_load_that_swings_as_compensation_begins_may_be_stopped():
    """Under a locked winch it swings at its own frequency, by what the load cell shows."""
    rig, swing, frequency = Rig(), 0.3, 1.0  # of a cable of an inertia of 1 s^2 or less
    locked = rig.run(62.0, 0.0, brake=True, duty=float(Duty.OPERATE))
    for tick in range(round(62.0 / DT)):
        load = CABLE["static_tension"] + CABLE["stiffness"] * swing * math.sin(0.9 * tick * DT)
        rig.step(0.0, brake=True, duty=float(Duty.OPERATE), load=load)
    begins, lead = rig.step(), swing / math.sqrt(2.0)
    assert begins.rate_bound == pytest.approx(locked.rate_bound + lead * frequency, rel=0.05)
    assert begins.travel_bound == pytest.approx(locked.travel_bound + lead, rel=0.05)
    later = rig.run(62.0)
    assert later.rate_bound == pytest.approx(locked.rate_bound + lead * frequency * math.exp(-62.0 / 60.0), rel=0.05)


@pytest.mark.parametrize("lost", [{}, {"mru_heave": math.nan, "mru_rate": math.nan}])
@pytest.mark.parametrize("has_load", [True, False])
def test_a_swing_that_a_fade_out_has_left_may_be_stopped_by_what_the_load_cell_shows_of_it(lost, has_load):
    """Without a load cell the bounds are those of an empty window."""
    rig, swing = Rig().settled(), 0.3
    plain = rig.orders[-1].rate_bound - BOUNDS["rate_margin"]
    for tick in range(round(30.0 / DT)):
        load = CABLE["static_tension"] + CABLE["stiffness"] * swing * math.sin(0.9 * tick * DT)
        rig.step(0.0, duty=float(Duty.FADE), load=load if has_load else math.nan, **lost)
    begins = rig.step(load=CABLE["static_tension"] if has_load else math.nan)
    more = swing / math.sqrt(2.0) if has_load else (BOUNDS["early_factor"] - 1.0) * plain
    assert begins.rate_bound - BOUNDS["rate_margin"] == pytest.approx(plain + more, rel=0.06)


def test_what_was_taken_over_stays_until_an_operator_acknowledges():
    rig = Rig().settled()
    rig.run(35.0, math.nan)
    assert rig.orders[-1].cause == Cause.NOT_FINITE
    assert rig.run(30.0).phase == Phase.HELD
    assert rig.step(0.0, brake=True, acknowledged=1.0).phase == Phase.FREE
    rate = rig.tip[1]
    assert rig.run(5.0).cause == Cause.NOTHING
    assert rate != 0.0


def test_an_acknowledgement_while_the_drum_moves_is_not_heard():
    rig = Rig().settled()
    rig.run(2.0, math.nan)
    assert rig.step(acknowledged=1.0).phase == Phase.TAKEN


def test_a_drum_that_moves_under_the_brake_trips_however_slowly():
    rig = Rig()
    rig.run(62.0, 0.0, brake=True, duty=float(Duty.OPERATE))
    for _ in range(300):  # 1 cm/s
        rig.payout += 0.01 * DT
        order = rig.step(0.0, brake=True, duty=float(Duty.OPERATE))
    assert order.cause == Cause.BRAKE_SLIPS
    assert order.value == pytest.approx(BOUNDS["brake_margin"], abs=0.005)


def slipping(rig, speed, time, *, held=True, **values):
    """Run a braked `rig` for a `time` [s] whose drum slips at a `speed` [m/s] under the brake; the drive may hold."""
    rig.run(62.0, 0.0, brake=True, duty=float(Duty.OPERATE))
    for _ in range(round(time / DT)):
        rig.payout += speed * DT * (not held or rig.line[0][1])
        order = rig.step(0.0, brake=True, **{"duty": float(Duty.OPERATE)} | values)
    return order


def test_a_drum_that_its_brake_does_not_hold_is_held_by_its_drive():
    """0.2 m/s: 3 cm until it is found, then as far as it goes until the order acts, a delay and three ticks."""
    rig = Rig()
    order = slipping(rig, 0.2, 30.0)
    assert (order.phase, order.cause) == (Phase.CAUGHT, Cause.BRAKE_SLIPS)
    assert (order.brake, order.rate, order.speed) == (0.0, 0.0, 0.0)
    assert rig.payout < BOUNDS["brake_margin"] + 0.2 * (WINCH["delay"] + 3.0 * DT)
    order = rig.step(0.0, brake=True, duty=float(Duty.OPERATE), acknowledged=1.0)
    assert (order.phase, order.brake) == (Phase.FREE, 1.0)


def test_a_position_loop_is_to_hold_the_drum_where_it_was_caught():
    rig = Rig(winch={"position_gain": 1.0})
    order = slipping(rig, 0.2, 30.0)
    assert order.phase == Phase.CAUGHT
    assert order.payout == pytest.approx(rig.payout, abs=1e-3), "a millimetre"


@pytest.mark.parametrize("why_not", [{"drive": float(DriveState.DRIVE_FAILED)}, {"duty": float(Duty.STOP)}])
def test_neither_a_drive_with_a_fault_nor_one_after_an_emergency_stop_is_to_hold_a_drum(why_not):
    order = slipping(Rig(), 0.2, 3.0, held=False, **why_not)
    assert (order.phase, order.cause, order.brake) == (Phase.HELD, Cause.BRAKE_SLIPS, 1.0)


def test_a_drive_that_trips_by_the_same_slip_is_braked_again_only_if_its_fault_lasts():
    """The order to hold is under way by then, and releases the trip; a brake after it would let the drum slip again."""
    rig = Rig()
    assert slipping(rig, 0.2, 0.2).phase == Phase.CAUGHT
    taken = WINCH["delay"] + BOUNDS["count_time"]
    tripped = {"brake": True, "duty": float(Duty.OPERATE), "drive": float(DriveState.DRIVE_FAILED)}
    orders = [rig.step(0.0, **tripped) for _ in range(round((taken + 1.0) / DT))]
    opened = [order.brake == 0.0 for order in rig.orders]
    assert DT * sum(opened) == pytest.approx(taken, abs=1.5 * DT)
    assert (orders[0].brake, orders[-1].brake) == (0.0, 1.0)


def test_a_drive_that_does_not_hold_a_drum_either_is_asked_once_and_the_brake_goes_on_again():
    rig = Rig()
    order = slipping(rig, 0.2, 3.0, held=False)
    assert (order.phase, order.brake) == (Phase.HELD, 1.0)
    opened = [order.brake == 0.0 for order in rig.orders]
    assert np.count_nonzero(np.diff(opened)) == 2, "one time without the brake"


@pytest.mark.parametrize("resolution", [0.005, 0.0136, 0.02, 0.03])
@pytest.mark.parametrize("speed", [0.05, 0.2])
def test_a_drum_that_slips_is_found_by_a_count_of_coarse_steps_and_one_that_rests_between_two_is_let_be(
    resolution, speed
):
    """Steps of more than half the margin were taken for jumps, each alone: 7.5 m went by without an alarm."""
    rig = Rig()
    rig.run(62.0, 0.0, brake=True, duty=float(Duty.STOP))
    for tick in range(200):
        count = resolution * (0.5 + math.copysign(0.5, math.sin(tick)))
        assert rig.step(0.0, brake=True, duty=float(Duty.STOP), count=count).cause == Cause.NOTHING
    begin = rig.tick
    while rig.orders[-1].cause == Cause.NOTHING:
        way = speed * DT * (rig.tick - begin)
        rig.step(0.0, brake=True, duty=float(Duty.STOP), count=resolution * math.floor(way / resolution))
    # beyond the margin or a step, the next two steps of the count, within a tick
    assert way < max(BOUNDS["brake_margin"], resolution) + 2.0 * resolution + 2.0 * speed * DT


@pytest.mark.parametrize("lost", [{"count": math.nan}, {"mru_heave": math.nan, "mru_rate": math.nan}])
def test_a_lost_reading_tightens_the_bounds_and_takes_nothing_over(lost):
    rig = Rig().settled()
    before = rig.orders[-1]
    after = rig.run(3.0, 0.0, **lost)
    assert after.phase == Phase.FREE
    assert after.rate_bound - 0.25 == pytest.approx(0.8 * (before.rate_bound - 0.25), rel=0.05)


def test_a_count_that_does_not_step_while_the_drum_turns_is_lost():
    rig = Rig().settled()
    stuck = rig.payout
    seen = [Bit.COUNT_LOST in Bit(int(rig.step(count=stuck).bits)) for _ in range(40)]
    assert seen[-1]
    assert rig.orders[-1].phase == Phase.FREE


def test_a_jump_of_the_count_or_of_the_heave_is_taken_off():
    rig = Rig().settled()
    bounds = rig.orders[-1]
    order = rig.step(count=rig.payout + 7.0)
    assert Bit.COUNT_JUMPED in Bit(int(order.bits))
    for _ in range(100):
        heave, rate = rig.tip
        order = rig.step(count=rig.payout + 7.0, mru_heave=heave + 4.0, mru_rate=rate)
    assert order.phase == Phase.FREE
    assert order.travel_bound == pytest.approx(bounds.travel_bound, abs=0.05)


@pytest.mark.parametrize(("time", "ends"), [(44.0, False), (47.0, True)])
def test_a_fade_out_ends_in_time_whatever_is_ordered(time, ends):
    rig = Rig().settled()
    order = rig.run(time, duty=float(Duty.FADE))
    assert (order.cause == Cause.FADE_LONG) is ends
    if ends:
        assert rig.run(34.0, duty=float(Duty.FADE)).brake == 1.0


def test_a_fade_out_that_the_depth_sensor_damps_has_longer_and_ends_too():
    rig = Rig(bounds={"blind_time": 100.0}).settled()
    assert rig.run(90.0, duty=float(Duty.DAMP)).phase == Phase.FREE
    assert rig.run(12.0, duty=float(Duty.DAMP)).cause == Cause.UNSEEN


def test_compensation_that_does_not_see_the_ship_ends_in_time():
    rig = Rig().settled()
    blind = {"mru_heave": math.nan, "mru_rate": math.nan}
    rig.run(50.0, 0.1, **blind)
    assert rig.orders[-1].cause in (Cause.UNSEEN, Cause.TRAVEL)
    assert rig.orders[-1].brake == 1.0


def test_a_stop_is_a_ramp_from_what_was_sent_last_and_the_law_is_not_asked():
    rig = Rig().settled()
    fastest = max(abs(rig.orders[-1].speed), abs(rig.rate))
    for tick in range(100):
        order = rig.step(2.0, duty=float(Duty.STOP))
        assert order.brake or abs(order.speed) <= max(fastest - tick * 0.5 * DT, 0.0) + 0.05 + 1e-9
    assert order.brake == 1.0


def test_a_load_cell_that_varies_more_than_under_a_locked_winch_ends_compensation():
    """Reversed motion reference unit: the tension varies by twice what the locked cable's does."""
    rig = Rig().settled()
    locked = 2.0 * CABLE["stiffness"] * CABLE["inertia"] * AMPLITUDE * OMEGA**2
    for _ in range(1200):
        phase = OMEGA * rig.tick * DT
        order = rig.step(load=37e3 + locked * math.sin(phase))
        if order.cause:
            break
    assert order.cause == Cause.HARM
    assert rig.run(34.0).brake == 1.0


@pytest.mark.parametrize(("error", "cause"), [(1.0, Cause.NOTHING), (0.97, Cause.HARM)])
def test_a_load_near_its_resonance_is_told_from_harm_by_the_inertia_of_its_first_mode(error, cause):
    """Under a drum that does not move it swings as with the winch locked; one of another mode beats with it."""
    swings = {"inertia": (0.98 / OMEGA) ** 2, "damping": 0.004, "participation": 1.2}
    rig, truth = Rig(amplitude=0.004, cable=swings | {"inertia": error * swings["inertia"]}), envelope(cable=swings)
    for tick in range(6000):
        heave, rate = rig.tip
        truth.step(readings(mru_heave=heave, mru_rate=rate, brake=1.0, count=0.0))
        load = 1.2 * CABLE["stiffness"] * (heave - float(truth.state["unit_heave"][0]))
        is_held = tick < 600
        duty = float(Duty.OPERATE if is_held else Duty.FOLLOW)
        order = rig.step(0.0, brake=is_held, duty=duty, load=CABLE["static_tension"] + load)
        if order.cause:
            break
    assert order.cause == cause


@pytest.mark.parametrize("fault", [lambda load: load + 50e3, lambda load: 0.7 * load, lambda load: -load])
def test_a_load_cell_that_jumps_is_reported_and_does_no_harm(fault):
    """An offset, a scale and a sign from one reading to the next; the spread goes on without the step."""
    rig = Rig().settled()
    swing = 0.5 * CABLE["stiffness"] * CABLE["inertia"] * AMPLITUDE * OMEGA**2
    bits = []
    for tick in range(1200):
        load = CABLE["static_tension"] + swing * math.sin(OMEGA * rig.tick * DT)
        bits.append(Bit.LOAD_JUMPED in Bit(int(rig.step(load=fault(load) if tick >= 600 else load).bits)))
    assert np.flatnonzero(bits).tolist() == [600]
    assert rig.orders[-1].cause == Cause.NOTHING
    assert max(order.harm for order in rig.orders[-1200:]) < 1.0


def test_a_cable_that_snaps_taut_is_no_load_cell_that_jumps():
    """From slack to twice the static tension in a tick: a load that is caught."""
    rig = Rig().settled()
    for share in (*np.linspace(1.0, 0.1, 20), *[0.1, 2.0, 1.0] * 20):
        assert Bit.LOAD_JUMPED not in Bit(int(rig.step(load=share * CABLE["static_tension"]).bits))


def test_a_load_cell_that_jumps_while_the_cable_may_snap_is_known_by_more_than_a_caught_load_makes():
    """In a rough sea the tension often falls below half of the static one: a jump in it moved the drum, unseen.

    A load of mass m that is caught at a speed v by a spring k adds v sqrt(k m) to the static tension; a = m/k.
    """
    rig, static = Rig().settled(), CABLE["static_tension"]
    for share in np.linspace(1.0, 0.4, 20):
        rig.step(load=share * static)
    fastest = BOUNDS["rate_factor"] * AMPLITUDE * OMEGA + BOUNDS["rate_margin"]
    caught = static + CABLE["stiffness"] * math.sqrt(CABLE["inertia"]) * fastest
    assert Bit.LOAD_JUMPED not in Bit(int(rig.step(load=caught).bits))
    rig.step(load=0.4 * static)
    assert Bit.LOAD_JUMPED in Bit(int(rig.step(load=2.5 * caught).bits))
    assert rig.envelope.state["load"][0] == pytest.approx(0.4 * static)


def test_a_brake_that_slips_is_no_load_cell_that_jumps():
    """0.5 m/s at once: the wave of it in the cable was blamed on the load cell, a tick before the slip was known."""
    rig = Rig()
    rig.run(62.0, 0.0, brake=True, duty=float(Duty.OPERATE))
    for _ in range(4):
        rig.payout += 0.5 * DT
        order = rig.step(0.0, brake=True, duty=float(Duty.OPERATE), load=CABLE["static_tension"] - 12e3)
        assert Bit.LOAD_JUMPED not in Bit(int(order.bits))
    assert order.cause == Cause.BRAKE_SLIPS


def test_a_load_that_cannot_be_is_reported_and_not_used():
    rig = Rig().settled()
    assert Bit.LOAD_JUMPED in Bit(int(rig.step(load=1e7).bits))
    assert Bit.LOAD_JUMPED not in Bit(int(rig.step().bits))


@pytest.mark.parametrize(("stiffer", "cause"), [(1.0, Cause.HARM), (1.9, Cause.NOTHING)])
def test_a_cable_that_is_stiffer_than_stated_is_known_from_the_locked_winch(stiffer, cause):
    """The load varies by 1.9 times that of the nominal cable, as it did under the brake, or more than then."""
    rig = Rig(bounds={"load_step": 10.0})

    def load(times):
        amplitude = CABLE["stiffness"] * CABLE["inertia"] * AMPLITUDE * OMEGA**2
        return CABLE["static_tension"] + times * amplitude * math.sin(OMEGA * rig.tick * DT)

    for _ in range(1200):
        rig.step(0.0, brake=True, duty=float(Duty.OPERATE), load=load(stiffer))
    for _ in range(1800):
        order = rig.step(load=load(1.9))
    assert order.cause == cause


@pytest.mark.parametrize("crest", [0.3, 2.0])
def test_constant_tension_has_its_own_travel_and_loses_it_afterwards(crest):
    rig = Rig(amplitude=crest).settled()
    plain = rig.orders[-1].travel_bound
    held = rig.step(duty=float(Duty.TENSION), held_tension=37e3)
    assert held.travel_bound >= plain + BOUNDS["tension_travel"] - 0.01
    later = rig.run(120.0)
    assert later.travel_bound - plain == pytest.approx(BOUNDS["tension_travel"] * math.exp(-2.0), rel=0.05)


@pytest.mark.parametrize("acceleration", [0.05, 0.1])
def test_a_move_on_a_soft_cable_has_room_for_the_swing_that_turning_it_round_leaves(acceleration):
    """a z'' + b z' + z = -payout: the drum goes from a z'' ahead to as much behind, at the load's own frequency."""
    inertia, length = 7.34, 900.0
    rig = Rig(cable={"inertia": inertia, "length": length}).settled()
    plain = rig.orders[-1]
    drive = {"kind": float(MoveKind.DRIVE), "speed": 0.6, "acceleration": acceleration}
    bounds = [rig.step(request=1.0, **drive) for _ in range(round(4.0 / DT))]
    travel = max(order.travel_bound for order in bounds) - plain.travel_bound
    rate = max(order.rate_bound for order in bounds) - plain.rate_bound
    assert travel == pytest.approx(2.0 * inertia * acceleration, rel=0.05)
    assert rate == pytest.approx(2.0 * math.sqrt(inertia) * acceleration, rel=0.05)


def test_a_winch_of_first_order_is_bounded_by_its_payout_set_point():
    box = envelope({"is_first_order": 1, "lag": 1.0})
    for tick in range(40):
        box.step(readings(mru_heave=0.0, mru_rate=0.0, count=0.0, payout=0.0, brake=tick < 20))
    order = box.step(readings(mru_heave=0.0, mru_rate=0.0, count=0.0, payout=0.4))
    assert order.payout == pytest.approx(order.rate_bound * 1.0)
    assert order.rate == 0.0


WILD = st.sampled_from([math.nan, math.inf, -math.inf, 1e300, -1e300, 0.0])
NUMBERS = st.one_of(st.floats(-3.0, 3.0), WILD, st.floats(allow_nan=True))
PIECE = st.fixed_dictionaries(
    {
        "ticks": st.integers(1, 60),
        "mru_heave": NUMBERS,
        "mru_rate": NUMBERS,
        "count": NUMBERS,
        "load": NUMBERS,
        "lift_rate": NUMBERS,
        "payout": NUMBERS,
        "rate": NUMBERS,
        "held_tension": NUMBERS,
        "target": NUMBERS,
        "reference": NUMBERS,
        "distance": NUMBERS,
        "speed": NUMBERS,
        "acceleration": NUMBERS,
        "drive": st.sampled_from([float(state) for state in DriveState]),
        "brake": st.sampled_from([0.0, 0.0, 0.0, 1.0]),
        "duty": st.sampled_from([float(duty) for duty in Duty]),
        "kind": st.sampled_from([float(kind) for kind in MoveKind]),
        "acknowledged": st.sampled_from([0.0, 0.0, 1.0]),
    }
)


@given(st.lists(PIECE, min_size=1, max_size=12), st.sampled_from([0.0, 2.0]), st.sampled_from([0, 1]))
def test_whatever_comes_in_a_finite_bounded_order_leaves(pieces, position_gain, is_first_order):
    box = envelope({"position_gain": position_gain, "is_first_order": is_first_order})
    for request, piece in enumerate(pieces):
        values = {name: value for name, value in piece.items() if name != "ticks"}
        for _ in range(piece["ticks"]):
            order = box.step(readings(request=float(request), **values))
            assert math.isfinite(order.speed)
            assert math.isfinite(order.rate_bound)
            if order.brake:
                continue
            assert math.isfinite(order.payout)
            assert math.isfinite(order.rate)
            if order.phase == Phase.FREE and piece["duty"] == Duty.STOP:
                continue
            if order.phase in (Phase.FREE, Phase.TAKEN):
                lag = 0.0 if is_first_order else WINCH["lag"]
                now = 0.0 if is_first_order else abs(box.state["drum"]["rate"][0] - order.move_rate)
                assert reached(box, order, lag=lag) <= max(order.rate_bound, now) + 1e-9


@pytest.mark.parametrize(
    "absurd",
    [
        {"mru_rate": 9e307},
        {"mru_heave": -9e306, "mru_rate": math.nan},
        {"count": 1e300},
        {"count": -9e307},
    ],
)
@pytest.mark.parametrize("is_first_order", [0, 1])
def test_a_reading_that_cannot_be_leaves_bounds_and_order_as_a_lost_one_does(absurd, is_first_order):
    """A rate of 9e307 was taken for a jump of the heave: the bound on travel was no number and bound nothing."""
    box, lost = (envelope({"is_first_order": is_first_order}) for _ in range(2))
    good = {"mru_heave": 0.0, "mru_rate": 0.0, "count": 0.0, "payout": 0.0, "rate": 0.0}
    for values in (*[good] * 3, absurd, absurd, *[good] * 3, {**good, "lift_rate": 1.0}, {**good, "lift_rate": 1.0}):
        order = box.step(readings(**{**good, **values}))
        other = lost.step(readings(**{**good, **values, **dict.fromkeys(absurd if values is absurd else (), math.nan)}))
        assert order == pytest.approx(other, nan_ok=True)
        assert math.isfinite(order.travel_bound)


@pytest.mark.parametrize("payout", [1e6, -9e307])
def test_a_payout_beyond_the_reach_of_a_position_loop_is_replaced_and_the_rate_stays_small(payout):
    """A rate against it was -inf, and cancelled to nothing it was wrong by rounding."""
    box = envelope({"position_gain": 2.0})
    for payouts in (0.0, 0.0, 0.0, payout):
        order = box.step(readings(mru_heave=0.0, mru_rate=0.0, count=0.0, payout=payouts))
    assert order.payout == pytest.approx(0.0, abs=1e-9)
    assert reached(box, order) <= order.rate_bound + 1e-9


@given(st.lists(PIECE, min_size=1, max_size=6), st.integers(0, 2))
def test_whatever_comes_in_what_was_taken_over_ends_at_rest(pieces, which):
    box = envelope()
    order = None
    for piece in pieces:
        values = {name: value for name, value in piece.items() if name not in ("ticks", "acknowledged", "request")}
        for _ in range(piece["ticks"]):
            order = box.step(readings(**values))
    for tick in range(10_000):
        heave = (0.0, 3.0 * math.sin(tick), math.nan)[which]
        order = box.step(readings(mru_heave=heave, mru_rate=0.1, count=0.0, rate=50.0, lift_rate=0.0, load=37e3))
        if order.phase >= Phase.HELD and box.state["drum"]["rate"][0] == 0.0:
            break
    assert (order.phase, order.brake, order.speed) in ((Phase.HELD, 1.0, 0.0), (Phase.CAUGHT, 0.0, 0.0))
    assert tick < 1000


def test_a_copy_of_the_state_is_the_envelope_at_that_tick():
    rig = Rig().settled()
    kept = rig.envelope.state.copy()
    seen = readings(mru_heave=0.1, mru_rate=0.2, count=rig.payout, rate=0.7)
    first = rig.envelope.step(seen)
    rig.envelope.state[:] = kept
    assert np.array_equal(rig.envelope.step(seen), first, equal_nan=True)


def worst_excess(rig, time, rate=None, **values):
    """Return the largest way of the count beyond what was sent while the rig runs on [m]."""
    worst = 0.0
    for _ in range(round(time / DT)):
        rig.step(rate, **values)
        worst = max(worst, abs(float(rig.envelope.state["runaway"][0])))
    return worst


FREE, LIMITED = {}, {"drive": DriveState.DRIVE_LIMITED}


@pytest.mark.parametrize("phase", [0.05, 0.75, 1.5, 2.25])
@pytest.mark.parametrize(
    ("scale", "state", "furthest"),
    [
        (3.0, FREE, 0.14),
        (100.0, FREE, 0.14),
        (-1.0, FREE, 0.16),
        (3.0, LIMITED, 0.2),
        (100.0, LIMITED, 0.2),
        (-1.0, LIMITED, 0.2),
    ],
)
def test_a_drum_that_goes_three_times_as_far_as_ordered_or_the_wrong_way_trips(scale, state, furthest, phase):
    """Of where it should be, from where the fault takes effect, in waves of 0.5 m/s and with a limit of 1.5 m/s2.

    Where that limit alone leaves 0.1 m within 0.37 s; a drum that is reversed comes to rest first.
    """
    rig, ordered = Rig().settled(), Rig()
    rig.run(phase, **state)
    ordered.payout, ordered.rate = rig.payout, rig.rate
    move, begin = rig._move, rig.tick

    def wrong(sent, *, braked):
        ordered._move(sent, braked=braked)
        move(scale * sent, braked=braked)

    rig._move = wrong
    while not rig.step(**state).cause:
        assert (rig.tick - begin) * DT < (0.7 if state is FREE else 1.2)
    assert rig.orders[-1].cause == Cause.DRUM
    assert rig.orders[-1].brake
    assert abs(rig.payout - ordered.payout) < furthest


@pytest.mark.parametrize(("acceleration", "amplitude"), [(0.65, 1.3), (0.75, 1.45)])
def test_a_drum_at_its_limit_that_catches_up_with_its_orders_is_none_that_runs(acceleration, amplitude):
    """Half of the stated acceleration: it trails, and gains speed as its orders already fall."""
    rig = Rig(amplitude=amplitude)
    rig.winch["acceleration"] = acceleration
    rig.run(20.0, 0.0, brake=True, duty=float(Duty.OPERATE))
    assert worst_excess(rig, 30.0, drive=DriveState.DRIVE_LIMITED) < BOUNDS["stroke_margin"]
    assert rig.orders[-1].cause == Cause.NOTHING


@pytest.mark.parametrize("phase", [0.25, 0.75, 1.75, 2.75])
@pytest.mark.parametrize("missing", [1, 4, 10, 60])
def test_a_drum_whose_count_is_missing_for_a_time_is_none_that_runs(missing, phase):
    rig = Rig().settled()
    rig.run(phase)
    rig.run(missing * DT, count=math.nan)
    assert worst_excess(rig, 5.0) < 0.5 * BOUNDS["stroke_margin"]
    assert rig.orders[-1].cause == Cause.NOTHING


@pytest.mark.parametrize("missing", [1, 4])
def test_a_drum_that_runs_while_counts_are_missing_trips_by_the_next_ones(missing):
    """Each so many ticks one comes: two more of them, 0.5 s at most, beyond the 0.7 s with all of them."""
    rig = Rig().settled()
    move, begin = rig._move, rig.tick
    rig._move = lambda sent, *, braked: move(3.0 * sent, braked=braked)
    while not rig.step(**({} if rig.tick % (missing + 1) == 0 else {"count": math.nan})).cause:
        assert (rig.tick - begin) * DT < 1.2
    assert rig.orders[-1].cause == Cause.DRUM


@pytest.mark.parametrize("amplitude", [0.15, 0.5, 1.0])
@pytest.mark.parametrize("late", [2, 4, 6, 9])
@pytest.mark.parametrize("repeats", [True, False])
def test_counts_that_come_late_for_a_time_are_no_drum_that_runs(repeats, late, amplitude):
    """A computer that stalls: the last count again and again, or none and then old ones, and then that of now."""
    rig = Rig(amplitude=amplitude).settled()
    for _ in range(8):
        rig.run(0.75)
        counts = []
        for tick in range(late):
            counts.append(rig.payout)
            rig.step(**({"count": counts[0], "count_age": tick * DT} if repeats else {"count": math.nan}))
        for count in [] if repeats else counts:
            rig.step(count=count, count_age=late * DT)
        assert worst_excess(rig, 3.0) < BOUNDS["stroke_margin"]
    assert rig.orders[-1].cause == Cause.NOTHING


def test_a_drum_that_runs_is_seen_by_counts_that_come_late_as_soon_as_they_come():
    rig, late = Rig().settled(), 4
    counts = [rig.payout] * late
    move, begin = rig._move, rig.tick
    rig._move = lambda sent, *, braked: move(3.0 * sent, braked=braked)
    while not rig.step(count=counts[-late], count_age=late * DT).cause:
        counts.append(rig.payout)
        assert (rig.tick - begin) * DT < 0.7 + late * DT
    assert rig.orders[-1].cause == Cause.DRUM


@pytest.mark.parametrize("jump", [0.3, 5.0])
def test_a_stamp_of_the_count_that_jumps_back_is_no_drum_off_its_orders(jump):
    rig = Rig().settled()
    for _ in range(200):
        rig.step(count_age=jump)
    assert rig.orders[-1].cause == Cause.NOTHING


@pytest.mark.parametrize("late", [{"lag": 0.45, "delay": 0.35}, {"lag": 0.05, "delay": 0.05}])
def test_a_drum_that_follows_later_or_sooner_than_stated_is_none_that_runs(late):
    """The largest deviations of the draws; by a drive of the stated lag the envelope learns nothing."""
    rig = Rig()
    rig.winch |= late
    rig.line = [(0.0, True)] * (round(late["delay"] / DT) + 1)
    rig.settled()
    assert worst_excess(rig, 60.0) < 0.5 * BOUNDS["stroke_margin"]


@pytest.mark.parametrize("phase", [0.0, 0.7, 1.4, 2.1, 2.8, 3.5, 4.2, 4.9, 5.6])
def test_a_count_that_stops_at_once_is_no_drum_that_runs(phase):
    """Sums of its steps differ in the last digit: a speed of 1e-16 m/s was one that gained by all of the stop."""
    rig = Rig().settled()
    for _ in range(round(phase / DT)):
        rig.step()
    assert worst_excess(rig, 3.0, count=rig.payout) < 0.5 * BOUNDS["stroke_margin"]
    assert rig.orders[-1].cause == Cause.NOTHING


@pytest.mark.parametrize("frozen", [0.7, 1.3, 2.0, 3.3, 4.3, 20.3])
def test_a_count_that_goes_on_after_it_froze_is_no_drum_off_its_orders(frozen):
    """All that the drum did meanwhile comes in one step, of up to the 0.95 m from crest to trough."""
    rig = Rig().settled()
    rig.run(frozen, count=rig.payout)
    rig.run(3.0)
    assert rig.orders[-1].cause == Cause.NOTHING
    assert float(rig.envelope.state["position"][0]) == pytest.approx(rig.payout, abs=0.05)  # a tick's way


@pytest.mark.parametrize("jump", [0.03, 0.08, 0.12, -0.12])
def test_a_step_of_the_count_alone_is_no_drum_that_runs(jump):
    rig = Rig().settled()
    place = rig.payout
    rig.step(count=place + jump)
    assert worst_excess(rig, 1.0) < BOUNDS["stroke_margin"]
    assert rig.orders[-1].cause == Cause.NOTHING


def test_the_count_of_an_encoder_in_steps_of_3_cm_is_no_drum_that_runs():
    rig = Rig()
    rig.run(20.0, 0.0, brake=True, duty=float(Duty.OPERATE))
    for _ in range(4800):
        assert rig.step(count=round(rig.payout / 0.03) * 0.03).cause == Cause.NOTHING
        assert abs(float(rig.envelope.state["runaway"][0])) < BOUNDS["stroke_margin"] + 0.5 * 2.0 * 0.03


@pytest.mark.parametrize("scale", [0.5, 0.333, 2.4, -1.0])
@pytest.mark.parametrize("place", [0.3, 3.0])
@pytest.mark.parametrize("duty", [Duty.FOLLOW, Duty.FADE])
def test_a_count_of_another_scale_that_has_jumped_is_no_witness_against_the_drum(scale, place, duty):
    """No drum jumps: the encoder is at fault, and the brake would set the load swinging for nothing."""
    rig = Rig().settled()
    for _ in range(400):
        rig.step(count=scale * (rig.payout + place), duty=float(duty))
    assert rig.orders[-1].cause == Cause.NOTHING
    assert rig.orders[-1].rate_bound - 0.25 == pytest.approx(0.8 * 1.5 * AMPLITUDE * OMEGA, rel=0.05)  # as with none


@pytest.mark.parametrize("scale", [0.3, 0.5])
def test_a_count_that_has_jumped_proves_nothing_while_a_limit_of_the_drive_acts(scale):
    """The drum may go any part of what is sent then: a count of a third of its scale braked it after 2 s."""
    rig = Rig().settled()
    for tick in range(400):
        acts = tick < 200
        rig.step(count=scale * (rig.payout + 0.3), drive=DriveState.DRIVE_LIMITED if acts else DriveState.DRIVE_FREE)
    assert rig.orders[-1].cause == Cause.NOTHING


@pytest.mark.parametrize("jump", [0.04, -0.04])
@pytest.mark.parametrize("scale", [1.0, 1.19])
def test_a_step_of_the_count_that_no_drum_makes_in_a_tick_is_no_drum_that_runs(jump, scale):
    """4 cm more within 50 ms are 16 m/s^2, which neither a drive nor gravity makes."""
    rig = Rig().settled()
    while rig.rate * jump > 0.0 or abs(rig.rate) < 0.7 * AMPLITUDE * OMEGA:
        rig.step()
    begin = rig.payout
    for _ in range(400):
        rig.step(count=begin + jump + scale * (rig.payout - begin))
    assert rig.orders[-1].cause == Cause.NOTHING


@pytest.mark.parametrize("jump", [0.2, -0.7])
def test_a_count_that_goes_along_after_it_jumped_is_a_witness_again(jump):
    rig = Rig().settled()
    for _ in range(60):
        rig.step(count=rig.payout + jump)
    move, begin = rig._move, rig.tick
    rig._move = lambda sent, *, braked: move(3.0 * sent, braked=braked)
    while not rig.step(count=rig.payout + jump).cause:
        assert (rig.tick - begin) * DT < 0.7
    assert rig.orders[-1].cause == Cause.DRUM


def test_orders_that_hit_a_limit_of_the_drive_do_not_widen_their_own_bounds():
    """They did, as a stop does: orders 100 times too large went through at 2 m/s, for 3.1 m."""
    rig = Rig().settled()
    bound = rig.orders[-1].rate_bound
    order = rig.run(0.4, 2.0, drive=DriveState.DRIVE_LIMITED)
    assert order.rate_bound == pytest.approx(bound, rel=0.05)
    assert rig.run(0.4, 2.0, drive=DriveState.DRIVE_LIMITED).cause == Cause.RATE


def test_a_drive_at_its_limit_may_be_sent_further_and_goes_no_further_than_another():
    """What trails is the drum: its count stays within the bound, what was sent alone may be beyond it."""
    rig = Rig(bounds={"rate_factor": 10.0}).settled()
    bound = rig.orders[-1].travel_bound
    for _ in range(round(1.5 / DT)):
        rig.step(1.2, drive=DriveState.DRIVE_LIMITED)
    assert max(order.travel_count for order in rig.orders[-30:]) < 1.05 * bound
    assert rig.orders[-1].cause in (Cause.NOTHING, Cause.TRAVEL)
    trails = Rig(bounds={"rate_factor": 10.0}).settled()
    stands = trails.payout
    orders = [trails.step(1.2, count=stands, drive=DriveState.DRIVE_LIMITED) for _ in range(round(0.3 / DT))]
    assert all(order.rate == 1.2 for order in orders)


@pytest.mark.parametrize("winch", [{}, {"gain": 0.8, "hauling_gain": 1.1, "creep": 0.02}, {"lag": 0.45}])
def test_an_order_up_to_the_set_point_that_is_reported_passes_in_the_next_tick(winch):
    """A controller that asks for ten times as much each way, kept to what was reported, is never bounded."""
    rig, largest = Rig(winch=winch), 0.0
    rig.run(62.0, 0.0, brake=True, duty=float(Duty.OPERATE))
    for tick in range(2000):
        last, wild = rig.orders[-1], 10.0 * math.sin(0.02 * tick)
        order = rig.step(min(max(wild, last.lowest), last.highest))
        assert not Bit(int(order.bits)) & (Bit.AT_RATE | Bit.AT_TRAVEL)
        largest = max(largest, abs(rig.rate))
    assert order.phase == Phase.FREE
    assert 0.8 * order.rate_bound < largest <= order.rate_bound  # by the margin, and no less than it


def test_nothing_is_reported_to_keep_to_while_the_envelope_makes_the_order_itself():
    rig = Rig().settled()
    assert math.isfinite(rig.orders[-1].lowest) and math.isfinite(rig.orders[-1].highest)
    taken = rig.run(1.0, 4.0)
    assert (taken.phase, taken.lowest, taken.highest) == (Phase.TAKEN, -math.inf, math.inf)


@pytest.mark.parametrize("wild", [4.0, -4.0, math.nan])
def test_a_take_over_asks_a_drum_for_rest_or_for_its_acceleration_and_no_more(wild):
    """The set-point stepped from the bound through rest to the boom tip's rate, by up to 2 m/s.

    The speed v is that of the nominal drum to which the order comes, by its equation from all orders before.
    """
    rig = Rig().settled()
    begin, speed, largest = len(rig.orders), rig.tip[1], 0.0
    rig.run(12.0, wild)
    for order in rig.orders[begin:]:
        beyond = max(order.speed - max(speed, 0.0), min(speed, 0.0) - order.speed)
        largest = max(largest, beyond if order.phase == Phase.TAKEN else 0.0)
        step = (order.speed - speed) * -math.expm1(-DT / WINCH["lag"])
        speed += min(max(step, -WINCH["acceleration"] * DT), WINCH["acceleration"] * DT)
    assert 0.0 < largest <= WINCH["acceleration"] * (WINCH["lag"] + DT) + 2e-3  # and where the rig began


@pytest.mark.parametrize("is_known", [True, False])
def test_a_drum_that_runs_under_orders_that_reverse_is_seen_where_the_drive_has_been_punctual(is_known):
    """Three times as fast, and ordered back by a law that sees it: a drive that may be 0.6 s late might do the same."""
    times = [0.0, 0.2, 0.35, 0.45, 0.6, 0.7, 0.8, 1.0, 1.1, 1.25, 1.45, 1.65, 1.95, 2.05, 2.35, 2.75, 3.05, 3.65, 3.95]
    rates = [-17, -4, 8, 23, 36, 10, -17, -45, -50, -35, 0, 33, 72, 41, -10, -59, -3, 86, 17]  # of a loop [cm/s]
    rig = Rig()
    rig.run(20.0, 0.0, brake=True, duty=float(Duty.OPERATE))
    rig.run(92.8)
    if not is_known:
        rig.envelope.state["punctual_time"] = 0.0
    move, begin = rig._move, rig.tick
    rig._move = lambda sent, *, braked: move(sent * (3.0 if rig.tick - begin > 4 else 1.0), braked=braked)
    orders = [rig.step(0.01 * np.interp(tick * DT, times, rates)) for tick in range(78)]
    assert (orders[-1].cause == Cause.DRUM) == is_known


@pytest.mark.parametrize("follows", [True, False])
def test_an_order_that_stays_near_its_bounds_is_taken_over_as_the_drum_fails_to_follow(follows):
    """A law may stop a swinging load there; a loop that is lost, of a drive far slower than stated, is given up."""
    rig = Rig()
    rig.winch |= {} if follows else {"lag": 0.8}
    rig.run(62.0, 0.0, brake=True, duty=float(Duty.OPERATE))
    for tick in range(160):
        last, wild = rig.orders[-1], math.copysign(9.0, math.sin(2.0 * math.pi * tick * DT / 3.0))
        order = rig.step(min(max(wild, last.lowest), last.highest))
    assert (order.cause == Cause.NOTHING) == follows
    assert order.cause in (Cause.NOTHING, Cause.RATE, Cause.TRAVEL)


def drifting(rate, *, creeps, sees_depth, time=40.0, wander=(0.0, 1.0), swing=0.0):
    """Follow with a drum or its count at a `rate` of its own; return the rig and the time at which it is taken over.

    The unit hangs still on a stiff cable: its depth is the true payout less the heave, which the drum takes out. By an
    amplitude [m], with a period [s], `wander`, the motion reference unit is off, and the load cell shows a `swing` [m].
    """
    rig = Rig(cable={"inertia": 1e-4}, bounds={"harm_margin": 10.0}).settled()
    amplitude, slow = wander[0], 2.0 * math.pi / wander[1]
    for tick in range(round(time / DT)):
        # a loop about the position goes by the count
        count = rig.payout + rate * tick * DT
        depth = 300.0 + (count if creeps else rig.payout) - rig.tip[0]
        ordered = rig.tip[1] + 0.5 * (rig.tip[0] - count)
        phase = slow * tick * DT
        heave, heave_rate = rig.tip[0] + amplitude * math.sin(phase), rig.tip[1] + amplitude * slow * math.cos(phase)
        seen = {"count": count, "depth": depth if sees_depth else math.nan}
        load = CABLE["static_tension"] + CABLE["stiffness"] * swing * math.sin(phase)
        order = rig.step(ordered, mru_heave=heave, mru_rate=heave_rate, load=load, **seen)
        if order.cause != Cause.NOTHING:
            assert (order.cause, order.phase) == (Cause.DRIFT, Phase.TAKEN)
            return rig, tick * DT
    return rig, math.inf


@pytest.mark.parametrize("rate", [0.03, -0.05])
@pytest.mark.parametrize("sees_depth", [True, False])
def test_a_count_that_drifts_ends_in_a_takeover_before_the_load_has_gone_far(rate, sees_depth):
    rig, time = drifting(rate, creeps=False, sees_depth=sees_depth)
    assert time < math.inf
    # the margin on travel, and the second for which the depth is smoothed; without it, up to two waves more
    assert abs(rate) * time < BOUNDS["travel_margin"] + abs(rate) * (2.0 if sees_depth else 2.0 * PERIOD) + 0.15
    assert abs(rig.envelope.state["drift"]["off"][0]) >= BOUNDS["travel_margin"]


@pytest.mark.parametrize("rate", [0.03, -0.03])
def test_a_drum_that_creeps_under_a_count_that_the_depth_sensor_confirms_goes_on(rate):
    _, time = drifting(rate, creeps=True, sees_depth=True, time=120.0)
    assert time == math.inf


@pytest.mark.parametrize("period", [12.0, 20.0, 35.0])
@pytest.mark.parametrize("rate", [0.012, -0.02, 0.03])
def test_a_drum_that_creeps_goes_on_beside_a_motion_reference_unit_that_wanders(rate, period):
    """At times in each wave the depth seems to have gone against the drift by its 0.3 m; in the mean it has not."""
    _, time = drifting(rate, creeps=True, sees_depth=True, time=150.0, wander=(0.3, period))
    assert time == math.inf


@pytest.mark.parametrize("rate", [0.012, -0.012])
def test_a_drum_that_creeps_goes_on_while_the_load_swings_and_is_not_where_the_nominal_one_is(rate):
    _, time = drifting(rate, creeps=True, sees_depth=True, time=150.0, wander=(0.6, 18.0), swing=0.6)
    assert time == math.inf


@pytest.mark.parametrize("period", [12.0, 20.0, 35.0])
@pytest.mark.parametrize("rate", [0.03, -0.05])
def test_a_count_that_drifts_is_taken_over_beside_a_motion_reference_unit_that_wanders(rate, period):
    """No later than without a depth sensor."""
    _, time = drifting(rate, creeps=False, sees_depth=True, wander=(0.3, period))
    assert time <= drifting(rate, creeps=False, sees_depth=False)[1]


def test_a_drum_that_creeps_and_that_no_depth_sensor_confirms_is_taken_over():
    _, time = drifting(0.05, creeps=True, sees_depth=False)
    assert time < 20.0


def test_a_drift_that_the_travel_forgets_is_none():
    """At a rate r it stays at r T, with T = 60 s: 0.004 m/s reach 0.24 m of 0.3 m."""
    rig, time = drifting(0.004, creeps=False, sees_depth=False, time=300.0)
    assert time == math.inf
    assert rig.envelope.state["drift"]["off"][0] == pytest.approx(0.24, abs=0.03)


def test_a_drum_that_does_what_it_is_sent_does_not_drift():
    rig, time = drifting(0.0, creeps=False, sees_depth=True, time=120.0)
    assert time == math.inf
    assert abs(rig.envelope.state["drift"]["off"][0]) < 0.1 * BOUNDS["travel_margin"]
