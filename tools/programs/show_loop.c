/* cpinn-show: a closed loop, the record of cpinn-control --out with the robot's shapes beside it.
 */
#include "tools/files/file_bytes.h"
#include "tools/programs/control_judge.h"
#include "tools/programs/show_source.h"
#include "tools/train/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct looped {
    showing *x;
    const table_source *record;
    const double *t, *wanted[4], *found[4], *estimated[4]; /* t, x, y, z; estimated: or NULL */
    double *off, *missed;                                  /* [rows] m */
    config *nominal, *plant;                               /* NULL: no --scene */
    table_file *shapes;                                    /* NULL: there are none */
} looped;

/* ---- the record ---------------------------------------------------------------------------- */

static const double *column_of(const looped *l, const char *kind, const char *name)
{
    char text[TABLE_MAX_NAME + 1];
    snprintf(text, sizeof text, "%s_%.50s", kind, name);
    return table_source_column(l->record, text);
}

static bool places_of(const looped *l, const char *kind, const double *columns[4])
{
    columns[0] = l->t;
    for (int k = 0; k < 3; k++) {
        columns[1 + k] = column_of(l, kind, (const char *const[]){"x", "y", "z"}[k]);
    }
    return columns[0] && columns[1] && columns[2] && columns[3];
}

static void distances(const looped *l, const double *const a[4], const double *const b[4],
                      double *apart)
{
    for (size_t i = 0; i < l->record->nrows; i++) {
        apart[i] = hypot(hypot(a[1][i] - b[1][i], a[2][i] - b[2][i]), a[3][i] - b[3][i]);
    }
}

static ad_status read_record(looped *l, ad_error *error)
{
    const size_t rows = l->record->nrows;
    l->t = table_source_column(l->record, "t");
    if (!places_of(l, "true", l->found) || !places_of(l, "reference", l->wanted) || rows == 0) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%s: needs rows, and columns t, reference_x to _z and true_x to _z",
                       l->x->source);
    }
    l->off = malloc(2 * rows * sizeof *l->off);
    if (!l->off) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a report");
    }
    l->missed = l->off + rows;
    distances(l, l->found, l->wanted, l->off);
    if (places_of(l, "estimated", l->estimated)) {
        distances(l, l->estimated, l->found, l->missed);
    } else {
        l->estimated[1] = NULL;
    }
    return AD_OK;
}

/* ---- the verdict --------------------------------------------------------------------------- */

static void put_errors(const looped *l)
{
    const control_settings *c = l->nominal ? &l->nominal->control : NULL;
    const size_t rows = l->record->nrows;
    const double approach = c && c->task.approach > 0 ? c->task.approach : 0;
    const double period = rows > 1 ? l->t[1] - l->t[0] : 0;
    loop_report report = {.done = (long)rows, .reach = NAN};
    for (size_t i = 0; i < rows; i++) {
        report.diverged = report.diverged || !isfinite(l->off[i]) ||
                          (c && !(l->off[i] < scene_length(&l->nominal->scene)));
        if (l->t[i] >= approach - 1e-9 * period) {
            report.rms += l->off[i] * l->off[i];
            report.worst = fmax(report.worst, l->off[i]);
            report.judged++;
        }
    }
    report.rms = sqrt(report.rms / (double)report.judged);
    for (int i = 0; c && i < c->estimate_count; i++) {
        const double *found = column_of(l, "estimate", c->estimate[i]);
        const double *deviation = column_of(l, "deviation", c->estimate[i]);
        const double *truth = column_of(l, "truth", c->estimate[i]);
        report.estimate[i] = found ? found[rows - 1] : NAN;
        report.deviation[i] = deviation ? deviation[rows - 1] : NAN;
        report.truth[i] = truth ? truth[rows - 1] : NAN;
    }
    if (c) {
        verdict judged = {.count = 0};
        control_judge(c, &report, &judged);
        report_verdict(&l->x->to, &judged);
    }
    json_open(&l->x->to, "facts", '[');
    show_fact(&l->x->to, "duration", "%g s", l->t[rows - 1]);
    show_fact(&l->x->to, "period", "%g ms", 1e3 * period);
    show_fact(&l->x->to,
              c ? "off the path after the approach, rms" : "off the path, rms, approach included",
              "%.3g mm", 1e3 * report.rms);
    show_fact(&l->x->to, "at most", "%.3g mm", 1e3 * report.worst);
    json_close(&l->x->to, ']');
}

