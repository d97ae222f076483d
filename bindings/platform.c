#include "platform.h"

#include <stddef.h>

static const cf_platform_facts_t FACTS[CF_PLATFORM_COUNT] = {
    [CF_PLATFORM_CF2] =
        {
            .name            = "cf2",
            .title           = "Crazyflie 2.1+",
            .mass            = 0.029f,
            .arm_length      = 0.046f,
            .battery_low     = 3.2f,
            .requires_arming = false,
            .thrust =
                {
                    .c0               = -0.02476537915958403f,
                    .c1               = 0.06523793527519485f,
                    .c2               = -0.026792504967750107f,
                    .c3               = 0.006776789303971145f,
                    .thrust_min       = 0.012817578393224994f,
                    .thrust_max       = 0.12f,
                    .thrust_to_torque = 0.0069928948992470565f,
                },
        },
    [CF_PLATFORM_CF21BL] =
        {
            .name            = "cf21bl",
            .title           = "Crazyflie 2.1 Brushless",
            .mass            = 0.0393f,
            .arm_length      = 0.050f,
            .battery_low     = 3.35f,
            .requires_arming = true,
            .thrust =
                {
                    .c0               = -0.014058926705279723f,
                    .c1               = 0.04265273261724981f,
                    .c2               = 0.0018327760144017432f,
                    .c3               = 0.0020576974784587178f,
                    .thrust_min       = 0.02136263065537499f,
                    .thrust_max       = 0.2f,
                    .thrust_to_torque = 0.00569278844371417f,
                },
        },
};

const cf_platform_facts_t *cf_platform_facts(cf_platform_t platform) {
  if ((int)platform < 0 || platform >= CF_PLATFORM_COUNT) {
    return NULL;
  }
  return &FACTS[platform];
}
