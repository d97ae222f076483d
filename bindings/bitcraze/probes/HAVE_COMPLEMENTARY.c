// The parts of the complementary estimator have the form that the adapter calls.
#include "position_estimator.h"
#include "sensfusion6.h"

void (*const init)(void)                                              = sensfusion6Init;
void (*const update)(float, float, float, float, float, float, float) = sensfusion6UpdateQ;
void (*const quaternion)(float *, float *, float *, float *)          = sensfusion6GetQuaternion;
void (*const angles)(float *, float *, float *)                       = sensfusion6GetEulerRPY;
float (*const climb)(const float, const float, const float) = sensfusion6GetAccZWithoutGravity;
void (*const velocity)(float, float)                        = positionUpdateVelocity;
void (*const height)(state_t *, const baro_t *, const tofMeasurement_t *, float,
                     stabilizerStep_t)                      = positionEstimate;
