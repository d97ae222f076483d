"""Files of the miniature checkout that are made from our own.

Where an algorithm of ours has the functions of upstream's file already, a copy would say nothing new. What is changed
here is its shape: names of headers, state at file scope where upstream has it, macros for parameters and logs.
"""

import re
from collections.abc import Callable
from pathlib import Path

BINDINGS = Path(__file__).parents[3] / "bindings"
TAILS = Path(__file__).parent / "tails"

# headers of ours that no checkout has, whose few inline functions move into the file that includes them
INLINED = {"convert.h": "convert.h", "builtin/control/cap_angle.h": "builtin/control/cap_angle.h"}
DROPPED = re.compile(r'"(variable_row|variables|platform|status|builtin/.*)(\.h)?"')


def _ours(name: str) -> str:
    return (BINDINGS / name).read_text()


def _included(match: re.Match) -> str:
    name = match.group(1)
    if name in INLINED:
        return _ours(INLINED[name])
    if DROPPED.fullmatch(f'"{name}"'):
        return ""
    return f'#include "{name.removeprefix("api/")}"\n'


def source(*names: str) -> str:
    """Sources or headers of ours in one file, including what upstream's files are called."""
    return re.sub(r'#include "(.+?)"\n', _included, "".join(_ours(name) for name in names))


def replaced(text: str, *pairs: tuple[str, str]) -> str:
    """Replaces each pattern, which must occur: ours have changed where it does not."""
    for pattern, by in pairs:
        text, count = re.subn(pattern, lambda match, by=by: match.expand(by), text, flags=re.S | re.M)
        assert count, f"nothing matches {pattern!r}"
    return text


def without_tables(text: str, tail: str) -> str:
    """The same with PARAM_* and LOG_* macros, from a file of tails/, in place of our tables."""
    body = re.split(r"^#define (?:PARAMETER|ROW|LOG)\(", text, maxsplit=1, flags=re.M)[0]
    return body + (TAILS / tail).read_text()


def _struct(header: str, first: str, last: str) -> str:
    return re.search(rf"^{first} \{{.*^\}} {last};$", _ours(header), flags=re.S | re.M).group(0) + "\n\n"


def _includes(*names: str) -> str:
    """Include lines, in this order: a name in angles stays as it is."""
    lines = [f"#include {name}" if name.startswith("<") else f'#include "{name}"' for name in names]
    return "".join(f"{line}\n" for line in ["// clang-format off", *lines, "// clang-format on", ""]) if names else ""


def header(name: str, guard: str | None, *includes: str) -> str:
    """A header of ours with the guard and the includes of the checkout's; no guard: `#pragma once`, first of all."""
    comment, _, rest = _ours(f"api/{name}.h").partition("#ifndef ")
    own, _, body = rest.partition("\n")
    body, _, _ = body.removeprefix(f"#define {own}\n").rpartition("#endif")
    body = _includes(*includes) + re.sub(r"^#include.*\n", "", body, flags=re.M).lstrip("\n")
    if guard is None:
        return f"#pragma once\n\n{comment}\n{body}".rstrip("\n") + "\n"
    return f"{comment}#ifndef {guard}\n#define {guard}\n\n{body}".rstrip("\n") + f"\n\n#endif  // {guard}\n"


def with_tail(text: str, tail: str) -> str:
    """Puts declarations behind those of a header."""
    if match := re.search(r"\n#endif  // \w+\n\Z", text):
        return text[: match.start()] + f"\n{tail}" + match.group(0)
    return f"{text}\n{tail}"


def since(number: int, text: str) -> str:
    return f"#if MINIATURE_RELEASE >= {number}\n{text.rstrip()}\n#endif\n"


# ------------------------------------------------------------------------------------------------- precise landing

# Said after release 2026.08: the table of controllers has functions that enter and leave a mode of precise landing. The
# names are not established. Those below are ours: each controller has a pair beside its init, without arguments.
PRECISE_LANDING = ("Enter", "Exit")


def precise_landing_prototypes(controller: str) -> str:
    return since(
        202609, "".join(f"void controller{controller}{what}PreciseLanding(void);\n" for what in PRECISE_LANDING)
    )


