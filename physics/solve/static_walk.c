#include "physics/solve/static_walk.h"

#include "physics/solve/static_arc.h"
#include "physics/solve/static_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    POINTS_MAX = 1000,
    PLACES = 4,     /* before, here, next, trial */
    HOPELESS = 3,   /* more unstable modes under the full load are not lost further on */
    ROOT_STEPS = 24 /* at most, to locate a mark */
};

/* Steps of arc length; and how far their guesses may be off and are meant to be. */
static const double FIRST = 0.02, LONGEST = 0.1, SHORTEST = 1e-8, OFF_MAX = 0.05, OFF_AIM = 0.01;

/* Bifurcations that are nearer to one another are one. */
static const double APART = 1e-6;

/* A longer step may not change the number of unstable modes by more than one. */
static const double SEVERAL = 5e-3;

/* Of the tangents at both ends of a step: less of a turn cannot hide two limit points. */
static const double COSINE = 0.9;

/* A path that goes beyond this many loads in either direction is not followed any further. */
static const double WINDOW = 4;

/* How far from a bifurcation the other path is looked for. */
static const double ASIDE = 0.02;

typedef struct tracer {
    static_solution *mesh;
    static_arc *arc;
    const path_shape *path;
    trace_goal goal;
    const solve_settings *settings;
    static_trace *trace;
    long *steps;
    size_t size; /* of a place's vectors */
    arc_place before, here, next, trial;
    double *side, *memory; /* side [size]: beside the path at a bifurcation */
    double *home;          /* [size] where the path, or the branch, begins */
    double *fallback;      /* [unknowns] an unstable equilibrium under the full load */
    bool has_before, has_fallback;
    double length;       /* of the next step */
    double distance;     /* from `before` to `here` */
    double arclength;    /* of `here` */
    double crossing;     /* of the last bifurcation */
    double since_home;   /* of that */
    int unstable;        /* modes of `here` */
    int bifurcations;    /* passed */
    bool turned, branch; /* passed a limit point; left for another path */
} tracer;

/* ---- one equilibrium ----------------------------------------------------------------------- */

/* Makes it the equilibrium of the mesh. */
static void adopt(const tracer *x, const double *at)
{
    static_path path = static_path_of_load(x->path, at[x->size - 1]);
    static_system_set(x->mesh->system, &path);
    memcpy(x->mesh->y, at, (x->size - 1) * sizeof *at);
}

/* A further point of the trace, at a place. */
static ad_status record(tracer *x, const double *at, double load, double arclength, int unstable,
                        solution_mark mark, ad_error *error)
{
    static_trace *to = x->trace;
    if (to->count == to->room) {
        size_t room = to->room ? 2 * to->room : 64;
        trace_point *grown = realloc(to->points, room * sizeof *grown);
        if (!grown) {
            return ad_fail(error, AD_NO_MEMORY, "out of memory for a path");
        }
        to->points = grown;
        to->room = room;
    }
    double s[TRACE_PLACES];
    solve_state states[TRACE_PLACES];
    for (int i = 0; i < TRACE_PLACES; i++) {
        s[i] = (double)i / (TRACE_PLACES - 1);
    }
    adopt(x, at);
    ad_status status = static_at(x->mesh, TRACE_PLACES, s, states, error);
    if (status == AD_OK) {
        trace_point *point = &to->points[to->count++];
        *point =
            (trace_point){.load = load, .arclength = arclength, .unstable = unstable, .mark = mark};
        for (int i = 0; i < TRACE_PLACES; i++) {
            memcpy(point->position[i], states[i].position, sizeof point->position[i]);
        }
    }
    return status;
}

static double load_of(const tracer *x, const arc_place *place)
{
    return place->at[x->size - 1];
}

static double rise_of(const tracer *x, const arc_place *place)
{
    return place->tangent[x->size - 1];
}

static void copy_place(const tracer *x, const arc_place *from, arc_place *to)
{
    memcpy(to->at, from->at, x->size * sizeof *to->at);
    memcpy(to->tangent, from->tangent, x->size * sizeof *to->tangent);
}

