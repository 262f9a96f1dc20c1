/* cpinn-eval: evaluate a trained network; see --help. */
#include "tools/config/config_experiment.h"
#include "tools/files/table_file.h"
#include "tools/programs/cli.h"
#include "tools/train/clock.h"
#include "tools/train/reference.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char program[] = "cpinn-eval";

static const char summary[] =
    "Restore a trained rod from a checkpoint, or from the folder that cpinn-train wrote; say how "
    "far\n"
    "it is from the scene's reference and how fast it is evaluated; write it at points (s, t).";

static const char epilogue[] =
    "Columns written, SI units: s, t; position x, y, z; quaternion qw, qx, qy, qz (body to "
    "world);\n"
    "strains v1..v3; curvatures u1..u3; internal force n1..n3 and moment m1..m3 (body frame); and\n"
    "where time exists velocity vx, vy, vz (world) and angular velocity w1..w3 (body). Where time\n"
    "has several windows, t reaches to the end of the one at work. An existing\n"
    "--out file is replaced. Exit status: 0, or 2 with one line that says what is wrong.";

/* Repeated evaluations are timed over at least this long, in batches of at least so many points. */
static const double TIMED_SECONDS = 0.2;
enum { TIMED_POINTS = 4096 };

typedef struct options {
    const char *checkpoint, *points, *grid, *out;
    int threads;
    bool json;
} options;

/* Where the field is asked for, and what it is there. */
typedef struct samples {
    size_t count;
    double *s, *t;  /* [count] m, s; one allocation, `s` owns it */
    double *values; /* [columns][count] */
} samples;

/* From "training/...", -1 or NaN: not in the checkpoint. */
typedef struct progress {
    int64_t step, stage;
    double seconds;
} progress;

typedef struct session {
    options asked;
    experiment *e;
    checkpoint *file;
    reference *known;
    field *field;
    samples samples;
    progress progress;
    reference_errors errors;
    double rate; /* evaluations per second */
} session;

static void session_free(session *x)
{
    free(x->samples.s);
    free(x->samples.values);
    field_free(x->field);
    reference_free(x->known);
    checkpoint_free(x->file);
    experiment_free(x->e);
}

/* ---- points -------------------------------------------------------------------------------- */

static ad_status samples_make(samples *p, size_t count, ad_error *error)
{
    p->count = count;
    p->s = calloc(2 * count + 1, sizeof *p->s);
    if (!p->s) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", count);
    }
    p->t = p->s + count;
    return AD_OK;
}

/* The end of the window of time at work; those after it are not trained yet. */
static double trained_until(const experiment *e)
{
    const scene *scene = e->scene;
    int windows = scene->windows, begun = e->window + 1;
    return begun == windows ? scene->duration : scene->duration * begun / windows;
}

static ad_status points_of_grid(session *x, ad_error *error)
{
    const scene *scene = x->e->scene;
    bool dynamic = scene_is_dynamic(scene);
    const char *text = x->asked.grid ? x->asked.grid : dynamic ? "51x21" : "101x1";
    long ns, nt;
    if (!cli_grid(text, dynamic, &ns, &nt)) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "--grid %s: allowed: NSxNT, the number of points along s and t%s", text,
                       dynamic ? "" : "; this scene is static, so NT is 1");
    }
    samples *p = &x->samples;
    ad_status status = samples_make(p, (size_t)(ns * nt), error);
    for (long i = 0; status == AD_OK && i < ns * nt; i++) {
        long at_s = i % ns, at_t = i / ns;
        p->s[i] = ns > 1 ? scene->rod.length * (double)at_s / (double)(ns - 1) : 0;
        p->t[i] = nt > 1 ? trained_until(x->e) * (double)at_t / (double)(nt - 1) : 0;
    }
    return status;
}

/* A point of the file that is not in the scene; an end may be missed by rounding. */
static ad_status check_point(const char *path, const table_file *table, size_t row,
                             const char *name, double value, double limit, ad_error *error)
{
    if (value >= -REFERENCE_END_TOLERANCE * limit &&
        value <= (1 + REFERENCE_END_TOLERANCE) * limit) {
        return AD_OK;
    }
    char where[64];
    size_t line = table_line(table, row);
    snprintf(where, sizeof where, line ? "%zu" : " row %zu", line ? line : row + 1);
    return ad_fail(error, AD_BAD_INPUT,
                   "%s:%s: %s = %.10g is outside the scene; allowed: 0 to %g %s", path, where, name,
                   value, limit, *name == 's' ? "m" : "s");
}

