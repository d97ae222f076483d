#include "status.h"

const char *cf_status_text(cf_status_t status) {
  switch (status) {
    case CF_OK:
      return "success";
    case CF_ERR_VALUE:
      return "value outside its allowed range";
    case CF_ERR_UNKNOWN:
      return "no such name";
    case CF_ERR_STATE:
      return "refused in the present state";
    case CF_ERR_BLOCKED:
      return "blocked by the supervisor";
    case CF_ERR_CAPACITY:
      return "buffer full or index too large";
  }
  return "unknown status";
}
