#ifndef CRTP_COMMANDER_HIGH_LEVEL_H_
#define CRTP_COMMANDER_HIGH_LEVEL_H_

#include <stdbool.h>
#include <stdint.h>

#include "planner.h"
#include "stabilizer_types.h"

#define NUM_TRAJECTORY_DEFINITIONS 31

typedef enum {
  CRTP_CHL_TRAJECTORY_TYPE_POLY4D            = 0,
  CRTP_CHL_TRAJECTORY_TYPE_POLY4D_COMPRESSED = 1,
} crtpCommanderTrajectoryType_t;

void crtpCommanderHighLevelInit(void);
bool crtpCommanderHighLevelGetSetpoint(setpoint_t *setpoint, const state_t *state,
                                       stabilizerStep_t stabilizerStep);
void crtpCommanderHighLevelTellState(const state_t *state);
void crtpCommanderBlock(bool doBlock);
bool crtpCommanderHighLevelIsBlocked(void);
bool crtpCommanderHighLevelIsStopped(void);
void crtpCommanderHighLevelDisable(void);

// Heights are absolute [m], durations [s], yaws [rad]. 0, or why nothing is flown.
int crtpCommanderHighLevelTakeoff(const float absoluteHeight_m, const float duration_s);
int crtpCommanderHighLevelTakeoffWithVelocity(const float height_m, const float velocity_m_s,
                                              bool relative);
int crtpCommanderHighLevelTakeoffYaw(const float absoluteHeight_m, const float duration_s,
                                     const float yaw);
int crtpCommanderHighLevelLand(const float absoluteHeight_m, const float duration_s);
int crtpCommanderHighLevelLandWithVelocity(const float height_m, const float velocity_m_s,
                                           bool relative);
int crtpCommanderHighLevelLandYaw(const float absoluteHeight_m, const float duration_s,
                                  const float yaw);
int crtpCommanderHighLevelStop(void);
int crtpCommanderHighLevelGoTo(const float x, const float y, const float z, const float yaw,
                               const float duration_s, const bool relative);
#if MINIATURE_RELEASE >= 202502
int crtpCommanderHighLevelGoTo2(const float x, const float y, const float z, const float yaw,
                                const float duration_s, const bool relative, const bool linear);
int crtpCommanderHighLevelSpiral(const float phi, const float r0, const float rf, const float dz,
                                 const float duration_s, const bool sideways);
#endif

bool crtpCommanderHighLevelIsTrajectoryDefined(uint8_t trajectoryId);
#if MINIATURE_RELEASE >= 202608
int crtpCommanderHighLevelStartTrajectory(const uint8_t trajectoryId, const float timeScale,
                                          const bool relativePosition, const bool relativeYaw,
                                          const bool reversed);
#else
int crtpCommanderHighLevelStartTrajectory(const uint8_t trajectoryId, const float timeScale,
                                          const bool relative, const bool reversed);
#endif
int crtpCommanderHighLevelDefineTrajectory(const uint8_t                       trajectoryId,
                                           const crtpCommanderTrajectoryType_t type,
                                           const uint32_t offset, const uint8_t nPieces);

uint32_t crtpCommanderHighLevelTrajectoryMemSize(void);
bool     crtpCommanderHighLevelWriteTrajectory(const uint32_t offset, const uint32_t length,
                                               const uint8_t *data);
bool     crtpCommanderHighLevelReadTrajectory(const uint32_t offset, const uint32_t length,
                                              uint8_t *destination);
bool     crtpCommanderHighLevelIsTrajectoryFinished(void);
#if MINIATURE_RELEASE >= 202608
enum trajectory_state crtpCommanderHighLevelGetPlannerState(void);
#endif

#endif  // CRTP_COMMANDER_HIGH_LEVEL_H_
