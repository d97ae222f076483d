#include "onboard/estimator.h"

#include <stddef.h>

#include "variable_row.h"

#define PREDICT_INTERVAL_MS 10
#define RATE_INTERVAL_MS 1000

#define GRAVITY_MAGNITUDE 9.81f  // [m/s^2]
#define DEG_TO_RAD (3.14159265358979f / 180.0f)

static void restart_filter(cf_estimator_t *estimator, const cf_provider_t *provider,
                           void *provider_state, uint32_t now_ms) {
  axis3fSubSamplerInit(&estimator->accSubSampler, GRAVITY_MAGNITUDE);
  axis3fSubSamplerInit(&estimator->gyroSubSampler, DEG_TO_RAD);
  provider->kalman_init(provider_state, now_ms);
}

void cf_estimator_init(cf_estimator_t *estimator, const cf_provider_t *provider,
                       void *provider_state, int type, uint32_t now_ms) {
  *estimator = (cf_estimator_t){.nextPredictionMs = now_ms, .rate_start_ms = now_ms};
  cf_estimator_switch_to(estimator, provider, provider_state, type, now_ms);
}

bool cf_estimator_switch_to(cf_estimator_t *estimator, const cf_provider_t *provider,
                            void *provider_state, int type, uint32_t now_ms) {
  if (!cf_estimator_exists(provider, type)) {
    return false;
  }
  if (type == StateEstimatorTypeKalman) {
    restart_filter(estimator, provider, provider_state, now_ms);
    estimator->type = StateEstimatorTypeKalman;
  } else if (type == StateEstimatorTypeOutOfTree) {
    provider->out_of_tree_estimator_init(provider_state);
    estimator->type = StateEstimatorTypeOutOfTree;
  } else {
    provider->complementary_init(provider_state);
    estimator->type = StateEstimatorTypeComplementary;
  }
  return true;
}

bool cf_estimator_exists(const cf_provider_t *provider, int type) {
  return cf_estimator_name(type) != NULL &&
         (type != StateEstimatorTypeOutOfTree || provider->out_of_tree_estimator != NULL);
}

const char *cf_estimator_name(int type) {
  static const char *const NAMES[StateEstimatorType_COUNT] = {"None", "Complementary", "Kalman",
                                                              "OutOfTree"};
  return type >= 0 && type < StateEstimatorType_COUNT ? NAMES[type] : NULL;
}

bool cf_estimator_enqueue(cf_estimator_t *estimator, const measurement_t *measurement) {
  estimator->events[CF_ESTIMATOR_APPENDED]++;

  if (estimator->queue_count >= CF_ESTIMATOR_QUEUE_SIZE) {
    estimator->events[CF_ESTIMATOR_REJECTED]++;
    estimator->rejected++;
    return false;
  }

  estimator->queue[estimator->queue_count++] = *measurement;
  return true;
}

// ----------------------------------------------------------------------- complementary estimator

static void keep(cf_latest_samples_t *latest, const measurement_t *measurement) {
  switch (measurement->type) {
    case MeasurementTypeGyroscope:
      latest->gyro = measurement->data.gyroscope.gyro;
      break;
    case MeasurementTypeAcceleration:
      latest->acc = measurement->data.acceleration.acc;
      break;
    case MeasurementTypeBarometer:
      latest->baro = measurement->data.barometer.baro;
      break;
    case MeasurementTypeTOF:
      latest->tof = measurement->data.tof;
      break;
    default:
      // poses, flow and the like are lost on this estimator
      break;
  }
}

int cf_estimator_take_queue(cf_estimator_t *estimator, measurement_t *queue,
                            cf_resolved_sweep_t *sweeps) {
  const uint32_t count = estimator->queue_count;
  for (uint32_t i = 0; i < count; i++) {
    queue[i] = *cf_lighthouse_resolve(&sweeps[i], &estimator->queue[i], &estimator->stations);
  }
  estimator->queue_count = 0;
  return (int)count;
}

// Not inlined, because the others have no need of that much stack.
__attribute__((noinline)) static void run_out_of_tree(cf_estimator_t      *estimator,
                                                      const cf_provider_t *provider,
                                                      void *provider_state, state_t *estimate,
                                                      stabilizerStep_t step, uint32_t now_ms) {
  measurement_t       queue[CF_ESTIMATOR_QUEUE_SIZE];
  cf_resolved_sweep_t sweeps[CF_ESTIMATOR_QUEUE_SIZE];
  const int           count = cf_estimator_take_queue(estimator, queue, sweeps);
  provider->out_of_tree_estimator(provider_state, queue, count, estimate, step, now_ms);
}

void cf_estimator_update(cf_estimator_t *estimator, const cf_provider_t *provider,
                         void *provider_state, state_t *estimate, stabilizerStep_t step,
                         uint32_t now_ms) {
  if (estimator->type == StateEstimatorTypeKalman) {
    cf_estimator_get(estimator, estimate);
    return;
  }
  if (estimator->type == StateEstimatorTypeOutOfTree) {
    run_out_of_tree(estimator, provider, provider_state, estimate, step, now_ms);
    return;
  }
  for (uint32_t i = 0; i < estimator->queue_count; i++) {
    keep(&estimator->latest, &estimator->queue[i]);
  }
  estimator->queue_count = 0;

  provider->complementary(provider_state, &estimator->latest, estimate, step, now_ms);
}

