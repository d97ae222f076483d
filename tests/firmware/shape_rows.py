"""What is known of the shape of a checkout, row by row, and which file of the miniature imitates it.

`python tests/firmware/shape_rows.py` prints the table. Tests check the rows on trees that are laid out: folders, guards
and includes of headers, includes of sources, constructs that make a build fail or a drone misbehave, and symbols of the
configuration. A row without a file says why nothing imitates it.
"""

from dataclasses import dataclass

MODULES = "src/modules/src"
INTERFACE = "src/modules/interface"
UTILS = "src/utils/interface"
CONTROLLER = f"{INTERFACE}/controller"
KALMAN = f"{INTERFACE}/kalman_core"
OUTLIERS = f"{INTERFACE}/outlierfilter"
ESTIMATOR = f"{INTERFACE}/estimator"
PLATFORM = "src/platform/interface"
HAL = "src/hal/interface"
CONFIG = "src/config"

ONCE = "#pragma once"
"""The guard of a header that has no macro of its own."""

NEWEST = "2026.08"
OLDEST = "2024.10"

TESTS = "test_miniature.py"
FORKS = "test_checkout_forks.py"


@dataclass(frozen=True)
class Header:
    """A header: its guard (None: none) and its includes in order, those before the guard first."""

    path: str
    guard: str | None
    includes: str = ""
    before_guard: int = 0
    notes: str = ""

    @property
    def name(self) -> str:
        return self.path.rpartition("/")[2]


@dataclass(frozen=True)
class Source:
    """A source and all of its includes in order."""

    path: str
    includes: str
    notes: str = ""


@dataclass(frozen=True)
class Fact:
    """Text that a file has, from a release on (or up to one), and text that it has not."""

    table: str
    says: str
    path: str
    has: tuple[str, ...] = ()
    lacks: tuple[str, ...] = ()
    release: str = NEWEST


@dataclass(frozen=True)
class Symbol:
    """A symbol of the configuration, its file, and the lines behind it."""

    name: str
    path: str
    lines: tuple[str, ...]


@dataclass(frozen=True)
class Row:
    """A row of the table that is printed."""

    table: str
    subject: str
    says: str
    file: str | None
    test: str | None
    why_not: str = ""


# --------------------------------------------------------------------------------------------------- headers, folders

FOLDERS = {
    "math3d.h": INTERFACE,
    "console.h": INTERFACE,
    "static_mem.h": INTERFACE,
    "crtp.h": INTERFACE,
    "param_logic.h": INTERFACE,
    "usec_time.h": HAL,
    "attitude_controller.h": CONTROLLER,
    "position_controller.h": CONTROLLER,
    "position_estimator.h": ESTIMATOR,
    "estimator.h": ESTIMATOR,
    "estimator_complementary.h": ESTIMATOR,
    "estimator_kalman.h": ESTIMATOR,
    "stm32fxxx.h": CONFIG,
    "FreeRTOSConfig.h": CONFIG,
    "outlierFilterTdoa.h": OUTLIERS,
    "outlierFilterTdoaSteps.h": OUTLIERS,
    "outlierFilterLighthouse.h": OUTLIERS,
}
NOWHERE = ("mm_robust.h", "stm32f4xx.h", "FreeRTOS.h", "autoconf.h")
"""Headers that a checkout does not have: each robust model has functions of its own, others come from elsewhere."""

