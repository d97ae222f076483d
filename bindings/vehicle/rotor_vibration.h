/* Lines in the spectrum of the IMU: what four rotors that are out of balance shake it with.
 *
 * Each rotor adds, at its own speed W, a vector that turns in the x-y plane, and at 2 W (two blades
 * pass) a shake along z, both growing with W^2. docs/reference/vehicle.md#10 knows amplitudes of
 * 0.1 to 0.5 m/s^2 at W and 2 W; how they spread over the axes is not established and chosen here.
 * Off by default: the noise in flight of imu.h holds on average what the lines would add. */
#ifndef CF_VEHICLE_ROTOR_VIBRATION_H
#define CF_VEHICLE_ROTOR_VIBRATION_H

#include <stdbool.h>

#include "status.h"

#define CF_VIBRATING_ROTORS 4

typedef struct {
  float acc;   // [m/s^2] >= 0, amplitude of one rotor in hover; 0 = off
  float gyro;  // [rad/s] >= 0, the same; 0 = off
} cf_rotor_vibration_config_t;

typedef struct {
  cf_rotor_vibration_config_t config;
  bool                        is_on;
  float                       phase[CF_VIBRATING_ROTORS];  // [rad], in [0, 2 pi)
} cf_rotor_vibration_t;

// Fills the lines. Returns CF_ERR_VALUE when an amplitude is negative or not a number.
cf_status_t cf_rotor_vibration_init(cf_rotor_vibration_t              *vibration,
                                    const cf_rotor_vibration_config_t *config);

// Turns the rotors on by 1 ms and adds what the IMU feels of them to body rates [rad/s] and
// specific force [m/s^2], at speeds [rpm] of which `hover_rpm` is that of hover.
void cf_rotor_vibration_add(cf_rotor_vibration_t *vibration, const float rpm[CF_VIBRATING_ROTORS],
                            float hover_rpm, float rates[3], float force[3]);

#endif  // CF_VEHICLE_ROTOR_VIBRATION_H
