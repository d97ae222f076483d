/* A provider: the firmware's algorithms behind one table of functions and one opaque block of
 * state.
 *
 * onboard/ calls nothing else, so that the same Crazyflie flies our own implementation (builtin) or
 * a user's checkout. The block holds no pointers and may be copied with memcpy. */
#ifndef CF_PROVIDER_H
#define CF_PROVIDER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "api/measurement.h"
#include "api/pptraj.h"
#include "api/stabilizer_types.h"
#include "platform.h"
#include "status.h"
#include "variables.h"

#define CF_PROVIDER_STATE_BYTES 8192
#define CF_PROVIDER_MAX_TABLES 32  // of parameters, and of log variables
#define PEER_LOCALIZATION_MAX_NEIGHBORS 10

#define CF_TRAJECTORY_MEMORY_BYTES 4096

// Controller numbers of the firmware (docs/reference/control-pid.md#5).
typedef enum {
  ControllerTypeAutoSelect  = 0,
  ControllerTypePID         = 1,
  ControllerTypeMellinger   = 2,
  ControllerTypeINDI        = 3,
  ControllerTypeBrescianini = 4,
  ControllerTypeLee         = 5,
  ControllerTypeOot         = 6,  // a user's own C, where a provider carries one
  ControllerType_COUNT      = 7,
} ControllerType;

// Where a high-level plan starts, or what the planner asks for.
typedef struct {
  struct vec pos;  // [m]
  struct vec vel;  // [m/s]
  float      yaw;  // [rad]
} cf_plan_start_t;

typedef enum {
  CF_TRAJECTORY_TYPE_POLY4D            = 0,
  CF_TRAJECTORY_TYPE_POLY4D_COMPRESSED = 1,
} cf_trajectory_type_t;

// An uploaded trajectory, found by its place in trajectory memory. The planner keeps it; the memory
// of CF_TRAJECTORY_MEMORY_BYTES is passed again at every evaluation because the state may have
// moved since. Compressed trajectories end with their bytes, run forward, at their own pace and in
// their own yaw, so that the members marked with * mean nothing to them.
typedef struct {
  cf_trajectory_type_t type;
  uint32_t             offset;     // [bytes] in trajectory memory
  uint8_t              n_pieces;   // *
  float                timescale;  // *
  bool                 reversed;   // *
  bool                 relative_position;
  bool                 relative_yaw;  // *
} cf_uploaded_trajectory_t;

// A spiral about a vertical axis beside the vehicle, which faces along the path or, sideways, flies
// to its left.
typedef struct {
  bool  sideways;
  bool  clockwise;
  float angle;     // [rad], within +-2 pi
  float radius0;   // [m], at the begin
  float radiusF;   // [m], at the end
  float ascent;    // [m]
  float duration;  // [s]
} cf_spiral_t;

// What the complementary estimator looks at: the latest sample of each sensor, zero before the
// first.
typedef struct {
  Axis3f           gyro;  // [deg/s]
  Axis3f           acc;   // [g]
  baro_t           baro;
  tofMeasurement_t tof;
} cf_latest_samples_t;

// Position of another drone; pos.timestamp is the tick [ms] at which this drone received it. Id 0
// is an empty entry.
typedef struct {
  uint8_t id;
  point_t pos;  // [m], world
} cf_peer_t;

#define CF_SYSTEM_PACKET_BYTES 30  // of a packet's data, and of its reply
#define CF_SYSTEM_MEASUREMENTS 20  // that may come in a tick

// How a provider's own modules boot.
typedef struct {
  int  estimator;   // StateEstimatorType, not AutoSelect
  int  controller;  // ControllerType of ours; AutoSelect leaves the choice to the configuration
  bool is_attitude_reversion_off;
} cf_system_boot_t;

// Inputs of the checkout's tasks, every millisecond.
typedef struct {
  uint32_t             now_ms;
  const sensorData_t  *sensors;          // the newest samples, after filters
  bool                 are_calibrated;   // the sensors, before these samples
  const measurement_t *queue;            // what was measured since the tick before, in order
  int                  count;            // of it
  float                battery_voltage;  // [V]
  const cf_peer_t     *peers;            // PEER_LOCALIZATION_MAX_NEIGHBORS entries
  int                  controller;       // parameters of the loop, where the loop is not theirs
  int                  estimator;
  bool                 is_held;  // that loop, while a health test of ours has the motors
} cf_system_inputs_t;

