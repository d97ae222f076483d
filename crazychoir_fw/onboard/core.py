"""The lower floor: the C core through cffi, its status codes as exceptions, and what was built.

Everything above talks to C through this module; nothing below knows Python.
"""

from __future__ import annotations

import ctypes
import functools
import importlib.util
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any, Protocol

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import CrazychoirError, RangeError, StateError, UnknownNameError
from crazychoir_fw.common.import_hook import at_import
from crazychoir_fw.common.opengl_libraries import importable
from crazychoir_fw.common.signals import held_signals
from crazychoir_fw.common.version import __version__

PLUGIN = "crazychoir.crazyflie"

_EXCEPTIONS: dict[int, type[CrazychoirError]] = {
    lib.CF_ERR_VALUE: RangeError,
    lib.CF_ERR_UNKNOWN: UnknownNameError,
    lib.CF_ERR_STATE: StateError,
    lib.CF_ERR_BLOCKED: StateError,
    lib.CF_ERR_CAPACITY: RangeError,
}


def check(status: int, what: str) -> None:
    """Raise the exception of a status code; `what` names the caller and the request."""
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
        who: Names the caller and the request, in the error.

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


class ProviderLibrary(Protocol):
    """What `load_library` wants to know of a provider library; `crazychoir_fw.firmware` builds them."""

    @property
    def path(self) -> str | Path:
        """File of the shared object."""

    @property
    def name(self) -> str:
        """Name by which drones ask for it, such as ``bitcraze``."""

    @property
    def platform(self) -> str | None:
        """The airframe that it was built for, such as ``cf2``; None means every one."""

    @property
    def ranges(self) -> Sequence[tuple[int, int]]:
        """Where its file-scope variables are: offset within the library and length (bytes), ascending."""

    @property
    def pointers(self) -> Sequence[int]:
        """Offsets of the words in there that hold an address (bytes)."""

    @property
    def identity(self) -> Mapping[str, Any]:
        """What it was built from, and how."""


_identities: dict[int, dict[str, Any]] = {}  # of the libraries, by the number of the provider
_following: set[int] = set()  # numbers of those that are replaced when their checkout changes
_identities_lock = threading.Lock()


def load_library(library: ProviderLibrary, follows_checkout: bool = False) -> int:
    """Load a provider library into this process, so that drones can ask for it by its name.

    The newest library of a name is the one that drones get; those that fly keep what they have. The same library
    again gives the same number, and makes it the newest one.

    Args:
        library: The library with its image map.
        follows_checkout: The next request for its name gets the checkout as it is then; otherwise this library stays.

    Returns:
        Its number as a provider, 1 or more.

    Raises:
        UnknownNameError: If there is no such file or platform.
        RangeError: If the file is no provider library, or its image map does not fit.
        StateError: If it was built for another version of this package.
    """
    platforms = platform_names()
    if library.platform is not None and library.platform not in platforms:
        raise UnknownNameError(
            f"library '{library.name}' is for platform '{library.platform}', allowed: {', '.join(platforms)}"
        )
    path, name = str(library.path).encode(), library.name.encode()
    words = {"path": ffi.new("char[]", path), "name": ffi.new("char[]", name)}
    ranges = ffi.new("cf_image_range_t[]", [tuple(item) for item in library.ranges])
    pointers = ffi.new("uint32_t[]", list(library.pointers))
    request = ffi.new("cf_library_t *", words)
    request.platform = -1 if library.platform is None else platforms.index(library.platform)
    request.map = {
        "ranges": ranges,
        "n_ranges": len(library.ranges),
        "pointers": pointers,
        "n_pointers": len(library.pointers),
    }
    message = ffi.new("char[]", lib.CF_LIBRARY_MESSAGE_BYTES)
    number = lib.cf_library_load(request, message)
    if number < 0:
        raise _EXCEPTIONS.get(number, CrazychoirError)(ffi.string(message).decode(errors="replace"))
    with _identities_lock:
        _identities[number] = dict(library.identity)
        if follows_checkout:
            _following.add(int(number))
        else:
            _following.discard(int(number))
    return int(number)


def follows_checkout(number: int) -> bool:
    """Tell whether a provider was loaded to be replaced when its checkout changes."""
    with _identities_lock:
        return number in _following


def _provider_name(number: int) -> str:
    count = lib.cf_provider_count()
    if not 0 <= number < count:
        raise UnknownNameError(f"no provider number {number}, there are {count}, counted from 0")
    return ffi.string(lib.cf_provider_name(number)).decode()


def provider_identity(number: int) -> dict[str, Any]:
    """Return what a provider was built from: for a library what it says itself, for the built-in one the core's build.

    Raises:
        UnknownNameError: If there is no provider of this number.
    """
    name = _provider_name(number)
    if number == 0:
        build = identity()
        return {"provider": name, **{key: build[key] for key in ("version", "compiler", "flags")}}
    with _identities_lock:
        return {"provider": name, **_identities.get(number, {})}


def provider_functions(number: int) -> Any:
    """Return the table of a provider for the calling thread, a cffi pointer to ``cf_provider_t``.

    Raises:
        UnknownNameError: If there is no provider of this number.
        StateError: If no copy of the library can be loaded for this thread.
    """
    name = _provider_name(number)
    functions = lib.cf_provider(number)
    if functions == ffi.NULL:
        raise StateError(f"no copy of provider '{name}' can be loaded for this thread: memory or files ran out")
    return functions


