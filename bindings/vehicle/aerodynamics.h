/* What the air does to the body: drag of rotors and frame, and the moment of forward flight.
 *
 * wrench.c adds them up. Velocities are relative to the air; body frame x forward, y left, z up
 * (docs/reference/vehicle.md#7). */
#ifndef CF_VEHICLE_AERODYNAMICS_H
#define CF_VEHICLE_AERODYNAMICS_H

#include <stdbool.h>

#include "status.h"
#include "vehicle/rotors.h"

typedef enum {
  CF_DRAG_NONE   = 0,
  CF_DRAG_LINEAR = 1,  // F = -diag(d_xy, d_xy, d_z) v, at the center of mass
  CF_DRAG_ROTORS = 2,  // F_i = -Omega_i diag(k_xy, k_xy, k_z) (v + rates x r_i), at each rotor
} cf_drag_form_t;

typedef struct {
  cf_drag_form_t form;

  float drag_xy;        // [N s/m] >= 0, linear form
  float drag_z;         // [N s/m] >= 0
  float rotor_drag_xy;  // [kg/rad] >= 0, rotor form
  float rotor_drag_z;   // [kg/rad] >= 0
  float body_drag;      // [N s^2/m^2] >= 0, F = -b |v| v in every form; 0 turns it off

  // The leading edge is lifted, up to 3 m/s: torque x = +k_x v_y, torque y = -k_y v_x, proportional
  // to thrust. The k hold at `flight_moment_thrust` and include the moment of the drag at the rotor
  // plane.
  bool  has_flight_moment;
  float flight_moment_x;       // [N m s/m] >= 0, k_x
  float flight_moment_y;       // [N m s/m] >= 0, k_y
  float flight_moment_thrust;  // [N] > 0, total
} cf_aerodynamics_config_t;

typedef struct {
  cf_aerodynamics_config_t config;

  // derived: moment of forward flight without that of the drag
  float moment_x;  // [s], torque per velocity and thrust
  float moment_y;  // [s]
} cf_aerodynamics_t;

// Fills the aerodynamics of a frame with these rotors. Returns CF_ERR_VALUE when a number of the
// config is outside its range.
cf_status_t cf_aerodynamics_init(cf_aerodynamics_t              *aerodynamics,
                                 const cf_aerodynamics_config_t *config,
                                 const cf_rotors_config_t       *rotors);

#endif  // CF_VEHICLE_AERODYNAMICS_H
