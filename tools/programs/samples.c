#include "tools/programs/samples.h"

#include "physics/numerics/clock.h"
#include "tools/programs/cli.h"
#include "tools/programs/section_size.h"
#include "tools/train/reference.h"

#include <math.h>
#include <stdlib.h>

ad_status samples_make(samples *p, size_t count, ad_error *error)
{
    p->count = count;
    p->s = calloc(2 * count + 1, sizeof *p->s);
    p->t = p->s ? p->s + count : NULL;
    return p->s ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", count);
}

void samples_free(samples *p)
{
    free(p->s);
    free(p->parameters);
    free(p->values);
    free(p->slopes);
    free(p->said);
}

size_t samples_rows(const samples *p)
{
    return p->members ? p->members * p->count : p->count;
}

static ad_status take_grid(samples *p, const char *grid, const scene *scene, double until,
                           ad_error *error)
{
    bool dynamic = scene_is_dynamic(scene);
    const char *text = grid ? grid : dynamic ? "51x21" : "101";
    long ns, nt;
    if (!cli_grid(text, dynamic, &ns, &nt)) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "--grid %s: allowed: NSxNT, the number of points along s and t%s", text,
                       dynamic ? "" : "; this scene is static, so NT is 1");
    }
    ad_status status = samples_make(p, (size_t)(ns * nt), error);
    for (long i = 0; status == AD_OK && i < ns * nt; i++) {
        long at_s = i % ns, at_t = i / ns;
        p->s[i] = ns > 1 ? scene_length(scene) * (double)at_s / (double)(ns - 1) : 0;
        p->t[i] = nt > 1 ? until * (double)at_t / (double)(nt - 1) : 0;
    }
    return status;
}

/* Refuses a point of the file that lies outside the scene by more than rounding. */
static ad_status check_point(const char *path, const table_file *table, size_t row,
                             const char *name, double value, double first, double limit,
                             ad_error *error)
{
    if (value >= first - REFERENCE_END_TOLERANCE * limit &&
        value <= (1 + REFERENCE_END_TOLERANCE) * limit) {
        return AD_OK;
    }
    char where[64];
    size_t line = table_line(table, row);
    snprintf(where, sizeof where, line ? "%zu" : " row %zu", line ? line : row + 1);
    return ad_fail(error, AD_BAD_INPUT,
                   "%s:%s: %s = %.10g is outside the scene; allowed: %g to %g %s", path, where,
                   name, value, first, limit, *name == 's' ? "m" : "s");
}

static ad_status take_points(samples *p, const char *path, const table_file *table,
                             const scene *scene, double until, ad_error *error)
{
    const double *s, *t = NULL, length = scene_length(scene);
    bool dynamic = scene_is_dynamic(scene);
    size_t rows = table_rows(table);
    ad_status status = table_find(table, "s", TABLE_FINITE, &s, error);
    if (status == AD_OK && dynamic) {
        status = table_find(table, "t", TABLE_FINITE, &t, error);
    }
    if (status != AD_OK) {
        return status;
    }
    if (!s || (dynamic && !t)) {
        return ad_fail(error, AD_BAD_INPUT, "%s: column '%s' is missing; points have columns s%s",
                       path, s ? "t" : "s", dynamic ? " and t" : "");
    }
    if (rows == 0) {
        return ad_fail(error, AD_BAD_INPUT, "%s: there are no rows; at least one is needed", path);
    }
    status = samples_make(p, rows, error);
    for (size_t i = 0; i < rows && status == AD_OK; i++) {
        p->t[i] = t ? t[i] : 0;
        p->s[i] = scene_at_place(scene, s[i], p->t[i]);
        status = check_point(path, table, i, "s", s[i], scene_place_at(scene, NULL, 0, p->t[i]),
                             scene_place_at(scene, NULL, length, p->t[i]), error);
        if (status == AD_OK && dynamic) {
            status = check_point(path, table, i, "t", t[i], 0, until, error);
        }
    }
    return status;
}

