/* The high-level commander: take-off, landing, go-to, spirals and uploaded trajectories, flown by
 * the provider's planner. Packets of a radio client are decoded in high_level_packets.h.
 *
 * Commands return CF_OK, CF_ERR_VALUE for an argument that is not finite, not positive where it
 * must be, or out of range; CF_ERR_BLOCKED while the motors may not run; CF_ERR_STATE when the
 * planner refuses (a take-off while flying, a landing while landing). Time is [us].
 *
 * Source: docs/reference/planner-commander.md#7. Three deliberate deviations: starting a trajectory
 * that is not defined is CF_ERR_UNKNOWN, where the firmware reports success and does nothing;
 * definitions are checked against the size of the memory; and a goal with any number that is not
 * finite disables the planner, where the firmware looks at the position only. */
#ifndef CF_ONBOARD_COMMANDER_HIGH_LEVEL_COMMANDER_H
#define CF_ONBOARD_COMMANDER_HIGH_LEVEL_COMMANDER_H

#include <stdbool.h>
#include <stdint.h>

#include "api/pptraj.h"
#include "api/stabilizer_types.h"
#include "provider.h"
#include "status.h"
#include "variables.h"

#define CF_TRAJECTORY_DEFINITIONS 31
#define CF_TRAJECTORY_PIECES 31  // that fit into the memory

typedef enum {
  CF_TRAJECTORY_LOCATION_INVALID = 0,
  CF_TRAJECTORY_LOCATION_MEMORY  = 1,
} cf_trajectory_location_t;

typedef struct {
  uint8_t  location;  // cf_trajectory_location_t
  uint8_t  type;      // cf_trajectory_type_t
  uint8_t  n_pieces;  // means nothing to a compressed one
  uint32_t offset;    // [bytes], multiple of 4 unless compressed
} cf_trajectory_definition_t;

typedef struct {
  // parameters
  float   vtoff;       // [m/s], default speed of a take-off
  float   vland;       // [m/s], default speed of a landing
  uint8_t group_mask;  // groups that this vehicle belongs to, beside 0 = all

  bool is_blocked;

  // where a plan starts: the last setpoint of an active plan, else the state estimate
  struct vec pos;  // [m]
  struct vec vel;  // [m/s]
  float      yaw;  // [rad]

  setpoint_t setpoint;  // the last one produced; members that plans do not name are kept

  cf_trajectory_definition_t definitions[CF_TRAJECTORY_DEFINITIONS];
  union {
    uint8_t       memory[CF_TRAJECTORY_MEMORY_BYTES];
    struct poly4d memory_pieces[CF_TRAJECTORY_PIECES];  // aligns the memory
  };
} cf_high_level_commander_t;

// Unblocked, at the origin, with default parameters and no trajectories.
void cf_high_level_commander_init(cf_high_level_commander_t *commander);

// Rises straight up to height [m, world] within duration [s]. Turns to yaw [rad] unless
// use_current_yaw.
cf_status_t cf_high_level_commander_takeoff(cf_high_level_commander_t *commander,
                                            const cf_provider_t *provider, void *provider_state,
                                            float height, float duration, float yaw,
                                            bool use_current_yaw, uint64_t now_us);

// The same with a speed [m/s] in place of a duration; param hlCommander.vtoff when velocity <= 0.
// With height_is_relative, height counts from the present position.
cf_status_t cf_high_level_commander_takeoff_with_velocity(cf_high_level_commander_t *commander,
                                                          const cf_provider_t       *provider,
                                                          void *provider_state, float height,
                                                          bool height_is_relative, float velocity,
                                                          float yaw, bool use_current_yaw,
                                                          uint64_t now_us);

// Sinks straight down to height [m, world] within duration [s]; then the motors stop.
cf_status_t cf_high_level_commander_land(cf_high_level_commander_t *commander,
                                         const cf_provider_t *provider, void *provider_state,
                                         float height, float duration, float yaw,
                                         bool use_current_yaw, uint64_t now_us);

// The same with a speed [m/s]; param hlCommander.vland when velocity <= 0. With height_is_relative,
// height counts downwards from the present position.
cf_status_t cf_high_level_commander_land_with_velocity(cf_high_level_commander_t *commander,
                                                       const cf_provider_t       *provider,
                                                       void *provider_state, float height,
                                                       bool height_is_relative, float velocity,
                                                       float yaw, bool use_current_yaw,
                                                       uint64_t now_us);

// Stops the motors, also while blocked.
cf_status_t cf_high_level_commander_stop(cf_high_level_commander_t *commander,
                                         const cf_provider_t *provider, void *provider_state);

