#include "vehicle/airframe.h"

#include "vehicle/valid.h"

#define RAD_PER_DEG 0.0174532925f
#define COULOMB_PER_MAH 3.6f
#define GRAM_FORCE_PER_NEWTON 101.971621f
#define MILLI_G 0.00981f  // [m/s^2]

// The BMI088, the same on both (vehicle dossier section 10).
#define BMI088                                                                                \
  {                                                                                           \
      .gyro_noise_rest    = 0.16f * RAD_PER_DEG,  /* data sheet, 116 Hz bandwidth */          \
      .gyro_noise_density = 0.014f * RAD_PER_DEG, /* data sheet */                            \
      .gyro_noise_flight  = 1.0f * RAD_PER_DEG,   /* NANO flights, filters undone: >= 0.8 */  \
      .acc_noise_rest     = 2.2f * MILLI_G,       /* data sheet, 145 Hz bandwidth */          \
      .acc_noise_density  = 0.175f * MILLI_G,     /* data sheet: 0.16 x, y, 0.19 z */         \
      .acc_noise_flight   = 0.2f,                 /* NANO flights, filters undone: >= 0.14 */ \
      .gyro_bias          = 1.0f * RAD_PER_DEG,   /* data sheet */                            \
      .acc_bias           = 20.0f * MILLI_G,      /* data sheet */                            \
      .gyro_scale_error   = 0.01f,                /* data sheet */                            \
      .acc_scale_error    = 0.005f,               /* data sheet: 0.5 to 1 % */                \
      .gyro_drift         = 0.003f * RAD_PER_DEG, /* estimate */                              \
      .acc_drift          = 0.05f * MILLI_G,      /* estimate */                              \
      .drift_time         = 3600.0f,              /* estimate: keeps a long flight bounded */ \
      .noise_scale        = 1.0f,                                                             \
      .bias_scale         = 1.0f,                                                             \
  }

