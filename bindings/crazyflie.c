#include "crazyflie.h"

#include <math.h>
#include <string.h>

#include "position_sensing.h"
#include "providers.h"

_Static_assert(sizeof(cf_t) % sizeof(double) == 0, "MuJoCo stores states as doubles");
_Static_assert(offsetof(cf_t, provider_state) + CF_PROVIDER_STATE_BYTES == sizeof(cf_t),
               "the block of the provider may go on behind the struct");

#define MAX_RADIO_ID 255
#define MAX_POSITION 1e4f  // [m], farther away than this the simulation has run wild

cf_status_t cf_config_default(cf_config_t *config, cf_platform_t platform) {
  memset(config, 0, sizeof *config);
  config->platform   = platform;
  config->controller = ControllerTypeAutoSelect;
  config->estimator  = StateEstimatorTypeAutoSelect;
  return cf_vehicle_default_config(&config->vehicle, platform);
}

// A library's block may be longer than the member, which every drone has.
static int block_bytes(int provider) {
  const int needed = cf_provider_block_bytes(provider);
  return needed > CF_PROVIDER_STATE_BYTES ? needed : CF_PROVIDER_STATE_BYTES;
}

int cf_state_bytes(int provider) {
  const bool exists = provider >= 0 && provider < cf_provider_count();
  return exists ? (int)offsetof(cf_t, provider_state) + block_bytes(provider) : 0;
}

const cf_provider_t *cf_provider_of(cf_t *cf) {
  const cf_provider_t *provider = cf_provider(cf->config.provider);
  if (provider == NULL) {
    cf_onboard_fail_because(&cf->onboard, "no copy of the provider can be loaded for this thread");
  }
  return cf->onboard.fault != CF_FAULT_SOFTWARE ? provider : NULL;
}

// --------------------------------------------------------------------------------------- booting

// Returns whether this changed anything.
static bool set_parameter(const cf_provider_t *provider, void *provider_state, const char *group,
                          const char *name, const void *value, size_t bytes) {
  bool           is_changed = false;
  cf_variables_t tables[CF_PROVIDER_MAX_TABLES];
  const int      count = provider->parameters(tables, CF_PROVIDER_MAX_TABLES);
  for (int i = 0; i < count && i < CF_PROVIDER_MAX_TABLES; i++) {
    for (int k = 0; k < tables[i].count; k++) {
      const cf_variable_t *row = &tables[i].rows[k];
      if (strcmp(row->group, group) == 0 && strcmp(row->name, name) == 0) {
        char *place = (char *)provider_state + tables[i].base + row->offset;
        is_changed  = is_changed || memcmp(place, value, bytes) != 0;
        memcpy(place, value, bytes);
      }
    }
  }
  return is_changed;
}

// Tells the Kalman filter where the drone stands. Returns whether it did not know.
static bool tell_start(cf_t *cf, const cf_provider_t *provider) {
  static const char *const NAMES[4] = {"initialX", "initialY", "initialZ", "initialYaw"};
  const float             *position = cf->config.start_position;
  const float values[4]             = {position[0], position[1], position[2], cf->config.start_yaw};
  bool        is_changed            = false;
  for (int i = 0; i < 4; i++) {
    const bool was_other = set_parameter(provider, cf->provider_state, "kalman", NAMES[i],
                                         &values[i], sizeof values[i]);
    is_changed           = is_changed || was_other;
  }
  return is_changed;
}

// Never 0, which names no peer. Drones whose ids are 255 apart share an address.
static uint8_t radio_id(const cf_config_t *config) {
  return (uint8_t)(config->radio_id != 0 ? config->radio_id : config->id % MAX_RADIO_ID + 1);
}

// What tells the position asks for the Kalman filter, as decks do at boot. Poses by radio do not on
// the vehicle; there a client sets stabilizer.estimator, which is taken for granted here.
static int boot_estimator(const cf_config_t *config) {
  if (config->estimator != StateEstimatorTypeAutoSelect) {
    return config->estimator;
  }
  return config->vehicle.positioning == CF_POSITIONING_NONE ? StateEstimatorTypeComplementary
                                                            : StateEstimatorTypeKalman;
}

