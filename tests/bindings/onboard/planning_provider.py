"""A provider that only plans, for the tests of the onboard part."""

from dataclasses import dataclass
from typing import Any

from crazychoir_fw._core import ffi, lib

PLAN_ENTRIES = [
    "takeoff",
    "land",
    "go_to",
    "spiral",
    "start_trajectory",
    "stop",
    "disable",
    "is_stopped",
    "is_disabled",
    "is_finished",
    "state",
    "current_goal",
]


@dataclass
class PlanningProvider:
    """The builtin planner behind the plan_* entries of a provider; the other entries are null."""

    table: Any
    state: Any

    @property
    def plan_state(self) -> int:
        return lib.cf_planner_state(self.state)


def planning_provider() -> PlanningProvider:
    table = ffi.new("cf_provider_t *")
    for entry in PLAN_ENTRIES:
        signature = ffi.typeof(getattr(table, f"plan_{entry}"))
        function = ffi.addressof(lib, f"cf_planner_{entry}")
        setattr(table, f"plan_{entry}", ffi.cast(signature, function))
    state = ffi.new("cf_planner_t *")
    lib.cf_planner_init(state)
    return PlanningProvider(table, state)
