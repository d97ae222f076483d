// The filter, with its scratch matrices where DMA cannot reach them.
// clang-format off
#include "kalman_core.h"
#include "cfassert.h"
#include "autoconf.h"

#include "physicalConstants.h"
#include "math3d.h"
#include "static_mem.h"
#if MINIATURE_RELEASE >= 202512
#include "kalman_core_params_defaults.h"
#endif
// clang-format on

// #define DEBUG_STATE_CHECK

#define MAX_COVARIANCE (100)
#define MIN_COVARIANCE (1e-6f)
#define EPS (1e-6f)

#define N KC_STATE_DIM

#if MINIATURE_RELEASE >= 202512
void kalmanCoreDefaultParams(kalmanCoreParams_t *params) {
  *params = (kalmanCoreParams_t){KALMAN_CORE_DEFAULT_PARAMS_INIT};
}
#else
#ifdef CONFIG_ESTIMATOR_KALMAN_GENERAL_PURPOSE
#define PROC_NOISE_ACC_Z 0.5f
#else
#define PROC_NOISE_ACC_Z 1.0f
#endif

void kalmanCoreDefaultParams(kalmanCoreParams_t *params) {
  memset(params, 0, sizeof *params);
  params->stdDevInitialPosition_xy        = 100;
  params->stdDevInitialPosition_z         = 1;
  params->stdDevInitialVelocity           = 0.01;
  params->stdDevInitialAttitude_rollpitch = 0.01;
  params->stdDevInitialAttitude_yaw       = 0.01;
  params->procNoiseAcc_xy                 = 0.5f;
  params->procNoiseAcc_z                  = PROC_NOISE_ACC_Z;
  params->measNoiseBaro                   = 2.0f;
  params->measNoiseGyro_rollpitch         = 0.1f;
  params->measNoiseGyro_yaw               = 0.1f;
}
#endif

void kalmanCoreInit(kalmanCoreData_t *this, const kalmanCoreParams_t *params,
                    const uint32_t nowMs) {
  memset(this, 0, sizeof *this);
  this->S[KC_STATE_X] = params->initialX;
  this->S[KC_STATE_Y] = params->initialY;
  this->S[KC_STATE_Z] = params->initialZ;

  this->initialQuaternion[0] = arm_cos_f32(params->initialYaw / 2);
  this->initialQuaternion[3] = arm_sin_f32(params->initialYaw / 2);
  for (int i = 0; i < 4; i++) {
    this->q[i] = this->initialQuaternion[i];
  }
  for (int i = 0; i < 3; i++) {
    this->R[i][i] = 1;
  }

  const float stdDev[N] = {
      params->stdDevInitialPosition_xy,        params->stdDevInitialPosition_xy,
      params->stdDevInitialPosition_z,         params->stdDevInitialVelocity,
      params->stdDevInitialVelocity,           params->stdDevInitialVelocity,
      params->stdDevInitialAttitude_rollpitch, params->stdDevInitialAttitude_rollpitch,
      params->stdDevInitialAttitude_yaw,
  };
  for (int i = 0; i < N; i++) {
    this->P[i][i] = powf(stdDev[i], 2);
  }
  this->Pm.numRows               = N;
  this->Pm.numCols               = N;
  this->Pm.pData                 = (float *)this->P;
  this->lastPredictionMs         = nowMs;
  this->lastProcessNoiseUpdateMs = nowMs;
}

#ifdef DEBUG_STATE_CHECK
static void assertStateNotNaN(const kalmanCoreData_t *this) {
  for (int i = 0; i < N; i++) {
    ASSERT(!isnan(this->S[i]));
    for (int j = 0; j < N; j++) {
      ASSERT(!isnan(this->P[i][j]));
    }
  }
}
#else
static void assertStateNotNaN(const kalmanCoreData_t *this) {
  return;
}
#endif

// symmetric and within bounds; r is what is added of K r K'
static void bound(kalmanCoreData_t *this, const float *K, float R) {
  for (int i = 0; i < N; i++) {
    for (int j = i; j < N; j++) {
      float p = 0.5f * this->P[i][j] + 0.5f * this->P[j][i];
      if (K != 0) {
        p += K[i] * R * K[j];
      }
      if (isnan(p) || p > MAX_COVARIANCE) {
        this->P[i][j] = this->P[j][i] = MAX_COVARIANCE;
      } else if (i == j && p < MIN_COVARIANCE) {
        this->P[i][j] = this->P[j][i] = MIN_COVARIANCE;
      } else {
        this->P[i][j] = this->P[j][i] = p;
      }
    }
  }
}

