/* What a process does and holds of a problem, alone or as one of several ranks. */
#include "physics/problem_internal.h"

const ad_ranks *problem_ranks(const problem *p)
{
    return ad_pool_ranks(p->pool);
}

ad_share problem_share(const problem *p, int set, bool normal, int ranks, int rank)
{
    const problem_set *s = &p->sets[set];
    const size_t points = s->trained.count;
    if (normal && s->normal) {
        return ad_normal_share(s->normal, points, ranks, rank);
    }
    return s->gradient ? ad_program_share(s->gradient, points, ranks, rank)
                       : (ad_share){.points = points, .items = 1}; /* a motion: all take all */
}

size_t problem_bytes(const problem *p, int ranks, int rank)
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
        const size_t trained = problem_set_is_shared(p, s)
                                   ? problem_share(p, i, false, ranks, rank).points
                                   : s->trained.count;
        bytes += ((size_t)p->model->domain.count + (size_t)s->about->source.rows) *
                 (trained + s->held_out.count) * sizeof(double);
        bytes += problem_weights_per_point(s) * s->trained.count * sizeof(double);
        bytes +=
            s->candidates.count *
            ((size_t)(p->model->domain.count + s->term_count) * sizeof(double) + sizeof *s->ranked);
        bytes += (size_t)s->gradient_fixed.rows * s->trained.count * sizeof(double);
        for (size_t k = 0; k < sizeof programs / sizeof *programs && programs[k].program; k++) {
            bytes += (size_t)threads * ad_program_inspect(programs[k].program).workspace_bytes +
                     ad_program_share(programs[k].program, programs[k].points, ranks, rank).bytes;
        }
    }
    return bytes;
}
