/* The controller of Lee, Leok and McClamroch, "Geometric tracking control of a quadrotor UAV on
 * SE(3)", with the firmware's names (docs/reference/control-geometric.md#11).
 *
 * It asks for newtons and newton meters. */
#ifndef CONTROLLER_LEE_H
#define CONTROLLER_LEE_H

#include <stdbool.h>

#include "api/math3d.h"
#include "api/stabilizer_types.h"

typedef struct {
  float mass;      // [kg]
  float thrustSi;  // [N], log

  struct vec J;  // [kg m^2], principal moments of inertia

  // acceleration: gains and how much of an error counts, per axis
  struct vec Kpos_P;        // [1/s^2]
  float      Kpos_P_limit;  // [m]
  struct vec Kpos_D;        // [1/s]
  float      Kpos_D_limit;  // [m/s]
  struct vec Kpos_I;        // [1/s^3]
  float      Kpos_I_limit;  // without effect, as in the firmware
  struct vec i_error_pos;   // [m s], unlimited
  struct vec p_error;       // [m], log
  struct vec v_error;       // [m/s], log

  // torque
  struct vec KR;           // [N m], per rotation error
  struct vec Komega;       // [N m s/rad]
  struct vec KI;           // [N m/s]
  struct vec i_error_att;  // [s], unlimited

  // logs
  struct vec   rpy;      // [rad], right-handed
  struct vec   rpy_des;  // [rad]
  struct mat33 R_des;    // body to world
  struct vec   omega;    // [rad/s], body
  struct vec   omega_r;  // [rad/s], desired, seen from the present body
  struct vec   u;        // [N m], torque

  // not in upstream's struct: there the mixer is asked
  float max_thrust;  // [N], of the four motors together
} controllerLee_t;

// Writes the whole struct: default gains, with mass and thrust of a Crazyflie 2.1+.
void controllerLeeInit(controllerLee_t *self);

// Both integrals start over.
void controllerLeeReset(controllerLee_t *self);

// Computes `control` at one step of the 1 kHz loop; odd steps leave it as it is. Follows position
// on all axes when one of mode.x, mode.y and mode.z is absolute, and is flown by attitude and
// thrust otherwise.
void controllerLee(controllerLee_t *self, control_t *control, const setpoint_t *setpoint,
                   const sensorData_t *sensors, const state_t *state,
                   const stabilizerStep_t stabilizerStep);

#endif  // CONTROLLER_LEE_H
