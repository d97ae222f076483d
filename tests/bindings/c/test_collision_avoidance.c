/* Collision avoidance, the table of peers and the grid of neighbors under the sanitizers: peers,
 * parameters and setpoints that are no numbers, and a drone that is told of them. */
#include "builtin/planning/collision_avoidance.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <string.h>

#include "api/math3d.h"
#include "check.h"
#include "commands.h"
#include "crazyflie.h"
#include "mujoco_plugin/peer_grid.h"

#define COUNT(array_) (sizeof(array_) / sizeof((array_)[0]))

static const float HOSTILE[] = {NAN,    INFINITY, -INFINITY, FLT_MAX, -FLT_MAX, FLT_MIN,
                                1e-45f, 0.0f,     -0.0f,     1.0f,    -1.0f,    1e20f,
                                1e-20f, 1e4f,     -1e4f,     2e9f,    -3e9f,    0.3f};
static const int   SWEEPS[]  = {INT_MIN, -1, 0, 1, 100, INT_MAX};
static const int   AGES[]    = {INT_MIN, -1, 0, 5000, INT_MAX};

// A table full of one position and its neighborhood.
static void fill(cf_peer_t *peers, float a, float b) {
  for (int i = 0; i < PEER_LOCALIZATION_MAX_NEIGHBORS; i++) {
    peers[i] = (cf_peer_t){
        .id  = (uint8_t)(i % 4),
        .pos = {.timestamp = i % 2 == 0 ? 0u : UINT32_MAX,
                .x         = i % 3 == 0 ? a : 0.1f * (float)i,
                .y         = i % 3 == 1 ? b : -0.1f * (float)i,
                .z         = i % 3 == 2 ? a : 1.0f},
    };
  }
}

static bool is_finite_setpoint(const setpoint_t *s) {
  return isfinite(s->position.x) && isfinite(s->position.y) && isfinite(s->position.z) &&
         isfinite(s->velocity.x) && isfinite(s->velocity.y) && isfinite(s->velocity.z);
}

// Whatever is told about peers, a sane drone is asked for something sane.
static void test_peers(float a, float b) {
  cf_collision_avoidance_t avoidance;
  cf_peer_t                peers[PEER_LOCALIZATION_MAX_NEIGHBORS];
  const state_t            estimate = {.position = {.x = 0.2f, .z = 1.0f}};
  const stab_mode_t        modes[]  = {modeDisable, modeAbs, modeVelocity};
  const uint32_t           times[]  = {0, 1, 5001, UINT32_MAX};
  cf_collision_avoidance_init(&avoidance);
  avoidance.enable = 1;
  fill(peers, a, b);
  for (size_t m = 0; m < COUNT(modes); m++) {
    for (size_t t = 0; t < COUNT(times); t++) {
      setpoint_t setpoint = {.mode.x = modes[m], .position = {.x = 2.0f}, .velocity = {.y = 1.0f}};
      cf_collision_avoidance_update(&avoidance, &setpoint, peers, PEER_LOCALIZATION_MAX_NEIGHBORS,
                                    NULL, &estimate, times[t]);
      CHECK(is_finite_setpoint(&setpoint));
    }
  }
}

// With parameters, setpoints and estimates as bad, nothing crashes and every loop ends.
static void test_parameters(float a, float b) {
  cf_collision_avoidance_t avoidance;
  cf_peer_t                peers[PEER_LOCALIZATION_MAX_NEIGHBORS];
  fill(peers, b, a);
  for (size_t i = 0; i < COUNT(SWEEPS); i++) {
    cf_collision_avoidance_init(&avoidance);
    avoidance.enable                            = UINT8_MAX;
    avoidance.params.ellipsoidRadii.x           = a;
    avoidance.params.ellipsoidRadii.z           = b;
    avoidance.params.bboxMin.y                  = b;
    avoidance.params.bboxMax.y                  = a;
    avoidance.params.horizonSecs                = b;
    avoidance.params.maxSpeed                   = a;
    avoidance.params.sidestepThreshold          = a;
    avoidance.params.voronoiProjectionTolerance = b;
    avoidance.params.voronoiProjectionMaxIters  = SWEEPS[i];
    avoidance.params.maxPeerLocAgeMillis        = AGES[i % COUNT(AGES)];
    avoidance.state.lastFeasibleSetPosition.x   = b;
    const state_t estimate                      = {.position = {.x = a, .y = b}};
    setpoint_t    setpoint                      = {.mode.x   = modeAbs,
                                                   .position = {.x = b, .y = a, .z = b},
                                                   .velocity = {.x = a, .y = b, .z = a}};
    cf_collision_avoidance_update(&avoidance, &setpoint, peers, PEER_LOCALIZATION_MAX_NEIGHBORS,
                                  NULL, &estimate, 7);
    setpoint.mode.x = modeVelocity;
    cf_collision_avoidance_update(&avoidance, &setpoint, peers, INT_MAX, NULL, &estimate, 7);
    cf_collision_avoidance_update(&avoidance, &setpoint, NULL, 0, NULL, &estimate, 7);
    cf_collision_avoidance_update(&avoidance, &setpoint, NULL, -1, NULL, &estimate, 7);
  }
}

