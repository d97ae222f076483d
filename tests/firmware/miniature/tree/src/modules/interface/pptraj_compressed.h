#pragma once

// clang-format off
#include "pptraj.h"
#include <stdio.h>
// clang-format on

enum piecewise_traj_storage_type {
  PPTRAJ_STORAGE_CONSTANT = 0,
  PPTRAJ_STORAGE_LINEAR   = 1,
  PPTRAJ_STORAGE_BEZIER   = 2,
  PPTRAJ_STORAGE_FULL     = 3,
};

// the piece that is flown
struct piecewise_traj_compressed_piece {
  const void   *data;  // null behind the end
  float         t_begin_relative;
  struct poly4d poly4d;
};

struct piecewise_traj_compressed {
  float       t_begin;
  float       duration;
  float       timescale;
  struct vec  shift;
  const void *data;

  struct piecewise_traj_compressed_piece current_piece;
};

float piecewise_compressed_duration(const struct piecewise_traj_compressed *traj);
bool  piecewise_compressed_is_finished(const struct piecewise_traj_compressed *traj, float t);
struct traj_eval piecewise_compressed_eval(struct piecewise_traj_compressed *traj, float t);
void piecewise_compressed_load(struct piecewise_traj_compressed *traj, const void *data);

// static and not inline: the compiler warns in a file that includes this and does not call it
static void piecewise_compressed_print(const struct piecewise_traj_compressed *traj) {
  printf("begins at %f, takes %f\n", (double)traj->t_begin, (double)traj->duration);
}