/* ---- curves -------------------------------------------------------------------------------- */

static bool has_curve(const char *name)
{
    static const char *const kinds[] = {"input_",     "estimate_",      "deviation_",     "truth_",
                                        "constraint", "filter_seconds", "control_seconds"};
    bool has = false;
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        has = has || strncmp(name, kinds[i], strlen(kinds[i])) == 0;
    }
    return has;
}

/* Columns, and what constraints allow if the scene is known: the page makes curves of them. */
static void put_curves(const looped *l)
{
    const table_source *r = l->record;
    const control_settings *c = l->nominal ? &l->nominal->control : NULL;
    json *to = &l->x->to;
    json_open(to, "loop", '{');
    json_open(to, "columns", '[');
    size_t kept = show_thinned(to, "t", l->t, r->nrows);
    show_thinned(to, "place off the path", l->off, r->nrows);
    if (l->estimated[1]) {
        show_thinned(to, "estimate off the place", l->missed, r->nrows);
    }
    for (size_t k = 0; k < r->ncols; k++) {
        if (has_curve(r->names[k])) {
            show_thinned(to, r->names[k], r->columns[k], r->nrows);
        }
    }
    json_close(to, ']');
    json_integer(to, "rows", (int64_t)kept);
    json_open(to, "limits", '[');
    for (int k = 0; c && k < c->limit_count; k++) {
        json_open(to, NULL, '[');
        json_number(to, NULL, c->limits[k].low);
        json_number(to, NULL, c->limits[k].high);
        json_close(to, ']');
    }
    json_close(to, ']');
    json_close(to, '}');
}

/* ---- the robot ----------------------------------------------------------------------------- */

static table_source places(const looped *l, const double *const columns[4])
{
    static const char *const names[] = {"t", "x", "y", "z"}, *const units[] = {"s", "m", "m", "m"};
    return (table_source){
        .names = names, .columns = columns, .ncols = 4, .nrows = l->record->nrows, .units = units};
}

/* NAME_shapes.h5 beside NAME.csv, if it is there. */
static ad_status read_shapes(looped *l, ad_error *error)
{
    char path[TABLE_PATH_MAX];
    table_shapes_beside(l->x->source, path);
    if (access(path, F_OK) != 0) {
        return AD_OK;
    }
    const ad_status status = table_read(path, TABLE_NONFINITE, &l->shapes, error);
    return status != AD_OK || table_column(l->shapes, "t")
               ? status
               : ad_fail(error, AD_BAD_INPUT, "%s: has no column t", file_bytes_shown(path));
}

