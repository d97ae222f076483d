#include "onboard/decks/lighthouse_deck.h"

#include "onboard/decks/lighthouse_geometry.h"
#include "variable_row.h"

#define SWEEP_STD 0.001f    // [rad], second generation
#define POSITION_STD 0.01f  // [m], of crossed beams
#define YAW_STD 0.01f       // [rad]
#define LONGEST_TURN 12u    // [ms], between the planes of a turn: a third of it
#define LONGEST_AGE 50u     // [ms], of a turn that is crossed with another
#define ALL_SENSORS 0xfu    // of CF_LIGHTHOUSE_SENSORS
#define MIN_SLANT 1e-3f     // sine of the angle between a ray and the plane of the deck

// the firmware's are not established; these are what cflib asks for
#define MATCHED_STATIONS 2
#define MATCHED_TIME 25  // [ms]

void cf_lighthouse_deck_init(cf_lighthouse_deck_t *deck) {
  *deck = (cf_lighthouse_deck_t){
      .method      = CF_LIGHTHOUSE_RAW_SWEEPS,
      .system_type = 2,
      .available   = (1u << CF_LIGHTHOUSE_STATIONS) - 1u,

      .matched_stations = MATCHED_STATIONS,
      .matched_time     = MATCHED_TIME,
  };
}

// Where the estimate has the deck.
typedef struct {
  float position[3];     // [m], world
  float rotation[3][3];  // body to world
  float normal[3];       // of the deck, world
} deck_pose_t;

static deck_pose_t pose_of(const cf_estimator_t *estimator) {
  state_t state;
  cf_estimator_get(estimator, &state);
  const quaternion_t *q    = &state.attitudeQuaternion;
  deck_pose_t         pose = {
      .position = {state.position.x, state.position.y, state.position.z},
      .rotation =
          {
              {1.0f - 2.0f * (q->y * q->y + q->z * q->z), 2.0f * (q->x * q->y - q->w * q->z),
               2.0f * (q->x * q->z + q->w * q->y)},
              {2.0f * (q->x * q->y + q->w * q->z), 1.0f - 2.0f * (q->x * q->x + q->z * q->z),
               2.0f * (q->y * q->z - q->w * q->x)},
              {2.0f * (q->x * q->z - q->w * q->y), 2.0f * (q->y * q->z + q->w * q->x),
               1.0f - 2.0f * (q->x * q->x + q->y * q->y)},
          },
  };
  for (int i = 0; i < 3; i++) {
    pose.normal[i] = pose.rotation[i][2];
  }
  return pose;
}

// Arm of a sensor in the world.
static void arm_of(const deck_pose_t *pose, int sensor, float arm[3]) {
  const float *s = *cf_lighthouse_sensor_position(sensor);
  for (int i = 0; i < 3; i++) {
    arm[i] = cf_dot3(pose->rotation[i], s);
  }
}

// ------------------------------------------------------------------------------------- yaw error

// Where the light of a sensor meets the plane of the deck; false when it grazes it.
static bool meet_deck(const cf_station_data_t *station, const deck_pose_t *pose,
                      const float angles[CF_LIGHTHOUSE_SWEEPS], float point[3]) {
  float ray[3];
  cf_lighthouse_ray(station, angles, ray);
  const float slant = cf_dot3(pose->normal, ray);
  if (!(slant * slant > MIN_SLANT * MIN_SLANT * cf_dot3(ray, ray))) {
    return false;
  }
  float to_deck[3];
  for (int i = 0; i < 3; i++) {
    to_deck[i] = pose->position[i] - station->origin[i];
  }
  const float way = cf_dot3(pose->normal, to_deck) / slant;
  for (int i = 0; i < 3; i++) {
    point[i] = station->origin[i] + way * ray[i];
  }
  return true;
}

// Angle of one diagonal of the deck, estimated minus seen.
static bool diagonal_delta(const cf_station_data_t *station, const deck_pose_t *pose,
                           const cf_rotor_turn_t *turn, int from, int to, float *delta) {
  float start[3], end[3];
  if (!meet_deck(station, pose, turn->angles[from], start) ||
      !meet_deck(station, pose, turn->angles[to], end)) {
    return false;
  }
  float arm_from[3], arm_to[3], ipv[3], spv[3];
  arm_of(pose, from, arm_from);
  arm_of(pose, to, arm_to);
  for (int i = 0; i < 3; i++) {
    ipv[i] = end[i] - start[i];
    spv[i] = arm_to[i] - arm_from[i];
  }
  return cf_lighthouse_yaw_delta(pose->normal, ipv, spv, delta);
}

