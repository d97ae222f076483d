// Take-off, landing, go-to, spirals and uploaded trajectories: port 8, a task that obeys the
// packets one after the other.
#include "crtp_commander_high_level.h"

#include <errno.h>
#include <math.h>
#include <string.h>

#include "FreeRTOS.h"
#include "commander.h"
#include "crtp.h"
#include "log.h"
#include "mem.h"
#include "param.h"
#include "planner.h"
#include "semphr.h"
#include "stabilizer.h"
#include "stabilizer_types.h"
#include "static_mem.h"
#include "task.h"
#include "usec_time.h"

#define ALL_GROUPS 0
#define TRAJECTORY_MEMORY_SIZE 4096
#define COMPRESSED_START_BYTES 8

enum TrajectoryLocation_e {
  TRAJECTORY_LOCATION_INVALID = 0,
  TRAJECTORY_LOCATION_MEM     = 1,
};

struct trajectoryDescription {
  uint8_t trajectoryLocation;
  uint8_t trajectoryType;
  union {
    struct {
      uint32_t offset;  // [bytes], in trajectories_memory
      uint8_t  n_pieces;
    } __attribute__((packed)) mem;
  } trajectoryIdentifier;
} __attribute__((packed));

static uint8_t __attribute__((aligned(4))) trajectories_memory[TRAJECTORY_MEMORY_SIZE];
static struct trajectoryDescription        trajectory_descriptions[NUM_TRAJECTORY_DEFINITIONS];

static bool           isInit;
static struct planner planner;
static uint8_t        group_mask;
static bool           isBlocked;

// where a plan starts: the last setpoint of an active one, else the vehicle
static struct vec pos;  // [m]
static struct vec vel;  // [m/s]
static float      yaw;  // [rad]

static struct piecewise_traj            trajectory;
static struct piecewise_traj_compressed compressed_trajectory;

static float defaultTakeoffVelocity = 0.5f;  // [m/s]
static float defaultLandingVelocity = 0.5f;

static SemaphoreHandle_t lockTraj;
static StaticSemaphore_t lockTrajBuffer;

STATIC_MEM_TASK_ALLOC(crtpCommanderHighLevelTask, CMD_HIGH_LEVEL_TASK_STACKSIZE);
static void crtpCommanderHighLevelTask(void *prm);

// -------------------------------------------------------------------------------------- records

enum TrajectoryCommand_e {
  COMMAND_SET_GROUP_MASK        = 0,
  COMMAND_TAKEOFF               = 1,
  COMMAND_LAND                  = 2,
  COMMAND_STOP                  = 3,
  COMMAND_GO_TO                 = 4,
  COMMAND_START_TRAJECTORY      = 5,
  COMMAND_DEFINE_TRAJECTORY     = 6,
  COMMAND_TAKEOFF_2             = 7,
  COMMAND_LAND_2                = 8,
  COMMAND_TAKEOFF_WITH_VELOCITY = 9,
  COMMAND_LAND_WITH_VELOCITY    = 10,
#if MINIATURE_RELEASE >= 202502
  COMMAND_SPIRAL  = 11,
  COMMAND_GO_TO_2 = 12,
#endif
#if MINIATURE_RELEASE >= 202608
  COMMAND_START_TRAJECTORY_2 = 13,
#endif
};

struct data_set_group_mask {
  uint8_t groupMask;
} __attribute__((packed));

// take-off and landing, which turn to yaw 0
struct data_vertical {
  uint8_t groupMask;
  float   height;    // [m]
  float   duration;  // [s]
} __attribute__((packed));

struct data_vertical_2 {
  uint8_t groupMask;
  float   height;
  float   yaw;  // [rad]
  bool    useCurrentYaw;
  float   duration;
} __attribute__((packed));

struct data_vertical_with_velocity {
  uint8_t groupMask;
  float   height;
  bool    heightIsRelative;
  float   yaw;
  bool    useCurrentYaw;
  float   velocity;  // [m/s]
} __attribute__((packed));

struct data_stop {
  uint8_t groupMask;
} __attribute__((packed));

struct data_go_to {
  uint8_t groupMask;
  uint8_t relative;
  float   x;  // [m]
  float   y;
  float   z;
  float   yaw;
  float   duration;
} __attribute__((packed));

