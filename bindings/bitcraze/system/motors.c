/* The driver of the motors between a ratio and a duty. Compensation of the battery is ours, with
 * the checkout's constants (own/motor_layer.h): upstream's stands among registers and timers. */
#include "bitcraze/system/system.h"

#include <string.h>

#include "bitcraze/own/motor_layer.h"
#include "bitcraze/rtos/hardware.h"

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
