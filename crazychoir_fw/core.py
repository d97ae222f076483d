"""The lower floor: the C core through cffi, its status codes as exceptions, and what was built.

Everything above talks to C through this module; nothing below knows Python.
"""

from __future__ import annotations

import ctypes
import functools
import platform as host
import subprocess
from pathlib import Path
from typing import Any

import mujoco

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.errors import CrazychoirError, RangeError, StateError, UnknownNameError
from crazychoir_fw.version import __version__

PLUGIN = "crazychoir.crazyflie"

_EXCEPTIONS: dict[int, type[CrazychoirError]] = {
    lib.CF_ERR_VALUE: RangeError,
    lib.CF_ERR_UNKNOWN: UnknownNameError,
    lib.CF_ERR_STATE: StateError,
    lib.CF_ERR_BLOCKED: StateError,
    lib.CF_ERR_CAPACITY: RangeError,
}


def check(status: int, what: str) -> None:
    """Raise the exception of a status code; `what` says who asked for what."""
    if status != lib.CF_OK:
        phrase = ffi.string(lib.cf_status_text(status)).decode()
        raise _EXCEPTIONS.get(status, CrazychoirError)(f"{what}: {phrase}")


def receive_packet(cf: Any, port: int, channel: int, data: bytes, who: str) -> bytes | None:
    """Hand a CRTP packet to a drone and return the payload of its answer, or None.

    Args:
        cf: The drone, a cffi pointer to ``cf_t``.
        port: 0 to 15.
        channel: 0 to 3.
        data: The payload, at most 30 bytes.
        who: Says who asked for what, in the error.

    Raises:
        RangeError: If the packet has a wrong length, or a number in it is not finite.
        UnknownNameError: If the drone knows no such port, channel or type.
        StateError: If it is refused in the present state.
    """
    if not (0 <= port <= 15 and 0 <= channel <= 3):
        raise RangeError(f"{who}: port {port}, channel {channel}; allowed: ports 0 to 15, channels 0 to 3")
    reply = ffi.new("cf_packet_reply_t *")
    status = lib.cf_receive_packet(cf, port, channel, ffi.from_buffer("uint8_t[]", data), len(data), reply)
    check(status, who)
    return bytes(reply.data[0 : reply.length]) if reply.length else None


def providers() -> list[str]:
    """Return the names of the providers of this build, the default one first."""
    names = []
    while (provider := lib.cf_provider(len(names))) != ffi.NULL:
        names.append(ffi.string(provider.name).decode())
    return names


def choices(attribute: str) -> list[str]:
    """Return the words that may be chosen for an attribute of the plugin, without the automatic choice."""
    return [word for word in attributes()[attribute][0].split(" | ") if word != "auto"]


def attributes() -> dict[str, tuple[str, str]]:
    """Return the attributes of the engine plugin: name to (allowed values, meaning)."""
    text = ffi.new("char[]", 256)
    table = {}
    for i in range(lib.cf_attribute_count()):
        lib.cf_attribute_range(i, text, 256)
        name = ffi.string(lib.cf_attribute_name(i)).decode()
        table[name] = (ffi.string(text).decode(), ffi.string(lib.cf_attribute_doc(i)).decode())
    return table


@functools.cache
def register_plugin() -> None:
    """Tell MuJoCo about the engine plugin, so that any MJCF that names it flies. Repeated calls do nothing.

    Raises:
        CrazychoirError: If the MuJoCo at hand is not the one this package was built with.
    """
    folder = Path(mujoco.__file__).parent
    libraries = sorted(folder.glob("libmujoco*"))
    status = lib.cf_plugin_register(str(libraries[0]).encode()) if libraries else -1
    if status == 0:
        return
    built = _version_text(lib.cf_plugin_mujoco_version())
    if status == -2:
        raise CrazychoirError(
            f"built with MuJoCo {built}, found {mujoco.__version__}; run `pip install --force-reinstall --no-deps "
            "crazychoir-fw` to build again"
        )
    raise CrazychoirError(f"MuJoCo {built} is not loaded from {folder}; run `pip install 'mujoco-core>=4.0,<4.1'`")


def _version_text(number: int) -> str:
    return f"{number // 1_000_000}.{number // 1000 % 1000}.{number % 1000}"


def _firmware_checkout() -> str:
    """Return what lies in the submodule firmware/, in words."""
    folder = Path(__file__).resolve().parents[1] / "firmware"
    if not (folder / "src").is_dir():
        return "none (builtin provider only; `git submodule update --init --recursive` fetches it)"
    described = subprocess.run(
        ["git", "-C", str(folder), "describe", "--always", "--dirty"], capture_output=True, text=True, check=False
    )
    return described.stdout.strip() or "unversioned checkout"


def _ros_distribution() -> str | None:
    import importlib.util
    import os

    return os.environ.get("ROS_DISTRO", "wheels") if importlib.util.find_spec("rclpy") else None


def identity() -> dict[str, str]:
    """Return what flew, for logs and reports: version, compiler and flags of the core, MuJoCo."""
    return {
        "version": __version__,
        "compiler": ffi.string(lib.cf_build_compiler()).decode(),
        "flags": ffi.string(lib.cf_build_flags()).decode(),
        "mujoco": mujoco.__version__,
    }


def info() -> dict[str, Any]:
    """Return what this installation is: versions, build flags, providers and the size of a drone."""
    from crazychoir_fw.variables import log_table, parameter_table

    return {
        **identity(),
        "provider": providers()[0],
        "providers": providers(),
        "firmware": _firmware_checkout(),
        "platform": f"{host.system()} {host.machine()}",
        "controllers": choices("controller"),
        "estimators": choices("estimator"),
        "parameters": len(parameter_table()),
        "logs": len(log_table()),
        "state_bytes": lib.cf_state_bytes(),
        "ros": _ros_distribution(),
        "python": host.python_version(),
    }


def struct_view(type_name: str, address: int) -> Any:
    """Return C memory at an address as a pointer; the caller keeps its owner alive."""
    return ffi.cast(f"{type_name} *", address)


def address_of(array: Any) -> int:
    """Return the address of the first byte of a NumPy array."""
    return ctypes.c_void_p(array.ctypes.data).value or 0
