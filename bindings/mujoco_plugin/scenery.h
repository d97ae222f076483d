/* What stands around the drones: the geoms of the model that never move. Asked by everything that
 * looks or feels downward or sideways: ranging decks, ground effect.
 *
 * Positions are in the world frame [m]. Only geoms that collide count; drones do not. Planes have
 * no end, as in contacts, and only their front is there. Any number of threads may ask. */
#ifndef CF_MUJOCO_PLUGIN_SCENERY_H
#define CF_MUJOCO_PLUGIN_SCENERY_H

#include <stdbool.h>

#include "mujoco_plugin/mujoco_api.h"

typedef struct cf_scenery_s cf_scenery_t;

// Reads the model. Returns null when there is no memory; otherwise it must be freed.
cf_scenery_t *cf_scenery_new(const cf_mujoco_api_t *mj, const mjModel *model);
void          cf_scenery_free(cf_scenery_t *scenery);

// Whether there is nothing but a floor at z = 0.
bool cf_scenery_is_flat_floor(const cf_scenery_t *scenery);

// Whether a body never moves: no joint is above it, and no hand moves it as a mocap body.
bool cf_scenery_is_static(const mjModel *model, int body);

// Distance [m] from a point straight down to the surface below it, at most `reach`; `reach` where
// there is none within it. Depends on the model and the point only.
float cf_scenery_height_below(const cf_scenery_t *scenery, const float point[3], float reach);

// Distance [m] along a unit vector to the first surface, at most `reach`.
float cf_scenery_ray(const cf_scenery_t *scenery, const float point[3], const float direction[3],
                     float reach);

#endif  // CF_MUJOCO_PLUGIN_SCENERY_H
