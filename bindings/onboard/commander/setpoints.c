#include "onboard/commander/setpoints.h"

#include <math.h>
#include <stddef.h>

#include "api/math3d.h"

bool cf_setpoint_is_finite(const setpoint_t *setpoint) {
  const setpoint_t *s        = setpoint;
  const float       values[] = {
      s->attitude.roll,
      s->attitude.pitch,
      s->attitude.yaw,
      s->attitudeRate.roll,
      s->attitudeRate.pitch,
      s->attitudeRate.yaw,
      s->attitudeQuaternion.x,
      s->attitudeQuaternion.y,
      s->attitudeQuaternion.z,
      s->attitudeQuaternion.w,
      s->thrust,
      s->position.x,
      s->position.y,
      s->position.z,
      s->velocity.x,
      s->velocity.y,
      s->velocity.z,
      s->acceleration.x,
      s->acceleration.y,
      s->acceleration.z,
      s->jerk.x,
      s->jerk.y,
      s->jerk.z,
  };
  for (size_t i = 0; i < sizeof values / sizeof values[0]; i++) {
    if (!isfinite(values[i])) {
      return false;
    }
  }
  return true;
}

static cf_status_t write_if_finite(setpoint_t *setpoint, const setpoint_t *wanted) {
  if (!cf_setpoint_is_finite(wanted)) {
    return CF_ERR_VALUE;
  }
  *setpoint = *wanted;
  return CF_OK;
}

void cf_setpoint_stop(setpoint_t *setpoint) {
  *setpoint = (setpoint_t){.timestamp = 0};
}

cf_status_t cf_setpoint_velocity_world(setpoint_t *setpoint, float vx, float vy, float vz,
                                       float yaw_rate) {
  const setpoint_t wanted = {
      .velocity     = {.x = vx, .y = vy, .z = vz},
      .attitudeRate = {.yaw = yaw_rate},
      .mode = {.x = modeVelocity, .y = modeVelocity, .z = modeVelocity, .yaw = modeVelocity},
  };
  return write_if_finite(setpoint, &wanted);
}

cf_status_t cf_setpoint_zdistance(setpoint_t *setpoint, float roll, float pitch, float yaw_rate,
                                  float z) {
  const setpoint_t wanted = {
      .attitude     = {.roll = roll, .pitch = pitch},
      .attitudeRate = {.yaw = yaw_rate},
      .position     = {.z = z},
      .mode         = {.z = modeAbs, .roll = modeAbs, .pitch = modeAbs, .yaw = modeVelocity},
  };
  return write_if_finite(setpoint, &wanted);
}

cf_status_t cf_setpoint_altitude_hold(setpoint_t *setpoint, float roll, float pitch, float yaw_rate,
                                      float vz) {
  const setpoint_t wanted = {
      .attitude     = {.roll = roll, .pitch = pitch},
      .attitudeRate = {.yaw = yaw_rate},
      .velocity     = {.z = vz},
      .mode         = {.z = modeVelocity, .roll = modeAbs, .pitch = modeAbs, .yaw = modeVelocity},
  };
  return write_if_finite(setpoint, &wanted);
}

cf_status_t cf_setpoint_hover(setpoint_t *setpoint, float vx, float vy, float yaw_rate, float z) {
  const setpoint_t wanted = {
      .velocity      = {.x = vx, .y = vy},
      .velocity_body = true,
      .attitudeRate  = {.yaw = yaw_rate},
      .position      = {.z = z},
      .mode          = {.x = modeVelocity, .y = modeVelocity, .z = modeAbs, .yaw = modeVelocity},
  };
  return write_if_finite(setpoint, &wanted);
}

cf_status_t cf_setpoint_full_state(setpoint_t *setpoint, const cf_full_state_t *full_state) {
  const point_t      p      = full_state->position;
  const velocity_t   v      = full_state->velocity;
  const acc_t        a      = full_state->acceleration;
  const quaternion_t q      = full_state->attitude;
  const Axis3f       w      = full_state->body_rates;
  const setpoint_t   wanted = {
      .position           = {.x = p.x, .y = p.y, .z = p.z},
      .velocity           = {.x = v.x, .y = v.y, .z = v.z},
      .acceleration       = {.x = a.x, .y = a.y, .z = a.z},
      .attitudeQuaternion = q,
      .attitudeRate       = {.roll = degrees(w.x), .pitch = degrees(w.y), .yaw = degrees(w.z)},
      .mode               = {.x = modeAbs, .y = modeAbs, .z = modeAbs, .quat = modeAbs},
  };
  return write_if_finite(setpoint, &wanted);
}

cf_status_t cf_setpoint_position(setpoint_t *setpoint, float x, float y, float z, float yaw) {
  const setpoint_t wanted = {
      .position = {.x = x, .y = y, .z = z},
      .attitude = {.yaw = yaw},
      .mode     = {.x = modeAbs, .y = modeAbs, .z = modeAbs, .yaw = modeAbs},
  };
  return write_if_finite(setpoint, &wanted);
}

cf_status_t cf_setpoint_manual(setpoint_t *setpoint, float roll, float pitch, float yaw_rate,
                               uint16_t thrust, bool rate) {
  setpoint_t wanted = {
      .attitudeRate = {.yaw = yaw_rate},
      .thrust       = (float)thrust,
      .mode         = {.yaw = modeVelocity},
  };
  attitude_t *angles = rate ? &wanted.attitudeRate : &wanted.attitude;
  angles->roll       = roll;
  angles->pitch      = pitch;
  wanted.mode.roll   = rate ? modeVelocity : modeAbs;
  wanted.mode.pitch  = wanted.mode.roll;
  return write_if_finite(setpoint, &wanted);
}
