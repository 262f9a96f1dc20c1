#include "tools/emit/export_family.h"

#include "physics/chain/solve_members.h"
#include "physics/learn/model.h"
#include "physics/numerics/gauss.h"
#include "physics/rod/rod.h"
#include "tools/emit/export_text.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BODY = EXPORT_CODE + 1 }; /* of the source */

/* ---- what is recorded ---------------------------------------------------------------------- */

/* Functions of the C: parameters p and, of what follows them, the factor of the loads, what is
 * sought u, the curvature behind forces that depend on the place, the state z of the rod by u,
 * directions of these for each parameter. The state comes first: it says how many numbers z has. */
enum {
    STATE,       /* p, u -> z */
    STATE_BY,    /* p, u, z, dp, du -> dz */
    NETWORK,     /* p -> curvature; without a network that of the unstressed rod */
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
    int inputs;  /* of p, u, z, dp, du, dz, beside the load */
    bool shared; /* p, u and z are those of all points */
} functions[FUNCTIONS + 1] = {
    {"state", 2, false},  {"state_by", 5, true},  {"network", 1, false},    {"network_by", 4, true},
    {"newton", 3, false}, {"residual", 3, false}, {"residual_by", 6, true}, {"shape", 3, false},
    {"tip", 3, false},    {"tip_by", 6, true},    {"shape_by", 6, true},    {"places_by", 6, true}};

/* Where positions are asked for the matrix is made column by column, by what a direction changes.
 */
static int row_of(const export_family *family, int function)
{
    return function == PLACES_BY && family->placed ? FUNCTIONS : function;
}

/* Whether it is asked for. */
static bool is_wanted(const export_family *family, int function)
{
    return function == TIP || function == TIP_BY ? family->tip
           : function == SHAPE_BY                ? family->shape_by
                                                 : true;
}

static int loads_of(const export_family *family)
{
    return family->network ? 0 : 1;
}

static size_t sought_of(const export_family *family)
{
    const int nodes = strain_mesh_nodes(&family->mesh);
    const int sought = family->forces + strain_twisting(family->open, nodes) + 3 * nodes;
    return (size_t)sought + (size_t)family->held;
}

typedef struct recording {
    ad_tape *tape;
    ad_value p, load, u, z, dp, du, dz;
    strain_rod *rod;
} recording;

static size_t points_of(const export_family *family, int function)
{
    return functions[row_of(family, function)].shared ? (size_t)family->open->parameter_count : 1;
}

/* Inputs in the order in which the C has them. */
static ad_status begin(const export_family *family, int function, recording *r, ad_error *error)
{
    const int count = family->open->parameter_count, row = row_of(family, function);
    const int rows = (int)sought_of(family);
    const bool shared = functions[row].shared;
    ad_value each[SCENE_PARAMETERS_MAX];
    const char *names[SCENE_PARAMETERS_MAX];
    double middle[SCENE_PARAMETERS_MAX];
    *r = (recording){.tape = ad_tape_create()};
    const struct {
        const char *name;
        ad_value *at;
        int rows;
    } inputs[] = {{"p", &r->p, count},          {"load", &r->load, loads_of(family)},
                  {"u", &r->u, rows},           {"z", &r->z, family->state},
                  {"dp", &r->dp, count},        {"du", &r->du, rows},
                  {"dz", &r->dz, family->state}};
    for (int i = 0; i <= functions[row].inputs; i++) {
        if (inputs[i].rows > 0) {
            *inputs[i].at = shared && i < 4
                                ? ad_input_member(r->tape, inputs[i].name, inputs[i].rows)
                                : ad_input(r->tape, inputs[i].name, inputs[i].rows);
        }
    }
    for (int i = 0; i < count; i++) {
        each[i] = ad_row(r->p, i);
        names[i] = family->open->parameters[i].name;
        middle[i] = scene_parameter_at(&family->open->parameters[i], 0.5);
    }
    const strain_settings settings = {
        family->open, count, names, middle, family->mesh, family->network ? NULL : &r->load};
    return !family->network || (function != NETWORK && function != NETWORK_BY)
               ? strain_rod_create(&settings, ad_input(r->tape, "s", 1), each, &r->rod, error)
               : AD_OK;
}

/* At coordinates of parameters, the inverse of scene_parameter_at; torsions first, as they are
 * sought. */
