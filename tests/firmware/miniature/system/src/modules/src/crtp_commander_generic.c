// Setpoints of several types, each with its own packet: port 7.
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "FreeRTOS.h"
#include "commander.h"
#include "crtp.h"
#include "crtp_commander.h"
#include "num.h"
#include "param.h"
#include "quatcompress.h"

enum packet_type {
  stopType                = 0,
  legacyVelocityWorldType = 1,
  legacyZDistanceType     = 2,
  cppmEmuType             = 3,
  altHoldType             = 4,
  legacyHoverType         = 5,
  fullStateType           = 6,
  positionType            = 7,
  velocityWorldType       = 8,
  zDistanceType           = 9,
  hoverType               = 10,
  manualType              = 11,
};

typedef void (*packetDecoder_t)(setpoint_t *setpoint, uint8_t type, const void *data,
                                size_t datalen);

static void stopDecoder(setpoint_t *setpoint, uint8_t type, const void *data, size_t datalen) {
  (void)setpoint;
  (void)type;
  (void)data;
  (void)datalen;
}

// ---------------------------------------------------------------------------------- velocities

struct velocityPacket_s {
  float vx;  // [m/s], world
  float vy;
  float vz;
  float yawrate;  // [deg/s]
} __attribute__((packed));

static void velocityDecoder(setpoint_t *setpoint, uint8_t type, const void *data, size_t datalen) {
  const struct velocityPacket_s *values = data;
  ASSERT(datalen == sizeof(struct velocityPacket_s));

  setpoint->mode.x     = modeVelocity;
  setpoint->mode.y     = modeVelocity;
  setpoint->mode.z     = modeVelocity;
  setpoint->velocity.x = values->vx;
  setpoint->velocity.y = values->vy;
  setpoint->velocity.z = values->vz;

  setpoint->mode.yaw         = modeVelocity;
  setpoint->attitudeRate.yaw = type == velocityWorldType ? values->yawrate : -values->yawrate;
}

// -------------------------------------------------------------------------------------- heights

struct zDistancePacket_s {
  float roll;  // [deg]
  float pitch;
  float yawrate;    // [deg/s]
  float zDistance;  // [m]
} __attribute__((packed));

static void zDistanceDecoder(setpoint_t *setpoint, uint8_t type, const void *data, size_t datalen) {
  const struct zDistancePacket_s *values = data;
  ASSERT(datalen == sizeof(struct zDistancePacket_s));

  setpoint->mode.z     = modeAbs;
  setpoint->position.z = values->zDistance;

  setpoint->mode.yaw         = modeVelocity;
  setpoint->attitudeRate.yaw = type == zDistanceType ? values->yawrate : -values->yawrate;

  setpoint->mode.roll      = modeAbs;
  setpoint->mode.pitch     = modeAbs;
  setpoint->attitude.roll  = values->roll;
  setpoint->attitude.pitch = values->pitch;
}

struct altHoldPacket_s {
  float roll;  // [deg]
  float pitch;
  float yawrate;    // [deg/s]
  float zVelocity;  // [m/s]
} __attribute__((packed));

static void altHoldDecoder(setpoint_t *setpoint, uint8_t type, const void *data, size_t datalen) {
  const struct altHoldPacket_s *values = data;
  (void)type;
  ASSERT(datalen == sizeof(struct altHoldPacket_s));

  setpoint->mode.z     = modeVelocity;
  setpoint->velocity.z = values->zVelocity;

  setpoint->mode.yaw         = modeVelocity;
  setpoint->attitudeRate.yaw = values->yawrate;

  setpoint->mode.roll      = modeAbs;
  setpoint->mode.pitch     = modeAbs;
  setpoint->attitude.roll  = values->roll;
  setpoint->attitude.pitch = values->pitch;
}

struct hoverPacket_s {
  float vx;  // [m/s], as the vehicle is turned
  float vy;
  float yawrate;    // [deg/s]
  float zDistance;  // [m]
} __attribute__((packed));

static void hoverDecoder(setpoint_t *setpoint, uint8_t type, const void *data, size_t datalen) {
  const struct hoverPacket_s *values = data;
  ASSERT(datalen == sizeof(struct hoverPacket_s));

  setpoint->mode.z     = modeAbs;
  setpoint->position.z = values->zDistance;

  setpoint->mode.yaw         = modeVelocity;
  setpoint->attitudeRate.yaw = type == hoverType ? values->yawrate : -values->yawrate;

  setpoint->mode.x        = modeVelocity;
  setpoint->mode.y        = modeVelocity;
  setpoint->velocity.x    = values->vx;
  setpoint->velocity.y    = values->vy;
  setpoint->velocity_body = true;
}

