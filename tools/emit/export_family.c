#include "tools/emit/export_family.h"

#include "physics/model.h"
#include "physics/rod.h"
#include "tools/emit/export_text.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- what is recorded ---------------------------------------------------------------------- */

/* Functions of the C: parameters p, what is sought u, the curvature behind forces that depend on
 * the place, the state z of the rod by u, directions of these for each parameter. The state comes
 * first: it says how many numbers z has. */
enum {
    STATE,       /* p, u -> z */
    STATE_BY,    /* p, u, z, dp, du -> dz */
    NETWORK,     /* p -> curvature */
    NETWORK_BY,  /* p, dp -> du of it */
    NEWTON,      /* p, u, z -> residual, strain_blocks; with laws of the position: */
    RESIDUAL,    /* p, u, z -> residual */
    RESIDUAL_BY, /* p, u, z, dp, du, dz -> its changes */
    SHAPE,       /* p, u, z -> columns at places */
    TIP,         /* the same of the end */
    TIP_BY,      /* p, u, z, dp, du, dz -> its changes */
    SHAPE_BY,    /* and of the columns at places */
    FUNCTIONS,
    PLACES_BY = NEWTON /* p, u, z, dp, du, dz -> changes of positions at points and the end */
};

static const struct {
    const char *name;
    int inputs;  /* of p, u, z, dp, du, dz */
    bool shared; /* p, u and z are those of all points */
} functions[FUNCTIONS + 1] = {
    {"state", 2, false},  {"state_by", 5, true},  {"network", 1, false},    {"network_by", 4, true},
    {"newton", 3, false}, {"residual", 3, false}, {"residual_by", 6, true}, {"shape", 3, false},
    {"tip", 3, false},    {"tip_by", 6, true},    {"shape_by", 6, true},    {"places_by", 6, true}};

/* Where positions are asked for the matrix is made column by column, by what a direction changes.
 */
static int row_of(const export_family *x, int function)
{
    return function == PLACES_BY && x->placed ? FUNCTIONS : function;
}

/* Whether it is asked for. */
static bool is_wanted(const export_family *x, int function)
{
    return function == TIP || function == TIP_BY ? x->tip
           : function == SHAPE_BY                ? x->shape_by
                                                 : true;
}

static size_t sought_of(const export_family *x)
{
    return (size_t)(x->forces + x->held) + 3 * (size_t)strain_mesh_nodes(&x->mesh);
}

typedef struct recording {
    ad_tape *tape;
    ad_value p, u, z, dp, du, dz;
    strain_rod *rod;
} recording;

static size_t points_of(const export_family *x, int function)
{
    return functions[row_of(x, function)].shared ? (size_t)x->open->parameter_count : 1;
}

/* Inputs in the order in which the C has them. */
static ad_status begin(const export_family *x, int function, recording *r, ad_error *error)
{
    const int count = x->open->parameter_count, row = row_of(x, function);
    const int rows = (int)sought_of(x);
    const bool shared = functions[row].shared;
    ad_value each[SCENE_PARAMETERS_MAX];
    const char *names[SCENE_PARAMETERS_MAX];
    double middle[SCENE_PARAMETERS_MAX];
    *r = (recording){.tape = ad_tape_create()};
    if (!r->tape) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a tape");
    }
    const struct {
        const char *name;
        ad_value *at;
        int rows;
    } inputs[] = {{"p", &r->p, count},   {"u", &r->u, rows},   {"z", &r->z, x->state},
                  {"dp", &r->dp, count}, {"du", &r->du, rows}, {"dz", &r->dz, x->state}};
    for (int i = 0; i < functions[row].inputs; i++) {
        *inputs[i].at = shared && i < 3 ? ad_input_member(r->tape, inputs[i].name, inputs[i].rows)
                                        : ad_input(r->tape, inputs[i].name, inputs[i].rows);
    }
    for (int i = 0; i < count; i++) {
        each[i] = ad_row(r->p, i);
        names[i] = x->open->parameters[i].name;
        middle[i] = scene_parameter_at(&x->open->parameters[i], 0.5);
    }
    const strain_settings settings = {x->open, count, names, middle, x->mesh};
    return function != NETWORK && function != NETWORK_BY
               ? strain_rod_create(&settings, ad_input(r->tape, "s", 1), each, &r->rod, error)
               : AD_OK;
}

