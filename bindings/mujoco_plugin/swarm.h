/* All drones of one model: where each finds its body, its joint and its state. Internal to the
 * plugin. */
#ifndef CF_MUJOCO_PLUGIN_SWARM_H
#define CF_MUJOCO_PLUGIN_SWARM_H

#include "crazyflie.h"
#include "mujoco_plugin/collisions.h"
#include "mujoco_plugin/looking.h"
#include "mujoco_plugin/mujoco_api.h"
#include "mujoco_plugin/peer_grid.h"
#include "mujoco_plugin/scenery.h"

typedef struct swarm_s swarm_t;

typedef struct {
  swarm_t     *swarm;
  cf_config_t *config;  // elsewhere, so that what each step asks for lies close together

  int instance;       // of the plugin
  int body;           // carries the free joint
  int tree;           // kinematic tree of that body
  int qpos_address;   // 7 numbers: position, quaternion
  int dof_address;    // 6 numbers: world velocity, body rates
  int state_address;  // in mjData.plugin_state

  bool   can_sleep;    // alone in its tree, so that it can be held (sleep.h)
  bool   is_isolated;  // other drones are not there for it, nor it for them
  bool   is_free;      // flies by itself where it touches nothing (free_flight.h)
  double weight;       // [N] at the start
  double reach;        // [m] of what collides, from the origin of the body

  double principal[7];        // diagonal and frame in the model that these come from
  double inertia[9];          // [kg m^2], body frame
  double inverse_inertia[9];  // [1/(kg m^2)]
} drone_t;

// What a drone's ticks start from and what they lead to. Not state: each step makes it again.
typedef struct {
  double      coordinates[13];  // pose (7) and twist (6) that the rest belongs to
  cf_motion_t motion;
  double      force[6];  // generalized, at the free joint
} work_t;

struct swarm_s {
  int          references;
  int          count;
  int          last_instance;  // works for all
  drone_t     *drones;
  cf_config_t *configs;  // of the drones
  work_t      *work;
  int32_t     *drone_of_body;  // index, also for what hangs on a drone; -1
  int32_t     *thing_of_geom;  // number among those that collide: what is only seen changes no bit

  const cf_mujoco_api_t *mj;

  // in the last step, see free_flight.h
  bool *in_contact;    // by drone
  bool  has_contacts;  // one of them
  bool  has_start;     // work[].coordinates are those at the start of this step

  struct cf_windows_s *windows;  // see windows.h; null where there are none

  // what each drone touched in the last step, see touch.h
  uint8_t *touched;
  bool     has_touches;

  // the ticks after the last step, see ticks.h
  const mjModel *model;
  mjData        *data;
  int            ticks;
  bool           is_overlapping;
  bool           is_pending;  // handed to the thread pool, not yet finished
  bool           has_forces;  // work[].force is that of work[].coordinates

  // the positions that these ticks start with, see broadcast.h
  cf_peer_grid_t peers;
  bool           is_broadcast;

  // drones with running rotors, see downwash.h
  cf_peer_grid_t blowing;
  float         *strengths;     // [count], by drone
  bool           has_downwash;  // a drone feels it
  bool           is_look;       // these ticks start with a look around

  // static bodies, what drones see, and their collisions
  cf_scenery_t    *scenery;
  cf_looking_t     looking;
  cf_collisions_t *collisions;
};

// Finds every drone of the model and reads its attributes. Ends in mju_error with one sentence when
// the model is wrong.
swarm_t *cf_swarm_new(const cf_mujoco_api_t *mj, const mjModel *model);
void     cf_swarm_free(swarm_t *swarm);

// The number that MuJoCo gave our plugin, and whether an instance is one of ours.
void cf_swarm_set_slot(int registered);
bool cf_swarm_has(const mjModel *model, int instance);

// The swarm that lives in this data, or NULL where no drone does.
swarm_t *cf_swarm_of(const mjModel *model, const mjData *data);

// The drone that a body is or hangs on, or NULL. Looks nothing up, also in models without drones.
const drone_t *cf_swarm_drone_of_body(const mjModel *model, const mjData *data, int body);

// Reads the inertia of the body again, if it has been changed in the model.
void cf_drone_read_inertia(drone_t *drone, const mjModel *model);

// The drone that belongs to a plugin instance.
drone_t *cf_swarm_find(swarm_t *swarm, int instance);

// Number of the provider that a plugin instance asks for. Where its attributes are wrong it is the
// built-in one; cf_swarm_new says what is wrong.
int cf_swarm_provider(const cf_mujoco_api_t *mj, const mjModel *model, int instance);

// Checks that steps and ticks fit together. Ends in mju_error otherwise.
void cf_swarm_check_timestep(const cf_mujoco_api_t *mj, double timestep);

#endif  // CF_MUJOCO_PLUGIN_SWARM_H
