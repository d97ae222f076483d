// Packets under the sanitizers: every type with its own lengths and others, numbers that are none,
// and a hundred thousand of random bytes into drones that fly on them.

#include <float.h>
#include <math.h>
#include <string.h>

#include "api/quatcompress.h"
#include "builtin/builtin.h"
#include "check.h"
#include "commands.h"
#include "onboard/commander/cppm.h"
#include "onboard/commander/rpyt.h"
#include "onboard/compressed.h"

#define PACKETS 100000
#define COUNT(array_) (sizeof(array_) / sizeof((array_)[0]))

static const cf_motion_t AT_REST = {.position       = {0.0f, 0.0f, 0.0145f},
                                    .quat_wxyz      = {1.0f, 0.0f, 0.0f, 0.0f},
                                    .rotation       = {1, 0, 0, 0, 1, 0, 0, 0, 1},
                                    .specific_force = {0.0f, 0.0f, 9.81f}};

static const float WILD[] = {NAN,     INFINITY, -INFINITY, FLT_MAX,  -FLT_MAX, FLT_MIN, 1e-45f,
                             -1e-45f, 0.0f,     -0.0f,     1e20f,    -1e20f,   1e38f,   3e38f,
                             180.0f,  -180.0f,  360.0f,    32767.0f, 65536.0f, 1.0f,    0.5f};

static const uint8_t PORTS[] = {3, 3, 6, 7, 7, 7, 7, 7, 8, 9};

static void boot(cf_t *cf) {
  cf_config_t config;
  CHECK(cf_config_default(&config, CF_PLATFORM_CF2) == CF_OK);
  CHECK(cf_init(cf, &config) == CF_OK);
}

static void rest(cf_t *cf, int ticks) {
  for (int i = 0; i < ticks; i++) {
    cf_tick(cf, &AT_REST);
  }
}

static uint32_t next(uint32_t *state) {
  *state ^= *state << 13;
  *state ^= *state >> 17;
  *state ^= *state << 5;
  return *state;
}

// Lengths by type of port 7 channel 0.
static const int GENERIC_LENGTHS[] = {1, 17, 17, 10, 17, 17, 29, 17, 17, 17, 17, 16, 1};
static const int OTHER_LENGTHS[]   = {1, 2, 5, 7, 12, 14, 21, 22, 23, 28, 29, 30};

static int right_length(uint32_t *random, uint8_t port, uint8_t type) {
  if (port == 3) {
    return 14;
  }
  return port == 7 ? GENERIC_LENGTHS[type] : OTHER_LENGTHS[next(random) % COUNT(OTHER_LENGTHS)];
}

// Three in four of a known type and mostly of its length, half of the floats wild.
static int make_packet(uint32_t *random, uint8_t port, uint8_t data[CF_PACKET_BYTES]) {
  for (int i = 0; i < CF_PACKET_BYTES; i++) {
    data[i] = (uint8_t)next(random);
  }
  for (int at = port != 3; at + 4 <= CF_PACKET_BYTES; at += 4) {
    const float tame  = (float)(next(random) % 4000) / 1000.0f - 2.0f;
    const float value = next(random) % 8 == 0 ? WILD[next(random) % COUNT(WILD)] : tame;
    memcpy(data + at, &value, sizeof value);
  }
  if (next(random) % 4 == 0) {
    return (int)(next(random) % (CF_PACKET_BYTES + 1));
  }
  const uint8_t type = (uint8_t)(next(random) % COUNT(GENERIC_LENGTHS));
  if (port != 3) {
    data[0] = type;
  }
  return right_length(random, port, type);
}

static bool is_changed(const cf_t *cf, const cf_t *before) {
  return memcmp(cf, before, sizeof *cf) != 0;
}

static bool is_finite_control(const control_t *control) {
  return isfinite(control->thrust);
}

