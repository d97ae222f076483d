"""What upstream's module has beside C: trajectories from Python, conversions, and a failed assertion on request."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from crazychoir_fw.cffirmware.functions import failed_assertion
from crazychoir_fw.cffirmware.members import demand
from crazychoir_fw.cffirmware.numbers import integer
from crazychoir_fw.cffirmware.struct_base import refer, view

_DIMENSIONS, _COEFFICIENTS = 4, 8
_ASSERTION_BYTES = 150


def additions(ffi: Any, firm: dict[str, Any], find: Callable[[str], Any]) -> dict[str, Any]:
    """Return the functions that are written in Python.

    Args:
        ffi: Of the provider.
        firm: Classes and functions so far, by name.
        find: Returns a C function, or None.
    """
    made = {
        **_trajectories(ffi, firm),
        **_conversions(firm),
        "collisionAvoidanceUpdateSetpointWrap": _wrap_collision_avoidance(firm),
        "assertFail": assert_fail,
    }
    if load := find("piecewise_compressed_load"):
        made["piecewise_compressed_load"] = _load_compressed(ffi, firm["piecewise_traj_compressed"], load)
    return made


def _trajectories(ffi: Any, firm: dict[str, Any]) -> dict[str, Any]:
    poly4d, piecewise_traj = firm["poly4d"], firm["piecewise_traj"]
    item = ffi.typeof("struct poly4d[]")

    def poly4d_malloc(size: int) -> poly4d:
        """Memory for so many pieces, to be assigned to `pieces` of a trajectory, which keeps it alive."""
        count = integer(size)
        if count < 1:
            raise ValueError(f"poly4d_malloc(): size must be at least 1, not {count}")
        memory = ffi.new(item, count)
        made = view(poly4d, memory + 0, memory)
        made.length = count
        return made

    def poly4d_free(p: poly4d) -> None:
        """Does nothing: memory is freed with the last reference to it."""
        demand(p, poly4d, "poly4d_free(): p")

    def place(dimension: int, coefficient: int, name: str) -> tuple[int, int]:
        i, j = integer(dimension), integer(coefficient)
        if not (0 <= i < _DIMENSIONS and 0 <= j < _COEFFICIENTS):
            raise IndexError(
                f"{name}(): dim {i}, coef {j}; allowed: 0 to {_DIMENSIONS - 1} (x, y, z, yaw), 0 to {_COEFFICIENTS - 1}"
            )
        return i, j

    def poly4d_set(poly: poly4d, dim: int, coef: int, val: float) -> None:
        """Sets a coefficient: dim 0 x, 1 y, 2 z, 3 yaw; coef is the power of t."""
        demand(poly, poly4d, "poly4d_set(): poly")
        i, j = place(dim, coef, "poly4d_set")
        poly._c.p[i][j] = val

    def poly4d_get(poly: poly4d, dim: int, coef: int) -> float:
        """A coefficient: dim 0 x, 1 y, 2 z, 3 yaw; coef is the power of t."""
        demand(poly, poly4d, "poly4d_get(): poly")
        i, j = place(dim, coef, "poly4d_get")
        return poly._c.p[i][j]

    def piecewise_get(pp: piecewise_traj, i: int) -> poly4d:
        """Piece i of a trajectory, a live view."""
        demand(pp, piecewise_traj, "piecewise_get(): pp")
        number, pieces = integer(i), pp.pieces
        if pieces is None:
            raise ValueError(
                "piecewise_get(): the trajectory has no pieces; set pieces, for instance to poly4d_malloc(n)"
            )
        length = getattr(pieces, "length", None)
        if number < 0 or (length is not None and number >= length):
            raise IndexError(f"piecewise_get(): piece {number}; allowed: 0 to {(length or pp.n_pieces) - 1}")
        return view(poly4d, ffi.cast(pieces._pointer_type, pp._c.pieces) + number, pieces)

    return {f.__name__: f for f in (poly4d_malloc, poly4d_free, poly4d_set, poly4d_get, piecewise_get)}


def _conversions(firm: dict[str, Any]) -> dict[str, Any]:
    vec, vec3_s = firm["vec"], firm["vec3_s"]

    def svec2vec(v: vec) -> vec3_s:
        """The vector of the stabilizer for a plain one, timestamp 0."""
        demand(v, vec, "svec2vec(): v")
        made = vec3_s()
        made._c.x, made._c.y, made._c.z = v._c.x, v._c.y, v._c.z
        return made

    def vec2svec(s: vec3_s) -> vec:
        """The plain vector for one of the stabilizer."""
        demand(s, vec3_s, "vec2svec(): s")
        return firm["mkvec"](s._c.x, s._c.y, s._c.z)

    return {"svec2vec": svec2vec, "vec2svec": vec2svec}


def _wrap_collision_avoidance(firm: dict[str, Any]) -> Callable[..., None]:
    core = firm["collisionAvoidanceUpdateSetpointCore"]

    def collisionAvoidanceUpdateSetpointWrap(
        params: Any,
        collisionState: Any,
        nOthers: int,
        otherPositions: Sequence[float],
        setpoint: Any,
        sensorData: Any,
        state: Any,
    ) -> None:
        """Bends a setpoint away from other drones.

        nOthers is the number of floats in otherPositions, three per drone.
        """
        core(params, collisionState, integer(nOthers) // 3, otherPositions, None, setpoint, sensorData, state)

    return collisionAvoidanceUpdateSetpointWrap


def _load_compressed(ffi: Any, cls: Any, load: Any) -> Callable[..., None]:
    def piecewise_compressed_load(traj: cls, data: bytes) -> None:
        """Makes a compressed trajectory of bytes; the trajectory keeps them alive."""
        demand(traj, cls, "piecewise_compressed_load(): traj")
        # a piece of duration 0 ends the trajectory, whatever follows
        memory = ffi.new("uint8_t[]", bytes(data) + bytes(64))
        refer(traj, dict(ffi.typeof(cls._pointer_type).item.fields)["data"].offset, memory)
        load(traj._c, memory, len(data) + 3)

    return piecewise_compressed_load


def assert_fail(exp: str, file: str, line: int) -> None:
    """Does what a failed assertion of the firmware does: SystemError, caused by an AssertionError."""
    if not isinstance(exp, str) or not isinstance(file, str):
        raise TypeError("assertFail(): exp and file must be str")
    text = f'{exp} in File: "{file}", line {integer(line)}\n'
    failed_assertion(text.encode()[: _ASSERTION_BYTES - 1].decode(errors="ignore"))


assert_fail.__name__ = assert_fail.__qualname__ = "assertFail"
