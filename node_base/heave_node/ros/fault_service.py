"""The service `NODE/inject_fault` of every node that simulates devices."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from heave_msgs.srv import InjectFault

from heave_node.interface.faults import FaultSchedule
from heave_node.ros.node import HeaveNode


class FaultService:
    """Injects faults into the devices of a node, from the next tick on that it works out.

    Parameters
    ----------
    node : that serves it
    devices : returns the schedules of its devices, by name; called each time, since a reset makes new ones
    """

    def __init__(self, node: HeaveNode, devices: Callable[[], Mapping[str, FaultSchedule]]) -> None:
        self._node = node
        self._devices = devices
        node.create_service(InjectFault, f"{node.name}/inject_fault", self._serve)

    def _serve(self, request: InjectFault.Request, response: InjectFault.Response) -> InjectFault.Response:
        """Describe what was done, or why not."""
        devices = self._devices()
        if request.device not in devices:
            response.message = f"{self._node.name} has no device {request.device}; it has {', '.join(devices)}"
            return response
        start = self._node.next_tick * self._node.run.tick_period
        try:
            devices[request.device].inject(
                request.kind, start=start, duration=request.duration, magnitude=request.magnitude
            )
        except ValueError as error:
            response.message = str(error)
            return response
        size = f" {request.magnitude:g}" if request.magnitude else ""
        lasting = f" for {request.duration:g} s" if request.duration else ""
        self._node.note_request(start, f"fault of {request.device}: {request.kind}{size}{lasting}")
        response.success, response.message = True, f"{request.device}: {request.kind} from t = {start:.3f} s"
        return response
