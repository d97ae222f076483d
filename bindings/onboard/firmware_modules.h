/* The part of the loop that is left when a provider flies the firmware's own modules (cf_system_t):
 * what sensors, decks and clients measured goes in, and what came out is copied to where our own
 * modules would have put it, so that logs, the world and its users find it there. */
#ifndef CF_ONBOARD_FIRMWARE_MODULES_H
#define CF_ONBOARD_FIRMWARE_MODULES_H

#include "onboard/onboard.h"

// Boots the modules of the provider. Returns CF_ERR_UNKNOWN for a controller or estimator that they
// lack, CF_ERR_STATE when one of their tests fails.
cf_status_t cf_firmware_modules_boot(cf_onboard_t *onboard, const cf_provider_t *provider,
                                     void *provider_state, const cf_boot_t *boot);

// One millisecond. `are_calibrated`: the sensors were before their newest samples. `is_held`: a
// loop that is not theirs does nothing, a test has set the motors.
void cf_firmware_modules_tick(cf_onboard_t *onboard, const cf_provider_t *provider,
                              void *provider_state, bool are_calibrated, bool is_held);

#endif  // CF_ONBOARD_FIRMWARE_MODULES_H
