#include "bitcraze/adapter.h"

#include <string.h>

#include "bitcraze/conversions.h"

static struct planner                   planner;
static struct piecewise_traj            trajectory;
static struct piecewise_traj_compressed compressed;

// The longest piece of a compressed trajectory: header, duration and seven points on four axes.
#define LONGEST_PIECE (1 + 2 + 4 * 7 * 2)
#define COMPRESSED_START 8  // [bytes], where a trajectory starts

// A copy of trajectory memory at a place of the library's own, so that what points into it is a
// pointer that the image may keep. Behind it are zeros, in which every compressed trajectory ends
// at the latest: the checkout's evaluation knows no other end.
static uint8_t memory_copy[CF_TRAJECTORY_MEMORY_BYTES + 2 * LONGEST_PIECE] CF_LIBRARY_KEEP = {0};

static void read_memory(const uint8_t *memory) {
  memcpy(memory_copy, memory, CF_TRAJECTORY_MEMORY_BYTES);
}

// Takes the bytes of now, if they are flown.
static void refresh(const uint8_t *memory) {
  const void *flown = planner.trajectory;
  if (flown == &trajectory || flown == &compressed) {
    read_memory(memory);
  }
}

void cf_planning_boot(void) {
  plan_init(&planner);
}

int cf_planning_takeoff(void *state CF_UNUSED, const cf_plan_start_t *from, float height, float yaw,
                        float duration, float t) {
  return plan_takeoff(&planner, cf_checkout_vec(from->pos), from->yaw, height, yaw, duration, t);
}

int cf_planning_land(void *state CF_UNUSED, const cf_plan_start_t *from, float height, float yaw,
                     float duration, float t) {
  return plan_land(&planner, cf_checkout_vec(from->pos), from->yaw, height, yaw, duration, t);
}

int cf_planning_go_to(void *state CF_UNUSED, const uint8_t *memory, const cf_plan_start_t *from,
                      bool relative, bool linear, struct api_vec goal, float yaw, float duration,
                      float t) {
  // invalid while idle or disabled
  refresh(memory);
  struct traj_eval start = plan_current_goal(&planner, t);
  if (!is_traj_eval_valid(&start)) {
    start = cf_checkout_start(from);
  }
#if HAVE_PLAN_GO_TO_LINEAR
  return plan_go_to_from(&planner, &start, relative, linear, cf_checkout_vec(goal), yaw, duration,
                         t);
#else
  if (linear) {
    cf_library_print("HLCOMMANDER: this firmware knows no linear go-to, it flies a smooth one\n");
  }
  return plan_go_to_from(&planner, &start, relative, cf_checkout_vec(goal), yaw, duration, t);
#endif
}

int cf_planning_spiral(void *state CF_UNUSED, const cf_plan_start_t *from,
                       const cf_spiral_t *spiral, float t) {
#if HAVE_PLAN_SPIRAL
  const struct traj_eval start = cf_checkout_start(from);
  return plan_spiral_from(&planner, &start, spiral->sideways, spiral->clockwise, spiral->angle,
                          spiral->radius0, spiral->radiusF, spiral->ascent, spiral->duration, t);
#else
  (void)from, (void)spiral, (void)t;
  cf_library_print("HLCOMMANDER: this firmware knows no spiral\n");
  return 1;
#endif
}

static bool is_within_memory(uint32_t offset, uint32_t bytes) {
  return offset <= CF_TRAJECTORY_MEMORY_BYTES && bytes <= CF_TRAJECTORY_MEMORY_BYTES - offset;
}

static int start_pieces(const cf_uploaded_trajectory_t *uploaded, const cf_plan_start_t *from,
                        float t) {
  if (!is_within_memory(uploaded->offset, uploaded->n_pieces * (uint32_t)sizeof(struct poly4d))) {
    return 1;
  }
  // padding included: see cf_checkout_setpoint
  memset(&trajectory, 0, sizeof trajectory);
  trajectory.t_begin   = t;
  trajectory.timescale = uploaded->timescale;
  trajectory.n_pieces  = uploaded->n_pieces;
  trajectory.pieces    = (struct poly4d *)(void *)&memory_copy[uploaded->offset];
#if HAVE_PLAN_START_TRAJECTORY_YAW
  return plan_start_trajectory(&planner, &trajectory, uploaded->reversed,
                               uploaded->relative_position, uploaded->relative_yaw,
                               cf_checkout_vec(from->pos), from->yaw);
#else
  if (uploaded->relative_yaw) {
    cf_library_print("HLCOMMANDER: this firmware does not turn trajectories to the present yaw\n");
  }
  return plan_start_trajectory(&planner, &trajectory, uploaded->reversed,
                               uploaded->relative_position, cf_checkout_vec(from->pos));
#endif
}

static int start_compressed(const cf_uploaded_trajectory_t *uploaded, const cf_plan_start_t *from,
                            float t) {
  if (!is_within_memory(uploaded->offset, COMPRESSED_START)) {
    return 1;
  }
  piecewise_compressed_load(&compressed, &memory_copy[uploaded->offset]);
  compressed.t_begin = t;
  return plan_start_compressed_trajectory(&planner, &compressed, uploaded->relative_position,
                                          cf_checkout_vec(from->pos));
}

int cf_planning_start_trajectory(void *state CF_UNUSED, const uint8_t *memory,
                                 const cf_uploaded_trajectory_t *uploaded,
                                 const cf_plan_start_t *from, float t) {
  read_memory(memory);
  return uploaded->type == CF_TRAJECTORY_TYPE_POLY4D_COMPRESSED
             ? start_compressed(uploaded, from, t)
             : start_pieces(uploaded, from, t);
}

void cf_planning_stop(void *state CF_UNUSED) {
  plan_stop(&planner);
}

void cf_planning_disable(void *state CF_UNUSED) {
  plan_disable(&planner);
}

bool cf_planning_is_stopped(const void *state CF_UNUSED) {
  return plan_is_stopped(&planner);
}

bool cf_planning_is_disabled(const void *state CF_UNUSED) {
  return plan_is_disabled(&planner);
}

bool cf_planning_is_finished(const void *state CF_UNUSED, const uint8_t *memory, float t) {
  // releases up to 2024.10 look into the trajectory without asking whether there is one
  if (planner.trajectory == NULL) {
    return true;
  }
  refresh(memory);
  return plan_is_finished(&planner, t);
}

int cf_planning_state(const void *state CF_UNUSED) {
  return (int)planner.state;
}

struct api_traj_eval cf_planning_current_goal(void *state CF_UNUSED, const uint8_t *memory,
                                              float t) {
  refresh(memory);
  const struct traj_eval goal = plan_current_goal(&planner, t);
  return cf_api_goal(&goal);
}