#if MINIATURE_RELEASE >= 202502
struct data_go_to_2 {
  uint8_t groupMask;
  uint8_t relative;
  uint8_t linear;
  float   x;
  float   y;
  float   z;
  float   yaw;
  float   duration;
} __attribute__((packed));

struct data_spiral {
  uint8_t groupMask;
  uint8_t sideways;
  uint8_t clockwise;
  float   phi;  // [rad]
  float   r0;   // [m]
  float   rf;
  float   dz;
  float   duration;
} __attribute__((packed));
#endif

struct data_start_trajectory {
  uint8_t groupMask;
  uint8_t relative;
  uint8_t reversed;
  uint8_t trajectoryId;
  float   timescale;
} __attribute__((packed));

#if MINIATURE_RELEASE >= 202608
struct data_start_trajectory_2 {
  uint8_t groupMask;
  uint8_t relativePosition;
  uint8_t relativeYaw;
  uint8_t reversed;
  uint8_t trajectoryId;
  float   timescale;
} __attribute__((packed));
#endif

struct data_define_trajectory {
  uint8_t  trajectoryId;
  uint8_t  trajectoryLocation;
  uint8_t  trajectoryType;
  uint32_t offset;
  uint8_t  n_pieces;
} __attribute__((packed));

// --------------------------------------------------------------------------------------- helpers

static float now(void) {
  return usecTimestamp() / 1e6;
}

static bool isInGroup(uint8_t g) {
  return g == ALL_GROUPS || (g & group_mask) != 0;
}

static bool isPositive(float value) {
  return isfinite(value) && value > 0.0f;
}

static void lock(void) {
  xSemaphoreTake(lockTraj, portMAX_DELAY);
}

static void unlock(void) {
  xSemaphoreGive(lockTraj);
}

static bool isInMemory(uint32_t offset, uint32_t length) {
  return length <= TRAJECTORY_MEMORY_SIZE && offset <= TRAJECTORY_MEMORY_SIZE - length;
}

static struct traj_eval startFromHere(void) {
  const struct traj_eval ev = {.pos = pos, .vel = vel, .yaw = yaw};
  return ev;
}

// --------------------------------------------------------------------------------------- plans

typedef int (*plan_vertical_t)(struct planner *p, struct vec curr_pos, float curr_yaw,
                               float hover_height, float hover_yaw, float duration, float t);

static int planVertical(plan_vertical_t plan, float height, float duration, float hoverYaw,
                        bool useCurrentYaw) {
  const float goalYaw = useCurrentYaw ? yaw : hoverYaw;
  if (!isfinite(height) || !isfinite(duration) || (!useCurrentYaw && !isfinite(hoverYaw))) {
    return ENOEXEC;
  }
  if (isBlocked) {
    return EBUSY;
  }
  lock();
  const int result = plan(&planner, pos, yaw, height, goalYaw, duration, now());
  unlock();
  return result;
}

static int vertical(plan_vertical_t plan, float height, float duration, float hoverYaw,
                    bool useCurrentYaw) {
  if (!isPositive(duration)) {
    return ENOEXEC;
  }
  return planVertical(plan, height, duration, hoverYaw, useCurrentYaw);
}

static int verticalWithVelocity(plan_vertical_t plan, float height, float velocity,
                                float defaultVelocity, float hoverYaw, bool useCurrentYaw) {
  const float speed = velocity > 0.0f ? velocity : defaultVelocity;
  if (!isfinite(velocity) || !isPositive(speed)) {
    return ENOEXEC;
  }
  return planVertical(plan, height, fabsf(height - pos.z) / speed, hoverYaw, useCurrentYaw);
}

