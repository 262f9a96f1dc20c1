/* Modes of a family: principal components of its members' curvature, by the distances that it moves
 * the rod. */
#include "physics/learn/family_fit.h"

#include "autodiff/memory.h"
#include "physics/numerics/quaternion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Members whose shapes make the metric, all of its rods alike; more change it little. Its smallest
 * eigenvalues are those of changes of curvature that hardly move the rod: RIDGE of the mean is
 * added. */
enum { METRIC_MEMBERS = 256, ITERATIONS = 24 };
static const double RIDGE = 1e-8;

/* Of the largest: modes with less are left out. */
static const double LEAST_SCALE = 1e-10;

typedef struct fit {
    family *f;
    size_t members;
    double *inputs; /* [inputs][members] */
    double *turn;   /* [9][members] */
    double *u;      /* [members][rows], curvature of the members that the inputs are of, times L */
    double *metric; /* [rows][rows], then its upper Cholesky factor */
    double *spread; /* [rows][rows], mean of products of what the affine function leaves */
    double *basis;  /* [modes][rows] */
    double *work;   /* [rows][rows] */
    ad_memory memory;
} fit;

/* ---- small dense matrices ------------------------------------------------------------------ */

/* The upper triangle a[n][n] becomes R with R^T R = a. False: not positive definite. */
static bool factor(size_t n, double *a)
{
    for (size_t k = 0; k < n; k++) {
        double *row = a + k * n;
        if (!(row[k] > 0)) {
            return false;
        }
        const double root = sqrt(row[k]);
        for (size_t j = k; j < n; j++) {
            row[j] /= root;
        }
        for (size_t i = k + 1; i < n; i++) {
            for (size_t j = i; j < n; j++) {
                a[i * n + j] -= row[i] * row[j];
            }
        }
    }
    return true;
}

/* R x = b, x[n] with so many numbers between two. */
static void solve_upper(size_t n, const double *r, double *x, size_t stride)
{
    for (size_t i = n; i-- > 0;) {
        for (size_t j = i + 1; j < n; j++) {
            x[i * stride] -= r[i * n + j] * x[j * stride];
        }
        x[i * stride] /= r[i * n + i];
    }
}

/* R^T x = b. */
static void solve_lower(size_t n, const double *r, double *x, size_t stride)
{
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j < i; j++) {
            x[i * stride] -= r[j * n + i] * x[j * stride];
        }
        x[i * stride] /= r[i * n + i];
    }
}

