#include "api/sensfusion6.h"

#include <math.h>
#include <string.h>

#include "api/math3d.h"
#include "api/num.h"
#include "builtin/complementary/complementary.h"
#include "variable_row.h"

#define TWO_KP 0.8f
#define TWO_KI 0.002f
#define BETA 0.01f

void cf_sensfusion6_boot(cf_sensfusion6_t *fusion, cf_sensfusion6_filter_t filter) {
  *fusion = (cf_sensfusion6_t){
      .filter   = filter,
      .beta     = BETA,
      .twoKp    = TWO_KP,
      .twoKi    = TWO_KI,
      .qw       = 1.0f,
      .baseZacc = 1.0f,
  };
}

void cf_sensfusion6_init(cf_sensfusion6_t *fusion) {
  fusion->isInit = 1;
}

bool cf_sensfusion6_test(const cf_sensfusion6_t *fusion) {
  return fusion->isInit != 0;
}

// 1 / sqrt(x) to 0.17 %: a first guess from the bits of the number, then one step of Newton's.
static float fast_inverse_sqrt(float x) {
  uint32_t bits;
  memcpy(&bits, &x, sizeof bits);
  bits = 0x5f3759dfu - (bits >> 1);
  float y;
  memcpy(&y, &bits, sizeof y);
  return y * (1.5f - 0.5f * x * y * y);
}

static bool is_zero(float ax, float ay, float az) {
  return ax == 0.0f && ay == 0.0f && az == 0.0f;
}

static void normalize(cf_sensfusion6_t *s) {
  const float scale =
      fast_inverse_sqrt(s->qw * s->qw + s->qx * s->qx + s->qy * s->qy + s->qz * s->qz);
  s->qw *= scale;
  s->qx *= scale;
  s->qy *= scale;
  s->qz *= scale;
}

static void mahony(cf_sensfusion6_t *s, float gx, float gy, float gz, float ax, float ay, float az,
                   float dt) {
  gx = gx * M_PI_F / 180.0f;
  gy = gy * M_PI_F / 180.0f;
  gz = gz * M_PI_F / 180.0f;

  if (!is_zero(ax, ay, az)) {
    const float scale = fast_inverse_sqrt(ax * ax + ay * ay + az * az);
    ax *= scale;
    ay *= scale;
    az *= scale;

    // half the error: measured x expected direction of gravity
    const float halfvx = s->qx * s->qz - s->qw * s->qy;
    const float halfvy = s->qw * s->qx + s->qy * s->qz;
    const float halfvz = s->qw * s->qw - 0.5f + s->qz * s->qz;
    const float halfex = ay * halfvz - az * halfvy;
    const float halfey = az * halfvx - ax * halfvz;
    const float halfez = ax * halfvy - ay * halfvx;

    if (s->twoKi > 0.0f) {
      s->integralFBx += s->twoKi * halfex * dt;
      s->integralFBy += s->twoKi * halfey * dt;
      s->integralFBz += s->twoKi * halfez * dt;
      gx += s->integralFBx;
      gy += s->integralFBy;
      gz += s->integralFBz;
    } else {
      s->integralFBx = 0.0f;
      s->integralFBy = 0.0f;
      s->integralFBz = 0.0f;
    }
    gx += s->twoKp * halfex;
    gy += s->twoKp * halfey;
    gz += s->twoKp * halfez;
  }

  gx *= 0.5f * dt;
  gy *= 0.5f * dt;
  gz *= 0.5f * dt;
  const float w = s->qw, x = s->qx, y = s->qy, z = s->qz;
  s->qw += -x * gx - y * gy - z * gz;
  s->qx += w * gx + y * gz - z * gy;
  s->qy += w * gy - x * gz + z * gx;
  s->qz += w * gz + x * gy - y * gx;
  normalize(s);
}

