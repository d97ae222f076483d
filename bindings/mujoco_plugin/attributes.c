#include "mujoco_plugin/attributes.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mujoco_plugin/attribute_table.h"
#include "providers.h"
#include "vehicle/parameters.h"

#define EVERY_PLATFORM (-1)

int cf_attribute_count(void) {
  int count = 0;
  while (cf_attribute(count) != NULL) {
    count++;
  }
  return count;
}

const char *cf_attribute_name(int i) {
  return cf_attribute(i) != NULL ? cf_attribute(i)->name : NULL;
}

const char *cf_attribute_doc(int i) {
  return cf_attribute(i) != NULL ? cf_attribute(i)->doc : NULL;
}

static bool has_platform(int provider, int platform) {
  const int own = cf_provider_platform(provider);
  return platform == EVERY_PLATFORM || own == -1 || own == platform;
}

// Names of the providers for a platform, each once.
static void list_providers(int platform, char *text, int capacity) {
  int used = 0;
  for (int i = 0; i < cf_provider_count() && used < capacity; i++) {
    bool is_new = has_platform(i, platform);
    for (int k = 0; k < i && is_new; k++) {
      is_new = !has_platform(k, platform) || strcmp(cf_provider_name(k), cf_provider_name(i)) != 0;
    }
    if (is_new) {
      used += snprintf(text + used, (size_t)(capacity - used), "%s%s", used == 0 ? "" : " | ",
                       cf_provider_name(i));
    }
  }
}

void cf_attribute_range(int i, char *text, int capacity) {
  const attribute_t *a = cf_attribute(i);
  text[0]              = '\0';
  if (a == NULL) {
    return;
  }
  if (a->kind == KIND_PROVIDER) {
    list_providers(EVERY_PLATFORM, text, capacity);
    return;
  }
  if (a->kind == KIND_PARAMETERS) {
    snprintf(text, (size_t)capacity, "name=value name=a,b,c, see `crazychoir vehicle`");
    return;
  }
  if (a->kind == KIND_REMARK) {
    snprintf(text, (size_t)capacity, "any text");
    return;
  }
  if (a->kind == KIND_VECTOR) {
    snprintf(text, (size_t)capacity, "%d numbers %.10g to %.10g", a->count, a->low, a->high);
    return;
  }
  if (a->words[0] == NULL) {
    snprintf(text, (size_t)capacity, "%s%.10g to %.10g",
             a->kind == KIND_COUNT ? "whole number " : "", a->low, a->high);
    return;
  }
  cf_attribute_choices(i, NULL, NULL, text, capacity);
}

void cf_attribute_choices(int i, bool (*has)(const void *context, int number), const void *context,
                          char *text, int capacity) {
  const attribute_t *a    = cf_attribute(i);
  int                used = 0;
  text[0]                 = '\0';
  for (int k = 0; k < CF_MAX_CHOICES && a->words[k] != NULL && used < capacity; k++) {
    if (has == NULL || has(context, a->numbers[k])) {
      used += snprintf(text + used, (size_t)(capacity - used), "%s%s", used == 0 ? "" : " | ",
                       a->words[k]);
    }
  }
}

static cf_status_t set_choice(cf_config_t *config, const attribute_t *a, const char *text) {
  for (int k = 0; k < CF_MAX_CHOICES && a->words[k] != NULL; k++) {
    if (strcmp(text, a->words[k]) == 0) {
      char *member = (char *)config + a->offset;
      if (a->kind == KIND_SWITCH) {
        *(bool *)member = a->numbers[k] != 0;
      } else {
        memcpy(member, &a->numbers[k], sizeof a->numbers[k]);
      }
      return CF_OK;
    }
  }
  return CF_ERR_VALUE;
}

static cf_status_t set_provider(cf_config_t *config, const attribute_t *a, const char *text) {
  const int number = cf_provider_find(text, config->platform);
  if (number < 0) {
    return CF_ERR_VALUE;
  }
  memcpy((char *)config + a->offset, &number, sizeof number);
  return CF_OK;
}