def precise_landing(controller: str) -> str:
    enter, leave = (f"void controller{controller}{what}PreciseLanding(void)" for what in PRECISE_LANDING)
    return since(
        202609,
        f"static bool isPreciseLanding;\n\n{enter} {{\n  isPreciseLanding = true;\n}}\n\n"
        f"{leave} {{\n  isPreciseLanding = false;\n}}\n",
    )


def with_precise_landing(text: str, name: str) -> str:
    """Replaces the mark of a file that is kept as it is."""
    make = precise_landing_prototypes if name.endswith(".h") else precise_landing
    return re.sub(r"^// PRECISE_LANDING (\w+)\n", lambda match: make(match.group(1)), text, flags=re.M)


# ---------------------------------------------------------------------------------------------------------- headers


def imu_types() -> str:
    axes = r"typedef struct \{\n  (\w+) x;\n  \w+ y;\n  \w+ z;\n\} (\w+);"
    union = r"typedef union {\n  struct {\n    \1 x;\n    \1 y;\n    \1 z;\n  };\n  \1 axis[3];\n} \2;"
    return replaced(header("imu_types", "IMU_TYPES_H_"), (axes, union))


ARRAYS = "typedef float vec3d[3];\ntypedef float mat3d[3][3];\n"


def lighthouse_types() -> str:
    text = header("lighthouse_types", None)
    assert ARRAYS in text
    return replaced(text.replace(ARRAYS, ""), (r"^typedef struct \{", "typedef struct __attribute__((packed)) {"))


def stabilizer_types() -> str:
    includes = ("<stdint.h>", "<stdbool.h>", "imu_types.h", "lighthouse_types.h")
    text = replaced(
        header("stabilizer_types", "__STABILIZER_TYPES_H__", *includes),
        (r"^  jerk_t +jerk;.*?$", "#if MINIATURE_RELEASE >= 202512\n\\g<0>\n#endif"),
        (r"^typedef struct vec3_s jerk_t;.*?$", "#if MINIATURE_RELEASE >= 202512\n\\g<0>\n#endif"),
        (r"^  float +coneHalfAngle;.*?$", "#if MINIATURE_RELEASE >= 202608\n\\g<0>\n#endif"),
        (r"^  controlModePWM +=.*?$", "#if MINIATURE_RELEASE >= 202608\n\\g<0>\n#endif"),
        (
            r"^#define RATE_SUPERVISOR .*?$",
            r"\g<0>\n#define RATE_DO_EXECUTE(RATE_HZ, TICK) \\\n"
            r"  ((TICK % (RATE_MAIN_LOOP / RATE_HZ)) == 0)",
        ),
        (
            r"^typedef struct attitude_s",
            "#define vec3d_size 3\ntypedef float vec3d[vec3d_size];\n"
            "typedef float mat3d[vec3d_size][vec3d_size];\n\n\\g<0>",
        ),
        (
            r"^  uint64_t interruptTimestamp;.*?$",
            "\\g<0>\n#ifdef LOG_SEC_IMU\n  Axis3f accSec;\n  Axis3f gyroSec;\n#endif",
        ),
    )
    # the type of the modes has had a name since 2026 only
    named = re.search(r"^typedef struct \{(?:(?!^typedef).)*?^\} setpoint_mode_t;\n", text, flags=re.S | re.M).group(0)
    anonymous = named.replace("typedef struct", "  struct").replace("} setpoint_mode_t;", "  } mode;")
    text = text.replace(named, f"#if MINIATURE_RELEASE >= 202608\n{named}#endif\n")
    member = re.search(r"^  setpoint_mode_t mode;\n", text, flags=re.M).group(0)
    return text.replace(member, f"#if MINIATURE_RELEASE >= 202608\n{member}#else\n{anonymous}#endif\n")


def num_header() -> str:
    return header("num", "__NUM_H", "<stdint.h>")


def filter_header() -> str:
    return header("filter", "FILTER_H_", "<stdint.h>", "math.h")


RESET = r"^void pidReset\(PidObject \*pid, float initial\)"


def _reset_without_value(text: str, end: str) -> str:
    """In the oldest release a reset says nothing of the measurement."""
    newer = re.search(RESET + end, text, flags=re.S | re.M).group(0)
    older = newer.replace(", float initial", "").replace("= initial", "= 0.0f")
    return text.replace(newer, f"#if MINIATURE_RELEASE >= 202502\n{newer}\n#else\n{older}\n#endif")


