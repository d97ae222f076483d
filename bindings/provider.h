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

#define CF_PROVIDER_STATE_BYTES 4096

// Controller numbers of the firmware (control-pid dossier section 5).
typedef enum {
  ControllerTypeAutoSelect  = 0,
  ControllerTypePID         = 1,
  ControllerTypeMellinger   = 2,
  ControllerTypeINDI        = 3,
  ControllerTypeBrescianini = 4,
  ControllerTypeLee         = 5,
  ControllerType_COUNT      = 6,
} ControllerType;

// Where a high-level plan starts, or what the planner asks for.
typedef struct {
  struct vec pos;  // [m]
  struct vec vel;  // [m/s]
  float      yaw;  // [rad]
} cf_plan_start_t;

// An uploaded trajectory, found by its place in trajectory memory. The planner keeps it; pieces are
// passed again at every evaluation because the state may have moved in memory since.
typedef struct {
  uint32_t offset;  // [bytes] in trajectory memory
  uint8_t  n_pieces;
  float    timescale;
  bool     reversed;
  bool     relative_position;
  bool     relative_yaw;
} cf_uploaded_trajectory_t;

typedef struct {
  const char *name;
  size_t      state_bytes;  // at most CF_PROVIDER_STATE_BYTES

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

  // Planner. Times are float32 seconds. Functions returning int return 0 when the plan was made, 1
  // when refused.
  int (*plan_takeoff)(void *state, const cf_plan_start_t *from, float height, float yaw,
                      float duration, float t);
  int (*plan_land)(void *state, const cf_plan_start_t *from, float height, float yaw,
                   float duration, float t);
  int (*plan_go_to)(void *state, const uint8_t *memory, const cf_plan_start_t *from, bool relative,
                    bool linear, struct vec goal, float yaw, float duration, float t);
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

  // Tables of parameters and log variables; bases count from the start of the state block. Fills
  // at most `capacity` tables and returns how many there are.
  int (*parameters)(cf_variables_t *tables, int capacity);
  int (*logs)(cf_variables_t *tables, int capacity);
} cf_provider_t;

// Returns provider number i, or null behind the last one.
const cf_provider_t *cf_provider(int i);

#endif  // CF_PROVIDER_H