/* ---- marks --------------------------------------------------------------------------------- */

/* What is 0 at a mark. */
typedef double (*trace_test)(tracer *x, const arc_place *place);

static double test_limit(tracer *x, const arc_place *place)
{
    return rise_of(x, place);
}

static double test_bifurcation(tracer *x, const arc_place *place)
{
    return static_arc_resistance(x->arc, place, x->side);
}

static double test_full_load(tracer *x, const arc_place *place)
{
    return load_of(x, place) - 1;
}

/* The test at some length from `here`, where x->trial is then; NaN: there is no equilibrium. */
static double test_at(tracer *x, trace_test test, double length)
{
    double off;
    const arc_place *before = x->has_before ? &x->before : NULL;
    bool found =
        static_arc_step(x->arc, before, x->distance, &x->here, length, &x->trial, &off, x->steps);
    return found ? test(x, &x->trial) : NAN;
}

/* The root of the test between lengths a and b, with values of different sign: regula falsi
 * (Illinois), to the share `small` of the larger. *length: of the root, near which x->trial is
 * then. false: a pole, or no equilibria. */
static bool locate(tracer *x, trace_test test, double a, double b, double small, double *length)
{
    double at_a = test_at(x, test, a), at_b = test_at(x, test, b);
    double size = fmax(fabs(at_a), fabs(at_b)), value = INFINITY;
    if (!(at_a * at_b <= 0)) {
        return false;
    }
    for (int i = 2; i < ROOT_STEPS && fabs(value) > small * size && fabs(b - a) > 1e-15; i++) {
        double c = (a * at_b - b * at_a) / (at_b - at_a), found = test_at(x, test, c);
        if (!isfinite(found)) { /* too near to where other paths cross: back to the last */
            test_at(x, test, *length);
            break;
        }
        value = found;
        *length = c;
        if (value * at_b < 0) {
            a = b;
            at_a = at_b;
        } else {
            at_a /= 2;
        }
        b = c;
        at_b = value;
    }
    return fabs(value) <= 1e-3 * size;
}

/* The load at a mark that is located: where Lagrange's polynomial through four places around it,
 * two on either side, has its root. At a bifurcation itself equilibria are nearly singular and
 * their loads off by up to 1e-8; a share of the step away they are exact. x->trial is then at the
 * mark. */
static double load_at_mark(tracer *x, trace_test test, double length)
{
    enum { PLACES_AROUND = 4 };
    static const double around[PLACES_AROUND] = {-2e-2, -1e-2, 1e-2, 2e-2};
    double tests[PLACES_AROUND], loads[PLACES_AROUND], load = 0;
    for (int i = 0; i < PLACES_AROUND; i++) {
        tests[i] = test_at(x, test, length + around[i] * x->length);
        loads[i] = load_of(x, &x->trial);
    }
    for (int i = 0; i < PLACES_AROUND; i++) {
        double weight = 1;
        for (int j = 0; j < PLACES_AROUND; j++) {
            weight *= j == i ? 1 : tests[j] / (tests[j] - tests[i]);
        }
        load += weight * loads[i];
    }
    test_at(x, test, length);
    return isfinite(load) ? load : load_of(x, &x->trial);
}

static ad_status mark_limit(tracer *x, double length, ad_error *error)
{
    double to_mark = 0;
    if (!locate(x, test_limit, 0, length, 1e-5, &to_mark)) {
        return AD_OK;
    }
    double load = load_at_mark(x, test_limit, to_mark);
    x->turned = true;
    return record(x, x->trial.at, load, x->arclength + to_mark, x->unstable, SOLUTION_LIMIT, error);
}

