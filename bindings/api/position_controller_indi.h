/* Outer loop of the INDI controller: position to roll, pitch and thrust
 * (docs/reference/control-geometric.md#10).
 *
 * From the wish for an acceleration and the acceleration that is felt, it computes by how much to
 * lean further and to push harder. All of it in a frame with x forward, y right and z down:
 * the world's x, -y and -z.
 *
 * Upstream keeps all of this at file scope; here it is a struct that the caller owns and passes as
 * first argument. */
#ifndef POSITION_CONTROLLER_INDI_H
#define POSITION_CONTROLLER_INDI_H

#include "api/filter.h"
#include "api/stabilizer_types.h"

struct Vectr {
  float x;
  float y;
  float z;
};

struct Angles {
  float phi;    // [rad], roll
  float theta;  // [rad], pitch, positive lifts the nose
  float psi;    // [rad], yaw, positive turns clockwise seen from above
};

// Values marked S are as sensed, F filtered.
struct IndiOuterVariables {
  Butterworth2LowPass ddxi[3];  // of the specific force, body
  Butterworth2LowPass ang[3];   // of the attitude
  Butterworth2LowPass thr;      // of the thrust; upstream has three and uses one

  float filt_cutoff;      // [Hz]
  float act_dyn_posINDI;  // share of a new thrust that arrives within one step

  struct Vectr linear_accel_ref;  // [m/s^2], wanted
  struct Vectr linear_accel_err;  // [m/s^2], wanted minus felt
  struct Vectr linear_accel_s;    // [m/s^2], S, body
  struct Vectr linear_accel_f;    // [m/s^2], F, body
  struct Vectr linear_accel_ft;   // [m/s^2], F, world with z down, without gravity

  struct Angles attitude_s;  // S
  struct Angles attitude_f;  // F
  struct Angles attitude_c;  // commanded; psi stays 0

  float phi_tilde;      // [rad], increment of roll
  float theta_tilde;    // [rad], increment of pitch
  float T_tilde;        // [counts], increment of thrust
  float T_inner;        // [counts], what the motors give by now, as the loop believes
  float T_inner_f;      // [counts], F
  float T_incremented;  // [counts], commanded, within [0, 60000]
};

typedef struct {
  // parameters posCtrlIndi.*
  float K_xi_x;  // [1/s]
  float K_xi_y;
  float K_xi_z;
  float K_dxi_x;  // [1/s]
  float K_dxi_y;
  float K_dxi_z;
  float pq_clamping;  // [deg], largest roll and pitch that are commanded

  struct IndiOuterVariables indiOuter;

  // logs, world with z down
  struct Vectr positionRef;  // [m], of the axes that ever were in absolute mode
  struct Vectr velocityRef;  // [m/s]
  struct Vectr velS;         // [m/s]
} positionControllerINDI_t;

// Starts the filters from zero; T_inner and T_incremented live on.
void positionControllerINDIInit(positionControllerINDI_t *self);

// One step of 2 ms. Writes roll [rad], pitch [rad] and thrust [counts] into x, y and z of
// `refOuterINDI`. Of the setpoint it reads position, velocity and the modes x, y, z: an axis in
// absolute mode flies to the position, any other follows the velocity. NaN where the attitude makes
// the effect of the motors singular (a lean of exactly 90 degrees).
void positionControllerINDI(positionControllerINDI_t *self, const sensorData_t *sensors,
                            const setpoint_t *setpoint, const state_t *state,
                            vector_t *refOuterINDI);

#endif  // POSITION_CONTROLLER_INDI_H
