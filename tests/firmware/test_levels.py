"""How much of a checkout flies: every release at every level, compared with the builtin provider and with physics."""

import struct

import numpy as np
import pytest
from level_flights import GENERIC, HIGH_LEVEL, RPYT, SUPERVISOR, airborne, everything, pieces, record, world_of
from miniature import RELEASES

from crazychoir_fw.errors import CrazychoirError, StateError
from crazychoir_fw.firmware.library import BUILD_LOG
from crazychoir_fw.firmware.levels import LEVELS, MODULES, STABILIZER

NEWEST = "2026.08"
SYSTEM = (MODULES, STABILIZER)
TAKEOFF_2, GO_TO, LAND_2, STOP, START, DEFINE, SPIRAL = 7, 4, 8, 3, 5, 6, 11


@pytest.fixture(params=SYSTEM)
def word(request, level_word):
    """A provider that brings the firmware's own modules."""
    return level_word(NEWEST, request.param)


def printed(library):
    """Return what the compiler printed: it stands in the build log behind the commands, which are indented."""
    lines = (library.path.parent / BUILD_LOG).read_text().partition("\ncommands:\n")[2].splitlines()
    begin = next((i for i, line in enumerate(lines) if not line.startswith("  ")), len(lines))
    return "\n".join(lines[begin:])


# -- every release -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("release", RELEASES)
def test_every_release_builds_silently_and_flies_at_every_level(release, level, level_library, level_word):
    library = level_library(release, level)
    assert library.identity["level"] == level
    assert library.identity["notes"] == []
    assert printed(library) == ""

    world = airborne(level_word(release, level), height=0.6)
    drone = world.drones[0]
    np.testing.assert_allclose(drone.true_position, [0.0, 0.0, 0.6], atol=0.05)
    drone.high_level_commander.go_to(0.4, -0.2, 0.8, 0.5, duration_s=1.5)
    world.run(2.5)
    np.testing.assert_allclose(drone.true_position, [0.4, -0.2, 0.8], atol=0.05)
    drone.high_level_commander.upload_trajectory(1, pieces())
    drone.high_level_commander.start_trajectory(1, relative_position=True)
    world.run(2.5)
    np.testing.assert_allclose(drone.true_position, [0.4, -0.2, 0.8], atol=0.08)
    drone.high_level_commander.land(absolute_height_m=0.0, duration_s=2.0)
    world.run(3.0)
    assert drone.true_position[2] < 0.03
    assert not drone.motors_turn if hasattr(drone, "motors_turn") else True
    assert drone.failure is None
    assert drone.high_level_commander.is_trajectory_finished


@pytest.mark.parametrize("release", ["2025.12", "2026.08"])
def test_modules_fly_like_builtin_bit_by_bit(release, level_word):
    ours, theirs = (everything(world_of(word)) for word in ("builtin", level_word(release, MODULES)))
    assert ours[:, 2].max() > 0.6
    assert ours[-1, 2] < 0.03
    np.testing.assert_array_equal(theirs, ours)