static void test_no_rows(float a) {
  float            none[1] = {0.0f};
  const struct vec v       = {a, a, a};
  CHECK(vinpolytope(v, none, none, 0, a));
  CHECK(isinf(rayintersectpolytope(v, v, none, none, 0, NULL)));
  const struct vec same = vprojectpolytope(v, none, none, none, 0, 1e-5f, 100);
  CHECK(memcmp(&same, &v, sizeof v) == 0);
}

// ------------------------------------------------------------------------------ table and grid

static void test_grid(float a, float b) {
  cf_peer_grid_t  grid;
  cf_seen_drone_t nearest[CF_PEER_GRID_MAX];
  CHECK(cf_peer_grid_new(&grid, 40));
  for (int again = 0; again < 2; again++) {
    cf_peer_grid_clear(&grid);
    for (int i = 0; i < 50; i++) {
      const float position[3] = {i % 3 == 0 ? a : 0.5f * (float)i, i % 5 == 0 ? b : -0.5f, 1.0f};
      cf_peer_grid_add(&grid, i, position);
    }
    cf_peer_grid_sort(&grid);
    CHECK(grid.count <= grid.capacity);
    const float at[3] = {a, b, 0.0f};
    for (int most = -1; most <= CF_PEER_GRID_MAX + 1; most++) {
      const int count = cf_peer_grid_nearest(&grid, at, 3, nearest, most);
      CHECK(count >= 0 && count <= (most > 0 ? most : 0) && count <= CF_PEER_GRID_MAX);
      for (int k = 0; k < count; k++) {
        CHECK(nearest[k].index != 3 && nearest[k].index < 50);
      }
    }
  }
  cf_peer_grid_free(&grid);
}

static void test_a_grid_of_one(void) {
  cf_peer_grid_t  grid;
  cf_seen_drone_t nearest[1];
  const float     here[3] = {0.0f, 0.0f, 0.0f};
  CHECK(cf_peer_grid_new(&grid, 1));
  cf_peer_grid_clear(&grid);
  cf_peer_grid_add(&grid, 0, here);
  cf_peer_grid_add(&grid, 1, here);
  cf_peer_grid_sort(&grid);
  CHECK(cf_peer_grid_nearest(&grid, here, 0, nearest, 1) == 0);
  CHECK(cf_peer_grid_nearest(&grid, here, -1, nearest, 1) == 1);
  cf_peer_grid_free(&grid);
}

// --------------------------------------------------------------------------------- a whole drone

static const cf_motion_t AT_REST = {.position       = {0.0f, 0.0f, 0.0145f},
                                    .quat_wxyz      = {1.0f, 0.0f, 0.0f, 0.0f},
                                    .rotation       = {1, 0, 0, 0, 1, 0, 0, 0, 1},
                                    .specific_force = {0.0f, 0.0f, 9.81f}};

static cf_collision_avoidance_t *avoidance_of(cf_t *cf) {
  cf_variables_t tables[CF_PROVIDER_MAX_TABLES];
  const int      count = cf_provider(0)->parameters(tables, CF_PROVIDER_MAX_TABLES);
  for (int i = 0; i < count; i++) {
    if (strcmp(tables[i].rows[0].group, "colAv") == 0) {
      return (cf_collision_avoidance_t *)((char *)cf->provider_state + tables[i].base);
    }
  }
  return NULL;
}

static void ready(cf_t *cf) {
  cf_config_t config;
  CHECK(cf_config_default(&config, CF_PLATFORM_CF2) == CF_OK);
  CHECK(cf_init(cf, &config) == CF_OK);
  for (int i = 0; i < 2000; i++) {
    cf_tick(cf, &AT_REST);
  }
}