// What they came to.
typedef struct {
  stabilizerStep_t    step;  // 0 until the loop runs
  state_t             estimate;
  setpoint_t          setpoint;
  control_t           control;
  motors_thrust_pwm_t motors;
  int                 controller;  // what is active
  int                 estimator;
  int                 priority;     // of the commander
  bool                is_blocked;   // the high-level commander
  bool                is_finished;  // its trajectory
  uint8_t             group_mask;   // its groups
  int                 state;        // of the supervisor, a supervisorState_t
  uint16_t            info;         // CF_SUPERVISOR_INFO_…
} cf_system_outputs_t;

// Requests of a client that are no packets.
typedef enum {
  CF_SYSTEM_ARM,
  CF_SYSTEM_DISARM,
  CF_SYSTEM_RECOVER,  // from a crash
  CF_SYSTEM_RELAX,    // the commander gives way to the high-level commander
  CF_SYSTEM_EMERGENCY_STOP,
  CF_SYSTEM_FEED_WATCHDOG,  // of the emergency stop
} cf_system_request_t;

// A provider that flies more than the algorithms: the firmware's own commander, high-level
// commander, supervisor, table of controllers, estimator task and, perhaps, its own loop. onboard/
// then keeps the sensor front end, the decks and what the outputs say, and nothing else of its own
// decides anything.
typedef struct {
  const char *modules;       // what is theirs, for people
  bool        has_own_loop;  // with its health tests

  // After cf_provider_t.init. Returns CF_ERR_UNKNOWN for a controller or estimator that they lack,
  // and CF_ERR_STATE when one of their tests fails.
  cf_status_t (*boot)(void *state, const cf_system_boot_t *boot);
  void (*tick)(void *state, const cf_system_inputs_t *inputs, cf_system_outputs_t *outputs);

  // Between two ticks. `set_setpoint` returns whether the commander took it. `packet` hands the
  // data of a CRTP packet to the module of its port, fills `reply` and returns its length, 0 when
  // there is none, and -1 when no module has this port.
  bool (*set_setpoint)(void *state, const setpoint_t *setpoint, int priority, uint32_t now_ms);
  int (*packet)(void *state, uint8_t port, uint8_t channel, const uint8_t *data, int length,
                uint8_t reply[CF_SYSTEM_PACKET_BYTES], uint32_t now_ms);
  bool (*request)(void *state, cf_system_request_t what, uint32_t now_ms);
  bool (*read_trajectory)(void *state, uint32_t offset, uint32_t length, uint8_t *data);
  bool (*write_trajectory)(void *state, uint32_t offset, uint32_t length, const uint8_t *data);
} cf_system_t;

