/* The driver of the motors between a ratio and a duty. Compensation of the battery is ours, with
 * the checkout's constants (own/motor_layer.h): upstream's stands among registers and timers. */
#include "bitcraze/system/system.h"

#include <string.h>

#include "bitcraze/own/motor_layer.h"
#include "bitcraze/rtos/hardware.h"

// How the health test turns a motor: on and off [ms], when the variance is measured from [ms], and
// the ratios of the tests of propellers and battery (docs/reference/control-pid.md#4; brushless
// motors take longer to settle).
typedef struct {
  uint16_t on;
  uint16_t off;
  uint16_t variance_start;
  uint16_t propeller_ratio;
  uint16_t battery_ratio;
} schedule_t;

void *motorsGetHealthTestSettings(uint32_t id);

// Returns a MotorHealthTestDef, whose five members have been these since there is one.
void *motorsGetHealthTestSettings(uint32_t id CF_UNUSED) {
#if CONFIG_MOTORS_REQUIRE_ARMING
  static const schedule_t SCHEDULE = {2000, 1000, 1000, 10000, 40000};
#else
  static const schedule_t SCHEDULE = {50, 950, 0, 65535, 40000};
#endif
  return (void *)(uintptr_t)&SCHEDULE;
}

#if HAVE_MOTORS_COMPENSATE
float motorsCompensateBatteryVoltage(uint32_t id, float iThrust, float supplyVoltage);

// Asked by the loop, motor by motor.
float motorsCompensateBatteryVoltage(uint32_t id, float iThrust, float supplyVoltage) {
#if CONFIG_ENABLE_THRUST_BAT_COMPENSATED
  return (float)cf_motor_layer_compensate_one((int)id, (int32_t)iThrust, supplyVoltage);
#else
  (void)id, (void)supplyVoltage;
  return iThrust;
#endif
}

static void compensate(float battery_voltage CF_UNUSED, api_motors_thrust_pwm_t *motors CF_UNUSED) {
}
#else
// Older drivers compensate by themselves when a ratio is set.
static void compensate(float battery_voltage CF_UNUSED, api_motors_thrust_pwm_t *motors CF_UNUSED) {
#if CONFIG_ENABLE_THRUST_BAT_COMPENSATED
  for (int i = 0; i < CF_HARDWARE_MOTORS; i++) {
    const int32_t duty = cf_motor_layer_compensate_one(i, motors->list[i], battery_voltage);
    motors->list[i]    = (uint16_t)(duty < 0 ? 0 : duty > UINT16_MAX ? UINT16_MAX : duty);
  }
#endif
}
#endif

void cf_system_motors(float battery_voltage, api_motors_thrust_pwm_t *motors) {
  memcpy(motors->list, cf_hardware_motors, sizeof motors->list);
  compensate(battery_voltage, motors);
}
