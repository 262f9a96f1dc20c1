/* Derivatives of equilibria by the parameters of their family, from the strain form on the tape
 * (physics/rod/strain.h): with the residual F(u, p) of the curvature u and the shape G(u, p),
 *
 *   dG/dp = G_p - G_u F_u^-1 F_p                                   (implicit function theorem)
 *
 * Forces that depend on the position, those of a held end, and tensions of tendons whose length is
 * given are sought with u, and follow from it. */
#include "tools/emit/export_jacobian.h"

#include "autodiff/dense.h"
#include "physics/local/complement.h"
#include "physics/rod/strain.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Tensions, by EI/L^2, that are none: of a tendon that is slack, or just as long as it may be. */
static const double SLACK = 1e-7;

typedef struct export_jacobian {
    size_t forces, held, unknowns, count; /* sought before the curvature, after it; all */
    size_t tensions;                      /* of the held, the last */
    double arm[SCENE_TENDONS_MAX];        /* of their tendons (strain_arms) */
    size_t rows;                          /* of a shape */
    double length;
    ad_program *residual, *shape; /* derivatives along a direction */
    ad_program *left, *values;    /* the residual, the shape */
    size_t members;
    /* By members: [unknowns][members], [count][members]; by directions, of which a member has
     * unknowns + count: the same with them, and [rows]. */
    double *curvature, *parameters, *by_curvature, *by_parameter, *results;
    double *matrix, *right; /* [unknowns][unknowns], [count][unknowns] of a member */
    double *holding;        /* [members][held][3 nodes + tensions]: what holds an end does */
    double *fit;            /* [held + 1][3 nodes + tensions], the same of one, and the residual */
    bool *slack;            /* [members][tensions] */
    int *pivots;
} export_jacobian;

