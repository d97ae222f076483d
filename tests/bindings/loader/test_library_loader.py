"""Provider libraries: what is loaded, what is refused, and which one a name means."""

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from toy_library import COMPILER, Toy, load_toy, toy_path

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError, StateError, UnknownNameError
from crazychoir_fw.onboard import core
from crazychoir_fw.onboard.core import find_provider, load_library, provider_functions, provider_identity
from crazychoir_fw.onboard.installation import info
from crazychoir_fw.onboard.variables import factory_values, log_table, parameter_table

BUILTIN_BYTES = lib.cf_state_bytes(0)


def test_a_library_becomes_a_provider_and_stays_the_same():
    number = load_toy(name="first")
    assert number >= 1
    assert load_toy(name="first") == number
    assert find_provider("first", "cf2") == find_provider("first", "cf21bl") == number
    assert "first" in core.providers()
    assert "first" in core.choices("provider")
    assert ffi.string(lib.cf_provider_name(number)) == b"first"
    assert ffi.string(provider_functions(number).name) == b"toy"


def test_the_newest_of_a_name_wins_and_names_are_listed_once():
    old, new = load_toy(name="twice"), load_toy("TOY_GAIN=0.5f", name="twice")
    assert old != new
    assert find_provider("twice", "cf2") == new
    # what was once built and is asked for again is the newest
    assert load_toy(name="twice") == old
    assert find_provider("twice", "cf2") == old
    assert core.providers().count("twice") == core.choices("provider").count("twice") == 1


def test_a_library_for_one_airframe_is_not_found_for_another():
    number = load_toy(name="brushless", platform="cf21bl")
    assert find_provider("brushless", "cf21bl") == number
    assert find_provider("brushless", "cf2") is None
    everywhere = load_toy("TOY_GAIN=0.5f", name="brushless")
    assert find_provider("brushless", "cf2") == everywhere
    assert find_provider("brushless", "balloon") is None


def test_builtin_is_number_0_and_says_how_it_was_built():
    assert find_provider("builtin", "cf2") == 0
    assert core.providers()[0] == "builtin"
    identity = provider_identity(0)
    assert identity["provider"] == "builtin"
    assert "-ffp-contract=off" in identity["flags"]
    assert identity["version"] and identity["compiler"]


def test_a_library_says_what_it_was_built_from():
    number = load_library(Toy(toy_path(), name="known", identity={"version": "2024.10", "features": ["kalman"]}))
    assert provider_identity(number) == {"provider": "known", "version": "2024.10", "features": ["kalman"]}
    assert provider_identity(number) in info()["libraries"]


@pytest.mark.parametrize("number", [-1, 5000])
def test_a_number_that_does_not_exist_is_unknown(number):
    assert lib.cf_provider(number) == ffi.NULL
    assert lib.cf_provider_name(number) == ffi.NULL
    assert lib.cf_state_bytes(number) == lib.cf_provider_block_bytes(number) == 0
    for ask in (provider_identity, provider_functions, parameter_table):
        with pytest.raises(UnknownNameError, match=f"no provider number {number}, there are"):
            ask(number)


# ---- what is refused ----


def compile_c(folder: Path, text: str) -> Path:
    source = folder / "library.c"
    source.write_text(text)
    subprocess.run(
        [
            COMPILER,
            "-shared",
            "-fPIC",
            str(source),
            "-o",
            str(folder / "library.so"),
            "-Wl,--unresolved-symbols=ignore-all",
        ],
        check=True,
    )
    return folder / "library.so"


def refusal(library, kind=RangeError) -> str:
    before = lib.cf_provider_count()
    with pytest.raises(kind) as caught:
        load_library(library)
    assert lib.cf_provider_count() == before
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_a_file_that_is_not_there(tmp_path):
    sentence = refusal(Toy(tmp_path / "gone.so"), UnknownNameError)
    assert sentence == f"{tmp_path / 'gone.so'} cannot be read: No such file or directory"


def test_a_file_that_is_no_library(tmp_path):
    text = tmp_path / "text.so"
    text.write_text("not a library, but long enough for a header of one" * 10)
    assert refusal(Toy(text)) == f"{text} cannot be loaded: invalid ELF header"
    text.write_text("")
    assert "it is empty" in refusal(Toy(text))
    assert "no file" in refusal(Toy(tmp_path))