static void enqueue_yaw_error(cf_lighthouse_deck_t *deck, cf_estimator_t *estimator,
                              const deck_pose_t *pose, int station_id, uint32_t tick) {
  const cf_station_data_t *station = &estimator->stations.list[station_id];
  const cf_rotor_turn_t   *turn    = &deck->turns[station_id];
  if ((turn->sensors[0] & turn->sensors[1]) != ALL_SENSORS || deck->yaw_tick == tick) {
    return;
  }
  float first, second;
  if (!diagonal_delta(station, pose, turn, 0, 3, &first) ||
      !diagonal_delta(station, pose, turn, 1, 2, &second)) {
    return;
  }
  const measurement_t measurement = {
      .type          = MeasurementTypeYawError,
      .data.yawError = {.timestamp = tick, .yawError = 0.5f * (first + second), .stdDev = YAW_STD},
  };
  cf_estimator_enqueue(estimator, &measurement);
  deck->yaw_tick = tick;
}

// --------------------------------------------------------------------------------- crossing beams

// Both planes have passed, the second one after the first; a newer first plane makes it incomplete.
static bool is_whole(const cf_rotor_turn_t *turn, uint32_t tick) {
  return turn->ticks[1] - turn->ticks[0] <= LONGEST_TURN && tick - turn->ticks[0] <= LONGEST_AGE;
}

// Where one sensor puts the middle of the deck; false when it was not seen from both sides.
static bool cross_beams(const cf_rotor_turn_t turns[2], const cf_station_data_t stations[2],
                        const deck_pose_t *pose, int sensor, float middle[3]) {
  const int both =
      turns[0].sensors[0] & turns[0].sensors[1] & turns[1].sensors[0] & turns[1].sensors[1];
  if ((both & (1 << sensor)) == 0) {
    return false;
  }
  float rays[2][3], arm[3];
  cf_lighthouse_ray(&stations[0], turns[0].angles[sensor], rays[0]);
  cf_lighthouse_ray(&stations[1], turns[1].angles[sensor], rays[1]);
  if (!cf_lighthouse_cross(stations[0].origin, rays[0], stations[1].origin, rays[1], middle)) {
    return false;
  }
  arm_of(pose, sensor, arm);
  for (int i = 0; i < 3; i++) {
    middle[i] -= arm[i];
  }
  return true;
}

static void enqueue_crossing(const cf_lighthouse_deck_t *deck, cf_estimator_t *estimator,
                             const deck_pose_t *pose, uint32_t tick) {
  if (!is_whole(&deck->turns[0], tick) || !is_whole(&deck->turns[1], tick)) {
    return;
  }
  float found[3][CF_LIGHTHOUSE_SENSORS];
  int   count = 0;
  for (int i = 0; i < CF_LIGHTHOUSE_SENSORS; i++) {
    float middle[3];
    if (cross_beams(deck->turns, estimator->stations.list, pose, i, middle)) {
      for (int k = 0; k < 3; k++) {
        found[k][count] = middle[k];
      }
      count++;
    }
  }
  if (count == 0) {
    return;
  }

  // a reflection moves one sensor, not the median
  const measurement_t measurement = {
      .type          = MeasurementTypePosition,
      .data.position = {.pos    = {cf_median(found[0], count), cf_median(found[1], count),
                                   cf_median(found[2], count)},
                        .stdDev = POSITION_STD,
                        .source = MeasurementSourceLighthouse},
  };
  cf_estimator_enqueue(estimator, &measurement);
}

// ---------------------------------------------------------------------------------------- sweeps

static void remember(cf_lighthouse_deck_t *deck, const cf_sweep_t *sweep, uint32_t tick) {
  cf_rotor_turn_t *turn       = &deck->turns[sweep->station];
  turn->ticks[sweep->sweep]   = tick;
  turn->sensors[sweep->sweep] = sweep->sensors;
  for (int i = 0; i < CF_LIGHTHOUSE_SENSORS; i++) {
    turn->angles[i][sweep->sweep] = sweep->angles[i];
  }
}

