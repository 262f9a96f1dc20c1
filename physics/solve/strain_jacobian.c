/* Derivatives of equilibria by the parameters of their family, from the strain form on the tape
 * (physics/strain.h): with the residual F(u, p) of the curvature u and the shape G(u, p),
 *
 *   dG/dp = G_p - G_u F_u^-1 F_p                                   (implicit function theorem)
 *
 * Forces that depend on the position, those of a held end, and tensions of tendons whose length is
 * given are sought with u, and follow from it. */
#include "physics/solve/strain_jacobian.h"

#include "autodiff/dense.h"
#include "physics/rod_internal.h"
#include "physics/solve/complement.h"
#include "physics/solve/solve_members.h"
#include "physics/solve/strain_group.h"
#include "physics/strain.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Directions at a time, of all members: enough for all threads. */
enum { DIRECTIONS = 4096 };

/* Tensions, by EI/L^2, that are none: of a tendon that is slack, or just as long as it may be. */
static const double SLACK = 1e-7;

struct strain_jacobian {
    size_t forces, held, unknowns, count; /* sought before the curvature, after it; all */
    size_t tensions;                      /* of the held, the last */
    double arm[SCENE_TENDONS_MAX];        /* of their tendons (rod_tendon_arm) */
    size_t rows;                          /* of a shape */
    int columns;
    double length;
    ad_program *residual, *shape; /* derivatives along a direction */
    ad_program *left, *values;    /* the residual, the shape */
    size_t chunk;                 /* members at a time */
    /* By members: [unknowns][chunk], [count][chunk]; by directions, of which a member has
     * unknowns + count: the same with them, and [rows]. */
    double *curvature, *parameters, *by_curvature, *by_parameter, *results;
    double *matrix, *right; /* [unknowns][unknowns], [count][unknowns] of a member */
    double *holding;        /* [chunk][held][3 nodes + tensions]: what holds an end does */
    double *fit;            /* [held + 1][3 nodes + tensions], the same of one, and the residual */
    bool *slack;            /* [chunk][tensions] */
    int *pivots;
};

void strain_jacobian_free(strain_jacobian *x)
{
    if (x) {
        ad_program_free(x->residual);
        ad_program_free(x->shape);
        ad_program_free(x->left);
        ad_program_free(x->values);
        free(x->curvature);
        free(x->parameters);
        free(x->by_curvature);
        free(x->by_parameter);
        free(x->results);
        free(x->matrix);
        free(x->right);
        free(x->holding);
        free(x->fit);
        free(x->slack);
        free(x->pivots);
        free(x);
    }
}

/* ---- recording ----------------------------------------------------------------------------- */

static ad_status compile(ad_value of, const ad_value wrt[2], const ad_value along[2], ad_pool *pool,
                         ad_program **program, ad_error *error)
{
    const ad_settings settings = ad_settings_default();
    if (wrt) {
        ad_directional(1, &of, 2, wrt, along, &of); /* its errors stay on the tape */
    }
    ad_status status = ad_tape_status(of.tape, error);
    return status == AD_OK ? ad_compile(1, &of, &settings, pool, program, error) : status;
}

static ad_status record(strain_jacobian *x, ad_tape *tape, const strain_settings *settings,
                        const double *s, const int *which, ad_pool *pool, ad_error *error)
{
    const int n = (int)x->unknowns, m = (int)x->count, points = (int)x->rows / x->columns;
    ad_value each[SCENE_PARAMETERS_MAX], wrt[2], along[2];
    strain_rod *rod = NULL;
    const ad_value at = ad_input(tape, "s", 1); /* the order is that of run */
    wrt[0] = ad_input_member(tape, "curvature", n);
    wrt[1] = ad_input_member(tape, "parameters", m);
    along[0] = ad_input(tape, "by curvature", n);
    along[1] = ad_input(tape, "by parameters", m);
    for (int i = 0; i < settings->count; i++) {
        each[i] = ad_row(wrt[1], i);
    }
    ad_status status = strain_rod_create(settings, at, each, &rod, error);
    if (status == AD_OK) {
        const ad_value state = strain_rod_state(rod, wrt[0]);
        const ad_value residual = strain_rod_residual(rod, wrt[0], state);
        status = compile(residual, wrt, along, pool, &x->residual, error);
        if (status == AD_OK && x->forces + x->held > 0) {
            status = compile(residual, NULL, NULL, pool, &x->left, error);
        }
        if (status == AD_OK) {
            const ad_value shape =
                strain_rod_columns(rod, wrt[0], state, points, s, x->columns, which);
            status = compile(shape, wrt, along, pool, &x->shape, error);
            status = status == AD_OK ? compile(shape, NULL, NULL, pool, &x->values, error) : status;
        }
    }
    strain_rod_free(rod);
    return status;
}

