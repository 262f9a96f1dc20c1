#include "physics/solve/stability.h"

#include "autodiff/dense.h"
#include "physics/solve/quaternion.h"
#include "physics/solve/rod_model.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

enum { ELEMENTS = STABILITY_POINTS };

/* The second variation as a matrix: axes unknowns at every node, then those of nu. */
typedef struct variation {
    int axes, axis[3]; /* the rod turns about these directors */
    int pulls;         /* components of nu: 0, 2 or 3 */
    int size;
    double *matrix;                   /* [size][size], symmetric */
    double stiffness[3], softness[3]; /* K, C of the element */
    double step;                      /* length of an element */
} variation;

/* Whether the question makes sense for this scene. */
static bool is_asked(const scene *rod_scene, bool planar)
{
    const scene_loads *loads = &rod_scene->loads;
    bool moments = loads->moment[0].is_given || loads->tip.moment[0].is_given ||
                   loads->base.moment[0].is_given;
    bool followers = loads->frame == SCENE_FOLLOWER || loads->tip.frame == SCENE_FOLLOWER ||
                     loads->base.frame == SCENE_FOLLOWER;
    bool turns = !scene_end_holds_rotation(rod_scene->start.type) &&
                 !scene_end_holds_rotation(rod_scene->end.type);
    return !scene_is_dynamic(rod_scene) && !scene_is_manufactured(rod_scene) && !followers &&
           (planar || (!moments && !turns));
}

/* R(q)^T R(p) e_k */
static void turned(const double p[4], const double q[4], int k, double result[3])
{
    double turn[4], R[3][3];
    quaternion_quotient(q, p, turn);
    rotation_matrix(turn, R);
    for (int i = 0; i < 3; i++) {
        result[i] = R[i][k];
    }
}

/* What one unknown is in the middle of an element: eta, a = eta_s + u x eta, R^T nu. */
typedef struct direction {
    int place;
    double eta[3], bend[3], pull[3];
} direction;

/* The bilinear form of two directions at a state. */
static double energy_of(const variation *x, const solve_state *state, const direction *p,
                        const direction *q)
{
    const double *v = state->strain, *n = state->force, *m = state->moment;
    double pn[3], qn[3], pv[3], qv[3], ab[3], ba[3], sum = 0;
    vector_cross(p->eta, n, pn);
    vector_cross(q->eta, n, qn);
    vector_cross(p->eta, v, pv);
    vector_cross(q->eta, v, qv);
    vector_cross(p->bend, q->eta, ab);
    vector_cross(q->bend, p->eta, ba);
    for (int i = 0; i < 3; i++) {
        sum += x->stiffness[i] * p->bend[i] * q->bend[i];
        sum -= x->softness[i] * (pn[i] - p->pull[i]) * (qn[i] - q->pull[i]);
        sum += (pn[i] * qv[i] + qn[i] * pv[i]) / 2; /* -n.(eta x (eta x v)) */
    }
    return sum + (vector_dot(m, ab) + vector_dot(m, ba)) / 2 - vector_dot(p->pull, qv) -
           vector_dot(q->pull, pv);
}

/* Element k, with the state in its middle; base: the rotation of the first. */
static void add_element(variation *x, int k, const solve_state *state, const double base[4])
{
    direction all[9];
    int count = 0;
    for (int side = 0; side < 2; side++) {
        for (int j = 0; j < x->axes; j++) {
            direction *d = &all[count++];
            *d = (direction){.place = (k + side) * x->axes + j};
            d->eta[x->axis[j]] = 0.5;
            vector_cross(state->curvature, d->eta, d->bend);
            d->bend[x->axis[j]] += (side ? 1 : -1) / x->step;
        }
    }
    for (int j = 0, axis = 0; j < x->pulls; j++, axis++) {
        direction *d = &all[count++];
        axis += x->axes == 1 && axis == x->axis[0]; /* within the plane */
        *d = (direction){.place = (ELEMENTS + 1) * x->axes + j};
        turned(base, state->rotation, axis, d->pull);
    }
    for (int i = 0; i < count; i++) {
        for (int j = 0; j < count; j++) {
            x->matrix[all[i].place * x->size + all[j].place] +=
                x->step * energy_of(x, state, &all[i], &all[j]);
        }
    }
}

