"""Provider libraries over the builtin provider, compiled here with a compiler alone, and a host that loads them."""

import fcntl
import importlib.util
import shutil
import subprocess
import sysconfig
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from cffi import FFI

from crazychoir_fw._core import ffi as core_ffi
from crazychoir_fw._core import lib as core_lib
from crazychoir_fw.firmware.image import image_map

ROOT = Path(__file__).resolve().parents[2]
BINDINGS = ROOT / "bindings"
HERE = Path(__file__).resolve().parent
COMPILER = (sysconfig.get_config_var("CC") or "cc").split()[0]
FLAGS = [
    *(BINDINGS / "cflags.txt").read_text().split(),
    *["-std=gnu11", "-g", "-fPIC", "-fno-common", "-fno-strict-aliasing"],
]
STRICT = ["-Werror", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wmissing-prototypes", "-Wdouble-promotion"]
APP_INCLUDES = [BINDINGS / "app/include", BINDINGS / "library/include", BINDINGS]
PROLOGUE = ["-include", str(BINDINGS / "library/include/prologue.h")]


def run(*command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def compile_c(source, target, includes, *flags):
    run(COMPILER, *FLAGS, *flags, *(f"-I{folder}" for folder in includes), "-c", source, "-o", target)
    return target


def link(target, objects):
    run(COMPILER, "-shared", "-Wl,-Bsymbolic", "-Wl,--no-undefined", *objects, "-lm", "-o", target)
    return target


def declarations():
    """What library.h and host.h declare, for cffi."""
    spec = importlib.util.spec_from_file_location("core_builder", BINDINGS / "cffi/build.py")
    builder = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(builder)
    seen = set()
    lines = [builder.declarations("library/library.h", seen)]
    lines += [line for line in (HERE / "host.h").read_text().splitlines() if not line.startswith("#")]
    lines += ["const cf_provider_t *cf_library_open(int, const cf_library_host_t *, const cf_image_map_t *);"]
    return "\n".join(lines)


@dataclass
class Host:
    """The other side of cf_library_host_t."""

    ffi: Any
    lib: Any

    @property
    def console(self):
        return self.ffi.string(self.lib.host_record.console).decode()

    @property
    def reason(self):
        return self.ffi.string(self.lib.host_record.reason).decode()

    @property
    def failures(self):
        return self.lib.host_record.failures

    @property
    def drone(self):
        return self.lib.host_record.drone

    def core(self, pointer):
        """A pointer of the core, as one of the host."""
        kind = core_ffi.typeof(pointer).cname
        return self.ffi.cast(kind, int(core_ffi.cast("uintptr_t", pointer)))

    @property
    def builtin(self):
        return self.core(core_lib.cf_provider(0))


@dataclass
class Library:
    """A compiled library and its map."""

    path: Path
    ranges: list
    pointers: list


@dataclass
class Copy:
    """One loaded copy of a library."""

    host: Host
    loaded: Any
    provider: Any
    keeps: list = field(default_factory=list)

    def __getattr__(self, name):
        return getattr(self.provider, name)

    def drone(self, platform=core_lib.CF_PLATFORM_CF2):
        """A drone after boot."""
        drone = Drone.empty(self.host, self.provider.state_bytes)
        assert self.provider.init(drone.block, platform, 0) == core_lib.CF_OK
        return drone

    def tables(self, kind):
        tables = self.host.ffi.new("cf_variables_t[]", core_lib.CF_PROVIDER_MAX_TABLES)
        count = getattr(self.provider, kind)(tables, len(tables))
        self.keeps.append(tables)  # elements do not keep their array
        return [tables[i] for i in range(count)]

    def variables(self, kind):
        """(group, name, type, flags, offset) of all parameters or logs."""
        text = lambda pointer: self.host.ffi.string(pointer).decode()
        return [
            (text(row.group), text(row.name), row.type, row.flags, table.base + row.offset)
            for table in self.tables(kind)
            for row in table.rows[0 : table.count]
        ]

    def find(self, kind, full_name):
        return next(row for row in self.variables(kind) if f"{row[0]}.{row[1]}" == full_name)

    def cell(self, drone, kind, full_name):
        """A pointer to a variable in the block of a drone."""
        c_types = ["uint8_t", "uint16_t", "uint32_t", "int8_t", "int16_t", "int32_t", "float"]
        _, _, number, _, offset = self.find(kind, full_name)
        return self.host.ffi.cast(f"{c_types[number]} *", drone.block + offset)

    def get(self, drone, kind, full_name):
        return self.cell(drone, kind, full_name)[0]

    def set(self, drone, full_name, value):
        self.cell(drone, "parameters", full_name)[0] = value
        group, name = full_name.split(".")
        self.provider.parameter_written(drone.block, group.encode(), name.encode())


@dataclass
class Drone:
    """A block, with the host's variables before it."""

    memory: Any
    block: Any
    host: Any
    bytes: int

    @staticmethod
    def empty(host, state_bytes):
        before = host.ffi.sizeof("host_drone_t")
        memory = host.ffi.new("uint64_t[]", (before + state_bytes + 7) // 8)
        start = host.ffi.cast("char *", memory)
        return Drone(memory, start + before, host.ffi.cast("host_drone_t *", start), state_bytes)

    def save(self, ffi):
        return bytes(ffi.buffer(self.block, self.bytes))

    def restore(self, ffi, saved):
        ffi.buffer(self.block, self.bytes)[:] = saved


@pytest.fixture(scope="session")
def library_folder(tmp_path_factory):
    """A folder that all processes of a test run share."""
    base = tmp_path_factory.getbasetemp()
    is_worker = base.name.startswith("popen-")
    folder = (base.parent if is_worker else base) / "provider_libraries"
    folder.mkdir(exist_ok=True)
    return folder


def once(folder, name, make):
    """Return the file of this name in a shared folder; the first worker makes it."""
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (folder / name).exists():
            make(folder / f"new_{name}")
            (folder / f"new_{name}").rename(folder / name)
    return folder / name


@pytest.fixture(scope="session")
def parts(library_folder):
    """Objects that every library of these tests has."""

    def make(target):
        listed = (ROOT / "bindings/sources.txt").read_text().split()
        builtin = [ROOT / name for name in listed if name.startswith("bindings/builtin/")]
        own = [*BINDINGS.glob("library/*.c"), *BINDINGS.glob("app/*.c")]
        sources = [BINDINGS / "platform.c", *builtin, *own]
        objects = [library_folder / f"{source.parent.name}_{source.stem}.o" for source in sources]
        with ThreadPoolExecutor(2) as pool:
            # the same bits at any level without -ffast-math, and compiled in a third of the time
            flags = {source: STRICT if source in own else ["-O1"] for source in sources}
            make_one = lambda source, target: compile_c(
                source, target, [BINDINGS, BINDINGS / "app/include"], *flags[source]
            )
            list(pool.map(make_one, sources, objects))
        target.write_text("\n".join(map(str, objects)))

    return once(library_folder, "objects.txt", make).read_text().split()


def load_map(path):
    ranges, pointers = image_map(path)
    return Library(path, ranges, pointers)


@pytest.fixture(scope="session")
def plain_library(library_folder, parts):
    """A library without an app."""
    return load_map(once(library_folder, "plain.so", lambda target: link(target, parts)))


@pytest.fixture(scope="session")
def app_library(library_folder, parts):
    """A library with the test app."""

    def make(target):
        objects = [
            compile_c(source, library_folder / f"{source.stem}.o", APP_INCLUDES, *PROLOGUE, "-Wall", "-Wextra")
            for source in sorted((HERE / "apps").glob("*.c"))
        ]
        link(target, [*parts, *objects])

    return load_map(once(library_folder, "app.so", make))


@pytest.fixture(scope="session")
def host(library_folder):
    def make(target):
        compiled = compile_c(HERE / "host.c", library_folder / "host.o", [BINDINGS], "-fvisibility=default")
        link(target, [compiled])

    ffi = FFI()
    ffi.cdef(declarations())
    return Host(ffi, ffi.dlopen(str(once(library_folder, "host.so", make))))


@pytest.fixture
def open_library(host, tmp_path):
    """Load a new copy of a library, at an address of its own."""
    copies = []

    def open_copy(library, ranges=None, pointers=None, abi=None):
        path = tmp_path / f"copy_{len(copies)}.so"
        shutil.copy(library.path, path)
        loaded = host.ffi.dlopen(str(path))
        ranges = host.ffi.new("cf_image_range_t[]", library.ranges if ranges is None else ranges)
        pointers = host.ffi.new("uint32_t[]", library.pointers if pointers is None else pointers)
        image = host.ffi.new("cf_image_map_t *", (ranges, len(ranges), pointers, len(pointers)))
        abi = host.lib.CF_LIBRARY_ABI if abi is None else abi
        provider = loaded.cf_library_open(abi, host.ffi.addressof(host.lib, "host"), image)
        copies.append(Copy(host, loaded, provider, [ranges, pointers, image]))
        if provider != host.ffi.NULL:
            host.lib.host_provider = provider
        return copies[-1]

    host.ffi.memmove(
        host.ffi.addressof(host.lib, "host_record"),
        bytes(host.ffi.sizeof("host_record_t")),
        host.ffi.sizeof("host_record_t"),
    )
    host.lib.host_catch_crashes()
    yield open_copy
    host.lib.host_catch_no_crashes()
    # in every case, no jump into a function that has returned is left armed
    assert not host.lib.host_has_rescue()


@pytest.fixture
def app(open_library, app_library):
    return open_library(app_library)


@pytest.fixture
def fly(host):
    """Call the controller of a drone once; what the app answers."""
    control = host.ffi.new("control_t *")
    setpoint, sensors, state = (host.ffi.new(f"{kind} *") for kind in ("setpoint_t", "sensorData_t", "state_t"))

    def call(copy, drone, step=0):
        copy.controller(drone.block, control, setpoint, sensors, state, step)
        return tuple(control.normalizedForces)

    return call