static ad_status allocate(strain_jacobian *x, ad_error *error)
{
    const size_t n = x->unknowns, m = x->count, directions = n + m;
    x->chunk = DIRECTIONS / directions > 0 ? DIRECTIONS / directions : 1;
    const size_t all = x->chunk * directions, most = x->rows > n ? x->rows : n;
    x->curvature = malloc(x->chunk * n * sizeof *x->curvature);
    x->parameters = malloc(x->chunk * m * sizeof *x->parameters);
    x->by_curvature = malloc(all * n * sizeof *x->by_curvature);
    x->by_parameter = malloc(all * m * sizeof *x->by_parameter);
    x->results = malloc(all * most * sizeof *x->results);
    x->matrix = malloc(n * n * sizeof *x->matrix);
    x->right = malloc(x->chunk * n * m * sizeof *x->right);
    x->holding = malloc(x->chunk * (x->held + 1) * n * sizeof *x->holding);
    x->fit = malloc((x->held + 1) * n * sizeof *x->fit);
    x->slack = malloc((x->chunk * x->tensions + 1) * sizeof *x->slack);
    x->pivots = malloc(n * sizeof *x->pivots);
    return x->curvature && x->parameters && x->by_curvature && x->by_parameter && x->results &&
                   x->matrix && x->right && x->holding && x->fit && x->slack && x->pivots
               ? AD_OK
               : ad_fail(error, AD_NO_MEMORY, "out of memory for derivatives of a family");
}

ad_status strain_jacobian_create(const scene *open, size_t nodes, const double *places,
                                 size_t points, const double *s, int columns, const int *which,
                                 ad_pool *pool, strain_jacobian **result, ad_error *error)
{
    const char *names[SCENE_PARAMETERS_MAX];
    double usual[SCENE_PARAMETERS_MAX];
    strain_settings settings = {
        .open = open, .count = open->parameter_count, .names = names, .values = usual};
    scene one;
    *result = NULL;
    for (int i = 0; i < settings.count; i++) {
        names[i] = open->parameters[i].name;
        usual[i] = scene_parameter_at(&open->parameters[i], 0.5);
    }
    scene_middle(open, &one);
    ad_status status = strain_mesh_at(&one, (int)nodes, places, &settings.mesh, error);
    if (status != AD_OK) {
        return status;
    }
    ad_tape *tape = ad_tape_create();
    strain_jacobian *x = calloc(1, sizeof *x);
    if (!tape || !x) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for derivatives of a family");
    } else {
        x->forces = (size_t)strain_forces(open, (int)nodes);
        x->held = (size_t)strain_held(open);
        for (int i = 0; i < one.tendon_count; i++) {
            if (one.tendons[i].displacement.is_given) {
                x->arm[x->tensions++] = rod_tendon_arm(&one, i);
            }
        }
        x->unknowns = x->forces + 3 * nodes + x->held;
        x->count = (size_t)settings.count;
        x->columns = columns;
        x->rows = (size_t)columns * points;
        x->length = scene_length(&one);
        status = record(x, tape, &settings, s, which, pool, error);
    }
    status = status == AD_OK ? allocate(x, error) : status;
    ad_tape_free(tape);
    if (status != AD_OK) {
        strain_jacobian_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}

/* ---- running ------------------------------------------------------------------------------- */

static ad_status run(const strain_jacobian *x, ad_program *program, size_t members,
                     size_t directions, ad_error *error)
{
    const double *const inputs[] = {NULL, x->curvature, x->parameters, x->by_curvature,
                                    x->by_parameter};
    double *const outputs[] = {x->results};
    const ad_run all = {
        .points = members * directions, .inputs = inputs, .outputs = outputs, .members = members};
    return ad_execute(program, &all, error);
}

/* Each unknown and each parameter by itself. */
static void set_units(strain_jacobian *x, size_t members)
{
    const size_t n = x->unknowns, m = x->count, all = members * (n + m);
    memset(x->by_curvature, 0, all * n * sizeof *x->by_curvature);
    memset(x->by_parameter, 0, all * m * sizeof *x->by_parameter);
    for (size_t i = 0; i < members; i++) {
        const size_t first = i * (n + m);
        for (size_t k = 0; k < n; k++) {
            x->by_curvature[k * all + first + k] = 1;
        }
        for (size_t k = 0; k < m; k++) {
            x->by_parameter[k * all + first + n + k] = 1;
        }
    }
}

