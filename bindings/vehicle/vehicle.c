#include "vehicle/vehicle.h"

#include "variable_row.h"

cf_status_t cf_vehicle_default_config(cf_vehicle_config_t *config, cf_platform_t platform) {
  cf_airframe_t     airframe;
  const cf_status_t status = cf_airframe(&airframe, platform);
  if (status != CF_OK) {
    return status;
  }

  *config = (cf_vehicle_config_t){
      .airframe  = airframe,
      .mocap     = {.rate           = 100,
                    .latency_ms     = 8,
                    .position_noise = 0.001f,
                    .attitude_noise = 0.002f,
                    .position_std   = 0.01f,
                    .attitude_std   = 4.5e-3f},
      .flow_deck = {.range_noise_scale = 1.0f, .flow_noise = 1.0f, .flow_std = 2.0f},
  };
  return CF_OK;
}

cf_status_t cf_vehicle_init(cf_vehicle_t *vehicle, const cf_vehicle_config_t *config, uint64_t seed,
                            uint64_t id) {
  const cf_airframe_t *airframe = &config->airframe;
  cf_vehicle_t         fresh    = {.mass = airframe->mass};

  // each sensor gets its own dice: switching one off leaves the others as they were
  cf_random_init(&fresh.random, seed, id);
  const cf_random_t imu_random   = cf_random_split(&fresh.random);
  const cf_random_t mocap_random = cf_random_split(&fresh.random);
  const cf_random_t flow_random  = cf_random_split(&fresh.random);

  const cf_status_t results[] = {
      cf_airframe_check(airframe),
      cf_rotors_init(&fresh.rotors, &airframe->rotors),
      cf_battery_init(&fresh.battery, &airframe->battery),
      cf_aerodynamics_init(&fresh.aerodynamics, &airframe->aerodynamics, &airframe->rotors),
      cf_imu_init(&fresh.imu, &airframe->imu, imu_random),
      cf_mocap_init(&fresh.mocap, &config->mocap, mocap_random),
      cf_flow_deck_init(&fresh.flow_deck, &config->flow_deck, flow_random),
  };
  for (size_t i = 0; i < sizeof results / sizeof results[0]; i++) {
    if (results[i] != CF_OK) {
      return results[i];
    }
  }
  *vehicle = fresh;
  return CF_OK;
}

void cf_vehicle_actuate(cf_vehicle_t *vehicle, const uint16_t ratios[CF_ROTOR_COUNT]) {
  cf_rotors_step(&vehicle->rotors, ratios, vehicle->battery.voltage);
  cf_battery_step(&vehicle->battery, cf_rotors_total_thrust(&vehicle->rotors));
}

void cf_vehicle_imu(cf_vehicle_t *vehicle, const float rates_body[3], const float specific_force[3],
                    Axis3i16 *gyro_raw, Axis3i16 *acc_raw) {
  cf_imu_sample(&vehicle->imu, rates_body, specific_force, vehicle->rotors.vibration, gyro_raw,
                acc_raw);
}

bool cf_vehicle_mocap(cf_vehicle_t *vehicle, const float position[3], const float quat_wxyz[4],
                      poseMeasurement_t *pose) {
  return cf_mocap_step(&vehicle->mocap, position, quat_wxyz, pose);
}

int cf_vehicle_flow_deck(cf_vehicle_t *vehicle, uint32_t tick, float height,
                         const float rotation[9], const float velocity_world[3],
                         const float rates_body[3], tofMeasurement_t *range,
                         flowMeasurement_t *flow) {
  return cf_flow_deck_step(&vehicle->flow_deck, tick, height, rotation, velocity_world, rates_body,
                           range, flow);
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
    CF_ROW("sim", "current", FLOAT, 0, cf_vehicle_t, battery.current),
    CF_ROW("sim", "charge", FLOAT, 0, cf_vehicle_t, battery.charge),
};

cf_variables_t cf_vehicle_logs(void) {
  return (cf_variables_t){.rows = LOGS, .count = (int)(sizeof LOGS / sizeof LOGS[0])};
}
