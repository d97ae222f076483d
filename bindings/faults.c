#include "faults.h"

#include <math.h>
#include <string.h>

#include "crazyflie.h"
#include "vehicle/valid.h"

static const float TICK               = 0.001f;  // [s]
static const float LARGEST_RESISTANCE = 10.0f;   // [Ohm]

cf_status_t cf_inject_motor(cf_t *cf, int motor, float share) {
  if (motor < 0 || motor >= CF_ROTOR_COUNT) {
    return CF_ERR_CAPACITY;
  }
  const float well = cf->config.vehicle.airframe.rotors.efficiency[motor];
  return cf_rotors_set_efficiency(&cf->vehicle.rotors, motor, well * share);
}

// ------------------------------------------------------------------------------------------- IMU

static void note_what_is_wrong(cf_injected_faults_t *faults) {
  bool is_wrong = faults->is_battery_cut || faults->stuck_axes != 0;
  for (int i = 0; i < CF_IMU_AXES; i++) {
    is_wrong = is_wrong || faults->imu_bias[i] != 0.0f || faults->imu_noise[i] > 0.0f;
  }
  faults->is_sensing_wrong = is_wrong;
}

cf_status_t cf_inject_imu(cf_t *cf, const cf_imu_fault_t *fault, uint64_t seed) {
  if (fault->axes > (CF_IMU_GYRO_AXES | CF_IMU_ACC_AXES) || !cf_is_not_negative(fault->noise) ||
      !cf_is_within(fault->bias, -CF_ANY_SIZE, CF_ANY_SIZE)) {
    return CF_ERR_VALUE;
  }
  cf_injected_faults_t *faults = &cf->injected;
  for (int i = 0; i < CF_IMU_AXES; i++) {
    if ((fault->axes & (1u << i)) != 0) {
      const float steps    = cf_imu_steps(i);
      faults->imu_bias[i]  = steps * fault->bias;
      faults->imu_noise[i] = steps * fault->noise;
    }
  }
  const uint8_t others = (uint8_t)~fault->axes;
  faults->stuck_axes   = (faults->stuck_axes & others) | (fault->is_stuck ? fault->axes : 0);
  faults->held_axes &= others;
  cf_random_init(&faults->random, seed, cf->config.id);
  note_what_is_wrong(faults);
  return CF_OK;
}

static int16_t within_range(float steps) {
  return (int16_t)rintf(fminf(fmaxf(steps, -32768.0f), 32767.0f));
}

void cf_injected_spoil_imu(cf_injected_faults_t *faults, Axis3i16 *gyro, Axis3i16 *acc) {
  int16_t *readings[CF_IMU_AXES] = {&gyro->x, &gyro->y, &gyro->z, &acc->x, &acc->y, &acc->z};
  float    normal[CF_IMU_AXES];
  cf_random_normals(&faults->random, normal, CF_IMU_AXES);
  for (int i = 0; i < CF_IMU_AXES; i++) {
    const unsigned bit = 1u << i;
    if ((faults->stuck_axes & bit) == 0) {
      const float error = faults->imu_bias[i] + faults->imu_noise[i] * normal[i];
      *readings[i]      = within_range((float)*readings[i] + error);
      continue;
    }
    if ((faults->held_axes & bit) == 0) {
      faults->held[i] = *readings[i];
      faults->held_axes |= (uint8_t)bit;
    }
    *readings[i] = faults->held[i];
  }
}

// ----------------------------------------------------------------------------------- positioning

cf_status_t cf_inject_positioning_loss(cf_t *cf, bool is_lost) {
  return cf_vehicle_lose_positioning(&cf->vehicle, is_lost);
}

cf_status_t cf_inject_positioning_dropout(cf_t *cf, float share) {
  const float well = cf->config.vehicle.mocap.mishap.dropout;
  return cf_vehicle_drop_poses(&cf->vehicle, share > 0.0f ? share : well);
}

cf_status_t cf_inject_positioning_delay(cf_t *cf, uint32_t extra_ms) {
  const uint32_t well = cf->config.vehicle.mocap.latency_ms;
  return extra_ms > UINT32_MAX - well ? CF_ERR_CAPACITY
                                      : cf_vehicle_delay_positioning(&cf->vehicle, well + extra_ms);
}

// --------------------------------------------------------------------------------------- battery

cf_status_t cf_inject_battery_charge(cf_t *cf, float charge) {
  return cf_battery_set_charge(&cf->vehicle.battery, charge);
}

cf_status_t cf_inject_battery_resistance(cf_t *cf, float extra) {
  if (!cf_is_within(extra, 0.0f, LARGEST_RESISTANCE)) {
    return CF_ERR_VALUE;
  }
  // the drone's own config keeps what it is when all is well
  const float well                      = cf->config.vehicle.airframe.battery.resistance;
  cf->vehicle.battery.config.resistance = well + extra;
  return CF_OK;
}

void cf_inject_battery_cut(cf_t *cf, bool is_cut) {
  cf_battery_t *battery   = &cf->vehicle.battery;
  const bool    is_supply = battery->config.constant_voltage > 0.0f;
  const float   no_load   = is_supply ? battery->config.constant_voltage : battery->open_circuit;
  cf->injected.is_battery_cut = is_cut;
  battery->current            = 0.0f;
  battery->voltage            = is_cut ? 0.0f : no_load;
  note_what_is_wrong(&cf->injected);
}

// ------------------------------------------------------------------------------------------ gust

cf_status_t cf_inject_gust(cf_t *cf, const float velocity[3], uint32_t ticks) {
  return cf_vehicle_gust(&cf->vehicle, velocity, (float)ticks * TICK);
}
