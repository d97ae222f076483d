"""What is to be learned: one dataclass per task, with rewards, limits and starts."""

from crazychoir_fw.learning.tasks.gates import Gates
from crazychoir_fw.learning.tasks.hover import Hover
from crazychoir_fw.learning.tasks.recover import Recover
from crazychoir_fw.learning.tasks.swarm import Swap, Swarm, SwarmTask
from crazychoir_fw.learning.tasks.task import Starts, Task
from crazychoir_fw.learning.tasks.track import Track

__all__ = ["Gates", "Hover", "Recover", "Starts", "Swap", "Swarm", "SwarmTask", "Task", "Track"]

BASES = ("Starts", "SwarmTask", "Task")


def names() -> list[str]:
    """Return the names of the tasks."""
    return [name for name in __all__ if name not in BASES]