/* Row of the record at an instant of a shape. */
static size_t row_at(const looped *l, double t)
{
    size_t low = 0, high = l->record->nrows - 1;
    while (low < high) {
        const size_t middle = (low + high) / 2;
        if (l->t[middle] < t - 1e-9) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

/* Members of the plant: inputs as they were, the truth of what is estimated. To be freed; NULL: out
 * of memory. */
static double *find_members(const looped *l, const table_shapes *at)
{
    const scene *of = &l->plant->scene;
    const size_t count = (size_t)of->parameter_count;
    double *values = malloc(at->frames * count * sizeof *values + 1);
    for (size_t k = 0; k < count && values; k++) {
        const scene_parameter *p = &of->parameters[k];
        const double *input = column_of(l, "input", p->name);
        input = input ? input : column_of(l, "truth", p->name);
        for (size_t i = 0; i < at->frames; i++) {
            const double now = input ? input[row_at(l, at->t[i * at->points])] : NAN;
            values[i * count + k] = isfinite(now) ? now : scene_parameter_at(p, 0.5);
        }
    }
    return values;
}

static const char *const shape_names[] = {"s", "t", "x", "y", "z"};

/* Where the filter believes that the robot is, as columns of shapes [5], is taken out of a table;
 * how far that is off [rows] takes its place. False: it is not there. */
static bool take_beliefs(table_build *read, const double *columns[5], double *off)
{
    table_source *table = &read->table;
    const double *place[3];
    bool known = true;
    for (int k = 0; k < 5; k++) {
        char name[32];
        snprintf(name, sizeof name, "%s%s", k < 2 ? "" : "estimated_", shape_names[k]);
        columns[k] = table_source_column(table, name);
        place[k < 2 ? 0 : k - 2] = table_source_column(table, shape_names[k]);
        known = known && columns[k];
    }
    if (!known || !place[0] || !place[1] || !place[2]) {
        return false;
    }
    for (size_t i = 0; i < table->nrows; i++) {
        off[i] = hypot(hypot(columns[2][i] - place[0][i], columns[3][i] - place[1][i]),
                       columns[4][i] - place[2][i]);
    }
    const size_t all = table->ncols;
    table->ncols = 0; /* and begins anew, over what it was */
    for (size_t k = 0; k < all; k++) {
        if (strncmp(read->names[k], "estimated_", 10) != 0) {
            table_add(read, read->names[k], read->units[k], read->columns[k], NULL);
        }
    }
    table_add(read, "estimate off", "m", off, NULL);
    return true;
}

static ad_status put_robot(looped *l, ad_error *error)
{
    table_build *read = show_read_table_of(l->shapes, NULL);
    double *off = read ? malloc(read->table.nrows * sizeof *off + 1) : NULL;
    if (!off) {
        free(read);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a report");
    }
    const double *columns[5];
    const bool known = take_beliefs(read, columns, off);
    const table_source ghost = {
        .names = shape_names, .columns = columns, .ncols = 5, .nrows = read->table.nrows};
    table_shapes at;
    double *members = NULL;
    ad_status status = table_shapes_of(&read->table, &at, error);
    if (status == AD_OK && l->plant && !(members = find_members(l, &at))) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a report");
    }
    status = status == AD_OK ? show_put_motion(l->x, &read->table, NULL, known ? &ghost : NULL,
                                               "as the filter believes", error)
                             : status;
    if (status == AD_OK && l->plant) {
        const scene *of = &l->plant->scene;
        status = show_scene(&l->x->to, of, of->parameter_count > 0 ? members : NULL, &l->x->kept,
                            NULL, error);
    }
    free(members);
    free(off);
    free(read);
    return status;
}

/* ---- all of it ----------------------------------------------------------------------------- */

static ad_status put_all(looped *l, ad_error *error)
{
    showing *showing = l->x;
    const table_source place = places(l, l->found), wanted = places(l, l->wanted);
    put_errors(l);
    put_curves(l);
    ad_status status =
        l->shapes ? put_robot(l, error) : show_put_motion(showing, &place, NULL, NULL, NULL, error);
    if (status == AD_OK) {
        json_open(&showing->to, "paths", '[');
        status = show_path(&showing->to, "wanted path", &wanted, error);
        status =
            status == AD_OK ? show_path(&showing->to, "path of the place", &place, error) : status;
        json_close(&showing->to, ']');
    }
    if (status == AD_OK && l->nominal) {
        show_settings(&showing->to, l->nominal);
    }
    return status;
}

ad_status show_loop(showing *showing, const table_source *table, ad_error *error)
{
    looped l = {.x = showing, .record = table};
    ad_status status = showing->at
                           ? ad_fail(error, AD_BAD_INPUT,
                                     "--at: a closed loop has values of its parameters itself")
                           : read_record(&l, error);
    if (status == AD_OK && showing->scene_path) {
        status = prepare_read_robot(showing->scene_path, showing->overrides.count,
                                    showing->overrides.texts, &l.nominal, &l.plant, error);
    }
    status = status == AD_OK ? read_shapes(&l, error) : status;
    status = status == AD_OK ? put_all(&l, error) : status;
    table_free(l.shapes);
    config_free(l.nominal);
    config_free(l.plant);
    free(l.off);
    return status;
}
