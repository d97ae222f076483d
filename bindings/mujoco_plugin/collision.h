/* A contact of a drone that has begun. */
#ifndef CF_MUJOCO_PLUGIN_COLLISION_H
#define CF_MUJOCO_PLUGIN_COLLISION_H

#include <stdint.h>

typedef enum {
  CF_COLLISION_TOUCHDOWN = 0,  // upright onto a surface that carries, slower than 2 m/s
  CF_COLLISION_FLOOR     = 1,  // any other contact with a surface that carries
  CF_COLLISION_OBSTACLE  = 2,  // a surface that does not
  CF_COLLISION_DRONE     = 3,
} cf_collision_kind_t;

typedef struct {
  double  time;         // [s], simulated
  int32_t kind;         // cf_collision_kind_t
  int32_t drone;        // body; of two drones the one that comes first in the model
  int32_t other;        // body of the other drone, or -1
  int32_t geom;         // of what was touched
  float   speed;        // [m/s], at which the two approached each other along the normal
  float   position[3];  // [m, world]
} cf_collision_t;

#endif  // CF_MUJOCO_PLUGIN_COLLISION_H
