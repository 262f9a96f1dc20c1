#include "physics/chain/strain_group.h"

#include "physics/local/strain_algebra.h"

#include <stdlib.h>

/* Where a path that is lost on the coarsest mesh is followed anew, and once more, if it is lost
 * without a pivot that is negative: a step of Magnus turns the rod by at most 3 rad. */
static const int SAFE_LEVELS[] = {2, 4};

/* ---- steps --------------------------------------------------------------------------------- */

/* Lengths of the steps, the largest change of curvature; not numbers where they are none. */
FOR_EACH_PROCESSOR static void measure(const strain_form *form, lanes *result)
{
    const integer_lanes size = (integer_lanes){0} + 0x7fffffffffffffffLL;
    integer_lanes most = {0};
    for (int i = 0; i < form->elastic; i++) { /* as integers numbers have the same order */
        const integer_lanes at = (integer_lanes)form->right[i] & size;
        const integer_lanes larger = at > most;
        most = (at & larger) | (most & ~larger);
    }
    *result = (lanes)most;
}

void strain_group_measure(const strain_form *form, lanes *length)
{
    measure(form, length);
}

static void drop_step(strain_form *form, int lane)
{
    for (int i = 0; i < form->unknowns; i++) {
        form->right[i][lane] = 0;
    }
}

void strain_group_step(strain_form *form, const bool *taken, lanes *length)
{
    for (int lane = 0; lane < LANES; lane++) {
        form->still[lane] = taken[lane] ? 0 : -1;
    }
    strain_form_shape(form);
    strain_form_linearise(form);
    strain_form_solve(form);
    measure(form, length);
    for (int lane = 0; lane < LANES; lane++) {
        if (!taken[lane] || !isfinite((*length)[lane])) {
            drop_step(form, lane);
        }
    }
}

static void move(strain_form *form)
{
    const lanes whole = NO_LANES + 1;
    strain_form_move(form, form->right, &whole);
}

/* ---- along the loads ----------------------------------------------------------------------- */

/* A step to a load is taken back where Newton's method does not settle at once, by the first ratio
 * of two steps and those that follow, or where a pivot of elimination is negative. Where loads have
 * an energy the matrix is that of its second variation, with positive factors: pivots are positive
 * as long as the equilibrium is a minimum, and so it stays on the path from the unstressed rod
 * until that loses its stability. Elsewhere only the parity of negative ones is known to stay, but
 * a round rod that buckles has two at once: none is taken, either. Of 16,000 members under strong
 * loads (tools/bench/members_time.c) a ratio of 0.05 alone leads two to other equilibria; with the
 * pivots none, also with 0.5. */
#define PATH_RULE(name, value) static const double name = value;
SOLVE_PATH_RULES(PATH_RULE)
#undef PATH_RULE

typedef struct follower {
    enum { FOLLOWING, ARRIVED, LOST } state;
    double load, done, before; /* tried, reached, reached before that; < 0: not yet */
    double length, ratio;      /* of the last steps */
    bool fell;                 /* a pivot was negative at a load beyond what is reached */
    int tries;                 /* steps at this load */
    int steps;                 /* all */
} follower;

/* The i-th number that is sought; most are curvatures. */
static inline lanes *unknown(strain_form *form, int i)
{
    return i < form->elastic ? &form->at[i / 3].u[i % 3] : strain_form_unknown(form, i);
}

/* The guess at the load that is tried, on the line through the last two points of the path. */
static void guess(strain_group *group, strain_form *form, const follower *f, int lane)
{
    const double share = f->before < 0 ? 0 : (f->load - f->done) / (f->done - f->before);
    for (int i = 0; i < form->unknowns; i++) {
        const double at = group->start[i][lane];
        (*unknown(form, i))[lane] = at + share * (at - group->before[i][lane]);
    }
}

static void try_load(strain_group *group, strain_form *form, follower *f, double step, int lane)
{
    f->load = f->done + step > 1 - 0.1 * step ? 1 : f->done + step;
    f->tries = 0;
    guess(group, form, f, lane);
    for (int i = 0; i < form->nodes; i++) { /* what was found may be none */
        for (int c = 0; c < 3; c++) {
            form->at[i].v[c][lane] = form->points[i].rest[c][lane];
        }
    }
}

/* After a step at a load: whether it is one to take. */
static bool is_good(follower *f, double length, bool is_stable)
{
    f->ratio = f->tries > 0 ? length / f->length : 1;
    bool settles = f->tries == 0 || f->ratio <= (f->tries == 1 ? FIRST_RATIO : RATIO);
    f->length = length;
    f->tries++;
    f->steps++;
    return isfinite(length) && settles && is_stable && f->tries < STEPS_MAX;
}

