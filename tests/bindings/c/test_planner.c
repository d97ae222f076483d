/* The planner and the high-level commander under the sanitizers: malformed definitions, times that
 * are no numbers, trajectories made of garbage. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "api/math3d.h"
#include "builtin/planning/planner.h"
#include "check.h"
#include "onboard/commander/commander.h"
#include "onboard/commander/high_level_commander.h"
#include "onboard/commander/rpyt.h"
#include "onboard/commander/setpoints.h"

#define COUNT(array_) (sizeof(array_) / sizeof((array_)[0]))

static int takeoff(void *state, const cf_plan_start_t *from, float height, float yaw,
                   float duration, float t) {
  return cf_planner_takeoff(state, from, height, yaw, duration, t);
}

static int land(void *state, const cf_plan_start_t *from, float height, float yaw, float duration,
                float t) {
  return cf_planner_land(state, from, height, yaw, duration, t);
}

static int go_to(void *state, const uint8_t *memory, const cf_plan_start_t *from, bool relative,
                 bool linear, struct vec goal, float yaw, float duration, float t) {
  return cf_planner_go_to(state, memory, from, relative, linear, goal, yaw, duration, t);
}

static int spiral(void *state, const cf_plan_start_t *from, const cf_spiral_t *wanted, float t) {
  return cf_planner_spiral(state, from, wanted, t);
}

static int start_trajectory(void *state, const uint8_t *memory,
                            const cf_uploaded_trajectory_t *trajectory, const cf_plan_start_t *from,
                            float t) {
  return cf_planner_start_trajectory(state, memory, trajectory, from, t);
}

static void stop(void *state) {
  cf_planner_stop(state);
}

static void disable(void *state) {
  cf_planner_disable(state);
}

static bool is_stopped(const void *state) {
  return cf_planner_is_stopped(state);
}

static bool is_disabled(const void *state) {
  return cf_planner_is_disabled(state);
}

static bool is_finished(const void *state, const uint8_t *memory, float t) {
  return cf_planner_is_finished(state, memory, t);
}

static int plan_state(const void *state) {
  return cf_planner_state(state);
}

static struct traj_eval current_goal(void *state, const uint8_t *memory, float t) {
  return cf_planner_current_goal(state, memory, t);
}

static const cf_provider_t PROVIDER = {
    .name                  = "planner only",
    .state_bytes           = sizeof(cf_planner_t),
    .plan_takeoff          = takeoff,
    .plan_land             = land,
    .plan_go_to            = go_to,
    .plan_spiral           = spiral,
    .plan_start_trajectory = start_trajectory,
    .plan_stop             = stop,
    .plan_disable          = disable,
    .plan_is_stopped       = is_stopped,
    .plan_is_disabled      = is_disabled,
    .plan_is_finished      = is_finished,
    .plan_state            = plan_state,
    .plan_current_goal     = current_goal,
};

static const float    HOSTILE[] = {NAN,     INFINITY, -INFINITY, FLT_MAX, -FLT_MAX,
                                   FLT_MIN, 1e-45f,   0.0f,      -0.0f,   -1.0f,
                                   1.0f,    1e-20f,   1e20f,     3.0e9f,  -3.0e9f};
static const uint64_t TIMES[]   = {0, 1, 1000000, UINT32_MAX, UINT64_MAX};

typedef struct {
  cf_planner_t              planner;
  cf_high_level_commander_t commander;
} vehicle_t;

static void init(vehicle_t *vehicle) {
  memset(vehicle, 0xa5, sizeof *vehicle);
  cf_planner_init(&vehicle->planner);
  cf_high_level_commander_init(&vehicle->commander);
}

// Asks for setpoints at all times, whatever is planned.
static void fly(vehicle_t *vehicle) {
  const state_t estimate = {.position = {.z = 1.0f}};
  setpoint_t    setpoint;
  for (size_t i = 0; i < COUNT(TIMES); i++) {
    (void)cf_high_level_commander_get_setpoint(&vehicle->commander, &PROVIDER, &vehicle->planner,
                                               &estimate, 10, TIMES[i], &setpoint);
    (void)cf_high_level_commander_is_trajectory_finished(&vehicle->commander, &PROVIDER,
                                                         &vehicle->planner, TIMES[i]);
  }
}

// Every command with hostile numbers: refused when not finite, and never worse than a bad plan.
static void test_commands(float a, float b) {
  vehicle_t vehicle;
  init(&vehicle);
  cf_high_level_commander_t *c = &vehicle.commander;
  cf_planner_t              *p = &vehicle.planner;

  const bool  good   = isfinite(a) && isfinite(b) && b > 0.0f;
  cf_status_t status = cf_high_level_commander_takeoff(c, &PROVIDER, p, a, b, 0.0f, true, 0);
  CHECK(status == (good ? CF_OK : CF_ERR_VALUE));
  fly(&vehicle);

  status = cf_high_level_commander_land(c, &PROVIDER, p, a, b, 0.0f, true, 0);
  CHECK(good ? status != CF_ERR_VALUE : status == CF_ERR_VALUE);
  fly(&vehicle);

  status = cf_high_level_commander_go_to(c, &PROVIDER, p, (struct vec){a, a, a}, a, b, true, true,
                                         UINT64_MAX);
  CHECK(status == (good ? CF_OK : CF_ERR_VALUE));
  fly(&vehicle);

  c->pos.z = a;
  (void)cf_high_level_commander_takeoff_with_velocity(c, &PROVIDER, p, a, true, b, b, false, 0);
  (void)cf_high_level_commander_land_with_velocity(c, &PROVIDER, p, b, true, a, a, false, 0);
  fly(&vehicle);
}

// A memory full of one number is a trajectory as well.
static void test_garbage_trajectory(float number, float timescale, bool reversed) {
  vehicle_t vehicle;
  init(&vehicle);
  cf_high_level_commander_t *c = &vehicle.commander;

  float words[CF_TRAJECTORY_MEMORY_BYTES / sizeof(float)];
  for (size_t i = 0; i < COUNT(words); i++) {
    words[i] = number;
  }
  CHECK(cf_high_level_commander_write_trajectory(c, 0, sizeof words, (const uint8_t *)words) ==
        CF_OK);
  CHECK(cf_high_level_commander_define_trajectory(c, 30, CF_TRAJECTORY_TYPE_POLY4D, 4, 31) ==
        CF_OK);

  const bool        good   = isfinite(timescale) && timescale > 0.0f;
  const cf_status_t status = cf_high_level_commander_start_trajectory(
      c, &PROVIDER, &vehicle.planner, 30, timescale, true, true, reversed, 0);
  CHECK(status == (good ? CF_OK : CF_ERR_VALUE));
  fly(&vehicle);

  // the planner itself takes any timescale
  const cf_uploaded_trajectory_t trajectory = {
      .offset = 4, .n_pieces = 31, .timescale = timescale, .reversed = reversed};
  const cf_plan_start_t from = {.yaw = number};
  CHECK(cf_planner_start_trajectory(&vehicle.planner, c->memory, &trajectory, &from, number) == 0);
  fly(&vehicle);
}

static void test_definitions(void) {
  static const uint32_t OFFSETS[] = {
      0, 1, 2, 4, 3960, 3964, 3965, 3968, 4092, 4096, UINT32_MAX, UINT32_MAX - 3, UINT32_MAX - 131};
  vehicle_t vehicle;
  init(&vehicle);
  for (size_t i = 0; i < COUNT(OFFSETS); i++) {
    for (int n = 0; n <= UINT8_MAX; n++) {
      for (int id = 29; id <= 33; id++) {
        const bool        fits   = id < 31 && n > 0 && OFFSETS[i] % 4 == 0 &&
                                   OFFSETS[i] + 132ull * (unsigned)n <= CF_TRAJECTORY_MEMORY_BYTES;
        const cf_status_t status = cf_high_level_commander_define_trajectory(
            &vehicle.commander, (uint8_t)id, CF_TRAJECTORY_TYPE_POLY4D, OFFSETS[i], (uint8_t)n);
        CHECK((status == CF_OK) == fits);
        if (fits) {
          CHECK(cf_high_level_commander_start_trajectory(&vehicle.commander, &PROVIDER,
                                                         &vehicle.planner, (uint8_t)id, 1.0f, true,
                                                         true, false, 0) == CF_OK);
          fly(&vehicle);
        }
      }
    }
  }
}

// The functions of pptraj with whatever a test bench may pass.
static void test_pptraj(float a, float b) {
  struct poly4d piece = poly4d_zero(a);
  for (int axis = 0; axis < 4; axis++) {
    for (int k = 0; k < PP_SIZE; k++) {
      piece.p[axis][k] = b;
    }
  }
  (void)poly4d_eval(&piece, a);
  if (fabsf(a) < 1e6f) {
    (void)poly4d_max_accel_approx(&piece);
  }
  polystretchtime(piece.p[0], a);
  polybezier(piece.p[1], a, (const float[]){a, b, a, b, a, b, a, b}, 8);
  poly5(piece.p[2], a, b, b, b, b, b, b);
  (void)normalize_radians(a);
  (void)shortest_signed_angle_radians(a, b);
}

static void test_setpoints(float a, float b) {
  setpoint_t setpoint = {.timestamp = 0};
  cf_rpyt_t  rpyt;
  cf_rpyt_init(&rpyt);
  const cf_status_t expected = isfinite(a) && isfinite(b) ? CF_OK : CF_ERR_VALUE;
  CHECK(cf_setpoint_velocity_world(&setpoint, a, b, a, b) == expected);
  CHECK(cf_setpoint_zdistance(&setpoint, a, b, a, b) == expected);
  CHECK(cf_setpoint_altitude_hold(&setpoint, a, b, a, b) == expected);
  CHECK(cf_setpoint_hover(&setpoint, a, b, a, b) == expected);
  CHECK(cf_setpoint_position(&setpoint, a, b, a, b) == expected);
  CHECK(cf_setpoint_manual(&setpoint, a, b, a, UINT16_MAX, true) == expected);
  CHECK(cf_setpoint_rpyt(&setpoint, &rpyt, 2, a, b, a, UINT16_MAX) == expected);
}

int main(void) {
  for (size_t i = 0; i < COUNT(HOSTILE); i++) {
    for (size_t j = 0; j < COUNT(HOSTILE); j++) {
      test_commands(HOSTILE[i], HOSTILE[j]);
      test_garbage_trajectory(HOSTILE[i], HOSTILE[j], j % 2 == 0);
      test_pptraj(HOSTILE[i], HOSTILE[j]);
      test_setpoints(HOSTILE[i], HOSTILE[j]);
    }
  }
  test_definitions();

  // the loop of samples is bounded for absurd durations
  const struct poly4d endless = poly4d_zero(FLT_MAX);
  CHECK(poly4d_max_accel_approx(&endless) == 0.0f);
  return 0;
}
