#include "tools/programs/signals.h"

#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <string.h>

/* The keyboard and users; terminals that close; queues of clusters, before the time is over. */
static const struct {
    int number;
    bool by_hand; /* impatient, the second one ends the program; others come again by themselves */
} asking[] = {{SIGINT, true},   {SIGTERM, true},  {SIGHUP, false},
              {SIGUSR1, false}, {SIGUSR2, false}, {SIGXCPU, false}};

enum { ASKING = sizeof asking / sizeof *asking };

static atomic_int caught; /* a handler has nowhere else to put it; any thread may ask */

static void on_signal(int number)
{
    caught = number;
}

void signals_catch(void)
{
    for (int i = 0; i < ASKING; i++) {
        struct sigaction action, before;
        memset(&action, 0, sizeof action);
        action.sa_handler = on_signal;
        action.sa_flags = asking[i].by_hand ? (int)SA_RESETHAND : 0;
        if (asking[i].by_hand || (sigaction(asking[i].number, NULL, &before) == 0 &&
                                  before.sa_handler != SIG_IGN)) { /* as nohup wants it */
            sigaction(asking[i].number, &action, NULL);
        }
    }
}

int signals_caught(void)
{
    return caught;
}
