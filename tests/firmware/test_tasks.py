"""Tasks that wait are part of the drone: their stacks go along to another copy of the library, thread or snapshot."""

import itertools
import shutil
import subprocess
import sysconfig
import threading
from pathlib import Path

import pytest
from cffi import FFI

from crazychoir_fw.firmware.image import image_map

ROOT = Path(__file__).resolve().parents[2]
BINDINGS = ROOT / "bindings"
COMPILER = (sysconfig.get_config_var("CC") or "cc").split()[0]
SOURCES = [
    ROOT / "tests/firmware/task_library.c",
    BINDINGS / "library/image.c",
    BINDINGS / "library/work.c",
    *sorted((BINDINGS / "bitcraze/rtos").glob("*.c")),
]
FLY, CRASH, RECURSE, ASSERT, LEAVE_DIRT = range(5)
TICKS = 60

ffi = FFI()
ffi.cdef(
    """
    typedef struct { uint32_t offset, bytes; } range_t;
    size_t toy_open(const range_t *ranges, int n_ranges, const uint32_t *pointers, int n_pointers);
    void toy_boot(void *state, int kind);
    const char *toy_tick(void *state, uint32_t now);
    uint64_t toy_sum(const void *state);
    uint32_t toy_laps(const void *state);
    """
)


class Copy:
    """One copy of the library, at addresses of its own."""

    def __init__(self, path, ranges, pointers, is_exact):
        self._is_exact = is_exact
        self.lib = ffi.dlopen(str(path))
        self._ranges = ffi.new("range_t[]", ranges)
        self._pointers = ffi.new("uint32_t[]", pointers)
        self.bytes = self.lib.toy_open(self._ranges, len(ranges), self._pointers, len(pointers))
        assert self.bytes > 0

    def boot(self, kind=FLY):
        state = ffi.new("char[]", self.bytes)
        self.lib.toy_boot(state, kind)
        return state

    def tick(self, state, now):
        return ffi.string(self.lib.toy_tick(state, now)).decode()

    def view(self, state):
        """Return what equal flights have in common: the image to the bit, or what the tasks saw."""
        if self._is_exact:
            return bytes(ffi.buffer(state))[: self.bytes]
        return self.lib.toy_sum(state), self.lib.toy_laps(state)

    def fly(self, kind=FLY):
        """Return the view after each tick."""
        state = self.boot(kind)
        return [self.tick(state, now) or self.view(state) for now in range(1, TICKS)]


@pytest.fixture(scope="module", params=["-O3", "-O2 -D_FORTIFY_SOURCE=2", "-Os", "-O0"])
def library(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("tasks") / f"tasks{request.param.split()[0]}.so"
    options = ["-std=gnu11", "-g", "-gdwarf-4", "-fPIC", "-fno-common", "-fvisibility=hidden", "-fno-stack-protector"]
    includes = [f"-I{BINDINGS}", f"-I{BINDINGS / 'bitcraze/freertos'}"]
    link = ["-shared", "-Wl,-Bsymbolic", "-Wl,--no-undefined", "-Wno-infinite-recursion"]
    subprocess.run(
        [COMPILER, *request.param.split(), *options, *includes, *map(str, SOURCES), *link, "-o", str(path)], check=True
    )
    return path


@pytest.fixture(scope="module")
def copies(library):
    ranges, pointers = image_map(library)
    paths = [library.with_name(f"copy{i}.so") for i in range(3)]
    for path in paths:
        shutil.copy(library, path)
    # without optimization the frames of tasks have gaps, in which there are halves of old addresses
    is_exact = library.name != "tasks-O0.so"
    return [Copy(path, ranges, pointers, is_exact) for path in paths]


def test_stacks_take_no_room_in_the_file_nor_in_the_image(library):
    assert library.stat().st_size < 300_000
    ranges, _ = image_map(library)
    assert sum(size for _, size in ranges) < 20_000


def test_tasks_do_their_work(copies):
    state = copies[0].boot()
    for now in range(1, TICKS):
        assert copies[0].tick(state, now) == ""
    assert copies[0].lib.toy_laps(state) == 29
    assert copies[0].lib.toy_sum(state) != 0


def test_equal_flights_are_equal_to_the_bit_on_every_copy(copies):
    flights = [copy.fly() for copy in (*copies, copies[0])]
    assert all(flight == flights[0] for flight in flights)
    assert len(set(flights[0])) > TICKS / 2


def test_a_drone_goes_from_copy_to_copy_at_every_tick(copies):
    expected = copies[0].fly()
    state = copies[2].boot()
    for now, copy in zip(range(1, TICKS), itertools.cycle(copies), strict=False):
        assert copy.tick(state, now) == ""
        assert copies[0].view(state) == expected[now - 1]


def test_what_other_drones_leave_on_the_stacks_is_not_seen(copies):
    expected = copies[1].fly()
    state, other = copies[0].boot(), copies[0].boot(LEAVE_DIRT)
    for now in range(1, TICKS):
        assert copies[0].tick(other, 2 * now) == ""
        assert copies[0].tick(state, now) == ""
        assert copies[0].view(state) == expected[now - 1]


def test_a_snapshot_flies_on_as_the_drone_did(copies):
    expected = copies[0].fly()
    state = copies[0].boot()
    for now in range(1, 31):
        copies[0].tick(state, now)
    snapshot = ffi.new("char[]", bytes(ffi.buffer(state)))
    for now in range(31, TICKS):
        copies[0].tick(state, now)
    for now in range(31, TICKS):
        copies[1].tick(snapshot, now)
    assert copies[0].view(snapshot) == copies[0].view(state) == expected[-1]


def test_threads_with_copies_of_their_own_hand_drones_over(copies):
    expected = copies[0].fly()
    drones = [copies[0].boot() for _ in range(3)]

    def work(copy, state, ticks):
        for now in ticks:
            copy.tick(state, now)

    for first in range(1, TICKS, 10):
        ticks = range(first, min(first + 10, TICKS))
        threads = [
            threading.Thread(target=work, args=(copies[(i + first // 10) % 3], drones[i], ticks)) for i in range(3)
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert all(copies[0].view(state) == expected[-1] for state in drones)


@pytest.mark.parametrize(
    ("kind", "reason"),
    [
        (CRASH, "segmentation fault in tick"),
        (RECURSE, "segmentation fault in tick"),
        (ASSERT, "assertion failed: thrust >= 0 (task.c:12)"),
    ],
)
def test_after_a_failure_in_a_task_the_others_fly_on(copies, kind, reason):
    expected = copies[1].fly()
    for _ in range(3):
        bad, good = copies[0].boot(kind), copies[0].boot()
        for now in range(1, 10):
            before = bytes(ffi.buffer(bad))
            failure = copies[0].tick(bad, now)
            assert failure == (reason if now >= 6 else "")
            if failure:
                assert bytes(ffi.buffer(bad)) == before
            assert copies[0].tick(good, now) == ""
            assert copies[0].view(good) == expected[now - 1]


def test_a_failure_in_a_task_is_survived_in_any_thread(copies):
    told = []

    def fail():
        state = copies[2].boot(ASSERT)
        told.append([copies[2].tick(state, now) for now in range(1, 7)][-1])

    for _ in range(2):
        thread = threading.Thread(target=fail)
        thread.start()
        thread.join()
    assert told == 2 * ["assertion failed: thrust >= 0 (task.c:12)"]
