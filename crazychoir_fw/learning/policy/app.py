"""A policy as a firmware app: one self-contained C file."""

from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path

import jinja2
import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.replacing import replacing
from crazychoir_fw.learning.action import Residual
from crazychoir_fw.learning.observation import BLOCKS
from crazychoir_fw.learning.policy.cost import cost_of
from crazychoir_fw.learning.policy.network import Policy

_NAME = re.compile(r"[a-z][a-z0-9_]{0,14}")
_PER_LINE = 6
_ON_BOARD = (
    *("position_error", "velocity_error", "reference_acceleration", "position", "velocity", "rotation"),
    *("rates", "specific_force", "action"),
)
"""Blocks that the C file knows; one of the user's own needs a line there."""


def write_app(policy: Policy, folder: str | Path, name: str = "policy", origin: str = "") -> Path:
    """Write the C file of an app that flies a policy, and return its path.

    Args:
        policy: The policy.
        folder: Where to; it is made.
        name: Of the file, and of its groups of parameters and log variables.
        origin: Where the policy comes from, for the head of the file.

    Raises:
        RangeError: If a firmware app cannot see what the policy sees, or the name is no C name.
    """
    if not _NAME.fullmatch(name):
        raise RangeError(f"name is '{name}', allowed: a small letter, then up to 14 small letters, digits and _")
    if policy.observation.source != "estimate":
        raise RangeError("policy: it sees the truth, which no drone knows; allowed: source 'estimate'")
    for block in policy.observation.blocks:
        if block not in _ON_BOARD or not BLOCKS[block].is_on_board:
            raise RangeError(f"policy: it sees '{block}', which an app cannot; allowed: {', '.join(_ON_BOARD)}")
    path = Path(folder) / f"{name}.c"
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as temporary:
        temporary.write_text(c_source(policy, name, origin), encoding="utf-8")
    return path


def c_source(policy: Policy, name: str, origin: str = "") -> str:
    """Return the text of the C file."""
    environment = jinja2.Environment(trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined)
    environment.filters["floats"] = _floats
    template = environment.from_string(files(__package__).joinpath("app.c.jinja").read_text(encoding="utf-8"))
    scale = policy.action.scale(policy.platform)
    return template.render(
        name=name,
        origin=" ".join(origin.split()).replace("*/", ""),
        policy=policy,
        blocks=[(block, BLOCKS[block]) for block in policy.observation.blocks],
        layers=list(enumerate(policy.layers)),
        widest=max([policy.observation.size, *(len(layer.bias) for layer in policy.layers)]),
        period=1000 // policy.rate_hz,
        scale=scale,
        kind=policy.action.kind,
        law_gain=_float(policy.action.gain) if isinstance(policy.action, Residual) else "0.0f",
        clip=_float(policy.clip),
        cost=cost_of(policy),
    )


def _float(number: float) -> str:
    """Return a float32 as C has it, to the last bit."""
    text = f"{np.float32(number):.9g}"
    return (text if "." in text or "e" in text else text + ".0") + "f"


def _floats(numbers: NDArray[np.float32]) -> str:
    """Return numbers as the inside of an initializer."""
    words = [_float(number) for number in np.ravel(numbers)]
    lines = [", ".join(words[k : k + _PER_LINE]) for k in range(0, len(words), _PER_LINE)]
    return ",\n    ".join(lines)
