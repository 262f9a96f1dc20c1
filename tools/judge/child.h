/* Work in a process of its own, so that a crash or an endless loop there does no harm here. */
#ifndef TOOLS_JUDGE_CHILD_H
#define TOOLS_JUDGE_CHILD_H

#include "autodiff/error.h"

#include <stddef.h>

typedef enum child_end {
    CHILD_TOLD, /* the result is whole */
    CHILD_LATE, /* its time was up and it was killed */
    CHILD_DIED  /* by a signal, or it exited within its work */
} child_end;

enum { CHILD_WHY = 32 };

/* Calls work(task, result) in a child, which starts with what is in result [size], and takes the
 * result over from there, within so many seconds; it must hold no pointers. What the child writes
 * elsewhere is lost, what it starts ends with it, and signals end it, and so does the end of this
 * process (where the system is Linux). After CHILD_DIED `why` says how, "signal 11", and the result
 * is as it was; a signal caught here (tools/judge/signals.h) kills it. AD_IO: there is no such
 * process. */
ad_status child_run(void (*work)(const void *task, void *result), const void *task, void *result,
                    size_t size, double seconds, child_end *end, char why[CHILD_WHY],
                    ad_error *error);

#endif
