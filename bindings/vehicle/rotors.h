/* Four motors with propellers: from the duty that the onboard software sets to speed and thrust.
 *
 * One step of 1 ms (docs/reference/vehicle.md#3, #4, #5 and #13):
 *
 *   duty  = level / top level, level = ratio >> (16 - duty_bits)
 *   V     = duty * V_pack
 *   n_c   = (-f1 + sqrt(f1^2 + 4 f2 F(V))) / (2 f2),  F the thrust curve of the platform
 *   n     = n_c + (n - n_c) exp(-h / tau), or by dn/dt = a (n_c - n) + b (n_c^2 - n^2)
 *   f     = thrust_scale * efficiency * h (f1 n + f2 n^2),  Q = thrust_to_torque * f
 *   h     = 1 + l (1 - w) + l_o (mean of w_o - w_o)
 *   dw/dt = (mean of (f / f_w)^2 - w) / T,  dw_o/dt = ((f / f_w)^2 - w_o) / T_o
 *
 * with one tau, or one a and one b, for speeding up and others for slowing down, so that a steady
 * motor gives exactly the thrust curve that the onboard battery compensation inverts. Below
 * `linear_voltage` the curve bends through zero; there n_c falls linearly to 0.
 *
 * w is the warmth that all four motors have in common, w_o that of each one's own winding. Both are
 * heated by the current, which goes with the thrust delivered. Cold motors have w = 0 and deliver a
 * share l more than those that have long carried the thrust f_w; a motor that works harder than
 * the others delivers less by l_o for each f_w^2 of difference. l = l_o = 0 leaves that out.
 *
 * M1 front right, M2 back right, M3 back left, M4 front left; M1 and M3 turn counter-clockwise seen
 * from above, so their reaction torque on the body is negative about z. */
#ifndef CF_VEHICLE_ROTORS_H
#define CF_VEHICLE_ROTORS_H

#include <stdbool.h>
#include <stdint.h>

#include "platform.h"
#include "status.h"

#define CF_ROTOR_COUNT 4

typedef enum {
  CF_ROTOR_FIRST_ORDER = 0,
  CF_ROTOR_QUADRATIC   = 1,
} cf_rotor_law_t;

typedef struct {
  cf_thrust_curve_t curve;  // thrust against voltage, and torque per thrust

  float linear_voltage;   // [V] > 0, below it the speed is proportional to the voltage
  float thrust_per_rpm;   // [N/rpm], f1
  float thrust_per_rpm2;  // [N/rpm^2] > 0, f2
  float hover_rpm;        // [rpm] > 0, speed at which vibration is 1
  float radius;           // [m] > 0, of a propeller

  // dynamics of the speed
  cf_rotor_law_t law;
  float          time_constant_up;    // [s] > 0, first order, speeding up
  float          time_constant_down;  // [s] > 0
  float          rate_up;             // [1/s] >= 0, a of the quadratic law
  float          square_rate_up;      // [1/(rpm s)] >= 0, b
  float          rate_down;           // [1/s] >= 0
  float          square_rate_down;    // [1/(rpm s)] >= 0

  float inertia;            // [kg m^2] >= 0, of one rotor about its axis
  float arm_x;              // [m] > 0, motors stand at x = +-arm_x
  float arm_y;              // [m] > 0, and y = +-arm_y
  float height;             // [m], rotor plane above the center of mass
  int   duty_bits;          // 8 brushed PWM, 11 DSHOT, 16 no quantization; 1 to 16
  int   duty_lowest_level;  // levels below this one stop the motor; 0 when all count

  // how thrust fades as motors get warm
  float heat_loss;      // [0, 0.5], l
  float heat_time;      // [s] > 0, T
  float heat_own_loss;  // [0, 0.5], l_o
  float heat_own_time;  // [s] > 0, T_o
  float heat_thrust;    // [N] > 0, f_w

  // what this very vehicle delivers, in [0, 2]: thrust and torque at a given speed
  float thrust_scale;                // of all four
  float efficiency[CF_ROTOR_COUNT];  // of each; 0 stops the rotor
} cf_rotors_config_t;

typedef struct {
  cf_rotors_config_t config;

  // settings
  float efficiency[CF_ROTOR_COUNT];  // [0, 2], as in the config
  float driven[CF_ROTOR_COUNT];      // 1, or 0 where the efficiency is 0
  float duty_per_level;              // derived from the config, as those that follow
  float gain[CF_ROTOR_COUNT];        // efficiency times thrust scale
  float decay_up;                    // exp(-h / tau)
  float decay_down;
  float vibration_per_rpm2;  // [1/rpm^2]
  bool  has_heat;
  float heat_rate;        // 1 - exp(-h / T)
  float heat_own_rate;    // 1 - exp(-h / T_o)
  float heat_per_thrust;  // [1/N], 1 / f_w

  // state
  float rpm[CF_ROTOR_COUNT];         // [rpm] >= 0
  float warmth;                      // >= 0, of all motors; stays 0 without a loss
  float own_warmth[CF_ROTOR_COUNT];  // >= 0, of each winding; likewise

  // outputs of the last step
  float thrust[CF_ROTOR_COUNT];   // [N] along body z, >= 0
  float torque[CF_ROTOR_COUNT];   // [N m] >= 0, aerodynamic reaction, against the spin
  float spin_up[CF_ROTOR_COUNT];  // [N m], reaction to dn/dt, against the spin when speeding up
  float vibration;                // mean of (n / hover_rpm)^2
} cf_rotors_t;

// Fills the rotors, at rest. Returns CF_ERR_VALUE when a number of the config is outside its range.
cf_status_t cf_rotors_init(cf_rotors_t *rotors, const cf_rotors_config_t *config);

// Sets the efficiency of motor 0..3. Returns CF_ERR_CAPACITY for another motor, CF_ERR_VALUE
// outside [0, 2].
cf_status_t cf_rotors_set_efficiency(cf_rotors_t *rotors, int motor, float efficiency);

// Advances by 1 ms with the ratios [0, 65535] of the motor layer (duty, after battery compensation)
// and the pack voltage [V].
void cf_rotors_step(cf_rotors_t *rotors, const uint16_t ratios[CF_ROTOR_COUNT], float pack_voltage);

// Returns the sum of the four thrusts [N].
float cf_rotors_total_thrust(const cf_rotors_t *rotors);

// Pure: steady speed [rpm] and thrust [N] of one healthy rotor at a motor voltage [V].
float cf_rotor_steady_rpm(const cf_rotors_config_t *config, float voltage);
float cf_rotor_steady_thrust(const cf_rotors_config_t *config, float voltage);

#endif  // CF_VEHICLE_ROTORS_H
