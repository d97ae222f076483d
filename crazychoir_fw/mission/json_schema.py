"""The JSON Schema of mission files, made of the models: completion, hover and checks in an editor."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import Annotated, Any

from pydantic import BaseModel, TypeAdapter
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema as schemas

from crazychoir_fw.common.docstrings import attribute_docstrings
from crazychoir_fw.mission.faults import FaultEntry
from crazychoir_fw.mission.schema import LayeredMission, Mission
from crazychoir_fw.mission.section import OneOf

_DRAFT = "https://json-schema.org/draft/2020-12/schema"


class _Generator(GenerateJsonSchema):
    """Knows the constraints of `common.constraints`; what only a function checks is left open."""

    ignored_warning_kinds = {"skipped-choice", "non-serializable-default"}  # noqa: RUF012 (the base class has it so)

    def is_instance_schema(self, schema: schemas.IsInstanceSchema) -> JsonSchemaValue:
        return {}

    def chain_schema(self, schema: schemas.ChainSchema) -> JsonSchemaValue:
        return self.generate_inner(schema["steps"][-1])

    def custom_error_schema(self, schema: schemas.CustomErrorSchema) -> JsonSchemaValue:
        must = schema.get("custom_error_context", {}).get("must", "")
        return {**self.generate_inner(schema["schema"]), "description": f"Allowed: {must}."}

    def function_before_schema(self, schema: schemas.BeforeValidatorFunctionSchema) -> JsonSchemaValue:
        inner = self.generate_inner(schema["schema"])
        is_whole = inner.get("type") in ("integer", "object") or "$ref" in inner or "$ref" in inner.get("items", {})
        return inner if is_whole else {}

    def str_schema(self, schema: schemas.StringSchema) -> JsonSchemaValue:
        made = super().str_schema(schema)
        if "pattern" in made:
            made["pattern"] = made["pattern"].replace(r"\A", "^").replace(r"\Z", "$")
        return made


def mission_schema() -> dict[str, Any]:
    """Return the JSON Schema of a mission file, with and without layers."""
    parts: TypeAdapter[Mission | LayeredMission] = TypeAdapter(Mission | LayeredMission)
    root: dict[str, Any] = parts.json_schema(schema_generator=_Generator)["$defs"]
    for model in models():
        if model.__name__ in root:
            _describe(model, root[model.__name__])
    for kind in _kinds_of_faults():
        root["FaultEntry"]["anyOf"][1]["properties"][kind["title"]] = kind
    # a variant says in parts what the mission that it extends says in whole
    root["Variant"] = {**root["LayeredMission"], "properties": dict(root["LayeredMission"]["properties"])}
    lists = [root[name]["properties"]["flight"] for name in ("Mission", "LayeredMission")]
    root["Variant"]["properties"]["flight"] = {"anyOf": lists, "description": "The phases in order."}
    for model in (Mission, LayeredMission):
        needed = [name for name, info in model.model_fields.items() if info.is_required()]
        root[model.__name__]["required"] = [name for name in needed if name != "name"]  # that of the file will do
    return {
        "$schema": _DRAFT,
        "title": "Mission of crazychoir_fw",
        "type": "object",
        "if": {"required": ["extends"]},
        "then": {"$ref": "#/$defs/Variant"},
        "else": {
            "if": {"required": ["layers"]},
            "then": {"$ref": "#/$defs/LayeredMission"},
            "else": {"$ref": "#/$defs/Mission"},
        },
        "$defs": root,
    }


def models() -> list[type[BaseModel]]:
    """Return all sections of a mission file, the whole first, each once."""
    found: dict[type[BaseModel], None] = {}
    todo: list[Any] = [Mission, LayeredMission]
    while todo:
        kind = todo.pop(0)
        if inspect.isclass(kind) and issubclass(kind, BaseModel) and kind not in found:
            found[kind] = None
            todo += [part for info in kind.model_fields.values() for part in _parts(info.annotation)]
    return list(found)


def _parts(annotation: Any) -> Iterator[Any]:
    yield annotation
    for part in getattr(annotation, "__args__", ()):
        yield from _parts(part)


def _describe(model: type[BaseModel], made: dict[str, Any]) -> None:
    """Add what the source says of each key; keys that other checks demand are not demanded here."""
    made.pop("required", None)
    texts = attribute_docstrings(model)
    for name, info in model.model_fields.items():
        key = info.alias or name
        if key not in made.get("properties", {}):
            continue
        entry = made["properties"][key]
        entry["description"] = " ".join(filter(None, [texts.get(name), _allowed(entry)]))
    if issubclass(model, OneOf):
        words = sorted(made["properties"])
        for key, entry in made["properties"].items():
            made["properties"][key] = {"anyOf": [entry, {"type": "null"}], "description": entry.get("description", "")}
        alternative = {**made, "minProperties": 1, "maxProperties": 1}
        made.clear()
        made.update({"anyOf": [{"enum": words}, alternative]})


def _allowed(entry: Mapping[str, Any]) -> str | None:
    """Return the sentence about what is allowed, which may stand in a choice."""
    places = [entry, *entry.get("anyOf", []), *([entry["items"]] if isinstance(entry.get("items"), dict) else [])]
    return next((place["description"] for place in places if place.get("description", "").startswith("Allowed")), None)


def _kinds_of_faults() -> Iterator[dict[str, Any]]:
    """Yield the schema of each kind of fault, whose keys are those of its class."""
    from crazychoir_fw.simulation.faults import KINDS

    for name in FaultEntry.model_fields:
        kind = KINDS[name]
        texts = attribute_docstrings(kind)
        keys = {}
        for member in fields(kind):
            made = TypeAdapter(Annotated[Any, member.metadata["constraint"]]).json_schema(schema_generator=_Generator)
            made["description"] = " ".join(filter(None, [texts.get(member.name), made.get("description")]))
            keys[member.name] = made
        yield {
            "title": name,
            "type": ["object", "null"],
            "description": inspect.getdoc(kind) or "",
            "properties": keys,
            "additionalProperties": False,
        }