// --------------------------------------------------------------------------------- Kalman filter

void cf_estimator_get(const cf_estimator_t *estimator, state_t *estimate) {
  *estimate = estimator->estimate;
}

static void predict(cf_estimator_t *estimator, const cf_provider_t *provider, void *provider_state,
                    uint32_t now_ms, bool is_flying) {
  const Axis3f *acc  = axis3fSubSamplerFinalize(&estimator->accSubSampler);
  const Axis3f *gyro = axis3fSubSamplerFinalize(&estimator->gyroSubSampler);
  provider->kalman_predict(provider_state, acc, gyro, now_ms, is_flying);

  estimator->nextPredictionMs = now_ms + PREDICT_INTERVAL_MS;
  estimator->events[CF_ESTIMATOR_PREDICTED]++;
}

static void fuse(cf_estimator_t *estimator, const cf_provider_t *provider, void *provider_state,
                 const measurement_t *measurement, uint32_t now_ms) {
  switch (measurement->type) {
    case MeasurementTypeGyroscope:
      estimator->gyroLatest = measurement->data.gyroscope.gyro;
      axis3fSubSamplerAccumulate(&estimator->gyroSubSampler, &estimator->gyroLatest);
      break;
    case MeasurementTypeAcceleration:
      estimator->accLatest = measurement->data.acceleration.acc;
      axis3fSubSamplerAccumulate(&estimator->accSubSampler, &estimator->accLatest);
      break;
    default: {
      cf_resolved_sweep_t sweep;
      measurement = cf_lighthouse_resolve(&sweep, measurement, &estimator->stations);
      provider->kalman_update(provider_state, measurement, &estimator->gyroLatest, now_ms);
      break;
    }
  }
}

static void drain_queue(cf_estimator_t *estimator, const cf_provider_t *provider,
                        void *provider_state, uint32_t now_ms) {
  // strictly in order: flow uses the gyroscope sample that came before it
  for (uint32_t i = 0; i < estimator->queue_count; i++) {
    fuse(estimator, provider, provider_state, &estimator->queue[i], now_ms);
  }
  estimator->queue_count = 0;
}

static void update_rates(cf_estimator_t *estimator, uint32_t now_ms) {
  const uint32_t elapsed_ms = now_ms - estimator->rate_start_ms;
  if (elapsed_ms < RATE_INTERVAL_MS) {
    return;
  }
  for (int i = 0; i < CF_ESTIMATOR_EVENTS; i++) {
    estimator->rates[i]  = (float)estimator->events[i] * 1000.0f / (float)elapsed_ms;
    estimator->events[i] = 0;
  }
  estimator->rate_start_ms = now_ms;
}

static void run_loop(cf_estimator_t *estimator, const cf_provider_t *provider, void *provider_state,
                     uint32_t now_ms, bool is_flying) {
  if (estimator->resetEstimation) {
    restart_filter(estimator, provider, provider_state, now_ms);
    estimator->resetEstimation = 0;
  }

  // the averages hold what earlier loops drained, so that the newest sample is one loop old
  if (now_ms >= estimator->nextPredictionMs) {
    predict(estimator, provider, provider_state, now_ms, is_flying);
  }
  provider->kalman_add_process_noise(provider_state, now_ms);
  drain_queue(estimator, provider, provider_state, now_ms);

  if (provider->kalman_finalize(provider_state)) {
    estimator->events[CF_ESTIMATOR_FINALIZED]++;
  }
  if (!provider->kalman_is_within_bounds(provider_state)) {
    estimator->resetEstimation = 1;
  }
  provider->kalman_externalize(provider_state, &estimator->estimate, &estimator->accLatest);

  estimator->events[CF_ESTIMATOR_UPDATED]++;
}

void cf_estimator_run(cf_estimator_t *estimator, const cf_provider_t *provider,
                      void *provider_state, uint32_t now_ms, bool is_flying) {
  if (estimator->type == StateEstimatorTypeKalman) {
    run_loop(estimator, provider, provider_state, now_ms, is_flying);
  }
  update_rates(estimator, now_ms);
}

// ------------------------------------------------------------------------------------- variables

static const cf_variable_t PARAMETERS[] = {
    CF_ROW("kalman", "resetEstimation", UINT8, CF_CORE, cf_estimator_t, resetEstimation),
};

#define RATE(group, name, event) CF_ROW(group, name, FLOAT, 0, cf_estimator_t, rates[event])

static const cf_variable_t LOGS[] = {
    RATE("kalman", "rtUpdate", CF_ESTIMATOR_UPDATED),
    RATE("kalman", "rtPred", CF_ESTIMATOR_PREDICTED),
    RATE("kalman", "rtFinal", CF_ESTIMATOR_FINALIZED),
    RATE("estimator", "rtApnd", CF_ESTIMATOR_APPENDED),
    RATE("estimator", "rtRej", CF_ESTIMATOR_REJECTED),
};

cf_variables_t cf_estimator_parameters(void) {
  return (cf_variables_t){.rows = PARAMETERS, .count = sizeof(PARAMETERS) / sizeof(PARAMETERS[0])};
}

cf_variables_t cf_estimator_logs(void) {
  return (cf_variables_t){.rows = LOGS, .count = sizeof(LOGS) / sizeof(LOGS[0])};
}