static int goTo(float x, float y, float z, float hoverYaw, float duration, bool relative,
                bool linear) {
  const struct vec hoverPos = mkvec(x, y, z);
  if (!isfinite(x) || !isfinite(y) || !isfinite(z) || !isfinite(hoverYaw) ||
      !isPositive(duration)) {
    return ENOEXEC;
  }
  if (isBlocked) {
    return EBUSY;
  }
  int result;
  lock();
  const float t = now();
  if (plan_is_disabled(&planner) || plan_is_stopped(&planner)) {
    const struct traj_eval ev = startFromHere();
#if MINIATURE_RELEASE >= 202502
    result = plan_go_to_from(&planner, &ev, relative, linear, hoverPos, hoverYaw, duration, t);
  } else {
    result = plan_go_to(&planner, relative, linear, hoverPos, hoverYaw, duration, t);
#else
    (void)linear;
    result = plan_go_to_from(&planner, &ev, relative, hoverPos, hoverYaw, duration, t);
  } else {
    result = plan_go_to(&planner, relative, hoverPos, hoverYaw, duration, t);
#endif
  }
  unlock();
  return result;
}

#if MINIATURE_RELEASE >= 202502
static int flySpiral(bool sideways, bool clockwise, float phi, float r0, float rf, float dz,
                     float duration) {
  if (!isfinite(phi) || !isfinite(r0) || !isfinite(rf) || !isfinite(dz) || !isPositive(duration)) {
    return ENOEXEC;
  }
  if (isBlocked) {
    return EBUSY;
  }
  lock();
  const struct traj_eval ev = startFromHere();
  const int              result =
      plan_spiral_from(&planner, &ev, sideways, clockwise, phi, r0, rf, dz, duration, now());
  unlock();
  return result;
}
#endif

static int startPieces(const struct trajectoryDescription *description, float timescale,
                       bool relativePosition, bool relativeYaw, bool reversed, float t) {
  trajectory.t_begin   = t;
  trajectory.timescale = timescale;
  trajectory.n_pieces  = description->trajectoryIdentifier.mem.n_pieces;
  trajectory.pieces =
      (struct poly4d *)&trajectories_memory[description->trajectoryIdentifier.mem.offset];
#if MINIATURE_RELEASE >= 202608
  return plan_start_trajectory(&planner, &trajectory, reversed, relativePosition, relativeYaw, pos,
                               yaw);
#else
  (void)relativeYaw;
  return plan_start_trajectory(&planner, &trajectory, reversed, relativePosition, pos);
#endif
}

static int startTrajectory(uint8_t id, float timescale, bool relativePosition, bool relativeYaw,
                           bool reversed) {
  if (!isPositive(timescale)) {
    return ENOEXEC;
  }
  if (isBlocked) {
    return EBUSY;
  }
  if (!crtpCommanderHighLevelIsTrajectoryDefined(id)) {
    return 0;
  }

  const struct trajectoryDescription *description = &trajectory_descriptions[id];
  int                                 result      = 0;
  lock();
  const float t = now();
  if (description->trajectoryType == CRTP_CHL_TRAJECTORY_TYPE_POLY4D) {
    result = startPieces(description, timescale, relativePosition, relativeYaw, reversed, t);
  } else if (timescale != 1.0f || reversed) {
    result = ENOEXEC;
  } else {
    piecewise_compressed_load(&compressed_trajectory,
                              &trajectories_memory[description->trajectoryIdentifier.mem.offset]);
    compressed_trajectory.t_begin = t;
    result =
        plan_start_compressed_trajectory(&planner, &compressed_trajectory, relativePosition, pos);
  }
  unlock();
  return result;
}

static int defineTrajectory(uint8_t id, uint8_t type, uint32_t offset, uint8_t nPieces) {
  const bool isCompressed = type == CRTP_CHL_TRAJECTORY_TYPE_POLY4D_COMPRESSED;
  if (id >= NUM_TRAJECTORY_DEFINITIONS ||
      (type != CRTP_CHL_TRAJECTORY_TYPE_POLY4D && !isCompressed)) {
    return ENOEXEC;
  }
  const uint32_t bytes = isCompressed ? COMPRESSED_START_BYTES : nPieces * sizeof(struct poly4d);
  if (!isInMemory(offset, bytes) || (!isCompressed && (nPieces == 0 || offset % 4 != 0))) {
    return ENOEXEC;
  }
  struct trajectoryDescription *description      = &trajectory_descriptions[id];
  description->trajectoryLocation                = TRAJECTORY_LOCATION_MEM;
  description->trajectoryType                    = type;
  description->trajectoryIdentifier.mem.offset   = offset;
  description->trajectoryIdentifier.mem.n_pieces = nPieces;
  return 0;
}

