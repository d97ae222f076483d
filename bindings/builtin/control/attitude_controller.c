#include "builtin/control/attitude_controller.h"

#include <math.h>
#include <stddef.h>

#include "convert.h"
#include "variable_row.h"

#define ATTITUDE_UPDATE_DT 0.002f  // [s]

static void init_pid(PidObject *pid, cf_pid_gains_t gains, float integral_limit, float cutoff,
                     bool filtered) {
  pidInit(pid, 0.0f, gains.kp, gains.ki, gains.kd, gains.kff, ATTITUDE_UPDATE_DT,
          (float)ATTITUDE_RATE, cutoff, filtered);
  pidSetIntegralLimit(pid, integral_limit);
}

static void init_rate_loop(cf_attitude_controller_t *attitude, const cf_platform_defaults_t *d) {
  const bool filtered = d->rate_filter_enabled;
  init_pid(&attitude->roll_rate, d->roll_rate, d->roll_rate_integral_limit, d->roll_rate_cutoff,
           filtered);
  init_pid(&attitude->pitch_rate, d->pitch_rate, d->pitch_rate_integral_limit, d->pitch_rate_cutoff,
           filtered);
  init_pid(&attitude->yaw_rate, d->yaw_rate, d->yaw_rate_integral_limit, d->yaw_rate_cutoff,
           filtered);
}

static void init_angle_loop(cf_attitude_controller_t *attitude, const cf_platform_defaults_t *d) {
  const float cutoff   = d->attitude_filter.cutoff;
  const bool  filtered = d->attitude_filter.enabled;
  init_pid(&attitude->roll, d->roll, d->roll_integral_limit, cutoff, filtered);
  init_pid(&attitude->pitch, d->pitch, d->pitch_integral_limit, cutoff, filtered);
  init_pid(&attitude->yaw, d->yaw, d->yaw_integral_limit, cutoff, filtered);
}

void cf_attitude_controller_init(cf_attitude_controller_t     *attitude,
                                 const cf_platform_defaults_t *defaults) {
  *attitude = (cf_attitude_controller_t){
      .yaw_max_delta           = defaults->yaw_max_delta,
      .attitude_cutoff         = defaults->attitude_filter.cutoff,
      .roll_rate_cutoff        = defaults->roll_rate_cutoff,
      .pitch_rate_cutoff       = defaults->pitch_rate_cutoff,
      .yaw_rate_cutoff         = defaults->yaw_rate_cutoff,
      .attitude_filter_enabled = defaults->attitude_filter.enabled,
      .rate_filter_enabled     = defaults->rate_filter_enabled,
  };
  init_rate_loop(attitude, defaults);
  init_angle_loop(attitude, defaults);
}

static float run(PidObject *pid, float measured, float desired, bool is_yaw_angle) {
  pidSetDesired(pid, desired);
  return pidUpdate(pid, measured, is_yaw_angle);
}

void cf_attitude_controller_correct_attitude(cf_attitude_controller_t *attitude,
                                             const attitude_t *measured, const attitude_t *desired,
                                             attitude_t *rate_desired) {
  rate_desired->roll  = run(&attitude->roll, measured->roll, desired->roll, false);
  rate_desired->pitch = run(&attitude->pitch, measured->pitch, desired->pitch, false);
  rate_desired->yaw   = run(&attitude->yaw, measured->yaw, desired->yaw, true);
}

bool cf_attitude_controller_correct_rate(cf_attitude_controller_t *attitude,
                                         const attitude_t *measured, const attitude_t *desired) {
  const float roll  = run(&attitude->roll_rate, measured->roll, desired->roll, false);
  const float pitch = run(&attitude->pitch_rate, measured->pitch, desired->pitch, false);
  const float yaw   = run(&attitude->yaw_rate, measured->yaw, desired->yaw, false);

  attitude->roll_output  = cf_to_int16(roll);
  attitude->pitch_output = cf_to_int16(pitch);
  attitude->yaw_output   = cf_to_int16(yaw);
  return !(isnan(roll) || isnan(pitch) || isnan(yaw));
}

