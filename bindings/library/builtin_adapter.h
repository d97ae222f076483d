/* The drone at work of a library over the builtin provider. */
#ifndef CF_LIBRARY_BUILTIN_ADAPTER_H
#define CF_LIBRARY_BUILTIN_ADAPTER_H

#include "builtin/builtin.h"

extern cf_builtin_t cf_library_builtin;

#endif  // CF_LIBRARY_BUILTIN_ADAPTER_H
