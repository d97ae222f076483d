"""The box: commands that lead out of it, and drones that are outside."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.radio import Mode, RadioHandlerFRPY, RadioHandlerVel, RadioHandlerXYZ, SafetyArea

BOX = ((-1, -1, 0), (1, 1, 2))
LEVEL = (0, 0, 0, 1)


def goal(air):
    return struct.unpack("<BBBBfffff", bytes.fromhex(air["fake://0"].take()[-1][2]))[4:7]


def sent_velocity(air):
    return struct.unpack("<Bffff", bytes.fromhex(air["fake://0"].take()[-1][2]))[1:4]


def test_goals_are_clamped(fly, air):
    swarm = fly(RadioHandlerXYZ, safety_area=SafetyArea(*BOX))
    swarm.command(0, 5, -5, 1, 2)
    assert goal(air) == (1, -1, 1)


def test_goals_are_refused(fly, air):
    swarm = fly(RadioHandlerXYZ, safety_area=SafetyArea(*BOX, commands="refuse"))
    with pytest.raises(RangeError, match=r"\(5, -5, 1\) is outside of the safety area \(-1, -1, 0\) to \(1, 1, 2\) m"):
        swarm.command(0, 5, -5, 1, 2)
    assert air["fake://0"].take() == []


def test_velocities_end_at_the_border(fly, air):
    swarm = fly(RadioHandlerVel, safety_area=SafetyArea(*BOX, horizon_s=0.5))
    swarm.external_pose(0, (0.75, 0, 1), LEVEL)
    swarm.command(0, 1.0, 1.0, 0.5)
    assert sent_velocity(air) == (0.5, 1.0, 0.5)


def test_velocities_are_bent_again_while_they_are_repeated(fly, air, clock):
    swarm = fly(RadioHandlerVel, safety_area=SafetyArea(*BOX))
    swarm.external_pose(0, (0, 0, 1), LEVEL)
    swarm.command(0, 1.0, 0, 0)
    assert sent_velocity(air) == (1, 0, 0)
    clock.now += 0.1
    swarm.external_pose(0, (1.1, 0, 1), LEVEL)
    swarm.tick()
    # outside: back, gently
    assert sent_velocity(air) == pytest.approx((-0.2, 0, 0))
    swarm.command(0, -1.0, 0, 0)
    clock.now += 0.1
    swarm.tick()
    assert sent_velocity(air) == (-1, 0, 0)


def test_a_drone_whose_position_is_old_stands_still(fly, air, clock):
    swarm = fly(RadioHandlerVel, safety_area=SafetyArea(*BOX), on_silence="repeat")
    swarm.command(0, 0.5, 0, 0)
    assert sent_velocity(air) == (0.5, 0, 0)  # without any position the safety area does not act
    swarm.external_pose(0, (0, 0, 1), LEVEL)
    clock.now += 0.9
    swarm.tick()
    assert sent_velocity(air) == (0.5, 0, 0)
    clock.now += 0.2
    swarm.tick()
    assert sent_velocity(air) == (0, 0, 0)


def test_velocities_that_lead_out_are_refused(fly, air):
    swarm = fly(RadioHandlerVel, safety_area=SafetyArea(*BOX, commands="refuse"))
    swarm.external_pose(0, (1, 0, 1), LEVEL)
    with pytest.raises(RangeError, match="leads out of the safety area"):
        swarm.command(0, 0.5, 0, 0)
    assert swarm.command(0, -0.5, 0, 0)


@pytest.mark.parametrize(("breach", "mode"), [("land", Mode.LANDING), ("stop", Mode.STOPPED), ("report", Mode.READY)])
def test_a_drone_that_leaves(fly, clock, breach, mode):
    heard = []
    swarm = fly(RadioHandlerVel, safety_area=SafetyArea(*BOX, breach=breach, margin=0.25))
    swarm.on_event = lambda *event: heard.append(event)
    swarm.external_pose(0, (0, 0, 1), LEVEL)
    swarm.command(0, 0.5, 0, 0)
    swarm.external_pose(0, (1.2, 0, 1), LEVEL)
    assert swarm[0].mode is Mode.READY
    assert heard == []
    for x in (1.3, 1.4, 1.5):
        clock.now += 0.1
        swarm.external_pose(0, (x, 0, 1), LEVEL)
    assert swarm[0].mode is mode
    assert heard == [
        ("agent_0", "safety_area", "at (1.30, 0.00, 1.00), outside of the safety area (-1, -1, 0) to (1, 1, 2) m")
    ]


def test_the_odometry_counts_too(fly, air, eventually):
    swarm = fly(RadioHandlerVel, logger=True, log={}, safety_area=SafetyArea(*BOX, breach="stop"))
    swarm.command(0, 0.5, 0, 0)
    air["fake://0"].log(1000, stateEstimateZ__x=2000)
    eventually(lambda: swarm[0].is_stopped)
    assert "outside of the safety area" in swarm[0].reason


def test_a_drone_that_has_not_flown_is_left_alone(fly, air):
    swarm = fly(RadioHandlerFRPY, safety_area=SafetyArea(*BOX))
    assert not swarm.external_pose(0, (9, 9, 9), (0, 0, 0, 0))
    swarm.external_pose(0, (9, 9, 0), LEVEL)
    assert swarm[0].mode is Mode.LOCKED
    with pytest.raises(RangeError, match=r"takeoff: \(9.00, 9.00\) is outside"):
        swarm.takeoff(0.5)
    assert air["fake://0"].take()[1:] == []


def test_nobody_takes_off_through_the_ceiling(fly):
    swarm = fly(RadioHandlerXYZ, safety_area=SafetyArea(*BOX))
    with pytest.raises(RangeError, match="takeoff: height 2.5 m is outside"):
        swarm.takeoff(2.5)


@pytest.mark.parametrize(
    ("area", "text"),
    [
        (((0, 0, 0), (1, 1, 0)), "lowest and highest corner"),
        (((0, 0), (1, 1)), "lowest and highest corner"),
        (((0, 0, float("nan")), (1, 1, 1)), "lowest and highest corner"),
        ((*BOX, "bend"), "commands is 'bend', allowed: clamp, refuse"),
        ((*BOX, "clamp", "panic"), "breach is 'panic', allowed: land, stop, report"),
        ((*BOX, "clamp", "land", -1), "margin is -1"),
        ((*BOX, "clamp", "land", 0, 0), "horizon_s is 0"),
    ],
)
def test_areas_that_are_none(area, text):
    with pytest.raises(RangeError) as caught:
        SafetyArea(*area)
    assert text in str(caught.value)


point = st.tuples(*[st.floats(-3, 3)] * 3)


@given(point, point)
def test_no_velocity_leads_farther_out(position, velocity):
    area = SafetyArea(*BOX, horizon_s=0.5)
    bent = np.array(area.velocity(np.array(position), velocity))
    ahead = np.array(position) + 0.5 * bent
    low, high = np.array(BOX)
    assert area.leads_out(np.array(position), velocity) or np.allclose(bent, velocity, atol=0.31)
    assert not area.leads_out(np.array(position), bent)
    outside = lambda p: np.maximum(np.maximum(low - p, p - high), 0.0)
    assert np.all(outside(ahead) <= outside(np.array(position)) + 1e-9)
    # and what leads back is left as it is
    inward = outside(np.array(position) + 0.5 * np.array(velocity)) == 0.0
    np.testing.assert_allclose(bent[inward], np.array(velocity)[inward], atol=1e-12)
