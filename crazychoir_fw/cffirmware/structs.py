"""Python classes made from the C types of a provider."""

from __future__ import annotations

from typing import Any

from crazychoir_fw.cffirmware import members
from crazychoir_fw.cffirmware.struct_base import Struct, copy_references
from crazychoir_fw.cffirmware.vector_protocol import VectorProtocol

# Python class: C type, for all that have not the same name
_TAGS = ("vec3_s", "vec", "quat", "mat33", "poly4d", "traj_eval", "piecewise_traj", "planner")

_OTHERS = """
attitude_t quaternion_t Axis3f baro_t sensorData_t state_t control_t motors_thrust_uncapped_t motors_thrust_pwm_t
setpoint_t setpoint_mode_t tdoaMeasurement_t positionMeasurement_t poseMeasurement_t distanceMeasurement_t
zDistance_t flowMeasurement_t tofMeasurement_t heightMeasurement_t yawErrorMeasurement_t sweepAngleMeasurement_t
gyroscopeMeasurement_t accelerationMeasurement_t barometerMeasurement_t estimate_t setpointZ_t
collision_avoidance_params_t collision_avoidance_state_t controllerMellinger_t controllerLee_t Axis3fSubSampler_t
OutlierFilterTdoaState_t kalmanCoreData_t kalmanCoreParams_t Axis3i16 Axis3i32 Axis3i64
"""
NAMES = (*_TAGS, *_OTHERS.split())
"""Classes of upstream's module; a provider has those that its headers declare."""

EXTRA_NAMES = ("lpf2pData", "piecewise_traj_compressed")
"""Classes that upstream's module does not have."""

TAGGED = (*_TAGS, "piecewise_traj_compressed")

# members of builtin that upstream's structs lack: bookkeeping of ours
HIDDEN = {("kalmanCoreData_t", "settled"), ("controllerLee_t", "max_thrust")}

# with an explicit constructor for copies
_COPYABLE = ("vec", "traj_eval")


class StructClasses:
    """The classes of one provider, made when they are first asked for."""

    def __init__(self, ffi: Any, lib: Any) -> None:
        self._ffi = ffi
        self._lib = lib
        self._made: dict[Any, type[Struct]] = {}
        self._names: dict[Any, str] = {}
        self.by_name: dict[str, type[Struct]] = {}
        types = {name: self._find(name) for name in (*NAMES, *EXTRA_NAMES)}
        self._names = {ctype: name for name, ctype in types.items() if ctype is not None}
        for ctype, name in self._names.items():
            self.by_name[name] = self.of(ctype)

    def _find(self, name: str) -> Any:
        try:
            ctype = self._ffi.typeof(f"struct {name}" if name in TAGGED else name)
        except self._ffi.error:
            return None
        # declared and never defined
        return None if ctype.fields is None else ctype

    def of(self, ctype: Any, name: str | None = None) -> type[Struct]:
        """Return the class of a C struct or union; `name` is for one that has none of its own."""
        if ctype not in self._made:
            self._made[ctype] = self._make(ctype, self._names.get(ctype) or name or ctype.cname.split()[-1])
        return self._made[ctype]

    def _make(self, ctype: Any, name: str) -> type[Struct]:
        base = VectorProtocol if name == "vec" else Struct
        body: dict[str, Any] = {"__module__": "cffirmware", "__doc__": _describe(name, ctype), "__slots__": ()}
        shown = []
        for member, field in ctype.fields or ():
            if (name, member) not in HIDDEN:
                body[member] = self._property(name, member, field)
                shown.append(member)
        body |= {
            "_ffi": self._ffi,
            "_pointer_type": self._ffi.getctype(ctype, "*"),
            "_size": self._ffi.sizeof(ctype),
            "_member_names": tuple(shown),
            "_has_pointers": _has_pointers(ctype),
        }
        if name == "vec":
            body |= {
                "_add": staticmethod(self._lib.vadd),
                "_subtract": staticmethod(self._lib.vsub),
                "_negate": staticmethod(self._lib.vneg),
                "_scale": staticmethod(self._lib.vscl),
                "_divide": staticmethod(self._lib.vdiv),
            }
        if name in _COPYABLE:
            body["__init__"] = _copy_constructor
        return type(name, (base,), body)

    def _property(self, struct: str, name: str, field: Any) -> property:
        ctype = field.type
        if ctype.kind in ("struct", "union"):
            return members.nested(name, self.of(ctype, f"{struct}_{name}"), field.offset)
        if ctype.kind == "array":
            if ctype.item.kind in ("struct", "union"):
                return members.structs(name, self.of(ctype.item, f"{struct}_{name}"), ctype.length)
            return members.numbers(name, ctype, field.offset)
        if ctype.kind == "pointer" and ctype.item in self._names:
            return members.pointer_to_struct(name, self.of(ctype.item), field.offset)
        if ctype.kind in ("pointer", "function"):
            return members.opaque_pointer(name, ctype, field.offset, self._ffi)
        return members.scalar(name, ctype)


def _has_pointers(ctype: Any) -> bool:
    while ctype.kind == "array":
        ctype = ctype.item
    if ctype.kind in ("struct", "union"):
        return any(_has_pointers(field.type) for _, field in ctype.fields or ())
    return ctype.kind in ("pointer", "function")


def _describe(name: str, ctype: Any) -> str:
    fields = ", ".join(f"{member}: {_type_name(field.type)}" for member, field in ctype.fields or ())
    return f"{name} of the firmware's C, all zero when made.\n\n{fields}"


def _type_name(ctype: Any) -> str:
    return ctype.cname.removeprefix("struct ")


def _copy_constructor(self: Struct, *originals: Any) -> None:
    """Make a struct of zeros or a copy of another one."""
    if len(originals) > 1:
        raise TypeError(f"{type(self).__name__}() takes at most 1 argument, {len(originals)} given")
    Struct.__init__(self)
    if originals:
        members.demand(originals[0], type(self), "the original")
        self._c[0] = originals[0]._c[0]
        if self._has_pointers:
            copy_references(originals[0], self, 0)
