/* The controllers INDI and Brescianini under extreme inputs: nothing undefined, nothing out of
 * range. */
#include <math.h>
#include <string.h>

#include "builtin/control/controller_brescianini.h"
#include "builtin/control/controller_indi.h"
#include "builtin/control/controller_pid.h"
#include "builtin/power/power_distribution.h"
#include "check.h"
#include "extremes.h"

// whatever a controller wrote becomes four duties
static void check_motors(const cf_power_distribution_t *power, const control_t *control) {
  motors_thrust_uncapped_t uncapped = {0};
  motors_thrust_pwm_t      pwm      = {0};
  cf_power_distribution_update(power, control, &uncapped);
  cf_power_distribution_cap(power, &uncapped, &pwm);
  for (int i = 0; i < 4; i++) {
    CHECK(pwm.list[i] >= cf_power_distribution_idle_thrust(power));
  }
}

// every float of a group of parameters becomes extreme
static void spoil(void *base, cf_variables_t table, uint32_t *seed) {
  for (int i = 0; i < table.count; i++) {
    const float value = random_extreme(seed);
    if (table.rows[i].type == CF_TYPE_FLOAT) {
      memcpy((char *)base + table.rows[i].offset, &value, sizeof value);
    }
  }
}

static void test_indi_with_extremes(cf_platform_t platform) {
  uint32_t                seed = 4711;
  cf_power_distribution_t power;
  CHECK(cf_power_distribution_init(&power, platform) == CF_OK);
  for (int flight = 0; flight < 300; flight++) {
    controllerINDI_t    indi;
    cf_controller_pid_t pid;
    cf_controller_indi_boot(&indi);
    CHECK(cf_controller_pid_init(&pid, platform) == CF_OK);
    if (flight % 3 == 1) {
      spoil(&indi, cf_controller_indi_parameters(), &seed);
      spoil(&indi.position, cf_position_controller_indi_parameters(), &seed);
    }
    indi.outerLoopActive = flight % 4 == 3 ? 0 : 255;
    controllerINDIInit(&indi, &pid);

    control_t control = {0};
    for (uint32_t step = 0; step <= 40; step++) {
      const setpoint_t   setpoint = random_setpoint(&seed);
      const state_t      state    = random_state(&seed);
      const sensorData_t sensors  = {.gyro = random_axes(&seed), .acc = random_axes(&seed)};
      controllerINDI(&indi, &pid, &control, &setpoint, &sensors, &state, step);
      CHECK(control.controlMode == controlModeLegacy);
      CHECK(control.roll >= -32767 && control.pitch >= -32767 && control.yaw >= -32767);
      check_motors(&power, &control);
    }
  }
}

static void test_a_poisoned_indi_recovers_at_init(void) {
  controllerINDI_t    indi;
  cf_controller_pid_t pid;
  cf_controller_indi_boot(&indi);
  CHECK(cf_controller_pid_init(&pid, CF_PLATFORM_CF2) == CF_OK);
  controllerINDIInit(&indi, &pid);

  control_t          control  = {0};
  const setpoint_t   hover    = {.mode   = {.x = modeAbs, .y = modeAbs, .z = modeDisable},
                                 .thrust = 30000.0f};
  const sensorData_t sensors  = {.acc = {.axis = {0.0f, 0.0f, 1.0f}}};
  const state_t      good     = {0};
  const state_t      poisoned = {.attitude = {.roll = NAN, .pitch = NAN, .yaw = NAN}};
  controllerINDI(&indi, &pid, &control, &hover, &sensors, &poisoned, 2);
  CHECK(control.roll == 0 && control.pitch == 0 && control.yaw == 0);

  controllerINDIInit(&indi, &pid);
  controllerINDI(&indi, &pid, &control, &hover, &sensors, &good, 4);
  CHECK(isfinite(indi.indi.u_in.p) && isfinite(indi.indi.u_in.q));
}

static void test_brescianini_with_extremes(cf_platform_t platform) {
  uint32_t                seed = 815;
  cf_power_distribution_t power;
  CHECK(cf_power_distribution_init(&power, platform) == CF_OK);
  for (int flight = 0; flight < 300; flight++) {
    controllerBrescianini_t brescianini;
    CHECK(cf_controller_brescianini_boot(&brescianini, platform) == CF_OK);
    if (flight % 3 == 1) {
      spoil(&brescianini, cf_controller_brescianini_parameters(), &seed);
    }

    control_t control = {0};
    for (uint32_t step = 0; step <= 40; step++) {
      const setpoint_t   setpoint = random_setpoint(&seed);
      const state_t      state    = random_state(&seed);
      const sensorData_t sensors  = {.gyro = random_axes(&seed)};
      controllerBrescianini(&brescianini, &control, &setpoint, &sensors, &state, step);
      CHECK(control.controlMode == controlModeForceTorque);
      CHECK(setpoint.mode.z != modeDisable || control.thrustSi == 0.0f);
      CHECK(isnan(control.thrustSi) || control.thrustSi <= 18.0f * brescianini.mass);
      check_motors(&power, &control);
    }
  }
}

static void test_a_poisoned_brescianini_recovers_at_its_next_outer_step(void) {
  controllerBrescianini_t brescianini;
  CHECK(cf_controller_brescianini_boot(&brescianini, CF_PLATFORM_CF2) == CF_OK);
  control_t          control  = {0};
  const setpoint_t   hover    = {.mode = {.z = modeAbs}};
  const sensorData_t sensors  = {0};
  const state_t      good     = {.attitudeQuaternion = {.w = 1.0f}};
  const state_t      poisoned = {.position = {.x = NAN}, .attitudeQuaternion = {.w = 1.0f}};
  controllerBrescianini(&brescianini, &control, &hover, &sensors, &poisoned, 10);
  CHECK(isnan(control.torqueX));
  controllerBrescianini(&brescianini, &control, &hover, &sensors, &good, 20);
  CHECK(control.torqueX == 0.0f && control.thrustSi > 0.0f);
}

static void test_yaw_angles_of_every_size(void) {
  for (int i = 0; i < EXTREME_COUNT; i++) {
    controllerINDI_t    indi;
    cf_controller_pid_t pid;
    cf_controller_indi_boot(&indi);
    CHECK(cf_controller_pid_init(&pid, CF_PLATFORM_CF2) == CF_OK);
    controllerINDIInit(&indi, &pid);
    control_t          control  = {0};
    const sensorData_t sensors  = {0};
    const state_t      state    = {0};
    const setpoint_t   setpoint = {.attitude = {.yaw = EXTREMES[i]}, .thrust = 30000.0f};
    controllerINDI(&indi, &pid, &control, &setpoint, &sensors, &state, 2);
    const float yaw = indi.attitudeDesired.yaw;
    CHECK(isfinite(EXTREMES[i]) ? fabsf(yaw) <= 3.1415927f : isnan(yaw));
  }
}

int main(void) {
  test_indi_with_extremes(CF_PLATFORM_CF2);
  test_indi_with_extremes(CF_PLATFORM_CF21BL);
  test_a_poisoned_indi_recovers_at_init();
  test_brescianini_with_extremes(CF_PLATFORM_CF2);
  test_brescianini_with_extremes(CF_PLATFORM_CF21BL);
  test_a_poisoned_brescianini_recovers_at_its_next_outer_step();
  test_yaw_angles_of_every_size();
  return 0;
}
