// Everything that C lets code remember: file-scope and function-local variables, in all sections,
// with pointers to themselves in structs, unions and arrays.

#include <stddef.h>

#include "app_modes.h"
#include "log.h"
#include "param.h"

typedef struct node {
  struct node *next;
  float        value;
} node_t;

static uint32_t calls;
static float    gain         = 0.5f;
static uint8_t  odd_bytes[5] = {1, 2, 3, 4, 5};
static uint32_t in_ccm __attribute__((section(".ccmbss")));

static node_t  nodes[3] = {{&nodes[1], 1.0f}, {&nodes[2], 2.0f}, {NULL, 3.0f}};
static node_t *head     = &nodes[0];
static node_t *late;  // null in the factory

// a pointer at an odd address, and one that shares its place
static struct __attribute__((packed)) {
  uint8_t   tag;
  uint32_t *to_calls;
} packed = {7, &calls};
static union {
  node_t  *node;
  uint64_t number;
} either;

static float *table[2][2];
static float  cells[4];

// what is no pointer into the library
static void *sentinels[2] = {(void *)1, (void *)-1};

static double half(double x) {
  return x / 2;
}
static double (*const volatile unchanging)(double) = half;
static double (*function)(double)                  = half;

static float sum(void) {
  float total = 0.0f;
  for (const node_t *node = head; node != NULL; node = node->next) {
    total += node->value;
  }
  return total;
}

static uint32_t next_number(void) {
  static uint32_t  number;
  static uint32_t *where;
  where = &number;
  return ++*where;
}

static void set_pointers(void) {
  late            = &nodes[calls % 3];
  either.node     = &nodes[(calls + 1) % 3];
  packed.to_calls = &calls;
  for (int i = 0; i < 4; i++) {
    table[i / 2][i % 2] = &cells[i];
  }
}

void count(const call_t *call) {
  if (late == NULL) {
    set_pointers();
  }
  (*packed.to_calls)++;
  late->value += gain;
  either.node->value += 0.25f;
  *table[1][0] += 1.0f;
  in_ccm += 2;
  odd_bytes[4]++;
  late        = late->next != NULL ? late->next : head;
  either.node = late;

  const bool is_whole                = sentinels[0] == (void *)1 && sentinels[1] == (void *)-1;
  call->control->controlMode         = controlModeForce;
  call->control->normalizedForces[0] = (float)calls;
  call->control->normalizedForces[1] = sum();
  call->control->normalizedForces[2] = (float)next_number() + (float)in_ccm + cells[2];
  call->control->normalizedForces[3] = is_whole ? (float)function(odd_bytes[4]) : -1.0f;
  (void)unchanging;
}

static float computed(uint32_t timestamp, void *data) {
  return *(float *)data * 10.0f + (float)timestamp;
}

static int8_t computed_byte(uint32_t timestamp, void *data) {
  (void)timestamp;
  (void)data;
  return (int8_t)-(int)calls;
}

static logByFunction_t with_data    = {.acquireFloat = computed, .data = &gain};
static logByFunction_t without_data = {.acquireInt8 = computed_byte};

static uint32_t gain_changes;
static void     gain_changed(void) {
  gain_changes++;
}

static const float constant = 4.0f;
static uint64_t    too_wide;

PARAM_GROUP_START(counters)
PARAM_ADD_CORE_WITH_CALLBACK(PARAM_FLOAT | PARAM_PERSISTENT, gain, &gain, gain_changed)
PARAM_ADD(PARAM_INT8, odd, &odd_bytes[4])
#define a_macro something_else  // which gets into the name of a parameter, as on the vehicle
PARAM_ADD_CORE(PARAM_UINT32, a_macro, &cells[0])
PARAM_ADD(PARAM_FLOAT, gain, &cells[0])                        // the first of a name wins
PARAM_ADD(PARAM_FLOAT, outside, &constant)                     // no drone's own
PARAM_ADD(PARAM_8BYTES | PARAM_UNSIGNED, too_wide, &too_wide)  // no type that a client knows
PARAM_GROUP_STOP(counters)

// a name that the builtin provider has already
PARAM_GROUP_START(pid_rate)
PARAM_ADD(PARAM_FLOAT, roll_kp, &cells[1])
PARAM_GROUP_STOP(pid_rate)

LOG_GROUP_START(counters)
LOG_ADD(LOG_UINT32, calls, &calls)
LOG_ADD_CORE(LOG_UINT32, ccm, &in_ccm)
LOG_ADD_CORE_BY_FUNCTION(LOG_FLOAT, computed, &with_data)
LOG_ADD_BY_FUNCTION(LOG_INT8, byte, &without_data)
LOG_ADD(LOG_UINT32, gainChanges, &gain_changes)
LOG_ADD_CORE(LOG_FLOAT, a_macro, &cells[0])
LOG_ADD(LOG_FP16, half, &cells[3])
LOG_ADD_DEBUG(LOG_FLOAT, debug, &cells[3])
LOG_GROUP_STOP(counters)
