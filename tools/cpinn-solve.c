/* cpinn-solve: solve a scene classically; see --help. */
#include "physics/field.h"
#include "tools/cli.h"
#include "tools/clock.h"
#include "tools/files/table_file.h"
#include "tools/reference.h"
#include "tools/solve/solve.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char program[] = "cpinn-solve";

static const char summary[] =
    "Solve the scene of a YAML file without a network: collocation at Gauss points along the rod,\n"
    "Newton's method, and continuation of the load from 0, with an estimate of the error. The\n"
    "equations are written separately from those that networks are trained on, so each checks the\n"
    "other; --out gives a scene a reference to train against (reference.file).";

static const char epilogue[] =
    "A rod may have several equilibria. This finds the one that continues the unstressed rod "
    "while\n"
    "the load grows: a straight column stays straight. --perturb 10 pushes it sideways on the way\n"
    "and takes the push away at the end, which leads to the buckled shape.\n"
    "\n"
    "Columns written are those of cpinn-eval, in SI units. An existing --out file is replaced.\n"
    "\n"
    "  cpinn-solve configs/heavy_cantilever.yaml --out reference.csv\n"
    "  cpinn-solve configs/elastica.yaml --work-precision classical.csv\n"
    "  cpinn-bench configs/elastica.yaml --curve classical.csv\n"
    "\n"
    "Exit status: 0; 1 with one line if the whole load or the tolerance was not reached; 2 with "
    "one\n"
    "line that says what is wrong with the input.";

typedef struct options {
    const char *config, *grid, *out, *work_precision;
    cli_list overrides;
    double tolerance, perturbation;
    int nodes;
    bool quiet;
} options;

/* Where the rod is asked for, and what it is there, in SI units. */
typedef struct samples {
    size_t count;
    double *s, *t;  /* [count]; one allocation, `s` owns it */
    double *values; /* [columns][count] */
} samples;

typedef struct session {
    options asked;
    config *settings; /* NULL once the experiment has them */
    const scene *scene;
    experiment *e;    /* with a reference only */
    reference *known; /* the same */
    solution *solved;
    solve_report report;
    double seconds;
} session;

static void session_free(session *x)
{
    solution_free(x->solved);
    reference_free(x->known);
    experiment_free(x->e);
    config_free(x->settings);
}

/* ---- samples ------------------------------------------------------------------------------- */

static int columns_of(const scene *scene)
{
    enum { RATES = 6 };
    return scene_is_dynamic(scene) ? FIELD_COLUMNS_MAX : FIELD_COLUMNS_MAX - RATES;
}

_Static_assert(sizeof(solve_state) == FIELD_COLUMNS_MAX * sizeof(double), "a state is its columns");

/* What one unit of each column is in SI. */
static void units_of(const rod_scales *scale, double *units)
{
    const double of[8] = {scale->length,
                          1,
                          1,
                          1 / scale->length,
                          scale->force,
                          scale->moment,
                          scale->length / scale->time,
                          1 / scale->time};
    const int rows[8] = {3, 4, 3, 3, 3, 3, 3, 3};
    for (int i = 0; i < 8; i++) {
        for (int k = 0; k < rows[i]; k++) {
            *units++ = of[i];
        }
    }
}

/* Values at points in SI, `s` within the rod; consecutive points of one time are evaluated
 * together. */
static ad_status evaluate(const solution *solved, const samples *p, int columns, ad_error *error)
{
    const rod_scales scale = solution_rod(solved)->scales;
    double *s = malloc(p->count * sizeof *s), units[FIELD_COLUMNS_MAX];
    solve_state *states = malloc(p->count * sizeof *states);
    ad_status status = s && states
                           ? AD_OK
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", p->count);
    units_of(&scale, units);
    for (size_t i = 0; status == AD_OK && i < p->count; i++) {
        s[i] = fmin(1, fmax(0, p->s[i] / scale.length));
    }
    for (size_t first = 0, end; status == AD_OK && first < p->count; first = end) {
        for (end = first; end < p->count && p->t[end] == p->t[first]; end++) {
        }
        status = solution_at(solved, end - first, s + first, p->t[first] / scale.time,
                             states + first, error);
    }
    for (size_t i = 0; status == AD_OK && i < p->count; i++) {
        for (int c = 0; c < columns; c++) {
            const double *row = (const double *)&states[i];
            p->values[(size_t)c * p->count + i] = row[c] * units[c] + 0.0; /* no -0 in a table */
        }
    }
    free(s);
    free(states);
    return status;
}

