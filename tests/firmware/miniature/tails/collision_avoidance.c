#ifdef CRAZYFLIE_FW
// clang-format off
#include "FreeRTOS.h"
#include "task.h"
#include "param.h"
#include "log.h"
// clang-format on

static uint8_t                      collisionAvoidanceEnable;
static collision_avoidance_params_t params = {
    .ellipsoidRadii             = {.x = 0.3f, .y = 0.3f, .z = 0.9f},
    .bboxMin                    = {.x = -FLT_MAX, .y = -FLT_MAX, .z = -FLT_MAX},
    .bboxMax                    = {.x = FLT_MAX, .y = FLT_MAX, .z = FLT_MAX},
    .horizonSecs                = 1.0f,
    .maxSpeed                   = 0.5f,
    .sidestepThreshold          = 0.25f,
    .maxPeerLocAgeMillis        = 5000,
    .voronoiProjectionTolerance = 1e-5f,
    .voronoiProjectionMaxIters  = 100,
};
static collision_avoidance_state_t collisionState = {
    .lastFeasibleSetPosition = {.x = NAN, .y = NAN, .z = NAN}};

static uint32_t latency;  // [ticks]

static float workspace[FLOATS_PER_ROW * (PEER_LOCALIZATION_MAX_NEIGHBORS + BOX_ROWS)];

void collisionAvoidanceInit(void) {
}

bool collisionAvoidanceTest(void) {
  return true;
}

void collisionAvoidanceUpdateSetpoint(setpoint_t *setpoint, const sensorData_t *sensorData,
                                      const state_t *state, stabilizerStep_t stabilizerStep) {
  (void)stabilizerStep;
  if (!collisionAvoidanceEnable) {
    return;
  }
  int            count = 0;
  const uint32_t now   = xTaskGetTickCount();
  for (int i = 0; i < PEER_LOCALIZATION_MAX_NEIGHBORS; i++) {
    const peerLocalizationOtherPosition_t *other = peerLocalizationGetPositionByIdx(i);
    if (other == NULL || other->id == 0 ||
        (params.maxPeerLocAgeMillis >= 0 &&
         now - other->pos.timestamp > (uint32_t)params.maxPeerLocAgeMillis)) {
      continue;
    }
    workspace[3 * count]     = other->pos.x;
    workspace[3 * count + 1] = other->pos.y;
    workspace[3 * count + 2] = other->pos.z;
    count++;
  }
  collisionAvoidanceUpdateSetpointCore(&params, &collisionState, count, workspace, workspace,
                                       setpoint, sensorData, state);
  latency = xTaskGetTickCount() - now;
}

PARAM_GROUP_START(colAv)
PARAM_ADD(PARAM_UINT8, enable, &collisionAvoidanceEnable)
PARAM_ADD(PARAM_FLOAT, ellipsoidX, &params.ellipsoidRadii.x)
PARAM_ADD(PARAM_FLOAT, ellipsoidY, &params.ellipsoidRadii.y)
PARAM_ADD(PARAM_FLOAT, ellipsoidZ, &params.ellipsoidRadii.z)
PARAM_ADD(PARAM_FLOAT, bboxMinX, &params.bboxMin.x)
PARAM_ADD(PARAM_FLOAT, bboxMinY, &params.bboxMin.y)
PARAM_ADD(PARAM_FLOAT, bboxMinZ, &params.bboxMin.z)
PARAM_ADD(PARAM_FLOAT, bboxMaxX, &params.bboxMax.x)
PARAM_ADD(PARAM_FLOAT, bboxMaxY, &params.bboxMax.y)
PARAM_ADD(PARAM_FLOAT, bboxMaxZ, &params.bboxMax.z)
PARAM_ADD(PARAM_FLOAT, horizon, &params.horizonSecs)
PARAM_ADD(PARAM_FLOAT, maxSpeed, &params.maxSpeed)
PARAM_ADD(PARAM_FLOAT, sidestepThrsh, &params.sidestepThreshold)
PARAM_ADD(PARAM_INT32, maxPeerLocAge, &params.maxPeerLocAgeMillis)
PARAM_ADD(PARAM_FLOAT, vorTol, &params.voronoiProjectionTolerance)
PARAM_ADD(PARAM_INT32, vorIters, &params.voronoiProjectionMaxIters)
PARAM_GROUP_STOP(colAv)

LOG_GROUP_START(colAv)
LOG_ADD(LOG_UINT32, latency, &latency)
LOG_GROUP_STOP(colAv)
#endif  // CRAZYFLIE_FW
