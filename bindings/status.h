/* Status codes of the whole core: zero for success, negative for failure. */
#ifndef CF_STATUS_H
#define CF_STATUS_H

typedef enum {
  CF_OK           = 0,
  CF_ERR_VALUE    = -1,  // a value is outside its allowed range, or not a number
  CF_ERR_UNKNOWN  = -2,  // no such platform, provider, parameter, controller or trajectory
  CF_ERR_STATE    = -3,  // the drone is in a state that refuses the request
  CF_ERR_BLOCKED  = -4,  // the supervisor blocks commands: the motors may not run
  CF_ERR_CAPACITY = -5,  // a buffer of fixed size is full, or an index lies behind its end
} cf_status_t;

// Returns a phrase for the code, never null.
const char *cf_status_text(cf_status_t status);

#endif  // CF_STATUS_H