static void samples_free(samples *p)
{
    free(p->s);
    free(p->values);
}

/* The points that --grid asks for, or their default. */
static ad_status grid_of(const session *x, long *ns, long *nt, ad_error *error)
{
    bool dynamic = scene_is_dynamic(x->scene);
    const char *text = x->asked.grid ? x->asked.grid : dynamic ? "51x21" : "101x1";
    return cli_grid(text, dynamic, ns, nt)
               ? AD_OK
               : ad_fail(error, AD_BAD_ARGUMENT,
                         "--grid %s: allowed: NSxNT, the number of points along s and t%s", text,
                         dynamic ? "" : "; this scene is static, so NT is 1");
}

static ad_status samples_of_grid(const session *x, samples *p, int columns, ad_error *error)
{
    long ns, nt;
    ad_status status = grid_of(x, &ns, &nt, error);
    if (status != AD_OK) {
        return status;
    }
    p->count = (size_t)(ns * nt);
    p->s = malloc(2 * p->count * sizeof *p->s);
    p->values = malloc((size_t)columns * p->count * sizeof *p->values);
    if (!p->s || !p->values) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", p->count);
    }
    p->t = p->s + p->count;
    for (long i = 0; i < ns * nt; i++) {
        long at_s = i % ns, at_t = i / ns;
        p->s[i] = ns > 1 ? x->scene->rod.length * (double)at_s / (double)(ns - 1) : 0;
        p->t[i] = nt > 1 ? x->scene->duration * (double)at_t / (double)(nt - 1) : 0;
    }
    return AD_OK;
}

static ad_status write_out(const session *x, size_t *points, ad_error *error)
{
    const char *names[2 + FIELD_COLUMNS_MAX] = {"s", "t"};
    const double *columns[2 + FIELD_COLUMNS_MAX];
    int count = columns_of(x->scene);
    samples p = {0};
    ad_status status = samples_of_grid(x, &p, count, error);
    if (status == AD_OK) {
        status = evaluate(x->solved, &p, count, error);
    }
    if (status == AD_OK) {
        columns[0] = p.s;
        columns[1] = p.t;
        for (int i = 0; i < count; i++) {
            names[2 + i] = field_column_name(i);
            columns[2 + i] = p.values + (size_t)i * p.count;
        }
        status = table_write(x->asked.out, names, columns, (size_t)count + 2, p.count, error);
    }
    *points = p.count;
    samples_free(&p);
    return status;
}

/* ---- report -------------------------------------------------------------------------------- */

static void print_number(const char *name, double value)
{
    if (isinf(value)) {
        printf(", %s locked", name);
    } else if (value > 0) {
        printf(", %s %.4g", name, value);
    }
}

static void print_scene(const session *x, const char *name)
{
    rod_numbers n = rod_numbers_of(x->scene);
    printf("%s: %s", name, scene_is_dynamic(x->scene) ? "dynamic" : "static");
    print_number("shear kGA L^2/EI", n.shear_ratio);
    print_number("stretch EA L^2/EI", n.axial_ratio);
    print_number("tip force F L^2/EI", n.tip_force);
    print_number("tip moment T L/EI", n.tip_moment);
    print_number("line load f L^3/EI", n.distributed_force);
    print_number("line moment l L^2/EI", n.distributed_moment);
    print_number("weight rhoA g L^3/EI", n.weight);
    print_number("duration", n.duration);
    putchar('\n');
}

