/* What goes wrong with single readings of a positioning system: some are lost, some are far off. */
#ifndef CF_VEHICLE_POSITIONING_MISHAP_H
#define CF_VEHICLE_POSITIONING_MISHAP_H

#include <stdbool.h>

#include "status.h"
#include "vehicle/random.h"

typedef struct {
  float dropout;  // [0, 1], probability that a reading is lost
  float outlier;  // [0, 1], probability that a reading is far off
  float
      outlier_size;  // >= 0, unit of the reading: outliers are off by a quarter of it to all of it
} cf_mishap_config_t;

// Returns CF_ERR_VALUE when a number is outside its range.
cf_status_t cf_mishap_check(const cf_mishap_config_t *config);

// Throws the dice for one reading. Returns true when it is lost.
bool cf_mishap_drops(const cf_mishap_config_t *config, cf_random_t *random);

// Throws the dice for one reading. Returns by how much it is off, of either sign; mostly 0.
float cf_mishap_error(const cf_mishap_config_t *config, cf_random_t *random);

#endif  // CF_VEHICLE_POSITIONING_MISHAP_H