def test_a_library_that_misses_a_function(tmp_path):
    path = compile_c(tmp_path, "int nobody_has_this(void);\nint call(void) { return nobody_has_this(); }\n")
    assert refusal(Toy(path)) == f"{path} cannot be loaded: undefined symbol: nobody_has_this"


def test_a_library_without_the_entry():
    path = toy_path("TOY_ENTRY=something_else")
    assert refusal(Toy(path)) == f"{path} is no provider library, it has no cf_library_open"


def test_a_library_of_another_version():
    path = toy_path("TOY_ABI=99")
    sentence = refusal(Toy(path), StateError)
    assert sentence == f"{path} was built for another version of crazychoir_fw, build it again"


@pytest.mark.parametrize("padding", [1, 300_000])
def test_a_library_that_remembers_too_much_or_no_whole_words(padding):
    assert "bytes per drone, allowed: 8 to 262144 in whole words of 8" in refusal(
        Toy(toy_path(f"TOY_PADDING={padding}"))
    )


@pytest.mark.parametrize("name", ["", "builtin", "x" * 64])
def test_a_name_that_cannot_be(name):
    assert f"a library is named '{name}', allowed: 1 to 63 characters" in refusal(Toy(toy_path(), name=name))


def test_an_airframe_that_is_unknown():
    sentence = refusal(Toy(toy_path(), platform="balloon"), UnknownNameError)
    assert sentence == "library 'toy' is for platform 'balloon', allowed: cf2, cf21bl"
    name = ffi.new("char[]", b"toy")
    request = ffi.new("cf_library_t *", {"name": name, "platform": 7})
    message = ffi.new("char[]", lib.CF_LIBRARY_MESSAGE_BYTES)
    assert lib.cf_library_load(request, message) == lib.CF_ERR_VALUE
    assert ffi.string(message) == b"library toy is for platform number 7, allowed: -1 to 1"


def variables_of(path: Path) -> tuple[int, int]:
    """Return a range of the library's variables that its code may write: the address of .bss, and its length."""
    for line in subprocess.run(
        ["objdump", "-h", str(path)], capture_output=True, text=True, check=True
    ).stdout.splitlines():
        if (words := line.split())[1:2] == [".bss"]:
            return int(words[3], 16), int(words[2], 16)
    raise AssertionError("no .bss")


def test_an_image_map_that_fits_is_taken():
    start, size = variables_of(toy_path())
    assert load_library(Toy(toy_path(), name="mapped", ranges=[(start, 16), (start + 16, size - 16)], pointers=[start]))
    # the same file with another map is another library
    assert find_provider("mapped", "cf2") != load_library(Toy(toy_path(), name="mapped", ranges=[(start, 16)]))


@pytest.mark.parametrize(
    ("ranges", "pointers", "fault"),
    [
        ([(0, 16)], [], "has a range outside the library's variables"),  # the header
        ([(1 << 30, 16)], [], "has a range outside the library's variables"),
        ([(0xFFFFFFFF, 0xFFFFFFFF)], [], "has a range outside the library's variables"),
        (["bss", (0, 16)], [], "has ranges that are empty, overlap or do not ascend"),
        (["bss", "bss"], [], "has ranges that are empty, overlap or do not ascend"),
        ([(64, 0)], [], "has ranges that are empty, overlap or do not ascend"),
        (["bss"], [8], "has a pointer outside its ranges"),
        ([], [8], "has a pointer outside its ranges"),
        (["relro"], [], "has a range outside the library's variables"),
    ],
)
def test_an_image_map_that_belongs_to_something_else(ranges, pointers, fault):
    path = toy_path()
    places = {"bss": variables_of(path), "relro": relocated_constants_of(path)}
    known = [places[item] if isinstance(item, str) else item for item in ranges]
    assert refusal(Toy(path, ranges=known, pointers=pointers)) == f"the image map of {path} {fault}"


