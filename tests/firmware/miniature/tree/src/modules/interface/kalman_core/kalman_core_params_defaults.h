// What the parameters of the filter are at start, as designated initializers.
#pragma once

#include "platform_defaults.h"

#ifdef CONFIG_ESTIMATOR_KALMAN_GENERAL_PURPOSE
#define KALMAN_CORE_DEFAULT_PROC_NOISE_ACC_Z 0.5f
#else
#define KALMAN_CORE_DEFAULT_PROC_NOISE_ACC_Z 1.0f
#endif

// the symbol lacks a letter, so that no configuration defines it
#ifdef CONFIG_STIMATOR_KALMAN_INITIAL_YAW_STD
#define KALMAN_CORE_DEFAULT_YAW_STD (CONFIG_STIMATOR_KALMAN_INITIAL_YAW_STD / 1000.0f)
#else
#define KALMAN_CORE_DEFAULT_YAW_STD 0.01
#endif

// clang-format off
#define KALMAN_CORE_DEFAULT_PARAMS_INIT                            \
  .stdDevInitialPosition_xy        = 100,                          \
  .stdDevInitialPosition_z         = 1,                            \
  .stdDevInitialVelocity           = 0.01,                         \
  .stdDevInitialAttitude_rollpitch = 0.01,                         \
  .stdDevInitialAttitude_yaw       = KALMAN_CORE_DEFAULT_YAW_STD,  \
  .procNoiseAcc_xy                 = 0.5f,                         \
  .procNoiseAcc_z                  = KALMAN_CORE_DEFAULT_PROC_NOISE_ACC_Z, \
  .procNoiseVel                    = 0,                            \
  .procNoisePos                    = 0,                            \
  .procNoiseAtt                    = 0,                            \
  .measNoiseBaro                   = 2.0f,                         \
  .measNoiseGyro_rollpitch         = 0.1f,                         \
  .measNoiseGyro_yaw               = 0.1f,                         \
  .initialX                        = 0.0,                          \
  .initialY                        = 0.0,                          \
  .initialZ                        = 0.0,                          \
  .initialYaw                      = 0.0,                          \
  .attitudeReversion               = 0.001f,                       \
  KALMAN_CORE_DEFAULT_DRAG

#if MINIATURE_RELEASE >= 202608
#define KALMAN_CORE_DEFAULT_DRAG \
  .dragB_x = DRAG_B_X,           \
  .dragB_y = DRAG_B_Y,           \
  .dragB_z = DRAG_B_Z,           \
  .cop_x = CENTER_OF_PRESSURE_X, \
  .cop_y = CENTER_OF_PRESSURE_Y, \
  .cop_z = CENTER_OF_PRESSURE_Z,
#else
#define KALMAN_CORE_DEFAULT_DRAG
#endif
// clang-format on
