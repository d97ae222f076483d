"""The mission file knows the names and ranges that the engine plugin knows."""

import pytest

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.mission import fleet, parse_mission, schema
from crazychoir_fw.mujoco_models import SCENES
from crazychoir_fw.onboard.core import attributes
from crazychoir_fw.simulation.drone_config import DECKS


@pytest.mark.parametrize(
    ("attribute", "names"),
    [
        ("platform", fleet.PLATFORMS),
        ("controller", fleet.CONTROLLERS),
        ("estimator", fleet.ESTIMATORS),
        ("positioning", fleet.POSITIONINGS),
        ("mocap_quality", fleet.MOCAP_QUALITIES),
    ],
)
def test_names_are_those_of_the_engine_plugin(attribute, names):
    allowed, _ = attributes()[attribute]
    # "auto" is what a mission says by leaving the key out
    assert set(names) == set(allowed.split(" | ")) - {"auto"}


def test_decks_and_scenes_are_those_that_there_are():
    assert fleet.DECKS == DECKS
    assert set(fleet.DECKS) <= set(attributes())
    assert set(schema.SCENES) == set(SCENES)


@pytest.mark.parametrize("attribute", ["noise", "battery"])
def test_ranges_lie_within_those_of_the_engine_plugin(hop, attribute):
    low, high = (float(word) for word in attributes()[attribute][0].split(" to "))
    for value in (low - 0.001, high + 0.001):
        hop["defaults"] = {attribute: value}
        with pytest.raises(MissionError):
            parse_mission(hop)