HEADERS = (
    Header(f"{INTERFACE}/param.h", ONCE, "<stdint.h> param_logic.h"),
    Header(f"{INTERFACE}/param_logic.h", ONCE, "<stdbool.h> <stdint.h> <param.h> <crtp.h>", notes="a ring, in angles"),
    Header(f"{INTERFACE}/crtp.h", "CRTP_H_", "<stdint.h> <stdbool.h>", notes="packed, bit-fields in unnamed unions"),
    Header(f"{INTERFACE}/log.h", "__LOG_H__", "<stdbool.h> <stdint.h>"),
    Header(
        f"{INTERFACE}/stabilizer_types.h",
        "__STABILIZER_TYPES_H__",
        "<stdint.h> <stdbool.h> imu_types.h lighthouse_types.h",
        notes="uses types of the lighthouse",
    ),
    Header(f"{INTERFACE}/math3d.h", ONCE, "<math.h> <stdbool.h> <stddef.h> <assert.h>", notes="abs() undeclared"),
    Header(f"{INTERFACE}/pptraj.h", ONCE, "math3d.h", notes="packed struct poly4d"),
    Header(f"{INTERFACE}/pptraj_compressed.h", ONCE, "pptraj.h <stdio.h>", notes="a static function, not inline"),
    Header(f"{INTERFACE}/planner.h", ONCE, "<stdint.h> math3d.h pptraj.h pptraj_compressed.h"),
    Header(f"{INTERFACE}/collision_avoidance.h", "__COLLISION_AVOIDANCE_H__", "math3d.h stabilizer_types.h"),
    Header(f"{INTERFACE}/peer_localization.h", "__PEER_LOCALIZATION_H__", "<stdbool.h> math3d.h stabilizer_types.h"),
    Header(f"{INTERFACE}/power_distribution.h", "__POWER_DISTRIBUTION_H__", "stabilizer_types.h"),
    Header(f"{INTERFACE}/commander.h", "COMMANDER_H_", "<stdint.h> <stdbool.h> config.h stabilizer_types.h"),
    Header(f"{INTERFACE}/axis3fSubSampler.h", ONCE, "<stdint.h> imu_types.h"),
    Header(f"{INTERFACE}/kalman_supervisor.h", None, "<stdbool.h> kalman_core.h"),
    Header(f"{INTERFACE}/sensfusion6.h", "SENSORFUSION6_H_", "<stdbool.h>", notes="declares what nobody defines"),
    Header(f"{INTERFACE}/console.h", "CONSOLE_H_", "<stdbool.h> <stddef.h> <stdint.h> eprintf.h"),
    Header(f"{INTERFACE}/static_mem.h", ONCE, "cfassert.h"),
    Header(f"{INTERFACE}/app.h", ONCE, notes="prototypes without arguments"),
    Header(f"{INTERFACE}/eventtrigger.h", "__EVENTTRIGGER_H__", "<stdbool.h> <stdint.h>"),
    Header(f"{CONTROLLER}/attitude_controller.h", "ATTITUDE_CONTROLLER_H_", "<stdbool.h> <stdint.h>"),
    Header(f"{CONTROLLER}/position_controller.h", "POSITION_CONTROLLER_H_", "stabilizer_types.h"),
    Header(f"{CONTROLLER}/controller_pid.h", "__CONTROLLER_PID_H__", "stabilizer_types.h"),
    Header(f"{CONTROLLER}/controller_mellinger.h", "__CONTROLLER_MELLINGER_H__", "stabilizer_types.h math3d.h"),
    Header(f"{CONTROLLER}/controller_brescianini.h", ONCE, "stabilizer_types.h"),
    Header(
        f"{CONTROLLER}/controller_lee.h", "__CONTROLLER_LEE_H__", "stabilizer_types.h", notes="needs math3d.h before"
    ),
    Header(
        f"{CONTROLLER}/controller_indi.h",
        "__CONTROLLER_INDI_H__",
        "stabilizer_types.h filter.h math3d.h log.h param.h position_controller.h attitude_controller.h "
        "position_controller_indi.h",
        notes="a ring with the next, and short names",
    ),
    Header(
        f"{CONTROLLER}/position_controller_indi.h",
        "__POSITION_CONTROLLER_INDI_H__",
        "controller_indi.h stabilizer_types.h filter.h math3d.h log.h param.h",
        notes="macros come before the includes",
    ),
    Header(f"{CONTROLLER}/controller.h", "__CONTROLLER_H__", "stabilizer_types.h", notes="no autoconf.h"),
    Header(f"{KALMAN}/kalman_core.h", ONCE, "cf_math.h stabilizer_types.h"),
    Header(f"{KALMAN}/kalman_core_params_defaults.h", ONCE, "platform_defaults.h", notes="reads a misspelt symbol"),
    Header(f"{KALMAN}/mm_tdoa.h", ONCE, "kalman_core.h outlierFilterTdoa.h"),
    Header(f"{KALMAN}/mm_tdoa_robust.h", ONCE, "kalman_core.h outlierFilterTdoa.h"),
    Header(f"{KALMAN}/mm_sweep_angles.h", ONCE, "kalman_core.h outlierFilterLighthouse.h"),
    *(
        Header(f"{KALMAN}/mm_{model}.h", ONCE, "kalman_core.h")
        for model in ("flow", "tof", "distance", "distance_robust", "position", "absolute_height", "yaw_error", "pose")
    ),
    Header(f"{OUTLIERS}/outlierFilterTdoa.h", ONCE, "stabilizer_types.h"),
    Header(f"{OUTLIERS}/outlierFilterLighthouse.h", ONCE, "stabilizer_types.h"),
    Header(f"{UTILS}/cf_math.h", ONCE, "arm_math.h cfassert.h", notes="a pointer becomes a uint32_t"),
    Header(f"{UTILS}/cfassert.h", "__CFASSERT_H__", "stm32fxxx.h console.h", before_guard=2),
    Header(f"{UTILS}/debug.h", None, "config.h console.h uart1.h SEGGER_RTT.h", notes="looks at macros each time"),
    Header(f"{UTILS}/eprintf.h", "__EPRINTF_H__", "<stdarg.h>", before_guard=1),
    Header(f"{UTILS}/filter.h", "FILTER_H_", "<stdint.h> math.h", notes="a standard header in quotes"),
    Header(f"{UTILS}/pid.h", "PID_H_", "<stdbool.h> filter.h"),
    Header(f"{UTILS}/num.h", "__NUM_H", "<stdint.h>"),
    Header(f"{UTILS}/physicalConstants.h", ONCE, notes="defines what math.h may define later"),
    Header(f"{UTILS}/test_support.h", ONCE, notes="#if, not #ifdef"),
    Header(f"{UTILS}/statsCnt.h", ONCE, "<stdint.h> log.h"),
    Header(f"{UTILS}/rateSupervisor.h", ONCE, "<stdint.h> <stdbool.h>"),
    Header(f"{UTILS}/lighthouse/lighthouse_types.h", ONCE, notes="needs stdint and stdbool before"),
    Header(f"{UTILS}/lighthouse/lighthouse_calibration.h", ONCE, notes="needs the types before"),
    Header(f"{HAL}/imu_types.h", "IMU_TYPES_H_", notes="needs stdint before"),
    Header(f"{HAL}/usec_time.h", "USEC_TIME_H_", "<stdint.h>"),
    Header(f"{HAL}/sensors.h", "__SENSORS_H__", "stabilizer_types.h"),
    Header(f"{CONFIG}/config.h", "CONFIG_H_", "nrf24l01.h trace.h usec_time.h"),
    Header(f"{CONFIG}/trace.h", "__TRACE_H__", "autoconf.h", notes="writes where a host has nothing"),
    Header(f"{CONFIG}/stm32fxxx.h", "STM32FXXX_H_", "stm32f4xx.h", notes="warns on a host"),
    Header(f"{CONFIG}/FreeRTOSConfig.h", "FREERTOS_CONFIG_H", "<stdint.h> config.h cfassert.h"),
    Header("src/drivers/interface/nrf24l01.h", "__NRF24L01_H__", "<stdbool.h> nRF24L01reg.h"),
    Header(
        f"{PLATFORM}/platform_defaults.h",
        ONCE,
        "autoconf.h platform_defaults_cf2.h platform_defaults_bolt.h platform_defaults_cf21bl.h",
    ),
    *(
        Header(f"{PLATFORM}/platform_defaults_{name}.h", ONCE, notes="refuses to be included by others")
        for name in ("cf2", "cf21bl", "bolt")
    ),
)
FIRST_LINE = (f"{INTERFACE}/math3d.h", f"{UTILS}/lighthouse/lighthouse_types.h")
"""Headers with the guard before everything else."""

# ------------------------------------------------------------------------------------------------------------ sources

