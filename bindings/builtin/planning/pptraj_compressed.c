/* Compressed trajectories (docs/reference/planner-commander.md#5). Whatever the bytes are: all that
 * is read lies within them, every step of the play-head consumes at least a header, and 16-bit
 * integers are finite. */
#include "api/pptraj_compressed.h"

#include <stddef.h>

#include "api/math3d.h"
#include "little_endian.h"

#define AXES 4
#define MAX_POINTS 7  // stored for one axis of a piece

#define START_BYTES PPTRAJ_COMPRESSED_START_BYTES  // four coordinates
#define HEADER_BYTES 3                             // storage types, duration

// ---------------------------------------------------------------------------------------- bytes

// x, y, z in [m], yaw in [rad]
static float read_coordinate(const uint8_t *bytes, int axis) {
  const float stored = (float)(int16_t)cf_le_u16(bytes);
  return axis < 3 ? stored / 1000.0f : stored * (M_PI_F / 1800.0f);
}

// the firmware divides by a constant in double
static float seconds(uint32_t milliseconds) {
  return (float)((double)milliseconds / 1000.0);
}

static int stored_points(uint8_t types, int axis) {
  static const int POINTS[] = {
      [PPTRAJ_STORAGE_CONSTANT] = 0,
      [PPTRAJ_STORAGE_LINEAR]   = 1,
      [PPTRAJ_STORAGE_BEZIER]   = 3,
      [PPTRAJ_STORAGE_FULL]     = MAX_POINTS,
  };
  return POINTS[(types >> (2 * axis)) & 3];
}

// A piece as it lies in the data.
typedef struct {
  uint8_t        types;
  uint16_t       duration;  // [ms]
  const uint8_t *points;
  uint32_t       next_offset;  // [bytes] in the data
} stored_piece_t;

// Finds the piece at an offset in the data. Returns false at the end of the trajectory: at a
// duration of 0, and at a piece that does not lie within the data.
static bool find_piece(const struct piecewise_traj_compressed *traj, uint32_t offset,
                       stored_piece_t *piece) {
  if (traj->size < HEADER_BYTES || offset > traj->size - HEADER_BYTES) {
    return false;
  }

  const uint8_t *bytes = (const uint8_t *)traj->data + offset;
  int            count = 0;
  for (int axis = 0; axis < AXES; axis++) {
    count += stored_points(bytes[0], axis);
  }
  const uint32_t length = HEADER_BYTES + 2 * (uint32_t)count;

  *piece = (stored_piece_t){
      .types       = bytes[0],
      .duration    = cf_le_u16(&bytes[1]),
      .points      = &bytes[HEADER_BYTES],
      .next_offset = offset + length,
  };
  return piece->duration != 0 && length <= traj->size - offset;
}

// ------------------------------------------------------------------------------------ play-head

// Puts the play-head on the piece at an offset, which starts at the given coordinates; behind the
// end it stays there.
static void build(struct piecewise_traj_compressed *traj, uint32_t offset,
                  const float start[AXES]) {
  struct piecewise_traj_compressed_piece *current = &traj->current_piece;
  current->poly4d                                 = poly4d_zero(0.0f);

  stored_piece_t piece  = {0};
  const bool     exists = find_piece(traj, offset, &piece);
  current->next_offset  = exists ? piece.next_offset : 0;
  if (exists) {
    current->poly4d.duration = seconds(piece.duration);
  }

  for (int axis = 0; axis < AXES; axis++) {
    const int count                  = exists ? stored_points(piece.types, axis) : 0;
    float     points[1 + MAX_POINTS] = {start[axis]};
    for (int i = 1; i <= count; i++) {
      points[i] = read_coordinate(piece.points, axis);
      piece.points += 2;
    }
    polybezier(current->poly4d.p[axis], current->poly4d.duration, points, 1 + count);
  }
}

static void rewind_to_start(struct piecewise_traj_compressed *traj) {
  float start[AXES];
  for (int axis = 0; axis < AXES; axis++) {
    start[axis] = read_coordinate((const uint8_t *)traj->data + 2 * axis, axis);
  }
  traj->current_piece.t_begin_relative = 0.0f;
  build(traj, START_BYTES, start);
}

// The next piece starts where the polynomial ends, which is not exactly the stored point.
static void advance(struct piecewise_traj_compressed *traj) {
  const struct poly4d *piece = &traj->current_piece.poly4d;
  float                end[AXES];
  for (int axis = 0; axis < AXES; axis++) {
    end[axis] = polyval(piece->p[axis], piece->duration);
  }
  traj->current_piece.t_begin_relative += piece->duration;
  build(traj, traj->current_piece.next_offset, end);
}

// ----------------------------------------------------------------------------------- trajectories

void piecewise_compressed_load(struct piecewise_traj_compressed *traj, const void *data,
                               uint32_t size) {
  traj->t_begin   = 0.0f;
  traj->duration  = 0.0f;
  traj->timescale = 1.0f;
  traj->shift     = vzero();
  traj->data      = size >= START_BYTES ? data : NULL;
  traj->size      = size;
  if (traj->data == NULL) {
    traj->current_piece = (struct piecewise_traj_compressed_piece){.next_offset = 0};
    return;
  }
  rewind_to_start(traj);

  uint32_t       milliseconds = 0;
  stored_piece_t piece        = {.next_offset = START_BYTES};
  while (find_piece(traj, piece.next_offset, &piece)) {
    milliseconds += piece.duration;
  }
  traj->duration = seconds(milliseconds);
}

float piecewise_compressed_duration(const struct piecewise_traj_compressed *traj) {
  return traj->duration;
}

bool piecewise_compressed_is_finished(const struct piecewise_traj_compressed *traj, float t) {
  return (t - traj->t_begin) >= traj->duration;
}

struct traj_eval piecewise_compressed_eval(struct piecewise_traj_compressed *traj, float t) {
  if (traj->data == NULL) {
    return traj_eval_invalid();
  }

  const struct piecewise_traj_compressed_piece *current = &traj->current_piece;
  if (t < traj->t_begin + current->t_begin_relative) {
    rewind_to_start(traj);
  }
  while (current->next_offset != 0 &&
         t >= (traj->t_begin + current->t_begin_relative) + current->poly4d.duration) {
    advance(traj);
  }

  struct traj_eval ev =
      poly4d_eval(&current->poly4d, t - (traj->t_begin + current->t_begin_relative));
  ev.pos = vadd(ev.pos, traj->shift);
  return ev;
}
