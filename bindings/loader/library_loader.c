#include "loader/library_loader.h"

#include <dlfcn.h>
#include <errno.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "loader/image_map.h"
#include "loader/library_copy.h"
#include "loader/rescue.h"
#include "platform.h"

#define MAX_FILE_BYTES (256L << 20)

typedef struct copy_s {
  const cf_provider_t *table;
  struct copy_s       *next_idle;
} copy_t;

typedef struct {
  char              name[CF_LIBRARY_NAME_BYTES];
  int               platform;
  cf_library_file_t file;
  cf_image_map_t    map;
  int               block_bytes;

  const cf_library_host_t *host;

  uint64_t loaded;  // counts calls of cf_library_add: the newest has the largest
  copy_t  *idle;    // copies that no thread has
} entry_t;

// What a thread has. Number 0 is no library.
typedef struct {
  copy_t *copies[CF_MAX_LIBRARIES + 1];
} thread_t;

static struct {
  pthread_mutex_t lock;  // guards everything here but `count` and entries below it
  entry_t        *entries[CF_MAX_LIBRARIES + 1];
  atomic_int      count;
  uint64_t        loads;
  uint32_t        serial;  // of the next copy
  pthread_once_t  once;
  pthread_key_t   end_of_thread;
} registry = {.lock = PTHREAD_MUTEX_INITIALIZER, .once = PTHREAD_ONCE_INIT, .serial = 1};

#ifdef __GLIBC__
// one look away, as the variables of the process are
#define NEAR __attribute__((tls_model("initial-exec")))
#else
#define NEAR
#endif

static _Thread_local thread_t *mine NEAR;

// -------------------------------------------------------------------------------------- messages

__attribute__((format(printf, 2, 3))) static void say(char        message[CF_LIBRARY_MESSAGE_BYTES],
                                                      const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(message, CF_LIBRARY_MESSAGE_BYTES, format, arguments);
  va_end(arguments);
}

// ---------------------------------------------------------------------------------------- threads

static void leave_copies(void *thread) {
  thread_t *ending = thread;
  pthread_mutex_lock(&registry.lock);
  for (int i = 1; i <= CF_MAX_LIBRARIES; i++) {
    copy_t *copy = ending->copies[i];
    if (copy != NULL) {
      copy->next_idle           = registry.entries[i]->idle;
      registry.entries[i]->idle = copy;
    }
  }
  pthread_mutex_unlock(&registry.lock);
  free(ending);
  mine = NULL;
  cf_rescue_leave_thread();
}

static void lock_for_fork(void) {
  pthread_mutex_lock(&registry.lock);
}

static void unlock_after_fork(void) {
  pthread_mutex_unlock(&registry.lock);
}

static void prepare(void) {
  pthread_key_create(&registry.end_of_thread, leave_copies);
  pthread_atfork(lock_for_fork, unlock_after_fork, unlock_after_fork);
  cf_rescue_install();
}

static thread_t *this_thread(void) {
  if (mine == NULL) {
    mine = calloc(1, sizeof *mine);
    if (mine != NULL) {
      pthread_setspecific(registry.end_of_thread, mine);
      cf_rescue_enter_thread();
    }
  }
  return mine;
}

// ----------------------------------------------------------------------------------------- copies

// ISO C has no cast from object to function pointer; POSIX guarantees that the bytes agree.
static cf_library_open_t entry_point(void *handle) {
  void             *symbol = dlsym(handle, CF_LIBRARY_ENTRY);
  cf_library_open_t open;
  memcpy(&open, &symbol, sizeof open);
  return open;
}

// With the lock held. Null when no copy can be made; the next call tries again.
static copy_t *take_copy(entry_t *entry) {
  copy_t *copy = entry->idle;
  if (copy != NULL) {
    entry->idle = copy->next_idle;
    return copy;
  }
  char  reason[CF_LIBRARY_COPY_REASON_BYTES];
  void *handle = cf_library_copy_open(&entry->file, registry.serial++, reason);
  copy         = handle != NULL ? calloc(1, sizeof *copy) : NULL;
  if (copy != NULL) {
    // the first copy answered, and so does this one
    copy->table = entry_point(handle)(CF_LIBRARY_ABI, entry->host, &entry->map);
  }
  return copy;
}

