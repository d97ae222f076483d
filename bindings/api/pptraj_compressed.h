/* Compressed trajectories: Bezier control points as 16-bit integers, 3 to 59 bytes a piece. Types
 * and functions with the names of the firmware's pptraj_compressed.h.
 *
 * The bytes are a start record (x, y, z [mm], yaw [0.1 deg]: four signed 16-bit numbers,
 * little-endian), then pieces of a header (1 byte: two bits of storage type for x, y, z and yaw, x
 * lowest), a duration (unsigned 16 bits, [ms]) and the control points that are stored: all of x,
 * then y, z and yaw. The first control point of a piece is the end of the piece before. A duration
 * of 0 ends the trajectory.
 *
 * Two differences from the firmware. A load takes the number of bytes, and a piece that does not
 * end within them ends the trajectory, because no bytes can be trusted. The play-head refers to
 * pieces by their offset, so that it may be kept in a drone's state. Yaw has the meaning that
 * clients send, stored * pi / 1800 (docs/reference/planner-commander.md#5.6).
 *
 * Source: docs/reference/planner-commander.md#5. Meters, seconds, radians. */
#ifndef PPTRAJ_COMPRESSED_H
#define PPTRAJ_COMPRESSED_H

#include <stdbool.h>
#include <stdint.h>

#include "api/pptraj.h"

#define PPTRAJ_COMPRESSED_START_BYTES 8

// How one axis of a piece is stored.
enum piecewise_traj_storage_type {
  PPTRAJ_STORAGE_CONSTANT = 0,  // nothing: it stays where it is
  PPTRAJ_STORAGE_LINEAR   = 1,  // the end point
  PPTRAJ_STORAGE_BEZIER   = 2,  // three control points of a cubic
  PPTRAJ_STORAGE_FULL     = 3,  // seven control points of degree 7
};

// The play-head: the piece that is flown. Behind the end, a piece of duration 0 that stays at the
// last point.
struct piecewise_traj_compressed_piece {
  uint32_t      next_offset;  // [bytes] in the data, of the piece that follows; 0 behind the end
  float         t_begin_relative;  // [s], since the begin of the trajectory
  struct poly4d poly4d;
};

// A view of bytes that live elsewhere (in trajectory memory): made on the stack. The play-head may
// be kept and put into a later view of the same bytes.
struct piecewise_traj_compressed {
  float       t_begin;    // [s]
  float       duration;   // [s], found by the load
  float       timescale;  // ignored, as in the firmware
  struct vec  shift;      // [m]
  float       shift_yaw;  // [rad], ignored, as in the firmware
  const void *data;       // the start record; null when there are too few bytes for one
  uint32_t    size;       // [bytes] that may be read from data on

  struct piecewise_traj_compressed_piece current_piece;
};

// Makes a view of `size` bytes that begins at t = 0, with the play-head on its first piece. Does
// not touch shift_yaw.
void piecewise_compressed_load(struct piecewise_traj_compressed *traj, const void *data,
                               uint32_t size);

float piecewise_compressed_duration(const struct piecewise_traj_compressed *traj);
bool  piecewise_compressed_is_finished(const struct piecewise_traj_compressed *traj, float t);

// Moves the play-head to t and evaluates there: times are meant to grow, an earlier one costs a
// walk from the first piece. A joint belongs to the later piece. traj_eval_invalid() without a
// start record.
struct traj_eval piecewise_compressed_eval(struct piecewise_traj_compressed *traj, float t);

#endif  // PPTRAJ_COMPRESSED_H
