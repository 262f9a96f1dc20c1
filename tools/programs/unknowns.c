#include "tools/programs/unknowns.h"

#include "physics/numerics/clock.h"
#include "tools/files/file_bytes.h"
#include "tools/files/table_shapes.h"
#include "tools/prepare/config_experiment.h"
#include "tools/programs/estimates.h"
#include "tools/programs/section_size.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const scene_parameter *unknown_of(const unknowns *unknowns, int index)
{
    const scene *open = unknowns->open;
    return &open->parameters[scene_known_count(open) + index];
}

/* Whether --at has a value for a name. */
static bool is_given(const char *at, const char *name)
{
    const size_t length = strlen(name);
    for (const char *item = at; item; item = strchr(item, ',')) {
        item += strspn(item, ", ");
        if (strncmp(item, name, length) == 0 && strchr(" =", item[length]) && item[length]) {
            return true;
        }
    }
    return false;
}

bool unknowns_leave_family(const unknowns *unknowns, const char *at)
{
    const scene *open = &unknowns->settings->scene;
    bool left = false;
    for (int i = 0; i < scene_given_count(open); i++) {
        left = left || !is_given(at, open->parameters[i].name);
    }
    return left;
}

/* What was asked for by --at, and values of the unknowns. */
static void join_at(unknowns *unknowns, const char *at, const double *values)
{
    size_t used = (size_t)snprintf(unknowns->at, sizeof unknowns->at, "%s", at ? at : "");
    for (int i = 0; i < unknowns->open->unknown_count && used < sizeof unknowns->at; i++) {
        used += (size_t)snprintf(unknowns->at + used, sizeof unknowns->at - used, "%s%s=%.17g",
                                 used ? ", " : "", unknown_of(unknowns, i)->name, values[i]);
    }
}

static ad_status search(unknowns *unknowns, int threads, fit_run *run, ad_error *error)
{
    const double start = clock_seconds(CLOCK_MONOTONIC);
    const least_squares_runner runner = fit_run_by(run);
    ad_status status = fit_run_ask(run, unknowns->settings, error, "# unknowns of a scene\n");
    if (status == AD_OK) {
        status = config_identify(unknowns->settings, threads, unknowns->modes, &runner,
                                 &unknowns->found, error);
    }
    unknowns->seconds = clock_seconds(CLOCK_MONOTONIC) - start;
    return status;
}

ad_status unknowns_find(const char *scene_file, const cli_list *overrides, const char *at,
                        int threads, bool wants_rows, fit_run *run, unknowns *unknowns,
                        ad_error *error)
{
    bool given = false;
    ad_status status = config_read(scene_file, NULL, overrides->count, overrides->texts,
                                   &unknowns->settings, error);
    if (status != AD_OK) {
        return status;
    }
    unknowns->open = &unknowns->settings->scene;
    for (int i = 0; i < unknowns->open->unknown_count; i++) {
        given = given || is_given(at, unknown_of(unknowns, i)->name);
    }
    const bool searches = unknowns->open->unknown_count > 0;
    const bool has_data = unknowns->settings->settings.data_count > 0;
    if (given || !(searches || has_data)) {
        unknowns_free(unknowns);
        return AD_OK;
    }
    status = prepare_config(unknowns->settings, error);
    if (status != AD_OK) {
        return status;
    }
    if (at && has_data) {
        config *member; /* what is wrong with it is said before the search */
        join_at(unknowns, at, unknowns->open->guess + scene_known_count(unknowns->open));
        status = prepare_read_member(scene_file, NULL, overrides->count, overrides->texts,
                                     unknowns->at, &member, error);
        if (status != AD_OK) {
            return status;
        }
        config_free(member);
    }
    status = searches ? search(unknowns, threads, run, error) : AD_OK;
    if (status == AD_OK && !run->signal) {
        join_at(unknowns, at, unknowns->found.value);
        status = config_judge(unknowns->settings, threads, unknowns->modes, &unknowns->found,
                              &unknowns->fit, wants_rows ? &unknowns->rows : NULL, error);
    }
    return status;
}

void unknowns_free(unknowns *x)
{
    config_free(x->settings);
    measured_rows_free(x->rows);
    *x = (unknowns){.settings = NULL};
}

