/* The firmware's platform_defaults.h for apps: what the airframe is
 * (docs/reference/control-pid.md#12, "Physical constants").
 *
 * Where the library is built for one platform, CONFIG_PLATFORM_CF2 or CONFIG_PLATFORM_CF21BL is
 * defined, as in the firmware, and these are constants. A library for every platform looks at the
 * drone: then they are no constants, and a static variable cannot be initialized with them, which
 * the compiler says. The numbers are those of platform.c. */
#ifndef CF_APP_PLATFORM_DEFAULTS_H
#define CF_APP_PLATFORM_DEFAULTS_H

#if defined(__has_include)
#if __has_include("autoconf.h")
#include "autoconf.h"
#endif
#endif

#if defined(CONFIG_PLATFORM_CF21BL)

#define CF_MASS 0.0393f                     // [kg]
#define ARM_LENGTH 0.050f                   // [m]
#define THRUST_MIN 0.02136263065537499f     // [N] per motor
#define THRUST_MAX 0.2f                     // [N] per motor
#define THRUST2TORQUE 0.00569278844371417f  // [m]
#define VMOTOR2THRUST0 -0.014058926705279723f
#define VMOTOR2THRUST1 0.04265273261724981f
#define VMOTOR2THRUST2 0.0018327760144017432f
#define VMOTOR2THRUST3 0.0020576974784587178f

#elif defined(CONFIG_PLATFORM_CF2)

#define CF_MASS 0.029f
#define ARM_LENGTH 0.046f
#define THRUST_MIN 0.012817578393224994f
#define THRUST_MAX 0.12f
#define THRUST2TORQUE 0.0069928948992470565f
#define VMOTOR2THRUST0 -0.02476537915958403f
#define VMOTOR2THRUST1 0.06523793527519485f
#define VMOTOR2THRUST2 -0.026792504967750107f
#define VMOTOR2THRUST3 0.006776789303971145f

#else

#include "platform.h"

// The airframe of the drone at work.
const cf_platform_facts_t *cf_app_airframe(void);

#define CF_MASS (cf_app_airframe()->mass)
#define ARM_LENGTH (cf_app_airframe()->arm_length)
#define THRUST_MIN (cf_app_airframe()->thrust.thrust_min)
#define THRUST_MAX (cf_app_airframe()->thrust.thrust_max)
#define THRUST2TORQUE (cf_app_airframe()->thrust.thrust_to_torque)
#define VMOTOR2THRUST0 (cf_app_airframe()->thrust.c0)
#define VMOTOR2THRUST1 (cf_app_airframe()->thrust.c1)
#define VMOTOR2THRUST2 (cf_app_airframe()->thrust.c2)
#define VMOTOR2THRUST3 (cf_app_airframe()->thrust.c3)

#endif

#endif  // CF_APP_PLATFORM_DEFAULTS_H
