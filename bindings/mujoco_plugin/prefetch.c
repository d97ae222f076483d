#include "mujoco_plugin/prefetch.h"

#include <stddef.h>

#define LARGE_SWARM 256
#define LINE 64

// From the first byte of one member to the last of another.
#define FROM(first, last) offsetof(cf_t, first), offsetof(cf_t, last) + sizeof(((cf_t *)0)->last)
#define BYTES(member, begin, end) offsetof(cf_t, member) + (begin), offsetof(cf_t, member) + (end)

// What valgrind's lackey saw a tick of a hovering drone touch, with the built-in Kalman filter and
// PID controller, poses and brushed motors.
static const struct {
  size_t begin;
  size_t end;
} TOUCHED[] = {
    {BYTES(config, 0, LINE)},
    {FROM(config.vehicle.airframe.imu, config.vehicle.airframe.imu)},
    {FROM(onboard.sensors.gyro_bias.next, onboard.int_to_out)},
    {FROM(onboard.supervisor, onboard.supervisor)},
    {FROM(onboard.health.variance_y, onboard.commander)},
    {FROM(onboard.estimator.queue_count, onboard.estimator.gyroLatest)},
    {FROM(onboard.estimator.nextPredictionMs, onboard.high_level.setpoint)},
    {FROM(vehicle.mass, vehicle.positioning)},
    {FROM(last_velocity, injected.is_sensing_wrong)},
    {FROM(rest.load, wants_peers)},
    {BYTES(provider_state, 0, 37 * LINE)},
};

bool cf_prefetch_pays(const swarm_t *swarm) {
  return swarm->count >= LARGE_SWARM;
}

void cf_prefetch(const cf_t *cf) {
  for (size_t i = 0; i < sizeof TOUCHED / sizeof TOUCHED[0]; i++) {
    for (size_t at = TOUCHED[i].begin / LINE * LINE; at < TOUCHED[i].end; at += LINE) {
      __builtin_prefetch((const char *)cf + at, 1, 2);
    }
  }
}
