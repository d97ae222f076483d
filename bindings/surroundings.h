/* What a drone can see of its surroundings: the one query that ranging sensors make to the world.
 *
 * The simulator of the motion may implement it (mujoco_plugin/looking.h does). Without an
 * implementation there is a flat floor at z = 0 and nothing else. */
#ifndef CF_SURROUNDINGS_H
#define CF_SURROUNDINGS_H

typedef struct cf_surroundings_s cf_surroundings_t;

struct cf_surroundings_s {
  // Distance [m] from a point along a unit vector (world frame) to the first thing there, at most
  // `reach`. Small things count already when they are within a cone around the vector, whose half
  // angle has the cosine `cone`; 1 is a ray.
  float (*distance)(const cf_surroundings_t *self, const float point[3], const float direction[3],
                    float cone, float reach);
};

// Asks, or answers for the flat floor where `surroundings` is null.
float cf_look(const cf_surroundings_t *surroundings, const float point[3], const float direction[3],
              float cone, float reach);

#endif  // CF_SURROUNDINGS_H
