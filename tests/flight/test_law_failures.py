"""A law of the user's that raises in the air: its drones land in order, one sentence says where, the others fly on."""

import numpy as np
import pytest
from flown_layers import hover, mission

from crazychoir_fw.flight.engine import fly

GUIDANCE = """
from crazychoir_fw.guidance import SimpleGuidance


class Mine(SimpleGuidance):
    def step(self, now):
        outputs = super().step(now)
        if self.agent_id in {agents} and self.current_pose.position[2] > 0.9:
            raise ValueError("lost my way")
        return outputs
"""
CONTROL = """
from crazychoir_fw.control import FlatnessPositionCtrl


class Mine(FlatnessPositionCtrl):
    def control(self, current_pose, desired_reference):
        place = current_pose.position
        if (place[..., 2] > 0.9).any() and {agents!r} == [0, 1]:
            raise ValueError("lost my way")
        if ((place[..., 2] > 0.9) & (place[..., 0] < 0.5)).any() and {agents!r} == [0]:
            raise ValueError("lost my way")
        return super().control(current_pose, desired_reference)
"""
FASTEST = 1.0
"""Of an orderly landing, downwards (m/s); a fall from 1 m ends with 4.4 m/s."""


def own(tmp_path, kind, agents, backend):
    (tmp_path / "mine.py").write_text({"guidance": GUIDANCE, "control": CONTROL}[kind].format(agents=agents))
    data = hover(2, backend=backend, seed=1, flight=[{"takeoff": {"duration": 4}}, {"land": {"duration": 3}}])
    data["layers"]["guidance"]["height"] = 1.0
    if kind == "guidance":
        data["layers"]["guidance"]["class"] = "mine.py:Mine"
    else:
        data["layers"]["control"]["position"] = "mine.py:Mine"
    return mission(data, folder=tmp_path)


def check(result, agents, z, vz, line):
    """Look at verdict and motion, z (m) and vz (m/s) of shape (T, 2)."""
    phases = ["failed" if i in agents else "landed" for i in range(2)]
    assert [drone["phase"] for drone in result.summary["drones"]] == phases
    told = [sentence for sentence in result.failures if "ValueError: lost my way" in sentence]
    assert len(told) == len(agents)
    assert all(f"(mine.py:{line})" in sentence for sentence in told)
    assert (z.max(axis=0) > 0.85).all() and (z[-1] < 0.06).all()
    assert vz.min() > -FASTEST
    events = result.summary["events"]
    assert sum("; it lands" in str(event["details"]) for event in events if event["kind"] == "failure") == len(agents)


@pytest.mark.parametrize("backend", ["integrator", "sim"])
@pytest.mark.parametrize("agents", [[0], [0, 1]])
@pytest.mark.parametrize("kind", ["guidance", "control"])
def test_in_one_process(tmp_path, kind, agents, backend):
    result = fly(own(tmp_path, kind, agents, backend))
    signals = result.log.signals
    line = {"guidance": 9, "control": 9 if len(agents) == 2 else 11}[kind]
    check(result, agents, signals["sim.z"], signals["sim.vz"], line)


@pytest.mark.parametrize(("kind", "agents"), [("guidance", [0]), ("guidance", [0, 1]), ("control", [0, 1])])
def test_over_the_radio(tmp_path, kind, agents):
    pytest.importorskip("cflib")
    from served_drones import Served

    flown = own(tmp_path, kind, agents, "integrator")
    served = Served(flown, tmp_path)
    world, seen = served.world_there, []
    world.agenda.every(10, lambda: seen.append(world.positions()[:, 2].copy()))
    result = fly(flown, backend=served)
    z = np.array(seen)
    check(result, agents, z, np.diff(z, axis=0) / 0.01, 9)
