"""The services of a drone, one file per port (docs/reference/crtp-cflib.md#5 to #14)."""

from crazychoir_fw.crtp.services.service import Reply, Service

__all__ = ["Reply", "Service"]