def relocated_constants_of(path: Path) -> tuple[int, int]:
    """Return what the dynamic loader makes read-only when it has filled in addresses."""
    text = subprocess.run(["readelf", "-lW", str(path)], capture_output=True, text=True, check=True).stdout
    words = next(line.split() for line in text.splitlines() if "GNU_RELRO" in line)
    return int(words[2], 16), 8


@pytest.mark.parametrize("changes", [{"n_ranges": -1}, {"n_pointers": -1}, {"n_ranges": 1}, {"n_pointers": 1}])
def test_an_image_map_without_lists(changes):
    words = {"name": ffi.new("char[]", b"toy"), "path": ffi.new("char[]", str(toy_path()).encode())}
    request = ffi.new("cf_library_t *", {**words, "platform": -1, "map": changes})
    message = ffi.new("char[]", lib.CF_LIBRARY_MESSAGE_BYTES)
    assert lib.cf_library_load(request, message) == lib.CF_ERR_VALUE
    assert ffi.string(message).decode().endswith("has a negative count or no list")


def test_a_long_path_does_not_overflow_the_message(tmp_path):
    sentence = refusal(Toy(tmp_path / "x" / ("y" * 240)), UnknownNameError)
    assert len(sentence) < lib.CF_LIBRARY_MESSAGE_BYTES
    assert sentence.endswith("cannot be read: No such file or directory")


# ---- copies ----


def test_every_thread_has_a_copy_and_leaves_it_to_the_next():
    number = load_toy(name="copied")
    tables = []

    def look() -> None:
        tables.append(int(ffi.cast("uintptr_t", lib.cf_provider(number))))
        assert lib.cf_provider(number) == lib.cf_provider(number)

    for _ in range(3):
        thread = threading.Thread(target=look)
        thread.start()
        task = Path(f"/proc/self/task/{thread.native_id}")
        thread.join()
        # Python is done with a thread a moment before it has ended, and only then is its copy given back
        while task.exists():
            time.sleep(0.001)
    assert len(set(tables)) == 1
    look()
    assert tables[-1] != tables[0]


def test_a_library_may_vanish_after_it_was_loaded(tmp_path):
    path = tmp_path / "toy.so"
    path.write_bytes(toy_path().read_bytes())
    number = load_library(Toy(path, name="vanishing"))
    path.unlink()
    found = []
    thread = threading.Thread(target=lambda: found.append(lib.cf_provider(number) != ffi.NULL))
    thread.start()
    thread.join()
    assert found == [True]


# ---- size of a drone, variables ----


def test_a_drone_is_as_long_as_its_provider_needs():
    small, large = load_toy(name="small"), load_toy("TOY_PADDING=20000", name="large")
    assert lib.cf_state_bytes(small) == BUILTIN_BYTES
    needed = provider_functions(large).state_bytes
    assert needed > 20000 > lib.CF_PROVIDER_STATE_BYTES
    assert lib.cf_provider_block_bytes(large) == needed
    assert lib.cf_state_bytes(large) == BUILTIN_BYTES + needed - lib.CF_PROVIDER_STATE_BYTES


def test_variables_of_a_library_are_its_own():
    number = load_toy("TOY_PADDING=20000", name="varied")
    assert set(parameter_table(number)) - set(parameter_table()) == {"toy.gain", "toy.mishap"}
    assert "toy.calls" in log_table(number)
    assert "toy.calls" not in log_table()
    assert factory_values("cf2", parameter_table(number), number)["toy.gain"] == 1.0


def test_factory_values_of_an_unknown_provider_are_refused():
    with pytest.raises(UnknownNameError, match="no provider number 5000"):
        factory_values("cf2", parameter_table(), 5000)


# ---- files or memory run out, and crashes outside of any library: each in its own process ----

PRELUDE = f"""
import resource, sys, threading
sys.path.insert(0, {str(Path(__file__).parents[2])!r})
from toy_library import load_toy
from crazychoir_fw._core import ffi, lib
from crazychoir_fw.onboard.core import provider_functions
from crazychoir_fw.simulation import DroneConfig, World
"""


def run_script(text: str, **options) -> subprocess.CompletedProcess:
    return subprocess.run(
        [sys.executable, "-c", PRELUDE + text],
        capture_output=True,
        text=True,
        timeout=60,
        env=dict(os.environ),
        **options,
    )