static cf_status_t boot(cf_t *cf) {
  const cf_config_t *config = &cf->config;
  memset(&cf->onboard, 0, sizeof cf->onboard);
  memset(cf->provider_state, 0, (size_t)block_bytes(config->provider));
  cf->wants_peers               = false;
  const cf_provider_t *provider = cf_provider_of(cf);
  if (provider == NULL) {
    return CF_ERR_STATE;
  }
  const cf_status_t status = provider->init(cf->provider_state, config->platform, 0);
  if (status != CF_OK) {
    return status;
  }
  if (cf->onboard.fault != CF_FAULT_NONE) {
    return CF_ERR_STATE;
  }

  tell_start(cf, provider);
  const cf_positioning_t positioning = config->vehicle.positioning;
  const bool             has_loco    = positioning == CF_POSITIONING_LOCO_TWR ||
                                       positioning == CF_POSITIONING_LOCO_TDOA2 ||
                                       positioning == CF_POSITIONING_LOCO_TDOA3;
  const cf_boot_t        onboard     = {
      .controller                = config->controller,
      .estimator                 = boot_estimator(config),
      .auto_arming               = !cf_platform_facts(config->platform)->requires_arming,
      .acc_trim_pitch            = config->acc_trim_pitch,
      .acc_trim_roll             = config->acc_trim_roll,
      .is_attitude_reversion_off = has_loco && config->loco_is_planar != 0,
      .platform                  = config->platform,
      .seed                      = config->seed,
      .serial                    = config->id,
      .radio_id                  = radio_id(config),
  };
  const cf_status_t booted = cf_onboard_init(&cf->onboard, provider, cf->provider_state, &onboard);
  if (booted != CF_OK) {
    return booted;
  }
  if (provider->system != NULL && tell_start(cf, provider)) {
    // the checkout's boot resets the parameters, so that the filter restarts from these, as on the
    // vehicle when a client sets them
    const uint8_t yes = 1;
    set_parameter(provider, cf->provider_state, "kalman", "resetEstimation", &yes, sizeof yes);
  }
  cf_position_boot(cf);
  return cf->onboard.fault == CF_FAULT_NONE ? CF_OK : CF_ERR_STATE;
}

static void fill_eeprom(cf_t *cf) {
  const cf_configuration_t configuration = {
      .channel    = CF_RADIO_CHANNEL,
      .speed      = CF_RADIO_SPEED,
      .pitch_trim = cf->config.acc_trim_pitch,
      .roll_trim  = cf->config.acc_trim_roll,
      .address    = CF_RADIO_ADDRESS | radio_id(&cf->config),
  };
  cf_configuration_pack(cf->configuration, &configuration);
}

cf_status_t cf_init(cf_t *cf, const cf_config_t *config) {
  const cf_config_t copy = *config;  // the caller may pass the drone's own
  if (cf_provider_name(copy.provider) == NULL) {
    return CF_ERR_UNKNOWN;  // the size of the state depends on the provider
  }
  memset(cf, 0, (size_t)cf_state_bytes(copy.provider));
  cf->config = copy;
  if (cf_platform_facts(copy.platform) == NULL) {
    return CF_ERR_UNKNOWN;
  }
  if (copy.radio_id > MAX_RADIO_ID) {
    return CF_ERR_VALUE;
  }
  fill_eeprom(cf);
  const cf_status_t status = cf_vehicle_init(&cf->vehicle, &copy.vehicle, copy.seed, copy.id);
  return status == CF_OK ? boot(cf) : status;
}

void cf_reboot(cf_t *cf) {
  // succeeded with the same configuration before, so that only the provider can have failed
  if (boot(cf) != CF_OK) {
    cf_onboard_fail_because(&cf->onboard, "the provider failed at boot");
  }
}

// ------------------------------------------------------------------------------------------ tick

static bool is_sane(const cf_motion_t *motion) {
  float sum = 0.0f;
  for (int i = 0; i < 3; i++) {
    sum += fabsf(motion->position[i]) + fabsf(motion->velocity[i]) + fabsf(motion->rates[i]) +
           fabsf(motion->quat_wxyz[i]) + fabsf(motion->specific_force[i]);
  }
  return isfinite(sum) && fabsf(motion->position[0]) < MAX_POSITION &&
         fabsf(motion->position[1]) < MAX_POSITION && fabsf(motion->position[2]) < MAX_POSITION;
}

