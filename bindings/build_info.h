/* How this library was compiled. */
#ifndef CF_BUILD_INFO_H
#define CF_BUILD_INFO_H

const char *cf_build_compiler(void);
const char *cf_build_flags(void);

#endif  // CF_BUILD_INFO_H
