/* The supervisor under the sanitizers: samples that are no numbers, ticks that wrap, states and
 * planner states that do not exist. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "check.h"
#include "onboard/supervisor.h"

static const float    ACC[]   = {NAN, INFINITY, -INFINITY, FLT_MAX, -FLT_MAX, 0.0f, 1.0f, -1.0f};
static const uint32_t TICKS[] = {0, 1, 500, 2000, 30001, UINT32_MAX - 10, UINT32_MAX};

#define COUNT(array_) (sizeof(array_) / sizeof((array_)[0]))

static bool is_known(supervisorState_t state) {
  return (int)state >= 0 && state < supervisorState_NrOfStates;
}

static void test_any_input(bool auto_arming) {
  cf_supervisor_t supervisor;
  memset(&supervisor, 0xa5, sizeof supervisor);
  cf_supervisor_init(&supervisor, auto_arming);

  for (size_t i = 0; i < COUNT(ACC); i++) {
    for (size_t j = 0; j < COUNT(TICKS); j++) {
      for (size_t k = 0; k < COUNT(TICKS); k++) {
        const cf_supervisor_inputs_t inputs = {
            .acc                 = {.x = ACC[i], .y = ACC[(i + j) % COUNT(ACC)], .z = ACC[i]},
            .setpoint_tick       = TICKS[j],
            .now                 = TICKS[k],
            .motor_ratio         = {TICKS[j], TICKS[k], 0, UINT32_MAX},
            .idle_thrust         = TICKS[i % COUNT(TICKS)],
            .planner_state       = (int)i - 2,
            .planner_is_finished = true,
        };
        (void)cf_supervisor_request_arming(&supervisor, k % 2 == 0);
        (void)cf_supervisor_request_crash_recovery(&supervisor, true);
        const char *line = cf_supervisor_update(&supervisor, &inputs, 40);
        CHECK(line == NULL || strlen(line) > 0);
        CHECK(is_known(supervisor.state));

        setpoint_t setpoint = {.thrust = 1.0f};
        cf_supervisor_override_setpoint(&supervisor, &setpoint);
        CHECK(cf_supervisor_are_motors_allowed(&supervisor) || setpoint.thrust == 0.0f);
      }
    }
  }
}

// Half of the time lines of a flight lie across the wrap of the tick after 49.7 days.
static void test_ticks_may_wrap(void) {
  cf_supervisor_t supervisor;
  cf_supervisor_init(&supervisor, true);
  cf_supervisor_inputs_t inputs = {.acc = {.z = 1.0f}, .now = UINT32_MAX - 2000};
  for (int update = 0; update < 1000; update++) {
    inputs.now += 40;
    inputs.setpoint_tick = inputs.now - 20;
    for (int m = 0; m < STABILIZER_NR_OF_MOTORS; m++) {
      inputs.motor_ratio[m] = 30000;
    }
    (void)cf_supervisor_update(&supervisor, &inputs, 40);
  }
  CHECK(supervisor.state == supervisorStateFlying);
}

int main(void) {
  test_any_input(true);
  test_any_input(false);
  test_ticks_may_wrap();
  return 0;
}
