/* The legacy command roll, pitch, yaw, thrust, and the flight modes that give its four numbers
 * another meaning (parameters flightmode.*).
 *
 * Source: docs/reference/planner-commander.md#10. One deliberate deviation: in the carefree yaw
 * mode, which halts the firmware, the command is refused. */
#ifndef CF_ONBOARD_COMMANDER_RPYT_H
#define CF_ONBOARD_COMMANDER_RPYT_H

#include <stdbool.h>
#include <stdint.h>

#include "api/stabilizer_types.h"
#include "status.h"
#include "variables.h"

// Values of flightmode.stabModeRoll, stabModePitch and stabModeYaw.
#define CF_STABILIZE_RATE 0
#define CF_STABILIZE_ANGLE 1

// Values of flightmode.yawMode: which way is forward.
#define CF_YAW_MODE_CAREFREE 0
#define CF_YAW_MODE_PLUS 1  // towards motor 1, 45 deg beside the x axis
#define CF_YAW_MODE_X 2     // the x axis

typedef struct {
  // parameters
  uint8_t althold;        // thrust is a climb rate: 32767 holds the height, 0 sinks with 1 m/s
  uint8_t poshold;        // pitch and roll are velocities, 30 for 1 m/s forward and left
  uint8_t posSet;         // -pitch, roll, thrust / 1000 and yaw are a position [m] and an angle
  uint8_t yawMode;        // CF_YAW_MODE_…
  uint8_t stabModeRoll;   // CF_STABILIZE_…: roll is a rate [deg/s] or an angle [deg]
  uint8_t stabModePitch;  // likewise
  uint8_t stabModeYaw;    // likewise; a rate is positive to the right, an angle to the left

  // memory
  bool thrust_is_locked;     // until a thrust of 0 is sent
  bool is_holding_altitude;  // the last command came with althold
} cf_rpyt_t;

// Locked, in the default flight mode: angles of roll and pitch, rate of yaw.
void cf_rpyt_init(cf_rpyt_t *rpyt);

// Makes a setpoint of one command. thrust is in [0, 65535], of which less than 1000 is 0 and more
// than 60000 is 60000; active_priority is the commander's. Members that the flight mode does not
// name keep what they were, as in the firmware: pass the client's last setpoint. When
// is_holding_altitude becomes true, the position loops have to be reset.
//
// Returns CF_ERR_VALUE when a number is not finite or leads to one that is not, CF_ERR_STATE in the
// carefree yaw mode; nothing changes then.
cf_status_t cf_setpoint_rpyt(setpoint_t *setpoint, cf_rpyt_t *rpyt, int active_priority, float roll,
                             float pitch, float yaw, uint16_t thrust);

cf_variables_t cf_rpyt_parameters(void);  // flightmode.*

#endif  // CF_ONBOARD_COMMANDER_RPYT_H
