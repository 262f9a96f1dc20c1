/* Shapes of curvatures by the strain form on the tape (physics/rod/strain.h). Forces that depend on
 * the position, those of a held end, and tensions of tendons whose length is given are sought with
 * the curvature, and follow from it. */
#include "tools/emit/export_shapes.h"

#include "autodiff/memory.h"
#include "physics/local/complement.h"
#include "physics/numerics/gauss.h"
#include "physics/rod/strain.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct finder {
    size_t forces, held, unknowns, count; /* sought before the curvature, after it; all */
    size_t tubes, curved;                 /* the first of the curvature, after torsions */
    size_t tensions;                      /* of the held, the last */
    double arm[SCENE_TENDONS_MAX];        /* of their tendons (strain_arms) */
    size_t columns, rows;                 /* of a shape */
    double length;
    ad_program *residual;      /* its derivatives along a direction */
    ad_program *left, *values; /* the residual, the shape */
    size_t members;
    /* By members: [unknowns][members], [count][members]; by directions, of which a member has
     * `held`: the same with them, and [rows]. */
    double *curvature, *parameters, *by_curvature, *results;
    double *holding; /* [members][held][3 nodes + tensions]: what holds an end does */
    double *fit;     /* [held + 1][3 nodes + tensions], the same of one, and the residual */
    ad_memory memory;
} finder;

static void clear(finder *x)
{
    ad_program_free(x->residual);
    ad_program_free(x->left);
    ad_program_free(x->values);
    ad_memory_free(&x->memory);
}

/* ---- recording ----------------------------------------------------------------------------- */

static ad_status compile(ad_value of, ad_pool *pool, ad_program **program, ad_error *error)
{
    const ad_settings settings = ad_settings_default();
    const ad_status status = ad_tape_status(of.tape, error);
    return status == AD_OK ? ad_compile(1, &of, &settings, pool, program, error) : status;
}

static ad_status record(finder *x, ad_tape *tape, const strain_settings *settings,
                        const export_shapes *asked, ad_error *error)
{
    const int n = (int)x->unknowns, m = (int)x->count, points = (int)asked->points;
    int which[STRAIN_COLUMNS_MAX];
    ad_pool *pool = asked->pool;
    ad_value each[SCENE_PARAMETERS_MAX];
    strain_rod *rod = NULL;
    const ad_value at = ad_input(tape, "s", 1); /* the order is that of run */
    const ad_value curvature = ad_input_member(tape, "curvature", n);
    const ad_value parameters = ad_input_member(tape, "parameters", m);
    const ad_value along = ad_input(tape, "by curvature", n);
    for (int i = 0; i < settings->count; i++) {
        each[i] = ad_row(parameters, i);
    }
    for (int i = 0; i < (int)x->columns; i++) {
        which[i] = i;
    }
    ad_status status = strain_rod_create(settings, at, each, &rod, error);
    if (status == AD_OK) {
        const ad_value state = strain_rod_state(rod, curvature);
        const ad_value residual = strain_rod_residual(rod, curvature, state);
        ad_value by = residual;
        if (x->held > 0) {
            ad_directional(1, &residual, 1, &curvature, &along, &by); /* errors stay on the tape */
            status = compile(by, pool, &x->residual, error);
        }
        if (status == AD_OK && x->forces + x->held > 0) {
            status = compile(residual, pool, &x->left, error);
        }
        if (status == AD_OK) {
            const ad_value shape =
                strain_rod_columns(rod, curvature, state, points, asked->s, (int)x->columns, which);
            status = compile(shape, pool, &x->values, error);
        }
    }
    strain_rod_free(rod);
    return status;
}

static ad_status allocate(finder *x, ad_error *error)
{
    const size_t n = x->unknowns, all = x->members * (x->held + 1);
    const size_t most = x->rows > n ? x->rows : n;
    AD_TAKE(x, curvature, x->members * n);
    AD_TAKE(x, parameters, x->members * x->count);
    AD_TAKE(x, by_curvature, all * n);
    AD_TAKE(x, results, all * most);
    AD_TAKE(x, holding, all * n);
    AD_TAKE(x, fit, (x->held + 1) * n);
    return ad_memory_status(&x->memory, error, "out of memory for shapes of a family");
}

/* The tape is that of the middle member's scales. */
static ad_status create(finder *x, const export_shapes *asked, ad_error *error)
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
    *x = (finder){.forces = (size_t)strain_forces(open, (int)nodes),
                  .held = (size_t)strain_held(open),
                  .tubes = (size_t)open->tube_count,
                  .tensions = (size_t)strain_tensions(open),
                  .count = (size_t)settings.count,
                  .columns = (size_t)strain_columns(open),
                  .rows = (size_t)strain_columns(open) * asked->points,
                  .members = asked->members,
                  .length = scene_length(&one)};
    x->curved = x->forces + (size_t)strain_twisting(open, (int)nodes);
    x->unknowns = x->curved + 3 * nodes + x->held;
    strain_arms(&one, x->arm);
    ad_status status = record(x, tape, &settings, asked, error);
    ad_tape_free(tape);
    return status == AD_OK ? allocate(x, error) : status;
}