static ad_status points_of_table(session *x, const char *path, const table_file *table,
                                 ad_error *error)
{
    const scene *scene = x->e->scene;
    const double *s = table_column(table, "s"), *t = table_column(table, "t");
    bool dynamic = scene_is_dynamic(scene);
    size_t rows = table_rows(table);
    if (!s || (dynamic && !t)) {
        return ad_fail(error, AD_BAD_INPUT, "%s: column '%s' is missing; points have columns s%s",
                       path, s ? "t" : "s", dynamic ? " and t" : "");
    }
    if (rows == 0) {
        return ad_fail(error, AD_BAD_INPUT, "%s: there are no rows; at least one is needed", path);
    }
    ad_status status = samples_make(&x->samples, rows, error);
    for (size_t i = 0; i < rows && status == AD_OK; i++) {
        x->samples.s[i] = s[i];
        x->samples.t[i] = t ? t[i] : 0;
        status = check_point(path, table, i, "s", s[i], scene->rod.length, error);
        if (status == AD_OK && dynamic) {
            status = check_point(path, table, i, "t", t[i], trained_until(x->e), error);
        }
    }
    return status;
}

static ad_status points_of_file(session *x, ad_error *error)
{
    table_file *table = NULL;
    ad_status status = table_read(x->asked.points, TABLE_FINITE, &table, error);
    if (status == AD_OK) {
        status = points_of_table(x, x->asked.points, table, error);
    }
    table_free(table);
    return status;
}

/* ---- work ---------------------------------------------------------------------------------- */

static void read_progress(session *x)
{
    progress *p = &x->progress;
    *p = (progress){-1, -1, NAN};
    checkpoint_get_int64(x->file, "training/step", &p->step, 1, NULL);
    checkpoint_get_int64(x->file, "training/stage", &p->stage, 1, NULL);
    checkpoint_get_doubles(x->file, "training/seconds", &p->seconds, 1, NULL);
}

static ad_status evaluate(session *x, ad_error *error)
{
    samples *p = &x->samples;
    size_t columns = (size_t)field_columns(x->field);
    p->values = malloc(columns * p->count * sizeof *p->values);
    if (!p->values) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", p->count);
    }
    ad_status status = field_evaluate(x->field, experiment_parameters(x->e), p->count, p->s, p->t,
                                      p->values, error);
    size_t bad = 0;
    for (size_t i = 0; status == AD_OK && i < columns * p->count; i++) {
        p->values[i] += 0.0; /* no -0 in a table */
        bad += !isfinite(p->values[i]);
    }
    if (bad) {
        cli_warn(program, "%zu of %zu values are not finite", bad, columns * p->count);
    }
    return status;
}

static ad_status write_out(const session *x, ad_error *error)
{
    const samples *p = &x->samples;
    const char *names[2 + MODEL_COLUMNS_MAX] = {"s", "t"};
    const double *columns[2 + MODEL_COLUMNS_MAX] = {p->s, p->t};
    int count = field_columns(x->field);
    for (int i = 0; i < count; i++) {
        names[2 + i] = field_column_name(x->field, i);
        columns[2 + i] = p->values + (size_t)i * p->count;
    }
    return table_write(x->asked.out, names, columns, (size_t)count + 2, p->count, error);
}

/* The asked points over and over, repeated to a batch worth timing. */
static ad_status measure(session *x, ad_error *error)
{
    const samples *p = &x->samples;
    size_t batch = p->count > TIMED_POINTS ? p->count : TIMED_POINTS, done = 0;
    double *memory = malloc((2 + (size_t)field_columns(x->field)) * batch * sizeof *memory);
    if (!memory) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", batch);
    }
    double *s = memory, *t = memory + batch, *values = memory + 2 * batch;
    for (size_t i = 0; i < batch; i++) {
        s[i] = p->s[i % p->count];
        t[i] = p->t[i % p->count];
    }
    ad_status status =
        field_evaluate(x->field, experiment_parameters(x->e), batch, s, t, values, error);
    double start = wall_seconds(), spent = 0;
    while (status == AD_OK && spent < TIMED_SECONDS) {
        status = field_evaluate(x->field, experiment_parameters(x->e), batch, s, t, values, error);
        spent = wall_seconds() - start;
        done += batch;
    }
    x->rate = (double)done / spent;
    free(memory);
    return status;
}

