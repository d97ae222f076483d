"""Tasks that wait are part of the drone: their stacks go along to another copy of the library, thread or snapshot."""

import collections
import itertools
import mmap
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
PRIVATE = mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS

ffi = FFI()
ffi.cdef(
    """
    typedef struct { uint32_t offset, bytes; } range_t;
    size_t toy_open(const range_t *ranges, int n_ranges, const uint32_t *pointers, int n_pointers);
    void toy_boot(void *state, int kind);
    const char *toy_tick(void *state, uint32_t now);
    uint64_t toy_sum(const void *state);
    uint32_t toy_laps(const void *state);
    void toy_watch(void);
    void toy_watch_no_more(void);
    """
)


class Copy:
    """One copy of the library, at addresses of its own."""

    def __init__(self, path, ranges, pointers, is_exact):
        self._is_exact = is_exact
        self.lib = ffi.dlopen(str(path))
        self.window = int(ffi.cast("uintptr_t", ffi.addressof(self.lib, "toy_open"))) >> 32  # of 4 GiB
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
        return self.seen(state)

    def seen(self, state):
        """Return what the tasks saw."""
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
def make_copy(library):
    """Load copies; those near each other have addresses with equal upper halves, of which gaps of frames hold some."""
    ranges, pointers = image_map(library)
    # without optimization there are lower halves, too
    is_exact = library.name != "tasks-O0.so"
    numbers = itertools.count()

    def load():
        path = library.with_name(f"copy{next(numbers)}.so")
        shutil.copy(library, path)
        return Copy(path, ranges, pointers, is_exact)

    return load


@pytest.fixture(scope="module")
def copies(make_copy):
    loaded = [make_copy()]
    while True:
        windows = collections.Counter(copy.window for copy in loaded)
        window, count = windows.most_common(1)[0]
        if count == 3:
            return [copy for copy in loaded if copy.window == window]
        loaded.append(make_copy())


def test_stacks_take_no_room_in_the_file_nor_in_the_image(library):
    assert library.stat().st_size < 300_000
    ranges, _ = image_map(library)
    assert sum(size for _, size in ranges) < 20_000


def test_pointers_into_stacks_are_pointers_into_the_library(library):
    table = subprocess.run(["nm", str(library)], capture_output=True, text=True, check=True).stdout.splitlines()
    at = {line.split()[-1]: int(line.split()[0], 16) for line in table if len(line.split()) == 3}
    assert at["__ehdr_start"] < at["cf_stacks"]
    assert at["cf_stacks"] + 8 * 65536 <= at["_end"]


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


def test_copies_far_from_each_other_fly_the_same(copies, make_copy):
    """Images differ only in bytes that no code reads, the upper halves of addresses in gaps; task results are equal."""
    rooms = [mmap.mmap(-1, 5 << 30, flags=PRIVATE, prot=0)]  # new things go below, once the holes above are full
    far = make_copy()
    while far.window == copies[0].window and len(rooms) < 100_000:  # a worker that has run for long has many holes
        rooms += [mmap.mmap(-1, 1 << 20, flags=PRIVATE, prot=0) for _ in range(256)]
        far = make_copy()
    assert far.window != copies[0].window
    state, there = copies[0].boot(), far.boot()
    for now in range(1, TICKS):
        assert copies[0].tick(state, now) == far.tick(there, now) == ""
        assert far.seen(there) == copies[0].seen(state)
    # and goes on where the other one was
    assert far.tick(state, TICKS) == copies[0].tick(there, TICKS) == ""
    assert far.seen(state) == copies[0].seen(there)


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


@pytest.fixture
def watched(copies):
    copies[0].lib.toy_watch()
    yield
    copies[0].lib.toy_watch_no_more()


@pytest.mark.usefixtures("watched")
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


# ---- headers ----

HEADERS = sorted(
    path.name for folder in ("freertos", "shadow") for path in (BINDINGS / "bitcraze" / folder).glob("*.h")
)

