/* The control chain under extreme inputs: nothing undefined, nothing out of range, nothing endless.
 */
#include <math.h>
#include <string.h>

#include "api/axis3fSubSampler.h"
#include "api/filter.h"
#include "api/num.h"
#include "api/pid.h"
#include "builtin/control/controller_pid.h"
#include "builtin/power/battery_compensation.h"
#include "builtin/power/motor_override.h"
#include "builtin/power/power_distribution.h"
#include "check.h"
#include "extremes.h"

static void test_pid_with_extremes(void) {
  for (int i = 0; i < EXTREME_COUNT; i++) {
    for (int j = 0; j < EXTREME_COUNT; j++) {
      PidObject pid = {0};
      pidInit(&pid, EXTREMES[i], 1.0f, 1.0f, 1.0f, 1.0f, 0.01f, 100.0f, 20.0f, i % 2 == 0);
      pid.outputLimit    = 10.0f;
      const float output = pidUpdate(&pid, EXTREMES[j], j % 2 == 0);
      CHECK(isnan(output) || fabsf(output) <= 10.0f);
      CHECK(!isnan(pid.deriv));
    }
  }
}

static void test_filters_with_extremes(void) {
  for (int i = 0; i < EXTREME_COUNT; i++) {
    lpf2pData lpf = {0};
    lpf2pInit(&lpf, 100.0f, EXTREMES[i]);
    lpf2pInit(&lpf, EXTREMES[i], 20.0f);
    lpf2pInit(&lpf, 100.0f, 20.0f);
    lpf2pReset(&lpf, EXTREMES[i]);
    lpf2pApply(&lpf, EXTREMES[i]);

    // whatever came in, the filter settles again
    float output = NAN;
    for (int k = 0; k < 200; k++) {
      output = lpf2pApply(&lpf, 1.0f);
    }
    CHECK(fabsf(output - 1.0f) < 1e-3f || fabsf(EXTREMES[i]) >= 1e20f);

    Butterworth2LowPass butterworth;
    init_butterworth_2_low_pass(&butterworth, EXTREMES[i], 0.002f, EXTREMES[i]);
    update_butterworth_2_low_pass(&butterworth, EXTREMES[i]);
  }
}

static void test_integer_filter_at_its_borders(void) {
  const int32_t values[] = {INT32_MIN, INT32_MIN + 1, -65536, -1, 0, 1, 65535, INT32_MAX};
  for (int i = 0; i < 8; i++) {
    for (int j = 0; j < 8; j++) {
      for (int k = 0; k < 8; k++) {
        int32_t filt = values[k];
        iirLPFilterSingle(values[i], values[j], &filt);
      }
    }
  }

  // a full share takes the input over at once
  int32_t filt = 0;
  CHECK(iirLPFilterSingle(-1234, 256, &filt) == -1234);
  CHECK(iirLPFilterSingle(1234, INT32_MAX, &filt) == 1234);
}

static void test_numbers_with_extremes(void) {
  CHECK(limitUint16(INT32_MIN) == 0);
  CHECK(limitUint16(INT32_MAX) == UINT16_MAX);
  for (int i = 0; i < EXTREME_COUNT; i++) {
    const float bounded = constrain(EXTREMES[i], -1.0f, 1.0f);
    CHECK(isnan(EXTREMES[i]) ? isnan(bounded) : fabsf(bounded) <= 1.0f);
    CHECK(!(fabsf(deadband(EXTREMES[i], 1.0f)) > fabsf(EXTREMES[i])));
    CHECK(isnan(half2single(single2half(EXTREMES[i]))) == isnan(EXTREMES[i]));
  }

  // every half has a single
  for (uint32_t half = 0; half <= UINT16_MAX; half++) {
    const float single = half2single((uint16_t)half);
    CHECK(isnan(single) == ((half & 0x7C00u) == 0x7C00u && (half & 0x3FFu) != 0u));
  }
}

static void test_sub_sampler_with_extremes(void) {
  uint32_t           seed = 7;
  Axis3fSubSampler_t sampler;
  axis3fSubSamplerInit(&sampler, 2.0f);
  for (int i = 0; i < 100; i++) {
    const Axis3f sample = random_axes(&seed);
    axis3fSubSamplerAccumulate(&sampler, &sample);
  }
  CHECK(isnan(axis3fSubSamplerFinalize(&sampler)->x));

  const Axis3f good = {.axis = {1.0f, 2.0f, 3.0f}};
  axis3fSubSamplerAccumulate(&sampler, &good);
  CHECK(axis3fSubSamplerFinalize(&sampler)->z == 6.0f);
}

