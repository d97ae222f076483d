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
    return "".join(f'#include "{name}.h"\n' for name in names)


# ---------------------------------------------------------------------------------------------------------- headers


def stabilizer_types() -> str:
    text = replaced(
        source("api/stabilizer_types.h"),
        (r"^  jerk_t +jerk;.*?$", "#if MINIATURE_RELEASE >= 202608\n\\g<0>\n#endif"),
        (r"^typedef struct vec3_s jerk_t;.*?$", "#if MINIATURE_RELEASE >= 202608\n\\g<0>\n#endif"),
        (r"^  float +coneHalfAngle;.*?$", "#if MINIATURE_RELEASE >= 202608\n\\g<0>\n#endif"),
        (r"^  controlModePWM +=.*?$", "#if MINIATURE_RELEASE >= 202608\n\\g<0>\n#endif"),
        (r"^#define RATE_SUPERVISOR .*?$", "\\g<0>\n#define RATE_DO_EXECUTE(HZ, STEP) ((STEP) % (1000 / (HZ)) == 0)"),
    )
    # the type of the modes has had a name since 2026 only
    named = re.search(r"^typedef struct \{(?:(?!^typedef).)*?^\} setpoint_mode_t;\n", text, flags=re.S | re.M).group(0)
    anonymous = named.replace("typedef struct", "  struct").replace("} setpoint_mode_t;", "  } mode;")
    text = text.replace(named, f"#if MINIATURE_RELEASE >= 202608\n{named}#endif\n")
    member = re.search(r"^  setpoint_mode_t mode;\n", text, flags=re.M).group(0)
    return text.replace(member, f"#if MINIATURE_RELEASE >= 202608\n{member}#else\n{anonymous}#endif\n")


def lighthouse_types() -> str:
    return replaced(
        source("api/lighthouse_types.h"), (r"^typedef struct \{", "typedef struct __attribute__((packed)) {")
    )


def estimator(tree_text: str) -> str:
    types = re.search(r"typedef enum \{.*\} measurement_t;\n", _ours("api/measurement.h"), flags=re.S).group(0)
    return tree_text.replace("// MEASUREMENT_TYPES\n", types)


def math3d() -> str:
    """Inline functions, in an order in which all are declared before they are used."""
    files = ("math3d", "math3d_vectors", "math3d_matrices", "math3d_quaternions", "math3d_convex")
    bodies = "".join(re.sub(r"^#include.*\n", "", _ours(f"builtin/math/{name}.c"), flags=re.M) for name in files)
    header = replaced(
        _ours("api/math3d.h"),
        (r'#include "api/vec.h"\n', "#include <stddef.h>\n#include <stdint.h>\n#include <string.h>\n"),
        (
            r"^#define M_PI_F",
            re.sub(r".*?(struct vec \{.*?\};).*", r"\1\n\n", _ours("api/vec.h"), flags=re.S) + r"\g<0>",
        ),
    )
    declarations, _, _ = header.rpartition("#endif")
    inline = r"^((?:struct (?:vec|mat33|quat)|float|bool|void) +\*?\w+\([^;{]*?\) ?[;{])"
    return re.sub(inline, r"static inline \1", declarations + bodies, flags=re.M) + "#endif\n"


def pptraj_header() -> str:
    return replaced(
        source("api/pptraj.h"),
        (r'#include "vec.h"', '#include "math3d.h"'),
        (r"^(struct poly4d \{.*?)^\};", r"\1} __attribute__((packed));"),
        (r"^  struct vec jerk;.*?$", "#if MINIATURE_RELEASE >= 202502\n\\g<0>\n#endif"),
        (r"^  float +shift_yaw;.*?$", "#if MINIATURE_RELEASE >= 202608\n\\g<0>\n#endif"),
        (r"const struct poly4d \*pieces;", "struct poly4d *pieces;"),
        (r"(void piecewise_plan_\w+\()struct poly4d \*piece,", r"\1struct piecewise_traj *pp,"),
    )


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
    return text


def controller_mellinger_header() -> str:
    return replaced(
        source("api/controller_mellinger.h"),
        (
            r"^#endif  // CONTROLLER_MELLINGER_H",
            """#ifdef CRAZYFLIE_FW
void controllerMellingerFirmwareInit(void);
bool controllerMellingerFirmwareTest(void);
void controllerMellingerFirmware(control_t *control, const setpoint_t *setpoint,
                                 const sensorData_t *sensors, const state_t *state,
                                 const stabilizerStep_t stabilizerStep);
#endif

\\g<0>""",
        ),
    )


