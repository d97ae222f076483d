/* The radio protocol's middle, in place of crtp.c, mem.c and the localization service: packets go
 * to the callback or the queue of their port, and what is sent back is kept for the asker. */
#include "bitcraze/system/system.h"

#include <string.h>

// clang-format off: the operating system first
#include "FreeRTOS.h"
#include "queue.h"
#include "task.h"
#include "crtp.h"
#include "mem.h"
// clang-format on

#include "bitcraze/rtos/kernel.h"

#define PORTS 16
#define QUEUED 16  // packets of a port
#define QUEUES 2   // ports whose tasks wait for packets: the high-level commander, and an app
#define READ_AT_ONCE 24

typedef struct {
  int           port;
  QueueHandle_t handle;
  StaticQueue_t storage;
  uint8_t       packets[QUEUED * sizeof(CRTPPacket)];
} port_queue_t;

static CrtpCallback              callbacks[PORTS];
static port_queue_t              queues[QUEUES];
static int                       n_queues;
static CRTPPacket                answer;
static bool                      has_answer;
static const MemoryHandlerDef_t *trajectories;
static bool                      is_stopped_for_good;
static uint32_t                  watchdog_tick;  // 0: not started

void cf_link_boot(void) {
  memset(callbacks, 0, sizeof callbacks);
  n_queues = 0;
}

// --------------------------------------------------------------------------------- what tasks call

void crtpInit(void) {
}

bool crtpTest(void) {
  return true;
}

bool crtpIsConnected(void) {
  return true;
}

int crtpReset(void) {
  return 0;
}

int crtpGetFreeTxQueuePackets(void) {
  return QUEUED;
}

void crtpRegisterPortCB(int port, CrtpCallback callback) {
  if (port >= 0 && port < PORTS) {
    callbacks[port] = callback;
  }
}

static port_queue_t *queue_of(int port) {
  for (int i = 0; i < n_queues; i++) {
    if (queues[i].port == port) {
      return &queues[i];
    }
  }
  return NULL;
}

void crtpInitTaskQueue(CRTPPort port) {
  if (queue_of((int)port) != NULL) {
    return;
  }
  if (n_queues == QUEUES) {
    cf_library_fail("more than 2 tasks wait for packets");
  }
  port_queue_t *queue = &queues[n_queues++];
  queue->port         = (int)port;
  queue->handle = xQueueCreateStatic(QUEUED, sizeof(CRTPPacket), queue->packets, &queue->storage);
}

static int receive(CRTPPort port, CRTPPacket *packet, TickType_t wait) {
  port_queue_t *queue = queue_of((int)port);
  return queue != NULL ? (int)xQueueReceive(queue->handle, packet, wait) : 0;
}

int crtpReceivePacket(CRTPPort port, CRTPPacket *packet) {
  return receive(port, packet, 0);
}

int crtpReceivePacketBlock(CRTPPort port, CRTPPacket *packet) {
  return receive(port, packet, portMAX_DELAY);
}

int crtpReceivePacketWait(CRTPPort port, CRTPPacket *packet, int wait) {
  return receive(port, packet, (TickType_t)wait);
}

int crtpSendPacket(CRTPPacket *packet) {
  answer     = *packet;
  has_answer = true;
  return 1;
}

int crtpSendPacketBlock(CRTPPacket *packet) {
  return crtpSendPacket(packet);
}

void memoryRegisterHandler(const MemoryHandlerDef_t *handler) {
  if (handler->type == MEM_TYPE_TRAJ) {
    trajectories = handler;
  }
}

bool     locSrvIsEmergencyStopRequested(void);
uint32_t locSrvGetEmergencyStopWatchdogNotificationTick(void);

bool locSrvIsEmergencyStopRequested(void) {
  return is_stopped_for_good;
}

uint32_t locSrvGetEmergencyStopWatchdogNotificationTick(void) {
  return watchdog_tick;
}

// ------------------------------------------------------------------------- what the adapter calls

void cf_link_stop_for_good(void) {
  is_stopped_for_good = true;
}

void cf_link_feed_watchdog(uint32_t now_ms) {
  watchdog_tick = now_ms;
}

int cf_link_packet(uint8_t port, uint8_t channel, const uint8_t *data, int length,
                   uint8_t reply[CF_SYSTEM_PACKET_BYTES]) {
  port_queue_t *queue = queue_of(port);
  if (port >= PORTS || (callbacks[port] == NULL && queue == NULL)) {
    return -1;
  }
  CRTPPacket packet;
  memset(&packet, 0, sizeof packet);
  packet.size   = (uint8_t)length;
  packet.header = (uint8_t)CRTP_HEADER(port, channel);
  memcpy(packet.data, data, (size_t)length);

  has_answer = false;
  if (callbacks[port] != NULL) {
    callbacks[port](&packet);
  } else {
    xQueueSend(queue->handle, &packet, 0);
    cf_rtos_run_ready();
  }
  if (!has_answer || answer.size > CF_SYSTEM_PACKET_BYTES) {
    return 0;
  }
  memcpy(reply, answer.data, answer.size);
  return answer.size;
}

bool cf_link_read_trajectory(uint32_t offset, uint32_t length, uint8_t *data) {
  for (uint32_t done = 0; done < length; done += READ_AT_ONCE) {
    const uint32_t left = length - done < READ_AT_ONCE ? length - done : READ_AT_ONCE;
    if (trajectories == NULL || !trajectories->read(0, offset + done, (uint8_t)left, data + done)) {
      return false;
    }
  }
  return true;
}

bool cf_link_write_trajectory(uint32_t offset, uint32_t length, const uint8_t *data) {
  for (uint32_t done = 0; done < length; done += READ_AT_ONCE) {
    const uint32_t left = length - done < READ_AT_ONCE ? length - done : READ_AT_ONCE;
    if (trajectories == NULL ||
        !trajectories->write(0, offset + done, (uint8_t)left, data + done)) {
      return false;
    }
  }
  return true;
}