static void print_error(const char *name, double value, const char *unit)
{
    if (!isnan(value)) {
        printf("  %-24s %.3e%s\n", name, value, unit);
    }
}

static ad_status print_reference(session *x, ad_error *error)
{
    samples p = {.count = reference_points(x->known)};
    p.s = malloc(2 * p.count * sizeof *p.s);
    p.values = malloc(FIELD_POSE * p.count * sizeof *p.values);
    ad_status status =
        p.s && p.values ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for points");
    if (status == AD_OK) {
        p.t = p.s + p.count;
        memcpy(p.s, reference_s(x->known), p.count * sizeof *p.s);
        memcpy(p.t, reference_t(x->known), p.count * sizeof *p.t);
        status = evaluate(x->solved, &p, FIELD_POSE, error);
    }
    if (status == AD_OK) {
        reference_errors errors = reference_compare_poses(x->known, p.values);
        printf("difference from %s (%zu points)\n", reference_name(x->known), p.count);
        print_error("position, relative L2", errors.position, "");
        print_error("position, largest", errors.position_max, " of the length");
        print_error("tip", errors.tip, " of the length");
        print_error("rotation, largest", errors.rotation_max, " rad");
    }
    samples_free(&p);
    return status;
}

static ad_status print_report(session *x, ad_error *error)
{
    const solve_report *r = &x->report;
    solve_state tip;
    double s = 1, length = x->scene->rod.length, end = solution_rod(x->solved)->duration;
    ad_status status = solution_at(x->solved, 1, &s, end, &tip, error);
    if (status != AD_OK) {
        return status;
    }
    printf("solved: %d nodes, ", r->nodes);
    if (scene_is_dynamic(x->scene)) {
        printf("%ld steps of time, ", r->time_steps);
    } else {
        printf("load in %ld step%s, %ld Newton steps, ", r->load_steps,
               r->load_steps == 1 ? "" : "s", r->newton_steps);
    }
    printf("%.1f ms\n", 1e3 * x->seconds);
    print_error("estimated error", r->estimate, " of the length");
    printf("  %-24s %.15g %.15g %.15g m\n", "tip", tip.position[0] * length + 0.0,
           tip.position[1] * length + 0.0, tip.position[2] * length + 0.0);
    if (r->may_buckle) {
        printf("pushed from both ends: of possibly several equilibria this one continues %s\n",
               x->asked.perturbation == 0
                   ? "the unstressed\nrod; --perturb 10 looks for a buckled one"
                   : "the rod\nas it was perturbed");
    }
    return x->known ? print_reference(x, error) : AD_OK;
}

static bool reached(const session *x)
{
    return scene_is_dynamic(x->scene) || x->report.load_fraction == 1;
}

/* What was not reached, in one line; 1, or 0 when there is nothing to say. */
static int complain(const session *x)
{
    const solve_report *r = &x->report;
    if (!reached(x)) {
        cli_warn(program,
                 "stopped at %.6g of the load: beyond it the equilibria that continue the "
                 "unstressed rod end, turn back or need more nodes; try --perturb 10, a smaller "
                 "load, or a stiffness that is not infinite",
                 r->load_fraction);
        return 1;
    }
    if (x->asked.nodes == 0 && !(r->estimate <= x->asked.tolerance)) {
        cli_warn(program,
                 "estimated error %.2g of the length with %d nodes, above --tol %.2g; try a larger "
                 "tolerance; jumps in loads or rest shape converge slowly",
                 r->estimate, r->nodes, x->asked.tolerance);
        return 1;
    }
    return 0;
}

/* ---- work and precision -------------------------------------------------------------------- */

enum { SWEEP_MAX = 24, REPEATS = 5 };
static const double FINEST = 1e-12;   /* tolerance of the solution to compare with */
static const double SMALLEST = 1e-16; /* error told, since curves are drawn over logarithms */

