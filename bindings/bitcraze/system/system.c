#include "bitcraze/system/system.h"

// clang-format off: the operating system first, and some headers use what they do not include
#include "FreeRTOS.h"
#include "task.h"
#include "commander.h"
#include "controller.h"
#include "crtp_commander_high_level.h"
#include "estimator.h"
#include "estimator_kalman.h"
#include "peer_localization.h"
#include "supervisor.h"
// clang-format on

#include "bitcraze/conversions.h"
#include "bitcraze/rtos/hardware.h"
#include "bitcraze/rtos/kernel.h"
#include "library/work.h"

// Bits of cf_system_outputs_t.info, as log supervisor.info has them.
#define CAN_ARM 0x0001
#define IS_ARMED 0x0002
#define AUTO_ARM 0x0004
#define CAN_FLY 0x0008
#define IS_FLYING 0x0010
#define IS_TUMBLED 0x0020
#define IS_LOCKED 0x0040
#define IS_CRASHED 0x0080
#define HL_FINISHED 0x0200

#if CF_WITH_STABILIZER
#define HAS_OWN_LOOP true
#else
#define HAS_OWN_LOOP false
#endif

static bool is_attitude_reversion_off;

void stabilizerInit(StateEstimatorType estimator);
bool stabilizerTest(void);
void appInit(void) __attribute__((weak));             // null without an app that has a task
void crtpSupervisorInit(void) __attribute__((weak));  // null before 2026

bool deckGetRequiredKalmanEstimatorAttitudeReversionOff(void);
bool deckGetRequiredKalmanEstimatorAttitudeReversionOff(void) {
  return is_attitude_reversion_off;
}

// ------------------------------------------------------------------------------------------- boot

static bool passes(bool passed, const char *module) {
  if (!passed) {
    cf_library_print("SYS: the test of ");
    cf_library_print(module);
    cf_library_print(" failed\n");
  }
  return passed;
}

// Numbers of controllers differ between releases and forks, their names do not. Returns the
// checkout's number of one of ours, or -1.
static int their_controller(int ours) {
  switch (ours) {
    case api_ControllerTypePID:
      return (int)ControllerTypePID;
    case api_ControllerTypeMellinger:
      return (int)ControllerTypeMellinger;
    case api_ControllerTypeINDI:
      return (int)ControllerTypeINDI;
    case api_ControllerTypeBrescianini:
      return (int)ControllerTypeBrescianini;
#if HAVE_CONTROLLER_LEE
    case api_ControllerTypeLee:
      return (int)ControllerTypeLee;
#endif
#if CONFIG_CONTROLLER_OOT
    case api_ControllerTypeOot:
      return (int)ControllerTypeOot;
#endif
    default:
      return -1;
  }
}

// The order of the vehicle's system.c.
static cf_status_t boot(void *state CF_UNUSED, const cf_system_boot_t *how) {
  if (how->estimator < 0 || how->estimator >= (int)StateEstimatorType_COUNT ||
      (how->controller != api_ControllerTypeAutoSelect && their_controller(how->controller) < 0)) {
    return CF_ERR_UNKNOWN;
  }
  is_attitude_reversion_off = how->is_attitude_reversion_off;
  cf_rtos_boot();
  cf_link_boot();
  if (appInit != NULL) {
    cf_work_on("appInit");
    appInit();
  }
  cf_work_on("peerLocalizationInit");
  peerLocalizationInit();
  cf_work_on("commanderInit");
  commanderInit();
  if (crtpSupervisorInit != NULL) {
    crtpSupervisorInit();
  }
  cf_work_on("estimatorKalmanTaskInit");
  estimatorKalmanTaskInit();
  cf_work_on("stabilizerInit");
  stabilizerInit((StateEstimatorType)how->estimator);
  cf_work_on("the tests at boot");
  const bool all = passes(peerLocalizationTest(), "peer localization") &
                   passes(commanderTest(), "the commander") &
                   passes(estimatorKalmanTaskTest(), "the Kalman task") &
                   passes(stabilizerTest(), "the stabilizer");
  if (!all) {
    return CF_ERR_STATE;
  }
  // run tasks until they wait for their first packet or tick: then they handle a packet at once
  cf_work_on("the firmware's tasks");
  cf_rtos_run_ready();
  int      type;
  uint8_t *chosen = cf_library_variable(0, "stabilizer", "controller", &type);
  if (chosen != NULL) {
    *chosen = (uint8_t)(how->controller != api_ControllerTypeAutoSelect
                            ? their_controller(how->controller)
                            : (int)controllerGetType());
  }
  return CF_OK;
}

// ------------------------------------------------------------------------------------------- tick

// The table of their module is filled as ours is, place by place.
static void tell_peers(const cf_peer_t *peers) {
  for (int i = 0; i < CF_PEERS; i++) {
    __auto_type entry = peerLocalizationGetPositionByIdx((uint8_t)i);
    if (entry == NULL) {
      return;
    }
    entry->id            = peers[i].id;
    entry->pos.timestamp = peers[i].pos.timestamp;
    entry->pos.x         = peers[i].pos.x;
    entry->pos.y         = peers[i].pos.y;
    entry->pos.z         = peers[i].pos.z;
  }
}

static uint16_t bit(bool is_set, uint16_t value) {
  return is_set ? value : 0;
}

