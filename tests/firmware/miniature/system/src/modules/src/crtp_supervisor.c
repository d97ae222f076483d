// The supervisor over the radio: port 9, questions on channel 0 and commands on channel 1.
#include "crtp_supervisor.h"

#include <stdbool.h>
#include <stdint.h>

#include "crtp.h"
#include "supervisor.h"

#define SUPERVISOR_CH_INFO 0
#define SUPERVISOR_CH_COMMAND 1
#define CMD_RESPONSE 0x80

enum infoQuery_e {
  INFO_CAN_ARM             = 0x01,
  INFO_IS_ARMED            = 0x02,
  INFO_AUTO_ARM            = 0x03,
  INFO_CAN_FLY             = 0x04,
  INFO_IS_FLYING           = 0x05,
  INFO_IS_TUMBLED          = 0x06,
  INFO_IS_LOCKED           = 0x07,
  INFO_IS_CRASHED          = 0x08,
  INFO_HL_CONTROL_ACTIVE   = 0x09,
  INFO_HL_TRAJ_FINISHED    = 0x0A,
  INFO_HL_CONTROL_DISABLED = 0x0B,
  INFO_BITFIELD            = 0x0C,
};

enum command_e {
  CMD_ARM_SYSTEM         = 0x01,
  CMD_RECOVER_SYSTEM     = 0x02,
  CMD_EMERGENCY_STOP     = 0x03,
  CMD_EMERGENCY_WATCHDOG = 0x04,
};

static bool isInit;

// States that can change between two updates are as of now, the others as of the last update.
static bool answer(uint8_t query) {
  switch (query) {
    case INFO_IS_ARMED:
      return supervisorIsArmed();
    case INFO_IS_CRASHED:
      return supervisorIsCrashed();
    default:
      return (supervisorGetInfoBitfield() >> (query - 1) & 1) != 0;
  }
}

static void infoProcess(CRTPPacket *p) {
  const uint8_t query = p->data[0];
  if (query < INFO_CAN_ARM || query > INFO_BITFIELD) {
    return;
  }
  p->data[0] = query | CMD_RESPONSE;
  if (query == INFO_BITFIELD) {
    const uint16_t bitfield = supervisorGetInfoBitfield();
    p->data[1]              = bitfield & 0xFF;
    p->data[2]              = bitfield >> 8;
    p->size                 = 3;
  } else {
    p->data[1] = answer(query);
    p->size    = 2;
  }
  crtpSendPacket(p);
}

static void commandProcess(CRTPPacket *p) {
  const uint8_t command = p->data[0];
  if (command == CMD_ARM_SYSTEM && p->size >= 2) {
    p->data[1] = supervisorRequestArming(p->data[1] != 0);
    p->data[2] = supervisorIsArmed();
  } else if (command == CMD_RECOVER_SYSTEM) {
    p->data[1] = supervisorRequestCrashRecovery(true);
    p->data[2] = !supervisorIsCrashed();
  } else {
    // not answered
    if (command == CMD_EMERGENCY_STOP) {
      supervisorRequestEmergencyStop();
    } else if (command == CMD_EMERGENCY_WATCHDOG) {
      supervisorNotifyEmergencyStopWatchdog();
    }
    return;
  }
  p->data[0] = command | CMD_RESPONSE;
  p->size    = 3;
  crtpSendPacket(p);
}

static void crtpSupervisorCB(CRTPPacket *p) {
  if (p->size == 0) {
    return;
  }
  switch (p->channel) {
    case SUPERVISOR_CH_INFO:
      infoProcess(p);
      break;
    case SUPERVISOR_CH_COMMAND:
      commandProcess(p);
      break;
    default:
      break;
  }
}

void crtpSupervisorInit(void) {
  if (isInit) {
    return;
  }
  crtpRegisterPortCB(CRTP_PORT_SUPERVISOR, crtpSupervisorCB);
  isInit = true;
}
