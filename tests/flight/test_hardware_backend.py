"""Layers over the radio: a served world, whose time goes on only when the layers ask for it."""

import numpy as np
import pytest
from flown_layers import formation, hover, mission

pytest.importorskip("cflib")

from served_drones import Served

from crazychoir_fw.common.errors import RadioError, RangeError
from crazychoir_fw.common.messages import Twist
from crazychoir_fw.flight.engine import fly, make_experiment
from crazychoir_fw.flight.hardware_backend import HardwareBackend


def test_formation_over_the_radio(tmp_path):
    data = formation(criteria={"bearing_error_deg": 1.5, "position_error_m": 0.05})
    data["layers"]["rate"] = 100
    flown = mission(data)
    served = Served(flown, tmp_path)
    result = fly(flown, backend=served)
    assert result.success, result.failures
    assert served.world_there.positions()[:, 2].max() < 0.05
    assert [drone["id"] for drone in result.log.metadata["stage"]["drones"]] == result.log.drone_ids
    # what the drones believed is what the log has
    assert "sim.x" not in result.log.signals
    assert np.isfinite(result.log.signals["stateEstimate.x"]).all()


def test_a_stopped_drone_is_told_of(tmp_path):
    data = hover(2, may_fail=["b"])
    flown = mission(data)
    served = Served(flown, tmp_path)
    experiment = make_experiment(flown, served)
    try:
        experiment.takeoff()
        experiment.run(2.5)
        served.world_there.drones[1].emergency_stop()
        experiment.run(1.0)
        assert [agent.failure is None for agent in experiment.agents] == [True, False]
        assert experiment.agents[1].failure.startswith("b: locked up")
        assert served.world_there.positions()[0, 2] == pytest.approx(0.5, abs=0.05)
    finally:
        served.close()


def test_poses_that_are_old_count_as_unknown(tmp_path):
    served = Served(mission(hover()), tmp_path)
    try:
        assert np.isfinite(served.poses().position).all()
        served._clock = lambda: served.world_there.time + 1.0
        assert np.isnan(served.poses().position).all()
    finally:
        served.close()


def test_a_kind_that_the_handler_was_not_made_for_is_refused(tmp_path):
    served = Served(mission(hover()), tmp_path)
    try:
        with pytest.raises(RangeError, match="kind is 'vel', allowed: fpqr"):
            served.send([0], Twist(np.zeros((1, 3)), np.zeros((1, 3))), "vel")
    finally:
        served.close()
    with pytest.raises(RangeError, match="allowed: fpqr, frpy, vel, xyz"):
        HardwareBackend({"a": "udp://127.0.0.1:19850"}, "thrust", connects=False)


def test_a_link_that_fails_is_a_sentence_and_no_traceback(caplog):
    with pytest.raises(RadioError, match="nobody listens there; is `crazychoir serve` running"):
        HardwareBackend({"a": "udp://127.0.0.1:1"}, "vel")
    assert "Traceback" not in caplog.text
