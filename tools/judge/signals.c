#include "tools/judge/signals.h"

#include <signal.h>
#include <stdatomic.h>
#include <string.h>

static atomic_int caught; /* a handler has nowhere else to put it; any thread may ask */

static void on_signal(int number)
{
    caught = number;
}

void signals_catch(void)
{
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = on_signal;
    action.sa_flags = SA_RESETHAND;
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

int signals_caught(void)
{
    return caught;
}