static void enqueue_angle(cf_estimator_t *estimator, int station, int sensor, int sweep,
                          float angle, uint32_t tick) {
  const measurement_t measurement = {
      .type            = MeasurementTypeSweepAngle,
      .data.sweepAngle = {.timestamp          = tick,
                          .sensorId           = (uint8_t)sensor,
                          .baseStationId      = (uint8_t)station,
                          .sweepId            = (uint8_t)sweep,
                          .t                  = cf_lighthouse_tilt(sweep),
                          .measuredSweepAngle = angle,
                          .stdDev             = SWEEP_STD},
  };
  cf_estimator_enqueue(estimator, &measurement);
}

// A sensor at a time, both planes together.
static void enqueue_turn(const cf_rotor_turn_t *turn, cf_estimator_t *estimator, int station,
                         uint32_t tick) {
  const int both = turn->sensors[0] & turn->sensors[1];
  for (int i = 0; i < CF_LIGHTHOUSE_SENSORS; i++) {
    for (int sweep = 0; sweep < CF_LIGHTHOUSE_SWEEPS && (both & (1 << i)) != 0; sweep++) {
      enqueue_angle(estimator, station, i, sweep, turn->angles[i][sweep], tick);
    }
  }
}

static bool is_usable(const cf_station_data_t *station) {
  return station->has_geometry && station->calibration.valid;
}

void cf_lighthouse_deck_sweep(cf_lighthouse_deck_t *deck, cf_estimator_t *estimator,
                              const cf_sweep_t *sweep, uint32_t tick) {
  deck->seen |= (uint16_t)(1u << sweep->station);
  if (!is_usable(&estimator->stations.list[sweep->station])) {
    return;
  }
  remember(deck, sweep, tick);

  // the second plane completes a turn
  if (sweep->sweep == 1 && is_whole(&deck->turns[sweep->station], tick)) {
    const deck_pose_t pose = pose_of(estimator);
    if (deck->method == CF_LIGHTHOUSE_CROSSING_BEAMS) {
      enqueue_crossing(deck, estimator, &pose, tick);
    } else {
      enqueue_turn(&deck->turns[sweep->station], estimator, sweep->station, tick);
    }
    enqueue_yaw_error(deck, estimator, &pose, sweep->station, tick);
  }
}

// ------------------------------------------------------------------------------------- variables

void cf_lighthouse_deck_count(cf_lighthouse_deck_t *deck, const cf_base_stations_t *stations) {
  uint16_t geometries = 0, calibrations = 0;
  for (uint32_t i = 0; i < CF_LIGHTHOUSE_STATIONS; i++) {
    const uint32_t bit = 1u << i;
    geometries         = (uint16_t)(geometries | (stations->list[i].has_geometry ? bit : 0u));
    calibrations = (uint16_t)(calibrations | (stations->list[i].calibration.valid ? bit : 0u));
  }
  deck->geometries_valid       = geometries;
  deck->calibrations_valid     = calibrations;
  deck->received               = deck->seen;
  deck->calibrations_confirmed = deck->received & calibrations;
  deck->active                 = deck->received & geometries & calibrations;
  deck->status                 = deck->received == 0 ? 0 : (deck->active == 0 ? 1 : 2);
  deck->seen                   = 0;
}

static const cf_variable_t PARAMETERS[] = {
    CF_ROW("lighthouse", "method", UINT8, 0, cf_lighthouse_deck_t, method),
    CF_ROW("lighthouse", "systemType", UINT8, CF_PERSISTENT, cf_lighthouse_deck_t, system_type),
    CF_ROW("lighthouse", "bsCalibReset", UINT8, 0, cf_lighthouse_deck_t, calib_reset),
};

#define LOG(name_, type_, member_) \
  CF_ROW("lighthouse", name_, type_, 0, cf_lighthouse_deck_t, member_)

static const cf_variable_t LOGS[] = {
    LOG("bsAvailable", UINT16, available),
    LOG("bsReceive", UINT16, received),
    LOG("bsActive", UINT16, active),
    LOG("bsCalVal", UINT16, calibrations_valid),
    LOG("bsCalCon", UINT16, calibrations_confirmed),
    LOG("bsCalUd", UINT16, calibrations_updated),
    LOG("bsGeoVal", UINT16, geometries_valid),
    LOG("status", UINT8, status),
};

cf_variables_t cf_lighthouse_deck_parameters(void) {
  return CF_TABLE(PARAMETERS);
}

cf_variables_t cf_lighthouse_deck_logs(void) {
  return CF_TABLE(LOGS);
}
