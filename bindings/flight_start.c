#include "flight_start.h"

#include <math.h>
#include <string.h>

#include "builtin/builtin.h"
#include "providers.h"

#define BUILTIN 0
#define DEGREES (180.0 / 3.14159265358979323846)
#define NORM_TOLERANCE 0.01

static bool is_allowed(const cf_flight_start_t *start) {
  double sum = 0.0;
  for (int i = 0; i < 3; i++) {
    sum += start->position[i] + start->velocity[i] + start->rates[i];
  }
  const double *q    = start->quat_wxyz;
  const double  norm = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  return isfinite(sum) && fabs(norm - 1.0) < NORM_TOLERANCE;
}

// --------------------------------------------------------------------------- what the drone knows

// Body to world.
static void rotation_of(const double q[4], float r[3][3]) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  const double rotation[3][3] = {
      {1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
      {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
      {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)},
  };
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      r[i][j] = (float)rotation[i][j];
    }
  }
}

static void tell_filter(cf_kalman_t *kalman, const cf_flight_start_t *start) {
  kalmanCoreData_t *core = &kalman->core;
  rotation_of(start->quat_wxyz, core->R);
  for (int i = 0; i < 4; i++) {
    core->q[i] = (float)start->quat_wxyz[i];
  }
  for (int i = 0; i < 3; i++) {
    core->S[KC_STATE_X + i]  = (float)start->position[i];
    core->S[KC_STATE_PX + i] = 0.0f;
    core->S[KC_STATE_D0 + i] = 0.0f;
    for (int j = 0; j < 3; j++) {
      core->S[KC_STATE_PX + i] += core->R[j][i] * (float)start->velocity[j];
    }
  }
}

static void tell_sensors(cf_onboard_t *onboard, const cf_flight_start_t *start) {
  cf_sensors_t *sensors = &onboard->sensors;
  for (int i = 0; i < 3; i++) {
    const float rate           = (float)(start->rates[i] * DEGREES);
    sensors->data.gyro.axis[i] = lpf2pReset(&sensors->gyro_filter[i], rate);
  }
  Axis3fSubSampler_t *gyro = &onboard->estimator.gyroSubSampler;
  Axis3fSubSampler_t *acc  = &onboard->estimator.accSubSampler;
  gyro->count = acc->count = 0;
  memset(&gyro->sum, 0, sizeof gyro->sum);
  memset(&acc->sum, 0, sizeof acc->sum);
  onboard->estimator.gyroLatest  = sensors->data.gyro;
  onboard->estimator.queue_count = 0;
}

static void tell_controller(cf_controller_pid_t *pid, const state_t *estimate) {
  const point_t *at = &estimate->position;
  cf_position_controller_reset(&pid->position, at->x, at->y, at->z);
  cf_position_controller_reset_filters(&pid->position);
  cf_attitude_controller_reset(&pid->attitude, &estimate->attitude);
  pid->attitude_desired = estimate->attitude;
}

static void tell_onboard(cf_t *cf, const cf_flight_start_t *start) {
  cf_onboard_t        *onboard  = &cf->onboard;
  cf_builtin_t        *builtin  = (cf_builtin_t *)(void *)cf->provider_state;
  const cf_provider_t *provider = cf_provider(BUILTIN);
  tell_filter(&builtin->kalman, start);
  tell_sensors(onboard, start);
  provider->kalman_externalize(builtin, &onboard->estimator.estimate,
                               &onboard->estimator.accLatest);
  onboard->estimate = onboard->estimator.estimate;
  tell_controller(&builtin->pid, &onboard->estimate);
}

// ----------------------------------------------------------------------------------- its own dice