/* To where the other path goes on, at x->here. */
static bool leave(tracer *x)
{
    arc_place *best = &x->before;
    double load = -INFINITY;
    for (double aside = ASIDE; aside > ASIDE / 100 && load == -INFINITY; aside /= 2) {
        for (int sign = 1; sign >= -1; sign -= 2) {
            arc_place *to = &x->next;
            for (size_t k = 0; k < x->size; k++) {
                to->at[k] = x->trial.at[k] + sign * aside * x->side[k];
                x->here.at[k] = to->at[k];
                x->here.tangent[k] = sign * x->side[k];
            }
            bool found = static_arc_correct(x->arc, x->side, to->at, x->steps) &&
                         static_arc_distance(x->arc, to->at, x->here.at) <= aside &&
                         static_arc_tangent(x->arc, x->here.tangent, to);
            /* of two that are alike the first */
            if (found && load_of(x, to) > load + 1e-9) {
                load = load_of(x, to);
                copy_place(x, to, best);
            }
        }
    }
    copy_place(x, best, &x->here);
    x->has_before = false;
    return load > -INFINITY;
}

/* Looks for a bifurcation in or near a step from `here` to `next`. *found: there is one. *left: the
 * path has changed. */
static ad_status mark_bifurcation(tracer *x, double length, bool *found, bool *left,
                                  ad_error *error)
{
    /* what tells how many modes are unstable is less exact than what locates it */
    const double reach[3][2] = {
        {0, length}, {-0.5 * length, 1.5 * length}, {-FIRST, length + FIRST}};
    const arc_place *from[2] = {&x->next, &x->here};
    double to_mark = 0;
    *found = false;
    for (int i = 0; i < 6 && !*found; i++) {
        *found = static_arc_weakest(x->arc, from[i % 2], x->side) &&
                 locate(x, test_bifurcation, reach[i / 2][0], reach[i / 2][1], 1e-4, &to_mark) &&
                 x->arclength + to_mark > x->crossing + APART;
    }
    if (!*found) {
        return AD_OK;
    }
    x->bifurcations++;
    x->crossing = x->arclength + to_mark;
    double load = load_at_mark(x, test_bifurcation, to_mark);
    ad_status status = record(x, x->trial.at, load, x->arclength + to_mark, x->unstable,
                              SOLUTION_BIFURCATION, error);
    if (status == AD_OK && !x->branch && x->bifurcations == x->settings->branch &&
        static_arc_weakest(x->arc, &x->trial, x->side) && leave(x)) {
        *left = x->branch = true;
        x->turned = false;
        x->arclength += to_mark + ASIDE;
        adopt(x, x->here.at);
        status = static_unstable(x->mesh, &x->unstable, error);
    }
    return status;
}

/* The equilibrium under the full load within a step; *done: it is the one to stop at. */
static ad_status cross(tracer *x, double length, bool *done, ad_error *error)
{
    double to_mark = 0;
    int unstable;
    *done = false;
    if (!locate(x, test_full_load, 0, length, 1e-9, &to_mark)) {
        return AD_OK;
    }
    x->trial.at[x->size - 1] = 1;
    adopt(x, x->trial.at);
    double *y = x->mesh->y;
    if (!static_newton_solve(x->mesh->newton, y, x->steps) ||
        static_arc_distance(x->arc, y, x->trial.at) > 1e-3) {
        return AD_OK;
    }
    memcpy(x->trial.at, y, (x->size - 1) * sizeof *y);
    ad_status status = static_unstable(x->mesh, &unstable, error);
    bool asked = x->settings->branch > 0 && !x->branch;
    *done = !asked && (unstable <= 0 || unstable > HOPELESS);
    if (!*done && !asked && !x->has_fallback) {
        memcpy(x->fallback, y, (x->size - 1) * sizeof *y);
        x->has_fallback = true;
    }
    if (status == AD_OK) {
        status = record(x, x->trial.at, 1, x->arclength + to_mark, unstable, SOLUTION_PLAIN, error);
    }
    x->trace->arrived = *done;
    return status;
}

/* ---- following ----------------------------------------------------------------------------- */

/* x->next, a step of x->length from x->here, which is shortened as it has to be; *unstable: its
 * modes. *found: whether there is one. */
