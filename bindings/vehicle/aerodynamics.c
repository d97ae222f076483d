#include "vehicle/aerodynamics.h"

#include <math.h>

#include "vehicle/valid.h"

static const float RAD_PER_RPM         = 0.104719755f;  // [rad/s per rpm]
static const float FLIGHT_MOMENT_SPEED = 3.0f;          // [m/s], beyond it nothing was identified

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

// F_i = -Omega_i K (v + w x r_i) summed over the rotors, in closed form: with the moments
// S = sum Omega, S_x = sum Omega x, S_y = sum Omega y, S_xy = sum Omega x y of the rotor speeds.
static void add_rotor_drag(const cf_aerodynamics_t *aerodynamics, const cf_rotors_t *rotors,
                           const float v[3], const float w[3], float force[3], float torque[3]) {
  const float k_xy = aerodynamics->config.rotor_drag_xy * RAD_PER_RPM;
  const float k_z  = aerodynamics->config.rotor_drag_z * RAD_PER_RPM;
  const float ax   = rotors->config.arm_x;
  const float ay   = rotors->config.arm_y;
  const float h    = rotors->config.height;
  const float n1 = rotors->rpm[0], n2 = rotors->rpm[1], n3 = rotors->rpm[2], n4 = rotors->rpm[3];

  const float s   = (n1 + n2) + (n3 + n4);
  const float sx  = ax * ((n1 + n4) - (n2 + n3));
  const float sy  = ay * ((n3 + n4) - (n1 + n2));
  const float sxy = ax * ay * ((n2 + n4) - (n1 + n3));
  const float sxx = ax * ax * s;
  const float syy = ay * ay * s;

  // velocity of the rotor plane's center
  const float vx = v[0] + w[1] * h;
  const float vy = v[1] - w[0] * h;

  const float fx = -k_xy * (s * vx - w[2] * sy);
  const float fy = -k_xy * (s * vy + w[2] * sx);
  force[0] += fx;
  force[1] += fy;
  force[2] -= k_z * (s * v[2] + w[0] * sy - w[1] * sx);

  torque[0] -= h * fy + k_z * (sy * v[2] + w[0] * syy - w[1] * sxy);
  torque[1] += h * fx + k_z * (sx * v[2] + w[0] * sxy - w[1] * sxx);
  torque[2] -= k_xy * (sx * vy - sy * vx + w[2] * (sxx + syy));
}

static void add_flight_moment(const cf_aerodynamics_t *aerodynamics, float thrust, const float v[3],
                              float torque[3]) {
  const float speed2 = v[0] * v[0] + v[1] * v[1];
  float       scale  = thrust;
  if (speed2 > FLIGHT_MOMENT_SPEED * FLIGHT_MOMENT_SPEED) {
    scale *= FLIGHT_MOMENT_SPEED / sqrtf(speed2);
  }
  torque[0] += aerodynamics->moment_x * scale * v[1];
  torque[1] -= aerodynamics->moment_y * scale * v[0];
}

void cf_aerodynamics_add(const cf_aerodynamics_t *aerodynamics, const cf_rotors_t *rotors,
                         const float velocity_body[3], const float rates_body[3],
                         float force_body[3], float torque_body[3]) {
  const cf_aerodynamics_config_t *config = &aerodynamics->config;

  // copies: the compiler may keep them in registers
  const float v[3] = {velocity_body[0], velocity_body[1], velocity_body[2]};
  const float w[3] = {rates_body[0], rates_body[1], rates_body[2]};

  // body: F = -b |v| v
  const float b         = -config->body_drag * sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  float       force[3]  = {b * v[0], b * v[1], b * v[2]};
  float       torque[3] = {0.0f, 0.0f, 0.0f};

  // rotors
  if (config->form == CF_DRAG_ROTORS) {
    add_rotor_drag(aerodynamics, rotors, v, w, force, torque);
  } else if (config->form == CF_DRAG_LINEAR) {
    force[0] -= config->drag_xy * v[0];
    force[1] -= config->drag_xy * v[1];
    force[2] -= config->drag_z * v[2];
  }
  if (config->has_flight_moment) {
    add_flight_moment(aerodynamics, cf_rotors_total_thrust(rotors), v, torque);
  }

  for (int i = 0; i < 3; i++) {
    force_body[i] += force[i];
    torque_body[i] += torque[i];
  }
}