/* What Newton's method leaves, as its ratio becomes the square of itself. */
static bool is_found(const follower *f, double goal)
{
    return f->length <= goal || f->length * f->ratio * f->ratio <= goal;
}

static void go_on(strain_group *group, strain_form *form, follower *f, int lane)
{
    const double step = f->load - f->done, longer = f->tries <= 3 ? LONGER : 1;
    if (f->load == 1) {
        f->state = ARRIVED;
        return;
    }
    for (int i = 0; i < form->unknowns; i++) {
        group->before[i][lane] = group->start[i][lane];
        group->start[i][lane] = (*unknown(form, i))[lane];
    }
    f->before = f->done;
    f->done = f->load;
    f->fell = false;
    try_load(group, form, f, longer * step, lane);
}

/* From the unstressed rod to the whole load, of lanes that are FOLLOWING. */
static void follow(strain_group *group, strain_level *level, follower *f)
{
    strain_form *form = level->form;
    lanes load, length;
    bool following[LANES], any = true;
    strain_level_rest(level);
    for (int lane = 0; lane < LANES; lane++) {
        f[lane].load = 1;
        f[lane].done = 0;
        f[lane].before = -1;
        f[lane].tries = 0;
        for (int i = 0; i < form->unknowns; i++) {
            group->start[i][lane] = (*unknown(form, i))[lane];
        }
    }
    while (any) {
        for (int lane = 0; lane < LANES; lane++) {
            following[lane] = f[lane].state == FOLLOWING;
            load[lane] = f[lane].load;
        }
        strain_level_load(level, &load);
        strain_group_step(form, following, &length);
        for (int lane = 0; lane < LANES; lane++) {
            const bool is_stable = form->negative[lane] == 0;
            f[lane].fell = f[lane].fell || (following[lane] && !is_stable);
            following[lane] = following[lane] && is_good(&f[lane], length[lane], is_stable);
            if (!following[lane]) {
                drop_step(form, lane);
            }
        }
        move(form);
        any = false;
        for (int lane = 0; lane < LANES; lane++) {
            follower *one = &f[lane];
            const double goal = one->load == 1 ? LEAVES * group->tolerance : ON_THE_WAY;
            if (following[lane] && is_found(one, goal)) {
                go_on(group, form, one, lane);
            } else if (!following[lane] && one->state == FOLLOWING) {
                const double step = SHORTER * (one->load - one->done);
                one->state = step < SHORTEST ? LOST : FOLLOWING;
                try_load(group, form, one, one->state == LOST ? 0 : step, lane);
            }
            any = any || one->state == FOLLOWING;
        }
    }
}

/* ---- finer meshes -------------------------------------------------------------------------- */

void strain_group_keep(const strain_form *form, lanes *to)
{
    for (int i = 0; i < form->nodes; i++) {
        memcpy(to + 3 * i, form->at[i].r, 3 * sizeof *to);
    }
    memcpy(to + 3 * form->nodes, form->edges[form->kind.elements].r, 3 * sizeof *to);
}

void strain_group_compare(const strain_form *form, const lanes *before, bool more, double *moved)
{
    for (int i = 0; i < form->nodes + more; i++) {
        const lanes *now = i < form->nodes ? form->at[i].r : form->edges[form->kind.elements].r;
        for (int lane = 0; lane < LANES; lane++) {
            double square = 0;
            for (int c = 0; c < 3; c++) {
                const double off = now[c][lane] - before[3 * i + c][lane];
                square += off * off;
            }
            const double off = sqrt(square);
            moved[lane] = off <= moved[lane] ? moved[lane] : off;
        }
    }
}

/* One step from the solution of the coarser mesh: how far it moves the rod is that one's error. To
 * it comes what positions by the next mesh lack against the one beyond, where they are taken. */
static void step_finer(strain_group *group, int k, const bool *wanted, double *moved)
{
    strain_form *form = group->level[k].form;
    const lanes whole = NO_LANES + 1;
    lanes length;
    strain_level_load(&group->level[k], &whole);
    strain_level_refine(&group->link[k], &group->level[k - 1], &group->level[k]);
    strain_group_step(form, wanted, &length);
    strain_group_keep(form, group->placed);
    move(form);
    strain_form_shape(form);
    memset(moved, 0, LANES * sizeof *moved);
    strain_group_compare(form, group->placed, true, moved);
    for (int j = k + 1; j <= k + STRAIN_BEYOND; j++) {
        strain_level_refine(&group->link[j], &group->level[j - 1], &group->level[j]);
        strain_form_place(group->level[j].form);
    }
    const int last = k + STRAIN_BEYOND;
    strain_level_foresee(&group->link[last], &group->level[last - 1], &group->level[last],
                         group->placed);
    strain_group_compare(group->level[last].form, group->placed, false, moved);
    for (int lane = 0; lane < LANES; lane++) {
        moved[lane] = isfinite(length[lane]) && isfinite(moved[lane]) ? moved[lane] : INFINITY;
    }
}

