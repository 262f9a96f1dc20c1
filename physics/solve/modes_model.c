#include "physics/solve/modes_model.h"

#include "physics/chain/modes_internal.h"
#include "physics/scene/support.h"
#include "physics/solve/modes_defect.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct modes_model {
    solve_rod *rod;
    modes *m;
    physics_model *physics;
    model_motion motion;
    double units[sizeof(solve_state) / sizeof(double)];
    double *memory; /* start [2 size], by_q and by_v [size][width] */
    double *by_q, *by_v;
    modes_counts finer;   /* of its modes */
    modes_defect *defect; /* NULL: there is none yet */
    double edges[DOMAIN_PIECES_MAX + 1];
    solve_state *seen; /* [room] at s [room], the last places */
    double *s;
    size_t room, count;
    modes_places *places;
};

/* ---- the equation of motion ---------------------------------------------------------------- */

static ad_status residual(void *context, double t, const double *y, double *residual,
                          const double *by[3], ad_error *error)
{
    modes_model *model = context;
    modes *m = model->m;
    ad_status status = modes_at(m, t, NULL, error);
    if (status == AD_OK && !by) {
        modes_shape(m, y, y + m->size, y + 2 * m->size);
        modes_forces(m, false, residual);
    } else if (status == AD_OK) {
        modes_linearise(m, y, y + m->size, y + 2 * m->size, residual, model->by_q, model->by_v);
        by[0] = model->by_q;
        by[1] = model->by_v;
        by[2] = m->mass;
    }
    return status;
}

static ad_status off(void *context, double begin, double end, size_t count, const double *y,
                     model_motion_error *off, ad_error *error)
{
    modes_model *model = context;
    ad_status status = AD_OK;
    if (!model->defect) {
        status = modes_defect_create(model->rod, model->m, model->motion.start, &model->finer,
                                     &model->defect, error);
    }
    return status == AD_OK ? modes_defect_follow(model->defect, begin, end, count, y, off, error)
                           : status;
}

/* Of the places looked at before nothing is made again. */
static ad_status look_at(modes_model *model, size_t n, const double *s, ad_error *error)
{
    if (model->places && n == model->count && memcmp(s, model->s, n * sizeof *s) == 0) {
        return AD_OK;
    }
    if (n > model->room) {
        free(model->seen);
        free(model->s);
        model->seen = malloc(n * sizeof *model->seen);
        model->s = malloc(n * sizeof *model->s);
        model->room = model->seen && model->s ? n : 0;
    }
    modes_places_free(model->places);
    model->places = NULL;
    model->count = n;
    if (n > model->room) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu places", n);
    }
    memcpy(model->s, s, n * sizeof *s);
    return modes_places_create(model->m, n, s, &model->places, error);
}

static ad_status observe(void *context, double t, const double *y, size_t n, const double *s,
                         size_t stride, double *values, ad_error *error)
{
    modes_model *model = context;
    modes *m = model->m;
    const size_t columns = (size_t)model->physics->column_count;
    ad_status status = look_at(model, n, s, error);
    status = status == AD_OK ? modes_at(m, t, NULL, error) : status;
    if (status == AD_OK) {
        modes_shape(m, y, y + m->size, y + 2 * m->size);
        modes_forces(m, false, m->room);
        modes_samples(m, model->places, model->seen);
    }
    for (size_t i = 0; i < n && status == AD_OK; i++) {
        const double *state = (const double *)&model->seen[i];
        for (size_t c = 0; c < columns; c++) {
            values[c * stride + i] = state[c] * model->units[c];
        }
    }
    return status;
}

/* ---- making -------------------------------------------------------------------------------- */

static ad_status make_physics(modes_model *model, const scene *rod_scene, ad_error *error)
{
    const scene_physics *physics = scene_physics_of(rod_scene);
    physics_model *to = model->physics = model_create();
    if (!to) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a model");
    }
    ad_status status = model_domain_of(rod_scene, &to->domain, error);
    to->scene = *rod_scene;
    to->has_scene = true;
    to->motion = &model->motion;
    to->field_count = to->unknowns = 1;
    to->field_rows[0] = to->outputs = model->motion.size;
    snprintf(to->symbols[0], sizeof to->symbols[0], "q");
    to->inputs = 1;
    to->columns = physics->columns;
    to->column_count = physics->column_count;
    to->position_columns = physics->position_columns;
    to->rotation_columns = physics->rotation_columns;
    to->sets[to->set_count++] = (model_set){.name = "interior", .points = MODEL_INTERIOR};
    to->sets[0].holds[0] = true; /* times alone */
    to->terms[to->term_count++] = (model_term){.name = "motion", .weight = 1};
    return status;
}