static ad_status take_file(samples *p, const char *path, const scene *scene, double until,
                           ad_error *error)
{
    table_file *table = NULL;
    ad_status status = table_read(path, TABLE_MEASURED, &table, error);
    if (status == AD_OK) {
        status = take_points(p, path, table, scene, until, error);
    }
    table_free(table);
    return status;
}

ad_status samples_choose(samples *p, const samples_asked *asked, const char *usual,
                         const scene *scene, double until, ad_error *error)
{
    return asked->points ? take_file(p, asked->points, scene, until, error)
                         : take_grid(p, asked->grid ? asked->grid : usual, scene, until, error);
}

int samples_check(const char *program, const samples_asked *asked, bool needs)
{
    return asked->points && asked->grid
               ? cli_fail(program, "--points and --grid are given; allowed: one of the two")
           : (asked->points || asked->grid) && !needs
               ? cli_fail(program, "%s: nothing would be written there; give --out FILE too",
                          asked->grid ? "--grid" : "--points")
               : CLI_RUN;
}

/* ---- asking -------------------------------------------------------------------------------- */

/* [rows][columns] as [columns][rows], without -0, which has no place in a table. */
static void turn(size_t rows, size_t columns, const double *from, double *to)
{
    for (size_t k = 0; k < columns * rows; k++) {
        to[k % columns * rows + k / columns] = from[k] + 0.0;
    }
}

static ad_status ask_for_members(samples *p, const answer *a, ad_error *error)
{
    const size_t rows = samples_rows(p), columns = (size_t)p->columns;
    const size_t slopes = p->derives ? columns * (size_t)a->scene->parameter_count : 0;
    double *values = malloc(((columns + slopes) * rows + 1) * sizeof *values);
    double *jacobian = values && p->derives ? values + columns * rows : NULL;
    p->said = calloc(p->members + 1, sizeof *p->said);
    p->slopes = p->derives ? malloc((slopes * rows + 1) * sizeof *p->slopes) : NULL;
    ad_status status = values && p->said && (!p->derives || p->slopes)
                           ? AD_OK
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu rows", rows);
    if (status == AD_OK) {
        const double start = clock_seconds(CLOCK_MONOTONIC);
        status =
            a->kind->of_members(a, p->members, p->parameters, values, jacobian, p->said, error);
        p->seconds = clock_seconds(CLOCK_MONOTONIC) - start;
    }
    if (status == AD_OK) {
        turn(rows, columns, values, p->values);
        turn(rows, slopes, jacobian, p->slopes);
    }
    free(values);
    return status;
}

ad_status samples_ask(samples *p, const answer *a, ad_error *error)
{
    const size_t numbers = (size_t)a->columns * samples_rows(p);
    p->of = a->scene;
    p->columns = a->columns;
    free(p->values);
    free(p->slopes);
    free(p->said);
    p->said = NULL;
    p->slopes = NULL;
    p->values = calloc(numbers + 1, sizeof *p->values);
    if (!p->values) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu numbers", numbers);
    }
    if (a->kind->of_members) {
        return ask_for_members(p, a, error);
    }
    if (p->derives && !a->kind->change_at_points) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "derivatives by parameters are of members of a family; this is one shape");
    }
    ad_status status = a->kind->at_points(a, p->count, p->s, p->t, p->values, error);
    for (size_t i = 0; i < numbers && status == AD_OK; i++) {
        p->values[i] += 0.0;
    }
    if (p->derives && status == AD_OK) {
        p->slopes = malloc((numbers * (size_t)a->scene->parameter_count + 1) * sizeof *p->slopes);
        status = p->slopes ? a->kind->change_at_points(a, p->count, p->s, p->t, p->slopes, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for derivatives");
    }
    return status;
}

/* ---- as a table ---------------------------------------------------------------------------- */

/* Columns that are not the model's: those from ERROR on say what is said of a member. */
enum { MEMBER, PLACE, INSTANT, ERROR, TRUSTED, OUTSIDE, NUMBERS, SOURCE = NUMBERS, REASON, OWN };

