// The firmware's pid.h for apps.
#include "api/pid.h"
