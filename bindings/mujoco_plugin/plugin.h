/* The engine plugin crazychoir.crazyflie: the only place where the core and MuJoCo meet.
 *
 * One plugin instance per drone, on a body with a free joint. The whole cf_t lives in
 * mjData.plugin_state. */
#ifndef CF_MUJOCO_PLUGIN_PLUGIN_H
#define CF_MUJOCO_PLUGIN_PLUGIN_H

#include <stdint.h>

#include "crazyflie.h"
#include "mujoco_plugin/collision.h"

// Registers the plugin with the MuJoCo library at this path, which must already be loaded. Returns
// 0, or -1 when the library or one of its functions is not found, or -2 when it is of another
// minor version than the headers this was built with.
int cf_plugin_register(const char *libmujoco_path);

// Takes away the clock by which MuJoCo measures its own stages in mjData.timer. Reading it some
// forty times in a step costs as much as a step of one drone. To be called after the registration.
void cf_plugin_stop_clock(void);

// Version of the MuJoCo headers this was built with, e.g. 4000000.
int cf_plugin_mujoco_version(void);

// The text of an attribute of the drone in a plugin instance of a model (address of mjModel), empty
// when it is not set. Null when the instance is no Crazyflie.
const char *cf_plugin_attribute(uintptr_t model, int instance, const char *name);

// Lets the ticks of a swarm run beside the first half of the next step. Between on and off, which
// must be calls of one thread, no other thread may access this mjData; afterwards everything is up
// to date. Takes the addresses of mjModel and mjData; does nothing when they have no Crazyflie.
void cf_plugin_overlap(uintptr_t model, uintptr_t data, int is_overlapping);

// Address of mjData.time [s], valid as long as the mjData.
const double *cf_plugin_clock(uintptr_t data);

// Advances by at most so many ticks without MuJoCo, as steps would, to the last bit. Returns by how
// many, or minus the number of steps that MuJoCo has to make. Of mjData it leaves qpos, qvel, qacc,
// qacc_warmstart, time and plugin_state up to date, and there is no contact. After all ticks, so is
// where bodies, geoms, sites, cameras and lights are, in the way of mj_step: at the start of the
// last one. Velocities of bodies and forces stay as they were. After less, a step is to follow.
int cf_plugin_window(uintptr_t model, uintptr_t data, int ticks);

// Takes out the contacts of drones that have begun, in the order of their beginning: at most
// `capacity` at a time. Returns how many; `lost` counts those for which there was no room.
int cf_plugin_take_collisions(uintptr_t model, uintptr_t data, cf_collision_t *collisions,
                              int capacity, uint32_t *lost);

// Distance [m] that a ranging chip of drone `self` (-1: no drone) would find from a point along a
// unit vector, at most `reach`, in the step that ended; see surroundings.h. -1 when there is no
// Crazyflie in the model.
float cf_plugin_look(uintptr_t model, uintptr_t data, int self, const float point[3],
                     const float direction[3], float cone, float reach);

// Nanoseconds spent so far in [0] onboard software and [1] vehicles (sensors, motors and wrenches),
// summed over threads, when timing is on. Timing is off at first and never influences the
// simulation.
void cf_plugin_timing(int enabled);
void cf_plugin_timing_read(uint64_t nanoseconds[2]);

#endif  // CF_MUJOCO_PLUGIN_PLUGIN_H
