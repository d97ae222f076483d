/* Driver of the lighthouse deck: sweeps in, measurements for the estimator out.
 *
 * Method 1, the default, enqueues the sweep angles of a turn one by one, a sensor at a time: its
 * two planes together hold the filter on a line before the next sensor adds what little it can.
 * Plane by plane, the covariance of 100 m^2 that the filter starts from would lose its digits in
 * float32 (three planes in, 1 m^2 had become less than 1e-6 m^2), and some starts went astray.
 * Method 0 crosses the beams of both base stations and enqueues a position, the median of what the
 * sensors say. Either adds how far the heading is off, when all four sensors have seen both planes
 * of a base station (docs/reference/estimators.md#5.5, #5.11, #13.4). */
#ifndef CF_ONBOARD_DECKS_LIGHTHOUSE_DECK_H
#define CF_ONBOARD_DECKS_LIGHTHOUSE_DECK_H

#include <stdbool.h>
#include <stdint.h>

#include "deck_facts.h"
#include "onboard/decks/base_stations.h"
#include "onboard/estimator.h"
#include "variables.h"

#define CF_LIGHTHOUSE_CROSSING_BEAMS 0
#define CF_LIGHTHOUSE_RAW_SWEEPS 1

// The latest turn of the rotor of one base station.
typedef struct {
  float    angles[CF_LIGHTHOUSE_SENSORS][CF_LIGHTHOUSE_SWEEPS];  // [rad]
  uint32_t ticks[CF_LIGHTHOUSE_SWEEPS];                          // [ms], when each plane passed
  uint8_t  sensors[CF_LIGHTHOUSE_SWEEPS];                        // bit i: sensor i was hit
} cf_rotor_turn_t;

typedef struct {
  // parameters
  uint8_t method;       // CF_LIGHTHOUSE_CROSSING_BEAMS, anything else is raw sweeps
  uint8_t system_type;  // 2: base stations of the second generation
  uint8_t calib_reset;  // for clients; there is nothing to forget

  // parameters of the streams to clients; the localization service reads `turns`
  uint8_t streams_angles;    // locSrv.enLhAngleStream
  uint8_t streams_matched;   // locSrv.enLhMtchStm
  uint8_t matched_stations;  // locSrv.minBsLhMtchStm, as many base stations make a group
  uint8_t matched_time;      // [ms], locSrv.maxTimeLhMtchStm, between the turns of a group

  // log: bit i stands for base station i
  uint16_t available;               // can be used at all
  uint16_t received;                // within the last second
  uint16_t active;                  // received, with geometry and calibration
  uint16_t calibrations_valid;      // calibration data is there
  uint16_t calibrations_confirmed;  // and equals what the station tells
  uint16_t calibrations_updated;    // or was replaced by it
  uint16_t geometries_valid;        // geometry is there
  uint8_t  status;                  // 0: no light, 1: data is missing, 2: position is estimated

  // state
  uint16_t        seen;  // bit i: base station i since the last count
  cf_rotor_turn_t turns[CF_LIGHTHOUSE_STATIONS];
  uint32_t        yaw_tick;  // [ms], of the last yaw error: at most one per loop
} cf_lighthouse_deck_t;

// Writes the whole struct.
void cf_lighthouse_deck_init(cf_lighthouse_deck_t *deck);

// Takes a sweep at a tick [ms] and enqueues what follows from it.
void cf_lighthouse_deck_sweep(cf_lighthouse_deck_t *deck, cf_estimator_t *estimator,
                              const cf_sweep_t *sweep, uint32_t tick);

// Counts for the log, once per second.
void cf_lighthouse_deck_count(cf_lighthouse_deck_t *deck, const cf_base_stations_t *stations);

// Group lighthouse. Offsets count from cf_lighthouse_deck_t.
cf_variables_t cf_lighthouse_deck_parameters(void);
cf_variables_t cf_lighthouse_deck_logs(void);

#endif  // CF_ONBOARD_DECKS_LIGHTHOUSE_DECK_H
