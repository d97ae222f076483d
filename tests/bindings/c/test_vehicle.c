/* The vehicle under the sanitizers: broken motion, broken configs, the ends of every range. */
#include "vehicle/vehicle.h"

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "check.h"

static const float EYE[9] = {1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f};

#define ODD_COUNT 14
static const float ODD[ODD_COUNT] = {
    0.0f,     -0.0f,  1.0f,    -1.0f,  FLT_MIN, 1e-42f,   FLT_MAX,
    -FLT_MAX, 2.2e9f, -2.2e9f, 4.3e9f, NAN,     INFINITY, -INFINITY,
};

static cf_vehicle_t make_with(cf_platform_t platform, cf_positioning_t positioning) {
  cf_vehicle_config_t config;
  cf_vehicle_t        vehicle;
  CHECK(cf_vehicle_default_config(&config, platform) == CF_OK);
  config.positioning = positioning;
  CHECK(cf_vehicle_init(&vehicle, &config, 1, 2) == CF_OK);
  return vehicle;
}

static cf_vehicle_t make(cf_platform_t platform) {
  return make_with(platform, CF_POSITIONING_MOCAP);
}

static void sensors_survive(cf_vehicle_t *vehicle, float odd, int place) {
  float position[3] = {0.1f, 0.2f, 1.0f};
  float quat[4]     = {1.0f, 0.0f, 0.0f, 0.0f};
  float rotation[9];
  float velocity[3] = {0.0f, 0.0f, 0.0f};
  float rates[3]    = {0.0f, 0.0f, 0.0f};
  float force[3]    = {0.0f, 0.0f, 9.81f};
  memcpy(rotation, EYE, sizeof rotation);

  // one broken number at a time
  float *const numbers[] = {&position[2], &quat[0],  &rotation[8], &rotation[0],
                            &velocity[0], &rates[1], &force[2]};
  *numbers[place]        = odd;

  Axis3i16          gyro;
  Axis3i16          acc;
  poseMeasurement_t pose;
  cf_flow_reading_t reading = {0};
  cf_sweep_t        sweeps[CF_LIGHTHOUSE_STATIONS];
  cf_ranging_t      ranging;
  uint16_t          ranges[CF_RANGE_COUNT];
  float             pressure;
  float             temperature;
  float             f[3];
  float             t[3];
  for (uint32_t tick = 0; tick < 60; tick++) {
    cf_vehicle_imu(vehicle, rates, force, &gyro, &acc);
    (void)cf_vehicle_mocap(vehicle, position, quat, &pose);
    (void)cf_vehicle_flow_deck(vehicle, position[2], rotation, velocity, rates, &reading);
    CHECK(reading.range < 5000 || reading.range == CF_RANGE_NOTHING);
    const int count = cf_vehicle_lighthouse(vehicle, position, rotation, sweeps);
    CHECK(count >= 0 && count <= CF_LIGHTHOUSE_STATIONS);
    for (int i = 0; i < count; i++) {
      CHECK(sweeps[i].station < CF_LIGHTHOUSE_STATIONS && sweeps[i].sweep < CF_LIGHTHOUSE_SWEEPS);
      CHECK(sweeps[i].sensors != 0 && sweeps[i].sensors < 1u << CF_LIGHTHOUSE_SENSORS);
      for (int k = 0; k < CF_LIGHTHOUSE_SENSORS; k++) {
        CHECK(isfinite(sweeps[i].angles[k]));
      }
    }
    if (cf_vehicle_loco(vehicle, position, &ranging)) {
      CHECK(ranging.anchor < CF_LOCO_ANCHORS && ranging.previous < CF_LOCO_ANCHORS);
    }
    const int measured = cf_rangers_step(&vehicle->rangers, position, rotation, NULL, ranges);
    for (int i = 0; i < CF_RANGE_COUNT; i++) {
      const bool is_new = (measured >> i & 1) != 0;
      CHECK(!is_new || ranges[i] < 5000 || ranges[i] == CF_RANGE_NOTHING);
    }
    (void)cf_vehicle_barometer(vehicle, position[2], &pressure, &temperature);
    cf_vehicle_feel_air(vehicle, position, rotation, velocity);
    for (int i = 0; i < CF_ROTOR_COUNT; i++) {
      CHECK(vehicle->ground_effect.gain[i] >= 1.0f);
      CHECK(vehicle->ground_effect.gain[i] <= vehicle->ground_effect.config.cap);
    }
    cf_vehicle_wrench(vehicle, rotation, velocity, rates, f, t);
  }
}

