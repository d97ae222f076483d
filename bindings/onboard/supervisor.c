#include "onboard/supervisor.h"

#include <math.h>
#include <stddef.h>

#include "api/planner.h"
#include "variable_row.h"

// docs/reference/planner-commander.md#8.3, #14.2 and #14.3.
#define SETPOINT_WARNING_MS 500
#define SETPOINT_TIMEOUT_MS 2000
#define IS_FLYING_HYSTERESIS_MS 2000
#define EMERGENCY_WATCHDOG_MS 1000

#define FREE_FALL_G 0.1f  // [g], below it on all axes the vehicle falls
#define TILT_G 0.5f       // [g], acc.z below it is a tilt: 60 deg at rest
#define TILT_MS 1000
#define UPSIDE_DOWN_G -0.2f  // [g], acc.z below it is upside down
#define UPSIDE_DOWN_MS 100

#define PREFLIGHT_TIMEOUT_MS 30000
#define LANDED_TIMEOUT_MS 3000

void cf_supervisor_init(cf_supervisor_t *supervisor, bool auto_arming) {
  *supervisor = (cf_supervisor_t){
      .auto_arming   = auto_arming,
      .prefltTimeout = PREFLIGHT_TIMEOUT_MS,
      .landedTimeout = LANDED_TIMEOUT_MS,
      .tmblChckEn    = 1,
      .state         = supervisorStateNotInitialized,
  };
}

static bool is_flying(cf_supervisor_t *supervisor, const cf_supervisor_inputs_t *inputs) {
  for (int i = 0; i < STABILIZER_NR_OF_MOTORS; i++) {
    if (inputs->motor_ratio[i] > inputs->idle_thrust) {
      supervisor->thrust_tick = inputs->now;
    }
  }
  return supervisor->thrust_tick != 0 &&
         inputs->now - supervisor->thrust_tick < IS_FLYING_HYSTERESIS_MS;
}

// Has it lain on its side for a second, or upside down for a tenth of one.
static bool is_tumbled(cf_supervisor_t *supervisor, const cf_supervisor_inputs_t *inputs) {
  const Axis3f *acc = &inputs->acc;
  const bool    free_fall =
      fabsf(acc->x) < FREE_FALL_G && fabsf(acc->y) < FREE_FALL_G && fabsf(acc->z) < FREE_FALL_G;
  if (free_fall || !(acc->z < TILT_G)) {
    supervisor->tumble_tick = 0;
    return false;
  }

  if (supervisor->tumble_tick == 0) {
    supervisor->tumble_tick = inputs->now;
  }
  const uint32_t elapsed = inputs->now - supervisor->tumble_tick;
  return elapsed > TILT_MS || (acc->z < UPSIDE_DOWN_G && elapsed > UPSIDE_DOWN_MS);
}

static bool is_emergency(const cf_supervisor_t *supervisor, uint32_t now) {
  const bool watchdog = supervisor->emergency_watchdog_started &&
                        now - supervisor->emergency_watchdog_tick >= EMERGENCY_WATCHDOG_MS;
  return watchdog || supervisor->emergency_stop_requested || supervisor->stop != 0;
}

static uint32_t bit(bool condition, cf_condition_t number) {
  return condition ? 1u << number : 0u;
}

static uint32_t find_conditions(cf_supervisor_t *supervisor, const cf_supervisor_inputs_t *inputs) {
  const uint32_t now          = inputs->now;
  const uint32_t setpoint_age = now - inputs->setpoint_tick;

  // the tumble check runs in any case: its clock has to follow
  const bool tumbled = is_tumbled(supervisor, inputs) && supervisor->tmblChckEn != 0;

  const bool preflight_timeout = supervisor->state == supervisorStateReadyToFly &&
                                 now - supervisor->arming_tick > supervisor->prefltTimeout;
  const bool landing_timeout =
      supervisor->landing_tick != 0 && now - supervisor->landing_tick > supervisor->landedTimeout;

  return bit(supervisor->is_armed, CF_CONDITION_ARMED) |
         bit(is_flying(supervisor, inputs), CF_CONDITION_IS_FLYING) |
         bit(tumbled, CF_CONDITION_IS_TUMBLED) |
         bit(setpoint_age > SETPOINT_WARNING_MS, CF_CONDITION_COMMANDER_WDT_WARNING) |
         bit(setpoint_age > SETPOINT_TIMEOUT_MS, CF_CONDITION_COMMANDER_WDT_TIMEOUT) |
         bit(is_emergency(supervisor, now), CF_CONDITION_EMERGENCY_STOP) |
         bit(supervisor->is_crashed, CF_CONDITION_CRASHED) |
         bit(preflight_timeout, CF_CONDITION_PREFLIGHT_TIMEOUT) |
         bit(landing_timeout, CF_CONDITION_LANDING_TIMEOUT);
}

