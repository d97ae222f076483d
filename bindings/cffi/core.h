/* Everything that Python may see of the C side: build.py reads this file, and what it includes, as declarations. */
#include "api/imu_types.h"
#include "api/measurement.h"
#include "api/stabilizer_types.h"
#include "api/vec.h"
#include "builtin/fast_math.h"
#include "platform.h"
#include "status.h"
#include "variables.h"
