/* cpinn-show: some members of a family at rest, solved as one batch. */
#include "tools/programs/show_source.h"

#include "physics/model.h"
#include "physics/solve/solve_members.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MEMBERS = 9, POINTS = 101, COLUMNS = 2 + SOLVE_MEMBERS_COLUMNS, LABEL = 120 };

typedef struct fan {
    double s[POINTS], *parameters, *values; /* [MEMBERS][parameters], [MEMBERS][POINTS][..] */
    double *columns[COLUMNS];               /* [solved POINTS]; the first owns all */
    solve_member results[MEMBERS];
    char texts[MEMBERS][LABEL];
    const char *labels[MEMBERS];
    size_t solved;
} fan;

void show_spread(const scene *of, int members, double *parameters)
{
    const int count = scene_known_count(of);
    double g = 1.5;
    for (int i = 0; i < 60; i++) {
        g = pow(1 + g, 1.0 / (count + 1));
    }
    for (int i = 0; i < members; i++) {
        for (int k = 0; k < count; k++) {
            const double part =
                count == 1 ? (double)i / (members - 1) : fmod(0.5 + (i + 1) * pow(g, -k - 1), 1);
            parameters[i * count + k] = scene_parameter_at(&of->parameters[k], part);
        }
    }
}

/* "tension_1 = 2, share = 0.5". */
static void describe(const scene *of, const double *parameters, char text[LABEL])
{
    size_t used = 0;
    *text = '\0';
    for (int k = 0; k < scene_known_count(of) && used < LABEL; k++) {
        const int more = snprintf(text + used, LABEL - used, "%s%.40s = %.3g", k > 0 ? ", " : "",
                                  of->parameters[k].name, parameters[k]);
        used += more > 0 ? (size_t)more : 0;
    }
}

static ad_status solve(const scene *of, fan *f, ad_error *error)
{
    solve_members *members = NULL;
    for (int i = 0; i < POINTS; i++) {
        f->s[i] = scene_length(of) * i / (POINTS - 1);
    }
    const solve_members_settings settings = {
        .tolerance = 1e-6, .threads = 1, .points = POINTS, .s = f->s};
    ad_status status = solve_members_create(of, &settings, &members, error);
    if (status == AD_OK) {
        status = solve_members_solve(members, MEMBERS, f->parameters, f->values, f->results, error);
    }
    solve_members_free(members);
    return status;
}

/* Members that are solved, one after the other. */
static void sort(const scene *of, fan *f)
{
    const size_t count = (size_t)scene_known_count(of);
    for (size_t i = 0; i < MEMBERS; i++) {
        const double *shape = f->values + i * POINTS * SOLVE_MEMBERS_COLUMNS;
        if (!f->results[i].solved) {
            continue;
        }
        const size_t first = f->solved * POINTS;
        for (size_t j = 0; j < POINTS; j++) {
            f->columns[0][first + j] = (double)f->solved;
            f->columns[1][first + j] = f->s[j];
            for (size_t k = 0; k < SOLVE_MEMBERS_COLUMNS; k++) {
                f->columns[2 + k][first + j] = shape[j * SOLVE_MEMBERS_COLUMNS + k];
            }
        }
        memmove(f->parameters + f->solved * count, f->parameters + i * count,
                count * sizeof *f->parameters);
        describe(of, f->parameters + f->solved * count, f->texts[f->solved]);
        f->labels[f->solved] = f->texts[f->solved];
        f->solved++;
    }
}

static ad_status show_fan(showing *showing, const scene *of, fan *f, ad_error *error)
{
    const char *names[COLUMNS] = {"member", "s"}, *units[COLUMNS] = {"", "m"};
    const scene_physics *rods = scene_physics_of(of);
    for (int k = 0; k < SOLVE_MEMBERS_COLUMNS; k++) {
        names[2 + k] = rods->columns[k].name;
        units[2 + k] = rods->columns[k].unit;
    }
    const table_source table = {.names = names,
                                .columns = (const double *const *)f->columns,
                                .units = units,
                                .ncols = COLUMNS,
                                .nrows = f->solved * POINTS};
    json_open(&showing->to, "facts", '[');
    show_scene_facts(&showing->to, of);
    show_fact(&showing->to, "members without an equilibrium", "%.0f",
              (double)(MEMBERS - f->solved));
    json_close(&showing->to, ']');
    showing->of = of;
    showing->members = f->parameters;
    ad_status status = show_put_motion(showing, &table, f->labels, NULL, NULL, error);
    status = status == AD_OK
                 ? show_scene(&showing->to, of, f->parameters, &showing->kept, NULL, error)
                 : status;
    showing->of = NULL;
    showing->members = NULL;
    return status;
}

ad_status show_members(showing *showing, ad_error *error)
{
    const scene *of = &showing->settings->scene;
    const size_t rows = (size_t)MEMBERS * POINTS;
    fan f = {.solved = 0};
    snprintf(showing->title, sizeof showing->title, "%s", showing->settings->settings.name);
    f.parameters = calloc(MEMBERS * (size_t)scene_known_count(of), sizeof *f.parameters);
    f.values = calloc(rows * SOLVE_MEMBERS_COLUMNS, sizeof *f.values);
    f.columns[0] = calloc(rows * COLUMNS, sizeof *f.columns[0]);
    ad_status status = f.parameters && f.values && f.columns[0]
                           ? AD_OK
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for a report");
    for (size_t k = 1; status == AD_OK && k < COLUMNS; k++) {
        f.columns[k] = f.columns[0] + k * rows;
    }
    if (status == AD_OK) {
        show_spread(of, MEMBERS, f.parameters);
        status = solve(of, &f, error);
    }
    if (status == AD_OK) {
        sort(of, &f);
        status = f.solved > 0 ? show_fan(showing, of, &f, error)
                              : ad_fail(error, AD_BAD_INPUT, "%s: none of %d members is solved",
                                        showing->source, MEMBERS);
    }
    free(f.parameters);
    free(f.values);
    free(f.columns[0]);
    return status;
}
