// The estimators, by number, and the queue of what was measured.
#pragma once

// clang-format off
#include "autoconf.h"
#include "stabilizer_types.h"
// clang-format on

typedef enum {
  StateEstimatorTypeAutoSelect = 0,
  StateEstimatorTypeComplementary,
#ifdef CONFIG_ESTIMATOR_KALMAN_ENABLE
  StateEstimatorTypeKalman,
#endif
#ifdef CONFIG_ESTIMATOR_UKF_ENABLE
  StateEstimatorTypeUkf,
#endif
#ifdef CONFIG_ESTIMATOR_OOT
  StateEstimatorTypeOutOfTree,
#endif
  StateEstimatorType_COUNT,
} StateEstimatorType;

// MEASUREMENT_TYPES

void               stateEstimatorInit(StateEstimatorType estimator);
bool               stateEstimatorTest(void);
void               stateEstimatorSwitchTo(StateEstimatorType estimator);
void               stateEstimator(state_t *state, const stabilizerStep_t stabilizerStep);
StateEstimatorType stateEstimatorGetType(void);
const char        *stateEstimatorGetName();

void estimatorEnqueue(const measurement_t *measurement);
bool estimatorDequeue(measurement_t *measurement);

static inline void estimatorEnqueueTDOA(const tdoaMeasurement_t *tdoa) {
  measurement_t m;
  m.type      = MeasurementTypeTDOA;
  m.data.tdoa = *tdoa;
  estimatorEnqueue(&m);
}

static inline void estimatorEnqueuePosition(const positionMeasurement_t *position) {
  measurement_t m;
  m.type          = MeasurementTypePosition;
  m.data.position = *position;
  estimatorEnqueue(&m);
}

static inline void estimatorEnqueuePose(const poseMeasurement_t *pose) {
  measurement_t m;
  m.type      = MeasurementTypePose;
  m.data.pose = *pose;
  estimatorEnqueue(&m);
}

static inline void estimatorEnqueueDistance(const distanceMeasurement_t *distance) {
  measurement_t m;
  m.type          = MeasurementTypeDistance;
  m.data.distance = *distance;
  estimatorEnqueue(&m);
}

static inline void estimatorEnqueueTOF(const tofMeasurement_t *tof) {
  measurement_t m;
  m.type     = MeasurementTypeTOF;
  m.data.tof = *tof;
  estimatorEnqueue(&m);
}

static inline void estimatorEnqueueAbsoluteHeight(const heightMeasurement_t *height) {
  measurement_t m;
  m.type        = MeasurementTypeAbsoluteHeight;
  m.data.height = *height;
  estimatorEnqueue(&m);
}

static inline void estimatorEnqueueFlow(const flowMeasurement_t *flow) {
  measurement_t m;
  m.type      = MeasurementTypeFlow;
  m.data.flow = *flow;
  estimatorEnqueue(&m);
}

static inline void estimatorEnqueueYawError(const yawErrorMeasurement_t *yawError) {
  measurement_t m;
  m.type          = MeasurementTypeYawError;
  m.data.yawError = *yawError;
  estimatorEnqueue(&m);
}

static inline void estimatorEnqueueSweepAngles(const sweepAngleMeasurement_t *sweepAngle) {
  measurement_t m;
  m.type            = MeasurementTypeSweepAngle;
  m.data.sweepAngle = *sweepAngle;
  estimatorEnqueue(&m);
}

#ifdef CONFIG_ESTIMATOR_OOT
void estimatorOutOfTreeInit(void);
bool estimatorOutOfTreeTest(void);
void estimatorOutOfTree(state_t *state, const stabilizerStep_t stabilizerStep);
#endif
