#ifndef TRACE_H_
#define TRACE_H_
#endif  // TRACE_H_
