#include "mujoco_plugin/touch.h"

#include <string.h>

#include "mujoco_plugin/motion.h"
#include "mujoco_plugin/sleep.h"

const drone_t *cf_touch_drone_at(const swarm_t *swarm, int body) {
  const int index = swarm->drone_of_body[body];
  return index >= 0 ? &swarm->drones[index] : NULL;
}

// What a body is to a drone that it touches.
static uint8_t touch_by(const swarm_t *swarm, const mjModel *model, mjData *data, int body) {
  const drone_t *drone = cf_touch_drone_at(swarm, body);
  if (drone != NULL) {
    return cf_sleep_is_awake(drone, data) ? CF_TOUCH_MOVER : CF_TOUCH_DRONE;
  }
  return cf_scenery_is_static(model, body) ? CF_TOUCH_NONE : CF_TOUCH_MOVER;
}

static void note(swarm_t *swarm, const drone_t *drone, uint8_t touch) {
  uint8_t *known     = &swarm->touched[drone - swarm->drones];
  *known             = touch > *known ? touch : *known;
  swarm->has_touches = true;
}

// Those that may touch a drone, or may have touched it where it was held.
static void note_neighbors(swarm_t *swarm, mjData *data, const drone_t *middle, uint8_t touch) {
  const double *place = cf_state_of(middle, data)->rest.pose;
  for (int i = 0; i < swarm->count; i++) {
    const drone_t *drone    = &swarm->drones[i];
    const double  *position = data->qpos + drone->qpos_address;
    const double   square   = (position[0] - place[0]) * (position[0] - place[0]) +
                              (position[1] - place[1]) * (position[1] - place[1]) +
                              (position[2] - place[2]) * (position[2] - place[2]);
    const double   limit    = drone->reach + middle->reach;
    if (drone != middle && square < limit * limit) {
      note(swarm, drone, touch);
    }
  }
}

void cf_touch_forget(swarm_t *swarm) {
  if (swarm->has_touches) {
    memset(swarm->touched, CF_TOUCH_NONE, (size_t)swarm->count);
    swarm->has_touches = false;
  }
}

void cf_touch_look(const mjModel *model, mjData *data, swarm_t *swarm, double elapsed) {
  cf_touch_forget(swarm);
  for (int i = 0; i < data->ncon; i++) {
    const int *geom = data->contact[i].geom;
    if (geom[0] < 0 || geom[1] < 0) {
      continue;  // soft things have no geom
    }
    const int bodies[2] = {model->geom_bodyid[geom[0]], model->geom_bodyid[geom[1]]};
    for (int side = 0; side < 2; side++) {
      const drone_t *drone = cf_touch_drone_at(swarm, bodies[side]);
      if (drone != NULL) {
        note(swarm, drone, touch_by(swarm, model, data, bodies[1 - side]));
      }
    }
  }
  for (int i = 0; i < swarm->count; i++) {
    const drone_t    *drone = &swarm->drones[i];
    const cf_sleep_t *sleep = &cf_state_of(drone, data)->rest;
    // a drone that leaned on it may have lost contact, and must not be held in the air
    if (cf_sleep_has_left(drone, data, elapsed)) {
      note_neighbors(swarm, data, drone, CF_TOUCH_LEFT);
    } else if (sleep->is_held && !sleep->is_weighed) {
      note_neighbors(swarm, data, drone, CF_TOUCH_HELD);
    }
  }
}
