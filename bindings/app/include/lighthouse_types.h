// The firmware's lighthouse_types.h for apps.
#include "api/lighthouse_types.h"
