/* Another program, started without a shell. */
#ifndef AD_PROCESS_H
#define AD_PROCESS_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

/* The program of that name: the first in an absolute folder of PATH. False: there is none. */
bool ad_find_program(const char *name, char *path, size_t room);

/* Starts arguments[0], a path, with arguments up to a NULL. In a process group of its own, so that
 * what it starts in turn can be stopped with it; it reads nothing, and what it prints is a file
 * `output`, or lost, "/dev/null". 0, or what errno would be. */
int ad_start_process(char *const *arguments, const char *output, pid_t *child);

#endif
