// Attitude from gyroscope and accelerometer: Mahony's filter, or Madgwick's.
// clang-format off
#include <math.h>
#include <stdint.h>

#include "sensfusion6.h"
#include "log.h"
#include "param.h"
#include "physicalConstants.h"
#include "autoconf.h"
// clang-format on

#ifdef CONFIG_IMU_MADGWICK_QUATERNION
#define BETA_DEF 0.01f
float beta = BETA_DEF;
#else
#define TWO_KP_DEF 0.8f
#define TWO_KI_DEF 0.002f
float twoKp       = TWO_KP_DEF;
float twoKi       = TWO_KI_DEF;
float integralFBx = 0.0f;
float integralFBy = 0.0f;
float integralFBz = 0.0f;
#endif

// body to world
float qw = 1.0f;
float qx = 0.0f;
float qy = 0.0f;
float qz = 0.0f;

static float gravX, gravY, gravZ;  // direction of gravity in the body frame
static float baseZacc = 1.0f;      // [g], along gravity at the first update

static uint8_t isInit;
static uint8_t isCalibrated;

static void  sensfusion6UpdateQImpl(float gx, float gy, float gz, float ax, float ay, float az,
                                    float dt);
static float sensfusion6GetAccZ(const float ax, const float ay, const float az);
static void  estimatedGravityDirection(float *gx, float *gy, float *gz);
static float invSqrt(float x);

void sensfusion6Init() {
  isInit = 1;
}

bool sensfusion6Test(void) {
  return isInit;
}

void sensfusion6UpdateQ(float gx, float gy, float gz, float ax, float ay, float az, float dt) {
  sensfusion6UpdateQImpl(gx, gy, gz, ax, ay, az, dt);
  estimatedGravityDirection(&gravX, &gravY, &gravZ);

  // the first update takes the vehicle for standing still
  if (!isCalibrated) {
    baseZacc     = sensfusion6GetAccZ(ax, ay, az);
    isCalibrated = 1;
  }
}

static void normalizeQuaternion(void) {
  const float scale = invSqrt(qw * qw + qx * qx + qy * qy + qz * qz);
  qw *= scale;
  qx *= scale;
  qy *= scale;
  qz *= scale;
}

#ifdef CONFIG_IMU_MADGWICK_QUATERNION
static void sensfusion6UpdateQImpl(float gx, float gy, float gz, float ax, float ay, float az,
                                   float dt) {
  const float w = qw, x = qx, y = qy, z = qz;

  float dw = 0.5f * (-x * gx - y * gy - z * gz);
  float dx = 0.5f * (w * gx + y * gz - z * gy);
  float dy = 0.5f * (w * gy - x * gz + z * gx);
  float dz = 0.5f * (w * gz + x * gy - y * gx);

  if (!((ax == 0.0f) && (ay == 0.0f) && (az == 0.0f))) {
    const float scale = invSqrt(ax * ax + ay * ay + az * az);
    ax *= scale;
    ay *= scale;
    az *= scale;

    // one step down the gradient of the distance to gravity
    const float ww = w * w, xx = x * x, yy = y * y, zz = z * z;
    float       s0    = 4.0f * w * yy + 2.0f * y * ax + 4.0f * w * xx - 2.0f * x * ay;
    float       s1    = 4.0f * x * zz - 2.0f * z * ax + 4.0f * ww * x - 2.0f * w * ay - 4.0f * x +
                        8.0f * x * xx + 8.0f * x * yy + 4.0f * x * az;
    float       s2    = 4.0f * ww * y + 2.0f * w * ax + 4.0f * y * zz - 2.0f * z * ay - 4.0f * y +
                        8.0f * y * xx + 8.0f * y * yy + 4.0f * y * az;
    float       s3    = 4.0f * xx * z - 2.0f * x * ax + 4.0f * yy * z - 2.0f * y * ay;
    const float slope = invSqrt(s0 * s0 + s1 * s1 + s2 * s2 + s3 * s3);
    dw -= beta * (s0 * slope);
    dx -= beta * (s1 * slope);
    dy -= beta * (s2 * slope);
    dz -= beta * (s3 * slope);
  }

  qw += dw * dt;
  qx += dx * dt;
  qy += dy * dt;
  qz += dz * dt;
  normalizeQuaternion();
}
#else
static void sensfusion6UpdateQImpl(float gx, float gy, float gz, float ax, float ay, float az,
                                   float dt) {
  gx = gx * M_PI_F / 180.0f;
  gy = gy * M_PI_F / 180.0f;
  gz = gz * M_PI_F / 180.0f;

  if (!((ax == 0.0f) && (ay == 0.0f) && (az == 0.0f))) {
    const float scale = invSqrt(ax * ax + ay * ay + az * az);
    ax *= scale;
    ay *= scale;
    az *= scale;

    // half the error: measured x expected direction of gravity
    const float halfvx = qx * qz - qw * qy;
    const float halfvy = qw * qx + qy * qz;
    const float halfvz = qw * qw - 0.5f + qz * qz;
    const float halfex = ay * halfvz - az * halfvy;
    const float halfey = az * halfvx - ax * halfvz;
    const float halfez = ax * halfvy - ay * halfvx;

    if (twoKi > 0.0f) {
      integralFBx += twoKi * halfex * dt;
      integralFBy += twoKi * halfey * dt;
      integralFBz += twoKi * halfez * dt;
      gx += integralFBx;
      gy += integralFBy;
      gz += integralFBz;
    } else {
      integralFBx = 0.0f;
      integralFBy = 0.0f;
      integralFBz = 0.0f;
    }
    gx += twoKp * halfex;
    gy += twoKp * halfey;
    gz += twoKp * halfez;
  }

  gx *= 0.5f * dt;
  gy *= 0.5f * dt;
  gz *= 0.5f * dt;
  const float w = qw, x = qx, y = qy, z = qz;
  qw += -x * gx - y * gy - z * gz;
  qx += w * gx + y * gz - z * gy;
  qy += w * gy - x * gz + z * gx;
  qz += w * gz + x * gy - y * gx;
  normalizeQuaternion();
}
#endif