SOURCES = (
    Source("src/utils/src/num.c", "num.h <stdint.h>"),
    Source("src/utils/src/filter.c", "<math.h> <stdlib.h> filter.h"),
    Source("src/utils/src/pid.c", "pid.h num.h <math.h> <float.h>"),
    Source("src/utils/src/rateSupervisor.c", "rateSupervisor.h"),
    Source("src/utils/src/statsCnt.c", "statsCnt.h"),
    Source(f"{MODULES}/axis3fSubSampler.c", "<string.h> axis3fSubSampler.h"),
    Source(f"{MODULES}/planner.c", "<stddef.h> planner.h"),
    Source(
        f"{MODULES}/collision_avoidance.c",
        "<float.h> <string.h> collision_avoidance.h peer_localization.h FreeRTOS.h task.h param.h log.h",
    ),
    Source(
        f"{MODULES}/power_distribution_quadrotor.c",
        "power_distribution.h <string.h> debug.h log.h param.h num.h autoconf.h config.h math.h platform_defaults.h",
    ),
    Source(
        f"{MODULES}/controller/controller_pid.c",
        "stabilizer_types.h attitude_controller.h position_controller.h controller_pid.h log.h param.h math3d.h "
        "<string.h>",
    ),
    Source(
        f"{MODULES}/controller/controller_lee.c",
        "<math.h> <string.h> math3d.h controller_lee.h physicalConstants.h power_distribution.h platform_defaults.h "
        "param.h log.h",
        notes="the last two in the middle",
    ),
    Source(
        f"{MODULES}/controller/position_controller_pid.c",
        "<math.h> num.h log.h param.h pid.h position_controller.h platform_defaults.h",
    ),
    Source(
        f"{MODULES}/controller/attitude_pid_controller.c",
        "stabilizer_types.h attitude_controller.h pid.h param.h log.h commander.h platform_defaults.h",
    ),
    Source(
        f"{MODULES}/controller/controller_brescianini.c",
        "controller_brescianini.h log.h param.h num.h math3d.h physicalConstants.h platform_defaults.h",
    ),
    Source(
        f"{MODULES}/kalman_core/kalman_core.c",
        "kalman_core.h cfassert.h autoconf.h physicalConstants.h math3d.h static_mem.h kalman_core_params_defaults.h",
        notes="no string.h, no math.h",
    ),
    Source(f"{MODULES}/kalman_core/mm_tdoa.c", "mm_tdoa.h test_support.h log.h outlierFilterTdoaSteps.h"),
    Source(f"{MODULES}/kalman_core/mm_tdoa_robust.c", "mm_tdoa_robust.h test_support.h"),
    Source(f"{MODULES}/kalman_core/mm_distance_robust.c", "mm_distance_robust.h test_support.h"),
    Source(f"{MODULES}/kalman_core/mm_flow.c", "mm_flow.h log.h param.h platform_defaults.h"),
    Source(f"{MODULES}/kalman_core/mm_pose.c", "mm_pose.h math3d.h"),
    *(
        Source(f"{MODULES}/kalman_core/mm_{model}.c", f"mm_{model}.h")
        for model in ("tof", "distance", "position", "absolute_height", "yaw_error", "sweep_angles")
    ),
    Source(f"{MODULES}/kalman_supervisor.c", "kalman_supervisor.h param.h"),
    Source(
        f"{MODULES}/outlierfilter/outlierFilterTdoa.c",
        "<math.h> autoconf.h outlierFilterTdoa.h stabilizer_types.h log.h",
    ),
    Source(
        f"{MODULES}/sensfusion6.c", "<math.h> <stdint.h> sensfusion6.h log.h param.h physicalConstants.h autoconf.h"
    ),
    Source(
        f"{MODULES}/estimator/position_estimator_altitude.c",
        "stm32f4xx.h FreeRTOS.h task.h log.h param.h num.h position_estimator.h",
    ),
)

# -------------------------------------------------------------------------------------------------------------- facts

PARAM, LOGIC, LOG = f"{INTERFACE}/param.h", f"{INTERFACE}/param_logic.h", f"{INTERFACE}/log.h"
MIXER = f"{MODULES}/power_distribution_quadrotor.c"
CORE = f"{MODULES}/kalman_core/kalman_core.c"
ROBUST = f"{MODULES}/kalman_core/mm_tdoa_robust.c"