typedef struct sweep {
    int count;
    double nodes[SWEEP_MAX], seconds[SWEEP_MAX], errors[SWEEP_MAX];
} sweep;

/* Relative L2 of positions, as cpinn-bench measures it. */
static double distance(const samples *p, const double *exact)
{
    double off = 0, size = 0;
    for (size_t i = 0; i < 3 * p->count; i++) {
        off += (p->values[i] - exact[i]) * (p->values[i] - exact[i]);
        size += exact[i] * exact[i];
    }
    return sqrt(off / size);
}

/* One row: the median time of a few solutions, everything included, and the error. */
static ad_status sweep_at(const session *x, const solve_settings *settings, samples *p,
                          const double *exact, sweep *rows, ad_error *error)
{
    double seconds[REPEATS];
    solution *solved = NULL;
    solve_report report;
    ad_status status = AD_OK;
    for (int i = 0; i < REPEATS && status == AD_OK; i++) {
        solution_free(solved);
        double start = wall_seconds();
        status = solution_create(x->scene, settings, &solved, &report, error);
        double spent = wall_seconds() - start;
        int k = i;
        for (; k > 0 && seconds[k - 1] > spent; k--) {
            seconds[k] = seconds[k - 1];
        }
        seconds[k] = spent;
    }
    if (status == AD_OK) {
        status = evaluate(solved, p, FIELD_POSE, error);
    }
    if (status == AD_OK && report.load_fraction == 1) {
        rows->nodes[rows->count] = report.nodes;
        rows->seconds[rows->count] = seconds[REPEATS / 2];
        rows->errors[rows->count++] = fmax(SMALLEST, distance(p, exact));
    }
    solution_free(solved);
    return status;
}

static ad_status sweep_write(const session *x, const sweep *rows, ad_error *error)
{
    static const char *const names[3] = {"seconds", "error", "nodes"};
    const double *columns[3] = {rows->seconds, rows->errors, rows->nodes};
    if (!x->asked.quiet) {
        printf("%6s %10s %12s\n", "nodes", "ms", "error");
        for (int i = 0; i < rows->count; i++) {
            printf("%6.0f %10.3f %12.2e\n", rows->nodes[i], 1e3 * rows->seconds[i],
                   rows->errors[i]);
        }
    }
    return table_write(x->asked.work_precision, names, columns, 3, (size_t)rows->count, error);
}

/* More and more nodes, against the solution at hand, until rounding stops it. */
static ad_status work_precision(const session *x, ad_error *error)
{
    static const int nodes[] = {2,  3,  4,  5,  6,  8,  10,  12,  16,
                                20, 24, 32, 48, 64, 96, 128, 192, 256};
    static const double rounding = 1e-14;
    solve_settings settings = {.perturbation = x->asked.perturbation};
    sweep rows = {0};
    samples p = {0};
    ad_status status = samples_of_grid(x, &p, FIELD_POSE, error);
    double *exact = status == AD_OK ? malloc(3 * p.count * sizeof *exact) : NULL;
    if (status == AD_OK && !exact) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", p.count);
    }
    if (status == AD_OK) {
        status = evaluate(x->solved, &p, FIELD_POSE, error);
    }
    if (status == AD_OK) {
        memcpy(exact, p.values, 3 * p.count * sizeof *exact);
    }
    for (size_t i = 0; i < sizeof nodes / sizeof *nodes && status == AD_OK; i++) {
        settings.nodes = nodes[i];
        status = sweep_at(x, &settings, &p, exact, &rows, error);
        if (rows.count > 0 && rows.errors[rows.count - 1] < rounding) {
            break;
        }
    }
    if (status == AD_OK) {
        status = sweep_write(x, &rows, error);
    }
    free(exact);
    samples_free(&p);
    return status;
}

/* ---- the program --------------------------------------------------------------------------- */

