// Everything that stops a program.

#include <signal.h>

#include "app_modes.h"
#include "cfassert.h"
#include "log.h"

enum { NULL_POINTER, DIVISION, ASSERTION, ABORT, BAD_ADDRESS };

static uint32_t half_done;

static volatile int *volatile nowhere;
static volatile int zero;

void fault(int kind) {
  half_done++;
  switch (kind) {
    case NULL_POINTER:
      *nowhere = 1;
      break;
    case DIVISION:
      zero = 1000 / zero;
      break;
    case ASSERTION:
      ASSERT(kind < ASSERTION);
      break;
    case ABORT:
      raise(SIGABRT);
      break;
    default:
      *(volatile int *)0x1234567890ULL = 1;
      break;
  }
}

LOG_GROUP_START(faults)
LOG_ADD(LOG_UINT32, halfDone, &half_done)
LOG_GROUP_STOP(faults)
