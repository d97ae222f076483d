#include "vehicle/vehicle.h"

#include "variable_row.h"

static const float RAD_PER_RPM = 0.104719755f;  // [rad/s per rpm]

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

// Thrusts, their moments, reaction torques and the gyroscopic torque of the rotors.
static void rotor_wrench(const cf_rotors_t *rotors, const float w[3], float force[3],
                         float torque[3]) {
  const float *f = rotors->thrust;
  const float *n = rotors->rpm;

  // reaction against the spin: aerodynamic torque and spin-up, clockwise rotors positive
  float q[CF_ROTOR_COUNT];
  for (int i = 0; i < CF_ROTOR_COUNT; i++) {
    q[i] = rotors->torque[i] + rotors->spin_up[i];
  }

  // H = J_r (Omega_1 - Omega_2 + Omega_3 - Omega_4) along z; torque -w x H
  const float h = rotors->config.inertia * RAD_PER_RPM * ((n[0] + n[2]) - (n[1] + n[3]));

  force[0]  = 0.0f;
  force[1]  = 0.0f;
  force[2]  = (f[0] + f[1]) + (f[2] + f[3]);
  torque[0] = rotors->config.arm_y * ((f[2] + f[3]) - (f[0] + f[1])) - w[1] * h;
  torque[1] = rotors->config.arm_x * ((f[1] + f[2]) - (f[0] + f[3])) + w[0] * h;
  torque[2] = (q[1] + q[3]) - (q[0] + q[2]);
}

void cf_vehicle_wrench(const cf_vehicle_t *vehicle, const float rotation[9],
                       const float velocity_world[3], const float rates_body[3],
                       float force_world[3], float torque_body[3]) {
  const float *r                = rotation;
  const float *v                = velocity_world;
  const float  velocity_body[3] = {
      r[0] * v[0] + r[3] * v[1] + r[6] * v[2],
      r[1] * v[0] + r[4] * v[1] + r[7] * v[2],
      r[2] * v[0] + r[5] * v[1] + r[8] * v[2],
  };

  float f[3];
  rotor_wrench(&vehicle->rotors, rates_body, f, torque_body);
  cf_aerodynamics_add(&vehicle->aerodynamics, &vehicle->rotors, velocity_body, rates_body, f,
                      torque_body);

  force_world[0] = r[0] * f[0] + r[1] * f[1] + r[2] * f[2];
  force_world[1] = r[3] * f[0] + r[4] * f[1] + r[5] * f[2];
  force_world[2] = r[6] * f[0] + r[7] * f[1] + r[8] * f[2];
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
