/* Collision avoidance: the checkout's law, with what stands around it on the vehicle. There it asks
 * the operating system for the time and another module for the peers; here both are given. */
#include "bitcraze/adapter.h"

#include <float.h>
#include <math.h>

#include "bitcraze/conversions.h"

#define BOX_ROWS 6
#define FLOATS_PER_ROW 7

// A client may ask for any number of sweeps; more than this would not fit into a millisecond.
#define MAX_SWEEPS 1000

cf_avoidance_t cf_avoidance = {
    .params =
        {
            .ellipsoidRadii             = {.x = 0.3f, .y = 0.3f, .z = 0.9f},
            .bboxMin                    = {.x = -FLT_MAX, .y = -FLT_MAX, .z = -FLT_MAX},
            .bboxMax                    = {.x = FLT_MAX, .y = FLT_MAX, .z = FLT_MAX},
            .horizonSecs                = 1.0f,
            .maxSpeed                   = 0.5f,
            .sidestepThreshold          = 0.25f,
            .maxPeerLocAgeMillis        = 5000,
            .voronoiProjectionTolerance = 1e-5f,
            .voronoiProjectionMaxIters  = 100,
        },
    .state = {.lastFeasibleSetPosition = {.x = NAN, .y = NAN, .z = NAN}},
};

#if CF_SYSTEM
// The parameter is that of the checkout's own half for the vehicle; its place is that of this copy.
bool cf_avoidance_is_enabled(const void *state CF_UNUSED) {
  static const uint8_t *enable CF_LIBRARY_KEEP = NULL;
  static bool is_known         CF_LIBRARY_KEEP = false;
  if (!is_known) {
    int type;
    enable   = cf_library_variable(0, "colAv", "enable", &type);
    is_known = enable != NULL;
  }
  return is_known && *enable != 0;
}
#else
bool cf_avoidance_is_enabled(const void *state CF_UNUSED) {
  return cf_avoidance.enable != 0;
}
#endif

static bool counts(const cf_peer_t *peer, int max_age, uint32_t now_ms) {
  return peer->id != 0 && (max_age < 0 || now_ms - peer->pos.timestamp <= (uint32_t)max_age);
}

void cf_avoidance_run(void *state CF_UNUSED, api_setpoint_t *setpoint, const cf_peer_t *peers,
                      const api_sensorData_t *sensors, const api_state_t *estimate,
                      uint32_t now_ms) {
  if (!cf_avoidance.enable) {
    return;
  }
  collision_avoidance_params_t params = cf_avoidance.params;
  if (params.voronoiProjectionMaxIters > MAX_SWEEPS) {
    params.voronoiProjectionMaxIters = MAX_SWEEPS;
  }

  // the positions are used up row by row while the cell is written over them
  float workspace[FLOATS_PER_ROW * (CF_PEERS + BOX_ROWS)];
  int   count = 0;
  for (int i = 0; i < CF_PEERS; i++) {
    if (counts(&peers[i], params.maxPeerLocAgeMillis, now_ms)) {
      workspace[3 * count]     = peers[i].pos.x;
      workspace[3 * count + 1] = peers[i].pos.y;
      workspace[3 * count + 2] = peers[i].pos.z;
      count++;
    }
  }

  setpoint_t bent;
  cf_checkout_setpoint(&bent, setpoint);
  const sensorData_t measured = cf_checkout_sensors(sensors);
  const state_t      is       = cf_checkout_state(estimate);
  collisionAvoidanceUpdateSetpointCore(&params, &cf_avoidance.state, count, workspace, workspace,
                                       &bent, &measured, &is);
  cf_api_setpoint(setpoint, &bent);
}
