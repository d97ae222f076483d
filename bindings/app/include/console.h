// The firmware's console.h for apps.
#include "library/services.h"