FACTS = (
    # constructs of headers
    Fact("headers", "a rate takes its tick without parentheses", f"{INTERFACE}/stabilizer_types.h", ("(TICK %",)),
    Fact(
        "headers",
        "samples of a second sensor under a macro",
        f"{INTERFACE}/stabilizer_types.h",
        ("#ifdef LOG_SEC_IMU",),
    ),
    Fact("headers", "the size of vectors is a macro", f"{INTERFACE}/stabilizer_types.h", ("#define vec3d_size 3",)),
    Fact(
        "headers", "modes have no name of their own", f"{INTERFACE}/stabilizer_types.h", ("  } mode;",), release=OLDEST
    ),
    Fact(
        "headers",
        "all functions are inline",
        f"{INTERFACE}/math3d.h",
        ("static inline struct vec vadd",),
        ("stdlib.h",),
    ),
    Fact(
        "headers", "bits of a number through a pointer", f"{INTERFACE}/math3d.h", ("*((int const *)&a)", "abs(apart)")
    ),
    Fact("headers", "pi is defined unless it is", f"{INTERFACE}/math3d.h", ("#ifndef M_PI_F\n#define M_PI_F",)),
    Fact("headers", "a piece is packed", f"{INTERFACE}/pptraj.h", ("} __attribute__((packed));",)),
    Fact(
        "headers",
        "a function that is not inline warns wherever it is not called",
        f"{INTERFACE}/pptraj_compressed.h",
        ("\nstatic void piecewise_compressed_print",),
    ),
    Fact("headers", "a trajectory is const in a union", f"{INTERFACE}/planner.h", ("const struct piecewise_traj  ",)),
    Fact("headers", "entries for the vehicle", f"{INTERFACE}/collision_avoidance.h", ("#ifdef CRAZYFLIE_FW",)),
    Fact(
        "headers",
        "ten neighbors",
        f"{INTERFACE}/peer_localization.h",
        ("PEER_LOCALIZATION_MAX_NEIGHBORS 10", "Init();"),
    ),
    Fact("headers", "no arguments are declared", f"{INTERFACE}/power_distribution.h", ("GetIdleThrust();",)),
    Fact(
        "headers",
        "priorities of setpoints",
        f"{INTERFACE}/commander.h",
        ("PRIORITY_DISABLE 0", "PRIORITY_LOWEST 1", "PRIORITY_HIGHLEVEL 1", "PRIORITY_CRTP 2", "PRIORITY_EXTRX 3"),
        ("M2T",),
    ),
    Fact(
        "headers",
        "resets take no values in old trees",
        f"{CONTROLLER}/attitude_controller.h",
        ("ResetAllPID(void)",),
        release=OLDEST,
    ),
    Fact("headers", "entries for the vehicle", f"{CONTROLLER}/controller_mellinger.h", ("#ifdef CRAZYFLIE_FW",)),
    Fact(
        "headers",
        "a test is not declared",
        f"{CONTROLLER}/controller_lee.h",
        ("struct mat33",),
        ("LeeTest(c", "math3d.h"),
    ),
    Fact(
        "headers", "generic names", f"{CONTROLLER}/controller_indi.h", ("struct FloatRates {", "struct IndiVariables {")
    ),
    Fact("headers", "a macro of two files", f"{CONTROLLER}/controller_indi.h", ("#define ATTITUDE_UPDATE_DT",)),
    Fact(
        "headers",
        "macros come first",
        f"{CONTROLLER}/position_controller_indi.h",
        ("#define MIN_THRUST 0\n#define MAX_THRUST 60000", "struct Vectr {", "struct Angles {"),
    ),
    Fact(
        "headers",
        "the number of controllers depends on a symbol",
        f"{CONTROLLER}/controller.h",
        ("CONFIG_CONTROLLER_OOT",),
    ),
    Fact(
        "headers",
        "an attribute stands before a member, and a matrix points into the state",
        f"{KALMAN}/kalman_core.h",
        ("__attribute__((aligned(4))) float P[", "arm_matrix_instance_f32           Pm;", "kalmanCoreData_t *this"),
    ),
    Fact("headers", "a symbol lacks a letter", f"{KALMAN}/kalman_core_params_defaults.h", ("CONFIG_STIMATOR_KALMAN",)),
    Fact(
        "headers",
        "warnings are off for one header",
        f"{UTILS}/cf_math.h",
        ("#pragma GCC diagnostic push", "(uint32_t)matrix->pData"),
    ),
    Fact(
        "headers",
        "constants unless they are there",
        f"{UTILS}/physicalConstants.h",
        ("#ifndef M_PI\n", "#ifndef M_PI_F\n"),
    ),
    Fact("headers", "a filter is reset by the header of PID", f"{UTILS}/pid.h", ("filterReset",)),
    Fact("headers", "types of the lighthouse are packed", f"{UTILS}/lighthouse/lighthouse_types.h", ("packed",)),
    Fact("headers", "samples are unions", f"{HAL}/imu_types.h", ("int16_t axis[3];", "float axis[3];")),
    Fact("headers", "rates of the radio", "src/drivers/interface/nrf24l01.h", ("RADIO_RATE_2M 2", "nrfInit();")),
    Fact(
        "headers",
        "who includes is marked",
        f"{PLATFORM}/platform_defaults.h",
        ("#define __INCLUDED_FROM_PLATFORM_DEFAULTS__",),
    ),
    Fact("headers", "a deck defines symbols", f"{PLATFORM}/platform_defaults.h", ("#ifdef CONFIG_DECK_BIGQUAD",)),
    Fact("headers", "an error by pragma", f"{PLATFORM}/platform_defaults_cf2.h", ("#pragma GCC error",)),
    Fact(
        "headers",
        "a symbol of the configuration",
        f"{PLATFORM}/platform_defaults_cf21bl.h",
        ("#define CONFIG_MOTORS_DEFAULT_IDLE_THRUST 7000",),
    ),
    Fact("headers", "a misspelt limit", f"{PLATFORM}/platform_defaults_bolt.h", ("DEFAULT_BAT_BAT_LOW_VOLTAGE",)),
    # constructs of sources
    Fact(
        "sources",
        "bits through pointers, a difference that wraps",
        "src/utils/src/num.c",
        ("15 - 127", "*(uint32_t *)&number"),
    ),
    Fact("sources", "pi of its own", "src/utils/src/filter.c", ("#define M_PI_F (float)M_PI",)),
    Fact(
        "sources",
        "a symbol is read that nobody includes",
        "src/utils/src/pid.c",
        ("#if CONFIG_CONTROLLER_PID_FILTER_ALL",),
        ("autoconf.h",),
    ),
    Fact("sources", "a literal of a union", f"{MODULES}/axis3fSubSampler.c", ("(Axis3f){",)),
    Fact(
        "sources",
        "angles come from math3d.h",
        f"{MODULES}/planner.c",
        ("normalize_radians(", "shortest_signed_angle_radians("),
        ("num.h",),
    ),
    Fact(
        "sources",
        "half of it is for the vehicle",
        f"{MODULES}/collision_avoidance.c",
        ("#ifdef CRAZYFLIE_FW", "PARAM_GROUP_START(colAv)"),
    ),
    Fact(
        "sources",
        "idle thrust without arming is refused",
        MIXER,
        ("#error", "static float motorForces"),
        ("define DEBUG_MODULE",),
    ),
    Fact(
        "sources", "the first line is empty", f"{MODULES}/controller/controller_pid.c", ("LOG_GROUP_START(controller)",)
    ),
    Fact(
        "sources",
        "includes in the middle, a test nobody declared",
        f"{MODULES}/controller/controller_lee.c",
        ("bool controllerLeeTest(",),
    ),
    Fact(
        "sources",
        "matrices of functions that point to others, in three orders of attributes",
        CORE,
        (
            "NO_DMA_CCM_SAFE_ZERO_INIT static float K[N];",
            "NO_DMA_CCM_SAFE_ZERO_INIT __attribute__((aligned(4))) static float",
            "static __attribute__((aligned(4))) arm_matrix_instance_f32",
            "#ifdef DEBUG_STATE_CHECK",
            "memset(",
        ),
        ("<string.h>", "<math.h>"),
    ),
    Fact(
        "sources",
        "a symbol is read that nobody includes",
        f"{MODULES}/kalman_core/mm_tdoa.c",
        ("#if CONFIG_ESTIMATOR_KALMAN_TDOA_OUTLIERFILTER_FALLBACK",),
        ("autoconf.h",),
    ),
    Fact(
        "sources", "arrays whose size is an argument", ROBUST, ("float matrix[n][n]", "mat_inv(", "static float x_err")
    ),
    Fact(
        "sources",
        "each robust model has its own",
        f"{MODULES}/kalman_core/mm_distance_robust.c",
        ("Cholesky_Decomposition(int n",),
    ),
    Fact("sources", "abs of another type", f"{MODULES}/kalman_core/mm_tof.c", ("fabs(",)),
    Fact("sources", "no tables", f"{MODULES}/kalman_core/mm_sweep_angles.c", (), ("log.h", "param.h", "GROUP_START")),
    Fact("sources", "globals", f"{MODULES}/kalman_supervisor.c", ("\nfloat maxPosition", "\nfloat maxVelocity")),
    Fact(
        "sources",
        "a constant made from another",
        f"{MODULES}/outlierfilter/outlierFilterTdoa.c",
        ("= INTEGRATOR_SIZE *",),
    ),
    Fact(
        "sources",
        "globals, and a function that is static by its declaration only",
        f"{MODULES}/sensfusion6.c",
        ("\nfloat qw = 1.0f;", "\nfloat twoKp ", "static float invSqrt(float x);", "\nfloat invSqrt(float x) {"),
    ),
    Fact(
        "sources",
        "a macro with a semicolon, and a header of the processor",
        f"{MODULES}/estimator/position_estimator_altitude.c",
        ("#define G 9.81f;", "static bool  surfaceFollowingMode"),
    ),
    Fact(
        "sources",
        "globals",
        f"{MODULES}/controller/controller_indi.c",
        ("\nstruct FloatRates body_rates", "\nvoid indi_init_filters(void) {"),
    ),
    # parameters
    Fact(
        "parameters",
        "a row",
        PARAM,
        (
            "uint8_t extended_type;",
            "void *(*getter)(void);",
            "typedef uint8_t *(*paramGetterUInt8)(void);",
            "paramGetterFloat",
        ),
    ),
    Fact(
        "parameters",
        "flags",
        PARAM,
        (
            "PARAM_PERSISTENT (1 << 8)",
            "PARAM_EXTENDED (1 << 4)",
            "PARAM_CORE (1 << 5)",
            "PARAM_RONLY (1 << 6)",
            "PARAM_SYNC 0x02",
            "PARAM_VARIABLE",
            "PARAM_8BYTES 0x03",
        ),
    ),
    Fact(
        "parameters",
        "numbers of the protocol",
        PARAM,
        ("TOC_CH 0", "MISC_CH 3", "MISC_SETBYNAME 0", "MISC_GET_DEFAULT_VALUE 6"),
    ),
    Fact(
        "parameters",
        "a row ends with a comma",
        PARAM,
        ("PARAM_ADD_FULL(TYPE, NAME, ADDRESS, CALLBACK, DEFAULT_GETTER)", "= (void *)DEFAULT_GETTER},"),
    ),
    Fact(
        "parameters",
        "the type of a core row stands without parentheses",
        PARAM,
        ("PARAM_ADD_FULL(TYPE | PARAM_CORE, NAME",),
    ),
    Fact(
        "parameters", "a test of units keeps the tables", PARAM, ("#ifndef UNIT_TEST_MODE\n#define PARAM_GROUP_START",)
    ),
    Fact(
        "parameters",
        "tables are written",
        PARAM,
        ("  static struct param_s __params_##NAME[]", 'section(".param." #NAME)'),
        ("ParamInit", "paramInit"),
    ),
    Fact("parameters", "no macro of 2021", PARAM, (), ("PARAM_ADD_PERSISTENT",)),
    Fact("parameters by name", "the id comes first", LOGIC, ("uint16_t id;\n  uint16_t index;", "packed")),
    Fact("parameters by name", "an argument without parentheses", LOGIC, ("(varId.id != 0xffffu)",)),
    Fact(
        "parameters by name",
        "functions",
        LOGIC,
        (
            "paramGetVarIdFromComplete(",
            "paramGetGroupAndName(",
            "paramVarSize(int type)",
            "paramGetUint(",
            "paramSetInt(",
            "paramSetFloat(",
        ),
    ),
    Fact(
        "parameters by name",
        "packets",
        LOGIC,
        ("void paramLogicInit();", "paramTOCProcess(CRTPPacket *p, int ", "paramPersistentClear(CRTPPacket *p)"),
    ),
    # logs
    Fact("logs", "a row", LOG, ("struct log_s {\n  uint8_t type;\n  char   *name;\n  void   *address;",)),
    Fact(
        "logs",
        "functions, and validity by one of them",
        LOG,
        (
            "static inline bool logVarIdIsValid(",
            "logGetGroupAndName(",
            "logGetAddress(",
            "logVarSize(int type)",
            "logGetUint(",
        ),
        ("LOG_VARID_IS_VALID",),
    ),
    Fact(
        "logs",
        "types and flags",
        LOG,
        ("LOG_UINT8 1", "LOG_FLOAT 7", "LOG_FP16 8", "LOG_CORE 0x20", "LOG_BY_FUNCTION 0x40", "LOG_GROUP 0x80"),
    ),
    Fact("logs", "a misspelt member", LOG, ("(*aquireFloat)(uint32_t timestamp, void *data)",), ("acquireFloat",)),
    Fact("logs", "tables are constant", LOG, ("static const struct log_s __logs_##NAME[]", 'section(".log." #NAME)')),
    Fact(
        "logs",
        "rows for developers, the wrong way round",
        LOG,
        ("#ifdef CONFIG_DEBUG_LOG_ENABLE\n#define LOG_ADD_DEBUG(TYPE, NAME, ADDRESS)\n#else",),
    ),
    Fact(
        "logs", "a test of units has none", LOG, ("#else  // UNIT_TEST_MODE\n\n#define LOG_ADD(TYPE, NAME, ADDRESS)\n",)
    ),
    # users of tables
    Fact(
        "users of tables",
        "a rate points to itself, and its row by function comes first",
        f"{UTILS}/statsCnt.h",
        ("logByFunction_t       logByFunction;\n", ".data = &NAME", "LOG_ADD_BY_FUNCTION(LOG_FLOAT"),
    ),
    Fact(
        "users of tables",
        "events in a section of their own, and none in a test of units",
        f"{INTERFACE}/eventtrigger.h",
        ('section(".eventtrigger." #NAME)', "##__VA_ARGS__", "#else\n\n#define EVENTTRIGGER(NAME, ...)\n"),
    ),
    # other headers
    Fact(
        "other headers",
        "prefix if there was a name before",
        f"{UTILS}/debug.h",
        ("#ifdef DEBUG_MODULE\n#define DEBUG_FMT", "DEBUG_PRINT_OS", "TEST_AND_PRINT"),
    ),
    Fact(
        "other headers",
        "an assertion is an if with an else",
        f"{UTILS}/cfassert.h",
        ("if (e)", "assertFail(#e, __FILE__, __LINE__)\n", "ASSERT_DMA_SAFE", "cfAssertNormalStartTest(void)"),
    ),
    Fact(
        "other headers",
        "older assertions",
        f"{UTILS}/cfassert.h",
        ("storeAssertSnapshotData",),
        ("stm32fxxx.h",),
        OLDEST,
    ),
    Fact(
        "other headers",
        "printing is a macro",
        f"{INTERFACE}/console.h",
        ("#define consolePrintf(FMT, ...) eprintf(consolePutchar", "ConsoleSource", "consolePutcharFromISR"),
    ),
    Fact(
        "other headers",
        "a format is checked",
        f"{UTILS}/eprintf.h",
        ("format(printf, 2, 3)", "evprintf(putc_t putcf, const char *fmt, va_list ap)"),
    ),
    Fact(
        "other headers",
        "memory without a heap",
        f"{INTERFACE}/static_mem.h",
        (
            'section(".ccmbss")',
            "FORCE_CCM_ZERO_INIT",
            "STATIC_MEM_QUEUE_ALLOC(NAME",
            "STATIC_MEM_QUEUE_CREATE(NAME)",
            "STATIC_MEM_TASK_ALLOC_STACK_NO_DMA_CCM_SAFE",
            "STATIC_MEM_TASK_CREATE(NAME",
        ),
        ("FreeRTOS.h",),
    ),
    Fact(
        "other headers",
        "tasks, and no conversion of times",
        f"{CONFIG}/config.h",
        (
            "STABILIZER_TASK_PRI 5",
            "KALMAN_TASK_PRI 2",
            "PM_TASK_PRI 0",
            "configMINIMAL_STACK_SIZE",
            "BAT_LOADING_SAG_THRESHOLD 0.70f",
        ),
        ("M2T", "F2T"),
    ),
    Fact(
        "other headers",
        "times in ticks, numbers of tasks",
        f"{CONFIG}/FreeRTOSConfig.h",
        (
            "#define M2T(X)",
            "#define F2T(X)",
            "#define T2M(X)",
            "#define S2T(X)",
            "#define T2S(X)",
            "TASK_STABILIZER_ID_NBR 3",
            "configASSERT(x)",
            "configTICK_RATE_HZ_RAW",
        ),
    ),
    # every tree
    Fact(
        "every tree",
        "the DSP library brings the standard headers",
        "vendor/CMSIS/CMSIS/DSP/Include/arm_math.h",
        ("<float.h>", "<math.h>", "<string.h>"),
    ),
    Fact(
        "every tree",
        "instructions of another processor",
        "vendor/CMSIS/CMSIS/Core/Include/cmsis_gcc.h",
        ("__asm volatile",),
    ),
    Fact("every tree", "a header warns on a host", f"{CONFIG}/stm32fxxx.h", ("#warning",)),
    Fact(
        "every tree",
        "a boolean is registered as a number",
        f"{MODULES}/controller/attitude_pid_controller.c",
        ("PARAM_INT8 | PARAM_PERSISTENT, rateFiltEn",),
    ),
    Fact("every tree", "one group in two files", f"{MODULES}/kalman_supervisor.c", ("PARAM_GROUP_START(kalman)",)),
    Fact(
        "every tree",
        "a group of parameters in two files, and enumerations as 8 bits",
        f"{MODULES}/stabilizer.c",
        (
            "PARAM_GROUP_START(stabilizer)",
            "PARAM_ADD_CORE(PARAM_UINT8, estimator, &estimatorType)",
            "static StateEstimatorType estimatorType;",
            "LOG_GROUP_START(controller)",
        ),
    ),
    Fact("every tree", "the second file of a group", f"{MODULES}/supervisor.c", ("PARAM_GROUP_START(stabilizer)",)),
    Fact(
        "every tree",
        "the second file of a group",
        f"{MODULES}/estimator/estimator_kalman.c",
        ("PARAM_GROUP_START(kalman)",),
    ),
    Fact(
        "every tree",
        "rows by function, events, and a register of the processor",
        f"{MODULES}/estimator/estimator.c",
        ("static STATS_CNT_RATE_DEFINE(", "STATS_CNT_RATE_LOG_ADD(", "EVENTTRIGGER(estPose)", "SCB->ICSR"),
    ),
    # releases
    Fact("trees", "2024.10: the planner follows a null pointer", f"{MODULES}/planner.c", (), ("== NULL",), OLDEST),
    Fact("trees", "2024.10: body rates have another name", f"{INTERFACE}/pptraj.h", ("rates;",), ("omega",), OLDEST),
    Fact(
        "trees",
        "2024.10: a window has another name",
        f"{OUTLIERS}/outlierFilterLighthouse.h",
        ("validUntilMs",),
        ("openingWindowMs;",),
        OLDEST,
    ),
    Fact(
        "trees",
        "2024.10: prediction without parameters",
        f"{KALMAN}/kalman_core.h",
        ("kalmanCorePredict(kalmanCoreData_t *this, Axis3f *acc",),
        ("attitudeReversion",),
        OLDEST,
    ),
    Fact(
        "trees",
        "2024.10: no Lee, no jerk, a cap without result",
        f"{INTERFACE}/power_distribution.h",
        ("void powerDistributionCap",),
        ("GetMaxThrust",),
        OLDEST,
    ),
    Fact(
        "trees",
        "2025.12: thrust curves by number",
        f"{PLATFORM}/platform_defaults_cf2.h",
        ("CONFIG_THRUST_BAT_COMPENSATION_TYPE == 2",),
        (),
        "2025.12",
    ),
    Fact(
        "trees",
        "2025.12: defaults of the filter in a macro",
        f"{KALMAN}/kalman_core_params_defaults.h",
        ("KALMAN_CORE_DEFAULT_PARAMS_INIT",),
        ("DRAG_B_X",),
        "2025.12",
    ),
    Fact(
        "trees",
        "2026.08: drag and the center of pressure",
        f"{KALMAN}/kalman_core_params_defaults.h",
        ("DRAG_B_X", "CENTER_OF_PRESSURE_Z"),
    ),
    Fact("trees", "2026.08: a lever arm of the flow deck", f"{MODULES}/kalman_core/mm_flow.c", ("FLOWDECK_POS_X",)),
    Fact(
        "trees",
        "2026.08: propellers by choice",
        f"{PLATFORM}/platform_defaults_cf2.h",
        ("CONFIG_CRAZYFLIE_LEGACY_PROPELLERS",),
    ),
    Fact(
        "trees",
        "after: controllers land precisely",
        f"{MODULES}/controller/controller_pid.c",
        ("void controllerPidEnterPreciseLanding(void) {",),
        (),
        "after",
    ),
)

