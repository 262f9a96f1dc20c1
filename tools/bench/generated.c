/* A trained network as C, one point at a time: ours against what CasADi generates of the same
 * network, 2-64-64-7 with tanh. All are compiled by the same command and called in turn. */
#include "peers.h"

#include "physics/sort.h"
#include "tools/programs/cli.h"

#include <dlfcn.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { INPUTS = 2, WIDTH = 64, OUTPUTS = 7, PARAMETERS = 4807, ROUNDS_MAX = 1000, CALLS = 500 };
enum { VALUE, JACOBIAN, TASKS, FORMS = 6, RESULTS = OUTPUTS * (1 + INPUTS) };

/* gcc takes half of the registers of AVX-512 unless it is told. */
#if defined(__x86_64__)
#define COMMAND "cc -O3 -march=native -mprefer-vector-width=512 -ffp-contract=fast"
#else
#define COMMAND "cc -O3 -march=native -ffp-contract=fast"
#endif
#define AGREEMENT 1e-12

static const char program[] = "generated";
static const char *const tasks[TASKS] = {"value", "jacobian"};

/* "ours", else of peers/peer_casadi.py */
static const struct {
    const char *name, *text;
} forms[FORMS] = {{"ours", "cpinn"},
                  {"sx", "CasADi, SX"},
                  {"sx_hand", "CasADi, SX, tangents by hand"},
                  {"mx", "CasADi, MX"},
                  {"mx_cse", "CasADi, MX, cse"},
                  {"mx_hand", "CasADi, MX, cse, tangents by hand"}};

typedef void our_function(const double *x, double *y, double *w);
typedef int their_function(const double **inputs, double **outputs, long long *iw, double *w,
                           int memory);
typedef int their_sizes(long long *arg, long long *res, long long *iw, long long *w);

typedef struct side {
    our_function *ours; /* or NULL */
    their_function *theirs;
    const double **arg;
    double **res, *w;
    long long *iw;
    double seconds[ROUNDS_MAX]; /* a call */
} side;

typedef struct options {
    int rounds;
    const char *python;
} options;

/* ---- writing -------------------------------------------------------------------------------- */

/* Both functions need `memory` numbers of workspace. */
static ad_status write_ours(const char *path, const double *x, size_t *memory, ad_error *error)
{
    ad_tape *tape = ad_tape_create();
    ad_pool *pool = ad_pool_create(1);
    FILE *file = fopen(path, "w");
    ad_value input = ad_input(tape, "x", INPUTS), y = input, along[2], results[1 + INPUTS];
    const int widths[] = {INPUTS, WIDTH, WIDTH, OUTPUTS};
    size_t at = 0;
    for (int layer = 0; layer < 3; layer++) {
        int m = widths[layer + 1], k = widths[layer];
        ad_value w = ad_parameter(tape, "weights", m * k, at);
        ad_value b = ad_parameter(tape, "bias", m, at + (size_t)(m * k));
        y = ad_add(ad_matvec(w, y), b);
        y = layer < 2 ? ad_tanh(y) : y;
        at += (size_t)(m * k + m);
    }
    ad_status status = file ? AD_OK : ad_fail(error, AD_IO, "%s: cannot be written", path);
    for (int i = 0; status == AD_OK && i < INPUTS; i++) {
        const double direction[] = {i == 0, i == 1};
        status = ad_taylor(1, &y, input, ad_constant(tape, INPUTS, direction), 1, along);
        results[1 + i] = along[1];
    }
    results[0] = y;
    static const char *const names[TASKS] = {"ours_value", "ours_jacobian"};
    const double *const none[] = {NULL}; /* uniform values */
    const double *const *const uniforms[] = {none};
    ad_c_options about[TASKS];
    ad_program *programs[TASKS] = {NULL};
    for (int task = 0; task < TASKS; task++) {
        about[task] = (ad_c_options){names[task], 1, 1, &x, uniforms, false};
        if (status == AD_OK) {
            status = ad_compile(task == VALUE ? 1 : 1 + INPUTS, results, NULL, pool,
                                &programs[task], error);
        }
    }
    if (status == AD_OK) {
        status = ad_write_c(TASKS, programs, about, false, file, memory, error);
    }
    for (int task = 0; task < TASKS; task++) {
        ad_program_free(programs[task]);
    }
    if (file && fclose(file) != 0 && status == AD_OK) {
        status = ad_fail(error, AD_IO, "%s: cannot be written", path);
    }
    ad_pool_free(pool);
    ad_tape_free(tape);
    return status;
}

