// The parts of the complementary estimator have the form that the adapter calls.
#include "position_estimator.h"
#include "sensfusion6.h"

float probe(state_t *state, baro_t *baro, tofMeasurement_t *tof, float *q);
float probe(state_t *state, baro_t *baro, tofMeasurement_t *tof, float *q) {
  sensfusion6Init();
  sensfusion6UpdateQ(1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 0.004f);
  sensfusion6GetQuaternion(q, q, q, q);
  sensfusion6GetEulerRPY(q, q, q);
  positionUpdateVelocity(1.0f, 0.004f);
  positionEstimate(state, baro, tof, 0.01f, 10u);
  return sensfusion6GetAccZWithoutGravity(1.0f, 1.0f, 1.0f);
}