// --------------------------------------------------------------------------------------- packets

static int set_group_mask(const struct data_set_group_mask *data) {
  group_mask = data->groupMask;
  return 0;
}

static int takeoff(const struct data_vertical *data) {
  return isInGroup(data->groupMask) ? vertical(plan_takeoff, data->height, data->duration, 0, false)
                                    : 0;
}

static int land(const struct data_vertical *data) {
  return isInGroup(data->groupMask) ? vertical(plan_land, data->height, data->duration, 0, false)
                                    : 0;
}

static int takeoff2(const struct data_vertical_2 *data) {
  return isInGroup(data->groupMask)
             ? vertical(plan_takeoff, data->height, data->duration, data->yaw, data->useCurrentYaw)
             : 0;
}

static int land2(const struct data_vertical_2 *data) {
  return isInGroup(data->groupMask)
             ? vertical(plan_land, data->height, data->duration, data->yaw, data->useCurrentYaw)
             : 0;
}

static int takeoff_with_velocity(const struct data_vertical_with_velocity *data) {
  if (!isInGroup(data->groupMask)) {
    return 0;
  }
  const float height = data->heightIsRelative ? data->height + pos.z : data->height;
  return verticalWithVelocity(plan_takeoff, height, data->velocity, defaultTakeoffVelocity,
                              data->yaw, data->useCurrentYaw);
}

static int land_with_velocity(const struct data_vertical_with_velocity *data) {
  if (!isInGroup(data->groupMask)) {
    return 0;
  }
  const float height = data->heightIsRelative ? pos.z - data->height : data->height;
  return verticalWithVelocity(plan_land, height, data->velocity, defaultLandingVelocity, data->yaw,
                              data->useCurrentYaw);
}

static int stop(const struct data_stop *data) {
  if (isInGroup(data->groupMask)) {
    lock();
    plan_stop(&planner);
    unlock();
  }
  return 0;
}

static int go_to(const struct data_go_to *data) {
  return isInGroup(data->groupMask)
             ? goTo(data->x, data->y, data->z, data->yaw, data->duration, data->relative, false)
             : 0;
}

#if MINIATURE_RELEASE >= 202502
static int go_to_2(const struct data_go_to_2 *data) {
  return isInGroup(data->groupMask) ? goTo(data->x, data->y, data->z, data->yaw, data->duration,
                                           data->relative, data->linear)
                                    : 0;
}

static int spiral(const struct data_spiral *data) {
  return isInGroup(data->groupMask) ? flySpiral(data->sideways, data->clockwise, data->phi,
                                                data->r0, data->rf, data->dz, data->duration)
                                    : 0;
}
#endif

static int start_trajectory(const struct data_start_trajectory *data) {
  return isInGroup(data->groupMask) ? startTrajectory(data->trajectoryId, data->timescale,
                                                      data->relative, false, data->reversed)
                                    : 0;
}

#if MINIATURE_RELEASE >= 202608
static int start_trajectory_2(const struct data_start_trajectory_2 *data) {
  return isInGroup(data->groupMask)
             ? startTrajectory(data->trajectoryId, data->timescale, data->relativePosition,
                               data->relativeYaw, data->reversed)
             : 0;
}
#endif

static int define_trajectory(const struct data_define_trajectory *data) {
  if (data->trajectoryLocation != TRAJECTORY_LOCATION_MEM) {
    return ENOEXEC;
  }
  return defineTrajectory(data->trajectoryId, data->trajectoryType, data->offset, data->n_pieces);
}