static ad_status step(tracer *x, bool *found, double *off, int *unstable, ad_error *error)
{
    const arc_place *before = x->has_before ? &x->before : NULL;
    ad_status status = AD_OK;
    for (*found = false; x->length >= SHORTEST; x->length *= 0.4) {
        if (!static_arc_step(x->arc, before, x->distance, &x->here, x->length, &x->next, off,
                             x->steps) ||
            *off > OFF_MAX ||
            static_arc_product(x->arc, x->here.tangent, x->next.tangent) < COSINE) {
            continue;
        }
        adopt(x, x->next.at);
        status = static_unstable(x->mesh, unstable, error);
        *found = x->unstable < 0 || abs(*unstable - x->unstable) <= 1 || x->length < SEVERAL;
        if (*found || status != AD_OK) {
            break;
        }
    }
    return status;
}

/* Puts the points from `first` on in the order in which the path meets them. */
static void put_in_order(static_trace *trace, size_t first)
{
    for (size_t i = first + 1; i < trace->count; i++) {
        for (size_t j = i; j > first && trace->points[j].arclength < trace->points[j - 1].arclength;
             j--) {
            trace_point swapped = trace->points[j];
            trace->points[j] = trace->points[j - 1];
            trace->points[j - 1] = swapped;
        }
    }
}

/* The marks between `here` and `next`, where `unstable` modes are. */
static ad_status mark(tracer *x, int unstable, bool *explained, bool *left, bool *done,
                      ad_error *error)
{
    bool limit = rise_of(x, &x->here) * rise_of(x, &x->next) < 0;
    bool crosses = (load_of(x, &x->here) - 1) * (load_of(x, &x->next) - 1) <= 0;
    int changed = x->unstable < 0 ? 0 : abs(unstable - x->unstable);
    ad_status status = limit ? mark_limit(x, x->length, error) : AD_OK;
    bool wanted = x->goal == TRACE_WHOLE || x->bifurcations == 0;
    *explained = true;
    *left = *done = false;
    if (status == AD_OK && wanted && changed > limit) {
        status = mark_bifurcation(x, x->length, explained, left, error);
    }
    return status == AD_OK && !*left && crosses ? cross(x, x->length, done, error) : status;
}

static void set_home(tracer *x)
{
    memcpy(x->home, x->here.at, x->size * sizeof *x->home);
    x->since_home = x->arclength;
}

/* Whether the path is closed: its next step ends where it began. */
static bool comes_home(const tracer *x)
{
    double off = fmax(static_arc_distance(x->arc, x->next.at, x->home),
                      fabs(load_of(x, &x->next) - x->home[x->size - 1]));
    return x->arclength - x->since_home > 5 * LONGEST && off < x->length;
}

static ad_status advance(tracer *x, bool *going, ad_error *error)
{
    const size_t first = x->trace->count;
    const bool turned = x->turned, has_fallback = x->has_fallback;
    bool found, explained = true, left = false, done = false;
    double off = 0;
    int unstable = -1;
    ad_status status = step(x, &found, &off, &unstable, error);
    while (status == AD_OK && found) {
        status = mark(x, unstable, &explained, &left, &done, error);
        if (status != AD_OK || explained || x->length < SEVERAL) {
            break;
        }
        x->trace->count = first; /* modes change without a reason: on to another path by mistake */
        x->trace->arrived = done = false;
        x->turned = turned;
        x->has_fallback = has_fallback;
        x->length *= 0.3;
        status = step(x, &found, &off, &unstable, error);
    }
    put_in_order(x->trace, first);
    *going = status == AD_OK && found && !done && x->trace->count < POINTS_MAX &&
             fabs(load_of(x, &x->here)) <= WINDOW && (left || !comes_home(x));
    if (*going && x->goal == TRACE_FIRST_MARK) {
        *going = !x->turned && x->bifurcations == 0;
    }
    if (!*going) {
        return status;
    }
    if (left) {
        x->length = FIRST;
        set_home(x);
    } else {
        arc_place passed = x->before;
        x->before = x->here;
        x->here = x->next;
        x->next = passed;
        x->has_before = true;
        x->distance = x->length;
        x->arclength += x->length;
        x->unstable = unstable;
        x->length *= fmin(2, fmax(0.3, cbrt(OFF_AIM / fmax(off, 1e-9))));
        x->length = fmin(LONGEST, x->length);
    }
    return record(x, x->here.at, load_of(x, &x->here), x->arclength, x->unstable, SOLUTION_PLAIN,
                  error);
}

