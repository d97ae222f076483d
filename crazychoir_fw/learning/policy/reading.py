"""Policies from files: ours (.npz), ONNX, Stable-Baselines3 (.zip) and torch (.pt). Nothing in a file is executed."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import MissingLibraryError, RangeError
from crazychoir_fw.learning.policy.network import Layer, Policy
from crazychoir_fw.learning.tasks.task import Task

Floats = NDArray[np.float32]
SUFFIXES = (".npz", ".onnx", ".zip", ".pt", ".pth")


def read_policy(
    path: str | Path, task: Task | None = None, normalization: str | Path | None = None, activation: str = "tanh"
) -> Policy:
    """Read a policy.

    Args:
        path: The file, with one of `SUFFIXES`.
        task: What it was trained for: observation, action and rate. A .npz says so itself.
        normalization: An archive (.npz) with ``mean`` and ``var`` of the observations, if the network does not have
            them within; as ``np.savez`` writes the ``obs_rms`` of Stable-Baselines3's `VecNormalize`.
        activation: Between the layers of a .zip or .pt, which do not say: ``tanh`` or ``relu``.

    Raises:
        RangeError: If the file holds no multilayer perceptron, or one that does not fit the task.
        MissingLibraryError: If a library is needed that is not installed.
    """
    path = Path(path)
    if path.suffix not in SUFFIXES:
        raise RangeError(f"{path}: a policy ends with {', '.join(SUFFIXES)}")
    if not path.is_file():
        raise RangeError(f"{path} does not exist")
    if path.suffix == ".npz":
        return Policy.load(path)
    if task is None:
        raise RangeError(f"{path} does not say what it sees and does; name the task that it was trained for")
    if task.camera is not None:
        raise RangeError(f"{path}: the task has a camera, allowed: none; a firmware app sees no pictures")
    if path.suffix == ".onnx":
        layers, known = _from_onnx(path)
    else:
        layers, known = _from_torch(path, activation), {}
    if normalization is not None:
        known = read_normalization(normalization)
    return Policy.for_task(task, layers, **known)


def read_normalization(path: str | Path, epsilon: float = 1e-8) -> dict[str, Floats]:
    """Return mean and factor of an archive with ``mean`` and ``var``.

    Raises:
        RangeError: If it is none.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            mean, var = np.asarray(file["mean"], float), np.asarray(file["var"], float)
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise RangeError(f"{path} is no archive with mean and var: {' '.join(str(error).split())}") from error
    return {"mean": mean.astype(np.float32), "factor": (1.0 / np.sqrt(var + epsilon)).astype(np.float32)}


# ------------------------------------------------------------------------------------------- torch


def layers_of(state: Mapping[str, Any], activation: str) -> list[Layer]:
    """Return the layers of a policy of Stable-Baselines3, or of a sequence of linear layers, by its weights.

    Args:
        state: Arrays by name: ``mlp_extractor.policy_net.0.weight`` and so on, or any with two-dimensional weights in
            order.
        activation: Behind each layer but the last one.

    Raises:
        RangeError: If there is no linear layer.
    """
    actor = [name for name in state if name.startswith(("mlp_extractor.policy_net.", "action_net."))]
    names = [name for name in (actor or state) if name.endswith(".weight") or name == "weight"]
    names = [name for name in names if np.ndim(state[name]) == 2]
    if not names:
        raise RangeError("policy: it has no linear layer, allowed: multilayer perceptrons")
    layers = []
    for number, name in enumerate(names):
        bias = name[: -len("weight")] + "bias"
        weight = np.array(state[name], np.float32)
        values = np.array(state[bias], np.float32) if bias in state else np.zeros(len(weight), np.float32)
        layers.append(Layer(weight, values, activation if number < len(names) - 1 else "none"))
    return layers


def _from_torch(path: Path, activation: str) -> list[Layer]:
    try:
        import torch
    except ImportError:
        raise MissingLibraryError(
            f"{path}: reading it needs torch; pip install 'crazychoir-fw[train]', or save an .npz or .onnx"
        ) from None
    try:
        if path.suffix == ".zip":
            with zipfile.ZipFile(path) as archive:
                source: Any = io.BytesIO(archive.read("policy.pth"))
        else:
            source = path
        state = torch.load(source, map_location="cpu", weights_only=True)
        arrays = {name: tensor.detach().numpy() for name, tensor in state.items()}
    except (KeyError, OSError, RuntimeError, AttributeError, zipfile.BadZipFile, ValueError) as error:
        raise RangeError(f"{path} holds no weights: {' '.join(str(error).split())[:200]}") from error
    return layers_of(arrays, activation)