def pid_header() -> str:
    return _reset_without_value(header("pid", "PID_H_", "<stdbool.h>", "filter.h"), ";")


def estimator(tree_text: str) -> str:
    types = re.search(r"typedef enum \{.*\} measurement_t;\n", _ours("api/measurement.h"), flags=re.S).group(0)
    return tree_text.replace("// MEASUREMENT_TYPES\n", types)


CLOSE_ULPS = """
bool fcloseulps(float a, float b, int ulps) {
  if ((a < 0.0f) != (b < 0.0f)) {
    return a == b;
  }
  int apart = *((int const *)&a) - *((int const *)&b);
  return abs(apart) <= ulps;
}
"""
PI_OF_MATH3D = r"^#define M_PI_F [^\n]*\n#define M_1_PI_F [^\n]*\n#define M_PI_2_F [^\n]*\n"


def math3d() -> str:
    """Inline functions, in an order in which all are declared before they are used.

    As upstream's it takes the bits of a number through a pointer, and abs() without the header that declares it.
    """
    files = ("math3d", "math3d_vectors", "math3d_matrices", "math3d_quaternions", "math3d_convex")
    bodies = "".join(re.sub(r"^#include.*\n", "", _ours(f"builtin/math/{name}.c"), flags=re.M) for name in files)
    bodies = replaced(
        bodies,
        (r"^static int64_t bits_of\(.*?^\}\n\n", ""),
        (r"^bool fcloseulps\(.*?^\}\n", CLOSE_ULPS.replace("\\", r"\\")),
        (r"^static (?!inline)", "static inline "),
    )
    declarations = header("math3d", None, "<math.h>", "<stdbool.h>", "<stddef.h>")
    vec = re.sub(r".*?(struct vec \{.*?\};).*", r"\1\n\n", _ours("api/vec.h"), flags=re.S)
    declarations = replaced(
        declarations,
        (
            PI_OF_MATH3D,
            f"#ifdef CMATH3D_ASSERTS\n#include <assert.h>\n#endif\n\n#ifndef M_PI_F\n\\g<0>#endif\n\n{vec.rstrip()}\n",
        ),
    )
    inline = r"^((?:struct (?:vec|mat33|quat)|float|bool|void) +\*?\w+\([^;{]*?\) ?[;{])"
    return re.sub(inline, r"static inline \1", declarations + bodies, flags=re.M)


OLD_RATES = "struct vec rates;  // [rad/s], body rates; what it was called is not established"


def pptraj_header() -> str:
    omega = r"^  struct vec omega;.*?$"
    return replaced(
        header("pptraj", None, "math3d.h"),
        (r"^(struct poly4d \{.*?)^\};", r"\1} __attribute__((packed));"),
        (r"^  struct vec jerk;.*?$", "#if MINIATURE_RELEASE >= 202502\n\\g<0>\n#endif"),
        (omega, f"#if MINIATURE_RELEASE >= 202502\n\\g<0>\n#else\n  {OLD_RATES}\n#endif"),
        (r"^  float +shift_yaw;.*?$", "#if MINIATURE_RELEASE >= 202608\n\\g<0>\n#endif"),
        (r"const struct poly4d \*pieces;", "struct poly4d *pieces;"),
        (r"(void piecewise_plan_\w+\()struct poly4d \*piece,", r"\1struct piecewise_traj *pp,"),
    )


def _rates(text: str) -> str:
    """The same, with the other name of the body rates in the oldest release."""
    lines = []
    for line in text.splitlines():
        older = re.sub(r"\bomega\b(?= +=|\.|,)", "rates", line) if re.search(r"(->|\.)omega\b", line) else line
        lines += [line] if older == line else ["#if MINIATURE_RELEASE >= 202502", line, "#else", older, "#endif"]
    return "\n".join(lines) + "\n"


