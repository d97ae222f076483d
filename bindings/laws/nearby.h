/* Which agents are near each, horizontally, for the safety filters of crazychoir_fw.control. */
#ifndef CF_LAWS_NEARBY_H
#define CF_LAWS_NEARBY_H

#include <stdint.h>

// Writes the numbers of the agents that are nearer than a distance [m] to each, the nearest first,
// then -1: `table` is (agents, agents - 1). Positions [m] are (agents, axes), with two axes or
// more; an agent whose position is NaN is near none. `scratch` holds `agents` numbers. Returns the
// largest number of agents near one.
int cf_find_nearby(int agents, int axes, const double *positions, double distance, double *scratch,
                   int32_t *table);

// Writes vectors of the agents in a table, (agents, near, axes), and NaN for -1. Of each row of the
// table, which has `width` numbers, the first `near` count.
void cf_gather_nearby(int agents, int axes, const double *vectors, const int32_t *table, int width,
                      int near, double *gathered);

#endif  // CF_LAWS_NEARBY_H