// Numbers and sources of vehicle dossier section 18; its tags name the sources.
static const cf_airframe_t AIRFRAMES[CF_PLATFORM_COUNT] = {
    [CF_PLATFORM_CF2] =
        {
            .inertia             = {16.571710e-6f, 16.655602e-6f, 29.261652e-6f},  // ETH15
            .products_of_inertia = {0.830806e-6f, 0.718277e-6f, 1.800197e-6f},     // ETH15
            .landed_height       = 0.0145f,  // half the overall height, estimate
            .rotors =
                {
                    .linear_voltage    = 0.5f,             // lowest voltage of the fit
                    .thrust_per_rpm    = -3.62002265e-7f,  // DM P250
                    .thrust_per_rpm2   = 1.60609243e-10f,  // DM P250
                    .hover_rpm         = 22200.0f,         // DM at 29 g
                    .time_constant     = 0.07f,            // ETH15, SYSID24, BDOC; 0.06 to 0.13
                    .inertia           = 26.97e-9f,        // DM P250
                    .arm_x             = 0.0325f,          // DM
                    .arm_y             = 0.0325f,          // DM
                    .height            = 0.012f,           // DM
                    .duty_bits         = 8,                // brushed PWM (FW)
                    .duty_lowest_level = 0,
                },
            .battery =
                {
                    .capacity         = 250.0f * COULOMB_PER_MAH,         // BHW
                    .resistance       = 0.20f,                            // NANO; 0.16 to 0.30
                    .slow_resistance  = 0.02f,                            // NANO
                    .slow_time        = 10.0f,                            // estimate
                    .base_power       = 1.10f,                            // BDOC
                    .power_per_thrust = 0.2337f * GRAM_FORCE_PER_NEWTON,  // BDOC
                    .initial_charge   = 1.0f,
                },
            .aerodynamics =
                {
                    .form                 = CF_DRAG_ROTORS,
                    .drag_xy              = 0.01351483f,  // DM P250
                    .drag_z               = 0.01677452f,  // DM P250
                    .rotor_drag_xy        = 1.45e-6f,     // DM drag over the speed in hover
                    .rotor_drag_z         = 1.80e-6f,     // DM drag over the speed in hover
                    .body_drag            = 0.003f,       // estimate
                    .has_flight_moment    = true,
                    .flight_moment_x      = 7.1e-4f,  // NANO regression
                    .flight_moment_y      = 7.9e-4f,  // NANO regression
                    .flight_moment_thrust = 0.4007f,  // NANO, weight of its vehicle
                },
            .imu = BMI088,
        },
    [CF_PLATFORM_CF21BL] =
        {
            .inertia             = {25.0e-6f, 28.0e-6f, 49.0e-6f},  // DM B500
            .products_of_inertia = {0.0f, 0.0f, 0.0f},
            .landed_height       = 0.0175f,  // legs, estimate
            .rotors =
                {
                    .linear_voltage    = 0.4f,             // keeps idle (0.45 V) on the fit
                    .thrust_per_rpm    = -3.13342729e-7f,  // DM B500
                    .thrust_per_rpm2   = 4.40735489e-10f,  // DM B500
                    .hover_rpm         = 15150.0f,         // DM at 39.3 g
                    .time_constant     = 0.055f,           // CFBL26, DM; 0.05 to 0.065
                    .inertia           = 38.93e-9f,        // DM B500
                    .arm_x             = 0.03536f,         // DM
                    .arm_y             = 0.03536f,         // DM
                    .height            = 0.012f,           // DM
                    .duty_bits         = 11,               // DSHOT (FW)
                    .duty_lowest_level = 47,               // DSHOT minimum throttle - 1 (FW)
                },
            .battery =
                {
                    .capacity         = 350.0f * COULOMB_PER_MAH,  // BHW
                    .resistance       = 0.10f,                     // 0.11 in all, scaled from BDOC
                    .slow_resistance  = 0.01f,                     // estimate
                    .slow_time        = 10.0f,                     // estimate
                    .base_power       = 1.1f,                      // fitted to 10 min of flight
                    .power_per_thrust = 0.193f * GRAM_FORCE_PER_NEWTON,  // the same
                    .initial_charge   = 1.0f,
                },
            .aerodynamics =
                {
                    .form                 = CF_DRAG_ROTORS,
                    .drag_xy              = 0.02149163f,  // DM B500
                    .drag_z               = 0.02359736f,  // DM B500
                    .rotor_drag_xy        = 3.39e-6f,     // DM drag over the speed in hover
                    .rotor_drag_z         = 3.72e-6f,     // DM drag over the speed in hover
                    .body_drag            = 0.004f,       // estimate
                    .has_flight_moment    = true,
                    .flight_moment_x      = 8.0e-4f,  // scaled from cf2 with thrust and arm
                    .flight_moment_y      = 8.0e-4f,  // the same
                    .flight_moment_thrust = 0.3855f,  // weight of 39.3 g
                },
            .imu = BMI088,
        },
};

cf_status_t cf_airframe(cf_airframe_t *airframe, cf_platform_t platform) {
  const cf_platform_facts_t *facts = cf_platform_facts(platform);
  if (!facts) {
    return CF_ERR_UNKNOWN;
  }

  *airframe              = AIRFRAMES[platform];
  airframe->mass         = facts->mass;
  airframe->rotors.curve = facts->thrust;
  return CF_OK;
}

cf_status_t cf_airframe_check(const cf_airframe_t *airframe) {
  if (!cf_is_positive(airframe->mass) || !cf_is_not_negative(airframe->landed_height)) {
    return CF_ERR_VALUE;
  }
  for (int i = 0; i < 3; i++) {
    if (!cf_is_positive(airframe->inertia[i]) ||
        !cf_is_within(airframe->products_of_inertia[i], -CF_ANY_SIZE, CF_ANY_SIZE)) {
      return CF_ERR_VALUE;
    }
  }
  return CF_OK;
}