def pptraj() -> str:
    text = source(
        "builtin/planning/pptraj_polynomials.c", "builtin/planning/pptraj_pieces.c", "builtin/planning/pptraj.c"
    )
    set_up = """  struct poly4d *piece = &pp->pieces[0];
  pp->timescale        = 1.0f;
  pp->shift            = vzero();
  pp->n_pieces         = 1;
"""
    text = replaced(
        text,
        (r"(void piecewise_plan_\w+\()struct poly4d \*piece,(.*?\) \{\n)", rf"\1struct piecewise_traj *pp,\2{set_up}"),
        (r"^  out\.jerk = (.*?);$", "#if MINIATURE_RELEASE >= 202502\n\\g<0>\n#endif"),
        (r"out\.acc, out\.jerk,", "out.acc, polyval_xyz(&derivative, t),"),
        (r"^  ev->jerk  = vzero\(\);$", "#if MINIATURE_RELEASE >= 202502\n\\g<0>\n#endif"),
        (
            r"^  traj_eval_transform\(&ev, traj->shift, traj->shift_yaw\);$|"
            r"^      traj_eval_transform\(&ev, traj->shift, traj->shift_yaw\);$",
            "#if MINIATURE_RELEASE >= 202608\n\\g<0>\n#else\n  ev.pos = vadd(ev.pos, traj->shift);\n#endif",
        ),
    )
    return _rates(text)


# entry points for the vehicle, which only its build declares
FIRMWARE_ENTRIES = """#ifdef CRAZYFLIE_FW
void controller{0}FirmwareInit(void);
bool controller{0}FirmwareTest(void);
void controller{0}Firmware(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                           const state_t *state, const stabilizerStep_t stabilizerStep);
{1}#endif
"""


def _firmware_entries(controller: str) -> str:
    return FIRMWARE_ENTRIES.format(controller, precise_landing_prototypes(f"{controller}Firmware"))


def controller_mellinger_header() -> str:
    text = header("controller_mellinger", "__CONTROLLER_MELLINGER_H__", "stabilizer_types.h", "math3d.h")
    return with_tail(text, _firmware_entries("Mellinger"))


def controller_lee_header() -> str:
    # a file that includes this has included math3d.h before
    text = replaced(
        header("controller_lee", "__CONTROLLER_LEE_H__", "stabilizer_types.h"),
        (r"^\n  // not in upstream's struct.*?max_thrust;.*?$", ""),
    )
    return with_tail(text, _firmware_entries("Lee"))


def _structs(header_name: str, first: str, last: str) -> str:
    """From the head of one struct to the end of another."""
    return re.search(
        rf"^struct {first} \{{.*?^struct {last} \{{.*?^\}};\n", _ours(header_name), flags=re.S | re.M
    ).group(0)


INDI_INCLUDES = ("stabilizer_types.h", "filter.h", "math3d.h", "log.h", "param.h")
INDI_CONTROL = """void controllerINDIInit(void);
bool controllerINDITest(void);
void controllerINDI(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                    const state_t *state, const stabilizerStep_t stabilizerStep);
"""
INDI_POSITION = """void positionControllerINDIInit(void);
void positionControllerINDI(const sensorData_t *sensors, const setpoint_t *setpoint,
                            const state_t *state, vector_t *refOuterINDI);
"""


def controller_indi_header() -> str:
    """One of a pair of headers that include each other."""
    includes = ("position_controller.h", "attitude_controller.h", "position_controller_indi.h")
    text = f"""#ifndef __CONTROLLER_INDI_H__
#define __CONTROLLER_INDI_H__

{_includes(*INDI_INCLUDES, *includes)}
#define ATTITUDE_UPDATE_DT (float)(1.0f / ATTITUDE_RATE)

{_structs("api/controller_indi.h", "FloatRates", "IndiVariables")}
{INDI_CONTROL}
#endif  // __CONTROLLER_INDI_H__
"""
    return with_tail(text, precise_landing_prototypes("INDI"))


def position_controller_indi_header() -> str:
    return f"""#ifndef __POSITION_CONTROLLER_INDI_H__
#define __POSITION_CONTROLLER_INDI_H__

#define MIN_THRUST 0
#define MAX_THRUST 60000

{_includes("controller_indi.h", *INDI_INCLUDES)}
{_structs("api/position_controller_indi.h", "Vectr", "IndiOuterVariables")}
{INDI_POSITION}
#endif  // __POSITION_CONTROLLER_INDI_H__
"""


# ------------------------------------------------------------------------------------------------------ controllers

INITIALIZER = r"^cf_status_t cf_controller_\w+\(.*?= \(\w+\)(\{.*?^  \};)\n  return CF_OK;\n\}\n"