static bool are_motors_allowed_in(supervisorState_t state) {
  return state == supervisorStateReadyToFly || state == supervisorStateFlying ||
         state == supervisorStateWarningLevelOut || state == supervisorStateLanded;
}

// What the firmware prints when it goes from one state to another.
static const char *console_line(const cf_supervisor_t *supervisor, supervisorState_t from,
                                supervisorState_t to) {
  if (to == supervisorStateLocked) {
    return "Locked, reboot required";
  }
  if (to == supervisorStateCrashed) {
    return "Crashed, recovery required";
  }
  if (supervisor->auto_arming) {
    return NULL;
  }
  if (to == supervisorStateReadyToFly) {
    return "Ready to fly";
  }
  const bool disarms = to == supervisorStateReset || from == supervisorStateReadyToFly;
  return disarms && !are_motors_allowed_in(to) ? "Disarming" : NULL;
}

// Does what belongs to entering a state.
static void enter(cf_supervisor_t *supervisor, supervisorState_t state, uint32_t now) {
  supervisor->state = state;
  if (state == supervisorStateReadyToFly) {
    supervisor->arming_tick = now;
  }
  if (state == supervisorStateLanded) {
    supervisor->landing_tick = now;
  }
  if (state == supervisorStateCrashed) {
    supervisor->is_crashed = true;
  }
  if (!are_motors_allowed_in(state)) {
    supervisor->is_armed = false;
  }
  if (supervisor->auto_arming && state == supervisorStatePreFlChecksPassed) {
    supervisor->is_armed = true;
  }
}

static void write_outputs(cf_supervisor_t *supervisor, const cf_supervisor_inputs_t *inputs) {
  supervisor->can_fly    = cf_supervisor_are_motors_allowed(supervisor);
  supervisor->is_flying  = supervisor->state == supervisorStateFlying ||
                           supervisor->state == supervisorStateWarningLevelOut;
  supervisor->is_tumbled = (supervisor->conditions & SUPERVISOR_CB_IS_TUMBLED) != 0;

  const bool is_active   = (inputs->planner_state & 1) == 1;
  const bool is_disabled = inputs->planner_state == TRAJECTORY_STATE_DISABLED;
  const int  info  = (cf_supervisor_can_arm(supervisor) ? CF_SUPERVISOR_INFO_CAN_ARM : 0) |
                     (supervisor->is_armed ? CF_SUPERVISOR_INFO_IS_ARMED : 0) |
                     (supervisor->auto_arming ? CF_SUPERVISOR_INFO_AUTO_ARM : 0) |
                     (supervisor->can_fly != 0 ? CF_SUPERVISOR_INFO_CAN_FLY : 0) |
                     (supervisor->is_flying != 0 ? CF_SUPERVISOR_INFO_IS_FLYING : 0) |
                     (supervisor->is_tumbled != 0 ? CF_SUPERVISOR_INFO_IS_TUMBLED : 0) |
                     (cf_supervisor_is_locked(supervisor) ? CF_SUPERVISOR_INFO_IS_LOCKED : 0) |
                     (supervisor->is_crashed ? CF_SUPERVISOR_INFO_IS_CRASHED : 0) |
                     (is_active ? CF_SUPERVISOR_INFO_HL_ACTIVE : 0) |
                     (inputs->planner_is_finished ? CF_SUPERVISOR_INFO_HL_FINISHED : 0) |
                     (is_disabled ? CF_SUPERVISOR_INFO_HL_DISABLED : 0);
  supervisor->info = (uint16_t)info;
}

const char *cf_supervisor_update(cf_supervisor_t *supervisor, const cf_supervisor_inputs_t *inputs,
                                 stabilizerStep_t step) {
  if (step % (RATE_MAIN_LOOP / RATE_SUPERVISOR) != 0) {
    return NULL;
  }

  supervisor->conditions = find_conditions(supervisor, inputs);

  const char             *line = NULL;
  const supervisorState_t from = supervisor->state;
  const supervisorState_t to   = supervisorStateUpdate(from, supervisor->conditions);
  if (to != from) {
    line = console_line(supervisor, from, to);
    enter(supervisor, to, inputs->now);
  }

  write_outputs(supervisor, inputs);
  supervisor->infdmp = 0;
  return line;
}

