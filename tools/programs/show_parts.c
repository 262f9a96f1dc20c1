/* Parts of a report that several sources have. */
#include "tools/programs/show_source.h"

#include "physics/learn/model.h"
#include "tools/train/history.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- parts of the page --------------------------------------------------------------------- */

void show_open_curve(json *to, const char *title, const char *x, const char *x_unit,
                     const char *y_unit, bool log)
{
    json_open(to, NULL, '{');
    json_text(to, "title", title);
    json_text(to, "x", x);
    json_text(to, "x_unit", x_unit);
    json_text(to, "y_unit", y_unit);
    json_text(to, "log", log ? "yes" : NULL);
    json_open(to, "series", '[');
}

void show_close_curve(json *to)
{
    json_close(to, ']');
    json_close(to, '}');
}

void show_fact(json *to, const char *name, const char *format, double value)
{
    char text[64];
    snprintf(text, sizeof text, format, value);
    json_open(to, NULL, '[');
    json_text(to, NULL, name);
    json_text(to, NULL, text);
    json_close(to, ']');
}

void show_text(json *to, const char *title, const char *text)
{
    json_open(to, NULL, '{');
    json_text(to, "title", title);
    json_text(to, "text", text);
    json_close(to, '}');
}

void show_settings(json *to, const config *settings)
{
    char *text = NULL;
    size_t size;
    FILE *file = open_memstream(&text, &size);
    json_open(to, "texts", '[');
    if (file && config_write(settings, file, false) == AD_OK && fflush(file) == 0) {
        show_text(to, "Scene and settings (YAML)", text);
    }
    json_close(to, ']');
    if (file) {
        fclose(file);
    }
    free(text);
}

void show_scene_facts(json *to, const scene *of)
{
    show_fact(to, "length", "%g m", scene_length(of));
    if (scene_is_dynamic(of)) {
        show_fact(to, "duration", "%g s", scene_duration(of));
    }
}

static void put_history_curve(json *to, const history *h, const char *title,
                              const char *const *wanted)
{
    double *columns = malloc(2 * h->count * sizeof *columns + 1), *values = columns + h->count;
    show_open_curve(to, title, "step", "", "", true);
    for (; columns && *wanted; wanted++) {
        bool any = false;
        for (size_t i = 0; i < h->count; i++) {
            columns[i] = history_value(h, i, "step");
            values[i] = history_value(h, i, *wanted);
            any = any || values[i] > 0;
        }
        if (any) {
            show_series(to, *wanted, columns, values, h->count);
        }
    }
    show_close_curve(to);
    free(columns);
}

ad_status show_history(json *to, const checkpoint *file, ad_error *error)
{
    static const char *const losses[] = {"loss", "held_out", "error", NULL};
    history h = {.columns = 0};
    for (const char *name; h.columns < HISTORY_COLUMNS_MAX &&
                           (name = checkpoint_column(file, "history/table", (size_t)h.columns));) {
        h.names[h.columns++] = name;
    }
    const ad_status status = h.columns > 0 ? history_get(&h, file, error) : AD_OK;
    if (status == AD_OK && h.count > 1) {
        put_history_curve(to, &h, "Training: loss and error", losses);
    }
    history_free(&h);
    return status;
}

/* ---- tables -------------------------------------------------------------------------------- */

const char *show_unit(const char *name, const scene *of)
{
    const scene_physics *rods = scene_physics_of(of);
    if (strcmp(name, "left") == 0 || strcmp(name, "radius") == 0) { /* of cpinn-plan */
        return "m";
    }
    for (int i = 0; i < rods->column_count; i++) {
        if (strcmp(rods->columns[i].name, name) == 0) {
            return rods->columns[i].unit;
        }
    }
    return "";
}

table_build *show_read_table_of(const table_file *from, const scene *of)
{
    scene usual;
    table_build *to = malloc(sizeof *to);
    scene_defaults(&usual);
    if (to) {
        table_begin(to, table_rows(from));
    }
    for (size_t k = 0; to && k < table_columns(from); k++) {
        const char *name = table_name(from, k);
        if (table_column(from, name)) {
            table_add(to, name, show_unit(name, of ? of : &usual), table_column(from, name), NULL);
        }
    }
    return to;
}

/* The motion, with the table of --reference as its ghost, or `ghost`. */
ad_status show_put_motion(showing *showing, const table_source *table, const char *const *labels,
                          const table_source *ghost, const char *ghost_name, ad_error *error)
{
    table_build *given = NULL;
    ad_error why;
    ad_status status = AD_OK;
    if (showing->reference_path) {
        table_shapes shapes;
        status = table_read(showing->reference_path, TABLE_NONFINITE, &showing->ghost, error);
        given = status == AD_OK ? show_read_table_of(showing->ghost, NULL) : NULL;
        if (status == AD_OK && !given) {
            status = ad_fail(error, AD_NO_MEMORY, "out of memory for a report");
        } else if (given && table_shapes_of(&given->table, &shapes, &why) != AD_OK) {
            status = ad_fail(error, AD_BAD_INPUT, "%s: %s", showing->reference_path, why.message);
        }
        ghost = given ? &given->table : ghost;
        ghost_name = showing->reference_path;
    }
    if (status == AD_OK && show_motion(&showing->to, table, labels, ghost, ghost_name,
                                       &showing->kept, &why) != AD_OK) {
        status = ad_fail(error, why.status, "%s: %s", showing->source, why.message);
    }
    free(given);
    return status;
}

ad_status show_choose_points(showing *showing, const scene *of, double until, ad_error *error)
{
    return samples_choose(&showing->samples, &(samples_asked){.grid = showing->grid},
                          scene_is_dynamic(of) ? "81x201" : NULL, of, until, error);
}

ad_status show_put_shapes(showing *showing, const scene *of, const char *const *labels,
                          const table_source *ghost, const char *ghost_name, ad_error *error)
{
    samples_table to;
    ad_status status = samples_fill(&showing->samples, false, &to, error);
    if (status != AD_OK) {
        return status;
    }
    status = show_put_motion(showing, &to.of.table, labels, ghost, ghost_name, error);
    if (status == AD_OK) {
        status =
            show_scene(&showing->to, of, showing->samples.parameters, &showing->kept, NULL, error);
    }
    samples_table_free(&to);
    return status;
}

void show_title_of(showing *showing, const char *path)
{
    const char *slash = strrchr(path, '/'), *name = slash && slash[1] ? slash + 1 : path;
    const char *dot = strrchr(name, '.');
    snprintf(showing->title, sizeof showing->title, "%.*s",
             (int)(dot && dot > name ? dot - name : 150), name);
}
