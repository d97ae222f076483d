/* The onboard software of one Crazyflie around a provider: the stabilizer loop and everything it
 * drives.
 *
 * Source: control-pid dossier section 4, planner-commander dossier section 8.5, estimators dossier
 * sections 8 and 13.3. */
#ifndef CF_ONBOARD_ONBOARD_H
#define CF_ONBOARD_ONBOARD_H

#include <stdbool.h>
#include <stdint.h>

#include "api/stabilizer_types.h"
#include "onboard/commander.h"
#include "onboard/estimator.h"
#include "onboard/high_level_commander.h"
#include "onboard/sensors.h"
#include "onboard/setpoints.h"
#include "onboard/supervisor.h"
#include "provider.h"
#include "status.h"
#include "variables.h"

// Why a drone was stopped for good: its numbers were no longer finite.
typedef enum {
  CF_FAULT_NONE     = 0,
  CF_FAULT_MOTION   = 1,  // the simulated motion is not a number, or without bounds
  CF_FAULT_ESTIMATE = 2,  // the state estimate is not a number
  CF_FAULT_CONTROL  = 3,  // the controller's output is not a number
} cf_fault_t;

// What the hardware delivers every millisecond.
typedef struct {
  Axis3i16 gyro;             // [LSB]
  Axis3i16 acc;              // [LSB]
  float    battery_voltage;  // [V]
} cf_hardware_t;

// What is chosen before the onboard software boots.
typedef struct {
  int  controller;   // ControllerType
  int  estimator;    // StateEstimatorType
  bool auto_arming;  // arms by itself when the pre-flight checks pass
} cf_boot_t;

typedef struct {
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
  motors_thrust_uncapped_t uncapped;
  motors_thrust_uncapped_t compensated;
  motors_thrust_pwm_t      motors;             // what the motor drivers hold; 0 while stopped
  int16_t                  control_yaw;        // log controller.ctr_yaw
  float                    battery_voltage;    // [V], as measured
  uint16_t                 battery_millivolt;  // [mV]
  float                    supply_voltage;     // [V], filtered for the compensation
  poseMeasurement_t        external_pose;      // the last one received, log locSrv

  // modules, the ones with large memories last
  cf_supervisor_t           supervisor;
  cf_commander_t            commander;
  setpoint_t                client_setpoint;  // kept between packets of the client (rpyt)
  cf_rpyt_t                 rpyt;
  cf_estimator_t            estimator;
  cf_high_level_commander_t high_level;
  cf_sensors_t              sensors;
} cf_onboard_t;

// Boots everything at tick 0. The provider's state must be initialised. Returns CF_ERR_UNKNOWN for
// a controller or estimator that does not exist.
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

// Stops the motors and locks the supervisor until the next boot.
void cf_onboard_fail(cf_onboard_t *onboard, cf_fault_t fault);

// A sentence about a fault, never null.
const char *cf_fault_text(cf_fault_t fault);

cf_variables_t cf_onboard_parameters(void);
cf_variables_t cf_onboard_logs(void);

#endif  // CF_ONBOARD_ONBOARD_H