void cf_supervisor_override_setpoint(const cf_supervisor_t *supervisor, setpoint_t *setpoint) {
  switch (supervisor->state) {
    case supervisorStateReadyToFly:
    case supervisorStateFlying:
    case supervisorStateLanded:
      break;

    case supervisorStateWarningLevelOut:
      // hover level on the spot, at the height that was asked for
      setpoint->mode.x           = modeDisable;
      setpoint->mode.y           = modeDisable;
      setpoint->mode.roll        = modeAbs;
      setpoint->mode.pitch       = modeAbs;
      setpoint->mode.yaw         = modeVelocity;
      setpoint->attitude.roll    = 0.0f;
      setpoint->attitude.pitch   = 0.0f;
      setpoint->attitudeRate.yaw = 0.0f;
      break;

    default:
      *setpoint = (setpoint_t){.timestamp = 0};
      break;
  }
}

bool cf_supervisor_are_motors_allowed(const cf_supervisor_t *supervisor) {
  return are_motors_allowed_in(supervisor->state);
}

bool cf_supervisor_can_fly(const cf_supervisor_t *supervisor) {
  return supervisor->can_fly != 0;
}

bool cf_supervisor_is_flying(const cf_supervisor_t *supervisor) {
  return supervisor->is_flying != 0;
}

bool cf_supervisor_is_tumbled(const cf_supervisor_t *supervisor) {
  return supervisor->is_tumbled != 0;
}

bool cf_supervisor_can_arm(const cf_supervisor_t *supervisor) {
  return supervisor->state == supervisorStatePreFlChecksPassed;
}

bool cf_supervisor_is_armed(const cf_supervisor_t *supervisor) {
  return supervisor->is_armed;
}

bool cf_supervisor_is_locked(const cf_supervisor_t *supervisor) {
  return supervisor->state == supervisorStateLocked;
}

bool cf_supervisor_is_crashed(const cf_supervisor_t *supervisor) {
  return supervisor->is_crashed;
}

bool cf_supervisor_request_arming(cf_supervisor_t *supervisor, bool arm) {
  if (arm == supervisor->is_armed) {
    return true;
  }
  if (arm && !cf_supervisor_can_arm(supervisor)) {
    return false;
  }
  supervisor->is_armed = arm;
  return true;
}

bool cf_supervisor_request_crash_recovery(cf_supervisor_t *supervisor, bool recover) {
  if (!recover) {
    supervisor->is_crashed = true;
    return true;
  }
  if (supervisor->is_crashed && cf_supervisor_is_tumbled(supervisor)) {
    return false;
  }
  supervisor->is_crashed = false;
  return true;
}

void cf_supervisor_request_emergency_stop(cf_supervisor_t *supervisor) {
  supervisor->emergency_stop_requested = true;
}

void cf_supervisor_notify_emergency_watchdog(cf_supervisor_t *supervisor, uint32_t now) {
  supervisor->emergency_watchdog_started = true;
  supervisor->emergency_watchdog_tick    = now;
}

static const cf_variable_t PARAMETERS[] = {
    CF_ROW("stabilizer", "stop", UINT8, CF_CORE, cf_supervisor_t, stop),
    CF_ROW("supervisor", "infdmp", UINT8, 0, cf_supervisor_t, infdmp),
    CF_ROW("supervisor", "prefltTimeout", UINT16, CF_PERSISTENT, cf_supervisor_t, prefltTimeout),
    CF_ROW("supervisor", "landedTimeout", UINT16, CF_PERSISTENT, cf_supervisor_t, landedTimeout),
    CF_ROW("supervisor", "tmblChckEn", UINT8, CF_PERSISTENT, cf_supervisor_t, tmblChckEn),
};

static const cf_variable_t LOGS[] = {
    CF_ROW("sys", "canfly", UINT8, CF_CORE, cf_supervisor_t, can_fly),
    CF_ROW("sys", "isFlying", UINT8, CF_CORE, cf_supervisor_t, is_flying),
    CF_ROW("sys", "isTumbled", UINT8, CF_CORE, cf_supervisor_t, is_tumbled),
    CF_ROW("sys", "armed", UINT8, 0, cf_supervisor_t, is_armed),
    CF_ROW("supervisor", "info", UINT16, 0, cf_supervisor_t, info),
};

cf_variables_t cf_supervisor_parameters(void) {
  return (cf_variables_t){PARAMETERS, (int)(sizeof PARAMETERS / sizeof PARAMETERS[0]), 0};
}

cf_variables_t cf_supervisor_logs(void) {
  return (cf_variables_t){LOGS, (int)(sizeof LOGS / sizeof LOGS[0]), 0};
}