void kalmanCoreScalarUpdate(kalmanCoreData_t *this, arm_matrix_instance_f32 *Hm, float error,
                            float stdMeasNoise) {
  // the gain
  NO_DMA_CCM_SAFE_ZERO_INIT static float K[N];
  static arm_matrix_instance_f32         Km = {N, 1, (float *)K};

  NO_DMA_CCM_SAFE_ZERO_INIT __attribute__((aligned(4))) static float tmpNN1d[N * N];
  static arm_matrix_instance_f32                                     tmpNN1m = {N, N, tmpNN1d};
  NO_DMA_CCM_SAFE_ZERO_INIT __attribute__((aligned(4))) static float tmpNN2d[N * N];
  static arm_matrix_instance_f32                                     tmpNN2m = {N, N, tmpNN2d};
  NO_DMA_CCM_SAFE_ZERO_INIT __attribute__((aligned(4))) static float tmpNN3d[N * N];
  static arm_matrix_instance_f32                                     tmpNN3m = {N, N, tmpNN3d};
  NO_DMA_CCM_SAFE_ZERO_INIT __attribute__((aligned(4))) static float HTd[N];
  static arm_matrix_instance_f32                                     HTm = {N, 1, HTd};
  NO_DMA_CCM_SAFE_ZERO_INIT __attribute__((aligned(4))) static float PHTd[N];
  static arm_matrix_instance_f32                                     PHTm = {N, 1, PHTd};

  ASSERT(Hm->numRows == 1);
  ASSERT(Hm->numCols == N);

  mat_trans(Hm, &HTm);
  mat_mult(&this->Pm, &HTm, &PHTm);
  const float R    = stdMeasNoise * stdMeasNoise;
  float       HPHR = R;
  for (int i = 0; i < N; i++) {
    HPHR += Hm->pData[i] * PHTd[i];
  }
  ASSERT(!isnan(HPHR));
  for (int i = 0; i < N; i++) {
    K[i]       = PHTd[i] / HPHR;
    this->S[i] = this->S[i] + K[i] * error;
  }

  // P = (KH - I) P (KH - I)' + K R K'
  mat_mult(&Km, Hm, &tmpNN1m);
  for (int i = 0; i < N; i++) {
    tmpNN1d[N * i + i] -= 1;
  }
  mat_trans(&tmpNN1m, &tmpNN2m);
  mat_mult(&tmpNN1m, &this->Pm, &tmpNN3m);
  mat_mult(&tmpNN3m, &tmpNN2m, &this->Pm);
  bound(this, K, R);
  assertStateNotNaN(this);
  this->isUpdated = true;
}

void kalmanCoreUpdateWithPKE(kalmanCoreData_t *this, arm_matrix_instance_f32 *Hm,
                             arm_matrix_instance_f32 *Km, arm_matrix_instance_f32 *P_w_m,
                             float error) {
  NO_DMA_CCM_SAFE_ZERO_INIT __attribute__((aligned(4))) static float tmpNN1d[N][N];
  static arm_matrix_instance_f32 tmpNN1m = {N, N, (float *)tmpNN1d};

  for (int i = 0; i < N; i++) {
    this->S[i] = this->S[i] + Km->pData[i] * error;
  }
  mat_mult(Km, Hm, &tmpNN1m);
  mat_scale(&tmpNN1m, -1.0f, &tmpNN1m);
  for (int i = 0; i < N; i++) {
    tmpNN1d[i][i] = 1.0f + tmpNN1d[i][i];
  }
  mat_mult(&tmpNN1m, P_w_m, &this->Pm);
  bound(this, 0, 0);
  this->isUpdated = true;
}

