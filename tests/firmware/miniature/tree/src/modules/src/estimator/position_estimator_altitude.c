// clang-format off
#include "stm32f4xx.h"
#include "FreeRTOS.h"
#include "task.h"

#include "log.h"
#include "param.h"
#include "num.h"
#include "position_estimator.h"
// clang-format on

#define G 9.81f;

struct selfState_s {
  float estimatedZ;
  float velocityZ;
  float estAlphaZrange;
  float estAlphaAsl;
  float velocityFactor;
  float vAccDeadband;
  float velZAlpha;
  float estimatedVZ;
};

static struct selfState_s state = {
    .estAlphaZrange = 0.90f,
    .estAlphaAsl    = 0.90f,
    .velocityFactor = 1.0f,
    .vAccDeadband   = 0.04f,
    .velZAlpha      = 0.995f,
};

void positionEstimate(state_t *estimate, const baro_t *baro, const tofMeasurement_t *tofMeasurement,
                      float dt, stabilizerStep_t stabilizerStep) {
  static bool  surfaceFollowingMode = false;
  static float filteredZ;
  (void)stabilizerStep;

  const uint32_t now            = xTaskGetTickCount();
  const bool     isSampleUseful = (now - tofMeasurement->timestamp) <= 50;
  const float    prev           = state.estimatedZ;
  const float    climbed        = state.velocityFactor * state.velocityZ * dt;
  if (isSampleUseful) {
    surfaceFollowingMode = true;
  }
  if (surfaceFollowingMode) {
    if (isSampleUseful) {
      state.estimatedZ = (state.estAlphaZrange * state.estimatedZ +
                          (1.0f - state.estAlphaZrange) * tofMeasurement->distance) +
                         climbed;
    }
  } else {
    filteredZ = baro->asl;
    if (state.estimatedZ != 0.0f) {
      filteredZ = state.estAlphaAsl * state.estimatedZ + (1.0f - state.estAlphaAsl) * baro->asl;
    }
    state.estimatedZ = filteredZ + climbed;
  }
  estimate->position.x = 0.0f;
  estimate->position.y = 0.0f;
  estimate->position.z = state.estimatedZ;
  estimate->velocity.z = (state.estimatedZ - prev) / dt;
  state.estimatedVZ    = estimate->velocity.z;
}

void positionUpdateVelocity(float accWZ, float dt) {
  state.velocityZ += deadband(accWZ, state.vAccDeadband) *dt *G state.velocityZ *= state.velZAlpha;
}

LOG_GROUP_START(posEstAlt)
LOG_ADD(LOG_FLOAT, estimatedZ, &state.estimatedZ)
LOG_ADD(LOG_FLOAT, estVZ, &state.estimatedVZ)
LOG_ADD(LOG_FLOAT, velocityZ, &state.velocityZ)
LOG_GROUP_STOP(posEstAlt)

PARAM_GROUP_START(posEstAlt)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, estAlphaAsl, &state.estAlphaAsl)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, estAlphaZr, &state.estAlphaZrange)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, velFactor, &state.velocityFactor)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, velZAlpha, &state.velZAlpha)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, vAccDeadband, &state.vAccDeadband)
PARAM_GROUP_STOP(posEstAlt)
