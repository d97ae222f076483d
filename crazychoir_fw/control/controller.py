"""`CrazyflieController`: what all controllers of a drone share (docs/reference/crazychoir.md#4.1, #4.2)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, Protocol

from crazychoir_fw.common.checkpoint import Stateful
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, Reference, Twist
from crazychoir_fw.control.senders import SenderStrategy


class ReferenceHandler(Protocol):
    """What a controller wants of a trajectory handler; those of the planning layer say what a reference consists of."""

    def update(self, reference: Reference) -> None:
        """Take a new reference."""

    def get_desired_reference(self) -> Reference | None:
        """Return the last reference, None before the first one."""


class LastReference:
    """Keeps the last reference, whatever it consists of: the handler of a controller that was given none."""

    def __init__(self) -> None:
        """Begin without a reference."""
        self._reference: Reference | None = None

    def update(self, reference: Reference) -> None:
        """See `ReferenceHandler`."""
        self._reference = reference

    def get_desired_reference(self) -> Reference | None:
        """See `ReferenceHandler`."""
        return self._reference


class CrazyflieController(Stateful, ABC):
    """Template of controllers: takes poses and references, and gives a command whenever one is due.

    One object flies one drone, arrays of shape (3,), or a group of equal drones at once, (N, 3).
    """

    commands: ClassVar[tuple[str, ...]] = ("fpqr", "frpy", "vel")
    """Kinds of commands that it may send, see `SenderStrategy.kind`; the first is the usual one."""
    filtered: ClassVar[str] = ""
    """What of its commands safety filters work on: acceleration, velocity, or nothing."""

    def __init__(
        self, command_sender: SenderStrategy | None = None, traj_handler: ReferenceHandler | None = None
    ) -> None:
        """Choose the parts.

        Args:
            command_sender: What the command consists of; needed.
            traj_handler: Keeps the reference; None keeps it as it is given.

        Raises:
            RangeError: If there is no sender.
        """
        if command_sender is None:
            raise RangeError(
                f"{type(self).__name__}: command_sender is None, allowed: FPQRSender, FRPYSender, VelSender or your own"
            )
        self.command_sender = command_sender
        self.traj_handler: ReferenceHandler = LastReference() if traj_handler is None else traj_handler
        self.current_pose = Pose()
        self._forgotten: Reference | None = None

    @classmethod
    def with_filter(cls) -> type[CrazyflieController]:
        """Return the class whose position law gets poses of nearby drones; a class that passes them returns itself."""
        return cls

    def set_pose(self, pose: Pose) -> None:
        """Take the present pose and twist; what is not known yet is None."""
        self.current_pose = pose

    def set_reference(self, reference: Reference) -> None:
        """Hand a reference to the trajectory handler."""
        self._forgotten = None
        self.traj_handler.update(reference)

    def clear_reference(self) -> None:
        """Forget the reference, as if none had ever come, until the next one."""
        self._forgotten = self.traj_handler.get_desired_reference()

    @property
    def desired_reference(self) -> Reference | None:
        """The last reference that came, None before the first one and after `clear_reference`."""
        reference = self.traj_handler.get_desired_reference()
        return None if reference is self._forgotten else reference

    @property
    @abstractmethod
    def periods(self) -> tuple[float, ...]:
        """The periods (s) of what happens in `step`: a caller that calls it at multiples of each misses nothing."""

    @abstractmethod
    def step(self, now: float) -> Twist | None:
        """Do what is due.

        Args:
            now: Time (s), by any monotonic clock; a clock that went back restarts the schedules.

        Returns:
            The command, or None if there is nothing to be sent now.
        """