static const struct {
    const char *name, *unit;
} own[OWN] = {[MEMBER] = {"member", ""}, [PLACE] = {"s", "m"},        [INSTANT] = {"t", "s"},
              [ERROR] = {"error", "m"},  [TRUSTED] = {"trusted", ""}, [OUTSIDE] = {"outside", ""},
              [SOURCE] = {"source", ""}, [REASON] = {"reason", ""}};

/* NULL: it is of no family. */
static const double *values_of(const samples *p, size_t member)
{
    return p->parameters ? p->parameters + member * (size_t)p->of->parameter_count : NULL;
}

static double number(const samples *p, int which, size_t row)
{
    const size_t member = row / p->count, point = row % p->count;
    return which == MEMBER  ? (double)member + 1
           : which == PLACE ? scene_place_at(p->of, values_of(p, member), p->s[point], p->t[point])
           : which == INSTANT ? p->t[point]
           : which == ERROR   ? p->said[member].error
           : which == TRUSTED ? p->said[member].trusted
                              : p->said[member].outside;
}

static void add_own(const samples *p, samples_table *to, int which)
{
    const size_t rows = to->of.table.nrows;
    double *numbers = to->numbers + (size_t)which * rows;
    const char **texts = to->texts + (size_t)(which % NUMBERS) * rows;
    for (size_t i = 0; i < rows; i++) {
        if (which < NUMBERS) {
            numbers[i] = number(p, which, i);
        } else {
            const cpinn_answer *said = &p->said[i / p->count];
            texts[i] =
                which == SOURCE ? cpinn_source_word(said->source) : cpinn_reason_word(said->reason);
        }
    }
    table_add(&to->of, own[which].name, own[which].unit, numbers, which < NUMBERS ? NULL : texts);
}

static void add_slopes(const samples *p, samples_table *to)
{
    const int count = p->of->parameter_count;
    const int given = scene_given_count(p->of), known = scene_known_count(p->of);
    for (int k = 0; k < p->columns * count; k++) {
        if (scene_is_dynamic(p->of) && k % count >= given && k % count < known) {
            continue; /* states of memory */
        }
        snprintf(to->names[k], sizeof to->names[k], "%s_by_%s",
                 scene_physics_of(p->of)->columns[k / count].name,
                 p->of->parameters[k % count].name);
        table_add(&to->of, to->names[k], "", p->slopes + (size_t)k * samples_rows(p), NULL);
    }
}

ad_status samples_fill(const samples *p, bool told, samples_table *to, ad_error *error)
{
    const model_column *model = scene_physics_of(p->of)->columns;
    const size_t rows = samples_rows(p);
    const size_t slopes = p->slopes ? (size_t)(p->columns * p->of->parameter_count) : 0;
    const bool timed = !p->members || scene_is_dynamic(p->of);
    to->memory = (ad_memory){0};
    AD_TAKE(to, numbers, OWN * rows + 1);
    AD_TAKE(to, texts, 2 * rows + 1);
    AD_TAKE(to, names, slopes + 1);
    if (to->memory.is_short) {
        samples_table_free(to);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a table of %zu rows", rows);
    }
    table_begin(&to->of, rows);
    for (int k = p->members ? MEMBER : PLACE; k < ERROR - !timed; k++) {
        add_own(p, to, k);
    }
    for (int k = 0; k < p->columns; k++) {
        table_add(&to->of, model[k].name, model[k].unit, p->values + (size_t)k * rows, NULL);
    }
    for (int k = ERROR; k < OWN && p->members && told; k++) {
        add_own(p, to, k);
    }
    if (told && p->slopes) {
        add_slopes(p, to);
    }
    return AD_OK;
}

void samples_table_free(samples_table *to)
{
    ad_memory_free(&to->memory);
}

ad_status samples_write(const samples *p, const char *path, ad_error *error)
{
    samples_table to;
    ad_status status = samples_fill(p, true, &to, error);
    if (status == AD_OK) {
        status = section_write(path, &to.of.table, p->of, false, error);
        samples_table_free(&to);
    }
    return status;
}
