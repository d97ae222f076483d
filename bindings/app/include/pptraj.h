// The firmware's pptraj.h for apps.
#include "api/pptraj.h"
