"""Dynamic task assignment: a table of tasks, and drones that share them out by distributed simplex."""

from crazychoir_fw.guidance.schemes.tasks.dispatch_table import DispatchTable, Offer
from crazychoir_fw.guidance.schemes.tasks.position_task import PositionTask
from crazychoir_fw.guidance.schemes.tasks.position_task_executor import PositionTaskExecutor
from crazychoir_fw.guidance.schemes.tasks.position_task_table import PositionTaskTable
from crazychoir_fw.guidance.schemes.tasks.task_guidance import TaskGuidance

__all__ = ["DispatchTable", "Offer", "PositionTask", "PositionTaskExecutor", "PositionTaskTable", "TaskGuidance"]