CONFIGURATION = """
#ifndef FREERTOS_CONFIG_H
#define FREERTOS_CONFIG_H
#define configTICK_RATE_HZ ((TickType_t)1000)
#define configMINIMAL_STACK_SIZE ((unsigned short)150)
#define configMAX_PRIORITIES (6)
#define configMAX_TASK_NAME_LEN (10)
void assertFail(char *expression, char *file, int line);
#define configASSERT(x) if ((x) == 0) assertFail(#x, __FILE__, __LINE__)
#define M2T(X) ((unsigned int)(X))
#endif
"""

# upstream's manner of speaking, old and new
USE = """
#include "FreeRTOS.h"
#include "event_groups.h"
#include "queue.h"
#include "semphr.h"
#include "task.h"
#include "timers.h"
#include "stm32fxxx.h"

#ifndef M2T
#define M2T(X) (X)
#endif

static xQueueHandle items;
static QueueHandle_t others;
static xSemaphoreHandle lock;
static xTimerHandle timer;
static StaticQueue_t items_place;
static StaticSemaphore_t lock_place;
static StaticTask_t task_place;
static StaticTimer_t timer_place;
static StackType_t stack[3 * configMINIMAL_STACK_SIZE];
static uint8_t storage[4 * sizeof(int)];

static void task(void *parameters) {
  portTickType last = xTaskGetTickCount();
  portBASE_TYPE woken = pdFALSE;
  int item = 0;
  vTaskSetApplicationTaskTag(0, (void *)3);
  while (1) {
    vTaskDelayUntil(&last, M2T(10));
    if (pdTRUE == xQueueReceive(items, &item, portMAX_DELAY)) {
      xSemaphoreTake(lock, portMAX_DELAY);
      xQueueOverwrite(others, &item);
      xSemaphoreGive(lock);
    }
    if ((SCB->ICSR & SCB_ICSR_VECTACTIVE_Msk) != 0) {
      xQueueSendFromISR(items, &item, &woken);
      if (woken) {
        portYIELD();
      }
    }
    taskENTER_CRITICAL();
    taskEXIT_CRITICAL();
    configASSERT(item >= 0);
    vTaskDelay(pdMS_TO_TICKS(5) * portTICK_RATE_MS / portTICK_PERIOD_MS);
  }
}

static void call(xTimerHandle of) {
  (void)pvTimerGetTimerID(of);
}

TaskHandle_t start(void);
TaskHandle_t start(void) {
  items = xQueueCreateStatic(4, sizeof(int), storage, &items_place);
  others = xQueueCreate(1, sizeof(int));
  lock = xSemaphoreCreateMutexStatic(&lock_place);
  timer = xTimerCreateStatic("TIMER", M2T(100), pdTRUE, NULL, call, &timer_place);
  xTimerStart(timer, 100);
  return xTaskCreateStatic(task, "TASK", 3 * configMINIMAL_STACK_SIZE, NULL, configMAX_PRIORITIES - 1, stack,
                           &task_place);
}
"""


def complaints(folder, text, *flags):
    """Return what a strict compiler says of a text."""
    source = folder / "code.c"
    source.write_text(text)
    includes = [f"-I{BINDINGS / 'bitcraze/shadow'}", f"-I{BINDINGS / 'bitcraze/freertos'}", f"-I{folder}"]
    command = [COMPILER, "-std=gnu11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", *flags, *includes, str(source)]
    return subprocess.run(command, capture_output=True, text=True, check=False).stderr


@pytest.mark.parametrize("header", HEADERS)
def test_each_header_stands_alone(tmp_path, header):
    assert complaints(tmp_path, f'#include "{header}"\n#include "{header}"\ntypedef int nothing;\n') == ""


@pytest.mark.parametrize("configuration", [CONFIGURATION, None])
def test_upstreams_manner_of_speaking_is_understood(tmp_path, configuration):
    if configuration is not None:
        (tmp_path / "FreeRTOSConfig.h").write_text(configuration)
    assert complaints(tmp_path, USE, "-Wno-unused-parameter") == ""
