%module cffirmware

%{
#define SWIG_FILE_WITH_INIT
#include <stdlib.h>
#include "math3d.h"
#include "pptraj.h"
#include "planner.h"
#include "stabilizer_types.h"
#include "collision_avoidance.h"
#include "imu_types.h"
#include "controller_pid.h"
#include "position_controller.h"
#include "pid.h"
#include "filter.h"
#include "num.h"
#include "controller_mellinger.h"
#include "controller_brescianini.h"
#if MINIATURE_RELEASE >= 202608
#include "controller_lee.h"
#endif
#include "power_distribution.h"
#include "axis3fSubSampler.h"
#include "outlierFilterTdoa.h"
#include "kalman_core.h"
#include "mm_tdoa.h"
%}

%include "math3d.h"
%include "pptraj.h"
%include "planner.h"
%include "stabilizer_types.h"
%include "collision_avoidance.h"
%include "imu_types.h"
%include "controller_pid.h"
%include "position_controller.h"
%include "pid.h"
%include "filter.h"
%include "num.h"
%include "controller_mellinger.h"
%include "controller_brescianini.h"
#if MINIATURE_RELEASE >= 202608
%include "controller_lee.h"
#endif
%include "power_distribution.h"
%include "axis3fSubSampler.h"
%include "outlierFilterTdoa.h"
%include "kalman_core.h"
%include "mm_tdoa.h"
