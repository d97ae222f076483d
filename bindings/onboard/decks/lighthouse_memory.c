#include "onboard/decks/lighthouse_memory.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "little_endian.h"

#define CALIBRATION_START 0x1000u
#define PAGE 0x100u
#define GEOMETRY_FLOATS 12
#define GEOMETRY_BYTES (GEOMETRY_FLOATS * 4 + 1)
#define SWEEP_FLOATS 7
#define CALIBRATION_FLOATS (CF_LIGHTHOUSE_SWEEPS * SWEEP_FLOATS)
#define CALIBRATION_BYTES (CALIBRATION_FLOATS * 4 + 4 + 1)

_Static_assert(sizeof(lighthouseCalibrationSweep_t) == SWEEP_FLOATS * sizeof(float),
               "a sweep is its numbers in the order of the memory");

// Where some bytes are.
typedef struct {
  bool     is_calibration;
  uint32_t station;
  uint32_t offset;  // within the page
} place_t;

static bool find(uint32_t address, uint32_t length, place_t *place) {
  place->is_calibration   = address >= CALIBRATION_START;
  const uint32_t relative = place->is_calibration ? address - CALIBRATION_START : address;
  const uint32_t bytes    = place->is_calibration ? CALIBRATION_BYTES : GEOMETRY_BYTES;
  place->station          = relative / PAGE;
  place->offset           = relative % PAGE;
  return place->station < CF_LIGHTHOUSE_STATIONS && length <= bytes &&
         place->offset <= bytes - length;
}

static void put_floats(uint8_t *bytes, const float *numbers, int count) {
  for (int i = 0; i < count; i++) {
    cf_put_le_float(bytes + 4 * i, numbers[i]);
  }
}

static bool take_floats(const uint8_t *bytes, float *numbers, int count) {
  float sum = 0.0f;
  for (int i = 0; i < count; i++) {
    numbers[i] = cf_le_float(bytes + 4 * i);
    sum += 0.0f * numbers[i];
  }
  return sum == 0.0f;  // not a number, if one of them is not finite
}

static void pack(const cf_station_data_t *station, bool is_calibration, uint8_t *page) {
  if (is_calibration) {
    const lighthouseCalibration_t *calibration = &station->calibration;
    float                          numbers[CALIBRATION_FLOATS];
    memcpy(numbers, calibration->sweep, sizeof numbers);
    put_floats(page, numbers, CALIBRATION_FLOATS);
    cf_put_le_u32(page + 4 * CALIBRATION_FLOATS, calibration->uid);
    page[CALIBRATION_BYTES - 1] = calibration->valid;
  } else {
    float numbers[GEOMETRY_FLOATS];
    memcpy(numbers, station->origin, sizeof station->origin);
    memcpy(numbers + 3, station->rotation, sizeof station->rotation);
    put_floats(page, numbers, GEOMETRY_FLOATS);
    page[GEOMETRY_BYTES - 1] = station->has_geometry;
  }
}

static bool unpack(cf_station_data_t *station, bool is_calibration, const uint8_t *page) {
  float numbers[CALIBRATION_FLOATS];
  if (!take_floats(page, numbers, is_calibration ? CALIBRATION_FLOATS : GEOMETRY_FLOATS)) {
    return false;
  }
  if (is_calibration) {
    lighthouseCalibration_t *calibration = &station->calibration;
    memcpy(calibration->sweep, numbers, sizeof calibration->sweep);
    calibration->uid   = cf_le_u32(page + 4 * CALIBRATION_FLOATS);
    calibration->valid = page[CALIBRATION_BYTES - 1] != 0;
  } else {
    memcpy(station->origin, numbers, sizeof station->origin);
    memcpy(station->rotation, numbers + 3, sizeof station->rotation);
    station->has_geometry = page[GEOMETRY_BYTES - 1] != 0;
  }
  return true;
}

cf_status_t cf_lighthouse_memory_read(const cf_base_stations_t *stations, uint32_t address,
                                      uint32_t length, uint8_t *data) {
  place_t place;
  if (!find(address, length, &place)) {
    return CF_ERR_CAPACITY;
  }
  uint8_t page[CALIBRATION_BYTES];
  pack(&stations->list[place.station], place.is_calibration, page);
  memcpy(data, page + place.offset, length);
  return CF_OK;
}

cf_status_t cf_lighthouse_memory_write(cf_base_stations_t *stations, uint32_t address,
                                       uint32_t length, const uint8_t *data) {
  place_t place;
  if (!find(address, length, &place)) {
    return CF_ERR_CAPACITY;
  }
  cf_station_data_t *station = &stations->list[place.station];
  uint8_t            page[CALIBRATION_BYTES];
  pack(station, place.is_calibration, page);
  memcpy(page + place.offset, data, length);
  return unpack(station, place.is_calibration, page) ? CF_OK : CF_ERR_VALUE;
}
