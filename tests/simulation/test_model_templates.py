"""A world that differs in values from one before is a copy of its model: with the bits of a compilation."""

import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.simulation import DroneConfig, World, builder
from crazychoir_fw.simulation.fingerprint import fingerprint
from crazychoir_fw.simulation.model_templates import ModelTemplates

_ROOM_OF_ATTRIBUTES = ("npluginattr", "plugin_attr", "plugin_attradr", "nbuffer", "text_data")


def drones_of(rng, count=2):
    return [
        DroneConfig(
            f"cf{i}",
            position=(float(rng.normal()) + 3 * i, float(rng.normal())),
            yaw_deg=float(rng.normal(scale=60.0)),
            mass=float(rng.uniform(0.028, 0.036)) if rng.random() < 0.7 else None,
            battery=float(rng.random()),
            vehicle={"rotors.thrust_scale": float(rng.uniform(0.9, 1.1))},
        )
        for i in range(count)
    ]


def numbers_of(model):
    parts = {"": model, "stat.": model.stat, "opt.": model.opt}
    found = {
        prefix + name: np.asarray(getattr(part, name))
        for prefix, part in parts.items()
        for name in dir(part)
        if not name.startswith("_") and isinstance(getattr(part, name), np.ndarray | int | float | bytes)
    }
    return {name: value for name, value in found.items() if name not in _ROOM_OF_ATTRIBUTES}


@pytest.fixture
def templates(monkeypatch):
    monkeypatch.setattr(builder, "_templates", ModelTemplates())


@pytest.fixture
def compilations(monkeypatch):
    made, compiled = [], builder._compiled

    def count(spec, what):
        made.append(what)
        return compiled(spec, what)

    monkeypatch.setattr(builder, "_compiled", count)
    return made


@pytest.mark.parametrize("visuals", [False, True])
def test_copies_have_the_bits_of_compilations(templates, compilations, visuals):
    rng = np.random.default_rng(3)
    for seed in range(12):
        drones = drones_of(rng)
        copied = builder.build_model(drones, "arena", seed, visuals)
        built = builder._built(drones, "arena", seed, visuals, ())[0]
        ours, theirs = numbers_of(copied), numbers_of(built)
        assert ours.keys() == theirs.keys()
        differing = [name for name in ours if ours[name].tobytes() != theirs[name].tobytes()]
        assert differing == []
        assert fingerprint(copied, [0]) == fingerprint(built, [0])
    assert len(compilations) == 12 + 2  # the first world and the template


def flown(drones, seed):
    world = World(drones, seed=seed, visuals=False)
    world.wait_until_ready()
    for drone in world.drones:
        drone.high_level_commander.takeoff(0.5, 1.0)
    world.run(1.5)
    return world.snapshot(), world.fingerprint


def test_worlds_of_copies_fly_the_same_bits(templates):
    rng = np.random.default_rng(5)
    flights = [drones_of(rng) for _ in range(3)]
    ours = [flown(drones, seed) for seed, drones in enumerate(flights)]
    builder._templates = ModelTemplates()
    for seed in (2, 1, 0):
        builder._templates = ModelTemplates()  # each is compiled
        theirs, what = flown(flights[seed], seed)
        assert what == ours[seed][1]
        assert theirs.state.tobytes() == ours[seed][0].state.tobytes()


def test_a_copy_belongs_to_its_world(templates):
    worlds = [World([DroneConfig("cf1", battery=0.5)], visuals=False) for _ in range(4)]
    worlds[1].model.body_mass[:] = 1.0
    assert worlds[2].model.body_mass[1] != 1.0
    again = World([DroneConfig("cf1", battery=0.5)], visuals=False)
    assert again.model.body_mass.tobytes() == worlds[0].model.body_mass.tobytes()


def test_values_out_of_range_are_refused_as_by_the_compiler(templates):
    for _ in range(3):
        World([DroneConfig("cf1")], visuals=False)
    for value in (1.5, -1.0):
        with pytest.raises(RangeError, match="battery"):
            World([DroneConfig("cf1", battery=value)], visuals=False)
    with pytest.raises(RangeError, match="no_such"):
        World([DroneConfig("cf1", attributes={"no_such": 1})], visuals=False)


def test_attributes_that_find_no_room_are_compiled(templates, compilations):
    for _ in range(3):
        World([DroneConfig("cf1")], visuals=False)
    before = len(compilations)
    properties = {f"key{k}": "x" * 100 for k in range(20)}
    drone = DroneConfig("cf1", motor_ctrl="MotorCtrlVel", motor_ctrl_properties=properties)
    builder.build_model([drone], "arena", 0, False)
    assert len(compilations) == before + 1