def controller_lee_header() -> str:
    return replaced(
        source("api/controller_lee.h"),
        (r'#include "math3d.h"\n', ""),  # whoever includes this has included it before
        (r"^\n  // not in upstream's struct.*?max_thrust;.*?$", ""),
        (
            r"^#endif  // CONTROLLER_LEE_H",
            """#ifdef CRAZYFLIE_FW
void controllerLeeFirmwareInit(void);
bool controllerLeeFirmwareTest(void);
void controllerLeeFirmware(control_t *control, const setpoint_t *setpoint,
                           const sensorData_t *sensors, const state_t *state, const uint32_t tick);
#endif

\\g<0>""",
        ),
    )


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
        (
            r"^#include <stddef.h>\n",
            '#include <stddef.h>\n#include "log.h"\n#include "param.h"\n#include "platform_defaults.h"\n',
        ),
        (r"^void controllerMellingerInit", "void controllerMellingerReset(controllerMellinger_t *self);\n\n\\g<0>"),
    )
    return '#include "controller_mellinger.h"\n' + without_tables(text, "controller_mellinger.c")


def controller_lee() -> str:
    text = replaced(
        source("builtin/control/controller_lee.c"),
        (INITIALIZER, r"static controllerLee_t g_self = \1" + "\n"),
        (r"facts->mass", "CF_MASS"),
        (r"^ *\.max_thrust .*?,\n", ""),
        (r"self->max_thrust", "powerDistributionGetMaxThrust()"),
        (r"  cf_controller_lee_init\(self, CF_PLATFORM_CF2\);", "  *self = g_self;\n  controllerLeeReset(self);"),
    )
    includes = _includes("math3d", "controller_lee", "log", "param", "platform_defaults", "power_distribution")
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
        (r'^#include "math3d.h"\n', "\\g<0>" + struct),
    )
    includes = _includes("controller_brescianini", "log", "param", "platform_defaults")
    return includes + without_tables(text, "controller_brescianini.c")


def controller_indi() -> str:
    types = _struct("api/controller_indi.h", "struct FloatRates", "controllerINDI_t")
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
        (r"cf_attitude_controller_reset_roll\(&pid->attitude, ", "attitudeControllerResetRollAttitudePID("),
        (r"cf_attitude_controller_reset_pitch\(&pid->attitude, ", "attitudeControllerResetPitchAttitudePID("),
        (
            r"cf_attitude_controller_reset\(&pid->attitude, &state->attitude\)",
            "attitudeControllerResetAllPID(state->attitude.roll, state->attitude.pitch, state->attitude.yaw)",
        ),
        (
            r"^  cf_position_controller_reset\(&pid->position, at->x, at->y, at->z\);$",
            "#if MINIATURE_RELEASE >= 202608\n  positionControllerResetAllPID(at->x, at->y, at->z);\n"
            "#else\n  (void)at;\n  positionControllerResetAllPID();\n#endif",
        ),
        (r'^#include "math3d.h"\n', "\\g<0>" + types.replace("positionControllerINDI_t position;\n", "\n")),
    )
    text = text.replace('#include "controller_indi.h"\n', "")
    includes = _includes(
        "controller_indi",
        "attitude_controller",
        "filter",
        "log",
        "param",
        "position_controller",
        "position_controller_indi",
    )
    return includes + without_tables(text, "controller_indi.c")


def position_controller_indi() -> str:
    types = _struct("api/position_controller_indi.h", "struct Vectr", "positionControllerINDI_t")
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
        (r'^#include "math3d.h"\n', "\\g<0>" + types),
    )
    includes = _includes("position_controller_indi", "filter", "log", "param")
    return includes + without_tables(text, "position_controller_indi.c")


# ------------------------------------------------------------------------------------------------------- everything


def collision_avoidance_header() -> str:
    return replaced(
        source("api/collision_avoidance.h"),
        (r'#include "vec.h"', '#include "math3d.h"'),
        (
            r"^#endif  // COLLISION_AVOIDANCE_H",
            """#ifdef CRAZYFLIE_FW
void collisionAvoidanceInit(void);
bool collisionAvoidanceTest(void);
void collisionAvoidanceUpdateSetpoint(setpoint_t *setpoint, const sensorData_t *sensorData,
                                      const state_t *state, stabilizerStep_t stabilizerStep);
#endif

\\g<0>""",
        ),
    )


