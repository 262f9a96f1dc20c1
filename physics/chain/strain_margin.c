/* The stability margin of members (solve_members.h). The matrix of Newton's method is, with factors
 * of the section's softness and of the weights of points, the second variation of the energy by
 * curvatures; forces that are sought are multipliers in it. So with B, 1 for curvatures and 0 for
 * these, the least eigenvalue of A x = lambda B x is the least of the second variation over the
 * energy that the same change of curvature has in bending and twist by itself. */
#include "physics/chain/strain_margin.h"

#include "autodiff/dense.h"
#include "physics/local/strain_algebra.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Newton's steps to an equilibrium from one that is near. The stencil of derivatives, of fourth
 * order, on either side of a member, over the range of the parameter. */
enum { STEPS = 3, SIDES = 4 };
static const double way[SIDES] = {-2, -1, 1, 2};
static const double weight[SIDES] = {1. / 12, -2. / 3, 2. / 3, -1. / 12};

/* Of vectors by inverse iteration: how far from the eigenvalue, and how often. */
static const double NEAR = 1e-6;
enum { TURNS = 4 };

typedef struct margins {
    strain_group *group;
    strain_form *form;
    int n, axis;                   /* unknowns; a plane's curvature, or -1 */
    lanes *matrix;                 /* [n][n], by columns */
    lanes *right, *result, *left;  /* [n] vectors of lanes, and what the matrix makes of one */
    double *dense, *factor, *room; /* [n][n], and [4 n + 1] */
    int *pivots;
    double *steps; /* [LANES][parameters] a member beside */
} margins;

static bool counts(const margins *m, int i)
{
    return i < m->form->elastic && (m->axis < 0 || i % 3 == m->axis);
}

/* The equilibrium next to a curvature, and the derivatives there. */
static ad_status settle(margins *m, size_t members, const double *parameters,
                        const double *curvature, ad_error *error)
{
    bool all[LANES];
    const lanes whole = NO_LANES + 1;
    const ad_status status = strain_group_take(m->group, members, parameters, curvature, error);
    memset(all, true, sizeof all);
    for (int k = 0; k < STEPS && status == AD_OK; k++) {
        lanes length;
        strain_group_step(m->form, all, &length);
        strain_form_move(m->form, m->form->right, &whole);
    }
    if (status == AD_OK) {
        strain_form_shape(m->form);
        strain_form_linearise(m->form);
    }
    return status;
}

/* A - shift B of one lane, column-major, or its transpose. Curvature across a plane is held. */
static void put_matrix(const margins *m, int lane, double shift, bool transposed, double *to)
{
    for (int c = 0; c < m->n; c++) {
        for (int r = 0; r < m->n; r++) {
            const bool held =
                (r < m->form->elastic && !counts(m, r)) || (c < m->form->elastic && !counts(m, c));
            const double value = held ? r == c : m->matrix[c * m->n + r][lane];
            to[transposed ? r * m->n + c : c * m->n + r] =
                value - (r == c && counts(m, r) ? shift : 0);
        }
    }
    for (int r = m->form->elastic; r < m->n; r++) { /* a force across the plane has no row */
        double size = 0;
        for (int c = 0; c < m->n; c++) {
            size = fmax(size, fabs(to[transposed ? r * m->n + c : c * m->n + r]));
        }
        to[r * m->n + r] += size == 0;
    }
}

/* By the eigenvalues 1/(lambda + 1) of (A + B)^-1 B, as B is singular. NaN: not found. */
static double least_of(margins *m, int lane)
{
    const int n = m->n, elastic = m->form->elastic;
    double *real = m->room, *imaginary = real + n, least = 1;
    put_matrix(m, lane, -1, false, m->factor);
    memset(m->dense, 0, (size_t)n * (size_t)elastic * sizeof *m->dense);
    for (int i = 0; i < elastic; i++) {
        m->dense[i * n + i] = counts(m, i);
    }
    if (ad_dense_lu((size_t)n, m->factor, m->pivots) != 0) {
        return NAN;
    }
    ad_dense_lu_solve((size_t)n, (size_t)elastic, m->factor, m->pivots, m->dense);
    for (int c = 0; c < elastic; c++) { /* rows of curvatures alone */
        memmove(m->dense + c * elastic, m->dense + c * n, (size_t)elastic * sizeof *m->dense);
    }
    double *work = m->factor; /* of n^2 > 3 n + 1 */
    if (ad_dense_eigenvalues((size_t)elastic, m->dense, real, imaginary, work) != 0) {
        return NAN;
    }
    for (int i = 0; i < elastic; i++) {
        least = fabs(real[i]) > NEAR ? fmin(least, 1 / real[i] - 1) : least;
    }
    return least;
}

