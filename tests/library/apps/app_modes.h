// The parts of the test app: one function per file, chosen by parameter testApp.mode.
#ifndef APP_MODES_H
#define APP_MODES_H

#include <stdbool.h>

#include "stabilizer_types.h"

typedef struct {
  control_t          *control;
  const setpoint_t   *setpoint;
  const sensorData_t *sensors;
  const state_t      *state;
  stabilizerStep_t    step;
} call_t;

void forward_to_controller(const call_t *call, int type);
void count(const call_t *call);
void fault(int kind);
void read_variables(const call_t *call);
void print(const call_t *call);
void call_parts(const call_t *call);

#endif  // APP_MODES_H
