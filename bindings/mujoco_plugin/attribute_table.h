/* The table of attributes: what may be chosen, in which range, and where it is stored. Internal to
 * the plugin. */
#ifndef CF_MUJOCO_PLUGIN_ATTRIBUTE_TABLE_H
#define CF_MUJOCO_PLUGIN_ATTRIBUTE_TABLE_H

#include <stddef.h>

#define CF_MAX_CHOICES 8
#define CF_MAX_VECTOR 6

typedef enum {
  KIND_CHOICE,      // one of a list of words; the number of the word is stored in an int
  KIND_PROVIDER,    // the name of a provider for the platform; its number is stored in an int
  KIND_QUALITY,     // the same; brings the numbers of a motion-capture system of this quality
  KIND_SWITCH,      // the same for off and on, stored in a bool
  KIND_COUNT,       // a whole number in [low, high], stored in a uint32_t
  KIND_NUMBER,      // a number in [low, high], stored in a float
  KIND_PARAMETERS,  // `name=value` of vehicle/parameters.h
  KIND_VECTOR,      // `count` such numbers with spaces between them, stored in floats
  KIND_REMARK,      // text for the program around the engine, not stored
} kind_t;

typedef struct {
  const char *name;
  const char *doc;
  kind_t      kind;
  size_t      offset;  // in cf_config_t
  double      low;
  double      high;
  int         count;  // of a vector, or of equal numbers side by side
  const char *words[CF_MAX_CHOICES];
  int         numbers[CF_MAX_CHOICES];
} attribute_t;

// Returns attribute number i, or null behind the last one.
const attribute_t *cf_attribute(int i);

#endif  // CF_MUJOCO_PLUGIN_ATTRIBUTE_TABLE_H
