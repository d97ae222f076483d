#include "onboard/commander/rpyt.h"

#include <math.h>

#include "onboard/commander/commander.h"
#include "onboard/commander/setpoints.h"
#include "variable_row.h"

#define THRUST_MIN 1000
#define THRUST_MAX 60000
#define CLIMB_MIDDLE 32767.0f    // [counts], of thrust: no climb, and the counts of 1 m/s
#define DEGREES_PER_SPEED 30.0f  // [deg s/m], of pitch and roll while the position is held
#define COS_45 0.70710678f       // sine and cosine of 45 deg

void cf_rpyt_init(cf_rpyt_t *rpyt) {
  *rpyt = (cf_rpyt_t){
      .yawMode          = CF_YAW_MODE_X,
      .stabModeRoll     = CF_STABILIZE_ANGLE,
      .stabModePitch    = CF_STABILIZE_ANGLE,
      .stabModeYaw      = CF_STABILIZE_RATE,
      .thrust_is_locked = true,
  };
}

// A client has to send thrust 0 once before its thrust counts.
static float unlocked_thrust(cf_rpyt_t *rpyt, int active_priority, uint16_t thrust) {
  if (active_priority == COMMANDER_PRIORITY_DISABLE) {
    rpyt->thrust_is_locked = true;
  }
  if (thrust == 0) {
    rpyt->thrust_is_locked = false;
  }
  if (rpyt->thrust_is_locked || thrust < THRUST_MIN) {
    return 0.0f;
  }
  return (float)(thrust < THRUST_MAX ? thrust : THRUST_MAX);
}

static void set_height(setpoint_t *setpoint, cf_rpyt_t *rpyt, uint16_t thrust) {
  rpyt->is_holding_altitude = rpyt->althold != 0;
  if (rpyt->is_holding_altitude) {
    setpoint->thrust     = 0.0f;
    setpoint->mode.z     = modeVelocity;
    setpoint->velocity.z = ((float)thrust - CLIMB_MIDDLE) / CLIMB_MIDDLE;
  } else {
    setpoint->mode.z = modeDisable;
  }
}

static void set_velocity(setpoint_t *setpoint, float roll, float pitch) {
  setpoint->mode.x         = modeVelocity;
  setpoint->mode.y         = modeVelocity;
  setpoint->mode.roll      = modeDisable;
  setpoint->mode.pitch     = modeDisable;
  setpoint->velocity.x     = pitch / DEGREES_PER_SPEED;
  setpoint->velocity.y     = roll / DEGREES_PER_SPEED;
  setpoint->attitude.roll  = 0.0f;
  setpoint->attitude.pitch = 0.0f;
}

static void set_position(setpoint_t *setpoint, float roll, float pitch, float yaw,
                         uint16_t thrust) {
  setpoint->mode.x         = modeAbs;
  setpoint->mode.y         = modeAbs;
  setpoint->mode.z         = modeAbs;
  setpoint->mode.roll      = modeDisable;
  setpoint->mode.pitch     = modeDisable;
  setpoint->mode.yaw       = modeAbs;
  setpoint->position.x     = -pitch;
  setpoint->position.y     = roll;
  setpoint->position.z     = (float)thrust / 1000.0f;
  setpoint->attitude.roll  = 0.0f;
  setpoint->attitude.pitch = 0.0f;
  setpoint->attitude.yaw   = yaw;
  setpoint->thrust         = 0.0f;
}

// One of roll and pitch.
static void set_angle_or_rate(uint8_t stabilize, float value, stab_mode_t *mode, float *angle,
                              float *rate) {
  const bool is_rate = stabilize == CF_STABILIZE_RATE;
  *mode              = is_rate ? modeVelocity : modeAbs;
  *angle             = is_rate ? 0.0f : value;
  *rate              = is_rate ? value : 0.0f;
}

static void set_attitude(setpoint_t *setpoint, const cf_rpyt_t *rpyt, float roll, float pitch) {
  setpoint->mode.x = modeDisable;
  setpoint->mode.y = modeDisable;
  set_angle_or_rate(rpyt->stabModeRoll, roll, &setpoint->mode.roll, &setpoint->attitude.roll,
                    &setpoint->attitudeRate.roll);
  set_angle_or_rate(rpyt->stabModePitch, pitch, &setpoint->mode.pitch, &setpoint->attitude.pitch,
                    &setpoint->attitudeRate.pitch);
  setpoint->velocity.x = 0.0f;
  setpoint->velocity.y = 0.0f;
}

static void set_yaw_angle(setpoint_t *setpoint, float yaw) {
  setpoint->mode.yaw         = modeAbs;
  setpoint->attitudeRate.yaw = 0.0f;
  setpoint->attitude.yaw     = yaw;
}

static void set_yaw_rate(setpoint_t *setpoint, const cf_rpyt_t *rpyt, float yaw_rate) {
  setpoint->mode.yaw         = modeVelocity;
  setpoint->attitudeRate.yaw = -yaw_rate;

  if (rpyt->yawMode == CF_YAW_MODE_PLUS) {
    const float roll         = setpoint->attitude.roll;
    const float pitch        = setpoint->attitude.pitch;
    setpoint->attitude.roll  = roll * COS_45 - pitch * COS_45;
    setpoint->attitude.pitch = pitch * COS_45 + roll * COS_45;
  }
}

cf_status_t cf_setpoint_rpyt(setpoint_t *setpoint, cf_rpyt_t *rpyt, int active_priority, float roll,
                             float pitch, float yaw, uint16_t thrust) {
  // looked at by themselves: posSet without thrust does not use the yaw
  if (!isfinite(roll) || !isfinite(pitch) || !isfinite(yaw)) {
    return CF_ERR_VALUE;
  }
  const bool is_yaw_rate = rpyt->stabModeYaw == CF_STABILIZE_RATE && rpyt->posSet == 0;
  if (is_yaw_rate && rpyt->yawMode == CF_YAW_MODE_CAREFREE) {
    return CF_ERR_STATE;
  }

  setpoint_t wanted = *setpoint;
  cf_rpyt_t  next   = *rpyt;
  wanted.thrust     = unlocked_thrust(&next, active_priority, thrust);
  set_height(&wanted, &next, thrust);

  // the thrust as sent: posSet knows no lock and no limits
  if (rpyt->poshold != 0) {
    set_velocity(&wanted, roll, pitch);
  } else if (rpyt->posSet != 0 && thrust != 0) {
    set_position(&wanted, roll, pitch, yaw, thrust);
  } else {
    set_attitude(&wanted, rpyt, roll, pitch);
  }

  if (is_yaw_rate) {
    set_yaw_rate(&wanted, rpyt, yaw);
  } else if (rpyt->posSet == 0) {
    set_yaw_angle(&wanted, yaw);
  }

  if (!cf_setpoint_is_finite(&wanted)) {
    return CF_ERR_VALUE;
  }
  *setpoint = wanted;
  *rpyt     = next;
  return CF_OK;
}

#define PARAMETER(name_, flags_) CF_ROW("flightmode", #name_, UINT8, flags_, cf_rpyt_t, name_)

static const cf_variable_t PARAMETERS[] = {
    PARAMETER(althold, CF_CORE),      PARAMETER(poshold, CF_CORE),
    PARAMETER(posSet, CF_CORE),       PARAMETER(yawMode, 0),
    PARAMETER(stabModeRoll, CF_CORE), PARAMETER(stabModePitch, CF_CORE),
    PARAMETER(stabModeYaw, CF_CORE),
};

cf_variables_t cf_rpyt_parameters(void) {
  return CF_TABLE(PARAMETERS);
}