def collision_avoidance() -> str:
    text = source("builtin/planning/collision_avoidance.c")
    body = text.partition("// ---")[0]
    return (
        '#include "collision_avoidance.h"\n#include "peer_localization.h"\n'
        + body
        + (TAILS / "collision_avoidance.c").read_text()
    )


def outlier_filter_tdoa() -> str:
    return '#include "outlierFilterTdoa.h"\n' + source("builtin/kalman/outlier_filter_tdoa.c")


def outlier_filter_tdoa_header() -> str:
    return replaced(source("api/outlierFilterTdoa.h"), (r"^// The deprecated gate.*(?=^#endif)", ""))


def sensfusion6() -> str:
    struct = "typedef enum {" + _ours("api/sensfusion6.h").partition("typedef enum {")[2].partition("// Writes")[0]
    text = source("builtin/complementary/sensfusion6.c").replace('#include "sensfusion6.h"\n', "")
    text = re.sub(r"^(void|bool|float) cf_", r"static \1 cf_", text, flags=re.M)
    text = _includes("sensfusion6", "log", "param", "stabilizer_types") + struct + text
    return without_tables(text, "sensfusion6.c")


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
    "src/hal/interface/imu_types.h": lambda: source("api/imu_types.h"),
    f"{UTILS}/interface/lighthouse/lighthouse_types.h": lighthouse_types,
    f"{UTILS}/interface/lighthouse/lighthouse_calibration.h": lambda: source("api/lighthouse_calibration.h"),
    f"{UTILS}/interface/math3d.h": math3d,
    f"{UTILS}/interface/num.h": lambda: source("api/num.h"),
    f"{UTILS}/interface/filter.h": lambda: source("api/filter.h"),
    f"{UTILS}/interface/pid.h": lambda: source("api/pid.h"),
    f"{UTILS}/src/num.c": lambda: source("builtin/math/num.c"),
    f"{UTILS}/src/filter.c": lambda: source("builtin/math/filter.c"),
    f"{UTILS}/src/pid.c": lambda: source("builtin/math/pid.c"),
    f"{UTILS}/src/lighthouse/lighthouse_calibration.c": lambda: source("builtin/kalman/lighthouse_calibration.c"),
    f"{INTERFACE}/stabilizer_types.h": stabilizer_types,
    f"{INTERFACE}/pptraj.h": pptraj_header,
    f"{INTERFACE}/collision_avoidance.h": collision_avoidance_header,
    f"{INTERFACE}/axis3fSubSampler.h": lambda: source("api/axis3fSubSampler.h"),
    f"{INTERFACE}/outlierfilter/outlierFilterTdoa.h": outlier_filter_tdoa_header,
    f"{INTERFACE}/outlierfilter/outlierFilterLighthouse.h": lambda: source("api/outlierFilterLighthouse.h"),
    f"{INTERFACE}/controller/controller_mellinger.h": controller_mellinger_header,
    f"{INTERFACE}/controller/controller_lee.h": controller_lee_header,
    f"{MODULES}/pptraj.c": pptraj,
    f"{MODULES}/collision_avoidance.c": collision_avoidance,
    f"{MODULES}/axis3fSubSampler.c": lambda: source("builtin/math/axis3f_sub_sampler.c"),
    f"{MODULES}/sensfusion6.c": sensfusion6,
    f"{MODULES}/outlierfilter/outlierFilterTdoa.c": outlier_filter_tdoa,
    f"{MODULES}/outlierfilter/outlierFilterLighthouse.c": lambda: source("builtin/kalman/outlier_filter_lighthouse.c"),
    f"{MODULES}/controller/controller_mellinger.c": controller_mellinger,
    f"{MODULES}/controller/controller_lee.c": controller_lee,
    f"{MODULES}/controller/controller_brescianini.c": controller_brescianini,
    f"{MODULES}/controller/controller_indi.c": controller_indi,
    f"{MODULES}/controller/position_controller_indi.c": position_controller_indi,
    "vendor/CMSIS/CMSIS/DSP/Source/CommonTables/arm_common_tables.c": arm_common_tables,
}
