#include "tools/programs/watch_shapes.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Members are a few of those that spread evenly over all ranges. */
enum { MEMBERS = 7, COLUMNS = 7 /* of position and rotation, at most */ };

struct watch_shapes {
    const experiment *e;
    bool failed; /* and not asked again */
    field *field;
    family_network *network; /* of a family in the strain form */
    double *curvature;
    double until; /* the last instant, s; 0 at rest */
    double values[SHAPE_VIEWS_SHAPES * TARGETS_POINTS * SOLVE_MEMBERS_COLUMNS +
                  COLUMNS * SHAPE_VIEWS_POINTS];
    shape_views shapes;
};

/* What is known of the shape at rest, or at the end of time. */
static void take_known(shape_views *to, const scene *of, const reference *r)
{
    const double until = scene_duration(of) * (1 - REFERENCE_END_TOLERANCE);
    const size_t apart = 1 + reference_points(r) / SHAPE_VIEWS_KNOWN;
    for (size_t i = 0; i < reference_points(r) && to->known < SHAPE_VIEWS_KNOWN; i++) {
        double *place = to->known_places[to->known];
        if (until > 0 ? reference_t(r)[i] < until : i % apart != 0) {
            continue;
        }
        for (int axis = 0; axis < SHAPE_VIEWS_AXES; axis++) {
            place[axis] = to->beam ? 0 : reference_known(r, axis)[i];
        }
        if (to->beam) {
            place[0] = reference_s(r)[i];
            place[2] = reference_known(r, 0)[i];
        }
        to->known++;
    }
}

watch_shapes *watch_shapes_create(const experiment *e, const reference *known)
{
    watch_shapes *w = calloc(1, sizeof *w);
    if (w) {
        w->e = e;
        w->shapes.length = scene_length(e->scene);
        w->shapes.beam = scene_is_beam(e->scene);
        if (known && !scene_is_family(e->scene)) {
            take_known(&w->shapes, e->scene, known);
        }
    }
    return w;
}

void watch_shapes_free(watch_shapes *w)
{
    if (w) {
        field_free(w->field);
        family_network_free(w->network);
        free(w->curvature);
        free(w);
    }
}

/* ---- asking the network -------------------------------------------------------------------- */

/* Of member k in the range of parameter i, from 0 to 1: an additive recurrence that begins in the
 * middle (Roberts' generalisation of the golden ratio to `dimension` of them). */
static double spread(int k, int i, int dimension)
{
    double root = 2;
    for (int n = 0; n < 30; n++) {
        root = pow(1 + root, 1.0 / (dimension + 1));
    }
    return fmod(0.5 + k * pow(root, -(i + 1)), 1);
}

/* Values of the parameters of one of the members; without any, nothing. */
static void choose_member(const scene *open, int k, double *values)
{
    const int count = scene_known_count(open);
    for (int i = 0; i < count; i++) {
        values[i] = scene_parameter_at(&open->parameters[i], spread(k, i, count));
    }
}

static ad_status ask_family(watch_shapes *w, const trainer *t, ad_error *error)
{
    const experiment *e = w->e;
    solve_members *solver = targets_solver(e->targets);
    double parameters[MEMBERS * SCENE_PARAMETERS_MAX];
    if (!w->network) {
        w->curvature = malloc(sizeof *w->curvature * 3 * MEMBERS * solve_members_nodes(solver));
        ad_status status = w->curvature ? family_network_create(targets_family(e->targets), e->mlp,
                                                                e->pool, &w->network, error)
                                        : AD_NO_MEMORY;
        if (status != AD_OK) {
            return status;
        }
    }
    for (int k = 0; k < MEMBERS; k++) {
        choose_member(e->scene, k, parameters + k * e->scene->parameter_count);
    }
    ad_status status = family_network_run(w->network, trainer_parameters(t), MEMBERS, parameters,
                                          w->curvature, error);
    if (status == AD_OK) {
        status = solve_members_refine(solver, MEMBERS, parameters, w->curvature, 0, w->values, NULL,
                                      NULL, error);
    }
    w->shapes.count = status == AD_OK ? MEMBERS : 0;
    w->shapes.points = TARGETS_POINTS;
    for (int k = 0; k < w->shapes.count; k++) {
        for (int i = 0; i < w->shapes.points; i++) {
            memcpy(w->shapes.places[k][i],
                   w->values + (k * w->shapes.points + i) * SOLVE_MEMBERS_COLUMNS,
                   SHAPE_VIEWS_AXES * sizeof(double));
        }
    }
    return status;
}

