/* provider.h and what it needs, with every name of ours that a checkout has as well behind `api_`.
 *
 * Our provider speaks the firmware's language: its types have the names and nearly the fields of
 * those of a checkout. For one file to see both, ours are renamed while they are read, and the
 * names are free again afterwards. So are include guards and macros. Comes before any header of a
 * checkout. */
#ifndef CF_BITCRAZE_API_H
#define CF_BITCRAZE_API_H

// imu_types.h
#define Axis3i16 api_Axis3i16
#define Axis3i32 api_Axis3i32
#define Axis3i64 api_Axis3i64
#define Axis3f api_Axis3f

// lighthouse_types.h
#define vec3d api_vec3d
#define mat3d api_mat3d
#define lighthouseCalibrationSweep_t api_lighthouseCalibrationSweep_t
#define lighthouseCalibration_t api_lighthouseCalibration_t
#define lighthouseCalibrationMeasurementModel_t api_lighthouseCalibrationMeasurementModel_t

// stabilizer_types.h
#define stabilizerStep_t api_stabilizerStep_t
#define attitude_s api_attitude_s
#define attitude_t api_attitude_t
#define vec3_s api_vec3_s
#define vector_t api_vector_t
#define point_t api_point_t
#define velocity_t api_velocity_t
#define acc_t api_acc_t
#define jerk_t api_jerk_t
#define quaternion_t api_quaternion_t
#define measurementSource_t api_measurementSource_t
#define MeasurementSourceLocationService api_MeasurementSourceLocationService
#define MeasurementSourceLighthouse api_MeasurementSourceLighthouse
#define tdoaMeasurement_t api_tdoaMeasurement_t
#define baro_t api_baro_t
#define positionMeasurement_t api_positionMeasurement_t
#define poseMeasurement_t api_poseMeasurement_t
#define distanceMeasurement_t api_distanceMeasurement_t
#define flowMeasurement_t api_flowMeasurement_t
#define tofMeasurement_t api_tofMeasurement_t
#define heightMeasurement_t api_heightMeasurement_t
#define yawErrorMeasurement_t api_yawErrorMeasurement_t
#define sweepAngleMeasurement_t api_sweepAngleMeasurement_t
#define gyroscopeMeasurement_t api_gyroscopeMeasurement_t
#define accelerationMeasurement_t api_accelerationMeasurement_t
#define barometerMeasurement_t api_barometerMeasurement_t
#define sensorData_t api_sensorData_t
#define state_t api_state_t
#define control_mode_t api_control_mode_t
#define controlModeLegacy api_controlModeLegacy
#define controlModeForceTorque api_controlModeForceTorque
#define controlModeForce api_controlModeForce
#define controlModePWM api_controlModePWM
#define control_t api_control_t
#define motors_thrust_uncapped_t api_motors_thrust_uncapped_t
#define motors_thrust_pwm_t api_motors_thrust_pwm_t
#define mode_e api_mode_e
#define modeDisable api_modeDisable
#define modeAbs api_modeAbs
#define modeVelocity api_modeVelocity
#define stab_mode_t api_stab_mode_t
#define setpoint_mode_t api_setpoint_mode_t
#define setpoint_t api_setpoint_t

// measurement.h
#define MeasurementTypeTDOA api_MeasurementTypeTDOA
#define MeasurementTypePosition api_MeasurementTypePosition
#define MeasurementTypePose api_MeasurementTypePose
#define MeasurementTypeDistance api_MeasurementTypeDistance
#define MeasurementTypeTOF api_MeasurementTypeTOF
#define MeasurementTypeAbsoluteHeight api_MeasurementTypeAbsoluteHeight
#define MeasurementTypeFlow api_MeasurementTypeFlow
#define MeasurementTypeYawError api_MeasurementTypeYawError
#define MeasurementTypeSweepAngle api_MeasurementTypeSweepAngle
#define MeasurementTypeGyroscope api_MeasurementTypeGyroscope
#define MeasurementTypeAcceleration api_MeasurementTypeAcceleration
#define MeasurementTypeBarometer api_MeasurementTypeBarometer
#define MeasurementType api_MeasurementType
#define measurement_t api_measurement_t

// vec.h and pptraj.h
#define vec api_vec
#define poly4d api_poly4d
#define traj_eval api_traj_eval
#define piecewise_traj api_piecewise_traj
#define polyval api_polyval
#define polylinear api_polylinear
#define polybezier api_polybezier
#define poly5 api_poly5
#define polyscale api_polyscale
#define polyder api_polyder
#define polystretchtime api_polystretchtime
#define polyreflect api_polyreflect
#define poly4d_zero api_poly4d_zero
#define poly4d_linear api_poly4d_linear
#define poly4d_scale api_poly4d_scale
#define poly4d_shift api_poly4d_shift
#define poly4d_shift_vec api_poly4d_shift_vec
#define poly4d_stretchtime api_poly4d_stretchtime
#define polyder4d api_polyder4d
#define poly4d_max_accel_approx api_poly4d_max_accel_approx
#define poly4d_eval api_poly4d_eval
#define traj_eval_zero api_traj_eval_zero
#define traj_eval_invalid api_traj_eval_invalid
#define is_traj_eval_valid api_is_traj_eval_valid
#define traj_eval_transform api_traj_eval_transform
#define piecewise_duration api_piecewise_duration
#define piecewise_eval api_piecewise_eval
#define piecewise_eval_reversed api_piecewise_eval_reversed
#define piecewise_is_finished api_piecewise_is_finished
#define piecewise_plan_5th_order api_piecewise_plan_5th_order
#define piecewise_plan_7th_order_no_jerk api_piecewise_plan_7th_order_no_jerk