# ------------------------------------------------------------------------------------------------------ configuration

TOP, MODULE_OPTIONS = "Kconfig", f"{MODULES}/Kconfig"
SYMBOLS = (
    Symbol("PLATFORM_CF2", TOP, ("select SENSORS_BMI088_BMP3XX",)),
    Symbol("PLATFORM_CF21BL", TOP, ("select MOTORS_REQUIRE_ARMING",)),
    Symbol("PLATFORM_BOLT", TOP, ("select SENSORS_BMI088_SPI",)),
    Symbol("ENABLE_THRUST_BAT_COMPENSATED", TOP, ("default y", "depends on PLATFORM_CF2 || PLATFORM_CF21BL")),
    Symbol("CRAZYFLIE_21_PLUS", TOP, ("bool",)),
    Symbol("THRUST_BAT_COMPENSATION_MAX_THRUST", TOP, ("default 200",)),
    Symbol("MODIFY_CF_MASS", TOP, ("default n",)),
    Symbol("MODIFIED_CF_MASS", TOP, ("default 29000",)),
    Symbol("MOTORS_ESC_PROTOCOL_ONESHOT125", TOP, ("bool",)),
    Symbol("MOTORS_ESC_PROTOCOL_DSHOT_BIDIRECTIONAL", TOP, ("bool",)),
    Symbol("MOTORS_ARMING_RPM_MIN", TOP, ("default 1000",)),
    Symbol("MOTORS_ARMING_RPM_MAX", TOP, ("default 3500",)),
    Symbol("MOTORS_RPM_NOT_RESPONDING_THRESHOLD", TOP, ("default 500",)),
    Symbol("MOTORS_REQUIRE_ARMING", TOP, ("default n",)),
    Symbol("MOTORS_DEFAULT_IDLE_THRUST", TOP, ("default 7000", "depends on MOTORS_REQUIRE_ARMING")),
    Symbol("MOTORS_DEFAULT_PROP_TEST_PWM_RATIO", TOP, ("default 0",)),
    Symbol("MOTORS_DEFAULT_BAT_TEST_PWM_RATIO", TOP, ("default 0",)),
    Symbol("LOG_MOTOR_CAP_WARNING", TOP, ("default n",)),
    Symbol("SENSORS_BMI088_BMP3XX", TOP, ("bool",)),
    Symbol("CONTROLLER_PID_FILTER_ALL", MODULE_OPTIONS, ("depends on CONTROLLER_PID",)),
    Symbol("CONTROLLER_LEE", MODULE_OPTIONS, ("bool",)),
    Symbol("CONTROLLER_OOT", MODULE_OPTIONS, ("bool",)),
    Symbol("ESTIMATOR_KALMAN_ENABLE", MODULE_OPTIONS, ("default y", "select ESTIMATOR_OUTLIER_FILTERS")),
    Symbol("ESTIMATOR_KALMAN_TDOA_OUTLIERFILTER_FALLBACK", MODULE_OPTIONS, ("default n",)),
    Symbol("ESTIMATOR_KALMAN_GENERAL_PURPOSE", MODULE_OPTIONS, ("default n",)),
    Symbol("ESTIMATOR_KALMAN_INITIAL_YAW_STD", MODULE_OPTIONS, ("default 10",)),
    Symbol("ESTIMATOR_UKF_ENABLE", MODULE_OPTIONS, ("default n",)),
    Symbol("ESTIMATOR_AUTO_SELECT", MODULE_OPTIONS, ("bool",)),
    Symbol("POWER_DISTRIBUTION_QUADROTOR", MODULE_OPTIONS, ("bool",)),
    Symbol("IMU_MAHONY_QUATERNION", MODULE_OPTIONS, ("bool",)),
    Symbol("APP_STACKSIZE", MODULE_OPTIONS, ("default 300",)),
    Symbol("APP_PRIORITY", MODULE_OPTIONS, ("default 0",)),
    Symbol("DECK_SUPERVISOR", MODULE_OPTIONS, ("default y",)),
    Symbol("DECK_USD", MODULE_OPTIONS, ("default y",)),
    Symbol("DECK_LOCO_2D_POSITION", MODULE_OPTIONS, ("default n",)),
)
DEFCONFIGS = {
    "cf2": ("CONFIG_PLATFORM_CF2=y",),
    "cf21bl": ("CONFIG_PLATFORM_CF21BL=y", "CONFIG_MOTORS_REQUIRE_ARMING=y", "CONFIG_MOTORS_ESC_PROTOCOL_DSHOT=y"),
    "bolt": ("CONFIG_PLATFORM_BOLT=y", "CONFIG_ESTIMATOR_ANY=y", "CONFIG_CONTROLLER_AUTO_SELECT=y"),
}

