/* A reduced rod between its points. */
#include "physics/chain/modes_internal.h"
#include "physics/chain/strain_inline.h"
#include "physics/local/mesh.h"

#include <stdlib.h>
#include <string.h>

/* Where s lies: element, and the fraction of it. What jumps between two is that just before. */
static int element_of(const modes *m, double s, double *fraction)
{
    int e = 0;
    double from = 0;
    while (e + 1 < m->elements &&
           (e < m->hinges || s > m->s[(e + 1) * (m->stages + 1) - 1] + SOLVE_SAME_PLACE)) {
        e++;
    }
    from = e > 0 ? m->s[e * (m->stages + 1) - 1] : 0;
    *fraction = fmin(1, fmax(0, (s - from) / m->element[e].length));
    return e;
}

/* Rotation before element e, behind a joint. */
static void rotation_before(const modes *m, int e, double q[4])
{
    if (e == 0) {
        memcpy(q, m->start.rotation, 4 * sizeof *q);
        return;
    }
    memcpy(q, m->point[e * (m->stages + 1) - 1].q, 4 * sizeof *q);
    if (m->turn_at[e - 1] >= 0) {
        double next[4];
        quaternion_product(q, m->rod->jumps.at[m->turn_at[e - 1]].turn, next);
        memcpy(q, next, 4 * sizeof *q);
    }
}

/* ---- places -------------------------------------------------------------------------------- */

ad_status modes_places_create(const modes *m, size_t n, const double *s, modes_places **result,
                              ad_error *error)
{
    modes_places *places = malloc(sizeof *places + n * sizeof *places->at);
    *result = places;
    if (!places) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu places", n);
    }
    places->count = n;
    for (size_t i = 0; i < n; i++) {
        modes_place *to = &places->at[i];
        double at;
        to->element = element_of(m, s[i], &at);
        to->length = m->element[to->element].length;
        to->before = -1;
        while (to->before + 1 < m->stages && m->rule.nodes[to->before + 1] <= at) {
            to->before++;
        }
        gauss_lagrange(&m->rule, at, to->values);
        gauss_integral(&m->rule, at, to->integrals);
        gauss_magnus(&m->rule, to->before >= 0 ? m->rule.nodes[to->before] : 0, at, to->magnus);
    }
    return AD_OK;
}

void modes_places_free(modes_places *places)
{
    free(places);
}

/* From the last point before it on. */
FOR_EACH_PROCESSOR static void rotate(const modes *m, const modes_place *at, double q[4])
{
    const modes_point *point = m->point + at->element * (m->stages + 1);
    lanes a[3][3], turn[4];
    if (at->before >= 0) {
        memcpy(q, point[at->before].q, 4 * sizeof *q);
    } else {
        rotation_before(m, at->element, q);
    }
    for (int k = 0; k < 3; k++) {
        for (int c = 0; c < 3; c++) {
            double sum = 0;
            for (int j = 0; j < m->stages; j++) {
                sum += at->magnus[k][j] * point[j].strain[MODES_U + c];
            }
            a[k][c] = NO_LANES + at->length * sum;
        }
    }
    for (int i = 0; i < 4; i++) {
        turn[i] = NO_LANES + q[i];
    }
    step_on(a, turn);
    for (int i = 0; i < 4; i++) {
        q[i] = turn[i][0];
    }
    quaternion_normalize(q);
}

static void sample(const modes *m, const modes_place *at, solve_state *out)
{
    double R[3][3], spin[3] = {0}, force[3] = {0}, moment[3] = {0}, start_spin[3], carry = 0;
    const int e = at->element;
    const modes_point *point = m->point + e * (m->stages + 1), *before = point - 1;
    memset(out, 0, sizeof *out);
    rotate(m, at, out->rotation);
    rotation_matrix(m->start.rotation, R);
    to_world(R, m->start.spin, start_spin);
    for (int k = 0; k < 3; k++) {
        out->position[k] = e > 0 ? before->r[k] : m->start.position[k];
        out->velocity[k] = e > 0 ? before->velocity[k] : m->start.velocity[k];
        spin[k] = e > 0 ? before->spin[k] : start_spin[k];
        for (int j = 0; j < m->stages; j++) {
            const modes_point *x = &point[j];
            const double by = at->length * at->integrals[j], value = at->values[j];
            out->position[k] += by * x->along[k];
            out->velocity[k] += by * (x->turning[k] + x->along_rate[k]);
            spin[k] += by * x->turned_rate[k];
            carry += k == 0 ? value * x->carry : 0;
            out->strain[k] += value * x->strain[MODES_V + k];
            out->curvature[k] += value * x->strain[MODES_U + k];
            force[k] += value * x->carried[0][k] / x->weight;
            moment[k] += value * x->carried[1][k] / x->weight;
        }
    }
    rotation_matrix(out->rotation, R);
    to_body(R, spin, out->spin);
    if (m->feed.mode >= 0) { /* of what is there */
        double along[3];
        to_world(R, out->strain, along);
        for (int k = 0; k < 3; k++) {
            out->velocity[k] += carry * along[k];
            out->spin[k] += carry * out->curvature[k];
        }
    }
    to_body(R, force, out->force);
    to_body(R, moment, out->moment);
}

void modes_samples(const modes *m, const modes_places *places, solve_state *out)
{
    for (size_t i = 0; i < places->count; i++) {
        sample(m, &places->at[i], &out[i]);
    }
}

ad_status modes_see(modes *m, const double *state, double *room, const modes_places *places,
                    solve_state *out, ad_error *error)
{
    const size_t size = (size_t)m->size;
    const double *q = state, *v = q + size, *d = v + size;
    double *a = room, *residual = a + size;
    modes_stretch(m, d);
    if (!modes_accelerations(m, q, v, a)) {
        return modes_accelerations_fail(m, error);
    }
    modes_shape(m, q, v, a);
    modes_forces(m, false, residual);
    modes_samples(m, places, out);
    return AD_OK;
}
