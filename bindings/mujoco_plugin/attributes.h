/* The attributes of the engine plugin: text of an MJCF file into a cf_config_t. One row per
 * attribute. */
#ifndef CF_MUJOCO_PLUGIN_ATTRIBUTES_H
#define CF_MUJOCO_PLUGIN_ATTRIBUTES_H

#include "crazyflie.h"

#define CF_ATTRIBUTE_MESSAGE_BYTES 256

// Number of attributes.
int cf_attribute_count(void);

// Name, allowed values and meaning of attribute i; null behind the last one.
const char *cf_attribute_name(int i);
const char *cf_attribute_doc(int i);

// Writes the allowed values of attribute i as text, e.g. "cf2 | cf21bl" or "0 to 1".
void cf_attribute_range(int i, char *text, int capacity);

// The same for an attribute with words, leaving out those whose number `has` denies.
void cf_attribute_choices(int i, bool (*has)(const void *context, int number), const void *context,
                          char *text, int capacity);

// Sets attribute i from text; empty text leaves the default. Attribute 0 is the platform and must
// be set first, because it chooses the defaults of the others. On CF_ERR_VALUE `message` says what
// is allowed. The words for a provider are the names of those that are loaded.
cf_status_t cf_attribute_set(cf_config_t *config, int i, const char *text,
                             char message[CF_ATTRIBUTE_MESSAGE_BYTES]);

#endif  // CF_MUJOCO_PLUGIN_ATTRIBUTES_H
