/* The controller of Mellinger and Kumar, "Minimum snap trajectory generation and control for
 * quadrotors", with the firmware's names (docs/reference/control-geometric.md#6, as of release
 * 2026.08).
 *
 * It asks for counts, not newtons: massThrust converts, and gains of moments are counts too. */
#ifndef CONTROLLER_MELLINGER_H
#define CONTROLLER_MELLINGER_H

#include <stdbool.h>

#include "api/math3d.h"
#include "api/stabilizer_types.h"

typedef struct {
  float mass;        // [kg]
  float massThrust;  // [counts/N], of the four motors together

  // force in the plane
  float kp_xy;       // [N/m]
  float kd_xy;       // [N s/m]
  float ki_xy;       // [N/(m s)]
  float i_range_xy;  // [m s]

  // force along z
  float kp_z;
  float kd_z;
  float ki_z;
  float i_range_z;

  // moments about x and y
  float kR_xy;         // [counts], per rotation error
  float kw_xy;         // [counts s/rad]
  float ki_m_xy;       // [counts/s]
  float i_range_m_xy;  // [s]

  // moment about z
  float kR_z;
  float kw_z;
  float ki_m_z;
  float i_range_m_z;

  float kd_omega_rp;  // [counts s^2/rad], of angular acceleration about x and y

  // integral of the position error
  float i_error_x;  // [m s]
  float i_error_y;
  float i_error_z;

  // of the call before
  float prev_omega_roll;            // [rad/s]
  float prev_omega_pitch;           // [rad/s], legacy sign
  float prev_setpoint_omega_roll;   // [rad/s]
  float prev_setpoint_omega_pitch;  // [rad/s], sign of the gyro's y axis

  // integral of the rotation error, sign reversed
  float i_error_m_x;  // [s]
  float i_error_m_y;
  float i_error_m_z;

  // logs
  struct vec z_axis_desired;  // unit vector, world
  float      cmd_thrust;      // [counts]
  float      cmd_roll;        // [counts]
  float      cmd_pitch;       // [counts]
  float      cmd_yaw;         // [counts]
  float      r_roll;          // [rad/s]
  float      r_pitch;         // [rad/s], legacy sign
  float      r_yaw;           // [rad/s]
  float      accelz;          // [g]
} controllerMellinger_t;

// Writes the whole struct: default gains, with the mass that the firmware of a Crazyflie 2.1+
// believes in.
void controllerMellingerInit(controllerMellinger_t *self);

// Always true.
bool controllerMellingerTest(controllerMellinger_t *self);

// Computes `control` at one step of the 1 kHz loop. On odd steps only the control mode is written.
// Follows position when mode.x is absolute; is flown by attitude and thrust when mode.z is disabled
// and mode.roll and mode.pitch are absolute; stays level and holds its height otherwise.
void controllerMellinger(controllerMellinger_t *self, control_t *control,
                         const setpoint_t *setpoint, const sensorData_t *sensors,
                         const state_t *state, const stabilizerStep_t stabilizerStep);

#endif  // CONTROLLER_MELLINGER_H
