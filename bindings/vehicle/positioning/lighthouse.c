#include "vehicle/positioning/lighthouse.h"

#include <math.h>
#include <string.h>

#include "vehicle/random_inline.h"
#include "vehicle/valid.h"

#define HIGHEST_RATE 100u    // [Hz]
#define TICK_US 1000u        // [us]
#define CHANNEL_STEP_US 42u  // [us], between the periods of two channels
#define SENSORS CF_LIGHTHOUSE_SENSORS

static const float FARTHEST_STATION = 1000.0f;       // [m]
static const float MIN_TARGET       = 0.01f;         // [m]
static const float LONGEST_RANGE    = 7.0f;          // [m]
static const float LARGEST_AZIMUTH  = 1.308996939f;  // [rad], 75 deg
static const float LARGEST_SLOPE    = 1.428148007f;  // tan(55 deg)
static const float MIN_INCIDENCE    = 0.0871557f;    // sin(5 deg)

// ----------------------------------------------------------------------------------------- start

static bool is_valid_pose(const cf_station_pose_t *pose) {
  float distance = 0.0f;
  for (int i = 0; i < 3; i++) {
    if (!cf_is_within(pose->position[i], -FARTHEST_STATION, FARTHEST_STATION) ||
        !cf_is_within(pose->target[i], -FARTHEST_STATION, FARTHEST_STATION)) {
      return false;
    }
    distance += fabsf(pose->target[i] - pose->position[i]);
  }
  return distance >= MIN_TARGET;
}

static bool is_valid(const cf_lighthouse_config_t *config) {
  return is_valid_pose(&config->stations[0]) && is_valid_pose(&config->stations[1]) &&
         config->rate <= HIGHEST_RATE && cf_is_within(config->noise, 0.0f, 1.0f) &&
         cf_is_within(config->calibration_error, 0.0f, 0.1f) &&
         cf_is_within(config->position_error, 0.0f, 10.0f) &&
         cf_is_within(config->attitude_error, 0.0f, 1.0f) &&
         cf_mishap_check(&config->mishap) == CF_OK;
}

// columns of R <- R exp(turn), for a small turn [rad] about the station's axes
static void turn_slightly(mat3d rotation, const float turn[3]) {
  const float angle = sqrtf(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2]);
  if (!(angle > 0.0f)) {
    return;
  }
  // Rodrigues: v cos a + (k x v) sin a + k (k v) (1 - cos a), here for the rows of R with -a
  const float k[3] = {turn[0] / angle, turn[1] / angle, turn[2] / angle};
  const float c    = cosf(angle);
  const float s    = -sinf(angle);
  for (int i = 0; i < 3; i++) {
    const float v[3]  = {rotation[i][0], rotation[i][1], rotation[i][2]};
    const float along = (k[0] * v[0] + k[1] * v[1] + k[2] * v[2]) * (1.0f - c);
    rotation[i][0]    = v[0] * c + (k[1] * v[2] - k[2] * v[1]) * s + k[0] * along;
    rotation[i][1]    = v[1] * c + (k[2] * v[0] - k[0] * v[2]) * s + k[1] * along;
    rotation[i][2]    = v[2] * c + (k[0] * v[1] - k[1] * v[0]) * s + k[2] * along;
  }
}

static void place(cf_base_station_t *station, const cf_lighthouse_config_t *config, uint32_t number,
                  cf_random_t *world) {
  float normal[10];
  cf_next_normals(world, normal, 10);

  const cf_station_pose_t *pose = &config->stations[number];
  cf_lighthouse_look_at(pose->position, pose->target, station->rotation);
  float turn[3];
  for (int i = 0; i < 3; i++) {
    station->position[i] = pose->position[i] + config->position_error * normal[i];
    turn[i]              = config->attitude_error * normal[3 + i];
  }
  turn_slightly(station->rotation, turn);
  for (int i = 0; i < CF_LIGHTHOUSE_SWEEPS; i++) {
    station->phase[i] = config->calibration_error * normal[6 + i];
    station->tilt[i]  = cf_lighthouse_tilt(i) + config->calibration_error * normal[8 + i];
  }
  if (config->rate > 0) {
    station->period_us = 1000000u / config->rate + CHANNEL_STEP_US * number;
    station->turned_us = number * (station->period_us / 6u);
  }
}

