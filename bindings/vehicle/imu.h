/* The BMI088: raw gyroscope and accelerometer samples from the true motion.
 *
 *   raw = saturate(round(gain * true + bias + sigma * normal)),
 *   sigma^2 = rest^2 + (flight * vibration)^2
 *
 * Ranges and steps are those of the onboard front end: +-2000 deg/s and +-24 g over 16 bits, with g
 * = 9.81 m/s^2 (estimators dossier section 12.1, vehicle dossier section 10). */
#ifndef CF_VEHICLE_IMU_H
#define CF_VEHICLE_IMU_H

#include "api/imu_types.h"
#include "status.h"
#include "vehicle/random.h"

#define CF_IMU_AXES 6

typedef struct {
  float gyro_noise_rest;    // [rad/s] >= 0, standard deviation per 1 kHz sample, motors off
  float gyro_noise_flight;  // [rad/s] >= 0, added in hover
  float acc_noise_rest;     // [m/s^2] >= 0
  float acc_noise_flight;   // [m/s^2] >= 0

  // turn-on errors, drawn at init within +- these
  float gyro_bias;         // [rad/s] >= 0
  float acc_bias;          // [m/s^2] >= 0
  float gyro_scale_error;  // [0, 0.5], relative
  float acc_scale_error;   // [0, 0.5], relative

  float noise_scale;  // [0, 100], on the noises; 0 = ideal
  float bias_scale;   // [0, 10], on the turn-on errors; 0 = ideal
} cf_imu_config_t;

// All in steps of the converter; x, y, z of the gyroscope, then of the accelerometer.
typedef struct {
  float gain[CF_IMU_AXES];  // [1/(rad/s)] and [1/(m/s^2)]
  float bias[CF_IMU_AXES];
  float rest_variance[2];  // gyroscope, accelerometer
  float flight_variance[2];

  cf_random_t random;
} cf_imu_t;

// Fills the sensor and draws its turn-on errors. Returns CF_ERR_VALUE when a number of the config
// is outside its range.
cf_status_t cf_imu_init(cf_imu_t *imu, const cf_imu_config_t *config, cf_random_t random);

// Takes one sample: body rates [rad/s], specific force in the body frame [m/s^2] (+9.81 along z at
// rest), vibration of the rotors (1 in hover). Writes raw steps; a NaN reads as the lowest one.
void cf_imu_sample(cf_imu_t *imu, const float rates_body[3], const float specific_force[3],
                   float vibration, Axis3i16 *gyro_raw, Axis3i16 *acc_raw);

#endif  // CF_VEHICLE_IMU_H
