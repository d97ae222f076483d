/* The complementary estimator: attitude at 250 Hz, height at 100 Hz
 * (docs/reference/estimators.md#10.1). It knows no horizontal position. */
#ifndef CF_BUILTIN_COMPLEMENTARY_COMPLEMENTARY_H
#define CF_BUILTIN_COMPLEMENTARY_COMPLEMENTARY_H

#include <stdint.h>

#include "api/sensfusion6.h"
#include "api/stabilizer_types.h"
#include "builtin/complementary/position_estimator_altitude.h"
#include "provider.h"
#include "variables.h"

typedef struct {
  cf_sensfusion6_t attitude;
  cf_altitude_t    altitude;
} cf_complementary_t;

// Writes the whole struct: the state after boot, with the filter of the attitude.
void cf_complementary_boot(cf_complementary_t *complementary, cf_sensfusion6_filter_t filter);

// What selecting the estimator does. Attitude and height go on from where they are.
void cf_complementary_init(cf_complementary_t *complementary);

// One step of the stabilizer loop. Writes attitude, vertical acceleration, position and vertical
// velocity of the estimate at their rates; the rest of it stays as it is.
void cf_complementary_update(cf_complementary_t *complementary, const cf_latest_samples_t *latest,
                             state_t *estimate, stabilizerStep_t step, uint32_t now_ms);

// Group sensfusion6. Offsets count from cf_sensfusion6_t.
cf_variables_t cf_sensfusion6_parameters(void);
cf_variables_t cf_sensfusion6_logs(void);

#endif  // CF_BUILTIN_COMPLEMENTARY_COMPLEMENTARY_H