// Obeys a record of so many bytes. One that is too short is refused.
static int handleCommand(enum TrajectoryCommand_e command, const uint8_t *data, size_t size) {
#define OBEY(FUNCTION, RECORD) \
  return size < sizeof(struct RECORD) ? ENOEXEC : FUNCTION((const struct RECORD *)data);

  switch (command) {
    case COMMAND_SET_GROUP_MASK:
      OBEY(set_group_mask, data_set_group_mask)
    case COMMAND_TAKEOFF:
      OBEY(takeoff, data_vertical)
    case COMMAND_LAND:
      OBEY(land, data_vertical)
    case COMMAND_STOP:
      OBEY(stop, data_stop)
    case COMMAND_GO_TO:
      OBEY(go_to, data_go_to)
    case COMMAND_START_TRAJECTORY:
      OBEY(start_trajectory, data_start_trajectory)
    case COMMAND_DEFINE_TRAJECTORY:
      OBEY(define_trajectory, data_define_trajectory)
    case COMMAND_TAKEOFF_2:
      OBEY(takeoff2, data_vertical_2)
    case COMMAND_LAND_2:
      OBEY(land2, data_vertical_2)
    case COMMAND_TAKEOFF_WITH_VELOCITY:
      OBEY(takeoff_with_velocity, data_vertical_with_velocity)
    case COMMAND_LAND_WITH_VELOCITY:
      OBEY(land_with_velocity, data_vertical_with_velocity)
#if MINIATURE_RELEASE >= 202502
    case COMMAND_SPIRAL:
      OBEY(spiral, data_spiral)
    case COMMAND_GO_TO_2:
      OBEY(go_to_2, data_go_to_2)
#endif
#if MINIATURE_RELEASE >= 202608
    case COMMAND_START_TRAJECTORY_2:
      OBEY(start_trajectory_2, data_start_trajectory_2)
#endif
    default:
      return ENOEXEC;
  }
#undef OBEY
}

static void crtpCommanderHighLevelTask(void *prm) {
  static CRTPPacket p;
  (void)prm;

  crtpInitTaskQueue(CRTP_PORT_SETPOINT_HL);
  while (true) {
    crtpReceivePacketBlock(CRTP_PORT_SETPOINT_HL, &p);
    if (p.size == 0) {
      continue;
    }
    for (int i = p.size; i < 3; i++) {
      p.data[i] = 0;
    }
    const int result = handleCommand(p.data[0], &p.data[1], p.size - 1);
    p.data[3]        = result;
    p.size           = 4;
    crtpSendPacketBlock(&p);
  }
}

// ---------------------------------------------------------------------------------------- memory

static uint32_t handleMemGetSize(const uint8_t internal_id) {
  (void)internal_id;
  return crtpCommanderHighLevelTrajectoryMemSize();
}

static bool handleMemRead(const uint8_t internal_id, const uint32_t memAddr, const uint8_t readLen,
                          uint8_t *buffer) {
  (void)internal_id;
  return crtpCommanderHighLevelReadTrajectory(memAddr, readLen, buffer);
}

static bool handleMemWrite(const uint8_t internal_id, const uint32_t memAddr,
                           const uint8_t writeLen, const uint8_t *buffer) {
  (void)internal_id;
  return crtpCommanderHighLevelWriteTrajectory(memAddr, writeLen, buffer);
}

static const MemoryHandlerDef_t memDef = {
    .type    = MEM_TYPE_TRAJ,
    .getSize = handleMemGetSize,
    .read    = handleMemRead,
    .write   = handleMemWrite,
};

// ------------------------------------------------------------------------------ what others call

void crtpCommanderHighLevelInit(void) {
  if (isInit) {
    return;
  }
  memoryRegisterHandler(&memDef);
  plan_init(&planner);
  lockTraj = xSemaphoreCreateMutexStatic(&lockTrajBuffer);
  STATIC_MEM_TASK_CREATE(crtpCommanderHighLevelTask, crtpCommanderHighLevelTask,
                         CMD_HIGH_LEVEL_TASK_NAME, NULL, CMD_HIGH_LEVEL_TASK_PRI);
  pos       = vzero();
  vel       = vzero();
  yaw       = 0;
  isBlocked = false;
  isInit    = true;
}

void crtpCommanderHighLevelTellState(const state_t *state) {
  lock();
  pos = mkvec(state->position.x, state->position.y, state->position.z);
  vel = mkvec(state->velocity.x, state->velocity.y, state->velocity.z);
  yaw = radians(state->attitude.yaw);
  unlock();
}

// Yaw counts as it is written. A sum is finite only when all of its terms are.
static bool isValid(const struct traj_eval *ev) {
  const float sum = (ev->pos.x + ev->pos.y + ev->pos.z) + (ev->vel.x + ev->vel.y + ev->vel.z) +
                    (ev->acc.x + ev->acc.y + ev->acc.z) +
#if MINIATURE_RELEASE >= 202502
                    (ev->jerk.x + ev->jerk.y + ev->jerk.z) +
#endif
                    degrees(ev->yaw);
  return isfinite(sum);
}

