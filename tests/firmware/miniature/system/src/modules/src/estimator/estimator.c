// The estimators, which of them estimates, and the queue of what was measured.
#define DEBUG_MODULE "ESTIMATOR"

// clang-format off
#include "stm32fxxx.h"
#include "FreeRTOS.h"
#include "queue.h"
#include "static_mem.h"

#include "debug.h"
#include "cfassert.h"
#include "estimator.h"
#include "estimator_complementary.h"
#include "estimator_kalman.h"
#include "estimator_ukf.h"
#include "log.h"
#include "statsCnt.h"
#include "eventtrigger.h"
#include "quatcompress.h"
// clang-format on

#define DEFAULT_ESTIMATOR StateEstimatorTypeComplementary

#if defined(CONFIG_ESTIMATOR_KALMAN)
#define FORCED_ESTIMATOR StateEstimatorTypeKalman
#elif defined(CONFIG_ESTIMATOR_UKF)
#define FORCED_ESTIMATOR StateEstimatorTypeUkf
#elif defined(CONFIG_ESTIMATOR_COMPLEMENTARY)
#define FORCED_ESTIMATOR StateEstimatorTypeComplementary
#endif

#define MEASUREMENTS_QUEUE_SIZE (20)
static QueueHandle_t measurementsQueue;
STATIC_MEM_QUEUE_ALLOC(measurementsQueue, MEASUREMENTS_QUEUE_SIZE, sizeof(measurement_t));

#define ONE_SECOND 1000
static STATS_CNT_RATE_DEFINE(measurementAppendedCounter, ONE_SECOND);
static STATS_CNT_RATE_DEFINE(measurementNotAppendedCounter, ONE_SECOND);

EVENTTRIGGER(estTDOA, uint8, idA, uint8, idB, float, distanceDiff)
EVENTTRIGGER(estPosition, uint8, source)
EVENTTRIGGER(estPose)
EVENTTRIGGER(estDistance, uint8, id, float, distance)
EVENTTRIGGER(estTOF)
EVENTTRIGGER(estAbsoluteHeight)
EVENTTRIGGER(estFlow)
EVENTTRIGGER(estYawError, float, yawError)
EVENTTRIGGER(estSweepAngle, uint8, sensorId, uint8, baseStationId, uint8, sweepId, float, t, float,
             sweepAngle)
EVENTTRIGGER(estGyroscope)
EVENTTRIGGER(estAcceleration)
EVENTTRIGGER(estBarometer)

static StateEstimatorType currentEstimator = StateEstimatorTypeAutoSelect;

static void initEstimator(const StateEstimatorType estimator);
static void deinitEstimator(const StateEstimatorType estimator);

typedef struct {
  void (*init)(void);
  void (*deinit)(void);
  bool (*test)(void);
  void (*update)(state_t *state, const stabilizerStep_t stabilizerStep);
  const char *name;
} EstimatorFcns;

#define NOT_IMPLEMENTED ((void *)0)

static EstimatorFcns estimatorFunctions[] = {
    {.init   = NOT_IMPLEMENTED,
     .deinit = NOT_IMPLEMENTED,
     .test   = NOT_IMPLEMENTED,
     .update = NOT_IMPLEMENTED,
     .name   = "None"},
    {.init   = estimatorComplementaryInit,
     .deinit = NOT_IMPLEMENTED,
     .test   = estimatorComplementaryTest,
     .update = estimatorComplementary,
     .name   = "Complementary"},
#ifdef CONFIG_ESTIMATOR_KALMAN_ENABLE
    {.init   = estimatorKalmanInit,
     .deinit = NOT_IMPLEMENTED,
     .test   = estimatorKalmanTest,
     .update = estimatorKalman,
     .name   = "Kalman"},
#endif
#ifdef CONFIG_ESTIMATOR_UKF_ENABLE
    {.init   = errorEstimatorUkfInit,
     .deinit = NOT_IMPLEMENTED,
     .test   = errorEstimatorUkfTest,
     .update = errorEstimatorUkf,
     .name   = "Error State UKF"},
#endif
#ifdef CONFIG_ESTIMATOR_OOT
    {.init   = estimatorOutOfTreeInit,
     .deinit = NOT_IMPLEMENTED,
     .test   = estimatorOutOfTreeTest,
     .update = estimatorOutOfTree,
     .name   = "OutOfTree"},
#endif
};

void stateEstimatorInit(StateEstimatorType estimator) {
  measurementsQueue = STATIC_MEM_QUEUE_CREATE(measurementsQueue);
  stateEstimatorSwitchTo(estimator);
}

void stateEstimatorSwitchTo(StateEstimatorType estimator) {
  if (estimator < 0 || estimator >= StateEstimatorType_COUNT) {
    return;
  }
  StateEstimatorType newEstimator = estimator;
  if (newEstimator == StateEstimatorTypeAutoSelect) {
    newEstimator = DEFAULT_ESTIMATOR;
  }
#ifdef FORCED_ESTIMATOR
  DEBUG_PRINT("Estimator type forced\n");
  newEstimator = FORCED_ESTIMATOR;
#endif

  initEstimator(newEstimator);
  const StateEstimatorType previousEstimator = currentEstimator;
  currentEstimator                           = newEstimator;
  deinitEstimator(previousEstimator);
  DEBUG_PRINT("Using %s (%d) estimator\n", stateEstimatorGetName(), currentEstimator);
}