# ---------------------------------------------------------------------------------------------------- the rest of them

OTHERS = (
    Row(
        "trees",
        "a fork at every level",
        "compiles up to its own loop",
        f"{MODULES}/stabilizer.c",
        f"{FORKS}::test_a_fork_compiles_up_to_its_own_loop",
    ),
    Row(
        "configuration",
        "CONTROLLER_PID_IMPROVED_BARO_Z_HOLD",
        "other gains, thrust and filters of height",
        None,
        None,
        "the numbers are not known; the symbol is in Kconfig",
    ),
    Row(
        "across files",
        "autoconf.h",
        "the vehicle's build forces it, the bindings' does not",
        "src/utils/src/pid.c",
        f"{TESTS}::test_every_source_compiles",
    ),
    Row(
        "across files",
        "%lu of a uint32_t",
        "the vehicle's uint32_t is long, so that hosts warn",
        MIXER,
        f"{TESTS}::test_every_source_compiles",
    ),
    Row(
        "across files",
        ".ccmbss",
        "initial values are lost on the vehicle, kept on a host",
        None,
        None,
        "a tree cannot show what a linker's script does",
    ),
    Row(
        "across files",
        "FreeRTOS.h",
        "brings config.h and cfassert.h through FreeRTOSConfig.h",
        f"{CONFIG}/FreeRTOSConfig.h",
        f"{TESTS}::test_every_source_compiles",
    ),
    Row(
        "parameters",
        "tables of a test of units",
        "before 2020 all macros were empty there",
        None,
        None,
        "older than all releases that are laid out",
    ),
    Row(
        "setup.py",
        "2023",
        "distutils, sources in both quotes with comments between them",
        "bindings/setup.py",
        f"{TESTS}::test_all_forms_of_the_list_name_the_same_files_and_these_exist",
    ),
    Row(
        "setup.py",
        "2025",
        "the same with Lee",
        "bindings/setup.py",
        f"{TESTS}::test_all_forms_of_the_list_name_the_same_files_and_these_exist",
    ),
    Row(
        "setup.py", "2026", "setuptools", "bindings/setup.py", f"{TESTS}::test_the_list_is_read_as_python_would_run_it"
    ),
    Row(
        "setup.py",
        "a second file at the root",
        "what make copies to build/",
        "cffirmware_setup.py",
        f"{TESTS}::test_the_bindings_are_described_as_the_firmware_does",
    ),
    Row(
        "setup.py",
        "cffirmware.i",
        "what is included is not what is wrapped; helpers inline",
        "bindings/cffirmware.i",
        f"{TESTS}::test_the_bindings_are_described_as_the_firmware_does",
    ),
    Row(
        "every tree",
        "vendor/",
        "empty until its submodule is there",
        "vendor/CMSIS",
        f"{TESTS}::test_without_the_nested_submodule_its_folder_is_empty",
    ),
    Row(
        "every tree",
        "estimator/",
        "headers that the bindings' list of folders does not have",
        f"{ESTIMATOR}/estimator.h",
        f"{TESTS}::test_the_list_lacks_the_folder_of_estimators",
    ),
    Row(
        "every tree",
        "warnings",
        "those that headers of the firmware cause, and no others",
        f"{UTILS}/cf_math.h",
        f"{TESTS}::test_every_source_compiles",
    ),
    Row(
        "trees",
        "2024.10, 2025.02, 2025.12, 2026.08",
        "signatures and members by release",
        f"{INTERFACE}/planner.h",
        f"{TESTS}::test_a_release_has_what_came_with_it_and_before",
    ),
    Row(
        "trees",
        "after 2026.08",
        "setuptools, and hooks for precise landing under names of ours",
        f"{CONTROLLER}/controller_pid.h",
        f"{TESTS}::test_a_release_has_what_came_with_it_and_before",
    ),
    Row("trees", "guidance branch", "an open request with another commander", None, None, "not part of the firmware"),
    Row(
        "trees",
        "fork old_param",
        "named guard, crtp.h in angles, constant tables",
        PARAM,
        f"{FORKS}::test_a_fork_flies_like_the_builtin_provider",
    ),
    Row(
        "trees",
        "fork fork_edits",
        "a controller, members, tabs, other ends of lines and letters",
        f"{MODULES}/controller/controller_mine.c",
        f"{FORKS}::test_the_edits_of_a_fork_are_there",
    ),
    Row(
        "trees",
        "fork simulation_port",
        "a folder with headers of names that are there",
        f"{CONFIG}/sim/config.h",
        f"{FORKS}::test_a_fork_flies_like_the_builtin_provider",
    ),
    Row(
        "trees",
        "robust model with two arguments",
        "another name, without a filter",
        None,
        None,
        "older than all releases that are laid out",
    ),
    Row(
        "trees",
        "PID whose flag says whether to update the error",
        "the third argument has flipped",
        None,
        None,
        "older than all releases that are laid out",
    ),
    Row(
        "trees",
        "2023 priorities and conversions of commander.h",
        "watchdog macros with M2T",
        None,
        None,
        "older than all releases that are laid out",
    ),
    Row(
        "trees",
        "num.h with min and max",
        "macros in place of constrain",
        None,
        None,
        "older than all releases that are laid out",
    ),
)


