"""The law of examples/new_law as nodes: it flies, is judged and drawn, and its options are parameters."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from ros_flights import PATIENCE, Flight

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.mission.registry import law_named
from crazychoir_fw.ros.guidance import law_node

EXAMPLE = Path(__file__).parents[2] / "examples" / "new_law"


def test_as_nodes(tmp_path):
    shutil.copy(EXAMPLE / "rendezvous.py", tmp_path)
    flight = Flight(tmp_path, (EXAMPLE / "mission.yaml").read_text(), "--processes", "per-drone")
    try:
        flight.begin()
        assert flight.process.wait(PATIENCE) == 0, flight.log.read_text()[-3000:]
    finally:
        flight.close()
    summary = json.loads((flight.out / "summary.json").read_text())
    assert summary["success"], summary["failures"]
    verdict = summary["criteria"][0]
    assert verdict["criterion"] == "meeting_m"
    assert verdict["value"] == pytest.approx(0.6 / np.sqrt(3), abs=0.03)
    assert (flight.out / "flight.png").stat().st_size > 10_000


def test_its_node_has_its_options_as_parameters(bench):
    law = law_named("guidance", f"{EXAMPLE / 'rendezvous.py'}:Rendezvous", "class")
    node = bench.make(law_node(law), pull=2.0, agent_id=0, parameters={"N": 2, "in_neigh": [1], "gap": 0.3})
    assert (node.guidance.pull, node.guidance.gap, node.guidance.brake) == (2.0, 0.3, 2.5)
    assert node.describe_parameter("gap").description == "distance that neighbors keep (m)"
    with pytest.raises(RangeError, match="gap is -1.0, allowed: above 0 m"):
        bench.make(law_node(law), agent_id=1, parameters={"N": 2, "gap": -1.0})
