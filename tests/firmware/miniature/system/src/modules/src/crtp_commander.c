// Setpoints that clients send: ports 3 and 7.
#include "crtp_commander.h"

#include <stddef.h>

#include "commander.h"
#include "crtp.h"

#define SET_SETPOINT_CHANNEL 0
#define META_COMMAND_CHANNEL 1

enum metaCommand_e {
  metaNotifySetpointsStop = 0,
  nMetaCommands,
};

struct notifySetpointsStopPacket {
  uint32_t remainValidMillisecs;
} __attribute__((packed));

typedef void (*metaCommandDecoder_t)(const void *data, size_t datalen);

static bool isInit;

static void notifySetpointsStopDecoder(const void *data, size_t datalen) {
  (void)data;
  if (datalen == sizeof(struct notifySetpointsStopPacket)) {
    commanderRelaxPriority();
  }
}

static const metaCommandDecoder_t metaCommandDecoders[] = {
    [metaNotifySetpointsStop] = notifySetpointsStopDecoder,
};

static void commanderCrtpCB(CRTPPacket *pk) {
  // the legacy command does not write all of it
  static setpoint_t setpoint;

  if (pk->port == CRTP_PORT_SETPOINT && pk->channel == 0) {
    crtpCommanderRpytDecodeSetpoint(&setpoint, pk);
    commanderSetSetpoint(&setpoint, COMMANDER_PRIORITY_CRTP);
  } else if (pk->port == CRTP_PORT_SETPOINT_GENERIC && pk->size > 0) {
    switch (pk->channel) {
      case SET_SETPOINT_CHANNEL:
        crtpCommanderGenericDecodeSetpoint(&setpoint, pk);
        commanderSetSetpoint(&setpoint, COMMANDER_PRIORITY_CRTP);
        break;
      case META_COMMAND_CHANNEL:
        if (pk->data[0] < nMetaCommands) {
          metaCommandDecoders[pk->data[0]](&pk->data[1], pk->size - 1);
        }
        break;
      default:
        break;
    }
  }
}

void crtpCommanderInit(void) {
  if (isInit) {
    return;
  }
  crtpInit();
  crtpRegisterPortCB(CRTP_PORT_SETPOINT, commanderCrtpCB);
  crtpRegisterPortCB(CRTP_PORT_SETPOINT_GENERIC, commanderCrtpCB);
  isInit = true;
}