static ad_value record_network(const export_family *family, const recording *r)
{
    const int bent = 3 * strain_mesh_nodes(&family->mesh), twisted = bent / 3 * family->tubes;
    ad_value at[SCENE_PARAMETERS_MAX];
    if (!family->network) {
        const ad_value rest = strain_rod_rest(r->rod);
        return twisted > 0 ? ad_pad(rest, twisted, twisted + bent) : rest;
    }
    for (int i = 0; i < family->open->parameter_count; i++) {
        const scene_parameter *p = &family->open->parameters[i];
        ad_value value = ad_row(r->p, i);
        at[i] = p->scale == SCENE_LOG
                    ? ad_scale(ad_log(ad_scale(value, 1 / p->low)), 1 / log(p->high / p->low))
                    : ad_scale(ad_sub(value, ad_scalar(r->tape, p->low)), 1 / (p->high - p->low));
    }
    const ad_value all = family->network(family->context, r->tape, at);
    if (twisted == 0) {
        return all;
    }
    return ad_stack(2, (ad_value[]){ad_slice(all, bent, twisted), ad_slice(all, 0, bent)});
}

/* [columns][places] */
static ad_value record_shape(const export_family *family, const recording *r, int places,
                             const double *s)
{
    return strain_rod_columns(r->rod, r->u, r->z, places, s, family->columns, family->which);
}

/* By p, and where they follow it by u and z. */
static ad_value change_of(const recording *r, ad_value y, bool all)
{
    const ad_value wrt[3] = {r->p, r->u, r->z}, along[3] = {r->dp, r->du, r->dz};
    ad_value result = y;
    ad_directional(1, &y, all ? 3 : 1, wrt, along, &result);
    return result;
}

static int record(export_family *family, int function, const recording *r, ad_value outputs[3])
{
    const double end = 1;
    strain_blocks at;
    const strain_changes changes = {2, (ad_value[]){r->p, r->u}, (ad_value[]){r->dp, r->du}};
    switch (function) {
    case STATE:
        outputs[0] = strain_rod_state(r->rod, r->u);
        family->state = ad_rows(outputs[0]);
        return 1;
    case STATE_BY:
        outputs[0] = strain_rod_state_change(r->rod, r->u, r->z, &changes);
        return 1;
    case NETWORK:
        outputs[0] = record_network(family, r);
        return 1;
    case NETWORK_BY:
        outputs[0] = change_of(r, record_network(family, r), false);
        return 1;
    case NEWTON:
        if (family->placed) {
            outputs[0] = change_of(r, strain_rod_positions(r->rod, r->u, r->z), true);
            return 1;
        }
        at = strain_rod_blocks(r->rod, r->u, r->z);
        family->follows = at.follows;
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
        outputs[0] = record_shape(family, r, family->places, family->s);
        return 1;
    case TIP:
        outputs[0] = record_shape(family, r, 1, &end);
        return 1;
    case TIP_BY:
        outputs[0] = change_of(r, record_shape(family, r, 1, &end), true);
        return 1;
    default:
        outputs[0] = change_of(r, record_shape(family, r, family->places, family->s), true);
        return 1;
    }
}

static ad_status compile(export_family *family, int function, ad_pool *pool, ad_program **program,
                         ad_error *error)
{
    const ad_settings settings = ad_settings_default();
    recording r;
    ad_value outputs[3];
    ad_status status = begin(family, function, &r, error);
    if (status == AD_OK) {
        const int count = record(family, function, &r, outputs);
        status = ad_compile(count, outputs, &settings, pool, program, error);
    }
    strain_rod_free(r.rod);
    ad_tape_free(r.tape);
    return status;
}

/* ---- the texts ----------------------------------------------------------------------------- */

static const char *type_of(const export_family *family)
{
    return family->single ? "float" : "double";
}

/* Of all numbers in a text. */
static export_type all_of(const export_family *family)
{
    return family->single ? EXPORT_ALL_FLOAT : EXPORT_DOUBLE;
}

static const model_column *column_of(const export_family *family, int column)
{
    return scene_physics_of(family->open)->columns + family->which[column];
}

static void put_numbers(const export_family *family, const char *name, size_t number, FILE *file)
{
    fprintf(file, "#define %s_%-12s %zu\n", family->name, name, number);
}

/* Inputs of the functions: p, u, z, and for each parameter a direction of these. */
static size_t inputs_of(const export_family *family)
{
    const size_t n = sought_of(family), p = (size_t)family->open->parameter_count;
    return (p + n + (size_t)family->state) * (1 + p) + (size_t)loads_of(family);
}

