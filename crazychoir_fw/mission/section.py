"""The base of every section of a mission file."""

from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, ConfigDict, model_validator

from crazychoir_fw.mission.values import refusal, unknown_key


class Section(BaseModel):
    """A mapping whose keys are known: a typo is refused with the nearest key that exists."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _refuse_unknown_keys(cls, data: Any) -> Any:
        if isinstance(data, Mapping) and cls.model_config.get("extra") == "forbid":
            known = [info.alias or name for name, info in cls.model_fields.items()]
            for key in data:
                if key not in known:
                    raise unknown_key(key, known)
        return data


class OneOf(Section):
    """A mapping with exactly one of the known keys, such as a phase or a fault; a word alone has nothing set."""

    @model_validator(mode="before")
    @classmethod
    def _fill(cls, data: Any) -> Any:
        # "- land" and "- land:" are a landing with nothing set
        if isinstance(data, str) and data in cls.model_fields:
            return {data: {}}
        if isinstance(data, Mapping):
            return {key: {} if value is None else value for key, value in data.items()}
        return data

    @model_validator(mode="after")
    def _exactly_one(self) -> "OneOf":
        if len(self.model_fields_set) != 1:
            raise refusal("a mapping with exactly one of " + ", ".join(type(self).model_fields))
        return self

    @property
    def name(self) -> str:
        """The key that is set, such as "takeoff" of a phase."""
        return next(iter(self.model_fields_set))
