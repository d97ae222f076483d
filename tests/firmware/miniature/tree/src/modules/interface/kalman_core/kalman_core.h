/* The filter, without its task.
 *
 * The state is the position in the world, the velocity in the frame of the body and an error of the
 * attitude, which is kept at zero: the attitude itself is a quaternion beside the state, into which
 * the error moves whenever the filter has something new. The covariance belongs to the state. Each
 * kind of measurement has a file of its own that makes an innovation and a derivative of it; the
 * filter turns both into a correction, one number at a time.
 *
 * Use: initialize with parameters; predict with what the inertial sensors say; add noise of the
 * process; correct with measurements; finalize, after which the attitude may be read; externalize
 * into the types of the stabilizer.
 *
 * Names: data is called `this`, as if it was an object. All of it is in SI units but for the
 * samples of the accelerometer, which predictions want in m/s^2 and what is externalized in g.
 *
 * Theory: Mueller, Hamer and D'Andrea, "Fusing ultra-wideband range measurements with
 * accelerometers and rate gyroscopes for quadrocopter state estimation", and Mueller, Hehn and
 * D'Andrea, "Covariance correction step for Kalman filtering with an attitude".
 */

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
#if MINIATURE_RELEASE >= 202512

  float attitudeReversion;
#endif
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
#if MINIATURE_RELEASE >= 202512
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
