/* The INDI controller (incremental nonlinear dynamic inversion): attitude by increments of what the
 * motors do already, with position_controller_indi.h as outer loop
 * (docs/reference/control-geometric.md#8 to #10).
 *
 * Works in a body frame with x forward, y right and z down, and with attitudes in the legacy frame.
 *
 * Upstream keeps all of this at file scope and shares the loops of the PID controller; here the
 * state is a struct that the caller owns and passes as first argument, and the PID controller whose
 * loops are shared is the second. */
#ifndef CONTROLLER_INDI_H
#define CONTROLLER_INDI_H

#include <stdbool.h>
#include <stdint.h>

#include "api/filter.h"
#include "api/position_controller_indi.h"
#include "api/stabilizer_types.h"

// The PID controller, builtin/control/controller_pid.h.
struct cf_controller_pid;

struct FloatRates {
  float p;  // about x
  float q;  // about y
  float r;  // about z
};

struct ReferenceSystem {
  float err_p;  // [1/s], attitude error to body rate
  float err_q;
  float err_r;
  float rate_p;  // [1/s], error of the body rate to angular acceleration
  float rate_q;
  float rate_r;
};

struct IndiVariables {
  float             thrust;             // [counts], of the last call
  struct FloatRates angular_accel_ref;  // [rad/s^2], wanted
  struct FloatRates du;                 // [counts], increment
  struct FloatRates u_in;               // [counts], commanded
  struct FloatRates u_act_dyn;          // [counts], what the motors give by now
  float             rate_d[3];          // [rad/s^2], measured

  Butterworth2LowPass u[3];     // of u_act_dyn
  Butterworth2LowPass rate[3];  // of the body rates [rad/s]

  // parameters
  struct FloatRates      g1;  // [rad/s^2 per count]
  float                  g2;  // [rad/s^2 per count], from spinning the rotors up
  struct ReferenceSystem reference_acceleration;
  struct FloatRates      act_dyn;        // share of a new command that arrives within one step
  float                  filt_cutoff;    // [Hz], roll and pitch; acts at the next init
  float                  filt_cutoff_r;  // [Hz], yaw; likewise
};

typedef struct {
  // parameters ctrlINDI.*, beside those in `indi`
  float   thrust_threshold;     // [counts], below which the inner loop forgets
  float   bound_control_input;  // [counts]
  uint8_t outerLoopActive;      // 0: the PID position loop leads (in degrees, which are taken for
                                // radians, as upstream does)

  struct IndiVariables     indi;
  positionControllerINDI_t position;

  struct FloatRates body_rates;       // [rad/s]
  attitude_t        attitudeDesired;  // [rad]; yaw [deg] while the thrust is zero
  attitude_t        rateDesired;      // [rad/s]
  float             actuatorThrust;   // [counts]
  vector_t          refOuterINDI;     // roll [rad], pitch [rad], thrust [counts]
} controllerINDI_t;

// What selecting this controller does: filters and commands of the inner loop start from zero, and
// so do the filters of the outer loop and the position loops of the PID controller. Increments,
// desired attitude and thrust live on.
void controllerINDIInit(controllerINDI_t *self, struct cf_controller_pid *pid);

// Starts the six filters of the inner loop from zero, at the cutoffs that are set now.
void indi_init_filters(controllerINDI_t *self);

// True: the attitude controller tests nothing.
bool controllerINDITest(const controllerINDI_t *self);

// Computes `control` at one step of the 1 kHz loop: legacy mode, roll, pitch and yaw within int16.
// The loops run on even steps; in between the outputs are written again.
void controllerINDI(controllerINDI_t *self, struct cf_controller_pid *pid, control_t *control,
                    const setpoint_t *setpoint, const sensorData_t *sensors, const state_t *state,
                    const stabilizerStep_t stabilizerStep);

#endif  // CONTROLLER_INDI_H
