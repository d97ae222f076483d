/* The complementary estimator of the builtin provider, for checkouts whose own does not compile on
 * a host. No type of a checkout. */
#ifndef CF_BITCRAZE_OWN_COMPLEMENTARY_H
#define CF_BITCRAZE_OWN_COMPLEMENTARY_H

#include <stdint.h>

// by its place: a checkout may have a header of the same name
#include "../../variables.h"

typedef struct {
  float    gyro[3];       // [deg/s]
  float    acc[3];        // [g]
  float    asl;           // [m]
  uint32_t tof_ms;        // of the latest range
  float    tof_distance;  // [m]
} cf_own_samples_t;

typedef struct {
  float rpy[3];         // [deg], legacy pitch
  float quaternion[4];  // x, y, z, w
  float acc_z;          // [g]
  float position[3];    // [m]
  float velocity_z;     // [m/s]
} cf_own_estimate_t;

void cf_own_complementary_boot(void);
void cf_own_complementary_init(void);
void cf_own_complementary_run(const cf_own_samples_t *latest, cf_own_estimate_t *estimate,
                              uint32_t step, uint32_t now_ms);

// Groups sensfusion6 and posEstAlt, over a block. Returns how many tables there are.
int cf_own_complementary_parameters(cf_variables_t tables[2]);
int cf_own_complementary_logs(cf_variables_t tables[2]);

#endif  // CF_BITCRAZE_OWN_COMPLEMENTARY_H
