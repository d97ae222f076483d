// Reads and writes variables of the drone by name: its own, those of the provider, those of the
// host.

#include "app_modes.h"
#include "log.h"
#include "param.h"

static logVarId_t   own;
static logVarId_t   of_function;
static logVarId_t   of_host;
static logVarId_t   missing;
static paramVarId_t own_parameter;
static paramVarId_t of_provider;
static paramVarId_t of_host_parameter;
static bool         is_ready;

static void find(void) {
  own               = logGetVarId("counters", "calls");
  of_function       = logGetVarId("counters", "computed");
  of_host           = logGetVarId("host", "height");
  missing           = logGetVarId("no", "such");
  own_parameter     = paramGetVarId("counters", "gain");
  of_provider       = paramGetVarId("pid_rate", "roll_kp");
  of_host_parameter = paramGetVarId("host", "selector");
  is_ready          = true;
}

void read_variables(const call_t *call) {
  if (!is_ready) {
    find();
  }
  if (logVarIdIsValid(missing) || PARAM_VARID_IS_VALID(paramGetVarId("no", "such")) ||
      logGetVarId("counters", "calls") != own || logGetType(own) != LOG_UINT32) {
    return;
  }
  call->control->controlMode         = controlModeForce;
  call->control->normalizedForces[0] = logGetFloat(of_host);
  call->control->normalizedForces[1] = logGetFloat(of_function);
  call->control->normalizedForces[2] = paramGetFloat(of_provider);
  call->control->normalizedForces[3] = (float)paramGetInt(of_host_parameter);
  paramSetFloat(own_parameter, 0.75f);
  paramSetInt(of_host_parameter, 5);
  paramSetInt(of_provider, 123);
}
