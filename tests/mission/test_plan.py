"""The plan of a mission: commands at ticks, and the places where the drones must then be."""

import math

import pytest

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.mission import parse_mission
from crazychoir_fw.mission.plan import ARMING_TICKS, SETTLE_TICKS, plan_flight


def plan_of(mission, *flight):
    return plan_flight(parse_mission(mission | {"flight": list(flight)}))


def commands_of(plan, drone=0):
    return [(c.tick, c.verb) for c in plan.commands if c.drone == drone]


def test_phases_follow_each_other_in_ticks(hop):
    plan = plan_flight(parse_mission(hop))
    assert commands_of(plan) == commands_of(plan, drone=1) == [(0, "takeoff"), (5000, "land")]
    assert plan.ticks == 7000 + SETTLE_TICKS
    assert plan.courses[0].airborne == [(0, 7000)]


def test_takeoff_and_land_keep_the_place_and_stagger_the_height(hop):
    plan = plan_of(hop, {"takeoff": {"height": 0.4, "stagger": 0.2}}, "land")
    assert [c.arguments["absolute_height_m"] for c in plan.commands] == pytest.approx([0.4, 0.6, 0.0, 0.0])
    assert [w.position for w in plan.waypoints] == [(0.0, 0.0, 0.4), (1.0, 0.0, pytest.approx(0.6))]
    assert plan.courses[1].position == (1.0, 0.0, 0.0)


def test_route_counts_from_the_start_of_each_drone(hop):
    route = {"route": {"points": [[1, 2, 0.5], [0, 0, 1.0]], "leg_duration": 3, "stagger": 0.25}}
    plan = plan_of(hop, {"takeoff": {"duration": 1}}, route)
    legs = [c for c in plan.commands if c.verb == "go_to" and c.drone == 1]
    assert [c.tick for c in legs] == [1000, 4000]
    assert [(c.arguments["x"], c.arguments["y"], c.arguments["z"]) for c in legs] == [(2, 2, 0.75), (1, 0, 1.25)]
    assert plan.waypoints[-1].phase == "flight[1].route.points[1]"
    assert plan.waypoints[-1].tick == 7000


def test_offset_counts_from_the_last_commanded_place_and_heading_stays(hop):
    hop["drones"][0]["yaw_deg"] = 90
    step = {"go_to": {"offset": [0.5, 0, 0.1], "duration": 1}}
    turn = {"go_to": {"offset": [0, 0, 0], "duration": 1, "yaw_deg": -45}}
    plan = plan_of(hop, {"takeoff": {"height": 1}}, step, step, turn)
    goals = [c.arguments for c in plan.commands if c.verb == "go_to" and c.drone == 0]
    assert [goal["x"] for goal in goals] == [0.5, 1.0, 1.0]
    assert [goal["z"] for goal in goals] == pytest.approx([1.1, 1.2, 1.2])
    assert [goal["yaw"] for goal in goals] == pytest.approx([math.pi / 2, math.pi / 2, -math.pi / 4])


def test_only_named_drones_take_part_and_the_others_hold(hop):
    plan = plan_of(hop, {"takeoff": {"drones": ["cf2"]}}, {"hover": {"duration": 1}}, {"land": {"drones": ["cf2"]}})
    assert commands_of(plan, drone=0) == []
    assert commands_of(plan, drone=1) == [(0, "takeoff"), (3000, "land")]
    assert {w.drone for w in plan.waypoints} == {1}


def test_phases_together_begin_at_once_and_end_with_the_longest(hop):
    apart = [
        {"go_to": {"drones": ["cf1"], "position": [0, 1, 1], "duration": 2}},
        {"go_to": {"drones": ["cf2"], "position": [1, 1, 1], "duration": 4}},
    ]
    plan = plan_of(hop, {"takeoff": {"duration": 1}}, {"together": apart}, "land")
    assert commands_of(plan, drone=0) == [(0, "takeoff"), (1000, "go_to"), (5000, "land")]
    assert commands_of(plan, drone=1) == [(0, "takeoff"), (1000, "go_to"), (5000, "land")]
    assert [w.phase for w in plan.waypoints[-2:]] == ["flight[1].together[0].go_to", "flight[1].together[1].go_to"]


def test_second_takeoff_arms_again(hop):
    plan = plan_of(hop, "takeoff", "land", {"hover": {"duration": 5}}, "takeoff")
    assert commands_of(plan) == [
        (0, "takeoff"),
        (2000, "land"),
        (9000, "arm"),
        (9000 + ARMING_TICKS // 2, "arm"),
        (9000 + ARMING_TICKS, "takeoff"),
    ]


def test_drone_that_does_not_land_flies_to_the_end(hop):
    plan = plan_of(hop, "takeoff", {"hover": {"duration": 3}})
    assert plan.courses[0].airborne == [(0, plan.ticks)]


LINE = {"pieces": [{"duration": 1, "x": [0.5, 1.0]}, {"duration": 1.5, "x": [1.5], "yaw": [0, 1]}]}


def test_relative_trajectory_begins_where_the_drone_is(hop):
    plan = plan_of(hop, {"takeoff": {"height": 1}}, {"trajectory": LINE | {"time_scale": 2, "repeat": 2}})
    starts = [c for c in plan.commands if c.verb == "start_trajectory" and c.drone == 1]
    assert [c.tick for c in starts] == [2000, 7000]
    assert starts[0].arguments["time_scale"] == 2
    assert plan.courses[1].position == (3.0, 0.0, 1.0)
    assert plan.courses[1].yaw == pytest.approx(1.5)


def test_absolute_and_reversed_trajectories_end_where_their_polynomials_do(hop):
    plan = plan_of(hop, {"takeoff": {"height": 1}}, {"trajectory": LINE | {"relative": False}})
    assert plan.courses[1].position == (1.5, 0.0, 0.0)
    plan = plan_of(hop, {"takeoff": {"height": 1}}, {"trajectory": LINE | {"reversed": True}})
    assert plan.courses[1].position == (0.0, 0.0, 1.0)


def test_each_trajectory_is_uploaded_once_behind_the_others(hop):
    other = {"pieces": [{"duration": 1, "x": [1.0]}]}
    plan = plan_of(hop, "takeoff", *({"trajectory": t} for t in (LINE, other, LINE)))
    assert [(u.number, u.offset, len(u.rows)) for u in plan.uploads] == [(0, 0, 2), (1, 264, 1)]


def test_trajectories_beyond_the_memory_are_refused(hop):
    many = [{"trajectory": {"pieces": [{"duration": 1, "x": [float(k)]}] * 16}} for k in range(2)]
    with pytest.raises(MissionError, match=r"flight\[2\].trajectory brings .* to 32 pieces, .* remembers 31"):
        plan_of(hop, "takeoff", *many)


def test_mission_of_too_many_commands_is_refused(hop, monkeypatch):
    monkeypatch.setattr("crazychoir_fw.mission.plan.LARGEST_PLAN", 10_000)  # a million take half a minute
    hop["drones"] = {"count": 20}
    route = {"route": {"points": [[0, 0, 1]] * 600, "leg_duration": 1}}
    with pytest.raises(MissionError, match="more than 10000 commands"):
        plan_of(hop, "takeoff", route)