void kalmanCoreUpdateWithBaro(kalmanCoreData_t *this, const kalmanCoreParams_t *params,
                              float baroAsl, bool quadIsFlying) {
  float                   h[N] = {0};
  arm_matrix_instance_f32 H    = {1, N, h};
  h[KC_STATE_Z]                = 1;
  if (!quadIsFlying || this->baroReferenceHeight < 1) {
    this->baroReferenceHeight = baroAsl;
  }
  const float meas = baroAsl - this->baroReferenceHeight;
  kalmanCoreScalarUpdate(this, &H, meas - this->S[KC_STATE_Z], params->measNoiseBaro);
}

// rows and columns D0 to D2 of a rotation of the covariance by twice (d0, d1, d2)
static void rotateCovariance(float A[N][N], float d0, float d1, float d2) {
  A[KC_STATE_D0][KC_STATE_D0] = 1 - d1 * d1 / 2 - d2 * d2 / 2;
  A[KC_STATE_D0][KC_STATE_D1] = d2 + d0 * d1 / 2;
  A[KC_STATE_D0][KC_STATE_D2] = -d1 + d0 * d2 / 2;

  A[KC_STATE_D1][KC_STATE_D0] = -d2 + d0 * d1 / 2;
  A[KC_STATE_D1][KC_STATE_D1] = 1 - d0 * d0 / 2 - d2 * d2 / 2;
  A[KC_STATE_D1][KC_STATE_D2] = d0 + d1 * d2 / 2;

  A[KC_STATE_D2][KC_STATE_D0] = d1 + d0 * d2 / 2;
  A[KC_STATE_D2][KC_STATE_D1] = -d0 + d1 * d2 / 2;
  A[KC_STATE_D2][KC_STATE_D2] = 1 - d0 * d0 / 2 - d1 * d1 / 2;
}

// q turned by (tx, ty, tz) in the body frame
static void turn(const float q[4], float tx, float ty, float tz, float turned[4]) {
  const float angle = arm_sqrt(tx * tx + ty * ty + tz * tz) + EPS;
  const float ca    = arm_cos_f32(angle / 2.0f);
  const float sa    = arm_sin_f32(angle / 2.0f);
  const float dq[4] = {ca, sa * tx / angle, sa * ty / angle, sa * tz / angle};

  turned[0] = dq[0] * q[0] - dq[1] * q[1] - dq[2] * q[2] - dq[3] * q[3];
  turned[1] = dq[1] * q[0] + dq[0] * q[1] + dq[3] * q[2] - dq[2] * q[3];
  turned[2] = dq[2] * q[0] - dq[3] * q[1] + dq[0] * q[2] + dq[1] * q[3];
  turned[3] = dq[3] * q[0] + dq[2] * q[1] - dq[1] * q[2] + dq[0] * q[3];
}

static void normalize(const float in[4], float q[4]) {
  const float norm = arm_sqrt(in[0] * in[0] + in[1] * in[1] + in[2] * in[2] + in[3] * in[3]) + EPS;
  for (int k = 0; k < 4; k++) {
    q[k] = in[k] / norm;
  }
}

typedef struct {
  float b[3];
  float c[3];
} drag_t;