void cf_attitude_controller_reset(cf_attitude_controller_t *attitude, const attitude_t *measured) {
  pidReset(&attitude->roll, measured->roll);
  pidReset(&attitude->pitch, measured->pitch);
  pidReset(&attitude->yaw, measured->yaw);

  // not at the present rates: the next derivative sees the whole rate, as on the vehicle
  pidReset(&attitude->roll_rate, 0.0f);
  pidReset(&attitude->pitch_rate, 0.0f);
  pidReset(&attitude->yaw_rate, 0.0f);
}

void cf_attitude_controller_reset_roll(cf_attitude_controller_t *attitude, float roll) {
  pidReset(&attitude->roll, roll);
}

void cf_attitude_controller_reset_pitch(cf_attitude_controller_t *attitude, float pitch) {
  pidReset(&attitude->pitch, pitch);
}

#define PARAMETER(group_, name_, type_, member_) \
  CF_ROW(group_, name_, type_, CF_PERSISTENT, cf_attitude_controller_t, member_)

#define GAINS(group_, axis_, pid_)                                                                \
  PARAMETER(group_, axis_ "_kp", FLOAT, pid_.kp), PARAMETER(group_, axis_ "_ki", FLOAT, pid_.ki), \
      PARAMETER(group_, axis_ "_kd", FLOAT, pid_.kd),                                             \
      PARAMETER(group_, axis_ "_kff", FLOAT, pid_.kff)

static const cf_variable_t PARAMETERS[] = {
    GAINS("pid_attitude", "roll", roll),
    GAINS("pid_attitude", "pitch", pitch),
    GAINS("pid_attitude", "yaw", yaw),
    PARAMETER("pid_attitude", "yawMaxDelta", FLOAT, yaw_max_delta),
    PARAMETER("pid_attitude", "attFiltEn", INT8, attitude_filter_enabled),
    PARAMETER("pid_attitude", "attFiltCut", FLOAT, attitude_cutoff),

    GAINS("pid_rate", "roll", roll_rate),
    GAINS("pid_rate", "pitch", pitch_rate),
    GAINS("pid_rate", "yaw", yaw_rate),
    PARAMETER("pid_rate", "rateFiltEn", INT8, rate_filter_enabled),
    PARAMETER("pid_rate", "omxFiltCut", FLOAT, roll_rate_cutoff),
    PARAMETER("pid_rate", "omyFiltCut", FLOAT, pitch_rate_cutoff),
    PARAMETER("pid_rate", "omzFiltCut", FLOAT, yaw_rate_cutoff),
};

cf_variables_t cf_attitude_controller_parameters(void) {
  return (cf_variables_t){.rows = PARAMETERS, .count = sizeof(PARAMETERS) / sizeof(PARAMETERS[0])};
}

#define LOG(group_, name_, member_) \
  CF_ROW(group_, name_, FLOAT, 0, cf_attitude_controller_t, member_)

#define TERMS(group_, axis_, pid_)                                              \
  LOG(group_, axis_ "_outP", pid_.outP), LOG(group_, axis_ "_outI", pid_.outI), \
      LOG(group_, axis_ "_outD", pid_.outD), LOG(group_, axis_ "_outFF", pid_.outFF)

static const cf_variable_t LOGS[] = {
    TERMS("pid_attitude", "roll", roll),    TERMS("pid_attitude", "pitch", pitch),
    TERMS("pid_attitude", "yaw", yaw),      TERMS("pid_rate", "roll", roll_rate),
    TERMS("pid_rate", "pitch", pitch_rate), TERMS("pid_rate", "yaw", yaw_rate),
};

cf_variables_t cf_attitude_controller_logs(void) {
  return (cf_variables_t){.rows = LOGS, .count = sizeof(LOGS) / sizeof(LOGS[0])};
}
