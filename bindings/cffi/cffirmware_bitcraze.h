/* Functions of a checkout whose signature differs between releases, in their newest form, for
 * crazychoir_fw.cffirmware. CF_HAS_X is 1 where the probe of that name compiles (see
 * crazychoir_fw/cffirmware/declarations.py), otherwise 0. */
#ifndef CF_CFFI_CFFIRMWARE_BITCRAZE_H
#define CF_CFFI_CFFIRMWARE_BITCRAZE_H

#include "cffi/cffirmware_headers.h"

// what older releases cannot do is refused in Python
#define CF_UPSTREAM_HAS_LINEAR CF_HAS_LINEAR
#define CF_UPSTREAM_HAS_RELATIVE_YAW CF_HAS_RELATIVE_YAW

// Returns what the latest failed assertion said, and forgets it; null without one.
const char *cf_upstream_take_assertion(void);

static inline int cf_upstream_plan_go_to(struct planner *p, bool relative, bool linear,
                                         struct vec hover_pos, float hover_yaw, float duration,
                                         float t) {
#if CF_HAS_LINEAR
  return plan_go_to(p, relative, linear, hover_pos, hover_yaw, duration, t);
#else
  (void)linear;
  return plan_go_to(p, relative, hover_pos, hover_yaw, duration, t);
#endif
}

static inline int cf_upstream_plan_go_to_from(struct planner *p, const struct traj_eval *curr_eval,
                                              bool relative, bool linear, struct vec hover_pos,
                                              float hover_yaw, float duration, float t) {
#if CF_HAS_LINEAR
  return plan_go_to_from(p, curr_eval, relative, linear, hover_pos, hover_yaw, duration, t);
#else
  (void)linear;
  return plan_go_to_from(p, curr_eval, relative, hover_pos, hover_yaw, duration, t);
#endif
}

static inline int cf_upstream_plan_start_trajectory(struct planner        *p,
                                                    struct piecewise_traj *trajectory,
                                                    bool reversed, bool relative, bool relative_yaw,
                                                    struct vec start_from, float start_yaw) {
#if CF_HAS_RELATIVE_YAW
  return plan_start_trajectory(p, trajectory, reversed, relative, relative_yaw, start_from,
                               start_yaw);
#else
  (void)relative_yaw;
  (void)start_yaw;
  return plan_start_trajectory(p, trajectory, reversed, relative, start_from);
#endif
}

#ifdef CF_WITH_PPTRAJ_COMPRESSED
// upstream reads until a piece of duration 0, wherever the bytes end
static inline void cf_upstream_piecewise_compressed_load(struct piecewise_traj_compressed *traj,
                                                         const void *data, uint32_t size) {
  (void)size;
  piecewise_compressed_load(traj, data);
}
#endif

static inline void cf_upstream_kalmanCorePredict(kalmanCoreData_t         *self,
                                                 const kalmanCoreParams_t *params,
                                                 const Axis3f *acc, const Axis3f *gyro,
                                                 uint32_t nowMs, bool quadIsFlying) {
  // older releases change none of the samples, but do not say so
#if CF_HAS_PREDICT_PARAMS
  kalmanCorePredict(self, (kalmanCoreParams_t *)params, (Axis3f *)acc, (Axis3f *)gyro, nowMs,
                    quadIsFlying);
#else
  (void)params;
  kalmanCorePredict(self, (Axis3f *)acc, (Axis3f *)gyro, nowMs, quadIsFlying);
#endif
}

#if CF_HAS_MATRIX_UPDATES
static inline void cf_upstream_kalmanCoreScalarUpdate(kalmanCoreData_t *self, const float Hm[9],
                                                      float error, float stdMeasNoise) {
  arm_matrix_instance_f32 H = {1, 9, (float *)Hm};
  kalmanCoreScalarUpdate(self, &H, error, stdMeasNoise);
}

static inline void cf_upstream_kalmanCoreUpdateWithPKE(kalmanCoreData_t *self, const float Hm[9],
                                                       const float Km[9], const float P_w_m[9][9],
                                                       float error) {
  arm_matrix_instance_f32 H = {1, 9, (float *)Hm};
  arm_matrix_instance_f32 K = {9, 1, (float *)Km};
  arm_matrix_instance_f32 P = {9, 9, (float *)P_w_m};
  kalmanCoreUpdateWithPKE(self, &H, &K, &P, error);
}
#endif

static inline bool cf_upstream_powerDistributionCap(
    const motors_thrust_uncapped_t *motorThrustUncapped, motors_thrust_pwm_t *motorPwm) {
#if CF_HAS_CAP_RESULT
  return powerDistributionCap(motorThrustUncapped, motorPwm);
#else
  bool exceeded = false;
  for (int i = 0; i < 4; i++) {
    exceeded = exceeded || motorThrustUncapped->list[i] > UINT16_MAX;
  }
  powerDistributionCap(motorThrustUncapped, motorPwm);
  return exceeded;
#endif
}

#endif  // CF_CFFI_CFFIRMWARE_BITCRAZE_H
