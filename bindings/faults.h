/* Faults that a caller injects into a drone: broken motors, sensors, batteries, gusts.
 *
 * Each function changes the drone from its next tick on; the fault lasts until the caller ends it.
 * Everything lives in cf_t, so that a fault is part of a snapshot. A drone without a fault checks
 * two flags per tick. The faults for which the core itself stops a drone are different: cf_fault_t
 * of onboard/onboard.h. */
#ifndef CF_FAULTS_H
#define CF_FAULTS_H

#include <stdbool.h>
#include <stdint.h>

#include "api/imu_types.h"
#include "status.h"
#include "vehicle/imu.h"
#include "vehicle/random.h"

// Axes of the IMU: x, y, z of the gyroscope, then of the accelerometer, one bit each.
#define CF_IMU_GYRO_AXES 7
#define CF_IMU_ACC_AXES 56

typedef struct {
  bool is_sensing_wrong;  // any fault of the IMU, or no battery

  bool    is_battery_cut;
  uint8_t stuck_axes;              // of the IMU, which give the same reading again and again
  uint8_t held_axes;               // those of them whose reading is known
  int16_t held[CF_IMU_AXES];       // [LSB]
  float   imu_bias[CF_IMU_AXES];   // [LSB]
  float   imu_noise[CF_IMU_AXES];  // [LSB], standard deviation per sample

  cf_random_t random;  // of the noise
} cf_injected_faults_t;

// What an IMU does wrong on some of its axes.
typedef struct {
  uint8_t axes;      // bits
  bool    is_stuck;  // the next reading stays
  float   bias;      // [rad/s] or [m/s^2], added; what leaves the range of the sensor is clipped
  float   noise;     // [rad/s] or [m/s^2] >= 0, standard deviation of white noise per sample, added
} cf_imu_fault_t;

struct cf;  // crazyflie.h, which has the faults of a drone as a member

// Lets motor 0..3 turn with a share [0, 2] of the thrust and torque that it has when it is well; 0
// stops it. Returns CF_ERR_CAPACITY for another motor, CF_ERR_VALUE for a share that leaves it with
// an efficiency outside [0, 2].
cf_status_t cf_inject_motor(struct cf *cf, int motor, float share);

// Spoils axes of the IMU, which replaces what was wrong with them before; a fault with neither
// stuck, bias nor noise heals them. Returns CF_ERR_VALUE for a number outside its range.
cf_status_t cf_inject_imu(struct cf *cf, const cf_imu_fault_t *fault, uint64_t seed);

// Silences the positioning system that is fitted, or lets it speak again. Returns CF_ERR_STATE when
// there is none.
cf_status_t cf_inject_positioning_loss(struct cf *cf, bool is_lost);

// Loses a share [0, 1] of the poses of the motion capture; 0 brings back what is lost when all is
// well. Returns CF_ERR_STATE when none is fitted, CF_ERR_VALUE for another share.
cf_status_t cf_inject_positioning_dropout(struct cf *cf, float share);

// Lets poses of the motion capture arrive `extra_ms` later than they do when all is well. Returns
// CF_ERR_STATE when none is fitted, CF_ERR_CAPACITY when too many would be under way.
cf_status_t cf_inject_positioning_delay(struct cf *cf, uint32_t extra_ms);

// Sets the state of charge [0, 1]. Returns CF_ERR_VALUE for another.
cf_status_t cf_inject_battery_charge(struct cf *cf, float charge);

// Puts a resistance [Ohm] in [0, 10] between battery and drone: a bad contact. Returns CF_ERR_VALUE
// for another.
cf_status_t cf_inject_battery_resistance(struct cf *cf, float extra);

// Cuts the battery: rotors run down, the onboard software ends with CF_FAULT_POWER. Connected
// again, the drone waits for a reboot.
void cf_inject_battery_cut(struct cf *cf, bool is_cut);

// Lets a gust pass: the wind [m/s, world] rises to `velocity` and falls again within `ticks`, as
// one minus a cosine (cf_vehicle_gust). Returns CF_ERR_VALUE unless each component is within +-50
// m/s and it takes 1 ms to an hour.
cf_status_t cf_inject_gust(struct cf *cf, const float velocity[3], uint32_t ticks);

// For cf_sense. Internal to C.
void cf_injected_spoil_imu(cf_injected_faults_t *faults, Axis3i16 *gyro, Axis3i16 *acc);

#endif  // CF_FAULTS_H
