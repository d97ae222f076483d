"""What browsers may ask for: every request as a model that is checked before anything happens."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from crazychoir_fw.common.errors import RangeError

FARTHEST_M = 100.0
MAX_POINTS = 20_000
"""Samples of a drawing."""
MAX_DRAWINGS = 100


def _number(value: object) -> object:
    # true and "1" are no numbers
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError("must be a number")
    return float(value)


def _ranged(low: float, high: float) -> Any:
    return Annotated[float, BeforeValidator(_number), Field(ge=low, le=high, allow_inf_nan=False)]


Metres = _ranged(-FARTHEST_M, FARTHEST_M)
Height = _ranged(0.05, FARTHEST_M)
Seconds = _ranged(0.0, 1e6)
Word = Annotated[str, Field(min_length=1, max_length=64, pattern=r"^[\w][\w .+-]*$")]
Id = Annotated[str, Field(min_length=1, max_length=64, pattern=r"^[\w-]+$")]
Drones = Annotated[list[Annotated[str, Field(max_length=64)]], Field(min_length=1, max_length=1000)] | None


class ApiRequest(BaseModel):
    """Base of all: unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class Press(ApiRequest):
    """A button of the flight."""

    name: Literal["takeoff", "land", "stop", "start"]
    drones: Drones = None


class GoTo(ApiRequest):
    """Fly to a point; several drones keep their places to each other, their middle flies there."""

    name: Literal["goto"]
    drones: Drones = None
    x: Metres
    y: Metres
    z: Height
    duration: _ranged(0.2, 600.0) | None = None


class GoToStarts(ApiRequest):
    """Fly to above the starts of the mission."""

    name: Literal["starts"]
    drones: Drones = None


class Arm(ApiRequest):
    """Arm or disarm."""

    name: Literal["arm"]
    drones: Drones = None
    armed: bool = True


class Reboot(ApiRequest):
    """Start the onboard software again."""

    name: Literal["reboot"]
    drones: Drones = None


class SetParameter(ApiRequest):
    """Write a parameter on board."""

    name: Literal["set_parameter"]
    drones: Drones = None
    parameter: Annotated[str, Field(min_length=1, max_length=64)]
    value: _ranged(-1e38, 1e38)


class SetSpeed(ApiRequest):
    """Simulated seconds per second; 0 pauses."""

    name: Literal["speed"]
    factor: _ranged(0.0, 100.0)


class Rewind(ApiRequest):
    """Go back to a time of a branch, and fly on from there as a new branch."""

    name: Literal["rewind"]
    branch: Annotated[int, Field(ge=0, le=10_000)] | None = None
    """Otherwise the one that flies now."""
    time: Seconds


class Fly(ApiRequest):
    """Fly what was previewed."""

    name: Literal["fly"]
    preview: Id


class FlyMission(ApiRequest):
    """Fly the phases of the mission that the page was opened with."""

    name: Literal["mission"]


Command = Annotated[
    Press | GoTo | GoToStarts | Arm | Reboot | SetParameter | SetSpeed | Rewind | Fly | FlyMission,
    Field(discriminator="name"),
]


class Envelope(ApiRequest):
    """A command with its id: a retry with the same id gets the first answer."""

    id: Id
    command: Command


Sample = Annotated[list[_ranged(-1e6, 1e6)], Field(min_length=3, max_length=3)]


class NewDrawing(ApiRequest):
    """A stroke, as it was drawn."""

    action: Literal["add"]
    points: Annotated[list[Sample], Field(min_length=2, max_length=MAX_POINTS)]
    """Rows x, y (m), time (s)."""
    height: Height = 1.0
    name: Word | None = None


class ChangeDrawing(ApiRequest):
    """A new name, height or drone of a drawing."""

    action: Literal["change"]
    drawing: Id
    name: Word | None = None
    height: Height | None = None
    drone: Annotated[str, Field(max_length=64)] | None = None


class DeleteDrawing(ApiRequest):
    """Away with a drawing, or with all."""

    action: Literal["delete"]
    drawing: Id | None = None


class UndoDrawing(ApiRequest):
    """Undo the last change of the drawings."""

    action: Literal["undo"]


class FileDrawing(ApiRequest):
    """Save all drawings under a name, load them, load an example, or take in the text of a CSV file."""

    action: Literal["save", "load", "example", "import"]
    name: Word
    text: Annotated[str, Field(max_length=2_000_000)] = ""


DrawingChange = Annotated[
    NewDrawing | ChangeDrawing | DeleteDrawing | UndoDrawing | FileDrawing, Field(discriminator="action")
]


class DrawingEnvelope(ApiRequest):
    """A change of the drawings with its id."""

    id: Id
    change: DrawingChange


class PreviewRequest(ApiRequest):
    """How drawings are made into curves."""

    method: Literal["spline", "minimum_snap"] = "spline"
    distance: _ranged(0.01, 1.0) = 0.2
    time_scale: _ranged(0.1, 20.0) = 5.0
    stretch: bool = True
    """Fly more slowly where limits of the platform would be broken."""
    drawings: Annotated[list[Id], Field(max_length=MAX_DRAWINGS)] | None = None


def sentence_of(error: ValidationError) -> str:
    """Return what is wrong with a request, in words."""
    first = error.errors()[0]
    place = ".".join(str(part) for part in first["loc"]) or "the request"
    given = repr(first.get("input"))
    return f"{place[:120]}: {first['msg']}, but is {given if len(given) <= 60 else given[:57] + '...'}"


def read(model: type[BaseModel], data: object) -> Any:
    """Return a request that has been checked.

    Raises:
        RangeError: If it is none; the text says where and why.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise RangeError(sentence_of(error)) from None
    except RecursionError:
        raise RangeError("the request is nested too deeply") from None
