#include "tools/programs/export_family.h"

#include "physics/rod.h"
#include "tools/programs/cli.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- what is recorded ---------------------------------------------------------------------- */

/* Functions of the C: parameters p, curvature u, a direction of u for each of its numbers, and of p
 * and u for each parameter. */
enum {
    NETWORK,     /* p -> u */
    NETWORK_BY,  /* p, dp -> du */
    NEWTON,      /* p, u, directions -> residual, its changes */
    RESIDUAL,    /* p, u -> residual */
    RESIDUAL_BY, /* p, u, dp -> its changes */
    MOVED,       /* p, u, direction -> changes of places */
    SHAPE,       /* p, u -> columns at places */
    TIP,         /* the same of the end */
    TIP_BY,      /* p, u, dp, du -> its changes */
    FUNCTIONS
};

static const struct {
    const char *name;
    bool of_u, by_u, by_p; /* inputs */
    bool shared;           /* p and u are those of all points */
} functions[FUNCTIONS] = {
    {"network", false, false, false, false},  {"network_by", false, false, true, true},
    {"newton", true, true, false, true},      {"residual", true, false, false, false},
    {"residual_by", true, false, true, true}, {"moved", true, true, false, false},
    {"shape", true, false, false, false},     {"tip", true, false, false, false},
    {"tip_by", true, true, true, true}};

typedef struct recording {
    ad_tape *tape;
    ad_value p, u, du, dp;
    strain_rod *rod;
} recording;

static size_t points_of(const export_family *x, int function)
{
    return !functions[function].shared ? 1
           : functions[function].by_p  ? (size_t)x->open->parameter_count
                                       : 3 * (size_t)strain_mesh_nodes(&x->mesh);
}

static ad_value leaf(ad_tape *tape, const char *name, int rows, bool shared)
{
    return shared ? ad_input_member(tape, name, rows) : ad_input(tape, name, rows);
}

/* Inputs in the order in which the C has them. */
static ad_status begin(const export_family *x, int function, recording *r, ad_error *error)
{
    const int count = x->open->parameter_count, rows = 3 * strain_mesh_nodes(&x->mesh);
    const bool shared = functions[function].shared;
    ad_value each[SCENE_PARAMETERS_MAX];
    const char *names[SCENE_PARAMETERS_MAX];
    double middle[SCENE_PARAMETERS_MAX];
    *r = (recording){.tape = ad_tape_create()};
    if (!r->tape) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a tape");
    }
    r->p = leaf(r->tape, "parameters", count, shared);
    if (functions[function].of_u) {
        r->u = leaf(r->tape, "curvature", rows, shared);
    }
    if (functions[function].by_p) {
        r->dp = ad_input(r->tape, "direction", count);
    }
    if (functions[function].by_u) {
        r->du = ad_input(r->tape, "change", rows);
    }
    for (int i = 0; i < count; i++) {
        each[i] = ad_row(r->p, i);
        names[i] = x->open->parameters[i].name;
        middle[i] = scene_parameter_at(&x->open->parameters[i], 0.5);
    }
    const strain_settings settings = {x->open, count, names, middle, x->mesh};
    return functions[function].of_u
               ? strain_rod_create(&settings, ad_input(r->tape, "s", 1), each, &r->rod, error)
               : AD_OK;
}

/* Coordinates of parameters, the inverse of scene_parameter_at. */
static ad_value record_network(const export_family *x, const recording *r)
{
    const int nodes = strain_mesh_nodes(&x->mesh);
    ad_value at[SCENE_PARAMETERS_MAX], rows[3 * STRAIN_ELEMENTS_MAX * STRAIN_STAGES_MAX];
    for (int i = 0; i < x->open->parameter_count; i++) {
        const scene_parameter *p = &x->open->parameters[i];
        ad_value value = ad_row(r->p, i);
        at[i] = p->scale == SCENE_LOG
                    ? ad_scale(ad_log(ad_scale(value, 1 / p->low)), 1 / log(p->high / p->low))
                    : ad_scale(ad_sub(value, ad_scalar(r->tape, p->low)), 1 / (p->high - p->low));
    }
    ad_value u = x->network(x->context, r->tape, at);
    for (int i = 0; i < 3 * nodes; i++) {
        rows[i] = ad_row(u, i % 3 * nodes + i / 3);
    }
    return ad_stack(3 * nodes, rows);
}

