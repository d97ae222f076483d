"""Bundles: what goes between the process of the drones and those of their layers, one message per process and round.

A message costs the same however large it is, so the odometry of all drones travels as one, and what a process has to
say to the host travels as one. These topics are hidden (their names begin with an underscore): they carry nothing that
the topics of the table would not, and replace these only where nobody else listens.

All are ``std_msgs/UInt8MultiArray`` or ``std_msgs/String``; labels are simulated times (ns).
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import NDArray
from std_msgs.msg import String, UInt8MultiArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.ros.names import Topic
from crazychoir_fw.ros.wire import label_and_data, labeled_bytes

Array = NDArray[np.float64]
Said = tuple[str, bytes]
"""A topic, and a message of it as bytes."""

ODOMETRY = Topic("/_swarm/odom", UInt8MultiArray, 10, 10, "odometry of all drones, 13 numbers each")
ANSWERS = Topic("/_swarm/answers", UInt8MultiArray, 10, 1000, "messages of a process to the host")
HOST = Topic("/_swarm/host", String, 1, 1, "which topics the host bundles")
MEMBERS = Topic("/_swarm/members", String, 1, 1000, "how many subscriptions of a process bundles serve")

_NUMBERS = 13
FRESH_S = 1.0
"""Wall time (s) for which somebody counts as there since he was heard."""
LOOK_EVERY = 0.05
"""Wall time (s) between two looks at who else listens."""


def pack_odometry(nanoseconds: int, rows: Array) -> bytes:
    """Return the odometry of all drones: position, quaternion (xyzw), velocity, rates, shape (N, 13)."""
    return labeled_bytes(nanoseconds, rows.tobytes())


def unpack_odometry(data: bytes) -> tuple[int, Array]:
    """Return time (ns) and rows, shape (N, 13), read-only.

    Raises:
        RangeError: If that is no odometry of drones.
    """
    nanoseconds, content = label_and_data(data)
    if len(content) % (8 * _NUMBERS):
        raise RangeError(f"{ODOMETRY.name}: {len(content)} bytes, allowed: {8 * _NUMBERS} per drone")
    return nanoseconds, np.frombuffer(content).reshape(-1, _NUMBERS)


def pack_answers(nanoseconds: int, member: str, said: Sequence[Said]) -> bytes:
    """Return what a process has to say to the host."""
    return labeled_bytes(nanoseconds, msgspec.msgpack.encode([member, said]))


def unpack_answers(data: bytes) -> tuple[int, str, list[Said]]:
    """Return time (ns), who it is, and what he says.

    Raises:
        RangeError: If they are no answers.
    """
    nanoseconds, content = label_and_data(data)
    try:
        member, said = msgspec.msgpack.decode(content, type=tuple[str, list[Said]])
    except (msgspec.MsgspecError, UnicodeError):
        raise RangeError(f"{ANSWERS.name}: {len(content)} bytes that are no answers") from None
    return nanoseconds, member, said


@dataclass(frozen=True)
class HostCard:
    """What a host says of itself."""

    odometry: Sequence[str]
    """Topics of odometry, in the order of the rows."""
    hears: Mapping[str, int]
    """Topics that it takes from bundles, and how many subscriptions it has on each."""

    def text(self) -> str:
        """Return it as JSON."""
        return json.dumps({"odometry": list(self.odometry), "hears": dict(self.hears)})

    @classmethod
    def read(cls, text: str) -> HostCard:
        """Read it.

        Raises:
            RangeError: If it is none.
        """
        try:
            fields = json.loads(text)
            card = cls([str(name) for name in fields["odometry"]], _counts(fields["hears"]))
        except (ValueError, TypeError, KeyError, AttributeError):
            raise RangeError(f"{HOST.name}: {text[:40]!r} is no description of a host") from None
        return card


@dataclass(frozen=True)
class MemberCard:
    """What a process of layers says of itself."""

    member: str
    """Its name, no other process has it."""
    served: Mapping[str, int]
    """How many of its subscriptions on which topics bundles serve."""

    def text(self) -> str:
        """Return it as JSON."""
        return json.dumps({"member": self.member, "served": dict(self.served)})

    @classmethod
    def read(cls, text: str) -> MemberCard:
        """Read it.

        Raises:
            RangeError: If it is none.
        """
        try:
            fields = json.loads(text)
            card = cls(str(fields["member"]), _counts(fields["served"]))
        except (ValueError, TypeError, KeyError, AttributeError):
            raise RangeError(f"{MEMBERS.name}: {text[:40]!r} is no description of a process") from None
        return card


def _counts(fields: Mapping[str, int]) -> dict[str, int]:
    return {str(name): int(count) for name, count in fields.items()}
