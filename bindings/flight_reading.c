#include "flight_reading.h"

#include <string.h>

#define RADIANS 0.0174532924f  // in a degree
#define GRAVITY 9.81f          // [m/s^2] in a g

// In the order of the exported policies, so that both see the same bits.
static void rotation_of(float w, float x, float y, float z, float r[9]) {
  r[0] = 1.0f - 2.0f * (y * y + z * z);
  r[1] = 2.0f * (x * y - w * z);
  r[2] = 2.0f * (x * z + w * y);
  r[3] = 2.0f * (x * y + w * z);
  r[4] = 1.0f - 2.0f * (x * x + z * z);
  r[5] = 2.0f * (y * z - w * x);
  r[6] = 2.0f * (x * z - w * y);
  r[7] = 2.0f * (y * z + w * x);
  r[8] = 1.0f - 2.0f * (x * x + y * y);
}

static void read(const cf_t *cf, uint32_t ticks, cf_flight_reading_t *reading) {
  const cf_onboard_t *onboard  = &cf->onboard;
  const state_t      *estimate = &onboard->estimator.estimate;
  const quaternion_t *q        = &estimate->attitudeQuaternion;
  memcpy(reading->position, &estimate->position.x, sizeof reading->position);
  memcpy(reading->velocity, &estimate->velocity.x, sizeof reading->velocity);
  rotation_of(q->w, q->x, q->y, q->z, reading->rotation);
  for (int i = 0; i < 3; i++) {
    reading->rates[i]          = onboard->sensors.data.gyro.axis[i] * RADIANS;
    reading->specific_force[i] = onboard->sensors.data.acc.axis[i] * GRAVITY;
  }
  reading->battery_voltage = cf->vehicle.battery.voltage;
  reading->is_out          = cf_is_out(cf) ? 1 : 0;
  reading->is_touching =
      cf->contacts.count > 0 && onboard->tick - cf->contacts.tick < ticks ? 1 : 0;
}

void cf_read_flights(const cf_t *const *drones, int count, uint32_t ticks,
                     cf_flight_reading_t *readings) {
  for (int i = 0; i < count; i++) {
    read(drones[i], ticks, &readings[i]);
  }
}

void cf_rotations_of(const double *quats, int count, int stride, float *rotations) {
  for (int i = 0; i < count; i++) {
    const double *q = quats + (ptrdiff_t)i * stride;
    rotation_of((float)q[0], (float)q[1], (float)q[2], (float)q[3], rotations + 9 * (ptrdiff_t)i);
  }
}