/* Glorot's distribution, with biases of the same size. */
static bool write_network(const char *path, double *x)
{
    nn_rng rng = nn_rng_seed(1);
    const int widths[] = {INPUTS, WIDTH, WIDTH, OUTPUTS};
    size_t at = 0;
    for (int layer = 0; layer < 3; layer++) {
        int m = widths[layer + 1], k = widths[layer];
        for (int i = 0; i < m * k + m; i++) {
            x[at++] = sqrt(6.0 / (m + k)) * (2 * nn_rng_uniform(&rng) - 1);
        }
    }
    FILE *file = fopen(path, "wb");
    bool ok = file && fwrite(x, sizeof *x, at, file) == at;
    return file && fclose(file) == 0 && ok;
}

/* ---- loading -------------------------------------------------------------------------------- */

static void *compile(const char *folder, const char *name)
{
    char command[1024], path[512];
    snprintf(path, sizeof path, "%s/%s.so", folder, name);
    snprintf(command, sizeof command, "%s -w -fPIC -shared -o '%s' '%s/%s.c' -lm", COMMAND, path,
             folder, name);
    return system(command) == 0 ? dlopen(path, RTLD_NOW | RTLD_LOCAL) : NULL;
}

/* Libraries and memory stay until the end. */
/* Ours needs `memory` numbers. */
static bool load(const char *folder, int form, int task, size_t memory, side *s)
{
    char name[64], work[80];
    snprintf(name, sizeof name, "%s_%s", forms[form].name, tasks[task]);
    void *library = compile(folder, form == 0 ? "ours" : name);
    void *found = library ? dlsym(library, name) : NULL;
    if (form == 0) {
        memcpy(&s->ours, &found, sizeof found);
        s->w = calloc(memory, sizeof *s->w);
        return found && s->w;
    }
    snprintf(work, sizeof work, "%s_work", name);
    void *sizes = library ? dlsym(library, work) : NULL;
    their_sizes *ask = NULL;
    long long n[4] = {0};
    memcpy(&s->theirs, &found, sizeof found);
    memcpy(&ask, &sizes, sizeof sizes);
    if (!found || !sizes || ask(&n[0], &n[1], &n[2], &n[3]) != 0) {
        return false;
    }
    s->arg = calloc((size_t)n[0] + 1, sizeof *s->arg);
    s->res = calloc((size_t)n[1] + 2, sizeof *s->res);
    s->iw = calloc((size_t)n[2] + 1, sizeof *s->iw);
    s->w = calloc((size_t)n[3] + 1, sizeof *s->w);
    return s->arg && s->res && s->iw && s->w;
}

/* ---- timing --------------------------------------------------------------------------------- */

/* results: [OUTPUTS], then derivatives by the first input, by the second. */
static void call(side *s, const double *x, double *results)
{
    if (s->ours) {
        s->ours(x, results, s->w);
    } else {
        s->arg[0] = x;
        s->res[0] = results;
        s->res[1] = results + OUTPUTS;
        s->theirs(s->arg, s->res, s->iw, s->w, 0);
    }
}

static void point(int number, double *x)
{
    x[0] = 2 * fmod(0.618034 * number, 1) - 1;
    x[1] = 2 * fmod(0.414214 * number, 1) - 1;
}

static double difference(side *a, side *b)
{
    double worst = 0;
    for (int i = 0; i < CALLS; i++) {
        double x[INPUTS], one[RESULTS] = {0}, other[RESULTS] = {0};
        point(i, x);
        call(a, x, one);
        call(b, x, other);
        for (int k = 0; k < RESULTS; k++) {
            double off = fabs(one[k] - other[k]) / fmax(1, fabs(one[k]));
            worst = off <= worst || isnan(worst) ? worst : off;
        }
    }
    return worst;
}

static double time_calls(side *s)
{
    struct timespec from, to;
    double x[INPUTS], results[RESULTS];
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &from);
    for (int i = 0; i < CALLS; i++) {
        point(i, x);
        call(s, x, results);
    }
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &to);
    return ((double)(to.tv_sec - from.tv_sec) + 1e-9 * (double)(to.tv_nsec - from.tv_nsec)) / CALLS;
}

static void print_cell(const side *s, const side *ours, int rounds)
{
    double ratios[ROUNDS_MAX], least = INFINITY;
    for (int i = 0; i < rounds; i++) {
        least = fmin(least, s->seconds[i]);
        ratios[i] = s->seconds[i] / ours->seconds[i];
    }
    printf("%10.2f (%5.2f)", 1e6 * least, sort_median((size_t)rounds, ratios));
}

