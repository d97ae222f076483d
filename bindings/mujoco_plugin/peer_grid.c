#include "mujoco_plugin/peer_grid.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define FARTHEST 1e4f  // [m], beyond it a drone has run wild

// A search for the neighbors of one position.
typedef struct {
  const cf_peer_grid_t *grid;
  const float          *position;
  int                   self;
  int                   most;

  int              count;
  cf_seen_drone_t *nearest;
  float            squares[CF_PEER_GRID_MAX];  // [m^2], distances of `nearest`
} search_t;

bool cf_peer_grid_new(cf_peer_grid_t *grid, int capacity) {
  *grid = (cf_peer_grid_t){.capacity = capacity, .bucket_bits = 1};
  while ((1 << grid->bucket_bits) < 2 * capacity) {
    grid->bucket_bits++;
  }
  const size_t buckets = (size_t)1 << grid->bucket_bits;
  grid->added          = calloc((size_t)capacity, sizeof *grid->added);
  grid->sorted         = calloc((size_t)capacity, sizeof *grid->sorted);
  grid->starts         = calloc(buckets + 1, sizeof *grid->starts);
  // no test runs out of memory
  if (grid->added == NULL || grid->sorted == NULL || grid->starts == NULL) {
    cf_peer_grid_free(grid);
    return false;
  }
  return true;
}

void cf_peer_grid_free(cf_peer_grid_t *grid) {
  free(grid->added);
  free(grid->sorted);
  free(grid->starts);
  *grid = (cf_peer_grid_t){.capacity = 0};
}

// --------------------------------------------------------------------------------------- filling

static bool is_seen(const float position[3]) {
  // negated by every NaN
  return fabsf(position[0]) < FARTHEST && fabsf(position[1]) < FARTHEST &&
         fabsf(position[2]) < FARTHEST;
}

// The side of 1 m makes this exact.
static int32_t column_of(float coordinate) {
  return (int32_t)floorf(coordinate);
}

// The high bits of these products are well mixed.
static uint32_t bucket_of(const cf_peer_grid_t *grid, int32_t x, int32_t y) {
  const uint32_t mixed = (uint32_t)x * 0x9e3779b1u + (uint32_t)y * 0x85ebca77u;
  return mixed >> (32 - grid->bucket_bits);
}

static int32_t min_of(int32_t a, int32_t b) {
  return a < b ? a : b;
}

static int32_t max_of(int32_t a, int32_t b) {
  return a > b ? a : b;
}

void cf_peer_grid_clear(cf_peer_grid_t *grid) {
  grid->count = 0;
  for (int k = 0; k < 2; k++) {
    grid->low[k]  = INT32_MAX;
    grid->high[k] = INT32_MIN;
  }
}

void cf_peer_grid_add(cf_peer_grid_t *grid, int index, const float position[3]) {
  if (grid->count == grid->capacity || !is_seen(position)) {
    return;
  }
  cf_seen_drone_t *drone = &grid->added[grid->count++];
  memcpy(drone->position, position, sizeof drone->position);
  drone->index = index;
  for (int k = 0; k < 2; k++) {
    drone->column[k] = column_of(position[k]);
    grid->low[k]     = min_of(grid->low[k], drone->column[k]);
    grid->high[k]    = max_of(grid->high[k], drone->column[k]);
  }
}

void cf_peer_grid_sort(cf_peer_grid_t *grid) {
  // count, sum up, and put each drone before the end of its bucket
  const size_t buckets = (size_t)1 << grid->bucket_bits;
  memset(grid->starts, 0, (buckets + 1) * sizeof *grid->starts);
  for (int i = 0; i < grid->count; i++) {
    const cf_seen_drone_t *drone = &grid->added[i];
    grid->starts[bucket_of(grid, drone->column[0], drone->column[1])]++;
  }
  int32_t sum = 0;
  for (size_t b = 0; b <= buckets; b++) {
    sum += grid->starts[b];
    grid->starts[b] = sum;
  }
  for (int i = grid->count - 1; i >= 0; i--) {
    const cf_seen_drone_t *drone    = &grid->added[i];
    const uint32_t         b        = bucket_of(grid, drone->column[0], drone->column[1]);
    grid->sorted[--grid->starts[b]] = *drone;
  }
}

