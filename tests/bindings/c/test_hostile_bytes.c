/* Bytes of strangers under the sanitizers: trajectory memory and packets of port 8 full of noise.
 * Buffers are exactly as long as they claim to be, so that one byte too many is found. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "api/pptraj_compressed.h"
#include "check.h"
#include "onboard/packets/high_level_packets.h"

#define CASES 100000

// xorshift32
static uint32_t next(uint32_t *random) {
  *random ^= *random << 13;
  *random ^= *random >> 17;
  *random ^= *random << 5;
  return *random;
}

static uint32_t below(uint32_t *random, uint32_t limit) {
  return next(random) % limit;
}

// Noise with many zeros and short durations among it; the caller frees it.
static uint8_t *noise(uint32_t *random, uint32_t size) {
  uint8_t *bytes = malloc(size > 0 ? size : 1);
  CHECK(bytes != NULL);
  const uint32_t zeros = below(random, 4);
  for (uint32_t i = 0; i < size; i++) {
    bytes[i] = below(random, 4) < zeros ? 0 : (uint8_t)next(random);
  }
  return bytes;
}

static bool is_finite(struct vec v) {
  return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

static void test_compressed_bytes(uint32_t *random) {
  const uint32_t size  = below(random, 160);
  uint8_t       *bytes = noise(random, size);

  struct piecewise_traj_compressed trajectory;
  piecewise_compressed_load(&trajectory, bytes, size);
  const float duration = piecewise_compressed_duration(&trajectory);
  CHECK(duration >= 0.0f && duration < 160.0f / 3.0f * 65.536f);

  trajectory.t_begin = (float)below(random, 100000);
  for (int i = 0; i < 6; i++) {
    const float      t  = trajectory.t_begin + duration * (float)below(random, 1100) / 1000.0f;
    struct traj_eval ev = piecewise_compressed_eval(&trajectory, t);
    const bool       ok = is_finite(ev.pos) && is_finite(ev.vel) && is_finite(ev.acc) &&
                          is_finite(ev.jerk) && isfinite(ev.yaw);
    CHECK(ok == (size >= PPTRAJ_COMPRESSED_START_BYTES));
    // the bytes may change under way
    if (size > 0) {
      bytes[below(random, size)] = (uint8_t)next(random);
    }
  }
  (void)piecewise_compressed_eval(&trajectory, NAN);
  (void)piecewise_compressed_eval(&trajectory, INFINITY);
  (void)piecewise_compressed_eval(&trajectory, -INFINITY);
  free(bytes);
}

typedef struct {
  uint64_t                  provider_state[CF_PROVIDER_STATE_BYTES / 8];
  cf_high_level_commander_t commander;
  uint64_t                  now_us;
} vehicle_t;

static void init(vehicle_t *vehicle) {
  memset(vehicle, 0, sizeof *vehicle);
  CHECK(cf_provider(0)->init(vehicle->provider_state, CF_PLATFORM_CF2, 0) == CF_OK);
  cf_high_level_commander_init(&vehicle->commander);
}

static void check_setpoint(const setpoint_t *s) {
  CHECK(isfinite(s->position.x) && isfinite(s->position.y) && isfinite(s->position.z));
  CHECK(isfinite(s->velocity.x) && isfinite(s->velocity.y) && isfinite(s->velocity.z));
  CHECK(isfinite(s->acceleration.x) && isfinite(s->acceleration.y) && isfinite(s->acceleration.z));
  CHECK(isfinite(s->jerk.x) && isfinite(s->jerk.y) && isfinite(s->jerk.z));
  CHECK(isfinite(s->attitude.yaw) && isfinite(s->thrust));
  CHECK(isfinite(s->attitudeRate.roll) && isfinite(s->attitudeRate.pitch) &&
        isfinite(s->attitudeRate.yaw));
}

// A packet whose command exists more often than not, and whose group is often 0, all vehicles.
static uint8_t send_noise(vehicle_t *vehicle, uint32_t *random) {
  const uint32_t size = below(random, 32);
  uint8_t       *data = noise(random, size);
  if (size > 0 && below(random, 8) > 0) {
    data[0] = (uint8_t)below(random, 14);
  }
  if (size > 1 && below(random, 2) > 0) {
    data[1] = 0;
  }
  if (size > 4 && data[0] == 6) {
    data[2] = 1;
    data[3] = (uint8_t)below(random, 2);
  }

  uint8_t   reply[CF_HIGH_LEVEL_REPLY_BYTES] = {0};
  const int replied =
      cf_high_level_commander_packet(&vehicle->commander, cf_provider(0), vehicle->provider_state,
                                     data, size, vehicle->now_us, reply);
  CHECK(replied == (size == 0 ? 0 : CF_HIGH_LEVEL_REPLY_BYTES));
  CHECK(size == 0 || reply[0] == data[0]);
  free(data);
  return reply[3];
}

static void write_noise(vehicle_t *vehicle, uint32_t *random) {
  const uint32_t size   = below(random, 300);
  const uint32_t offset = below(random, CF_TRAJECTORY_MEMORY_BYTES - 300);
  uint8_t       *bytes  = noise(random, size);
  CHECK(cf_high_level_commander_write_trajectory(&vehicle->commander, offset, size, bytes) ==
        CF_OK);
  free(bytes);
}

static void test_packets(vehicle_t *vehicle, uint32_t *random, int answers[256]) {
  if (below(random, 16) == 0) {
    write_noise(vehicle, random);
  }
  const bool block = below(random, 64) == 0;
  cf_high_level_commander_block(&vehicle->commander, cf_provider(0), vehicle->provider_state,
                                block);
  answers[send_noise(vehicle, random)]++;

  const state_t estimate = {.position = {.z = 0.5f}};
  for (int i = 0; i < 2; i++) {
    vehicle->now_us += below(random, 2000000);
    setpoint_t setpoint;
    if (cf_high_level_commander_get_setpoint(&vehicle->commander, cf_provider(0),
                                             vehicle->provider_state, &estimate, 10,
                                             vehicle->now_us, &setpoint)) {
      check_setpoint(&setpoint);
    }
    (void)cf_high_level_commander_is_trajectory_finished(&vehicle->commander, cf_provider(0),
                                                         vehicle->provider_state, vehicle->now_us);
  }
}

int main(void) {
  uint32_t random = 20260801;
  for (int i = 0; i < CASES; i++) {
    test_compressed_bytes(&random);
  }

  static vehicle_t vehicle;
  static int       answers[256];
  init(&vehicle);
  for (int i = 0; i < CASES; i++) {
    test_packets(&vehicle, &random, answers);
  }
  // the noise reached every kind of answer, and no other
  const int known = answers[CF_HIGH_LEVEL_REPLY_OK] + answers[CF_HIGH_LEVEL_REPLY_REFUSED] +
                    answers[CF_HIGH_LEVEL_REPLY_NOEXEC] + answers[CF_HIGH_LEVEL_REPLY_BUSY];
  CHECK(answers[CF_HIGH_LEVEL_REPLY_OK] > 0 && answers[CF_HIGH_LEVEL_REPLY_REFUSED] > 0);
  CHECK(answers[CF_HIGH_LEVEL_REPLY_NOEXEC] > 0 && answers[CF_HIGH_LEVEL_REPLY_BUSY] > 0);
  CHECK(known == CASES);
  return 0;
}
