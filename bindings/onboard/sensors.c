#include "onboard/sensors.h"

#include <math.h>
#include <string.h>

#include "variable_row.h"

// BMI088 on the Crazyflie 2.1 and later (docs/reference/estimators.md#12.1)
#define GYRO_DEG_PER_LSB (4000.0f / 65536.0f)
#define ACC_G_PER_LSB (48.0f / 65536.0f)
#define SAMPLE_RATE 1000.0f       // [Hz]
#define GYRO_CUTOFF 80.0f         // [Hz]
#define ACC_CUTOFF 30.0f          // [Hz]
#define ACC_CUTOFF_TEST 500.0f    // [Hz], while propellers are tested
#define GYRO_MAX_VARIANCE 100.0f  // [LSB^2], still enough to trust the mean
#define GYRO_BIAS_HOLD_OFF 1000   // [ms]

// barometer: the standard atmosphere upside down (docs/reference/estimators.md#12.8)
#define SEA_LEVEL_PRESSURE 1015.7f  // [mbar]
#define BARO_EXPONENT 0.1902630958f
#define BARO_TEMPERATURE (25.0f + 273.15f)  // [K], taken for granted
#define LAPSE_RATE 0.0065f                  // [K/m]

void cf_sensors_init(cf_sensors_t *sensors) {
  memset(sensors, 0, sizeof *sensors);
  sensors->has_barometer   = 1;
  sensors->acc_scale.scale = 1.0f;
  for (int i = 0; i < 3; i++) {
    sensors->alignment[i][i] = 1.0f;
    lpf2pInit(&sensors->gyro_filter[i], SAMPLE_RATE, GYRO_CUTOFF);
    lpf2pInit(&sensors->acc_filter[i], SAMPLE_RATE, ACC_CUTOFF);
  }
}

void cf_sensors_listen_to_propellers(cf_sensors_t *sensors, bool is_listening) {
  for (int i = 0; i < 3; i++) {
    lpf2pInit(&sensors->acc_filter[i], SAMPLE_RATE, is_listening ? ACC_CUTOFF_TEST : ACC_CUTOFF);
  }
}

bool cf_sensors_are_calibrated(const cf_sensors_t *sensors) {
  return sensors->gyro_bias.is_found;
}

// The sums run along with the ring: integers, so they equal a fresh summation exactly.
static void bias_add(cf_gyro_bias_t *bias, const Axis3i16 *sample) {
  Axis3i16     *slot   = &bias->ring[bias->next];
  const int32_t old[3] = {slot->x, slot->y, slot->z};
  const int32_t now[3] = {sample->x, sample->y, sample->z};
  for (int i = 0; i < 3; i++) {
    bias->sum[i] += now[i] - old[i];
    bias->sum_of_squares[i] += (int64_t)now[i] * now[i] - (int64_t)old[i] * old[i];
  }

  *slot = *sample;
  bias->next++;
  if (bias->next == CF_GYRO_BIAS_SAMPLES) {
    bias->next    = 0;
    bias->is_full = true;
  }
}

static void bias_check(cf_gyro_bias_t *bias, uint32_t tick) {
  bool is_still = true;
  for (int i = 0; i < 3; i++) {
    const float mean        = (float)bias->sum[i] / CF_GYRO_BIAS_SAMPLES;
    const float mean_square = (float)(bias->sum_of_squares[i] / CF_GYRO_BIAS_SAMPLES);
    bias->variance[i]       = mean_square - mean * mean;
    is_still                = is_still && bias->variance[i] < GYRO_MAX_VARIANCE;
  }

  if (is_still && tick > GYRO_BIAS_HOLD_OFF) {
    for (int i = 0; i < 3; i++) {
      bias->bias.axis[i] = (float)bias->sum[i] / CF_GYRO_BIAS_SAMPLES;
    }
    bias->is_found = true;
  }
}

static void bias_update(cf_gyro_bias_t *bias, const Axis3i16 *sample, uint32_t tick) {
  bias_add(bias, sample);
  if (bias->is_full) {
    bias_check(bias, tick);
  }
}

