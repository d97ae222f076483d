/* The types that flow through the stabilizer loop, with the names, order and units of the firmware.
 *
 * Source: docs/reference/control-pid.md#2 (release 2026.08: with jerk, PWM mode and the named mode
 * type). Attitudes are in degrees in the legacy frame of the Crazyflie 2, where a positive pitch
 * lifts the nose; quaternions are right-handed. World and body frames: x forward, y left, z up. */
#ifndef STABILIZER_TYPES_H
#define STABILIZER_TYPES_H

#include <stdbool.h>
#include <stdint.h>

#include "api/imu_types.h"
#include "api/lighthouse_types.h"

#define STABILIZER_NR_OF_MOTORS 4

#define RATE_1000_HZ 1000
#define RATE_500_HZ 500
#define RATE_250_HZ 250
#define RATE_100_HZ 100
#define RATE_50_HZ 50
#define RATE_25_HZ 25

#define RATE_MAIN_LOOP 1000
#define ATTITUDE_RATE 500
#define POSITION_RATE 100
#define RATE_HL_COMMANDER 100
#define RATE_SUPERVISOR 25

// Number of iterations of the 1 kHz loop; starts at 1.
typedef uint32_t stabilizerStep_t;

typedef struct attitude_s {
  uint32_t timestamp;
  float    roll;   // [deg]
  float    pitch;  // [deg], positive lifts the nose
  float    yaw;    // [deg]
} attitude_t;

struct vec3_s {
  uint32_t timestamp;
  float    x;
  float    y;
  float    z;
};
typedef struct vec3_s vector_t;
typedef struct vec3_s point_t;     // [m]
typedef struct vec3_s velocity_t;  // [m/s]
typedef struct vec3_s acc_t;       // [g] in state_t, [m/s^2] in setpoint_t
typedef struct vec3_s jerk_t;      // [m/s^3]

typedef union {
  struct {
    float q0;
    float q1;
    float q2;
    float q3;
  };
  struct {
    float x;
    float y;
    float z;
    float w;
  };
} quaternion_t;

typedef enum {
  MeasurementSourceLocationService = 0,
  MeasurementSourceLighthouse      = 1,
} measurementSource_t;

// Difference of the distances to two anchors.
typedef struct {
  union {
    point_t anchorPositions[2];  // [m], world
    struct {
      point_t anchorPositionA;
      point_t anchorPositionB;
    };
  };
  union {
    uint8_t anchorIds[2];
    struct {
      uint8_t anchorIdA;
      uint8_t anchorIdB;
    };
  };
  float distanceDiff;  // [m], distance to B minus distance to A
  float stdDev;        // [m]
} tdoaMeasurement_t;

typedef struct {
  float pressure;     // [mbar]
  float temperature;  // [deg C]
  float asl;          // [m], above sea level
} baro_t;

typedef struct {
  union {
    struct {
      float x;
      float y;
      float z;
    };
    float pos[3];  // [m], world
  };
  float               stdDev;  // [m]
  measurementSource_t source;
} positionMeasurement_t;

typedef struct {
  union {
    struct {
      float x;
      float y;
      float z;
    };
    float pos[3];  // [m], world
  };
  quaternion_t quat;        // body to world
  float        stdDevPos;   // [m]
  float        stdDevQuat;  // [rad]
} poseMeasurement_t;

// Distance to one anchor.
typedef struct {
  union {
    struct {
      float x;
      float y;
      float z;
    };
    float pos[3];  // [m], the anchor, world
  };
  uint8_t anchorId;
  float   distance;  // [m]
  float   stdDev;    // [m]
} distanceMeasurement_t;

typedef struct {
  uint32_t timestamp;
  union {
    struct {
      float dpixelx;
      float dpixely;
    };
    float dpixel[2];  // accumulated motion pixels
  };
  float stdDevX;  // [pixel]
  float stdDevY;  // [pixel]
  float dt;       // [s], over which the pixels were accumulated
} flowMeasurement_t;

typedef struct {
  uint32_t timestamp;
  float    distance;    // [m], along body -z
  float    stdDev;      // [m]
  float coneHalfAngle;  // [rad], the sensor tells the nearest point within this angle of its axis
} tofMeasurement_t;

