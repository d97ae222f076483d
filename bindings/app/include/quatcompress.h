// The firmware's quatcompress.h for apps.
#include "api/quatcompress.h"