void cf_sense(cf_t *cf, const cf_motion_t *motion, cf_hardware_t *hardware) {
  memset(hardware, 0, sizeof *hardware);
  hardware->battery_voltage = cf->vehicle.battery.voltage;
  if (!is_sane(motion)) {
    cf_onboard_fail(&cf->onboard, CF_FAULT_MOTION);
    return;
  }
  if (cf->injected.is_battery_cut) {
    cf_onboard_fail(&cf->onboard, CF_FAULT_POWER);
    return;
  }
  cf_vehicle_imu(&cf->vehicle, motion->rates, motion->specific_force, &hardware->gyro,
                 &hardware->acc);
  if (cf->injected.is_sensing_wrong) {
    cf_injected_spoil_imu(&cf->injected, &hardware->gyro, &hardware->acc);
  }
  hardware->has_pressure = cf_vehicle_barometer(&cf->vehicle, motion->position[2],
                                                &hardware->pressure, &hardware->temperature);
  cf_vehicle_feel_air(&cf->vehicle, motion->position, motion->rotation, motion->velocity);
  cf_position_sense(cf, motion);
}

void cf_think(cf_t *cf, const cf_hardware_t *hardware) {
  const cf_provider_t *provider = cf_provider_of(cf);
  const bool           works    = provider != NULL;
  if (works && provider->begin != NULL) {
    provider->begin(cf->provider_state);
  }
  // for a drone that was stopped time goes on, and nothing else
  cf_onboard_tick(&cf->onboard, provider, cf->provider_state, hardware);
  cf->wants_peers = works && provider->collision_avoidance_is_enabled(cf->provider_state);
  if (works && provider->end != NULL) {
    provider->end(cf->provider_state);
  }
}

void cf_actuate(cf_t *cf) {
  if (cf->injected.is_battery_cut) {
    cf_rotors_step(&cf->vehicle.rotors, cf->onboard.motors.list, 0.0f);
  } else {
    cf_vehicle_actuate(&cf->vehicle, cf->onboard.motors.list);
  }
}

void cf_tick(cf_t *cf, const cf_motion_t *motion) {
  cf_hardware_t hardware;
  cf_sense(cf, motion, &hardware);
  cf_think(cf, &hardware);
  cf_actuate(cf);
}

void cf_wrench(const cf_t *cf, const cf_motion_t *motion, float force[3], float torque[3]) {
  cf_vehicle_wrench(&cf->vehicle, motion->rotation, motion->velocity, motion->rates, force, torque);
  const float sum = (force[0] + force[1] + force[2]) + (torque[0] + torque[1] + torque[2]);
  if (!isfinite(sum)) {
    memset(force, 0, 3 * sizeof *force);
    memset(torque, 0, 3 * sizeof *torque);
  }
}

// ------------------------------------------------------------------------------- the other drones

void cf_tell_peers(cf_t *cf, const cf_peer_t *peers, int count) {
  cf_peer_localization_tell_all(&cf->onboard.peers, peers, count, cf->onboard.tick);
}

// ------------------------------------------------------------------------------------- variables

bool cf_is_out(const cf_t *cf) {
  const cf_supervisor_t *supervisor = &cf->onboard.supervisor;
  return cf->onboard.fault != CF_FAULT_NONE || cf_supervisor_is_crashed(supervisor) ||
         cf_supervisor_is_locked(supervisor);
}

int cf_count_out(const cf_t *const *drones, int count) {
  int out = 0;
  for (int i = 0; i < count; i++) {
    out += cf_is_out(drones[i]) ? 1 : 0;
  }
  return out;
}

void cf_refresh_logs(cf_t *first, int count, ptrdiff_t stride) {
  for (int i = 0; i < count; i++) {
    cf_t *cf = (cf_t *)(void *)((char *)first + i * stride);
    cf_onboard_refresh_logs(&cf->onboard);
    cf_contacts_refresh(&cf->contacts, cf->onboard.tick);
    const cf_provider_t *provider = cf_provider_of(cf);
    if (provider != NULL && provider->refresh_logs != NULL) {
      provider->refresh_logs(cf->provider_state);
    }
  }
}

void cf_copy_logs(uint8_t *to, cf_t *first, int count, ptrdiff_t stride, const uint32_t *bounds,
                  int stretches) {
  cf_refresh_logs(first, count, stride);
  for (int i = 0; i < count; i++) {
    const char *memory = (const char *)first + i * stride;
    for (int k = 0; k < stretches; k++) {
      const size_t size = bounds[2 * k + 1] - bounds[2 * k];
      memcpy(to, memory + bounds[2 * k], size);
      to += size;
    }
  }
}

void cf_gather_floats(double *to, const cf_t *first, int count, ptrdiff_t stride,
                      const uint32_t *offsets, int variables) {
  const uint8_t *drone = (const uint8_t *)first;
  for (int i = 0; i < count; i++, drone += stride) {
    for (int k = 0; k < variables; k++) {
      float value;
      memcpy(&value, drone + offsets[k], sizeof value);
      *to++ = value;
    }
  }
}

