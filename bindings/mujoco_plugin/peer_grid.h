/* Neighbor search: the drones that a ground station sees, sorted into square columns.
 *
 * A grid is scratch memory, computed from positions on demand; it is not part of any state.
 * The time to fill it is proportional to the number of drones. The time of a query for one drone
 * depends on its neighborhood only. Columns have a side of 1 m and unlimited height. */
#ifndef CF_MUJOCO_PLUGIN_PEER_GRID_H
#define CF_MUJOCO_PLUGIN_PEER_GRID_H

#include <stdbool.h>
#include <stdint.h>

#define CF_PEER_GRID_REACH 10  // [m], what is farther away is no neighbor

typedef struct {
  float   position[3];  // [m], world
  int32_t column[2];
  int32_t index;  // of the drone
} cf_seen_drone_t;

typedef struct {
  int capacity;
  int count;
  int bucket_bits;  // there are 2^bits buckets

  int32_t low[2];   // columns that hold a drone
  int32_t high[2];  // inclusive

  cf_seen_drone_t *added;   // [capacity], in the order of their coming
  cf_seen_drone_t *sorted;  // [capacity], by bucket
  int32_t         *starts;  // [buckets + 1], in `sorted`
} cf_peer_grid_t;

// Makes room for `capacity` > 0 drones. Returns false when there is no memory; otherwise the grid
// must be freed.
bool cf_peer_grid_new(cf_peer_grid_t *grid, int capacity);
void cf_peer_grid_free(cf_peer_grid_t *grid);

// Fills the grid: clear, add every drone once, sort. The grid leaves out positions that are not
// finite, or 10 km away.
void cf_peer_grid_clear(cf_peer_grid_t *grid);
void cf_peer_grid_add(cf_peer_grid_t *grid, int index, const float position[3]);
void cf_peer_grid_sort(cf_peer_grid_t *grid);

// Writes the drones nearest to this position, without the drone `self`, nearest first and with the
// lower index first among equals; at most `most` <= CF_PEER_GRID_MAX, all nearer than the reach.
// Returns how many. What comes out depends on the positions only.
#define CF_PEER_GRID_MAX 16
int cf_peer_grid_nearest(const cf_peer_grid_t *grid, const float position[3], int self,
                         cf_seen_drone_t *nearest, int most);

// The drones that share a bucket with a column, `column` of each says whether it is in it. Returns
// how many.
int cf_peer_grid_bucket(const cf_peer_grid_t *grid, int32_t x, int32_t y,
                        const cf_seen_drone_t **first);

#endif  // CF_MUJOCO_PLUGIN_PEER_GRID_H