static void clear(export_jacobian *jacobian)
{
    ad_program_free(jacobian->residual);
    ad_program_free(jacobian->shape);
    ad_program_free(jacobian->left);
    ad_program_free(jacobian->values);
    free(jacobian->curvature);
    free(jacobian->parameters);
    free(jacobian->by_curvature);
    free(jacobian->by_parameter);
    free(jacobian->results);
    free(jacobian->matrix);
    free(jacobian->right);
    free(jacobian->holding);
    free(jacobian->fit);
    free(jacobian->slack);
    free(jacobian->pivots);
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

static ad_status record(export_jacobian *jacobian, ad_tape *tape, const strain_settings *settings,
                        const export_shapes *asked, ad_error *error)
{
    const int n = (int)jacobian->unknowns, m = (int)jacobian->count, points = (int)asked->points;
    int which[STRAIN_COLUMNS];
    ad_pool *pool = asked->pool;
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
    for (int i = 0; i < STRAIN_COLUMNS; i++) {
        which[i] = i;
    }
    ad_status status = strain_rod_create(settings, at, each, &rod, error);
    if (status == AD_OK) {
        const ad_value state = strain_rod_state(rod, wrt[0]);
        const ad_value residual = strain_rod_residual(rod, wrt[0], state);
        status = compile(residual, wrt, along, pool, &jacobian->residual, error);
        if (status == AD_OK && jacobian->forces + jacobian->held > 0) {
            status = compile(residual, NULL, NULL, pool, &jacobian->left, error);
        }
        if (status == AD_OK) {
            const ad_value shape =
                strain_rod_columns(rod, wrt[0], state, points, asked->s, STRAIN_COLUMNS, which);
            status = compile(shape, wrt, along, pool, &jacobian->shape, error);
            status = status == AD_OK ? compile(shape, NULL, NULL, pool, &jacobian->values, error)
                                     : status;
        }
    }
    strain_rod_free(rod);
    return status;
}

static ad_status allocate(export_jacobian *jacobian, ad_error *error)
{
    const size_t n = jacobian->unknowns, m = jacobian->count, directions = n + m;
    const size_t all = jacobian->members * directions,
                 most = jacobian->rows > n ? jacobian->rows : n;
    jacobian->curvature = malloc(jacobian->members * n * sizeof *jacobian->curvature);
    jacobian->parameters = malloc(jacobian->members * m * sizeof *jacobian->parameters);
    jacobian->by_curvature = malloc(all * n * sizeof *jacobian->by_curvature);
    jacobian->by_parameter = malloc(all * m * sizeof *jacobian->by_parameter);
    jacobian->results = malloc(all * most * sizeof *jacobian->results);
    jacobian->matrix = malloc(n * n * sizeof *jacobian->matrix);
    jacobian->right = malloc(jacobian->members * n * m * sizeof *jacobian->right);
    jacobian->holding =
        malloc(jacobian->members * (jacobian->held + 1) * n * sizeof *jacobian->holding);
    jacobian->fit = malloc((jacobian->held + 1) * n * sizeof *jacobian->fit);
    jacobian->slack =
        malloc((jacobian->members * jacobian->tensions + 1) * sizeof *jacobian->slack);
    jacobian->pivots = malloc(n * sizeof *jacobian->pivots);
    return jacobian->curvature && jacobian->parameters && jacobian->by_curvature &&
                   jacobian->by_parameter && jacobian->results && jacobian->matrix &&
                   jacobian->right && jacobian->holding && jacobian->fit && jacobian->slack &&
                   jacobian->pivots
               ? AD_OK
               : ad_fail(error, AD_NO_MEMORY, "out of memory for derivatives of a family");
}

/* The tape is that of the middle member's scales. */
static ad_status create(export_jacobian *jacobian, const export_shapes *asked, ad_error *error)
{
    const scene *open = asked->open;
    const char *names[SCENE_PARAMETERS_MAX];
    double usual[SCENE_PARAMETERS_MAX];
    const strain_settings settings = {open,  open->parameter_count, names,
                                      usual, *asked->mesh,          NULL};
    const size_t nodes = (size_t)strain_mesh_nodes(asked->mesh);
    scene one;
    ad_tape *tape = ad_tape_create();
    for (int i = 0; i < settings.count; i++) {
        names[i] = open->parameters[i].name;
        usual[i] = scene_parameter_at(&open->parameters[i], 0.5);
    }
    scene_middle(open, &one);
    *jacobian = (export_jacobian){.forces = (size_t)strain_forces(open, (int)nodes),
                                  .held = (size_t)strain_held(open),
                                  .tensions = (size_t)strain_tensions(open),
                                  .count = (size_t)settings.count,
                                  .rows = STRAIN_COLUMNS * asked->points,
                                  .members = asked->members,
                                  .length = scene_length(&one)};
    jacobian->unknowns = jacobian->forces + 3 * nodes + jacobian->held;
    strain_arms(&one, jacobian->arm);
    ad_status status = record(jacobian, tape, &settings, asked, error);
    ad_tape_free(tape);
    return status == AD_OK ? allocate(jacobian, error) : status;
}

/* ---- running ------------------------------------------------------------------------------- */

static ad_status run(const export_jacobian *jacobian, ad_program *program, size_t members,
                     size_t directions, ad_error *error)
{
    const double *const inputs[] = {NULL, jacobian->curvature, jacobian->parameters,
                                    jacobian->by_curvature, jacobian->by_parameter};
    double *const outputs[] = {jacobian->results};
    const ad_run all = {
        .points = members * directions, .inputs = inputs, .outputs = outputs, .members = members};
    return ad_execute(program, &all, error);
}

/* Each unknown and each parameter by itself. */
static void set_units(export_jacobian *jacobian, size_t members)
{
    const size_t n = jacobian->unknowns, m = jacobian->count, all = members * (n + m);
    memset(jacobian->by_curvature, 0, all * n * sizeof *jacobian->by_curvature);
    memset(jacobian->by_parameter, 0, all * m * sizeof *jacobian->by_parameter);
    for (size_t i = 0; i < members; i++) {
        const size_t first = i * (n + m);
        for (size_t k = 0; k < n; k++) {
            jacobian->by_curvature[k * all + first + k] = 1;
        }
        for (size_t k = 0; k < m; k++) {
            jacobian->by_parameter[k * all + first + n + k] = 1;
        }
    }
}

/* The equations of tendons that are slack: no tension, in place of a length. */
static void let_go(export_jacobian *jacobian, size_t member)
{
    const size_t n = jacobian->unknowns, first = n - jacobian->tensions;
    for (size_t k = 0; k < jacobian->tensions; k++) {
        if (jacobian->slack[member * jacobian->tensions + k]) {
            for (size_t i = 0; i < n; i++) {
                jacobian->matrix[i * n + first + k] = i == first + k;
            }
            for (size_t i = 0; i < jacobian->count; i++) {
                jacobian->right[(member * jacobian->count + i) * n + first + k] = 0;
            }
        }
    }
}

/* du/dp into `right` [count][unknowns] of a member; not numbers where F_u is singular. */
static void solve(export_jacobian *jacobian, size_t members, size_t member)
{
    const size_t n = jacobian->unknowns, m = jacobian->count, all = members * (n + m),
                 first = member * (n + m);
    double *right = jacobian->right + member * n * m;
    for (size_t row = 0; row < n; row++) {
        const double *of = jacobian->results + row * all + first;
        for (size_t k = 0; k < n; k++) {
            jacobian->matrix[k * n + row] = of[k];
        }
        for (size_t k = 0; k < m; k++) {
            right[k * n + row] = -of[n + k];
        }
    }
    let_go(jacobian, member);
    if (ad_dense_lu(n, jacobian->matrix, jacobian->pivots) == 0) {
        ad_dense_lu_solve(n, m, jacobian->matrix, jacobian->pivots, right);
    } else {
        for (size_t i = 0; i < n * m; i++) {
            right[i] = NAN;
        }
    }
}

/* The directions in which members move when a parameter does. */
static void set_changes(export_jacobian *jacobian, size_t members)
{
    const size_t n = jacobian->unknowns, m = jacobian->count, all = members * m;
    memset(jacobian->by_parameter, 0, all * m * sizeof *jacobian->by_parameter);
    for (size_t k = 0; k < all; k++) { /* member and parameter */
        jacobian->by_parameter[k % m * all + k] = 1;
        for (size_t row = 0; row < n; row++) {
            jacobian->by_curvature[row * all + k] = jacobian->right[k * n + row];
        }
    }
}

/* By how much a tendon is shorter than it may be, by what its tension takes away as it bends the
 * rod. */
static double shorter(const export_jacobian *jacobian, size_t members, size_t member, size_t k)
{
    const size_t row = jacobian->unknowns - jacobian->tensions + k;
    return jacobian->results[row * members + member] / (jacobian->arm[k] * jacobian->arm[k]);
}

/* What each number that holds an end, and each tension, does to the equations of the curvature and
 * to the lengths of tendons, into `holding`. */
static ad_status find_holding(export_jacobian *jacobian, size_t members, ad_error *error)
{
    const size_t held = jacobian->held, n = jacobian->unknowns, bent = n - jacobian->forces - held,
                 all = members * held;
    const size_t rows = bent + jacobian->tensions;
    memset(jacobian->by_curvature, 0, all * n * sizeof *jacobian->by_curvature);
    memset(jacobian->by_parameter, 0, all * jacobian->count * sizeof *jacobian->by_parameter);
    for (size_t i = 0; i < all; i++) {
        jacobian->by_curvature[(n - held + i % held) * all + i] = 1;
    }
    const ad_status status = run(jacobian, jacobian->residual, members, held, error);
    for (size_t i = 0; i < all && status == AD_OK; i++) {
        double *to = jacobian->holding + i * rows;
        for (size_t k = 0; k < bent; k++) {
            to[k] = jacobian->results[(jacobian->forces + k) * all + i];
        }
        for (size_t k = 0; k < jacobian->tensions; k++) {
            to[bent + k] = shorter(jacobian, all, i, k);
        }
    }
    return status;
}

/* Those with which these equations are met best, at the residual in `results`, but for lengths of
 * tendons that are slack; the largest change. */
static double hold(export_jacobian *jacobian, size_t members)
{
    const size_t held = jacobian->held, first = jacobian->unknowns - held,
                 bent = first - jacobian->forces;
    const size_t rows = bent + jacobian->tensions, open = held - jacobian->tensions;
    double most = 0;
    for (size_t i = 0; i < members && held > 0; i++) {
        double now[COMPLEMENT_MAX], *columns = jacobian->fit;
        memcpy(columns, jacobian->holding + i * held * rows, held * rows * sizeof *columns);
        for (size_t k = 0; k < bent; k++) {
            columns[held * rows + k] = jacobian->results[(jacobian->forces + k) * members + i];
        }
        for (size_t c = 0; c < held; c++) {
            now[c] = jacobian->curvature[(first + c) * members + i];
        }
        for (size_t k = 0; k < jacobian->tensions; k++) {
            columns[held * rows + bent + k] = shorter(jacobian, members, i, k);
            const bool slack = columns[held * rows + bent + k] > now[open + k];
            for (size_t c = 0; c <= held && slack; c++) {
                columns[c * rows + bent + k] = 0;
            }
        }
        solve_complement_fit((int)rows, (int)held, (int)open, 1, columns, now);
        for (size_t c = 0; c < held; c++) {
            double *number = &jacobian->curvature[(first + c) * members + i];
            most = fmax(most, fabs(now[c] - *number));
            *number = now[c];
        }
    }
    return most;
}

/* Forces of the given curvature: the shape has them but for the stretch by them, which is small:
 * each pass leaves that share of what was missing. */
static ad_status find_forces(export_jacobian *jacobian, size_t members, ad_error *error)
{
    enum { PASSES = 30 };
    const size_t count = jacobian->forces * members, held = jacobian->held * members;
    double most = count + held > 0;
    ad_status status = AD_OK;
    memset(jacobian->curvature, 0, count * sizeof *jacobian->curvature);
    memset(jacobian->curvature + jacobian->unknowns * members - held, 0,
           held * sizeof *jacobian->curvature);
    status = held > 0 ? find_holding(jacobian, members, error) : AD_OK;
    for (int k = 0; k < PASSES && most > 1e-13 && status == AD_OK; k++) {
        status = run(jacobian, jacobian->left, members, 1, error);
        most = status == AD_OK ? hold(jacobian, members) : 0;
        for (size_t i = 0; i < count && status == AD_OK; i++) {
            jacobian->curvature[i] -= jacobian->results[i];
            most = fmax(most, fabs(jacobian->results[i]));
        }
    }
    if (status == AD_OK && jacobian->tensions > 0) {
        status = run(jacobian, jacobian->left, members, 1, error);
    }
    for (size_t i = 0; i < members * jacobian->tensions && status == AD_OK; i++) {
        const size_t k = i % jacobian->tensions, member = i / jacobian->tensions;
        const double pull =
            jacobian->curvature[(jacobian->unknowns - jacobian->tensions + k) * members + member];
        jacobian->slack[i] = shorter(jacobian, members, member, k) > pull - SLACK;
    }
    return status;
}

/* Where the results of a program, [columns][points][members][each], have row [points][columns] of a
 * member's shape. */
static double *result_of(const export_jacobian *jacobian, size_t members, size_t each,
                         size_t member, size_t row)
{
    const size_t columns = STRAIN_COLUMNS, points = jacobian->rows / columns;
    return jacobian->results + ((row % columns * points + row / columns) * members + member) * each;
}

static ad_status find(export_jacobian *derivatives, const export_shapes *asked, double *values,
                      double *jacobian, ad_error *error)
{
    const size_t n = derivatives->unknowns, m = derivatives->count, members = asked->members,
                 bent = n - derivatives->forces - derivatives->held, rows = derivatives->rows;
    const size_t nodes = bent / 3; /* the tape has [3][nodes] */
    for (size_t i = 0; i < members; i++) {
        for (size_t k = 0; k < bent; k++) {
            derivatives->curvature[(derivatives->forces + k) * members + i] =
                derivatives->length * asked->curvature[i * bent + k % nodes * 3 + k / nodes];
        }
        for (size_t k = 0; k < m; k++) {
            derivatives->parameters[k * members + i] = asked->parameters[i * m + k];
        }
    }
    ad_status status = find_forces(derivatives, members, error);
    set_units(derivatives, members);
    status =
        status == AD_OK ? run(derivatives, derivatives->residual, members, n + m, error) : status;
    for (size_t i = 0; i < members && status == AD_OK; i++) {
        solve(derivatives, members, i);
    }
    if (status == AD_OK) {
        set_changes(derivatives, members);
        status = run(derivatives, derivatives->shape, members, m, error);
    }
    for (size_t i = 0; i < members * rows * m && status == AD_OK; i++) {
        jacobian[i] = result_of(derivatives, members, m, i / m / rows, i / m % rows)[i % m];
    }
    status = status == AD_OK ? run(derivatives, derivatives->values, members, 1, error) : status;
    for (size_t i = 0; i < members * rows && status == AD_OK; i++) {
        values[i] = *result_of(derivatives, members, 1, i / rows, i % rows);
    }
    return status;
}

ad_status export_shapes_find(const export_shapes *asked, double *values, double *jacobian,
                             ad_error *error)
{
    export_jacobian x = {.members = 0};
    ad_status status = create(&x, asked, error);
    status = status == AD_OK ? find(&x, asked, values, jacobian, error) : status;
    clear(&x);
    return status;
}
