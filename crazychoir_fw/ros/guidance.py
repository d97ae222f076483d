"""Guidance laws as ROS 2 nodes: one node class around any law, built from the options that the law declares.

``crazychoir_fw.ros.NAME`` is the node of our law of that name, with the class names and arguments of the paper's
listings; `law_node` makes that of yours. For rounds and silent neighbors see `crazychoir_fw.ros.guidance_node`.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any, ClassVar

import numpy as np
from geometry_msgs.msg import Vector3
from numpy.typing import NDArray

from crazychoir_fw import guidance as plain
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.guidance import BestEffortCommunicator, Graph, Outputs, TimeVaryingCommunicator
from crazychoir_fw.guidance.law import Option, arguments_of, options_of
from crazychoir_fw.mission.registry import law_named, our_names
from crazychoir_fw.ros.guidance_node import GuidanceNode
from crazychoir_fw.ros.names import qos
from crazychoir_fw.ros.tasks import TableDesk

_OF_NODES = ("agent_id", "communicator", "init_pos", "update_frequency", "graph")
"""Arguments of laws that nodes know."""


class LawNode(GuidanceNode):
    """Wires a law to topics: its options are parameters and keyword arguments of the node."""

    law: ClassVar[Any] = plain.CFGuidance
    """Class of the law."""

    def __init__(self, *args: Any, law: Mapping[str, Any] | None = None, **options: Any) -> None:
        """Make the node; parameters ``init_pos`` and the options of the law.

        Laws that talk to neighbors have the parameters ``N``, ``in_neigh``, ``out_neigh`` and ``asynchronous``, too.

        Args:
            args: See `NodeFace.positional` of the law.
            law: Options of the law, such as ``{"k": 0.3, "max_speed": 1.0}``; as well as by their names.
            options: Of the law, and of `GuidanceNode`.

        Raises:
            RangeError: If a number is outside its range.
        """
        face = self.law.node
        if len(args) > len(face.positional):
            raise TypeError(f"{type(self).__name__} takes {len(face.positional)} arguments, but got {len(args)}")
        named = {**dict(zip(face.positional, args, strict=False)), **options, **(law or {})}
        named = {face.aliases.get(name, name): value for name, value in named.items()}
        named.pop("", None)
        frequency = named.pop("update_frequency", options_of(self.law)["update_frequency"].default)
        velocity_topic = named.pop("velocity_topic", face.velocity_topic)
        own = [name for name in named if name in arguments_of(self.law) and name not in _OF_NODES]
        self._given = {**face.defaults, **{name: named.pop(name) for name in own}}
        named.setdefault("node_name", face.name)
        super().__init__(self._build, update_frequency=frequency, **named)
        self._velocity = self.create_publisher(Vector3, velocity_topic, qos(1)) if velocity_topic else None

    def _build(self, node: GuidanceNode) -> Any:
        arguments, size = {"init_pos": self.declare_start(), "update_frequency": self.update_frequency}, 1
        if "communicator" in arguments_of(self.law):
            is_asynchronous = self.declare("asynchronous", False, "whether rounds take what has come")
            kind = BestEffortCommunicator if is_asynchronous else TimeVaryingCommunicator
            arguments["communicator"] = self.declare_communicator(kind)
            size = arguments["communicator"].size
        if "graph" in arguments_of(self.law):
            # of the graph only the own edges matter, and the draws of all pairs, which the complete graph has
            arguments["graph"] = Graph.complete(size)
        declared = {**self.law.node.parameters, **options_of(self.law)}
        values = {name: self._value(name, one) for name, one in declared.items() if name not in _OF_NODES}
        for name in self.law.node.parameters:
            setattr(self, name, values[name])
        law = self._law_of_subclass()
        made = law(agent_id=self.agent_id, **arguments, **law.from_parameters(values, size))
        if law.needs.table:
            made.connect(TableDesk(self))
        return made

    def _value(self, name: str, option: Option) -> Any:
        """Return the value of an option: from its parameter, or from the arguments if no parameter can hold it."""
        value = self._given.get(name, option.default)
        if option.type is None or not _is_plain(value) or self.has_parameter(name):
            return value
        default = list(value) if isinstance(value, tuple) else value
        what = f"{option.what} ({option.unit})" if option.unit else option.what
        return self.declare(name, default, what, option.type, low=option.low, high=option.high)

    def _law_of_subclass(self) -> Any:
        """Return the law, with the input of a subclass of this node that overrides it."""
        node = self
        if type(self).evaluate_input is LawNode.evaluate_input:
            return self.law

        class Law(self.law):  # type: ignore[misc, name-defined]
            def evaluate_input(self, neigh_data: dict[int, Pose]) -> NDArray[np.float64]:
                return node.evaluate_input(neigh_data)

        return Law

    def evaluate_input(self, neigh_data: dict[int, Pose]) -> NDArray[np.float64]:
        """Return the input of a feedback law, shape (3,), from the poses of neighbors; may be overridden."""
        method = self.law.evaluate_input
        if getattr(method, "__isabstractmethod__", False):
            raise NotImplementedError(f"{type(self).__name__}: override evaluate_input")
        return method(self.guidance, neigh_data)

    def _send(self, outputs: Outputs) -> None:
        super()._send(outputs)
        reference = outputs.reference
        if self._velocity is not None and reference is not None and reference.velocity is not None:
            x, y, z = (float(value) for value in reference.velocity)
            self._velocity.publish(Vector3(x=x, y=y, z=z))


def _is_plain(value: Any) -> bool:
    if isinstance(value, list | tuple):
        return all(isinstance(item, int | float) for item in value)
    return value is None or isinstance(value, bool | int | float | str)


@cache
def law_node(law: type) -> type[LawNode]:
    """Return the class of nodes around a law, of ours or of yours."""
    return type(law.__name__, (LawNode,), {"law": law, "__doc__": law.__doc__, "__module__": __name__})


def __getattr__(name: str) -> Any:
    if name in our_names("guidance"):
        return law_node(law_named("guidance", name, "guidance"))
    if name in ("CFGuidance", "CFDistributedFeedback", "DistributedControlGuidance"):
        return law_node(getattr(plain, name))
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
