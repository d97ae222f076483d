/* Both sides of the adapter: our provider, with api_ before its types, and the checkout's headers,
 * in the order in which upstream's own bindings include them.
 *
 * HAVE_* say what the release has (probes/), CF_WITH_* which of extra_sources.txt are part of the
 * library, and CF_VEHICLE_MODE_* which are compiled as for the vehicle. */
#ifndef CF_BITCRAZE_CHECKOUT_H
#define CF_BITCRAZE_CHECKOUT_H

#include "bitcraze/api.h"

// clang-format off: one before the other, some headers use what they do not include
#include "math3d.h"
#include "pptraj.h"
#include "pptraj_compressed.h"
#include "planner.h"
#include "stabilizer_types.h"
#include "collision_avoidance.h"
#include "imu_types.h"
#include "autoconf.h"
#include "kalman_core.h"
#include "outlierFilterTdoa.h"
// clang-format on

#endif  // CF_BITCRAZE_CHECKOUT_H
