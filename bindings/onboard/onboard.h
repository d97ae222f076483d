/* The onboard software of one Crazyflie around a provider: the stabilizer loop and everything it
 * drives.
 *
 * Source: docs/reference/control-pid.md#4, docs/reference/planner-commander.md#8.5,
 * docs/reference/estimators.md#8 and #13.3. */
#ifndef CF_ONBOARD_ONBOARD_H
#define CF_ONBOARD_ONBOARD_H

#include <stdbool.h>
#include <stdint.h>

#include "api/stabilizer_types.h"
#include "onboard/commander/commander.h"
#include "onboard/commander/cppm.h"
#include "onboard/commander/high_level_commander.h"
#include "onboard/commander/rpyt.h"
#include "onboard/commander/setpoints.h"
#include "onboard/compressed.h"
#include "onboard/console.h"
#include "onboard/decks/decks.h"
#include "onboard/estimator.h"
#include "onboard/health.h"
#include "onboard/lights.h"
#include "onboard/peer_localization.h"
#include "onboard/power_management.h"
#include "onboard/sensors.h"
#include "onboard/supervisor.h"
#include "onboard/system_variables.h"
#include "provider.h"
#include "status.h"
#include "variables.h"

#define CF_FAILURE_BYTES 192

// Why a drone was stopped until it is booted again: its numbers were no longer finite, a provider
// gave up, there was no power, or the program that flies it failed.
typedef enum {
  CF_FAULT_NONE     = 0,
  CF_FAULT_MOTION   = 1,  // the simulated motion is not a number, or without bounds
  CF_FAULT_ESTIMATE = 2,  // the state estimate is not a number
  CF_FAULT_CONTROL  = 3,  // the controller's output is not a number
  CF_FAULT_SOFTWARE = 4,  // code of a provider failed; onboard.failure says how
  CF_FAULT_POWER    = 5,  // the battery was cut
  CF_FAULT_PILOT    = 6,  // the program that commands the drone failed; onboard.failure says how
} cf_fault_t;

// What the hardware delivers every millisecond.
typedef struct {
  Axis3i16 gyro;             // [LSB]
  Axis3i16 acc;              // [LSB]
  float    battery_voltage;  // [V]
  bool     has_pressure;     // the barometer has a new sample
  float    pressure;         // [Pa]
  float    temperature;      // [deg C], of the barometer
} cf_hardware_t;

// What is chosen before the onboard software boots.
typedef struct {
  int   controller;                 // ControllerType
  int   estimator;                  // StateEstimatorType
  bool  auto_arming;                // arms by itself when the pre-flight checks pass
  bool  is_attitude_reversion_off;  // a deck cannot live with the drift to the first attitude
  float acc_trim_pitch;             // [deg], see cf_sensors_set_trim
  float acc_trim_roll;              // [deg]

  cf_platform_t platform;
  uint32_t      seed;  // with `serial` it makes the unique id of the processor
  uint32_t      serial;
  uint8_t radio_id;  // low byte of the radio address, by which packed positions name a vehicle
} cf_boot_t;

// A program beside the onboard software that is the controller, such as a policy that is being
// trained: what it holds flies in place of what a controller computes. Not with a provider that
// flies its own modules.
typedef struct {
  bool      is_on;
  control_t control;
} cf_held_control_t;

