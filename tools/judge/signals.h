/* Ctrl-C and SIGTERM, for programs that finish the step at hand first. */
#ifndef TOOLS_JUDGE_SIGNALS_H
#define TOOLS_JUDGE_SIGNALS_H

/* From now on SIGINT and SIGTERM are only noted; a second of the same ends the program at once. */
void signals_catch(void);

/* The signal that came, or 0. */
int signals_caught(void);

#endif
