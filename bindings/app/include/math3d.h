// The firmware's math3d.h for apps.
#include "api/math3d.h"