static void acc_scale_update(cf_acc_scale_t *self, const Axis3i16 *acc) {
  const float x = (float)acc->x * ACC_G_PER_LSB;
  const float y = (float)acc->y * ACC_G_PER_LSB;
  const float z = (float)acc->z * ACC_G_PER_LSB;
  self->sum += sqrtf(x * x + y * y + z * z);
  self->count++;
  if (self->count == CF_ACC_SCALE_SAMPLES) {
    self->scale = self->sum / CF_ACC_SCALE_SAMPLES;
  }
}

// Rotation by the three mounting angles; made again only when a parameter moved
// (docs/reference/estimators.md#12.5).
static void align_update(cf_sensors_t *sensors) {
  const float angles[3] = {sensors->imu_phi, sensors->imu_theta, sensors->imu_psi};
  if (memcmp(angles, sensors->aligned_angles, sizeof angles) == 0) {
    return;
  }
  memcpy(sensors->aligned_angles, angles, sizeof angles);

  const float to_rad = 3.14159265358979f / 180.0f;
  const float sp = sinf(angles[0] * to_rad), cp = cosf(angles[0] * to_rad);
  const float st = sinf(angles[1] * to_rad), ct = cosf(angles[1] * to_rad);
  const float ss = sinf(angles[2] * to_rad), cs = cosf(angles[2] * to_rad);
  const float m[3][3] = {
      {ct * cs, ct * ss, -st},
      {sp * st * cs - cp * ss, sp * st * ss + cp * cs, sp * ct},
      {cp * st * cs + sp * ss, cp * st * ss - sp * cs, cp * ct},
  };
  memcpy(sensors->alignment, m, sizeof m);
}

static Axis3f align(const float m[3][3], const Axis3f *in) {
  return (Axis3f){.axis = {
                      m[0][0] * in->x + m[0][1] * in->y + m[0][2] * in->z,
                      m[1][0] * in->x + m[1][1] * in->y + m[1][2] * in->z,
                      m[2][0] * in->x + m[2][1] * in->y + m[2][2] * in->z,
                  }};
}

void cf_sensors_set_trim(cf_sensors_t *sensors, float pitch, float roll) {
  const float to_rad      = 3.14159265358979f / 180.0f;
  sensors->is_trimmed     = pitch != 0.0f || roll != 0.0f;
  sensors->trim_sin_pitch = sinf(pitch * to_rad);
  sensors->trim_cos_pitch = cosf(pitch * to_rad);
  sensors->trim_sin_roll  = sinf(roll * to_rad);
  sensors->trim_cos_roll  = cosf(roll * to_rad);
}

// About x by the roll, then about y by the pitch (docs/reference/estimators.md#12.6).
static Axis3f trim(const cf_sensors_t *sensors, Axis3f in) {
  if (!sensors->is_trimmed) {
    return in;
  }
  const float y = in.y * sensors->trim_cos_roll - in.z * sensors->trim_sin_roll;
  const float z = in.y * sensors->trim_sin_roll + in.z * sensors->trim_cos_roll;
  return (Axis3f){.axis = {
                      in.x * sensors->trim_cos_pitch - z * sensors->trim_sin_pitch,
                      y,
                      in.x * sensors->trim_sin_pitch + z * sensors->trim_cos_pitch,
                  }};
}

void cf_sensors_update(cf_sensors_t *sensors, const Axis3i16 *gyro, const Axis3i16 *acc,
                       uint32_t tick) {
  sensors->gyro_raw = *gyro;
  if (!sensors->gyro_bias.is_found) {
    bias_update(&sensors->gyro_bias, gyro, tick);
  }
  if (sensors->gyro_bias.is_found && sensors->acc_scale.count < CF_ACC_SCALE_SAMPLES) {
    acc_scale_update(&sensors->acc_scale, acc);
  }
  align_update(sensors);

  const Axis3f *bias  = &sensors->gyro_bias.bias;
  const Axis3f  rate  = {.axis = {
                             ((float)gyro->x - bias->x) * GYRO_DEG_PER_LSB,
                             ((float)gyro->y - bias->y) * GYRO_DEG_PER_LSB,
                             ((float)gyro->z - bias->z) * GYRO_DEG_PER_LSB,
                         }};
  const float   scale = sensors->acc_scale.scale;
  const Axis3f  force = {.axis = {
                             (float)acc->x * ACC_G_PER_LSB / scale,
                             (float)acc->y * ACC_G_PER_LSB / scale,
                             (float)acc->z * ACC_G_PER_LSB / scale,
                         }};

  const Axis3f rate_aligned  = align(sensors->alignment, &rate);
  const Axis3f force_aligned = trim(sensors, align(sensors->alignment, &force));
  for (int i = 0; i < 3; i++) {
    sensors->data.gyro.axis[i] = lpf2pApply(&sensors->gyro_filter[i], rate_aligned.axis[i]);
    sensors->data.acc.axis[i]  = lpf2pApply(&sensors->acc_filter[i], force_aligned.axis[i]);
  }
  sensors->data.interruptTimestamp = (uint64_t)tick * 1000;
}