static void predictDt(kalmanCoreData_t *this, drag_t drag, Axis3f *acc, Axis3f *gyro, float dt,
                      bool quadIsFlying, float reversion) {
  // what is never written below stays zero
  NO_DMA_CCM_SAFE_ZERO_INIT static float                             A[N][N];
  static __attribute__((aligned(4))) arm_matrix_instance_f32         Am = {N, N, (float *)A};
  NO_DMA_CCM_SAFE_ZERO_INIT __attribute__((aligned(4))) static float tmpNN1d[N * N];
  static arm_matrix_instance_f32                                     tmpNN1m = {N, N, tmpNN1d};
  NO_DMA_CCM_SAFE_ZERO_INIT __attribute__((aligned(4))) static float tmpNN2d[N * N];
  static arm_matrix_instance_f32                                     tmpNN2m = {N, N, tmpNN2d};

  const float (*R)[3] = this->R;
  const float px = this->S[KC_STATE_PX], py = this->S[KC_STATE_PY], pz = this->S[KC_STATE_PZ];
  const float g   = GRAVITY_MAGNITUDE;
  const float dt2 = dt * dt;

  for (int i = 0; i < 3; i++) {
    A[i][i]           = 1;
    A[i][KC_STATE_PX] = R[i][0] * dt;
    A[i][KC_STATE_PY] = R[i][1] * dt;
    A[i][KC_STATE_PZ] = R[i][2] * dt;
    A[i][KC_STATE_D0] = (py * R[i][2] - pz * R[i][1]) * dt;
    A[i][KC_STATE_D1] = (-px * R[i][2] + pz * R[i][0]) * dt;
    A[i][KC_STATE_D2] = (px * R[i][1] - py * R[i][0]) * dt;
  }
  A[KC_STATE_PX][KC_STATE_PX] = 1 - dt * drag.b[0];
  A[KC_STATE_PX][KC_STATE_PY] = gyro->z * dt;
  A[KC_STATE_PX][KC_STATE_PZ] = -gyro->y * dt;
  A[KC_STATE_PY][KC_STATE_PX] = -gyro->z * dt;
  A[KC_STATE_PY][KC_STATE_PY] = 1 - dt * drag.b[1];
  A[KC_STATE_PY][KC_STATE_PZ] = gyro->x * dt;
  A[KC_STATE_PZ][KC_STATE_PX] = gyro->y * dt;
  A[KC_STATE_PZ][KC_STATE_PY] = -gyro->x * dt;
  A[KC_STATE_PZ][KC_STATE_PZ] = 1 - dt * drag.b[2];

  A[KC_STATE_PX][KC_STATE_D1] = g * R[2][2] * dt;
  A[KC_STATE_PX][KC_STATE_D2] = -g * R[2][1] * dt;
  A[KC_STATE_PY][KC_STATE_D0] = -g * R[2][2] * dt;
  A[KC_STATE_PY][KC_STATE_D2] = g * R[2][0] * dt;
  A[KC_STATE_PZ][KC_STATE_D0] = g * R[2][1] * dt;
  A[KC_STATE_PZ][KC_STATE_D1] = -g * R[2][0] * dt;

  rotateCovariance(A, gyro->x * dt / 2, gyro->y * dt / 2, gyro->z * dt / 2);

  mat_mult(&Am, &this->Pm, &tmpNN1m);
  mat_trans(&Am, &tmpNN2m);
  mat_mult(&tmpNN1m, &tmpNN2m, &this->Pm);

  // the state
  float moved[3] = {px * dt, py * dt, pz * dt + acc->z * dt2 / 2.0f};
  float a[3]     = {0, 0, acc->z};
  if (!quadIsFlying) {
    moved[0] = px * dt + acc->x * dt2 / 2.0f;
    moved[1] = py * dt + acc->y * dt2 / 2.0f;
    a[0]     = acc->x;
    a[1]     = acc->y;
  }
  for (int i = 0; i < 2; i++) {
    this->S[i] += R[i][0] * moved[0] + R[i][1] * moved[1] + R[i][2] * moved[2];
  }
  this->S[KC_STATE_Z] +=
      R[2][0] * moved[0] + R[2][1] * moved[1] + R[2][2] * moved[2] - g * dt2 / 2.0f;

  if (quadIsFlying) {
    const float o[3] = {gyro->y * drag.c[2] - gyro->z * drag.c[1],
                        gyro->z * drag.c[0] - gyro->x * drag.c[2],
                        gyro->x * drag.c[1] - gyro->y * drag.c[0]};
    this->S[KC_STATE_PX] +=
        dt * (gyro->z * py - gyro->y * pz - g * R[2][0] - drag.b[0] * px - drag.b[0] * o[0]);
    this->S[KC_STATE_PY] +=
        dt * (-gyro->z * px + gyro->x * pz - g * R[2][1] - drag.b[1] * py - drag.b[1] * o[1]);
    this->S[KC_STATE_PZ] +=
        dt * (a[2] + gyro->y * px - gyro->x * py - g * R[2][2] - drag.b[2] * pz - drag.b[2] * o[2]);
  } else {
    this->S[KC_STATE_PX] += dt * (a[0] + gyro->z * py - gyro->y * pz - g * R[2][0]);
    this->S[KC_STATE_PY] += dt * (a[1] - gyro->z * px + gyro->x * pz - g * R[2][1]);
    this->S[KC_STATE_PZ] += dt * (a[2] + gyro->y * px - gyro->x * py - g * R[2][2]);
  }

  float turned[4];
  turn(this->q, dt * gyro->x, dt * gyro->y, dt * gyro->z, turned);
  if (!quadIsFlying) {
    const float keep = 1.0f - reversion;
    for (int k = 0; k < 4; k++) {
      turned[k] = keep * turned[k] + reversion * this->initialQuaternion[k];
    }
  }
  normalize(turned, this->q);
  this->isUpdated = true;
}

