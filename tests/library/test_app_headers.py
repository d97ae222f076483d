"""An app for the vehicle includes the firmware's headers by their names, and finds them."""

import re
import subprocess
from pathlib import Path

import pytest

from crazychoir_fw._core import ffi, lib

ROOT = Path(__file__).resolve().parents[2]
BINDINGS = ROOT / "bindings"
HEADERS = sorted(path.name for folder in ("app", "library") for path in (BINDINGS / folder / "include").glob("*.h"))
INCLUDES = [f"-I{BINDINGS / folder}" for folder in ("app/include", "library/include", ".")]
STRICT = ["-Wall", "-Wextra", "-Wshadow", "-Wmissing-prototypes", "-Werror"]
PLATFORMS = {"CF2": lib.CF_PLATFORM_CF2, "CF21BL": lib.CF_PLATFORM_CF21BL}


def compile_text(text, *flags):
    command = ["gcc", "-std=gnu11", "-fsyntax-only", *STRICT, *flags, *INCLUDES, "-x", "c", "-"]
    return subprocess.run(command, input=text, capture_output=True, text=True)


def test_every_header_stands_alone_and_may_come_twice():
    for header in HEADERS:
        done = compile_text(f'#include "{header}"\n#include "{header}"\nint nothing;\n')
        assert done.returncode == 0, f"{header}: {done.stderr}"


@pytest.mark.parametrize("order", [sorted, lambda names: sorted(names, reverse=True)])
def test_all_headers_together(order):
    done = compile_text("".join(f'#include "{header}"\n' for header in order(HEADERS)) + "int nothing;\n")
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("name, number", PLATFORMS.items())
def test_constants_of_a_platform_are_those_of_the_core(name, number):
    text = (
        '#include "platform_defaults.h"\n_Static_assert(sizeof(CF_MASS) == 4, "a float");\nstatic float m = CF_MASS;\n'
    )
    assert (
        compile_text(
            text + "float *nothing(void);\nfloat *nothing(void) { return &m; }\n", f"-DCONFIG_PLATFORM_{name}=1"
        ).returncode
        == 0
    )
    facts = lib.cf_platform_facts(number)
    curve = facts.thrust
    expected = {
        "CF_MASS": facts.mass,
        "ARM_LENGTH": facts.arm_length,
        "THRUST_MIN": curve.thrust_min,
        "THRUST_MAX": curve.thrust_max,
        "THRUST2TORQUE": curve.thrust_to_torque,
        **{f"VMOTOR2THRUST{i}": getattr(curve, f"c{i}") for i in range(4)},
    }
    text = "".join(f'const char *n{i} = "{key}"; float v{i} = {key};\n' for i, key in enumerate(expected))
    command = ["gcc", "-E", "-P", f"-DCONFIG_PLATFORM_{name}=1", *INCLUDES, "-x", "c", "-"]
    done = subprocess.run(
        command, input=f'#include "platform_defaults.h"\n{text}', capture_output=True, text=True, check=True
    )
    found = re.findall(r'"(\w+)"; float v\d+ = (\S+)f;', done.stdout)
    assert {key: float(ffi.cast("float", float(value))) for key, value in found} == expected


def test_for_every_platform_the_constants_are_those_of_the_drone():
    done = compile_text('#include "platform_defaults.h"\nstatic float mass = CF_MASS;\n')
    assert "initializer element is not constant" in done.stderr
    assert (
        compile_text('#include "platform_defaults.h"\nfloat f(void);\nfloat f(void) { return CF_MASS; }\n').returncode
        == 0
    )
