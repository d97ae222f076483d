#include "onboard/compressed.h"

#include "api/quatcompress.h"
#include "convert.h"

#define THOUSANDTHS 1000.0f
#define GRAVITY 9.81f  // [m/s^2]

static const float MILLIRADIANS = 3.14159265358979f * 1000.0f / 180.0f;  // per degree

// The low 16 bits of the whole number.
static int16_t whole(float value) {
  const uint32_t low = (uint32_t)cf_to_int32(value) & 0xffffu;
  return (int16_t)(low < 0x8000u ? (int32_t)low : (int32_t)low - 0x10000);
}

cf_compressed_state_t cf_compress_state(const state_t *state, const Axis3f *gyro) {
  const quaternion_t *q       = &state->attitudeQuaternion;
  const float         quat[4] = {q->x, q->y, q->z, q->w};
  return (cf_compressed_state_t){
      .x         = whole(state->position.x * THOUSANDTHS),
      .y         = whole(state->position.y * THOUSANDTHS),
      .z         = whole(state->position.z * THOUSANDTHS),
      .vx        = whole(state->velocity.x * THOUSANDTHS),
      .vy        = whole(state->velocity.y * THOUSANDTHS),
      .vz        = whole(state->velocity.z * THOUSANDTHS),
      .ax        = whole(state->acc.x * GRAVITY * THOUSANDTHS),
      .ay        = whole(state->acc.y * GRAVITY * THOUSANDTHS),
      .az        = whole((state->acc.z + 1.0f) * GRAVITY * THOUSANDTHS),
      .quat      = quatcompress(quat),
      .rateRoll  = whole(gyro->x * MILLIRADIANS),
      .ratePitch = whole(-gyro->y * MILLIRADIANS),
      .rateYaw   = whole(gyro->z * MILLIRADIANS),
  };
}

cf_compressed_setpoint_t cf_compress_setpoint(const setpoint_t *setpoint) {
  return (cf_compressed_setpoint_t){
      .x  = whole(setpoint->position.x * THOUSANDTHS),
      .y  = whole(setpoint->position.y * THOUSANDTHS),
      .z  = whole(setpoint->position.z * THOUSANDTHS),
      .vx = whole(setpoint->velocity.x * THOUSANDTHS),
      .vy = whole(setpoint->velocity.y * THOUSANDTHS),
      .vz = whole(setpoint->velocity.z * THOUSANDTHS),
      .ax = whole(setpoint->acceleration.x * THOUSANDTHS),
      .ay = whole(setpoint->acceleration.y * THOUSANDTHS),
      .az = whole(setpoint->acceleration.z * THOUSANDTHS),
  };
}
