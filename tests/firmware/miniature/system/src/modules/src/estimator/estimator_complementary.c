// Attitude and height from inertial sensors and a barometer or a range finder.
// clang-format off
#include "stm32f4xx.h"

#include "FreeRTOS.h"
#include "queue.h"

#include "stabilizer.h"
#include "estimator_complementary.h"
#include "sensfusion6.h"
#include "position_estimator.h"
#include "sensors.h"
#include "stabilizer_types.h"
#include "static_mem.h"
// clang-format on

#define ATTITUDE_UPDATE_RATE RATE_250_HZ
#define ATTITUDE_UPDATE_DT (1.0f / ATTITUDE_UPDATE_RATE)
#define POS_UPDATE_RATE RATE_100_HZ
#define POS_UPDATE_DT (1.0f / POS_UPDATE_RATE)

static Axis3f           gyro;
static Axis3f           acc;
static baro_t           baro;
static tofMeasurement_t tof;

void estimatorComplementaryInit(void) {
  sensfusion6Init();
}

bool estimatorComplementaryTest(void) {
  return sensfusion6Test();
}

void estimatorComplementary(state_t *state, const stabilizerStep_t stabilizerStep) {
  measurement_t m;
  while (estimatorDequeue(&m)) {
    switch (m.type) {
      case MeasurementTypeGyroscope:
        gyro = m.data.gyroscope.gyro;
        break;
      case MeasurementTypeAcceleration:
        acc = m.data.acceleration.acc;
        break;
      case MeasurementTypeBarometer:
        baro = m.data.barometer.baro;
        break;
      case MeasurementTypeTOF:
        tof = m.data.tof;
        break;
      default:
        break;
    }
  }

  if (RATE_DO_EXECUTE(ATTITUDE_UPDATE_RATE, stabilizerStep)) {
    sensfusion6UpdateQ(gyro.x, gyro.y, gyro.z, acc.x, acc.y, acc.z, ATTITUDE_UPDATE_DT);
    sensfusion6GetEulerRPY(&state->attitude.roll, &state->attitude.pitch, &state->attitude.yaw);
    sensfusion6GetQuaternion(&state->attitudeQuaternion.x, &state->attitudeQuaternion.y,
                             &state->attitudeQuaternion.z, &state->attitudeQuaternion.w);
    state->acc.z = sensfusion6GetAccZWithoutGravity(acc.x, acc.y, acc.z);
    positionUpdateVelocity(state->acc.z, ATTITUDE_UPDATE_DT);
  }
  if (RATE_DO_EXECUTE(POS_UPDATE_RATE, stabilizerStep)) {
    positionEstimate(state, &baro, &tof, POS_UPDATE_DT, stabilizerStep);
  }
}