static bool any(const bool *Bool)
{
    bool result = false;
    for (int lane = 0; lane < LANES; lane++) {
        result = result || Bool[lane];
    }
    return result;
}

/* More steps on the same mesh, of each until its next one would be small. */
static void settle(strain_group *group, int k, const bool *wanted, follower *f)
{
    enum { FEW = 4 };
    strain_form *form = group->level[k].form;
    bool taken[LANES];
    memcpy(taken, wanted, sizeof taken);
    for (int i = 0; i < FEW && any(taken); i++) {
        lanes length;
        strain_group_step(form, taken, &length);
        move(form);
        for (int lane = 0; lane < LANES; lane++) {
            f[lane].steps += taken[lane];
            taken[lane] = taken[lane] && length[lane] > 0.1 * group->tolerance;
        }
    }
}

/* ---- results ------------------------------------------------------------------------------- */

void strain_group_evaluate(strain_group *group, int k)
{
    const double length = group->rod->scales.length;
    const double units[SOLVE_MEMBERS_COLUMNS] = {
        length, length, length, 1, 1, 1, 1, 1, 1, 1, 1 / length, 1 / length, 1 / length};
    strain_level_evaluate(&group->level[k], group->values);
    for (int i = 0; i < group->level[k].outputs; i++) {
        for (int c = 0; c < SOLVE_MEMBERS_COLUMNS; c++) {
            group->values[i * SOLVE_MEMBERS_COLUMNS + c] *= units[c];
        }
        for (int lane = 0; lane < LANES; lane++) { /* strains by metres as they are written */
            const double growth = group->growth[lane * group->level[k].outputs + i];
            for (int c = 7; c < SOLVE_MEMBERS_COLUMNS; c++) {
                group->values[i * SOLVE_MEMBERS_COLUMNS + c][lane] /= growth;
            }
        }
    }
}

void strain_group_put(const strain_group *group, int lane, double *values)
{
    for (int i = 0; i < group->level[0].outputs * SOLVE_MEMBERS_COLUMNS; i++) {
        values[i] = group->values[i][lane];
    }
}

/* Curvature of level k at the points of that on which it is given and taken. */
static void put_curvature(const strain_group *group, int k, int lane, double *curvature)
{
    const strain_link *link = &group->sample[k];
    const strain_form *form = group->level[k].form;
    const int stages = group->level[k].stages, width = strain_group_width(group);
    for (int i = 0; i < group->level[group->modes].form->nodes; i++) {
        const int first = link->element[i] * stages;
        for (int c = 0; c < width; c++) {
            double sum = 0;
            for (int j = 0; j < stages; j++) {
                sum += link->value[i][j] * (*strain_number(form, first + j, c))[lane];
            }
            curvature[width * i + c] = sum / group->rod->scales.length;
        }
    }
}

/* In the numbers of a lane, values [lanes][count] or NULL. */
static void put_nothing(double *values, size_t lane, int count)
{
    for (size_t i = 0; values && i < (size_t)count; i++) {
        values[lane * (size_t)count + i] = NAN;
    }
}

/* Results of lanes that are within the tolerance on mesh k, or are on the last one. */
static void finish(strain_group *group, int k, const double *moved, bool *wanted, const follower *f,
                   double *values, double *curvature, solve_member *results)
{
    const size_t width = (size_t)group->level[k].outputs * SOLVE_MEMBERS_COLUMNS;
    const size_t unknowns =
        (size_t)strain_group_width(group) * (size_t)group->level[group->modes].form->nodes;
    bool evaluated = !values;
    for (int lane = 0; lane < LANES; lane++) {
        const bool met = moved[lane] <= group->tolerance;
        if (!wanted[lane] || !(met || k == group->solved - 1)) {
            continue;
        }
        if (!evaluated) {
            strain_group_evaluate(group, k + STRAIN_BEYOND);
            evaluated = true;
        }
        wanted[lane] = false;
        if (values) {
            strain_group_put(group, lane, values + (size_t)lane * width);
        }
        if (curvature) {
            put_curvature(group, k, lane, curvature + (size_t)lane * unknowns);
        }
        results[lane].nodes = group->level[k].form->nodes;
        results[lane].estimate = moved[lane];
        results[lane].load = 1;
        results[lane].steps = f[lane].steps + 1;
        results[lane].solved = met;
        results[lane].end = met ? SOLVE_MEMBER_SOLVED : SOLVE_MEMBER_COARSE;
    }
}