void sensfusion6GetQuaternion(float *q_x, float *q_y, float *q_z, float *q_w) {
  *q_x = qx;
  *q_y = qy;
  *q_z = qz;
  *q_w = qw;
}

void sensfusion6GetEulerRPY(float *roll, float *pitch, float *yaw) {
  float gx = gravX;
  if (gx > 1.0f) {
    gx = 1.0f;
  }
  if (gx < -1.0f) {
    gx = -1.0f;
  }
  *yaw =
      atan2f(2.0f * (qw * qz + qx * qy), qw * qw + qx * qx - qy * qy - qz * qz) * 180.0f / M_PI_F;
  *pitch = asinf(gx) * 180.0f / M_PI_F;  // legacy: positive lifts the nose
  *roll  = atan2f(gravY, gravZ) * 180.0f / M_PI_F;
}

float sensfusion6GetAccZWithoutGravity(const float ax, const float ay, const float az) {
  return sensfusion6GetAccZ(ax, ay, az) - baseZacc;
}

// 1 / sqrt(x) to 0.17 %: static by its declaration above, not by this one
float invSqrt(float x) {
  float    half = 0.5f * x;
  float    y    = x;
  uint32_t bits = *(uint32_t *)&y;
  bits          = 0x5f3759df - (bits >> 1);
  y             = *(float *)&bits;
  y             = y * (1.5f - (half * y * y));
  return y;
}

static float sensfusion6GetAccZ(const float ax, const float ay, const float az) {
  return ax * gravX + ay * gravY + az * gravZ;
}

static void estimatedGravityDirection(float *gx, float *gy, float *gz) {
  *gx = 2.0f * (qx * qz - qw * qy);
  *gy = 2.0f * (qw * qx + qy * qz);
  *gz = qw * qw - qx * qx - qy * qy + qz * qz;
}

LOG_GROUP_START(sensfusion6)
LOG_ADD(LOG_FLOAT, qw, &qw)
LOG_ADD(LOG_FLOAT, qx, &qx)
LOG_ADD(LOG_FLOAT, qy, &qy)
LOG_ADD(LOG_FLOAT, qz, &qz)
LOG_ADD(LOG_FLOAT, gravityX, &gravX)
LOG_ADD(LOG_FLOAT, gravityY, &gravY)
LOG_ADD(LOG_FLOAT, gravityZ, &gravZ)
LOG_ADD(LOG_FLOAT, accZbase, &baseZacc)
LOG_ADD(LOG_UINT8, isInit, &isInit)
LOG_ADD(LOG_UINT8, isCalibrated, &isCalibrated)
LOG_GROUP_STOP(sensfusion6)

PARAM_GROUP_START(sensfusion6)
#ifdef CONFIG_IMU_MADGWICK_QUATERNION
PARAM_ADD(PARAM_FLOAT, beta, &beta)
#else
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, kp, &twoKp)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, ki, &twoKi)
#endif
PARAM_ADD(PARAM_FLOAT, baseZacc, &baseZacc)
PARAM_GROUP_STOP(sensfusion6)
