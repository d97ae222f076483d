%module cffirmware

// fixed widths are numbers
%include <stdint.i>

// the generator of wrappers knows no attributes
#define __attribute__(x)

%{
#define SWIG_FILE_WITH_INIT
#include <stdlib.h>
#include "math3d.h"
#include "pptraj.h"
#include "planner.h"
#include "stabilizer_types.h"
#include "collision_avoidance.h"
#include "imu_types.h"
#include "controller_pid.h"
#include "position_controller.h"
#include "pid.h"
#include "filter.h"
#include "num.h"
#include "controller_mellinger.h"
#include "controller_brescianini.h"
#if MINIATURE_RELEASE >= 202512
#include "controller_lee.h"
#endif
#include "power_distribution.h"
#include "axis3fSubSampler.h"
#include "outlierFilterTdoa.h"
#include "kalman_core.h"
#include "mm_tdoa.h"
%}

%include "math3d.h"
%include "pptraj.h"
%include "planner.h"
%include "stabilizer_types.h"
%include "collision_avoidance.h"
%include "controller_pid.h"
%include "imu_types.h"
%include "controller_mellinger.h"
%include "controller_brescianini.h"
#if MINIATURE_RELEASE >= 202512
%include "controller_lee.h"
#endif
%include "power_distribution.h"
%include "axis3fSubSampler.h"
%include "outlierFilterTdoa.h"
%include "kalman_core.h"
%include "mm_tdoa.h"

%inline %{
struct poly4d *piecewise_get(struct piecewise_traj *pp, int i) {
  return (struct poly4d *)&pp->pieces[i];
}

void poly4d_set(struct poly4d *poly, int dim, int coef, float val) {
  poly->p[dim][coef] = val;
}

float poly4d_get(struct poly4d *poly, int dim, int coef) {
  return poly->p[dim][coef];
}

struct poly4d *poly4d_malloc(int size) {
  return (struct poly4d *)malloc(sizeof(struct poly4d) * size);
}

void poly4d_free(struct poly4d *p) {
  free(p);
}

struct vec vec2svec(struct vec3_s v) {
  return mkvec(v.x, v.y, v.z);
}

struct vec3_s svec2vec(struct vec v) {
  struct vec3_s result = {.timestamp = 0, .x = v.x, .y = v.y, .z = v.z};
  return result;
}

void collisionAvoidanceUpdateSetpointWrap(collision_avoidance_params_t const *params,
                                          collision_avoidance_state_t *collisionState, int nOthers,
                                          float const *otherPositions, setpoint_t *setpoint,
                                          sensorData_t const *sensorData, state_t const *state) {
  // numbers were counted, not positions
  nOthers /= 3;
  float *workspace = malloc(sizeof(float) * 7 * (nOthers + 6));
  collisionAvoidanceUpdateSetpointCore(params, collisionState, nOthers, otherPositions, workspace,
                                       setpoint, sensorData, state);
  free(workspace);
}

// returns: the exception is seen by whoever called from Python
void assertFail(char *exp, char *file, int line) {
  PyErr_Format(PyExc_AssertionError, "%s at %s:%d", exp, file, line);
}
%}

%pythoncode %{
import numpy as np
%}

%extend vec {
  vec(struct vec const *x) {
    struct vec *copy = malloc(sizeof(struct vec));
    *copy = *x;
    return copy;
  }
  ~vec() {
    free($self);
  }
  %pythoncode %{
    def __repr__(self):
        return f"({self.x}, {self.y}, {self.z})"

    def __array__(self):
        return np.array([self.x, self.y, self.z])

    def __len__(self):
        return 3

    def __getitem__(self, i):
        if i < 0 or i > 2:
            raise IndexError("a vector has three elements")
        return (self.x, self.y, self.z)[i]

    def __neg__(self):
        return _cffirmware.vneg(self)

    def __rmul__(self, s):
        return _cffirmware.vscl(s, self)

    def __div__(self, s):
        return self.__truediv__(s)

    def __truediv__(self, s):
        return _cffirmware.vdiv(self, s)

    def __add__(self, other):
        return _cffirmware.vadd(self, other)

    def __sub__(self, other):
        return _cffirmware.vsub(self, other)
  %}
}

%extend traj_eval {
  traj_eval(struct traj_eval const *x) {
    struct traj_eval *copy = malloc(sizeof(struct traj_eval));
    *copy = *x;
    return copy;
  }
  ~traj_eval() {
    free($self);
  }
}