void unknowns_verdict(const unknowns *unknowns, verdict *result)
{
    if (unknowns->found.count > 0) {
        identified_verdict(&unknowns->found, unknowns->open, result);
    }
    for (int i = 0; i < unknowns->fit.count; i++) {
        const judged_set *set = &unknowns->fit.set[i];
        const char *why = unknowns->fit.unsolved.message;
        if (set->unsolved > 0) {
            verdict_add(
                result, VERDICT_MISFIT,
                "data[%d]: there is no solution for %zu rows of %.60s, so that nobody knows "
                "how far they are off%s%.300s",
                set->entry, set->unsolved,
                file_bytes_name(unknowns->settings->settings.data[set->entry].file),
                *why ? ": " : "", why);
        }
    }
}

/* ---- for people ---------------------------------------------------------------------------- */

static void print_correlations(const unknowns *unknowns)
{
    static const double SMALL = 0.3;
    const identified *found = &unknowns->found;
    int shown = 0;
    for (int i = 0; i < found->count; i++) {
        for (int k = 0; k < i; k++) {
            if (fabs(found->information.correlation[i][k]) >= SMALL) {
                printf("%s%s %s %+.2f", shown++ ? ", " : "  correlations             ",
                       unknown_of(unknowns, k)->name, unknown_of(unknowns, i)->name,
                       found->information.correlation[i][k]);
            }
        }
    }
    if (shown) {
        putchar('\n');
    }
}

/* How far the scene is from each file. */
static void print_fit(const unknowns *unknowns)
{
    const judged *fit = &unknowns->fit;
    for (int i = 0; i < fit->count; i++) {
        const judged_set *set = &fit->set[i];
        const train_data *data = &unknowns->settings->settings.data[set->entry];
        if (i == 0) {
            printf("  %-24s %6s %10s %10s %10s %10s %12s\n", "measured less computed", "rows",
                   "rms", "mean", "median", "worst", "chi squared");
        }
        printf("  %-24.24s %6zu %10.4g %10.4g %10.4g %10.4g %12.4g%s\n",
               file_bytes_name(data->file), set->rows, set->rms, set->mean, set->median, set->worst,
               set->chi_squared, set->held_out ? "  held out" : "");
    }
}

static void print_found(const unknowns *unknowns)
{
    const identified *found = &unknowns->found;
    printf("identified from %zu numbers", found->residuals);
    if (found->solutions > 0) { /* without a network */
        printf(" of %zu experiment%s: %d steps, %ld solutions%s, %.1f ms", found->experiments,
               found->experiments == 1 ? "" : "s", found->steps, found->solutions,
               found->by_members ? " in batches" : "", 1e3 * unknowns->seconds);
    }
    if (found->missing > 0) {
        printf("; %zu more are missing", found->missing);
    }
    putchar('\n');
    for (int i = 0; i < found->count; i++) {
        printf("  %-24s %.6g", unknown_of(unknowns, i)->name, found->value[i]);
        const char *end = found->bounded[i] ? ", an end of its range" : "";
        if (found->held[i]) {
            puts(end);
        } else if (found->information.deviation[i] > SOLVE_UNTOLD) {
            puts(", no better known than by its range");
        } else {
            printf(" +- %.2g%s\n", found->deviation[i], end);
        }
    }
    print_correlations(unknowns);
    printf("  %-24s %.4g of %zu degrees of freedom", "chi squared",
           found->chi_squared / (found->noise_factor * found->noise_factor),
           found->residuals - (size_t)found->count);
    if (found->scaled) {
        printf(", by a noise of %.3g", found->noise_factor);
    }
    putchar('\n');
}

void unknowns_print(const unknowns *unknowns)
{
    if (unknowns->found.count > 0) {
        print_found(unknowns);
    }
    print_fit(unknowns);
}

ad_status unknowns_write(const unknowns *unknowns, const char *path, bool quiet, ad_error *error)
{
    char beside[TABLE_PATH_MAX];
    const table_source *rows = measured_rows_table(unknowns->rows);
    const table_source *shapes = measured_rows_shapes(unknowns->rows);
    table_shapes_beside(path, beside);
    ad_status status = table_write(path, rows, error);
    status = status == AD_OK ? section_write(beside, shapes, unknowns->open, true, error) : status;
    if (status == AD_OK && !quiet) {
        printf("wrote %s: %zu rows; %s has the shapes, cpinn-show makes a page of both\n", path,
               rows->nrows, file_bytes_name(beside));
    }
    return status;
}

