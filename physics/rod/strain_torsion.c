/* Concentric tubes in the strain form on a tape, as physics/chain/strain_tubes.h has them. */
#include "physics/rod/strain_internal.h"

/* Rows of the gradient of a tube's energy beyond those by u. */
enum { BY_THETA = 3, BY_TORSION };

int strain_columns(const scene *open)
{
    return STRAIN_COLUMNS + 2 * open->tube_count;
}

int strain_twisting(const scene *open, int nodes)
{
    return open->tube_count * (1 + nodes);
}

/* What is at the points of a tube's elements. */
static ad_value within(const strain_rod *rod, const strain_torsion *of, ad_value x)
{
    const int count = of->elements * rod->mesh.stages;
    return ad_rows(x) > count ? ad_slice(x, 0, count) : x;
}

void strain_torsion_give(strain_rod *rod)
{
    const ad_value start = ad_scalar(rod->tape, 0);
    rod->tubes = rod->open.tube_count;
    rod->twisting = strain_twisting(&rod->open, rod->nodes);
    for (int i = 0; i < rod->tubes; i++) {
        const rod_tube tube = rod_tube_of(&rod->rod, i);
        const double *edges = rod->mesh.edges;
        strain_torsion *to = &rod->torsions[i];
        ad_value numbers[LAW_TUBE_GIVEN];
        while (to->elements < rod->mesh.elements &&
               (edges[to->elements] + edges[to->elements + 1]) / 2 < tube.end) {
            to->elements++;
        }
        rod_tube_numbers(&rod->rod, i, numbers);
        for (int k = 0; k < LAW_TUBE_GIVEN; k++) {
            strain_spread(rod, numbers[k], &to->numbers[k]);
            to->numbers[k] = within(rod, to, to->numbers[k]);
        }
        to->turned = ad_mul(ad_square(rod->at.load_factor), tube.turned);
        to->yielding = ad_mul(ad_substitute(tube.softness, rod->rod.s, start), tube.transmission);
    }
}

static void record(const strain_rod *rod, const strain_state *state, int i, ad_value theta,
                   ad_value gradient[LAW_WRENCH])
{
    const strain_torsion *of = &rod->torsions[i];
    ad_value given[LAW_WRENCH + LAW_TUBE_GIVEN] = {
        [3] = ad_cos(theta), [4] = ad_sin(theta), [5] = within(rod, of, state->torsion[i])};
    for (int c = 0; c < 3; c++) {
        given[c] = within(rod, of, state->curvature.x[c]);
    }
    for (int k = 0; k < LAW_TUBE_GIVEN; k++) {
        given[LAW_WRENCH + k] = of->numbers[k];
    }
    law_record(LAW_TUBE, rod->tape, given, NULL, gradient, NULL);
}

/* Of a rate at the points of `elements`, from `sum` on: the integral to the points from s = 0, or
 * back to them from the end of the last; sum: that of all. */
static ad_value integral(const strain_rod *rod, int elements, bool back, ad_value rate,
                         ad_value *sum)
{
    const int n = rod->mesh.stages;
    ad_value parts[STRAIN_ELEMENTS_MAX];
    for (int k = 0; k < elements; k++) {
        const int e = back ? elements - 1 - k : k;
        const double h = rod->mesh.edges[e + 1] - rod->mesh.edges[e];
        double to[(STRAIN_STAGES_MAX + 1) * STRAIN_STAGES_MAX];
        for (int j = 0; j < n; j++) {
            const double all = h * rod->rule.weights[j];
            to[n * n + j] = all;
            for (int i = 0; i < n; i++) {
                const double part = h * rod->rule.matrix[i][j];
                to[i * n + j] = back ? all - part : part;
            }
        }
        const ad_value both =
            strain_weigh(n + 1, n, to, ad_rows(rate) == 1 ? rate : ad_slice(rate, e * n, n));
        parts[e] = ad_add(ad_slice(both, 0, n), *sum);
        *sum = ad_add(ad_row(both, n), *sum);
    }
    return ad_stack(elements, parts);
}

void strain_torsion_turn(const strain_rod *rod, ad_value sought, int first, strain_state *state)
{
    for (int i = 0; i < rod->tubes; i++) {
        const strain_torsion *of = &rod->torsions[i];
        state->base[i] = ad_row(sought, first + i);
        state->torsion[i] = ad_slice(sought, first + rod->tubes + i * rod->nodes, rod->nodes);
        ad_value theta = ad_add(of->turned, ad_mul(of->yielding, state->base[i]));
        record(rod, state, i, theta, state->tube[i]);
        const ad_value rate = ad_neg(state->tube[i][BY_TORSION]); /* of any theta */
        const ad_value at = integral(rod, of->elements, false, rate, &theta);
        const int beyond = rod->nodes - ad_rows(at);
        record(rod, state, i, at, state->tube[i]);
        state->theta[i] = at;
        if (beyond > 0) {
            state->theta[i] = ad_stack(2, (ad_value[]){at, ad_repeat(theta, beyond)});
        }
    }
}

along strain_torsion_moment(const strain_rod *rod, const strain_state *state)
{
    along sum = strain_zeros(rod->tape);
    for (int i = 0; i < rod->tubes; i++) {
        for (int c = 0; c < 3; c++) {
            const int count = rod->torsions[i].elements * rod->mesh.stages;
            ad_value part = state->tube[i][c];
            part = ad_rows(part) < count ? ad_repeat(part, count) : part;
            sum.x[c] = ad_add(sum.x[c], ad_pad(part, 0, rod->nodes));
        }
    }
    return sum;
}

int strain_torsion_missing(const strain_rod *rod, const strain_state *state, ad_value *rows)
{
    for (int i = 0; i < rod->tubes; i++) {
        ad_value base = ad_scalar(rod->tape, 0);
        const ad_value rate = ad_neg(state->tube[i][BY_THETA]);
        const ad_value made = integral(rod, rod->torsions[i].elements, true, rate, &base);
        rows[i] = ad_sub(state->base[i], base);
        rows[rod->tubes + i] = ad_sub(state->torsion[i], ad_pad(made, 0, rod->nodes));
    }
    return 2 * rod->tubes;
}
