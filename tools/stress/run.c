/* One row in a process of its own. */
#include "tools/clock.h"
#include "tools/stress/stress.h"

#include <errno.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

static const double usual_seconds = 10;
static const double grace = 20; /* s beyond a row's own limit, for recording and a last step */

const char *stress_outcome_name(stress_outcome outcome)
{
#define STRESS_NAME(name, text) text,
    static const char *const names[] = {STRESS_OUTCOME_LIST(STRESS_NAME)};
#undef STRESS_NAME
    return names[outcome];
}

const char *stress_method_name(stress_method method)
{
    static const char *const names[STRESS_METHODS] = {"pinn"};
    return names[method];
}

static double limit_of(const stress_row *row)
{
    return row->seconds > 0 ? row->seconds : usual_seconds;
}

/* ---- within the child ---------------------------------------------------------------------- */

/* The files beside the scene. */
static ad_status write_files(const stress_row *row, const char *folder, ad_error *error)
{
    char path[4096];
    if (!row->file && !row->write) {
        return AD_OK;
    }
    snprintf(path, sizeof path, "%s/reference.csv", folder);
    FILE *file = fopen(path, "w");
    if (!file) {
        return ad_fail(error, AD_IO, "%s: %s", path, strerror(errno));
    }
    if (row->file) {
        fputs(row->file, file);
    } else {
        row->write(file);
    }
    return fclose(file) == 0 ? AD_OK : ad_fail(error, AD_IO, "%s: %s", path, strerror(errno));
}

static ad_status read_scene(const stress_row *row, const char *folder, config **settings,
                            ad_error *error)
{
    char path[4096];
    int count = 0;
    while (count < STRESS_OVERRIDES_MAX && row->overrides[count]) {
        count++;
    }
    snprintf(path, sizeof path, "%s/scene.yaml", folder);
    return config_read(path, row->scene, count, row->overrides, settings, error);
}

/* Whether the time was enough. */
static ad_status train(session *s, double seconds, bool *ended, ad_error *error)
{
    double began = wall_seconds();
    ad_status status = AD_OK;
    *ended = true;
    while (status == AD_OK && trainer_inspect(s->trainer).state == TRAINER_RUNNING) {
        if (wall_seconds() - began > seconds) {
            *ended = false;
            return AD_OK;
        }
        status = trainer_step(s->trainer, error);
    }
    return status;
}

static ad_status measure_of(const stress_row *row, const session *s, double *measured,
                            ad_error *error)
{
    *measured = NAN;
    if (row->measure) {
        return row->measure(s, measured, error);
    }
    if (s->known) {
        *measured = trainer_inspect(s->trainer).errors.position;
    }
    return AD_OK;
}

/* What the user is left with when training is over: a doubt, or a solution. */
static void conclude(const stress_row *row, const session *s, stress_result *result)
{
    ad_error error;
    const stress_expectation *expected = &row->expected[STRESS_PINN];
    bool bounded = expected->outcome == STRESS_SOLVED;
    if (measure_of(row, s, &result->error, &error) != AD_OK) {
        result->outcome = STRESS_STOPPED;
        snprintf(result->text, sizeof result->text, "%s", error.message);
        return;
    }
    if (trainer_doubts(s->trainer, result->text)) {
        result->outcome = STRESS_DOUBTED;
        return;
    }
    trainer_info info = trainer_inspect(s->trainer);
    snprintf(result->text, sizeof result->text, "held-out loss %.1e", info.held_out);
    bool right = bounded && result->error <= expected->bound;
    result->outcome = right ? STRESS_SOLVED : STRESS_WRONG;
}

static void run_pinn(const stress_row *row, const char *folder, stress_result *result)
{
    ad_error error = {AD_OK, ""};
    config *settings;
    session s = {.e = NULL};
    bool ended = true;
    result->outcome = STRESS_REFUSED;
    ad_status status = write_files(row, folder, &error);
    if (status == AD_OK) {
        status = read_scene(row, folder, &settings, &error);
    }
    if (status == AD_OK) {
        status = session_create(settings, 1, &s, &error);
    }
    if (status == AD_OK) {
        result->outcome = STRESS_STOPPED;
        status = train(&s, limit_of(row), &ended, &error);
    }
    if (status != AD_OK) {
        snprintf(result->text, sizeof result->text, "%s", error.message);
    } else if (!ended) {
        result->outcome = STRESS_OUT_OF_TIME;
    } else {
        conclude(row, &s, result);
    }
    session_free(&s);
}

/* ---- without ------------------------------------------------------------------------------- */

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
    *result = (stress_result){.error = NAN};
    if (pipe(ends) != 0) {
        return ad_fail(error, AD_IO, "a pipe: %s", strerror(errno));
    }
    fflush(NULL);
    pid_t child = fork();
    if (child == 0) {
        close(ends[0]);
        run_pinn(row, folder, result);
        send(ends[1], result);
        _exit(0);
    }
    close(ends[1]);
    if (child < 0) {
        close(ends[0]);
        return ad_fail(error, AD_IO, "a process: %s", strerror(errno));
    }
    double patience = limit_of(row) + grace;
    bool told = receive(ends[0], patience, result);
    close(ends[0]);
    bool late = wall_seconds() - began >= patience;
    if (told) {
        while (waitpid(child, NULL, 0) < 0 && errno == EINTR) {
        }
    } else {
        *result = (stress_result){.error = NAN};
        report_end(child, late, result);
    }
    result->seconds = wall_seconds() - began;
    result->as_expected = as_expected(&row->expected[method], result);
    return AD_OK;
}
