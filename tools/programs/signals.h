/* Signals that ask a program to end: Ctrl-C, TERM, HUP of a terminal that closes, and USR1, USR2
 * and XCPU of queues of clusters. For programs that finish the step at hand first. */
#ifndef TOOLS_PROGRAMS_SIGNALS_H
#define TOOLS_PROGRAMS_SIGNALS_H

/* From now on these signals are only noted. A second Ctrl-C or TERM ends the program at once. HUP,
 * USR1, USR2 and XCPU stay ignored where the program was started so. */
void signals_catch(void);

/* The signal that came, or 0. */
int signals_caught(void);

#endif