// the whole chain, with everything extreme at once
static void test_chain_with_extremes(cf_platform_t platform) {
  uint32_t seed = 12345;
  for (int flight = 0; flight < 300; flight++) {
    cf_controller_pid_t     pid;
    cf_power_distribution_t power;
    CHECK(cf_controller_pid_init(&pid, platform) == CF_OK);
    CHECK(cf_power_distribution_init(&power, platform) == CF_OK);
    pid.attitude.yaw_max_delta = random_extreme(&seed);
    pid.position.roll_max      = random_extreme(&seed);

    control_t                control     = {0};
    motors_thrust_uncapped_t uncapped    = {0};
    motors_thrust_uncapped_t compensated = {0};
    motors_thrust_pwm_t      pwm         = {0};
    for (uint32_t step = 1; step <= 40; step++) {
      const setpoint_t   setpoint = random_setpoint(&seed);
      const state_t      state    = random_state(&seed);
      const sensorData_t sensors  = {.gyro = random_axes(&seed), .acc = random_axes(&seed)};
      cf_controller_pid_update(&pid, &control, &setpoint, &sensors, &state, step);
      CHECK(control.roll >= -32767 && control.pitch >= -32767 && control.yaw >= -32767);

      // at rest the yaw target is the state's, whatever that is
      const bool  turned = step % 2u == 0u && control.thrust != 0.0f;
      const float yaw    = pid.attitude_desired.yaw;
      CHECK(!turned || isnan(yaw) || fabsf(yaw) <= 180.0f);

      cf_power_distribution_update(&power, &control, &uncapped);
      cf_power_distribution_compensate(&power, &uncapped, random_extreme(&seed), &compensated);
      cf_power_distribution_cap(&power, &compensated, &pwm);
      const uint32_t idle = cf_power_distribution_idle_thrust(&power);
      for (int i = 0; i < 4; i++) {
        CHECK(pwm.list[i] >= idle);
      }
    }
  }
}

static void test_a_poisoned_state_recovers_at_zero_thrust(void) {
  cf_controller_pid_t pid;
  CHECK(cf_controller_pid_init(&pid, CF_PLATFORM_CF2) == CF_OK);
  control_t          control = {0};
  const setpoint_t   hover   = {.mode = {.x = modeAbs, .y = modeAbs, .z = modeAbs, .yaw = modeAbs}};
  const setpoint_t   null    = {0};
  const sensorData_t sensors = {0};
  const state_t      good    = {0};
  const state_t      poisoned = {.position = {.x = NAN, .y = NAN, .z = NAN},
                                 .attitude = {.roll = NAN, .pitch = NAN, .yaw = NAN}};
  cf_controller_pid_update(&pid, &control, &hover, &sensors, &poisoned, 10);
  CHECK(control.roll == 0 && control.pitch == 0 && control.yaw == 0);
  CHECK(isnan(control.thrust));

  cf_controller_pid_update(&pid, &control, &null, &sensors, &good, 12);
  cf_controller_pid_update(&pid, &control, &hover, &sensors, &good, 20);
  CHECK(control.thrust == 36000.0f);
  CHECK(control.roll == 0 && control.pitch == 0 && control.yaw == 0);
}

static void test_mixer_with_extremes(void) {
  cf_power_distribution_t power;
  CHECK(cf_power_distribution_init(&power, CF_PLATFORM_CF21BL) == CF_OK);
  uint32_t seed = 99;
  for (int i = 0; i < 20000; i++) {
    control_t control   = {.normalizedForces = {random_extreme(&seed), random_extreme(&seed),
                                                random_extreme(&seed), random_extreme(&seed)}};
    control.controlMode = (control_mode_t)(next_random(&seed) % 5u);
    motors_thrust_uncapped_t uncapped = {.list = {-1, -1, -1, -1}};
    cf_power_distribution_update(&power, &control, &uncapped);
    for (int k = 0; k < 4; k++) {
      switch (control.controlMode) {
        case controlModeLegacy:
          break;
        case controlModeForceTorque:
          CHECK(uncapped.list[k] >= 0);
          break;
        case controlModeForce:
        case controlModePWM:
          CHECK(uncapped.list[k] >= 0 && uncapped.list[k] <= 65535);
          break;
        default:
          CHECK(uncapped.list[k] == -1);
      }
    }
  }
}

static void test_compensation_with_extremes(void) {
  const cf_thrust_curve_t *curve = &cf_platform_facts(CF_PLATFORM_CF2)->thrust;
  for (int i = 0; i < EXTREME_COUNT; i++) {
    for (int j = 0; j < EXTREME_COUNT; j++) {
      const float duty = cf_battery_compensate(curve, EXTREMES[i], EXTREMES[j]);
      CHECK(isnan(duty) || duty >= 0.0f);

      cf_motor_override_t motor_override;
      cf_motor_override_init(&motor_override);
      motor_override.enable   = 3;
      motor_override.motor[0] = UINT16_MAX;
      motors_thrust_pwm_t pwm = {0};
      cf_motor_override_apply(&motor_override, curve, EXTREMES[j], &pwm);
      CHECK(pwm.list[0] == pwm.list[3]);
    }
  }
}

int main(void) {
  test_pid_with_extremes();
  test_filters_with_extremes();
  test_integer_filter_at_its_borders();
  test_numbers_with_extremes();
  test_sub_sampler_with_extremes();
  test_chain_with_extremes(CF_PLATFORM_CF2);
  test_chain_with_extremes(CF_PLATFORM_CF21BL);
  test_a_poisoned_state_recovers_at_zero_thrust();
  test_mixer_with_extremes();
  test_compensation_with_extremes();
  return 0;
}
