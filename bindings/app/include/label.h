/* Functions that the firmware and our api/ have under one name with different parameters: the
 * firmware's work on file-scope variables, ours on a struct that is passed. Both are linked into
 * one library, so the symbol of what apps see has another name; in C it is the firmware's. */
#ifndef CF_APP_LABEL_H
#define CF_APP_LABEL_H

#define CF_APP_LABEL(name_) __asm__("cf_app_" #name_)

#endif  // CF_APP_LABEL_H
