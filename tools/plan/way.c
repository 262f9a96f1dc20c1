#include "tools/plan/way.h"

#include "physics/numerics/clock.h"
#include "physics/numerics/quaternion.h"
#include "tools/plan/ompl_shim.h"
#include "tools/plan/reach.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { HALVINGS = 2, SEARCHES_MAX = 5, GOALS_MAX = 16, SHAPES_MAX = 20000 };

/* Where a way starts or ends. */
typedef struct place {
    double q[GOALS_MAX * PLAN_VARIABLES_MAX]; /* configurations that are free */
    double room, unknown;                     /* m, the least and the most of them, as below */
} place;

typedef struct finder {
    const way_problem *of;
    const plan_robot *robot;
    way *to;
    const plan_goal *goals; /* [to->goals] */
    place start, at[PLAN_GOALS_MAX];
    double room;    /* m, the least that start and goal have beyond what is promised */
    double unknown; /* what unknown parameters take off there at most */
    int wider;      /* powers of two of the room that is kept beyond that */
    double needed;  /* of the rod from the surface, in the search */
    roadmap map;
    double *values, *r; /* [points][columns], [points][3] */
    ad_error *error;
    ad_status status; /* of what fails within a planner */
} finder;

/* ---- one configuration in the search --------------------------------------------------------- */

/* Whether a line between points is as far from the surface as is needed: by the grid where that
 * decides, for distances change by no more than places do, else exactly. */
static bool is_beyond(const finder *f, const double a[3], const double b[3], int halvings)
{
    const distance_field *const field = &f->of->grid->field;
    const environment *const of = f->of->environment;
    const double middle[3] = {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2};
    const double least = distance_field_least(field, middle);
    if (least - vector_distance(a, middle) >= f->needed) {
        return true;
    }
    if (halvings > 0 && least >= f->needed) {
        return is_beyond(f, a, middle, halvings - 1) && is_beyond(f, middle, b, halvings - 1);
    }
    return environment_is_beyond(of, a, b, f->needed) &&
           !(least < 0 && environment_distance(of, middle, INFINITY) < 0);
}

/* Whether all of the rod is. */
static bool is_free(void *context, const double *configuration)
{
    finder *const f = context;
    const way_shapes *const shapes = f->of->shapes;
    const distance_grid *const grid = f->of->grid;
    const double off = distance_grid_error(grid);
    double parameters[SCENE_PARAMETERS_MAX];
    if (f->status != AD_OK) {
        return false;
    }
    plan_robot_parameters(f->robot, configuration, parameters);
    f->status = shapes->of_member(shapes->context, parameters, f->values, f->error);
    plan_robot_place(f->robot, configuration, shapes->points, shapes->columns, f->values, f->r);
    double before = NAN;
    for (size_t k = shapes->points; k-- > 0 && f->status == AD_OK;) { /* the tip is likelier */
        if (shapes->s[k] < f->of->settings->from) {
            break;
        }
        const double *const r = &f->r[3 * k];
        if (!isfinite(r[0] + r[1] + r[2])) {
            return false; /* there is no such shape */
        }
        const double here = distance_field_at(&grid->field, r);
        if (here + off < f->needed) {
            return false;
        }
        if (k + 1 < shapes->points &&
            (here + before - vector_distance(r, r + 3)) / 2 - off < f->needed &&
            !is_beyond(f, r, r + 3, HALVINGS)) {
            return false;
        }
        before = here;
    }
    return f->status == AD_OK;
}

/* ---- start and goals ------------------------------------------------------------------------- */

static ad_status take(const finder *f, const char *of, int count, const double *given, double *to,
                      char key[PLAN_KEY])
{
    const plan_robot *const robot = f->robot;
    snprintf(key, PLAN_KEY, "%s", of);
    if (count != robot->count) {
        return ad_fail(f->error, AD_BAD_INPUT, "has %d numbers; the robot has %d variables", count,
                       robot->count);
    }
    for (int k = 0; k < count; k++) {
        if (!(given[k] >= robot->low[k] && given[k] <= robot->high[k])) {
            return ad_fail(f->error, AD_BAD_INPUT,
                           "%s = %g is outside its range; allowed: %g to %g", robot->names[k],
                           given[k], robot->low[k], robot->high[k]);
        }
        to[k] = given[k];
    }
    return AD_OK;
}