// What holds after any packet and any tick.
static void check_drone(const cf_t *cf) {
  const cf_onboard_t *onboard = &cf->onboard;
  CHECK(cf_setpoint_is_finite(&onboard->client_setpoint));
  CHECK(cf_setpoint_is_finite(&onboard->commander.setpoint));
  CHECK(cf_setpoint_is_finite(&onboard->setpoint));
  CHECK(onboard->fault != CF_FAULT_NONE || is_finite_control(&onboard->control));
  if (onboard->fault != CF_FAULT_NONE) {
    for (int i = 0; i < STABILIZER_NR_OF_MOTORS; i++) {
      CHECK(onboard->motors.list[i] == 0);
    }
  }
}

static void test_random_packets_never_reach_the_motors_as_no_numbers(void) {
  static cf_t ready, cf, before;
  boot(&ready);
  rest(&ready, 2000);
  cf                 = ready;
  uint32_t random    = 2463534242u;
  int      counts[6] = {0};
  int      turning   = 0;

  for (int i = 0; i < PACKETS; i++) {
    const uint8_t port    = PORTS[next(&random) % COUNT(PORTS)];
    const uint8_t channel = (uint8_t)(next(&random) % 8 / (port == 6 ? 2 : 7));
    uint8_t       data[CF_PACKET_BYTES];
    const int     length = make_packet(&random, port, data);

    // any flight mode, and scales that may be no numbers
    if (i % 50 == 0) {
      uint8_t *modes           = &cf.onboard.rpyt.althold;
      modes[next(&random) % 7] = (uint8_t)(next(&random) % 4);
      cf.onboard.cppm.angRoll  = WILD[next(&random) % COUNT(WILD)];
    }

    // exactly as long as it says, so that the sanitizer sees the byte behind it
    uint8_t *exact = malloc((size_t)length + 1);
    memcpy(exact + 1, data, (size_t)length);
    before = cf;
    cf_packet_reply_t reply;
    const cf_status_t status = cf_receive_packet(&cf, port, channel, exact + 1, length, &reply);
    free(exact);

    counts[-status]++;
    CHECK(reply.length >= 0 && reply.length <= CF_PACKET_BYTES);
    if (status == CF_ERR_VALUE || status == CF_ERR_UNKNOWN) {
      CHECK(!is_changed(&cf, &before));
      CHECK(reply.length == 0);
    }
    check_drone(&cf);
    cf_tick(&cf, &AT_REST);
    check_drone(&cf);
    turning += cf.onboard.motors.list[0] > 0;

    // a drone that is stopped for good makes room for a fresh one
    if (cf.onboard.fault != CF_FAULT_NONE || cf_supervisor_is_locked(&cf.onboard.supervisor)) {
      cf = ready;
    }
  }
  // the test has seen every outcome
  CHECK(counts[0] > PACKETS / 4);
  CHECK(counts[-CF_ERR_VALUE] > PACKETS / 8);
  CHECK(counts[-CF_ERR_UNKNOWN] > PACKETS / 20);
  CHECK(counts[-CF_ERR_STATE] > 0);
  CHECK(turning > PACKETS / 4);
}

static void test_altitude_hold_resets_the_position_loops_once(void) {
  static cf_t cf;
  boot(&cf);
  cf_builtin_t *provider   = (cf_builtin_t *)cf.provider_state;
  float        *integral   = &provider->pid.position.vz.integ;
  const bool    holds[]    = {false, true, true, false, true};
  const float   expected[] = {3.0f, 0.0f, 3.0f, 3.0f, 0.0f};
  for (size_t i = 0; i < COUNT(holds); i++) {
    *integral               = 3.0f;
    cf.onboard.rpyt.althold = holds[i];
    CHECK(cf_send_rpyt(&cf, 0.0f, 0.0f, 0.0f, 40000) == CF_OK);
    CHECK(*integral == expected[i]);
  }

  // a refused command resets nothing
  cf.onboard.rpyt.althold = 0;
  CHECK(cf_send_rpyt(&cf, 0.0f, 0.0f, 0.0f, 40000) == CF_OK);
  cf.onboard.rpyt.althold = 1;
  *integral               = 3.0f;
  CHECK(cf_send_rpyt(&cf, NAN, 0.0f, 0.0f, 40000) == CF_ERR_VALUE);
  CHECK(*integral == 3.0f);
}

