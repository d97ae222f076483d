// Gains and constants of the platform, and what stands in where it has none.
#ifndef PLATFORM_DEFAULTS_H_
#define PLATFORM_DEFAULTS_H_

#include "autoconf.h"

#define __INCLUDED_FROM_PLATFORM_DEFAULTS__

#ifdef CONFIG_PLATFORM_CF2
#include "platform_defaults_cf2.h"
#endif
#ifdef CONFIG_PLATFORM_CF21BL
#include "platform_defaults_cf21bl.h"
#endif
#ifdef CONFIG_PLATFORM_BOLT
#include "platform_defaults_bolt.h"
#endif

#ifndef ARM_LENGTH
#define ARM_LENGTH 0.046f
#endif
#ifndef CF_MASS
#define CF_MASS 0.029f
#endif
#ifndef THRUST_MIN
#define THRUST_MIN 0.02f
#endif
#ifndef THRUST_MAX
#define THRUST_MAX 0.1125f
#endif
#ifndef THRUST2TORQUE
#define THRUST2TORQUE 0.005964552f
#endif
#ifndef VMOTOR2THRUST0
#define VMOTOR2THRUST0 0.0f
#define VMOTOR2THRUST1 0.0f
#define VMOTOR2THRUST2 0.0f
#define VMOTOR2THRUST3 0.0f
#endif
#ifndef DEFAULT_IDLE_THRUST
#define DEFAULT_IDLE_THRUST 0
#endif

#define FLOWDECK_POS_X 0.0f
#define FLOWDECK_POS_Y 0.0f
#define FLOWDECK_POS_Z 0.0f

#define ATTITUDE_LPF_ENABLE false
#define ATTITUDE_LPF_CUTOFF_FREQ 15.0f
#define ATTITUDE_RATE_LPF_ENABLE false
#define ATTITUDE_ROLL_RATE_LPF_CUTOFF_FREQ 30.0f
#define ATTITUDE_PITCH_RATE_LPF_CUTOFF_FREQ 30.0f
#define ATTITUDE_YAW_RATE_LPF_CUTOFF_FREQ 30.0f
#define PID_POS_XY_FILT_ENABLE true
#define PID_POS_XY_FILT_CUTOFF 20.0f
#define PID_POS_Z_FILT_ENABLE true
#define PID_POS_Z_FILT_CUTOFF 20.0f
#define PID_VEL_XY_FILT_ENABLE true
#define PID_VEL_XY_FILT_CUTOFF 20.0f
#define PID_VEL_Z_FILT_ENABLE true
#define PID_VEL_Z_FILT_CUTOFF 20.0f
#define YAW_MAX_DELTA 0.0f

#endif  // PLATFORM_DEFAULTS_H_
