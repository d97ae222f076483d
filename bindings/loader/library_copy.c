#define _GNU_SOURCE  // memfd_create
#include "loader/library_copy.h"

#include <dlfcn.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#define PATH_BYTES 4096
#define WAY_BYTES 128

static void explain(char reason[CF_LIBRARY_COPY_REASON_BYTES], const char *text) {
  snprintf(reason, CF_LIBRARY_COPY_REASON_BYTES, "%.*s", CF_LIBRARY_COPY_REASON_BYTES - 1,
           text != NULL ? text : "unknown reason");
}

static bool write_all(int descriptor, const cf_library_file_t *file) {
  for (size_t written = 0; written < file->size;) {
    const ssize_t count = write(descriptor, file->bytes + written, file->size - written);
    if (count < 0 && errno != EINTR) {
      return false;
    }
    written += count > 0 ? (size_t)count : 0;
  }
  return true;
}

// The message of the dynamic loader without the path, which is not the user's.
static const char *without_path(const char *message, const char *path) {
  const size_t length = strlen(path);
  return message != NULL && strncmp(message, path, length) == 0 && message[length] == ':'
             ? message + length + 2
             : message;
}

static void *load(const char *path, char reason[CF_LIBRARY_COPY_REASON_BYTES]) {
  void *handle = dlopen(path, RTLD_NOW | RTLD_LOCAL);
  if (handle == NULL) {
    explain(reason, without_path(dlerror(), path));
  }
  return handle;
}

#ifdef __linux__

// A path to the descriptor that no other copy has had: the loader tells objects apart by their
// path, and descriptors are used again. The serial number is written with slashes and dots, which
// lead nowhere: "./" for a 1 and "/" for a 0, lowest bit first.
static void write_path(char path[WAY_BYTES], int descriptor, uint32_t serial) {
  char *end = path + snprintf(path, WAY_BYTES, "/proc/self/fd/");
  for (uint32_t rest = serial; rest != 0; rest >>= 1) {
    if ((rest & 1) != 0) {
      *end++ = '.';
    }
    *end++ = '/';
  }
  snprintf(end, (size_t)(path + WAY_BYTES - end), "%d", descriptor);
}

void *cf_library_copy_in_memory(const cf_library_file_t *file, uint32_t serial,
                                char reason[CF_LIBRARY_COPY_REASON_BYTES]) {
  const int descriptor = memfd_create("crazychoir-library", MFD_CLOEXEC);
  if (descriptor < 0) {
    explain(reason, strerror(errno));
    return NULL;
  }
  void *handle = NULL;
  if (write_all(descriptor, file)) {
    char path[WAY_BYTES];
    write_path(path, descriptor, serial);
    handle = load(path, reason);
  } else {
    explain(reason, strerror(errno));
  }
  close(descriptor);
  return handle;
}

#else

void *cf_library_copy_in_memory(const cf_library_file_t *file, uint32_t serial,
                                char reason[CF_LIBRARY_COPY_REASON_BYTES]) {
  (void)file;
  (void)serial;
  explain(reason, "this system has no files in memory");
  return NULL;
}

#endif

void *cf_library_copy_on_disk(const cf_library_file_t *file,
                              char                     reason[CF_LIBRARY_COPY_REASON_BYTES]) {
  const char *folder = getenv("TMPDIR");
  char        path[PATH_BYTES];
  snprintf(path, sizeof path, "%s/crazychoir-XXXXXX", folder != NULL ? folder : "/tmp");
  const int descriptor = mkstemp(path);
  if (descriptor < 0) {
    explain(reason, strerror(errno));
    return NULL;
  }
  void *handle = NULL;
  if (write_all(descriptor, file)) {
    handle = load(path, reason);
  } else {
    explain(reason, strerror(errno));
  }
  unlink(path);
  close(descriptor);
  return handle;
}

void *cf_library_copy_open(const cf_library_file_t *file, uint32_t serial,
                           char reason[CF_LIBRARY_COPY_REASON_BYTES]) {
  void *handle = cf_library_copy_in_memory(file, serial, reason);
  return handle != NULL ? handle : cf_library_copy_on_disk(file, reason);
}