// ------------------------------------------------------------------------------- remote controls

#define MAX_AUX_RC_CHANNELS 10

static float s_CppmEmuRollMaxRateDps   = 720.0f;
static float s_CppmEmuPitchMaxRateDps  = 720.0f;
static float s_CppmEmuRollMaxAngleDeg  = 50.0f;
static float s_CppmEmuPitchMaxAngleDeg = 50.0f;
static float s_CppmEmuYawMaxRateDps    = 400.0f;

struct cppmEmuPacket_s {
  uint8_t  numAuxChannels : 4;
  uint8_t  reserved : 4;
  uint16_t channelRoll;  // pulse lengths [us]
  uint16_t channelPitch;
  uint16_t channelYaw;
  uint16_t channelThrust;
  uint16_t channelAux[MAX_AUX_RC_CHANNELS];
} __attribute__((packed));

float getCPPMRollScale(void) {
  return s_CppmEmuRollMaxAngleDeg;
}

float getCPPMRollRateScale(void) {
  return s_CppmEmuRollMaxRateDps;
}

float getCPPMPitchScale(void) {
  return s_CppmEmuPitchMaxAngleDeg;
}

float getCPPMPitchRateScale(void) {
  return s_CppmEmuPitchMaxRateDps;
}

float getCPPMYawRateScale(void) {
  return s_CppmEmuYawMaxRateDps;
}

static float unitOf(uint16_t pulse, uint16_t zero, uint16_t range) {
  return ((float)pulse - (float)zero) / (float)range;
}

static void cppmEmuDecoder(setpoint_t *setpoint, uint8_t type, const void *data, size_t datalen) {
  const struct cppmEmuPacket_s *values = data;
  (void)type;
  ASSERT(datalen >= 9);
  ASSERT(values->numAuxChannels <= MAX_AUX_RC_CHANNELS);
  ASSERT(datalen == 9 + 2 * (size_t)values->numAuxChannels);

  const bool  levels = values->numAuxChannels < 1 || values->channelAux[0] >= 1500;
  const float roll   = -unitOf(values->channelRoll, 1500, 500);
  const float pitch  = -unitOf(values->channelPitch, 1500, 500);
  if (levels) {
    setpoint->mode.roll      = modeAbs;
    setpoint->mode.pitch     = modeAbs;
    setpoint->attitude.roll  = roll * s_CppmEmuRollMaxAngleDeg;
    setpoint->attitude.pitch = pitch * s_CppmEmuPitchMaxAngleDeg;
  } else {
    setpoint->mode.roll          = modeVelocity;
    setpoint->mode.pitch         = modeVelocity;
    setpoint->attitudeRate.roll  = roll * s_CppmEmuRollMaxRateDps;
    setpoint->attitudeRate.pitch = pitch * s_CppmEmuPitchMaxRateDps;
  }

  setpoint->mode.yaw         = modeVelocity;
  setpoint->attitudeRate.yaw = -unitOf(values->channelYaw, 1500, 500) * s_CppmEmuYawMaxRateDps;

  const float thrust = unitOf(values->channelThrust, 1000, 1000) * (float)UINT16_MAX;
  setpoint->thrust   = thrust > 0.0f ? thrust : 0.0f;
}

struct manualPacket_s {
  float    roll;  // [deg] or [deg/s]
  float    pitch;
  float    yawrate;  // [deg/s]
  uint16_t thrust;
  char     rate;  // whether roll and pitch are rates
} __attribute__((packed));

static void manualDecoder(setpoint_t *setpoint, uint8_t type, const void *data, size_t datalen) {
  const struct manualPacket_s *values = data;
  (void)type;
  ASSERT(datalen == sizeof(struct manualPacket_s));

  if (values->rate == 1) {
    setpoint->mode.roll          = modeVelocity;
    setpoint->mode.pitch         = modeVelocity;
    setpoint->attitudeRate.roll  = values->roll;
    setpoint->attitudeRate.pitch = values->pitch;
  } else {
    setpoint->mode.roll      = modeAbs;
    setpoint->mode.pitch     = modeAbs;
    setpoint->attitude.roll  = values->roll;
    setpoint->attitude.pitch = values->pitch;
  }
  setpoint->mode.yaw         = modeVelocity;
  setpoint->attitudeRate.yaw = values->yawrate;
  setpoint->thrust           = values->thrust;
}

