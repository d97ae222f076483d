"""What is asked of both providers: every function of the table, with recorded and with systematic inputs."""

from crazychoir_fw.parity.cases.avoidance import avoidance_cases
from crazychoir_fw.parity.cases.case import Case, CaseRequest, Outcome
from crazychoir_fw.parity.cases.complementary import complementary_cases
from crazychoir_fw.parity.cases.controllers import controller_cases
from crazychoir_fw.parity.cases.kalman import kalman_cases
from crazychoir_fw.parity.cases.planning import planning_cases
from crazychoir_fw.parity.cases.power import power_cases
from crazychoir_fw.parity.inputs import Inputs


def all_cases(inputs: Inputs) -> list[Case]:
    """Return every case that these inputs allow."""
    return [
        *controller_cases(inputs),
        *power_cases(inputs),
        *kalman_cases(inputs),
        *complementary_cases(inputs),
        *planning_cases(),
        *avoidance_cases(inputs),
    ]


__all__ = ["Case", "CaseRequest", "Outcome", "all_cases"]
