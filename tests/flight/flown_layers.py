"""Small missions with layers, for tests."""

from crazychoir_fw.mission.loader import parse_mission

SQUARE = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]
STARTS = [[-0.5, -0.5], [0.5, -0.5], [0.3, 0.2], [-0.3, 0.7]]
NAMES = ["a", "b", "c", "d"]


def formation(**changes):
    """Return the text of a formation of four on the integrator, as a mapping."""
    data = {
        "name": "square",
        "backend": "integrator",
        "seed": 1,
        "log_rate": 25,
        "drones": [{"id": name, "position": start} for name, start in zip(NAMES, STARTS, strict=True)],
        "layers": {
            "rate": 50,
            "odometry": "truth",
            "communication": {"graph": "complete"},
            "guidance": {
                "class": "BearingFormation",
                "leaders": ["a", "b"],
                "formation": SQUARE,
                "gains": "mujoco",
                "height": 0.6,
            },
            "planning": {"class": "Spline"},
            "control": {"gains": "mujoco"},
        },
        "flight": [{"takeoff": {"duration": 3}}, {"start": {"duration": 8}}, {"land": {"duration": 3}}],
    }
    return {**data, **changes}


def hover(count=1, **changes):
    """Return a mission, as a mapping, in which drones take off, follow their references, and land."""
    data = {
        "name": "hover",
        "backend": "integrator",
        "log_rate": 25,
        "drones": [{"id": NAMES[i], "position": [float(i), 0.0]} for i in range(count)],
        "layers": {
            "rate": 50,
            "odometry": "truth",
            "guidance": {"class": "SimpleGuidance", "height": 0.5},
            "planning": {"class": "Spline"},
            "control": {"gains": "mujoco"},
        },
        "flight": [{"takeoff": {"duration": 2}}, {"hover": {"duration": 1}}, {"land": {"duration": 2}}],
    }
    return {**data, **changes}


def within(data, path, value):
    """Return a copy of nested mappings with one value changed; None as value takes it away."""
    key, _, rest = path.partition(".")
    copy = dict(data)
    if rest:
        copy[key] = within(copy.get(key, {}), rest, value)
    elif value is None:
        copy.pop(key, None)
    else:
        copy[key] = value
    return copy


def mission(data, **overrides):
    """Return the mission of a mapping."""
    return parse_mission(data, **overrides)