static void writeSetpoint(setpoint_t *setpoint, const struct traj_eval *ev) {
  setpoint->position.x     = ev->pos.x;
  setpoint->position.y     = ev->pos.y;
  setpoint->position.z     = ev->pos.z;
  setpoint->velocity.x     = ev->vel.x;
  setpoint->velocity.y     = ev->vel.y;
  setpoint->velocity.z     = ev->vel.z;
  setpoint->acceleration.x = ev->acc.x;
  setpoint->acceleration.y = ev->acc.y;
  setpoint->acceleration.z = ev->acc.z;
#if MINIATURE_RELEASE >= 202512
  setpoint->jerk.x = ev->jerk.x;
  setpoint->jerk.y = ev->jerk.y;
  setpoint->jerk.z = ev->jerk.z;
#endif
  setpoint->attitude.yaw = degrees(ev->yaw);

  // a thrust without direction has no rates
#if MINIATURE_RELEASE >= 202502
  const struct vec omega = ev->omega;
#else
  const struct vec omega = ev->rates;
#endif
  const attitude_t rates = {
      .roll  = degrees(omega.x),
      .pitch = degrees(omega.y),
      .yaw   = degrees(omega.z),
  };
  const bool       exist = isfinite(rates.roll + rates.pitch + rates.yaw);
  const attitude_t none  = {.roll = 0.0f};
  setpoint->attitudeRate = exist ? rates : none;

  setpoint->mode.x     = modeAbs;
  setpoint->mode.y     = modeAbs;
  setpoint->mode.z     = modeAbs;
  setpoint->mode.roll  = modeDisable;
  setpoint->mode.pitch = modeDisable;
  setpoint->mode.yaw   = modeAbs;
  setpoint->mode.quat  = modeDisable;
}

bool crtpCommanderHighLevelGetSetpoint(setpoint_t *setpoint, const state_t *state,
                                       stabilizerStep_t stabilizerStep) {
  static const setpoint_t nullSetpoint;

  if (!RATE_DO_EXECUTE(RATE_HL_COMMANDER, stabilizerStep)) {
    return false;
  }

  lock();
  const struct traj_eval ev = plan_current_goal(&planner, now());
  unlock();

  if (plan_is_disabled(&planner) || plan_is_stopped(&planner)) {
    crtpCommanderHighLevelTellState(state);
    if (plan_is_stopped(&planner)) {
      *setpoint = nullSetpoint;
      return true;
    }
    return false;
  }
  if (!isValid(&ev)) {
    plan_disable(&planner);
    return false;
  }
  writeSetpoint(setpoint, &ev);
  pos = ev.pos;
  vel = ev.vel;
  yaw = ev.yaw;
  return true;
}

void crtpCommanderBlock(bool doBlock) {
  if (doBlock && !isBlocked) {
    if (!plan_is_disabled(&planner) && !plan_is_stopped(&planner)) {
      plan_stop(&planner);
    }
  }
  isBlocked = doBlock;
}

bool crtpCommanderHighLevelIsBlocked(void) {
  return isBlocked;
}

bool crtpCommanderHighLevelIsStopped(void) {
  return plan_is_stopped(&planner);
}

void crtpCommanderHighLevelDisable(void) {
  plan_disable(&planner);
}

int crtpCommanderHighLevelTakeoff(const float absoluteHeight_m, const float duration_s) {
  return vertical(plan_takeoff, absoluteHeight_m, duration_s, 0, true);
}

int crtpCommanderHighLevelTakeoffWithVelocity(const float height_m, const float velocity_m_s,
                                              bool relative) {
  return verticalWithVelocity(plan_takeoff, relative ? height_m + pos.z : height_m, velocity_m_s,
                              defaultTakeoffVelocity, 0, true);
}

int crtpCommanderHighLevelTakeoffYaw(const float absoluteHeight_m, const float duration_s,
                                     const float hoverYaw) {
  return vertical(plan_takeoff, absoluteHeight_m, duration_s, hoverYaw, false);
}

