/* Several starts, the best of them, and the worst of a box. */
#include "tools/optimize/optimize_parts.h"

#include "nn/rng.h"
#include "physics/numerics/clock.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of the spread of what is bounded: as exactly as rows are kept; starts that end as close to each
 * other are one. */
static const double KEPT = 1e-6, SAME = 1e-6;

/* Random variables that are looked at for each start, and of a case's own ones for each case. */
enum { LOOKS = 4, LOOKS_LEAST = 16, LOOKS_EACH = 6 };

/* Starts that end at one optimum, the best, after which no other is tried. */
enum { ENOUGH = 3 };

/* Of the spread, by how much members of a box may be worse than those that count. */
static const double WORSE = 1e-4;

/* Of a box: random members of each case in a round, rounds, corners of so many parameters. */
enum { BOX_MEMBERS = 128, BOX_ROUNDS = 8, BOX_CORNERS = 4 };

/* ---- violations ---------------------------------------------------------------------------- */

static double beyond(const optimize_constraint *c, double row)
{
    const double under = c->scale * c->low - row, over = row - c->scale * c->high;
    return isnan(row) ? INFINITY : fmax(0, fmax(under, over));
}

typedef struct violations {
    const optimization *of;
    double worst, *by_case; /* [cases], or NULL */
} violations;

static void violation_of_row(void *context, int constraint, size_t scenario, size_t row)
{
    violations *v = context;
    const double by = beyond(&v->of->constraint[constraint], v->of->row[row]);
    v->worst = fmax(v->worst, by);
    if (v->by_case) {
        v->by_case[scenario] += by;
    }
}

static double violation(const optimization *o)
{
    violations v = {.of = o};
    optimize_visit(o, violation_of_row, &v);
    return v.worst;
}

/* ---- starts -------------------------------------------------------------------------------- */

/* Bounds of objectives above what they bound. */
static void lift_tops(optimization *o)
{
    const size_t first = o->n - o->tops;
    for (size_t k = 0; k < o->tops; k++) {
        double top = -INFINITY;
        for (size_t e = o->tops > 1 ? k : 0; e < (o->tops > 1 ? k + 1 : o->scenarios); e++) {
            top = fmax(top, o->sign * o->objective_scale * o->objectives[e]);
        }
        o->x[first + k] = isfinite(top) ? top : 0;
    }
    o->known = false;
}

static void draw(nn_rng *rng, size_t count, double *z)
{
    for (size_t i = 0; i < count; i++) {
        z[i] = nn_rng_uniform(rng);
    }
}

/* Smallest and largest of what is looked at. */
typedef struct spreads {
    const optimization *of;
    double low[OPTIMIZE_CONSTRAINTS_MAX + 1], high[OPTIMIZE_CONSTRAINTS_MAX + 1];
} spreads;

static void widen(spreads *s, int i, double value)
{
    if (isfinite(value)) {
        s->low[i] = fmin(s->low[i], value);
        s->high[i] = fmax(s->high[i], value);
    }
}

static void widen_by_row(void *context, int constraint, size_t scenario, size_t row)
{
    spreads *s = context;
    (void)scenario;
    widen(s, constraint, s->of->row[row] / s->of->constraint[constraint].scale);
}

/* So that numbers of objective and rows are of the order of 1. */
static ad_status scale(optimization *o, nn_rng *rng, ad_error *error)
{
    spreads s = {.of = o};
    for (int i = 0; i <= OPTIMIZE_CONSTRAINTS_MAX; i++) {
        s.low[i] = INFINITY;
        s.high[i] = -INFINITY;
    }
    for (int look = 0; look < 2 * LOOKS_LEAST && o->why.status == AD_OK; look++) {
        draw(rng, o->n - o->tops, o->x);
        optimize_look(o, o->x);
        for (size_t e = 0; e < o->scenarios; e++) {
            widen(&s, OPTIMIZE_CONSTRAINTS_MAX, o->objectives[e]);
        }
        optimize_visit(o, widen_by_row, &s);
    }
    for (int i = 0; i <= OPTIMIZE_CONSTRAINTS_MAX; i++) {
        const double spread = s.high[i] - s.low[i];
        double *to = i < OPTIMIZE_CONSTRAINTS_MAX ? &o->constraint[i].scale : &o->objective_scale;
        *to = spread > 0 && isfinite(spread) ? 1 / spread : 1;
    }
    o->known = false;
    if (o->why.status != AD_OK) {
        *error = o->why;
    }
    return o->why.status;
}