/* Sides of one form that cannot be had have neither function. */
static bool race(side (*sides)[TASKS], int rounds)
{
    for (int round = -1; round < rounds; round++) { /* the first warms up */
        for (int k = 0; k < FORMS * TASKS; k++) {
            side *s = &sides[k / TASKS][k % TASKS];
            if (s->ours || s->theirs) {
                s->seconds[round < 0 ? 0 : round] = time_calls(s);
            }
        }
    }
    printf("\n%-36s%18s%18s\n", "us a point (times cpinn's)", "value", "and Jacobian");
    for (int form = 0; form < FORMS; form++) {
        side *now = sides[form];
        if (!now[VALUE].ours && !now[VALUE].theirs) {
            continue;
        }
        printf("%-36s", forms[form].text);
        for (int task = 0; task < TASKS; task++) {
            print_cell(&now[task], &sides[0][task], rounds);
        }
        printf("\n");
        for (int task = 0; task < TASKS; task++) {
            double off = difference(&sides[0][task], &now[task]);
            if (!(off <= AGREEMENT)) {
                cli_fail(program, "%s, %s: differs by %.1e", forms[form].text, tasks[task], off);
                return false;
            }
        }
    }
    return true;
}

/* ---- all ------------------------------------------------------------------------------------ */

static bool load_form(const char *folder, int form, size_t memory, side *now)
{
    bool ok = load(folder, form, VALUE, memory, &now[VALUE]) &&
              load(folder, form, JACOBIAN, memory, &now[JACOBIAN]);
    if (!ok) {
        cli_fail(program, "%s: cannot be compiled", forms[form].text);
    }
    return ok;
}

static bool compare(const options *o, const char *folder)
{
    static double x[PARAMETERS];
    static side sides[FORMS][TASKS];
    const peer_kind casadi = {"CasADi", "peer_casadi.py", "2-64-64-7", false};
    char network[512], ours[512];
    size_t memory = 0;
    ad_error error = {AD_OK, ""};
    peer p = {0};
    snprintf(network, sizeof network, "%s/network.bin", folder);
    snprintf(ours, sizeof ours, "%s/ours.c", folder);
    if (!write_network(network, x) || write_ours(ours, x, &memory, &error) != AD_OK) {
        cli_fail_error(program, &error);
        return false;
    }
    printf("network 2-64-64-7, tanh, one point at a time; all by %s\n", COMMAND);
    bool ok = load_form(folder, 0, memory, sides[0]);
    peer_status status = peer_start(&p, &casadi, o->python, folder, 1);
    if (status != PEER_READY) {
        printf("CasADi: %s: %s\n", status == PEER_MISSING ? "not installed" : "failed", p.message);
    }
    for (int form = 1; form < FORMS && ok && status == PEER_READY; form++) {
        ok = load_form(folder, form, 0, sides[form]);
    }
    peer_stop(&p);
    return ok && status != PEER_FAILED && race(sides, o->rounds);
}

int main(int count, char **arguments)
{
    options o = {.rounds = 41, .python = "python3"};
    const char *operand;
    static const char *const help[] = {
        "A network as C, one point at a time: ours against what CasADi\n"
        "generates of the same network in its several forms.\n",
        "\n", "options:\n",
        "\n"
        "CasADi is a package of Python:\n"
        "    python3 -m venv peers && peers/bin/pip install numpy casadi\n"
        "    generated --python peers/bin/python3\n"
        "Times are the least of all rounds, ratios their medians.\n",
        NULL};
    const cli_program about = {program, NULL, help, NULL, NULL};
    const cli_option known[] = {
        {"--rounds", "N", CLI_INTEGER, &o.rounds, 1, ROUNDS_MAX, "of 500 calls of each (41)"},
        {"--python", "PROGRAM", CLI_TEXT, &o.python, 0, 0, "that has casadi (python3)"}};
    int result = cli_parse(&about, known, sizeof known / sizeof *known, count, arguments, &operand);
    if (result != CLI_RUN) {
        return result;
    }
    char folder[] = "/tmp/cpinn-generated-XXXXXX", command[64];
    if (!mkdtemp(folder)) {
        return cli_fail(program, "no temporary folder can be made");
    }
    bool ok = compare(&o, folder);
    snprintf(command, sizeof command, "rm -r %s", folder);
    return system(command) == 0 && ok ? EXIT_SUCCESS : EXIT_FAILURE;
}