static void broken_motion_does_not_trap(void) {
  for (int platform = 0; platform < CF_PLATFORM_COUNT; platform++) {
    for (int system = 0; system < CF_POSITIONING_COUNT; system++) {
      cf_vehicle_t vehicle = make_with((cf_platform_t)platform, (cf_positioning_t)system);
      for (int i = 0; i < ODD_COUNT; i++) {
        for (int place = 0; place < 7; place++) {
          sensors_survive(&vehicle, ODD[i], place);
        }
      }
    }
  }
}

static void saturation_is_at_the_ends_of_16_bits(void) {
  cf_vehicle_t   vehicle  = make(CF_PLATFORM_CF2);
  const float    up[3]    = {INFINITY, FLT_MAX, 40.0f};
  const float    down[3]  = {-INFINITY, -FLT_MAX, NAN};
  const float    force[3] = {240.0f, -240.0f, 0.0f};
  Axis3i16       gyro;
  Axis3i16       acc;
  const uint16_t off[4] = {0, 0, 0, 0};
  cf_vehicle_actuate(&vehicle, off);

  cf_vehicle_imu(&vehicle, up, force, &gyro, &acc);
  CHECK(gyro.x == 32767 && gyro.y == 32767 && gyro.z == 32767);
  CHECK(acc.x == 32767 && acc.y == -32768);
  cf_vehicle_imu(&vehicle, down, force, &gyro, &acc);
  CHECK(gyro.x == -32768 && gyro.y == -32768 && gyro.z == -32768);
}

static void every_ratio_is_fine(void) {
  for (int platform = 0; platform < CF_PLATFORM_COUNT; platform++) {
    cf_vehicle_t vehicle = make((cf_platform_t)platform);
    for (uint32_t ratio = 0; ratio <= 65535; ratio += 17) {
      const uint16_t r         = (uint16_t)ratio;
      const uint16_t ratios[4] = {r, (uint16_t)(65535 - r), 0, 65535};
      cf_vehicle_actuate(&vehicle, ratios);
      CHECK(isfinite(vehicle.battery.voltage) && vehicle.battery.voltage > 0.0f);
      for (int i = 0; i < CF_ROTOR_COUNT; i++) {
        CHECK(vehicle.rotors.thrust[i] >= 0.0f && vehicle.rotors.thrust[i] < 0.5f);
      }
    }
  }
}

static void pack_runs_down_without_trap(void) {
  cf_vehicle_t   vehicle   = make(CF_PLATFORM_CF2);
  const uint16_t ratios[4] = {65535, 65535, 65535, 65535};
  vehicle.battery.charge   = 0.01f;
  for (int i = 0; i < 200000; i++) {
    cf_vehicle_actuate(&vehicle, ratios);
  }
  CHECK(vehicle.battery.charge == -0.2f);
  CHECK(cf_rotors_total_thrust(&vehicle.rotors) < vehicle.mass * 9.81f);
}

// A bool may hold nothing else than 0 and 1; those that switch effects are on.
static bool holds_bools(size_t at) {
  const size_t places[] = {
      offsetof(cf_vehicle_config_t, airframe.aerodynamics.has_flight_moment),
      offsetof(cf_vehicle_config_t, airframe.ground_effect.is_enabled),
      offsetof(cf_vehicle_config_t, airframe.downwash.is_enabled),
      offsetof(cf_vehicle_config_t, rangers),
  };
  bool holds = false;
  for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
    holds = holds || places[i] / sizeof(float) == at / sizeof(float);
  }
  return holds;
}

static void odd_gusts_are_refused_or_blow(void) {
  const float still[3] = {0.0f, 0.0f, 0.0f};
  const float place[3] = {0.0f, 0.0f, 1.0f};
  for (int i = 0; i < ODD_COUNT; i++) {
    for (int k = 0; k < ODD_COUNT; k++) {
      cf_vehicle_t vehicle = make(CF_PLATFORM_CF2);
      const float  peak[3] = {0.0f, ODD[i], 0.0f};
      (void)cf_vehicle_gust(&vehicle, peak, ODD[k]);
      for (int tick = 0; tick < 1200; tick++) {
        cf_vehicle_feel_air(&vehicle, place, EYE, still);
        CHECK(fabsf(vehicle.wind.velocity[1]) <= 50.0f);
      }
    }
  }
}

