#include "vehicle/vehicle.h"

#include <string.h>

#include "variable_row.h"
#include "vehicle/parameters.h"
#include "vehicle/positioning/mocap_quality.h"

#define WORLD_ID UINT64_MAX  // drones have ids of 32 bits
#define POSITIONING_DICE 4   // mocap, flow deck, lighthouse, loco

static const float TICK    = 0.001f;  // [s]
static const float GRAVITY = 9.81f;   // [m/s^2]

// ------------------------------------------------------------------------------------ positioning

// A room of 5 m by 5 m by 2.5 m around the origin: base stations in two opposite corners under the
// ceiling, anchors in all eight. It has been surveyed: anchors to 2 cm, their antenna delays to
// another 2 cm, base stations so that a deck knows its place to 1 cm. Neighbors in the order of the
// anchors are never straight above each other, so that TDoA2 sees all directions.
static void default_positioning(cf_vehicle_config_t *config) {
  config->positioning = CF_POSITIONING_MOCAP;
  cf_mocap_of_quality(&config->mocap, CF_MOCAP_GOOD);
  config->flow_deck.range_mishap = (cf_mishap_config_t){.outlier_size = 0.5f};
  config->flow_deck.flow_mishap  = (cf_mishap_config_t){.outlier_size = 60.0f};

  config->lighthouse = (cf_lighthouse_config_t){
      .stations       = {{.position = {-2.5f, -2.5f, 2.5f}, .target = {0.0f, 0.0f, 0.7f}},
                         {.position = {2.5f, 2.5f, 2.5f}, .target = {0.0f, 0.0f, 0.7f}}},
      .rate           = 50,
      .noise          = 0.0002f,
      .position_error = 0.003f,
      .attitude_error = 0.001f,
      .mishap         = {.dropout = 0.02f, .outlier = 0.0001f, .outlier_size = 0.2f},
  };
  config->loco = (cf_loco_config_t){
      .anchors   = {{-2.5f, -2.5f, 0.2f},
                    {-2.5f, 2.5f, 2.4f},
                    {2.5f, 2.5f, 0.2f},
                    {2.5f, -2.5f, 2.4f},
                    {-2.5f, -2.5f, 2.4f},
                    {-2.5f, 2.5f, 0.2f},
                    {2.5f, 2.5f, 2.4f},
                    {2.5f, -2.5f, 0.2f}},
      .twr_rate  = 125,
      .tdoa_rate = 500,
      .noise     = 0.07f,
      .bias      = 0.03f,
      .mishap    = {.dropout = 0.05f, .outlier = 0.01f, .outlier_size = 2.0f},
  };
}

static cf_loco_mode_t loco_mode(cf_positioning_t positioning) {
  switch (positioning) {
    case CF_POSITIONING_LOCO_TDOA2:
      return CF_LOCO_TDOA2;
    case CF_POSITIONING_LOCO_TDOA3:
      return CF_LOCO_TDOA3;
    default:
      return CF_LOCO_TWR;
  }
}

// Fits the system of the config; the configs of the others are checked all the same.
static cf_status_t fit(cf_vehicle_t *vehicle, const cf_vehicle_config_t *config,
                       const cf_random_t noise[POSITIONING_DICE], cf_random_t mishap,
                       cf_random_t world) {
  cf_mocap_t        mocap;
  cf_flow_deck_t    flow_deck;
  cf_lighthouse_t   lighthouse;
  cf_loco_t         loco;
  const cf_status_t results[] = {
      cf_mocap_init(&mocap, &config->mocap, noise[0], mishap),
      cf_flow_deck_init(&flow_deck, &config->flow_deck, noise[1], mishap),
      cf_lighthouse_init(&lighthouse, &config->lighthouse, noise[2], mishap, world),
      cf_loco_init(&loco, &config->loco, loco_mode(config->positioning), noise[3], mishap, world),
  };
  for (size_t i = 0; i < sizeof results / sizeof results[0]; i++) {
    if (results[i] != CF_OK) {
      return results[i];
    }
  }

  vehicle->positioning = config->positioning;
  switch (config->positioning) {
    case CF_POSITIONING_NONE:
      return CF_OK;
    case CF_POSITIONING_MOCAP:
    case CF_POSITIONING_MOCAP_POSITION:
      vehicle->mocap = mocap;
      return CF_OK;
    case CF_POSITIONING_FLOW:
      vehicle->flow_deck = flow_deck;
      return CF_OK;
    case CF_POSITIONING_LIGHTHOUSE:
      vehicle->lighthouse = lighthouse;
      return CF_OK;
    case CF_POSITIONING_LOCO_TWR:
    case CF_POSITIONING_LOCO_TDOA2:
    case CF_POSITIONING_LOCO_TDOA3:
      vehicle->loco = loco;
      return CF_OK;
    default:
      return CF_ERR_VALUE;
  }
}

