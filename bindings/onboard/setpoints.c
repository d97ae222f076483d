#include "onboard/setpoints.h"

#include <math.h>

#include "builtin/math3d.h"
#include "onboard/commander.h"

#define RPYT_THRUST_MIN 1000
#define RPYT_THRUST_MAX 60000

static bool are_finite(const float *values, int count) {
  for (int i = 0; i < count; i++) {
    if (!isfinite(values[i])) {
      return false;
    }
  }
  return true;
}

// Writes a setpoint unless one of the numbers in it came from a value that is not finite.
static cf_status_t write_if_finite(setpoint_t *setpoint, const setpoint_t *wanted,
                                   const float *values, int count) {
  if (!are_finite(values, count)) {
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
  const float      values[] = {vx, vy, vz, yaw_rate};
  const setpoint_t wanted   = {
      .velocity     = {.x = vx, .y = vy, .z = vz},
      .attitudeRate = {.yaw = yaw_rate},
      .mode = {.x = modeVelocity, .y = modeVelocity, .z = modeVelocity, .yaw = modeVelocity},
  };
  return write_if_finite(setpoint, &wanted, values, 4);
}

cf_status_t cf_setpoint_zdistance(setpoint_t *setpoint, float roll, float pitch, float yaw_rate,
                                  float z) {
  const float      values[] = {roll, pitch, yaw_rate, z};
  const setpoint_t wanted   = {
      .attitude     = {.roll = roll, .pitch = pitch},
      .attitudeRate = {.yaw = yaw_rate},
      .position     = {.z = z},
      .mode         = {.z = modeAbs, .roll = modeAbs, .pitch = modeAbs, .yaw = modeVelocity},
  };
  return write_if_finite(setpoint, &wanted, values, 4);
}

cf_status_t cf_setpoint_altitude_hold(setpoint_t *setpoint, float roll, float pitch, float yaw_rate,
                                      float vz) {
  const float      values[] = {roll, pitch, yaw_rate, vz};
  const setpoint_t wanted   = {
      .attitude     = {.roll = roll, .pitch = pitch},
      .attitudeRate = {.yaw = yaw_rate},
      .velocity     = {.z = vz},
      .mode         = {.z = modeVelocity, .roll = modeAbs, .pitch = modeAbs, .yaw = modeVelocity},
  };
  return write_if_finite(setpoint, &wanted, values, 4);
}

cf_status_t cf_setpoint_hover(setpoint_t *setpoint, float vx, float vy, float yaw_rate, float z) {
  const float      values[] = {vx, vy, yaw_rate, z};
  const setpoint_t wanted   = {
      .velocity      = {.x = vx, .y = vy},
      .velocity_body = true,
      .attitudeRate  = {.yaw = yaw_rate},
      .position      = {.z = z},
      .mode          = {.x = modeVelocity, .y = modeVelocity, .z = modeAbs, .yaw = modeVelocity},
  };
  return write_if_finite(setpoint, &wanted, values, 4);
}

cf_status_t cf_setpoint_full_state(setpoint_t *setpoint, const cf_full_state_t *full_state) {
  const point_t      p        = full_state->position;
  const velocity_t   v        = full_state->velocity;
  const acc_t        a        = full_state->acceleration;
  const quaternion_t q        = full_state->attitude;
  const Axis3f       w        = full_state->body_rates;
  const float        values[] = {p.x, p.y, p.z, v.x, v.y, v.z, a.x, a.y,
                                 a.z, q.x, q.y, q.z, q.w, w.x, w.y, w.z};
  const setpoint_t   wanted   = {
      .position           = {.x = p.x, .y = p.y, .z = p.z},
      .velocity           = {.x = v.x, .y = v.y, .z = v.z},
      .acceleration       = {.x = a.x, .y = a.y, .z = a.z},
      .attitudeQuaternion = q,
      .attitudeRate       = {.roll = degrees(w.x), .pitch = degrees(w.y), .yaw = degrees(w.z)},
      .mode               = {.x = modeAbs, .y = modeAbs, .z = modeAbs, .quat = modeAbs},
  };
  return write_if_finite(setpoint, &wanted, values, 16);
}

cf_status_t cf_setpoint_position(setpoint_t *setpoint, float x, float y, float z, float yaw) {
  const float      values[] = {x, y, z, yaw};
  const setpoint_t wanted   = {
      .position = {.x = x, .y = y, .z = z},
      .attitude = {.yaw = yaw},
      .mode     = {.x = modeAbs, .y = modeAbs, .z = modeAbs, .yaw = modeAbs},
  };
  return write_if_finite(setpoint, &wanted, values, 4);
}

cf_status_t cf_setpoint_manual(setpoint_t *setpoint, float roll, float pitch, float yaw_rate,
                               uint16_t thrust, bool rate) {
  const float values[] = {roll, pitch, yaw_rate};
  setpoint_t  wanted   = {
      .attitudeRate = {.yaw = yaw_rate},
      .thrust       = (float)thrust,
      .mode         = {.yaw = modeVelocity},
  };
  attitude_t *angles = rate ? &wanted.attitudeRate : &wanted.attitude;
  angles->roll       = roll;
  angles->pitch      = pitch;
  wanted.mode.roll   = rate ? modeVelocity : modeAbs;
  wanted.mode.pitch  = wanted.mode.roll;
  return write_if_finite(setpoint, &wanted, values, 3);
}

void cf_rpyt_init(cf_rpyt_t *rpyt) {
  *rpyt = (cf_rpyt_t){.thrust_is_locked = true};
}

// A client has to send thrust 0 once before its thrust counts.
static float unlocked_thrust(cf_rpyt_t *rpyt, int active_priority, uint16_t thrust) {
  if (active_priority == COMMANDER_PRIORITY_DISABLE) {
    rpyt->thrust_is_locked = true;
  }
  if (thrust == 0) {
    rpyt->thrust_is_locked = false;
  }
  if (rpyt->thrust_is_locked || thrust < RPYT_THRUST_MIN) {
    return 0.0f;
  }
  return (float)(thrust < RPYT_THRUST_MAX ? thrust : RPYT_THRUST_MAX);
}

cf_status_t cf_setpoint_rpyt(setpoint_t *setpoint, cf_rpyt_t *rpyt, int active_priority, float roll,
                             float pitch, float yaw_rate, uint16_t thrust) {
  const float values[] = {roll, pitch, yaw_rate};
  if (!are_finite(values, 3)) {
    return CF_ERR_VALUE;
  }

  setpoint->thrust = unlocked_thrust(rpyt, active_priority, thrust);

  // angles of roll and pitch, rate of yaw
  setpoint->attitude.roll      = roll;
  setpoint->attitude.pitch     = pitch;
  setpoint->attitudeRate.roll  = 0.0f;
  setpoint->attitudeRate.pitch = 0.0f;
  setpoint->attitudeRate.yaw   = -yaw_rate;
  setpoint->velocity.x         = 0.0f;
  setpoint->velocity.y         = 0.0f;

  // mode.quat keeps what an earlier setpoint left (dossier section 10.3)
  setpoint->mode.x     = modeDisable;
  setpoint->mode.y     = modeDisable;
  setpoint->mode.z     = modeDisable;
  setpoint->mode.roll  = modeAbs;
  setpoint->mode.pitch = modeAbs;
  setpoint->mode.yaw   = modeVelocity;
  return CF_OK;
}
