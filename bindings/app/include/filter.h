// The firmware's filter.h for apps.
#include "api/filter.h"
