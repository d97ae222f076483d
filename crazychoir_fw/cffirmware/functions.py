"""Python functions over C functions: checked arguments, structs as objects, errors that name the parameter.

They are written as source text and compiled, as dataclasses are, so that a call costs little more than the call of C:
the parameters are real ones, for `inspect` and for keywords.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from crazychoir_fw.cffirmware.arrays import DTYPES, argument_maker, copy_back
from crazychoir_fw.cffirmware.function_table import Function, Parameter
from crazychoir_fw.cffirmware.numbers import integer, truth
from crazychoir_fw.cffirmware.struct_base import Struct, own, refer, view
from crazychoir_fw.cffirmware.structs import StructClasses

CANONICAL = "cf_upstream_"
"""In front of the name of a C function that has the newest signature whatever the provider's own has."""

GLOBALS = "cf_upstream_globals_t"

# the pointer of a planner that a function sets to one of its arguments
_KEEPS = {
    "plan_start_trajectory": ("p", "trajectory"),
    "plan_start_compressed_trajectory": ("p", "trajectory"),
}

# these do nothing bad to a trajectory without pieces
_WITHOUT_PIECES = ("piecewise_duration", "piecewise_is_finished")
# these write the first piece, however many there are
_FILLING = ("piecewise_plan_5th_order", "piecewise_plan_7th_order_no_jerk")


class FunctionMaker:
    """Makes the functions of one provider."""

    def __init__(self, ffi: Any, lib: Any, classes: StructClasses, c_globals: Any) -> None:
        """Make a maker.

        Args:
            ffi: Of the provider.
            lib: Its functions.
            classes: Its structs.
            c_globals: Pointer to what the provider keeps in place of file-scope variables; None if it has some.
        """
        self._ffi = ffi
        self._lib = lib
        self._classes = classes
        self._globals = c_globals

    def find(self, name: str) -> Any:
        """Return the C function of a name, or None."""
        return getattr(self._lib, CANONICAL + name, None) or getattr(self._lib, name, None)

    def make(self, function: Function) -> Callable[..., Any] | None:
        """Return the Python function, or None if the provider has no such function."""
        call = self.find(function.name)
        if call is None:
            return None
        writer = _Writer(self, function, call)
        source = writer.source()
        namespace = dict(writer.names)
        exec(compile(source, f"<cffirmware {function.name}>", "exec"), namespace)
        made = namespace[function.name]
        made.__module__ = "cffirmware"
        made.__qualname__ = function.name
        made.__doc__ = function.meaning
        made.__annotations__ = writer.annotations
        return made

    # of use to the writer
    @property
    def ffi(self) -> Any:
        """The ffi of the provider."""
        return self._ffi

    @property
    def lib(self) -> Any:
        """The functions of the provider."""
        return self._lib

    @property
    def classes(self) -> StructClasses:
        """The structs of the provider."""
        return self._classes

    @property
    def c_globals(self) -> Any:
        """What the provider keeps in place of file-scope variables."""
        return self._globals