# -------------------------------------------------------------------------------------------- ONNX

_PASSED_BY = ("Identity", "Flatten", "Cast", "Clip", "Reshape", "Dropout")


def _from_onnx(path: Path) -> tuple[list[Layer], dict[str, Any]]:
    """Return layers and normalization of a graph that is one chain from the observation on."""
    try:
        import onnx
        from onnx import numpy_helper
    except ImportError:
        raise MissingLibraryError(f"{path}: reading it needs onnx; pip install onnx installs it") from None
    try:
        graph = onnx.load(str(path)).graph
    except Exception as error:  # protobuf has an exception of its own, of a module that moves
        raise RangeError(f"{path} is no ONNX file: {' '.join(str(error).split())[:200]}") from error
    constants = {one.name: numpy_helper.to_array(one) for one in graph.initializer}
    for node in graph.node:
        if node.op_type == "Constant":
            constants[node.output[0]] = numpy_helper.to_array(node.attribute[0].t)
    chain = _Chain(str(path))
    at = next(one.name for one in graph.input if one.name not in constants)
    for node in graph.node:
        if node.op_type == "Constant" or at not in node.input:
            continue
        others = [constants[name] for name in node.input if name in constants]
        attributes = {one.name: onnx.helper.get_attribute_value(one) for one in node.attribute}
        chain.add(node.op_type, others, attributes, is_first=node.input[0] == at)
        at = node.output[0]
    return chain.layers(), chain.normalization()


class _Chain:
    """Operations one behind the other, as layers."""

    def __init__(self, path: str) -> None:
        self._path = path
        self._layers: list[Layer] = []
        self._mean: Any = None
        self._factor: Any = None

    def add(self, kind: str, others: Sequence[Any], attributes: Mapping[str, Any], is_first: bool) -> None:
        """Add an operation with its constants."""
        if kind in ("Tanh", "Relu") and self._layers and self._layers[-1].activation == "none":
            last = self._layers.pop()
            self._layers.append(Layer(last.weight, last.bias, kind.lower()))
        elif kind in ("Gemm", "MatMul") and others and is_first:
            self._add_linear(kind, others, attributes)
        elif kind == "Add" and self._layers and others and self._layers[-1].activation == "none":
            last = self._layers.pop()
            self._layers.append(Layer(last.weight, last.bias + np.ravel(others[0]), "none"))
        elif kind in ("Sub", "Div", "Mul") and not self._layers and others and is_first:
            self._add_normalization(kind, np.ravel(others[0]).astype(np.float32))
        elif kind not in _PASSED_BY:
            raise RangeError(
                f"{self._path}: operation {kind} is none of a multilayer perceptron, allowed: Gemm, MatMul, Add, Tanh, "
                "Relu, and Sub, Div or Mul before the first layer"
            )

    def _add_linear(self, kind: str, others: Sequence[Any], attributes: Mapping[str, Any]) -> None:
        is_turned = kind == "Gemm" and attributes.get("transB", 0) == 1
        scale = np.float32(attributes.get("alpha", 1.0))
        weight = np.asarray(others[0], np.float32) * scale
        weight = weight if is_turned else weight.T
        has_bias = kind == "Gemm" and len(others) > 1
        bias = np.ravel(others[1]) * np.float32(attributes.get("beta", 1.0)) if has_bias else np.zeros(len(weight))
        self._layers.append(Layer(weight, bias.astype(np.float32), "none"))

    def _add_normalization(self, kind: str, values: Floats) -> None:
        if kind == "Sub":
            self._mean = values
        else:
            self._factor = values if kind == "Mul" else np.float32(1.0) / values

    def layers(self) -> list[Layer]:
        """Return what was found."""
        if not self._layers:
            raise RangeError(f"{self._path}: it has no linear layer, allowed: multilayer perceptrons")
        return self._layers

    def normalization(self) -> dict[str, Any]:
        """Return mean and factor, if the graph has them."""
        if self._mean is None and self._factor is None:
            return {}
        size = self._layers[0].weight.shape[1]
        mean = np.zeros(size, np.float32) if self._mean is None else np.broadcast_to(self._mean, (size,))
        factor = np.ones(size, np.float32) if self._factor is None else np.broadcast_to(self._factor, (size,))
        return {"mean": np.array(mean, np.float32), "factor": np.array(factor, np.float32)}