static void test_a_drone_asks_for_peers_while_it_avoids_them(void) {
  static cf_t cf;
  ready(&cf);
  CHECK(!cf.wants_peers);
  avoidance_of(&cf)->enable = 1;
  cf_tick(&cf, &AT_REST);
  CHECK(cf.wants_peers);
  cf_reboot(&cf);
  CHECK(!cf.wants_peers);
}

static void test_peers_of_a_client(void) {
  static cf_t cf;
  ready(&cf);
  const float bad[] = {NAN, INFINITY, -INFINITY};
  for (size_t k = 0; k < COUNT(bad); k++) {
    CHECK(cf_send_peer_position(&cf, 1, bad[k], 0.0f, 0.0f) == CF_ERR_VALUE);
    CHECK(cf_send_peer_position(&cf, 1, 0.0f, bad[k], 0.0f) == CF_ERR_VALUE);
    CHECK(cf_send_peer_position(&cf, 1, 0.0f, 0.0f, bad[k]) == CF_ERR_VALUE);
  }
  CHECK(cf_send_peer_position(&cf, 0, 1.0f, 2.0f, 3.0f) == CF_ERR_VALUE);
  for (int id = 1; id <= PEER_LOCALIZATION_MAX_NEIGHBORS; id++) {
    CHECK(cf_send_peer_position(&cf, (uint8_t)id, 1.0f, 2.0f, 3.0f) == CF_OK);
  }
  CHECK(cf_send_peer_position(&cf, 200, 1.0f, 2.0f, 3.0f) == CF_ERR_CAPACITY);
  CHECK(cf_send_peer_position(&cf, 10, 4.0f, 5.0f, 6.0f) == CF_OK);
  CHECK(cf_peer_localization_by_id(&cf.onboard.peers, 10)->pos.timestamp == cf.onboard.tick);
  cf_reboot(&cf);
  CHECK(!cf_peer_localization_is_id_active(&cf.onboard.peers, 10));
}

// The setpoint is bent before the supervisor overrides it, and only what the loop holds: what the
// commander has stored stays.
static void test_the_loop_bends_its_own_copy(void) {
  static cf_t cf;
  ready(&cf);
  avoidance_of(&cf)->enable = 1;
  CHECK(cf_send_position(&cf, 2.0f, 0.0f, 0.3f, 0.0f) == CF_OK);
  cf_tick(&cf, &AT_REST);
  CHECK(cf.onboard.setpoint.position.x < 0.6f);
  setpoint_t stored;
  cf_commander_get_setpoint(&cf.onboard.commander, &stored);
  CHECK(stored.position.x == 2.0f);

  avoidance_of(&cf)->enable = 0;
  cf_tick(&cf, &AT_REST);
  CHECK(cf.onboard.setpoint.position.x == 2.0f);
}

static void test_a_drone_survives_what_it_is_told(float a, float b) {
  static cf_t cf;
  cf_peer_t   peers[PEER_LOCALIZATION_MAX_NEIGHBORS];
  fill(peers, a, b);
  ready(&cf);
  avoidance_of(&cf)->enable = 1;
  CHECK(cf_send_position(&cf, 1.0f, 0.0f, 0.5f, 0.0f) == CF_OK);
  for (int i = 0; i < 50; i++) {
    cf_tell_peers(&cf, peers, PEER_LOCALIZATION_MAX_NEIGHBORS);
    cf_tick(&cf, &AT_REST);
  }
  CHECK(cf.onboard.fault == CF_FAULT_NONE);
  cf_tell_peers(&cf, peers, 0);
  cf_tell_peers(&cf, NULL, -1);
}

int main(void) {
  for (size_t i = 0; i < COUNT(HOSTILE); i++) {
    for (size_t j = 0; j < COUNT(HOSTILE); j++) {
      test_peers(HOSTILE[i], HOSTILE[j]);
      test_parameters(HOSTILE[i], HOSTILE[j]);
      test_grid(HOSTILE[i], HOSTILE[j]);
    }
    test_no_rows(HOSTILE[i]);
    test_a_drone_survives_what_it_is_told(HOSTILE[i], HOSTILE[COUNT(HOSTILE) - 1 - i]);
  }
  test_a_grid_of_one();
  test_a_drone_asks_for_peers_while_it_avoids_them();
  test_peers_of_a_client();
  test_the_loop_bends_its_own_copy();
  return 0;
}
