#include "tools/plan/way.h"

#include "physics/numerics/quaternion.h"
#include "tools/plan/ompl_shim.h"
#include "tools/plan/reach.h"
#include "tools/train/clock.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SEARCHES_MAX = 5, GOALS_MAX = 16, SHAPES_MAX = 20000 };

typedef struct finder {
    const way_problem *of;
    const plan_robot *robot;
    way *to;
    double start[PLAN_VARIABLES_MAX];
    double goals[GOALS_MAX * PLAN_VARIABLES_MAX];
    double room;        /* m, the least that start and goals have beyond what is promised */
    double unknown;     /* what unknown parameters take off there at most */
    double needed;      /* of the rod from the surface, in the search */
    double *values, *r; /* [points][columns], [points][3] */
    ad_error *error;
    ad_status status; /* of what fails within a planner */
} finder;

/* ---- one configuration in the search --------------------------------------------------------- */

/* Whether all lines between points are as far from the surface as is needed: by the grid where that
 * decides, for distances change by no more than places do, else exactly. */
static bool is_free(void *context, const double *configuration)
{
    finder *const f = context;
    const way_shapes *const shapes = f->of->shapes;
    const environment *const of = f->of->environment;
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
        const double here = distance_grid_at(grid, r);
        if (here + off < f->needed) {
            return false;
        }
        if (k + 1 < shapes->points &&
            (here + before - vector_distance(r, r + 3)) / 2 - off < f->needed &&
            (!environment_is_beyond(of, r, r + 3, f->needed) ||
             (here < off && environment_distance(of, r, INFINITY) < 0))) {
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

/* Whether one configuration is free; it is counted into the room. */
static ad_status try_one(finder *f, const double *q, bool *free_of_it, char why[200])
{
    certificate *c = NULL;
    ad_status status = certify(f, 1, q, &c);
    *free_of_it = status == AD_OK && c->end == CERTIFICATE_HOLDS;
    if (*free_of_it) {
        const clearance *const shape = &c->shape[0];
        f->room = fmin(f->room, shape->free + shape->unknown - f->of->settings->clearance);
        f->unknown = fmax(f->unknown, shape->unknown);
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
                            s->start_count ? s->start : q, f->start, key);
    bool holds = false;
    char why[200];
    status = status == AD_OK ? try_one(f, f->start, &holds, why) : status;
    return status == AD_OK && !holds ? ad_fail(f->error, AD_BAD_INPUT, "%s", why) : status;
}

static ad_status find_tips(finder *f, char key[PLAN_KEY])
{
    const plan_settings *const s = f->of->settings;
    const double tolerance =
        isnan(s->goal_tolerance) ? 1e-3 * f->of->exact->length : s->goal_tolerance;
    const size_t n = (size_t)f->robot->count;
    reach *const found = malloc(sizeof *found);
    if (!found) {
        return ad_fail(f->error, AD_NO_MEMORY, "out of memory for goals");
    }
    ad_status status = reach_tip(f->of->exact, s->goal_position, tolerance, f->start,
                                 (uint64_t)s->seed, found, f->error);
    f->to->nearest = found->nearest;
    f->to->end = found->count ? WAY_GOAL_TOUCHES : WAY_GOAL_BEYOND;
    for (size_t i = 0; i < found->count && f->to->goals < GOALS_MAX && status == AD_OK; i++) {
        bool holds = false;
        char why[200];
        status = try_one(f, &found->configuration[i * n], &holds, why);
        if (holds) {
            memcpy(&f->goals[f->to->goals++ * n], &found->configuration[i * n], n * sizeof(double));
        }
    }
    snprintf(key, PLAN_KEY, "plan.goal.position");
    free(found);
    return status;
}

static ad_status find_goals(finder *f, char key[PLAN_KEY])
{
    const plan_settings *const s = f->of->settings;
    bool holds = false;
    char why[200];
    if (s->goal_count == 0 && isnan(s->goal_position[0])) {
        snprintf(key, PLAN_KEY, "plan.goal.position");
        return ad_fail(f->error, AD_BAD_INPUT,
                       "is not given; allowed: three numbers (m), or plan.goal.actuators");
    }
    if (s->goal_count == 0) {
        return find_tips(f, key);
    }
    ad_status status = take(f, "plan.goal.actuators", s->goal_count, s->goal, f->goals, key);
    status = status == AD_OK ? try_one(f, f->goals, &holds, why) : status;
    f->to->goals = 1;
    return status == AD_OK && !holds ? ad_fail(f->error, AD_BAD_INPUT, "%s", why) : status;
}

/* ---- searches -------------------------------------------------------------------------------- */

/* What a search keeps beyond what is promised: the error of its shapes, what unknown parameters
 * take off, and some room for what bounds take off, more each time; where start and goals leave
 * less, most of that. */
static double margin(const finder *f, int search)
{
    const double wanted = fmax(0.1 * f->of->settings->clearance, 1e-4 * f->of->exact->length);
    return f->of->shapes->error + fmin(f->unknown + ldexp(wanted, search), 0.8 * f->room);
}

static ad_status search(finder *f)
{
    const plan_settings *const s = f->of->settings;
    const size_t states = (size_t)s->states;
    for (int k = 0; k < SEARCHES_MAX && f->to->looked < states; k++) {
        f->needed = s->radius + s->clearance + margin(f, k);
        const ompl_search asked = {.count = f->robot->count,
                                   .low = f->robot->low,
                                   .high = f->robot->high,
                                   .is_free = is_free,
                                   .context = f,
                                   .step = ldexp(0.02, -k),
                                   .method = s->method,
                                   .states = states - f->to->looked,
                                   .seed = s->seed + k,
                                   .start = f->start,
                                   .goals = f->to->goals,
                                   .goal = f->goals};
        double *found = NULL;
        size_t length = 0, looked = 0;
        const double start = train_seconds();
        ad_status status = ompl_find(&asked, &found, &length, &looked, f->error);
        const double middle = train_seconds();
        status = status == AD_OK ? f->status : status;
        f->to->looked += looked;
        f->to->searches++;
        f->to->seconds_search += middle - start;
        if (status == AD_OK && found) {
            certificate_free(f->to->certificate);
            f->to->certificate = NULL;
            f->to->corners = length;
            status = certify(f, length, found, &f->to->certificate);
            f->to->seconds_certificate += train_seconds() - middle;
        }
        free(found);
        if (status != AD_OK) {
            return status;
        }
        f->to->end = f->to->certificate ? WAY_NOT_CERTIFIED : WAY_NOT_FOUND;
        if (f->to->certificate && f->to->certificate->end == CERTIFICATE_HOLDS) {
            f->to->end = WAY_CERTIFIED;
            return AD_OK;
        }
    }
    return AD_OK;
}

ad_status way_find(const way_problem *problem, way *result, char key[PLAN_KEY], ad_error *error)
{
    finder f = {.of = problem,
                .robot = problem->exact->robot,
                .to = result,
                .room = INFINITY,
                .error = error};
    *result = (way){.end = WAY_NOT_FOUND};
    f.values = malloc(problem->shapes->points * problem->shapes->columns * sizeof *f.values);
    f.r = malloc(3 * problem->shapes->points * sizeof *f.r);
    ad_status status = f.values && f.r ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    status = status == AD_OK ? find_start(&f, key) : status;
    status = status == AD_OK ? find_goals(&f, key) : status;
    if (status == AD_OK && result->goals > 0) {
        status = search(&f);
    }
    free(f.values);
    free(f.r);
    if (status != AD_OK) {
        way_free(result);
    }
    return status;
}

void way_free(way *of)
{
    certificate_free(of->certificate);
    of->certificate = NULL;
}