def controller_mellinger() -> str:
    text = replaced(
        source("builtin/control/controller_mellinger.c"),
        (INITIALIZER, r"static controllerMellinger_t g_self = \1" + "\n"),
        (r"facts->mass", "CF_MASS"),
        (
            r"  cf_controller_mellinger_init\(self, CF_PLATFORM_CF2\);",
            "  *self = g_self;\n  controllerMellingerReset(self);",
        ),
        (r"is_manual\(const setpoint_mode_t \*mode\)", "is_manual(const setpoint_t *setpoint)"),
        (r"mode->(\w+) == ", r"setpoint->mode.\1 == "),
        (r"is_manual\(&setpoint->mode\)", "is_manual(setpoint)"),
        (r"^#include <math.h>\n+#include <stddef.h>\n", ""),
        (r"^void controllerMellingerInit", "void controllerMellingerReset(controllerMellinger_t *self);\n\n\\g<0>"),
    )
    includes = _includes(
        "<math.h>",
        "param.h",
        "log.h",
        "position_controller.h",
        "controller_mellinger.h",
        "physicalConstants.h",
        "platform_defaults.h",
    )
    return includes + without_tables(text, "controller_mellinger.c")


def controller_lee() -> str:
    text = replaced(
        source("builtin/control/controller_lee.c"),
        (INITIALIZER, r"static controllerLee_t g_self = \1" + "\n"),
        (r"facts->mass", "CF_MASS"),
        (r"^ *\.max_thrust .*?,\n", ""),
        (r"self->max_thrust", "powerDistributionGetMaxThrust()"),
        (r"^ *const setpoint_mode_t +\*mode += &setpoint->mode;\n", ""),
        (r"\bmode->(\w+) == ", r"setpoint->mode.\1 == "),
        (r"  cf_controller_lee_init\(self, CF_PLATFORM_CF2\);", "  *self = g_self;\n  controllerLeeReset(self);"),
        (r"^#include <math.h>\n+#include <stddef.h>\n", ""),
    )
    includes = _includes(
        "<math.h>",
        "<string.h>",
        "math3d.h",
        "controller_lee.h",
        "physicalConstants.h",
        "power_distribution.h",
        "platform_defaults.h",
    )
    return includes + without_tables(text, "controller_lee.c")


def controller_brescianini() -> str:
    struct = _struct("api/controller_brescianini.h", "typedef struct", "controllerBrescianini_t")
    text = replaced(
        source("builtin/control/controller_brescianini.c"),
        (INITIALIZER, r"static controllerBrescianini_t self = \1" + "\n"),
        (r"facts->mass", "CF_MASS"),
        (r"^void controllerBrescianiniInit\(.*?\) \{.*?^\}\n", ""),
        (r"^bool controllerBrescianiniTest\(.*?\) \{.*?^\}\n", ""),
        (
            r"^void controllerBrescianini\(controllerBrescianini_t \*self",
            "static void update(controllerBrescianini_t *self",
        ),
        (r'^#include <math.h>\n+#include <stddef.h>\n+#include "math3d.h"\n#include "num.h"\n', struct),
    )
    includes = _includes(
        "controller_brescianini.h",
        "log.h",
        "param.h",
        "num.h",
        "math3d.h",
        "physicalConstants.h",
        "platform_defaults.h",
    )
    return includes + without_tables(text, "controller_brescianini.c")


def _typedef(header_name: str, last: str) -> str:
    return re.search(
        rf"^typedef struct \{{(?:(?!^typedef).)*?^\}} {last};\n", _ours(header_name), flags=re.S | re.M
    ).group(0)


INDI_RESETS = """#if MINIATURE_RELEASE >= 202502
#define RESET_ALL(at) attitudeControllerResetAllPID(at.roll, at.pitch, at.yaw)
#define RESET_ROLL(at) attitudeControllerResetRollAttitudePID(at)
#define RESET_PITCH(at) attitudeControllerResetPitchAttitudePID(at)
#else
#define RESET_ALL(at) attitudeControllerResetAllPID()
#define RESET_ROLL(at) attitudeControllerResetRollAttitudePID()
#define RESET_PITCH(at) attitudeControllerResetPitchAttitudePID()
#endif

"""