typedef struct {
  const char *name;
  int         platform;     // cf_platform_t, or -1: every one
  size_t      state_bytes;  // whole words of 8; above CF_PROVIDER_STATE_BYTES a drone is longer

  // Everything between the two is for one drone, by one thread. They save work where a call is
  // dear, change nothing, and may be null.
  void (*begin)(void *state);
  void (*end)(void *state);

  // Writes the whole block: gains of the platform, default controller, filter at now_ms.
  cf_status_t (*init)(void *state, cf_platform_t platform, uint32_t now_ms);

  // Controllers. init resets the controller of this number; AutoSelect becomes the default; a
  // number that the provider lacks is CF_ERR_UNKNOWN and changes nothing. `controller_type` tells
  // the active one.
  cf_status_t (*controller_init)(void *state, int type);
  int (*controller_type)(const void *state);
  const char *(*controller_name)(int type);  // null when the provider lacks it
  void (*controller)(void *state, control_t *control, const setpoint_t *setpoint,
                     const sensorData_t *sensors, const state_t *estimate, stabilizerStep_t step);
  // The position loops of the PID controller forget and stand at this position: altitude hold of
  // the legacy commander begins.
  void (*reset_position_control)(void *state, const point_t *position);

  // Mixer. `compensate` turns thrust into duty for the supply [V]; `cap` returns true when it had
  // to reduce.
  void (*power_distribution)(void *state, const control_t *control,
                             motors_thrust_uncapped_t *uncapped);
  void (*battery_compensate)(void *state, const motors_thrust_uncapped_t *uncapped,
                             float supply_voltage, motors_thrust_uncapped_t *compensated);
  bool (*power_cap)(void *state, const motors_thrust_uncapped_t *uncapped,
                    motors_thrust_pwm_t *pwm);
  uint32_t (*idle_thrust)(const void *state);
  // The test override motorPowerSet.*, applied to every duty that is set; battery [V].
  void (*motor_override)(void *state, float battery_voltage, motors_thrust_pwm_t *pwm);

  // Kalman filter. acc in m/s^2 and gyro in rad/s for predict; acc in g for externalize; gyro in
  // deg/s for update.
  void (*kalman_init)(void *state, uint32_t now_ms);
  void (*kalman_predict)(void *state, const Axis3f *acc, const Axis3f *gyro, uint32_t now_ms,
                         bool is_flying);
  void (*kalman_add_process_noise)(void *state, uint32_t now_ms);
  void (*kalman_update)(void *state, const measurement_t *measurement, const Axis3f *gyro_latest,
                        uint32_t now_ms);
  bool (*kalman_finalize)(void *state);
  bool (*kalman_is_within_bounds)(const void *state);
  void (*kalman_externalize)(const void *state, state_t *estimate, const Axis3f *acc);
  // For decks that cannot live with it: on the ground the attitude no longer drifts to the initial
  // one.
  void (*kalman_disable_attitude_reversion)(void *state);

  // Complementary estimator, at 1 kHz. init is what selecting it does: the attitude goes on from
  // where it is. The estimate keeps what is not written: horizontal velocity and acceleration.
  void (*complementary_init)(void *state);
  void (*complementary)(void *state, const cf_latest_samples_t *latest, state_t *estimate,
                        stabilizerStep_t step, uint32_t now_ms);

  // The user's own estimator, at 1 kHz, with what arrived in the queue since the latest call. Both
  // are null where the provider carries none.
  void (*out_of_tree_estimator_init)(void *state);
  void (*out_of_tree_estimator)(void *state, const measurement_t *queue, int count,
                                state_t *estimate, stabilizerStep_t step, uint32_t now_ms);

  // Planner. Times are float32 seconds. Functions returning int return 0 when the plan was made, 1
  // when refused.
  int (*plan_takeoff)(void *state, const cf_plan_start_t *from, float height, float yaw,
                      float duration, float t);
  int (*plan_land)(void *state, const cf_plan_start_t *from, float height, float yaw,
                   float duration, float t);
  int (*plan_go_to)(void *state, const uint8_t *memory, const cf_plan_start_t *from, bool relative,
                    bool linear, struct vec goal, float yaw, float duration, float t);
  int (*plan_spiral)(void *state, const cf_plan_start_t *from, const cf_spiral_t *spiral, float t);
  int (*plan_start_trajectory)(void *state, const uint8_t *memory,
                               const cf_uploaded_trajectory_t *trajectory,
                               const cf_plan_start_t *from, float t);
  void (*plan_stop)(void *state);
  void (*plan_disable)(void *state);
  bool (*plan_is_stopped)(const void *state);
  bool (*plan_is_disabled)(const void *state);
  bool (*plan_is_finished)(const void *state, const uint8_t *memory, float t);
  int (*plan_state)(const void *state);  // IDLE 0, FLYING 1, LANDING 3, DISABLED 4
  struct traj_eval (*plan_current_goal)(void *state, const uint8_t *memory, float t);

  // Collision avoidance, off until a client sets colAv.enable: bends the setpoint away from the
  // peers, a table of PEER_LOCALIZATION_MAX_NEIGHBORS entries. `now_ms` is the drone's tick.
  bool (*collision_avoidance_is_enabled)(const void *state);
  void (*collision_avoidance)(void *state, setpoint_t *setpoint, const cf_peer_t *peers,
                              const sensorData_t *sensors, const state_t *estimate,
                              uint32_t now_ms);

  // Tables of parameters and log variables; bases count from the start of the state block. Fills
  // at most `capacity` tables and returns how many there are.
  int (*parameters)(cf_variables_t *tables, int capacity);
  int (*logs)(cf_variables_t *tables, int capacity);
  // After a client wrote a parameter: runs what the code wants to run then. May be null.
  void (*parameter_written)(void *state, const char *group, const char *name);
  // Called before log variables are read: updates those that are computed on demand. May be null.
  void (*refresh_logs)(void *state);

  const cf_system_t *system;  // null: the algorithms are all there is
} cf_provider_t;

// Returns provider number i, or null behind the last one.
const cf_provider_t *cf_provider(int i);

#endif  // CF_PROVIDER_H