def test_a_thread_that_gets_no_copy_stops_the_drone_and_not_the_process():
    done = run_script("""
load_toy()
world = World([DroneConfig("a", (0, 0), provider="toy"), DroneConfig("b", (1, 0))])
world.wait_until_ready()
resource.setrlimit(resource.RLIMIT_NOFILE, (3, 3))

def elsewhere():
    cf = world["a"].struct
    try:
        provider_functions(1)
    except Exception as error:
        print(type(error).__name__, error)
    print(lib.cf_takeoff(cf, 1.0, 2.0, 0.0, True), lib.cf_send_stop(cf), lib.cf_is_trajectory_finished(cf))
    world.run(0.1)
    lib.cf_reboot(cf)
    world.run(0.1)
    print(world["a"].failure, "|", world["b"].failure)

thread = threading.Thread(target=elsewhere)
thread.start()
thread.join()
""")
    assert done.returncode == 0, done.stderr
    first, second, third = done.stdout.splitlines()
    assert first == "StateError no copy of provider 'toy' can be loaded for this thread: memory or files ran out"
    assert second == f"{lib.CF_ERR_STATE} {lib.CF_ERR_STATE} True"
    reason = "the onboard software failed: no copy of the provider can be loaded for this thread"
    assert third == f"a: {reason} (at 0.000 s) | None"


@pytest.mark.parametrize("handler", ["", "import faulthandler; faulthandler.enable()\n"])
@pytest.mark.parametrize("crash", ["ctypes.string_at(0)", "os.kill(os.getpid(), signal.SIGSEGV); time.sleep(5)"])
def test_a_crash_of_other_code_ends_the_process_as_ever(handler, crash):
    done = run_script(f"import ctypes, os, signal, time\n{handler}load_toy()\n{crash}\nprint('alive')\n")
    assert done.returncode == -11
    assert "alive" not in done.stdout
    assert ("Fatal Python error" in done.stderr) == bool(handler)


def test_a_handler_of_python_is_still_called():
    done = run_script("""
import signal, os
signal.signal(signal.SIGABRT, lambda number, frame: print("python", number))
load_toy()
os.kill(os.getpid(), signal.SIGABRT)
print("alive")
""")
    assert (done.returncode, done.stdout) == (0, "python 6\nalive\n"), done.stderr


def test_a_model_that_asks_for_the_firmware_says_how_to_load_it():
    """In a process that has not loaded it."""
    done = run_script("""
config, message = ffi.new("cf_config_t *"), ffi.new("char[]", lib.CF_ATTRIBUTE_MESSAGE_BYTES)
lib.cf_config_default(config, lib.CF_PLATFORM_CF21BL)
names = [ffi.string(lib.cf_attribute_name(i)).decode() for i in range(lib.cf_attribute_count())]
load_toy(platform="cf2")
load_toy(name="other")
print(lib.cf_attribute_set(config, names.index("provider"), b"bitcraze", message) == lib.CF_ERR_VALUE)
print(ffi.string(message).decode())
""")
    command = "call crazychoir_fw.firmware.providers.load('bitcraze', 'cf21bl') first"
    assert done.stdout == f"True\nprovider is 'bitcraze', allowed: builtin | other; {command}\n", done.stderr


def test_there_is_an_end_to_loading():
    done = run_script("""
try:
    for i in range(2000):
        load_toy(name=f"toy{i}")
except Exception as error:
    print(i, error)
print(lib.cf_provider_count(), load_toy(name="toy5"))
""")
    sentence = "1023 libraries have been loaded, more are not possible: start again"
    assert done.stdout == f"{lib.CF_MAX_LIBRARIES} {sentence}\n{lib.CF_MAX_LIBRARIES + 1} 6\n", done.stderr


def test_a_forked_child_flies_on():
    done = run_script("""
import os
load_toy()
world = World([DroneConfig("a", provider="toy")])
world.run(1.8)
child = os.fork()
if child == 0:
    world.run(0.2)
    os._exit(7 if world["a"].log["toy.calls"] > 400 else 1)
print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
""")
    assert done.stdout == "7\n", done.stderr
