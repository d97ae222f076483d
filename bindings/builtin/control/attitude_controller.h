/* Attitude and rate loops: degrees to body rates, body rates to actuator counts, at 500 Hz
 * (docs/reference/control-pid.md#9).
 *
 * Angles are in the legacy frame: a positive pitch lifts the nose. */
#ifndef CF_BUILTIN_CONTROL_ATTITUDE_CONTROLLER_H
#define CF_BUILTIN_CONTROL_ATTITUDE_CONTROLLER_H

#include <stdbool.h>
#include <stdint.h>

#include "api/pid.h"
#include "api/stabilizer_types.h"
#include "builtin/platform_defaults.h"
#include "variables.h"

typedef struct {
  PidObject roll_rate;   // deg/s -> counts
  PidObject pitch_rate;  // deg/s -> counts
  PidObject yaw_rate;    // deg/s -> counts
  PidObject roll;        // deg -> deg/s
  PidObject pitch;       // deg -> deg/s
  PidObject yaw;         // deg -> deg/s

  // parameters
  float yaw_max_delta;  // [deg], 0 for no bound

  // parameters that act only while the controller boots
  float  attitude_cutoff;          // [Hz]
  float  roll_rate_cutoff;         // [Hz]
  float  pitch_rate_cutoff;        // [Hz]
  float  yaw_rate_cutoff;          // [Hz]
  int8_t attitude_filter_enabled;  // 0 or 1
  int8_t rate_filter_enabled;      // 0 or 1

  // outputs of the rate loop, within [-32767, 32767]
  int16_t roll_output;
  int16_t pitch_output;
  int16_t yaw_output;
} cf_attitude_controller_t;

// Writes the whole struct: the state after boot, with the gains of the platform.
void cf_attitude_controller_init(cf_attitude_controller_t     *attitude,
                                 const cf_platform_defaults_t *defaults);

// Angle loop: from measured and desired angles [deg] to desired rates [deg/s].
void cf_attitude_controller_correct_attitude(cf_attitude_controller_t *attitude,
                                             const attitude_t *measured, const attitude_t *desired,
                                             attitude_t *rate_desired);

// Rate loop: from measured and desired rates [deg/s] to the outputs in the struct. Returns false
// when one of them is not a number; it is 0 then.
bool cf_attitude_controller_correct_rate(cf_attitude_controller_t *attitude,
                                         const attitude_t *measured, const attitude_t *desired);

// Resets the angle PIDs at the present angles [deg] and the rate PIDs at zero. Only roll, pitch and
// yaw of `measured` are read.
void cf_attitude_controller_reset(cf_attitude_controller_t *attitude, const attitude_t *measured);
void cf_attitude_controller_reset_roll(cf_attitude_controller_t *attitude, float roll);
void cf_attitude_controller_reset_pitch(cf_attitude_controller_t *attitude, float pitch);

// Tables of pid_attitude and pid_rate, offsets relative to cf_attitude_controller_t.
cf_variables_t cf_attitude_controller_parameters(void);
cf_variables_t cf_attitude_controller_logs(void);

#endif  // CF_BUILTIN_CONTROL_ATTITUDE_CONTROLLER_H