/* The equations of tendons that are slack: no tension, in place of a length. */
static void let_go(strain_jacobian *x, size_t member)
{
    const size_t n = x->unknowns, first = n - x->tensions;
    for (size_t k = 0; k < x->tensions; k++) {
        if (x->slack[member * x->tensions + k]) {
            for (size_t i = 0; i < n; i++) {
                x->matrix[i * n + first + k] = i == first + k;
            }
            for (size_t i = 0; i < x->count; i++) {
                x->right[(member * x->count + i) * n + first + k] = 0;
            }
        }
    }
}

/* du/dp into `right` [count][unknowns] of a member; not numbers where F_u is singular. */
static void solve(strain_jacobian *x, size_t members, size_t member)
{
    const size_t n = x->unknowns, m = x->count, all = members * (n + m), first = member * (n + m);
    double *right = x->right + member * n * m;
    for (size_t row = 0; row < n; row++) {
        const double *of = x->results + row * all + first;
        for (size_t k = 0; k < n; k++) {
            x->matrix[k * n + row] = of[k];
        }
        for (size_t k = 0; k < m; k++) {
            right[k * n + row] = -of[n + k];
        }
    }
    let_go(x, member);
    if (ad_dense_lu(n, x->matrix, x->pivots) == 0) {
        ad_dense_lu_solve(n, m, x->matrix, x->pivots, right);
    } else {
        for (size_t i = 0; i < n * m; i++) {
            right[i] = NAN;
        }
    }
}

/* The directions in which members move when a parameter does. */
static void set_changes(strain_jacobian *x, size_t members)
{
    const size_t n = x->unknowns, m = x->count, all = members * m;
    memset(x->by_parameter, 0, all * m * sizeof *x->by_parameter);
    for (size_t k = 0; k < all; k++) { /* member and parameter */
        x->by_parameter[k % m * all + k] = 1;
        for (size_t row = 0; row < n; row++) {
            x->by_curvature[row * all + k] = x->right[k * n + row];
        }
    }
}

/* By how much a tendon is shorter than it may be, by what its tension takes away as it bends the
 * rod. */
static double shorter(const strain_jacobian *x, size_t members, size_t member, size_t k)
{
    const size_t row = x->unknowns - x->tensions + k;
    return x->results[row * members + member] / (x->arm[k] * x->arm[k]);
}

/* What each number that holds an end, and each tension, does to the equations of the curvature and
 * to the lengths of tendons, into `holding`. */
static ad_status find_holding(strain_jacobian *x, size_t members, ad_error *error)
{
    const size_t held = x->held, n = x->unknowns, bent = n - x->forces - held, all = members * held;
    const size_t rows = bent + x->tensions;
    memset(x->by_curvature, 0, all * n * sizeof *x->by_curvature);
    memset(x->by_parameter, 0, all * x->count * sizeof *x->by_parameter);
    for (size_t i = 0; i < all; i++) {
        x->by_curvature[(n - held + i % held) * all + i] = 1;
    }
    const ad_status status = run(x, x->residual, members, held, error);
    for (size_t i = 0; i < all && status == AD_OK; i++) {
        double *to = x->holding + i * rows;
        for (size_t k = 0; k < bent; k++) {
            to[k] = x->results[(x->forces + k) * all + i];
        }
        for (size_t k = 0; k < x->tensions; k++) {
            to[bent + k] = shorter(x, all, i, k);
        }
    }
    return status;
}

/* Those with which these equations are met best, at the residual in `results`, but for lengths of
 * tendons that are slack; the largest change. */
static double hold(strain_jacobian *x, size_t members)
{
    const size_t held = x->held, first = x->unknowns - held, bent = first - x->forces;
    const size_t rows = bent + x->tensions, open = held - x->tensions;
    double most = 0;
    for (size_t i = 0; i < members && held > 0; i++) {
        double now[COMPLEMENT_MAX], *columns = x->fit;
        memcpy(columns, x->holding + i * held * rows, held * rows * sizeof *columns);
        for (size_t k = 0; k < bent; k++) {
            columns[held * rows + k] = x->results[(x->forces + k) * members + i];
        }
        for (size_t c = 0; c < held; c++) {
            now[c] = x->curvature[(first + c) * members + i];
        }
        for (size_t k = 0; k < x->tensions; k++) {
            columns[held * rows + bent + k] = shorter(x, members, i, k);
            const bool slack = columns[held * rows + bent + k] > now[open + k];
            for (size_t c = 0; c <= held && slack; c++) {
                columns[c * rows + bent + k] = 0;
            }
        }
        strain_group_fit((int)rows, (int)held, (int)open, 1, columns, now);
        for (size_t c = 0; c < held; c++) {
            double *number = &x->curvature[(first + c) * members + i];
            most = fmax(most, fabs(now[c] - *number));
            *number = now[c];
        }
    }
    return most;
}

