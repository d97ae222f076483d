"""Modified checkouts: each fork takes the files of a release and returns its own."""

import re
from collections.abc import Callable

Files = dict[str, bytes]
INTERFACE = "src/modules/interface"
MODULES = "src/modules/src"


def _edit(files: Files, name: str, *pairs: tuple[str, str]) -> None:
    text = files[name].decode()
    for pattern, by in pairs:
        text, count = re.subn(pattern, lambda match, by=by: match.expand(by), text, count=1, flags=re.S | re.M)
        assert count, f"nothing of {name} matches {pattern!r}"
    files[name] = text.encode()


def old_param(files: Files) -> Files:
    """The tables of 2021: a named guard, crtp.h in angles, no param_logic.h, read-only rows."""
    files = dict(files)
    prototypes = files.pop(f"{INTERFACE}/param_logic.h").decode()
    api = re.search(r"typedef struct paramVarId_s.*?void +paramSetFloat\(.*?\);\n", prototypes, flags=re.S).group(0)
    api = re.sub(r"^void paramLogic\w*\(\);\n", "", api, flags=re.M)
    persistent = "#define PARAM_ADD_PERSISTENT(TYPE, NAME, ADDRESS, CALLBACK) \\\\\n"
    _edit(
        files,
        f"{INTERFACE}/param.h",
        (
            r"^#pragma once\n\n#include <stdint.h>\n\n#include \"param_logic.h\"\n",
            "#ifndef __PARAM_H__\n"
            "#define __PARAM_H__\n\n// clang-format off\n#include <stdbool.h>\n#include <stdint.h>\n#include <crtp.h>\n"
            "// clang-format on\n\nvoid paramInit(void);\nbool paramTest(void);\n\n" + api,
        ),
        (
            r"^#define PARAM_ADD_GROUP",
            f"{persistent}  PARAM_ADD_FULL(TYPE | PARAM_PERSISTENT, NAME, ADDRESS, CALLBACK, 0)\n\n\\g<0>",
        ),
        (r"^  static struct param_s __params_", "  static const struct param_s __params_"),
        (r"\Z", "\n#endif /* __PARAM_H__ */\n"),
    )
    return files


OWN_HEADER = """// A header of a fork. Its neighbour is found before any folder of the command line.
#ifndef MY_CONTROLLER_H
#define MY_CONTROLLER_H
#include "stabilizer_types.h"
#include "log.h"

void controllerMineInit(void);
bool controllerMineTest(void);
void controllerMine(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                    const state_t *state, const stabilizerStep_t stabilizerStep);
#endif
"""
OWN_SOURCE = """// Régulateur à moi: ne fait rien, et le compte. 制御
#include "my_controller.h"
#include "param.h"
#include "debug.h"

#define DEBUG_MODULE "MINE"

static uint32_t calls;
static float gain = 1.0f;

void controllerMineInit(void)
{
\tcalls = 0;
\tDEBUG_PRINT("ready, %u calls\\n", (unsigned)calls);
}

bool controllerMineTest(void)
{
\treturn true;
}

void controllerMine(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
\t\tconst state_t *state, const stabilizerStep_t stabilizerStep)
{
\t(void)sensors;\t(void)state;\t(void)stabilizerStep;
\tcalls++;
\tcontrol->controlMode = controlModeLegacy;
\tcontrol->thrust = gain * setpoint->thrust + setpoint->myFeedForward[2];
\tcontrol->roll = control->pitch = control->yaw = 0;
}

LOG_GROUP_START(mine)
LOG_ADD(LOG_UINT32, calls, &calls)
LOG_GROUP_STOP(mine)

PARAM_GROUP_START(mine)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, gain, &gain)
PARAM_GROUP_STOP(mine)"""


