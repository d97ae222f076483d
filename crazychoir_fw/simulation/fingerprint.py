"""What makes two worlds the same, so that one may take the other's place: versions, providers, drones, physics."""

from __future__ import annotations

import functools
import hashlib
import json
from collections.abc import Iterable, Mapping
from itertools import pairwise
from typing import Any

import mujoco
import numpy as np

from crazychoir_fw.onboard.core import attribute_names, identity, provider_identity
from crazychoir_fw.onboard.variables import log_table, parameter_table
from crazychoir_fw.simulation.model_templates import without_padding

_MEANINGS = {
    "versions": "was made with {theirs}, this is {ours}",
    "providers": "has other onboard software: {theirs}, here flies {ours}",
    "memory": "keeps its drones in another layout of memory",
    "size": "has {theirs}, this one {ours}",
    "drones": "has drones that are configured differently or another seed",
    "programs": "has drones that are flown by other Python classes",
    "physics": "has another scene or other vehicles",
}
"""What to say of a world that differs in a part, the most telling one first."""

_PROGRAMS = ("motor_ctrl", "motor_ctrl_properties")

_OPTIONS = ("timestep", "gravity", "wind", "magnetic", "density", "viscosity", "integrator", "cone", "solver")
_OPTIONS += ("iterations", "tolerance", "disableflags", "enableflags")
_BODIES = ("body_parentid", "body_pos", "body_quat", "body_ipos", "body_iquat", "body_mass", "body_inertia")
_JOINTS = ("jnt_type", "jnt_bodyid", "jnt_pos", "jnt_axis", "jnt_range", "qpos0")
_JOINTS += ("dof_damping", "dof_armature", "dof_frictionloss")
_GEOMS = ("geom_type", "geom_bodyid", "geom_contype", "geom_conaffinity", "geom_condim", "geom_size", "geom_pos")
_GEOMS += ("geom_quat", "geom_friction", "geom_solref", "geom_solimp", "geom_margin", "geom_gap")

Fingerprint = Mapping[str, str]
"""Parts of what a world is, by name; short texts and digests."""


def fingerprint(model: mujoco.MjModel, providers: Iterable[int]) -> dict[str, str]:
    """Return what a world is; what is only seen does not count.

    Args:
        model: The compiled world.
        providers: Numbers of the providers that its drones ask for.
    """
    build = identity()
    numbers = list(providers)
    collides = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    physics = [np.asarray(getattr(model.opt, name)) for name in _OPTIONS]
    physics += [getattr(model, name) for name in (*_BODIES, *_JOINTS)]
    physics += [getattr(model, name)[collides] for name in _GEOMS]
    if np.any(model.geom_type[collides] == mujoco.mjtGeom.mjGEOM_MESH):
        physics.append(model.mesh_vert)
    physics.append(model.hfield_data)
    drones, programs = _attributes(model)
    return {
        "versions": f"crazychoir_fw {build['version']} over MuJoCo {build['mujoco']}",
        "providers": "; ".join(_provider(number) for number in numbers),
        "memory": _layout(tuple(numbers)),
        "size": f"{np.count_nonzero(model.body_plugin >= 0)} drones and {_state_size(model)} numbers of state",
        "drones": _digest([*drones, *_names(model)]),
        "programs": _digest(programs),
        "physics": _digest(np.ascontiguousarray(part).tobytes() for part in physics),
    }


def difference(theirs: Fingerprint, ours: Fingerprint) -> str | None:
    """Return in what a world differs from this one, as the end of a sentence about it, or None."""
    for part, meaning in _MEANINGS.items():
        if theirs.get(part) != ours.get(part):
            return meaning.format(theirs=theirs.get(part), ours=ours.get(part))
    return None


@functools.cache
def _layout(providers: tuple[int, ...]) -> str:
    """Return a digest of where drones with these providers keep their variables."""
    tables = [table for number in providers for table in (log_table(number), parameter_table(number))]
    layouts = [[(name, row.offset, str(row.dtype)) for name, row in table.items()] for table in tables]
    return _digest([json.dumps(layouts).encode()])


def _provider(number: int) -> str:
    known: dict[str, Any] = provider_identity(number)
    keys = ("provider", "version", "platform", "compiler", "content")
    return " ".join(str(known[key]) for key in keys if key in known)


def _attributes(model: mujoco.MjModel) -> tuple[list[bytes], list[bytes]]:
    """Return the attributes of the plugins of a model, and apart from them the Python classes that they name."""
    everything = model.plugin_attr.tobytes()
    known = attribute_names()
    places = sorted(known.index(name) for name in _PROGRAMS)
    told, programs = [], []
    for begin, end in pairwise([*model.plugin_attradr.tolist(), len(everything)]):
        texts = list(without_padding(everything[begin:end].split(b"\0")))
        if len(texts) == len(known) + 1:  # each text ends with a zero; other plugins have other attributes
            programs += [texts.pop(place) for place in reversed(places)]
        told.append(b"\0".join(texts))
    return told, programs


def _names(model: mujoco.MjModel) -> list[bytes]:
    """Return the names of the bodies with plugins; other names belong to what is only seen."""
    return [model.body(int(body)).name.encode() for body in np.flatnonzero(model.body_plugin >= 0)]


def _state_size(model: mujoco.MjModel) -> int:
    return mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_INTEGRATION)


def _digest(parts: Iterable[bytes]) -> str:
    digest = hashlib.sha256()
    for part in parts:
        digest.update(len(part).to_bytes(8, "little"))
        digest.update(part)
    return digest.hexdigest()[:32]