void cf_sensors_update_baro(cf_sensors_t *sensors, float pressure, float temperature) {
  const float mbar   = pressure * 0.01f;
  const float height = powf(SEA_LEVEL_PRESSURE / mbar, BARO_EXPONENT) - 1.0f;

  sensors->data.baro = (baro_t){
      .pressure    = mbar,
      .temperature = temperature,
      .asl         = height * BARO_TEMPERATURE / LAPSE_RATE,
  };
}

static const cf_variable_t PARAMETERS[] = {
    CF_ROW("imu_sensors", "BMP3XX", UINT8, CF_READ_ONLY, cf_sensors_t, has_barometer),
    CF_ROW("imu_sensors", "imuPhi", FLOAT, CF_PERSISTENT, cf_sensors_t, imu_phi),
    CF_ROW("imu_sensors", "imuTheta", FLOAT, CF_PERSISTENT, cf_sensors_t, imu_theta),
    CF_ROW("imu_sensors", "imuPsi", FLOAT, CF_PERSISTENT, cf_sensors_t, imu_psi),
};

static const cf_variable_t LOGS[] = {
    CF_ROW("acc", "x", FLOAT, CF_CORE, cf_sensors_t, data.acc.x),
    CF_ROW("acc", "y", FLOAT, CF_CORE, cf_sensors_t, data.acc.y),
    CF_ROW("acc", "z", FLOAT, CF_CORE, cf_sensors_t, data.acc.z),
    CF_ROW("gyro", "x", FLOAT, CF_CORE, cf_sensors_t, data.gyro.x),
    CF_ROW("gyro", "y", FLOAT, CF_CORE, cf_sensors_t, data.gyro.y),
    CF_ROW("gyro", "z", FLOAT, CF_CORE, cf_sensors_t, data.gyro.z),
    CF_ROW("mag", "x", FLOAT, CF_CORE, cf_sensors_t, data.mag.x),
    CF_ROW("mag", "y", FLOAT, CF_CORE, cf_sensors_t, data.mag.y),
    CF_ROW("mag", "z", FLOAT, CF_CORE, cf_sensors_t, data.mag.z),
    CF_ROW("baro", "asl", FLOAT, CF_CORE, cf_sensors_t, data.baro.asl),
    CF_ROW("baro", "temp", FLOAT, 0, cf_sensors_t, data.baro.temperature),
    CF_ROW("baro", "pressure", FLOAT, CF_CORE, cf_sensors_t, data.baro.pressure),
    CF_ROW("gyro", "xRaw", INT16, 0, cf_sensors_t, gyro_raw.x),
    CF_ROW("gyro", "yRaw", INT16, 0, cf_sensors_t, gyro_raw.y),
    CF_ROW("gyro", "zRaw", INT16, 0, cf_sensors_t, gyro_raw.z),
    CF_ROW("gyro", "xVariance", FLOAT, 0, cf_sensors_t, gyro_bias.variance[0]),
    CF_ROW("gyro", "yVariance", FLOAT, 0, cf_sensors_t, gyro_bias.variance[1]),
    CF_ROW("gyro", "zVariance", FLOAT, 0, cf_sensors_t, gyro_bias.variance[2]),
};

cf_variables_t cf_sensors_parameters(void) {
  return CF_TABLE(PARAMETERS);
}

cf_variables_t cf_sensors_logs(void) {
  return CF_TABLE(LOGS);
}