/* Lanes that are wanted, followed on mesh `first`; those that are lost there stay wanted. */
static ad_status solve_from(strain_group *group, int first, bool *wanted, double *values,
                            double *curvature, solve_member *results, ad_error *error)
{
    follower f[LANES];
    bool finer[LANES];
    double moved[LANES];
    ad_status status = strain_level_give(&group->level[first], group->rod, group->count,
                                         group->parameters, group->room, error);
    for (int lane = 0; lane < LANES; lane++) {
        f[lane] = (follower){.state = wanted[lane] ? FOLLOWING : LOST};
    }
    if (status != AD_OK) {
        return status;
    }
    follow(group, &group->level[first], f);
    for (int lane = 0; lane < LANES; lane++) {
        finer[lane] = f[lane].state == ARRIVED;
        if (wanted[lane]) {
            results[lane] =
                (solve_member){.estimate = INFINITY,
                               .load = f[lane].done,
                               .steps = f[lane].steps,
                               .end = f[lane].fell ? SOLVE_MEMBER_UNSTABLE : SOLVE_MEMBER_LOST};
        }
        wanted[lane] = wanted[lane] && !finer[lane];
    }
    for (int k = first + 1; k < group->solved && any(finer); k++) {
        status = strain_level_give(&group->level[k], group->rod, group->count, group->parameters,
                                   group->room, error);
        if (status != AD_OK) {
            return status;
        }
        step_finer(group, k, finer, moved);
        finish(group, k, moved, finer, f, values, curvature, results);
        if (any(finer)) {
            settle(group, k, finer, f);
        }
    }
    return AD_OK;
}

ad_status strain_group_parameters(strain_group *group, size_t members, const double *parameters,
                                  ad_error *error)
{
    const size_t count = (size_t)group->count, outputs = (size_t)group->level[0].outputs;
    const bool grows = solve_rod_part_kind(group->rod, SOLVE_GROWTH).width > 0;
    ad_status status = AD_OK;
    for (size_t lane = 0; lane < LANES && count > 0; lane++) {
        const size_t from = lane % members;
        memcpy(group->parameters + lane * count, parameters + from * count,
               count * sizeof *parameters);
        for (size_t i = 0; i < outputs && grows; i++) {
            memcpy(group->each + (lane * outputs + i) * count, parameters + from * count,
                   count * sizeof *parameters);
        }
    }
    if (grows && outputs > 0) {
        status = solve_rod_part(group->rod, SOLVE_GROWTH, LANES * outputs, group->outputs, 0,
                                group->each, group->growth, error);
    }
    return status;
}

ad_status strain_group_solve(strain_group *group, size_t members, const double *parameters,
                             double *values, double *curvature, solve_member *results,
                             ad_error *error)
{
    const int width = group->level[0].outputs * SOLVE_MEMBERS_COLUMNS;
    const int unknowns = strain_group_width(group) * group->level[group->modes].form->nodes;
    bool wanted[LANES];
    ad_status status = strain_group_parameters(group, members, parameters, error);
    for (size_t lane = 0; lane < LANES; lane++) {
        wanted[lane] = lane < members;
    }
    status =
        status != AD_OK ? status : solve_from(group, 0, wanted, values, curvature, results, error);
    for (int k = 0; k < 2 && status == AD_OK && any(wanted); k++) {
        bool again[LANES];
        for (size_t lane = 0; lane < LANES; lane++) {
            again[lane] = wanted[lane] && (k == 0 || results[lane].end != SOLVE_MEMBER_UNSTABLE);
        }
        if (any(again) && SAFE_LEVELS[k] + 1 < group->solved) {
            status = solve_from(group, SAFE_LEVELS[k], again, values, curvature, results, error);
        }
        for (size_t lane = 0; lane < members; lane++) {
            wanted[lane] = wanted[lane] && isinf(results[lane].estimate);
        }
    }
    for (size_t lane = 0; lane < members && status == AD_OK; lane++) {
        if (wanted[lane]) {
            put_nothing(values, lane, width);
            put_nothing(curvature, lane, unknowns);
        }
    }
    return status;
}
