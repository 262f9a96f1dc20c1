/* cpinn-show: a family of which the page computes the shapes. */
#include "tools/programs/show_source.h"

#include "physics/learn/model.h"
#include "physics/rod/strain.h"
#include "tools/library/cpinn.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

enum { MEMBERS = 128, STEPS = 2 };

/* Of an answer that is not trusted: the first reasons of the library. */
enum { REASONS = CPINN_REASON_NOT_SETTLING + 1 };

typedef struct module {
    show_drawn drawn;
    char *scene, *bytes; /* a text; the module */
    size_t length, size;
} module;

/* One instant. */
static ad_status keep(show_kept *kept, size_t points, const double *s, ad_error *error)
{
    kept->frame = calloc(1, sizeof *kept->frame);
    kept->point = calloc(points, sizeof *kept->point);
    kept->t = calloc(1, sizeof *kept->t);
    kept->s = malloc(points * sizeof *kept->s);
    if (!kept->frame || !kept->point || !kept->t || !kept->s) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a report");
    }
    kept->frames = 1;
    kept->points = points;
    memcpy(kept->s, s, points * sizeof *s);
    return AD_OK;
}

/* What is drawn is known when the scene has been written, which shows that it can be; on the page
 * it is once there is a module. */
static ad_status make(const showing *showing, const double *middle, const show_kept *kept,
                      module *made, ad_error *error)
{
    json text;
    json_begin(&text);
    ad_status status = show_scene(&text, showing->e->scene, middle, kept, &made->drawn, error);
    if (json_take(&text, &made->scene, &made->length, error) != AD_OK) {
        status = AD_NO_MEMORY;
    }
    return status == AD_OK
               ? export_module_create(showing->e, (int)kept->points, kept->s, made->drawn.count,
                                      made->drawn.list, &made->bytes, &made->size, error)
               : status;
}

/* Members all over the ranges and their tips, NaN where they are not trusted: numbers [MEMBERS]
 * [parameters + 3]. */
static ad_status put_members(json *to, const scene *of, cpinn_family *family, size_t points,
                             ad_error *error)
{
    const cpinn_polish polish = {.steps = STEPS, .alone = true};
    const size_t count = (size_t)of->parameter_count, row = count + 3,
                 columns = (size_t)cpinn_family_columns(family);
    cpinn_answer answers[MEMBERS];
    double *parameters = malloc(MEMBERS * (count + row + points * columns) * sizeof *parameters);
    if (!parameters) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a report");
    }
    double *numbers = parameters + MEMBERS * count, *values = numbers + MEMBERS * row;
    show_spread(of, MEMBERS, parameters);
    const ad_status status =
        cpinn_family_evaluate(family, &polish, MEMBERS, parameters, values, answers, error);
    for (size_t i = 0; i < MEMBERS; i++) {
        memcpy(numbers + i * row, parameters + i * count, count * sizeof *numbers);
        for (size_t k = 0; k < 3; k++) {
            numbers[i * row + count + k] =
                answers[i].trusted ? values[((i + 1) * points - 1) * columns + k] : NAN;
        }
    }
    json_integer(to, "members", MEMBERS);
    json_bytes(to, "tips", numbers, MEMBERS * row * sizeof *numbers);
    free(parameters);
    return status;
}

static void put_parameters(json *to, const scene *of)
{
    json_open(to, "parameters", '[');
    for (int i = 0; i < of->parameter_count; i++) {
        const scene_parameter *p = &of->parameters[i];
        json_open(to, NULL, '{');
        json_text(to, "name", p->name);
        json_number(to, "low", p->low);
        json_number(to, "high", p->high);
        json_text(to, "log", p->scale == SCENE_LOG ? "yes" : NULL);
        json_text(to, "actuates", scene_parameter_actuates(of, i) ? "yes" : NULL);
        json_close(to, '}');
    }
    json_close(to, ']');
}

static void put_columns(json *to, const scene *of)
{
    const model_column *known = scene_physics_of(of)->columns;
    json_open(to, "columns", '[');
    for (int i = 0; i < STRAIN_COLUMNS; i++) {
        json_open(to, NULL, '{');
        json_text(to, "name", known[i].name);
        json_text(to, "unit", known[i].unit);
        json_close(to, '}');
    }
    json_close(to, ']');
    json_open(to, "reasons", '[');
    for (int i = 0; i < REASONS; i++) {
        json_text(to, NULL, cpinn_reason_text((cpinn_reason)i));
    }
    json_close(to, ']');
}

/* Packed, as DecompressionStream("deflate") of browsers unpacks it. */
static ad_status put_module(json *to, const module *made, ad_error *error)
{
    uLongf size = compressBound((uLong)made->size);
    Bytef *packed = malloc(size);
    const bool done = packed && compress2(packed, &size, (const Bytef *)made->bytes,
                                          (uLong)made->size, Z_BEST_COMPRESSION) == Z_OK;
    if (done) {
        json_bytes(to, "module", packed, size);
    }
    free(packed);
    return done ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a report");
}

static ad_status put_live(showing *showing, const module *made, cpinn_family *family,
                          ad_error *error)
{
    json *to = &showing->to;
    const scene *of = showing->e->scene;
    const show_kept *kept = &showing->kept;
    json_open(to, "live", '{');
    json_integer(to, "points", (int64_t)kept->points);
    json_integer(to, "steps", STEPS);
    json_integer(to, "drawn", made->drawn.count);
    json_number(to, "length", scene_length(of));
    json_number(to, "tolerance", CPINN_TOLERANCE * scene_length(of)); /* of the library's own */
    json_open(to, "s", '[');
    show_column(to, "s", "m", kept->s, kept->points, false);
    json_close(to, ']');
    put_parameters(to, of);
    put_columns(to, of);
    ad_status status = put_members(to, of, family, kept->points, error);
    status = status == AD_OK ? put_module(to, made, error) : status;
    json_close(to, '}');
    return status;
}

ad_status show_live(showing *showing, cpinn_family *family, size_t points, const double *s,
                    bool *is_live, ad_error *error)
{
    const scene *of = showing->e->scene;
    double middle[SCENE_PARAMETERS_MAX];
    module made = {.bytes = NULL};
    show_kept kept = {.frames = 0};
    ad_error why = {.message = ""};
    *is_live = false;
    if (*cpinn_family_without_error(family)) {
        return AD_OK;
    }
    for (int i = 0; i < of->parameter_count; i++) {
        middle[i] = scene_parameter_at(&of->parameters[i], 0.5);
    }
    ad_status status = keep(&kept, points, s, error);
    if (status == AD_OK && make(showing, middle, &kept, &made, &why) != AD_OK) {
        char text[sizeof why.message + 160];
        snprintf(text, sizeof text, "Shapes were computed beforehand. %s%s%s",
                 why.status == AD_IO
                     ? "With clang and lld (Debian: apt-get install clang lld) this "
                       "page computes them for any parameters: "
                     : "This page cannot compute them: ",
                 why.message, why.message[strlen(why.message) - 1] == '.' ? "" : ".");
        json_text(&showing->to, "advice", text);
        show_kept_free(&kept);
    } else if (status == AD_OK) {
        showing->kept = kept;
        json_add(&showing->to, made.scene, made.length);
        status = put_live(showing, &made, family, error);
        *is_live = status == AD_OK;
    }
    free(made.scene);
    free(made.drawn.list);
    free(made.bytes);
    return status;
}