def controller_indi() -> str:
    types = _typedef("api/controller_indi.h", "controllerINDI_t").replace("positionControllerINDI_t position;\n", "\n")
    text = replaced(
        source("builtin/control/controller_indi.c"),
        (
            r"^void cf_controller_indi_boot\(.*?= \(controllerINDI_t\)(\{.*?^  \};).*?^\}\n",
            r"static controllerINDI_t self = \1" + "\n",
        ),
        (r"^void indi_init_filters\(controllerINDI_t \*self\)", "static void init_filters(controllerINDI_t *self)"),
        (r"^void controllerINDIInit\(.*?^\}\n", ""),
        (r"^bool controllerINDITest\(.*?^\}\n", ""),
        (
            r"^void controllerINDI\(controllerINDI_t \*self, struct cf_controller_pid \*pid, ",
            "static void update(controllerINDI_t *self, ",
        ),
        (r"cf_controller_pid_t \*pid,\s*", ""),
        (r"\(self, pid, ", "(self, "),
        (r"positionControllerINDI\(&self->position, ", "positionControllerINDI("),
        (r"cf_position_controller_update\(&pid->position, ", "positionController("),
        (r"cf_attitude_controller_reset_roll\(&pid->attitude, ", "RESET_ROLL("),
        (r"cf_attitude_controller_reset_pitch\(&pid->attitude, ", "RESET_PITCH("),
        (r"cf_attitude_controller_reset\(&pid->attitude, &state->attitude\)", "RESET_ALL(state->attitude)"),
        (
            r"^  cf_position_controller_reset\(&pid->position, at->x, at->y, at->z\);$",
            "#if MINIATURE_RELEASE >= 202502\n  positionControllerResetAllPID(at->x, at->y, at->z);\n"
            "#else\n  (void)at;\n  positionControllerResetAllPID();\n#endif",
        ),
        (r'^#include <math.h>\n+#include <stddef.h>\n+#include "math3d.h"\n', INDI_RESETS + types),
    )
    text = text.replace('#include "controller_indi.h"\n', "")
    includes = _includes("controller_indi.h", "num.h")
    return includes + without_tables(text, "controller_indi.c")


def position_controller_indi() -> str:
    types = _typedef("api/position_controller_indi.h", "positionControllerINDI_t")
    text = replaced(
        source("builtin/control/position_controller_indi.c"),
        (
            r"^void cf_position_controller_indi_boot\(.*?= \(positionControllerINDI_t\)(\{.*?^  \};).*?^\}\n",
            r"static positionControllerINDI_t self = \1" + "\n",
        ),
        (
            r"^void positionControllerINDIInit\(positionControllerINDI_t \*self\)",
            "static void init(positionControllerINDI_t *self)",
        ),
        (
            r"^void positionControllerINDI\(positionControllerINDI_t \*self, ",
            "static void update(positionControllerINDI_t *self, ",
        ),
        (r'^#include "math3d.h"\n', types),
        (r"^#define LARGEST_THRUST 60000\.0f.*?$", "#define LARGEST_THRUST ((float)MAX_THRUST)"),
    )
    includes = _includes("position_controller_indi.h", "num.h")
    return includes + without_tables(text, "position_controller_indi.c")


# ------------------------------------------------------------------------------------------------------- everything


def collision_avoidance_header() -> str:
    text = header("collision_avoidance", "__COLLISION_AVOIDANCE_H__", "math3d.h", "stabilizer_types.h")
    return with_tail(
        text,
        """#ifdef CRAZYFLIE_FW
void collisionAvoidanceInit(void);
bool collisionAvoidanceTest(void);
void collisionAvoidanceUpdateSetpoint(setpoint_t *setpoint, const sensorData_t *sensorData,
                                      const state_t *state, stabilizerStep_t stabilizerStep);
#endif
""",
    )


def collision_avoidance() -> str:
    text = source("builtin/planning/collision_avoidance.c")
    body = re.sub(r"^#include.*\n", "", text.partition("// ---")[0], flags=re.M).lstrip("\n")
    includes = _includes("<float.h>", "<string.h>", "collision_avoidance.h", "peer_localization.h")
    return f"{includes}\n{body}{(TAILS / 'collision_avoidance.c').read_text()}"


# an initial value of one constant that is made from another: what a compiler may refuse
TDOA_SIZES = """static const float INTEGRATOR_SIZE = 300.0f;  // [ms]
static const float INTEGRATOR_FORCE_OPEN_LEVEL = INTEGRATOR_SIZE * 0.1f;
static const float INTEGRATOR_RESUME_ACTION_LEVEL = INTEGRATOR_SIZE * 0.9f;
"""