void cf_parameter_written(cf_t *cf, const char *group, const char *name) {
  const cf_provider_t *provider = cf_provider_of(cf);
  if (provider != NULL && provider->parameter_written != NULL) {
    provider->parameter_written(cf->provider_state, group, name);
  }
}

static int add(cf_variables_t *tables, int capacity, int count, cf_variables_t table, size_t base) {
  if (count < capacity) {
    table.base += (uint32_t)base;
    tables[count] = table;
  }
  return count + 1;
}

static int add_provider(cf_variables_t *tables, int capacity, int count,
                        int (*list)(cf_variables_t *tables, int capacity)) {
  cf_variables_t own[CF_PROVIDER_MAX_TABLES];
  const int      found = list(own, CF_PROVIDER_MAX_TABLES);
  for (int i = 0; i < found && i < CF_PROVIDER_MAX_TABLES; i++) {
    count = add(tables, capacity, count, own[i], offsetof(cf_t, provider_state));
  }
  return count;
}

#define ONBOARD(member_) (offsetof(cf_t, onboard) + offsetof(cf_onboard_t, member_))

int cf_parameters(int provider, cf_variables_t *tables, int capacity) {
  if (cf_provider(provider) == NULL) {
    return 0;
  }
  int n = 0;
  n     = add(tables, capacity, n, cf_onboard_parameters(), offsetof(cf_t, onboard));
  n     = add(tables, capacity, n, cf_supervisor_parameters(), ONBOARD(supervisor));
  n     = add(tables, capacity, n, cf_power_management_parameters(), ONBOARD(power));
  n     = add(tables, capacity, n, cf_health_parameters(), ONBOARD(health));
  n     = add(tables, capacity, n, cf_system_variables_parameters(), ONBOARD(system));
  n     = add(tables, capacity, n, cf_commander_parameters(), ONBOARD(commander));
  n     = add(tables, capacity, n, cf_rpyt_parameters(), ONBOARD(rpyt));
  n     = add(tables, capacity, n, cf_cppm_parameters(), ONBOARD(cppm));
  n     = add(tables, capacity, n, cf_high_level_commander_parameters(), ONBOARD(high_level));
  n     = add(tables, capacity, n, cf_estimator_parameters(), ONBOARD(estimator));
  n     = add(tables, capacity, n, cf_sensors_parameters(), ONBOARD(sensors));
  n     = add(tables, capacity, n, cf_decks_parameters(), ONBOARD(decks));
  n     = add(tables, capacity, n, cf_flow_driver_parameters(), ONBOARD(decks.flow));
  n     = add(tables, capacity, n, cf_lighthouse_deck_parameters(), ONBOARD(decks.lighthouse));
  n     = add(tables, capacity, n, cf_loco_deck_parameters(), ONBOARD(decks.loco));
  return add_provider(tables, capacity, n, cf_provider(provider)->parameters);
}

int cf_logs(int provider, cf_variables_t *tables, int capacity) {
  if (cf_provider(provider) == NULL) {
    return 0;
  }
  int n = 0;
  n     = add(tables, capacity, n, cf_onboard_logs(), offsetof(cf_t, onboard));
  n     = add(tables, capacity, n, cf_supervisor_logs(), ONBOARD(supervisor));
  n     = add(tables, capacity, n, cf_power_management_logs(), ONBOARD(power));
  n     = add(tables, capacity, n, cf_health_logs(), ONBOARD(health));
  n     = add(tables, capacity, n, cf_system_variables_logs(), ONBOARD(system));
  n     = add(tables, capacity, n, cf_sensors_logs(), ONBOARD(sensors));
  n     = add(tables, capacity, n, cf_flow_driver_logs(), ONBOARD(decks.flow));
  n     = add(tables, capacity, n, cf_ranger_driver_logs(), ONBOARD(decks.ranger));
  n     = add(tables, capacity, n, cf_lighthouse_deck_logs(), ONBOARD(decks.lighthouse));
  n     = add(tables, capacity, n, cf_loco_deck_logs(), ONBOARD(decks.loco));
  n     = add_provider(tables, capacity, n, cf_provider(provider)->logs);
  if (cf_provider(provider)->system == NULL) {
    n = add(tables, capacity, n, cf_estimator_logs(), ONBOARD(estimator));  // ends group kalman
  }
  n = add(tables, capacity, n, cf_vehicle_logs(), offsetof(cf_t, vehicle));
  return add(tables, capacity, n, cf_contacts_logs(), offsetof(cf_t, contacts));
}
