"""How the manager of a flight ends its processes."""

import os
import signal
from pathlib import Path

import pytest

from crazychoir_fw.mission import load_mission
from crazychoir_fw.ros import manager

EXAMPLE = Path(__file__).parents[2] / "examples" / "bearing_formation.yaml"


@pytest.mark.parametrize("sign", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP])
def test_who_asks_twice_does_not_keep_it_from_ending_all_processes(sign, monkeypatch):
    ended = []

    class ImpatientUser(manager.Supervisor):
        def stop(self, patience=5.0):
            os.kill(os.getpid(), sign)
            ended.append("all")

    class Interrupted(manager._Flight):
        def run(self, host):
            os.kill(os.getpid(), sign)
            pytest.fail("was not interrupted")

    monkeypatch.setattr(manager, "Supervisor", ImpatientUser)
    monkeypatch.setattr(manager, "_Flight", Interrupted)
    monkeypatch.setenv("ROS_DOMAIN_ID", os.environ["ROS_DOMAIN_ID"])
    before = [signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)]
    mission = load_mission(EXAMPLE, backend="integrator")
    assert manager.fly_as_processes(mission, manager.RosOptions(domain=7), lambda options: 0, quiet=True) == 130
    assert ended == ["all"]
    assert [signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)] == before
