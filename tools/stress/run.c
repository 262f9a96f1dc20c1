/* One row in a process of its own. */
#include "tools/clock.h"
#include "tools/stress/methods.h"

#include <errno.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

static const double usual_seconds = 10;
static const double patience_of_limits = 10; /* of wall time, on a busy machine, and */
static const double grace = 30;              /* s for recording, measuring and the solver */

const char *stress_outcome_name(stress_outcome outcome)
{
#define STRESS_NAME(name, text) text,
    static const char *const names[] = {STRESS_OUTCOME_LIST(STRESS_NAME)};
#undef STRESS_NAME
    return names[outcome];
}

const char *stress_method_name(stress_method method)
{
    static const char *const names[STRESS_METHODS] = {"pinn", "solver"};
    return names[method];
}

double stress_limit(const stress_row *row)
{
    return row->seconds > 0 ? row->seconds : usual_seconds;
}

/* All of the child's result, or nothing: it was killed, or went another way. */
static bool receive(int from, double seconds, stress_result *result)
{
    size_t got = 0;
    double until = wall_seconds() + seconds;
    while (got < sizeof *result) {
        struct pollfd waiting = {.fd = from, .events = POLLIN};
        double left = until - wall_seconds();
        int ready = left > 0 ? poll(&waiting, 1, (int)(1000 * left) + 1) : 0;
        if (ready < 0 && errno == EINTR) {
            continue;
        }
        ssize_t size = ready > 0 ? read(from, (char *)result + got, sizeof *result - got) : 0;
        if (size <= 0) {
            return false;
        }
        got += (size_t)size;
    }
    return true;
}

static void send(int to, const stress_result *result)
{
    size_t sent = 0;
    while (sent < sizeof *result) {
        ssize_t size = write(to, (const char *)result + sent, sizeof *result - sent);
        if (size <= 0) {
            return;
        }
        sent += (size_t)size;
    }
}

/* The child has not told how it ended. */
static void report_end(pid_t child, bool late, stress_result *result)
{
    int status = 0;
    kill(child, SIGKILL); /* where it has ended already this does nothing */
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (late) {
        result->outcome = STRESS_HUNG;
    } else {
        result->outcome = STRESS_CRASHED;
        snprintf(result->text, sizeof result->text,
                 WIFSIGNALED(status) ? "signal %d" : "exit status %d",
                 WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status));
    }
}

static bool as_expected(const stress_expectation *expected, const stress_result *result)
{
    bool said = !expected->text || strstr(result->text, expected->text);
    return result->outcome == expected->outcome && said;
}

ad_status stress_run(const stress_row *row, stress_method method, const char *folder,
                     stress_result *result, ad_error *error)
{
    int ends[2];
    double began = wall_seconds();
    *result = (stress_result){.error = NAN, .seconds = NAN};
    if (pipe(ends) != 0) {
        return ad_fail(error, AD_IO, "a pipe: %s", strerror(errno));
    }
    fflush(NULL);
    pid_t child = fork();
    if (child == 0) {
        close(ends[0]);
        stress_answer_by(method, row, folder, result);
        send(ends[1], result);
        _exit(0);
    }
    close(ends[1]);
    if (child < 0) {
        close(ends[0]);
        return ad_fail(error, AD_IO, "a process: %s", strerror(errno));
    }
    double patience = patience_of_limits * stress_limit(row) + grace;
    bool told = receive(ends[0], patience, result);
    close(ends[0]);
    bool late = wall_seconds() - began >= patience;
    if (told) {
        while (waitpid(child, NULL, 0) < 0 && errno == EINTR) {
        }
    } else {
        *result = (stress_result){.error = NAN, .seconds = NAN};
        report_end(child, late, result);
    }
    if (isnan(result->seconds)) {
        result->seconds = wall_seconds() - began;
    }
    result->as_expected = as_expected(&row->expected[method], result);
    return AD_OK;
}
