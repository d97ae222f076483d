"""What a client can read and write by address (docs/reference/crtp-cflib.md#10)."""

from crazychoir_fw.crtp.memories.fitted import fitted_memories
from crazychoir_fw.crtp.memories.memory import Memory, MemoryType

__all__ = ["Memory", "MemoryType", "fitted_memories"]
