"""Old call forms beside the newest ones, told apart by the number of arguments."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Any, NamedTuple


class Form(NamedTuple):
    """A call form of an older release."""

    parameters: tuple[str, ...]
    convert: Callable[..., tuple[Any, ...]]
    """From the arguments of this form to those of the newest one."""


def accepting(newest: Callable[..., Any], *older: Form) -> Callable[..., Any]:
    """Return a function that takes the arguments of the newest form or of an older one."""
    name = newest.__name__
    names = tuple(inspect.signature(newest).parameters)
    count = len(names)
    forms = {len(form.parameters): form for form in older}
    allowed = " or ".join(map(str, sorted([*forms, count])))

    def function(*args: Any, **named: Any) -> Any:
        given = len(args) + len(named)
        if given == count:
            return newest(*args, *_in_order(name, names[len(args) :], named)) if named else newest(*args)
        form = forms.get(given)
        if form is None:
            raise TypeError(f"{name}() takes {allowed} arguments, {given} given")
        return newest(*form.convert(*args, *_in_order(name, form.parameters[len(args) :], named)))

    function.__name__ = function.__qualname__ = name
    function.__module__ = newest.__module__
    old = "; ".join(f"({', '.join(form.parameters)})" for form in older)
    function.__doc__ = f"{newest.__doc__}\n\nOlder releases, accepted as well: {old}"
    function.__signature__ = inspect.signature(newest)  # type: ignore[attr-defined]
    return function


def _in_order(name: str, rest: tuple[str, ...], named: dict[str, Any]) -> list[Any]:
    """Return arguments that were given by name, in the order of the parameters that are left."""
    if set(rest) != set(named):
        raise TypeError(f"{name}(): the last parameters are {', '.join(rest)}, not {', '.join(named)}")
    return [named[parameter] for parameter in rest]


def refusing(function: Callable[..., Any], parameter: str, is_there: bool) -> Callable[..., Any]:
    """Return a function that takes no true value of a parameter, unless the provider can do what it asks for.

    The error is the TypeError that the SWIG module of that release raises for an argument too many.
    """
    if is_there:
        return function
    place = list(inspect.signature(function).parameters).index(parameter)

    @functools.wraps(function)
    def checked(*args: Any) -> Any:
        if len(args) > place and args[place]:
            raise TypeError(f"{function.__name__}(): {parameter} is unknown to this release of the firmware")
        return function(*args)

    return checked


def with_old_forms(firm: dict[str, Any], lib: Any) -> dict[str, Any]:
    """Return the functions of a module whose signature has changed between releases.

    Args:
        firm: Classes and functions of the provider, in the newest form.
        lib: Its C functions and constants.
    """
    has_linear = bool(getattr(lib, "CF_UPSTREAM_HAS_LINEAR", True))
    has_relative_yaw = bool(getattr(lib, "CF_UPSTREAM_HAS_RELATIVE_YAW", True))
    made = {
        "plan_go_to": accepting(
            refusing(firm["plan_go_to"], "linear", has_linear),
            Form(
                ("p", "relative", "hover_pos", "hover_yaw", "duration", "t"),
                lambda p, relative, *rest: (p, relative, False, *rest),
            ),
        ),
        "plan_go_to_from": accepting(
            refusing(firm["plan_go_to_from"], "linear", has_linear),
            Form(
                ("p", "curr_eval", "relative", "hover_pos", "hover_yaw", "duration", "t"),
                lambda p, start, relative, *rest: (p, start, relative, False, *rest),
            ),
        ),
        "plan_start_trajectory": accepting(
            refusing(firm["plan_start_trajectory"], "relative_yaw", has_relative_yaw),
            Form(
                ("p", "trajectory", "reversed", "relative", "start_from"),
                lambda p, trajectory, reverse, relative, start: (p, trajectory, reverse, relative, False, start, 0.0),
            ),
        ),
        **_kalman(firm),
        **_mellinger(firm),
    }
    return made


def _kalman(firm: dict[str, Any]) -> dict[str, Any]:
    """Prediction without parameters uses those that the filter was started with."""
    start, default_params, params_type = (
        firm["kalmanCoreInit"],
        firm["kalmanCoreDefaultParams"],
        firm["kalmanCoreParams_t"],
    )

    def kalmanCoreInit(core: Any, params: Any, nowMs: int) -> None:
        start(core, params, nowMs)
        core.__dict__["_params"] = params.__copy__()

    kalmanCoreInit.__doc__ = start.__doc__
    kalmanCoreInit.__annotations__ = start.__annotations__

    def with_params(core: Any, *rest: Any) -> tuple[Any, ...]:
        params = getattr(core, "_params", None)
        if params is None:
            params = params_type()
            default_params(params)
        return (core, params, *rest)

    return {
        "kalmanCoreInit": kalmanCoreInit,
        "kalmanCorePredict": accepting(
            firm["kalmanCorePredict"], Form(("core", "acc", "gyro", "nowMs", "quadIsFlying"), with_params)
        ),
    }


def _mellinger(firm: dict[str, Any]) -> dict[str, Any]:
    """Without `self`, as before 2023, they work on one controller of the module."""
    the_one = firm["controllerMellinger_t"]()
    firm["controllerMellingerInit"](the_one)

    def with_self(*arguments: Any) -> tuple[Any, ...]:
        return (the_one, *arguments)

    inputs = ("control", "setpoint", "sensors", "state", "stabilizerStep")
    return {
        "controllerMellingerInit": accepting(firm["controllerMellingerInit"], Form((), with_self)),
        "controllerMellingerTest": accepting(firm["controllerMellingerTest"], Form((), with_self)),
        "controllerMellinger": accepting(firm["controllerMellinger"], Form(inputs, with_self)),
    }
