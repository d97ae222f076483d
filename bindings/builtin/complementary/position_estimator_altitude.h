/* Height and climb rate from barometer or range finder, and the vertical acceleration
 * (docs/reference/estimators.md#10.3).
 *
 * Without a range finder the height is that of the barometer, above sea level. With the first
 * useful range it becomes the distance to the ground, for the rest of the run. */
#ifndef CF_BUILTIN_COMPLEMENTARY_POSITION_ESTIMATOR_ALTITUDE_H
#define CF_BUILTIN_COMPLEMENTARY_POSITION_ESTIMATOR_ALTITUDE_H

#include <stdbool.h>
#include <stdint.h>

#include "api/stabilizer_types.h"
#include "variables.h"

typedef struct {
  // parameters
  float estAlphaZrange;  // part of the old height that is kept when a range comes
  float estAlphaAsl;     // the same for the barometer
  float velocityFactor;  // on the integrated velocity
  float vAccDeadband;    // [g]
  float velZAlpha;       // part of the integrated velocity that is kept per update

  // state
  float estimatedZ;            // [m]
  float velocityZ;             // [m/s], integral of the acceleration, leaking
  float estimatedVZ;           // [m/s], change of the height
  bool  is_surface_following;  // a useful range has been seen
} cf_altitude_t;

// Writes the whole struct: the state after boot.
void cf_altitude_init(cf_altitude_t *altitude);

// Integrates the vertical acceleration [g] over dt [s].
void cf_altitude_update_velocity(cf_altitude_t *altitude, float acc_wz, float dt);

// Takes one step of dt [s]; a range is useful for 50 ms. Writes the position (x and y are 0) and
// the vertical velocity of `estimate`, nothing else of it.
void cf_altitude_estimate(cf_altitude_t *altitude, state_t *estimate, const baro_t *baro,
                          const tofMeasurement_t *tof, float dt, uint32_t now_ms);

// Group posEstAlt. Offsets count from cf_altitude_t.
cf_variables_t cf_altitude_parameters(void);
cf_variables_t cf_altitude_logs(void);

#endif  // CF_BUILTIN_COMPLEMENTARY_POSITION_ESTIMATOR_ALTITUDE_H
