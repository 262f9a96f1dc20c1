/* What there is to be doubted of training that is over. */
#include "physics/beam.h"
#include "physics/solve/stability.h"
#include "tools/train/trainer_internal.h"

#include <math.h>
#include <stdlib.h>

ad_status trainer_measure_size(trainer *t, ad_error *error)
{
    const scene *rod_scene = t->e->scene;
    rod_numbers n = rod_numbers_of(rod_scene);
    double load = fmax(fmax(n.tip_force, n.tip_moment),
                       fmax(fmax(n.distributed_force, n.distributed_moment), n.weight));
    double *nothing = calloc(t->e->count, sizeof *nothing), loss = 0;
    if (!nothing) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu parameters", t->e->count);
    }
    ad_status status = problem_held_out(t->problem, nothing, &loss, NULL, error);
    free(nothing);
    double size =
        scene_is_dynamic(rod_scene) ? fmax(loss, load * load) : loss; /* some come later */
    t->size = size > 0 && size < 1 ? size : 1;
    if (scene_is_beam(rod_scene)) { /* on a stiff foundation slopes are smaller than loads tell */
        double foundation = fmax(1, beam_numbers_of(rod_scene).foundation);
        t->size *= pow(fmin(1, 8 * pow(foundation / 4, 0.25) / foundation), 2);
    } else if (!rod_plane_of(rod_scene).is_planar) {
        t->size *= pow(fmin(1, n.torsion_ratio), 2);
    }
    return status;
}

bool trainer_is_small(const trainer *t, double loss)
{
    return loss < fmax(TRAINER_LARGE_LOSS * t->size, TRAINER_ROUNDING_LOSS);
}

/* The largest held-out loss with which a window ended, and the window, from 0. */
static double worst_held_out(const trainer *t, int *window)
{
    const history *h = &t->history;
    double worst = -1;
    for (size_t row = 0; row < h->count; row++) {
        int at = trainer_row_window(t, row);
        double held_out = history_value(h, row, "held_out");
        bool last = row + 1 == h->count || trainer_row_window(t, row + 1) != at;
        if (last && !(held_out <= worst)) { /* not a number is the worst */
            worst = held_out;
            *window = at;
        }
    }
    return worst;
}

int trainer_ways_to_give(const trainer *t)
{
    const experiment *e = t->e;
    scene at_work = *e->scene, *rod_scene = &at_work;
    double s[STABILITY_POINTS], values[MODEL_COLUMNS_MAX * STABILITY_POINTS];
    ad_error ignored;
    int ways = -1;
    field *shape = NULL;
    if (scene_is_dynamic(rod_scene)) {
        return ways;
    }
    at_work.loads.part = t->info.part;
    stability_points(rod_scene, s);
    ad_status status = field_create(rod_scene, e->mlp, false, e->pool, &shape, &ignored);
    if (status == AD_OK) {
        status = field_evaluate(shape, experiment_parameters(e), STABILITY_POINTS, s, NULL, values,
                                &ignored);
    }
    if (status == AD_OK) {
        stability_count(rod_scene, values, &ways, &ignored);
    }
    field_free(shape);
    return ways;
}

/* A shape of which the forces balance but which gives way. */
static bool is_unstable(const trainer *t, char text[TRAINER_DOUBT])
{
    int ways = trainer_ways_to_give(t);
    snprintf(text, TRAINER_DOUBT,
             "unstable: in this equilibrium the energy falls in %d direction%s, so that the rod "
             "buckles or snaps to another; rod.rest.imperfection says to which, or take another "
             "training.seed",
             ways, ways == 1 ? "" : "s");
    return ways > 0;
}

bool trainer_doubts(const trainer *t, char text[TRAINER_DOUBT])
{
    int window = 0, windows = t->e->scene->windows;
    double held_out = worst_held_out(t, &window);
    char where[64] = "";
    if (t->info.interpolates) {
        snprintf(text, TRAINER_DOUBT,
                 "the network interpolates its points: between them, where it was not trained, "
                 "the loss is %.1e times as large; take more losses.interior.points, or a "
                 "smaller network.hidden",
                 t->info.held_out_ratio);
        return true;
    }
    if (windows > 1) {
        snprintf(where, sizeof where, " in window %d of %d", window + 1, windows);
    }
    snprintf(text, TRAINER_DOUBT,
             "not converged%s: on points never trained on the residuals are still large; train "
             "longer, or look at --explain for what makes this scene hard",
             where);
    return !trainer_is_small(t, held_out) || is_unstable(t, text);
}