static cf_status_t set_number(cf_config_t *config, const attribute_t *a, const char *text) {
  char        *end       = NULL;
  const double value     = strtod(text, &end);
  const bool   is_number = end != text;
  while (*end == ' ') {
    end++;
  }
  // negated, so that NaN is refused as well
  if (!is_number || *end != '\0' || !(value >= a->low && value <= a->high)) {
    return CF_ERR_VALUE;
  }

  char *member = (char *)config + a->offset;
  if (a->kind == KIND_COUNT) {
    const uint32_t whole = (uint32_t)value;
    if ((double)whole != value) {
      return CF_ERR_VALUE;
    }
    memcpy(member, &whole, sizeof whole);
  } else {
    const float number = (float)value;
    for (int i = 0; i < (a->count > 1 ? a->count : 1); i++) {
      memcpy(member + (size_t)i * sizeof number, &number, sizeof number);
    }
  }
  return CF_OK;
}

static cf_status_t set_vector(cf_config_t *config, const attribute_t *a, const char *text) {
  float       numbers[CF_MAX_VECTOR];
  const char *rest = text;
  for (int i = 0; i < a->count; i++) {
    char        *end   = NULL;
    const double value = strtod(rest, &end);
    if (end == rest || !(value >= a->low && value <= a->high)) {
      return CF_ERR_VALUE;
    }
    numbers[i] = (float)value;
    rest       = end;
  }
  while (*rest == ' ') {
    rest++;
  }
  if (*rest != '\0') {
    return CF_ERR_VALUE;
  }
  memcpy((char *)config + a->offset, numbers, (size_t)a->count * sizeof *numbers);
  return CF_OK;
}

static cf_status_t set(cf_config_t *config, const attribute_t *a, const char *text) {
  switch (a->kind) {
    case KIND_CHOICE:
    case KIND_QUALITY:
    case KIND_SWITCH:
      return set_choice(config, a, text);
    case KIND_VECTOR:
      return set_vector(config, a, text);
    case KIND_PROVIDER:
      return set_provider(config, a, text);
    case KIND_REMARK:
      return CF_OK;
    default:
      return set_number(config, a, text);
  }
}

static void explain(const cf_config_t *config, int i, const char *text,
                    char message[CF_ATTRIBUTE_MESSAGE_BYTES]) {
  const attribute_t *a = cf_attribute(i);
  char               range[CF_ATTRIBUTE_MESSAGE_BYTES / 2];
  cf_attribute_range(i, range, (int)sizeof range);
  if (a->kind != KIND_PROVIDER) {
    snprintf(message, CF_ATTRIBUTE_MESSAGE_BYTES, "%s is '%.60s', allowed: %s", a->name, text,
             range);
    return;
  }
  const char *platform = cf_platform_facts(config->platform)->name;
  char        hint[96] = "";
  if (strcmp(text, "bitcraze") == 0) {
    // the user loaded a model directly, in a process that has not loaded the library
    snprintf(hint, sizeof hint,
             "; call crazychoir_fw.firmware.providers.load('bitcraze', '%s') first", platform);
  }
  list_providers((int)config->platform, range, (int)sizeof range);
  snprintf(message, CF_ATTRIBUTE_MESSAGE_BYTES, "provider is '%.40s', allowed: %s%s", text, range,
           hint);
}

cf_status_t cf_attribute_set(cf_config_t *config, int i, const char *text,
                             char message[CF_ATTRIBUTE_MESSAGE_BYTES]) {
  const attribute_t *a = cf_attribute(i);
  if (a == NULL) {
    snprintf(message, CF_ATTRIBUTE_MESSAGE_BYTES, "no attribute number %d", i);
    return CF_ERR_UNKNOWN;
  }
  if (text == NULL || text[0] == '\0') {
    return CF_OK;
  }

  if (a->kind == KIND_PARAMETERS) {
    return cf_parameters_set(&config->vehicle, text, message);
  }
  const cf_status_t status = set(config, a, text);
  if (status != CF_OK) {
    explain(config, i, text, message);
    return status;
  }
  if (a->kind == KIND_QUALITY) {
    cf_mocap_of_quality(&config->vehicle.mocap, config->vehicle.mocap_quality);
  }
  if (i == 0) {
    // the platform brings its own vehicle; identity stays
    const uint32_t id = config->id;
    cf_config_default(config, config->platform);
    config->id = id;
  }
  return CF_OK;
}
