// A whole drone on a bench: it boots, gets ready, and survives whatever the simulator feeds it.

#include "commands.h"

#include <math.h>
#include <string.h>

#include "check.h"
#include "crazyflie.h"
#include "mujoco_plugin/attributes.h"

static const cf_motion_t AT_REST = {.position       = {0.0f, 0.0f, 0.0145f},
                                    .quat_wxyz      = {1.0f, 0.0f, 0.0f, 0.0f},
                                    .rotation       = {1, 0, 0, 0, 1, 0, 0, 0, 1},
                                    .specific_force = {0.0f, 0.0f, 9.81f}};

static void boot(cf_t *cf, cf_platform_t platform) {
  cf_config_t config;
  CHECK(cf_config_default(&config, platform) == CF_OK);
  CHECK(cf_init(cf, &config) == CF_OK);
}

static void rest(cf_t *cf, int ticks) {
  for (int i = 0; i < ticks; i++) {
    cf_tick(cf, &AT_REST);
  }
}

static void test_gets_ready_by_itself_or_after_arming(void) {
  for (int platform = 0; platform < CF_PLATFORM_COUNT; platform++) {
    static cf_t cf;
    boot(&cf, (cf_platform_t)platform);
    rest(&cf, 2000);
    if (cf_platform_facts((cf_platform_t)platform)->requires_arming) {
      CHECK(!cf_supervisor_are_motors_allowed(&cf.onboard.supervisor));
      CHECK(cf_arm(&cf, true) == CF_OK);
      rest(&cf, 100);
    }
    CHECK(cf_supervisor_are_motors_allowed(&cf.onboard.supervisor));
    CHECK(cf.onboard.fault == CF_FAULT_NONE);
  }
}

static void test_commands_are_blocked_before_the_drone_is_ready(void) {
  static cf_t cf;
  boot(&cf, CF_PLATFORM_CF2);
  rest(&cf, 1700 - 100);
  CHECK(cf_takeoff(&cf, 1.0f, 2.0f, 0.0f, true) == CF_ERR_BLOCKED);
  rest(&cf, 500);
  CHECK(cf_takeoff(&cf, 1.0f, 2.0f, 0.0f, true) == CF_OK);
  CHECK(cf_takeoff(&cf, 1.0f, 2.0f, 0.0f, true) == CF_ERR_STATE);
  rest(&cf, 1000);
  CHECK(cf.onboard.motors.list[0] > 0);
}

static void test_a_motion_that_is_no_number_stops_the_drone(void) {
  const float bad[] = {NAN, INFINITY, -INFINITY, 3e38f};
  for (int k = 0; k < 4; k++) {
    static cf_t cf;
    boot(&cf, CF_PLATFORM_CF2);
    rest(&cf, 2000);
    CHECK(cf_takeoff(&cf, 1.0f, 2.0f, 0.0f, true) == CF_OK);
    rest(&cf, 500);
    CHECK(cf.onboard.motors.list[0] > 0);

    cf_motion_t motion = AT_REST;
    motion.position[1] = bad[k];
    cf_tick(&cf, &motion);
    CHECK(cf.onboard.fault == CF_FAULT_MOTION);
    CHECK(cf.onboard.motors.list[0] == 0);
    CHECK(cf_supervisor_is_locked(&cf.onboard.supervisor));

    rest(&cf, 3000);
    CHECK(cf.onboard.fault == CF_FAULT_MOTION);
    cf_reboot(&cf);
    rest(&cf, 2000);
    CHECK(cf.onboard.fault == CF_FAULT_NONE);
  }
}

static void test_wrench_is_always_finite(void) {
  const float bad[] = {0.0f, NAN, INFINITY, 1e30f};
  static cf_t cf;
  boot(&cf, CF_PLATFORM_CF21BL);
  for (int k = 0; k < 4; k++) {
    cf_motion_t motion = AT_REST;
    motion.velocity[0] = bad[k];
    motion.rates[2]    = bad[3 - k];
    float force[3], torque[3];
    cf_wrench(&cf, &motion, force, torque);
    for (int i = 0; i < 3; i++) {
      CHECK(isfinite(force[i]) && isfinite(torque[i]));
    }
  }
}