/* A place to start from: the best of some random ones, of which each case has its own. Its merit;
 * infinite where members are not solved. */
static double look(optimization *o, nn_rng *rng, double *best, double *by_case)
{
    const size_t cases = o->scenarios, each = (size_t)o->each;
    double merit[OPTIMIZE_SCENARIOS_MAX], sum = 0;
    for (size_t e = 0; e < cases; e++) {
        merit[e] = INFINITY;
    }
    draw(rng, (size_t)o->shared, o->x);
    memcpy(best, o->x, (o->n - o->tops) * sizeof *best);
    for (int k = 0; k < (each > 0 ? LOOKS_EACH : 1); k++) {
        violations v = {.of = o, .by_case = by_case};
        memset(by_case, 0, cases * sizeof *by_case);
        draw(rng, each * o->cases.count, o->x + o->shared);
        optimize_look(o, o->x);
        optimize_visit(o, violation_of_row, &v);
        for (size_t e = 0; e < cases; e++) {
            const double now = o->sign * o->objective_scale * o->objectives[e] + 10 * by_case[e];
            const size_t first = (size_t)o->shared + o->scenario[e].of * each;
            if (now < merit[e]) {
                merit[e] = now;
                memcpy(best + first, o->x + first, each * sizeof *best);
            }
        }
    }
    for (size_t e = 0; e < cases; e++) {
        sum += merit[e];
    }
    return sum;
}

/* The best of so many places to start from, z [starts][n], the best first. */
static ad_status look_around(optimization *o, nn_rng *rng, int starts, double *z, ad_error *error)
{
    const size_t n = o->n;
    const int looks = LOOKS * starts > LOOKS_LEAST ? LOOKS * starts : LOOKS_LEAST;
    double merit[OPTIMIZE_STARTS_MAX];
    double *now = calloc(n + o->scenarios, sizeof *now); /* bounds of objectives follow */
    if (!now) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for an optimisation");
    }
    for (int i = 0; i < starts; i++) {
        merit[i] = INFINITY;
    }
    for (int i = 0; i < looks && o->why.status == AD_OK; i++) {
        const double found = look(o, rng, now, now + n);
        int at = starts;
        while (at > 0 && found < merit[at - 1]) {
            at--;
        }
        if (at < starts) {
            memmove(merit + at + 1, merit + at, (size_t)(starts - 1 - at) * sizeof *merit);
            memmove(z + (size_t)(at + 1) * n, z + (size_t)at * n,
                    (size_t)(starts - 1 - at) * n * sizeof *z);
            merit[at] = found;
            memcpy(z + (size_t)at * n, now, n * sizeof *z);
        }
    }
    free(now);
    if (o->why.status != AD_OK) {
        *error = o->why;
        return o->why.status;
    }
    return merit[0] < INFINITY
               ? AD_OK
               : ad_fail(error, AD_NOT_FINITE,
                         "no random values of the variables have equilibria in all cases; narrow "
                         "the ranges");
}

/* ---- a descent ----------------------------------------------------------------------------- */

static ad_status descend(optimization *o, optimize_start *end, ad_error *error)
{
    optimize_look(o, o->x);
    lift_tops(o);
    ad_status status = optimize_descend(o, &end->steps, &end->converged, error);
    if (status != AD_OK) {
        return status;
    }
    bool solved = optimize_look(o, o->x);
    if (solved && !end->converged) { /* bounds of objectives may be below what they bound */
        lift_tops(o);
        solved = optimize_look(o, o->x);
    }
    end->violation = solved ? violation(o) : INFINITY;
    end->objective = solved ? o->value / (o->sign * o->objective_scale) : NAN;
    return AD_OK;
}

