/* What actuators and the law of the section do to the strain, on the tape. */
#include "physics/law/law.h"
#include "physics/rod/strain_internal.h"

#include <string.h>

/* ---- one actuator --------------------------------------------------------------------------- */

/* Rows that stay together, which a factor of zeros and ones would not. */
ad_value strain_pull_within(const strain_rod *rod, const strain_pull *of, ad_value pull)
{
    const int first = of->first, count = of->count;
    if (count == 0 || count == rod->nodes) {
        return count == 0 ? ad_scalar(rod->tape, 0) : pull;
    }
    ad_value here = ad_rows(pull) == 1 ? ad_repeat(pull, count) : ad_slice(pull, first, count);
    return ad_pad(here, first, rod->nodes);
}

static void record_pull(const strain_rod *rod, const strain_pull *a, ad_value pull, along v,
                        along u, ad_value *energy, ad_value *wrench, ad_value *stiffness)
{
    const ad_value given[] = {v.x[0],       v.x[1],       v.x[2],      u.x[0],      u.x[1], u.x[2],
                              a->offset[0], a->offset[1], a->slope[0], a->slope[1], pull};
    law_record(a->law, rod->tape, given, energy, wrench, stiffness);
}

ad_value strain_pull_length(const strain_rod *rod, const strain_pull *of, along v, along u)
{
    ad_value length;
    record_pull(rod, of, ad_scalar(rod->tape, 1), v, u, &length, NULL, NULL);
    return strain_pull_within(rod, of, length);
}

ad_value strain_pull_angle(const strain_rod *rod, const strain_pull *of, const strain_state *state)
{
    /* of one that does not turn, a root that has a derivative */
    const ad_value least = ad_scalar(rod->tape, 1e-30);
    const int n = rod->mesh.stages;
    double slope[GAUSS_STAGES_MAX][GAUSS_STAGES_MAX];
    double by[STRAIN_STAGES_MAX * STRAIN_STAGES_MAX],
        to[(STRAIN_STAGES_MAX + 1) * STRAIN_STAGES_MAX];
    ad_value wrench[LAW_WRENCH], parts[STRAIN_ELEMENTS_MAX], angle = ad_scalar(rod->tape, 0);
    int count = 0;
    gauss_slope(&rod->rule, slope);
    for (int i = 0; i < n * n; i++) {
        by[i] = slope[i / n][i % n];
        to[i] = rod->rule.matrix[i / n][i % n];
    }
    memcpy(to + n * n, rod->rule.weights, (size_t)n * sizeof *to);
    record_pull(rod, of, ad_scalar(rod->tape, 1), state->strain, state->curvature, NULL, wrench,
                NULL);
    const along tangent = strain_to_world(&state->R, (along){{wrench[0], wrench[1], wrench[2]}});
    for (int e = of->first / n; e * n < of->first + of->count; e++) {
        along turning = strain_element(rod, tangent, e);
        for (int c = 0; c < 3; c++) {
            turning.x[c] = strain_weigh(n, n, by, turning.x[c]);
        }
        const ad_value size = ad_sqrt(ad_add(strain_dot(turning, turning), least));
        const ad_value sums = strain_weigh(n + 1, n, to, size);
        parts[count++] = ad_add(ad_slice(sums, 0, n), angle);
        angle = ad_add(angle, ad_row(sums, n));
    }
    return count > 0 ? ad_pad(ad_stack(count, parts), of->first, rod->nodes)
                     : ad_zeros(rod->tape, rod->nodes);
}

/* ---- all actuators --------------------------------------------------------------------------- */

/* Of actuators and a law of the section at v, u: force, moment, and the derivative of the
 * force by v. */
typedef struct pulling {
    along force, moment;
    along_matrix by_v;
} pulling;

static void add_pull(const ad_value *wrench, const ad_value *stiffness, pulling *sum)
{
    for (int i = 0; i < 3; i++) {
        sum->force.x[i] = ad_add(sum->force.x[i], wrench[i]);
        sum->moment.x[i] = ad_add(sum->moment.x[i], wrench[3 + i]);
        for (int j = 0; j < 3; j++) {
            sum->by_v.x[i][j] = ad_add(sum->by_v.x[i][j], stiffness[law_entry(i, j)]);
        }
    }
}