def fork_edits(files: Files) -> Files:
    """A controller of one's own, and what editors leave behind.

    Tabs, ends of lines of another system, no newline at the end of a file, comments in other letters; a member in the
    middle of the setpoint, a controller between those that are there, sources with comments behind them in the list.
    """
    files = dict(files)
    files[f"{INTERFACE}/my_controller.h"] = OWN_HEADER.encode()
    files[f"{MODULES}/controller/controller_mine.c"] = OWN_SOURCE.encode()  # ends without a newline
    _edit(
        files,
        f"{INTERFACE}/stabilizer_types.h",
        (r"^  velocity_t +velocity; [^\n]*\n(?=  acc_t +acceleration;)", "\\g<0>\tfloat myFeedForward[3]; // à moi\n"),
        (r"^\} setpoint_t;", "\tuint8_t myFlags : 3;\n\\g<0>"),
    )
    _edit(
        files,
        f"{INTERFACE}/controller/controller.h",
        (r"^  ControllerTypeMellinger,\n", "\\g<0>\tControllerTypeMine, // entre les autres\n"),
    )
    table = f"{MODULES}/controller/controller.c"
    if table in files:
        _add_to_table(files, table)
    for name in ("bindings/setup.py", "cffirmware_setup.py"):
        tdoa = r'^(\s*)"src/modules/src/kalman_core/mm_tdoa\.c",\n'
        pose = '\\g<0>\\1"src/modules/src/kalman_core/mm_pose.c",  # for the motion capture\n'
        last = r'^(\s*)"src/modules/src/outlierfilter/outlierFilterTdoa\.c",\n'
        models = (
            "kalman_core/mm_tof.c",
            "kalman_core/mm_flow.c",
            "kalman_core/mm_distance.c",
            "controller/controller_mine.c",
        )
        behind = "\\g<0>" + "".join(f'\\1"src/modules/src/{model}",  # added, "{model}"\n' for model in models)
        _edit(files, name, (tdoa, pose), (last, behind))
    # ends of lines of another system, in a source and in a header that is included by all
    for name in (f"{MODULES}/planner.c", f"{INTERFACE}/stabilizer_types.h", f"{INTERFACE}/log.h"):
        files[name] = files[name].replace(b"\n", b"\r\n")
    for name in ("src/utils/src/num.c", f"{INTERFACE}/planner.h"):
        files[name] = files[name].rstrip(b"\n")
    # letters of an older encoding, which are no UTF-8
    pid = f"{MODULES}/controller/position_controller_pid.c"
    files[pid] = b"// R\xe9gulateur de position\n" + files[pid]
    return files


def _add_to_table(files: Files, table: str) -> None:
    """Puts the controller behind that of Mellinger, in the form of its row."""
    text = files[table].decode()
    row = re.search(r"^[ \t]*\{[^{}]*controllerMellingerFirmwareInit.*?\},?[ \t]*\n", text, flags=re.S | re.M)
    if row is None:
        return
    mine = row.group(0).replace("controllerMellingerFirmware", "controllerMine").replace('"Mellinger"', '"Mine"')
    mine = re.sub(r"controllerMine(Enter|Exit)PreciseLanding", "0", mine)
    text = text[: row.end()] + mine + text[row.end() :]
    text = text.replace('#include "controller.h"\n', '#include "controller.h"\n#include "my_controller.h"\n', 1)
    files[table] = text.encode()


SIMULATED_HEADER = '#ifndef {guard}\n#define {guard}\n#error "this folder is for the simulation port only"\n#endif\n'
SIMULATED = ("config.h", "FreeRTOSConfig.h", "stm32fxxx.h", "trace.h")


def simulation_port(files: Files) -> Files:
    """A port to a simulator: a platform more, and a folder with headers of names that are there already."""
    files = dict(files)
    for name in SIMULATED:
        guard = f"SIM_{name.upper().replace('.', '_')}"
        files[f"src/config/sim/{name}"] = SIMULATED_HEADER.format(guard=guard).encode()
    files["src/platform/interface/platform_defaults_sim.h"] = files[
        "src/platform/interface/platform_defaults_bolt.h"
    ].replace(b"two cells", b"no cell")
    files["configs/sim_defconfig"] = b"CONFIG_PLATFORM_SIM=y\n"
    files[f"{MODULES}/power_distribution_quadrotor_sim.c"] = b'#error "a twin for the simulation port"\n'
    files["src/hal/src/sensors_sim.c"] = b'#error "a twin for the simulation port"\n'
    _edit(
        files,
        "src/platform/interface/platform_defaults.h",
        (
            r"^#ifdef CONFIG_PLATFORM_BOLT",
            '#ifdef CONFIG_PLATFORM_SIM\n#include "platform_defaults_sim.h"\n#endif\n\\g<0>',
        ),
    )
    _edit(
        files,
        "Kconfig",
        (r"^config PLATFORM_TAG", 'config PLATFORM_SIM\n    bool "Simulation"\n\n\\g<0>'),
    )
    return files


FORKS: dict[str, Callable[[Files], Files]] = {
    "old_param": old_param,
    "fork_edits": fork_edits,
    "simulation_port": simulation_port,
}
