"""The list `faults` of a mission file: what goes wrong, with which drone and when.

Each entry has one key, the kind of the fault, like an entry of `flight`. Keys, ranges and defaults are those of the
classes in `crazychoir_fw.simulation.faults`, which are the only place where they are written.
"""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BeforeValidator, model_validator

from crazychoir_fw.common.constraints import refusal_of
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.mission.section import OneOf
from crazychoir_fw.mission.values import objection, refusal, unknown_key

if TYPE_CHECKING:
    from crazychoir_fw.simulation.faults import Fault


class FaultEntry(OneOf):
    """One entry of `faults`: exactly one of these keys, with a mapping of what the kind has."""

    motor: Mapping[str, Any] | None = None
    imu: Mapping[str, Any] | None = None
    positioning: Mapping[str, Any] | None = None
    radio: Mapping[str, Any] | None = None
    battery: Mapping[str, Any] | None = None
    payload: Mapping[str, Any] | None = None
    kick: Mapping[str, Any] | None = None
    gust: Mapping[str, Any] | None = None

    @model_validator(mode="after")
    def _understand(self) -> "FaultEntry":
        _ = self.fault
        return self

    @property
    def fault(self) -> "Fault":
        """The fault, with `at` as it stands in the file: seconds since the first phase."""
        # a mission without faults is checked before the simulation is loaded
        from crazychoir_fw.simulation.faults import KINDS

        kind = KINDS[self.name]
        values = getattr(self, self.name)
        members = {member.name: member for member in fields(kind)}
        for key, value in values.items():
            if key not in members:
                raise unknown_key(key, members, f".{self.name}")
            if allowed := refusal_of(members[key], value):
                raise refusal(f"{allowed}", f".{self.name}.{key}", value=value, known=" ".join(allowed.known))
        try:
            return kind(**{key: tuple(value) if isinstance(value, list) else value for key, value in values.items()})
        except RangeError as error:
            raise objection(str(error).removeprefix(f"{self.name}: "), f".{self.name}") from None


def _from_script(value: Any) -> Any:
    """Let a list hold faults made in Python beside those of a file."""
    if not isinstance(value, list | tuple):
        return value
    return [{entry.kind: _members(entry)} if is_dataclass(entry) else entry for entry in value]


def _members(fault: Any) -> dict[str, Any]:
    return {member.name: getattr(fault, member.name) for member in fields(fault)}


Faults = Annotated[list[FaultEntry], BeforeValidator(_from_script)]
