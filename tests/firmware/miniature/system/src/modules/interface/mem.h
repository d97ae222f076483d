#pragma once

#include <stdbool.h>
#include <stdint.h>

typedef enum {
  MEM_TYPE_EEPROM   = 0x00,
  MEM_TYPE_OW       = 0x01,
  MEM_TYPE_LED12    = 0x10,
  MEM_TYPE_LOCO     = 0x11,
  MEM_TYPE_TRAJ     = 0x12,
  MEM_TYPE_LOCO2    = 0x13,
  MEM_TYPE_LH       = 0x14,
  MEM_TYPE_TESTER   = 0x15,
  MEM_TYPE_USD      = 0x16,
  MEM_TYPE_LEDMEM   = 0x17,
  MEM_TYPE_APP      = 0x18,
  MEM_TYPE_DECK_MEM = 0x19,
} MemoryType_t;

// What a memory is and who serves it. Addresses count from its beginning.
typedef struct {
  MemoryType_t type;
  uint32_t (*getSize)(const uint8_t internal_id);
  bool (*read)(const uint8_t internal_id, const uint32_t memAddr, const uint8_t readLen,
               uint8_t *buffer);
  bool (*write)(const uint8_t internal_id, const uint32_t memAddr, const uint8_t writeLen,
                const uint8_t *buffer);
} MemoryHandlerDef_t;

void memInit(void);
bool memTest(void);
void memoryRegisterHandler(const MemoryHandlerDef_t *handlerDefinition);