/* A reference that cannot be had is worth a warning: the network can still be evaluated. */
static ad_status compare(session *x, ad_error *error)
{
    if (x->e->warning[0]) {
        cli_warn(program, "no reference: %s", x->e->warning);
    } else if (reference_create(x->e, &x->known, error) != AD_OK) {
        cli_warn(program, "no reference: %s", error->message);
        x->known = NULL;
    } else if (x->known && *reference_remark(x->known)) {
        cli_warn(program, "reference: %s", reference_remark(x->known));
    }
    return x->known ? reference_compare(x->known, experiment_parameters(x->e), &x->errors, error)
                    : AD_OK;
}

/* ---- report -------------------------------------------------------------------------------- */

static void print_progress(const session *x)
{
    const progress *p = &x->progress;
    int stages = x->e->settings->stage_count;
    printf("%s: %s", x->e->settings->name, x->asked.checkpoint);
    if (p->step >= 0) {
        printf(", step %lld", (long long)p->step);
    }
    if (x->e->scene->windows > 1) {
        printf(", window %d of %d (t = 0 to %g s)", x->e->window + 1, x->e->scene->windows,
               trained_until(x->e));
    }
    if (p->stage >= stages) {
        printf(", trained to the end");
    } else if (p->stage >= 0) {
        printf(", in stage %lld of %d", (long long)p->stage + 1, stages);
    }
    if (!isnan(p->seconds)) {
        printf(", %.1f s of training", p->seconds);
    }
    putchar('\n');
}

static void print_error(const char *name, double value, const char *unit)
{
    if (!isnan(value)) {
        printf("  %-24s %.3e%s\n", name, value, unit);
    }
}

static void print_reference(const session *x)
{
    char doubt[REFERENCE_DOUBT];
    if (*reference_account(x->known)) {
        printf("reference: %s\n", reference_account(x->known));
    }
    printf("error against %s (%zu points", reference_name(x->known), reference_points(x->known));
    if (reference_left_out(x->known)) {
        printf("; %zu outside the scene left out", reference_left_out(x->known));
    }
    printf(")\n");
    print_error("position, relative L2", x->errors.position, "");
    print_error("position, largest", x->errors.position_max, " of the length");
    print_error("tip", x->errors.tip, " of the length");
    print_error("rotation, rms", x->errors.rotation, " rad");
    print_error("rotation, largest", x->errors.rotation_max, " rad");
    if (isnan(x->errors.position)) {
        printf("  the position is not a number\n");
    }
    if (reference_doubts(x->known, &x->errors, doubt)) {
        printf("  %s\n", doubt);
    }
}

static void print_report(const session *x)
{
    print_progress(x);
    if (x->known) {
        print_reference(x);
    } else if (!x->e->warning[0]) {
        printf("no reference to compare with\n");
    }
    printf("speed: %.3g evaluations per second of all %d columns, on %d thread%s\n", x->rate,
           field_columns(x->field), ad_pool_threads(x->e->pool),
           ad_pool_threads(x->e->pool) == 1 ? "" : "s");
    if (x->asked.out) {
        printf("wrote %s: %zu points\n", x->asked.out, x->samples.count);
    }
}

static void json_text(const char *name, const char *text)
{
    printf("\"%s\": ", name);
    if (!text) {
        printf("null");
        return;
    }
    putchar('"');
    for (; *text; text++) {
        if (*text == '"' || *text == '\\') {
            putchar('\\');
        }
        if ((unsigned char)*text < ' ') {
            printf("\\u%04x", (unsigned)(unsigned char)*text);
        } else {
            putchar(*text);
        }
    }
    putchar('"');
}

/* JSON has neither NaN nor infinity. */
static void json_number(const char *name, double value)
{
    printf(isfinite(value) ? "\"%s\": %.17g" : "\"%s\": null", name, value);
}

static void json_integer(const char *name, int64_t value)
{
    printf(value >= 0 ? "\"%s\": %lld" : "\"%s\": null", name, (long long)value);
}

