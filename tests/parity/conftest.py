"""What tests of the comparison share: short recordings, and sides that are off by a known amount."""

import pytest
from perturbed import PerturbedSide

from crazychoir_fw.parity.fleet import FLEET
from crazychoir_fw.parity.inputs import record
from crazychoir_fw.parity.side import Side


@pytest.fixture(scope="session")
def members():
    """Return members of the fleet by their names."""

    def take(*names):
        return [member for member in FLEET if member.name in names]

    return take


@pytest.fixture(scope="session")
def short_inputs():
    """A second of every drone of the fleet."""
    return record(Side(), 0.8)


@pytest.fixture(scope="session")
def whole_flight(members):
    """The whole flight of the drone that meets every kind of set-point."""
    return record(Side(), 60.0, fleet=members("pid")).flights["pid"]


@pytest.fixture
def perturbed():
    """Make a side whose function does something else to its output from a call on."""
    return PerturbedSide