/* A reference needs the experiment around the scene. */
static ad_status open_reference(session *x, ad_error *error)
{
    if (x->settings->reference == CONFIG_REFERENCE_NONE && !x->settings->reference_file) {
        return AD_OK;
    }
    config *settings = x->settings;
    x->settings = NULL;
    ad_status status = experiment_create(settings, 1, &x->e, error);
    if (status == AD_OK) {
        x->scene = &x->e->settings->scene;
        status = reference_create(x->e, &x->known, error);
    }
    return status;
}

static ad_status solve(session *x, ad_error *error)
{
    options *o = &x->asked;
    double tolerance = o->work_precision ? fmin(o->tolerance, FINEST) : o->tolerance;
    const solve_settings settings = {tolerance, o->nodes, o->perturbation};
    double start = wall_seconds();
    ad_status status = solution_create(x->scene, &settings, &x->solved, &x->report, error);
    x->seconds = wall_seconds() - start;
    return status;
}

static ad_status run(session *x, ad_error *error)
{
    options *o = &x->asked;
    size_t points = 0;
    char name[128];
    ad_status status =
        config_read(o->config, NULL, o->overrides.count, o->overrides.texts, &x->settings, error);
    if (status != AD_OK) {
        return status;
    }
    x->scene = &x->settings->scene;
    snprintf(name, sizeof name, "%s", x->settings->name);
    long ns, nt;
    status = grid_of(x, &ns, &nt, error);
    if (status == AD_OK) {
        status = open_reference(x, error);
    }
    if (status == AD_OK) {
        status = solve(x, error);
    }
    if (status != AD_OK || !reached(x)) {
        return status;
    }
    if (o->out) {
        status = write_out(x, &points, error);
    }
    if (status == AD_OK && !o->quiet) {
        print_scene(x, name);
        status = print_report(x, error);
        if (o->out) {
            printf("wrote %s: %zu points\n", o->out, points);
        }
    }
    if (status == AD_OK && o->work_precision) {
        status = work_precision(x, error);
    }
    return status;
}

int main(int argc, char **argv)
{
    session x = {.asked = {.tolerance = 1e-10}};
    options *o = &x.asked;
    const cli_option list[] = {
        {"--tol", "X", CLI_NUMBER, &o->tolerance, 1e-13, 1,
         "refine until the position is estimated to be within so many\nlengths (default 1e-10)"},
        {"--nodes", "N", CLI_INTEGER, &o->nodes, 1, 6000,
         "so many nodes along the rod, without refinement and estimate"},
        {"--perturb", "X", CLI_NUMBER, &o->perturbation, -1e6, 1e6,
         "push the rod sideways while the load grows, by X EI/L^3 per\nlength: finds buckled "
         "shapes"},
        {"--out", "FILE", CLI_TEXT, &o->out, 0, 0, "write the values, as .csv, .h5 or .hdf5"},
        {"--grid", "NSxNT", CLI_TEXT, &o->grid, 0, 0,
         "where: that many points along s and t, ends included\n(default 101x1 static)"},
        {"--work-precision", "CSV", CLI_TEXT, &o->work_precision, 0, 0,
         "solve with more and more nodes; print and write run time and\nerror against the finest, "
         "for cpinn-bench --curve CSV"},
        {"--set", "KEY=VALUE", CLI_LIST, &o->overrides, 0, 0,
         "change one key, as in --set loads.tip.force[2]=-10;\nmay be repeated"},
        {"--quiet", NULL, CLI_FLAG, &o->quiet, 0, 0, "say nothing but errors"}};
    const cli_program about = {program, "CONFIG.yaml", summary, epilogue, NULL, NULL};
    int status = cli_parse(&about, list, sizeof list / sizeof *list, argc, argv, &o->config);
    if (status != CLI_RUN) {
        return status;
    }
    if (o->nodes > 0 && o->work_precision) {
        return cli_fail(program, "--nodes and --work-precision are given; allowed: one of the two");
    }
    ad_error error = {.message = ""};
    status = run(&x, &error) == AD_OK ? complain(&x) : cli_fail_error(program, &error);
    session_free(&x);
    return status;
}
