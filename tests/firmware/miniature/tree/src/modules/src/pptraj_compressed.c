#include "pptraj_compressed.h"

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "math3d.h"

static const int POINTS[] = {0, 1, 3, 7};

static float coordinate(const uint8_t *bytes, int axis) {
  int16_t stored;
  memcpy(&stored, bytes, sizeof stored);
  return axis < 3 ? stored / 1000.0f : stored * (M_PI_F / 1800.0f);
}

static uint16_t milliseconds(const uint8_t *piece) {
  uint16_t ms;
  memcpy(&ms, piece + 1, sizeof ms);
  return ms;
}

// null at the mark that ends the trajectory, and there is no other end
static const uint8_t *unless_end(const uint8_t *piece) {
  return milliseconds(piece) == 0 ? NULL : piece;
}

static const uint8_t *next(const uint8_t *piece) {
  const uint8_t *after = piece + 3;
  for (int axis = 0; axis < 4; axis++) {
    after += 2 * POINTS[piece[0] >> (2 * axis) & 3];
  }
  return unless_end(after);
}

static void build(struct piecewise_traj_compressed_piece *current, const float start[4]) {
  const uint8_t *piece = current->data;
  const uint8_t *body  = piece + 3;
  current->poly4d      = poly4d_zero(piece ? milliseconds(piece) / 1000.0 : 0);
  for (int axis = 0; axis < 4; axis++) {
    const int count     = piece ? POINTS[piece[0] >> (2 * axis) & 3] : 0;
    float     points[8] = {start[axis]};
    for (int i = 1; i <= count; i++, body += 2) {
      points[i] = coordinate(body, axis);
    }
    polybezier(current->poly4d.p[axis], current->poly4d.duration, points, 1 + count);
  }
}

static void rewind_to_start(struct piecewise_traj_compressed *traj) {
  const uint8_t *bytes = traj->data;
  float          start[4];
  for (int axis = 0; axis < 4; axis++) {
    start[axis] = coordinate(bytes + 2 * axis, axis);
  }
  traj->current_piece.data             = unless_end(bytes + 8);
  traj->current_piece.t_begin_relative = 0;
  build(&traj->current_piece, start);
}

static void advance(struct piecewise_traj_compressed *traj) {
  struct piecewise_traj_compressed_piece *current = &traj->current_piece;
  float                                   end[4];
  for (int axis = 0; axis < 4; axis++) {
    end[axis] = polyval(current->poly4d.p[axis], current->poly4d.duration);
  }
  current->t_begin_relative += current->poly4d.duration;
  current->data = next(current->data);
  build(current, end);
}

void piecewise_compressed_load(struct piecewise_traj_compressed *traj, const void *data) {
  traj->t_begin   = 0;
  traj->timescale = 1;
  traj->shift     = vzero();
  traj->data      = data;
  rewind_to_start(traj);

  uint32_t total = 0;
  for (const uint8_t *piece = traj->current_piece.data; piece != NULL; piece = next(piece)) {
    total += milliseconds(piece);
  }
  traj->duration = total / 1000.0;
}

float piecewise_compressed_duration(const struct piecewise_traj_compressed *traj) {
  return traj->duration;
}

bool piecewise_compressed_is_finished(const struct piecewise_traj_compressed *traj, float t) {
  return (t - traj->t_begin) >= traj->duration;
}

struct traj_eval piecewise_compressed_eval(struct piecewise_traj_compressed *traj, float t) {
  struct piecewise_traj_compressed_piece *current = &traj->current_piece;
  if (t < traj->t_begin + current->t_begin_relative) {
    rewind_to_start(traj);
  }
  while (current->data != NULL &&
         t >= (traj->t_begin + current->t_begin_relative) + current->poly4d.duration) {
    advance(traj);
  }
  struct traj_eval ev =
      poly4d_eval(&current->poly4d, t - (traj->t_begin + current->t_begin_relative));
  ev.pos = vadd(ev.pos, traj->shift);
  return ev;
}
