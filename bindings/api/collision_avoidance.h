/* Collision avoidance by buffered Voronoi cells, with the names of the firmware's
 * collision_avoidance.h.
 *
 * A drone keeps within a cell around itself: each other drone takes away the half of space that is
 * nearer to it, and a margin the size of an ellipsoid around the drone. What lies outside of the
 * cell is replaced by the nearest that is inside. All drones do so, and none needs to know what the
 * others want. Source: docs/reference/planner-commander.md#12. */
#ifndef COLLISION_AVOIDANCE_H
#define COLLISION_AVOIDANCE_H

#include "api/stabilizer_types.h"
#include "api/vec.h"

typedef struct {
  struct vec ellipsoidRadii;  // [m] > 0, half axes of the space that a drone needs
  struct vec bboxMin;         // [m], world: drones stay within this box
  struct vec bboxMax;         // [m], world

  float horizonSecs;        // [s] > 0, how far ahead
  float maxSpeed;           // [m/s] > 0; a goal lies at most horizon times speed away on each axis
  float sidestepThreshold;  // [m] > 0, to the wall of the cell; nearer than this, step aside
  int   maxPeerLocAgeMillis;  // [ms], an older position does not count; negative: all count

  float voronoiProjectionTolerance;  // [m]
  int   voronoiProjectionMaxIters;   // sweeps
} collision_avoidance_params_t;

typedef struct {
  struct vec lastFeasibleSetPosition;  // [m], NaN until there was one
} collision_avoidance_state_t;

// Bends a setpoint so that it stays within the cell. mode.x alone decides what is bent: a position
// (modeAbs), a velocity (modeVelocity, always taken as one in world axes), or nothing.
//
// otherPositions holds x, y, z [m] of nOthers drones, one after the other; workspace is scratch of
// 7 (nOthers + 6) floats and may begin at the same address. The result is finite whenever the
// estimate and the setpoint are: where the cell is empty or no number, the drone stays where it is
// (or at its last feasible position). The sensors are not looked at.
void collisionAvoidanceUpdateSetpointCore(const collision_avoidance_params_t *params,
                                          collision_avoidance_state_t *collisionState, int nOthers,
                                          const float *otherPositions, float *workspace,
                                          setpoint_t *setpoint, const sensorData_t *sensorData,
                                          const state_t *state);

#endif  // COLLISION_AVOIDANCE_H
