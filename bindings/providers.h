/* The providers that a drone can ask for: the built-in one is number 0, the others are libraries
 * that were loaded at run time. */
#ifndef CF_PROVIDERS_H
#define CF_PROVIDERS_H

#include "provider.h"

// Number of providers; they are 0 to one less.
int cf_provider_count(void);

// Name of a provider, null for a number that does not exist. Several may have the same.
const char *cf_provider_name(int i);

// What it flies: a cf_platform_t, or -1 for every platform.
int cf_provider_platform(int i);

// Number of the newest provider of this name for this platform, or CF_ERR_UNKNOWN.
int cf_provider_find(const char *name, cf_platform_t platform);

// Bytes of the block in which a provider keeps a drone; 0 for a number that does not exist.
int cf_provider_block_bytes(int i);

#endif  // CF_PROVIDERS_H