// Once per thread and library: not where every call comes by.
__attribute__((noinline, cold)) static const cf_provider_t *table_of_new_copy(int number) {
  thread_t *thread = this_thread();
  if (thread == NULL) {
    return NULL;  // no test runs out of memory
  }
  pthread_mutex_lock(&registry.lock);
  copy_t *copy = take_copy(registry.entries[number]);
  pthread_mutex_unlock(&registry.lock);
  thread->copies[number] = copy;
  return copy != NULL ? copy->table : NULL;
}

int cf_library_count(void) {
  return atomic_load_explicit(&registry.count, memory_order_acquire);
}

const cf_provider_t *cf_library_table(int number) {
  if (number < 1 || number > cf_library_count()) {
    return NULL;
  }
  if (mine != NULL && mine->copies[number] != NULL) {
    return mine->copies[number]->table;
  }
  return table_of_new_copy(number);
}

// ---------------------------------------------------------------------------------------- loading

static cf_status_t check_request(const cf_library_t *library,
                                 char                message[CF_LIBRARY_MESSAGE_BYTES]) {
  const size_t length = strlen(library->name);
  if (length == 0 || length >= CF_LIBRARY_NAME_BYTES || strcmp(library->name, "builtin") == 0) {
    say(message, "a library is named '%.80s', allowed: 1 to %d characters, and not 'builtin'",
        library->name, CF_LIBRARY_NAME_BYTES - 1);
    return CF_ERR_VALUE;
  }
  if (library->platform < -1 || library->platform >= CF_PLATFORM_COUNT) {
    say(message, "library %s is for platform number %d, allowed: -1 to %d", library->name,
        library->platform, CF_PLATFORM_COUNT - 1);
    return CF_ERR_VALUE;
  }
  const char *fault = cf_image_map_fault(&library->map);
  if (fault != NULL) {
    say(message, "the image map of %.120s %s", library->path, fault);
    return CF_ERR_VALUE;
  }
  return CF_OK;
}

static cf_status_t read_file(const char *path, cf_library_file_t *file,
                             char message[CF_LIBRARY_MESSAGE_BYTES]) {
  FILE *stream = fopen(path, "rb");
  if (stream == NULL) {
    say(message, "%.150s cannot be read: %s", path, strerror(errno));
    return CF_ERR_UNKNOWN;
  }
  const long size =
      fseek(stream, 0, SEEK_END) == 0 && ftell(stream) <= MAX_FILE_BYTES ? ftell(stream) : 0;
  uint8_t *bytes = size > 0 ? malloc((size_t)size) : NULL;
  rewind(stream);
  const bool is_whole = bytes != NULL && fread(bytes, 1, (size_t)size, stream) == (size_t)size;
  fclose(stream);
  if (!is_whole) {
    free(bytes);
    say(message, "%.150s cannot be read: it is empty, too large or no file", path);
    return CF_ERR_VALUE;
  }
  *file = (cf_library_file_t){.bytes = bytes, .size = (size_t)size};
  return CF_OK;
}

static cf_status_t check_table(const cf_library_t *library, const cf_provider_t *table,
                               char message[CF_LIBRARY_MESSAGE_BYTES]) {
  if (table == NULL) {
    say(message, "%.120s was built for another version of crazychoir_fw, build it again",
        library->path);
    return CF_ERR_STATE;
  }
  if (table->state_bytes == 0 || table->state_bytes % sizeof(uint64_t) != 0 ||
      table->state_bytes > CF_LIBRARY_MAX_STATE_BYTES) {
    say(message, "%.100s remembers %zu bytes per drone, allowed: 8 to %d in whole words of 8",
        library->path, table->state_bytes, CF_LIBRARY_MAX_STATE_BYTES);
    return CF_ERR_CAPACITY;
  }
  return CF_OK;
}

// Asks a copy that was just loaded for its table, when all is well with it.
static cf_status_t open_table(const cf_library_t *library, void *handle, entry_t *entry,
                              copy_t *copy, char message[CF_LIBRARY_MESSAGE_BYTES]) {
  const cf_library_open_t open = entry_point(handle);
  if (open == NULL) {
    say(message, "%.150s is no provider library, it has no " CF_LIBRARY_ENTRY, library->path);
    return CF_ERR_VALUE;
  }
  const char *misfit = cf_image_map_misfit(&library->map, handle);
  if (misfit != NULL) {
    say(message, "the image map of %.120s %s", library->path, misfit);
    return CF_ERR_VALUE;
  }
  copy->table = open(CF_LIBRARY_ABI, entry->host, &entry->map);
  return check_table(library, copy->table, message);
}

