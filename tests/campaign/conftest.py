"""A mission that flies in a few milliseconds, and campaigns of it."""

import pytest
import yaml

from crazychoir_fw.campaign.campaign import load_campaign

MISSION = {
    "name": "hop",
    "drones": [{"id": "cf1", "position": [0.0, 0.0]}],
    "flight": [{"takeoff": {"height": 0.5, "duration": 1.0}}, {"land": {"duration": 1.0}}],
}


@pytest.fixture
def hop(tmp_path):
    """The mission file."""
    path = tmp_path / "hop.yaml"
    path.write_text(yaml.safe_dump(MISSION))
    return path


@pytest.fixture
def campaign(hop):
    """Makes campaigns of the mission."""

    def make(**keys):
        path = hop.with_name("campaign.yaml")
        path.write_text(yaml.safe_dump({"extends": hop.name, **keys}, sort_keys=False))
        return load_campaign(path)

    return make