/* A shape of a family, or of an instant. */
static ad_status ask_shape(watch_shapes *w, const trainer *t, int k, ad_error *error)
{
    const experiment *e = w->e;
    const bool family = scene_is_family(e->scene);
    const int points = w->shapes.points;
    double member[SCENE_PARAMETERS_MAX], s[SHAPE_VIEWS_POINTS], instant[SHAPE_VIEWS_POINTS];
    choose_member(e->scene, k, member);
    field_member(w->field, member);
    for (int i = 0; i < points; i++) {
        s[i] = w->shapes.length * i / (points - 1);
        instant[i] =
            family || w->shapes.count == 1 ? w->until : w->until * k / (w->shapes.count - 1);
    }
    const ad_status status = field_evaluate(w->field, trainer_parameters(t), (size_t)points,
                                            (const double *const[]){s, instant}, w->values, error);
    for (int i = 0; i < points; i++) {
        double *place = w->shapes.places[k][i];
        for (int axis = 0; axis < SHAPE_VIEWS_AXES; axis++) {
            place[axis] = w->shapes.beam ? 0 : w->values[axis * points + i];
        }
        if (w->shapes.beam) {
            place[0] = s[i];
            place[2] = w->values[i];
        }
    }
    return status;
}

static ad_status ask_field(watch_shapes *w, trainer *t, ad_error *error)
{
    const experiment *e = w->e;
    ad_status status =
        w->field ? AD_OK : field_create(e->model, e->mlp, true, e->pool, &w->field, error);
    w->until = experiment_until(e);
    w->shapes.points = SHAPE_VIEWS_POINTS;
    w->shapes.count = scene_is_family(e->scene)    ? MEMBERS
                      : scene_is_dynamic(e->scene) ? SHAPE_VIEWS_SHAPES
                                                   : 1;
    if (status == AD_OK) {
        field_enter(w->field, e->window, e->parameters, e->starts);
        field_load(w->field, trainer_fit(t)->at.part);
    }
    for (int k = 0; k < w->shapes.count && status == AD_OK; k++) {
        status = ask_shape(w, t, k, error);
    }
    w->shapes.count = status == AD_OK ? w->shapes.count : 0;
    return status;
}

void watch_shapes_update(watch_shapes *w, trainer *t)
{
    ad_error error;
    if (!w->failed) {
        w->failed = (w->e->targets ? ask_family(w, t, &error) : ask_field(w, t, &error)) != AD_OK;
    }
}

/* ---- drawing ------------------------------------------------------------------------------- */

static void draw_caption(const watch_shapes *w, canvas *c, int column, int row)
{
    char text[64];
    if (scene_is_family(w->e->scene)) {
        snprintf(text, sizeof text, "%d members of the family", w->shapes.count);
        canvas_text(c, column, row, CANVAS_PLAIN, text);
    } else if (w->shapes.count > 1) {
        column = canvas_text(c, column, row, CANVAS_PLAIN, "t = 0 ");
        for (int k = 0; k < w->shapes.count; k++) {
            canvas_put(c, column++, row, shape_views_colour(&w->shapes, k), 0x25a0); /* ■ */
        }
        snprintf(text, sizeof text, " %.4g s", w->until);
        column = canvas_text(c, column, row, CANVAS_PLAIN, text);
    } else {
        column = canvas_text(c, column, row, CANVAS_GREEN, "shape");
    }
    canvas_text(c, column, row, CANVAS_DIM, w->shapes.known ? "  reference" : "");
}

void watch_shapes_draw(const watch_shapes *w, canvas *c, int column, int row, int columns, int rows)
{
    if (w->shapes.count > 0) {
        draw_caption(w, c, column, row);
        shape_views_draw(&w->shapes, c, column, row + 1, columns, rows - 1);
    }
}
