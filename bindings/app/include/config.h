// The firmware's config.h for apps: the times, which is what apps include it for.
#include "FreeRTOS.h"
