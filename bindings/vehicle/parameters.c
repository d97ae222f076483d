#include "vehicle/parameters.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "vehicle/airframe_table.h"

#define RAD_PER_DEG 0.0174532925f
#define COULOMB_PER_MAH 3.6f

typedef enum { KIND_FLOAT, KIND_INT, KIND_BOOL } kind_t;

// Where a parameter is stored, and the factor from its unit to that of the member.
typedef struct {
  const char *name;
  kind_t      kind;
  size_t      offset;
  float       factor;
} place_t;

#define PLACE(name_, kind_, member_) \
  {.name = name_, .kind = kind_, .offset = offsetof(cf_vehicle_config_t, member_), .factor = 1.0f}
#define NUMBER(name_, member_) PLACE(name_, KIND_FLOAT, member_)
#define WHOLE(name_, member_) PLACE(name_, KIND_INT, member_)
#define SWITCH(name_, member_) PLACE(name_, KIND_BOOL, member_)
#define SCALED(name_, member_, factor_)              \
  {.name   = name_,                                  \
   .kind   = KIND_FLOAT,                             \
   .offset = offsetof(cf_vehicle_config_t, member_), \
   .factor = factor_}

// In the order of crazychoir_fw/onboard/vehicles/parameters.yaml.
static const place_t PLACES[] = {
    NUMBER("mass", airframe.mass),
    NUMBER("inertia", airframe.inertia),
    NUMBER("products_of_inertia", airframe.products_of_inertia),
    NUMBER("landed_height", airframe.landed_height),
    NUMBER("rotors.thrust_curve", airframe.rotors.curve.c0),
    NUMBER("rotors.torque_per_thrust", airframe.rotors.curve.thrust_to_torque),
    NUMBER("rotors.linear_voltage", airframe.rotors.linear_voltage),
    NUMBER("rotors.thrust_per_rpm", airframe.rotors.thrust_per_rpm),
    NUMBER("rotors.thrust_per_rpm2", airframe.rotors.thrust_per_rpm2),
    NUMBER("rotors.hover_rpm", airframe.rotors.hover_rpm),
    NUMBER("rotors.thrust_scale", airframe.rotors.thrust_scale),
    NUMBER("rotors.efficiency", airframe.rotors.efficiency),
    WHOLE("rotors.law", airframe.rotors.law),
    NUMBER("rotors.time_constant_up", airframe.rotors.time_constant_up),
    NUMBER("rotors.time_constant_down", airframe.rotors.time_constant_down),
    NUMBER("rotors.rate_up", airframe.rotors.rate_up),
    NUMBER("rotors.square_rate_up", airframe.rotors.square_rate_up),
    NUMBER("rotors.rate_down", airframe.rotors.rate_down),
    NUMBER("rotors.square_rate_down", airframe.rotors.square_rate_down),
    NUMBER("rotors.heat_loss", airframe.rotors.heat_loss),
    NUMBER("rotors.heat_time", airframe.rotors.heat_time),
    NUMBER("rotors.heat_own_loss", airframe.rotors.heat_own_loss),
    NUMBER("rotors.heat_own_time", airframe.rotors.heat_own_time),
    NUMBER("rotors.heat_thrust", airframe.rotors.heat_thrust),
    NUMBER("rotors.inertia", airframe.rotors.inertia),
    NUMBER("rotors.arm_x", airframe.rotors.arm_x),
    NUMBER("rotors.arm_y", airframe.rotors.arm_y),
    NUMBER("rotors.height", airframe.rotors.height),
    NUMBER("rotors.radius", airframe.rotors.radius),
    WHOLE("rotors.duty_bits", airframe.rotors.duty_bits),
    WHOLE("rotors.duty_lowest_level", airframe.rotors.duty_lowest_level),
    NUMBER("trim.torque", airframe.trim_torque),
    SCALED("battery.capacity", airframe.battery.capacity, COULOMB_PER_MAH),
    NUMBER("battery.resistance", airframe.battery.resistance),
    NUMBER("battery.slow_resistance", airframe.battery.slow_resistance),
    NUMBER("battery.slow_time", airframe.battery.slow_time),
    NUMBER("battery.base_power", airframe.battery.base_power),
    NUMBER("battery.power_per_thrust", airframe.battery.power_per_thrust),
    NUMBER("battery.initial_charge", airframe.battery.initial_charge),
    NUMBER("battery.constant_voltage", airframe.battery.constant_voltage),
    WHOLE("drag.form", airframe.aerodynamics.form),
    NUMBER("drag.rotor_xy", airframe.aerodynamics.rotor_drag_xy),
    NUMBER("drag.rotor_z", airframe.aerodynamics.rotor_drag_z),
    NUMBER("drag.linear_xy", airframe.aerodynamics.drag_xy),
    NUMBER("drag.linear_z", airframe.aerodynamics.drag_z),
    NUMBER("drag.body", airframe.aerodynamics.body_drag),
    SWITCH("flight_moment.enabled", airframe.aerodynamics.has_flight_moment),
    NUMBER("flight_moment.x", airframe.aerodynamics.flight_moment_x),
    NUMBER("flight_moment.y", airframe.aerodynamics.flight_moment_y),
    NUMBER("flight_moment.thrust", airframe.aerodynamics.flight_moment_thrust),
    SWITCH("ground_effect.enabled", airframe.ground_effect.is_enabled),
    NUMBER("ground_effect.body", airframe.ground_effect.body),
    NUMBER("ground_effect.cap", airframe.ground_effect.cap),
    NUMBER("ground_effect.lowest_height", airframe.ground_effect.lowest_height),
    SWITCH("downwash.enabled", airframe.downwash.is_enabled),
    NUMBER("downwash.peak", airframe.downwash.peak),
    NUMBER("downwash.height", airframe.downwash.height),
    NUMBER("downwash.depth", airframe.downwash.depth),
    NUMBER("downwash.width", airframe.downwash.width),
    NUMBER("downwash.narrowing", airframe.downwash.narrowing),
    NUMBER("wind.velocity", airframe.wind.velocity),
    WHOLE("wind.turbulence", airframe.wind.turbulence),
    NUMBER("wind.indoor_deviation", airframe.wind.indoor_deviation),
    NUMBER("wind.indoor_time", airframe.wind.indoor_time),
    NUMBER("wind.dryden_speed", airframe.wind.dryden_speed),
    SCALED("imu.gyro_noise_rest", airframe.imu.gyro_noise_rest, RAD_PER_DEG),
    SCALED("imu.gyro_noise_density", airframe.imu.gyro_noise_density, RAD_PER_DEG),
    SCALED("imu.gyro_noise_flight", airframe.imu.gyro_noise_flight, RAD_PER_DEG),
    NUMBER("imu.acc_noise_rest", airframe.imu.acc_noise_rest),
    NUMBER("imu.acc_noise_density", airframe.imu.acc_noise_density),
    NUMBER("imu.acc_noise_flight", airframe.imu.acc_noise_flight),
    SCALED("imu.gyro_bias", airframe.imu.gyro_bias, RAD_PER_DEG),
    NUMBER("imu.acc_bias", airframe.imu.acc_bias),
    NUMBER("imu.gyro_scale_error", airframe.imu.gyro_scale_error),
    NUMBER("imu.acc_scale_error", airframe.imu.acc_scale_error),
    SCALED("imu.gyro_drift", airframe.imu.gyro_drift, RAD_PER_DEG),
    NUMBER("imu.acc_drift", airframe.imu.acc_drift),
    NUMBER("imu.drift_time", airframe.imu.drift_time),
    NUMBER("imu.acc_vibration", airframe.imu.lines.acc),
    SCALED("imu.gyro_vibration", airframe.imu.lines.gyro, RAD_PER_DEG),
    NUMBER("imu.noise_scale", airframe.imu.noise_scale),
    NUMBER("imu.bias_scale", airframe.imu.bias_scale),
    NUMBER("barometer.altitude", barometer.altitude),
    NUMBER("barometer.noise", barometer.noise),
    NUMBER("barometer.drift", barometer.drift),
    NUMBER("barometer.wash_low", barometer.wash_low),
    NUMBER("barometer.wash_high", barometer.wash_high),
    NUMBER("barometer.wash_height", barometer.wash_height),
    NUMBER("barometer.noise_scale", barometer.noise_scale),
};

