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

// Controller numbers of the firmware (control-pid dossier section 5).
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

// Where another drone was, and when this one was told [ms, its tick]. Id 0 is an empty entry.
typedef struct {
  uint8_t id;
  point_t pos;  // [m], world
} cf_peer_t;

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
  // Before somebody reads log variables: brings those up to date that are computed. May be null.
  void (*refresh_logs)(void *state);
} cf_provider_t;

// Returns provider number i, or null behind the last one.
const cf_provider_t *cf_provider(int i);

#endif  // CF_PROVIDER_H