static void pull_one(const strain_rod *rod, const strain_pull *a, ad_value pull, along v, along u,
                     pulling *sum)
{
    ad_value wrench[LAW_WRENCH], stiffness[LAW_STIFFNESS];
    record_pull(rod, a, pull, v, u, NULL, wrench, stiffness);
    add_pull(wrench, stiffness, sum);
}

/* What the law of the section is beyond its stiffness. */
static void pull_by_law(const strain_rod *rod, along v, along u, pulling *sum)
{
    const along off[2] = {strain_sub(v, rod->rest_strain), strain_sub(u, rod->rest_curvature)};
    ad_value strains[LAW_WRENCH], wrench[LAW_WRENCH], stiffness[LAW_STIFFNESS];
    for (int i = 0; i < LAW_WRENCH; i++) {
        strains[i] = off[i / 3].x[i % 3];
    }
    scene_law_record_places(rod->open.rod.law, rod->rod.scales.length, rod->rod.scales.force,
                            strains, wrench, stiffness);
    add_pull(wrench, stiffness, sum);
}

static bool pulls(const strain_rod *rod)
{
    return rod->actuators > 0 || rod->open.rod.law;
}

static pulling pull_all(const strain_rod *rod, const ad_value *pull, along v, along u)
{
    const along none = strain_zeros(rod->tape);
    pulling sum = {.force = none, .moment = none};
    for (int i = 0; i < 9; i++) {
        sum.by_v.x[i / 3][i % 3] = none.x[0];
    }
    for (int i = 0; i < rod->actuators; i++) {
        pull_one(rod, &rod->pulls[i], pull[i], v, u, &sum);
    }
    if (rod->open.rod.law) {
        pull_by_law(rod, v, u, &sum);
    }
    return sum;
}

/* By cofactors: the matrix is near 1. */
along strain_softened(const strain_rod *rod, const ad_value *pull, along v, along u, along a)
{
    const along_matrix by_v = pull_all(rod, pull, v, u).by_v;
    along rows[3], solved;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            rows[i].x[j] = ad_mul(rod->strain_compliance.x[i], by_v.x[i][j]);
        }
        rows[i].x[i] = ad_add(rows[i].x[i], ad_scalar(rod->tape, 1));
    }
    along cofactors[3] = {strain_cross(rows[1], rows[2]), strain_cross(rows[2], rows[0]),
                          strain_cross(rows[0], rows[1])};
    ad_value by = ad_reciprocal(strain_dot(rows[0], cofactors[0]));
    for (int c = 0; c < 3; c++) { /* the inverse's columns are the cofactors */
        solved.x[c] =
            strain_dot((along){{cofactors[0].x[c], cofactors[1].x[c], cofactors[2].x[c]}}, a);
    }
    return strain_by(by, solved);
}

along strain_balance(const strain_rod *rod, const ad_value *pull, along n, along u, along v)
{
    const along force = pulls(rod) ? strain_sub(n, pull_all(rod, pull, v, u).force) : n;
    return rod->shears ? strain_add(rod->rest_strain, strain_mul(rod->strain_compliance, force))
                       : rod->rest_strain;
}

bool strain_is_implicit(const strain_rod *rod)
{
    return rod->shears && pulls(rod);
}

along strain_yield_on(const strain_rod *rod, const ad_value *pull, along n, along u, along v,
                      along matrix_u)
{
    const along there = strain_balance(rod, pull, n, u, v);
    if (!strain_is_implicit(rod)) {
        return there;
    }
    return strain_sub(v, strain_softened(rod, pull, v, matrix_u, strain_sub(v, there)));
}

along strain_yield(const strain_rod *rod, const ad_value *pull, along n, along u, along v)
{
    enum { STEPS = 3 }; /* leave (C pull)^15 of it */
    for (int k = 0; k < STEPS; k++) {
        v = strain_yield_on(rod, pull, n, u, v, u);
    }
    return v;
}

along strain_missing(const strain_rod *rod, const ad_value *pull, const along_matrix *R, along v,
                     along u, along M)
{
    const pulling sum = pull_all(rod, pull, v, u);
    along m = strain_sub(strain_to_body(R, M), sum.moment);
    return strain_sub(strain_sub(u, rod->rest_curvature), strain_mul(rod->curvature_compliance, m));
}
