/* Preloaded into a command: after FULL_DISK_AFTER writes to files below FULL_DISK_FOLDER the disk
 * is full. At the end the number of writes goes to the file FULL_DISK_COUNT, if that is set. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/uio.h>
#include <unistd.h>

static long writes;

static int is_full(int file) {
  const char *folder = getenv("FULL_DISK_FOLDER"), *after = getenv("FULL_DISK_AFTER");
  char        link[64], path[4096];
  snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  ssize_t length = readlink(link, path, sizeof path - 1);
  if (folder == NULL || length <= 0) {
    return 0;
  }
  path[length] = '\0';
  if (strncmp(path, folder, strlen(folder)) != 0) {
    return 0;
  }
  long number = __atomic_add_fetch(&writes, 1, __ATOMIC_RELAXED);
  if (after == NULL || number <= atol(after)) {
    return 0;
  }
  errno = ENOSPC;
  return 1;
}

ssize_t write(int file, const void *data, size_t size) {
  static ssize_t (*next)(int, const void *, size_t);
  if (next == NULL) {
    *(void **)&next = dlsym(RTLD_NEXT, "write");
  }
  return is_full(file) ? -1 : next(file, data, size);
}

ssize_t pwrite64(int file, const void *data, size_t size, off64_t offset) {
  static ssize_t (*next)(int, const void *, size_t, off64_t);
  if (next == NULL) {
    *(void **)&next = dlsym(RTLD_NEXT, "pwrite64");
  }
  return is_full(file) ? -1 : next(file, data, size, offset);
}

ssize_t pwrite(int file, const void *data, size_t size, off_t offset) {
  return pwrite64(file, data, size, offset);
}

__attribute__((destructor)) static void tell(void) {
  const char *path = getenv("FULL_DISK_COUNT");
  FILE       *file = path != NULL && writes > 0 ? fopen(path, "w") : NULL;
  if (file != NULL) {
    fprintf(file, "%ld\n", writes);
    fclose(file);
  }
}