def rows() -> list[Row]:
    """All rows, each with its file and its test."""
    every = [
        Row(
            "folders",
            name,
            f"lies in {folder}",
            f"{folder}/{name}",
            f"{TESTS}::test_headers_lie_where_the_firmware_has_them",
        )
        for name, folder in FOLDERS.items()
    ]
    every += [
        Row("folders", name, "is nowhere in a checkout", ".", f"{TESTS}::test_headers_lie_where_the_firmware_has_them")
        for name in NOWHERE
    ]
    for header in HEADERS:
        says = f"guard {header.guard or 'none'}; {header.includes or 'includes nothing'}"
        says += f"; {header.notes}" if header.notes else ""
        every.append(
            Row("headers", header.name, says, header.path, f"{TESTS}::test_a_header_has_its_guard_and_includes")
        )
    for source in SOURCES:
        says = source.includes + (f"; {source.notes}" if source.notes else "")
        every.append(
            Row(
                "sources",
                source.path.rpartition("/")[2],
                says,
                source.path,
                f"{TESTS}::test_a_source_includes_what_it_does",
            )
        )
    every += [
        Row(fact.table, fact.path.rpartition("/")[2], fact.says, fact.path, f"{TESTS}::test_a_fact_holds")
        for fact in FACTS
    ]
    every += [
        Row("configuration", one.name, ", ".join(one.lines), one.path, f"{TESTS}::test_a_symbol_is_configured")
        for one in SYMBOLS
    ]
    every += [
        Row(
            "configuration",
            name,
            " ".join(lines),
            f"configs/{name}_defconfig",
            f"{TESTS}::test_defconfigs_are_as_stored",
        )
        for name, lines in DEFCONFIGS.items()
    ]
    return every + list(OTHERS)


def main() -> None:
    for row in rows():
        place = row.file or f"({row.why_not})"
        print(f"{row.table:20} {row.subject:40} {place:60} {row.test or '-'}\n{'':20} {row.says}")


if __name__ == "__main__":
    main()