// every float of the config in turn becomes every odd number: init must say no or make a vehicle
// that runs
static void odd_configs_are_refused_or_run(cf_positioning_t positioning) {
  cf_vehicle_config_t good;
  CHECK(cf_vehicle_default_config(&good, CF_PLATFORM_CF2) == CF_OK);
  good.positioning = positioning;
  good.rangers     = (cf_rangers_config_t){.has_multiranger = true, .has_zranger = true};
  good.airframe.wind.turbulence = CF_TURBULENCE_DRYDEN;
  const uint16_t ratios[4]      = {65535, 30000, 1, 0};

  for (size_t word = 0; word < sizeof good / sizeof(float); word++) {
    for (int i = 0; i < ODD_COUNT; i++) {
      cf_vehicle_config_t config = good;
      const size_t        at     = word * sizeof(float);
      if (holds_bools(at)) {
        continue;
      }
      memcpy((char *)&config + at, &ODD[i], sizeof(float));
      cf_vehicle_t vehicle;
      if (cf_vehicle_init(&vehicle, &config, 1, 1) != CF_OK) {
        continue;
      }
      for (int tick = 0; tick < 20; tick++) {
        cf_vehicle_actuate(&vehicle, ratios);
      }
      sensors_survive(&vehicle, 1.0f, 0);
    }
  }
}

static void refused_config_leaves_the_vehicle(void) {
  cf_vehicle_config_t config;
  CHECK(cf_vehicle_default_config(&config, CF_PLATFORM_CF21BL) == CF_OK);
  config.airframe.mass = NAN;
  cf_vehicle_t vehicle;
  cf_vehicle_t before;
  memset(&vehicle, 0x5a, sizeof vehicle);
  memset(&before, 0x5a, sizeof before);
  CHECK(cf_vehicle_init(&vehicle, &config, 1, 1) == CF_ERR_VALUE);
  CHECK(memcmp(&vehicle, &before, sizeof vehicle) == 0);
  CHECK(cf_vehicle_default_config(&config, (cf_platform_t)CF_PLATFORM_COUNT) == CF_ERR_UNKNOWN);
}

static void normal_numbers_exist_for_all_kinds_of_bits(void) {
  for (uint32_t i = 0; i < 32; i++) {
    for (uint32_t around = 0; around < 5; around++) {
      const float x = cf_random_normal_from_bits((1u << i) + around - 2u);
      CHECK(fabsf(x) < 6.24f);
    }
  }
  CHECK(fabsf(cf_random_normal_from_bits(0xffffffffu)) < 1e-6f);
}

static void ring_of_the_mocap_never_overflows(void) {
  cf_vehicle_config_t config;
  CHECK(cf_vehicle_default_config(&config, CF_PLATFORM_CF2) == CF_OK);
  const float position[3] = {0.0f, 0.0f, 0.0f};
  const float quat[4]     = {1.0f, 0.0f, 0.0f, 0.0f};
  for (uint32_t rate = 1; rate <= 1000; rate += 37) {
    config.mocap.rate       = rate;
    config.mocap.latency_ms = CF_MOCAP_CAPACITY * 1000u / rate - 1u;
    cf_mocap_t mocap;
    config.mocap.latency_ms++;
    const cf_random_t dice = {{1, 2}};
    CHECK(cf_mocap_init(&mocap, &config.mocap, dice, dice) == CF_ERR_CAPACITY);
    config.mocap.latency_ms--;
    CHECK(cf_mocap_init(&mocap, &config.mocap, dice, dice) == CF_OK);
    uint32_t          arrived = 0;
    poseMeasurement_t pose;
    for (uint32_t tick = 0; tick < 3000 + config.mocap.latency_ms; tick++) {
      CHECK(mocap.waiting <= CF_MOCAP_CAPACITY);
      arrived += cf_mocap_step(&mocap, position, quat, &pose) ? 1u : 0u;
    }
    CHECK(arrived == 3u * rate);
  }
}

int main(void) {
  broken_motion_does_not_trap();
  saturation_is_at_the_ends_of_16_bits();
  every_ratio_is_fine();
  pack_runs_down_without_trap();
  for (int system = 0; system < CF_POSITIONING_COUNT; system++) {
    odd_configs_are_refused_or_run((cf_positioning_t)system);
  }
  refused_config_leaves_the_vehicle();
  odd_gusts_are_refused_or_blow();
  normal_numbers_exist_for_all_kinds_of_bits();
  ring_of_the_mocap_never_overflows();
  return 0;
}