static certificate_settings promise(const finder *f)
{
    const plan_settings *const s = f->of->settings;
    return (certificate_settings){s->radius, s->from, s->clearance, SHAPES_MAX};
}

static ad_status certify(const finder *f, size_t count, const double *configurations,
                         certificate **result)
{
    const certificate_settings settings = promise(f);
    return certificate_create(f->of->exact, f->of->environment, f->of->settings->environment.side,
                              &settings, count, configurations, result, f->error);
}

/* Whether one configuration is free; it is counted into the room of a place. */
static ad_status try_one(finder *f, const double *q, place *at, bool *free_of_it, char why[200])
{
    certificate *c = NULL;
    ad_status status = certify(f, 1, q, &c);
    *free_of_it = status == AD_OK && c->end == CERTIFICATE_HOLDS;
    if (*free_of_it) {
        const clearance *const shape = &c->shape[0];
        at->room = fmin(at->room, shape->free + shape->unknown - f->of->settings->clearance);
        at->unknown = fmax(at->unknown, shape->unknown);
    } else if (status == AD_OK && c->end == CERTIFICATE_TOO_NEAR) {
        snprintf(why, 200,
                 "the robot is too near to the surface there: of %.4g mm, %.4g mm are "
                 "left at s = %.4g m",
                 1e3 * f->of->settings->clearance, 1e3 * c->shape[0].free, c->shape[0].at);
    } else if (status == AD_OK) {
        snprintf(why, 200, "%s there", certificate_text(c->end));
    }
    certificate_free(c);
    return status;
}

static ad_status find_start(finder *f, char key[PLAN_KEY])
{
    const plan_settings *const s = f->of->settings;
    double q[PLAN_VARIABLES_MAX];
    for (int k = 0; k < f->robot->count; k++) {
        q[k] = fmin(fmax(0, f->robot->low[k]), f->robot->high[k]);
    }
    ad_status status = take(f, "plan.start", s->start_count ? s->start_count : f->robot->count,
                            s->start_count ? s->start : q, f->start.q, key);
    bool holds = false;
    char why[200];
    status = status == AD_OK ? try_one(f, f->start.q, &f->start, &holds, why) : status;
    return status == AD_OK && !holds ? ad_fail(f->error, AD_BAD_INPUT, "%s", why) : status;
}

/* A key of a goal by its name there. */
static void name_key(const finder *f, int goal, const char *what, char key[PLAN_KEY])
{
    if (f->of->settings->goal_count > 0) {
        snprintf(key, PLAN_KEY, "plan.goals[%d].%s", goal, what);
    } else {
        snprintf(key, PLAN_KEY, "plan.goal.%s", what);
    }
}

static ad_status find_tips(finder *f, int goal, char key[PLAN_KEY])
{
    const plan_goal *const g = &f->goals[goal];
    way_goal *const to = &f->to->goal[goal];
    const size_t n = (size_t)f->robot->count;
    const double length = sqrt(vector_dot(g->direction, g->direction));
    reach_goal tip = {.tolerance = isnan(g->tolerance) ? 1e-3 * f->of->exact->length : g->tolerance,
                      .angle = g->angle};
    for (int i = 0; i < 3; i++) {
        tip.tip[i] = g->position[i];
        tip.direction[i] = g->direction[i] / length;
    }
    name_key(f, goal, "direction", key);
    if (length == 0) {
        return ad_fail(f->error, AD_BAD_INPUT, "has no length; allowed: not all three 0");
    }
    reach *const found = malloc(sizeof *found);
    if (!found) {
        return ad_fail(f->error, AD_NO_MEMORY, "out of memory for goals");
    }
    name_key(f, goal, "position", key);
    ad_status status =
        reach_tip(f->of->exact, &tip, f->start.q, (uint64_t)f->of->settings->seed, found, f->error);
    to->nearest = found->nearest;
    to->angle = found->angle;
    to->end = found->count ? WAY_GOAL_TOUCHES : WAY_GOAL_BEYOND;
    for (size_t i = 0; i < found->count && to->count < GOALS_MAX && status == AD_OK; i++) {
        bool holds = false;
        char why[200];
        status = try_one(f, &found->configuration[i * n], &f->at[goal], &holds, why);
        if (holds) {
            memcpy(&f->at[goal].q[to->count++ * n], &found->configuration[i * n],
                   n * sizeof(double));
            to->end = WAY_NOT_TRIED;
        }
    }
    free(found);
    return status;
}

