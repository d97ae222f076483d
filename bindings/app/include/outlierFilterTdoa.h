// The firmware's outlierFilterTdoa.h for apps.
#include "api/outlierFilterTdoa.h"