/* Whether two objectives are one: within SAME of what objectives vary by, or of themselves. */
static bool is_same(const optimization *o, double one, double other)
{
    const double far = fabs(one - other);
    return far * o->objective_scale <= SAME || far <= SAME * fabs(other);
}

/* What keeps the constraints is better than what does not, then what has the better objective, of
 * equal ones what is an optimum. */
static bool is_better(const optimization *o, const optimize_start *one, const optimize_start *other)
{
    const bool kept = one->violation <= KEPT, others = other->violation <= KEPT;
    if (kept != others || !kept) {
        return kept || (!others && one->violation < other->violation);
    }
    if (is_same(o, one->objective, other->objective)) {
        return one->converged && !other->converged;
    }
    return o->sign * one->objective < o->sign * other->objective;
}

/* ---- a box --------------------------------------------------------------------------------- */

static const scene_parameter *of_box(const optimization *o, int b)
{
    for (int p = 0; p < o->parameters; p++) {
        if (o->role[p] == OPTIMIZE_BOX && o->index[p] == b) {
            return &o->family->parameters[p];
        }
    }
    return NULL;
}

static void add_corners(optimization *o)
{
    const int count = o->settings->box_count;
    for (size_t i = 0; i < o->cases.count && count > 0 && count <= BOX_CORNERS; i++) {
        for (unsigned corner = 0; corner < 1u << count; corner++) {
            if (o->scenarios == OPTIMIZE_SCENARIOS_MAX) {
                return;
            }
            optimize_scenario *added = &o->scenario[o->scenarios++];
            added->of = i;
            for (int b = 0; b < count; b++) {
                added->box[b] = scene_parameter_at(of_box(o, b), corner >> b & 1);
            }
        }
    }
}

/* Members of the box in a case. */
static void draw_scenarios(const optimization *o, nn_rng *rng, size_t which, int count,
                           optimize_scenario *drawn)
{
    for (int k = 0; k < count; k++) {
        drawn[k].of = which;
        for (int b = 0; b < o->settings->box_count; b++) {
            drawn[k].box[b] = scene_parameter_at(of_box(o, b), nn_rng_uniform(rng));
        }
    }
}

/* How bad others than its own scenarios are at the variables z: objectives, scaled, infinite where
 * there is no equilibrium, and violations, each [count]. */
static ad_status measure(optimization *o, const double *z, optimize_scenario *others, size_t count,
                         double *objective, double *violated, ad_error *error)
{
    optimize_scenario *own = o->scenario;
    const size_t own_count = o->scenarios;
    o->scenario = others;
    o->scenarios = count;
    ad_status status = optimize_shape(o, error);
    if (status == AD_OK) {
        violations v = {.of = o, .by_case = violated};
        memset(violated, 0, count * sizeof *violated);
        memcpy(o->x, z, (o->n - o->tops) * sizeof *z);
        optimize_look(o, o->x);
        optimize_visit(o, violation_of_row, &v);
        for (size_t e = 0; e < count; e++) {
            const double value = o->sign * o->objective_scale * o->objectives[e];
            objective[e] = isnan(value) ? INFINITY : value;
        }
    }
    o->scenario = own;
    o->scenarios = own_count;
    return status;
}

/* Of random members of the box the worst, in the objective and in what is bounded, become scenarios
 * where they are worse than all that are known. Whether there were any. */
