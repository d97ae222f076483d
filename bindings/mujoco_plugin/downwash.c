#include "mujoco_plugin/downwash.h"

#include <math.h>
#include <stdlib.h>

#include "mujoco_plugin/motion.h"
#include "mujoco_plugin/scenery.h"

static const float WEAKEST      = 0.01f;  // strength below which rotors do not count as running
static const float FARTHEST     = 1e4f;   // [m], beyond it a drone has run wild
static const float GROUND_REACH = 2.0f;   // [m], below this no rotor feels a surface

bool cf_downwash_new(swarm_t *swarm) {
  for (int i = 0; i < swarm->count; i++) {
    const drone_t *drone = &swarm->drones[i];
    swarm->has_downwash |=
        !drone->is_isolated && drone->config->vehicle.airframe.downwash.is_enabled;
  }
  swarm->has_downwash = swarm->has_downwash && swarm->count > 1;
  if (!swarm->has_downwash) {
    return true;
  }
  swarm->strengths = calloc((size_t)swarm->count, sizeof *swarm->strengths);
  return swarm->strengths != NULL && cf_peer_grid_new(&swarm->blowing, swarm->count);
}

void cf_downwash_free(swarm_t *swarm) {
  free(swarm->strengths);
  cf_peer_grid_free(&swarm->blowing);
}

bool cf_downwash_is_due(double before, double now) {
  return floor(now / CF_DOWNWASH_PERIOD) > floor(before / CF_DOWNWASH_PERIOD);
}

void cf_downwash_look(swarm_t *swarm) {
  cf_peer_grid_clear(&swarm->blowing);
  for (int i = 0; i < swarm->count; i++) {
    const cf_vehicle_t *vehicle  = &cf_state_of(&swarm->drones[i], swarm->data)->vehicle;
    const float         thrust   = cf_rotors_total_thrust(&vehicle->rotors);
    const float         strength = cf_downwash_strength(vehicle->mass, thrust);
    // false for NaN
    if (strength > WEAKEST && !swarm->drones[i].is_isolated) {
      swarm->strengths[i] = strength;
      cf_peer_grid_add(&swarm->blowing, i, swarm->work[i].motion.position);
    }
  }
  cf_peer_grid_sort(&swarm->blowing);
}

static float force_in_column(const swarm_t *swarm, const cf_downwash_config_t *config,
                             const float position[3], int self, int32_t x, int32_t y) {
  const cf_seen_drone_t *others;
  const int              count = cf_peer_grid_bucket(&swarm->blowing, x, y, &others);
  float                  force = 0.0f;
  for (int k = 0; k < count; k++) {
    const cf_seen_drone_t *other = &others[k];
    const float offset[3] = {other->position[0] - position[0], other->position[1] - position[1],
                             other->position[2] - position[2]};
    // buckets hold columns from elsewhere as well, which are out of reach
    const bool is_of_column = other->column[0] == x && other->column[1] == y;
    if (is_of_column && other->index != self) {
      force += cf_downwash_force(config, offset, swarm->strengths[other->index]);
    }
  }
  return force;
}

// Sums over the columns within reach, in an order that depends on positions only.
static float force_on(const swarm_t *swarm, const cf_downwash_config_t *config, int i) {
  const float *p = swarm->work[i].motion.position;
  // false for NaN
  if (swarm->blowing.count == 0 || !(fabsf(p[0]) < FARTHEST && fabsf(p[1]) < FARTHEST)) {
    return 0.0f;
  }
  const int32_t left   = (int32_t)floorf(p[0] - CF_DOWNWASH_REACH_ASIDE);
  const int32_t right  = (int32_t)floorf(p[0] + CF_DOWNWASH_REACH_ASIDE);
  const int32_t bottom = (int32_t)floorf(p[1] - CF_DOWNWASH_REACH_ASIDE);
  const int32_t top    = (int32_t)floorf(p[1] + CF_DOWNWASH_REACH_ASIDE);
  float         force  = 0.0f;
  for (int32_t y = bottom; y <= top; y++) {
    for (int32_t x = left; x <= right; x++) {
      force += force_in_column(swarm, config, p, i, x, y);
    }
  }
  return force;
}

// World z [m] of the surface straight below, or of a point GROUND_REACH below if there is none.
static float surface_below(const swarm_t *swarm, const float position[3]) {
  if (cf_scenery_is_flat_floor(swarm->scenery)) {
    return 0.0f;
  }
  return position[2] - cf_scenery_height_below(swarm->scenery, position, GROUND_REACH);
}

void cf_downwash_tell(const swarm_t *swarm, int i) {
  cf_vehicle_t               *vehicle = &cf_state_of(&swarm->drones[i], swarm->data)->vehicle;
  const cf_downwash_config_t *config  = &swarm->drones[i].config->vehicle.airframe.downwash;
  if (swarm->has_downwash && config->is_enabled && !swarm->drones[i].is_isolated) {
    vehicle->downwash = force_on(swarm, config, i);
  }
  if (vehicle->ground_effect.config.is_enabled ||
      vehicle->barometer.config.noise_scale * fabsf(vehicle->barometer.wash) > 0.0f) {
    vehicle->surface = surface_below(swarm, swarm->work[i].motion.position);
  }
}
