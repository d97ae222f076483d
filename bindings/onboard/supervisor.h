/* The supervisor: decides 25 times a second whether the motors may run, and overrides setpoints
 * that are too old.
 *
 * Without the spin-up state "arming" of the trees of mid 2026. Source:
 * docs/reference/planner-commander.md#14. Ticks are [ms]. */
#ifndef CF_ONBOARD_SUPERVISOR_H
#define CF_ONBOARD_SUPERVISOR_H

#include <stdbool.h>
#include <stdint.h>

#include "api/stabilizer_types.h"
#include "onboard/supervisor_state_machine.h"
#include "variables.h"

// Bits of cf_supervisor_t.info (log supervisor.info).
#define CF_SUPERVISOR_INFO_CAN_ARM 1
#define CF_SUPERVISOR_INFO_IS_ARMED 2
#define CF_SUPERVISOR_INFO_AUTO_ARM 4
#define CF_SUPERVISOR_INFO_CAN_FLY 8
#define CF_SUPERVISOR_INFO_IS_FLYING 16
#define CF_SUPERVISOR_INFO_IS_TUMBLED 32
#define CF_SUPERVISOR_INFO_IS_LOCKED 64
#define CF_SUPERVISOR_INFO_IS_CRASHED 128
#define CF_SUPERVISOR_INFO_HL_ACTIVE 256
#define CF_SUPERVISOR_INFO_HL_FINISHED 512
#define CF_SUPERVISOR_INFO_HL_DISABLED 1024

typedef struct {
  // settings
  bool     auto_arming;
  uint8_t  stop;           // param stabilizer.stop: emergency stop while not 0
  uint8_t  infdmp;         // param supervisor.infdmp: prints the state once and clears itself
  uint16_t prefltTimeout;  // [ms], from arming until the vehicle has to fly
  uint16_t landedTimeout;  // [ms], from landing until the vehicle disarms
  uint8_t  tmblChckEn;     // 0: a tumbled vehicle may fly

  // state
  supervisorState_t state;
  uint32_t          conditions;  // SUPERVISOR_CB_…, of the last update
  bool              is_armed;
  bool              is_crashed;
  bool              emergency_stop_requested;
  bool              emergency_watchdog_started;
  uint32_t          emergency_watchdog_tick;  // of the last notification
  uint32_t          tumble_tick;              // since when it lies tilted, 0 = it does not
  uint32_t          thrust_tick;   // when a motor last turned faster than idle, 0 = never
  uint32_t          arming_tick;   // when it last became ready to fly
  uint32_t          landing_tick;  // when it last landed, 0 = never

  // outputs of the last update, logged
  uint8_t  can_fly;     // log sys.canfly
  uint8_t  is_flying;   // log sys.isFlying
  uint8_t  is_tumbled;  // log sys.isTumbled
  uint16_t info;        // log supervisor.info
} cf_supervisor_t;

// What one update looks at.
typedef struct {
  Axis3f   acc;                                   // [g], specific force: z = +1 at rest
  uint32_t setpoint_tick;                         // timestamp of the commander's setpoint
  uint32_t now;                                   // tick
  uint32_t motor_ratio[STABILIZER_NR_OF_MOTORS];  // [0, 65535], last commanded; 0 while stopped
  uint32_t idle_thrust;                           // [0, 65535]
  int      planner_state;                         // enum trajectory_state
  bool     planner_is_finished;
} cf_supervisor_inputs_t;

// Starts up, not armed, with default parameters. `auto_arming` is what the platform was built with:
// true for brushed vehicles, false where the motors require arming.
void cf_supervisor_init(cf_supervisor_t *supervisor, bool auto_arming);

// Advances the state machine at every 40th step, otherwise does nothing. Returns the line that the
// firmware prints on its console about a transition, or null.
const char *cf_supervisor_update(cf_supervisor_t *supervisor, const cf_supervisor_inputs_t *inputs,
                                 stabilizerStep_t step);

// Changes a setpoint that the present state does not allow: levels it out or makes it null. Every
// step.
void cf_supervisor_override_setpoint(const cf_supervisor_t *supervisor, setpoint_t *setpoint);

// May the motors run, in the present state.
bool cf_supervisor_are_motors_allowed(const cf_supervisor_t *supervisor);

// The same as of the last update, and whether the vehicle flew or lay tumbled then.
bool cf_supervisor_can_fly(const cf_supervisor_t *supervisor);
bool cf_supervisor_is_flying(const cf_supervisor_t *supervisor);
bool cf_supervisor_is_tumbled(const cf_supervisor_t *supervisor);

bool cf_supervisor_can_arm(const cf_supervisor_t *supervisor);
bool cf_supervisor_is_armed(const cf_supervisor_t *supervisor);
bool cf_supervisor_is_locked(const cf_supervisor_t *supervisor);
bool cf_supervisor_is_crashed(const cf_supervisor_t *supervisor);

// Arms or disarms from the next update on. Returns false when it may not be armed now.
bool cf_supervisor_request_arming(cf_supervisor_t *supervisor, bool arm);

// Declares a crash recovered (false while it still lies tumbled), or with recover = false declares
// one.
bool cf_supervisor_request_crash_recovery(cf_supervisor_t *supervisor, bool recover);

// Emergency stop: latched until the vehicle is started up again.
void cf_supervisor_request_emergency_stop(cf_supervisor_t *supervisor);

// Starts or feeds the emergency watchdog: from now on an emergency stop follows 1000 ms after the
// last notification.
void cf_supervisor_notify_emergency_watchdog(cf_supervisor_t *supervisor, uint32_t now);

cf_variables_t cf_supervisor_parameters(void);  // stabilizer.stop, supervisor.*
cf_variables_t cf_supervisor_logs(void);        // sys.canfly, …, supervisor.info

#endif  // CF_ONBOARD_SUPERVISOR_H