/* Residual and blocks. */
static size_t linearised_of(const export_family *family)
{
    const size_t nodes = (size_t)strain_mesh_nodes(&family->mesh),
                 edges = (size_t)family->mesh.elements;
    if (family->placed) {
        return sought_of(family);
    }
    return 3 * nodes + nodes * 9 * (family->follows ? STRAIN_BLOCKS : STRAIN_LOAD_BY_TURN) +
           18 * edges;
}

/* As `room` of the C divides it. */
static size_t memory_of(const export_family *family)
{
    const size_t n = sought_of(family), p = (size_t)family->open->parameter_count;
    return inputs_of(family) + linearised_of(family) + 4 * n * n + n * (n > p ? n : p) +
           (size_t)family->places * (size_t)family->columns * (family->shape_by ? p : 1) +
           family->workspace;
}

/* Columns: index, unit, scale, and how far this C is from cpinn. */
static void write_columns(const export_family *family, FILE *file)
{
    const bool measured = !isnan(family->values[0]);
    fputs(
        "/* columns: index, unit, scale (the largest of that unit, or that of the rod: EI/L^2 of a "
        "force).\n * position r, rotation q, and in the frame of the section strain v, curvature "
        "u, force n, moment m */\nenum {\n",
        file);
    for (int i = 0; i < family->columns; i++) {
        const model_column *c = column_of(family, i);
        export_put_index(family->name, "", c->name, i, family->columns, file);
        fprintf(file, " /* %s, %.3g", *c->unit ? c->unit : "1", family->scale[i]);
        if (measured) {
            fprintf(file, "; to %.1e of it, its derivatives to %.1e", family->values[1 + i],
                    family->derivatives[1 + i]);
        }
        fputs(" */\n", file);
    }
    fprintf(
        file,
        "};\n\n/* How far this C, with numbers of type %s, is from cpinn's evaluation in double "
        "precision",
        type_of(family));
    if (measured) {
        fprintf(file,
                " after\n * %d of Newton's steps: above for %s; the curvature to %.1e of its "
                "largest; at "
                "%d members, those of\n * %s_selftest.c. */\n\n",
                family->steps, family->shape_by ? "the shape" : "the tip", family->derivatives[0],
                family->members, family->name);
    } else {
        fputs(" has\n * not been measured. */\n\n", file);
    }
}

static void write_header(const export_family *family, FILE *file)
{
    const int count = family->open->parameter_count;
    fprintf(file, "/* %s: ", family->name);
    export_put_comment(family->about, file);
    fprintf(file, ", a family of rods at rest as C99; written by cpinn " CPINN_VERSION ". */\n");
    export_begin_header(family->name, file);
    put_numbers(family, "PARAMETERS", (size_t)count, file);
    put_numbers(family, "POINTS", (size_t)family->places, file);
    put_numbers(family, "COLUMNS", (size_t)family->columns, file);
    put_numbers(family, "NODES", (size_t)strain_mesh_nodes(&family->mesh), file);
    put_numbers(family, "WIDTH", (size_t)3 + (size_t)family->tubes, file);
    put_numbers(family, "MEMORY", memory_of(family), file);
    put_numbers(family, "OUT_OF_RANGE", 1, file);
    put_numbers(family, "SINGULAR", 2, file);
    put_numbers(family, "NOT_FINITE", SOLVE_NOT_FINITE, file);
    put_numbers(family, "UNSTABLE", SOLVE_UNSTABLE, file);
    put_numbers(family, "TOO_FAR", SOLVE_TOO_FAR, file);
    put_numbers(family, "NOT_SETTLING", SOLVE_NOT_SETTLING, file);
    fputs("\n/* parameters: index, range */\nenum {\n", file);
    for (int i = 0; i < count; i++) {
        const scene_parameter *p = &family->open->parameters[i];
        export_put_index(family->name, "IN_", p->name, i, count, file);
        fprintf(file, " /* %.9g to %.9g */\n", p->low, p->high);
    }
    fputs("};\n\n", file);
    write_columns(family, file);
    export_put_lines(family->name, all_of(family), export_family_types, file);
    if (family->shape_by) {
        export_put(
            family->name, all_of(family),
            "\n/* The same of the shape: jacobian [POINTS][COLUMNS][PARAMETERS]. */\n"
            "int model_shape_jacobian(const double *parameters, int steps, double *shape, double "
            "*jacobian,\n                         model_answer *answer, double *memory);\n",
            file);
    }
    if (family->wall) {
        const surface_tree *const wall = family->wall->surface;
        fprintf(
            file,
            "\n/* How far, m, all of the rod with a radius of %g m around it keeps from the wall "
            "at least,\n * from s = %g m on, also between the places of its shape, or `enough` if "
            "that is less, which\n * is found soon; less than 0: it may touch. shape "
            "[POINTS][COLUMNS], in the axes of the scene,\n * moved as the base is; off: how far "
            "its places may be off, m, as answer.left. Distances from\n * the wall's %d "
            "triangles, %zu kB, are exact to %.1e m. -HUGE_VAL: a place is no number, or\n * the "
            "rod is longer than it can be. */\n",
            family->wall->radius, family->wall->from, wall->tree.triangles,
            surface_tree_bytes(wall) / 1000, wall->error);
        export_put(family->name, family->single ? EXPORT_FLOAT : EXPORT_DOUBLE,
                   "double model_clear(const model_number *shape, double off, double enough);\n",
                   file);
    }
    export_end_header(file);
}

