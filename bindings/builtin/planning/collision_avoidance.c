#include "builtin/planning/collision_avoidance.h"

#include <float.h>
#include <math.h>

#include "api/math3d.h"
#include "variable_row.h"

#define BOX_ROWS 6
#define FLOATS_PER_ROW 7  // normal (3), distance (1), scratch of the projection (3)

// The cell around the drone, in coordinates relative to its position; its arrays lie in the
// caller's workspace.
typedef struct {
  const collision_avoidance_params_t *params;

  int    rows;
  float *normals;
  float *distances;
  float *scratch;
} cell_t;

static bool is_inside(const cell_t *cell, struct vec v) {
  const float tolerance = 10.0f * cell->params->voronoiProjectionTolerance;
  return vinpolytope(v, cell->normals, cell->distances, cell->rows, tolerance);
}

static struct vec project(const cell_t *cell, struct vec v) {
  return vprojectpolytope(v, cell->normals, cell->distances, cell->scratch, cell->rows,
                          cell->params->voronoiProjectionTolerance,
                          cell->params->voronoiProjectionMaxIters);
}

static float ray(const cell_t *cell, struct vec origin, struct vec direction) {
  return rayintersectpolytope(origin, direction, cell->normals, cell->distances, cell->rows, NULL);
}

static void add_row(cell_t *cell, struct vec normal, float distance) {
  float *row                    = cell->normals + 3 * cell->rows;
  row[0]                        = normal.x;
  row[1]                        = normal.y;
  row[2]                        = normal.z;
  cell->distances[cell->rows++] = distance;
}

// Half-way to the peer in a space where the ellipsoids are spheres of radius 1, then one radius
// back. Negative when the drone already stands within that margin.
static void add_peer(cell_t *cell, struct vec inverse_radii, struct vec own, struct vec peer) {
  const struct vec u     = veltmul(vsub(peer, own), inverse_radii);
  const float      d     = vmag(u);
  const struct vec a     = vdiv(veltmul(u, inverse_radii), d);
  const float      b     = d / 2.0f - 1.0f;
  const float      scale = 1.0f / vmag(a);
  add_row(cell, vscl(scale, a), scale * b);
}

// No farther than the drone may fly within the horizon, and not out of the box.
static void add_box(cell_t *cell, struct vec own) {
  const collision_avoidance_params_t *params = cell->params;

  const float      reach = params->horizonSecs * params->maxSpeed;
  const struct vec high  = vsub(params->bboxMax, own);
  const struct vec low   = vsub(params->bboxMin, own);
  add_row(cell, mkvec(1.0f, 0.0f, 0.0f), fminf(reach, high.x));
  add_row(cell, mkvec(0.0f, 1.0f, 0.0f), fminf(reach, high.y));
  add_row(cell, mkvec(0.0f, 0.0f, 1.0f), fminf(reach, high.z));
  add_row(cell, mkvec(-1.0f, 0.0f, 0.0f), -fmaxf(-reach, low.x));
  add_row(cell, mkvec(0.0f, -1.0f, 0.0f), -fmaxf(-reach, low.y));
  add_row(cell, mkvec(0.0f, 0.0f, -1.0f), -fmaxf(-reach, low.z));
}

// The goal, brought into the cell. Close to a wall it is first turned to the right, so that drones
// that meet head-on pass each other.
static struct vec sidestep(const cell_t *cell, struct vec goal, bool modify_if_inside) {
  const float steps = ray(cell, vzero(), goal);
  if (steps >= 1.0f && !modify_if_inside) {
    return goal;
  }
  const float threshold = cell->params->sidestepThreshold;
  const float to_wall   = steps * vmag(goal);
  if (to_wall <= threshold) {
    const float      urgency = 1.0f - to_wall / threshold;
    const struct vec right   = vcross(goal, mkvec(0.0f, 0.0f, 1.0f));
    goal                     = vadd(goal, vscl(urgency * urgency, right));
  }
  return project(cell, goal);
}