/* Coordinates of parameters, the inverse of scene_parameter_at. */
static ad_value record_network(const export_family *x, const recording *r)
{
    ad_value at[SCENE_PARAMETERS_MAX];
    for (int i = 0; i < x->open->parameter_count; i++) {
        const scene_parameter *p = &x->open->parameters[i];
        ad_value value = ad_row(r->p, i);
        at[i] = p->scale == SCENE_LOG
                    ? ad_scale(ad_log(ad_scale(value, 1 / p->low)), 1 / log(p->high / p->low))
                    : ad_scale(ad_sub(value, ad_scalar(r->tape, p->low)), 1 / (p->high - p->low));
    }
    return x->network(x->context, r->tape, at);
}

/* [columns][places] */
static ad_value record_shape(const export_family *x, const recording *r, int places,
                             const double *s)
{
    return strain_rod_columns(r->rod, r->u, r->z, places, s, x->columns, x->which);
}

/* By p, and where they follow it by u and z. */
static ad_value change_of(const recording *r, ad_value y, bool all)
{
    const ad_value wrt[3] = {r->p, r->u, r->z}, along[3] = {r->dp, r->du, r->dz};
    ad_value result = y;
    ad_directional(1, &y, all ? 3 : 1, wrt, along, &result);
    return result;
}

static int record(export_family *x, int function, const recording *r, ad_value outputs[3])
{
    const double end = 1;
    strain_blocks at;
    const strain_changes changes = {2, (ad_value[]){r->p, r->u}, (ad_value[]){r->dp, r->du}};
    switch (function) {
    case STATE:
        outputs[0] = strain_rod_state(r->rod, r->u);
        x->state = ad_rows(outputs[0]);
        return 1;
    case STATE_BY:
        outputs[0] = strain_rod_state_change(r->rod, r->u, r->z, &changes);
        return 1;
    case NETWORK:
        outputs[0] = record_network(x, r);
        return 1;
    case NETWORK_BY:
        outputs[0] = change_of(r, record_network(x, r), false);
        return 1;
    case NEWTON:
        if (x->placed) {
            outputs[0] = change_of(r, strain_rod_positions(r->rod, r->u, r->z), true);
            return 1;
        }
        at = strain_rod_blocks(r->rod, r->u, r->z);
        x->follows = at.follows;
        outputs[0] = at.residual;
        outputs[1] = at.blocks;
        outputs[2] = at.edges;
        return 3;
    case RESIDUAL:
        outputs[0] = strain_rod_residual(r->rod, r->u, r->z);
        return 1;
    case RESIDUAL_BY:
        outputs[0] = change_of(r, strain_rod_residual(r->rod, r->u, r->z), true);
        return 1;
    case SHAPE:
        outputs[0] = record_shape(x, r, x->places, x->s);
        return 1;
    case TIP:
        outputs[0] = record_shape(x, r, 1, &end);
        return 1;
    case TIP_BY:
        outputs[0] = change_of(r, record_shape(x, r, 1, &end), true);
        return 1;
    default:
        outputs[0] = change_of(r, record_shape(x, r, x->places, x->s), true);
        return 1;
    }
}

static ad_status compile(export_family *x, int function, ad_pool *pool, ad_program **program,
                         ad_error *error)
{
    const ad_settings settings = ad_settings_default();
    recording r;
    ad_value outputs[3];
    ad_status status = begin(x, function, &r, error);
    if (status == AD_OK) {
        const int count = record(x, function, &r, outputs);
        status = ad_compile(count, outputs, &settings, pool, program, error);
    }
    strain_rod_free(r.rod);
    ad_tape_free(r.tape);
    return status;
}

/* ---- the texts ----------------------------------------------------------------------------- */

static const char *type_of(const export_family *x)
{
    return x->single ? "float" : "double";
}

/* Of all numbers in a text. */
static export_type all_of(const export_family *x)
{
    return x->single ? EXPORT_ALL_FLOAT : EXPORT_DOUBLE;
}

static const model_column *column_of(const export_family *x, int column)
{
    return scene_physics_of(x->open)->columns + x->which[column];
}

static void put_numbers(const export_family *x, const char *name, size_t number, FILE *file)
{
    fprintf(file, "#define %s_%-12s %zu\n", x->name, name, number);
}

/* Inputs of the functions: p, u, z, and for each parameter a direction of these. */
static size_t inputs_of(const export_family *x)
{
    const size_t n = sought_of(x), p = (size_t)x->open->parameter_count;
    return (p + n + (size_t)x->state) * (1 + p);
}