/* Columns of each place in turn, in SI units. */
static ad_value record_shape(const export_family *x, const recording *r, int places,
                             const double *s)
{
    scene middle;
    scene_middle(x->open, &middle);
    const rod_scales scale = rod_scales_of(&middle);
    const strain_shape shape = strain_rod_shape(r->rod, r->u, places, s);
    const struct {
        const ad_value *of;
        int rows;
        double unit;
    } fields[] = {{shape.position, 3, scale.length},
                  {shape.rotation, 4, 1},
                  {shape.strain, 3, 1},
                  {shape.curvature, 3, 1 / scale.length},
                  {shape.force, 3, scale.force},
                  {shape.moment, 3, scale.moment}};
    ad_value columns[EXPORT_FAMILY_COLUMNS];
    ad_value *all = calloc((size_t)places * EXPORT_FAMILY_COLUMNS, sizeof *all);
    if (!all) {
        ad_tape_fail(r->tape, AD_NO_MEMORY, "out of memory for a shape");
        return shape.position[0];
    }
    for (int f = 0, c = 0; f < 6; f++) {
        for (int k = 0; k < fields[f].rows; k++) {
            columns[c++] = ad_scale(fields[f].of[k], fields[f].unit);
        }
    }
    for (int i = 0; i < places * EXPORT_FAMILY_COLUMNS; i++) {
        all[i] = ad_row(columns[i % EXPORT_FAMILY_COLUMNS], i / EXPORT_FAMILY_COLUMNS);
    }
    ad_value result = ad_stack(places * EXPORT_FAMILY_COLUMNS, all);
    free(all);
    return result;
}

/* Derivatives by parameters, and where u follows them with u. */
static ad_value change_of(const recording *r, ad_value y, bool with_u)
{
    const ad_value wrt[2] = {r->p, r->u}, along[2] = {r->dp, r->du};
    ad_value result = y;
    ad_directional(1, &y, with_u ? 2 : 1, wrt, along, &result);
    return result;
}

static int record(const export_family *x, int function, const recording *r, ad_value outputs[2])
{
    const double end = 1;
    strain_change change;
    switch (function) {
    case NETWORK:
        outputs[0] = record_network(x, r);
        return 1;
    case NETWORK_BY:
        outputs[0] = change_of(r, record_network(x, r), false);
        return 1;
    case NEWTON:
        change = strain_rod_change(r->rod, r->u, r->du);
        outputs[0] = strain_rod_residual(r->rod, r->u);
        outputs[1] = change.residual;
        return 2;
    case RESIDUAL:
        outputs[0] = strain_rod_residual(r->rod, r->u);
        return 1;
    case RESIDUAL_BY:
        outputs[0] = change_of(r, strain_rod_residual(r->rod, r->u), false);
        return 1;
    case MOVED:
        change = strain_rod_change(r->rod, r->u, r->du);
        outputs[0] = ad_stack(3, change.places);
        return 1;
    case SHAPE:
        outputs[0] = record_shape(x, r, x->places, x->s);
        return 1;
    case TIP:
        outputs[0] = record_shape(x, r, 1, &end);
        return 1;
    default:
        outputs[0] = change_of(r, record_shape(x, r, 1, &end), true);
        return 1;
    }
}

