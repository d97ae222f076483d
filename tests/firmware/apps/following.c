// An estimator that believes motion capture: poses as they come, velocity from their differences.
#include "estimator.h"
#include "log.h"
#include "math3d.h"

#define WEIGHT 0.3f  // of the newest difference

static struct vec position;
static struct vec velocity;
static bool       has_pose;
static uint32_t   poses;

void estimatorOutOfTreeInit(void) {
  has_pose = false;
}

bool estimatorOutOfTreeTest(void) {
  return true;
}

static void follow(state_t *state, const poseMeasurement_t *pose) {
  const struct vec now = mkvec(pose->x, pose->y, pose->z);
  if (has_pose) {
    const struct vec difference = vscl(100.0f, vsub(now, position));
    velocity                    = vadd(vscl(1.0f - WEIGHT, velocity), vscl(WEIGHT, difference));
  }
  position = now;
  has_pose = true;
  poses++;

  const quaternion_t *q       = &pose->quat;
  const struct vec    rpy     = quat2rpy(mkquat(q->x, q->y, q->z, q->w));
  state->attitudeQuaternion.x = q->x;
  state->attitudeQuaternion.y = q->y;
  state->attitudeQuaternion.z = q->z;
  state->attitudeQuaternion.w = q->w;
  state->attitude =
      (attitude_t){.roll = degrees(rpy.x), .pitch = -degrees(rpy.y), .yaw = degrees(rpy.z)};
}

void estimatorOutOfTree(state_t *state, const stabilizerStep_t stabilizerStep) {
  (void)stabilizerStep;
  measurement_t measurement;
  while (estimatorDequeue(&measurement)) {
    if (measurement.type == MeasurementTypePose) {
      follow(state, &measurement.data.pose);
    }
  }
  state->position = (point_t){.x = position.x, .y = position.y, .z = position.z};
  state->velocity = (velocity_t){.x = velocity.x, .y = velocity.y, .z = velocity.z};
}

LOG_GROUP_START(follow)
LOG_ADD(LOG_UINT32, poses, &poses)
LOG_GROUP_STOP(follow)
