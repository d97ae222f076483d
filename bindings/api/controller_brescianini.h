/* The controller of Brescianini, Hehn and D'Andrea: a thrust direction from the position error,
 * body rates from a quaternion error, torques from the body rates
 * (docs/reference/control-geometric.md#7).
 *
 * Reads every setpoint as a position with feed-forward: position, velocity, acceleration, yaw and
 * yaw rate, whatever the modes say; only mode.z = modeDisable counts, it stops the motors.
 *
 * Upstream keeps its state at file scope, and mass and gains as constants or parameters; here all
 * of it is a struct that the caller owns and passes as first argument. */
#ifndef CONTROLLER_BRESCIANINI_H
#define CONTROLLER_BRESCIANINI_H

#include <stdbool.h>

#include "api/stabilizer_types.h"

typedef struct {
  // parameters ctrlAtt.*
  float tau_xy;         // [s], time constants of the position
  float tau_z;          // [s]
  float zeta_xy;        // damping of the position
  float zeta_z;         //
  float tau_rp;         // [s], time constant of the attitude
  float mixing_factor;  // 0: thrust direction only, 1: yaw at the same pace
  float coll_fairness;  // in [0, 1]: what gives way when thrust is short, 0 = x and y alone

  float mass;  // [kg], of the airframe, a constant upstream

  // state, held between the ticks of the outer loop
  float omega[3];              // [rad/s], commanded body rates
  float control_thrust_accel;  // [m/s^2], commanded collective
} controllerBrescianini_t;

// What selecting this controller does: nothing. State and gains live on.
void controllerBrescianiniInit(controllerBrescianini_t *self);

// True.
bool controllerBrescianiniTest(const controllerBrescianini_t *self);

// Computes `control` at one step of the 1 kHz loop, in force-torque mode. Position and attitude run
// at every tenth step, the body rates at every step.
void controllerBrescianini(controllerBrescianini_t *self, control_t *control,
                           const setpoint_t *setpoint, const sensorData_t *sensors,
                           const state_t *state, const stabilizerStep_t stabilizerStep);

#endif  // CONTROLLER_BRESCIANINI_H