/* Residual and blocks. */
static size_t linearised_of(const export_family *x)
{
    const size_t nodes = (size_t)strain_mesh_nodes(&x->mesh), edges = (size_t)x->mesh.elements;
    if (x->placed) {
        return sought_of(x);
    }
    return 3 * nodes + nodes * 9 * (x->follows ? STRAIN_BLOCKS : STRAIN_LOAD_BY_TURN) + 18 * edges;
}

/* As `room` of the C divides it. */
static size_t memory_of(const export_family *x)
{
    const size_t n = sought_of(x), p = (size_t)x->open->parameter_count;
    return inputs_of(x) + linearised_of(x) + 4 * n * n + n * (n > p ? n : p) +
           (size_t)x->places * (size_t)x->columns * (x->shape_by ? p : 1) + x->workspace;
}

/* Columns: index, unit, scale, and how far this C is from cpinn. */
static void write_columns(const export_family *x, FILE *file)
{
    const bool measured = !isnan(x->values[0]);
    fputs(
        "/* columns: index, unit, scale (the largest of that unit, or that of the rod: EI/L^2 of a "
        "force).\n * position r, rotation q, and in the frame of the section strain v, curvature "
        "u, force n, moment m */\nenum {\n",
        file);
    for (int i = 0; i < x->columns; i++) {
        const model_column *c = column_of(x, i);
        export_put_index(x->name, "", c->name, i, x->columns, file);
        fprintf(file, " /* %s, %.3g", *c->unit ? c->unit : "1", x->scale[i]);
        if (measured) {
            fprintf(file, "; to %.1e of it, its derivatives to %.1e", x->values[1 + i],
                    x->derivatives[1 + i]);
        }
        fputs(" */\n", file);
    }
    fprintf(
        file,
        "};\n\n/* How far this C, with numbers of type %s, is from cpinn's evaluation in double "
        "precision",
        type_of(x));
    if (measured) {
        fprintf(file,
                " after\n * %d of Newton's steps: above for %s; the curvature to %.1e of its "
                "largest; at "
                "%d members, those of\n * %s_selftest.c. */\n\n",
                x->steps, x->shape_by ? "the shape" : "the tip", x->derivatives[0], x->members,
                x->name);
    } else {
        fputs(" has\n * not been measured. */\n\n", file);
    }
}

static void write_header(const export_family *x, FILE *file)
{
    const int count = x->open->parameter_count;
    fprintf(file, "/* %s: ", x->name);
    export_put_comment(x->about, file);
    fprintf(file, ", a family of rods at rest as C99; written by cpinn " CPINN_VERSION ". */\n");
    export_begin_header(x->name, file);
    put_numbers(x, "PARAMETERS", (size_t)count, file);
    put_numbers(x, "POINTS", (size_t)x->places, file);
    put_numbers(x, "COLUMNS", (size_t)x->columns, file);
    put_numbers(x, "NODES", (size_t)strain_mesh_nodes(&x->mesh), file);
    put_numbers(x, "MEMORY", memory_of(x), file);
    put_numbers(x, "OUT_OF_RANGE", 1, file);
    put_numbers(x, "SINGULAR", 2, file);
    fputs("\n/* parameters: index, range */\nenum {\n", file);
    for (int i = 0; i < count; i++) {
        const scene_parameter *p = &x->open->parameters[i];
        export_put_index(x->name, "IN_", p->name, i, count, file);
        fprintf(file, " /* %.9g to %.9g */\n", p->low, p->high);
    }
    fputs("};\n\n", file);
    write_columns(x, file);
    export_put_lines(x->name, all_of(x), export_family_types, file);
    if (x->shape_by) {
        export_put(
            x->name, all_of(x),
            "\n/* The same of the shape: jacobian [POINTS][COLUMNS][PARAMETERS]. */\n"
            "int model_shape_jacobian(const double *parameters, int steps, double *shape, double "
            "*jacobian,\n                         model_answer *answer, double *memory);\n",
            file);
    }
    export_end_header(file);
}

static void put_macro(const export_family *x, const char *name, double value, FILE *file)
{
    fprintf(file, "#define %s ", name);
    export_put_number(value, x->single, file);
    fputc('\n', file);
}

