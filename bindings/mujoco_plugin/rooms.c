#include "mujoco_plugin/rooms.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mujoco_plugin/motion.h"
#include "mujoco_plugin/sleep.h"

#define STEP 0.001               // [s]
#define SLACK 0.02               // [m], so that no drone leans on one that flies (touch.h)
#define COLUMN 1.0               // [m], of a peer grid
#define ENDLESS 1e9              // [m], no other drone can be touched
#define MOST_ACCELERATION 300.0  // [m/s^2], that a window allows for
#define MOST_PUSH 200.0          // [m/s^2], by rotors; the rest is for air and weight
#define MOST_SPEED 20.0          // [m/s], of a drone and of the wind
#define MOST_VOLTAGE 4.5f        // [V], more than any battery has
#define MOST_GAIN 2.2f           // of a rotor by its efficiency and the ground

// More than all rotors together could push [N], whatever happens to them.
static double most_thrust_of(const drone_t *drone) {
  const cf_rotors_config_t *rotors = &drone->config->vehicle.airframe.rotors;
  const float               cold   = 1.0f + rotors->heat_loss + rotors->heat_own_loss;
  return (double)(CF_ROTOR_COUNT * MOST_GAIN * rotors->thrust_scale * cold *
                  cf_rotor_steady_thrust(rotors, MOST_VOLTAGE));
}

bool cf_rooms_new(cf_rooms_t *rooms, const swarm_t *swarm) {
  rooms->of = calloc((size_t)swarm->count, sizeof *rooms->of);
  if (rooms->of == NULL || !cf_peer_grid_new(&rooms->grid, swarm->count)) {
    return false;
  }
  for (int i = 0; i < swarm->count; i++) {
    rooms->of[i].most_thrust = most_thrust_of(&swarm->drones[i]);
  }
  return true;
}

void cf_rooms_free(cf_rooms_t *rooms) {
  free(rooms->of);
  cf_peer_grid_free(&rooms->grid);
}

static double square_of_distance(const double a[3], const double b[3]) {
  return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
         (a[2] - b[2]) * (a[2] - b[2]);
}

// Gap [m] between what collides of a drone and of those around it. Held drones leave out each
// other.
static double gap_around(const cf_rooms_t *rooms, const swarm_t *swarm, const mjData *data, int i) {
  const drone_t *drone = &swarm->drones[i];
  const double  *place = data->qpos + drone->qpos_address;
  const int32_t  x     = (int32_t)floor(place[0]);
  const int32_t  y     = (int32_t)floor(place[1]);
  double         gap   = COLUMN - drone->reach - CF_ROOMS_REACH;
  if (drone->is_isolated) {
    return ENDLESS;
  }
  for (int k = 0; k < 9; k++) {
    const cf_seen_drone_t *others;
    const int count = cf_peer_grid_bucket(&rooms->grid, x + k % 3 - 1, y + k / 3 - 1, &others);
    for (int n = 0; n < count; n++) {
      const int      index = others[n].index;
      const drone_t *other = &swarm->drones[index];
      if (index != i && !(rooms->of[i].is_held && rooms->of[index].is_held)) {
        const double square = square_of_distance(place, data->qpos + other->qpos_address);
        gap                 = fmin(gap, sqrt(square) - drone->reach - other->reach);
      }
    }
  }
  return gap;
}

static bool measure_gaps(cf_rooms_t *rooms, const swarm_t *swarm, mjData *data) {
  int in_company = 0;
  cf_peer_grid_clear(&rooms->grid);
  for (int i = 0; i < swarm->count; i++) {
    const double *place   = data->qpos + swarm->drones[i].qpos_address;
    const float   rough[] = {(float)place[0], (float)place[1], (float)place[2]};
    if (!swarm->drones[i].is_isolated) {
      cf_peer_grid_add(&rooms->grid, i, rough);
      in_company++;
    }
    rooms->of[i].is_held = cf_state_of(&swarm->drones[i], data)->rest.is_held;
  }
  if (rooms->grid.count < in_company) {
    return false;  // one has run wild
  }
  cf_peer_grid_sort(&rooms->grid);
  for (int i = 0; i < swarm->count; i++) {
    cf_room_t *room = &rooms->of[i];
    memcpy(room->place, data->qpos + swarm->drones[i].qpos_address, sizeof room->place);
    room->gap = 0.5 * gap_around(rooms, swarm, data, i);
  }
  return true;
}

static double length_of(double x, double y, double z) {
  return sqrt(x * x + y * y + z * z);
}

// How far a drone may move in a window [m]; NaN when it flies in a way that has no bound.
static double spread_of(const cf_room_t *room, const drone_t *drone, const mjModel *model,
                        mjData *data, int ticks) {
  const double *v     = data->qvel + drone->dof_address;
  const float  *wind  = cf_state_of(drone, data)->vehicle.wind.velocity;
  const double  speed = length_of(v[0], v[1], v[2]);
  const double  time  = ticks * STEP;
  const double  push  = room->most_thrust / model->body_mass[drone->body];
  return speed < MOST_SPEED && push < MOST_PUSH &&
                 length_of((double)wind[0], (double)wind[1], (double)wind[2]) < MOST_SPEED
             ? speed * time + 0.5 * MOST_ACCELERATION * time * time
             : (double)NAN;
}

// Whether a drone flies, and may for the window, or is held and goes on so. False for what is no
// number.
static bool has_room(const cf_rooms_t *rooms, const swarm_t *swarm, const mjModel *model,
                     mjData *data, int i, int ticks) {
  const cf_room_t  *room   = &rooms->of[i];
  const drone_t    *drone  = &swarm->drones[i];
  const double     *place  = data->qpos + drone->qpos_address;
  const cf_sleep_t *rest   = &cf_state_of(drone, data)->rest;
  const double      spread = spread_of(room, drone, model, data, ticks);
  const double      moved  = sqrt(square_of_distance(place, room->place));
  if (rest->is_held != room->is_held) {
    return false;
  }
  if (rest->is_held) {
    return cf_sleep_holds(drone, data) && rest->is_weighed && moved + SLACK < room->gap;
  }
  return moved + spread + SLACK < room->gap && place[2] - drone->reach - SLACK > spread &&
         rest->still_time == 0.0f && rest->placed_time == 0.0f;
}

static bool have_room(const cf_rooms_t *rooms, const swarm_t *swarm, const mjModel *model,
                      mjData *data, int ticks) {
  bool all = true;
  for (int i = 0; i < swarm->count && all; i++) {
    all = has_room(rooms, swarm, model, data, i, ticks);
  }
  return all;
}

bool cf_rooms_suffice(cf_rooms_t *rooms, const swarm_t *swarm, const mjModel *model, mjData *data,
                      int ticks) {
  return have_room(rooms, swarm, model, data, ticks) ||
         (measure_gaps(rooms, swarm, data) && have_room(rooms, swarm, model, data, ticks));
}
