// The firmware's num.h for apps.
#include "api/num.h"