int crtpCommanderHighLevelLand(const float absoluteHeight_m, const float duration_s) {
  return vertical(plan_land, absoluteHeight_m, duration_s, 0, true);
}

int crtpCommanderHighLevelLandWithVelocity(const float height_m, const float velocity_m_s,
                                           bool relative) {
  return verticalWithVelocity(plan_land, relative ? pos.z - height_m : height_m, velocity_m_s,
                              defaultLandingVelocity, 0, true);
}

int crtpCommanderHighLevelLandYaw(const float absoluteHeight_m, const float duration_s,
                                  const float hoverYaw) {
  return vertical(plan_land, absoluteHeight_m, duration_s, hoverYaw, false);
}

int crtpCommanderHighLevelStop(void) {
  const struct data_stop all = {.groupMask = ALL_GROUPS};
  return stop(&all);
}

int crtpCommanderHighLevelGoTo(const float x, const float y, const float z, const float hoverYaw,
                               const float duration_s, const bool relative) {
  return goTo(x, y, z, hoverYaw, duration_s, relative, false);
}

#if MINIATURE_RELEASE >= 202502
int crtpCommanderHighLevelGoTo2(const float x, const float y, const float z, const float hoverYaw,
                                const float duration_s, const bool relative, const bool linear) {
  return goTo(x, y, z, hoverYaw, duration_s, relative, linear);
}

int crtpCommanderHighLevelSpiral(const float phi, const float r0, const float rf, const float dz,
                                 const float duration_s, const bool sideways) {
  return flySpiral(sideways, false, phi, r0, rf, dz, duration_s);
}

#endif
bool crtpCommanderHighLevelIsTrajectoryDefined(uint8_t trajectoryId) {
  return trajectoryId < NUM_TRAJECTORY_DEFINITIONS &&
         trajectory_descriptions[trajectoryId].trajectoryLocation != TRAJECTORY_LOCATION_INVALID;
}

#if MINIATURE_RELEASE >= 202608
int crtpCommanderHighLevelStartTrajectory(const uint8_t trajectoryId, const float timeScale,
                                          const bool relativePosition, const bool relativeYaw,
                                          const bool reversed) {
  return startTrajectory(trajectoryId, timeScale, relativePosition, relativeYaw, reversed);
}
#else
int crtpCommanderHighLevelStartTrajectory(const uint8_t trajectoryId, const float timeScale,
                                          const bool relative, const bool reversed) {
  return startTrajectory(trajectoryId, timeScale, relative, false, reversed);
}
#endif

int crtpCommanderHighLevelDefineTrajectory(const uint8_t                       trajectoryId,
                                           const crtpCommanderTrajectoryType_t type,
                                           const uint32_t offset, const uint8_t nPieces) {
  return defineTrajectory(trajectoryId, type, offset, nPieces);
}

uint32_t crtpCommanderHighLevelTrajectoryMemSize(void) {
  return sizeof(trajectories_memory);
}

bool crtpCommanderHighLevelWriteTrajectory(const uint32_t offset, const uint32_t length,
                                           const uint8_t *data) {
  if (!isInMemory(offset, length)) {
    return false;
  }
  memcpy(&trajectories_memory[offset], data, length);
  return true;
}

bool crtpCommanderHighLevelReadTrajectory(const uint32_t offset, const uint32_t length,
                                          uint8_t *destination) {
  if (!isInMemory(offset, length)) {
    return false;
  }
  memcpy(destination, &trajectories_memory[offset], length);
  return true;
}

bool crtpCommanderHighLevelIsTrajectoryFinished(void) {
  return plan_is_finished(&planner, now());
}

#if MINIATURE_RELEASE >= 202608
enum trajectory_state crtpCommanderHighLevelGetPlannerState(void) {
  return planner.state;
}

#endif
PARAM_GROUP_START(hlCommander)
PARAM_ADD_CORE(PARAM_FLOAT, vtoff, &defaultTakeoffVelocity)
PARAM_ADD_CORE(PARAM_FLOAT, vland, &defaultLandingVelocity)
PARAM_ADD_CORE(PARAM_UINT8, groupmask, &group_mask)
PARAM_GROUP_STOP(hlCommander)