def outlier_filter_tdoa() -> str:
    text = replaced(
        source("builtin/kalman/outlier_filter_tdoa.c"),
        (r"^#include <math.h>\n+", ""),
        (
            r"^#define INTEGRATOR_SIZE 300\.0f .*?\n#define INTEGRATOR_RESUME 270\.0f .*?\n"
            r"#define INTEGRATOR_FORCE_OPEN 30\.0f .*?\n",
            TDOA_SIZES,
        ),
        (r"\bINTEGRATOR_RESUME\b", "INTEGRATOR_RESUME_ACTION_LEVEL"),
        (r"\bINTEGRATOR_FORCE_OPEN\b", "INTEGRATOR_FORCE_OPEN_LEVEL"),
        (r"^bool cf_tdoa_is_possible", "static bool cf_tdoa_is_possible"),
    )
    log = '#if CONFIG_DEBUG_TDOA_QUALITY\n#include "log.h"\n#endif\n'
    return _includes("<math.h>", "autoconf.h", "outlierFilterTdoa.h", "stabilizer_types.h") + log + "\n" + text


def outlier_filter_tdoa_header() -> str:
    text = header("outlierFilterTdoa", None, "stabilizer_types.h")
    return re.sub(r"^// The deprecated gate.*\Z", "", text, flags=re.M | re.S).rstrip("\n") + "\n"


def outlier_filter_lighthouse() -> str:
    return source("builtin/kalman/outlier_filter_lighthouse.c").replace("openingWindowMs", WINDOW)


WINDOW = "LH_WINDOW"  # what the member is called depends on the release


def _window(text: str) -> str:
    lines = []
    for line in text.splitlines():
        newer, older = line.replace(WINDOW, "openingWindowMs"), line.replace(WINDOW, "validUntilMs")
        lines += [line] if WINDOW not in line else ["#if MINIATURE_RELEASE >= 202502", newer, "#else", older, "#endif"]
    return "\n".join(lines) + "\n"


def outlier_filter_lighthouse_header() -> str:
    text = header("outlierFilterLighthouse", None, "stabilizer_types.h")
    return _window(re.sub(r"\bopeningWindowMs(?=;)", WINDOW, text))


def filter_source() -> str:
    """With a constant of its own, which is not that of math3d.h letter by letter."""
    text = replaced(
        source("builtin/math/filter.c"),
        (r"^#include <math.h>\n#include <stddef.h>\n", ""),
        (r"\A.*?(?=^#define)", ""),
        (r"^#define PI_F .*?$", "#define M_PI_F (float)M_PI"),
        (r"\bPI_F\b(?<!M_PI_F)", "M_PI_F"),
    )
    return f"{_includes('<math.h>', '<stdlib.h>', 'filter.h')}\n{text}"


FILTER_ALL = "#if CONFIG_CONTROLLER_PID_FILTER_ALL\n{}\n#else\n{}\n#endif"


def pid_source() -> str:
    """A symbol of the configuration decides what is filtered, and nothing here includes the configuration."""
    text = replaced(
        source("builtin/math/pid.c"),
        (r"\A.*?(?=^#define)", ""),
        (
            r"^  const float deriv = (pid->enableDFilter \? .*?);$",
            FILTER_ALL.format("  const float deriv = rate;", r"\g<0>"),
        ),
        (
            r"^  if \(pid->outputLimit != 0\.0f\) \{$",
            "#if CONFIG_CONTROLLER_PID_FILTER_ALL\n  if (pid->enableDFilter) {\n"
            "    output = lpf2pApply(&pid->dFilter, output);\n  }\n#endif\n\\g<0>",
        ),
    )
    return _includes("pid.h", "num.h", "<math.h>", "<float.h>") + "\n" + _reset_without_value(text, r" \{.*?^\}")


def num_source() -> str:
    """Without headers but the types: bits through pointers, and a difference that wraps."""
    return replaced(
        source("builtin/math/num.c"),
        (r"\A.*?(?=^#define)", _includes("num.h", "<stdint.h>") + "\n"),
        (r"^#define BIAS_DISTANCE 112u", "static const uint32_t e = 15 - 127;"),
        (r"exponent - BIAS_DISTANCE", "exponent + e"),
        (r"exponent \+ BIAS_DISTANCE", "exponent - e"),
        (r"\bisnan\(number\)", "number != number"),
        (r"\bfabsf\(value\)", "(value < 0.0f ? -value : value)"),
        (r"\bconst bool +negative", "const uint32_t negative"),
        (
            r"^  uint32_t bits;\n  memcpy\(&bits, &number, sizeof\(bits\)\);$",
            "  const uint32_t bits = *(uint32_t *)&number;",
        ),
        (
            r"^  float single;\n  memcpy\(&single, &bits, sizeof\(single\)\);\n  return single;$",
            "  return *(float *)&bits;",
        ),
    )


