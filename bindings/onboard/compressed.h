/* Estimate and setpoint in whole numbers, half as long: what the log groups stateEstimateZ and
 * ctrltargetZ hold (docs/reference/control-pid.md#16).
 *
 * Fractions are cut towards zero. What exceeds 16 bits (33 m) wraps around, as on the vehicle. */
#ifndef CF_ONBOARD_COMPRESSED_H
#define CF_ONBOARD_COMPRESSED_H

#include <stdint.h>

#include "api/stabilizer_types.h"

typedef struct {
  int16_t  x, y, z;                       // [mm]
  int16_t  vx, vy, vz;                    // [mm/s]
  int16_t  ax, ay, az;                    // [mm/s^2], with gravity: z = +9810 at rest
  uint32_t quat;                          // see quatcompress.h
  int16_t  rateRoll, ratePitch, rateYaw;  // [mrad/s], legacy pitch
} cf_compressed_state_t;

typedef struct {
  int16_t x, y, z;     // [mm]
  int16_t vx, vy, vz;  // [mm/s]
  int16_t ax, ay, az;  // [mm/s^2]
} cf_compressed_setpoint_t;

// Pure. gyro [deg/s] is what the sensors measured last.
cf_compressed_state_t    cf_compress_state(const state_t *state, const Axis3f *gyro);
cf_compressed_setpoint_t cf_compress_setpoint(const setpoint_t *setpoint);

#endif  // CF_ONBOARD_COMPRESSED_H