static void test_legacy_command_survives_wild_numbers_in_every_mode(void) {
  for (int mode = 0; mode < 128; mode++) {
    for (size_t i = 0; i < COUNT(WILD); i++) {
      for (size_t k = 0; k < COUNT(WILD); k++) {
        cf_rpyt_t  rpyt     = {.althold       = mode & 1,
                               .poshold       = mode >> 1 & 1,
                               .posSet        = mode >> 2 & 1,
                               .yawMode       = (uint8_t)(mode >> 3 & 3),
                               .stabModeRoll  = mode >> 5 & 1,
                               .stabModePitch = mode >> 6 & 1,
                               .stabModeYaw   = mode >> 6 & 1};
        setpoint_t setpoint = {.timestamp = 0};
        (void)cf_setpoint_rpyt(&setpoint, &rpyt, 2, WILD[i], WILD[k], WILD[(i + k) % COUNT(WILD)],
                               65535);
        CHECK(cf_setpoint_is_finite(&setpoint));
      }
    }
  }
}

static void test_sticks_survive_wild_scales(void) {
  for (size_t i = 0; i < COUNT(WILD); i++) {
    const cf_cppm_t        cppm     = {WILD[i], WILD[i], WILD[i], WILD[i], WILD[i]};
    const cf_cppm_sticks_t sticks   = {65535, 0, 65535, 65535, (int)(i % 2), {0}};
    setpoint_t             setpoint = {.timestamp = 0};
    (void)cf_setpoint_cppm(&setpoint, &cppm, &sticks);
    CHECK(cf_setpoint_is_finite(&setpoint));
  }
}

static void test_compression_survives_wild_numbers(void) {
  for (size_t i = 0; i < COUNT(WILD); i++) {
    const float w = WILD[i];
    for (int k = 0; k < 4; k++) {
      float q[4] = {0.5f, w, -0.5f, 0.5f};
      q[k]       = w;
      float back[4];
      quatdecompress(quatcompress(q), back);
      CHECK(fabsf(back[(quatcompress(q) >> 30) ^ 1u]) <= 0.70711f);
    }

    const state_t    state    = {.position           = {.x = w, .y = -w},
                                 .velocity           = {.z = w},
                                 .acc                = {.x = w, .z = w},
                                 .attitudeQuaternion = {.x = w, .w = 1.0f}};
    const Axis3f     gyro     = {.axis = {w, w, w}};
    const setpoint_t setpoint = {.position = {.x = w}, .acceleration = {.z = w}};
    CHECK(cf_compress_state(&state, &gyro).x == cf_compress_setpoint(&setpoint).x);
  }
}

static void test_every_word_is_four_numbers_or_one_that_is_none(void) {
  uint32_t random = 88172645u;
  for (int i = 0; i < PACKETS; i++) {
    const uint32_t word = next(&random);
    float          q[4];
    quatdecompress(word, q);
    for (unsigned k = 0; k < 4; k++) {
      CHECK(k == word >> 30 ? isnan(q[k]) || (q[k] >= 0.0f && q[k] <= 1.0f)
                            : fabsf(q[k]) <= 0.70711f);
    }
  }
}

int main(void) {
  test_random_packets_never_reach_the_motors_as_no_numbers();
  test_altitude_hold_resets_the_position_loops_once();
  test_legacy_command_survives_wild_numbers_in_every_mode();
  test_sticks_survive_wild_scales();
  test_compression_survives_wild_numbers();
  test_every_word_is_four_numbers_or_one_that_is_none();
  return 0;
}
