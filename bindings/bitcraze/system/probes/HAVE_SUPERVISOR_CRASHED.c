// The supervisor knows crashes, and recovers from them when it is asked to.
#include "supervisor.h"

bool probe(void);
bool probe(void) {
  return supervisorIsCrashed() && supervisorRequestCrashRecovery(true);
}
