#include "builtin/planning/planner_spiral.h"

#include <math.h>

#include "api/math3d.h"

// What does not change along a spiral.
typedef struct {
  bool  sideways;
  float sign;   // +1 clockwise, -1 counter-clockwise
  float rate;   // [rad/s], of yaw and of the angle about the axis
  float dr;     // [m/s], of the radius
  float climb;  // [m/s]
} sense_t;

// One end of a spiral: where it is, seen from its axis, and how it moves.
typedef struct {
  struct vec offset;  // [m], horizontal
  struct vec vel;     // [m/s]
  struct vec acc;     // [m/s^2]
} spiral_end_t;

static spiral_end_t spiral_end(const sense_t *sense, float r, float yaw) {
  const float sign = sense->sign;
  const float w    = sense->rate;
  const float dr   = sense->dr;
  const float c    = cosf(yaw);
  const float s    = sinf(yaw);

  if (sense->sideways) {
    return (spiral_end_t){
        .offset = mkvec(-sign * r * c, -sign * r * s, 0.0f),
        .vel    = mkvec(sign * (r * s * w - dr * c), sign * (-r * c * w - dr * s), sense->climb),
        .acc    = mkvec(sign * (r * c * w * w + 2.0f * dr * s * w),
                        sign * (r * s * w * w - 2.0f * dr * c * w), 0.0f),
    };
  }
  return (spiral_end_t){
      .offset = mkvec(-sign * r * s, sign * r * c, 0.0f),
      .vel    = mkvec(-sign * (r * c * w + dr * s), sign * (-r * s * w + dr * c), sense->climb),
      .acc    = mkvec(sign * (r * s * w * w - 2.0f * dr * c * w),
                      sign * (-r * c * w * w - 2.0f * dr * s * w), 0.0f),
  };
}

void cf_plan_spiral(struct poly4d *piece, const cf_plan_start_t *from, const cf_spiral_t *spiral) {
  const float full_turn = 2.0f * M_PI_F;
  const float angle     = fminf(fmaxf(spiral->angle, -full_turn), full_turn);
  const float r0        = fmaxf(spiral->radius0, 0.0f);
  const float rF        = fmaxf(spiral->radiusF, 0.0f);
  const float T         = spiral->duration;

  const float   sign  = spiral->clockwise ? 1.0f : -1.0f;
  const sense_t sense = {
      .sideways = spiral->sideways,
      .sign     = sign,
      .rate     = -sign * angle / T,
      .dr       = (rF - r0) / T,
      .climb    = spiral->ascent / T,
  };

  const float        yaw0  = normalize_radians(from->yaw);
  const float        yawF  = yaw0 - sign * angle;
  const spiral_end_t begin = spiral_end(&sense, r0, yaw0);
  const spiral_end_t end   = spiral_end(&sense, rF, yawF);

  const struct vec axis = vsub(from->pos, begin.offset);
  const struct vec goal = vadd(vadd(axis, end.offset), mkvec(0.0f, 0.0f, spiral->ascent));
  piecewise_plan_7th_order_no_jerk(piece, T, from->pos, yaw0, begin.vel, sense.rate, begin.acc,
                                   goal, yawF, end.vel, sense.rate, end.acc);
}
