"""A trained policy as plain numbers: normalization, layers, and what it sees and does."""

from __future__ import annotations

import dataclasses
import json
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.replacing import replacing
from crazychoir_fw.learning.action import KINDS, Action
from crazychoir_fw.learning.observation import Observation
from crazychoir_fw.learning.tasks.task import Task

Floats = NDArray[np.float32]

ACTIVATIONS = ("tanh", "relu", "none")
FORMAT = "crazychoir_fw policy 1"


def _floats(numbers: ArrayLike) -> Floats:
    return np.array(numbers, np.float32)


@dataclass(frozen=True)
class Layer:
    """y = activation(weight x + bias)."""

    weight: Floats
    """Shape (out, in)."""
    bias: Floats
    """Shape (out,)."""
    activation: str = "tanh"
    """One of `ACTIVATIONS`."""


@dataclass(frozen=True)
class Policy:
    """A multilayer perceptron in float32, from an observation to an action in [-1, 1]."""

    layers: Sequence[Layer]
    """From the observation to the action."""
    observation: Observation
    """What it sees."""
    action: Action
    """What it does."""
    rate_hz: int = 100
    """How often it acts (Hz)."""
    mean: Floats = field(default_factory=lambda: np.zeros(0, np.float32))
    """Subtracted from an observation, shape (k,); empty is no normalization."""
    factor: Floats = field(default_factory=lambda: np.zeros(0, np.float32))
    """Then multiplied with, shape (k,): one by the standard deviation."""
    clip: float = 10.0
    """A normalized observation lies within +- this."""
    platform: str = "cf2"
    """Airframe that its actions are scaled for."""

    def __post_init__(self) -> None:
        size = self.observation.size
        if not len(self.mean):
            object.__setattr__(self, "mean", np.zeros(size, np.float32))
            object.__setattr__(self, "factor", np.ones(size, np.float32))
        if self.mean.shape != (size,) or self.factor.shape != (size,):
            raise RangeError(f"policy: normalization has {self.mean.shape[0]} numbers, allowed: {size}, as observed")
        if not self.layers:
            raise RangeError("policy: it has no layer, allowed: 1 or more")
        for number, layer in enumerate(self.layers):
            if layer.weight.ndim != 2 or layer.weight.shape[1] != size or layer.bias.shape != layer.weight.shape[:1]:
                raise RangeError(
                    f"policy: layer {number} has weights of shape {layer.weight.shape}, allowed: (n, {size})"
                    + (f", as the observation has {size} numbers: {self.observation.blocks}" if number == 0 else "")
                )
            if layer.activation not in ACTIVATIONS:
                raise RangeError(f"policy: activation is {layer.activation!r}, allowed: {', '.join(ACTIVATIONS)}")
            size = len(layer.bias)
        if size != self.action.size:
            raise RangeError(f"policy: it has {size} outputs, allowed: {self.action.size}")
        parts = [self.mean, self.factor, *(part for layer in self.layers for part in (layer.weight, layer.bias))]
        if not all(np.isfinite(part).all() for part in parts):
            raise RangeError("policy: a number in it is not finite")

    @classmethod
    def for_task(cls, task: Task, layers: Sequence[Layer], **normalization: Any) -> Policy:
        """Return a policy that sees and does what a task says."""
        return cls(layers, task.observation, task.action, task.rate_hz, platform=task.platform, **normalization)

    def act(self, observations: ArrayLike) -> Floats:
        """Return actions, shape (N, A), of observations, shape (N, k): what the exported C computes."""
        x = (np.asarray(observations, np.float32) - self.mean) * self.factor
        x = np.clip(x, np.float32(-self.clip), np.float32(self.clip))
        for layer in self.layers:
            x = x @ layer.weight.T + layer.bias
            if layer.activation == "tanh":
                x = np.tanh(x)
            elif layer.activation == "relu":
                x = np.maximum(x, np.float32(0.0))
        return np.clip(x, np.float32(-1.0), np.float32(1.0))

    # ---------------------------------------------------------------------------------------- files

    def save(self, path: str | Path) -> None:
        """Write a NumPy archive (.npz) that `load` reads; plain numbers and text, nothing that is executed."""
        about = {
            "format": FORMAT,
            "blocks": list(self.observation.blocks),
            "source": self.observation.source,
            "action": {"kind": self.action.kind, **dataclasses.asdict(self.action)},
            "rate_hz": self.rate_hz,
            "clip": self.clip,
            "platform": self.platform,
            "activations": [layer.activation for layer in self.layers],
        }
        arrays = {"mean": self.mean, "factor": self.factor}
        for number, layer in enumerate(self.layers):
            arrays |= {f"weight{number}": layer.weight, f"bias{number}": layer.bias}
        with replacing(Path(path)) as temporary, temporary.open("wb") as file:
            np.savez(file, about=np.array(json.dumps(about)), **arrays)

    @classmethod
    def load(cls, path: str | Path) -> Policy:
        """Read a file of `save`.

        Raises:
            RangeError: If it is none.
        """
        try:
            with np.load(path, allow_pickle=False) as file:
                about = json.loads(str(file["about"]))
                if about["format"] != FORMAT:
                    raise ValueError(f"its format is '{about['format']}', this version reads '{FORMAT}'")
                layers = [
                    Layer(_floats(file[f"weight{number}"]), _floats(file[f"bias{number}"]), str(activation))
                    for number, activation in enumerate(about["activations"])
                ]
                return cls(
                    layers,
                    Observation(tuple(about["blocks"]), about["source"]),
                    action_of(about["action"]),
                    int(about["rate_hz"]),
                    _floats(file["mean"]),
                    _floats(file["factor"]),
                    float(about["clip"]),
                    str(about["platform"]),
                )
        except RangeError:
            raise
        except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile) as error:
            raise RangeError(f"{path} is no policy: {' '.join(str(error).split())}") from error


def action_of(about: Mapping[str, Any]) -> Action:
    """Return an action by its kind and fields.

    Raises:
        ValueError: If there is no such kind.
    """
    fields = dict(about)
    kind = fields.pop("kind")
    if kind not in KINDS:
        raise ValueError(f"its action is '{kind}', allowed: {', '.join(KINDS)}")
    return KINDS[kind](**fields)
