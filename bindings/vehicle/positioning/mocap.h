/* Motion capture and the radio behind it: poses at a rate, with noise, some milliseconds late.
 *
 * Now and then a frame is lost, or shows a wrong marker somewhere around the drone. For some time
 * the drone may be out of sight, a marker hidden (the pose jumps by some millimeters) or confused
 * with another one (it jumps and turns by more), or the radio busy (poses come later).
 * docs/reference/vehicle.md#10 and #11; standard deviations told to the filter:
 * docs/reference/estimators.md#13.3. How good a system is, mocap_quality.h. */
#ifndef CF_VEHICLE_POSITIONING_MOCAP_H
#define CF_VEHICLE_POSITIONING_MOCAP_H

#include <stdbool.h>
#include <stdint.h>

#include "api/stabilizer_types.h"
#include "status.h"
#include "vehicle/positioning/mishap.h"
#include "vehicle/positioning/spell.h"
#include "vehicle/random.h"

#define CF_MOCAP_CAPACITY 32

// A spell in which poses are displaced and turned, each time in directions of their own.
typedef struct {
  cf_spell_config_t spell;
  float             size;   // [m], [0, 10], by how far
  float             angle;  // [rad], [0, 3.2], by how much
} cf_mocap_shift_config_t;

typedef struct {
  uint32_t rate;            // [Hz], 0 (off) to 1000
  uint32_t latency_ms;      // [ms]; (latency_ms + 1) rate <= 1000 CF_MOCAP_CAPACITY
  float    position_noise;  // [m] >= 0, standard deviation per axis
  float    attitude_noise;  // [rad] >= 0, standard deviation per axis
  float    position_std;    // [m] > 0, what the client tells the filter (locSrv.extPosStdDev)
  float    attitude_std;    // [rad] > 0 (locSrv.extQuatStdDev)

  cf_mishap_config_t mishap;  // of one frame; size in m

  cf_spell_config_t       gap;   // out of sight
  cf_mocap_shift_config_t jump;  // a marker is hidden
  cf_mocap_shift_config_t swap;  // markers are confused
  cf_spell_config_t       busy;  // the radio is busy: each time later by up to `busy_ms`
  uint32_t                busy_ms;
} cf_mocap_config_t;

typedef struct {
  uint32_t due;           // [ticks], when it arrives
  float    position[3];   // [m], world
  float    quat_wxyz[4];  // body to world
} cf_mocap_sample_t;

typedef struct {
  uint32_t left;         // [frames] to its end, 0 = all is well
  float    position[3];  // [m]
  float    turn[3];      // [rad], body
} cf_mocap_shift_t;

typedef struct {
  cf_mocap_config_t config;
  bool              is_lost;  // while true the cameras do not see the drone

  uint32_t    tick;   // number of steps
  uint32_t    phase;  // [0, 1000), a sample is taken when it wraps
  uint32_t    oldest;
  uint32_t    waiting;
  cf_random_t random;         // noise
  cf_random_t mishap_random;  // everything else

  uint32_t         gap_left;   // [frames]
  uint32_t         busy_left;  // [frames]
  uint32_t         extra_ms;   // [ms], on the latency while the radio is busy
  cf_mocap_shift_t jump;
  cf_mocap_shift_t swap;

  cf_mocap_sample_t samples[CF_MOCAP_CAPACITY];  // ring
} cf_mocap_t;

// Fills the system; the first step takes the first sample. Returns CF_ERR_VALUE when a number of
// the config is outside its range, CF_ERR_CAPACITY when too many samples would be under way.
cf_status_t cf_mocap_init(cf_mocap_t *mocap, const cf_mocap_config_t *config, cf_random_t random,
                          cf_random_t mishap_random);

// Changes how late poses arrive [ms], from the next one on. Those that are under way keep their
// time, and no pose overtakes another. Returns CF_ERR_CAPACITY when too many would be under way.
cf_status_t cf_mocap_set_latency(cf_mocap_t *mocap, uint32_t latency_ms);

// Advances by 1 ms with the true position [m] and attitude (body to world, unit). Returns true and
// writes the pose when one arrives at this tick.
bool cf_mocap_step(cf_mocap_t *mocap, const float position[3], const float quat_wxyz[4],
                   poseMeasurement_t *pose);

#endif  // CF_VEHICLE_POSITIONING_MOCAP_H
