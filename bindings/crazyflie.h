/* One Crazyflie: onboard software and vehicle in one flat struct.
 *
 * cf_t holds everything that a drone is: no pointers into itself, no clock but its tick. A snapshot
 * is a memcpy, a swarm is an array, and two threads may step two drones without a lock. */
#ifndef CF_CRAZYFLIE_H
#define CF_CRAZYFLIE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "configuration_block.h"
#include "contacts.h"
#include "faults.h"
#include "onboard/onboard.h"
#include "platform.h"
#include "provider.h"
#include "status.h"
#include "surroundings.h"
#include "variables.h"
#include "vehicle/vehicle.h"

// Everything that is chosen before a drone exists. `cf_config_default` fills it.
typedef struct {
  int           provider;  // number for cf_provider()
  cf_platform_t platform;
  int           controller;  // ControllerType
  int           estimator;   // StateEstimatorType; AutoSelect chooses by the positioning
  uint32_t      seed;        // of the world
  uint32_t      id;          // of the drone: equal seeds and different ids give independent noise
  uint32_t radio_id;  // low byte of the radio address, 1 to 255; 0: counts from 1 as ids do from 0

  float start_position[3];  // [m], told to the estimator as kalman.initialX, Y, Z
  float start_yaw;          // [rad], told as kalman.initialYaw

  // configuration block, read at boot, so that a change takes cf_reboot; see cf_sensors_set_trim
  float acc_trim_pitch;  // [deg]
  float acc_trim_roll;   // [deg]

  int   loco_is_planar;  // not 0: the loco deck's driver was built for two dimensions
  float loco_height;     // [m], then: where the drone is kept

  bool is_isolated;  // neither meets, feels nor sees other drones, nor they it

  cf_vehicle_config_t vehicle;
} cf_config_t;

// True motion of the body, as the simulator knows it.
typedef struct {
  float position[3];        // [m], world
  float quat_wxyz[4];       // body to world
  float rotation[9];        // the same as a matrix, row by row
  float velocity[3];        // [m/s], world
  float rates[3];           // [rad/s], body
  float specific_force[3];  // [m/s^2], body: +9.81 on z at rest

  const cf_surroundings_t *surroundings;  // what ranging decks see; null: a flat floor at z = 0
} cf_motion_t;

// Sleep state of a drone at rest, which the simulator holds at its pose (mujoco_plugin/sleep.h).
typedef struct {
  float  still_time;   // [s] with stopped rotors, up to now
  float  placed_time;  // [s] with stopped rotors near `pose`, up to now
  bool   is_held;      // since it has been still for long enough
  bool   is_loose;     // let go, and not yet away from `pose`
  bool   is_weighed;   // `load` is known
  double pose[7];      // position [m] and quaternion (w, x, y, z) where it is held, or may be
  double load[6];      // generalized force [N, world; N m, body] of those that lean on it
} cf_sleep_t;

// A drone whose provider needs more memory than the member has is longer, see cf_state_bytes.
typedef struct cf {
  cf_config_t config;

  cf_onboard_t onboard;
  cf_vehicle_t vehicle;

  // for the IMU: specific force is the change of velocity over a tick
  double last_velocity[3];  // [m/s], world, at the end of the last tick
  double last_rates[3];     // [rad/s], body, likewise
  bool   has_last_velocity;

  cf_injected_faults_t injected;
  cf_sleep_t           rest;

  // here, because the world looks at both in every drone: one cache line less per look
  bool wants_peers;  // collision avoidance was on in the last tick

  cf_contacts_t contacts;

  uint8_t configuration[CF_CONFIGURATION_BYTES];  // what the EEPROM holds, across reboots

  uint64_t provider_state[CF_PROVIDER_STATE_BYTES / 8];  // stays the last member
} cf_t;

// Fills the configuration of a stock drone. Returns CF_ERR_UNKNOWN for an unknown platform.
cf_status_t cf_config_default(cf_config_t *config, cf_platform_t platform);

// Boots a drone at tick 0, in memory of cf_state_bytes(config->provider). Returns CF_ERR_UNKNOWN
// for a provider, controller or estimator that does not exist, CF_ERR_VALUE for a radio id above
// 255 or a vehicle that cannot be built and CF_ERR_STATE for a provider that failed, as
// onboard.failure says; the drone is then unusable.
cf_status_t cf_init(cf_t *cf, const cf_config_t *config);

// Boots the onboard software again, as a power cycle would. Battery, rotors and sensor biases stay
// as they are. A provider that fails on the way stops the drone.
void cf_reboot(cf_t *cf);

// One millisecond: sensors, onboard software, motors, rotors and battery. Cannot fail; a drone
// whose numbers are no longer finite stops its motors, locks and says why in onboard.fault.
void cf_tick(cf_t *cf, const cf_motion_t *motion);

// The three parts of a tick, to be called in this order: the vehicle's sensors measure, the onboard
// software decides, the vehicle's motors turn.
void cf_sense(cf_t *cf, const cf_motion_t *motion, cf_hardware_t *hardware);
void cf_think(cf_t *cf, const cf_hardware_t *hardware);
void cf_actuate(cf_t *cf);

// Force [N, world] and torque [N m, body, about the body origin] of rotors and air at this motion.
// Has no effect on the drone. A wrench that is not finite is returned as zero.
void cf_wrench(const cf_t *cf, const cf_motion_t *motion, float force[3], float torque[3]);

// Whether it cannot fly any more: the core stopped it, it crashed, or its supervisor is locked.
bool cf_is_out(const cf_t *cf);

// Number of drones of which that is so.
int cf_count_out(const cf_t *const *drones, int count);

// Updates the log variables that the tick does not compute (cf_onboard_refresh_logs, refresh_logs
// of the provider), in `count` drones whose states start `stride` bytes apart.
void cf_refresh_logs(cf_t *first, int count, ptrdiff_t stride);

// Refreshes the logs of drones as cf_refresh_logs does, then copies stretches of their memory to
// `to`, one drone behind the other. `bounds` has the first byte and the one behind the last of each
// of the `stretches`.
void cf_copy_logs(uint8_t *to, cf_t *first, int count, ptrdiff_t stride, const uint32_t *bounds,
                  int stretches);

// Copies some float variables of drones to `to`, (count, variables). `offsets` are their first
// bytes in the memory of a drone.
void cf_gather_floats(double *to, const cf_t *first, int count, ptrdiff_t stride,
                      const uint32_t *offsets, int variables);

// To be called after a client wrote a parameter of the drone into its memory.
void cf_parameter_written(cf_t *cf, const char *group, const char *name);

// Writes the positions of all peers into the drone (onboard/peer_localization.h). A drone without
// wants_peers does not read them.
void cf_tell_peers(cf_t *cf, const cf_peer_t *peers, int count);

// Bytes of one drone with this provider, a whole number of doubles; 0 for a provider that does not
// exist.
int cf_state_bytes(int provider);

// The provider of a drone, for this thread. Null when it has failed, and the drone is stopped with
// CF_FAULT_SOFTWARE: its code gave up, or the machine has no memory for a copy for this thread.
const cf_provider_t *cf_provider_of(cf_t *cf);

// Tables of parameters and log variables over a cf_t with this provider; bases count from its
// start. They fill at most `capacity` tables and return how many there are.
int cf_parameters(int provider, cf_variables_t *tables, int capacity);
int cf_logs(int provider, cf_variables_t *tables, int capacity);

#endif  // CF_CRAZYFLIE_H
