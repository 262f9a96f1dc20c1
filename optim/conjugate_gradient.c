/* Hestenes & Stiefel 1952, preconditioned. */
#include "internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct optim_cg {
    size_t count;
    double *r, *z, *p, *ap; /* [count] each */
};

optim_cg *optim_cg_create(size_t count)
{
    const optim_part parts[] = {
        OPTIM_WORK(optim_cg, r, 1, count), OPTIM_WORK(optim_cg, z, 1, count),
        OPTIM_WORK(optim_cg, p, 1, count), OPTIM_WORK(optim_cg, ap, 1, count)};
    optim_cg *cg = optim_room_create(sizeof *cg, sizeof parts / sizeof *parts, parts);
    if (cg) {
        cg->count = count;
    }
    return cg;
}

void optim_cg_free(optim_cg *cg)
{
    free(cg);
}

optim_cg_result optim_cg_solve(optim_cg *cg, optim_product product, void *context, double damping,
                               const optim_nystrom *preconditioner, const double *b,
                               double tolerance, int most, double *x)
{
    const size_t count = cg->count;
    optim_cg_result result = {0, 0, 0};
    memset(x, 0, count * sizeof *x);
    memcpy(cg->r, b, count * sizeof *b);
    optim_nystrom_apply(preconditioner, damping, cg->r, cg->z);
    memcpy(cg->p, cg->z, count * sizeof *cg->p);
    double rz = optim_dot(count, cg->r, cg->z);
    const double first = rz;
    result.residual = rz > 0;
    while (result.residual > tolerance && result.iterations < most) {
        result.code = product(context, cg->p, cg->ap);
        if (result.code != 0) {
            return result;
        }
        result.iterations++;
        const double pp = optim_dot(count, cg->p, cg->p);
        const double curvature = optim_dot(count, cg->p, cg->ap) + damping * pp;
        if (!(curvature > 0)) {
            break;
        }
        const double length = rz / curvature;
        for (size_t i = 0; i < count; i++) {
            x[i] += length * cg->p[i];
            cg->r[i] -= length * (cg->ap[i] + damping * cg->p[i]);
        }
        optim_nystrom_apply(preconditioner, damping, cg->r, cg->z);
        const double next = optim_dot(count, cg->r, cg->z);
        if (!(next > 0)) {
            break;
        }
        for (size_t i = 0; i < count; i++) {
            cg->p[i] = cg->z[i] + next / rz * cg->p[i];
        }
        rz = next;
        result.residual = sqrt(rz / first);
    }
    return result;
}