static ad_status find_goal(finder *f, int goal, char key[PLAN_KEY])
{
    const plan_goal *const g = &f->goals[goal];
    char name[PLAN_KEY], why[200];
    bool holds = false;
    f->at[goal].room = INFINITY;
    if (g->count == 0 && isnan(g->position[0])) {
        name_key(f, goal, "position", key);
        name_key(f, goal, "actuators", name);
        return ad_fail(f->error, AD_BAD_INPUT, "is not given; allowed: three numbers (m), or %s",
                       name);
    }
    if (g->count == 0) {
        return find_tips(f, goal, key);
    }
    name_key(f, goal, "actuators", name);
    ad_status status = take(f, name, g->count, g->actuators, f->at[goal].q, key);
    status = status == AD_OK ? try_one(f, f->at[goal].q, &f->at[goal], &holds, why) : status;
    f->to->goal[goal].count = 1;
    return status == AD_OK && !holds ? ad_fail(f->error, AD_BAD_INPUT, "%s", why) : status;
}

/* All of them before any search; whether all can be reached. */
static ad_status find_goals(finder *f, bool *all, char key[PLAN_KEY])
{
    ad_status status = AD_OK;
    *all = true;
    for (int k = 0; k < f->to->goals && status == AD_OK; k++) {
        status = find_goal(f, k, key);
        *all &= f->to->goal[k].count > 0;
    }
    return status;
}

/* ---- searches -------------------------------------------------------------------------------- */

/* What a search keeps beyond what is promised: the error of its shapes, what unknown parameters
 * take off, and some room for what bounds take off, which makes a certificate short; where start
 * and goals leave less, most of that. */
static double margin(const finder *f)
{
    const plan_settings *const s = f->of->settings;
    const double wanted =
        fmax(fmax(0.1 * s->clearance, 0.2 * s->radius), 1e-4 * f->of->exact->length);
    return fmin(f->of->shapes->error + f->unknown + ldexp(wanted, f->wider), 0.8 * f->room);
}

static ompl_search search_of(finder *f, int search, int goal, size_t states)
{
    const plan_settings *const s = f->of->settings;
    f->needed = s->radius + s->clearance + margin(f);
    return (ompl_search){.count = f->robot->count,
                         .low = f->robot->low,
                         .high = f->robot->high,
                         .is_free = is_free,
                         .context = f,
                         .step = ldexp(f->of->roadmap && search == 0 ? 0.02 : 0.04, -search),
                         .method = s->method,
                         .states = states,
                         .seed = s->seed + search,
                         .start = f->start.q,
                         .goals = f->to->goal[goal].count,
                         .goal = f->at[goal].q};
}

/* With as much room as any search wants at first. */
static ad_status open_roadmap(finder *f, char key[PLAN_KEY])
{
    const double start = clock_seconds(CLOCK_MONOTONIC);
    if (!f->of->roadmap) {
        return AD_OK;
    }
    snprintf(key, PLAN_KEY, "plan.roadmap.file");
    f->room = INFINITY;
    f->unknown = f->start.unknown;
    for (int k = 0; k < f->to->goals; k++) {
        f->unknown = fmax(f->unknown, f->at[k].unknown);
    }
    const ompl_search how = search_of(f, 0, 0, 0);
    const ad_status status =
        roadmap_open(f->of->roadmap, f->robot, &how, f->needed, &f->status, &f->map, f->error);
    f->to->source = f->map.source;
    f->to->nodes = f->map.nodes;
    f->to->edges = f->map.edges;
    f->to->seconds_roadmap = clock_seconds(CLOCK_MONOTONIC) - start;
    return status;
}

