// Gains and constants of the platform, and what stands in where it has none.
#pragma once

#include "autoconf.h"

#define __INCLUDED_FROM_PLATFORM_DEFAULTS__

#ifdef CONFIG_PLATFORM_CF2
#include "platform_defaults_cf2.h"
#endif
#ifdef CONFIG_PLATFORM_BOLT
#include "platform_defaults_bolt.h"
#endif
#ifdef CONFIG_PLATFORM_CF21BL
#include "platform_defaults_cf21bl.h"
#endif

#ifdef CONFIG_DECK_BIGQUAD
#ifndef CONFIG_MOTORS_REQUIRE_ARMING
#define CONFIG_MOTORS_REQUIRE_ARMING 1
#endif
#ifndef CONFIG_MOTORS_DEFAULT_IDLE_THRUST
#define CONFIG_MOTORS_DEFAULT_IDLE_THRUST 7000
#endif
#endif

#if MINIATURE_RELEASE >= 202608
#if defined(CONFIG_MODIFY_CF_MASS) && defined(CONFIG_MODIFIED_CF_MASS)
#undef CF_MASS
#define CF_MASS (CONFIG_MODIFIED_CF_MASS / 1000000.0f)
#endif
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
#endif
#ifndef VMOTOR2THRUST1
#define VMOTOR2THRUST1 0.0f
#endif
#ifndef VMOTOR2THRUST2
#define VMOTOR2THRUST2 0.0f
#endif
#ifndef VMOTOR2THRUST3
#define VMOTOR2THRUST3 0.0f
#endif
#ifndef DEFAULT_BAT_LOW_VOLTAGE
#define DEFAULT_BAT_LOW_VOLTAGE 3.2f
#endif
#ifndef DEFAULT_BAT_CRITICAL_LOW_VOLTAGE
#define DEFAULT_BAT_CRITICAL_LOW_VOLTAGE 3.0f
#endif
#ifndef DEFAULT_BAT_LOW_DURATION_TO_TRIGGER_SEC
#define DEFAULT_BAT_LOW_DURATION_TO_TRIGGER_SEC 5
#endif
#ifndef HEALTH_PROPELLER_TEST_THRESHOLD
#define HEALTH_PROPELLER_TEST_THRESHOLD 10
#endif
#if MINIATURE_RELEASE >= 202608
#ifndef FLOWDECK_POS_X
#define FLOWDECK_POS_X 0.0f
#endif
#ifndef FLOWDECK_POS_Y
#define FLOWDECK_POS_Y 0.0f
#endif
#ifndef FLOWDECK_POS_Z
#define FLOWDECK_POS_Z 0.0f
#endif
#ifndef DRAG_B_X
#define DRAG_B_X 0.0f
#endif
#ifndef DRAG_B_Y
#define DRAG_B_Y 0.0f
#endif
#ifndef DRAG_B_Z
#define DRAG_B_Z 0.0f
#endif
#ifndef CENTER_OF_PRESSURE_X
#define CENTER_OF_PRESSURE_X 0.0f
#endif
#ifndef CENTER_OF_PRESSURE_Y
#define CENTER_OF_PRESSURE_Y 0.0f
#endif
#ifndef CENTER_OF_PRESSURE_Z
#define CENTER_OF_PRESSURE_Z 0.0f
#endif
#endif
#ifndef ATTITUDE_LPF_ENABLE
#define ATTITUDE_LPF_ENABLE false
#endif
#ifndef ATTITUDE_LPF_CUTOFF_FREQ
#define ATTITUDE_LPF_CUTOFF_FREQ 15.0f
#endif
#ifndef ATTITUDE_RATE_LPF_ENABLE
#define ATTITUDE_RATE_LPF_ENABLE false
#endif
#ifndef ATTITUDE_ROLL_RATE_LPF_CUTOFF_FREQ
#define ATTITUDE_ROLL_RATE_LPF_CUTOFF_FREQ 30.0f
#endif
#ifndef ATTITUDE_PITCH_RATE_LPF_CUTOFF_FREQ
#define ATTITUDE_PITCH_RATE_LPF_CUTOFF_FREQ 30.0f
#endif
#ifndef ATTITUDE_YAW_RATE_LPF_CUTOFF_FREQ
#define ATTITUDE_YAW_RATE_LPF_CUTOFF_FREQ 30.0f
#endif
#ifndef PID_POS_XY_FILT_ENABLE
#define PID_POS_XY_FILT_ENABLE true
#endif
#ifndef PID_POS_XY_FILT_CUTOFF
#define PID_POS_XY_FILT_CUTOFF 20.0f
#endif
#ifndef PID_POS_Z_FILT_ENABLE
#define PID_POS_Z_FILT_ENABLE true
#endif
#ifndef PID_POS_Z_FILT_CUTOFF
#define PID_POS_Z_FILT_CUTOFF 20.0f
#endif
#ifndef PID_VEL_XY_FILT_ENABLE
#define PID_VEL_XY_FILT_ENABLE true
#endif
#ifndef PID_VEL_XY_FILT_CUTOFF
#define PID_VEL_XY_FILT_CUTOFF 20.0f
#endif
#ifndef PID_VEL_Z_FILT_ENABLE
#define PID_VEL_Z_FILT_ENABLE true
#endif
#ifndef PID_VEL_Z_FILT_CUTOFF
#define PID_VEL_Z_FILT_CUTOFF 20.0f
#endif
#ifndef YAW_MAX_DELTA
#define YAW_MAX_DELTA 0.0f
#endif