static void put_macro(const export_family *family, const char *name, double value, FILE *file)
{
    fprintf(file, "#define %s ", name);
    export_put_number(value, family->single, file);
    fputc('\n', file);
}

/* Integrals from s = 0 to points and to edges of what is at points. */
static void write_integrals(const export_family *family, FILE *file)
{
    const strain_mesh *mesh = &family->mesh;
    static const char *const names[2] = {"to_point", "to_edge"};
    double weights[STRAIN_ELEMENTS_MAX * STRAIN_STAGES_MAX];
    const int nodes = strain_mesh_nodes(mesh);
    for (int k = 0; k < 2; k++) {
        const int rows = k == 0 ? nodes : mesh->elements + 1;
        fprintf(file, "static const %s %s[%d][%d] = {\n", type_of(family), names[k], rows, nodes);
        for (int i = 0; i < rows; i++) {
            strain_mesh_integral(mesh, k == 1, i, weights);
            export_put_list((size_t)nodes, weights, 1, family->single, file);
            fputs(i + 1 < rows ? ",\n" : "};\n", file);
        }
    }
}

/* Of the highest modes in an element; its widths. */
static void write_modes(const export_family *family, FILE *file)
{
    const strain_mesh *mesh = &family->mesh;
    double weights[STRAIN_MODES][STRAIN_STAGES_MAX], width[STRAIN_ELEMENTS_MAX];
    strain_mesh_modes(mesh, weights);
    for (int e = 0; e < mesh->elements; e++) {
        width[e] = mesh->edges[e + 1] - mesh->edges[e];
    }
    fprintf(file, "static const %s modes[%d][%d] = {\n", type_of(family), STRAIN_MODES,
            mesh->stages);
    for (int k = 0; k < STRAIN_MODES; k++) {
        export_put_list((size_t)mesh->stages, weights[k], 1, family->single, file);
        fputs(k + 1 < STRAIN_MODES ? ",\n" : "};\n", file);
    }
    fprintf(file, "static const %s widths[%d] = ", type_of(family), mesh->elements);
    export_put_list((size_t)mesh->elements, width, 1, family->single, file);
    fputs(";\n", file);
}

/* What points of the first element say of s = 0. */
static void write_start(const export_family *family, FILE *file)
{
    const gauss_rule rule = solve_gauss_rule_of(family->mesh.stages);
    double weights[STRAIN_STAGES_MAX];
    gauss_lagrange(&rule, 0, weights);
    fprintf(file, "static const %s at_start[%d] = ", type_of(family), family->mesh.stages);
    export_put_list((size_t)family->mesh.stages, weights, 1, family->single, file);
    fputs(";\n", file);
}

/* In double precision, whatever that of the shape is: what rounding leaves of a place is a
 * millionth of the length then. */
