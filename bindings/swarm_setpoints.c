#include "swarm_setpoints.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#define PI 3.14159265358979323846
#define DEGREES (180.0 / PI)  // in a radian
#define FULL_THRUST 65535.0

static bool are_finite(const double *linear, const double *angular) {
  for (int k = 0; k < 3; k++) {
    if (!isfinite(linear[k]) || !isfinite(angular[k])) {
      return false;
    }
  }
  return true;
}

// Returns an angle in [-pi, pi) as degrees.
static double wrapped(double angle) {
  double turn = fmod(angle + PI, 2.0 * PI);
  if (turn < 0.0) {
    turn += 2.0 * PI;
  }
  return (turn - PI) * DEGREES;
}

static float thrust_of(double force, double max_thrust) {
  return (float)(fmin(fmax(force / max_thrust, 0.0), 1.0) * FULL_THRUST);
}

// A positive pitch lifts the nose on board.
static void make_fpqr(const double *linear, const double *angular, double max_thrust,
                      setpoint_t *setpoint) {
  setpoint->thrust             = thrust_of(linear[2], max_thrust);
  setpoint->attitudeRate.roll  = (float)(angular[0] * DEGREES);
  setpoint->attitudeRate.pitch = (float)(angular[1] * -DEGREES);
  setpoint->attitudeRate.yaw   = (float)(angular[2] * DEGREES);
  setpoint->mode.roll = setpoint->mode.pitch = setpoint->mode.yaw = modeVelocity;
}

static void make_frpy(const double *linear, const double *angular, double max_thrust,
                      setpoint_t *setpoint) {
  setpoint->thrust         = thrust_of(linear[2], max_thrust);
  setpoint->attitude.roll  = (float)wrapped(angular[0]);
  setpoint->attitude.pitch = (float)-wrapped(angular[1]);
  setpoint->attitude.yaw   = (float)wrapped(angular[2]);
  setpoint->mode.roll = setpoint->mode.pitch = setpoint->mode.yaw = modeAbs;
}

static void make_vel(const double *linear, const double *angular, setpoint_t *setpoint) {
  setpoint->velocity.x       = (float)linear[0];
  setpoint->velocity.y       = (float)linear[1];
  setpoint->velocity.z       = (float)linear[2];
  setpoint->attitudeRate.yaw = (float)(angular[2] * DEGREES);
  setpoint->mode.x = setpoint->mode.y = setpoint->mode.z = setpoint->mode.yaw = modeVelocity;
}

int cf_make_setpoints(cf_twist_kind_t kind, int count, const double *linear, const double *angular,
                      const double *max_thrusts, uint32_t timestamp, setpoint_t *setpoints) {
  memset(setpoints, 0, (size_t)count * sizeof *setpoints);
  for (int i = 0; i < count; i++, linear += 3, angular += 3) {
    if (!are_finite(linear, angular)) {
      return i;
    }
    setpoints[i].timestamp = timestamp;
    switch (kind) {
      case CF_TWIST_FPQR:
        make_fpqr(linear, angular, max_thrusts[i], &setpoints[i]);
        break;
      case CF_TWIST_FRPY:
        make_frpy(linear, angular, max_thrusts[i], &setpoints[i]);
        break;
      case CF_TWIST_VEL:
        make_vel(linear, angular, &setpoints[i]);
        break;
    }
  }
  return count;
}