/* Forces of the given curvature: the shape has them but for the stretch by them, which is small:
 * each pass leaves that share of what was missing. */
static ad_status find_forces(strain_jacobian *x, size_t members, ad_error *error)
{
    enum { PASSES = 30 };
    const size_t count = x->forces * members, held = x->held * members;
    double most = count + held > 0;
    ad_status status = AD_OK;
    memset(x->curvature, 0, count * sizeof *x->curvature);
    memset(x->curvature + x->unknowns * members - held, 0, held * sizeof *x->curvature);
    status = held > 0 ? find_holding(x, members, error) : AD_OK;
    for (int k = 0; k < PASSES && most > 1e-13 && status == AD_OK; k++) {
        status = run(x, x->left, members, 1, error);
        most = status == AD_OK ? hold(x, members) : 0;
        for (size_t i = 0; i < count && status == AD_OK; i++) {
            x->curvature[i] -= x->results[i];
            most = fmax(most, fabs(x->results[i]));
        }
    }
    if (status == AD_OK && x->tensions > 0) {
        status = run(x, x->left, members, 1, error);
    }
    for (size_t i = 0; i < members * x->tensions && status == AD_OK; i++) {
        const size_t k = i % x->tensions, member = i / x->tensions;
        const double pull = x->curvature[(x->unknowns - x->tensions + k) * members + member];
        x->slack[i] = shorter(x, members, member, k) > pull - SLACK;
    }
    return status;
}

/* Where the results of a program, [columns][points][members][each], have row [points][columns] of a
 * member's shape. */
static double *result_of(const strain_jacobian *x, size_t members, size_t each, size_t member,
                         size_t row)
{
    const size_t columns = (size_t)x->columns, points = x->rows / columns;
    return x->results + ((row % columns * points + row / columns) * members + member) * each;
}

static ad_status run_chunk(strain_jacobian *x, size_t members, const double *parameters,
                           const double *curvature, double *values, double *jacobian,
                           ad_error *error)
{
    const size_t n = x->unknowns, m = x->count, bent = n - x->forces - x->held;
    const size_t nodes = bent / 3; /* the tape has [3][nodes] */
    for (size_t i = 0; i < members; i++) {
        for (size_t k = 0; k < bent; k++) {
            x->curvature[(x->forces + k) * members + i] =
                x->length * curvature[i * bent + k % nodes * 3 + k / nodes];
        }
        for (size_t k = 0; k < m; k++) {
            x->parameters[k * members + i] = parameters[i * m + k];
        }
    }
    ad_status status = find_forces(x, members, error);
    set_units(x, members);
    status = status == AD_OK ? run(x, x->residual, members, n + m, error) : status;
    for (size_t i = 0; i < members && status == AD_OK; i++) {
        solve(x, members, i);
    }
    if (status == AD_OK) {
        set_changes(x, members);
        status = run(x, x->shape, members, m, error);
    }
    for (size_t i = 0; i < members * x->rows && status == AD_OK; i++) {
        const size_t member = i / x->rows;
        const double *of = result_of(x, members, m, member, i % x->rows);
        for (size_t k = 0; k < m; k++) {
            jacobian[i * m + k] = isfinite(x->right[member * n * m]) ? of[k] : NAN;
        }
    }
    if (status == AD_OK && values) {
        status = run(x, x->values, members, 1, error);
    }
    for (size_t i = 0; i < members * x->rows && status == AD_OK && values; i++) {
        values[i] = *result_of(x, members, 1, i / x->rows, i % x->rows);
    }
    return status;
}

ad_status strain_jacobian_run(strain_jacobian *x, size_t members, const double *parameters,
                              const double *curvature, double *values, double *jacobian,
                              ad_error *error)
{
    ad_status status = AD_OK;
    for (size_t first = 0; first < members && status == AD_OK; first += x->chunk) {
        const size_t left = members - first, now = left < x->chunk ? left : x->chunk;
        status = run_chunk(x, now, parameters + first * x->count,
                           curvature + first * (x->unknowns - x->forces - x->held),
                           values ? values + first * x->rows : NULL,
                           jacobian + first * x->rows * x->count, error);
    }
    return status;
}
