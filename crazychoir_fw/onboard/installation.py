"""What is installed here."""

from __future__ import annotations

import importlib.util
import os
import platform as host
from typing import Any

from crazychoir_fw._core import lib
from crazychoir_fw.onboard.core import choices, identity, provider_identity, providers
from crazychoir_fw.onboard.variables import log_table, parameter_table


def info() -> dict[str, Any]:
    """Return what this installation is: versions, build flags, providers and the size of a drone."""
    return {
        **identity(),
        "provider": providers()[0],
        "providers": providers(),
        "libraries": [provider_identity(number) for number in range(1, lib.cf_provider_count())],
        "platform": f"{host.system()} {host.machine()}",
        "controllers": choices("controller"),
        "estimators": choices("estimator"),
        "parameters": len(parameter_table()),
        "logs": len(log_table()),
        "state_bytes": lib.cf_state_bytes(0),
        "ros": _ros_distribution(),
        "python": host.python_version(),
    }


def _ros_distribution() -> str | None:
    return os.environ.get("ROS_DISTRO", "wheels") if importlib.util.find_spec("rclpy") else None