// Each generator gets a sequence of its own, in this order.
static void throw_new_dice(cf_vehicle_t *vehicle, const cf_flight_start_t *start) {
  cf_random_init(&vehicle->random, start->seed, start->id);
  cf_random_t *const common[] = {&vehicle->imu.random, &vehicle->barometer.random,
                                 &vehicle->wind.random, &vehicle->rangers.random,
                                 &vehicle->rangers.mishap_random};
  for (size_t i = 0; i < sizeof common / sizeof common[0]; i++) {
    *common[i] = cf_random_split(&vehicle->random);
  }
  const cf_random_t noise  = cf_random_split(&vehicle->random);
  const cf_random_t mishap = cf_random_split(&vehicle->random);
  switch (vehicle->positioning) {
    case CF_POSITIONING_MOCAP:
    case CF_POSITIONING_MOCAP_POSITION:
      vehicle->mocap.random        = noise;
      vehicle->mocap.mishap_random = mishap;
      vehicle->mocap.waiting       = 0;
      break;
    case CF_POSITIONING_FLOW:
      vehicle->flow_deck.random        = noise;
      vehicle->flow_deck.mishap_random = mishap;
      break;
    case CF_POSITIONING_LIGHTHOUSE:
      vehicle->lighthouse.random        = noise;
      vehicle->lighthouse.mishap_random = mishap;
      break;
    case CF_POSITIONING_LOCO_TWR:
    case CF_POSITIONING_LOCO_TDOA2:
    case CF_POSITIONING_LOCO_TDOA3:
      vehicle->loco.random        = noise;
      vehicle->loco.mishap_random = mishap;
      break;
    default:
      break;
  }
}

// ------------------------------------------------------------------------------------------ starts

cf_status_t cf_start_flight(cf_t *cf, const cf_t *pattern, const cf_flight_start_t *start) {
  if (!is_allowed(start)) {
    return CF_ERR_VALUE;
  }
  if (cf->config.provider != BUILTIN || pattern->config.provider != BUILTIN) {
    return CF_ERR_STATE;
  }
  if (cf != pattern) {
    memcpy(cf, pattern, sizeof *cf);
  }
  memcpy(cf->last_velocity, start->velocity, sizeof cf->last_velocity);
  memcpy(cf->last_rates, start->rates, sizeof cf->last_rates);
  cf->has_last_velocity = true;
  throw_new_dice(&cf->vehicle, start);
  tell_onboard(cf, start);
  return CF_OK;
}

static void move_body(const cf_flights_t *flights, size_t number, const cf_flight_start_t *start) {
  double *pose  = flights->qpos + number * (size_t)flights->qpos_stride;
  double *twist = flights->qvel + number * (size_t)flights->qvel_stride;
  memcpy(pose, start->position, sizeof start->position);
  memcpy(pose + 3, start->quat_wxyz, sizeof start->quat_wxyz);
  memcpy(twist, start->velocity, sizeof start->velocity);
  memcpy(twist + 3, start->rates, sizeof start->rates);
}

static void begin_episode(const cf_flights_t *flights, size_t number, const double *plan) {
  const size_t plan_size   = (size_t)flights->plan_size;
  const size_t action_size = (size_t)flights->action_size;
  flights->episodes[number]++;
  flights->steps[number] = 0;
  memcpy(flights->plans + number * plan_size, plan, plan_size * sizeof *plan);
  memset(flights->actions + number * action_size, 0, action_size * sizeof(float));
  memset(flights->previous_actions + number * action_size, 0, action_size * sizeof(float));
}

int cf_start_flights(const cf_flights_t *flights, const int32_t *numbers, int count,
                     cf_status_t *status) {
  const size_t ahead = (size_t)flights->ahead;
  *status            = CF_OK;
  for (int k = 0; k < count; k++) {
    const size_t  number  = (size_t)numbers[k];
    const size_t  episode = (size_t)flights->episodes[number] % ahead;
    const double *row = flights->starts + (number * ahead + episode) * (size_t)flights->start_size;
    cf_flight_start_t start;
    memcpy(&start, row, sizeof start);
    const double *rest    = row + sizeof start / sizeof *row;
    const cf_t   *pattern = flights->patterns[(size_t)rest[0]];
    *status               = cf_start_flight(flights->drones[number], pattern, &start);
    if (*status != CF_OK) {
      return k;
    }
    move_body(flights, number, &start);
    begin_episode(flights, number, rest + 1);
  }
  return count;
}
