#include "onboard/health.h"

#include <string.h>

#include "variable_row.h"

#define TEST_NONE 0
#define TEST_PROPELLERS 1
#define TEST_BATTERY 2

typedef struct {
  uint32_t on;              // [ms], a motor turns
  uint32_t off;             // [ms], and rests
  uint32_t variance_start;  // [ms], when it has settled
  uint16_t propeller_ratio;
  uint16_t battery_ratio;
} schedule_t;

static const schedule_t BRUSHED   = {50, 950, 0, 65535, 40000};
static const schedule_t BRUSHLESS = {2000, 1000, 1000, 10000, 40000};

#define GOOD_SAG 0.95f  // [V]

void cf_health_init(cf_health_t *health, cf_platform_t platform) {
  *health              = (cf_health_t){.test = TEST_NONE};
  health->is_brushless = platform == CF_PLATFORM_CF21BL;
}

static void start_motor(cf_health_t *health, uint8_t motor) {
  health->motor   = motor;
  health->tick    = 0;
  health->samples = 0;
  memset(health->sum, 0, sizeof health->sum);
  memset(health->sum_of_squares, 0, sizeof health->sum_of_squares);
}

bool cf_health_is_running(cf_health_t *health, bool is_flying) {
  if (health->test != TEST_NONE) {
    return true;
  }
  if (health->start_propeller_test == 0 && health->start_battery_test == 0) {
    return false;
  }

  if (!is_flying) {
    health->test = health->start_propeller_test != 0 ? TEST_PROPELLERS : TEST_BATTERY;
    start_motor(health, 0);
    if (health->test == TEST_PROPELLERS) {
      health->motor_pass = 0;
    }
  }
  health->start_propeller_test = 0;
  health->start_battery_test   = 0;
  return health->test != TEST_NONE;
}

bool cf_health_is_testing_propellers(const cf_health_t *health) {
  return health->test == TEST_PROPELLERS;
}

static float variance(float sum, float sum_of_squares, uint32_t samples) {
  const float n    = (float)samples;
  const float mean = sum / n;
  return sum_of_squares / n - mean * mean;
}

static void listen(cf_health_t *health, const Axis3f *acc) {
  for (int i = 0; i < 2; i++) {
    health->sum[i] += acc->axis[i];
    health->sum_of_squares[i] += acc->axis[i] * acc->axis[i];
  }
  health->samples++;
}

// The threshold of the firmware is 0, which lets every propeller pass.
static void finish_motor(cf_health_t *health) {
  const uint8_t motor       = health->motor;
  health->variance_x[motor] = variance(health->sum[0], health->sum_of_squares[0], health->samples);
  health->variance_y[motor] = variance(health->sum[1], health->sum_of_squares[1], health->samples);
  health->motor_pass        = (uint8_t)(health->motor_pass | 1 << motor);
  if (motor + 1 < STABILIZER_NR_OF_MOTORS) {
    start_motor(health, (uint8_t)(motor + 1));
  } else {
    health->motor_tests++;
    health->test = TEST_NONE;
  }
}

static void test_propellers(cf_health_t *health, const schedule_t *times, const Axis3f *acc,
                            motors_thrust_pwm_t *motors) {
  if (health->tick < times->on) {
    motors->list[health->motor] = times->propeller_ratio;
    if (health->tick >= times->variance_start) {
      listen(health, acc);
    }
  }
  health->tick++;
  if (health->tick == times->on + times->off) {
    finish_motor(health);
  }
}

static void test_battery(cf_health_t *health, const schedule_t *times, float voltage,
                         motors_thrust_pwm_t *motors) {
  if (health->tick == 0) {
    health->rest_voltage  = voltage;
    health->least_voltage = voltage;
  }
  if (voltage < health->least_voltage) {
    health->least_voltage = voltage;
  }
  if (health->tick < times->on) {
    for (int i = 0; i < STABILIZER_NR_OF_MOTORS; i++) {
      motors->list[i] = times->battery_ratio;
    }
  }
  health->tick++;
  if (health->tick == times->on + times->off) {
    health->battery_sag  = health->rest_voltage - health->least_voltage;
    health->battery_pass = health->battery_sag < GOOD_SAG;
    health->test         = TEST_NONE;
  }
}

void cf_health_run(cf_health_t *health, const Axis3f *acc, float voltage,
                   motors_thrust_pwm_t *motors) {
  const schedule_t *times = health->is_brushless ? &BRUSHLESS : &BRUSHED;
  memset(motors, 0, sizeof *motors);
  if (health->test == TEST_PROPELLERS) {
    test_propellers(health, times, acc, motors);
  } else {
    test_battery(health, times, voltage, motors);
  }
}

static const cf_variable_t PARAMETERS[] = {
    CF_ROW("health", "startPropTest", UINT8, CF_CORE, cf_health_t, start_propeller_test),
    CF_ROW("health", "startBatTest", UINT8, CF_CORE, cf_health_t, start_battery_test),
};

static const cf_variable_t LOGS[] = {
    CF_ROW("health", "motorVarXM1", FLOAT, 0, cf_health_t, variance_x[0]),
    CF_ROW("health", "motorVarYM1", FLOAT, 0, cf_health_t, variance_y[0]),
    CF_ROW("health", "motorVarXM2", FLOAT, 0, cf_health_t, variance_x[1]),
    CF_ROW("health", "motorVarYM2", FLOAT, 0, cf_health_t, variance_y[1]),
    CF_ROW("health", "motorVarXM3", FLOAT, 0, cf_health_t, variance_x[2]),
    CF_ROW("health", "motorVarYM3", FLOAT, 0, cf_health_t, variance_y[2]),
    CF_ROW("health", "motorVarXM4", FLOAT, 0, cf_health_t, variance_x[3]),
    CF_ROW("health", "motorVarYM4", FLOAT, 0, cf_health_t, variance_y[3]),
    CF_ROW("health", "motorPass", UINT8, CF_CORE, cf_health_t, motor_pass),
    CF_ROW("health", "batterySag", FLOAT, 0, cf_health_t, battery_sag),
    CF_ROW("health", "batteryPass", UINT8, CF_CORE, cf_health_t, battery_pass),
    CF_ROW("health", "motorTestCount", UINT16, CF_CORE, cf_health_t, motor_tests),
};

cf_variables_t cf_health_parameters(void) {
  return CF_TABLE(PARAMETERS);
}

cf_variables_t cf_health_logs(void) {
  return CF_TABLE(LOGS);
}
