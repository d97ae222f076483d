"""Missions in which something goes wrong."""

import json
import subprocess
import sys

import pytest

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.flight.engine import fly
from crazychoir_fw.mission import parse_mission
from crazychoir_fw.simulation import Kick, MotorFault


def refusal_of(mission):
    with pytest.raises(MissionError) as refused:
        parse_mission(mission)
    return str(refused.value).removeprefix("mission: ")


@pytest.mark.parametrize(
    ("faults", "sentence"),
    [
        ([{"motro": {}}], "faults[0] has no key 'motro' (did you mean 'motor'?), but only battery, gust"),
        ([{"motor": {}, "kick": {}}], "faults[0] is {"),
        (["hover"], "faults[0] is 'hover', but must be"),
        ([{"motor": {"motor": 5}}], "faults[0].motor.motor is 5, but must be a whole number in [1, 4]"),
        ([{"motor": {"efficiencyy": 0.5}}], "faults[0].motor has no key 'efficiencyy' (did you mean 'efficiency'?)"),
        (
            [{"imu": {"sensor": "gyros", "stuck": True}}],
            "faults[0].imu.sensor is 'gyros', but must be one of gyro, acc (did",
        ),
        ([{"kick": {}}], "faults[0].kick: impulse is missing, allowed: one that is not zero"),
        ([{"motor": {"drones": ["cf3"]}}], "faults[0].motor.drones names 'cf3', but must name drones of the mission"),
        ([{"positioning": {"delay": 0.1}}], "faults[0].positioning befalls cf2 with positioning 'flow'"),
    ],
)
def test_impossible_faults_are_refused_in_one_sentence(hop, faults, sentence):
    hop["drones"][1]["positioning"] = "flow"
    hop["faults"] = faults
    text = refusal_of(hop)
    assert text.startswith(sentence)
    assert "\n" not in text


def test_a_drop_of_what_nobody_carries_is_refused_before_the_flight(hop):
    hop["faults"] = [{"motor": {"at": 1.0}}, {"payload": {"at": 1.0, "drones": ["cf2"]}}]
    with pytest.raises(MissionError, match=r"^faults\[1\]\.payload: cf2: carries no detachable payload$"):
        fly(parse_mission(hop), visuals=False)


def test_may_fail_names_drones(hop):
    hop["may_fail"] = ["cf7"]
    assert refusal_of(hop).startswith("may_fail names 'cf7', but must name drones of the mission")


def test_faults_happen_in_times_of_the_flight_and_are_written_down(hop):
    hop["faults"] = [{"kick": {"at": 3.0, "drones": ["cf2"], "impulse": [0.01, 0, 0]}}, {"motor": {"efficiency": 0.9}}]
    result = fly(parse_mission(hop), visuals=False)
    assert result.failures == []
    start = result.world.time - 9.5  # seven seconds of phases, then the drones come to rest
    kicks = [event for event in result.world.events if event.details.get("fault") == "kick"]
    assert [event.drone for event in kicks] == ["cf2"]
    assert kicks[0].time == pytest.approx(start + 3.0, abs=1e-6)
    assert [fault["kind"] for fault in result.summary["faults"]] == ["kick", "motor"]
    assert result.summary["faults"] == result.log.metadata["faults"]
    json.dumps(result.summary)


def test_a_drone_that_may_fail_ends_no_flight(hop):
    hop["faults"] = [{"motor": {"at": 2.5, "drones": ["cf1"], "motor": 1}}]
    assert fly(parse_mission(hop), visuals=False).failures[0].startswith("cf1: crashed at")

    result = fly(parse_mission({**hop, "may_fail": ["cf1"]}), visuals=False)
    assert result.success
    assert len(result.expected_failures) == 1
    assert result.expected_failures[0].startswith("cf1: crashed at")
    assert result.summary["drones"][0]["supervisor_state"] == "Crashed"
    assert result.summary["drones"][1]["endpoint_error_m"] < 0.1


def test_faults_of_a_script_replace_those_of_the_file(hop):
    hop["faults"] = [{"motor": {"at": 1.0, "motor": 1}}]
    assert parse_mission(hop, faults=[]).faults == []
    mixed = parse_mission(hop, faults=[Kick(at=2.0, impulse=(0.01, 0.0, 0.0)), {"motor": {"efficiency": 0.5}}])
    assert [entry.fault for entry in mixed.faults] == [
        Kick(at=2.0, impulse=(0.01, 0.0, 0.0)),
        MotorFault(efficiency=0.5),
    ]


def test_a_mission_without_faults_is_checked_without_the_simulation():
    code = (
        "import sys; from crazychoir_fw.mission import parse_mission; "
        "parse_mission({'name': 'a', 'drones': {'count': 1}, 'flight': ['takeoff', 'land']}); "
        "print('crazychoir_fw.simulation' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
