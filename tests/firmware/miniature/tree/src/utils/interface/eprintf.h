#ifndef EPRINTF_H_
#define EPRINTF_H_

typedef int (*putc_t)(int c);

int eprintf(putc_t putcf, const char *fmt, ...);

#endif  // EPRINTF_H_