// ---------------------------------------------------------------------------------------- vehicle

cf_status_t cf_vehicle_default_config(cf_vehicle_config_t *config, cf_platform_t platform) {
  const cf_platform_facts_t *facts = cf_platform_facts(platform);
  if (facts == NULL) {
    return CF_ERR_UNKNOWN;
  }

  *config = (cf_vehicle_config_t){
      .airframe  = {.rotors = {.curve = facts->thrust}},
      .flow_deck = {.range_noise_scale = 1.0f, .flow_noise = 1.0f},
  };
  cf_parameters_of_platform(config, platform);
  default_positioning(config);
  return CF_OK;
}

cf_status_t cf_vehicle_init(cf_vehicle_t *vehicle, const cf_vehicle_config_t *config, uint64_t seed,
                            uint64_t id) {
  const cf_airframe_t *airframe = &config->airframe;
  cf_vehicle_t         fresh    = {.mass = airframe->mass, .air_countdown = 1};
  for (int i = 0; i < 3; i++) {
    fresh.trim_per_thrust[i] = airframe->trim_torque[i] / (airframe->mass * GRAVITY);
  }

  // each sensor gets its own dice: switching one off leaves the others as they were
  cf_random_init(&fresh.random, seed, id);
  const cf_random_t imu_random = cf_random_split(&fresh.random);
  cf_random_t       positioning_random[POSITIONING_DICE];
  for (int i = 0; i < POSITIONING_DICE; i++) {
    positioning_random[i] = cf_random_split(&fresh.random);
  }
  const cf_random_t mishap_random = cf_random_split(&fresh.random);
  cf_random_t       world_random;
  cf_random_init(&world_random, seed, WORLD_ID);
  const cf_random_t baro_random = cf_random_split(&fresh.random);
  const cf_random_t wind_random = cf_random_split(&fresh.random);

  const cf_status_t results[] = {
      cf_airframe_check(airframe),
      cf_rotors_init(&fresh.rotors, &airframe->rotors),
      cf_battery_init(&fresh.battery, &airframe->battery),
      cf_aerodynamics_init(&fresh.aerodynamics, &airframe->aerodynamics, &airframe->rotors),
      cf_ground_effect_init(&fresh.ground_effect, &airframe->ground_effect, &airframe->rotors),
      cf_wind_init(&fresh.wind, &airframe->wind, wind_random),
      cf_imu_init(&fresh.imu, &airframe->imu, imu_random),
      fit(&fresh, config, positioning_random, mishap_random, world_random),
      cf_barometer_init(&fresh.barometer, &config->barometer, baro_random),
  };
  for (size_t i = 0; i < sizeof results / sizeof results[0]; i++) {
    if (results[i] != CF_OK) {
      return results[i];
    }
  }
  cf_rangers_config_t rangers = config->rangers;
  rangers.has_zranger         = rangers.has_zranger && config->positioning != CF_POSITIONING_FLOW;
  cf_rangers_init(&fresh.rangers, &rangers, config->flow_deck.range_noise_scale,
                  &config->flow_deck.range_mishap, seed, id);
  *vehicle = fresh;
  return CF_OK;
}

