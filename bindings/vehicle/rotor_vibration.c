#include "vehicle/rotor_vibration.h"

#include <math.h>

#include "vehicle/valid.h"

static const float RAD_PER_RPM_TICK = 1.04719755e-4f;  // [rad per rpm and ms]
static const float TURN             = 6.28318531f;

cf_status_t cf_rotor_vibration_init(cf_rotor_vibration_t              *vibration,
                                    const cf_rotor_vibration_config_t *config) {
  if (!cf_is_not_negative(config->acc) || !cf_is_not_negative(config->gyro)) {
    return CF_ERR_VALUE;
  }
  *vibration = (cf_rotor_vibration_t){
      .config = *config,
      .is_on  = config->acc > 0.0f || config->gyro > 0.0f,
  };
  return CF_OK;
}

void cf_rotor_vibration_add(cf_rotor_vibration_t *vibration, const float rpm[CF_VIBRATING_ROTORS],
                            float hover_rpm, float rates[3], float force[3]) {
  float shake[3] = {0.0f, 0.0f, 0.0f};
  for (int i = 0; i < CF_VIBRATING_ROTORS; i++) {
    // less than a turn per tick up to 60 000 rpm, but a rotor may be faster
    vibration->phase[i] = fmodf(vibration->phase[i] + rpm[i] * RAD_PER_RPM_TICK, TURN);
    const float speed   = rpm[i] / hover_rpm;
    const float size    = speed * speed;
    const float c       = cosf(vibration->phase[i]);
    const float s       = sinf(vibration->phase[i]);
    shake[0] += size * c;
    shake[1] += size * s;
    shake[2] += size * 2.0f * s * c;  // sin of the double angle
  }
  for (int i = 0; i < 3; i++) {
    rates[i] += vibration->config.gyro * shake[i];
    force[i] += vibration->config.acc * shake[i];
  }
}