/* At the unstressed rod. *found: false where it is not held well enough to stay there. */
static ad_status set_out(tracer *x, bool *found, ad_error *error)
{
    static_path path = static_path_of_load(x->path, 0);
    double *y = x->mesh->y;
    ad_status status = static_system_guess(x->mesh->system, y, error);
    solve_report report = {.load_fraction = 1};
    if (status == AD_OK && x->path->twisted) { /* what the ends bend before they twist */
        path_shape bend = *x->path;
        bool leaps;
        bend.last = 0;
        status =
            static_path_follow(x->mesh->system, x->mesh->newton, &bend, y, &leaps, &report, error);
        *x->steps += report.newton_steps;
    }
    static_system_set(x->mesh->system, &path);
    *found = status == AD_OK && report.load_fraction == 1 &&
             static_newton_solve(x->mesh->newton, y, x->steps);
    if (!*found) {
        return status;
    }
    memset(x->next.tangent, 0, x->size * sizeof *x->next.tangent);
    x->next.tangent[x->size - 1] = 1;
    memcpy(x->here.at, y, (x->size - 1) * sizeof *y);
    x->here.at[x->size - 1] = 0;
    x->length = FIRST;
    set_home(x);
    x->crossing = -1;
    *found = static_arc_tangent(x->arc, x->next.tangent, &x->here);
    status = static_unstable(x->mesh, &x->unstable, error);
    return status == AD_OK && *found
               ? record(x, x->here.at, 0, 0, x->unstable, SOLUTION_PLAIN, error)
               : status;
}

static bool allocate(tracer *x)
{
    arc_place *places[] = {&x->before, &x->here, &x->next, &x->trial};
    double *memory = x->memory = malloc((2 * PLACES + 3) * x->size * sizeof *memory);
    for (int i = 0; i < PLACES && memory; i++, memory += 2 * x->size) {
        *places[i] = (arc_place){memory, memory + x->size};
    }
    x->side = memory;
    x->home = memory ? memory + x->size : NULL;
    x->fallback = memory ? memory + 2 * x->size : NULL;
    x->trace = calloc(1, sizeof *x->trace);
    return memory && x->trace;
}

ad_status static_walk(static_solution *mesh, const solve_settings *settings, const path_shape *path,
                      trace_goal goal, static_trace **result, long *steps, ad_error *error)
{
    tracer x = {.mesh = mesh, .path = path, .goal = goal, .settings = settings, .steps = steps};
    bool going = false;
    ad_status status = static_arc_create(mesh->system, path, &x.arc, error);
    if (status == AD_OK) {
        x.size = static_arc_size(x.arc);
        status = allocate(&x) ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a path");
    }
    if (status == AD_OK) {
        status = set_out(&x, &going, error);
    }
    bool found = going;
    while (status == AD_OK && going) {
        status = advance(&x, &going, error);
    }
    bool missed = settings->branch > 0 && !x.branch;
    if (status == AD_OK && found && !x.trace->arrived && x.has_fallback && !missed) {
        memcpy(mesh->y, x.fallback, (x.size - 1) * sizeof *mesh->y);
        static_system_set(mesh->system, &(static_path){.load = 1});
        x.trace->arrived = true;
    }
    if (status == AD_OK && found && missed) {
        status = ad_fail(error, AD_BAD_ARGUMENT,
                         "branch %d: the path to the full load has %d bifurcation%s",
                         settings->branch, x.bifurcations, x.bifurcations == 1 ? "" : "s");
    }
    if (status != AD_OK || !found) {
        static_trace_free(x.trace);
        x.trace = NULL;
    }
    *result = x.trace;
    static_arc_free(x.arc);
    free(x.memory);
    return status;
}
