#pragma once

#ifndef __INCLUDED_FROM_PLATFORM_DEFAULTS__
#pragma GCC error "Do not include this file directly, but platform_defaults.h"
#endif

// of a battery with two cells
#define DEFAULT_BAT_BAT_LOW_VOLTAGE 6.4f
#define DEFAULT_BAT_CRITICAL_LOW_VOLTAGE 6.0f
#define DEFAULT_BAT_LOW_DURATION_TO_TRIGGER_SEC 5

#define PID_ROLL_RATE_KP 250.0
#define PID_ROLL_RATE_KI 500.0
#define PID_ROLL_RATE_KD 2.5
#define PID_ROLL_RATE_KFF 0.0
#define PID_ROLL_RATE_INTEGRATION_LIMIT 33.3
#define PID_PITCH_RATE_KP 250.0
#define PID_PITCH_RATE_KI 500.0
#define PID_PITCH_RATE_KD 2.5
#define PID_PITCH_RATE_KFF 0.0
#define PID_PITCH_RATE_INTEGRATION_LIMIT 33.3
#define PID_YAW_RATE_KP 120.0
#define PID_YAW_RATE_KI 16.7
#define PID_YAW_RATE_KD 0.0
#define PID_YAW_RATE_KFF 0.0
#define PID_YAW_RATE_INTEGRATION_LIMIT 166.7

#define PID_ROLL_KP 6.0
#define PID_ROLL_KI 3.0
#define PID_ROLL_KD 0.0
#define PID_ROLL_KFF 0.0
#define PID_ROLL_INTEGRATION_LIMIT 20.0
#define PID_PITCH_KP 6.0
#define PID_PITCH_KI 3.0
#define PID_PITCH_KD 0.0
#define PID_PITCH_KFF 0.0
#define PID_PITCH_INTEGRATION_LIMIT 20.0
#define PID_YAW_KP 6.0
#define PID_YAW_KI 1.0
#define PID_YAW_KD 0.35
#define PID_YAW_KFF 0.0
#define PID_YAW_INTEGRATION_LIMIT 360.0

#define PID_VEL_X_KP 25.0
#define PID_VEL_X_KI 1.0
#define PID_VEL_X_KD 0.0
#define PID_VEL_X_KFF 0.0
#define PID_VEL_Y_KP 25.0
#define PID_VEL_Y_KI 1.0
#define PID_VEL_Y_KD 0.0
#define PID_VEL_Y_KFF 0.0
#define PID_VEL_Z_KP 25.0
#define PID_VEL_Z_KI 15.0
#define PID_VEL_Z_KD 0.0
#define PID_VEL_Z_KFF 0.0
#define PID_VEL_THRUST_BASE 36000
#define PID_VEL_THRUST_MIN 20000
#define PID_VEL_ROLL_MAX 20.0
#define PID_VEL_PITCH_MAX 20.0

#define PID_POS_X_KP 2.0
#define PID_POS_X_KI 0.0
#define PID_POS_X_KD 0.0
#define PID_POS_X_KFF 0.0
#define PID_POS_Y_KP 2.0
#define PID_POS_Y_KI 0.0
#define PID_POS_Y_KD 0.0
#define PID_POS_Y_KFF 0.0
#define PID_POS_Z_KP 2.0
#define PID_POS_Z_KI 0.5
#define PID_POS_Z_KD 0.0
#define PID_POS_Z_KFF 0.0
#define PID_POS_VEL_X_MAX 1.0f
#define PID_POS_VEL_Y_MAX 1.0f
#define PID_POS_VEL_Z_MAX 1.0f
