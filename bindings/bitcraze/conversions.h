/* From our types to those of the checkout and back, member by member: releases differ in members
 * and in their order. */
#ifndef CF_BITCRAZE_CONVERSIONS_H
#define CF_BITCRAZE_CONVERSIONS_H

#include "bitcraze/checkout.h"

state_t          cf_checkout_state(const api_state_t *from);
sensorData_t     cf_checkout_sensors(const api_sensorData_t *from);
control_t        cf_checkout_control(const api_control_t *from);
Axis3f           cf_checkout_axes(const api_Axis3f *from);
baro_t           cf_checkout_baro(const api_baro_t *from);
struct vec       cf_checkout_vec(struct api_vec from);
struct traj_eval cf_checkout_start(const cf_plan_start_t *from);

// Padding included, since the checkout may keep a copy: what a drone is shall not hold what stood
// on the stack. On the way back padding, and what the checkout lacks, stay as they are.
void cf_checkout_setpoint(setpoint_t *to, const api_setpoint_t *from);
void cf_api_setpoint(api_setpoint_t *to, const setpoint_t *from);

void cf_api_state(api_state_t *to, const state_t *from);
void cf_api_control(api_control_t *to, const control_t *from);

struct api_traj_eval cf_api_goal(const struct traj_eval *from);

// What waits in the queue of the estimator.
tdoaMeasurement_t     cf_checkout_tdoa(const api_tdoaMeasurement_t *from);
positionMeasurement_t cf_checkout_position(const api_positionMeasurement_t *from);
poseMeasurement_t     cf_checkout_pose(const api_poseMeasurement_t *from);
distanceMeasurement_t cf_checkout_distance(const api_distanceMeasurement_t *from);
tofMeasurement_t      cf_checkout_tof(const api_tofMeasurement_t *from);
heightMeasurement_t   cf_checkout_height(const api_heightMeasurement_t *from);
flowMeasurement_t     cf_checkout_flow(const api_flowMeasurement_t *from);
yawErrorMeasurement_t cf_checkout_yaw_error(const api_yawErrorMeasurement_t *from);

// A sweep points at others; `calibration`, the caller's, becomes one of them.
sweepAngleMeasurement_t cf_checkout_sweep(const api_sweepAngleMeasurement_t *from,
                                          lighthouseCalibrationSweep_t      *calibration);

#endif  // CF_BITCRAZE_CONVERSIONS_H
