/* The extended Kalman filter of the firmware, with its names (docs/reference/estimators.md#3, #4
 * and #15).
 *
 * Four things differ from upstream's header, none of them in a number. kalmanCoreData_t lacks
 * `Pm`, the matrix view of P: it would be a pointer into the struct itself, and our state is copied
 * with memcpy. For the same reason there are no matrix instances: vectors are nine floats, matrices
 * nine times nine. `settled`, which saves work, sits in bytes that upstream leaves unused. And the
 * robust models take one more argument, what upstream keeps in a static variable.
 *
 * World frame: x forward, y left, z up. Body frame: the same, carried by the vehicle. */
#ifndef KALMAN_CORE_H
#define KALMAN_CORE_H

#include <stdbool.h>
#include <stdint.h>

#include "api/imu_types.h"
#include "api/outlierFilterLighthouse.h"
#include "api/outlierFilterTdoa.h"
#include "api/stabilizer_types.h"

typedef enum {
  KC_STATE_X   = 0,  // [m], position in the world
  KC_STATE_Y   = 1,
  KC_STATE_Z   = 2,
  KC_STATE_PX  = 3,  // [m/s], velocity in the body frame
  KC_STATE_PY  = 4,
  KC_STATE_PZ  = 5,
  KC_STATE_D0  = 6,  // [rad], attitude error in the body frame, a rotation vector
  KC_STATE_D1  = 7,
  KC_STATE_D2  = 8,
  KC_STATE_DIM = 9,
} kalmanCoreStateIdx_t;

typedef struct {
  float S[9];     // the state, see kalmanCoreStateIdx_t
  float q[4];     // attitude w, x, y, z, body to world
  float R[3][3];  // the same as a matrix, of the latest finalize
  float P[9][9];  // covariance of S; code outside the filter that writes P sets `settled` to 0

  float   baroReferenceHeight;   // [m]
  float   initialQuaternion[4];  // w, x, y, z
  bool    isUpdated;             // something changed since the latest finalize
  uint8_t settled;  // ours, in upstream's padding: how often P was bounded since it last changed,
                    // at most 2. From 1 on P is symmetric, at 2 bounding it again changes nothing

  uint32_t lastPredictionMs;
  uint32_t lastProcessNoiseUpdateMs;
} kalmanCoreData_t;

typedef struct {
  // standard deviations after init
  float stdDevInitialPosition_xy;         // [m]
  float stdDevInitialPosition_z;          // [m]
  float stdDevInitialVelocity;            // [m/s]
  float stdDevInitialAttitude_rollpitch;  // [rad]
  float stdDevInitialAttitude_yaw;        // [rad]

  // noise
  float procNoiseAcc_xy;          // [m/s^2]
  float procNoiseAcc_z;           // [m/s^2]
  float procNoiseVel;             // [m/s]
  float procNoisePos;             // [m]
  float procNoiseAtt;             // [rad]
  float measNoiseBaro;            // [m]
  float measNoiseGyro_rollpitch;  // [rad/s]
  float measNoiseGyro_yaw;        // [rad/s]

  // state after init
  float initialX;    // [m]
  float initialY;    // [m]
  float initialZ;    // [m]
  float initialYaw;  // [rad], 0 faces +x, pi/2 faces +y

  float attitudeReversion;  // share of the initial attitude mixed in per prediction on the ground

  // drag of platforms that ask for it; zero on every quadrotor
  float dragB_x;  // [1/s]
  float dragB_y;  // [1/s]
  float dragB_z;  // [1/s]
  float cop_x;    // [m], center of pressure in the body frame, from the center of mass
  float cop_y;    // [m]
  float cop_z;    // [m]
} kalmanCoreParams_t;

void kalmanCoreDefaultParams(kalmanCoreParams_t *params);

// Starts the filter at the initial position and yaw of params. R is the identity until the first
// finalize.
void kalmanCoreInit(kalmanCoreData_t *self, const kalmanCoreParams_t *params, uint32_t nowMs);

// Advances state, attitude and covariance from the latest prediction to nowMs. acc [m/s^2] and gyro
// [rad/s] are averages over that time; in flight only acc->z is used.
void kalmanCorePredict(kalmanCoreData_t *self, const kalmanCoreParams_t *params, const Axis3f *acc,
                       const Axis3f *gyro, uint32_t nowMs, bool quadIsFlying);

