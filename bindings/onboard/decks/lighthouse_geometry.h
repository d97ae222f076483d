/* Geometry of light rays and decks. All functions are pure. */
#ifndef CF_ONBOARD_DECKS_LIGHTHOUSE_GEOMETRY_H
#define CF_ONBOARD_DECKS_LIGHTHOUSE_GEOMETRY_H

#include <stdbool.h>

// Angle [rad] about the normal n from the vector between two sensors as light shows it (ipv)
// to the one as the estimate has it (spv), positive counter-clockwise. Returns false when ipv is
// too short.
bool cf_lighthouse_yaw_delta(const float n[3], const float ipv[3], const float spv[3],
                             float *delta);

// The middle of the shortest line between two rays p + s d. Returns false when they are
// parallel or pass each other at 5 cm or more.
bool cf_lighthouse_cross(const float p0[3], const float d0[3], const float p1[3], const float d1[3],
                         float middle[3]);

float cf_dot3(const float a[3], const float b[3]);

// Median of one to four numbers; sorts them.
float cf_median(float *numbers, int count);

#endif  // CF_ONBOARD_DECKS_LIGHTHOUSE_GEOMETRY_H
