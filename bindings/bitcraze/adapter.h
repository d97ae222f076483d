/* The functions of the inner table, one file each for what belongs together. Internal to the
 * adapter.
 *
 * They are called with the image of the drone at work in place, so that `state` says nothing:
 * everything is at file scope, in the checkout's files and in ours. */
#ifndef CF_BITCRAZE_ADAPTER_H
#define CF_BITCRAZE_ADAPTER_H

#include "bitcraze/checkout.h"

#define CF_UNUSED __attribute__((unused))

// Prints on the drone's console the first time it is reached by this drone.
#define CF_SAY_ONCE(text_)     \
  do {                         \
    static bool said;          \
    if (!said) {               \
      said = true;             \
      cf_library_print(text_); \
    }                          \
  } while (0)

// ------------------------------------------------------------------------------- controllers.c

void        cf_controllers_boot(void);
cf_status_t cf_controllers_init(void *state, int type);
int         cf_controllers_type(const void *state);
const char *cf_controllers_name(int type);
void        cf_controllers_run(void *state, api_control_t *control, const api_setpoint_t *setpoint,
                               const api_sensorData_t *sensors, const api_state_t *estimate,
                               api_stabilizerStep_t step);
void        cf_controllers_reset_position(void *state, const api_point_t *position);

// ------------------------------------------------------------------------------------- power.c

void     cf_power_boot(cf_platform_t platform);
void     cf_motors_boot(cf_platform_t platform);  // what stands between mixer and motors
void     cf_power_mix(void *state, const api_control_t *control,
                      api_motors_thrust_uncapped_t *uncapped);
void     cf_power_compensate(void *state, const api_motors_thrust_uncapped_t *uncapped,
                             float supply_voltage, api_motors_thrust_uncapped_t *compensated);
bool     cf_power_cap(void *state, const api_motors_thrust_uncapped_t *uncapped,
                      api_motors_thrust_pwm_t *pwm);
uint32_t cf_power_idle_thrust(const void *state);
void     cf_power_override(void *state, float battery_voltage, api_motors_thrust_pwm_t *pwm);

// ------------------------------------------------------------------------------------ kalman.c

// What the estimator's task keeps on the vehicle, for the variables of the group kalman.
typedef struct {
  kalmanCoreData_t   core;
  kalmanCoreParams_t params;
  uint8_t            robust_tdoa;   // parameter: not 0 takes the robust model
  uint8_t            robust_twr;    // parameter: the same for distances
  bool               is_flying;     // told with the latest prediction
  int32_t            sweep_window;  // [ms], log
  float              max_position;  // [m], parameters where the checkout has none
  float              max_velocity;  // [m/s]
} cf_kalman_task_t;
extern cf_kalman_task_t cf_kalman_task;

void cf_kalman_boot(uint32_t now_ms);
void cf_kalman_init(void *state, uint32_t now_ms);
void cf_kalman_predict(void *state, const api_Axis3f *acc, const api_Axis3f *gyro, uint32_t now_ms,
                       bool is_flying);
void cf_kalman_add_process_noise(void *state, uint32_t now_ms);
bool cf_kalman_finalize(void *state);
bool cf_kalman_is_within_bounds(const void *state);
void cf_kalman_externalize(const void *state, api_state_t *estimate, const api_Axis3f *acc);
void cf_kalman_disable_attitude_reversion(void *state);

// -------------------------------------------------------------------------- measurements.c

void cf_measurements_reset(void);  // the outlier filters
void cf_measurements_fuse(void *state, const api_measurement_t *measurement,
                          const api_Axis3f *gyro_latest, uint32_t now_ms);

// -------------------------------------------------------------------------- complementary.c

void cf_complementary_select(void *state);
void cf_complementary_run(void *state, const cf_latest_samples_t *latest, api_state_t *estimate,
                          api_stabilizerStep_t step, uint32_t now_ms);

// ------------------------------------------------------------------------------- planning.c

void cf_planning_boot(void);
int  cf_planning_takeoff(void *state, const cf_plan_start_t *from, float height, float yaw,
                         float duration, float t);
int  cf_planning_land(void *state, const cf_plan_start_t *from, float height, float yaw,
                      float duration, float t);
int  cf_planning_go_to(void *state, const uint8_t *memory, const cf_plan_start_t *from,
                       bool relative, bool linear, struct api_vec goal, float yaw, float duration,
                       float t);
int  cf_planning_spiral(void *state, const cf_plan_start_t *from, const cf_spiral_t *spiral,
                        float t);
int  cf_planning_start_trajectory(void *state, const uint8_t *memory,
                                  const cf_uploaded_trajectory_t *uploaded,
                                  const cf_plan_start_t *from, float t);
void cf_planning_stop(void *state);
void cf_planning_disable(void *state);
bool cf_planning_is_stopped(const void *state);
bool cf_planning_is_disabled(const void *state);
bool cf_planning_is_finished(const void *state, const uint8_t *memory, float t);
int  cf_planning_state(const void *state);
struct api_traj_eval cf_planning_current_goal(void *state, const uint8_t *memory, float t);

// -------------------------------------------------------------------- collision_avoidance.c

typedef struct {
  uint8_t                      enable;  // parameter: 0 is off
  collision_avoidance_params_t params;
  collision_avoidance_state_t  state;
  uint32_t                     latency;  // [ticks], log: computing is instant
} cf_avoidance_t;
extern cf_avoidance_t cf_avoidance;

bool cf_avoidance_is_enabled(const void *state);
void cf_avoidance_run(void *state, api_setpoint_t *setpoint, const cf_peer_t *peers,
                      const api_sensorData_t *sensors, const api_state_t *estimate,
                      uint32_t now_ms);

// ------------------------------------------------------------------------------ out_of_tree.c

void cf_out_of_tree_control(control_t *control, const setpoint_t *setpoint,
                            const sensorData_t *sensors, const state_t *state,
                            stabilizerStep_t step);
void cf_out_of_tree_select_estimator(void *state);
void cf_out_of_tree_estimate(void *state, const api_measurement_t *queue, int count,
                             api_state_t *estimate, api_stabilizerStep_t step, uint32_t now_ms);

#endif  // CF_BITCRAZE_ADAPTER_H
