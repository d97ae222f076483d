/* The controllers of Mellinger and Lee, and the small mathematics below them, under extreme inputs:
 * nothing undefined, nothing out of range, nothing endless. */
#include <math.h>
#include <stdlib.h>

#include "api/controller_lee.h"
#include "api/controller_mellinger.h"
#include "api/math3d.h"
#include "builtin/control/controller_lee.h"
#include "builtin/control/controller_mellinger.h"
#include "builtin/power/power_distribution.h"
#include "check.h"

static const float EXTREMES[] = {
    0.0f,     -0.0f,    1.0f,      -1.0f,         0.7071068f,     9.81f,  -9.81f, 180.0f, 540.0f,
    32767.0f, 999.9f,   65535.0f,  2147483520.0f, -2147483904.0f, 1e-45f, 1e-30f, 1e20f,  3.4e38f,
    -3.4e38f, INFINITY, -INFINITY, NAN,
};
#define EXTREME_COUNT ((int)(sizeof(EXTREMES) / sizeof(EXTREMES[0])))

// a small generator, so that the test needs no clock and no library
static uint32_t next_random(uint32_t *seed) {
  *seed = *seed * 1664525u + 1013904223u;
  return *seed >> 8;
}

// every fourth number is extreme, the others are those of a calm flight
static float random_number(uint32_t *seed) {
  if (next_random(seed) % 4u == 0u) {
    return EXTREMES[next_random(seed) % (uint32_t)EXTREME_COUNT];
  }
  return (float)(next_random(seed) % 2001u) / 1000.0f - 1.0f;
}

static struct vec random_vec(uint32_t *seed) {
  return mkvec(random_number(seed), random_number(seed), random_number(seed));
}

static struct quat random_quat(uint32_t *seed) {
  return quatvw(random_vec(seed), random_number(seed));
}

static vector_t random_vector(uint32_t *seed) {
  return (vector_t){.x = random_number(seed), .y = random_number(seed), .z = random_number(seed)};
}

static attitude_t random_attitude(uint32_t *seed) {
  return (attitude_t){
      .roll = random_number(seed), .pitch = random_number(seed), .yaw = random_number(seed)};
}

static quaternion_t random_quaternion(uint32_t *seed) {
  return (quaternion_t){.x = random_number(seed),
                        .y = random_number(seed),
                        .z = random_number(seed),
                        .w = random_number(seed)};
}

static stab_mode_t random_mode(uint32_t *seed) {
  return (stab_mode_t)(next_random(seed) % 3u);
}

static setpoint_t random_setpoint(uint32_t *seed) {
  return (setpoint_t){
      .attitude           = random_attitude(seed),
      .attitudeRate       = random_attitude(seed),
      .attitudeQuaternion = random_quaternion(seed),
      .thrust             = 30000.0f * random_number(seed),
      .position           = random_vector(seed),
      .velocity           = random_vector(seed),
      .acceleration       = random_vector(seed),
      .jerk               = random_vector(seed),
      .mode =
          {
              .x     = random_mode(seed),
              .y     = random_mode(seed),
              .z     = random_mode(seed),
              .roll  = random_mode(seed),
              .pitch = random_mode(seed),
              .yaw   = random_mode(seed),
              .quat  = random_mode(seed),
          },
  };
}

static state_t random_state(uint32_t *seed) {
  return (state_t){.attitude           = random_attitude(seed),
                   .attitudeQuaternion = random_quaternion(seed),
                   .position           = random_vector(seed),
                   .velocity           = random_vector(seed)};
}

static sensorData_t random_sensors(uint32_t *seed) {
  return (sensorData_t){
      .gyro = {.axis = {random_number(seed), random_number(seed), random_number(seed)}},
      .acc  = {.axis = {0.0f, 0.0f, random_number(seed)}},
  };
}

// whatever a controller says, the motors get a duty
static void check_motors(const cf_power_distribution_t *power, const control_t *control) {
  motors_thrust_uncapped_t uncapped = {{0}};
  motors_thrust_pwm_t      pwm;
  cf_power_distribution_update(power, control, &uncapped);
  cf_power_distribution_cap(power, &uncapped, &pwm);
  for (int i = 0; i < 4; i++) {
    CHECK(pwm.list[i] >= cf_power_distribution_idle_thrust(power));
  }
}

static void test_controllers_with_extremes(void) {
  uint32_t seed = 1;
  for (int round = 0; round < 400; round++) {
    const cf_platform_t     platform = (cf_platform_t)(round % 2);
    controllerMellinger_t   mellinger;
    controllerLee_t         lee;
    cf_power_distribution_t power;
    CHECK(cf_controller_mellinger_init(&mellinger, platform) == CF_OK);
    CHECK(cf_controller_lee_init(&lee, platform) == CF_OK);
    CHECK(cf_power_distribution_init(&power, platform) == CF_OK);

    control_t control = {.controlMode = controlModeLegacy};
    for (stabilizerStep_t step = 1; step < 60; step++) {
      const setpoint_t   setpoint = random_setpoint(&seed);
      const state_t      state    = random_state(&seed);
      const sensorData_t sensors  = random_sensors(&seed);

      controllerMellinger(&mellinger, &control, &setpoint, &sensors, &state, step);
      CHECK(control.controlMode == controlModeLegacy);
      if (step % 2u == 0u) {
        CHECK(abs(control.roll) <= 32000);
        CHECK(abs(control.pitch) <= 32000);
        CHECK(abs(control.yaw) <= 32000);
      }
      check_motors(&power, &control);

      controllerLee(&lee, &control, &setpoint, &sensors, &state, step);
      CHECK(step % 2u != 0u || control.controlMode == controlModeForceTorque);
      check_motors(&power, &control);
    }
  }
}

