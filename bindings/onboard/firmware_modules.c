#include "onboard/firmware_modules.h"

#include <string.h>

cf_status_t cf_firmware_modules_boot(cf_onboard_t *onboard, const cf_provider_t *provider,
                                     void *provider_state, const cf_boot_t *boot) {
  const cf_system_boot_t theirs = {
      .estimator                 = boot->estimator,
      .controller                = boot->controller,
      .is_attitude_reversion_off = boot->is_attitude_reversion_off,
  };
  const cf_status_t status = provider->system->boot(provider_state, &theirs);
  onboard->estimator_type  = (uint8_t)boot->estimator;
  onboard->estimator.type  = (uint8_t)boot->estimator;
  return status;
}

static void mirror_supervisor(cf_supervisor_t *supervisor, const cf_system_outputs_t *outputs) {
  const uint16_t info    = outputs->info;
  supervisor->info       = info;
  supervisor->state      = (supervisorState_t)outputs->state;
  supervisor->is_armed   = (info & CF_SUPERVISOR_INFO_IS_ARMED) != 0;
  supervisor->is_crashed = (info & CF_SUPERVISOR_INFO_IS_CRASHED) != 0;
  supervisor->can_fly    = (info & CF_SUPERVISOR_INFO_CAN_FLY) != 0;
  supervisor->is_flying  = (info & CF_SUPERVISOR_INFO_IS_FLYING) != 0;
  supervisor->is_tumbled = (info & CF_SUPERVISOR_INFO_IS_TUMBLED) != 0;
}

static void mirror(cf_onboard_t *onboard, const cf_system_outputs_t *outputs) {
  onboard->step                  = outputs->step;
  onboard->estimate              = outputs->estimate;
  onboard->setpoint              = outputs->setpoint;
  onboard->control               = outputs->control;
  onboard->control_yaw           = outputs->control.yaw;
  onboard->motors                = outputs->motors;
  onboard->estimator.type        = (uint8_t)outputs->estimator;
  onboard->estimator.estimate    = outputs->estimate;  // what decks ask for
  onboard->commander.setpoint    = outputs->setpoint;
  onboard->commander.priority    = outputs->priority;
  onboard->high_level.is_blocked = outputs->is_blocked;
  onboard->plan_is_finished      = outputs->is_finished;
  if (outputs->step != 0) {
    // what a client chose before the loop begins is still to be carried out
    onboard->controller_type = (uint8_t)outputs->controller;
    onboard->estimator_type  = (uint8_t)outputs->estimator;
  }
  onboard->high_level.group_mask = outputs->group_mask;
  mirror_supervisor(&onboard->supervisor, outputs);
}

void cf_firmware_modules_tick(cf_onboard_t *onboard, const cf_provider_t *provider,
                              void *provider_state, bool are_calibrated, bool is_held) {
  measurement_t            queue[CF_ESTIMATOR_QUEUE_SIZE];
  cf_resolved_sweep_t      sweeps[CF_ESTIMATOR_QUEUE_SIZE];
  const cf_system_inputs_t inputs = {
      .now_ms          = onboard->tick,
      .sensors         = &onboard->sensors.data,
      .are_calibrated  = are_calibrated,
      .queue           = queue,
      .count           = cf_estimator_take_queue(&onboard->estimator, queue, sweeps),
      .battery_voltage = onboard->power.voltage,
      .peers           = onboard->peers.peers,
      .controller      = onboard->controller_type,
      .estimator       = onboard->estimator_type,
      .is_held         = is_held,
  };
  // a tick in which no controller runs keeps these values
  cf_system_outputs_t outputs = {
      .step       = onboard->step,
      .estimate   = onboard->estimate,
      .setpoint   = onboard->setpoint,
      .control    = onboard->control,
      .group_mask = onboard->high_level.group_mask,
  };
  const stabilizerStep_t before = onboard->step;
  provider->system->tick(provider_state, &inputs, &outputs);
  if (onboard->fault != CF_FAULT_NONE) {
    return;
  }
  if (is_held) {
    outputs.motors = onboard->motors;
  }
  mirror(onboard, &outputs);
  if (!is_held) {
    provider->motor_override(provider_state, onboard->power.voltage, &onboard->motors);
  }
  if (onboard->step != before && onboard->step % (RATE_MAIN_LOOP / RATE_SUPERVISOR) == 0) {
    cf_power_management_update(&onboard->power, onboard->tick);
    cf_system_variables_update(&onboard->system);
  }
}
