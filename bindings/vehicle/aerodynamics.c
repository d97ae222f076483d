#include "vehicle/aerodynamics.h"

#include "vehicle/valid.h"

static const float RAD_PER_RPM = 0.104719755f;  // [rad/s per rpm]

static bool is_valid(const cf_aerodynamics_config_t *config) {
  return config->form >= CF_DRAG_NONE && config->form <= CF_DRAG_ROTORS &&
         cf_is_not_negative(config->drag_xy) && cf_is_not_negative(config->drag_z) &&
         cf_is_not_negative(config->rotor_drag_xy) && cf_is_not_negative(config->rotor_drag_z) &&
         cf_is_not_negative(config->body_drag) && cf_is_not_negative(config->flight_moment_x) &&
         cf_is_not_negative(config->flight_moment_y) &&
         cf_is_positive(config->flight_moment_thrust);
}

cf_status_t cf_aerodynamics_init(cf_aerodynamics_t              *aerodynamics,
                                 const cf_aerodynamics_config_t *config,
                                 const cf_rotors_config_t       *rotors) {
  if (!is_valid(config)) {
    return CF_ERR_VALUE;
  }

  // the rotor form already brings the moment of its drag at the rotor plane
  const float hover_speed = (float)CF_ROTOR_COUNT * rotors->hover_rpm * RAD_PER_RPM;
  const float of_drag =
      config->form == CF_DRAG_ROTORS ? rotors->height * config->rotor_drag_xy * hover_speed : 0.0f;
  const float per_thrust = config->has_flight_moment ? 1.0f / config->flight_moment_thrust : 0.0f;

  *aerodynamics = (cf_aerodynamics_t){
      .config   = *config,
      .moment_x = (config->flight_moment_x - of_drag) * per_thrust,
      .moment_y = (config->flight_moment_y - of_drag) * per_thrust,
  };
  return CF_OK;
}
