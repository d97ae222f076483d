// The legacy command of roll, pitch, yaw and thrust: port 3. Parameters give the four numbers other
// meanings.
#include <math.h>
#include <stdbool.h>

#include "FreeRTOS.h"
#include "commander.h"
#include "crtp.h"
#include "crtp_commander.h"
#include "num.h"
#include "param.h"
#include "position_controller.h"

#define MIN_THRUST 1000
#define MAX_THRUST 60000

struct CommanderCrtpLegacyValues {
  float    roll;  // [deg] or [deg/s]
  float    pitch;
  float    yaw;
  uint16_t thrust;
} __attribute__((packed));

typedef enum {
  RATE  = 0,
  ANGLE = 1,
} RPYType;

typedef enum {
  CAREFREE = 0,  // as it was when the mode began; not implemented
  PLUSMODE = 1,  // towards motor 1
  XMODE    = 2,  // between motors 1 and 4
} YawModeType;

static RPYType     stabilizationModeRoll  = ANGLE;
static RPYType     stabilizationModePitch = ANGLE;
static RPYType     stabilizationModeYaw   = RATE;
static YawModeType yawMode                = XMODE;

static bool thrustLocked = true;
static bool altHoldMode;
static bool posHoldMode;
static bool posSetMode;
static bool modeSet;  // altHoldMode was met by a packet already

// By 45 deg.
static void rotateYaw(setpoint_t *setpoint) {
  const float cosy          = 0.70710678f;
  const float siny          = 0.70710678f;
  const float originalRoll  = setpoint->attitude.roll;
  const float originalPitch = setpoint->attitude.pitch;

  setpoint->attitude.roll  = originalRoll * cosy - originalPitch * siny;
  setpoint->attitude.pitch = originalPitch * cosy + originalRoll * siny;
}

static void yawModeUpdate(setpoint_t *setpoint) {
  switch (yawMode) {
    case CAREFREE:
      ASSERT(false);
      break;
    case PLUSMODE:
      rotateYaw(setpoint);
      break;
    case XMODE:
    default:
      break;
  }
}

static void resetHeight(void) {
#if MINIATURE_RELEASE >= 202502
  positionControllerResetAllPID(0, 0, 0);
#else
  positionControllerResetAllPID();
#endif
  positionControllerResetAllfilters();
}

static void decodeThrust(setpoint_t *setpoint, uint16_t rawThrust) {
  if (commanderGetActivePriority() == COMMANDER_PRIORITY_DISABLE) {
    thrustLocked = true;
  }
  if (rawThrust == 0) {
    thrustLocked = false;
  }
  if (thrustLocked || rawThrust < MIN_THRUST) {
    setpoint->thrust = 0;
  } else {
    setpoint->thrust = rawThrust < MAX_THRUST ? rawThrust : MAX_THRUST;
  }

  if (altHoldMode) {
    if (!modeSet) {
      modeSet = true;
      resetHeight();
    }
    setpoint->thrust     = 0;
    setpoint->mode.z     = modeVelocity;
    setpoint->velocity.z = ((float)rawThrust - 32767.0f) / 32767.0f;
  } else {
    setpoint->mode.z = modeDisable;
    modeSet          = false;
  }
}

static void decodeAngle(RPYType mode, float value, stab_mode_t *stabMode, float *angle,
                        float *rate) {
  *stabMode = mode == RATE ? modeVelocity : modeAbs;
  *angle    = mode == RATE ? 0 : value;
  *rate     = mode == RATE ? value : 0;
}

void crtpCommanderRpytDecodeSetpoint(setpoint_t *setpoint, CRTPPacket *pk) {
  const struct CommanderCrtpLegacyValues *values =
      (const struct CommanderCrtpLegacyValues *)pk->data;

  decodeThrust(setpoint, values->thrust);

  if (posHoldMode) {
    setpoint->mode.x         = modeVelocity;
    setpoint->mode.y         = modeVelocity;
    setpoint->mode.roll      = modeDisable;
    setpoint->mode.pitch     = modeDisable;
    setpoint->velocity.x     = values->pitch / 30.0f;
    setpoint->velocity.y     = values->roll / 30.0f;
    setpoint->attitude.roll  = 0;
    setpoint->attitude.pitch = 0;
  } else if (posSetMode && values->thrust != 0) {
    setpoint->mode.x         = modeAbs;
    setpoint->mode.y         = modeAbs;
    setpoint->mode.z         = modeAbs;
    setpoint->mode.roll      = modeDisable;
    setpoint->mode.pitch     = modeDisable;
    setpoint->mode.yaw       = modeAbs;
    setpoint->position.x     = -values->pitch;
    setpoint->position.y     = values->roll;
    setpoint->position.z     = values->thrust / 1000.0f;
    setpoint->attitude.roll  = 0;
    setpoint->attitude.pitch = 0;
    setpoint->attitude.yaw   = values->yaw;
    setpoint->thrust         = 0;
  } else {
    setpoint->mode.x = modeDisable;
    setpoint->mode.y = modeDisable;
    decodeAngle(stabilizationModeRoll, values->roll, &setpoint->mode.roll, &setpoint->attitude.roll,
                &setpoint->attitudeRate.roll);
    decodeAngle(stabilizationModePitch, values->pitch, &setpoint->mode.pitch,
                &setpoint->attitude.pitch, &setpoint->attitudeRate.pitch);
    setpoint->velocity.x = 0;
    setpoint->velocity.y = 0;
  }

  if (!posSetMode) {
    if (stabilizationModeYaw == RATE) {
      setpoint->mode.yaw         = modeVelocity;
      setpoint->attitudeRate.yaw = -values->yaw;
      yawModeUpdate(setpoint);
    } else {
      setpoint->mode.yaw         = modeAbs;
      setpoint->attitudeRate.yaw = 0;
      setpoint->attitude.yaw     = values->yaw;
    }
  }
}

PARAM_GROUP_START(flightmode)
PARAM_ADD_CORE(PARAM_UINT8, althold, &altHoldMode)
PARAM_ADD_CORE(PARAM_UINT8, poshold, &posHoldMode)
PARAM_ADD_CORE(PARAM_UINT8, posSet, &posSetMode)
PARAM_ADD(PARAM_UINT8, yawMode, &yawMode)
PARAM_ADD_CORE(PARAM_UINT8, stabModeRoll, &stabilizationModeRoll)
PARAM_ADD_CORE(PARAM_UINT8, stabModePitch, &stabilizationModePitch)
PARAM_ADD_CORE(PARAM_UINT8, stabModeYaw, &stabilizationModeYaw)
PARAM_GROUP_STOP(flightmode)
