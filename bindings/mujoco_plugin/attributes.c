#include "mujoco_plugin/attributes.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_CHOICES 6

typedef enum {
  KIND_CHOICE,  // one of a list of words; the number of the word is stored in an int
  KIND_COUNT,   // a whole number in [low, high], stored in a uint32_t
  KIND_NUMBER,  // a number in [low, high], stored in a float
} kind_t;

typedef struct {
  const char *name;
  const char *doc;
  kind_t      kind;
  size_t      offset;  // in cf_config_t
  double      low;
  double      high;
  const char *words[MAX_CHOICES];
  int         numbers[MAX_CHOICES];
} attribute_t;

#define CONFIG(member_) offsetof(cf_config_t, member_)

static const attribute_t ATTRIBUTES[] = {
    {.name    = "platform",
     .doc     = "airframe; chooses the defaults of everything else",
     .kind    = KIND_CHOICE,
     .offset  = CONFIG(platform),
     .words   = {"cf2", "cf21bl"},
     .numbers = {CF_PLATFORM_CF2, CF_PLATFORM_CF21BL}},
    {.name    = "provider",
     .doc     = "implementation of the onboard algorithms",
     .kind    = KIND_CHOICE,
     .offset  = CONFIG(provider),
     .words   = {"builtin"},
     .numbers = {0}},
    {.name    = "controller",
     .doc     = "controller at boot",
     .kind    = KIND_CHOICE,
     .offset  = CONFIG(controller),
     .words   = {"auto", "pid"},
     .numbers = {ControllerTypeAutoSelect, ControllerTypePID}},
    {.name    = "estimator",
     .doc     = "state estimator at boot",
     .kind    = KIND_CHOICE,
     .offset  = CONFIG(estimator),
     .words   = {"auto", "kalman"},
     .numbers = {StateEstimatorTypeAutoSelect, StateEstimatorTypeKalman}},
    {.name    = "positioning",
     .doc     = "what tells the drone where it is",
     .kind    = KIND_CHOICE,
     .offset  = CONFIG(positioning),
     .words   = {"none", "mocap", "flow"},
     .numbers = {CF_POSITIONING_NONE, CF_POSITIONING_MOCAP, CF_POSITIONING_FLOW}},
    {.name   = "seed",
     .doc    = "of all noise; drones with equal seeds differ by their id",
     .kind   = KIND_COUNT,
     .offset = CONFIG(seed),
     .low    = 0,
     .high   = 4294967295.0},
    {.name   = "id",
     .doc    = "number of the drone; default: its place in the model",
     .kind   = KIND_COUNT,
     .offset = CONFIG(id),
     .low    = 0,
     .high   = 4294967295.0},
    {.name   = "battery",
     .doc    = "state of charge at the start, 1 = full",
     .kind   = KIND_NUMBER,
     .offset = CONFIG(vehicle.airframe.battery.initial_charge),
     .low    = 0,
     .high   = 1},
    {.name   = "supply_voltage",
     .doc    = "constant supply in place of a battery [V]; 0 = battery",
     .kind   = KIND_NUMBER,
     .offset = CONFIG(vehicle.airframe.battery.constant_voltage),
     .low    = 0,
     .high   = 20},
    {.name   = "noise",
     .doc    = "factor on the noise of the inertial sensors; 0 = ideal",
     .kind   = KIND_NUMBER,
     .offset = CONFIG(vehicle.airframe.imu.noise_scale),
     .low    = 0,
     .high   = 100},
    {.name   = "bias",
     .doc    = "factor on the turn-on errors of the inertial sensors; 0 = ideal",
     .kind   = KIND_NUMBER,
     .offset = CONFIG(vehicle.airframe.imu.bias_scale),
     .low    = 0,
     .high   = 10},
    {.name   = "mocap_rate",
     .doc    = "poses per second [Hz]; 0 = off",
     .kind   = KIND_COUNT,
     .offset = CONFIG(vehicle.mocap.rate),
     .low    = 0,
     .high   = 1000},
    {.name   = "mocap_latency_ms",
     .doc    = "age of a pose on arrival [ms]",
     .kind   = KIND_COUNT,
     .offset = CONFIG(vehicle.mocap.latency_ms),
     .low    = 0,
     .high   = 1000},
    {.name   = "mocap_noise",
     .doc    = "standard deviation of a position [m]",
     .kind   = KIND_NUMBER,
     .offset = CONFIG(vehicle.mocap.position_noise),
     .low    = 0,
     .high   = 1},
    {.name   = "mocap_attitude_noise",
     .doc    = "standard deviation of an attitude [rad]",
     .kind   = KIND_NUMBER,
     .offset = CONFIG(vehicle.mocap.attitude_noise),
     .low    = 0,
     .high   = 1},
    {.name    = "drag",
     .doc     = "form of the rotor drag",
     .kind    = KIND_CHOICE,
     .offset  = CONFIG(vehicle.airframe.aerodynamics.form),
     .words   = {"none", "linear", "rotor"},
     .numbers = {CF_DRAG_NONE, CF_DRAG_LINEAR, CF_DRAG_ROTORS}},
    {.name    = "flight_moment",
     .doc     = "the moment that lifts the leading edge in forward flight",
     .kind    = KIND_CHOICE,
     .offset  = CONFIG(vehicle.airframe.aerodynamics.has_flight_moment),
     .words   = {"off", "on"},
     .numbers = {0, 1}},
    {.name   = "body_drag",
     .doc    = "quadratic drag of the body [N s^2/m^2]",
     .kind   = KIND_NUMBER,
     .offset = CONFIG(vehicle.airframe.aerodynamics.body_drag),
     .low    = 0,
     .high   = 1},
    {.name   = "motor_time_constant",
     .doc    = "first-order lag of the rotor speed [s]",
     .kind   = KIND_NUMBER,
     .offset = CONFIG(vehicle.airframe.rotors.time_constant),
     .low    = 0.001,
     .high   = 1},
};