/* The vector of an eigenvalue, or that of the transposed matrix, from what is in `to`. */
static bool find_vector(margins *m, int lane, double value, bool transposed, lanes *to)
{
    const size_t n = (size_t)m->n;
    double *x = m->room;
    put_matrix(m, lane, value - NEAR * fmax(1, fabs(value)), transposed, m->factor);
    if (ad_dense_lu(n, m->factor, m->pivots) != 0) {
        return false;
    }
    for (int k = 0; k < TURNS; k++) {
        double size = 0;
        for (int i = 0; i < m->n; i++) {
            x[i] = counts(m, i) ? to[i][lane] : 0;
        }
        ad_dense_lu_solve(n, 1, m->factor, m->pivots, x);
        for (int i = 0; i < m->n; i++) {
            size = counts(m, i) ? fmax(size, fabs(x[i])) : size;
        }
        for (int i = 0; i < m->n; i++) {
            to[i][lane] = x[i] / size;
        }
    }
    return true;
}

static void find_margins(margins *m, size_t members, bool vectors, double *margin)
{
    strain_form *form = m->form;
    for (int c = 0; c < m->n; c++) {
        form->direction[c] = NO_LANES + 1;
        strain_form_apply(form, form->direction, m->matrix + c * m->n);
        form->direction[c] = NO_LANES;
    }
    for (int lane = 0; lane < (int)members; lane++) {
        margin[lane] = least_of(m, lane);
        for (int i = 0; i < m->n; i++) {
            m->right[i][lane] = counts(m, i) ? 1 + 0.1 * sin(1 + i) : 0;
        }
        if (!vectors || !isfinite(margin[lane])) {
            continue;
        }
        bool found = find_vector(m, lane, margin[lane], false, m->right);
        for (int i = 0; i < m->n; i++) {
            m->left[i][lane] = counts(m, i) ? m->right[i][lane] : 0;
        }
        found = found && find_vector(m, lane, margin[lane], true, m->left);
        margin[lane] = found ? margin[lane] : NAN;
    }
}

/* y (A' x) of equilibria beside the members, where y B x = 1. */
static ad_status derive(margins *m, size_t members, const double *parameters,
                        const double *curvature, const double *steps, const double *margin,
                        double *by, ad_error *error)
{
    const int count = m->group->count;
    ad_status status = AD_OK;
    memset(by, 0, members * (size_t)count * sizeof *by);
    for (int k = 0; k < count * SIDES && status == AD_OK; k++) {
        const int p = k / SIDES;
        for (size_t i = 0; i < members * (size_t)count; i++) {
            m->steps[i] =
                parameters[i] + ((int)(i % (size_t)count) == p ? way[k % SIDES] * steps[i] : 0);
        }
        status = settle(m, members, m->steps, curvature, error);
        for (int i = 0; i < m->n && status == AD_OK; i++) {
            m->form->direction[i] = m->right[i];
        }
        if (status == AD_OK) {
            strain_form_apply(m->form, m->form->direction, m->result);
            memset(m->form->direction, 0, (size_t)m->form->unknowns * sizeof(lanes));
        }
        for (size_t lane = 0; lane < members && status == AD_OK; lane++) {
            double change = 0, size = 0;
            for (int i = 0; i < m->n; i++) {
                change += m->left[i][lane] * m->result[i][lane];
                size += counts(m, i) ? m->left[i][lane] * m->right[i][lane] : 0;
            }
            const size_t at = lane * (size_t)count + (size_t)p;
            by[at] += margin[lane] < 1 ? weight[k % SIDES] * change / (size * steps[at]) : 0;
        }
    }
    return status;
}

ad_status strain_group_margin(strain_group *group, size_t members, const double *parameters,
                              const double *curvature, int axis, const double *steps,
                              double *margin, double *by, ad_error *error)
{
    strain_form *form = group->level[group->modes].form;
    const size_t n = (size_t)form->unknowns, square = n * n;
    margins m = {.group = group, .form = form, .n = (int)n, .axis = axis};
    double *numbers =
        malloc((2 * square + 4 * n + 1 + LANES * (size_t)(group->count + 1)) * sizeof *numbers);
    ad_status status = ad_dense_load(error);
    m.pivots = malloc(n * sizeof *m.pivots);
    lanes *room = malloc((square + 3 * n) * sizeof *room);
    if (status == AD_OK && (!numbers || !room || !m.pivots)) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a stability margin");
    }
    if (status == AD_OK) {
        m.matrix = room;
        m.right = m.matrix + square;
        m.result = m.right + n;
        m.left = m.result + n;
        m.dense = numbers;
        m.factor = m.dense + square;
        m.room = m.factor + square;
        m.steps = m.room + 4 * n + 1;
        status = settle(&m, members, parameters, curvature, error);
    }
    if (status == AD_OK) {
        find_margins(&m, members, by, margin);
        status = by ? derive(&m, members, parameters, curvature, steps, margin, by, error) : AD_OK;
    }
    free(numbers);
    free(m.pivots);
    free(room);
    return status;
}
