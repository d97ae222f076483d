/* The firmware's plain vector (math3d.h). */
#ifndef VEC_H
#define VEC_H

struct vec {
  float x;
  float y;
  float z;
};

#endif  // VEC_H
