/* What crazychoir_fw.cffirmware declares to cffi of a checkout's headers: upstream's names, the
 * newest forms. crazychoir_fw/cffirmware/declarations.py leaves out, statement by statement and
 * member by member, what the checkout at hand does not have, and lets the compiler find the
 * layouts.
 *
 * One member per line. Lengths of arrays and types of enumerations are the compiler's to say.
 * Functions with cf_upstream_ in front are in cffirmware_bitcraze.h. */

// ------------------------------------------------------------------------------- imu_types, math3d
typedef struct {
  int16_t x;
  int16_t y;
  int16_t z;
} Axis3i16;
typedef struct {
  int32_t x;
  int32_t y;
  int32_t z;
} Axis3i32;
typedef struct {
  int64_t x;
  int64_t y;
  int64_t z;
} Axis3i64;
typedef union {
  struct {
    float x;
    float y;
    float z;
  };
  float axis[3];
} Axis3f;

struct vec {
  float x;
  float y;
  float z;
};
struct mat33 {
  float m[3][3];
};
struct quat {
  float x;
  float y;
  float z;
  float w;
};

// ------------------------------------------------------------------------------------------ pptraj
struct poly4d {
  float p[4][8];
  float duration;
};
struct traj_eval {
  struct vec pos;
  struct vec vel;
  struct vec acc;
  struct vec jerk;
  struct vec omega;
  float      yaw;
};
struct piecewise_traj {
  float          t_begin;
  float          timescale;
  struct vec     shift;
  float          shift_yaw;
  unsigned char  n_pieces;
  struct poly4d *pieces;
};
struct piecewise_traj_compressed {
  float      t_begin;
  float      duration;
  float      timescale;
  struct vec shift;
  void      *data;
};
struct planner {
  int  state;
  int  type;
  bool reversed;
  union {
    struct piecewise_traj            *trajectory;
    struct piecewise_traj_compressed *compressed_trajectory;
  };
  struct piecewise_traj planned_trajectory;
  struct poly4d         pieces[1];
};

