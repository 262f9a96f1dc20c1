/* What a process does and holds of a problem, alone or as one of several ranks. */
#include "physics/learn/problem_internal.h"

const ad_ranks *problem_ranks(const problem *p)
{
    return ad_pool_ranks(p->pool);
}

/* Whether all that is done with the points of a set is done point by point by programs, which ranks
 * share: weights, data and moves need all of them. */
bool problem_set_is_shared(const problem *p, const problem_set *set)
{
    const problem_settings *s = &p->settings;
    return !p->model->motion && set->about->points != MODEL_GIVEN && set->about->source.rows == 0 &&
           !s->causal_slices && !s->adaptive.kind;
}

/* ---- points that this rank has ------------------------------------------------------------- */

static bool has_all(const problem_set *set)
{
    return set->trained.first == 0 && set->trained.end == set->trained.count;
}

static ad_status hold(problem_set *set, const ad_share *of, ad_error *error)
{
    return problem_cloud_hold(set->problem, set, &set->trained, of->first, of->first + of->points,
                              error);
}

ad_status problem_set_hold(problem_set *set, const ad_program *program, size_t points,
                           ad_error *error)
{
    const ad_ranks *ranks = problem_ranks(set->problem);
    if (has_all(set)) {
        return AD_OK;
    }
    const ad_share of =
        ad_program_share(program, points, ranks ? ranks->count : 1, ranks ? ranks->rank : 0);
    return hold(set, &of, error);
}

ad_status problem_set_hold_rows(problem_set *set, ad_error *error)
{
    const ad_ranks *ranks = problem_ranks(set->problem);
    if (has_all(set)) {
        return AD_OK;
    }
    const ad_share of = ad_normal_share(set->normal, set->trained.count, ranks ? ranks->count : 1,
                                        ranks ? ranks->rank : 0);
    return hold(set, &of, error);
}

ad_status problem_set_hold_all(problem_set *set, ad_error *error)
{
    const ad_share all = {.points = set->trained.count};
    return hold(set, &all, error);
}

/* ---- memory -------------------------------------------------------------------------------- */

size_t problem_bytes(const problem *p)
{
    size_t bytes = 2 * p->parameters * sizeof(double);
    int threads = ad_pool_threads(p->pool);
    for (int i = 0; i < p->set_count; i++) {
        const problem_set *s = &p->sets[i];
        const struct {
            const ad_program *program;
            size_t points;
        } programs[] = {{s->gradient, s->trained.count},
                        {s->value, s->held_out.count},
                        {s->gradient_fixed.program, s->trained.count}};
        bytes += ((size_t)p->model->domain.count + (size_t)s->about->source.rows) *
                 (s->trained.count + s->held_out.count) * sizeof(double);
        bytes += problem_weights_per_point(s) * s->trained.count * sizeof(double);
        bytes +=
            s->candidates.count *
            ((size_t)(p->model->domain.count + s->term_count) * sizeof(double) + sizeof *s->ranked);
        bytes += (size_t)s->gradient_fixed.rows * s->trained.count * sizeof(double);
        for (size_t k = 0; k < sizeof programs / sizeof *programs && programs[k].program; k++) {
            bytes += (size_t)threads * ad_program_inspect(programs[k].program).workspace_bytes +
                     ad_program_share(programs[k].program, programs[k].points, 1, 0).bytes;
        }
    }
    return bytes;
}
