#include "mujoco_plugin/collisions.h"

#include <math.h>
#include <string.h>

#include "mujoco_plugin/motion.h"
#include "mujoco_plugin/swarm.h"

static const double CARRYING =
    0.7;  // cosine between the normal and up, from which on a surface carries
static const float UPRIGHT = 0.7f;
// [m/s], what falls faster has crashed: clients whose estimate or setpoint lags stop the motors up
// to 0.17 m above the floor, from where a drone falls at 1.8 m/s
static const double TOUCHDOWN    = 2.0;
static const double FIRST_MOMENT = 0.1;  // [s], in which drones come to stand where they start

// Velocity of the point of a body, before the step: MuJoCo keeps it about the center of mass of the
// tree.
static void velocity_at(const mjModel *model, const mjData *data, int body, const double point[3],
                        double out[3]) {
  const double *spin   = data->cvel + 6 * body;
  const double *center = data->subtree_com + 3 * model->body_rootid[body];
  const double  arm[3] = {point[0] - center[0], point[1] - center[1], point[2] - center[2]};
  out[0]               = spin[3] + spin[1] * arm[2] - spin[2] * arm[1];
  out[1]               = spin[4] + spin[2] * arm[0] - spin[0] * arm[2];
  out[2]               = spin[5] + spin[0] * arm[1] - spin[1] * arm[0];
}

static double closing_speed(const mjModel *model, const mjData *data, const mjContact *contact) {
  double v[2][3];
  double speed = 0;
  for (int k = 0; k < 2; k++) {
    velocity_at(model, data, model->geom_bodyid[contact->geom[k]], contact->pos, v[k]);
  }
  // the normal points from the first geom to the second
  for (int k = 0; k < 3; k++) {
    speed += contact->frame[k] * (v[0][k] - v[1][k]);
  }
  return fmax(speed, 0.0);
}

// `up` is the vertical part of the normal from what is touched to the drone.
static int kind_of(const cf_motion_t *motion, double up, double speed) {
  if (up < CARRYING) {
    return CF_COLLISION_OBSTACLE;
  }
  const bool is_upright = motion->rotation[8] > UPRIGHT;
  return is_upright && speed < TOUCHDOWN ? CF_COLLISION_TOUCHDOWN : CF_COLLISION_FLOOR;
}

static bool is_same(const cf_collision_t *a, const cf_collision_t *b) {
  return a->time == b->time && a->drone == b->drone && a->other == b->other &&
         (a->other >= 0 || a->geom == b->geom);
}

// A hull on a floor touches it in several points at once: the fastest counts.
static bool merge(cf_collisions_t *collisions, const cf_collision_t *found) {
  for (int i = collisions->count - 1; i >= 0 && collisions->list[i].time == found->time; i--) {
    cf_collision_t *told = &collisions->list[i];
    if (is_same(told, found)) {
      if (found->speed > told->speed) {
        *told = *found;
      }
      return true;
    }
  }
  return false;
}

static void tell(cf_collisions_t *collisions, const cf_collision_t *found) {
  if (collisions->count < CF_MOST_COLLISIONS) {
    collisions->list[collisions->count++] = *found;
  } else {
    collisions->lost++;
  }
}

typedef struct {
  swarm_t       *swarm;
  const mjModel *model;
  mjData        *data;
} step_t;

// Notes in a drone that it touches something. Returns whether that begins.
static bool touch(const step_t *step, int drone, int other, int geom) {
  cf_t *cf = cf_state_of(&step->swarm->drones[drone], step->data);
  // geoms first, drones behind them
  const int32_t *things = step->swarm->thing_of_geom;
  const int32_t  number = other < 0 ? things[geom] : things[step->model->ngeom] + other;
  const uint32_t thing  = 1 + (uint32_t)number;
  const uint32_t now    = cf_contacts_clock(step->data->time);
  const uint32_t tick   = cf->onboard.tick + (uint32_t)step->swarm->ticks;
  return cf_contacts_note(&cf->contacts, thing, now, tick);
}

// A contact that is side `own` of one drone; the other side is another drone, or none (-1).
static void look_at_touch(const step_t *step, const mjContact *contact, int own, int first,
                          int second) {
  const swarm_t *swarm  = step->swarm;
  const bool     begins = touch(step, first, second, contact->geom[1 - own]);
  if (second >= 0) {
    touch(step, second, first, 0);
  }

  const double speed = closing_speed(step->model, step->data, contact);
  const double up    = own == 1 ? contact->frame[2] : -contact->frame[2];
  cf_motion_t  motion;
  cf_motion_of(&swarm->drones[first], step->data, &motion);
  cf_collision_t found = {
      .time  = step->data->time,
      .kind  = second >= 0 ? CF_COLLISION_DRONE : kind_of(&motion, up, speed),
      .drone = swarm->drones[first].body,
      .other = second >= 0 ? swarm->drones[second].body : -1,
      .geom  = contact->geom[1 - own],
      .speed = (float)speed,
  };
  for (int k = 0; k < 3; k++) {
    found.position[k] = (float)contact->pos[k];
  }
  const bool is_start = step->data->time < FIRST_MOMENT && found.kind == CF_COLLISION_TOUCHDOWN;
  cf_collisions_t *collisions = step->swarm->collisions;
  if (!merge(collisions, &found) && begins && !is_start) {
    tell(collisions, &found);
  }
}

static void look_at(const step_t *step, const mjContact *contact) {
  if (contact->geom[0] < 0 || contact->geom[1] < 0 || contact->exclude != 0) {
    return;
  }
  int drones[2];
  for (int k = 0; k < 2; k++) {
    drones[k] = step->swarm->drone_of_body[step->model->geom_bodyid[contact->geom[k]]];
  }
  if (drones[0] == drones[1]) {
    return;  // neither, or a drone and what hangs on it
  }
  // of two drones the one with the lower index tells
  const int own = drones[0] < 0 || (drones[1] >= 0 && drones[1] < drones[0]) ? 1 : 0;
  look_at_touch(step, contact, own, drones[own], drones[1 - own]);
}

void cf_collisions_look(swarm_t *swarm, const mjModel *model, mjData *data) {
  const step_t step = {.swarm = swarm, .model = model, .data = data};
  for (int i = 0; i < data->ncon; i++) {
    look_at(&step, &data->contact[i]);
  }
}
