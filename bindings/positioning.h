/* What tells a drone where it is: one system per drone. */
#ifndef CF_POSITIONING_H
#define CF_POSITIONING_H

typedef enum {
  CF_POSITIONING_NONE           = 0,  // inertial sensors only
  CF_POSITIONING_MOCAP          = 1,  // poses of a motion-capture system, by radio
  CF_POSITIONING_FLOW           = 2,  // flow deck: optical flow and range to the floor
  CF_POSITIONING_MOCAP_POSITION = 3,  // motion capture of a single marker: positions only
  CF_POSITIONING_LIGHTHOUSE     = 4,  // lighthouse deck and two base stations
  CF_POSITIONING_LOCO_TWR       = 5,  // loco deck and eight anchors: distances
  CF_POSITIONING_LOCO_TDOA2     = 6,  // differences of distances, the anchors in turn
  CF_POSITIONING_LOCO_TDOA3     = 7,  // differences of distances, anchors at random
  CF_POSITIONING_COUNT          = 8,
} cf_positioning_t;

#endif  // CF_POSITIONING_H