static struct vec bend_velocity(const cell_t *cell, struct vec velocity) {
  const collision_avoidance_params_t *params = cell->params;
  if (!is_inside(cell, vzero())) {
    // too close to another drone: leave the margin, whatever velocity the setpoint has
    const struct vec way_out = project(cell, vzero());
    return is_inside(cell, way_out) ? vclampnorm(way_out, params->maxSpeed) : vzero();
  }
  const struct vec goal = sidestep(cell, vscl(params->horizonSecs, velocity), true);
  return is_inside(cell, goal) ? vdiv(goal, params->horizonSecs) : vzero();
}

static bool is_equal(struct vec a, struct vec b) {
  return a.x == b.x && a.y == b.y && a.z == b.z;
}

static void bend_position(const cell_t *cell, const collision_avoidance_state_t *memory,
                          struct vec own, struct vec *position, struct vec *velocity) {
  const struct vec goal = vsub(*position, own);
  const struct vec near = sidestep(cell, goal, false);
  if (!is_inside(cell, near)) {
    *velocity = vzero();
    *position = visnan(memory->lastFeasibleSetPosition) ? own : memory->lastFeasibleSetPosition;
  } else if (is_equal(*velocity, vzero())) {
    *position = vadd(own, near);
  } else if (!is_equal(goal, near)) {
    *position = vadd(own, near);
    *velocity = vzero();
  } else {
    // the velocity may lead out of the cell sooner than the position does
    const float steps = ray(cell, goal, *velocity);
    if (steps < 1.0f) {
      *velocity = vscl(steps, *velocity);
    }
  }
}

void collisionAvoidanceUpdateSetpointCore(const collision_avoidance_params_t *params,
                                          collision_avoidance_state_t *collisionState, int nOthers,
                                          const float *otherPositions, float *workspace,
                                          setpoint_t *setpoint, const sensorData_t *sensorData,
                                          const state_t *state) {
  (void)sensorData;
  const int        rows          = nOthers + BOX_ROWS;
  const struct vec own           = mkvec(state->position.x, state->position.y, state->position.z);
  cell_t           cell          = {.params    = params,
                                    .normals   = workspace,
                                    .distances = workspace + 3 * rows,
                                    .scratch   = workspace + 4 * rows};
  const struct vec inverse_radii = veltrecip(params->ellipsoidRadii);
  for (int i = 0; i < nOthers; i++) {
    const float *other = otherPositions + 3 * i;
    add_peer(&cell, inverse_radii, own, mkvec(other[0], other[1], other[2]));
  }
  add_box(&cell, own);

  struct vec position = mkvec(setpoint->position.x, setpoint->position.y, setpoint->position.z);
  struct vec velocity = mkvec(setpoint->velocity.x, setpoint->velocity.y, setpoint->velocity.z);
  if (setpoint->mode.x == modeVelocity) {
    velocity                                = bend_velocity(&cell, velocity);
    collisionState->lastFeasibleSetPosition = own;
  } else if (setpoint->mode.x == modeAbs) {
    bend_position(&cell, collisionState, own, &position, &velocity);
    collisionState->lastFeasibleSetPosition = position;
  }
  setpoint->position.x = position.x;
  setpoint->position.y = position.y;
  setpoint->position.z = position.z;
  setpoint->velocity.x = velocity.x;
  setpoint->velocity.y = velocity.y;
  setpoint->velocity.z = velocity.z;
}

// ---------------------------------------------------------------------------------- on the drone

void cf_collision_avoidance_init(cf_collision_avoidance_t *avoidance) {
  *avoidance = (cf_collision_avoidance_t){
      .params =
          {
              .ellipsoidRadii             = {0.3f, 0.3f, 0.9f},
              .bboxMin                    = {-FLT_MAX, -FLT_MAX, -FLT_MAX},
              .bboxMax                    = {FLT_MAX, FLT_MAX, FLT_MAX},
              .horizonSecs                = 1.0f,
              .maxSpeed                   = 0.5f,
              .sidestepThreshold          = 0.25f,
              .maxPeerLocAgeMillis        = 5000,
              .voronoiProjectionTolerance = 1e-5f,
              .voronoiProjectionMaxIters  = 100,
          },
      .state.lastFeasibleSetPosition = {NAN, NAN, NAN},
  };
}