// Adds the noise of the time since the latest call, if any, and bounds the covariance. The noise is
// quadratic in that time: the rate of calls (1 kHz) is part of the tuning.
void kalmanCoreAddProcessNoise(kalmanCoreData_t *self, const kalmanCoreParams_t *params,
                               uint32_t nowMs);

// Fuses one number: `error` is measured minus predicted, Hm its derivative by the state. Never
// fails; a NaN that reaches the covariance becomes 100, one that reaches the state stays to be
// seen.
void kalmanCoreScalarUpdate(kalmanCoreData_t *self, const float Hm[9], float error,
                            float stdMeasNoise);

// The end of a robust update: S += Km error, P = (I - Km Hm) P_w_m, bounded.
void kalmanCoreUpdateWithPKE(kalmanCoreData_t *self, const float Hm[9], const float Km[9],
                             const float P_w_m[9][9], float error);

// Moves the attitude error into q and R and bounds the covariance. Returns false, and does nothing,
// when no prediction or update came since the latest call.
bool kalmanCoreFinalize(kalmanCoreData_t *self);

// Writes the estimate as the controllers read it: attitude in deg with legacy pitch, velocity in
// the world. acc is the latest sample [g].
void kalmanCoreExternalizeState(const kalmanCoreData_t *self, state_t *state, const Axis3f *acc);

// Forgets x, y and their velocities: zero, known to 10 m and 10 m/s, correlated with nothing.
void kalmanCoreDecoupleXY(kalmanCoreData_t *self);

// Measurement models. Each ends in one or more scalar updates.
void kalmanCoreUpdateWithPosition(kalmanCoreData_t *self, const positionMeasurement_t *xyz);
void kalmanCoreUpdateWithPose(kalmanCoreData_t *self, const poseMeasurement_t *pose);

// Only tilt beyond the cone of the sensor makes the way to the floor longer. Does nothing when the
// vehicle is tilted by 84 degrees or more. The floor is z = 0.
void kalmanCoreUpdateWithTof(kalmanCoreData_t *self, const tofMeasurement_t *tof);

// gyro is the latest sample [deg/s]. The sensor sits at the center of mass.
void kalmanCoreUpdateWithFlow(kalmanCoreData_t *self, const flowMeasurement_t *flow,
                              const Axis3f *gyro);

void kalmanCoreUpdateWithAbsoluteHeight(kalmanCoreData_t *self, const heightMeasurement_t *height);

// baroAsl [m] above sea level. On the ground, and as long as the reference is below 1 m, the
// present height becomes the reference; heights are measured from there.
void kalmanCoreUpdateWithBaro(kalmanCoreData_t *self, const kalmanCoreParams_t *params,
                              float baroAsl, bool quadIsFlying);

// A positive error turns the estimate clockwise. At most one between two finalize: the attitude
// error that a first one leaves behind would count with the wrong sign.
void kalmanCoreUpdateWithYawError(kalmanCoreData_t *self, const yawErrorMeasurement_t *error);

void kalmanCoreUpdateWithDistance(kalmanCoreData_t *self, const distanceMeasurement_t *d);

// Does nothing at the very place of an anchor, or when the filter refuses the sample.
void kalmanCoreUpdateWithTdoa(kalmanCoreData_t *self, const tdoaMeasurement_t *tdoa, uint32_t nowMs,
                              OutlierFilterTdoaState_t *outlierFilterState);

// The same two with weights that make little of odd samples. xErr is zero before the first call and
// belongs to this drone and model; upstream has it static. The outlier filter is not used. Without
// a positive definite covariance the estimate becomes NaN; right after kalmanCoreInit, before
// process noise has bounded it, one update is enough to lose that.
void kalmanCoreRobustUpdateWithDistance(kalmanCoreData_t *self, const distanceMeasurement_t *d,
                                        float xErr[9]);
void kalmanCoreRobustUpdateWithTdoa(kalmanCoreData_t *self, const tdoaMeasurement_t *tdoa,
                                    OutlierFilterTdoaState_t *outlierFilterState, float xErr[9]);

// All pointers of the measurement must be valid. Does nothing when the filter refuses the sample,
// or within 1 cm of the edge of what the light plane reaches.
void kalmanCoreUpdateWithSweepAngles(kalmanCoreData_t *self, const sweepAngleMeasurement_t *sweep,
                                     uint32_t nowMs, OutlierFilterLhState_t *state);

#endif  // KALMAN_CORE_H