// gains are parameters, so that anything may stand there
static void test_controllers_with_extreme_gains(void) {
  uint32_t seed = 2;
  for (int round = 0; round < 400; round++) {
    controllerMellinger_t mellinger;
    controllerLee_t       lee;
    controllerMellingerInit(&mellinger);
    controllerLeeInit(&lee);
    mellinger.massThrust        = random_number(&seed);
    mellinger.kR_xy             = random_number(&seed);
    mellinger.kd_omega_rp       = random_number(&seed);
    mellinger.i_range_xy        = random_number(&seed);
    mellinger.i_range_m_z       = random_number(&seed);
    lee.mass                    = random_number(&seed);
    lee.Kpos_P_limit            = random_number(&seed);
    lee.KR                      = random_vec(&seed);
    lee.J                       = random_vec(&seed);
    const setpoint_t   setpoint = random_setpoint(&seed);
    const state_t      state    = random_state(&seed);
    const sensorData_t sensors  = random_sensors(&seed);

    control_t control = {.controlMode = controlModeLegacy};
    controllerMellinger(&mellinger, &control, &setpoint, &sensors, &state, 2);
    CHECK(abs(control.yaw) <= 32000);
    controllerLee(&lee, &control, &setpoint, &sensors, &state, 2);
    CHECK(control.controlMode == controlModeForceTorque);
  }
}

static void test_a_poisoned_lee_shows_it_and_recovers(void) {
  controllerLee_t lee;
  controllerLeeInit(&lee);
  const setpoint_t   hover    = {.mode = {.x = modeAbs, .y = modeAbs, .z = modeAbs}};
  const setpoint_t   null     = {.thrust = 0.0f};
  const sensorData_t sensors  = {.acc = {.axis = {0.0f, 0.0f, 1.0f}}};
  const state_t      good     = {.attitudeQuaternion = {.w = 1.0f}};
  const state_t      poisoned = {.attitudeQuaternion = {.x = NAN, .w = 1.0f}};

  control_t control = {.controlMode = controlModeLegacy};
  controllerLee(&lee, &control, &hover, &sensors, &poisoned, 2);
  CHECK(isnan(control.thrustSi));
  controllerLee(&lee, &control, &null, &sensors, &good, 4);
  controllerLee(&lee, &control, &hover, &sensors, &good, 6);
  CHECK(isfinite(control.thrustSi + control.torqueX + control.torqueY + control.torqueZ));
}

static void test_math_with_extremes(void) {
  uint32_t seed = 3;
  for (int round = 0; round < 2000; round++) {
    const struct vec  v = random_vec(&seed);
    const struct quat q = random_quat(&seed);
    const struct quat p = random_quat(&seed);
    const float       t = random_number(&seed);
    volatile float    sink;
    sink = qvrot(qqmul(q, qnormalize(p)), vnormalize(v)).x;
    sink = qslerp(q, p, t).w + qnlerp(q, p, t).w + quat2angle(q) + qanglebetween(q, p);
    sink = quat2rpy(mat2quat(quat2rotmat(q))).y + rpy2quat(v).x + rpy2quat_small(v).x;
    sink = qaxisangle(v, t).z + qvectovec(v, quat2axis(q)).w + maxisangle(v, t).m[0][1];
    sink = vclampnorm(v, t).x + clamp(t, -1.0f, 1.0f);
    (void)sink;
    CHECK(fcloseulps(t, t, 0));
  }
  // the two zeros are as many floats apart as an int32 cannot count
  CHECK(!fcloseulps(-0.0f, 0.0f, INT32_MAX));
}

static void test_polytopes_with_extremes(void) {
  uint32_t seed = 4;
  for (int round = 0; round < 2000; round++) {
    float A[12];
    float b[4];
    float work[12];
    for (int i = 0; i < 12; i++) {
      A[i] = random_number(&seed);
    }
    for (int i = 0; i < 4; i++) {
      b[i] = random_number(&seed);
    }
    int row = 7;
    rayintersectpolytope(random_vec(&seed), random_vec(&seed), A, b, 4, &row);
    CHECK(row >= -1 && row < 4);
    vprojectpolytope(random_vec(&seed), A, b, work, 4, random_number(&seed), 100);
  }
}

int main(void) {
  test_controllers_with_extremes();
  test_controllers_with_extreme_gains();
  test_a_poisoned_lee_shows_it_and_recovers();
  test_math_with_extremes();
  test_polytopes_with_extremes();
  return 0;
}
