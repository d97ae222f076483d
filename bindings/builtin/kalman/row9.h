/* Rows of nine floats, in registers of four. Internal to C.
 *
 * The filter spends its time in 9 x 9 matrices. Compilers do not vectorize loops over nine, so a
 * row is three vectors of four, written with the vector extension that gcc and clang share. Every
 * function is element by element and rounds as the plain loop would. */
#ifndef CF_BUILTIN_KALMAN_ROW9_H
#define CF_BUILTIN_KALMAN_ROW9_H

#include <stdint.h>
#include <string.h>

typedef float   cf_float4_t __attribute__((vector_size(16)));
typedef int32_t cf_int4_t __attribute__((vector_size(16)));

typedef struct {
  cf_float4_t a;  // elements 0 to 3
  cf_float4_t b;  // elements 4 to 7
  cf_float4_t c;  // element 8, and three that do not matter
} cf_row9_t;

// takes elements of x (0 to 3) and y (4 to 7)
#ifdef __clang__
#define CF_SHUFFLE4(x, y, i, j, k, l) __builtin_shufflevector(x, y, i, j, k, l)
#else
#define CF_SHUFFLE4(x, y, i, j, k, l) __builtin_shuffle(x, y, (cf_int4_t){i, j, k, l})
#endif

static inline cf_float4_t cf_all4(float x) {
  return (cf_float4_t){x, x, x, x};
}

// Element by element: x where the mask is set, else y.
static inline cf_float4_t cf_select4(cf_int4_t mask, cf_float4_t x, cf_float4_t y) {
  return (cf_float4_t)((mask & (cf_int4_t)x) | (~mask & (cf_int4_t)y));
}

static inline void cf_transpose4(cf_float4_t out[4], const cf_float4_t in[4]) {
  const cf_float4_t low01  = CF_SHUFFLE4(in[0], in[1], 0, 4, 1, 5);
  const cf_float4_t high01 = CF_SHUFFLE4(in[0], in[1], 2, 6, 3, 7);
  const cf_float4_t low23  = CF_SHUFFLE4(in[2], in[3], 0, 4, 1, 5);
  const cf_float4_t high23 = CF_SHUFFLE4(in[2], in[3], 2, 6, 3, 7);

  out[0] = CF_SHUFFLE4(low01, low23, 0, 1, 4, 5);
  out[1] = CF_SHUFFLE4(low01, low23, 2, 3, 6, 7);
  out[2] = CF_SHUFFLE4(high01, high23, 0, 1, 4, 5);
  out[3] = CF_SHUFFLE4(high01, high23, 2, 3, 6, 7);
}

static inline cf_row9_t cf_row9_zero(void) {
  return (cf_row9_t){cf_all4(0.0f), cf_all4(0.0f), cf_all4(0.0f)};
}

static inline cf_row9_t cf_row9_load(const float x[9]) {
  cf_row9_t row;
  memcpy(&row.a, x, sizeof(row.a));
  memcpy(&row.b, x + 4, sizeof(row.b));
  row.c = (cf_float4_t){x[8], 0.0f, 0.0f, 0.0f};
  return row;
}

static inline void cf_row9_store(float x[9], cf_row9_t row) {
  memcpy(x, &row.a, sizeof(row.a));
  memcpy(x + 4, &row.b, sizeof(row.b));
  x[8] = row.c[0];
}

static inline cf_row9_t cf_row9_plus(cf_row9_t x, cf_row9_t y) {
  return (cf_row9_t){x.a + y.a, x.b + y.b, x.c + y.c};
}

static inline cf_row9_t cf_row9_minus(cf_row9_t x, cf_row9_t y) {
  return (cf_row9_t){x.a - y.a, x.b - y.b, x.c - y.c};
}

static inline cf_row9_t cf_row9_times(cf_row9_t x, float factor) {
  const cf_float4_t f = cf_all4(factor);
  return (cf_row9_t){x.a * f, x.b * f, x.c * f};
}

static inline cf_row9_t cf_row9_over(cf_row9_t x, float divisor) {
  const cf_float4_t d = cf_all4(divisor);
  return (cf_row9_t){x.a / d, x.b / d, x.c / d};
}

// x, with value at element i.
static inline cf_row9_t cf_row9_with(cf_row9_t x, int i, float value) {
  const cf_int4_t   at = {i, i, i, i};
  const cf_float4_t v  = cf_all4(value);
  return (cf_row9_t){
      cf_select4(at == (cf_int4_t){0, 1, 2, 3}, v, x.a),
      cf_select4(at == (cf_int4_t){4, 5, 6, 7}, v, x.b),
      cf_select4(at == (cf_int4_t){8, 9, 10, 11}, v, x.c),
  };
}

// Column h of a matrix.
static inline cf_row9_t cf_row9_column(const float matrix[9][9], int h) {
  return (cf_row9_t){
      {matrix[0][h], matrix[1][h], matrix[2][h], matrix[3][h]},
      {matrix[4][h], matrix[5][h], matrix[6][h], matrix[7][h]},
      {matrix[8][h], 0.0f, 0.0f, 0.0f},
  };
}

// x at the elements from first to last, zero elsewhere.
static inline cf_row9_t cf_row9_between(cf_row9_t x, int first, int last) {
  const cf_int4_t at_a  = {0, 1, 2, 3};
  const cf_int4_t at_b  = {4, 5, 6, 7};
  const cf_int4_t at_c  = {8, 9, 10, 11};
  const cf_int4_t above = {first - 1, first - 1, first - 1, first - 1};
  const cf_int4_t below = {last + 1, last + 1, last + 1, last + 1};
  return (cf_row9_t){
      (cf_float4_t)((cf_int4_t)x.a & (at_a > above) & (at_a < below)),
      (cf_float4_t)((cf_int4_t)x.b & (at_b > above) & (at_b < below)),
      (cf_float4_t)((cf_int4_t)x.c & (at_c > above) & (at_c < below)),
  };
}

#endif  // CF_BUILTIN_KALMAN_ROW9_H