static void test_setpoints_that_are_no_numbers_are_refused(void) {
  static cf_t cf;
  boot(&cf, CF_PLATFORM_CF2);
  rest(&cf, 2000);
  const float bad[] = {NAN, INFINITY, -INFINITY};
  for (int k = 0; k < 3; k++) {
    CHECK(cf_send_position(&cf, bad[k], 0, 1, 0) == CF_ERR_VALUE);
    CHECK(cf_send_hover(&cf, 0, bad[k], 0, 1) == CF_ERR_VALUE);
    CHECK(cf_send_velocity_world(&cf, 0, 0, bad[k], 0) == CF_ERR_VALUE);
    CHECK(cf_takeoff(&cf, bad[k], 1, 0, true) == CF_ERR_VALUE);
    CHECK(cf_takeoff(&cf, 1, bad[k], 0, true) == CF_ERR_VALUE);
    CHECK(cf_go_to(&cf, 0, 0, bad[k], 0, 1, false, false) == CF_ERR_VALUE);
    CHECK(cf_send_external_position(&cf, 0, 0, bad[k]) == CF_ERR_VALUE);
  }
}

static void test_a_snapshot_is_a_memcpy(void) {
  static cf_t cf, copy;
  boot(&cf, CF_PLATFORM_CF2);
  rest(&cf, 2000);
  CHECK(cf_takeoff(&cf, 1.0f, 2.0f, 0.0f, true) == CF_OK);
  rest(&cf, 123);
  memcpy(&copy, &cf, sizeof cf);
  rest(&cf, 500);
  rest(&copy, 500);
  CHECK(memcmp(&copy, &cf, sizeof cf) == 0);
}

static void test_attributes_refuse_every_bad_text(void) {
  const char *bad[] = {"nan", "-1", "inf", "1e99", "x", "cf3", " ", "0x", "1.5.5", "--", "2,5"};
  for (int i = 0; i < cf_attribute_count(); i++) {
    // remarks for Python are any text, and the list of parameters may be empty
    const bool is_remark  = strncmp(cf_attribute_name(i), "motor_ctrl", 10) == 0;
    const bool is_vehicle = strcmp(cf_attribute_name(i), "vehicle") == 0;
    for (size_t k = 0; k < sizeof bad / sizeof bad[0] && !is_remark; k++) {
      if (is_vehicle && strcmp(bad[k], " ") == 0) {
        continue;
      }
      char        message[CF_ATTRIBUTE_MESSAGE_BYTES] = "";
      cf_config_t config;
      cf_config_default(&config, CF_PLATFORM_CF2);
      CHECK(cf_attribute_set(&config, i, bad[k], message) ==
            (is_vehicle ? CF_ERR_UNKNOWN : CF_ERR_VALUE));
      CHECK(strstr(message, cf_attribute_name(i)) != NULL);
      CHECK(strstr(message, bad[k]) != NULL);
      CHECK(strstr(message, "allowed: ") != NULL);
    }
  }
}

static void test_nothing_else_than_known_numbers_boots(void) {
  static cf_t cf;
  cf_config_t config;
  CHECK(cf_config_default(&config, (cf_platform_t)7) == CF_ERR_UNKNOWN);
  cf_config_default(&config, CF_PLATFORM_CF2);
  config.controller = 99;
  CHECK(cf_init(&cf, &config) == CF_ERR_UNKNOWN);
  cf_config_default(&config, CF_PLATFORM_CF2);
  config.estimator = StateEstimatorType_COUNT;
  CHECK(cf_init(&cf, &config) == CF_ERR_UNKNOWN);
  cf_config_default(&config, CF_PLATFORM_CF2);
  config.provider = 1;
  CHECK(cf_init(&cf, &config) == CF_ERR_UNKNOWN);
}

int main(void) {
  test_gets_ready_by_itself_or_after_arming();
  test_commands_are_blocked_before_the_drone_is_ready();
  test_a_motion_that_is_no_number_stops_the_drone();
  test_wrench_is_always_finite();
  test_setpoints_that_are_no_numbers_are_refused();
  test_a_snapshot_is_a_memcpy();
  test_attributes_refuse_every_bad_text();
  test_nothing_else_than_known_numbers_boots();
  return 0;
}