static ad_status find_worse(optimization *o, nn_rng *rng, bool *any, ad_error *error)
{
    const size_t n = o->n - o->tops;
    optimize_scenario drawn[BOX_MEMBERS], worst[2];
    double by[2][BOX_MEMBERS], limit[2] = {-INFINITY, WORSE};
    double *z = malloc((n + 1) * sizeof *z);
    *any = false;
    if (!z) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for an optimisation");
    }
    memcpy(z, o->x, n * sizeof *z);
    for (size_t e = 0; e < o->scenarios; e++) {
        limit[0] = fmax(limit[0], o->sign * o->objective_scale * o->objectives[e] + WORSE);
    }
    bool found[2] = {false, false};
    ad_status status = AD_OK;
    for (size_t i = 0; i < o->cases.count && status == AD_OK; i++) {
        draw_scenarios(o, rng, i, BOX_MEMBERS, drawn);
        status = measure(o, z, drawn, BOX_MEMBERS, by[0], by[1], error);
        for (int e = 0; e < BOX_MEMBERS && status == AD_OK; e++) {
            for (int k = 0; k < 2; k++) {
                if (by[k][e] > limit[k]) {
                    limit[k] = by[k][e];
                    worst[k] = drawn[e];
                    found[k] = true;
                }
            }
        }
    }
    for (int k = 0; k < 2; k++) {
        if (found[k] && o->scenarios < OPTIMIZE_SCENARIOS_MAX) {
            o->scenario[o->scenarios++] = worst[k];
            *any = true;
        }
    }
    if (status == AD_OK) {
        status = optimize_shape(o, error);
    }
    memcpy(o->x, z, n * sizeof *z);
    free(z);
    return status;
}

static ad_status meet_box(optimization *o, nn_rng *rng, optimize_start *end,
                          optimize_report *report, ad_error *error)
{
    bool any = o->settings->box_count > 0;
    ad_status status = AD_OK;
    while (any && status == AD_OK && report->rounds < BOX_ROUNDS) {
        report->rounds++;
        status = find_worse(o, rng, &any, error);
        if (status == AD_OK && any) {
            const int steps = end->steps;
            status = descend(o, end, error);
            end->steps += steps;
        }
    }
    report->box_open = any;
    return status;
}

/* ---- reports ------------------------------------------------------------------------------- */

typedef struct bounding {
    const optimization *of;
    optimize_report *report;
    size_t last[OPTIMIZE_CONSTRAINTS_MAX]; /* scenario in which it was found active, and 1 */
} bounding;

static void bound_by_row(void *context, int constraint, size_t scenario, size_t row)
{
    bounding *b = context;
    const optimization *o = b->of;
    const optimize_constraint *c = &o->constraint[constraint];
    optimize_bound *to = &b->report->bound[constraint];
    const double value = o->row[row] / c->scale;
    const double distance =
        fmin(fabs(o->row[row] - c->scale * c->low), fabs(o->row[row] - c->scale * c->high));
    to->least = fmin(to->least, value);
    to->most = fmax(to->most, value);
    to->kept = to->kept && beyond(c, o->row[row]) <= KEPT;
    const double multiplier = o->multiplier[row] * c->scale / (o->sign * o->objective_scale);
    to->multiplier -= multiplier;
    to->weight += fabs(multiplier);
    if (distance < 1e-4 && b->last[constraint] != scenario + 1) {
        b->last[constraint] = scenario + 1;
        to->active++;
    }
}

ad_status optimize_evaluate(optimization *o, const optimize_solver *solver, optimize_report *report,
                            ad_error *error)
{
    o->solver = solver;
    o->why.status = AD_OK;
    o->known = false;
    const bool solved = optimize_look(o, o->x);
    if (o->why.status != AD_OK) {
        *error = o->why;
        return o->why.status;
    }
    lift_tops(o);
    double value = 0;
    for (size_t i = o->n - o->tops; i < o->n; i++) {
        value += o->x[i] / (double)o->tops;
    }
    report->objective =
        solved ? (o->tops > 0 ? value : o->value) / (o->sign * o->objective_scale) : NAN;
    report->violation = solved ? violation(o) : INFINITY;
    report->cases = o->scenarios;
    report->bounds = o->constraints;
    bounding b = {.of = o, .report = report};
    for (int i = 0; i < o->constraints; i++) {
        report->bound[i] = (optimize_bound){.text = o->settings->constraints[i],
                                            .low = o->constraint[i].low,
                                            .high = o->constraint[i].high,
                                            .least = INFINITY,
                                            .most = -INFINITY,
                                            .kept = true};
    }
    optimize_visit(o, bound_by_row, &b);
    return AD_OK;
}