#define PLACE_COUNT (int)(sizeof PLACES / sizeof PLACES[0])

int cf_parameter_count(void) {
  return PLACE_COUNT;
}

// The two tables have the same order, which a test checks.
const cf_parameter_facts_t *cf_parameter_facts(int i) {
  const bool exists = i >= 0 && i < PLACE_COUNT && i < CF_PARAMETER_FACTS_COUNT &&
                      strcmp(PLACES[i].name, CF_PARAMETER_FACTS[i].name) == 0;
  return exists ? &CF_PARAMETER_FACTS[i] : NULL;
}

// --------------------------------------------------------------------------------------- members

static void store(cf_vehicle_config_t *config, int i, int k, float value) {
  const place_t *place = &PLACES[i];
  char          *at    = (char *)config + place->offset;
  if (place->kind == KIND_BOOL) {
    *(bool *)at = value > 0.5f;
  } else if (place->kind == KIND_INT) {
    const int whole = (int)value;
    memcpy(at, &whole, sizeof whole);
  } else {
    const float number = value * place->factor;
    memcpy(at + (size_t)k * sizeof number, &number, sizeof number);
  }
}

static float fetch(const cf_vehicle_config_t *config, int i, int k) {
  const place_t *place = &PLACES[i];
  const char    *at    = (const char *)config + place->offset;
  if (place->kind == KIND_BOOL) {
    return *(const bool *)at ? 1.0f : 0.0f;
  }
  if (place->kind == KIND_INT) {
    int whole;
    memcpy(&whole, at, sizeof whole);
    return (float)whole;
  }
  float number;
  memcpy(&number, at + (size_t)k * sizeof number, sizeof number);
  return number / place->factor;
}

