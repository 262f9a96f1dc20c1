/* A reduced rod between its points. */
#include "physics/solve/modes_internal.h"
#include "physics/solve/mesh.h"
#include "physics/solve/strain_inline.h"

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

struct modes_places {
    size_t count;
    struct place {
        int element, before; /* the last of its points before the place; -1: none */
        double length, values[GAUSS_STAGES_MAX], integrals[GAUSS_STAGES_MAX]; /* by points */
        double magnus[3][GAUSS_STAGES_MAX];
    } at[];
};

ad_status modes_places_create(const modes *m, size_t n, const double *s, modes_places **result,
                              ad_error *error)
{
    modes_places *x = malloc(sizeof *x + n * sizeof *x->at);
    *result = x;
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu places", n);
    }
    x->count = n;
    for (size_t i = 0; i < n; i++) {
        struct place *to = &x->at[i];
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

void modes_places_free(modes_places *x)
{
    free(x);
}

/* From the last point before it on. */
FOR_EACH_PROCESSOR static void rotate(const modes *m, const struct place *at, double q[4])
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

static void sample(const modes *m, const struct place *at, solve_state *out)
{
    double R[3][3], spin[3] = {0}, force[3] = {0}, moment[3] = {0}, start_spin[3];
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
            out->strain[k] += value * x->strain[MODES_V + k];
            out->curvature[k] += value * x->strain[MODES_U + k];
            force[k] += value * x->carried[0][k] / x->weight;
            moment[k] += value * x->carried[1][k] / x->weight;
        }
    }
    rotation_matrix(out->rotation, R);
    to_body(R, spin, out->spin);
    to_body(R, force, out->force);
    to_body(R, moment, out->moment);
}

void modes_samples(const modes *m, const modes_places *places, solve_state *out)
{
    for (size_t i = 0; i < places->count; i++) {
        sample(m, &places->at[i], &out[i]);
    }
}

/* Turn and displacement by each mode, world; their integrals go on from the element's start. */
static void sample_rows(const modes *m, const struct place *at, int k, double *theta, double *rho)
{
    const int n = m->stages, width = m->width, e = at->element, first = e * (n + 1);
    const modes_element *element = &m->element[e];
    const double *before = m->theta + ((first - 1) * 3 + k) * width;
    const double *moved = m->rho + ((first - 1) * 3 + k) * width;
    for (int a = 0; a < m->size; a++) {
        theta[a] = e > 0 ? before[a] : 0;
        rho[a] = e > 0 ? moved[a] : 0;
    }
    for (int j = 0; j < n; j++) {
        const modes_point *point = &m->point[first + j];
        const double by = at->length * at->integrals[j];
        const double *turn = m->theta + (first + j) * 3 * width;
        const double *value = m->value + (first + j) * width;
        const int x = (k + 1) % 3, y = (k + 2) % 3;
        for (int a = 0; a < element->end; a++) {
            rho[a] += by * (turn[x * width + a] * point->along[y] -
                            turn[y * width + a] * point->along[x]);
        }
        for (int a = element->own; a < element->end; a++) {
            const int c = m->mode[a].strain;
            double *to = c >= MODES_U ? theta : rho;
            to[a] += by * point->R[k][c % 3] * value[a];
        }
    }
}

/* Changes of velocity and spin by q at places: of the integrals that `sample` takes. */
static void sample_rates(const modes *m, const struct place *at, int a, double *spin,
                         double *velocity)
{
    const int n = m->stages, width = m->width;
    memset(spin, 0, 3 * sizeof *spin);
    memset(velocity, 0, 3 * sizeof *velocity);
    for (int e = 0; e <= at->element; e++) {
        const modes_element *element = &m->element[e];
        double turned[GAUSS_STAGES_MAX][3], before[3];
        memcpy(before, spin, sizeof before);
        for (int j = 0; j < n; j++) { /* theta x R u_t */
            const modes_point *point = &m->point[e * (n + 1) + j];
            const double *row = m->theta + (e * (n + 1) + j) * 3 * width + a;
            const double theta[3] = {row[0], row[width], row[2 * width]};
            vector_cross(theta, point->turned_rate, turned[j]);
        }
        for (int j = 0; j < n; j++) {
            const modes_point *point = &m->point[e * (n + 1) + j];
            const double *row = m->theta + (e * (n + 1) + j) * 3 * width + a;
            const double theta[3] = {row[0], row[width], row[2 * width]};
            const double by =
                e < at->element ? element->matrix[n][j] : at->length * at->integrals[j];
            const bool own = a >= element->own && a < element->end && m->mode[a].strain < MODES_U;
            const double value = own ? m->value[(e * (n + 1) + j) * width + a] : 0;
            double w[3] = {before[0], before[1], before[2]}, along[3], rate[3], part[3];
            for (int i = 0; i < n; i++) {
                for (int k = 0; k < 3; k++) {
                    w[k] += element->matrix[j][i] * turned[i][k];
                }
            }
            vector_cross(theta, point->along, along);
            for (int k = 0; k < 3; k++) {
                along[k] += value * point->R[k][m->mode[a].strain % 3];
            }
            vector_cross(w, point->along, rate);
            vector_cross(point->spin, along, part);
            for (int k = 0; k < 3; k++) {
                rate[k] += part[k];
            }
            vector_cross(theta, point->along_rate, part);
            for (int k = 0; k < 3; k++) {
                velocity[k] += by * (rate[k] + part[k]);
                spin[k] += by * turned[j][k];
            }
        }
    }
}

void modes_sample_derivatives(const modes *m, const modes_places *places, double *by)
{
    const int n = m->size, columns = 2 * n;
    for (size_t i = 0; i < places->count; i++) {
        const struct place *at = &places->at[i];
        double *to = by + i * 12 * (size_t)columns, R[3][3], q[4], spin[3] = {0};
        solve_state here;
        sample(m, at, &here);
        memcpy(q, here.rotation, sizeof q);
        rotation_matrix(q, R);
        to_world(R, here.spin, spin);
        for (int k = 0; k < 3; k++) {
            sample_rows(m, at, k, to + (3 + k) * columns, to + k * columns);
        }
        for (int a = 0; a < n; a++) {
            double w[3], v[3], theta[3], turned[3], body[2][3], change[3];
            sample_rates(m, at, a, w, v);
            for (int k = 0; k < 3; k++) {
                theta[k] = to[(3 + k) * columns + a];
            }
            vector_cross(theta, spin, turned); /* R^T (w - theta x spin) */
            for (int k = 0; k < 3; k++) {
                change[k] = w[k] - turned[k];
            }
            to_body(R, change, body[0]);
            to_body(R, theta, body[1]);
            for (int k = 0; k < 3; k++) {
                to[k * columns + n + a] = to[(3 + k) * columns + n + a] = 0;
                to[(6 + k) * columns + a] = v[k];
                to[(6 + k) * columns + n + a] = to[k * columns + a];
                to[(9 + k) * columns + a] = body[0][k];
                to[(9 + k) * columns + n + a] = body[1][k];
            }
        }
    }
}
