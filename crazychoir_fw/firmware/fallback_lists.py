"""The lists of the newest known release, for a checkout whose bindings/setup.py says nothing that can be read."""

_DSP = "vendor/CMSIS/CMSIS/DSP/Source"
_MODULES = "src/modules/src"

SOURCES = (
    f"{_DSP}/BasicMathFunctions/arm_add_f32.c",
    f"{_DSP}/BasicMathFunctions/arm_dot_prod_f32.c",
    f"{_DSP}/BasicMathFunctions/arm_scale_f32.c",
    f"{_DSP}/BasicMathFunctions/arm_sub_f32.c",
    f"{_DSP}/CommonTables/arm_common_tables.c",
    f"{_DSP}/FastMathFunctions/arm_cos_f32.c",
    f"{_DSP}/FastMathFunctions/arm_sin_f32.c",
    f"{_DSP}/MatrixFunctions/arm_mat_mult_f32.c",
    f"{_DSP}/MatrixFunctions/arm_mat_scale_f32.c",
    f"{_DSP}/MatrixFunctions/arm_mat_trans_f32.c",
    f"{_DSP}/StatisticsFunctions/arm_power_f32.c",
    f"{_MODULES}/axis3fSubSampler.c",
    f"{_MODULES}/collision_avoidance.c",
    f"{_MODULES}/controller/attitude_pid_controller.c",
    f"{_MODULES}/controller/controller_brescianini.c",
    f"{_MODULES}/controller/controller_lee.c",
    f"{_MODULES}/controller/controller_mellinger.c",
    f"{_MODULES}/controller/controller_pid.c",
    f"{_MODULES}/controller/position_controller_pid.c",
    f"{_MODULES}/kalman_core/kalman_core.c",
    f"{_MODULES}/kalman_core/mm_tdoa.c",
    f"{_MODULES}/outlierfilter/outlierFilterTdoa.c",
    f"{_MODULES}/planner.c",
    f"{_MODULES}/power_distribution_quadrotor.c",
    f"{_MODULES}/pptraj.c",
    f"{_MODULES}/pptraj_compressed.c",
    "src/utils/src/filter.c",
    "src/utils/src/num.c",
    "src/utils/src/pid.c",
)

GENERATED = "build/include/generated"
"""Where upstream's build leaves its configuration header; ours takes the place."""

INCLUDE_DIRS = (
    "src/modules/interface",
    "src/modules/interface/controller",
    "src/modules/interface/kalman_core",
    "src/modules/interface/outlierfilter",
    "src/hal/interface",
    "src/utils/interface/lighthouse",
    "src/utils/interface",
    GENERATED,
    "src/config",
    "src/drivers/interface",
    "src/platform/interface",
    "vendor/CMSIS/CMSIS/DSP/Include",
    "vendor/CMSIS/CMSIS/Core/Include",
)

FLAGS = ("-O3", "-fno-strict-aliasing", "-Wno-address-of-packed-member", "-DUNIT_TEST_MODE")