/* Integrals from s = 0 to points and to edges of what is at points. */
static void write_integrals(const export_family *x, FILE *file)
{
    const strain_mesh *mesh = &x->mesh;
    static const char *const names[2] = {"to_point", "to_edge"};
    double weights[STRAIN_ELEMENTS_MAX * STRAIN_STAGES_MAX];
    const int nodes = strain_mesh_nodes(mesh);
    for (int k = 0; k < 2; k++) {
        const int rows = k == 0 ? nodes : mesh->elements + 1;
        fprintf(file, "static const %s %s[%d][%d] = {\n", type_of(x), names[k], rows, nodes);
        for (int i = 0; i < rows; i++) {
            strain_mesh_integral(mesh, k == 1, i, weights);
            export_put_list((size_t)nodes, weights, 1, x->single, file);
            fputs(i + 1 < rows ? ",\n" : "};\n", file);
        }
    }
}

/* Of the highest modes in an element; its widths. */
static void write_modes(const export_family *x, FILE *file)
{
    const strain_mesh *mesh = &x->mesh;
    double weights[STRAIN_MODES][STRAIN_STAGES_MAX], width[STRAIN_ELEMENTS_MAX];
    strain_mesh_modes(mesh, weights);
    for (int e = 0; e < mesh->elements; e++) {
        width[e] = mesh->edges[e + 1] - mesh->edges[e];
    }
    fprintf(file, "static const %s modes[%d][%d] = {\n", type_of(x), STRAIN_MODES, mesh->stages);
    for (int k = 0; k < STRAIN_MODES; k++) {
        export_put_list((size_t)mesh->stages, weights[k], 1, x->single, file);
        fputs(k + 1 < STRAIN_MODES ? ",\n" : "};\n", file);
    }
    fprintf(file, "static const %s widths[%d] = ", type_of(x), mesh->elements);
    export_put_list((size_t)mesh->elements, width, 1, x->single, file);
    fputs(";\n", file);
}

static void write_constants(const export_family *x, FILE *file)
{
    const int count = x->open->parameter_count;
    const char *names[STRAIN_COLUMNS];
    export_put_parameters(x->name, "parameter_names", x->open, x->single, file);
    fprintf(file, "const %s %s_places[%d] = ", type_of(x), x->name, x->places);
    export_put_list((size_t)x->places, x->s, scene_length(x->open), x->single, file);
    fputs(";\n", file);
    for (int i = 0; i < x->columns; i++) {
        names[i] = column_of(x, i)->name;
    }
    export_put_names(x->name, "column_names", (size_t)x->columns, names, file);
    fputc('\n', file);
    fprintf(file,
            "#define FORCES %d\n#define HELD %d\n#define TENSIONS %d\n#define PLACED %d\n"
            "#define TIP %d\n#define SHAPE_BY %d\nenum {\n    NODES = %d,\n    N = "
            "FORCES + 3 * NODES + HELD,\n    P = %d,\n    Z = %d,\n"
            "    ELEMENTS = %d,\n"
            "    STAGES = %d,\n    FOLLOWS = %d, /* forces follow the rod */\n    INPUTS = %zu,\n"
            "    LINEARISED = %zu\n};\n",
            x->forces, x->held, strain_tensions(x->open), x->placed, x->tip, x->shape_by,
            strain_mesh_nodes(&x->mesh), count, x->state, x->mesh.elements, x->mesh.stages,
            x->follows, inputs_of(x), linearised_of(x));
    put_macro(x, "LENGTH", scene_length(x->open), file);
    put_macro(x, "MESH", x->mesh_error, file);
    put_macro(x, "RESOLVED", STRAIN_RESOLVED, file);
    put_macro(x, "ROUNDING", x->single ? 1e-6 : 1e-9, file);   /* of a range */
    put_macro(x, "DIFFERENCE", x->single ? 5e-3 : 1e-5, file); /* of a range */
    put_macro(x, "SETTLED", x->single ? 1e-5 : 1e-9, file);    /* steps over the length */
    put_macro(x, "LARGE", x->single ? 1e15 : 1e100, file);     /* curvature times the length */
    write_modes(x, file);
    if (!x->placed) {
        write_integrals(x, file);
    }
}

