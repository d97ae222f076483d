"""Writes airframe_table.c, the numbers of all vehicles, from the YAML files in crazychoir_fw/onboard/vehicles.

Run it from anywhere: `python bindings/vehicle/airframe_table.py`.
"""

from pathlib import Path
from typing import Any

import yaml

HERE = Path(__file__).resolve().parent
VEHICLES = HERE.parents[1] / "crazychoir_fw" / "onboard" / "vehicles"
PLATFORMS = ("cf2", "cf21bl")


def read(name: str) -> dict[str, dict[str, Any]]:
    """Return one file of the folder."""
    return yaml.safe_load((VEHICLES / f"{name}.yaml").read_text())


def words(meaning: dict[str, Any]) -> list[str]:
    """Return the words of a choice, or nothing for numbers. YAML reads off and on as false and true."""
    first = meaning["range"][0]
    if isinstance(first, bool):
        return ["off", "on"]
    return meaning["range"] if isinstance(first, str) else []


def literal(value: float) -> str:
    """Return a C literal of type float."""
    text = repr(float(value))
    return f"{text}f" if "." in text or "e" in text else f"{text}.0f"


def row(name: str, meaning: dict[str, Any], platforms: list[dict[str, Any]]) -> str:
    """Return one row of the table."""
    choice = words(meaning)
    low, high = (0, len(choice) - 1) if choice else meaning["range"]
    size = meaning.get("size", 1)
    sets = []
    for platform in platforms:
        entry = platform[name]
        if entry["unit"] != meaning["unit"]:
            raise SystemExit(f"{name}: unit {entry['unit']!r} differs from {meaning['unit']!r} in parameters.yaml")
        value = entry["value"]
        numbers = [choice.index(value) if isinstance(value, str) else value] if size == 1 else value
        if len(numbers) != size or not all(low <= number <= high for number in numbers):
            raise SystemExit(f"{name}: value {value!r} is not {size} within {low} to {high}")
        sets.append("{" + ", ".join(literal(number) for number in numbers) + "}")
    listed = ", ".join(f'"{word}"' for word in choice) or "NULL"
    return (
        f'    {{"{name}", "{meaning["unit"] or "1"}", {size}, {literal(low)}, {literal(high)}, '
        f"{{{listed}}}, {{{', '.join(sets)}}}}},"
    )


def table() -> str:
    """Return the text of airframe_table.c."""
    meanings = read("parameters")
    platforms = [read(name) for name in PLATFORMS]
    for name, platform in zip(PLATFORMS, platforms, strict=True):
        if list(platform) != list(meanings):
            odd = set(platform) ^ set(meanings) or "their order"
            raise SystemExit(f"{name}.yaml and parameters.yaml differ in {odd}")
    return "\n".join(
        [
            "/* Numbers of crazychoir_fw/onboard/vehicles, made by airframe_table.py. */",
            '#include "vehicle/airframe_table.h"',
            "",
            "#include <stddef.h>",
            "",
            "// clang-format off",
            "const cf_parameter_facts_t CF_PARAMETER_FACTS[] = {",
            *(row(name, meaning, platforms) for name, meaning in meanings.items()),
            "};",
            "// clang-format on",
            "",
            "const int CF_PARAMETER_FACTS_COUNT =",
            "    (int)(sizeof CF_PARAMETER_FACTS / sizeof CF_PARAMETER_FACTS[0]);",
            "",
        ]
    )


if __name__ == "__main__":
    (HERE / "airframe_table.c").write_text(table())
