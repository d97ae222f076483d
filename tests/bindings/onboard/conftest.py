"""What the tests of the onboard part share: a provider that only plans."""

import pytest
from planning_provider import PlanningProvider, planning_provider


@pytest.fixture
def provider() -> PlanningProvider:
    return planning_provider()
