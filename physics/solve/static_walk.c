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
static void adopt(const tracer *tracer, const double *at)
{
    static_path path = static_path_of_load(tracer->path, at[tracer->size - 1]);
    static_system_set(tracer->mesh->system, &path);
    memcpy(tracer->mesh->y, at, (tracer->size - 1) * sizeof *at);
}

/* A further point of the trace, at a place. */
static ad_status record(tracer *tracer, const double *at, double load, double arclength,
                        int unstable, solution_mark mark, ad_error *error)
{
    static_trace *to = tracer->trace;
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
    adopt(tracer, at);
    ad_status status = static_at(tracer->mesh, TRACE_PLACES, s, states, error);
    if (status == AD_OK && tracer->goal == TRACE_WHOLE && tracer->path->planar) {
        status = static_unstable_in_space(tracer->mesh, &unstable, error);
    }
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

static double load_of(const tracer *tracer, const arc_place *place)
{
    return place->at[tracer->size - 1];
}

static double rise_of(const tracer *tracer, const arc_place *place)
{
    return place->tangent[tracer->size - 1];
}

static void copy_place(const tracer *tracer, const arc_place *from, arc_place *to)
{
    memcpy(to->at, from->at, tracer->size * sizeof *to->at);
    memcpy(to->tangent, from->tangent, tracer->size * sizeof *to->tangent);
}

/* ---- marks --------------------------------------------------------------------------------- */

/* What is 0 at a mark. */
typedef double (*trace_test)(tracer *x, const arc_place *place);

static double test_limit(tracer *tracer, const arc_place *place)
{
    return rise_of(tracer, place);
}

static double test_bifurcation(tracer *tracer, const arc_place *place)
{
    return static_arc_resistance(tracer->arc, place, tracer->side);
}

static double test_full_load(tracer *tracer, const arc_place *place)
{
    return load_of(tracer, place) - 1;
}

/* The test at some length from `here`, where tracer->trial is then; NaN: there is no equilibrium.
 */
static double test_at(tracer *tracer, trace_test test, double length)
{
    double off;
    const arc_place *before = tracer->has_before ? &tracer->before : NULL;
    bool found = static_arc_step(tracer->arc, before, tracer->distance, &tracer->here, length,
                                 &tracer->trial, &off, tracer->steps);
    return found ? test(tracer, &tracer->trial) : NAN;
}

/* The root of the test between lengths a and b, with values of different sign: regula falsi
 * (Illinois), to the share `small` of the larger. *length: of the root, near which tracer->trial is
 * then. false: a pole, or no equilibria. */
static bool locate(tracer *tracer, trace_test test, double a, double b, double small,
                   double *length)
{
    double at_a = test_at(tracer, test, a), at_b = test_at(tracer, test, b);
    double size = fmax(fabs(at_a), fabs(at_b)), value = INFINITY;
    if (!(at_a * at_b <= 0)) {
        return false;
    }
    for (int i = 2; i < ROOT_STEPS && fabs(value) > small * size && fabs(b - a) > 1e-15; i++) {
        double c = (a * at_b - b * at_a) / (at_b - at_a), found = test_at(tracer, test, c);
        if (!isfinite(found)) { /* too near to where other paths cross: back to the last */
            test_at(tracer, test, *length);
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
 * their loads off by up to 1e-8; a share of the step away they are exact. tracer->trial is then at
 * the mark. */
static double load_at_mark(tracer *tracer, trace_test test, double length)
{
    enum { PLACES_AROUND = 4 };
    static const double around[PLACES_AROUND] = {-2e-2, -1e-2, 1e-2, 2e-2};
    double tests[PLACES_AROUND], loads[PLACES_AROUND], load = 0;
    for (int i = 0; i < PLACES_AROUND; i++) {
        tests[i] = test_at(tracer, test, length + around[i] * tracer->length);
        loads[i] = load_of(tracer, &tracer->trial);
    }
    for (int i = 0; i < PLACES_AROUND; i++) {
        double weight = 1;
        for (int j = 0; j < PLACES_AROUND; j++) {
            weight *= j == i ? 1 : tests[j] / (tests[j] - tests[i]);
        }
        load += weight * loads[i];
    }
    test_at(tracer, test, length);
    return isfinite(load) ? load : load_of(tracer, &tracer->trial);
}

static ad_status mark_limit(tracer *tracer, double length, ad_error *error)
{
    double to_mark = 0;
    if (!locate(tracer, test_limit, 0, length, 1e-5, &to_mark)) {
        return AD_OK;
    }
    double load = load_at_mark(tracer, test_limit, to_mark);
    tracer->turned = true;
    return record(tracer, tracer->trial.at, load, tracer->arclength + to_mark, tracer->unstable,
                  SOLUTION_LIMIT, error);
}

/* To where the other path goes on, at tracer->here. */
static bool leave(tracer *tracer)
{
    arc_place *best = &tracer->before;
    double load = -INFINITY;
    for (double aside = ASIDE; aside > ASIDE / 100 && load == -INFINITY; aside /= 2) {
        for (int sign = 1; sign >= -1; sign -= 2) {
            arc_place *to = &tracer->next;
            for (size_t k = 0; k < tracer->size; k++) {
                to->at[k] = tracer->trial.at[k] + sign * aside * tracer->side[k];
                tracer->here.at[k] = to->at[k];
                tracer->here.tangent[k] = sign * tracer->side[k];
            }
            bool found = static_arc_correct(tracer->arc, tracer->side, to->at, tracer->steps) &&
                         static_arc_distance(tracer->arc, to->at, tracer->here.at) <= aside &&
                         static_arc_tangent(tracer->arc, tracer->here.tangent, to);
            /* of two that are alike the first */
            if (found && load_of(tracer, to) > load + 1e-9) {
                load = load_of(tracer, to);
                copy_place(tracer, to, best);
            }
        }
    }
    copy_place(tracer, best, &tracer->here);
    tracer->has_before = false;
    return load > -INFINITY;
}

/* Looks for a bifurcation in or near a step from `here` to `next`. *found: there is one. *left: the
 * path has changed. */
static ad_status mark_bifurcation(tracer *tracer, double length, bool *found, bool *left,
                                  ad_error *error)
{
    /* what tells how many modes are unstable is less exact than what locates it */
    const double reach[3][2] = {
        {0, length}, {-0.5 * length, 1.5 * length}, {-FIRST, length + FIRST}};
    const arc_place *from[2] = {&tracer->next, &tracer->here};
    double to_mark = 0;
    *found = false;
    for (int i = 0; i < 6 && !*found; i++) {
        *found =
            static_arc_weakest(tracer->arc, from[i % 2], tracer->side) &&
            locate(tracer, test_bifurcation, reach[i / 2][0], reach[i / 2][1], 1e-4, &to_mark) &&
            tracer->arclength + to_mark > tracer->crossing + APART;
    }
    if (!*found) {
        return AD_OK;
    }
    tracer->bifurcations++;
    tracer->crossing = tracer->arclength + to_mark;
    double load = load_at_mark(tracer, test_bifurcation, to_mark);
    ad_status status = record(tracer, tracer->trial.at, load, tracer->arclength + to_mark,
                              tracer->unstable, SOLUTION_BIFURCATION, error);
    if (status == AD_OK && !tracer->branch && tracer->bifurcations == tracer->settings->branch &&
        static_arc_weakest(tracer->arc, &tracer->trial, tracer->side) && leave(tracer)) {
        *left = tracer->branch = true;
        tracer->turned = false;
        tracer->arclength += to_mark + ASIDE;
        adopt(tracer, tracer->here.at);
        status = static_unstable(tracer->mesh, &tracer->unstable, error);
    }
    return status;
}

/* The equilibrium under the full load within a step; *done: it is the one to stop at. */
static ad_status cross(tracer *tracer, double length, bool *done, ad_error *error)
{
    double to_mark = 0;
    int unstable;
    *done = false;
    if (!locate(tracer, test_full_load, 0, length, 1e-9, &to_mark)) {
        return AD_OK;
    }
    tracer->trial.at[tracer->size - 1] = 1;
    adopt(tracer, tracer->trial.at);
    double *y = tracer->mesh->y;
    if (!static_newton_solve(tracer->mesh->newton, y, tracer->steps) ||
        static_arc_distance(tracer->arc, y, tracer->trial.at) > 1e-3) {
        return AD_OK;
    }
    memcpy(tracer->trial.at, y, (tracer->size - 1) * sizeof *y);
    ad_status status = static_unstable(tracer->mesh, &unstable, error);
    bool asked = tracer->settings->branch > 0 && !tracer->branch;
    *done = !asked && (unstable <= 0 || unstable > HOPELESS);
    if (!*done && !asked && !tracer->has_fallback) {
        memcpy(tracer->fallback, y, (tracer->size - 1) * sizeof *y);
        tracer->has_fallback = true;
    }
    if (status == AD_OK) {
        status = record(tracer, tracer->trial.at, 1, tracer->arclength + to_mark, unstable,
                        SOLUTION_PLAIN, error);
    }
    tracer->trace->arrived = *done;
    return status;
}

/* ---- following ----------------------------------------------------------------------------- */

/* tracer->next, a step of tracer->length from tracer->here, which is shortened as it has to be;
 * *unstable: its modes. *found: whether there is one. */
static ad_status step(tracer *tracer, bool *found, double *off, int *unstable, ad_error *error)
{
    const arc_place *before = tracer->has_before ? &tracer->before : NULL;
    ad_status status = AD_OK;
    for (*found = false; tracer->length >= SHORTEST; tracer->length *= 0.4) {
        if (!static_arc_step(tracer->arc, before, tracer->distance, &tracer->here, tracer->length,
                             &tracer->next, off, tracer->steps) ||
            *off > OFF_MAX ||
            static_arc_product(tracer->arc, tracer->here.tangent, tracer->next.tangent) < COSINE) {
            continue;
        }
        adopt(tracer, tracer->next.at);
        status = static_unstable(tracer->mesh, unstable, error);
        *found = tracer->unstable < 0 || abs(*unstable - tracer->unstable) <= 1 ||
                 tracer->length < SEVERAL;
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
static ad_status mark(tracer *tracer, int unstable, bool *explained, bool *left, bool *done,
                      ad_error *error)
{
    bool limit = rise_of(tracer, &tracer->here) * rise_of(tracer, &tracer->next) < 0;
    bool crosses = (load_of(tracer, &tracer->here) - 1) * (load_of(tracer, &tracer->next) - 1) <= 0;
    int changed = tracer->unstable < 0 ? 0 : abs(unstable - tracer->unstable);
    ad_status status = limit ? mark_limit(tracer, tracer->length, error) : AD_OK;
    bool wanted = tracer->goal == TRACE_WHOLE || tracer->bifurcations == 0;
    *explained = true;
    *left = *done = false;
    if (status == AD_OK && wanted && changed > limit) {
        status = mark_bifurcation(tracer, tracer->length, explained, left, error);
    }
    return status == AD_OK && !*left && crosses ? cross(tracer, tracer->length, done, error)
                                                : status;
}

static void set_home(tracer *tracer)
{
    memcpy(tracer->home, tracer->here.at, tracer->size * sizeof *tracer->home);
    tracer->since_home = tracer->arclength;
}

/* Whether the path is closed: its next step ends where it began. */
static bool comes_home(const tracer *tracer)
{
    double off = fmax(static_arc_distance(tracer->arc, tracer->next.at, tracer->home),
                      fabs(load_of(tracer, &tracer->next) - tracer->home[tracer->size - 1]));
    return tracer->arclength - tracer->since_home > 5 * LONGEST && off < tracer->length;
}

static ad_status advance(tracer *tracer, bool *going, ad_error *error)
{
    const size_t first = tracer->trace->count;
    const bool turned = tracer->turned, has_fallback = tracer->has_fallback;
    bool found, explained = true, left = false, done = false;
    double off = 0;
    int unstable = -1;
    ad_status status = step(tracer, &found, &off, &unstable, error);
    while (status == AD_OK && found) {
        status = mark(tracer, unstable, &explained, &left, &done, error);
        if (status != AD_OK || explained || tracer->length < SEVERAL) {
            break;
        }
        tracer->trace->count =
            first; /* modes change without a reason: on to another path by mistake */
        tracer->trace->arrived = done = false;
        tracer->turned = turned;
        tracer->has_fallback = has_fallback;
        tracer->length *= 0.3;
        status = step(tracer, &found, &off, &unstable, error);
    }
    put_in_order(tracer->trace, first);
    *going = status == AD_OK && found && !done && tracer->trace->count < POINTS_MAX &&
             fabs(load_of(tracer, &tracer->here)) <= WINDOW && (left || !comes_home(tracer));
    if (*going && tracer->goal == TRACE_FIRST_MARK) {
        *going = !tracer->turned && tracer->bifurcations == 0;
    }
    if (!*going) {
        return status;
    }
    if (left) {
        tracer->length = FIRST;
        set_home(tracer);
    } else {
        arc_place passed = tracer->before;
        tracer->before = tracer->here;
        tracer->here = tracer->next;
        tracer->next = passed;
        tracer->has_before = true;
        tracer->distance = tracer->length;
        tracer->arclength += tracer->length;
        tracer->unstable = unstable;
        tracer->length *= fmin(2, fmax(0.3, cbrt(OFF_AIM / fmax(off, 1e-9))));
        tracer->length = fmin(LONGEST, tracer->length);
    }
    return record(tracer, tracer->here.at, load_of(tracer, &tracer->here), tracer->arclength,
                  tracer->unstable, SOLUTION_PLAIN, error);
}

/* At the unstressed rod. *found: false where it is not held well enough to stay there. */
static ad_status set_out(tracer *tracer, bool *found, ad_error *error)
{
    static_path path = static_path_of_load(tracer->path, 0);
    double *y = tracer->mesh->y;
    ad_status status = static_system_guess(tracer->mesh->system, y, error);
    solve_report report = {.load_fraction = 1};
    if (status == AD_OK && tracer->path->twisted) { /* what the ends bend before they twist */
        path_shape bend = *tracer->path;
        bool leaps;
        bend.last = 0;
        status = static_path_follow(tracer->mesh->system, tracer->mesh->newton, &bend, y, &leaps,
                                    &report, error);
        *tracer->steps += report.newton_steps;
    }
    static_system_set(tracer->mesh->system, &path);
    *found = status == AD_OK && report.load_fraction == 1 &&
             static_newton_solve(tracer->mesh->newton, y, tracer->steps);
    if (!*found) {
        return status;
    }
    memset(tracer->next.tangent, 0, tracer->size * sizeof *tracer->next.tangent);
    tracer->next.tangent[tracer->size - 1] = 1;
    memcpy(tracer->here.at, y, (tracer->size - 1) * sizeof *y);
    tracer->here.at[tracer->size - 1] = 0;
    tracer->length = FIRST;
    set_home(tracer);
    tracer->crossing = -1;
    *found = static_arc_tangent(tracer->arc, tracer->next.tangent, &tracer->here);
    status = static_unstable(tracer->mesh, &tracer->unstable, error);
    return status == AD_OK && *found
               ? record(tracer, tracer->here.at, 0, 0, tracer->unstable, SOLUTION_PLAIN, error)
               : status;
}

static bool allocate(tracer *tracer)
{
    arc_place *places[] = {&tracer->before, &tracer->here, &tracer->next, &tracer->trial};
    double *memory = tracer->memory = malloc((2 * PLACES + 3) * tracer->size * sizeof *memory);
    for (int i = 0; i < PLACES && memory; i++, memory += 2 * tracer->size) {
        *places[i] = (arc_place){memory, memory + tracer->size};
    }
    tracer->side = memory;
    tracer->home = memory ? memory + tracer->size : NULL;
    tracer->fallback = memory ? memory + 2 * tracer->size : NULL;
    tracer->trace = calloc(1, sizeof *tracer->trace);
    return memory && tracer->trace;
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
