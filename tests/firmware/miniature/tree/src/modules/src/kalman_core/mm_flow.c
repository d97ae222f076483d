#include "mm_flow.h"

#include "log.h"
#if MINIATURE_RELEASE >= 202608
#include "param.h"
#include "platform_defaults.h"
#endif

#define FLOW_RESOLUTION 0.1f

static float predictedNX;
static float predictedNY;
static float measuredNX;
static float measuredNY;

#if MINIATURE_RELEASE >= 202608
// where the deck is, seen from the center of mass
static float flowdeckPos_x = FLOWDECK_POS_X;
static float flowdeckPos_y = FLOWDECK_POS_Y;
static float flowdeckPos_z = FLOWDECK_POS_Z;
#else
static const float flowdeckPos_x = 0.0f;
static const float flowdeckPos_y = 0.0f;
static const float flowdeckPos_z = 0.0f;
#endif

void kalmanCoreUpdateWithFlow(kalmanCoreData_t *this, const flowMeasurement_t *flow,
                              const Axis3f *gyro) {
  const float Npix     = 35.0f;
  const float thetapix = 0.71674f;
  const float wx = gyro->x * DEG_TO_RAD, wy = gyro->y * DEG_TO_RAD, wz = gyro->z * DEG_TO_RAD;
  const float z  = this->S[KC_STATE_Z] < 0.1f ? 0.1f : this->S[KC_STATE_Z];
  const float vx = this->S[KC_STATE_PX] + (wy * flowdeckPos_z - wz * flowdeckPos_y);
  const float vy = this->S[KC_STATE_PY] + (wz * flowdeckPos_x - wx * flowdeckPos_z);
  const float r  = this->R[2][2];
  const float k  = flow->dt * Npix / thetapix;

  float                   hx[KC_STATE_DIM] = {0};
  arm_matrix_instance_f32 Hx               = {1, KC_STATE_DIM, hx};
  predictedNX                              = k * (vx * r / z - wy);
  measuredNX                               = flow->dpixelx * FLOW_RESOLUTION;
  hx[KC_STATE_Z]                           = k * (r * vx / (-z * z));
  hx[KC_STATE_PX]                          = k * (r / z);
  kalmanCoreScalarUpdate(this, &Hx, measuredNX - predictedNX, flow->stdDevX * FLOW_RESOLUTION);

  float                   hy[KC_STATE_DIM] = {0};
  arm_matrix_instance_f32 Hy               = {1, KC_STATE_DIM, hy};
  predictedNY                              = k * (vy * r / z + wx);
  measuredNY                               = flow->dpixely * FLOW_RESOLUTION;
  hy[KC_STATE_Z]                           = k * (r * vy / (-z * z));
  hy[KC_STATE_PY]                          = k * (r / z);
  kalmanCoreScalarUpdate(this, &Hy, measuredNY - predictedNY, flow->stdDevY * FLOW_RESOLUTION);
}

LOG_GROUP_START(kalman_pred)
LOG_ADD(LOG_FLOAT, predNX, &predictedNX)
LOG_ADD(LOG_FLOAT, predNY, &predictedNY)
LOG_ADD(LOG_FLOAT, measNX, &measuredNX)
LOG_ADD(LOG_FLOAT, measNY, &measuredNY)
LOG_GROUP_STOP(kalman_pred)
#if MINIATURE_RELEASE >= 202608

PARAM_GROUP_START(flowdeck)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, flowdeckPos_x, &flowdeckPos_x)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, flowdeckPos_y, &flowdeckPos_y)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, flowdeckPos_z, &flowdeckPos_z)
PARAM_GROUP_STOP(flowdeck)
#endif
