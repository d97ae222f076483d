// The firmware's axis3fSubSampler.h for apps.
#include "api/axis3fSubSampler.h"