cf_status_t cf_lighthouse_init(cf_lighthouse_t *lighthouse, const cf_lighthouse_config_t *config,
                               cf_random_t random, cf_random_t mishap_random, cf_random_t world) {
  if (!is_valid(config)) {
    return CF_ERR_VALUE;
  }
  *lighthouse = (cf_lighthouse_t){
      .config        = *config,
      .random        = random,
      .mishap_random = mishap_random,
  };
  for (uint32_t i = 0; i < CF_LIGHTHOUSE_STATIONS; i++) {
    place(&lighthouse->stations[i], config, i, &world);
  }
  return CF_OK;
}

// ---------------------------------------------------------------------------------------- sweeps

float cf_sweep_angle(float x, float y, float z, float tilt) {
  return atan2f(y, x) + asinf(z * tanf(tilt) / sqrtf(x * x + y * y));
}

// Advances the rotor by a tick; returns which of its planes passes straight ahead, or -1.
static int turn_rotor(cf_base_station_t *station) {
  if (station->period_us == 0) {
    return -1;
  }
  const uint32_t third  = station->period_us / 3u;
  const uint32_t before = station->turned_us;
  station->turned_us += TICK_US;
  if (station->turned_us >= station->period_us) {
    station->turned_us -= station->period_us;
    return 0;
  }
  return before < third && station->turned_us >= third ? 1 : -1;
}

// From the sensor to the frame of the station; false when no light can fall on it.
static bool is_lit(const cf_base_station_t *station, const float sensor[3], const float up[3],
                   float seen[3]) {
  const float d[3] = {
      sensor[0] - station->position[0],
      sensor[1] - station->position[1],
      sensor[2] - station->position[2],
  };
  for (int i = 0; i < 3; i++) {
    seen[i] = station->rotation[0][i] * d[0] + station->rotation[1][i] * d[1] +
              station->rotation[2][i] * d[2];
  }
  const float range = sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  const float level = sqrtf(seen[0] * seen[0] + seen[1] * seen[1]);
  const float glare = -(up[0] * d[0] + up[1] * d[1] + up[2] * d[2]);
  // written so that NaN is dark
  return range <= LONGEST_RANGE && level > 0.0f &&
         fabsf(atan2f(seen[1], seen[0])) <= LARGEST_AZIMUTH &&
         fabsf(seen[2]) <= LARGEST_SLOPE * level && glare >= MIN_INCIDENCE * range;
}

static void sweep_sensors(cf_lighthouse_t *lighthouse, const cf_base_station_t *station,
                          const float p[3], const float r[9], cf_sweep_t *sweep) {
  const cf_mishap_config_t *mishap = &lighthouse->config.mishap;
  const float               up[3]  = {r[2], r[5], r[8]};
  float                     normal[SENSORS];
  // drawn even when nothing is seen, so that a shadow does not change the noise after it
  cf_next_normals(&lighthouse->random, normal, SENSORS);

  for (int i = 0; i < SENSORS; i++) {
    const float *s         = *cf_lighthouse_sensor_position(i);
    const float  sensor[3] = {
        p[0] + r[0] * s[0] + r[1] * s[1] + r[2] * s[2],
        p[1] + r[3] * s[0] + r[4] * s[1] + r[5] * s[2],
        p[2] + r[6] * s[0] + r[7] * s[1] + r[8] * s[2],
    };
    float      seen[3];
    const bool is_hit = is_lit(station, sensor, up, seen) && !lighthouse->is_lost &&
                        !cf_mishap_drops(mishap, &lighthouse->mishap_random);
    if (!is_hit) {
      continue;
    }
    const float angle = cf_sweep_angle(seen[0], seen[1], seen[2], station->tilt[sweep->sweep]);
    sweep->angles[i] = angle + station->phase[sweep->sweep] + lighthouse->config.noise * normal[i] +
                       cf_mishap_error(mishap, &lighthouse->mishap_random);
    sweep->sensors |= (uint8_t)(1u << i);
  }
}

int cf_lighthouse_step(cf_lighthouse_t *lighthouse, const float position[3],
                       const float rotation[9], cf_sweep_t sweeps[CF_LIGHTHOUSE_STATIONS]) {
  int count = 0;
  for (int i = 0; i < CF_LIGHTHOUSE_STATIONS; i++) {
    cf_base_station_t *station = &lighthouse->stations[i];
    const int          plane   = turn_rotor(station);
    if (plane < 0) {
      continue;
    }
    cf_sweep_t *sweep = &sweeps[count];
    *sweep            = (cf_sweep_t){.station = (uint8_t)i, .sweep = (uint8_t)plane};
    sweep_sensors(lighthouse, station, position, rotation, sweep);
    count += sweep->sensors != 0 ? 1 : 0;
  }
  return count;
}