static uint16_t info(bool is_finished) {
  uint16_t bits = 0;
  bits |= bit(supervisorCanArm(), CAN_ARM);
  bits |= bit(supervisorIsArmed(), IS_ARMED);
#if !CONFIG_MOTORS_REQUIRE_ARMING
  bits |= AUTO_ARM;
#endif
  bits |= bit(supervisorCanFly(), CAN_FLY);
  bits |= bit(supervisorIsFlying(), IS_FLYING);
  bits |= bit(supervisorIsTumbled(), IS_TUMBLED);
  bits |= bit(supervisorIsLocked(), IS_LOCKED);
#if HAVE_SUPERVISOR_CRASHED
  bits |= bit(supervisorIsCrashed(), IS_CRASHED);
#endif
  return bits | bit(is_finished, HL_FINISHED);
}

// The checkout's high-level commander publishes its group mask only as a parameter.
static void tell_groups(cf_system_outputs_t *outputs) {
  static const uint8_t *mask CF_LIBRARY_KEEP = NULL;
  static bool is_known       CF_LIBRARY_KEEP = false;
  if (!is_known) {
    int type;
    mask     = cf_library_variable(0, "hlCommander", "groupmask", &type);
    is_known = true;
  }
  if (mask != NULL) {
    outputs->group_mask = *mask;
  }
}

static void tick(void *state CF_UNUSED, const cf_system_inputs_t *inputs,
                 cf_system_outputs_t *outputs) {
  cf_system_sensors.data           = cf_checkout_sensors(inputs->sensors);
  cf_system_sensors.are_calibrated = inputs->are_calibrated;
  cf_system_wanted                 = (cf_system_wanted_t){
      .controller = inputs->controller, .estimator = inputs->estimator, .is_held = inputs->is_held};
  cf_hardware_battery = inputs->battery_voltage;
  if (cf_avoidance_is_enabled(NULL)) {
    tell_peers(inputs->peers);
  }
  cf_rtos_set_time(inputs->now_ms);
  for (int i = 0; i < inputs->count; i++) {
    cf_system_enqueue(&inputs->queue[i]);
  }
  cf_rtos_signal_data_ready();
  cf_work_on("the firmware's tasks");
  cf_rtos_run_ready();

  cf_work_on("what the firmware's modules tell");
  outputs->step = cf_system_seen.step;
  cf_api_state(&outputs->estimate, &cf_system_seen.estimate);
  cf_api_setpoint(&outputs->setpoint, &cf_system_seen.setpoint);
  cf_api_control(&outputs->control, &cf_system_seen.control);
  cf_system_motors(inputs->battery_voltage, &outputs->motors);
  outputs->controller = (int)controllerGetType();
  outputs->estimator  = (int)stateEstimatorGetType();
  outputs->priority   = commanderGetActivePriority();
  outputs->is_blocked = crtpCommanderHighLevelIsBlocked();
  // old planners look into a trajectory that they do not have
  outputs->is_finished =
      crtpCommanderHighLevelIsStopped() || crtpCommanderHighLevelIsTrajectoryFinished();
  tell_groups(outputs);
  outputs->state = cf_system_supervisor_state;
  outputs->info  = info(outputs->is_finished);
}

// --------------------------------------------------------------------------------------- requests

static bool set_setpoint(void *state CF_UNUSED, const api_setpoint_t *setpoint, int priority,
                         uint32_t now_ms CF_UNUSED) {
  setpoint_t theirs;
  cf_checkout_setpoint(&theirs, setpoint);
  commanderSetSetpoint(&theirs, priority);
  return commanderGetActivePriority() <= priority;
}

static int packet(void *state CF_UNUSED, uint8_t port, uint8_t channel, const uint8_t *data,
                  int length, uint8_t reply[CF_SYSTEM_PACKET_BYTES], uint32_t now_ms CF_UNUSED) {
  return cf_link_packet(port, channel, data, length, reply);
}

static bool request(void *state CF_UNUSED, cf_system_request_t what, uint32_t now_ms) {
  switch (what) {
    case CF_SYSTEM_ARM:
      return supervisorRequestArming(true);
    case CF_SYSTEM_DISARM:
      return supervisorRequestArming(false);
    case CF_SYSTEM_RECOVER:
#if HAVE_SUPERVISOR_CRASHED
      return supervisorRequestCrashRecovery(true);
#else
      return false;
#endif
    case CF_SYSTEM_RELAX:
      commanderRelaxPriority();
      return true;
    case CF_SYSTEM_EMERGENCY_STOP:
      cf_link_stop_for_good();
      return true;
    case CF_SYSTEM_FEED_WATCHDOG:
      cf_link_feed_watchdog(now_ms);
      return true;
  }
  return false;
}

static bool read_trajectory(void *state CF_UNUSED, uint32_t offset, uint32_t length,
                            uint8_t *data) {
  return cf_link_read_trajectory(offset, length, data);
}

static bool write_trajectory(void *state CF_UNUSED, uint32_t offset, uint32_t length,
                             const uint8_t *data) {
  return cf_link_write_trajectory(offset, length, data);
}

static cf_system_t table CF_LIBRARY_KEEP = {.modules = NULL};

const cf_system_t *cf_system(void) {
  table = (cf_system_t){
      .modules          = CF_SYSTEM_MODULES,
      .has_own_loop     = HAS_OWN_LOOP,
      .boot             = boot,
      .tick             = tick,
      .set_setpoint     = set_setpoint,
      .packet           = packet,
      .request          = request,
      .read_trajectory  = read_trajectory,
      .write_trajectory = write_trajectory,
  };
  return &table;
}