void cf_vehicle_feel_air(cf_vehicle_t *vehicle, const float position[3], const float rotation[9],
                         const float velocity_world[3]) {
  if (--vehicle->air_countdown > 0) {
    return;
  }
  vehicle->air_countdown = CF_AIR_TICKS;
  const float height     = position[2] - vehicle->surface;
  if (vehicle->ground_effect.config.is_enabled) {
    cf_ground_effect_update(&vehicle->ground_effect, &vehicle->rotors.config, height, rotation);
  }
  cf_wind_update(&vehicle->wind, (float)CF_AIR_TICKS * TICK, height, velocity_world);
}

cf_status_t cf_vehicle_gust(cf_vehicle_t *vehicle, const float peak[3], float duration) {
  return cf_wind_gust(&vehicle->wind, peak, duration);
}

void cf_vehicle_actuate(cf_vehicle_t *vehicle, const uint16_t ratios[CF_ROTOR_COUNT]) {
  cf_rotors_step(&vehicle->rotors, ratios, vehicle->battery.voltage);
  cf_battery_step(&vehicle->battery, cf_rotors_total_thrust(&vehicle->rotors));
}

void cf_vehicle_imu(cf_vehicle_t *vehicle, const float rates_body[3], const float specific_force[3],
                    Axis3i16 *gyro_raw, Axis3i16 *acc_raw) {
  const cf_rotors_t *rotors    = &vehicle->rotors;
  const float        vibration = rotors->vibration;
  if (!vehicle->imu.lines.is_on) {
    cf_imu_sample(&vehicle->imu, rates_body, specific_force, vibration, gyro_raw, acc_raw);
    return;
  }
  float rates[3], force[3];
  memcpy(rates, rates_body, sizeof rates);
  memcpy(force, specific_force, sizeof force);
  cf_rotor_vibration_add(&vehicle->imu.lines, rotors->rpm, rotors->config.hover_rpm, rates, force);
  cf_imu_sample(&vehicle->imu, rates, force, vibration, gyro_raw, acc_raw);
}

bool cf_vehicle_mocap(cf_vehicle_t *vehicle, const float position[3], const float quat_wxyz[4],
                      poseMeasurement_t *pose) {
  const cf_positioning_t fitted = vehicle->positioning;
  return (fitted == CF_POSITIONING_MOCAP || fitted == CF_POSITIONING_MOCAP_POSITION) &&
         cf_mocap_step(&vehicle->mocap, position, quat_wxyz, pose);
}

int cf_vehicle_flow_deck(cf_vehicle_t *vehicle, float height, const float rotation[9],
                         const float velocity_world[3], const float rates_body[3],
                         cf_flow_reading_t *reading) {
  if (vehicle->positioning != CF_POSITIONING_FLOW) {
    return 0;
  }
  return cf_flow_deck_step(&vehicle->flow_deck, height, rotation, velocity_world, rates_body,
                           reading);
}

int cf_vehicle_lighthouse(cf_vehicle_t *vehicle, const float position[3], const float rotation[9],
                          cf_sweep_t sweeps[CF_LIGHTHOUSE_STATIONS]) {
  if (vehicle->positioning != CF_POSITIONING_LIGHTHOUSE) {
    return 0;
  }
  return cf_lighthouse_step(&vehicle->lighthouse, position, rotation, sweeps);
}

bool cf_vehicle_loco(cf_vehicle_t *vehicle, const float position[3], cf_ranging_t *ranging) {
  const cf_positioning_t fitted = vehicle->positioning;
  return fitted >= CF_POSITIONING_LOCO_TWR && fitted <= CF_POSITIONING_LOCO_TDOA3 &&
         cf_loco_step(&vehicle->loco, position, ranging);
}

bool cf_vehicle_barometer(cf_vehicle_t *vehicle, float height, float *pressure,
                          float *temperature) {
  return cf_barometer_step(&vehicle->barometer, height, vehicle->surface, vehicle->rotors.vibration,
                           pressure, temperature);
}