/* All but how the file begins. */
static ad_status write_functions(export_family *x, FILE *file, ad_error *error)
{
    static const double *const *const no_uniforms[] = {NULL};
    ad_program *programs[FUNCTIONS] = {NULL};
    ad_c_options options[FUNCTIONS];
    ad_pool *pool = ad_pool_create(1);
    int count = 0;
    x->forces = strain_forces(x->open, strain_mesh_nodes(&x->mesh));
    x->held = strain_held(x->open);
    x->placed = strain_is_placed(x->open);
    ad_status status = pool ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a thread");
    for (int i = 0; i < FUNCTIONS && status == AD_OK; i++) {
        if (is_wanted(x, i)) {
            options[count] = (ad_c_options){.name = functions[row_of(x, i)].name,
                                            .points = points_of(x, i),
                                            .sets = 1,
                                            .parameters = &x->weights,
                                            .uniforms = no_uniforms,
                                            .internal = true};
            status = compile(x, i, pool, &programs[count++], error);
        }
    }
    if (status == AD_OK) {
        status =
            ad_write_c((size_t)count, programs, options, x->single, file, &x->workspace, error);
    }
    if (status == AD_OK) {
        write_constants(x, file);
        fputc('\n', file);
        export_put_lines(x->name, all_of(x), export_family_functions, file);
    }
    for (int i = 0; i < FUNCTIONS; i++) {
        ad_program_free(programs[i]);
    }
    ad_pool_free(pool);
    return status;
}

static ad_status write_source(export_family *x, FILE *file, ad_error *error)
{
    export_begin_source(x->name, file);
    return write_functions(x, file, error);
}

/* The header has numbers that the source knows. */
ad_status export_family_write_code(export_family *x, FILE *file, ad_error *error)
{
    export_text source = {.bytes = NULL};
    ad_status status = export_text_open(&source) ? write_functions(x, source.file, error) : AD_OK;
    if (!export_text_close(&source) && status == AD_OK) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory while writing C");
    }
    if (status == AD_OK) {
        write_header(x, file);
        fputs(source.bytes, file);
        export_put_lines(x->name, all_of(x), export_code_functions, file);
    }
    free(source.bytes);
    return status;
}

int export_family_compared(const export_family *x, int places[EXPORT_COMPARED])
{
    const int count = x->shape_by && x->places > 1 ? EXPORT_COMPARED : 1;
    for (int i = 0; i < count; i++) {
        places[i] = (x->places - 1) * (EXPORT_COMPARED - count + 1 + i) / EXPORT_COMPARED;
    }
    return count;
}

static void write_selftest(const export_family *x, FILE *file)
{
    const int rows = 3 * strain_mesh_nodes(&x->mesh), count = x->open->parameter_count;
    double scale = 0;
    for (int i = 0; i < rows * x->members; i++) {
        scale = fmax(scale, fabs(x->polished[i]));
    }
    int places[EXPORT_COMPARED];
    const int compared = export_family_compared(x, places);
    export_begin_selftest(x->name, "c99", file);
    if (x->shape_by) {
        export_put_integers(file, (size_t)compared, places, "static const int places[]");
    }
    fprintf(file,
            "enum { MEMBERS = %d, N = %d, P = %d, STEPS = %d, COMPARED = %d };\n#define SHAPE_BY "
            "%d\n#define LARGEST %.17g\n#define TOLERANCE %g\n\n",
            x->members, rows, count, x->steps, compared, x->shape_by, scale,
            x->single      ? 1e-3
            : x->steps > 1 ? 1e-6   /* forces of two steps, not of the curvature */
                           : 1e-9); /* rounding, a thousand times and more larger near a fold */
    const size_t members = (size_t)x->members, n = (size_t)rows, columns = (size_t)x->columns,
                 numbers = (size_t)compared * columns, parameters = (size_t)count;
    export_put_rows(x->single ? "static const float parameters" : "static const double parameters",
                    members, parameters, x->parameters, x->single, file);
    export_put_rows("static const double curvature", members, n, x->curvature, false, file);
    export_put_rows("static const double polished", members, n, x->polished, false, file);
    export_put_rows("static const double columns", members, numbers, x->shapes, false, file);
    export_put_rows("static const double derivatives", members, numbers * parameters, x->jacobian,
                    false, file);
    export_put_rows("static const double scale", 1, columns, x->scale, false, file);
    fputc('\n', file);
    export_put_lines(x->name, x->single ? EXPORT_FLOAT : EXPORT_DOUBLE, export_family_selftest,
                     file);
}

ad_status export_family_write(void *of, int which, FILE *file, ad_error *error)
{
    if (which == EXPORT_SOURCE) {
        return write_source(of, file, error);
    }
    (which == EXPORT_HEADER ? write_header : write_selftest)(of, file);
    return AD_OK;
}