// Loads the first copy.
static cf_status_t open_first(const cf_library_t *library, entry_t *entry, copy_t *copy,
                              char message[CF_LIBRARY_MESSAGE_BYTES]) {
  char  reason[CF_LIBRARY_COPY_REASON_BYTES];
  void *handle = cf_library_copy_open(&entry->file, registry.serial++, reason);
  if (handle == NULL) {
    say(message, "%.100s cannot be loaded: %s", library->path, reason);
    return CF_ERR_VALUE;
  }
  const cf_status_t status = open_table(library, handle, entry, copy, message);
  if (status != CF_OK) {
    dlclose(handle);
  }
  return status;
}

static void forget(entry_t *entry, copy_t *copy) {
  if (entry != NULL) {
    cf_image_map_free(&entry->map);
  }
  free(entry);
  free(copy);
}

static int find_same(const cf_library_t *library, const cf_library_file_t *file) {
  for (int i = 1; i <= cf_library_count(); i++) {
    const entry_t *entry = registry.entries[i];
    if (strcmp(entry->name, library->name) == 0 && entry->platform == library->platform &&
        entry->file.size == file->size && memcmp(entry->file.bytes, file->bytes, file->size) == 0 &&
        cf_image_map_equals(&entry->map, &library->map)) {
      return i;
    }
  }
  return 0;
}

// Keeps the bytes of the file, unless it fails.
static int add_new(const cf_library_t *library, const cf_library_host_t *host,
                   const cf_library_file_t *file, char message[CF_LIBRARY_MESSAGE_BYTES]) {
  thread_t   *thread = this_thread();
  entry_t    *entry  = calloc(1, sizeof *entry);
  copy_t     *copy   = calloc(1, sizeof *copy);
  cf_status_t status = CF_ERR_CAPACITY;
  const int   number = cf_library_count() + 1;
  if (number > CF_MAX_LIBRARIES) {
    say(message, "%d libraries have been loaded, more are not possible: start again",
        CF_MAX_LIBRARIES);
  } else if (thread == NULL || entry == NULL || copy == NULL ||
             !cf_image_map_copy(&entry->map, &library->map)) {
    say(message, "out of memory");  // no test runs out of it
  } else {
    entry->file     = *file;
    entry->host     = host;
    entry->platform = library->platform;
    snprintf(entry->name, sizeof entry->name, "%s", library->name);
    status = open_first(library, entry, copy, message);
  }
  if (status != CF_OK) {
    forget(entry, copy);
    return status;
  }
  entry->block_bytes       = (int)copy->table->state_bytes;
  thread->copies[number]   = copy;
  registry.entries[number] = entry;
  atomic_store_explicit(&registry.count, number, memory_order_release);
  return number;
}

int cf_library_add(const cf_library_t *library, const cf_library_host_t *host,
                   char message[CF_LIBRARY_MESSAGE_BYTES]) {
  cf_library_file_t file   = {0};
  cf_status_t       status = check_request(library, message);
  if (status == CF_OK) {
    status = read_file(library->path, &file, message);
  }
  if (status != CF_OK) {
    return status;
  }
  pthread_once(&registry.once, prepare);
  pthread_mutex_lock(&registry.lock);
  const int known  = find_same(library, &file);
  const int number = known != 0 ? known : add_new(library, host, &file, message);
  if (number > 0) {
    registry.entries[number]->loaded = ++registry.loads;
  }
  pthread_mutex_unlock(&registry.lock);
  if (number < 0 || known != 0) {
    free((void *)(uintptr_t)file.bytes);
  }
  return number;
}

// --------------------------------------------------------------------------------- what is loaded

const char *cf_library_name(int number) {
  return registry.entries[number]->name;
}

int cf_library_platform(int number) {
  return registry.entries[number]->platform;
}

int cf_library_block_bytes(int number) {
  return registry.entries[number]->block_bytes;
}

int cf_library_find(const char *name, int platform) {
  int      found  = CF_ERR_UNKNOWN;
  uint64_t newest = 0;
  pthread_mutex_lock(&registry.lock);
  for (int i = 1; i <= cf_library_count(); i++) {
    const entry_t *entry = registry.entries[i];
    if (entry->loaded > newest && strcmp(entry->name, name) == 0 &&
        (entry->platform == -1 || entry->platform == platform)) {
      newest = entry->loaded;
      found  = i;
    }
  }
  pthread_mutex_unlock(&registry.lock);
  return found;
}