static bool counts(const cf_peer_t *peer, int max_age, uint32_t now) {
  return peer->id != 0 && (max_age < 0 || now - peer->pos.timestamp <= (uint32_t)max_age);
}

static int min_int(int a, int b) {
  return a < b ? a : b;
}

void cf_collision_avoidance_update(cf_collision_avoidance_t *avoidance, setpoint_t *setpoint,
                                   const cf_peer_t *peers, int n_peers, const sensorData_t *sensors,
                                   const state_t *estimate, uint32_t now) {
  if (!avoidance->enable) {
    return;
  }
  // the positions are used up row by row while the cell is written over them
  float     workspace[FLOATS_PER_ROW * (PEER_LOCALIZATION_MAX_NEIGHBORS + BOX_ROWS)];
  const int most  = min_int(n_peers, PEER_LOCALIZATION_MAX_NEIGHBORS);
  int       count = 0;
  for (int i = 0; i < most; i++) {
    const cf_peer_t *peer = &peers[i];
    if (counts(peer, avoidance->params.maxPeerLocAgeMillis, now)) {
      workspace[3 * count]     = peer->pos.x;
      workspace[3 * count + 1] = peer->pos.y;
      workspace[3 * count + 2] = peer->pos.z;
      count++;
    }
  }

  collision_avoidance_params_t params = avoidance->params;
  params.voronoiProjectionMaxIters =
      min_int(params.voronoiProjectionMaxIters, CF_COLLISION_AVOIDANCE_MAX_SWEEPS);
  collisionAvoidanceUpdateSetpointCore(&params, &avoidance->state, count, workspace, workspace,
                                       setpoint, sensors, estimate);
}

#define PARAMETER(name_, type_, member_) \
  CF_ROW("colAv", name_, type_, 0, cf_collision_avoidance_t, member_)

static const cf_variable_t PARAMETERS[] = {
    PARAMETER("enable", UINT8, enable),
    PARAMETER("ellipsoidX", FLOAT, params.ellipsoidRadii.x),
    PARAMETER("ellipsoidY", FLOAT, params.ellipsoidRadii.y),
    PARAMETER("ellipsoidZ", FLOAT, params.ellipsoidRadii.z),
    PARAMETER("bboxMinX", FLOAT, params.bboxMin.x),
    PARAMETER("bboxMinY", FLOAT, params.bboxMin.y),
    PARAMETER("bboxMinZ", FLOAT, params.bboxMin.z),
    PARAMETER("bboxMaxX", FLOAT, params.bboxMax.x),
    PARAMETER("bboxMaxY", FLOAT, params.bboxMax.y),
    PARAMETER("bboxMaxZ", FLOAT, params.bboxMax.z),
    PARAMETER("horizon", FLOAT, params.horizonSecs),
    PARAMETER("maxSpeed", FLOAT, params.maxSpeed),
    PARAMETER("sidestepThrsh", FLOAT, params.sidestepThreshold),
    PARAMETER("maxPeerLocAge", INT32, params.maxPeerLocAgeMillis),
    PARAMETER("vorTol", FLOAT, params.voronoiProjectionTolerance),
    PARAMETER("vorIters", INT32, params.voronoiProjectionMaxIters),
};

static const cf_variable_t LOGS[] = {
    CF_ROW("colAv", "latency", UINT32, 0, cf_collision_avoidance_t, latency),
};

cf_variables_t cf_collision_avoidance_parameters(void) {
  return CF_TABLE(PARAMETERS);
}

cf_variables_t cf_collision_avoidance_logs(void) {
  return CF_TABLE(LOGS);
}
