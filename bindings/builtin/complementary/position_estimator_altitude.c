#include "builtin/complementary/position_estimator_altitude.h"

#include "api/num.h"
#include "variable_row.h"

#define GRAVITY 9.81f      // [m/s^2]
#define MAX_RANGE_AGE 50u  // [ms]

void cf_altitude_init(cf_altitude_t *altitude) {
  *altitude = (cf_altitude_t){
      .estAlphaZrange = 0.90f,
      .estAlphaAsl    = 0.90f,
      .velocityFactor = 1.0f,
      .vAccDeadband   = 0.04f,
      .velZAlpha      = 0.995f,
  };
}

void cf_altitude_update_velocity(cf_altitude_t *altitude, float acc_wz, float dt) {
  altitude->velocityZ += deadband(acc_wz, altitude->vAccDeadband) * dt * GRAVITY;
  altitude->velocityZ *= altitude->velZAlpha;
}

static float from_range(const cf_altitude_t *altitude, float distance) {
  return altitude->estAlphaZrange * altitude->estimatedZ +
         (1.0f - altitude->estAlphaZrange) * distance;
}

static float from_baro(const cf_altitude_t *altitude, float asl) {
  if (altitude->estimatedZ == 0.0f) {
    return asl;  // the first time: jump to it
  }
  return altitude->estAlphaAsl * altitude->estimatedZ + (1.0f - altitude->estAlphaAsl) * asl;
}

void cf_altitude_estimate(cf_altitude_t *altitude, state_t *estimate, const baro_t *baro,
                          const tofMeasurement_t *tof, float dt, uint32_t now_ms) {
  const float previous  = altitude->estimatedZ;
  const float climbed   = altitude->velocityFactor * altitude->velocityZ * dt;
  const bool  is_useful = now_ms - tof->timestamp <= MAX_RANGE_AGE;
  if (is_useful) {
    altitude->is_surface_following = true;
  }

  // following the surface without a fresh range, the height stays as it is
  if (!altitude->is_surface_following) {
    altitude->estimatedZ = from_baro(altitude, baro->asl) + climbed;
  } else if (is_useful) {
    altitude->estimatedZ = from_range(altitude, tof->distance) + climbed;
  }

  estimate->position.x  = 0.0f;
  estimate->position.y  = 0.0f;
  estimate->position.z  = altitude->estimatedZ;
  estimate->velocity.z  = (altitude->estimatedZ - previous) / dt;
  altitude->estimatedVZ = estimate->velocity.z;
}

#define ROW(name, flags, member) CF_ROW("posEstAlt", name, FLOAT, flags, cf_altitude_t, member)

static const cf_variable_t PARAMETERS[] = {
    ROW("estAlphaAsl", CF_CORE | CF_PERSISTENT, estAlphaAsl),
    ROW("estAlphaZr", CF_CORE | CF_PERSISTENT, estAlphaZrange),
    ROW("velFactor", CF_PERSISTENT, velocityFactor),
    ROW("velZAlpha", CF_PERSISTENT, velZAlpha),
    ROW("vAccDeadband", CF_CORE | CF_PERSISTENT, vAccDeadband),
};

static const cf_variable_t LOGS[] = {
    ROW("estimatedZ", 0, estimatedZ),
    ROW("estVZ", 0, estimatedVZ),
    ROW("velocityZ", 0, velocityZ),
};

cf_variables_t cf_altitude_parameters(void) {
  return CF_TABLE(PARAMETERS);
}

cf_variables_t cf_altitude_logs(void) {
  return CF_TABLE(LOGS);
}