/* Starts that end with the best objective. IPOPT has not converged where that has a kink, as a
 * distance has at 0, for its slopes are never small: several that end alike tell it as well. */
static int count_agreeing(const optimization *o, const optimize_report *report)
{
    const optimize_start *best = &report->start[report->best];
    int count = 0;
    for (int i = 0; i < report->starts; i++) {
        const optimize_start *end = &report->start[i];
        count += end->violation <= KEPT && is_same(o, end->objective, best->objective);
    }
    return count;
}

ad_status optimize_run(optimization *o, const optimize_solver *solver, optimize_progress *progress,
                       void *context, optimize_report *report, ad_error *error)
{
    const double begin = clock_seconds(CLOCK_MONOTONIC);
    const int starts =
        o->settings->starts < OPTIMIZE_STARTS_MAX ? o->settings->starts : OPTIMIZE_STARTS_MAX;
    nn_rng rng = nn_rng_split((uint64_t)o->settings->seed, "optimize");
    *report = (optimize_report){.best = -1};
    o->solver = solver;
    o->why.status = AD_OK;
    o->members = 0;
    add_corners(o);
    ad_status status = optimize_shape(o, error);
    const size_t n = o->n;
    double *z = status == AD_OK ? malloc((((size_t)starts + 1) * n + o->m) * sizeof *z) : NULL;
    double *best = z ? z + (size_t)starts * n : NULL, *multiplier = z ? best + n : NULL;
    if (status == AD_OK && !z) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for an optimisation");
    }
    status = status == AD_OK ? scale(o, &rng, error) : status;
    status = status == AD_OK ? look_around(o, &rng, starts, z, error) : status;
    for (int i = 0; i < starts && status == AD_OK; i++) {
        optimize_start *end = &report->start[i];
        memcpy(o->x, z + (size_t)i * n, n * sizeof *z);
        status = descend(o, end, error);
        if (status != AD_OK) {
            break;
        }
        report->starts = i + 1;
        if (report->best < 0 || is_better(o, end, &report->start[report->best])) {
            report->best = i;
            memcpy(best, o->x, n * sizeof *best);
            memcpy(multiplier, o->multiplier, o->m * sizeof *multiplier);
        }
        report->seconds = clock_seconds(CLOCK_MONOTONIC) - begin;
        report->agreeing = count_agreeing(o, report);
        if ((progress && !progress(context, report)) || report->agreeing == ENOUGH) {
            break;
        }
    }
    if (status == AD_OK) {
        optimize_start *end = &report->start[report->best];
        memcpy(o->x, best, n * sizeof *best);
        memcpy(o->multiplier, multiplier, o->m * sizeof *multiplier);
        optimize_look(o, o->x);
        status = meet_box(o, &rng, end, report, error);
    }
    status = status == AD_OK ? optimize_evaluate(o, solver, report, error) : status;
    report->found = status == AD_OK && report->violation <= KEPT &&
                    (report->start[report->best].converged || report->agreeing >= ENOUGH);
    report->left = SAME / o->objective_scale;
    report->members = o->members;
    report->seconds = clock_seconds(CLOCK_MONOTONIC) - begin;
    free(z);
    return status;
}

const double *optimize_variables(const optimization *o, size_t *count)
{
    *count = o->n - o->tops;
    return o->x;
}

ad_status optimize_take(optimization *o, const optimization *from, ad_error *error)
{
    o->scenarios = from->scenarios;
    memcpy(o->scenario, from->scenario, from->scenarios * sizeof *from->scenario);
    o->objective_scale = from->objective_scale;
    for (int i = 0; i < o->constraints; i++) {
        o->constraint[i].scale = from->constraint[i].scale;
    }
    ad_status status = optimize_shape(o, error);
    if (status == AD_OK) {
        memcpy(o->x, from->x, (o->n - o->tops) * sizeof *o->x);
        memset(o->multiplier, 0, o->m * sizeof *o->multiplier);
    }
    return status;
}
