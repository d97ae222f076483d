/* Drivers of the decks under the sanitizers: whatever the hardware says, and whatever a client
 * writes into parameters. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "check.h"
#include "crazyflie.h"
#include "onboard/decks/decks.h"

#define ODD_COUNT 12
static const float ODD[ODD_COUNT] = {
    0.0f, 1.0f, -1.0f, 1e-42f, FLT_MIN, FLT_MAX, -FLT_MAX, 1e10f, -1e10f, NAN, INFINITY, -INFINITY,
};

static void drain(cf_estimator_t *estimator) {
  estimator->queue_count = 0;
}

// Base stations anywhere, of any attitude, with any calibration.
static void odd_stations(cf_base_stations_t *stations, float odd, int place) {
  for (int i = 0; i < CF_LIGHTHOUSE_STATIONS; i++) {
    cf_station_data_t *station = &stations->list[i];
    cf_lighthouse_look_at((float[3]){0.0f, (float)i, 2.0f}, (float[3]){2.0f, 0.0f, 0.0f},
                          station->rotation);
    station->has_geometry      = true;
    station->calibration.valid = true;
  }
  float *const numbers[] = {
      &stations->list[0].origin[1],
      &stations->list[1].rotation[0][2],
      &stations->list[0].calibration.sweep[0].tilt,
      &stations->list[1].calibration.sweep[1].phase,
      &stations->list[0].calibration.sweep[1].gibmag,
  };
  *numbers[place] = odd;
}

static void lighthouse_survives(uint8_t method, float odd, int place) {
  cf_estimator_t       estimator = {0};
  cf_lighthouse_deck_t deck;
  cf_lighthouse_deck_init(&deck);
  deck.method                             = method;
  estimator.estimate.attitudeQuaternion.w = place == 0 ? odd : 1.0f;
  estimator.estimate.position.x           = place == 1 ? odd : 1.0f;
  odd_stations(&estimator.stations, odd, place);

  for (uint32_t tick = UINT32_MAX - 60; tick != 60; tick++) {
    cf_sweep_t sweep = {.station = (uint8_t)(tick % 2), .sweep = (uint8_t)(tick / 7 % 2)};
    for (uint32_t i = 0; i < CF_LIGHTHOUSE_SENSORS; i++) {
      sweep.sensors |= (uint8_t)((tick + i) % 5 != 0 ? 1u << i : 0u);
      sweep.angles[i] = i == tick % 4 ? odd : 0.1f * (float)i;
    }
    cf_lighthouse_deck_sweep(&deck, &estimator, &sweep, tick);
    for (uint32_t i = 0; i < estimator.queue_count; i++) {
      cf_resolved_sweep_t resolved;
      CHECK(cf_lighthouse_resolve(&resolved, &estimator.queue[i], &estimator.stations) != NULL);
    }
    drain(&estimator);
  }
  cf_lighthouse_deck_count(&deck, &estimator.stations);
}

static void every_number_of_light_is_fine(void) {
  for (int i = 0; i < ODD_COUNT; i++) {
    for (int place = 0; place < 5; place++) {
      lighthouse_survives(CF_LIGHTHOUSE_CROSSING_BEAMS, ODD[i], place);
      lighthouse_survives(CF_LIGHTHOUSE_RAW_SWEEPS, ODD[i], place);
    }
  }
}

static void every_id_of_a_sweep_is_fine(void) {
  cf_base_stations_t stations;
  memset(&stations, 0, sizeof stations);
  for (int id = 0; id < 256; id++) {
    const uint8_t byte        = (uint8_t)id;
    measurement_t measurement = {.type = MeasurementTypeSweepAngle};
    for (int place = 0; place < 3; place++) {
      measurement.data.sweepAngle = (sweepAngleMeasurement_t){
          .sensorId      = place == 0 ? byte : 0,
          .baseStationId = place == 1 ? byte : 0,
          .sweepId       = place == 2 ? byte : 0,
      };
      cf_resolved_sweep_t  resolved;
      const measurement_t *result = cf_lighthouse_resolve(&resolved, &measurement, &stations);
      const bool           exists = id < (place == 0 ? CF_LIGHTHOUSE_SENSORS : 2);
      CHECK((result->data.sweepAngle.rotorRotInv != NULL) == exists);
    }
  }
}

static void every_register_of_the_flow_deck_is_fine(void) {
  cf_estimator_t   estimator = {0};
  cf_flow_driver_t driver;
  cf_flow_driver_init(&driver, UINT32_MAX);
  for (int value = -32768; value <= 32767; value += 7) {
    for (uint8_t adaptive = 0; adaptive < 2; adaptive++) {
      const cf_flow_reading_t reading = {
          .delta_x = (int16_t)value,
          .delta_y = (int16_t)(-1 - value),
          .shutter = (uint16_t)(value + 32768),
          .motion  = (uint8_t)value,
          .squal   = (uint8_t)value,
      };
      driver.adaptive = adaptive;
      cf_flow_driver_read(&driver, &estimator, &reading, (uint32_t)value);
      CHECK(estimator.queue_count <= 1 && driver.std >= 0.0f);
      drain(&estimator);
    }
  }
}

static void every_range_is_fine(void) {
  cf_estimator_t     estimator = {0};
  cf_ranger_driver_t driver    = {.ranges = {0}};
  for (int value = 0; value <= UINT16_MAX; value += 7) {
    for (int direction = 0; direction < CF_RANGE_COUNT; direction++) {
      cf_ranger_driver_read(&driver, &estimator, direction, (uint16_t)value, 3);
      CHECK(driver.ranges[direction] == value);
    }
    CHECK(estimator.queue_count == (value < 5000));
    drain(&estimator);
  }
}

static void every_ranging_is_fine(void) {
  cf_estimator_t estimator = {0};
  cf_loco_deck_t deck;
  cf_loco_deck_init(&deck);
  deck.is_planar = true;
  for (int i = 0; i < ODD_COUNT; i++) {
    deck.height = ODD[i];
    for (uint8_t anchor = 0; anchor < CF_LOCO_ANCHORS; anchor++) {
      for (uint8_t mode = CF_LOCO_TWR; mode <= CF_LOCO_TDOA3; mode++) {
        const cf_ranging_t ranging = {.mode     = mode,
                                      .anchor   = anchor,
                                      .previous = (uint8_t)(CF_LOCO_ANCHORS - 1 - anchor),
                                      .distance = ODD[i]};
        cf_loco_deck_ranging(&deck, &estimator, &ranging, anchor);
        CHECK(estimator.queue_count == 2);
        drain(&estimator);
      }
    }
  }
  cf_loco_deck_count(&deck);
  CHECK(deck.state == 255);
}

static void boot_with(cf_t *cf, cf_positioning_t positioning) {
  cf_config_t config;
  CHECK(cf_config_default(&config, CF_PLATFORM_CF2) == CF_OK);
  config.vehicle.positioning = positioning;
  config.loco_is_planar      = 1;
  config.vehicle.rangers     = (cf_rangers_config_t){.has_multiranger = true, .has_zranger = true};
  config.loco_height         = 0.5f;
  CHECK(cf_init(cf, &config) == CF_OK);
}

// Clients write what they like: a drone that lies still must go on ticking.
static void parameters_may_hold_anything(void) {
  static cf_t       cf;
  const cf_motion_t motion = {
      .position       = {0.3f, -0.2f, 0.0145f},
      .quat_wxyz      = {1.0f, 0.0f, 0.0f, 0.0f},
      .rotation       = {1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f},
      .specific_force = {0.0f, 0.0f, 9.81f},
  };
  for (int system = 0; system < CF_POSITIONING_COUNT; system++) {
    for (int i = 0; i < ODD_COUNT; i++) {
      boot_with(&cf, (cf_positioning_t)system);
      cf.onboard.decks.flow.fixed_std    = ODD[i];
      cf.onboard.decks.loco.tdoa2_std    = ODD[i];
      cf.onboard.decks.loco.tdoa3_std    = ODD[i];
      cf.onboard.decks.lighthouse.method = (uint8_t)(i * 51);
      cf.onboard.decks.loco.mode         = (uint8_t)(i % 5);
      for (int tick = 0; tick < 1700; tick++) {
        cf_tick(&cf, &motion);
      }
      cf_reboot(&cf);
      cf_tick(&cf, &motion);
    }
  }
}

int main(void) {
  every_number_of_light_is_fine();
  every_id_of_a_sweep_is_fine();
  every_register_of_the_flow_deck_is_fine();
  every_range_is_fine();
  every_ranging_is_fine();
  parameters_may_hold_anything();
  return 0;
}
