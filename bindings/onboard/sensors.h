/* The sensor front end: raw IMU samples in, calibrated and filtered body rates and accelerations
 * out.
 *
 * One call per millisecond, as the gyro's data-ready interrupt drives it on the vehicle
 * (estimators dossier section 12, BMI088). */
#ifndef CF_ONBOARD_SENSORS_H
#define CF_ONBOARD_SENSORS_H

#include <stdbool.h>
#include <stdint.h>

#include "api/filter.h"
#include "api/stabilizer_types.h"
#include "variables.h"

#define CF_GYRO_BIAS_SAMPLES 512
#define CF_ACC_SCALE_SAMPLES 200

// The mean of a window of raw gyro samples, accepted as bias once the vehicle lies still.
typedef struct {
  Axis3i16 ring[CF_GYRO_BIAS_SAMPLES];
  int32_t  next;               // index of the oldest sample
  bool     is_full;            // the ring has been filled once
  bool     is_found;           // the mean has been accepted
  int64_t  sum[3];             // [LSB]
  int64_t  sum_of_squares[3];  // [LSB^2]
  float    variance[3];        // [LSB^2], of the last check
  Axis3f   bias;               // [LSB]
} cf_gyro_bias_t;

// Scales the accelerometer so that gravity at rest measures 1 g.
typedef struct {
  int32_t count;
  float   sum;    // [g]
  float   scale;  // divides every axis
} cf_acc_scale_t;

typedef struct {
  // parameters
  float imu_phi;    // [deg], rotation of the board in the airframe
  float imu_theta;  // [deg]
  float imu_psi;    // [deg]

  // state
  cf_gyro_bias_t gyro_bias;
  cf_acc_scale_t acc_scale;
  lpf2pData      gyro_filter[3];
  lpf2pData      acc_filter[3];
  float          alignment[3][3];    // airframe from board
  float          aligned_angles[3];  // [deg], the angles that `alignment` was made from

  // output
  Axis3i16     gyro_raw;  // [LSB]
  sensorData_t data;
} cf_sensors_t;

// Fills the whole struct: filters at rest, no bias known.
void cf_sensors_init(cf_sensors_t *sensors);

// Takes the raw samples [LSB] of one millisecond; the result is in `data`.
void cf_sensors_update(cf_sensors_t *sensors, const Axis3i16 *gyro, const Axis3i16 *acc,
                       uint32_t tick);

// True once the gyro bias is known; the stabilizer waits for it.
bool cf_sensors_are_calibrated(const cf_sensors_t *sensors);

cf_variables_t cf_sensors_parameters(void);
cf_variables_t cf_sensors_logs(void);

#endif  // CF_ONBOARD_SENSORS_H
