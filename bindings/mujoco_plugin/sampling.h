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

// How far cf_fly_and_sample came.
typedef struct {
  int32_t samples;   // taken
  int32_t flown;     // of the window behind them, which is not whole: as cf_plugin_window returned
  double  sampling;  // [s] of wall time that the samples took
} cf_sampled_t;

// Writes row number `row` of all columns. Threads share the drones of parts whose provider computes
// no log variables for readers.
void cf_sample(const cf_sampler_t *sampler, int64_t row, int64_t requests);

// Flies windows of so many steps (cf_plugin_window) and takes a sample after each, from row number
// `row` on, at most `count` times. It returns earlier behind a sample at which a contact has begun
// or a drone is out, and where a window is not whole: `flown` differs from `steps` then, and the
// rest of that window is to be made by MuJoCo. Takes the addresses of mjModel and mjData.
cf_sampled_t cf_fly_and_sample(uintptr_t model, uintptr_t data, int steps, int count,
                               const cf_sampler_t *sampler, int64_t row, int64_t requests);

#endif  // CF_MUJOCO_PLUGIN_SAMPLING_H
