/* What a recorder keeps of a world at an instant: one row in each of its columns, written by one
 * call. */
#ifndef CF_MUJOCO_PLUGIN_SAMPLING_H
#define CF_MUJOCO_PLUGIN_SAMPLING_H

#include <stddef.h>
#include <stdint.h>

#include "crazyflie.h"

// Drones with one provider, and the column of their log variables.
typedef struct {
  cf_t           *first;
  ptrdiff_t       stride;     // [bytes] from a drone to the next
  int32_t         count;      // drones
  int32_t         stretches;  // of the memory of each
  const uint32_t *bounds;     // first byte of each stretch, and the one behind its last
  int64_t         bytes;      // of all stretches of one drone
  uint8_t        *rows;       // count * bytes each
} cf_sampled_part_t;

// Addresses within one mjData, and the columns that are filled: first free row of each.
typedef struct {
  const double  *time;  // [s]
  const double  *qpos;
  const double  *qvel;
  const int32_t *dofs;  // address of the first of the six velocities of each drone
  int32_t        nq;
  int32_t        drones;

  const cf_sampled_part_t *parts;
  int32_t                  part_count;

  double  *times;        // [s]
  int64_t *requests;     // in the journal
  double  *qpos_rows;    // nq each
  double  *motion_rows;  // 6 for each drone
} cf_sampler_t;

// Writes row number `row` of all columns. Threads share the drones of parts whose provider computes
// no log variables for readers.
void cf_sample(const cf_sampler_t *sampler, int64_t row, int64_t requests);

#endif  // CF_MUJOCO_PLUGIN_SAMPLING_H
