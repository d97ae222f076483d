/* Headers of a checkout that crazychoir_fw.cffirmware looks into, in the order in which upstream's
 * interface file includes them. CF_WITH_X says that x.c is compiled. */
#ifndef CF_CFFI_CFFIRMWARE_HEADERS_H
#define CF_CFFI_CFFIRMWARE_HEADERS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "math3d.h"
// after math3d.h, on which some of them rely
#include "pptraj.h"
#ifdef CF_WITH_PPTRAJ_COMPRESSED
#include "pptraj_compressed.h"
#endif
#include "planner.h"
#include "stabilizer_types.h"
// after stabilizer_types.h
#include "collision_avoidance.h"
#include "controller_pid.h"
#include "filter.h"
#include "imu_types.h"
#include "num.h"
#ifdef CF_WITH_CONTROLLER_MELLINGER
#include "controller_mellinger.h"
#endif
#ifdef CF_WITH_CONTROLLER_BRESCIANINI
#include "controller_brescianini.h"
#endif
#ifdef CF_WITH_CONTROLLER_LEE
#include "controller_lee.h"
#endif
#include "axis3fSubSampler.h"
#include "kalman_core.h"
#include "outlierFilterTdoa.h"
#include "power_distribution.h"
#ifdef CF_WITH_MM_TDOA
#include "mm_tdoa.h"
#endif
#ifdef CF_WITH_MM_POSITION
#include "mm_position.h"
#endif
#ifdef CF_WITH_MM_POSE
#include "mm_pose.h"
#endif
#ifdef CF_WITH_MM_DISTANCE
#include "mm_distance.h"
#endif
#ifdef CF_WITH_MM_TOF
#include "mm_tof.h"
#endif
#ifdef CF_WITH_MM_FLOW
#include "mm_flow.h"
#endif
#ifdef CF_WITH_MM_ABSOLUTE_HEIGHT
#include "mm_absolute_height.h"
#endif
#ifdef CF_WITH_MM_YAW_ERROR
#include "mm_yaw_error.h"
#endif

#endif  // CF_CFFI_CFFIRMWARE_HEADERS_H