// ---------------------------------------------------------------------------------------- asking

static float square_distance(const float a[3], const float b[3]) {
  const float x = a[0] - b[0];
  const float y = a[1] - b[1];
  const float z = a[2] - b[2];
  return x * x + y * y + z * z;
}

// Puts a drone in its place among the nearest so far, or nowhere.
static void consider(search_t *search, const cf_seen_drone_t *drone) {
  const float square = square_distance(search->position, drone->position);
  if (drone->index == search->self ||
      !(square < (float)(CF_PEER_GRID_REACH * CF_PEER_GRID_REACH))) {
    return;
  }
  int place = search->count;
  while (place > 0 && (square < search->squares[place - 1] ||
                       (square == search->squares[place - 1] &&
                        drone->index < search->nearest[place - 1].index))) {
    place--;
  }
  if (place == search->most) {
    return;
  }
  const int last = search->count < search->most ? search->count++ : search->most - 1;
  for (int i = last; i > place; i--) {
    search->squares[i] = search->squares[i - 1];
    search->nearest[i] = search->nearest[i - 1];
  }
  search->squares[place] = square;
  search->nearest[place] = *drone;
}

static void look_into(search_t *search, int32_t x, int32_t y) {
  const cf_peer_grid_t *grid = search->grid;
  const uint32_t        b    = bucket_of(grid, x, y);
  for (int32_t i = grid->starts[b]; i < grid->starts[b + 1]; i++) {
    const cf_seen_drone_t *drone = &grid->sorted[i];
    if (drone->column[0] == x && drone->column[1] == y) {
      consider(search, drone);
    }
  }
}

// Searches the columns with drones at distance `ring` from the middle.
static void look_around(search_t *search, const int32_t middle[2], int32_t ring) {
  const cf_peer_grid_t *grid = search->grid;

  const int32_t left   = middle[0] - ring;
  const int32_t right  = middle[0] + ring;
  const int32_t bottom = max_of(middle[1] - ring, grid->low[1]);
  const int32_t top    = min_of(middle[1] + ring, grid->high[1]);
  for (int32_t y = bottom; y <= top; y++) {
    if (y == middle[1] - ring || y == middle[1] + ring) {
      for (int32_t x = max_of(left, grid->low[0]); x <= min_of(right, grid->high[0]); x++) {
        look_into(search, x, y);
      }
    } else {
      if (left >= grid->low[0]) {
        look_into(search, left, y);
      }
      if (right <= grid->high[0]) {
        look_into(search, right, y);
      }
    }
  }
}

static bool is_all_searched(const search_t *search, const int32_t middle[2], int32_t ring) {
  const cf_peer_grid_t *grid = search->grid;
  // a drone outside of the ring has a distance >= `ring`, in float32 too: rounding is monotonic
  const bool is_full = search->count == search->most;
  if (is_full && search->squares[search->most - 1] < (float)(ring * ring)) {
    return true;
  }
  return middle[0] - ring <= grid->low[0] && middle[0] + ring >= grid->high[0] &&
         middle[1] - ring <= grid->low[1] && middle[1] + ring >= grid->high[1];
}

int cf_peer_grid_nearest(const cf_peer_grid_t *grid, const float position[3], int self,
                         cf_seen_drone_t *nearest, int most) {
  if (!is_seen(position) || grid->count == 0 || most < 1) {
    return 0;
  }
  search_t search = {.grid     = grid,
                     .position = position,
                     .self     = self,
                     .most     = min_of(most, CF_PEER_GRID_MAX),
                     .nearest  = nearest};

  const int32_t middle[2] = {column_of(position[0]), column_of(position[1])};
  for (int32_t ring = 0; ring <= CF_PEER_GRID_REACH; ring++) {
    look_around(&search, middle, ring);
    if (is_all_searched(&search, middle, ring)) {
      break;
    }
  }
  return search.count;
}

int cf_peer_grid_bucket(const cf_peer_grid_t *grid, int32_t x, int32_t y,
                        const cf_seen_drone_t **first) {
  const uint32_t b = bucket_of(grid, x, y);
  *first           = grid->sorted + grid->starts[b];
  return grid->starts[b + 1] - grid->starts[b];
}