def find_provider(name: str, platform: str) -> int | None:
    """Return the number of the newest provider of this name for an airframe, or None."""
    platforms = platform_names()
    if platform not in platforms:
        return None
    number = lib.cf_provider_find(name.encode(), platforms.index(platform))
    return int(number) if number >= 0 else None


def platform_names() -> list[str]:
    """Return the names of the airframes, in the order of their numbers."""
    return [ffi.string(lib.cf_platform_facts(i).name).decode() for i in range(lib.CF_PLATFORM_COUNT)]


def providers() -> list[str]:
    """Return the names of the providers that are loaded, each once, the built-in one first."""
    names = [ffi.string(lib.cf_provider_name(i)).decode() for i in range(lib.cf_provider_count())]
    return list(dict.fromkeys(names))


def choices(attribute: str) -> list[str]:
    """Return the words that may be chosen for an attribute of the plugin, without the automatic choice."""
    return [word for word in attributes()[attribute][0].split(" | ") if word != "auto"]


def attributes() -> dict[str, tuple[str, str]]:
    """Return the attributes of the engine plugin: name to (allowed values, meaning)."""
    room = 256 + lib.CF_LIBRARY_NAME_BYTES * lib.cf_provider_count()
    text = ffi.new("char[]", room)
    table = {}
    for i in range(lib.cf_attribute_count()):
        lib.cf_attribute_range(i, text, room)
        name = ffi.string(lib.cf_attribute_name(i)).decode()
        table[name] = (ffi.string(text).decode(), ffi.string(lib.cf_attribute_doc(i)).decode())
    return table


@functools.cache
def attribute_names() -> tuple[str, ...]:
    """Return the names of the attributes of the engine plugin, in its order."""
    return tuple(ffi.string(lib.cf_attribute_name(i)).decode() for i in range(lib.cf_attribute_count()))


@functools.cache
def register_plugin() -> None:
    """Tell MuJoCo about the engine plugin, so that any MJCF that names it flies. Repeated calls do nothing.

    MuJoCo's Python module stays unimported, because it takes three times as long as all of this.

    Raises:
        CrazychoirError: If the MuJoCo at hand is not the one this package was built with.
    """
    spec = importlib.util.find_spec("mujoco")
    folder = Path(spec.submodule_search_locations[0]) if spec and spec.submodule_search_locations else None
    libraries = sorted(folder.glob("libmujoco*")) if folder else []
    built = _version_text(lib.cf_plugin_mujoco_version())
    try:
        status = lib.cf_plugin_register(str(ctypes.CDLL(str(libraries[0]))._name).encode()) if libraries else -1
    except OSError as error:
        raise CrazychoirError(f"MuJoCo's library cannot be loaded: {error}") from None
    if status == 0:
        at_import("mujoco", _importing_mujoco, _stop_clock)
        return
    if status == -2:
        raise CrazychoirError(
            f"built with MuJoCo {built}, found {_mujoco_version()}; run `pip install --force-reinstall --no-deps "
            "crazychoir-fw` to build again"
        )
    where = f"in {folder}" if folder else "installed"
    raise CrazychoirError(f"MuJoCo {built} is not {where}; run `pip install 'mujoco-core>=4.0,<4.1'`")


def _stop_clock() -> None:
    """Switch off MuJoCo's stop watch, unless one is set.

    MuJoCo's Python module lets every step measure its own stages for `mjData.timer`, which takes as long as half of a
    small model's step. `mujoco.set_mjcb_time(None)` switches it on again.
    """
    import mujoco

    if mujoco.get_mjcb_time() is None:
        lib.cf_plugin_stop_clock()


@contextmanager
def _importing_mujoco() -> Iterator[None]:
    """Let the extensions of MuJoCo be imported as a whole: they take a signal in between for a mistake of theirs."""
    is_main = threading.current_thread() is threading.main_thread()
    with importable(), held_signals() if is_main else nullcontext():
        yield


def _mujoco_version() -> str:
    import importlib.metadata

    for distribution in ("mujoco-core", "mujoco"):
        try:
            return importlib.metadata.version(distribution)
        except importlib.metadata.PackageNotFoundError:
            continue
    return "another version"


def _version_text(number: int) -> str:
    return f"{number // 1_000_000}.{number // 1000 % 1000}.{number % 1000}"


def identity() -> dict[str, str]:
    """Return what flew, for logs and reports: version, compiler and flags of the core, MuJoCo."""
    import mujoco

    return {
        "version": __version__,
        "compiler": ffi.string(lib.cf_build_compiler()).decode(),
        "flags": ffi.string(lib.cf_build_flags()).decode(),
        "mujoco": mujoco.__version__,
    }


def struct_view(type_name: str, address: int) -> Any:
    """Return C memory at an address as a pointer; the caller keeps its owner alive."""
    return ffi.cast(f"{type_name} *", address)


def address_of(array: Any) -> int:
    """Return the address of the first byte of a NumPy array."""
    return ctypes.c_void_p(array.ctypes.data).value or 0