int cf_attribute_count(void) {
  return (int)(sizeof ATTRIBUTES / sizeof ATTRIBUTES[0]);
}

static const attribute_t *find(int i) {
  return i >= 0 && i < cf_attribute_count() ? &ATTRIBUTES[i] : NULL;
}

const char *cf_attribute_name(int i) {
  return find(i) != NULL ? find(i)->name : NULL;
}

const char *cf_attribute_doc(int i) {
  return find(i) != NULL ? find(i)->doc : NULL;
}

void cf_attribute_range(int i, char *text, int capacity) {
  const attribute_t *a = find(i);
  text[0]              = '\0';
  if (a == NULL) {
    return;
  }
  if (a->kind != KIND_CHOICE) {
    snprintf(text, (size_t)capacity, "%s%.10g to %.10g",
             a->kind == KIND_COUNT ? "whole number " : "", a->low, a->high);
    return;
  }
  int used = 0;
  for (int k = 0; k < MAX_CHOICES && a->words[k] != NULL && used < capacity; k++) {
    used +=
        snprintf(text + used, (size_t)(capacity - used), "%s%s", k == 0 ? "" : " | ", a->words[k]);
  }
}

static cf_status_t set_choice(cf_config_t *config, const attribute_t *a, const char *text) {
  for (int k = 0; k < MAX_CHOICES && a->words[k] != NULL; k++) {
    if (strcmp(text, a->words[k]) == 0) {
      char *member = (char *)config + a->offset;
      if (a->offset == CONFIG(vehicle.airframe.aerodynamics.has_flight_moment)) {
        *(bool *)member = a->numbers[k] != 0;
      } else {
        memcpy(member, &a->numbers[k], sizeof a->numbers[k]);
      }
      return CF_OK;
    }
  }
  return CF_ERR_VALUE;
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
    memcpy(member, &number, sizeof number);
  }
  return CF_OK;
}

cf_status_t cf_attribute_set(cf_config_t *config, int i, const char *text,
                             char message[CF_ATTRIBUTE_MESSAGE_BYTES]) {
  const attribute_t *a = find(i);
  if (a == NULL) {
    snprintf(message, CF_ATTRIBUTE_MESSAGE_BYTES, "no attribute number %d", i);
    return CF_ERR_UNKNOWN;
  }
  if (text == NULL || text[0] == '\0') {
    return CF_OK;
  }

  const cf_status_t status =
      a->kind == KIND_CHOICE ? set_choice(config, a, text) : set_number(config, a, text);
  if (status != CF_OK) {
    char range[CF_ATTRIBUTE_MESSAGE_BYTES / 2];
    cf_attribute_range(i, range, (int)sizeof range);
    snprintf(message, CF_ATTRIBUTE_MESSAGE_BYTES, "%s is '%.60s', allowed: %s", a->name, text,
             range);
    return status;
  }
  if (i == 0) {
    // the platform brings its own vehicle; identity stays
    const uint32_t id = config->id;
    cf_config_default(config, config->platform);
    config->id = id;
  }
  return CF_OK;
}