/* ---- running ------------------------------------------------------------------------------- */

static ad_status run(const finder *x, ad_program *program, size_t members, size_t directions,
                     ad_error *error)
{
    const double *const inputs[] = {NULL, x->curvature, x->parameters, x->by_curvature};
    double *const outputs[] = {x->results};
    const ad_run all = {
        .points = members * directions, .inputs = inputs, .outputs = outputs, .members = members};
    return ad_execute(program, &all, error);
}

/* By how much a tendon is shorter than it may be, by what its tension takes away as it bends the
 * rod. */
static double shorter(const finder *x, size_t members, size_t member, size_t k)
{
    const size_t row = x->unknowns - x->tensions + k;
    return x->results[row * members + member] / (x->arm[k] * x->arm[k]);
}

/* What each number that holds an end, and each tension, does to the equations of the curvature and
 * to the lengths of tendons, into `holding`. */
static ad_status find_holding(finder *x, size_t members, ad_error *error)
{
    const size_t held = x->held, n = x->unknowns, bent = n - x->curved - held, all = members * held;
    const size_t rows = bent + x->tensions;
    memset(x->by_curvature, 0, all * n * sizeof *x->by_curvature);
    for (size_t i = 0; i < all; i++) {
        x->by_curvature[(n - held + i % held) * all + i] = 1;
    }
    const ad_status status = run(x, x->residual, members, held, error);
    for (size_t i = 0; i < all && status == AD_OK; i++) {
        double *to = x->holding + i * rows;
        for (size_t k = 0; k < bent; k++) {
            to[k] = x->results[(x->curved + k) * all + i];
        }
        for (size_t k = 0; k < x->tensions; k++) {
            to[bent + k] = shorter(x, all, i, k);
        }
    }
    return status;
}

/* Those with which these equations are met best, at the residual in `results`, but for lengths of
 * tendons that are slack; the largest change. */
static double hold(finder *x, size_t members)
{
    const size_t held = x->held, first = x->unknowns - held, bent = first - x->curved;
    const size_t rows = bent + x->tensions, open = held - x->tensions;
    double most = 0;
    for (size_t i = 0; i < members && held > 0; i++) {
        double now[COMPLEMENT_MAX], *columns = x->fit;
        memcpy(columns, x->holding + i * held * rows, held * rows * sizeof *columns);
        for (size_t k = 0; k < bent; k++) {
            columns[held * rows + k] = x->results[(x->curved + k) * members + i];
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
        solve_complement_fit((int)rows, (int)held, (int)open, 1, columns, now);
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
static ad_status find_forces(finder *x, size_t members, ad_error *error)
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
    return status;
}

static ad_status find(finder *x, const export_shapes *asked, double *values, ad_error *error)
{
    const size_t members = asked->members, points = asked->points;
    const size_t nodes = (size_t)strain_mesh_nodes(asked->mesh), width = 3 + x->tubes;
    double start[STRAIN_STAGES_MAX]; /* what points of the first element say of s = 0 */
    const gauss_rule rule = solve_gauss_rule_of(asked->mesh->stages);
    gauss_lagrange(&rule, 0, start);
    for (size_t i = 0; i < members; i++) {
        for (size_t k = 0; k < width * nodes; k++) { /* torsions [nodes] first, and [3][nodes] */
            x->curvature[(x->forces + x->tubes + k) * members + i] =
                x->length *
                asked->curvature[(i * nodes + k % nodes) * width + (k / nodes + 3) % width];
        }
        for (size_t k = 0; k < x->tubes; k++) {
            double *base = &x->curvature[(x->forces + k) * members + i],
                   *from = base + (x->tubes - k + k * nodes) * members;
            *base = 0;
            for (int j = 0; j < asked->mesh->stages; j++) {
                *base += start[j] * from[(size_t)j * members];
            }
        }
        for (size_t k = 0; k < x->count; k++) {
            x->parameters[k * members + i] = asked->parameters[i * x->count + k];
        }
    }
    ad_status status = find_forces(x, members, error);
    status = status == AD_OK ? run(x, x->values, members, 1, error) : status;
    for (size_t i = 0; i < members * x->rows && status == AD_OK; i++) { /* of [columns][points] */
        const size_t row = i % x->rows;
        values[i] =
            x->results[(row % x->columns * points + row / x->columns) * members + i / x->rows];
    }
    return status;
}

ad_status export_shapes_find(const export_shapes *asked, double *values, ad_error *error)
{
    finder x = {.members = 0};
    ad_status status = create(&x, asked, error);
    status = status == AD_OK ? find(&x, asked, values, error) : status;
    clear(&x);
    return status;
}