static double dot(size_t n, const double *a, const double *b)
{
    double sum = 0;
    for (size_t i = 0; i < n; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

/* ---- inputs -------------------------------------------------------------------------------- */

static ad_status run_inputs(fit *fit, ad_pool *pool, const double *at, ad_error *error)
{
    const family *f = fit->f;
    ad_tape *tape = ad_tape_create();
    ad_value coordinates[SCENE_PARAMETERS_MAX], matrix[3][3], outputs[2];
    const double *inputs[SCENE_PARAMETERS_MAX];
    groups_turn turn;
    for (int i = 0; i < f->open.parameter_count; i++) {
        coordinates[i] = ad_input(tape, f->open.parameters[i].name, 1);
        inputs[i] = at + (size_t)i * fit->members;
    }
    outputs[0] = family_inputs(f, tape, coordinates, &turn);
    family_turn_matrix(&turn, tape, matrix);
    outputs[1] = ad_stack(9, matrix[0]);
    double *to[] = {fit->inputs, fit->turn};
    const ad_run run = {
        .points = fit->members, .inputs = inputs, .outputs = to, .everywhere = true};
    const ad_status status = ad_evaluate(2, outputs, pool, &run, error);
    ad_tape_free(tape);
    return status;
}

/* Curvature turned to that of the members that the inputs are of. */
static void turn_back(fit *fit, const double *curvature)
{
    const size_t nodes = fit->f->nodes, members = fit->members, width = (size_t)fit->f->width;
    for (size_t k = 0; k < members; k++) {
        for (size_t i = 0; i < nodes; i++) {
            const double *from = curvature + width * (k * nodes + i);
            for (size_t j = 0; j < 3; j++) {
                double sum = 0;
                for (size_t c = 0; c < 3; c++) {
                    sum += fit->turn[(3 * c + j) * members + k] * from[c];
                }
                fit->u[(width * k + j) * nodes + i] = sum * fit->f->length;
            }
            for (size_t j = 3; j < width; j++) {
                fit->u[(width * k + j) * nodes + i] = from[j] * fit->f->length;
            }
        }
    }
}

/* ---- the affine part ----------------------------------------------------------------------- */

static void design(const fit *fit, size_t member, double *row)
{
    row[0] = 1;
    for (int i = 0; i < fit->f->inputs; i++) {
        row[1 + i] = fit->inputs[(size_t)i * fit->members + member];
    }
}

/* Least squares over all members; u becomes what is left. */
static bool fit_affine(fit *fit)
{
    family *f = fit->f;
    const size_t n = (size_t)f->inputs + 1, rows = (size_t)f->rows;
    double gram[(NN_INPUTS_MAX + 1) * (NN_INPUTS_MAX + 1)] = {0}, row[NN_INPUTS_MAX + 1];
    memset(f->affine, 0, rows * n * sizeof *f->affine);
    for (size_t k = 0; k < fit->members; k++) {
        const double *u = fit->u + k * rows;
        design(fit, k, row);
        for (size_t i = 0; i < n; i++) {
            for (size_t j = i; j < n; j++) {
                gram[i * n + j] += row[i] * row[j];
            }
            for (size_t j = 0; j < rows; j++) {
                f->affine[j * n + i] += u[j] * row[i];
            }
        }
    }
    for (size_t i = 0; i < n; i++) { /* inputs that depend on one another share */
        gram[i * n + i] += 1e-9 * (double)fit->members;
    }
    if (!factor(n, gram)) {
        return false;
    }
    for (size_t j = 0; j < rows; j++) {
        solve_lower(n, gram, f->affine + j * n, 1);
        solve_upper(n, gram, f->affine + j * n, 1);
    }
    return true;
}

static void leave_rest(fit *fit)
{
    const family *f = fit->f;
    const size_t n = (size_t)f->inputs + 1, rows = (size_t)f->rows;
    double row[NN_INPUTS_MAX + 1];
    for (size_t k = 0; k < fit->members; k++) {
        double *u = fit->u + k * rows;
        design(fit, k, row);
        for (size_t j = 0; j < rows; j++) {
            u[j] -= dot(n, f->affine + j * n, row);
        }
    }
}

/* ---- the metric ---------------------------------------------------------------------------- */

/* R exp(h u^), by columns. */
static void turn_on(double R[3][3], const double u[3], double h)
{
    const double w[3] = {h * u[0], h * u[1], h * u[2]};
    const double angle = sqrt(vector_dot(w, w)), c = angle > 1e-6 ? sin(angle) / angle : 1;
    const double d = angle > 1e-6 ? (1 - cos(angle)) / (angle * angle) : 0.5;
    for (int i = 0; i < 3; i++) {
        const double a[3] = {R[i][0], R[i][1], R[i][2]}; /* a exp(w^): Rodrigues */
        double b[3], e[3];
        vector_cross(a, w, b);
        vector_cross(b, w, e);
        for (int j = 0; j < 3; j++) {
            R[i][j] = a[j] + c * b[j] + d * e[j];
        }
    }
}

/* Widths [nodes] of the parts of the rod for which places stand. */
static double width(const family *f, size_t i)
{
    const double low = i > 0 ? 0.5 * (f->places[i - 1] + f->places[i]) : 0;
    return (i + 1 < f->nodes ? 0.5 * (f->places[i] + f->places[i + 1]) : 1) - low;
}

/* R [nodes][3][3] and r [nodes][3] by curvature u [3][nodes], without shear and stretch. */
static void shape(const family *f, const double *u, double (*R)[3][3], double (*r)[3])
{
    double now[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, at[3] = {0, 0, 0};
    for (size_t i = 0; i < f->nodes; i++) {
        const double h = width(f, i) / 2, own[3] = {u[i], u[f->nodes + i], u[2 * f->nodes + i]};
        for (int half = 0; half < 2; half++) {
            for (int c = 0; c < 3; c++) {
                at[c] += h * (half ? R[i][c][2] : now[c][2]);
            }
            turn_on(now, own, h);
            if (half == 0) {
                memcpy(R[i], now, sizeof now);
                memcpy(r[i], at, sizeof at);
            }
        }
    }
}

/* Adds to the metric, upper triangle: J^T J, J [3 nodes][rows] the change of positions, times the
 * root of the widths: a change du at b moves a by width_b R_b du x (r_a - r_b). */
static void add_metric(fit *fit, const double *u, double (*R)[3][3], double (*r)[3])
{
    const family *f = fit->f;
    const size_t nodes = f->nodes, rows = (size_t)f->rows;
    double *J = fit->work;
    memset(J, 0, 3 * nodes * rows * sizeof *J);
    shape(f, u, R, r);
    for (size_t a = 0; a < nodes; a++) {
        const double root = sqrt(width(f, a));
        for (size_t b = 0; b < a; b++) {
            const double size = root * width(f, b);
            const double d[3] = {r[a][0] - r[b][0], r[a][1] - r[b][1], r[a][2] - r[b][2]};
            for (size_t j = 0; j < 3; j++) {
                for (size_t c = 0; c < 3; c++) {
                    const size_t p = (c + 1) % 3, q = (c + 2) % 3;
                    J[(3 * a + c) * rows + j * nodes + b] =
                        size * (R[b][p][j] * d[q] - R[b][q][j] * d[p]);
                }
            }
        }
    }
    for (size_t k = 0; k < 3 * nodes; k++) {
        const double *row = J + k * rows;
        for (size_t i = 0; i < rows; i++) {
            for (size_t j = i; row[i] != 0 && j < rows; j++) {
                fit->metric[i * rows + j] += row[i] * row[j];
            }
        }
    }
}

/* The torsion of a tube counts as the bending that the same moment makes. */
static void count_torsions(fit *fit)
{
    const size_t nodes = fit->f->nodes, rows = (size_t)fit->f->rows;
    for (size_t first = 3 * nodes; first < rows; first += nodes) {
        for (size_t i = 0; i < nodes; i++) {
            memcpy(fit->metric + (first + i) * rows + first, fit->metric + i * rows,
                   nodes * sizeof *fit->metric);
        }
    }
}

/* Before leave_rest: of whole shapes. */
static bool make_metric(fit *fit)
{
    const family *f = fit->f;
    const size_t rows = (size_t)f->rows, nodes = f->nodes;
    const size_t count = fit->members < METRIC_MEMBERS ? fit->members : METRIC_MEMBERS;
    double(*R)[3][3] = malloc(nodes * sizeof *R), (*r)[3] = malloc(nodes * sizeof *r), trace = 0;
    if (R && r) {
        for (size_t k = 0; k < count; k++) {
            add_metric(fit, fit->u + k * rows, R, r);
        }
    }
    count_torsions(fit);
    for (size_t i = 0; i < rows * rows; i++) {
        fit->metric[i] /= (double)count;
    }
    for (size_t i = 0; i < rows; i++) {
        trace += fit->metric[i * rows + i];
    }
    for (size_t i = 0; i < rows; i++) {
        fit->metric[i * rows + i] += RIDGE * trace / (double)rows;
    }
    const bool made = R && r && factor(rows, fit->metric);
    free(R);
    free(r);
    return made;
}

/* ---- modes --------------------------------------------------------------------------------- */

/* u becomes W u, W the factor of the metric, and the spread of it is summed up. */
static void sum_spread(fit *fit)
{
    const size_t rows = (size_t)fit->f->rows;
    for (size_t k = 0; k < fit->members; k++) {
        double *u = fit->u + k * rows;
        for (size_t i = 0; i < rows; i++) {
            u[i] = dot(rows - i, fit->metric + i * rows + i, u + i);
        }
        for (size_t i = 0; i < rows; i++) {
            for (size_t j = 0; j < rows; j++) {
                fit->spread[i * rows + j] += u[i] * u[j] / (double)fit->members;
            }
        }
    }
}

/* Rows of basis become orthonormal, in turn; one that depends on those before is 0. */
static void orthonormalise(size_t count, size_t n, double *basis)
{
    for (size_t i = 0; i < count; i++) {
        double *row = basis + i * n;
        const double before = sqrt(dot(n, row, row));
        for (size_t again = 0; again < 2; again++) {
            for (size_t k = 0; k < i; k++) {
                const double part = dot(n, basis + k * n, row);
                for (size_t j = 0; j < n; j++) {
                    row[j] -= part * basis[k * n + j];
                }
            }
        }
        const double size = sqrt(dot(n, row, row));
        for (size_t j = 0; j < n; j++) {
            row[j] = size > 1e-14 * before ? row[j] / size : 0;
        }
    }
}

/* Eigenvectors of the spread by orthogonal iteration, the largest first. */
static void find_basis(fit *fit)
{
    const size_t rows = (size_t)fit->f->rows, modes = (size_t)fit->f->modes;
    nn_rng rng = nn_rng_seed(1);
    for (size_t i = 0; i < modes * rows; i++) {
        fit->basis[i] = nn_rng_normal(&rng);
    }
    orthonormalise(modes, rows, fit->basis);
    for (int k = 0; k < ITERATIONS; k++) {
        for (size_t m = 0; m < modes; m++) {
            double *row = fit->basis + m * rows;
            for (size_t i = 0; i < rows; i++) {
                fit->work[i] = dot(rows, fit->spread + i * rows, row);
            }
            memcpy(row, fit->work, rows * sizeof *row);
        }
        orthonormalise(modes, rows, fit->basis);
    }
}

/* project = Q^T W, shapes = W^-1 Q, and the sizes of the modes. */
static void make_modes(fit *fit)
{
    family *f = fit->f;
    const size_t rows = (size_t)f->rows, modes = (size_t)f->modes;
    double all = 0, kept = 0;
    for (size_t i = 0; i < rows; i++) {
        all += fit->spread[i * rows + i];
    }
    for (size_t m = 0; m < modes; m++) {
        const double *q = fit->basis + m * rows;
        double square = 0;
        for (size_t i = 0; i < rows; i++) {
            square += q[i] * dot(rows, fit->spread + i * rows, q);
            f->shapes[i * modes + m] = q[i];
            f->project[m * rows + i] = 0;
        }
        for (size_t i = 0; i < rows; i++) {
            for (size_t j = i; j < rows; j++) {
                f->project[m * rows + j] += q[i] * fit->metric[i * rows + j];
            }
        }
        solve_upper(rows, fit->metric, f->shapes + m, modes);
        f->scale[m] = sqrt(fmax(0, square));
        f->scale[m] = f->scale[m] > LEAST_SCALE * f->scale[0] ? f->scale[m] : 0;
        kept += square;
    }
    f->spread = sqrt(fmax(0, kept));
    f->missed = sqrt(fmax(0, all - kept));
}

/* ---- all of it ----------------------------------------------------------------------------- */

static bool make_room(fit *fit)
{
    const size_t rows = (size_t)fit->f->rows;
    AD_TAKE(fit, inputs, (size_t)fit->f->inputs * fit->members);
    AD_TAKE(fit, turn, 9 * fit->members);
    AD_TAKE(fit, u, fit->members * rows);
    AD_TAKE(fit, metric, rows * rows);
    AD_TAKE(fit, spread, rows * rows);
    AD_TAKE(fit, basis, (size_t)fit->f->modes * rows);
    AD_TAKE(fit, work, rows * rows);
    return !fit->memory.is_short;
}

ad_status family_fit(family *f, ad_pool *pool, size_t members, const double *x,
                     const double *curvature, ad_error *error)
{
    fit at = {.f = f, .members = members};
    ad_status status = members > (size_t)f->inputs
                           ? AD_OK
                           : ad_fail(error, AD_BAD_INPUT,
                                     "%zu members to find modes from; allowed: more than the %d "
                                     "inputs of the network",
                                     members, f->inputs);
    if (status == AD_OK && !make_room(&at)) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for the modes of a family");
    }
    status = status == AD_OK ? run_inputs(&at, pool, x, error) : status;
    if (status == AD_OK) {
        turn_back(&at, curvature);
        bool sound = fit_affine(&at) && make_metric(&at);
        if (sound) {
            leave_rest(&at);
            sum_spread(&at);
            find_basis(&at);
            make_modes(&at);
        } else {
            status = ad_fail(error, AD_NOT_FINITE, "modes of a family: members are not finite");
        }
    }
    ad_memory_free(&at.memory);
    return status;
}