// provider.h
#define ControllerTypeAutoSelect api_ControllerTypeAutoSelect
#define ControllerTypePID api_ControllerTypePID
#define ControllerTypeMellinger api_ControllerTypeMellinger
#define ControllerTypeINDI api_ControllerTypeINDI
#define ControllerTypeBrescianini api_ControllerTypeBrescianini
#define ControllerTypeLee api_ControllerTypeLee
#define ControllerTypeOot api_ControllerTypeOot
#define ControllerType_COUNT api_ControllerType_COUNT
#define ControllerType api_ControllerType

#include "library/inner.h"

enum { CF_PEERS = PEER_LOCALIZATION_MAX_NEIGHBORS };

// imu_types.h
#undef Axis3i16
#undef Axis3i32
#undef Axis3i64
#undef Axis3f

// lighthouse_types.h
#undef vec3d
#undef mat3d
#undef lighthouseCalibrationSweep_t
#undef lighthouseCalibration_t
#undef lighthouseCalibrationMeasurementModel_t

// stabilizer_types.h
#undef stabilizerStep_t
#undef attitude_s
#undef attitude_t
#undef vec3_s
#undef vector_t
#undef point_t
#undef velocity_t
#undef acc_t
#undef jerk_t
#undef quaternion_t
#undef measurementSource_t
#undef MeasurementSourceLocationService
#undef MeasurementSourceLighthouse
#undef tdoaMeasurement_t
#undef baro_t
#undef positionMeasurement_t
#undef poseMeasurement_t
#undef distanceMeasurement_t
#undef flowMeasurement_t
#undef tofMeasurement_t
#undef heightMeasurement_t
#undef yawErrorMeasurement_t
#undef sweepAngleMeasurement_t
#undef gyroscopeMeasurement_t
#undef accelerationMeasurement_t
#undef barometerMeasurement_t
#undef sensorData_t
#undef state_t
#undef control_mode_t
#undef controlModeLegacy
#undef controlModeForceTorque
#undef controlModeForce
#undef controlModePWM
#undef control_t
#undef motors_thrust_uncapped_t
#undef motors_thrust_pwm_t
#undef mode_e
#undef modeDisable
#undef modeAbs
#undef modeVelocity
#undef stab_mode_t
#undef setpoint_mode_t
#undef setpoint_t

// measurement.h
#undef MeasurementTypeTDOA
#undef MeasurementTypePosition
#undef MeasurementTypePose
#undef MeasurementTypeDistance
#undef MeasurementTypeTOF
#undef MeasurementTypeAbsoluteHeight
#undef MeasurementTypeFlow
#undef MeasurementTypeYawError
#undef MeasurementTypeSweepAngle
#undef MeasurementTypeGyroscope
#undef MeasurementTypeAcceleration
#undef MeasurementTypeBarometer
#undef MeasurementType
#undef measurement_t

// vec.h and pptraj.h
#undef vec
#undef poly4d
#undef traj_eval
#undef piecewise_traj
#undef polyval
#undef polylinear
#undef polybezier
#undef poly5
#undef polyscale
#undef polyder
#undef polystretchtime
#undef polyreflect
#undef poly4d_zero
#undef poly4d_linear
#undef poly4d_scale
#undef poly4d_shift
#undef poly4d_shift_vec
#undef poly4d_stretchtime
#undef polyder4d
#undef poly4d_max_accel_approx
#undef poly4d_eval
#undef traj_eval_zero
#undef traj_eval_invalid
#undef is_traj_eval_valid
#undef traj_eval_transform
#undef piecewise_duration
#undef piecewise_eval
#undef piecewise_eval_reversed
#undef piecewise_is_finished
#undef piecewise_plan_5th_order
#undef piecewise_plan_7th_order_no_jerk

// provider.h
#undef ControllerTypeAutoSelect
#undef ControllerTypePID
#undef ControllerTypeMellinger
#undef ControllerTypeINDI
#undef ControllerTypeBrescianini
#undef ControllerTypeLee
#undef ControllerTypeOot
#undef ControllerType_COUNT
#undef ControllerType

// guards and macros
#undef IMU_TYPES_H
#undef LIGHTHOUSE_TYPES_H
#undef MEASUREMENT_H
#undef PPTRAJ_H
#undef STABILIZER_TYPES_H
#undef VEC_H
#undef PP_DEGREE
#undef PP_SIZE
#undef STABILIZER_NR_OF_MOTORS
#undef PEER_LOCALIZATION_MAX_NEIGHBORS
#undef RATE_1000_HZ
#undef RATE_500_HZ
#undef RATE_250_HZ
#undef RATE_100_HZ
#undef RATE_50_HZ
#undef RATE_25_HZ
#undef RATE_MAIN_LOOP
#undef ATTITUDE_RATE
#undef POSITION_RATE
#undef RATE_HL_COMMANDER
#undef RATE_SUPERVISOR

#endif  // CF_BITCRAZE_API_H
