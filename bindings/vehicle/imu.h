/* The BMI088: raw gyroscope and accelerometer samples from the true motion.
 *
 *   raw = saturate(round(gain * (true + lines) + bias + rest + flight * vibration * normal)),
 *   rest <- a * rest + b * another normal
 *
 * `rest` is the noise of the chip, shaped by one pole in place of its own low-pass, so that both
 * its standard deviation and its density at low frequencies are those of the data sheet: white
 * noise of that deviation would have half the density. `flight` is what turning rotors add, white,
 * and `lines` what they add at their own frequencies (rotor_vibration.h; off by default). `bias` is
 * drawn at init, as the gain is, and walks from there on.
 *
 * A sum of one-pole and white noise is a process with one pole and one zero, driven by one normal
 * number: that is how `rest` and `flight` are made, at the price of one of them.
 *
 * Ranges and steps are those of the onboard front end: +-2000 deg/s and +-24 g over 16 bits, with g
 * = 9.81 m/s^2 (docs/reference/estimators.md#12.1, docs/reference/vehicle.md#10). Left out: drift
 * with temperature, misalignment, sensitivity of the gyroscope to acceleration. */
#ifndef CF_VEHICLE_IMU_H
#define CF_VEHICLE_IMU_H

#include <stdint.h>

#include "api/imu_types.h"
#include "status.h"
#include "vehicle/random.h"
#include "vehicle/rotor_vibration.h"

#define CF_IMU_AXES 6

typedef struct {
  float gyro_noise_rest;     // [rad/s] >= 0, standard deviation per 1 kHz sample, motors off
  float gyro_noise_density;  // [(rad/s)/sqrt(Hz)] >= 0, of it, one-sided, at low frequencies
  float gyro_noise_flight;   // [rad/s] >= 0, white, added in hover
  float acc_noise_rest;      // [m/s^2] >= 0
  float acc_noise_density;   // [(m/s^2)/sqrt(Hz)] >= 0; one that is too low for a one-pole low-pass
  float acc_noise_flight;    // [m/s^2] >= 0            makes the noise at rest white

  // turn-on errors, drawn at init within +- these
  float gyro_bias;         // [rad/s] >= 0
  float acc_bias;          // [m/s^2] >= 0
  float gyro_scale_error;  // [0, 0.5], relative
  float acc_scale_error;   // [0, 0.5], relative

  // random walk of the bias, on a long leash
  float gyro_drift;  // [(rad/s)/sqrt(s)] >= 0
  float acc_drift;   // [(m/s^2)/sqrt(s)] >= 0
  float drift_time;  // [s] >= 1, after which the walk forgets where it was

  cf_rotor_vibration_config_t lines;

  float noise_scale;  // [0, 100], on the noises; 0 = ideal
  float bias_scale;   // [0, 10], on turn-on errors and drift; 0 = ideal
} cf_imu_config_t;

// All in steps of the converter; x, y, z of the gyroscope, then of the accelerometer.
typedef struct {
  float gain[CF_IMU_AXES];  // [1/(rad/s)] and [1/(m/s^2)]
  float bias[CF_IMU_AXES];  // as it is now
  float kept[CF_IMU_AXES];  // of the noise so far, what goes into the next sample

  float rest_memory[2];      // a, of gyroscope and accelerometer
  float rest_variance[2];    // b^2
  float flight_variance[2];  // in hover

  float    turn_on_bias[CF_IMU_AXES];
  float    drift[2];   // standard deviation of a step of the walk
  float    leash;      // share of the way back to the turn-on bias that a step goes
  uint32_t countdown;  // [ticks] to the next step of the walk

  cf_rotor_vibration_t lines;
  cf_random_t          random;
} cf_imu_t;

// Fills the sensor and draws its turn-on errors. Returns CF_ERR_VALUE when a number of the config
// is outside its range.
cf_status_t cf_imu_init(cf_imu_t *imu, const cf_imu_config_t *config, cf_random_t random);

// Pure: steps of the converter per rad/s (axes 0 to 2) or per m/s^2 (3 to 5).
float cf_imu_steps(int axis);

// Takes one sample: body rates [rad/s], specific force in the body frame [m/s^2] (+9.81 along z at
// rest), vibration of the rotors (1 in hover). Writes raw steps; a NaN reads as the lowest one.
void cf_imu_sample(cf_imu_t *imu, const float rates_body[3], const float specific_force[3],
                   float vibration, Axis3i16 *gyro_raw, Axis3i16 *acc_raw);

#endif  // CF_VEHICLE_IMU_H