// The order of members keeps together what a tick touches, so that it lies in few pages of memory:
// a thousand drones are more than a cache holds, and the sensors begin with a large buffer that is
// only used while they calibrate.
typedef struct {
  cf_sensors_t sensors;

  // parameters
  uint8_t estimator_type;    // stabilizer.estimator
  uint8_t controller_type;   // stabilizer.controller
  float   ext_pos_std_dev;   // [m], locSrv.extPosStdDev
  float   ext_quat_std_dev;  // [rad], locSrv.extQuatStdDev

  // loop
  uint32_t         tick;  // [ms] since boot
  stabilizerStep_t step;  // 0 until the sensors are calibrated, then counts from 1
  cf_fault_t       fault;
  uint32_t         fault_tick;  // [ms], when it happened

  // what flows through the loop
  state_t                  estimate;
  setpoint_t               setpoint;
  control_t                control;
  cf_held_control_t        held_control;
  motors_thrust_uncapped_t uncapped;
  motors_thrust_uncapped_t compensated;
  motors_thrust_pwm_t      motors;       // what the motor drivers hold; 0 while stopped
  int16_t                  control_yaw;  // log controller.ctr_yaw
  bool              plan_is_finished;  // said by a provider that flies its own high-level commander
  float             supply_voltage;    // [V], filtered for the compensation
  poseMeasurement_t external_pose;     // the last one received, log locSrv
  uint16_t          external_tick;     // [ms], low half of when; log locSrvZ.tick
  uint8_t           radio_id;          // low byte of the radio address

  // log variables; cf_onboard_refresh_logs computes the compressed ones when they are read
  float                 loop_rate;   // [Hz], stabilizer.rtStab: over the latest 500 ms
  uint32_t              rate_tick;   // [ms], when it was counted
  stabilizerStep_t      rate_step;   // how far the loop was then
  uint32_t              int_to_out;  // [us], stabilizer.intToOut: 0, computing takes no time here
  cf_compressed_state_t compressed_state;
  cf_compressed_setpoint_t compressed_setpoint;

  // modules that every tick looks at
  cf_supervisor_t           supervisor;
  cf_power_management_t     power;
  cf_health_t               health;
  cf_commander_t            commander;
  cf_estimator_t            estimator;
  cf_high_level_commander_t high_level;  // ends with the trajectory memory

  // and the others
  cf_system_variables_t  system;
  setpoint_t             client_setpoint;  // kept between packets of the client (rpyt)
  cf_rpyt_t              rpyt;
  cf_cppm_t              cppm;
  cf_decks_t             decks;
  cf_peer_localization_t peers;
  cf_console_t           console;
  char                   failure[CF_FAILURE_BYTES];  // ends with a zero
  cf_lights_t            lights;
} cf_onboard_t;

// Boots everything at tick 0, but leaves the console alone, on which the provider may have printed
// already. The provider's state must be initialised. Returns CF_ERR_UNKNOWN for a controller or
// estimator that does not exist.
cf_status_t cf_onboard_init(cf_onboard_t *onboard, const cf_provider_t *provider,
                            void *provider_state, const cf_boot_t *boot);

// One millisecond of the whole software; the result is in `motors`.
void cf_onboard_tick(cf_onboard_t *onboard, const cf_provider_t *provider, void *provider_state,
                     const cf_hardware_t *hardware);

// A pose from a motion-capture system. The standard deviations are those of the parameters
// locSrv.*. Returns false when the queue of the estimator is full.
bool cf_onboard_external_pose(cf_onboard_t *onboard, const poseMeasurement_t *pose);

// A position alone, likewise.
bool cf_onboard_external_position(cf_onboard_t *onboard, float x, float y, float z);

// Updates the log groups stateEstimateZ and ctrltargetZ. Readers call this first, so that the tick
// need not compute them. Nothing in the tick reads them.
void cf_onboard_refresh_logs(cf_onboard_t *onboard);

// Stops the motors and locks the supervisor until the next boot.
void cf_onboard_fail(cf_onboard_t *onboard, cf_fault_t fault);

// The same with CF_FAULT_SOFTWARE or CF_FAULT_PILOT, for a reason in words.
void cf_onboard_fail_because(cf_onboard_t *onboard, const char *reason);
void cf_onboard_fail_pilot(cf_onboard_t *onboard, const char *reason);

// A sentence about a fault, never null.
const char *cf_fault_text(cf_fault_t fault);

cf_variables_t cf_onboard_parameters(void);
cf_variables_t cf_onboard_logs(void);

#endif  // CF_ONBOARD_ONBOARD_H