class _Writer:
    """Writes the source of one function."""

    def __init__(self, maker: FunctionMaker, function: Function, call: Any) -> None:
        self._maker = maker
        self._function = function
        self.names: dict[str, Any] = {"_call": call, "_integer": integer, "_truth": truth, "_copy_back": copy_back}
        self.annotations: dict[str, Any] = {}
        self._before: list[str] = []
        self._after: list[str] = []
        self._types: list[tuple[str, Any]] = []
        signature = maker.ffi.typeof(call)
        c_types = list(signature.args)
        self._arguments: list[str] = []
        if maker.c_globals is not None and c_types and c_types[0].cname.startswith(GLOBALS):
            self.names["_globals"] = maker.c_globals
            self._arguments.append("_globals")
            del c_types[0]
        if len(c_types) != len(function.parameters):
            raise AssertionError(f"{function.name}: {len(function.parameters)} parameters, C has {len(c_types)}")
        for parameter, c_type in zip(function.parameters, c_types, strict=True):
            self._arguments.append(self._argument(parameter, c_type))
        self._add_special_lines()
        self._result = self._write_result(signature.result)

    def _argument(self, parameter: Parameter, c_type: Any) -> str:
        name = parameter.name
        if parameter.length is not None:
            return self._array(parameter, c_type)
        if c_type.kind == "pointer":
            cls = self._maker.classes.of(c_type.item)
            return self._typed(name, cls, f"{name}._c")
        if c_type.kind in ("struct", "union"):
            return self._typed(name, self._maker.classes.of(c_type), f"{name}._c[0]")
        if c_type.cname == "_Bool":
            return self._typed(name, bool, f"_truth({name})")
        if c_type.cname in ("float", "double"):
            return self._typed(name, float, name)
        return self._typed(name, int, f"_integer({name})")

    def _typed(self, name: str, expected: type, expression: str) -> str:
        self.annotations[name] = expected
        self._types.append((name, expected))
        return expression

    def _array(self, parameter: Parameter, c_type: Any) -> str:
        name = parameter.name
        item = c_type.item
        while item.kind == "array":
            item = item.item
        item_name = item.cname if item.cname in DTYPES else "uint8_t"
        self.annotations[name] = "Sequence[float]" if item_name in ("float", "double") else "Sequence[int]"
        self.names[f"_make_{name}"] = argument_maker(self._maker.ffi, item_name)
        self._before.append(
            f"{name}_c, {name}_copy = _make_{name}({name}, {parameter.length}, {name!r}, {parameter.is_written})"
        )
        if parameter.is_written:
            self._after.append(f"_copy_back({name}, {name}_copy)")
        if c_type.item.kind == "array":
            self.names["_cast"] = self._maker.ffi.cast
            self.names[f"_type_of_{name}"] = c_type
            return f"_cast(_type_of_{name}, {name}_c)"
        return f"{name}_c"

    def _add_special_lines(self) -> None:
        name = self._function.name
        first = self._types[0] if self._types else ("", None)
        for parameter, expected in self._types:
            if getattr(expected, "__name__", "") == "piecewise_traj":
                self.names["_demand_pieces"] = _demand_pieces
                at_least = 0 if name in _WITHOUT_PIECES else 1
                count = 1 if name in _FILLING else f"{parameter}._c.n_pieces"
                self._before.append(f"_demand_pieces({parameter}, {count}, {at_least})")
        if getattr(first[1], "__name__", "") == "kalmanCoreData_t" and _has_member(
            self._maker.ffi, first[1], "settled"
        ):
            # the covariance may have been written from outside
            self._before.append(f"{first[0]}._c.settled = 0")
        if name in _KEEPS:
            owner, kept = _KEEPS[name]
            planner = self._maker.ffi.typeof("struct planner")
            self.names["_refer"] = refer
            self._after.append(f"_refer({owner}, {dict(planner.fields)['trajectory'].offset}, {kept})")
        if hasattr(self._maker.lib, "cf_upstream_take_assertion"):
            self.names["_raise_assertion"] = assertion_raiser(self._maker.ffi, self._maker.lib)
            if name.startswith("kalmanCore"):
                self._after.append("_raise_assertion()")

    def _write_result(self, c_type: Any) -> str:
        if c_type.kind == "void":
            self.annotations["return"] = None
            return "None"
        if c_type.kind in ("struct", "union"):
            self.names |= {"_own": own, "_result": self._maker.classes.of(c_type)}
            self.annotations["return"] = self.names["_result"]
            return "_own(_result, result)"
        if c_type.kind == "pointer":
            # of one struct within another, the first argument
            self.names |= {"_view": view, "_result": self._maker.classes.of(c_type.item)}
            self.annotations["return"] = self.names["_result"]
            return f"_view(_result, result, {self._function.parameters[0].name})"
        self.annotations["return"] = {"_Bool": bool, "float": float, "double": float}.get(c_type.cname, int)
        return "result"

    def source(self) -> str:
        """Return the text of the function."""
        function = self._function
        names = ", ".join(parameter.name for parameter in function.parameters)
        call = f"_call({', '.join(self._arguments)})"
        body = [*self._before, f"result = {call}"]
        lines = [f"def {function.name}({names}):"]
        if function.parameters:
            self.names["_explain"] = _explainer(function.name, self._types)
            values = "".join(f"{name}, " for name, _ in self._types)
            lines += [
                "    try:",
                *(f"        {line}" for line in body),
                "    except (AttributeError, TypeError) as error:",
                f"        raise _explain(error, ({values})) from None",
            ]
        else:
            lines += [f"    {line}" for line in body]
        lines += [f"    {line}" for line in (*self._after, f"return {self._result}")]
        return "\n".join(lines) + "\n"


def _has_member(ffi: Any, cls: type[Struct], name: str) -> bool:
    """Return whether the C struct behind a class has a member, also one that Python does not show."""
    return name in dict(ffi.typeof(cls._pointer_type).item.fields)


def _explainer(name: str, types: list[tuple[str, Any]]) -> Callable[[Exception, tuple[Any, ...]], TypeError]:
    """Return a function that makes the TypeError of a call with wrong arguments."""

    def explain(error: Exception, values: tuple[Any, ...]) -> TypeError:
        for (parameter, expected), value in zip(types, values, strict=True):
            if not _fits(value, expected):
                given = "None" if value is None else type(value).__name__
                return TypeError(f"{name}(): {parameter} must be {expected.__name__}, not {given}")
        return TypeError(f"{name}(): {error}")

    return explain


def _fits(value: Any, expected: type) -> bool:
    if issubclass(expected, Struct):
        return isinstance(value, expected)
    try:
        if expected is float:
            float(value)
            return not isinstance(value, str)
        (truth if expected is bool else integer)(value)
    except (TypeError, ValueError):
        return False
    return True


def _demand_pieces(trajectory: Any, count: int, at_least: int) -> None:
    """Raise a ValueError where C would use memory that is not there."""
    if count == 0 and at_least == 0:
        return
    if count < at_least or not trajectory._c.pieces:
        raise ValueError(
            "the trajectory has no pieces: set n_pieces and pieces, for instance to poly4d_malloc(n_pieces)"
        )
    length = getattr(trajectory.pieces, "length", None)
    if length is not None and count > length:
        raise ValueError(f"the trajectory has n_pieces {count}, but memory for {length}")


def assertion_raiser(ffi: Any, lib: Any) -> Callable[[], None]:
    """Return a function that raises what an assertion of the firmware has left behind."""

    def raise_assertion() -> None:
        text = lib.cf_upstream_take_assertion()
        if text:
            failed_assertion(ffi.string(text).decode(errors="replace"))

    return raise_assertion


def failed_assertion(text: str) -> None:
    """Raise what upstream's module raises: SystemError, because of an AssertionError."""
    raise SystemError("an assertion of the firmware failed") from AssertionError(text)