static void print_json_reference(const session *x)
{
    if (!x->known) {
        printf("\"reference\": null");
        return;
    }
    printf("\"reference\": {");
    json_text("name", reference_name(x->known));
    printf(", \"points\": %zu, \"left_out\": %zu, ", reference_points(x->known),
           reference_left_out(x->known));
    json_number("estimated_error_over_length", reference_estimates(x->known).position_max);
    printf(", ");
    json_number("position_relative_l2", x->errors.position);
    printf(", ");
    json_number("position_max_over_length", x->errors.position_max);
    printf(", ");
    json_number("tip_over_length", x->errors.tip);
    printf(", ");
    json_number("rotation_rms_rad", x->errors.rotation);
    printf(", ");
    json_number("rotation_max_rad", x->errors.rotation_max);
    printf("}");
}

static void print_json(const session *x)
{
    printf("{");
    json_text("name", x->e->settings->name);
    printf(", ");
    json_text("checkpoint", x->asked.checkpoint);
    printf(", ");
    json_integer("step", x->progress.step);
    printf(", ");
    printf("\"window\": %d, \"windows\": %d, ", x->e->window, x->e->scene->windows);
    json_integer("stage", x->progress.stage);
    printf(", \"stages\": %d, ", x->e->settings->stage_count);
    json_number("training_seconds", x->progress.seconds);
    printf(", \"parameters\": %zu, ", x->e->count);
    print_json_reference(x);
    printf(", ");
    json_number("evaluations_per_second", x->rate);
    printf(", \"threads\": %d, \"points\": %zu, ", ad_pool_threads(x->e->pool), x->samples.count);
    json_text("out", x->asked.out);
    printf("}\n");
}

static ad_status run(session *x, ad_error *error)
{
    ad_status status = x->asked.out ? table_check_path(x->asked.out, error) : AD_OK;
    if (status != AD_OK) {
        return status;
    }
    status = config_experiment_open(x->asked.checkpoint, 0, NULL, x->asked.threads, &x->e, &x->file,
                                    error);
    if (status == AD_OK) {
        read_progress(x);
        status = x->asked.points ? points_of_file(x, error) : points_of_grid(x, error);
    }
    if (status == AD_OK) {
        status = field_create(x->e->scene, x->e->mlp, false, x->e->pool, &x->field, error);
    }
    if (status == AD_OK) {
        field_enter(x->field, x->e->window, x->e->parameters, x->e->starts);
        status = evaluate(x, error);
    }
    if (status == AD_OK && x->asked.out) {
        status = write_out(x, error);
    }
    if (status == AD_OK) {
        status = compare(x, error);
    }
    return status == AD_OK ? measure(x, error) : status;
}

int main(int argc, char **argv)
{
    session x = {.e = NULL};
    const cli_option list[] = {
        {"--points", "FILE", CLI_TEXT, &x.asked.points, 0, 0,
         "CSV or HDF5 with columns s and, where time exists, t"},
        {"--grid", "NSxNT", CLI_TEXT, &x.asked.grid, 0, 0,
         "that many points along s and t, ends included\n(default 101x1 static, 51x21 dynamic)"},
        {"--out", "FILE", CLI_TEXT, &x.asked.out, 0, 0, "write the values, as .csv, .h5 or .hdf5"},
        {"--json", NULL, CLI_FLAG, &x.asked.json, 0, 0, "report as one JSON object"},
        {"--threads", "N", CLI_INTEGER, &x.asked.threads, 0, 1024,
         "default 0: one for each processor"}};
    const cli_program about = {program, "DIR_OR_CHECKPOINT", summary, epilogue, NULL, NULL};
    int status =
        cli_parse(&about, list, sizeof list / sizeof *list, argc, argv, &x.asked.checkpoint);
    if (status != CLI_RUN) {
        return status;
    }
    if (x.asked.points && x.asked.grid) {
        return cli_fail(program, "--points and --grid are given; allowed: one of the two");
    }
    ad_error error = {.message = ""};
    status = 0;
    if (run(&x, &error) != AD_OK) {
        status = cli_fail_error(program, &error);
    } else if (x.asked.json) {
        print_json(&x);
    } else {
        print_report(&x);
    }
    session_free(&x);
    return status;
}