// -------------------------------------------------------------------------------- stabilizer_types
typedef struct {
  uint32_t timestamp;
  float    roll;
  float    pitch;
  float    yaw;
} attitude_t;
struct vec3_s {
  uint32_t timestamp;
  float    x;
  float    y;
  float    z;
};
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
typedef struct {
  float pressure;
  float temperature;
  float asl;
} baro_t;
typedef struct {
  union {
    struct vec3_s anchorPositions[2];
    struct {
      struct vec3_s anchorPositionA;
      struct vec3_s anchorPositionB;
    };
  };
  union {
    uint8_t anchorIds[2];
    struct {
      uint8_t anchorIdA;
      uint8_t anchorIdB;
    };
  };
  float distanceDiff;
  float stdDev;
} tdoaMeasurement_t;
typedef struct {
  union {
    struct {
      float x;
      float y;
      float z;
    };
    float pos[3];
  };
  float stdDev;
  int   source;
} positionMeasurement_t;
typedef struct {
  union {
    struct {
      float x;
      float y;
      float z;
    };
    float pos[3];
  };
  quaternion_t quat;
  float        stdDevPos;
  float        stdDevQuat;
} poseMeasurement_t;
typedef struct {
  union {
    struct {
      float x;
      float y;
      float z;
    };
    float pos[3];
  };
  uint8_t anchorId;
  float   distance;
  float   stdDev;
} distanceMeasurement_t;
typedef struct {
  uint32_t timestamp;
  float    distance;
} zDistance_t;
typedef struct {
  uint32_t timestamp;
  union {
    struct {
      float dpixelx;
      float dpixely;
    };
    float dpixel[2];
  };
  float stdDevX;
  float stdDevY;
  float dt;
} flowMeasurement_t;
typedef struct {
  uint32_t timestamp;
  float    distance;
  float    stdDev;
  float    coneHalfAngle;
} tofMeasurement_t;
typedef struct {
  uint32_t timestamp;
  float    height;
  float    stdDev;
} heightMeasurement_t;
typedef struct {
  uint32_t timestamp;
  float    yawError;
  float    stdDev;
} yawErrorMeasurement_t;
typedef struct {
  uint32_t timestamp;
  void    *sensorPos;
  void    *rotorPos;
  void    *rotorRot;
  void    *rotorRotInv;
  uint8_t  sensorId;
  uint8_t  baseStationId;
  uint8_t  sweepId;
  float    t;
  float    measuredSweepAngle;
  float    stdDev;
  void    *calib;
  void    *calibrationMeasurementModel;
} sweepAngleMeasurement_t;
typedef struct {
  Axis3f gyro;
} gyroscopeMeasurement_t;
typedef struct {
  Axis3f acc;
} accelerationMeasurement_t;
typedef struct {
  baro_t baro;
} barometerMeasurement_t;
typedef struct {
  uint32_t      timestamp;
  struct vec3_s position;
} estimate_t;
typedef struct {
  float z;
  bool  isUpdate;
} setpointZ_t;
typedef struct {
  Axis3f   acc;
  Axis3f   gyro;
  Axis3f   mag;
  baro_t   baro;
  uint64_t interruptTimestamp;
} sensorData_t;
typedef struct {
  attitude_t    attitude;
  quaternion_t  attitudeQuaternion;
  struct vec3_s position;
  struct vec3_s velocity;
  struct vec3_s acc;
} state_t;
typedef struct {
  union {
    struct {
      int16_t roll;
      int16_t pitch;
      int16_t yaw;
      float   thrust;
    };
    struct {
      float thrustSi;
      union {
        float torque[3];
        struct {
          float torqueX;
          float torqueY;
          float torqueZ;
        };
      };
    };
    float normalizedForces[4];
  };
  int controlMode;
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
typedef struct {
  uint32_t      timestamp;
  attitude_t    attitude;
  attitude_t    attitudeRate;
  quaternion_t  attitudeQuaternion;
  float         thrust;
  struct vec3_s position;
  struct vec3_s velocity;
  struct vec3_s acceleration;
  struct vec3_s jerk;
  bool          velocity_body;
  struct {
    int x;
    int y;
    int z;
    int roll;
    int pitch;
    int yaw;
    int quat;
  } mode;
} setpoint_t;

// ----------------------------------------------------------------------------- collision_avoidance
typedef struct {
  struct vec ellipsoidRadii;
  struct vec bboxMin;
  struct vec bboxMax;
  float      horizonSecs;
  float      maxSpeed;
  float      sidestepThreshold;
  int        maxPeerLocAgeMillis;
  float      voronoiProjectionTolerance;
  int        voronoiProjectionMaxIters;
} collision_avoidance_params_t;
typedef struct {
  struct vec lastFeasibleSetPosition;
} collision_avoidance_state_t;

// ------------------------------------------------------------------------------------- controllers
typedef struct {
  float      mass;
  float      massThrust;
  float      kp_xy;
  float      kd_xy;
  float      ki_xy;
  float      i_range_xy;
  float      kp_z;
  float      kd_z;
  float      ki_z;
  float      i_range_z;
  float      kR_xy;
  float      kw_xy;
  float      ki_m_xy;
  float      i_range_m_xy;
  float      kR_z;
  float      kw_z;
  float      ki_m_z;
  float      i_range_m_z;
  float      kd_omega_rp;
  float      i_error_x;
  float      i_error_y;
  float      i_error_z;
  float      prev_omega_roll;
  float      prev_omega_pitch;
  float      prev_setpoint_omega_roll;
  float      prev_setpoint_omega_pitch;
  float      i_error_m_x;
  float      i_error_m_y;
  float      i_error_m_z;
  struct vec z_axis_desired;
  float      cmd_thrust;
  float      cmd_roll;
  float      cmd_pitch;
  float      cmd_yaw;
  float      r_roll;
  float      r_pitch;
  float      r_yaw;
  float      accelz;
} controllerMellinger_t;
typedef struct {
  float        mass;
  float        thrustSi;
  struct vec   J;
  struct vec   Kpos_P;
  float        Kpos_P_limit;
  struct vec   Kpos_D;
  float        Kpos_D_limit;
  struct vec   Kpos_I;
  float        Kpos_I_limit;
  struct vec   i_error_pos;
  struct vec   p_error;
  struct vec   v_error;
  struct vec   KR;
  struct vec   Komega;
  struct vec   KI;
  struct vec   i_error_att;
  struct vec   rpy;
  struct vec   rpy_des;
  struct vec   qr;
  struct mat33 R_des;
  struct vec   omega;
  struct vec   omega_r;
  struct vec   u;
} controllerLee_t;

// ------------------------------------------------------------------------------------------
// filters
typedef struct {
  Axis3f   sum;
  uint32_t count;
  float    conversionFactor;
  Axis3f   subSample;
} Axis3fSubSampler_t;
typedef struct {
  float    integrator;
  uint32_t latestUpdateMs;
  bool     isFilterOpen;
} OutlierFilterTdoaState_t;
typedef struct {
  float a1;
  float a2;
  float b0;
  float b1;
  float b2;
  float delay_element_1;
  float delay_element_2;
} lpf2pData;

// --------------------------------------------------------------------------------------
// kalman_core
typedef struct {
  float    S[9];
  float    q[4];
  float    R[3][3];
  float    P[9][9];
  float    baroReferenceHeight;
  float    initialQuaternion[4];
  bool     isUpdated;
  uint32_t lastPredictionMs;
  uint32_t lastProcessNoiseUpdateMs;
} kalmanCoreData_t;
typedef struct {
  float stdDevInitialPosition_xy;
  float stdDevInitialPosition_z;
  float stdDevInitialVelocity;
  float stdDevInitialAttitude_rollpitch;
  float stdDevInitialAttitude_yaw;
  float procNoiseAcc_xy;
  float procNoiseAcc_z;
  float procNoiseVel;
  float procNoisePos;
  float procNoiseAtt;
  float measNoiseBaro;
  float measNoiseGyro_rollpitch;
  float measNoiseGyro_yaw;
  float initialX;
  float initialY;
  float initialZ;
  float initialYaw;
  float attitudeReversion;
  float dragB_x;
  float dragB_y;
  float dragB_z;
  float cop_x;
  float cop_y;
  float cop_z;
} kalmanCoreParams_t;

// --------------------------------------------------------------------------------------- functions
float        fsqr(float x);
float        radians(float degrees);
float        degrees(float radians);
float        clamp(float value, float min, float max);
bool         fcloseulps(float a, float b, int ulps);
float        normalize_radians(float radians);
float        shortest_signed_angle_radians(float start, float goal);
struct vec   mkvec(float x, float y, float z);
struct vec   vrepeat(float x);
struct vec   vzero(void);
struct vec   vbasis(int i);
struct vec   vscl(float s, struct vec v);
struct vec   vneg(struct vec v);
struct vec   vdiv(struct vec v, float s);
struct vec   vadd(struct vec a, struct vec b);
struct vec   vsub(struct vec a, struct vec b);
struct vec   vadd3(struct vec a, struct vec b, struct vec c);
struct vec   vadd4(struct vec a, struct vec b, struct vec c, struct vec d);
struct vec   vsub2(struct vec a, struct vec b, struct vec c);
float        vdot(struct vec a, struct vec b);
struct vec   vcross(struct vec a, struct vec b);
float        vmag2(struct vec v);
float        vmag(struct vec v);
float        vdist2(struct vec a, struct vec b);
float        vdist(struct vec a, struct vec b);
struct vec   vnormalize(struct vec v);
struct vec   vclampnorm(struct vec v, float max);
struct vec   vprojectunit(struct vec a, struct vec b_unit);
struct vec   vorthunit(struct vec a, struct vec b_unit);
struct vec   veltmul(struct vec a, struct vec b);
struct vec   veltdiv(struct vec a, struct vec b);
struct vec   veltrecip(struct vec a);
struct vec   vabs(struct vec v);
struct vec   vmin(struct vec a, struct vec b);
struct vec   vmax(struct vec a, struct vec b);
struct vec   vclamp(struct vec v, struct vec lower, struct vec upper);
struct vec   vclampabs(struct vec v, struct vec abs_upper);
float        vmaxelt(struct vec v);
float        vminelt(struct vec v);
float        vnorm1(struct vec v);
bool         veq(struct vec a, struct vec b);
bool         vneq(struct vec a, struct vec b);
bool         veqepsilon(struct vec a, struct vec b, float epsilon);
bool         vless(struct vec a, struct vec b);
bool         vleq(struct vec a, struct vec b);
bool         vgreater(struct vec a, struct vec b);
bool         vgeq(struct vec a, struct vec b);
bool         visnan(struct vec v);
struct vec   vload(const double *d);
void         vstore(struct vec v, double *d);
struct vec   vloadf(const float *f);
void         vstoref(struct vec v, float *f);
float        vindex(struct vec v, int i);
struct mat33 mzero(void);
struct mat33 mdiag(float a, float b, float c);
struct mat33 meyescl(float a);
struct mat33 meye(void);
struct mat33 mcolumns(struct vec a, struct vec b, struct vec c);
struct mat33 mrows(struct vec a, struct vec b, struct vec c);
struct mat33 mcrossmat(struct vec v);
struct vec   mcolumn(struct mat33 m, int column);
struct vec   mrow(struct mat33 m, int row);
struct mat33 mtranspose(struct mat33 m);
struct mat33 mscl(float s, struct mat33 a);
struct mat33 mneg(struct mat33 a);
struct mat33 madd(struct mat33 a, struct mat33 b);
struct mat33 msub(struct mat33 a, struct mat33 b);
struct mat33 madd3(struct mat33 a, struct mat33 b, struct mat33 c);
struct vec   mvmul(struct mat33 a, struct vec v);
struct mat33 mmul(struct mat33 a, struct mat33 b);
struct mat33 maddridge(struct mat33 a, float d);
bool         misnan(struct mat33 m);
void         set_block33_rowmaj(float *block, int stride, const struct mat33 *m);
struct mat33 maxisangle(struct vec axis_unit, float angle);
struct mat33 mrotx(float angle);
struct mat33 mroty(float angle);
struct mat33 mrotz(float angle);
struct quat  mkquat(float x, float y, float z, float w);
struct quat  quatvw(struct vec v, float w);
struct quat  qeye(void);
struct quat  qaxisangle(struct vec axis, float angle);
struct quat  qvectovec(struct vec a_unit, struct vec b_unit);
struct quat  rpy2quat(struct vec rpy);
struct quat  rpy2quat_small(struct vec rpy);
struct quat  mat2quat(struct mat33 m);
struct vec   quat2rpy(struct quat q);
struct vec   quat2axis(struct quat q);
float        quat2angle(struct quat q);
struct vec   quatimagpart(struct quat q);
struct mat33 quat2rotmat(struct quat q);
struct vec   qvrot(struct quat q, struct vec v);
struct quat  qqmul(struct quat q, struct quat p);
struct quat  qinv(struct quat q);
struct quat  qneg(struct quat q);
struct quat  qposreal(struct quat q);
float        qdot(struct quat a, struct quat b);
float        qanglebetween(struct quat a, struct quat b);
bool         qeq(struct quat a, struct quat b);
struct quat  qnormalize(struct quat q);
struct quat  quat_gyro_update(struct quat q, struct vec gyro, float dt);
struct quat  qnlerp(struct quat a, struct quat b, float t);
struct quat  qslerp(struct quat a, struct quat b, float t);
struct quat  qload(const double *d);
void         qstore(struct quat q, double *d);
struct quat  qloadf(const float *f);
void         qstoref(struct quat q, float *f);
struct vec   vprojecthalfspace(struct vec x, struct vec a_unit, float b);
bool         vinpolytope(struct vec v, const float A[], const float b[], int n, float tolerance);
float        rayintersectpolytope(struct vec origin, struct vec direction, const float A[],
                                  const float b[], int n, int *active_row);
struct vec   vprojectpolytope(struct vec v, const float A[], const float b[], float work[], int n,
                              float tolerance, int maxiters);
float        polyval(const float p[8], float t);
void         polylinear(float p[8], float duration, float x0, float x1);
void         polybezier(float p[8], float duration, const float *x, int dim);
void         poly5(float p[8], float T, float x0, float v0, float a0, float xf, float vf, float af);
void         polyscale(float p[8], float s);
void         polyder(float p[8]);
void         polystretchtime(float p[8], float s);
void         polyreflect(float p[8]);
struct poly4d poly4d_zero(float duration);
struct poly4d poly4d_linear(float duration, struct vec p0, struct vec p1, float yaw0, float yaw1);
void          poly4d_scale(struct poly4d *p, float x, float y, float z, float yaw);
void          poly4d_shift(struct poly4d *p, float x, float y, float z, float yaw);
void          poly4d_shift_vec(struct poly4d *p, struct vec pos, float yaw);
void          poly4d_stretchtime(struct poly4d *p, float s);
void          polyder4d(struct poly4d *p);
float         poly4d_max_accel_approx(const struct poly4d *p);
struct traj_eval poly4d_eval(const struct poly4d *p, float t);
struct traj_eval traj_eval_zero(void);
struct traj_eval traj_eval_invalid(void);
bool             is_traj_eval_valid(const struct traj_eval *ev);
float            piecewise_duration(const struct piecewise_traj *traj);
void piecewise_plan_5th_order(struct piecewise_traj *pp, float duration, struct vec p0, float y0,
                              struct vec v0, float dy0, struct vec a0, struct vec p1, float y1,
                              struct vec v1, float dy1, struct vec a1);
void piecewise_plan_7th_order_no_jerk(struct piecewise_traj *pp, float duration, struct vec p0,
                                      float y0, struct vec v0, float dy0, struct vec a0,
                                      struct vec p1, float y1, struct vec v1, float dy1,
                                      struct vec a1);
struct traj_eval piecewise_eval(const struct piecewise_traj *traj, float t);
struct traj_eval piecewise_eval_reversed(const struct piecewise_traj *traj, float t);
bool             piecewise_is_finished(const struct piecewise_traj *traj, float t);
struct traj_eval piecewise_compressed_eval(struct piecewise_traj_compressed *traj, float t);
float            piecewise_compressed_duration(const struct piecewise_traj_compressed *traj);
bool piecewise_compressed_is_finished(const struct piecewise_traj_compressed *traj, float t);
void plan_init(struct planner *p);
void plan_stop(struct planner *p);
bool plan_is_stopped(struct planner *p);
void plan_disable(struct planner *p);
bool plan_is_disabled(struct planner *p);
bool plan_is_finished(struct planner *p, float t);
struct traj_eval plan_current_goal(struct planner *p, float t);
int plan_takeoff(struct planner *p, struct vec curr_pos, float curr_yaw, float hover_height,
                 float hover_yaw, float duration, float t);
int plan_land(struct planner *p, struct vec curr_pos, float curr_yaw, float hover_height,
              float hover_yaw, float duration, float t);
int cf_upstream_plan_go_to(struct planner *p, bool relative, bool linear, struct vec hover_pos,
                           float hover_yaw, float duration, float t);
int cf_upstream_plan_go_to_from(struct planner *p, const struct traj_eval *curr_eval, bool relative,
                                bool linear, struct vec hover_pos, float hover_yaw, float duration,
                                float t);
int plan_spiral(struct planner *p, bool sideways, bool clockwise, float spiral_angle, float radius0,
                float radiusF, float ascent, float duration, float t);
int plan_spiral_from(struct planner *p, const struct traj_eval *curr_eval, bool sideways,
                     bool clockwise, float spiral_angle, float radius0, float radiusF, float ascent,
                     float duration, float t);
int cf_upstream_plan_start_trajectory(struct planner *p, struct piecewise_traj *trajectory,
                                      bool reversed, bool relative, bool relative_yaw,
                                      struct vec start_from, float start_yaw);
int plan_start_compressed_trajectory(struct planner                   *p,
                                     struct piecewise_traj_compressed *trajectory, bool relative,
                                     struct vec start_from);
void  controllerPidInit(void);
bool  controllerPidTest(void);
void  controllerPid(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                    const state_t *state, uint32_t stabilizerStep);
void  controllerMellingerInit(controllerMellinger_t *self);
bool  controllerMellingerTest(controllerMellinger_t *self);
void  controllerMellinger(controllerMellinger_t *self, control_t *control,
                          const setpoint_t *setpoint, const sensorData_t *sensors,
                          const state_t *state, uint32_t stabilizerStep);
void  controllerBrescianiniInit(void);
bool  controllerBrescianiniTest(void);
void  controllerBrescianini(control_t *control, const setpoint_t *setpoint,
                            const sensorData_t *sensors, const state_t *state,
                            uint32_t stabilizerStep);
void  controllerLeeInit(controllerLee_t *self);
void  controllerLeeReset(controllerLee_t *self);
void  controllerLee(controllerLee_t *self, control_t *control, const setpoint_t *setpoint,
                    const sensorData_t *sensors, const state_t *state, uint32_t stabilizerStep);
void  powerDistributionInit(void);
bool  powerDistributionTest(void);
void  powerDistribution(const control_t *control, motors_thrust_uncapped_t *motorThrustUncapped);
bool  cf_upstream_powerDistributionCap(const motors_thrust_uncapped_t *motorThrustUncapped,
                                       motors_thrust_pwm_t            *motorPwm);
int   powerDistributionMotorType(uint32_t id);
int   powerDistributionStopRatio(uint32_t id);
int   powerDistributionGetIdleThrust(void);
float powerDistributionGetMaxThrust(void);
void  collisionAvoidanceUpdateSetpointCore(const collision_avoidance_params_t *params,
                                           collision_avoidance_state_t *collisionState, int nOthers,
                                           const float *otherPositions, float *workspace,
                                           setpoint_t *setpoint, const sensorData_t *sensorData,
                                           const state_t *state);
void  axis3fSubSamplerInit(Axis3fSubSampler_t *s, float conversionFactor);
void  axis3fSubSamplerAccumulate(Axis3fSubSampler_t *s, const Axis3f *sample);
Axis3f *axis3fSubSamplerFinalize(Axis3fSubSampler_t *s);
void    outlierFilterTdoaReset(OutlierFilterTdoaState_t *s);
bool outlierFilterTdoaValidateIntegrator(OutlierFilterTdoaState_t *s, const tdoaMeasurement_t *tdoa,
                                         float error, uint32_t nowMs);
void kalmanCoreDefaultParams(kalmanCoreParams_t *params);
void kalmanCoreInit(kalmanCoreData_t *self, const kalmanCoreParams_t *params, uint32_t nowMs);
void cf_upstream_kalmanCorePredict(kalmanCoreData_t *self, const kalmanCoreParams_t *params,
                                   const Axis3f *acc, const Axis3f *gyro, uint32_t nowMs,
                                   bool quadIsFlying);
void kalmanCoreAddProcessNoise(kalmanCoreData_t *self, const kalmanCoreParams_t *params,
                               uint32_t nowMs);
bool kalmanCoreFinalize(kalmanCoreData_t *self);
void kalmanCoreExternalizeState(const kalmanCoreData_t *self, state_t *state, const Axis3f *acc);
void kalmanCoreDecoupleXY(kalmanCoreData_t *self);
void cf_upstream_kalmanCoreScalarUpdate(kalmanCoreData_t *self, const float Hm[9], float error,
                                        float stdMeasNoise);
void cf_upstream_kalmanCoreUpdateWithPKE(kalmanCoreData_t *self, const float Hm[9],
                                         const float Km[9], const float P_w_m[9][9], float error);
void kalmanCoreUpdateWithBaro(kalmanCoreData_t *self, const kalmanCoreParams_t *params,
                              float baroAsl, bool quadIsFlying);
void kalmanCoreUpdateWithTdoa(kalmanCoreData_t *self, const tdoaMeasurement_t *tdoa, uint32_t nowMs,
                              OutlierFilterTdoaState_t *outlierFilterState);
float kalmanCoreTdoaInnovation(const kalmanCoreData_t *self, const tdoaMeasurement_t *tdoa);
void  kalmanCoreUpdateWithTdoaUnfiltered(kalmanCoreData_t *self, const tdoaMeasurement_t *tdoa);
void  kalmanCoreUpdateWithPosition(kalmanCoreData_t *self, const positionMeasurement_t *xyz);
void  kalmanCoreUpdateWithPose(kalmanCoreData_t *self, const poseMeasurement_t *pose);
void  kalmanCoreUpdateWithDistance(kalmanCoreData_t *self, const distanceMeasurement_t *d);
void  kalmanCoreUpdateWithTof(kalmanCoreData_t *self, const tofMeasurement_t *tof);
void  kalmanCoreUpdateWithFlow(kalmanCoreData_t *self, const flowMeasurement_t *flow,
                               const Axis3f *gyro);
void  kalmanCoreUpdateWithAbsoluteHeight(kalmanCoreData_t *self, const heightMeasurement_t *height);
void  kalmanCoreUpdateWithYawError(kalmanCoreData_t *self, const yawErrorMeasurement_t *error);
void  lpf2pInit(lpf2pData *lpfData, float sample_freq, float cutoff_freq);
void  lpf2pSetCutoffFreq(lpf2pData *lpfData, float sample_freq, float cutoff_freq);
float lpf2pApply(lpf2pData *lpfData, float sample);
float lpf2pReset(lpf2pData *lpfData, float sample);
void cf_upstream_piecewise_compressed_load(struct piecewise_traj_compressed *traj, const void *data,
                                           uint32_t size);
const char *cf_upstream_take_assertion(void);

// --------------------------------------------------------------------------------------- constants
#define CF_UPSTREAM_HAS_LINEAR ...
#define CF_UPSTREAM_HAS_RELATIVE_YAW ...
#define modeDisable ...
#define modeAbs ...
#define modeVelocity ...
#define controlModeLegacy ...
#define controlModeForceTorque ...
#define controlModeForce ...
#define controlModePWM ...
#define MeasurementSourceLocationService ...
#define MeasurementSourceLighthouse ...
#define TRAJECTORY_STATE_IDLE ...
#define TRAJECTORY_STATE_FLYING ...
#define TRAJECTORY_STATE_LANDING ...
#define TRAJECTORY_STATE_DISABLED ...
#define TRAJECTORY_TYPE_PIECEWISE ...
#define TRAJECTORY_TYPE_PIECEWISE_COMPRESSED ...
#define KC_STATE_X ...
#define KC_STATE_Y ...
#define KC_STATE_Z ...
#define KC_STATE_PX ...
#define KC_STATE_PY ...
#define KC_STATE_PZ ...
#define KC_STATE_D0 ...
#define KC_STATE_D1 ...
#define KC_STATE_D2 ...
#define KC_STATE_DIM ...
#define STABILIZER_NR_OF_MOTORS ...
#define RATE_1000_HZ ...
#define RATE_500_HZ ...
#define RATE_250_HZ ...
#define RATE_100_HZ ...
#define RATE_50_HZ ...
#define RATE_25_HZ ...
#define RATE_MAIN_LOOP ...
#define ATTITUDE_RATE ...
#define POSITION_RATE ...
#define RATE_HL_COMMANDER ...
#define RATE_SUPERVISOR ...
#define PP_DEGREE ...
#define PP_SIZE ...