/* ---- as JSON ------------------------------------------------------------------------------- */

static void write_unknown(const unknowns *unknowns, int i, json *to)
{
    const identified *found = &unknowns->found;
    estimate_open(to, unknown_of(unknowns, i)->name, found->value[i], found->deviation[i]);
    json_number(to, "low", unknown_of(unknowns, i)->low);
    json_number(to, "high", unknown_of(unknowns, i)->high);
    json_text(to, "known_by",
              found->bounded[i]                                ? "end_of_range"
              : found->information.deviation[i] > SOLVE_UNTOLD ? "range"
                                                               : "measurements");
    json_close(to, '}');
}

static void write_fit(const unknowns *unknowns, json *to)
{
    if (unknowns->fit.count == 0) {
        json_null(to, "files");
        return;
    }
    json_open(to, "files", '[');
    for (int i = 0; i < unknowns->fit.count; i++) {
        const judged_set *set = &unknowns->fit.set[i];
        const train_data *data = &unknowns->settings->settings.data[set->entry];
        json_open(to, NULL, '{');
        json_text(to, "file", data->file);
        json_text(to, "quantity", train_quantity_names()[data->quantity]);
        json_text(to, "judged", measured_how(unknowns->open, set->held_out));
        json_integer(to, "rows", (long long)set->rows);
        json_number(to, "rms", set->rms);
        json_number(to, "mean", set->mean);
        json_number(to, "median", set->median);
        json_number(to, "worst", set->worst);
        json_number(to, "chi_squared", set->chi_squared);
        json_integer(to, "numbers", (long long)set->numbers);
        json_integer(to, "unsolved", (long long)set->unsolved);
        json_close(to, '}');
    }
    json_close(to, ']');
}

static void write_found(const unknowns *unknowns, json *to)
{
    const identified *found = &unknowns->found;
    if (found->count == 0) {
        json_text(to, "identified", NULL);
        return;
    }
    json_open(to, "identified", '{');
    json_open(to, "unknowns", '[');
    for (int i = 0; i < found->count; i++) {
        write_unknown(unknowns, i, to);
    }
    json_close(to, ']');
    json_open(to, "correlations", '[');
    for (int i = 0; i < found->count; i++) {
        json_open(to, NULL, '[');
        for (int k = 0; k < found->count; k++) {
            json_number(to, NULL, found->information.correlation[i][k]);
        }
        json_close(to, ']');
    }
    json_close(to, ']');
    json_open(to, "not_told", '[');
    for (int i = 0; i < found->information.untold; i++) {
        json_open(to, NULL, '{'); /* a direction, in parts of the ranges */
        for (int k = 0; k < found->count; k++) {
            json_number(to, unknown_of(unknowns, k)->name, found->information.direction[i][k]);
        }
        json_close(to, '}');
    }
    json_close(to, ']');
    json_number(to, "collinearity", found->information.collinearity);
    json_open(to, "others", '['); /* values that suit as well */
    for (int i = 0; i < found->others; i++) {
        json_open(to, NULL, '{');
        for (int k = 0; k < found->count; k++) {
            json_number(to, unknown_of(unknowns, k)->name, found->other[i].value[k]);
        }
        json_number(to, "chi_squared", found->other[i].chi_squared);
        json_close(to, '}');
    }
    json_close(to, ']');
    json_number(to, "chi_squared", found->chi_squared);
    json_integer(to, "numbers", (long long)found->residuals);
    json_integer(to, "missing", (long long)found->missing);
    json_integer(to, "experiments", (long long)found->experiments);
    json_number(to, "noise_factor", found->noise_factor);
    json_integer(to, "steps", found->steps);
    json_integer(to, "solutions", found->solutions);
    json_number(to, "seconds", unknowns->seconds);
    json_close(to, '}');
}

void unknowns_json(const unknowns *unknowns, json *to)
{
    write_found(unknowns, to);
    write_fit(unknowns, to);
}