/* From the start to a goal: the certificate of the last way that was found; NULL: none was. */
static ad_status search(finder *f, int goal, certificate **result)
{
    const size_t states = (size_t)f->of->settings->states, before = f->to->looked;
    size_t corners = 0;
    f->wider = 0;
    for (int k = 0; k < SEARCHES_MAX && f->to->looked - before < states; k++) {
        const bool by_map = f->map.map && k == 0; /* later ones want more room than it knows of */
        const size_t left = states - (f->to->looked - before);
        const ompl_search asked = search_of(f, k, goal, k < 2 ? left / 4 : left);
        double *found = NULL;
        size_t length = 0, looked = 0;
        const double start = clock_seconds(CLOCK_MONOTONIC),
                     begin = clock_seconds(CLOCK_THREAD_CPUTIME_ID);
        ad_status status =
            by_map ? roadmap_find(&f->map, &asked, f->needed, &found, &length, &looked, f->error)
                   : ompl_find(&asked, &found, &length, &looked, f->error);
        const double middle = clock_seconds(CLOCK_MONOTONIC),
                     half = clock_seconds(CLOCK_THREAD_CPUTIME_ID);
        status = status == AD_OK ? f->status : status;
        f->to->looked += looked;
        f->to->searches++;
        f->to->seconds_search += middle - start;
        f->to->processor_search += half - begin;
        f->wider += found ? 1 : -2;
        if (status == AD_OK && found) {
            certificate_free(*result);
            *result = NULL;
            corners = length;
            status = certify(f, length, found, result);
            f->to->seconds_certificate += clock_seconds(CLOCK_MONOTONIC) - middle;
            f->to->processor_certificate += clock_seconds(CLOCK_THREAD_CPUTIME_ID) - half;
        }
        free(found);
        if (status != AD_OK) {
            return status;
        }
        if (*result && (*result)->end == CERTIFICATE_HOLDS) {
            break;
        }
    }
    f->to->corners += corners - (goal > 0 && corners > 0); /* a goal on the way is one */
    return AD_OK;
}

/* From goal to goal, as long as ways hold. */
static ad_status go(finder *f)
{
    way *const to = f->to;
    for (int k = 0; k < to->goals; k++) {
        certificate *leg = NULL;
        f->room = fmin(f->start.room, f->at[k].room);
        f->unknown = fmax(f->start.unknown, f->at[k].unknown);
        ad_status status = search(f, k, &leg);
        to->goal[k].end = to->end = !leg                            ? WAY_NOT_FOUND
                                    : leg->end == CERTIFICATE_HOLDS ? WAY_CERTIFIED
                                                                    : WAY_NOT_CERTIFIED;
        if (status == AD_OK && leg) {
            const size_t n = (size_t)f->robot->count;
            memcpy(f->start.q, &leg->configuration[(leg->count - 1) * n], n * sizeof(double));
            f->start.room = f->at[k].room;
            f->start.unknown = f->at[k].unknown;
            status = certificate_join(&to->certificate, leg, f->error);
            leg = status == AD_OK ? NULL : leg;
        }
        if (status != AD_OK || to->end != WAY_CERTIFIED) {
            certificate_free(leg);
            return status;
        }
        to->goal[k].row = to->certificate->count - 1;
    }
    return AD_OK;
}

ad_status way_find(const way_problem *problem, way *result, char key[PLAN_KEY], ad_error *error)
{
    const plan_settings *const s = problem->settings;
    const size_t points = problem->shapes->points;
    bool all = false;
    *result = (way){.goals = s->goal_count ? s->goal_count : 1};
    finder *const f = calloc(1, sizeof *f);
    if (!f) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory");
    }
    f->of = problem;
    f->robot = problem->exact->robot;
    f->to = result;
    f->goals = s->goal_count ? s->goals : &s->goal;
    f->start.room = INFINITY;
    f->error = error;
    f->values = malloc(points * problem->shapes->columns * sizeof *f->values);
    f->r = malloc(3 * points * sizeof *f->r);
    for (int k = 0; k < result->goals; k++) {
        result->goal[k].end = WAY_NOT_TRIED;
    }
    ad_status status = f->values && f->r ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    status = status == AD_OK ? find_start(f, key) : status;
    status = status == AD_OK ? find_goals(f, &all, key) : status;
    for (int k = result->goals; k-- > 0 && !all;) {
        result->end = result->goal[k].count == 0 ? result->goal[k].end : result->end;
    }
    status = status == AD_OK && all ? open_roadmap(f, key) : status;
    status = status == AD_OK && all ? go(f) : status;
    roadmap_close(&f->map);
    free(f->values);
    free(f->r);
    free(f);
    if (status != AD_OK || result->end == WAY_NOT_FOUND) {
        way_free(result);
    }
    return status;
}

void way_free(way *of)
{
    certificate_free(of->certificate);
    of->certificate = NULL;
}
