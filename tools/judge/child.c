#include "tools/judge/child.h"

#include "tools/judge/signals.h"
#include "tools/train/clock.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif
#include <sys/wait.h>
#include <unistd.h>

/* s; a signal that another thread has caught does not end a wait */
static const double look = 0.2;

/* All of the child's result, or less: it was late, or went another way. */
static size_t receive(int from, double seconds, char *result, size_t size)
{
    size_t got = 0;
    double until = train_seconds() + seconds;
    while (got < size) {
        struct pollfd waiting = {.fd = from, .events = POLLIN};
        double left = until - train_seconds();
        double wait = left < look ? left : look;
        int ready = left > 0 ? poll(&waiting, 1, (int)(1000 * wait) + 1) : 0;
        bool woken = ready < 0 ? errno == EINTR : ready == 0 && left > 0;
        if (woken && !signals_caught()) {
            continue;
        }
        ssize_t more = ready > 0 ? read(from, result + got, size - got) : 0;
        if (more <= 0) {
            break;
        }
        got += (size_t)more;
    }
    return got;
}

static void send(int to, const char *result, size_t size)
{
    for (size_t sent = 0; sent < size;) {
        ssize_t more = write(to, result + sent, size - sent);
        if (more <= 0) {
            return;
        }
        sent += (size_t)more;
    }
}

static int wait_for(pid_t child)
{
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    return status;
}

/* The child has not told how it ended; where it has ended already, killing it does nothing. */
static void report_end(pid_t child, char why[CHILD_WHY])
{
    kill(child, SIGKILL);
    int status = wait_for(child);
    snprintf(why, CHILD_WHY, WIFSIGNALED(status) ? "signal %d" : "exit status %d",
             WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status));
}

/* In the child: nobody is left to wait for it once its parent is gone, however that has ended. */
static void end_with(pid_t parent)
{
#ifdef PR_SET_PDEATHSIG
    prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
    if (getppid() != parent) {
        _exit(1); /* it has gone meanwhile */
    }
}

ad_status child_run(void (*work)(const void *task, void *result), const void *task, void *result,
                    size_t size, double seconds, child_end *end, char why[CHILD_WHY],
                    ad_error *error)
{
    int ends[2];
    char *received = malloc(size);
    if (!received) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a result");
    }
    if (pipe(ends) != 0) {
        free(received);
        return ad_fail(error, AD_NO_MEMORY, "a pipe: %s", strerror(errno));
    }
    double began = train_seconds();
    fflush(NULL); /* or the child would have what is buffered as well */
    pid_t parent = getpid(), child = fork();
    if (child == 0) {
        end_with(parent);
        signal(SIGINT, SIG_DFL);
        signal(SIGTERM, SIG_DFL);
        close(ends[0]);
        work(task, result);
        send(ends[1], result, size);
        _exit(0);
    }
    close(ends[1]);
    bool told = child > 0 && receive(ends[0], seconds, received, size) == size;
    close(ends[0]);
    *end = told ? CHILD_TOLD : train_seconds() - began >= seconds ? CHILD_LATE : CHILD_DIED;
    if (told) {
        wait_for(child);
        memcpy(result, received, size);
    } else if (child > 0) {
        report_end(child, why);
    }
    free(received);
    return child > 0 ? AD_OK : ad_fail(error, AD_NO_MEMORY, "a process: %s", strerror(errno));
}