static ad_status compile(const export_family *x, int function, ad_pool *pool, ad_program **program,
                         ad_error *error)
{
    const ad_settings settings = ad_settings_default();
    recording r;
    ad_value outputs[2];
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

/* The text with the name in place of @. */
static void put(const export_family *x, const char *text, FILE *file)
{
    for (; *text; text++) {
        if (*text == '@') {
            fputs(x->name, file);
        } else {
            fputc(*text, file);
        }
    }
}

/* "TIP_X" of "tip_x". */
static void put_upper(const char *name, FILE *file)
{
    for (; *name; name++) {
        fputc(toupper((unsigned char)*name), file);
    }
}

static const char *const columns[EXPORT_FAMILY_COLUMNS] = {"X",  "Y",  "Z",  "QW", "QX", "QY", "QZ",
                                                           "V1", "V2", "V3", "U1", "U2", "U3", "N1",
                                                           "N2", "N3", "M1", "M2", "M3"};

static const char head[] =
    " *\n"
    " * A member is a point of the parameters, in SI units. Its curvature u at @_NODES points of "
    "the\n"
    " * rod, three numbers each, times the length, is what a network says; steps of Newton's "
    "method\n"
    " * for the rod's equation polish it, 0, 1 or 2 of them; positions, rotations and all else "
    "follow\n"
    " * from it. The functions work in the caller's memory alone, @_MEMORY numbers, and keep "
    "nothing:\n"
    " * several may run at once, each with memory of its own. They return 0, or @_OUT_OF_RANGE "
    "where\n"
    " * a parameter is beyond its range by more than rounding, or not a number: the result is "
    "then\n"
    " * that at the nearer end of the range (of what is not a number: at its lower end). */\n";

static const char declarations[] =
    "/* What is known of an answer. Distances are the largest over the rod, in m, to where one "
    "more\n"
    " * step, linearised, leads; the error of the mesh, which is that of a converged solution, "
    "comes\n"
    " * to them. trusted: the equilibrium is stable or may be by its pivots, `predicted` is at "
    "most a\n"
    " * twentieth of the length, and the last step is at most a quarter of that before. */\n"
    "typedef struct @_answer {\n"
    "    double predicted; /* of the network */\n"
    "    double left;      /* of what is returned */\n"
    "    double ratio;     /* of the last two steps; -1: none was taken */\n"
    "    int stable, trusted;\n"
    "} @_answer;\n\n"
    "extern const double @_lower[@_PARAMETERS], @_upper[@_PARAMETERS];\n"
    "extern const char *const @_parameter_names[@_PARAMETERS], *const @_column_names[@_COLUMNS];\n"
    "extern const double @_places[@_POINTS]; /* of the shape, m */\n\n"
    "/* shape [POINTS][COLUMNS], or tip [COLUMNS], of a member with 0, 1 or 2 steps. answer may "
    "be\n"
    " * NULL: that is quicker, without steps much so. */\n"
    "int @_shape(const double *parameters, int steps, double *shape, @_answer *answer,\n"
    "            double *memory);\n"
    "int @_tip(const double *parameters, int steps, double *tip, @_answer *answer, double "
    "*memory);\n\n"
    "/* The same and derivatives by the parameters, jacobian [COLUMNS][PARAMETERS]: of the "
    "network\n"
    " * where no steps are taken, else of the equilibrium. */\n"
    "int @_tip_jacobian(const double *parameters, int steps, double *tip, double *jacobian,\n"
    "                   @_answer *answer, double *memory);\n\n"
    "/* In parts: the network's curvature [NODES][3] times the length; steps from any curvature; "
    "the\n"
    " * shape of a curvature. */\n"
    "int @_network(const double *parameters, double *curvature, double *memory);\n"
    "int @_polish(const double *parameters, int steps, double *curvature, @_answer *answer,\n"
    "             double *memory);\n"
    "int @_shape_of(const double *parameters, const double *curvature, double *shape,\n"
    "               double *memory);\n\n";

static void put_numbers(const export_family *x, const char *name, size_t number, FILE *file)
{
    fprintf(file, "#define %s_%-12s %zu\n", x->name, name, number);
}

/* Of curvature, residual, matrix, and more for inputs. */
static size_t memory_of(const export_family *x)
{
    const size_t n = 3 * (size_t)strain_mesh_nodes(&x->mesh), p = (size_t)x->open->parameter_count;
    return p + n + (n * n > p * p + n * p ? n * n : p * p + n * p) /* x */
           + n + n * n                                             /* newton */
           + n                                                     /* curvature */
           + n + 3 + n * p + x->workspace;
}

void export_family_write_header(const export_family *x, FILE *file)
{
    const int count = x->open->parameter_count;
    put(x, "/* @: ", file);
    for (const char *c = x->about; *c; c++) { /* nothing that ends the comment */
        fputc(*c == '*' || *c == '\n' || *c == '\\' ? ' ' : *c, file);
    }
    fprintf(file, ", a family of rods at rest as C99; written by cpinn %s.\n", cli_version());
    put(x, head, file);
    put(x, "#ifndef @_H\n#define @_H\n\n#ifdef __cplusplus\nextern \"C\" {\n#endif\n\n", file);
    put_numbers(x, "PARAMETERS", (size_t)count, file);
    put_numbers(x, "POINTS", (size_t)x->places, file);
    put_numbers(x, "COLUMNS", EXPORT_FAMILY_COLUMNS, file);
    put_numbers(x, "NODES", (size_t)strain_mesh_nodes(&x->mesh), file);
    put_numbers(x, "MEMORY", memory_of(x), file);
    put_numbers(x, "OUT_OF_RANGE", 1, file);
    fputs("\n/* parameters: index, range */\nenum {\n", file);
    for (int i = 0; i < count; i++) {
        const scene_parameter *p = &x->open->parameters[i];
        fprintf(file, "    %s_IN_", x->name);
        put_upper(p->name, file);
        fprintf(file, " = %d%s /* %.9g to %.9g */\n", i, i + 1 < count ? "," : "", p->low, p->high);
    }
    fputs("};\n\n/* columns: position r (m) and rotation q, strain v, curvature u (1/m), force n "
          "(N) and "
          "moment\n * m (N m) in the frame of the section */\nenum {\n",
          file);
    for (int i = 0; i < EXPORT_FAMILY_COLUMNS; i++) {
        fprintf(file, "    %s_%s = %d%s\n", x->name, columns[i], i,
                i + 1 < EXPORT_FAMILY_COLUMNS ? "," : "");
    }
    fputs("};\n\n", file);
    put(x, declarations, file);
    fputs("#ifdef __cplusplus\n}\n#endif\n\n#endif\n", file);
}

static const char algebra[] =
    "\n/* Parameters within their ranges. */\n"
    "static int place(const double *parameters, double *x)\n{\n"
    "    int i, status = 0;\n"
    "    for (i = 0; i < @_PARAMETERS; i++) {\n"
    "        const double low = @_lower[i], high = @_upper[i], rounding = (high - low) * 1e-9;\n"
    "        double value = parameters[i];\n"
    "        if (!(value >= low - rounding && value <= high + rounding)) {\n"
    "            status = @_OUT_OF_RANGE;\n        }\n"
    "        value = value >= low ? value : low; /* also what is not a number */\n"
    "        x[i] = value <= high ? value : high;\n    }\n    return status;\n}\n\n"
    "static void copy(int count, const double *from, double *to)\n{\n"
    "    int i;\n    for (i = 0; i < count; i++) {\n        to[i] = from[i];\n    }\n}\n\n"
    "static void set_unit(int n, double *x)\n{\n"
    "    int i;\n    for (i = 0; i < n * n; i++) {\n        x[i] = 0;\n    }\n"
    "    for (i = 0; i < n; i++) {\n        x[i * n + i] = 1;\n    }\n}\n\n"
    "/* Gauss' elimination of a [N][N]. A pivot makes way where one below it is a hundred times "
    "as\n"
    " * large. Returns negative pivots and exchanges, -1: the matrix is singular. */\n"
    "static int eliminate(double *a, int *rows)\n{\n"
    "    int i, j, k, negative = 0;\n"
    "    for (k = 0; k < N; k++) {\n"
    "        int best = k;\n"
    "        double by;\n"
    "        for (i = k + 1; i < N; i++) {\n"
    "            best = fabs(a[i * N + k]) > fabs(a[best * N + k]) ? i : best;\n        }\n"
    "        rows[k] = k;\n"
    "        if (fabs(a[k * N + k]) < 0.01 * fabs(a[best * N + k])) {\n"
    "            for (j = k; j < N; j++) {\n"
    "                const double held = a[k * N + j];\n"
    "                a[k * N + j] = a[best * N + j];\n"
    "                a[best * N + j] = held;\n            }\n"
    "            rows[k] = best;\n            negative++;\n        }\n"
    "        by = 1 / a[k * N + k];\n"
    "        if (!(fabs(by) < HUGE_VAL)) {\n            return -1;\n        }\n"
    "        negative += by < 0;\n"
    "        for (i = k + 1; i < N; i++) {\n"
    "            const double factor = a[i * N + k] * by;\n"
    "            a[i * N + k] = factor;\n"
    "            for (j = k + 1; j < N; j++) {\n"
    "                a[i * N + j] -= factor * a[k * N + j];\n            }\n        }\n    }\n"
    "    return negative;\n}\n\n"
    "/* x [N], its numbers `apart` from one another, becomes the solution. */\n"
    "static void solve(const double *a, const int *rows, int apart, double *x)\n{\n"
    "    int i, k;\n"
    "    for (k = 0; k < N; k++) {\n"
    "        const double at = x[rows[k] * apart];\n"
    "        x[rows[k] * apart] = x[k * apart];\n        x[k * apart] = at;\n"
    "        for (i = k + 1; i < N; i++) {\n"
    "            x[i * apart] -= a[i * N + k] * at;\n        }\n    }\n"
    "    for (k = N - 1; k >= 0; k--) {\n"
    "        const double at = x[k * apart] / a[k * N + k];\n"
    "        x[k * apart] = at;\n"
    "        for (i = 0; i < k; i++) {\n            x[i * apart] -= a[i * N + k] * at;\n        }\n"
    "    }\n}\n";

static const char answers[] =
    "\n/* Memory: inputs, residual and matrix (as newton leaves them), curvature, changes of "
    "places,\n"
    " * changes of the curvature by parameters, workspace. */\n"
    "typedef struct room {\n"
    "    double *x, *residual, *matrix, *curvature, *moved, *by, *w;\n"
    "} room;\n\n"
    "static room divide(double *memory)\n{\n"
    "    room r;\n"
    "    r.x = memory;\n"
    "    r.residual = r.x + INPUTS;\n"
    "    r.matrix = r.residual + N;\n"
    "    r.curvature = r.matrix + N * N;\n"
    "    r.moved = r.curvature + N;\n"
    "    r.by = r.moved + N + 3;\n"
    "    r.w = r.by + N * P;\n"
    "    return r;\n}\n\n"
    "/* Residual, and the matrix eliminated. */\n"
    "static int linearise(room r, const double *curvature, int *rows)\n{\n"
    "    copy(N, curvature, r.x + P);\n"
    "    set_unit(N, r.x + P + N);\n"
    "    newton(r.x, r.residual, r.w);\n"
    "    return eliminate(r.matrix, rows);\n}\n\n"
    "/* By how much a step moves the rod, m. */\n"
    "static double distance(room r, const double *curvature, const double *step)\n{\n"
    "    double most = 0;\n    int i;\n"
    "    copy(N, curvature, r.x + P);\n"
    "    copy(N, step, r.x + P + N);\n"
    "    moved(r.x, r.moved, r.w);\n"
    "    for (i = 0; i < N / 3 + 1; i++) {\n"
    "        const double *m = r.moved + i;\n"
    "        const double x = m[0], y = m[N / 3 + 1], z = m[2 * (N / 3 + 1)];\n"
    "        const double square = x * x + y * y + z * z;\n"
    "        most = square <= most ? most : square; /* also what is not a number */\n    }\n"
    "    return LENGTH * sqrt(most);\n}\n\n"
    "static double largest(const double *x)\n{\n"
    "    double most = 0;\n    int i;\n"
    "    for (i = 0; i < N; i++) {\n"
    "        most = fabs(x[i]) <= most ? most : fabs(x[i]);\n    }\n    return most;\n}\n\n"
    "/* Parameters are in r.x. */\n"
    "static void polish(room r, int steps, double *curvature, @_answer *answer)\n{\n"
    "    int rows[N], i, k;\n"
    "    double length = 0, before = 0;\n"
    "    if (answer) {\n        answer->stable = 1;\n        answer->ratio = -1;\n    }\n"
    "    for (k = 0; k < steps || (k == 0 && answer); k++) {\n"
    "        const int negative = linearise(r, curvature, rows);\n"
    "        solve(r.matrix, rows, 1, r.residual);\n"
    "        length = largest(r.residual);\n"
    "        if (answer) {\n"
    "            answer->stable = answer->stable && negative >= 0 && IS_STABLE(negative);\n"
    "            if (k == 0) {\n"
    "                answer->predicted = distance(r, curvature, r.residual);\n            }\n"
    "        }\n"
    "        for (i = 0; i < N && k < steps; i++) {\n"
    "            curvature[i] -= r.residual[i];\n        }\n    }\n"
    "    if (!answer) {\n        return;\n    }\n"
    "    answer->left = answer->predicted;\n"
    "    if (steps > 0) { /* one more, with the last matrix */\n"
    "        before = length;\n"
    "        copy(N, curvature, r.x + P);\n"
    "        residual(r.x, r.residual, r.w);\n"
    "        solve(r.matrix, rows, 1, r.residual);\n"
    "        answer->left = distance(r, curvature, r.residual);\n"
    "        answer->ratio = before > 0 ? largest(r.residual) / before : 0;\n    }\n"
    "    answer->trusted = answer->stable && answer->predicted <= 0.05 * LENGTH &&\n"
    "                      (answer->ratio <= 0.25 || answer->left <= 1e-9 * LENGTH);\n}\n\n"
    "int @_network(const double *parameters, double *curvature, double *memory)\n{\n"
    "    const room r = divide(memory);\n"
    "    const int status = place(parameters, r.x);\n"
    "    network(r.x, curvature, r.w);\n    return status;\n}\n\n"
    "int @_polish(const double *parameters, int steps, double *curvature, @_answer *answer,\n"
    "             double *memory)\n{\n"
    "    const room r = divide(memory);\n"
    "    const int status = place(parameters, r.x);\n"
    "    polish(r, steps, curvature, answer);\n    return status;\n}\n\n"
    "int @_shape_of(const double *parameters, const double *curvature, double *to, double "
    "*memory)\n"
    "{\n"
    "    const room r = divide(memory);\n"
    "    const int status = place(parameters, r.x);\n"
    "    copy(N, curvature, r.x + P);\n"
    "    shape(r.x, to, r.w);\n    return status;\n}\n\n"
    "static int find(room r, const double *parameters, int steps, @_answer *answer)\n{\n"
    "    const int status = place(parameters, r.x);\n"
    "    network(r.x, r.curvature, r.w);\n"
    "    polish(r, steps, r.curvature, answer);\n"
    "    copy(N, r.curvature, r.x + P);\n    return status;\n}\n\n"
    "int @_shape(const double *parameters, int steps, double *to, @_answer *answer,\n"
    "            double *memory)\n{\n"
    "    const room r = divide(memory);\n"
    "    const int status = find(r, parameters, steps, answer);\n"
    "    shape(r.x, to, r.w);\n    return status;\n}\n\n"
    "int @_tip(const double *parameters, int steps, double *to, @_answer *answer, double *memory)\n"
    "{\n"
    "    const room r = divide(memory);\n"
    "    const int status = find(r, parameters, steps, answer);\n"
    "    tip(r.x, to, r.w);\n    return status;\n}\n\n"
    "int @_tip_jacobian(const double *parameters, int steps, double *to, double *jacobian,\n"
    "                   @_answer *answer, double *memory)\n{\n"
    "    const room r = divide(memory);\n"
    "    const int status = find(r, parameters, steps, answer);\n"
    "    int rows[N], i;\n"
    "    tip(r.x, to, r.w);\n"
    "    if (steps > 0) { /* residual (p, u) = 0 */\n"
    "        linearise(r, r.curvature, rows);\n"
    "        set_unit(P, r.x + P + N);\n"
    "        residual_by(r.x, r.by, r.w);\n"
    "        for (i = 0; i < P; i++) {\n"
    "            solve(r.matrix, rows, P, r.by + i);\n        }\n"
    "        for (i = 0; i < N * P; i++) {\n            r.by[i] = -r.by[i];\n        }\n"
    "    } else {\n"
    "        set_unit(P, r.x + P);\n"
    "        network_by(r.x, r.by, r.w);\n"
    "        copy(N, r.curvature, r.x + P);\n"
    "        set_unit(P, r.x + P + N);\n    }\n"
    "    copy(N * P, r.by, r.x + P + N + P * P);\n"
    "    tip_by(r.x, jacobian, r.w);\n    return status;\n}\n";

static void put_list(const export_family *x, const char *name, int count, const double *list,
                     double unit, FILE *file)
{
    fprintf(file, "const double %s_%s[%d] = {", x->name, name, count);
    for (int i = 0; i < count; i++) {
        fprintf(file, "%s%.17g", i == 0 ? "" : i % 4 ? ", " : ",\n    ", list[i] * unit);
    }
    fputs("};\n", file);
}

static void write_constants(const export_family *x, FILE *file)
{
    const int count = x->open->parameter_count;
    double low[SCENE_PARAMETERS_MAX], high[SCENE_PARAMETERS_MAX];
    for (int i = 0; i < count; i++) {
        low[i] = x->open->parameters[i].low;
        high[i] = x->open->parameters[i].high;
    }
    put_list(x, "lower", count, low, 1, file);
    put_list(x, "upper", count, high, 1, file);
    put_list(x, "places", x->places, x->s, scene_length(x->open), file);
    put(x, "const char *const @_parameter_names[@_PARAMETERS] = {", file);
    for (int i = 0; i < count; i++) {
        fprintf(file, "%s\"%s\"", i ? ", " : "", x->open->parameters[i].name);
    }
    put(x, "};\nconst char *const @_column_names[@_COLUMNS] = {", file);
    for (int i = 0; i < EXPORT_FAMILY_COLUMNS; i++) {
        fprintf(file, "%s\"", i % 10 == 0 ? "\n    " : " ");
        for (const char *c = columns[i]; *c; c++) {
            fputc(tolower((unsigned char)*c), file);
        }
        fprintf(file, "\"%s", i + 1 < EXPORT_FAMILY_COLUMNS ? "," : "");
    }
    fputs("};\n\n", file);
    const size_t n = 3 * (size_t)strain_mesh_nodes(&x->mesh), p = (size_t)count;
    fprintf(file, "enum { N = %zu, P = %zu, INPUTS = %zu };\n", n, p,
            p + n + (n * n > p * p + n * p ? n * n : p * p + n * p));
    fprintf(file, "#define LENGTH %.17g\n#define IS_STABLE(negative) ((negative) %s)\n",
            scene_length(x->open), x->has_energy ? "== 0" : "% 2 == 0");
}

ad_status export_family_write_source(export_family *x, FILE *file, ad_error *error)
{
    ad_program *programs[FUNCTIONS] = {NULL};
    ad_c_options options[FUNCTIONS];
    ad_pool *pool = ad_pool_create(1);
    ad_status status = pool ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a thread");
    for (int i = 0; i < FUNCTIONS && status == AD_OK; i++) {
        options[i] = (ad_c_options){.name = functions[i].name,
                                    .points = points_of(x, i),
                                    .sets = 1,
                                    .parameters = &x->weights,
                                    .uniforms = (const double *const *const[]){NULL},
                                    .internal = true};
        status = compile(x, i, pool, &programs[i], error);
    }
    if (status == AD_OK) {
        fprintf(file,
                "/* %s, see %s.h; written by cpinn %s. */\n#include \"%s.h\"\n\n#include "
                "<stddef.h>\n\n",
                x->name, x->name, cli_version(), x->name);
        status = ad_write_c(FUNCTIONS, programs, options, false, file, &x->workspace, error);
    }
    if (status == AD_OK) {
        write_constants(x, file);
        put(x, algebra, file);
        put(x, answers, file);
    }
    for (int i = 0; i < FUNCTIONS; i++) {
        ad_program_free(programs[i]);
    }
    ad_pool_free(pool);
    return status;
}
