#pragma once

#include "cf_math.h"
#include "stabilizer_types.h"

typedef enum {
  KC_STATE_X,
  KC_STATE_Y,
  KC_STATE_Z,
  KC_STATE_PX,
  KC_STATE_PY,
  KC_STATE_PZ,
  KC_STATE_D0,
  KC_STATE_D1,
  KC_STATE_D2,
  KC_STATE_DIM,
} kalmanCoreStateIdx_t;

typedef struct {
  float                             S[KC_STATE_DIM];
  float                             q[4];  // w, x, y, z
  float                             R[3][3];
  __attribute__((aligned(4))) float P[KC_STATE_DIM][KC_STATE_DIM];
  arm_matrix_instance_f32           Pm;

  float    baroReferenceHeight;
  float    initialQuaternion[4];
  bool     isUpdated;
  uint32_t lastPredictionMs;
  uint32_t lastProcessNoiseUpdateMs;
} kalmanCoreData_t;

typedef struct {
  float stdDevInitialPosition_xy;
  float stdDevInitialPosition_z;
  float stdDevInitialVelocity;
  float stdDevInitialAttitude_rollpitch;
  float stdDevInitialAttitude_yaw;

  float procNoiseAcc_xy;
  float procNoiseAcc_z;
  float procNoiseVel;
  float procNoisePos;
  float procNoiseAtt;
  float measNoiseBaro;
  float measNoiseGyro_rollpitch;
  float measNoiseGyro_yaw;

  float initialX;
  float initialY;
  float initialZ;
  float initialYaw;

  float attitudeReversion;
#if MINIATURE_RELEASE >= 202608

  float dragB_x;
  float dragB_y;
  float dragB_z;
  float cop_x;
  float cop_y;
  float cop_z;
#endif
} kalmanCoreParams_t;

void kalmanCoreDefaultParams(kalmanCoreParams_t *params);
void kalmanCoreInit(kalmanCoreData_t *this, const kalmanCoreParams_t *params, const uint32_t nowMs);

void kalmanCoreUpdateWithBaro(kalmanCoreData_t *this, const kalmanCoreParams_t *params,
                              float baroAsl, bool quadIsFlying);
#if MINIATURE_RELEASE >= 202608
void kalmanCorePredict(kalmanCoreData_t *this, const kalmanCoreParams_t *params, Axis3f *acc,
                       Axis3f *gyro, const uint32_t nowMs, bool quadIsFlying);
#else
void kalmanCorePredict(kalmanCoreData_t *this, Axis3f *acc, Axis3f *gyro, const uint32_t nowMs,
                       bool quadIsFlying);
#endif
void kalmanCoreAddProcessNoise(kalmanCoreData_t *this, const kalmanCoreParams_t *params,
                               const uint32_t nowMs);
bool kalmanCoreFinalize(kalmanCoreData_t *this);
void kalmanCoreExternalizeState(const kalmanCoreData_t *this, state_t *state, const Axis3f *acc);
void kalmanCoreDecoupleXY(kalmanCoreData_t *this);

void kalmanCoreScalarUpdate(kalmanCoreData_t *this, arm_matrix_instance_f32 *Hm, float error,
                            float stdMeasNoise);
void kalmanCoreUpdateWithPKE(kalmanCoreData_t *this, arm_matrix_instance_f32 *Hm,
                             arm_matrix_instance_f32 *Km, arm_matrix_instance_f32 *P_w_m,
                             float error);