def axis3f_sub_sampler() -> str:
    text = source("builtin/math/axis3f_sub_sampler.c").partition("\n")[2]
    return _includes("<string.h>", "axis3fSubSampler.h") + text


def lighthouse_calibration() -> str:
    """Its header needs the types before it."""
    text = source("builtin/kalman/lighthouse_calibration.c")
    return re.sub(
        r'^#include "lighthouse_calibration.h"\n',
        _includes("<stdbool.h>", "<stdint.h>", "lighthouse_types.h", "lighthouse_calibration.h"),
        text,
        flags=re.M,
    )


def arm_common_tables() -> str:
    return replaced(
        _ours("builtin/math/sine_table.c"),
        (r'#include "builtin/math/sine_table.h"', '#include "arm_math.h"'),
        (r"const float CF_SINE_TABLE\[.*?\]", "const float32_t sinTable_f32[FAST_MATH_TABLE_SIZE + 1]"),
    )


MODULES = "src/modules/src"
INTERFACE = "src/modules/interface"
UTILS = "src/utils"

FILES: dict[str, Callable[[], str]] = {
    "src/hal/interface/imu_types.h": imu_types,
    f"{UTILS}/interface/lighthouse/lighthouse_types.h": lighthouse_types,
    f"{UTILS}/interface/lighthouse/lighthouse_calibration.h": lambda: header("lighthouse_calibration", None),
    f"{UTILS}/interface/num.h": num_header,
    f"{UTILS}/interface/filter.h": filter_header,
    f"{UTILS}/interface/pid.h": pid_header,
    f"{UTILS}/src/num.c": num_source,
    f"{UTILS}/src/filter.c": filter_source,
    f"{UTILS}/src/pid.c": pid_source,
    f"{UTILS}/src/lighthouse/lighthouse_calibration.c": lighthouse_calibration,
    f"{INTERFACE}/math3d.h": math3d,
    f"{INTERFACE}/stabilizer_types.h": stabilizer_types,
    f"{INTERFACE}/pptraj.h": pptraj_header,
    f"{INTERFACE}/collision_avoidance.h": collision_avoidance_header,
    f"{INTERFACE}/axis3fSubSampler.h": lambda: header("axis3fSubSampler", None, "<stdint.h>", "imu_types.h"),
    f"{INTERFACE}/outlierfilter/outlierFilterTdoa.h": outlier_filter_tdoa_header,
    f"{INTERFACE}/outlierfilter/outlierFilterLighthouse.h": outlier_filter_lighthouse_header,
    f"{INTERFACE}/controller/controller_mellinger.h": controller_mellinger_header,
    f"{INTERFACE}/controller/controller_lee.h": controller_lee_header,
    f"{INTERFACE}/controller/controller_indi.h": controller_indi_header,
    f"{INTERFACE}/controller/position_controller_indi.h": position_controller_indi_header,
    f"{MODULES}/pptraj.c": pptraj,
    f"{MODULES}/collision_avoidance.c": collision_avoidance,
    f"{MODULES}/axis3fSubSampler.c": axis3f_sub_sampler,
    f"{MODULES}/outlierfilter/outlierFilterTdoa.c": outlier_filter_tdoa,
    f"{MODULES}/outlierfilter/outlierFilterLighthouse.c": lambda: _window(outlier_filter_lighthouse()),
    f"{MODULES}/controller/controller_mellinger.c": controller_mellinger,
    f"{MODULES}/controller/controller_lee.c": controller_lee,
    f"{MODULES}/controller/controller_brescianini.c": controller_brescianini,
    f"{MODULES}/controller/controller_indi.c": controller_indi,
    f"{MODULES}/controller/position_controller_indi.c": position_controller_indi,
    "vendor/CMSIS/CMSIS/DSP/Source/CommonTables/arm_common_tables.c": arm_common_tables,
}
