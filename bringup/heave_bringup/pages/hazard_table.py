"""Hazards of a heave compensator and the protective measures of the suite against each, one row of a table each.

Causes are the faults of `heave_node.interface.faults`, detections the alarms of `heave_bringup.pages.alarms`, reactions
rows of the table of modes. A fault, a high or critical alarm, or a mode entered without a request that no hazard names
fails a test, and so does a test that is not there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from cable_sim_node.winch.parameters import WinchParameters
from winch_controller_node.core.supervision.modes import Event
from winch_controller_node.core.supervision.supervisor import BLIND_LIMIT
from winch_controller_node.parameters.laws import ModeParameters

WINCH, MODES = WinchParameters(), ModeParameters()


@dataclass(frozen=True)
class Hazard:
    """A hazard, and the protective measures against it."""

    name: str  # the hazardous event, and whom or what it harms
    causes: Mapping[str, tuple[str, ...]]  # faults by kind of device
    alarms: tuple[str, ...]  # codes by which it is detected; `*` stands for any letters
    reaction: str  # besides the changes of mode, in words
    time: str  # from the cause to the reaction, with its source
    residual: str  # risk that remains
    tests: tuple[str, ...]  # `file::function` of tests that show it
    others: str = ""  # causes that are no fault of a simulated device, in words
    events: tuple[Event, ...] = ()  # of the table of modes, to which the controller reacts


_C = "winch_controller_node/test/"
_W = "cable_sim_node/test/test_virtual_winch.py::test_"
_STOP = f"stops at {WINCH.deceleration:g} m/s² (`stop_deceleration`)"

HAZARDS: tuple[Hazard, ...] = (
    Hazard(
        "The drum runs against its orders: the load is driven into the bottom or up to the boom",
        {"winch": ("reverse",)},
        ("DRUM_*", "DRIVE_AT_FAULT", "COUNT_SPEED_DISAGREE", "WINCH_DRIVE_FAULT", "WINCH_OR_ENCODER_*"),
        "the envelope brakes; the drive's supervision trips where it is fitted; the guard ends compensation",
        "`supervision_time`, 1 s where it is set, counted while the order is above 0.05 m/s; guard: seconds",
        "the drum moves for the time of the supervision; without it until the guard has seen it",
        ("tests/test_winch_faults.py::"
         "test_a_drum_that_does_not_follow_is_stopped_by_its_drive_and_the_controller_stops_with_it",
         f"{_C}test_guard.py::test_a_drum_that_runs_wild_is_noticed_before_the_unit_has_answered"),
        events=(Event.WINCH_FAULT, Event.HARM, Event.ENVELOPE),
    ),
    Hazard(
        "The load drops past the brake",
        {"winch": ("brake_slip", "brake_open")},
        ("*BRAKE*", "DRUM_*HELD*", "WINCH_DRIVE_FAULT"),
        "the drive trips, and the virtual winch's holds the drum where it is; the controller stops and reports it. "
        "No second brake is commanded",
        "0.05 m of motion from the standstill, and 0.3 s (test)",
        "without power, after an emergency stop, or with a drive of your own that does not do so the load goes on to "
        "pay out at the speed of the slip: a second brake, or a person, has to hold it",
        (f"{_C}test_brake_watch.py::test_a_drum_that_slips_is_told_at_the_highest_severity_within_a_third_of_a_second_and_"
         "five_centimetres",
         f"{_C}test_brake_watch.py::test_a_slip_that_the_count_does_not_show_is_told_by_the_load_cell",
         "tests/test_winch_faults.py::test_a_brake_that_does_not_hold_is_reported_within_two_seconds_of_the_standstill",
         "node_base/test/test_motion_supervision.py::"
         "test_a_drum_that_has_stood_and_sinks_past_a_brake_that_says_open_is_found_by_its_way",
         "cable_sim_node/test/test_faulty_drum.py::"
         "test_a_drum_that_slips_past_its_brake_is_held_by_the_drive_without_any_command"),
        events=(Event.WINCH_FAULT,),
    ),
    Hazard(
        "After a stop the load swings, or hangs in the waves on its way",
        {},
        ("LOAD_SWINGS", "MOVE_LOST"),
        "size, period and half-life of the swing are reported once the drum stands; compensation takes it out",
        "2 s after the brake was ordered",
        "for minutes the load moves by up to three times its motion under a locked drum",
        (f"{_C}test_after_stop.py::"
         "test_after_an_emergency_stop_the_operator_is_told_by_how_much_the_load_swings_and_for_how_long",
         f"{_C}test_after_stop.py::"
         "test_a_move_that_a_fault_has_ended_is_told_at_the_severity_of_a_load_that_hangs_in_the_waves"),
        others="an emergency stop, or a fault that ends compensation",
    ),
    Hazard(
        "What was identified, estimated or computed is wrong: the drum is driven away",
        {},
        ("ORDER_TOO_FAST", "ORDER_TOO_FAR", "ORDER_NOT_FINITE", "STOP_OVERDUE", "LOAD_SWUNG_HIGHER"),
        "the envelope bounds the order, replaces it by one from raw readings that fades, then brakes; an operator "
        "releases it",
        "bounded at once, replaced after 0.5 s at a bound and sooner far beyond it",
        "the drum travels 1.5 times the heave of the last minute and 0.3 m; the load swings after the stop",
        ("tests/test_envelope.py::test_a_fault_drives_the_drum_no_further_than_the_sea_explains",),
        others="an identified value, an estimate or a design that is wrong",
        events=(Event.ENVELOPE,),
    ),
    Hazard(
        "The brake does not open while the drive pulls: drive and gear are overloaded",
        {"winch": ("brake_shut",)},
        ("WINCH_DRIVE_FAULT",),
        "the drive trips, and the drum stays braked",
        "`supervision_time`, 1 s where it is set",
        "torque against the brake for that time",
        ("tests/test_winch_faults.py::"
         "test_a_drum_that_does_not_follow_is_stopped_by_its_drive_and_the_controller_stops_with_it",),
        events=(Event.WINCH_FAULT,),
    ),
    Hazard(
        "The drum creeps under the load: the unit sinks unasked",
        {"winch": ("creep",)},
        ("WINCH_MODEL_UPDATED",),
        "the controller identifies the creep and orders against it; the brake ends it at rest",
        "compensated at once by feedback; identified within a minute",
        "in mode manual, without compensation, the operator has to see it",
        ("tests/test_winch_faults.py::test_a_drum_that_creeps_under_load_is_compensated",),
    ),
    Hazard(
        "Hydraulic pressure falls and comes back: the drum lags, then shoots back",
        {"winch": ("low_pressure",)},
        ("WORSE_THAN_OFF", "WINCH_MODEL_UPDATED", "AUTHORITY_LIMITED_BY_WINCH"),
        "authority falls with what the winch can do; compensation ends where it would do harm",
        "seconds; compensation is back within two minutes of the pressure (test)",
        "the unit moves as without compensation meanwhile",
        ("tests/test_winch_faults.py::"
         "test_pressure_that_falls_and_comes_back_costs_compensation_for_a_while_and_no_more",
         "tests/test_weak_winch.py::test_a_winch_weaker_than_believed_is_found_out_and_the_unit_held_still"),
        events=(Event.HARM,),
    ),
    Hazard(
        "The drive trips or loses its power under load",
        {"winch": ("drive",)},
        ("WINCH_DRIVE_FAULT", "COMPENSATION_LOST", "MOVE_LOST"),
        f"the winch {_STOP} and brakes, and latches; an operator, or a bounded number of retries, releases it",
        "at once; from 2 m/s 1.3 s",
        "the unit swings with the ship; a tension that rises until the brake holds",
        (f"{_W}scheduled_trip_acts_at_its_time_and_needs_a_release_after_it_ended",),
        events=(Event.WINCH_FAULT,),
    ),
    Hazard(
        "An emergency stop is pressed, and the winch moves on or starts again by itself",
        {"winch": ("emergency_stop",)},
        ("WINCH_EMERGENCY_STOP",),
        f"the winch {_STOP} and brakes; only an operator's request leaves the mode",
        "at once; from 2 m/s 1.3 s",
        "the stop of the simulator is no safety function: that of the ship is a circuit of its own",
        (f"{_C}test_component.py::test_an_emergency_stop_brakes_within_the_deceleration_of_the_winch",
         f"{_C}test_modes.py::test_only_an_operator_leaves_an_emergency_stop"),
        events=(Event.WINCH_EMERGENCY_STOP, Event.ASK_EMERGENCY_STOP),
    ),
    Hazard(
        "Orders do not reach the winch, or reach it late: it moves by an order of the past",
        {"winch": ("gap", "delay")},
        ("WINCH_COMMAND_TIMEOUT", "COMMAND_TIMEOUTS", "COMMANDS_TOO_LATE", "COMMANDS_CUT", "INPUT_LATE"),
        f"the winch's own watchdog {_STOP} and brakes; late orders are counted, identified, and cut authority",
        f"`command_timeout`, {WINCH.command_timeout:g} s, then the stop",
        "the drum follows the last order until the watchdog acts",
        (f"{_W}watchdog_stops_brakes_and_latches_until_an_explicit_release",
         "tests/test_hardware_in_the_loop.py::"
         "test_the_winch_stops_within_its_limits_and_brakes_when_its_controller_is_killed",
         f"{_C}test_command_timeouts.py::test_the_fourth_timeout_in_ten_minutes_waits_for_an_operator"),
        others="the controller's process ends; the network is cut",
        events=(Event.WINCH_FAULT, Event.WINCH_SILENT),
    ),
    Hazard(
        "A command is not a finite number",
        {},
        ("WINCH_INVALID_COMMAND",),
        f"the winch {_STOP}, brakes and latches",
        "at once",
        "none known",
        (f"{_W}command_that_is_not_a_finite_number_stops_the_winch_with_a_named_fault",),
        others="a defect of a controller",
        events=(Event.WINCH_FAULT,),
    ),
    Hazard(
        "The ship's motion is not known: the drum follows nothing, or a sea that is over",
        {"mru": ("gap", "nan", "freeze", "restart", "rate")},
        ("MRU_STALE", "MRU_LATE", "MRU_ABSENT", "MRU_NOT_A_NUMBER", "MRU_BAD_STAMP", "MRU_OUT_OF_ORDER",
         "MRU_FROZEN", "MRU_FAULT",
         "MRU_OUTPUT_STOPPED"),
        f"the last motion is predicted for at most {MODES.coast_time:g} s, then compensation fades out; with a depth "
        f"sensor the unit is damped by it, for at most {BLIND_LIMIT / 60.0:g} minutes; without one, or on a short "
        "stiff cable, the winch stops",
        "3 samples to the alarm (test)",
        "until the MRU is back the unit swings more with the depth sensor alone, and moves with the ship without one",
        (f"{_C}test_sensor_health.py::test_a_fault_raises_the_alarm_within_three_samples_and_is_named",
         f"{_C}test_component.py::"
         "test_a_frozen_mru_is_named_within_three_samples_and_the_unit_is_damped_without_it_and_without_a_jerk",
         f"{_C}test_storm.py::"
         "test_an_mru_lost_in_a_storm_leaves_a_unit_that_the_depth_sensor_damps_without_a_jerk_and_without_a_snap"),
        events=(Event.SENSOR_LOST,),
    ),
    Hazard(
        "The ship's motion is reported falsely: compensation adds motion to the unit",
        {"mru": ("scale", "jump", "spike", "delay")},
        ("MRU_SPIKES", "MRU_JUMPS", "MRU_EXCLUDED", "MRU_REVERSED", "MRU_*UNPROVED", "MRU_SCALE_ERROR", "MRU_DELAYED",
         "DEPTH_MRU_DISAGREE", "UNIT_HEAVE_HIGH"),
        "before the brake opens the MRU is proved by load cell and depth sensor on the nominal cable, and a reversed "
        "one is refused; later readings beyond the gate are rejected; scale, delay and drift are identified, or the "
        "sensor is excluded",
        "spikes and jumps: the sample; a reversed MRU: 20 s (test)",
        "a scale error of a few percent leaves as much motion until it is identified; without a depth sensor it stays",
        (f"{_C}test_proofs.py::test_a_sound_mru_is_proved_and_a_reversed_one_is_named_by_either_witness",
         f"{_C}test_excluded_sensors.py::"
         "test_a_unit_whose_motion_reference_unit_is_turned_over_for_good_is_never_worse_off",
         "tests/test_sensor_faults.py::test_a_sensor_of_a_wrong_scale_leaves_the_unit_no_worse_than_off"),
        events=(Event.HARM, Event.SENSOR_LOST),
    ),
    Hazard(
        "The boom tip is taken to be where it is not: roll and pitch are carried to a false place, the winch follows a "
        "lift that is not",
        {"sensor": ("freeze", "gap", "nan", "spike", "jump", "scale", "rate", "delay")},
        ("CRANE_POSE_STALE", "CRANE_POSE_INVALID", "CRANE_POSE_JUMP", "CRANE_RATES_DISAGREE"),
        "a false pose is rejected, and the last one held; height counts from there, and the unit is not moved. Rates "
        "that a joint does not follow are not used",
        "at once for a jump or scale that begins, and for no number; 1 s without a pose; 1 s of motion for a freeze "
        "while the crane moves (tests)",
        "a pose that freezes while the crane stands, or has a scale from the start, is not detected: the unit then "
        "moves as without a pose",
        (f"{_C}test_crane_pose.py::test_each_fault_of_the_encoders_raises_its_alarm_in_time_and_moves_nothing",
         f"{_C}test_crane_pose.py::"
         "test_a_joint_that_does_not_move_by_its_stated_rate_is_told_within_a_second_and_goes_by_its_poses"),
        others="encoders of a crane, whose poses travel as `crane/pose`",
    ),
    Hazard(
        "Payout is not known, or counted falsely: the unit is lowered too far, or the drum runs to its end",
        {"encoder": ("freeze", "nan", "spike", "jump", "scale")},
        ("PAYOUT_DEPTH_DISAGREE", "ENCODER_STALE", "ENCODER_LATE", "ENCODER_ABSENT", "ENCODER_NOT_A_NUMBER",
          "ENCODER_BAD_STAMP",
         "ENCODER_OUT_OF_ORDER", "DRUM_OR_ENCODER_STILL", "ENCODER_JUMPS", "ENCODER_EXCLUDED",
         "DRUM_OR_ENCODER_REVERSED", "DRUM_OR_ENCODER_SCALE", "ENCODER_AT_FAULT", "ENCODER_SCALE_ERROR"),
        "a jump is taken out of the count, and put into the payout set-point, by which a position loop does not follow "
        "it; a lost or reversed encoder fades compensation out and stops",
        "3 samples for a jump (test); a reversed one: seconds",
        "a payout zero that a person has set falsely by less than 3 m and 1 % of the cable "
        "(`health.payout_tolerance`), or by any amount without a depth sensor. Touchdown ends the lowering, after "
        "27 cm of rope on a unit that stands (museum)",
        (f"{_C}test_component.py::"
         "test_an_encoder_jump_raises_an_alarm_within_three_samples_and_does_not_move_the_unit",
         f"{_C}test_component.py::"
         "test_a_drive_that_counts_by_the_encoder_does_not_follow_its_jump_and_nothing_is_found_wrong",
         f"{_C}test_sensor_health.py::test_a_drum_that_turns_unseen_is_a_frozen_encoder",
         "tests/test_sensor_faults.py::"
         "test_an_encoder_that_reads_another_scale_all_at_once_does_not_set_the_unit_swinging",
         "tests/test_museum.py::"
         "test_a_payout_zero_that_was_not_set_is_named_before_the_lowering_and_a_landing_ends_that"),
        others="a rope that jumps the sheave",
        events=(Event.SENSOR_LOST, Event.HARM),
    ),
    Hazard(
        "A sensor on unit or cable is lost or false: the unit is corrected by what is not so",
        {"sensor": ("freeze", "gap", "spike", "jump", "scale", "nan", "rate", "delay")},
        ("DEPTH_*", "LOAD_CELL_*", "VELOCITY_*", "IMU_*", "LOWERING_BLIND", "SENSORS_DISAGREE"),
        "readings beyond the gate are rejected, a sensor that disagrees is excluded; compensation goes on by the MRU",
        "3 samples (test); a false scale: tens of seconds",
        "without a depth sensor nothing sees a slow error of the unit's place",
        (f"{_C}test_sensor_health.py::test_a_fault_raises_the_alarm_within_three_samples_and_is_named",
         f"{_C}test_excluded_sensors.py::test_compensation_goes_on_without_a_depth_sensor_that_lies",
         "tests/test_sensor_faults.py::"
         "test_a_unit_that_no_depth_sensor_sees_is_not_corrected_by_what_is_guessed_of_it"),
    ),
    Hazard(
        "Compensation excites the unit: it swings more than without",
        {},
        ("UNIT_SWING_HIGH", "LOAD_SWINGS", "UNIT_HEAVE_HIGH", "WORSE_THAN_OFF", "DRUM_SPEED_OFF", "COMPENSATION_LOST"),
        "compensation fades out, and is tried again after a growing wait",
        "a swing of a higher frequency than the sea: seconds; of a lower one: a minute",
        "up to 1.05 times the motion without compensation over a minute, where nothing else is at fault",
        (f"{_C}test_guard.py::test_a_swing_above_the_sea_is_noticed_within_seconds_and_one_below_never",
         "tests/test_promise.py::test_a_draw_that_was_lost_before_its_winch_or_mru_was_known_is_kept"),
        others="cable, unit, winch or sea are other than the parameters state",
        events=(Event.HARM,),
    ),
    Hazard(
        "The cable goes slack and snaps taut, or carries more than it can: it parts",
        {},
        ("CABLE_SLACK", "TENSION_HIGH", "ROPE_SAFETY_LOW", "ROPE_OVERLOADED", "CABLE_OVERSTRAINED"),
        "the governor keeps the drum from slackening the cable; tension is watched against limits and strength",
        "the sample of the load cell",
        "a snap that the sea itself causes is not prevented; a strength that is not stated is not watched",
        (f"{_C}test_load_watch.py::"
         "test_a_rope_that_carries_more_than_it_should_and_more_than_it_can_is_told_with_its_safety_factor",
         f"{_C}test_highest_tension.py::test_the_winch_pays_out_the_excess_within_a_second"),
        others="a sea beyond the limits of the lift",
    ),
    Hazard(
        "Compensation begins over a load that stands, on the bottom or on deck: the rope is slackened and snatches it",
        {},
        ("UNIT_NOT_SUSPENDED",),
        "compensation does not begin while the brake is on and the rope carries too little of the weight on average",
        "a wave or a free swing of the unit, before compensation can begin",
        "a load that the rope carries more than 60 % of (`tension.touchdown_ratio`) counts as suspended; without a "
        "load cell nothing is weighed, and one that reads far too little keeps compensation off",
        (f"{_C}test_landing.py::test_under_a_brake_a_unit_that_stands_is_known_within_seconds_and_is_waited_for",
         f"{_C}test_landing.py::test_under_a_brake_a_unit_that_hangs_is_never_taken_for_one_that_stands",
         "tests/test_museum.py::"
         "test_with_this_suite_the_cause_is_named_in_time_with_an_action_and_the_load_stays"),
        others="a lift that has not begun, or a landing that was not seen",
    ),
    Hazard(
        "Constant tension runs away: the load is let go, or taken up to the boom",
        {},
        ("TENSION_TRAVEL_END",),
        "the mode ends at the limit of its travel, after a warning at half of it",
        "at the limit",
        "the travel itself",
        (f"{_C}test_component.py::"
         "test_constant_tension_refuses_a_hanging_unit_at_whatever_instant_of_a_wave_under_a_brake",),
        others="the load comes off the bottom, or a false tension",
        events=(Event.LIFTED_OFF,),
    ),
    Hazard(
        "The crane moves and its pose is not known: the boom tip is assumed elsewhere",
        {},
        ("CRANE_POSE_STALE", "CRANE_POSE_JUMP", "CRANE_LENGTHS_MISSING", "CRANE_TOO_FAST", "CRANE_BEYOND_RANGE"),
        "the last pose is held; another one is approached slowly",
        "the age of a pose (`crane`)",
        "motion of a crane that is not measured reaches the unit",
        (f"{_C}test_crane_pose.py::test_a_stale_pose_is_held_and_told_once",
         f"{_C}test_crane_pose.py::test_a_jump_says_which_joint_and_by_how_much"),
    ),
    Hazard(
        "The adviser ends, is late, or answers with what cannot be",
        {},
        ("ADVISER_*",),
        "the controller keeps what is active; answers that are late or make no sense are refused and counted",
        "an answer has a second",
        "nothing new is identified until it is back",
        (f"{_C}test_answers.py::test_a_late_answer_is_refused_and_counted_and_what_is_in_force_stays",
         "tests/test_adviser.py::test_in_real_time_a_run_goes_on_without_an_adviser_that_was_killed_and_says_so"),
        others="a process that ends",
    ),
    Hazard(
        "Somebody else commands the winch, or feeds the controller",
        {},
        ("UNKNOWN_PUBLISHER", "MESSAGE_REJECTED"),
        "a topic has one publisher: messages of a second one are not obeyed",
        "the message",
        "who can take part under a node's own name is trusted: keep the network apart, or use SROS2",
        ("tests/test_strangers.py::test_a_second_controller_moves_nothing_and_fails_the_run",),
        others="a second controller, or a replayed bag, in the same domain",
    ),
    Hazard(
        "Clocks differ or a node is late: readings are used at the time when they do not hold",
        {},
        ("CLOCK_VIOLATION", "EXTERNAL_NODE_UNHEARD", "PARTICIPANT_LATE"),
        "stamps are judged by a declared or detected clock; what is late is rejected and counted",
        "the message; a missing node: `participant_timeout`",
        "an offset that is within what the clock allows shows as delay of a sensor",
        ("tests/test_killed_nodes.py::test_a_killed_node_ends_the_run_with_its_name_and_a_bag_that_reads_to_the_end",),
    ),
    Hazard(
        "What happened is not recorded",
        {},
        ("RECORDING_FAILED",),
        "lockstep: the run ends; real time: the run continues without a recording. The bag reads to its last whole "
        "chunk, and the loss is named in seconds and messages",
        "the first message that is not written",
        "the time that is lost",
        ("bags/test/test_recorded_losses.py::"
         "test_the_bag_of_a_full_disk_holds_or_names_every_message_that_was_sent",),
        others="a full or slow disk",
    ),
)  # fmt: skip
"""Hazards, the winch's own first."""
