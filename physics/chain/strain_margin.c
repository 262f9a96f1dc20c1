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

/* Of vectors by inverse iteration: how far from the eigenvalue, and how often. Of two eigenvalues
 * that are one: how near. */
static const double NEAR = 1e-6, ONE = 1e-8;
enum { TURNS = 4, BOTH = SOLVE_MARGINS };

typedef struct margins {
    strain_group *group;
    strain_form *form;
    int n, axis;                              /* unknowns; a plane's curvature, or -1 */
    lanes *matrix;                            /* [n][n], by columns */
    lanes *right[BOTH], *left[BOTH], *result; /* [n] vectors of lanes, what a matrix makes of one */
    double *dense, *factor, *room;            /* [n][n], and [4 n + 1] */
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
static void find_least(margins *m, int lane, double least[BOTH])
{
    const int n = m->n, elastic = m->form->elastic;
    double *real = m->room, *imaginary = real + n;
    least[0] = least[1] = NAN;
    put_matrix(m, lane, -1, false, m->factor);
    memset(m->dense, 0, (size_t)n * (size_t)elastic * sizeof *m->dense);
    for (int i = 0; i < elastic; i++) {
        m->dense[i * n + i] = counts(m, i);
    }
    if (ad_dense_lu((size_t)n, m->factor, m->pivots) != 0) {
        return;
    }
    ad_dense_lu_solve((size_t)n, (size_t)elastic, m->factor, m->pivots, m->dense);
    for (int c = 0; c < elastic; c++) { /* rows of curvatures alone */
        memmove(m->dense + c * elastic, m->dense + c * n, (size_t)elastic * sizeof *m->dense);
    }
    double *work = m->factor; /* of n^2 > 3 n + 1 */
    if (ad_dense_eigenvalues((size_t)elastic, m->dense, real, imaginary, work) != 0) {
        return;
    }
    least[0] = least[1] = 1;
    for (int i = 0; i < elastic; i++) {
        const double value = fabs(real[i]) > NEAR ? 1 / real[i] - 1 : 1;
        least[1] = fmin(least[1], fmax(least[0], value));
        least[0] = fmin(least[0], value);
    }
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

/* Vectors c of a matrix [2][2] with real eigenvalues, as columns. */
static void vectors_of(double a[2][2], double c[2][2])
{
    const double half = (a[0][0] - a[1][1]) / 2;
    const double apart = sqrt(fmax(0, half * half + a[0][1] * a[1][0]));
    for (int k = 0; k < 2; k++) {
        const double value = (a[0][0] + a[1][1]) / 2 + (k ? apart : -apart);
        const double one[2] = {a[0][1], value - a[0][0]}, other[2] = {value - a[1][1], a[1][0]};
        const bool first = hypot(one[0], one[1]) >= hypot(other[0], other[1]);
        const double *of = first ? one : other, size = hypot(of[0], of[1]);
        c[0][k] = size > 0 ? of[0] / size : k == 0;
        c[1][k] = size > 0 ? of[1] / size : k == 1;
    }
}

/* What is between left and right vectors: the matrix; a weight of each curvature by its axis and
 * its place; and B. */
static void project(const margins *m, int lane, double a[2][2], double w[2][2], double b[2][2])
{
    for (int i = 0; i < 2; i++) {
        for (int k = 0; k < 2; k++) {
            a[i][k] = w[i][k] = b[i][k] = 0;
            for (int c = 0; c < m->n; c++) {
                const double x = m->right[k][c][lane];
                for (int r = 0; r < m->n; r++) {
                    a[i][k] += m->left[i][r][lane] * m->matrix[c * m->n + r][lane] * x;
                }
                const double both = counts(m, c) ? m->left[i][c][lane] * x : 0;
                b[i][k] += both;
                w[i][k] += both * (1 + c % 3 + 0.3 * c / m->n);
            }
        }
    }
}

/* a becomes b^-1 a. */
static void divide(double b[2][2], double a[2][2])
{
    const double size = b[0][0] * b[1][1] - b[0][1] * b[1][0];
    for (int k = 0; k < 2; k++) {
        const double first = a[0][k], second = a[1][k];
        a[0][k] = (b[1][1] * first - b[0][1] * second) / size;
        a[1][k] = (b[0][0] * second - b[1][0] * first) / size;
    }
}

static void product(double a[2][2], double b[2][2], double to[2][2])
{
    for (int i = 0; i < 2; i++) {
        for (int k = 0; k < 2; k++) {
            to[i][k] = a[i][0] * b[0][k] + a[i][1] * b[1][k];
        }
    }
}

static void swap(double *a, double *b)
{
    const double held = *a;
    *a = *b;
    *b = held;
}

/* Iteration leaves of the vectors of two near eigenvalues some in each other. Where the two are
 * one, their vectors are any: those are taken that the weights do not mix, as bending about either
 * axis of a section. */
static void separate(margins *m, int lane, double margin[BOTH])
{
    double a[2][2], w[2][2], b[2][2], c[2][2], bc[2][2], apart[2][2];
    project(m, lane, a, w, b);
    divide(b, a);
    divide(b, w);
    const double half = (a[0][0] - a[1][1]) / 2;
    vectors_of(half * half + a[0][1] * a[1][0] > ONE * ONE ? a : w, c);
    product(a, c, apart);
    divide(c, apart);
    margin[0] = apart[0][0];
    margin[1] = apart[1][1];
    if (margin[0] > margin[1]) {
        swap(&margin[0], &margin[1]);
        swap(&c[0][0], &c[0][1]);
        swap(&c[1][0], &c[1][1]);
    }
    product(b, c, bc);
    for (int i = 0; i < m->n; i++) {
        const double right[2] = {m->right[0][i][lane], m->right[1][i][lane]};
        double left[2][2] = {{m->left[0][i][lane]}, {m->left[1][i][lane]}};
        divide(bc, left);
        for (int k = 0; k < 2; k++) {
            m->right[k][i][lane] = c[0][k] * right[0] + c[1][k] * right[1];
            m->left[k][i][lane] = left[k][0];
        }
    }
}

/* With vectors of both. */
static bool find_vectors(margins *m, int lane, double margin[BOTH])
{
    bool found = true;
    for (int k = 0; k < BOTH; k++) {
        for (int i = 0; i < m->n; i++) {
            m->right[k][i][lane] = counts(m, i) ? 1 + (k ? 1 : 0.1) * sin(1 + i + k * i) : 0;
        }
        found = found && find_vector(m, lane, margin[k], false, m->right[k]);
        for (int i = 0; i < m->n; i++) {
            m->left[k][i][lane] = counts(m, i) ? m->right[k][i][lane] : 0;
        }
        found = found && find_vector(m, lane, margin[k], true, m->left[k]);
    }
    if (found && margin[1] < 1) {
        separate(m, lane, margin);
    }
    return found;
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
        double *both = margin + BOTH * lane;
        find_least(m, lane, both);
        if (vectors && isfinite(both[0]) && !find_vectors(m, lane, both)) {
            both[0] = both[1] = NAN;
        }
    }
}

/* y (A' x) of equilibria beside the members, where y B x = 1. */
static ad_status derive(margins *m, size_t members, const double *parameters,
                        const double *curvature, const double *steps, const double *margin,
                        double *by, ad_error *error)
{
    const int count = m->group->count;
    ad_status status = AD_OK;
    memset(by, 0, members * BOTH * (size_t)count * sizeof *by);
    for (int k = 0; k < count * SIDES && status == AD_OK; k++) {
        const int p = k / SIDES;
        for (size_t i = 0; i < members * (size_t)count; i++) {
            m->steps[i] =
                parameters[i] + ((int)(i % (size_t)count) == p ? way[k % SIDES] * steps[i] : 0);
        }
        status = settle(m, members, m->steps, curvature, error);
        for (int which = 0; which < BOTH && status == AD_OK; which++) {
            memcpy(m->form->direction, m->right[which], (size_t)m->n * sizeof(lanes));
            strain_form_apply(m->form, m->form->direction, m->result);
            memset(m->form->direction, 0, (size_t)m->form->unknowns * sizeof(lanes));
            for (size_t lane = 0; lane < members; lane++) {
                const size_t of = BOTH * lane + (size_t)which;
                double change = 0, size = 0;
                for (int i = 0; i < m->n; i++) {
                    const double left = m->left[which][i][lane];
                    change += left * m->result[i][lane];
                    size += counts(m, i) ? left * m->right[which][i][lane] : 0;
                }
                by[of * (size_t)count + (size_t)p] +=
                    margin[of] < 1 ? weight[k % SIDES] * change /
                                         (size * steps[lane * (size_t)count + (size_t)p])
                                   : 0;
            }
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
    lanes *room = malloc((square + (2 * BOTH + 1) * n) * sizeof *room);
    if (status == AD_OK && (!numbers || !room || !m.pivots)) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a stability margin");
    }
    if (status == AD_OK) {
        m.matrix = room;
        m.result = m.matrix + square;
        for (size_t k = 0; k < BOTH; k++) {
            m.right[k] = m.result + (1 + 2 * k) * n;
            m.left[k] = m.right[k] + n;
        }
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