static void madgwick(cf_sensfusion6_t *s, float gx, float gy, float gz, float ax, float ay,
                     float az, float dt) {
  const float w = s->qw, x = s->qx, y = s->qy, z = s->qz;

  float dw = 0.5f * (-x * gx - y * gy - z * gz);
  float dx = 0.5f * (w * gx + y * gz - z * gy);
  float dy = 0.5f * (w * gy - x * gz + z * gx);
  float dz = 0.5f * (w * gz + x * gy - y * gx);

  if (!is_zero(ax, ay, az)) {
    const float scale = fast_inverse_sqrt(ax * ax + ay * ay + az * az);
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
    const float slope = fast_inverse_sqrt(s0 * s0 + s1 * s1 + s2 * s2 + s3 * s3);
    dw -= s->beta * (s0 * slope);
    dx -= s->beta * (s1 * slope);
    dy -= s->beta * (s2 * slope);
    dz -= s->beta * (s3 * slope);
  }

  s->qw += dw * dt;
  s->qx += dx * dt;
  s->qy += dy * dt;
  s->qz += dz * dt;
  normalize(s);
}

static float along_gravity(const cf_sensfusion6_t *s, float ax, float ay, float az) {
  return ax * s->gravX + ay * s->gravY + az * s->gravZ;
}

void cf_sensfusion6_update_q(cf_sensfusion6_t *fusion, float gx, float gy, float gz, float ax,
                             float ay, float az, float dt) {
  cf_sensfusion6_t *s = fusion;
  if (s->filter == CF_SENSFUSION6_MADGWICK) {
    madgwick(s, gx, gy, gz, ax, ay, az, dt);
  } else {
    mahony(s, gx, gy, gz, ax, ay, az, dt);
  }

  s->gravX = 2.0f * (s->qx * s->qz - s->qw * s->qy);
  s->gravY = 2.0f * (s->qw * s->qx + s->qy * s->qz);
  s->gravZ = s->qw * s->qw - s->qx * s->qx - s->qy * s->qy + s->qz * s->qz;

  if (s->isCalibrated == 0) {
    s->baseZacc     = along_gravity(s, ax, ay, az);
    s->isCalibrated = 1;
  }
}

void cf_sensfusion6_get_quaternion(const cf_sensfusion6_t *fusion, float *x, float *y, float *z,
                                   float *w) {
  *x = fusion->qx;
  *y = fusion->qy;
  *z = fusion->qz;
  *w = fusion->qw;
}

void cf_sensfusion6_get_euler_rpy(const cf_sensfusion6_t *fusion, float *roll, float *pitch,
                                  float *yaw) {
  const cf_sensfusion6_t *s = fusion;

  *yaw = atan2f(2.0f * (s->qw * s->qz + s->qx * s->qy),
                s->qw * s->qw + s->qx * s->qx - s->qy * s->qy - s->qz * s->qz) *
         180.0f / M_PI_F;
  *pitch =
      asinf(constrain(s->gravX, -1.0f, 1.0f)) * 180.0f / M_PI_F;  // legacy: positive lifts the nose
  *roll = atan2f(s->gravY, s->gravZ) * 180.0f / M_PI_F;
}

float cf_sensfusion6_get_acc_z_without_gravity(const cf_sensfusion6_t *fusion, float ax, float ay,
                                               float az) {
  return along_gravity(fusion, ax, ay, az) - fusion->baseZacc;
}

#define ROW(name, type, flags, member) \
  CF_ROW("sensfusion6", name, type, flags, cf_sensfusion6_t, member)

static const cf_variable_t PARAMETERS[] = {
    ROW("kp", FLOAT, CF_CORE | CF_PERSISTENT, twoKp),
    ROW("ki", FLOAT, CF_CORE | CF_PERSISTENT, twoKi),
    ROW("baseZacc", FLOAT, 0, baseZacc),
};

static const cf_variable_t LOGS[] = {
    ROW("qw", FLOAT, 0, qw),          ROW("qx", FLOAT, 0, qx),
    ROW("qy", FLOAT, 0, qy),          ROW("qz", FLOAT, 0, qz),
    ROW("gravityX", FLOAT, 0, gravX), ROW("gravityY", FLOAT, 0, gravY),
    ROW("gravityZ", FLOAT, 0, gravZ), ROW("accZbase", FLOAT, 0, baseZacc),
    ROW("isInit", UINT8, 0, isInit),  ROW("isCalibrated", UINT8, 0, isCalibrated),
};

cf_variables_t cf_sensfusion6_parameters(void) {
  return CF_TABLE(PARAMETERS);
}

cf_variables_t cf_sensfusion6_logs(void) {
  return CF_TABLE(LOGS);
}