StateEstimatorType stateEstimatorGetType(void) {
  return currentEstimator;
}

static void initEstimator(const StateEstimatorType estimator) {
  if (estimatorFunctions[estimator].init) {
    estimatorFunctions[estimator].init();
  }
}

static void deinitEstimator(const StateEstimatorType estimator) {
  if (estimatorFunctions[estimator].deinit) {
    estimatorFunctions[estimator].deinit();
  }
}

bool stateEstimatorTest(void) {
  return estimatorFunctions[currentEstimator].test();
}

void stateEstimator(state_t *state, const stabilizerStep_t stabilizerStep) {
  estimatorFunctions[currentEstimator].update(state, stabilizerStep);
}

const char *stateEstimatorGetName() {
  return estimatorFunctions[currentEstimator].name;
}

// Tells loggers, also of what the queue has no room for.
static void triggerEvent(const measurement_t *measurement) {
  switch (measurement->type) {
    case MeasurementTypeTDOA:
      eventTrigger_estTDOA_payload.idA          = measurement->data.tdoa.anchorIdA;
      eventTrigger_estTDOA_payload.idB          = measurement->data.tdoa.anchorIdB;
      eventTrigger_estTDOA_payload.distanceDiff = measurement->data.tdoa.distanceDiff;
      eventTrigger(&eventTrigger_estTDOA);
      break;
    case MeasurementTypePosition:
      eventTrigger_estPosition_payload.source = measurement->data.position.source;
      eventTrigger(&eventTrigger_estPosition);
      break;
    case MeasurementTypePose:
      eventTrigger(&eventTrigger_estPose);
      break;
    case MeasurementTypeDistance:
      eventTrigger_estDistance_payload.id       = measurement->data.distance.anchorId;
      eventTrigger_estDistance_payload.distance = measurement->data.distance.distance;
      eventTrigger(&eventTrigger_estDistance);
      break;
    case MeasurementTypeTOF:
      eventTrigger(&eventTrigger_estTOF);
      break;
    case MeasurementTypeAbsoluteHeight:
      eventTrigger(&eventTrigger_estAbsoluteHeight);
      break;
    case MeasurementTypeFlow:
      eventTrigger(&eventTrigger_estFlow);
      break;
    case MeasurementTypeYawError:
      eventTrigger_estYawError_payload.yawError = measurement->data.yawError.yawError;
      eventTrigger(&eventTrigger_estYawError);
      break;
    case MeasurementTypeSweepAngle:
      eventTrigger_estSweepAngle_payload.sensorId      = measurement->data.sweepAngle.sensorId;
      eventTrigger_estSweepAngle_payload.baseStationId = measurement->data.sweepAngle.baseStationId;
      eventTrigger_estSweepAngle_payload.sweepId       = measurement->data.sweepAngle.sweepId;
      eventTrigger_estSweepAngle_payload.t             = measurement->data.sweepAngle.t;
      eventTrigger_estSweepAngle_payload.sweepAngle =
          measurement->data.sweepAngle.measuredSweepAngle;
      eventTrigger(&eventTrigger_estSweepAngle);
      break;
    case MeasurementTypeGyroscope:
      eventTrigger(&eventTrigger_estGyroscope);
      break;
    case MeasurementTypeAcceleration:
      eventTrigger(&eventTrigger_estAcceleration);
      break;
    case MeasurementTypeBarometer:
      eventTrigger(&eventTrigger_estBarometer);
      break;
    default:
      break;
  }
}

void estimatorEnqueue(const measurement_t *measurement) {
  if (!measurementsQueue) {
    return;
  }

  portBASE_TYPE result;
  const bool    isInInterrupt = (SCB->ICSR & SCB_ICSR_VECTACTIVE_Msk) != 0;
  if (isInInterrupt) {
    portBASE_TYPE xHigherPriorityTaskWoken = pdFALSE;
    result = xQueueSendFromISR(measurementsQueue, measurement, &xHigherPriorityTaskWoken);
    if (xHigherPriorityTaskWoken == pdTRUE) {
      portYIELD();
    }
  } else {
    result = xQueueSend(measurementsQueue, measurement, 0);
  }

  if (result == pdTRUE) {
    STATS_CNT_RATE_EVENT(&measurementAppendedCounter);
  } else {
    STATS_CNT_RATE_EVENT(&measurementNotAppendedCounter);
  }
  triggerEvent(measurement);
}

bool estimatorDequeue(measurement_t *measurement) {
  return pdTRUE == xQueueReceive(measurementsQueue, measurement, 0);
}

LOG_GROUP_START(estimator)
STATS_CNT_RATE_LOG_ADD(rtApnd, &measurementAppendedCounter)
STATS_CNT_RATE_LOG_ADD(rtRej, &measurementNotAppendedCounter)
LOG_GROUP_STOP(estimator)
