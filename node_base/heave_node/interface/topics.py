"""The topics of the suite: one definition of each name, type and publisher.

Names are relative, so that namespaces and remapping work; types are named by text, so that pure code can read this
table. The topics of sensors are in the table of `sensors`; those that code refers to have a name here too.
"""

from __future__ import annotations

from heave_node.interface import sensors
from heave_node.interface.topic import Role, Topic

CLOCK = Topic("clock", "rosgraph_msgs/msg/Clock", "cable_sim")
SEA_STATE = Topic("sea_state", "heave_msgs/msg/SeaState", "wave_vessel", Role.LATCHED)
SEA_STATE_ESTIMATE = Topic("sea_state_estimate", "heave_msgs/msg/SeaStateEstimate", "wave_vessel")
WAVE_COMPONENTS = Topic("wave_components", "heave_msgs/msg/WaveComponents", "wave_vessel", Role.LATCHED)
WAVE_ELEVATION = Topic("wave_elevation", "heave_msgs/msg/WaveElevation", "wave_vessel")
VESSEL_ODOMETRY = Topic("vessel/odometry", "nav_msgs/msg/Odometry", "wave_vessel")
BOOM_TIP = Topic("boom_tip", "heave_msgs/msg/PointMotion", "wave_vessel", is_needed=True)
MRU = sensors.MRU.topic
HEAVE_PREVIEW = Topic("vessel/heave_preview", "heave_msgs/msg/HeavePreview", "wave_vessel")
CRANE_POSE = Topic("crane/pose", "heave_msgs/msg/CranePose", "wave_vessel")
WINCH_COMMAND = Topic("winch/command", "heave_msgs/msg/WinchCommand", "winch_controller", Role.COMMAND, is_needed=True)
WINCH_COMMAND_WITHIN = Topic("winch/command_within", "heave_msgs/msg/WinchCommand", "winch_envelope", Role.COMMAND)
WINCH_STATE = Topic("winch/state", "heave_msgs/msg/WinchState", "virtual_winch", is_needed=True)
CABLE_STATE = Topic("cable/state", "heave_msgs/msg/CableState", "cable_sim")
UNIT_ODOMETRY = Topic("unit/odometry", "nav_msgs/msg/Odometry", "cable_sim")
UNIT_UNCOMPENSATED = Topic("unit_uncompensated", "heave_msgs/msg/PointMotion", "cable_sim")
UNIT_PRESSURE = sensors.DEPTH.topic
UNIT_VELOCITY = sensors.VELOCITY.topic
LOAD_CELL = sensors.LOAD_CELL.topic
CONTROLLER_STATE = Topic("controller/state", "heave_msgs/msg/ControllerState", "winch_controller")
CONTROLLER_KPI = Topic("controller/kpi", "heave_msgs/msg/CompensationKpi", "winch_controller")
CONTROLLER_OBSERVATIONS = Topic("controller/observations", "heave_msgs/msg/Observations", "winch_controller")
CONTROLLER_BELIEFS = Topic("controller/beliefs", "heave_msgs/msg/Beliefs", "winch_adviser", Role.KEPT)
OPERATOR_SPEED = Topic("controller/operator_speed", "geometry_msgs/msg/TwistStamped", "")
DIAGNOSTICS = Topic("diagnostics", "diagnostic_msgs/msg/DiagnosticArray", "")
MARKERS = Topic("markers", "visualization_msgs/msg/MarkerArray", "cable_sim")

ALL_TOPICS: tuple[Topic, ...] = tuple(
    dict.fromkeys(
        [
            *(value for value in list(globals().values()) if isinstance(value, Topic)),
            *(sensor.topic for sensor in sensors.SENSORS.values()),
        ]
    )
)
TOPIC_BY_NAME: dict[str, Topic] = {topic.name: topic for topic in ALL_TOPICS}

# The tick protocol. A leading underscore hides a topic from tools and from the recorder: these say how a run went, not
# what happened in it.
TICK_JOIN = Topic("_tick/join", "heave_msgs/msg/TickJoin", "")
TICK_ROSTER = Topic("_tick/roster", "heave_msgs/msg/TickRoster", "", Role.LATCHED)
TICK_START = Topic("_tick/start", "heave_msgs/msg/TickStart", "")
TICK_STATUS = Topic("_tick/status", "heave_msgs/msg/TickStatus", "", Role.LATCHED)
TICK_AHEAD = Topic("_tick/ahead", "heave_msgs/msg/TickPart", "")
TICK_LEAD = Topic("_tick/lead", "heave_msgs/msg/TickPart", "")
TICK_PAST = Topic("_tick/past", "heave_msgs/msg/TickPart", "")
_PART = "_tick/part/"


def tick_done_topic(node: str) -> Topic:
    """Return the topic on which `node` says that its part of a tick is done."""
    return Topic(f"_tick/done/{node}", "heave_msgs/msg/TickDone", node)


def tick_part_topic(node: str) -> Topic:
    """Return the topic on which `node`, not the clock master, sends its part of a tick."""
    return Topic(f"{_PART}{node}", "heave_msgs/msg/TickPart", node)


def is_part(name: str) -> bool:
    """Return whether a topic with the resolved `name` carries parts of ticks."""
    return name.endswith((f"/{TICK_AHEAD.name}", f"/{TICK_LEAD.name}", f"/{TICK_PAST.name}")) or f"/{_PART}" in name
