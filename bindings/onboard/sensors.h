/* The sensor front end: raw samples in, calibrated and filtered body rates and accelerations, and
 * the height above sea level out.
 *
 * One call per millisecond, as the gyro's data-ready interrupt drives it on the vehicle, and one
 * per sample of the barometer (docs/reference/estimators.md#12, BMI088 and BMP388). There is no
 * magnetometer: it reads zero. */
#ifndef CF_ONBOARD_SENSORS_H
#define CF_ONBOARD_SENSORS_H

#include <stdbool.h>
#include <stdint.h>

#include "api/filter.h"
#include "api/stabilizer_types.h"
#include "variables.h"

#define CF_GYRO_BIAS_SAMPLES 512
#define CF_ACC_SCALE_SAMPLES 200

// The mean of a window of raw gyro samples, accepted as bias once the vehicle is at rest.
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
  cf_gyro_bias_t gyro_bias;

  // parameters
  uint8_t has_barometer;  // imu_sensors.BMP3XX, always 1
  float   imu_phi;        // [deg], rotation of the board in the airframe
  float   imu_theta;      // [deg]
  float   imu_psi;        // [deg]

  // settings
  bool  is_trimmed;
  float trim_sin_pitch, trim_cos_pitch;  // level of the accelerometer in the airframe
  float trim_sin_roll, trim_cos_roll;

  // state
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

// Sets the trim of the accelerometer, which the vehicle keeps in its configuration block: the pitch
// and roll [deg, legacy pitch] that it shows while the vehicle is level.
void cf_sensors_set_trim(cf_sensors_t *sensors, float pitch, float roll);

// Moves the low-pass of the accelerometer from 30 Hz to half the sample rate, and back: the test of
// the propellers wants to hear every shake. The filter starts from zero each time.
void cf_sensors_listen_to_propellers(cf_sensors_t *sensors, bool is_listening);

// Takes the raw samples [LSB] of one millisecond; the result is in `data`.
void cf_sensors_update(cf_sensors_t *sensors, const Axis3i16 *gyro, const Axis3i16 *acc,
                       uint32_t tick);

// Takes a sample of the barometer: pressure [Pa] and its temperature [deg C].
void cf_sensors_update_baro(cf_sensors_t *sensors, float pressure, float temperature);

// True once the gyro bias is known; the stabilizer waits for it.
bool cf_sensors_are_calibrated(const cf_sensors_t *sensors);

cf_variables_t cf_sensors_parameters(void);
cf_variables_t cf_sensors_logs(void);

#endif  // CF_ONBOARD_SENSORS_H