// ------------------------------------------------------------------------------ whole references

struct fullStatePacket_s {
  int16_t x;  // [mm]
  int16_t y;
  int16_t z;
  int16_t vx;  // [mm/s]
  int16_t vy;
  int16_t vz;
  int16_t ax;  // [mm/s^2]
  int16_t ay;
  int16_t az;
  int32_t quat;      // see quatcompress.h
  int16_t rateRoll;  // [mrad/s]
  int16_t ratePitch;
  int16_t rateYaw;
} __attribute__((packed));

static void fullStateDecoder(setpoint_t *setpoint, uint8_t type, const void *data, size_t datalen) {
  const struct fullStatePacket_s *values = data;
  (void)type;
  ASSERT(datalen == sizeof(struct fullStatePacket_s));

#define UNPACK(AXIS)                                       \
  setpoint->mode.AXIS         = modeAbs;                   \
  setpoint->position.AXIS     = values->AXIS / 1000.0f;    \
  setpoint->velocity.AXIS     = values->v##AXIS / 1000.0f; \
  setpoint->acceleration.AXIS = values->a##AXIS / 1000.0f;

  UNPACK(x)
  UNPACK(y)
  UNPACK(z)
#undef UNPACK

  const float millirad2deg     = 180.0f / ((float)M_PI * 1000.0f);
  setpoint->attitudeRate.roll  = millirad2deg * values->rateRoll;
  setpoint->attitudeRate.pitch = millirad2deg * values->ratePitch;
  setpoint->attitudeRate.yaw   = millirad2deg * values->rateYaw;

  float quat[4];
  quatdecompress((uint32_t)values->quat, quat);
  setpoint->attitudeQuaternion.x = quat[0];
  setpoint->attitudeQuaternion.y = quat[1];
  setpoint->attitudeQuaternion.z = quat[2];
  setpoint->attitudeQuaternion.w = quat[3];

  setpoint->mode.quat  = modeAbs;
  setpoint->mode.roll  = modeDisable;
  setpoint->mode.pitch = modeDisable;
  setpoint->mode.yaw   = modeDisable;
}

struct positionPacket_s {
  float x;  // [m]
  float y;
  float z;
  float yaw;  // [deg]
} __attribute__((packed));

static void positionDecoder(setpoint_t *setpoint, uint8_t type, const void *data, size_t datalen) {
  const struct positionPacket_s *values = data;
  (void)type;
  (void)datalen;

  setpoint->mode.x       = modeAbs;
  setpoint->mode.y       = modeAbs;
  setpoint->mode.z       = modeAbs;
  setpoint->position.x   = values->x;
  setpoint->position.y   = values->y;
  setpoint->position.z   = values->z;
  setpoint->mode.yaw     = modeAbs;
  setpoint->attitude.yaw = values->yaw;
}

static const packetDecoder_t packetDecoders[] = {
    [stopType]                = stopDecoder,
    [legacyVelocityWorldType] = velocityDecoder,
    [legacyZDistanceType]     = zDistanceDecoder,
    [cppmEmuType]             = cppmEmuDecoder,
    [altHoldType]             = altHoldDecoder,
    [legacyHoverType]         = hoverDecoder,
    [fullStateType]           = fullStateDecoder,
    [positionType]            = positionDecoder,
    [velocityWorldType]       = velocityDecoder,
    [zDistanceType]           = zDistanceDecoder,
    [hoverType]               = hoverDecoder,
    [manualType]              = manualDecoder,
};

void crtpCommanderGenericDecodeSetpoint(setpoint_t *setpoint, CRTPPacket *pk) {
  static int nTypes = -1;

  ASSERT(pk->size > 0);
  if (nTypes < 0) {
    nTypes = sizeof(packetDecoders) / sizeof(packetDecoders[0]);
  }

  const uint8_t type = pk->data[0];
  memset(setpoint, 0, sizeof(setpoint_t));
  if (type < nTypes && packetDecoders[type] != NULL) {
    packetDecoders[type](setpoint, type, &pk->data[1], pk->size - 1);
  }
}

PARAM_GROUP_START(cppm)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, rateRoll, &s_CppmEmuRollMaxRateDps)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, ratePitch, &s_CppmEmuPitchMaxRateDps)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, angPitch, &s_CppmEmuPitchMaxAngleDeg)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, angRoll, &s_CppmEmuRollMaxAngleDeg)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, rateYaw, &s_CppmEmuYawMaxRateDps)
PARAM_GROUP_STOP(cppm)
