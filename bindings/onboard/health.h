/* The health tests: each motor is spun briefly while the accelerometer shakes, or all of them while
 * the battery sags.
 *
 * While one runs, the loop does nothing else (docs/reference/control-pid.md#4). Times and ratios:
 * docs/reference/control-pid.md#12, docs/reference/planner-commander.md#15. Not established, chosen
 * here: the ratio of the brushless propeller test, the sag that a good battery may have, the names
 * of the log variables, and that a request in flight is dropped. */
#ifndef CF_ONBOARD_HEALTH_H
#define CF_ONBOARD_HEALTH_H

#include <stdbool.h>
#include <stdint.h>

#include "api/stabilizer_types.h"
#include "platform.h"
#include "variables.h"

typedef struct {
  // parameters; a request clears itself when its test starts
  uint8_t start_propeller_test;
  uint8_t start_battery_test;

  bool is_brushless;

  // the running test
  uint8_t  test;   // 0 none, 1 propellers, 2 battery
  uint8_t  motor;  // [0, 3], of the propeller test
  uint32_t tick;   // [ms], since the motor, or all of them, started
  uint32_t samples;
  float    sum[2];             // [g], of the accelerometer's x and y
  float    sum_of_squares[2];  // [g^2]
  float    rest_voltage;       // [V], before the motors turned
  float    least_voltage;      // [V]

  // results, logged
  float    variance_x[STABILIZER_NR_OF_MOTORS];  // [g^2]
  float    variance_y[STABILIZER_NR_OF_MOTORS];  // [g^2]
  uint8_t  motor_pass;                           // bit per motor
  uint16_t motor_tests;                          // propeller tests since boot
  float    battery_sag;                          // [V]
  uint8_t  battery_pass;
} cf_health_t;

void cf_health_init(cf_health_t *health, cf_platform_t platform);

// Takes up a request, unless the drone flies. Returns whether a test runs.
bool cf_health_is_running(cf_health_t *health, bool is_flying);

// Returns whether the running test is that of the propellers.
bool cf_health_is_testing_propellers(const cf_health_t *health);

// One millisecond of the running test: acc [g] and battery voltage [V] in, motor ratios out.
void cf_health_run(cf_health_t *health, const Axis3f *acc, float voltage,
                   motors_thrust_pwm_t *motors);

cf_variables_t cf_health_parameters(void);
cf_variables_t cf_health_logs(void);

#endif  // CF_ONBOARD_HEALTH_H