void cf_parameters_of_platform(cf_vehicle_config_t *config, cf_platform_t platform) {
  for (int i = 0; i < PLACE_COUNT; i++) {
    const cf_parameter_facts_t *facts = cf_parameter_facts(i);
    for (int k = 0; facts != NULL && k < facts->size; k++) {
      store(config, i, k, facts->values[platform][k]);
    }
  }
}

int cf_parameter_get(const cf_vehicle_config_t *config, int i,
                     float values[CF_PARAMETER_MAX_SIZE]) {
  const cf_parameter_facts_t *facts = cf_parameter_facts(i);
  for (int k = 0; facts != NULL && k < facts->size; k++) {
    values[k] = fetch(config, i, k);
  }
  return facts != NULL ? facts->size : 0;
}

// ------------------------------------------------------------------------------------------ text

// One piece of a text: no copy, no end of its own.
typedef struct {
  const char *text;
  int         length;
} piece_t;

static bool is_word(piece_t piece, const char *word) {
  return (int)strlen(word) == piece.length && strncmp(piece.text, word, strlen(word)) == 0;
}

// Takes what stands before the next separator, and the separator as well.
static piece_t take(piece_t *rest, const char *separators) {
  int length = 0;
  while (length < rest->length && strchr(separators, rest->text[length]) == NULL) {
    length++;
  }
  const piece_t piece = {rest->text, length};
  const int     used  = length < rest->length ? length + 1 : length;
  rest->text += used;
  rest->length -= used;
  return piece;
}

static bool read_choice(const cf_parameter_facts_t *facts, piece_t piece, float *value) {
  for (int k = 0; k < CF_PARAMETER_MAX_WORDS && facts->words[k] != NULL; k++) {
    if (is_word(piece, facts->words[k])) {
      *value = (float)k;
      return true;
    }
  }
  return false;
}

static bool read_number(int i, const cf_parameter_facts_t *facts, piece_t piece, float *value) {
  char text[48];
  if (piece.length == 0 || piece.length >= (int)sizeof text) {
    return false;
  }
  memcpy(text, piece.text, (size_t)piece.length);
  text[piece.length] = '\0';

  char *end         = NULL;
  *value            = (float)strtod(text, &end);
  const bool is_end = *end == '\0';
  const bool is_fit = *value >= facts->lowest && *value <= facts->highest;  // NaN does not
  const bool is_ok  = PLACES[i].kind != KIND_INT || !is_fit || *value == (float)(int)*value;
  return is_end && is_fit && is_ok;
}

