/* The forces of one physics step, all in this file so that the compiler keeps them in registers. */
#include <math.h>

#include "vehicle/vehicle.h"

static const float RAD_PER_RPM         = 0.104719755f;  // [rad/s per rpm]
static const float FLIGHT_MOMENT_SPEED = 3.0f;          // [m/s], beyond it nothing was identified

// Thrusts, their moments, reaction torques and the gyroscopic torque of the rotors.
static inline void add_rotors(const cf_rotors_t *rotors, const float gain[CF_ROTOR_COUNT],
                              const float w[3], float force[3], float torque[3]) {
  const float f1 = gain[0] * rotors->thrust[0], f2 = gain[1] * rotors->thrust[1];
  const float f3 = gain[2] * rotors->thrust[2], f4 = gain[3] * rotors->thrust[3];
  const float n1 = rotors->rpm[0], n2 = rotors->rpm[1], n3 = rotors->rpm[2], n4 = rotors->rpm[3];

  force[2] += (f1 + f2) + (f3 + f4);
  torque[0] += rotors->config.arm_y * ((f3 + f4) - (f1 + f2));
  torque[1] += rotors->config.arm_x * ((f2 + f3) - (f1 + f4));

  // against the spin: aerodynamic reaction and spin-up
  const float q1 = rotors->torque[0] + rotors->spin_up[0];
  const float q2 = rotors->torque[1] + rotors->spin_up[1];
  const float q3 = rotors->torque[2] + rotors->spin_up[2];
  const float q4 = rotors->torque[3] + rotors->spin_up[3];
  torque[2] += (q2 + q4) - (q1 + q3);

  // H = J_r (Omega_1 - Omega_2 + Omega_3 - Omega_4) along z; torque -w x H
  const float h = rotors->config.inertia * RAD_PER_RPM * ((n1 + n3) - (n2 + n4));
  torque[0] -= w[1] * h;
  torque[1] += w[0] * h;
}

// F_i = -Omega_i K (v + w x r_i) summed over the rotors, in closed form: with the moments
// S = sum Omega, S_x = sum Omega x, S_y = sum Omega y, S_xy = sum Omega x y of the rotor speeds.
static inline void add_rotor_drag(const cf_aerodynamics_t *aerodynamics, const cf_rotors_t *rotors,
                                  const float v[3], const float w[3], float force[3],
                                  float torque[3]) {
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

static inline void add_flight_moment(const cf_aerodynamics_t *aerodynamics, float thrust,
                                     const float v[3], float torque[3]) {
  const float speed2 = v[0] * v[0] + v[1] * v[1];
  float       scale  = thrust;
  if (speed2 > FLIGHT_MOMENT_SPEED * FLIGHT_MOMENT_SPEED) {
    scale *= FLIGHT_MOMENT_SPEED / sqrtf(speed2);
  }
  torque[0] += aerodynamics->moment_x * scale * v[1];
  torque[1] -= aerodynamics->moment_y * scale * v[0];
}

// F = -b |v| v
static inline void add_body_drag(float body_drag, const float v[3], float force[3]) {
  const float b = body_drag * sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  force[0] -= b * v[0];
  force[1] -= b * v[1];
  force[2] -= b * v[2];
}

static inline void add_linear_drag(const cf_aerodynamics_config_t *config, const float v[3],
                                   float force[3]) {
  force[0] -= config->drag_xy * v[0];
  force[1] -= config->drag_xy * v[1];
  force[2] -= config->drag_z * v[2];
}

void cf_vehicle_wrench(const cf_vehicle_t *vehicle, const float rotation[9],
                       const float velocity_world[3], const float rates_body[3],
                       float force_world[3], float torque_body[3]) {
  const cf_aerodynamics_t *air    = &vehicle->aerodynamics;
  const cf_rotors_t       *rotors = &vehicle->rotors;
  const float             *r      = rotation;

  // relative to the air
  const float u[3] = {velocity_world[0] - vehicle->wind.velocity[0],
                      velocity_world[1] - vehicle->wind.velocity[1],
                      velocity_world[2] - vehicle->wind.velocity[2]};

  // into the body frame
  const float w[3] = {rates_body[0], rates_body[1], rates_body[2]};
  const float v[3] = {
      r[0] * u[0] + r[3] * u[1] + r[6] * u[2],
      r[1] * u[0] + r[4] * u[1] + r[7] * u[2],
      r[2] * u[0] + r[5] * u[1] + r[8] * u[2],
  };

  // sum up
  float f[3] = {0.0f, 0.0f, 0.0f};
  float t[3] = {0.0f, 0.0f, 0.0f};
  add_rotors(rotors, vehicle->ground_effect.gain, w, f, t);
  const float thrust = f[2];
  for (int i = 0; i < 3; i++) {
    t[i] += thrust * vehicle->trim_per_thrust[i];
  }
  add_body_drag(air->config.body_drag, v, f);
  if (air->config.form == CF_DRAG_ROTORS) {
    add_rotor_drag(air, rotors, v, w, f, t);
  } else if (air->config.form == CF_DRAG_LINEAR) {
    add_linear_drag(&air->config, v, f);
  }
  add_flight_moment(air, thrust, v, t);

  // force back into the world frame
  force_world[0] = r[0] * f[0] + r[1] * f[1] + r[2] * f[2];
  force_world[1] = r[3] * f[0] + r[4] * f[1] + r[5] * f[2];
  force_world[2] = r[6] * f[0] + r[7] * f[1] + r[8] * f[2];
  force_world[2] -= vehicle->downwash;
  torque_body[0] = t[0];
  torque_body[1] = t[1];
  torque_body[2] = t[2];
}