/* Where pieces of the rod end: modes are those of a piece. */
static ad_status list_edges(modes_model *model, ad_error *error)
{
    const modes *m = model->m;
    int pieces = 0;
    if (m->pieces > DOMAIN_PIECES_MAX) {
        return ad_fail(error, AD_BAD_INPUT, "strain modes of %d pieces of a rod; allowed: up to %d",
                       m->pieces, DOMAIN_PIECES_MAX);
    }
    for (int e = m->hinges; e < m->elements; e++) {
        const bool ends = e + 1 == m->elements || m->element[e + 1].own != m->element[e].own;
        if (ends) {
            model->edges[++pieces] = m->s[(e + 1) * (m->stages + 1) - 1];
        }
    }
    model->motion.pieces = pieces;
    model->motion.edges = model->edges;
    return AD_OK;
}

static ad_status make_motion(modes_model *model, ad_error *error)
{
    const size_t size = (size_t)model->m->size, width = (size_t)model->m->width;
    if (size == 0) {
        return ad_fail(error, AD_BAD_INPUT,
                       "network.modes: are all 0 or of locked strains; nothing to learn");
    }
    model->memory = calloc(2 * size + 2 * size * width, sizeof *model->memory);
    if (!model->memory) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu modes", size);
    }
    model->by_q = model->memory + 2 * size;
    model->by_v = model->by_q + size * width;
    model->motion = (model_motion){.size = (int)size,
                                   .stride = (int)width,
                                   .start = model->memory,
                                   .context = model,
                                   .residual = residual,
                                   .off = off,
                                   .observe = observe};
    solve_rod_units(model->rod, model->units);
    ad_status status = list_edges(model, error);
    status = status == AD_OK ? modes_initial(model->m, model->memory, model->memory + size, error)
                             : status;
    return status;
}

ad_status modes_model_create(const scene *rod_scene, const int counts[4], modes_model **result,
                             ad_error *error)
{
    enum { FINER = 2 };
    ad_status status = support_check(rod_scene, SUPPORT_STRAIN_MOTION, NULL, error);
    modes_model *model = status == AD_OK ? calloc(1, sizeof *model) : NULL;
    *result = NULL;
    if (!model) {
        return status != AD_OK ? status : ad_fail(error, AD_NO_MEMORY, "out of memory for a model");
    }
    scene as_mixed = *rod_scene; /* coefficients and formulas are those of any form */
    as_mixed.formulation = SCENE_MIXED;
    status = solve_rod_create(&as_mixed, &model->rod, error);
    const modes_counts all = modes_counts_in(&as_mixed, counts);
    int finer[4];
    for (int i = 0; i < 4; i++) {
        finer[i] = counts[i] + counts[i] / 2 + 2;
    }
    model->finer = modes_counts_in(&as_mixed, finer);
    status =
        status == AD_OK ? modes_create(model->rod, NULL, &all, FINER, &model->m, error) : status;
    status = status == AD_OK ? make_motion(model, error) : status;
    status = status == AD_OK ? make_physics(model, rod_scene, error) : status;
    if (status != AD_OK) {
        modes_model_free(model);
        return status;
    }
    *result = model;
    return AD_OK;
}

void modes_model_free(modes_model *model)
{
    if (model) {
        modes_free(model->m);
        solve_rod_free(model->rod);
        model_free(model->physics);
        free(model->memory);
        modes_defect_free(model->defect);
        modes_places_free(model->places);
        free(model->seen);
        free(model->s);
        free(model);
    }
}

physics_model *modes_model_physics(modes_model *model)
{
    return model->physics;
}

void modes_model_counts(const modes_model *model, int counts[6])
{
    memcpy(counts, model->m->counts.of, 6 * sizeof *counts);
}