static void say_what_is_allowed(int i, piece_t value, char message[CF_PARAMETER_MESSAGE_BYTES]) {
  const cf_parameter_facts_t *facts = &CF_PARAMETER_FACTS[i];
  const int                   shown = value.length < 60 ? value.length : 60;
  if (facts->words[0] != NULL) {
    const char *third = facts->words[2];
    snprintf(message, CF_PARAMETER_MESSAGE_BYTES, "%s is '%.*s', allowed: %s | %s%s%s", facts->name,
             shown, value.text, facts->words[0], facts->words[1], third != NULL ? " | " : "",
             third != NULL ? third : "");
    return;
  }
  char count[48] = "";
  if (facts->size > 1) {
    snprintf(count, sizeof count, "%d numbers with commas between, ", facts->size);
  }
  const bool has_unit = strcmp(facts->unit, "1") != 0;
  snprintf(message, CF_PARAMETER_MESSAGE_BYTES, "%s is '%.*s', allowed: %s%s%g to %g%s%s",
           facts->name, shown, value.text, count, PLACES[i].kind == KIND_INT ? "whole number " : "",
           (double)facts->lowest, (double)facts->highest, has_unit ? " " : "",
           has_unit ? facts->unit : "");
}

static cf_status_t set_one(cf_vehicle_config_t *config, int i, piece_t text,
                           char message[CF_PARAMETER_MESSAGE_BYTES]) {
  const cf_parameter_facts_t *facts = cf_parameter_facts(i);
  float                       values[CF_PARAMETER_MAX_SIZE];
  piece_t                     rest = text;
  int                         read = 0;
  while (facts != NULL && read < facts->size && rest.length > 0) {
    const piece_t piece = take(&rest, ",");
    const bool    is_ok = facts->words[0] != NULL ? read_choice(facts, piece, &values[read])
                                                  : read_number(i, facts, piece, &values[read]);
    if (!is_ok) {
      break;
    }
    read++;
  }
  const bool has_more = rest.length > 0 || (text.length > 0 && text.text[text.length - 1] == ',');
  if (facts == NULL || read < facts->size || has_more) {
    say_what_is_allowed(i, text, message);
    return CF_ERR_VALUE;
  }
  for (int k = 0; k < facts->size; k++) {
    store(config, i, k, values[k]);
  }
  return CF_OK;
}

static int find(piece_t name) {
  for (int i = 0; i < PLACE_COUNT; i++) {
    if (is_word(name, PLACES[i].name)) {
      return i;
    }
  }
  return -1;
}

static int find_word(const char *name) {
  return find((piece_t){name, (int)strlen(name)});
}

cf_status_t cf_parameters_set(cf_vehicle_config_t *config, const char *text,
                              char message[CF_PARAMETER_MESSAGE_BYTES]) {
  piece_t rest = {text, (int)strlen(text)};
  while (rest.length > 0) {
    piece_t entry = take(&rest, " \t\n\r");
    if (entry.length == 0) {
      continue;
    }
    const piece_t name   = take(&entry, "=");
    cf_status_t   status = CF_ERR_UNKNOWN;
    if (is_word(name, "rotors.time_constant")) {
      status = set_one(config, find_word("rotors.time_constant_up"), entry, message);
      if (status == CF_OK) {
        status = set_one(config, find_word("rotors.time_constant_down"), entry, message);
      }
    } else if (find(name) >= 0) {
      status = set_one(config, find(name), entry, message);
    } else {
      snprintf(
          message, CF_PARAMETER_MESSAGE_BYTES,
          "vehicle has no parameter '%.*s', allowed: name=value of those that `crazychoir vehicle` "
          "lists",
          name.length < 60 ? name.length : 60, name.text);
    }
    if (status != CF_OK) {
      return status;
    }
  }
  return CF_OK;
}
