#include "fuzz.h"

#include <math.h>
#include <string.h>

#include "../bindings/c/check.h"
#include "commands.h"

#define BOOT_TICKS 1700
#define CLIMB_TICKS 1500

uint8_t fuzz_u8(fuzz_input_t *input) {
  uint8_t value;
  fuzz_bytes(input, &value, sizeof value);
  return value;
}

uint16_t fuzz_u16(fuzz_input_t *input) {
  uint16_t value;
  fuzz_bytes(input, &value, sizeof value);
  return value;
}

float fuzz_float(fuzz_input_t *input) {
  float value;
  fuzz_bytes(input, &value, sizeof value);
  return value;
}

void fuzz_bytes(fuzz_input_t *input, void *bytes, size_t size) {
  const size_t count = size < input->left ? size : input->left;
  memset(bytes, 0, size);
  if (count > 0) {
    memcpy(bytes, input->data, count);
    input->data += count;
    input->left -= count;
  }
}

// at rest on the floor, or held in the air
static cf_motion_t at_height(float height) {
  return (cf_motion_t){
      .position       = {0.0f, 0.0f, height},
      .quat_wxyz      = {1.0f, 0.0f, 0.0f, 0.0f},
      .rotation       = {1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f},
      .specific_force = {0.0f, 0.0f, 9.81f},
  };
}

static const cf_positioning_t POSITIONING[] = {
    CF_POSITIONING_MOCAP,      CF_POSITIONING_MOCAP,    CF_POSITIONING_FLOW,
    CF_POSITIONING_LIGHTHOUSE, CF_POSITIONING_LOCO_TWR, CF_POSITIONING_LOCO_TDOA3,
};
#define DRONES (int)(sizeof POSITIONING / sizeof POSITIONING[0])

static void make_hovering(cf_t *cf, int number) {
  cf_config_t config;
  CHECK(cf_config_default(&config, number % 2 == 0 ? CF_PLATFORM_CF2 : CF_PLATFORM_CF21BL) ==
        CF_OK);
  config.vehicle.positioning = POSITIONING[number];
  CHECK(cf_init(cf, &config) == CF_OK);

  cf_motion_t motion = at_height(0.0f);
  for (int i = 0; i < BOOT_TICKS; i++) {
    cf_tick(cf, &motion);
    if (i == BOOT_TICKS - 100) {
      cf_arm(cf, true);
    }
  }
  CHECK(cf_takeoff(cf, 1.0f, 1.0f, 0.0f, false) == CF_OK);
  for (int i = 0; i < CLIMB_TICKS; i++) {
    motion = at_height(fminf(1.0f, 0.001f * (float)i));
    cf_tick(cf, &motion);
  }
  CHECK(cf_supervisor_is_flying(&cf->onboard.supervisor));
}

void fuzz_hovering_drone(cf_t *cf, uint8_t number) {
  static cf_t drones[DRONES];
  static bool is_made = false;
  if (!is_made) {
    for (int i = 0; i < DRONES; i++) {
      make_hovering(&drones[i], i);
    }
    is_made = true;
  }
  memcpy(cf, &drones[number % DRONES], sizeof *cf);
}

static void check_plant(const cf_t *cf, const cf_motion_t *motion) {
  float force[3];
  float torque[3];
  cf_wrench(cf, motion, force, torque);
  for (int i = 0; i < 3; i++) {
    CHECK(isfinite(force[i]) && isfinite(torque[i]));
  }
  for (int i = 0; i < 4; i++) {
    CHECK(isfinite(cf->vehicle.rotors.rpm[i]) && isfinite(cf->vehicle.rotors.thrust[i]));
  }
  CHECK(isfinite(cf->vehicle.battery.voltage) && isfinite(cf->vehicle.battery.charge));
}

static void check_onboard(const cf_onboard_t *onboard) {
  if (onboard->fault == CF_FAULT_NONE) {
    CHECK(isfinite(onboard->estimate.position.x + onboard->estimate.position.z));
    CHECK(isfinite(onboard->control.thrust));
    return;
  }
  CHECK(onboard->supervisor.state == supervisorStateLocked);
  CHECK(strlen(cf_fault_text(onboard->fault)) > 10);
  for (int i = 0; i < 4; i++) {
    CHECK(onboard->motors.list[i] == 0);
  }
}

void fuzz_run(cf_t *cf, int ticks) {
  const cf_motion_t motion = at_height(1.0f);
  for (int i = 0; i < ticks; i++) {
    cf_tick(cf, &motion);
    check_plant(cf, &motion);
    check_onboard(&cf->onboard);
  }
}
