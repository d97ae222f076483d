// The part of FreeRTOS's task.h that apps use. Apps do not sleep here: a delay returns at once.
#ifndef CF_APP_TASK_H
#define CF_APP_TASK_H

#include "FreeRTOS.h"
#include "library/services.h"

#endif  // CF_APP_TASK_H
