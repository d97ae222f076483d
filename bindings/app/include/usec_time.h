// The firmware's usec_time.h for apps: the time of the drone, in steps of a millisecond.
#include "library/services.h"
