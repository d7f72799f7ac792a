"""Asks the nodes of a run for their parameters, so that a bag carries the values that were active, defaults
included.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import yaml
from heave_node.files.bounded_yaml import DUMPER
from heave_node.ros.node_parameters import plain_value
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.task import Future


class ParameterSurvey:
    """Collects the parameters of nodes, asking through `node`; a node that does not answer is left out."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clients: dict[str, AsyncParameterClient] = {}
        self._values: dict[str, dict[str, Any]] = {}

    def ask(self, names: Iterable[str]) -> None:
        """Ask the nodes `names` whose services are there and that have not been asked."""
        for name in names:
            if name in self._values:
                continue
            if name not in self._clients:
                self._clients[name] = AsyncParameterClient(self._node, name)
            client = self._clients[name]
            if client.services_are_ready():
                self._values[name] = {}
                client.list_parameters(callback=self._listener(name, client))

    def _listener(self, name: str, client: AsyncParameterClient) -> Any:
        def on_list(future: Future[Any]) -> None:
            answer: Any = future.result()
            names = list(answer.result.names)
            client.get_parameters(names, callback=lambda values: self._keep(name, names, values.result()))

        return on_list

    def _keep(self, name: str, names: list[str], answer: Any) -> None:
        values = [parameter_value_to_python(value) for value in answer.values]
        plain = {key: plain_value(value) for key, value in zip(names, values, strict=True)}
        self._values[name] = {key: value for key, value in sorted(plain.items()) if value is not None}

    def to_yaml(self) -> bytes:
        """Return what was learnt as a parameter file."""
        content = {name: {"ros__parameters": values} for name, values in sorted(self._values.items()) if values}
        text: str = yaml.dump(content, Dumper=DUMPER, sort_keys=False)
        return text.encode()

    @property
    def is_empty(self) -> bool:
        """Return whether no node has answered."""
        return not any(self._values.values())
