#include "position_sensing.h"

#include <string.h>

#define COUNT_INTERVAL 1000u  // [ms]

// ------------------------------------------------------------------------------------------ boot

// What the client of a real drone uploads: geometry as it was estimated, calibration as it was
// received. The simulated base stations are ideal but for errors that the client does not know.
static void describe_stations(const cf_lighthouse_config_t *config, cf_base_stations_t *stations) {
  for (uint32_t i = 0; i < CF_LIGHTHOUSE_STATIONS; i++) {
    const cf_station_pose_t *pose    = &config->stations[i];
    cf_station_data_t       *station = &stations->list[i];
    memcpy(station->origin, pose->position, sizeof station->origin);
    cf_lighthouse_look_at(pose->position, pose->target, station->rotation);
    station->has_geometry = true;
    station->calibration  = (lighthouseCalibration_t){.uid = i + 1, .valid = true};
  }
}

// The client that forwards poses sets both on connecting, as radio handlers do on the vehicle.
static void tell_deviations(const cf_mocap_config_t *config, cf_onboard_t *onboard) {
  onboard->ext_pos_std_dev  = config->position_std;
  onboard->ext_quat_std_dev = config->attitude_std;
}

void cf_position_boot(cf_t *cf) {
  const cf_vehicle_config_t *config = &cf->config.vehicle;
  cf_decks_t                *decks  = &cf->onboard.decks;
  if (config->positioning == CF_POSITIONING_MOCAP ||
      config->positioning == CF_POSITIONING_MOCAP_POSITION) {
    tell_deviations(&config->mocap, &cf->onboard);
  }
  cf_decks_init(decks, config->positioning, config->rangers.has_zranger,
                config->rangers.has_multiranger);
  if (decks->flags.lighthouse4) {
    describe_stations(&config->lighthouse, &cf->onboard.estimator.stations);
  }
  if (decks->flags.loco) {
    memcpy(decks->loco.anchors, config->loco.anchors, sizeof decks->loco.anchors);
    decks->loco.is_planar = cf->config.loco_is_planar != 0;
    decks->loco.height    = cf->config.loco_height;
    if (decks->loco.is_planar) {
      cf_provider(cf->config.provider)->kalman_disable_attitude_reversion(cf->provider_state);
    }
  }
}

// --------------------------------------------------------------------------------------- sensing

static void sense_mocap(cf_t *cf, const cf_motion_t *motion) {
  poseMeasurement_t pose;
  if (!cf_vehicle_mocap(&cf->vehicle, motion->position, motion->quat_wxyz, &pose)) {
    return;
  }
  if (cf->config.vehicle.positioning == CF_POSITIONING_MOCAP) {
    cf_onboard_external_pose(&cf->onboard, &pose);
  } else {
    cf_onboard_external_position(&cf->onboard, pose.x, pose.y, pose.z);
  }
}

static void sense_flow(cf_t *cf, const cf_motion_t *motion) {
  cf_flow_deck_t *deck = &cf->vehicle.flow_deck;
  if (motion->surroundings != NULL && cf_flow_deck_will_look_down(deck)) {
    cf_flow_deck_look_down(deck, motion->position, motion->rotation, motion->surroundings);
  }
  const float       height  = motion->position[2] - deck->surface;
  cf_decks_t       *decks   = &cf->onboard.decks;
  cf_flow_reading_t reading = {0};
  const int what = cf_vehicle_flow_deck(&cf->vehicle, height, motion->rotation, motion->velocity,
                                        motion->rates, &reading);
  if (what & CF_FLOW_DECK_RANGE) {
    cf_ranger_driver_read(&decks->ranger, &cf->onboard.estimator, CF_RANGE_DOWN, reading.range,
                          cf->onboard.tick);
  }
  if (what & CF_FLOW_DECK_FLOW) {
    cf_flow_driver_read(&decks->flow, &cf->onboard.estimator, &reading, cf->onboard.tick);
  }
}

static void sense_ranges(cf_t *cf, const cf_motion_t *motion) {
  uint16_t  readings[CF_RANGE_COUNT];
  const int measured = cf_rangers_step(&cf->vehicle.rangers, motion->position, motion->rotation,
                                       motion->surroundings, readings);
  for (int direction = 0; measured >> direction != 0; direction++) {
    if (measured >> direction & 1) {
      cf_ranger_driver_read(&cf->onboard.decks.ranger, &cf->onboard.estimator, direction,
                            readings[direction], cf->onboard.tick);
    }
  }
}

static void sense_lighthouse(cf_t *cf, const cf_motion_t *motion) {
  cf_sweep_t sweeps[CF_LIGHTHOUSE_STATIONS];
  const int count = cf_vehicle_lighthouse(&cf->vehicle, motion->position, motion->rotation, sweeps);
  for (int i = 0; i < count; i++) {
    cf_lighthouse_deck_sweep(&cf->onboard.decks.lighthouse, &cf->onboard.estimator, &sweeps[i],
                             cf->onboard.tick);
  }
}

static void sense_loco(cf_t *cf, const cf_motion_t *motion) {
  cf_ranging_t ranging;
  if (cf_vehicle_loco(&cf->vehicle, motion->position, &ranging)) {
    cf_loco_deck_ranging(&cf->onboard.decks.loco, &cf->onboard.estimator, &ranging,
                         cf->onboard.tick);
  }
}

static void count(cf_t *cf) {
  if (cf->onboard.tick % COUNT_INTERVAL == 0) {
    cf_decks_count(&cf->onboard.decks, &cf->onboard.estimator.stations);
  }
}

void cf_position_sense(cf_t *cf, const cf_motion_t *motion) {
  const cf_rangers_config_t *rangers = &cf->vehicle.rangers.fitted;
  if (rangers->has_multiranger || rangers->has_zranger) {
    sense_ranges(cf, motion);
  }
  switch (cf->config.vehicle.positioning) {
    case CF_POSITIONING_MOCAP:
    case CF_POSITIONING_MOCAP_POSITION:
      sense_mocap(cf, motion);
      break;
    case CF_POSITIONING_FLOW:
      sense_flow(cf, motion);
      break;
    case CF_POSITIONING_LIGHTHOUSE:
      sense_lighthouse(cf, motion);
      count(cf);
      break;
    case CF_POSITIONING_LOCO_TWR:
    case CF_POSITIONING_LOCO_TDOA2:
    case CF_POSITIONING_LOCO_TDOA3:
      sense_loco(cf, motion);
      count(cf);
      break;
    default:
      // without a position nothing can be flown, but the inertial sensors go on
      break;
  }
}