#if MINIATURE_RELEASE >= 202512
void kalmanCorePredict(kalmanCoreData_t *this, const kalmanCoreParams_t *params, Axis3f *acc,
                       Axis3f *gyro, const uint32_t nowMs, bool quadIsFlying) {
#if MINIATURE_RELEASE >= 202608
  const drag_t drag = {{params->dragB_x, params->dragB_y, params->dragB_z},
                       {params->cop_x, params->cop_y, params->cop_z}};
#else
  const drag_t drag = {{0}, {0}};
#endif
  float dt = (nowMs - this->lastPredictionMs) / 1000.0f;
  predictDt(this, drag, acc, gyro, dt, quadIsFlying, params->attitudeReversion);
  this->lastPredictionMs = nowMs;
}
#else
void kalmanCorePredict(kalmanCoreData_t *this, Axis3f *acc, Axis3f *gyro, const uint32_t nowMs,
                       bool quadIsFlying) {
  const drag_t none = {{0}, {0}};
  float        dt   = (nowMs - this->lastPredictionMs) / 1000.0f;
  predictDt(this, none, acc, gyro, dt, quadIsFlying, 0.001f);
  this->lastPredictionMs = nowMs;
}
#endif

void kalmanCoreAddProcessNoise(kalmanCoreData_t *this, const kalmanCoreParams_t *params,
                               const uint32_t nowMs) {
  const float dt = (nowMs - this->lastProcessNoiseUpdateMs) / 1000.0f;
  if (!(dt > 0.0f)) {
    return;
  }
  const float xy =
      params->procNoiseAcc_xy * dt * dt + params->procNoiseVel * dt + params->procNoisePos;
  const float z =
      params->procNoiseAcc_z * dt * dt + params->procNoiseVel * dt + params->procNoisePos;
  const float vxy        = params->procNoiseAcc_xy * dt + params->procNoiseVel;
  const float vz         = params->procNoiseAcc_z * dt + params->procNoiseVel;
  const float rp         = params->measNoiseGyro_rollpitch * dt + params->procNoiseAtt;
  const float yaw        = params->measNoiseGyro_yaw * dt + params->procNoiseAtt;
  const float stdDevs[N] = {xy, xy, z, vxy, vxy, vz, rp, rp, yaw};
  for (int i = 0; i < N; i++) {
    this->P[i][i] += powf(stdDevs[i], 2);
  }
  bound(this, 0, 0);
  this->lastProcessNoiseUpdateMs = nowMs;
}