typedef struct {
  uint32_t timestamp;
  float    height;  // [m], world
  float    stdDev;  // [m]
} heightMeasurement_t;

typedef struct {
  uint32_t timestamp;
  float    yawError;  // [rad], estimated minus measured
  float    stdDev;    // [rad]
} yawErrorMeasurement_t;

// One light plane of a base station seen by one sensor. The pointers are made when the measurement
// is fused; while it waits in a queue they are null, and the ids say what they will point at.
typedef struct {
  uint32_t                                timestamp;
  const vec3d                            *sensorPos;    // [m], body
  const vec3d                            *rotorPos;     // [m], world
  const mat3d                            *rotorRot;     // rotor to world
  const mat3d                            *rotorRotInv;  // world to rotor
  uint8_t                                 sensorId;
  uint8_t                                 baseStationId;
  uint8_t                                 sweepId;
  float                                   t;                   // [rad], tilt of the light plane
  float                                   measuredSweepAngle;  // [rad]
  float                                   stdDev;              // [rad]
  const lighthouseCalibrationSweep_t     *calib;
  lighthouseCalibrationMeasurementModel_t calibrationMeasurementModel;
} sweepAngleMeasurement_t;

typedef struct {
  Axis3f gyro;  // [deg/s]
} gyroscopeMeasurement_t;

typedef struct {
  Axis3f acc;  // [g]
} accelerationMeasurement_t;

typedef struct {
  baro_t baro;
} barometerMeasurement_t;

typedef struct {
  Axis3f   acc;   // [g], specific force: z = +1 at rest
  Axis3f   gyro;  // [deg/s], right-handed body rates
  Axis3f   mag;   // [gauss]
  baro_t   baro;
  uint64_t interruptTimestamp;  // [us]
} sensorData_t;

typedef struct {
  attitude_t   attitude;            // [deg], legacy pitch
  quaternion_t attitudeQuaternion;  // body to world
  point_t      position;            // [m], world
  velocity_t   velocity;            // [m/s], world
  acc_t        acc;                 // [g], world, without gravity
} state_t;

typedef enum {
  controlModeLegacy      = 0,
  controlModeForceTorque = 1,
  controlModeForce       = 2,
  controlModePWM         = 3,
} control_mode_t;

// The three views overlap: only the one that controlMode names is meaningful.
typedef struct {
  union {
    struct {
      int16_t roll;
      int16_t pitch;
      int16_t yaw;     // positive turns clockwise seen from above
      float   thrust;  // [0, 65535]
    };
    struct {
      float thrustSi;  // [N]
      union {
        float torque[3];  // [N m], right-handed
        struct {
          float torqueX;
          float torqueY;
          float torqueZ;
        };
      };
    };
    float normalizedForces[4];  // [0, 1]
  };
  control_mode_t controlMode;
} control_t;

typedef union {
  int32_t list[4];
  struct {
    int32_t m1;
    int32_t m2;
    int32_t m3;
    int32_t m4;
  } motors;
} motors_thrust_uncapped_t;

typedef union {
  uint16_t list[4];
  struct {
    uint16_t m1;
    uint16_t m2;
    uint16_t m3;
    uint16_t m4;
  } motors;
} motors_thrust_pwm_t;

typedef enum mode_e {
  modeDisable  = 0,
  modeAbs      = 1,
  modeVelocity = 2,
} stab_mode_t;

typedef struct {
  stab_mode_t x;
  stab_mode_t y;
  stab_mode_t z;
  stab_mode_t roll;
  stab_mode_t pitch;
  stab_mode_t yaw;
  stab_mode_t quat;
} setpoint_mode_t;

// What the commander holds. All zero is the null setpoint: cut the power.
typedef struct {
  uint32_t        timestamp;  // [ms], tick at which it was set
  attitude_t      attitude;
  attitude_t      attitudeRate;  // [deg/s]
  quaternion_t    attitudeQuaternion;
  float           thrust;         // [0, 65535]
  point_t         position;       // [m]
  velocity_t      velocity;       // [m/s]
  acc_t           acceleration;   // [m/s^2]
  jerk_t          jerk;           // [m/s^3]
  bool            velocity_body;  // the x, y velocity is in the yaw-aligned body frame
  setpoint_mode_t mode;
} setpoint_t;

#endif  // STABILIZER_TYPES_H
