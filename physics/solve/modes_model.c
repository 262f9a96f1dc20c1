#include "physics/solve/modes_model.h"

#include "physics/solve/modes_defect.h"
#include "physics/solve/modes_internal.h"
#include "physics/support.h"

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
    modes_model *x = context;
    modes *m = x->m;
    ad_status status = modes_at(m, t, NULL, error);
    if (status == AD_OK) {
        modes_shape(m, y, y + m->size, y + 2 * m->size);
        modes_forces(m, by != NULL, residual);
    }
    if (status == AD_OK && by) {
        modes_mass(m);
        modes_derivatives(m, x->by_q, x->by_v);
        by[0] = x->by_q;
        by[1] = x->by_v;
        by[2] = m->mass;
    }
    return status;
}

static ad_status off(void *context, double begin, double end, size_t count, const double *y,
                     model_motion_error *off, ad_error *error)
{
    modes_model *x = context;
    ad_status status = AD_OK;
    if (!x->defect) {
        status = modes_defect_create(x->rod, x->m, x->motion.start, &x->finer, &x->defect, error);
    }
    return status == AD_OK ? modes_defect_follow(x->defect, begin, end, count, y, off, error)
                           : status;
}

/* Of the places looked at before nothing is made again. */
static ad_status look_at(modes_model *x, size_t n, const double *s, ad_error *error)
{
    if (x->places && n == x->count && memcmp(s, x->s, n * sizeof *s) == 0) {
        return AD_OK;
    }
    if (n > x->room) {
        free(x->seen);
        free(x->s);
        x->seen = malloc(n * sizeof *x->seen);
        x->s = malloc(n * sizeof *x->s);
        x->room = x->seen && x->s ? n : 0;
    }
    modes_places_free(x->places);
    x->places = NULL;
    x->count = n;
    if (n > x->room) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu places", n);
    }
    memcpy(x->s, s, n * sizeof *s);
    return modes_places_create(x->m, n, s, &x->places, error);
}

static ad_status observe(void *context, double t, const double *y, size_t n, const double *s,
                         size_t stride, double *values, ad_error *error)
{
    modes_model *x = context;
    modes *m = x->m;
    const size_t columns = (size_t)x->physics->column_count;
    ad_status status = look_at(x, n, s, error);
    status = status == AD_OK ? modes_at(m, t, NULL, error) : status;
    if (status == AD_OK) {
        modes_shape(m, y, y + m->size, y + 2 * m->size);
        modes_forces(m, false, m->room);
        modes_samples(m, x->places, x->seen);
    }
    for (size_t i = 0; i < n && status == AD_OK; i++) {
        const double *state = (const double *)&x->seen[i];
        for (size_t c = 0; c < columns; c++) {
            values[c * stride + i] = state[c] * x->units[c];
        }
    }
    return status;
}

/* ---- making -------------------------------------------------------------------------------- */

static ad_status make_physics(modes_model *x, const scene *rod_scene, ad_error *error)
{
    const scene_physics *physics = scene_physics_of(rod_scene);
    physics_model *to = x->physics = model_create();
    if (!to) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a model");
    }
    ad_status status = model_domain_of(rod_scene, &to->domain, error);
    to->scene = *rod_scene;
    to->has_scene = true;
    to->motion = &x->motion;
    to->field_count = to->unknowns = 1;
    to->field_rows[0] = to->outputs = x->motion.size;
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
static ad_status list_edges(modes_model *x, ad_error *error)
{
    const modes *m = x->m;
    int pieces = 0;
    if (m->pieces > DOMAIN_PIECES_MAX) {
        return ad_fail(error, AD_BAD_INPUT, "strain modes of %d pieces of a rod; allowed: up to %d",
                       m->pieces, DOMAIN_PIECES_MAX);
    }
    for (int e = m->hinges; e < m->elements; e++) {
        const bool ends = e + 1 == m->elements || m->element[e + 1].own != m->element[e].own;
        if (ends) {
            x->edges[++pieces] = m->s[(e + 1) * (m->stages + 1) - 1];
        }
    }
    x->motion.pieces = pieces;
    x->motion.edges = x->edges;
    return AD_OK;
}

static ad_status make_motion(modes_model *x, ad_error *error)
{
    const size_t size = (size_t)x->m->size, width = (size_t)x->m->width;
    if (size == 0) {
        return ad_fail(error, AD_BAD_INPUT,
                       "network.modes: are all 0 or of locked strains; nothing to learn");
    }
    x->memory = calloc(2 * size + 2 * size * width, sizeof *x->memory);
    if (!x->memory) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu modes", size);
    }
    x->by_q = x->memory + 2 * size;
    x->by_v = x->by_q + size * width;
    x->motion = (model_motion){.size = (int)size,
                               .stride = (int)width,
                               .start = x->memory,
                               .context = x,
                               .residual = residual,
                               .off = off,
                               .observe = observe};
    solve_rod_units(x->rod, x->units);
    ad_status status = list_edges(x, error);
    status = status == AD_OK ? modes_initial(x->m, x->memory, x->memory + size, error) : status;
    return status;
}

ad_status modes_model_create(const scene *rod_scene, const int counts[4], modes_model **result,
                             ad_error *error)
{
    enum { FINER = 2 };
    ad_status status = support_check(rod_scene, SUPPORT_STRAIN_MOTION, NULL, error);
    modes_model *x = status == AD_OK ? calloc(1, sizeof *x) : NULL;
    *result = NULL;
    if (!x) {
        return status != AD_OK ? status : ad_fail(error, AD_NO_MEMORY, "out of memory for a model");
    }
    scene as_mixed = *rod_scene; /* coefficients and formulas are those of any form */
    as_mixed.formulation = SCENE_MIXED;
    status = solve_rod_create(&as_mixed, &x->rod, error);
    const modes_counts all = modes_counts_in(&as_mixed, counts);
    int finer[4];
    for (int i = 0; i < 4; i++) {
        finer[i] = counts[i] + counts[i] / 2 + 2;
    }
    x->finer = modes_counts_in(&as_mixed, finer);
    status = status == AD_OK ? modes_create(x->rod, NULL, &all, FINER, &x->m, error) : status;
    status = status == AD_OK ? make_motion(x, error) : status;
    status = status == AD_OK ? make_physics(x, rod_scene, error) : status;
    if (status != AD_OK) {
        modes_model_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}

void modes_model_free(modes_model *x)
{
    if (x) {
        modes_free(x->m);
        solve_rod_free(x->rod);
        model_free(x->physics);
        free(x->memory);
        modes_defect_free(x->defect);
        modes_places_free(x->places);
        free(x->seen);
        free(x->s);
        free(x);
    }
}

physics_model *modes_model_physics(modes_model *x)
{
    return x->physics;
}

void modes_model_counts(const modes_model *x, int counts[6])
{
    memcpy(counts, x->m->counts.of, 6 * sizeof *counts);
}
