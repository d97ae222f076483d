"""What numbers, words and lists may be, said once for mission files and for scripts.

Pydantic checks; a constraint adds the words for whatever it refuses.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from pydantic_core import CoreSchema, SchemaValidator
from pydantic_core import core_schema as schemas


@dataclass(eq=False)
class Constraint:
    """What `typing.Annotated` says of a value: a schema of pydantic, and the words for all that it refuses."""

    schema: CoreSchema
    must: str
    """What is allowed, as it continues "must be"."""
    known: tuple[str, ...] = ()
    """Words, of which the nearest one is suggested."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> CoreSchema:
        """Return the schema, with one error for whatever is wrong."""
        context = {"must": self.must, "known": " ".join(self.known), "path": ""}
        return schemas.custom_error_schema(
            self.schema, "must_be", custom_error_message="must be {must}", custom_error_context=context
        )

    def __str__(self) -> str:
        return self.must

    def allows(self, value: Any) -> bool:
        """Return whether a value is allowed."""
        return self._validator.isinstance_python(value)

    @cached_property
    def _validator(self) -> SchemaValidator:
        return SchemaValidator(self.schema)


def number(low: float, high: float, unit: str = "") -> Constraint:
    """A real number in [low, high]: no NaN, no boolean, no text."""
    must = f"a number in [{low:g}, {high:g}] {unit}".rstrip()
    return Constraint(schemas.float_schema(ge=low, le=high, strict=True), must)


def whole(low: int, high: int) -> Constraint:
    """A whole number in [low, high]."""
    plain = lambda value: int(value) if isinstance(value, np.integer) else value
    schema = schemas.int_schema(ge=low, le=high, strict=True)
    return Constraint(schemas.no_info_before_validator_function(plain, schema), f"a whole number in [{low}, {high}]")


def choice(*known: str, must: str = "") -> Constraint:
    """One of a few words."""
    must = must or ("one of " + ", ".join(known) if len(known) > 1 else known[0])
    return Constraint(schemas.literal_schema(list(known)), must, known)


def choices(*known: str) -> Constraint:
    """A list of a few words, each at most once."""
    words = listed(schemas.tuple_schema([schemas.literal_schema(list(known))], variadic_item_index=0))
    once = lambda value: tuple(dict.fromkeys(value))
    return Constraint(schemas.no_info_after_validator_function(once, words), "a list of " + ", ".join(known), known)


def switch() -> Constraint:
    """True or false."""
    return Constraint(schemas.bool_schema(strict=True), "true or false")


def word(pattern: str, must: str) -> Constraint:
    """Text that matches *pattern*."""
    return Constraint(schemas.str_schema(pattern=rf"\A(?:{pattern})\Z", strict=True, regex_engine="python-re"), must)


def point(
    *names: str, low: float = -1000.0, high: float = 1000.0, floor: float | None = None, unit: str = "m"
) -> Constraint:
    """A list of coordinates.

    Args:
        names: The axes in order. An axis in brackets, such as "[z]", may be left out.
        low: Lowest coordinate.
        high: Highest coordinate.
        floor: Lowest third coordinate, when it differs.
        unit: Of all coordinates.
    """
    must = f"numbers [{', '.join(names)}] in [{low:g}, {high:g}] {unit}"
    if floor is not None:
        must += f" with z >= {floor:g}"
    axes: list[CoreSchema] = [schemas.float_schema(ge=low, le=high, strict=True) for _ in names]
    if floor is not None:
        axes[2] = schemas.float_schema(ge=max(low, floor), le=high, strict=True)
    shortest = sum(not name.startswith("[") for name in names)
    lengths = [schemas.tuple_schema(axes[:count]) for count in range(shortest, len(names) + 1)]
    return Constraint(listed(schemas.union_schema(lengths) if len(lengths) > 1 else lengths[0]), must)


def listed(schema: CoreSchema) -> CoreSchema:
    """Return a schema that is handed lists and tuples only: pydantic's own take sets for lists, too."""
    return schemas.chain_schema([schemas.is_instance_schema((list, tuple)), schema])


def names() -> Constraint:
    """Ids of drones, at least one."""
    words = schemas.tuple_schema([schemas.str_schema(strict=True)], variadic_item_index=0, min_length=1)
    return Constraint(listed(words), "a list of at least one id of a drone")


def constrained(constraint: Constraint, default: Any) -> Any:
    """Return a dataclass field with a constraint; None is allowed where it is the default."""
    return field(default=default, metadata={"constraint": constraint})


def refusal_of(member: Any, value: Any) -> Constraint | None:
    """Return the constraint of a dataclass field that a value breaks, or None."""
    constraint = member.metadata["constraint"]
    return None if (value is None and member.default is None) or constraint.allows(value) else constraint
