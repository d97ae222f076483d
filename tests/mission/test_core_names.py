"""The mission file knows the names and ranges that the engine plugin knows."""

import pytest

from crazychoir_fw.core import attributes
from crazychoir_fw.errors import MissionError
from crazychoir_fw.mission import fleet, parse_mission


@pytest.mark.parametrize(
    ("attribute", "names"),
    [
        ("platform", fleet.PLATFORMS),
        ("controller", fleet.CONTROLLERS),
        ("estimator", fleet.ESTIMATORS),
        ("positioning", fleet.POSITIONINGS),
    ],
)
def test_names_are_those_of_the_engine_plugin(attribute, names):
    allowed, _ = attributes()[attribute]
    # "auto" is what a mission says by leaving the key out
    assert set(names) == set(allowed.split(" | ")) - {"auto"}


@pytest.mark.parametrize("attribute", ["noise", "battery"])
def test_ranges_lie_within_those_of_the_engine_plugin(hop, attribute):
    low, high = (float(word) for word in attributes()[attribute][0].split(" to "))
    for value in (low - 0.001, high + 0.001):
        hop["defaults"] = {attribute: value}
        with pytest.raises(MissionError):
            parse_mission(hop)