bool kalmanCoreFinalize(kalmanCoreData_t *this) {
  NO_DMA_CCM_SAFE_ZERO_INIT static float                             A[N][N];
  static __attribute__((aligned(4))) arm_matrix_instance_f32         Am = {N, N, (float *)A};
  NO_DMA_CCM_SAFE_ZERO_INIT __attribute__((aligned(4))) static float tmpNN1d[N * N];
  static arm_matrix_instance_f32                                     tmpNN1m = {N, N, tmpNN1d};
  NO_DMA_CCM_SAFE_ZERO_INIT __attribute__((aligned(4))) static float tmpNN2d[N * N];
  static arm_matrix_instance_f32                                     tmpNN2m = {N, N, tmpNN2d};

  if (!this->isUpdated) {
    return false;
  }

  const float v0 = this->S[KC_STATE_D0], v1 = this->S[KC_STATE_D1], v2 = this->S[KC_STATE_D2];
  if ((fabsf(v0) > 0.1e-3f || fabsf(v1) > 0.1e-3f || fabsf(v2) > 0.1e-3f) &&
      (fabsf(v0) < 10 && fabsf(v1) < 10 && fabsf(v2) < 10)) {
    float turned[4];
    turn(this->q, v0, v1, v2, turned);
    normalize(turned, this->q);

    for (int i = 0; i < KC_STATE_D0; i++) {
      A[i][i] = 1;
    }
    rotateCovariance(A, v0 / 2, v1 / 2, v2 / 2);
    mat_trans(&Am, &tmpNN1m);
    mat_mult(&Am, &this->Pm, &tmpNN2m);
    mat_mult(&tmpNN2m, &tmpNN1m, &this->Pm);
  }

  const float *q = this->q;
  this->R[0][0]  = q[0] * q[0] + q[1] * q[1] - q[2] * q[2] - q[3] * q[3];
  this->R[0][1]  = 2 * q[1] * q[2] - 2 * q[0] * q[3];
  this->R[0][2]  = 2 * q[1] * q[3] + 2 * q[0] * q[2];
  this->R[1][0]  = 2 * q[1] * q[2] + 2 * q[0] * q[3];
  this->R[1][1]  = q[0] * q[0] - q[1] * q[1] + q[2] * q[2] - q[3] * q[3];
  this->R[1][2]  = 2 * q[2] * q[3] - 2 * q[0] * q[1];
  this->R[2][0]  = 2 * q[1] * q[3] - 2 * q[0] * q[2];
  this->R[2][1]  = 2 * q[2] * q[3] + 2 * q[0] * q[1];
  this->R[2][2]  = q[0] * q[0] - q[1] * q[1] - q[2] * q[2] + q[3] * q[3];

  this->S[KC_STATE_D0] = 0;
  this->S[KC_STATE_D1] = 0;
  this->S[KC_STATE_D2] = 0;
  bound(this, 0, 0);
  this->isUpdated = false;
  return true;
}

void kalmanCoreExternalizeState(const kalmanCoreData_t *this, state_t *state, const Axis3f *acc) {
  const float (*R)[3] = this->R;
  const float *p      = &this->S[KC_STATE_PX];
  const float *q      = this->q;
  memset(state, 0, sizeof *state);

  state->position.x = this->S[KC_STATE_X];
  state->position.y = this->S[KC_STATE_Y];
  state->position.z = this->S[KC_STATE_Z];
  state->velocity.x = R[0][0] * p[0] + R[0][1] * p[1] + R[0][2] * p[2];
  state->velocity.y = R[1][0] * p[0] + R[1][1] * p[1] + R[1][2] * p[2];
  state->velocity.z = R[2][0] * p[0] + R[2][1] * p[1] + R[2][2] * p[2];
  state->acc.x      = R[0][0] * acc->x + R[0][1] * acc->y + R[0][2] * acc->z;
  state->acc.y      = R[1][0] * acc->x + R[1][1] * acc->y + R[1][2] * acc->z;
  state->acc.z      = R[2][0] * acc->x + R[2][1] * acc->y + R[2][2] * acc->z - 1;

  const float yaw             = atan2f(2 * (q[1] * q[2] + q[0] * q[3]),
                                       q[0] * q[0] + q[1] * q[1] - q[2] * q[2] - q[3] * q[3]);
  const float pitch           = asinf(-2 * (q[1] * q[3] - q[0] * q[2]));
  const float roll            = atan2f(2 * (q[2] * q[3] + q[0] * q[1]),
                                       q[0] * q[0] - q[1] * q[1] - q[2] * q[2] + q[3] * q[3]);
  state->attitude.roll        = roll * RAD_TO_DEG;
  state->attitude.pitch       = -pitch * RAD_TO_DEG;
  state->attitude.yaw         = yaw * RAD_TO_DEG;
  state->attitudeQuaternion.w = q[0];
  state->attitudeQuaternion.x = q[1];
  state->attitudeQuaternion.y = q[2];
  state->attitudeQuaternion.z = q[3];
}

void kalmanCoreDecoupleXY(kalmanCoreData_t *this) {
  const int forgotten[4] = {KC_STATE_X, KC_STATE_PX, KC_STATE_Y, KC_STATE_PY};
  for (int n = 0; n < 4; n++) {
    const int i = forgotten[n];
    for (int j = 0; j < N; j++) {
      this->P[i][j] = this->P[j][i] = 0;
    }
    this->P[i][i] = MAX_COVARIANCE;
    this->S[i]    = 0;
  }
}