static void write_wall(const export_family *family, FILE *file)
{
    const export_wall *const wall = family->wall;
    bool stretches = false;
    if (!wall) {
        return;
    }
    for (int i = 0; i < family->columns; i++) {
        stretches |= strcmp(column_of(family, i)->name, "v3") == 0;
    }
    fputs("\n#define WHOLE_FUNCTION static\n", file);
    export_put_lines(family->name, EXPORT_DOUBLE, export_wall_distance, file);
    export_put_tree(&wall->surface->tree, "wall", file);
    fprintf(file,
            "#define WALL_OFF %.17g\n#define WALL_RADIUS %.17g\n#define WALL_FROM %.17g\n"
            "#define ROUNDED %.17g\n#define STRETCHES %d\n\n",
            wall->surface->error, wall->radius, wall->from,
            (family->single ? 1e-6 : 1e-12) * scene_length(family->open), stretches);
    export_put_lines(family->name, family->single ? EXPORT_FLOAT : EXPORT_DOUBLE,
                     export_wall_functions, file);
}

static void write_constants(const export_family *family, FILE *file)
{
    const int count = family->open->parameter_count;
    const char *names[STRAIN_COLUMNS_MAX];
    export_put_parameters(family->name, "parameter_names", family->open, family->single, file);
    fprintf(file, "const %s %s_places[%d] = ", type_of(family), family->name, family->places);
    export_put_list((size_t)family->places, family->s, scene_length(family->open), family->single,
                    file);
    fputs(";\n", file);
    for (int i = 0; i < family->columns; i++) {
        names[i] = column_of(family, i)->name;
    }
    export_put_names(family->name, "column_names", (size_t)family->columns, names, file);
    fputc('\n', file);
    fprintf(file,
            "#define FORCES %d\n#define TUBES %d\n#define HELD %d\n#define TENSIONS %d\n"
            "#define PLACED %d\n#define TIP %d\n#define SHAPE_BY %d\nenum {\n    NODES = %d,\n"
            "    TORSIONS = FORCES + TUBES,\n    CURVED = TORSIONS + TUBES * NODES,\n"
            "    N = CURVED + 3 * NODES + HELD,\n    P = %d,\n    GIVEN = P + %d,\n    Z = %d,\n"
            "    ELEMENTS = %d,\n"
            "    STAGES = %d,\n    FOLLOWS = %d, /* forces follow the rod */\n    INPUTS = %zu,\n"
            "    LINEARISED = %zu\n};\n",
            family->forces, family->tubes, family->held, strain_tensions(family->open),
            family->placed, family->tip, family->shape_by, strain_mesh_nodes(&family->mesh), count,
            loads_of(family), family->state, family->mesh.elements, family->mesh.stages,
            family->follows, inputs_of(family), linearised_of(family));
    put_macro(family, "LENGTH", scene_length(family->open), file);
    put_macro(family, "MESH", family->mesh_error, file);
    put_macro(family, "RESOLVED", STRAIN_RESOLVED, file);
    put_macro(family, "ROUNDING", family->single ? 1e-6 : 1e-9, file);   /* of a range */
    put_macro(family, "DIFFERENCE", family->single ? 5e-3 : 1e-5, file); /* of a range */
    put_macro(family, "SETTLED", family->single ? 1e-5 : 1e-9, file);    /* steps over the length */
    put_macro(family, "LARGE", family->single ? 1e15 : 1e100,
              file); /* curvature times the length */
    put_macro(family, "TINY", family->single ? 1e-15 : 1e-60, file); /* the same */
    if (!family->network) {
        put_macro(family, "TOLERANCE", family->tolerance, file);
#define PATH_RULE(name, value) put_macro(family, #name, value, file);
        SOLVE_PATH_RULES(PATH_RULE)
#undef PATH_RULE
    }
    write_modes(family, file);
    if (family->tubes > 0) {
        write_start(family, file);
    }
    if (!family->placed) {
        write_integrals(family, file);
    }
}

