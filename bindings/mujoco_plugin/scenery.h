/* What stands around the drones: the geoms of the model that never move. Asked by everything that
 * looks or feels downward or sideways: ranging decks, ground effect.
 *
 * Positions are in the world frame [m]. Only geoms that collide count; drones do not. */
#ifndef CF_MUJOCO_PLUGIN_SCENERY_H
#define CF_MUJOCO_PLUGIN_SCENERY_H

#include "mujoco_plugin/mujoco_api.h"

typedef struct cf_scenery_s cf_scenery_t;

// Distance [m] from a point straight down to the surface below it, at most `reach`; `reach` where
// there is none within it. Depends on the model and the point only.
float cf_scenery_height_below(const cf_scenery_t *scenery, const float point[3], float reach);

// Distance [m] along a unit vector to the first surface, at most `reach`.
float cf_scenery_ray(const cf_scenery_t *scenery, const float point[3], const float direction[3],
                     float reach);

#endif  // CF_MUJOCO_PLUGIN_SCENERY_H
