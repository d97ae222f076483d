/* Attitude from gyroscope and accelerometer alone: Mahony's filter, or Madgwick's
 * (docs/reference/estimators.md#10.2).
 *
 * The firmware keeps this state in a file, so that none of its functions is pure; here the same
 * functions take the state as their first argument. What upstream chooses at build time is a field:
 * Madgwick's filter is kept for comparison only, since it takes deg/s for rad/s and turns 57 times
 * too fast, as the release does. Yaw is the integral of the gyroscope, from 0. */
#ifndef SENSFUSION6_H
#define SENSFUSION6_H

#include <stdbool.h>
#include <stdint.h>

typedef enum {
  CF_SENSFUSION6_MAHONY   = 0,
  CF_SENSFUSION6_MADGWICK = 1,
} cf_sensfusion6_filter_t;

typedef struct {
  // settings
  cf_sensfusion6_filter_t filter;
  float                   beta;  // gain of Madgwick's filter

  // parameters
  float twoKp;  // [1/s], twice the proportional gain
  float twoKi;  // [1/s^2], twice the integral gain; 0 forgets the integral

  // state
  float   qw, qx, qy, qz;  // body to world; of norm 0.9983, which the fast square root leaves
  float   integralFBx, integralFBy, integralFBz;  // [rad/s]
  uint8_t isInit;
  uint8_t isCalibrated;  // baseZacc has been measured

  // outputs
  float gravX, gravY, gravZ;  // direction of gravity in the body frame, of norm 0.9966
  float baseZacc;             // [g], along gravity at the first update; a parameter as well
} cf_sensfusion6_t;

// Writes the whole struct: the state after boot, level.
void cf_sensfusion6_boot(cf_sensfusion6_t *fusion, cf_sensfusion6_filter_t filter);

// Marks the filter as started. It goes on from the attitude it has.
void cf_sensfusion6_init(cf_sensfusion6_t *fusion);
bool cf_sensfusion6_test(const cf_sensfusion6_t *fusion);

// Advances by dt [s] with body rates [deg/s] and specific force [g, not normalized]. The first
// update takes the vehicle for standing still.
void cf_sensfusion6_update_q(cf_sensfusion6_t *fusion, float gx, float gy, float gz, float ax,
                             float ay, float az, float dt);

void cf_sensfusion6_get_quaternion(const cf_sensfusion6_t *fusion, float *x, float *y, float *z,
                                   float *w);

// Angles [deg], positive pitch lifts the nose.
void cf_sensfusion6_get_euler_rpy(const cf_sensfusion6_t *fusion, float *roll, float *pitch,
                                  float *yaw);

// Returns the acceleration [g] along gravity, without gravity, of a specific force [g].
float cf_sensfusion6_get_acc_z_without_gravity(const cf_sensfusion6_t *fusion, float ax, float ay,
                                               float az);

#endif  // SENSFUSION6_H
