#include "onboard/commander/cppm.h"

#include "onboard/commander/setpoints.h"
#include "variable_row.h"

#define MIDDLE 1500
#define HALF_RANGE 500
#define SHORTEST 1000
#define RANGE 1000
#define FULL_THRUST 65535.0f

void cf_cppm_init(cf_cppm_t *cppm) {
  *cppm = (cf_cppm_t){
      .rateRoll  = 720.0f,
      .ratePitch = 720.0f,
      .angPitch  = 50.0f,
      .angRoll   = 50.0f,
      .rateYaw   = 400.0f,
  };
}

static float unit(uint16_t pulse, uint16_t zero, uint16_t range) {
  return ((float)pulse - (float)zero) / (float)range;
}

static float deflection(uint16_t pulse) {
  return unit(pulse, MIDDLE, HALF_RANGE);
}

cf_status_t cf_setpoint_cppm(setpoint_t *setpoint, const cf_cppm_t *cppm,
                             const cf_cppm_sticks_t *sticks) {
  const bool  is_levelling = sticks->n_aux < 1 || sticks->aux[0] >= MIDDLE;
  const float thrust       = unit(sticks->thrust, SHORTEST, RANGE) * FULL_THRUST;

  // longer pulses are negative angles and rates
  setpoint_t wanted = {
      .attitudeRate = {.yaw = -deflection(sticks->yaw) * cppm->rateYaw},
      .thrust       = thrust > 0.0f ? thrust : 0.0f,
      .mode         = {.yaw = modeVelocity},
  };
  if (is_levelling) {
    wanted.mode.roll      = modeAbs;
    wanted.mode.pitch     = modeAbs;
    wanted.attitude.roll  = -deflection(sticks->roll) * cppm->angRoll;
    wanted.attitude.pitch = -deflection(sticks->pitch) * cppm->angPitch;
  } else {
    wanted.mode.roll          = modeVelocity;
    wanted.mode.pitch         = modeVelocity;
    wanted.attitudeRate.roll  = -deflection(sticks->roll) * cppm->rateRoll;
    wanted.attitudeRate.pitch = -deflection(sticks->pitch) * cppm->ratePitch;
  }

  if (!cf_setpoint_is_finite(&wanted)) {
    return CF_ERR_VALUE;
  }
  *setpoint = wanted;
  return CF_OK;
}

#define PARAMETER(name_) CF_ROW("cppm", #name_, FLOAT, CF_PERSISTENT, cf_cppm_t, name_)

static const cf_variable_t PARAMETERS[] = {
    PARAMETER(rateRoll), PARAMETER(ratePitch), PARAMETER(angPitch),
    PARAMETER(angRoll),  PARAMETER(rateYaw),
};

cf_variables_t cf_cppm_parameters(void) {
  return CF_TABLE(PARAMETERS);
}