static bool *loss_of(cf_vehicle_t *vehicle) {
  switch (vehicle->positioning) {
    case CF_POSITIONING_MOCAP:
    case CF_POSITIONING_MOCAP_POSITION:
      return &vehicle->mocap.is_lost;
    case CF_POSITIONING_FLOW:
      return &vehicle->flow_deck.is_lost;
    case CF_POSITIONING_LIGHTHOUSE:
      return &vehicle->lighthouse.is_lost;
    case CF_POSITIONING_LOCO_TWR:
    case CF_POSITIONING_LOCO_TDOA2:
    case CF_POSITIONING_LOCO_TDOA3:
      return &vehicle->loco.is_lost;
    default:
      return NULL;
  }
}

cf_status_t cf_vehicle_lose_positioning(cf_vehicle_t *vehicle, bool is_lost) {
  bool *loss = loss_of(vehicle);
  if (loss == NULL) {
    return CF_ERR_STATE;
  }
  *loss = is_lost;
  return CF_OK;
}

static bool has_mocap(const cf_vehicle_t *vehicle) {
  return vehicle->positioning == CF_POSITIONING_MOCAP ||
         vehicle->positioning == CF_POSITIONING_MOCAP_POSITION;
}

cf_status_t cf_vehicle_delay_positioning(cf_vehicle_t *vehicle, uint32_t latency_ms) {
  return has_mocap(vehicle) ? cf_mocap_set_latency(&vehicle->mocap, latency_ms) : CF_ERR_STATE;
}

cf_status_t cf_vehicle_drop_poses(cf_vehicle_t *vehicle, float share) {
  if (!has_mocap(vehicle)) {
    return CF_ERR_STATE;
  }
  cf_mishap_config_t mishap = vehicle->mocap.config.mishap;
  mishap.dropout            = share;
  const cf_status_t status  = cf_mishap_check(&mishap);
  if (status == CF_OK) {
    vehicle->mocap.config.mishap = mishap;
  }
  return status;
}

bool cf_vehicle_is_out_of_sight(const cf_vehicle_t *vehicle) {
  return has_mocap(vehicle) && vehicle->mocap.is_lost;
}

static const cf_variable_t LOGS[] = {
    CF_ROW("sim", "rpm1", FLOAT, 0, cf_vehicle_t, rotors.rpm[0]),
    CF_ROW("sim", "rpm2", FLOAT, 0, cf_vehicle_t, rotors.rpm[1]),
    CF_ROW("sim", "rpm3", FLOAT, 0, cf_vehicle_t, rotors.rpm[2]),
    CF_ROW("sim", "rpm4", FLOAT, 0, cf_vehicle_t, rotors.rpm[3]),
    CF_ROW("sim", "thrust1", FLOAT, 0, cf_vehicle_t, rotors.thrust[0]),
    CF_ROW("sim", "thrust2", FLOAT, 0, cf_vehicle_t, rotors.thrust[1]),
    CF_ROW("sim", "thrust3", FLOAT, 0, cf_vehicle_t, rotors.thrust[2]),
    CF_ROW("sim", "thrust4", FLOAT, 0, cf_vehicle_t, rotors.thrust[3]),
    CF_ROW("sim", "windX", FLOAT, 0, cf_vehicle_t, wind.velocity[0]),
    CF_ROW("sim", "windY", FLOAT, 0, cf_vehicle_t, wind.velocity[1]),
    CF_ROW("sim", "windZ", FLOAT, 0, cf_vehicle_t, wind.velocity[2]),
    CF_ROW("sim", "downwash", FLOAT, 0, cf_vehicle_t, downwash),
    CF_ROW("sim", "groundGain", FLOAT, 0, cf_vehicle_t, ground_effect.gain[0]),
    CF_ROW("sim", "current", FLOAT, 0, cf_vehicle_t, battery.current),
    CF_ROW("sim", "charge", FLOAT, 0, cf_vehicle_t, battery.charge),
};

cf_variables_t cf_vehicle_logs(void) {
  return (cf_variables_t){.rows = LOGS, .count = (int)(sizeof LOGS / sizeof LOGS[0])};
}
