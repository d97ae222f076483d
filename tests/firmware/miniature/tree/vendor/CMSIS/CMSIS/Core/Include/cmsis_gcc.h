// Instructions of the vehicle's processor. On a host they compile as long as no code calls them.
#ifndef CMSIS_GCC_H
#define CMSIS_GCC_H

static inline void __DSB(void) {
  __asm volatile("dsb 0xF" ::: "memory");
}

static inline uint32_t __get_IPSR(void) {
  uint32_t result;
  __asm volatile("mrs %0, ipsr" : "=r"(result));
  return result;
}

#endif  // CMSIS_GCC_H