/* All but how the file begins. */
static ad_status write_functions(export_family *family, FILE *file, ad_error *error)
{
    static const double *const *const no_uniforms[] = {NULL};
    ad_program *programs[FUNCTIONS] = {NULL};
    ad_c_options options[FUNCTIONS];
    ad_pool *pool = ad_pool_create(1);
    int count = 0;
    family->forces = strain_forces(family->open, strain_mesh_nodes(&family->mesh));
    family->held = strain_held(family->open);
    family->tubes = family->open->tube_count;
    family->placed = strain_is_placed(family->open);
    ad_status status = pool ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a thread");
    for (int i = 0; i < FUNCTIONS && status == AD_OK; i++) {
        if (is_wanted(family, i)) {
            options[count] = (ad_c_options){.name = functions[row_of(family, i)].name,
                                            .points = points_of(family, i),
                                            .sets = 1,
                                            .parameters = &family->weights,
                                            .uniforms = no_uniforms,
                                            .internal = true};
            status = compile(family, i, pool, &programs[count++], error);
        }
    }
    if (status == AD_OK) {
        status = ad_write_c((size_t)count, programs, options, family->single, file,
                            &family->workspace, error);
    }
    if (status == AD_OK) {
        write_constants(family, file);
        fputc('\n', file);
        export_put_lines(family->name, all_of(family), export_equation_functions, file);
        fputc('\n', file);
        export_put_lines(family->name, all_of(family), export_family_functions, file);
        write_wall(family, file);
    }
    for (int i = 0; i < FUNCTIONS; i++) {
        ad_program_free(programs[i]);
    }
    ad_pool_free(pool);
    return status;
}

int export_family_compared(const export_family *family, int places[EXPORT_COMPARED])
{
    const int count = family->shape_by && family->places > 1 ? EXPORT_COMPARED : 1;
    for (int i = 0; i < count; i++) {
        places[i] = (family->places - 1) * (EXPORT_COMPARED - count + 1 + i) / EXPORT_COMPARED;
    }
    return count;
}

static void write_selftest(const export_family *family, FILE *file)
{
    const int rows = (3 + family->tubes) * strain_mesh_nodes(&family->mesh),
              count = family->open->parameter_count;
    double scale = 0;
    for (int i = 0; i < rows * family->members; i++) {
        scale = fmax(scale, fabs(family->polished[i]));
    }
    int places[EXPORT_COMPARED];
    const int compared = export_family_compared(family, places);
    export_begin_selftest(family->name, "c99", file);
    if (family->shape_by) {
        export_put_integers(file, (size_t)compared, places, "static const int places[]");
    }
    fprintf(file,
            "enum { MEMBERS = %d, N = %d, P = %d, STEPS = %d, SETTLED = 9, COMPARED = %d,\n"
            "       ROWS = %d * %d };\n#define SHAPE_BY %d\n#define LARGEST %.17g\n"
            "#define TOLERANCE %g\n#define STEP %g\n#define DIFFERENCES %g\n\n",
            family->members, rows, count, family->steps, compared,
            family->shape_by ? compared + 1 : 1, family->columns, family->shape_by, scale,
            family->single      ? 1e-3
            : family->steps > 1 ? 1e-6  /* forces of two steps, not of the curvature */
                                : 1e-9, /* rounding, a thousand times and more larger near a fold */
            family->single ? 0.02 : 1e-3, family->single ? 0.05 : 1e-3);
    const size_t members = (size_t)family->members, n = (size_t)rows,
                 columns = (size_t)family->columns, numbers = (size_t)compared * columns;
    export_put_rows(family->single ? "static const float parameters"
                                   : "static const double parameters",
                    members, (size_t)count, family->parameters, family->single, file);
    export_put_rows("static const double curvature", members, n, family->curvature, false, file);
    export_put_rows("static const double polished", members, n, family->polished, false, file);
    export_put_rows("static const double columns", members, numbers, family->shapes, false, file);
    export_put_rows("static const double scale", 1, columns, family->scale, false, file);
    fputc('\n', file);
    export_put_lines(family->name, family->single ? EXPORT_FLOAT : EXPORT_DOUBLE,
                     export_family_selftest, file);
}

/* The header has numbers that the functions know. */
static ad_status write_code(export_family *family, FILE *file, ad_error *error)
{
    export_text functions = {.bytes = NULL};
    const ad_status status =
        export_text_write(&functions, BODY, export_family_write, family, error);
    if (status == AD_OK) {
        write_header(family, file);
        fputs(functions.bytes, file);
        export_put_lines(family->name, all_of(family),
                         family->network ? export_code_functions : export_solver_functions, file);
    }
    free(functions.bytes);
    return status;
}

ad_status export_family_write(void *of, int which, FILE *file, ad_error *error)
{
    export_family *family = of;
    if (which == EXPORT_CODE) {
        return write_code(family, file, error);
    }
    if (which == EXPORT_SOURCE) {
        export_begin_source(family->name, file);
    }
    if (which == EXPORT_SOURCE || which == BODY) {
        return write_functions(family, file, error);
    }
    (which == EXPORT_HEADER ? write_header : write_selftest)(family, file);
    return AD_OK;
}
