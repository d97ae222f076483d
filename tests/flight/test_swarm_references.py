import numpy as np
import pytest

from crazychoir_fw.common.messages import Reference
from crazychoir_fw.flight.swarm_references import SwarmReferences

PARTS = ("position", "velocity", "acceleration", "jerk", "yaw", "yaw_rate")
PLACES = np.arange(9.0).reshape(3, 3)


def one_by_one(references):
    """Return what `SwarmReferences` promises, without memory."""
    parts = {"position": PLACES.copy()}
    for k, reference in enumerate(references):
        for name in PARTS:
            value = getattr(reference, name, None)
            if value is not None:
                parts.setdefault(name, np.zeros((3, *np.shape(value))))[k] = value
    return parts


def random_reference(dice, held):
    kind = dice.integers(5)
    if kind == 0:
        return None
    if kind == 1:
        return held
    vectors = list(dice.normal(size=(4, 3)))
    if kind == 2:
        return Reference(*vectors, 0.3, 0.1)
    return Reference(*(vector if dice.random() < 0.5 else None for vector in vectors), 0.2 if kind == 3 else None)


def test_rows_are_those_of_the_present_references():
    dice = np.random.default_rng(1)
    end, zero = dice.normal(size=3), np.zeros(3)
    end.flags.writeable = zero.flags.writeable = False
    held = Reference(end, zero, zero, zero, 0.5, 0.0)
    swarm = SwarmReferences(3)
    for _ in range(500):
        references = [random_reference(dice, held) for _ in range(3)]
        swarm.update(references)
        arrays, expected = swarm.arrays(PLACES), one_by_one(references)
        assert set(arrays) == set(expected)
        for name, values in expected.items():
            np.testing.assert_array_equal(arrays[name], values)


def test_a_reference_that_is_written_to_is_read_again():
    reference = Reference(*np.ones((4, 3)), 0.0, 0.0)
    swarm = SwarmReferences(1)
    for _ in range(3):
        swarm.update([reference])
        assert swarm.arrays(np.zeros((1, 3)))["position"] == pytest.approx(reference.position[None])
        reference.position[:] += 1.0


def test_arrays_are_the_callers_own():
    swarm = SwarmReferences(1)
    swarm.update([Reference(position=np.ones(3))])
    swarm.arrays(np.zeros((1, 3)))["position"][:] = 7.0
    assert swarm.arrays(np.zeros((1, 3)))["position"] == pytest.approx(np.ones((1, 3)))
