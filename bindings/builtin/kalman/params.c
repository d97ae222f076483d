#include "api/kalman_core.h"

void kalmanCoreDefaultParams(kalmanCoreParams_t *params) {
  *params = (kalmanCoreParams_t){
      .stdDevInitialPosition_xy        = 100.0f,
      .stdDevInitialPosition_z         = 1.0f,
      .stdDevInitialVelocity           = 0.01f,
      .stdDevInitialAttitude_rollpitch = 0.01f,
      .stdDevInitialAttitude_yaw       = 0.01f,

      .procNoiseAcc_xy         = 0.5f,
      .procNoiseAcc_z          = 1.0f,
      .measNoiseBaro           = 2.0f,
      .measNoiseGyro_rollpitch = 0.1f,
      .measNoiseGyro_yaw       = 0.1f,

      .attitudeReversion = 0.001f,
  };
}