static void hold_rotation(variation *x, int node)
{
    for (int j = 0; j < x->axes; j++) {
        int place = node * x->axes + j;
        for (int i = 0; i < x->size; i++) {
            x->matrix[place * x->size + i] = x->matrix[i * x->size + place] = 0;
        }
        x->matrix[place * x->size + place] = 1;
    }
}

static variation variation_of(const scene *rod_scene, const rod_plane *plane)
{
    bool held = scene_end_holds_position(rod_scene->start.type) &&
                scene_end_holds_position(rod_scene->end.type);
    variation x = {.axes = plane->is_planar ? 1 : 3,
                   .axis = {plane->is_planar ? plane->director : 0, 1, 2},
                   .step = scene_length(rod_scene) / ELEMENTS};
    x.pulls = !held ? 0 : plane->is_planar ? 2 : 3;
    x.size = (ELEMENTS + 1) * x.axes + x.pulls;
    return x;
}

static void take_section(variation *x, const scene *rod_scene, const scene_properties *p, int k)
{
    double s = scene_length(rod_scene) * (k + 0.5) / ELEMENTS, bending[3];
    for (int i = 0; i < 3; i++) {
        bending[i] = quantity_value(p->curvature_stiffness[i], s, 0);
    }
    for (int i = 0; i < 3; i++) { /* a locked curvature is a very stiff one */
        x->stiffness[i] = fmin(bending[i], 1e6 * fmin(bending[0], bending[1]));
        x->softness[i] = 1 / quantity_value(p->strain_stiffness[i], s, 0);
    }
}

/* values [columns][ELEMENTS] in the middles of the elements. */
static void assemble(variation *x, const scene *rod_scene, const double *values)
{
    const scene_properties properties = scene_properties_of(rod_scene);
    double base[4];
    for (int k = 0; k < ELEMENTS; k++) {
        solve_state state = {.velocity = {0}};
        for (size_t column = 0; column < offsetof(solve_state, velocity) / sizeof(double);
             column++) {
            ((double *)&state)[column] = values[column * ELEMENTS + (size_t)k];
        }
        if (k == 0) {
            memcpy(base, state.rotation, sizeof base);
        }
        take_section(x, rod_scene, &properties, k);
        add_element(x, k, &state, base);
    }
    if (scene_end_holds_rotation(rod_scene->start.type)) {
        hold_rotation(x, 0);
    }
    if (scene_end_holds_rotation(rod_scene->end.type)) {
        hold_rotation(x, ELEMENTS);
    }
}

void stability_points(const scene *rod_scene, double *s)
{
    for (int k = 0; k < ELEMENTS; k++) {
        s[k] = scene_length(rod_scene) * (k + 0.5) / ELEMENTS;
    }
}

ad_status stability_count(const scene *rod_scene, const double *values, int *count, ad_error *error)
{
    *count = -1;
    if (scene_is_beam(rod_scene)) {
        return AD_OK;
    }
    rod_plane plane = rod_plane_of(rod_scene);
    if (!is_asked(rod_scene, plane.is_planar)) {
        return AD_OK;
    }
    variation x = variation_of(rod_scene, &plane);
    x.matrix = calloc((size_t)x.size * (size_t)x.size, sizeof *x.matrix);
    int *pivots = malloc((size_t)x.size * sizeof *pivots);
    ad_status status = x.matrix && pivots ? AD_OK
                                          : ad_fail(error, AD_NO_MEMORY,
                                                    "out of memory for %d directions", x.size);
    if (status == AD_OK) {
        assemble(&x, rod_scene, values);
        *count = ad_dense_negative((size_t)x.size, x.matrix, pivots) - x.pulls;
    }
    free(pivots);
    free(x.matrix);
    return status;
}
