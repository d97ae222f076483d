/* The trajectory memory of the high-level commander: its bytes, what is defined in them, and the
 * start of a trajectory (docs/reference/planner-commander.md#7.3 and #7.6). */
#include <string.h>

#include "api/pptraj_compressed.h"
#include "onboard/commander/high_level_commander.h"
#include "onboard/commander/high_level_internal.h"

_Static_assert(sizeof(struct poly4d) == 132, "a piece is its wire format");
_Static_assert(sizeof(struct poly4d) * CF_TRAJECTORY_PIECES <= CF_TRAJECTORY_MEMORY_BYTES,
               "the pieces are a view of the memory");

static bool is_in_memory(uint32_t offset, uint32_t length) {
  return length <= CF_TRAJECTORY_MEMORY_BYTES && offset <= CF_TRAJECTORY_MEMORY_BYTES - length;
}

cf_status_t cf_high_level_commander_define_trajectory(cf_high_level_commander_t *commander,
                                                      uint8_t id, uint8_t type, uint32_t offset,
                                                      uint8_t n_pieces) {
  if (type != CF_TRAJECTORY_TYPE_POLY4D && type != CF_TRAJECTORY_TYPE_POLY4D_COMPRESSED) {
    return CF_ERR_UNKNOWN;
  }
  const bool is_compressed = type == CF_TRAJECTORY_TYPE_POLY4D_COMPRESSED;
  if (n_pieces == 0 && !is_compressed) {
    return CF_ERR_VALUE;
  }
  const uint32_t bytes =
      is_compressed ? PPTRAJ_COMPRESSED_START_BYTES : (uint32_t)sizeof(struct poly4d) * n_pieces;
  const bool is_aligned = is_compressed || offset % 4 == 0;
  if (id >= CF_TRAJECTORY_DEFINITIONS || !is_aligned || !is_in_memory(offset, bytes)) {
    return CF_ERR_CAPACITY;
  }

  commander->definitions[id] = (cf_trajectory_definition_t){
      .location = CF_TRAJECTORY_LOCATION_MEMORY,
      .type     = type,
      .n_pieces = n_pieces,
      .offset   = offset,
  };
  return CF_OK;
}

cf_status_t cf_high_level_commander_write_trajectory(cf_high_level_commander_t *commander,
                                                     uint32_t offset, uint32_t length,
                                                     const uint8_t *data) {
  if (!is_in_memory(offset, length)) {
    return CF_ERR_CAPACITY;
  }
  if (length > 0) {
    memcpy(&commander->memory[offset], data, length);
  }
  return CF_OK;
}

cf_status_t cf_high_level_commander_read_trajectory(const cf_high_level_commander_t *commander,
                                                    uint32_t offset, uint32_t length,
                                                    uint8_t *data) {
  if (!is_in_memory(offset, length)) {
    return CF_ERR_CAPACITY;
  }
  if (length > 0) {
    memcpy(data, &commander->memory[offset], length);
  }
  return CF_OK;
}

bool cf_high_level_commander_is_trajectory_defined(const cf_high_level_commander_t *commander,
                                                   uint8_t                          id) {
  return id < CF_TRAJECTORY_DEFINITIONS &&
         commander->definitions[id].location != CF_TRAJECTORY_LOCATION_INVALID;
}

cf_status_t cf_high_level_commander_start_trajectory(cf_high_level_commander_t *commander,
                                                     const cf_provider_t       *provider,
                                                     void *provider_state, uint8_t id,
                                                     float timescale, bool relative_position,
                                                     bool relative_yaw, bool reversed,
                                                     uint64_t now_us) {
  if (!cf_high_level_is_positive(timescale)) {
    return CF_ERR_VALUE;
  }
  if (commander->is_blocked) {
    return CF_ERR_BLOCKED;
  }
  if (!cf_high_level_commander_is_trajectory_defined(commander, id)) {
    return CF_ERR_UNKNOWN;
  }
  const cf_trajectory_definition_t *definition = &commander->definitions[id];
  if (definition->type == CF_TRAJECTORY_TYPE_POLY4D_COMPRESSED && (reversed || timescale != 1.0f)) {
    return CF_ERR_VALUE;
  }

  const cf_uploaded_trajectory_t trajectory = {
      .type              = (cf_trajectory_type_t)definition->type,
      .offset            = definition->offset,
      .n_pieces          = definition->n_pieces,
      .timescale         = timescale,
      .reversed          = reversed,
      .relative_position = relative_position,
      .relative_yaw      = relative_yaw,
  };
  const cf_plan_start_t from = cf_high_level_plan_start(commander);
  return cf_high_level_from_planner(provider->plan_start_trajectory(
      provider_state, commander->memory, &trajectory, &from, cf_high_level_seconds(now_us)));
}