// Flies to a position [m] and yaw [rad] within duration [s]; relative ones count from the present
// setpoint. linear: at constant speed, otherwise smoothly.
cf_status_t cf_high_level_commander_go_to(cf_high_level_commander_t *commander,
                                          const cf_provider_t *provider, void *provider_state,
                                          struct vec position, float yaw, float duration,
                                          bool relative, bool linear, uint64_t now_us);

// Flies a spiral from the present setpoint with its own speed. Angles beyond a full turn become
// one, negative radii 0, as in the firmware.
cf_status_t cf_high_level_commander_spiral(cf_high_level_commander_t *commander,
                                           const cf_provider_t *provider, void *provider_state,
                                           const cf_spiral_t *spiral, uint64_t now_us);

// Says which bytes of the memory make trajectory number id: n_pieces > 0 pieces from an offset that
// is a multiple of 4 or, compressed, all from any offset up to the end marker or the end of the
// memory. CF_ERR_CAPACITY unless id < 31 and the pieces, or a compressed start record, lie within
// the memory; CF_ERR_UNKNOWN for another type. May be called while blocked.
cf_status_t cf_high_level_commander_define_trajectory(cf_high_level_commander_t *commander,
                                                      uint8_t id, uint8_t type, uint32_t offset,
                                                      uint8_t n_pieces);

// Copies bytes into or out of the trajectory memory. CF_ERR_CAPACITY when they do not lie in it.
// Uncompressed pieces are 33 little-endian floats: 8 coefficients each of x, y, z, yaw, then [s].
// Compressed trajectories are described in api/pptraj_compressed.h.
cf_status_t cf_high_level_commander_write_trajectory(cf_high_level_commander_t *commander,
                                                     uint32_t offset, uint32_t length,
                                                     const uint8_t *data);
cf_status_t cf_high_level_commander_read_trajectory(const cf_high_level_commander_t *commander,
                                                    uint32_t offset, uint32_t length,
                                                    uint8_t *data);

// Follows trajectory id, slowed down by timescale > 0. relative_position moves its first point to
// the present position, relative_yaw (with relative_position) its first yaw to the present yaw.
// CF_ERR_UNKNOWN when id is not defined. A compressed one is CF_ERR_VALUE unless it runs forward
// with timescale 1, and keeps its own yaw.
cf_status_t cf_high_level_commander_start_trajectory(cf_high_level_commander_t *commander,
                                                     const cf_provider_t       *provider,
                                                     void *provider_state, uint8_t id,
                                                     float timescale, bool relative_position,
                                                     bool relative_yaw, bool reversed,
                                                     uint64_t now_us);

bool cf_high_level_commander_is_trajectory_defined(const cf_high_level_commander_t *commander,
                                                   uint8_t                          id);

// True behind the end of the current plan, and before there is one.
bool cf_high_level_commander_is_trajectory_finished(const cf_high_level_commander_t *commander,
                                                    const cf_provider_t             *provider,
                                                    const void *provider_state, uint64_t now_us);

// Chooses the groups of the vehicle, one per bit.
void cf_high_level_commander_set_group_mask(cf_high_level_commander_t *commander, uint8_t mask);

// Whether a command for this group concerns the vehicle; group 0 is all vehicles.
bool cf_high_level_commander_is_in_group(const cf_high_level_commander_t *commander, uint8_t group);

// Every 10th step fills setpoint with the planner's goal (or with the null setpoint while it is
// stopped) and returns true. Returns false at other steps, while disabled, and when a number of the
// goal is not finite, which disables the planner. Body rates alone may be missing, where the thrust
// has no direction (free fall): they become 0.
bool cf_high_level_commander_get_setpoint(cf_high_level_commander_t *commander,
                                          const cf_provider_t *provider, void *provider_state,
                                          const state_t *estimate, stabilizerStep_t step,
                                          uint64_t now_us, setpoint_t *setpoint);

// Blocks commands or lets them pass. A plan under way is stopped when blocking begins.
void cf_high_level_commander_block(cf_high_level_commander_t *commander,
                                   const cf_provider_t *provider, void *provider_state, bool block);

// Lets the next plan start at this state estimate.
void cf_high_level_commander_tell_state(cf_high_level_commander_t *commander,
                                        const state_t             *estimate);

cf_variables_t cf_high_level_commander_parameters(void);  // hlCommander.*

#endif  // CF_ONBOARD_COMMANDER_HIGH_LEVEL_COMMANDER_H
