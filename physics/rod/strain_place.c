/* Shapes at places between the points of the mesh. */
#include "physics/rod/strain_internal.h"

#include <math.h>
#include <string.h>

/* ---- steps --------------------------------------------------------------------------------- */

/* A step of at most so much of the length takes order 6 of Magnus' expansion to 1e-9 of it in a rod
 * that turns once. */
static const double STEP_MAX = 1.0 / 16;

/* Steps from mark to mark: edges, places, and more between them. */
typedef struct steps {
    int count, element[STRAIN_STEPS_MAX];
    double from[STRAIN_STEPS_MAX], to[STRAIN_STEPS_MAX]; /* within the element, 0 to 1 */
    int first[STRAIN_ELEMENTS_MAX + 1];                  /* of each element */
} steps;

static void add_steps(const strain_rod *rod, int e, double from, double to, steps *all)
{
    const double h = rod->mesh.edges[e + 1] - rod->mesh.edges[e];
    const int parts = (int)ceil((to - from) * h / STEP_MAX - 1e-9);
    for (int i = 0; i < parts && all->count < STRAIN_STEPS_MAX; i++) {
        all->element[all->count] = e;
        all->from[all->count] = from + (to - from) * i / parts;
        all->to[all->count++] = from + (to - from) * (i + 1) / parts;
    }
}

/* after [places]: the step after which a place is, -1: it is where the rod begins. */
static void list_steps(const strain_rod *rod, int places, const double *s, steps *all, int *after)
{
    const double *edges = rod->mesh.edges;
    int k = 0;
    all->count = 0;
    for (int e = 0; e < rod->mesh.elements; e++) {
        const double h = edges[e + 1] - edges[e];
        double from = 0;
        all->first[e] = all->count;
        for (; k < places && (s[k] <= edges[e + 1] || e + 1 == rod->mesh.elements); k++) {
            const double to = fmin((s[k] - edges[e]) / h, 1);
            if (to > from + 1e-12) {
                add_steps(rod, e, from, to, all);
                from = to;
            }
            after[k] = all->count - 1;
        }
        if (from < 1 - 1e-12) {
            add_steps(rod, e, from, 1, all);
        }
    }
    all->first[rod->mesh.elements] = all->count;
}

/* Terms of Magnus' steps of an element, of a field; one row for each step. */
static void step_terms(const strain_rod *rod, const steps *all, int e, along field, along a[3])
{
    const int n = rod->mesh.stages, count = all->first[e + 1] - all->first[e];
    const double h = rod->mesh.edges[e + 1] - rod->mesh.edges[e];
    double weights[3 * STRAIN_STEPS_MAX * STRAIN_STAGES_MAX];
    for (int i = 0; i < count; i++) {
        const int step = all->first[e] + i;
        double terms[3][GAUSS_STAGES_MAX];
        gauss_magnus(&rod->rule, all->from[step], all->to[step], terms);
        for (int k = 0; k < 3; k++) {
            for (int j = 0; j < n; j++) {
                weights[(k * count + i) * n + j] = h * terms[k][j];
            }
        }
    }
    for (int c = 0; c < 3; c++) {
        const bool same = ad_rows(field.x[c]) == 1; /* where terms of differences are 0 */
        const ad_value terms = same ? field.x[c] : strain_weigh(3 * count, n, weights, field.x[c]);
        for (int k = 0; k < 3; k++) {
            a[k].x[c] = same ? strain_weigh(count, n, weights + k * count * n, terms)
                             : ad_slice(terms, k * count, count);
        }
    }
}

/* ---- shapes -------------------------------------------------------------------------------- */

/* What is at places of an element: places [first, end) of all, x within the element. */
typedef struct group {
    int count;
    double x[STRAIN_STEPS_MAX];
} group;

static group group_of(const strain_rod *rod, int e, int places, const double *s)
{
    const double *edges = rod->mesh.edges;
    group g = {.count = 0};
    for (int k = 0; k < places; k++) {
        if ((e == 0 || s[k] > edges[e]) && (e + 1 == rod->mesh.elements || s[k] <= edges[e + 1])) {
            g.x[g.count++] = fmin((s[k] - edges[e]) / (edges[e + 1] - edges[e]), 1);
        }
    }
    return g;
}

/* Of a field at the points of an element: its polynomial, or the integral of that from a place to
 * the end of the element. */
static along at_places(const strain_rod *rod, int e, along field, const group *g, bool integral)
{
    const int n = rod->mesh.stages;
    const double h = rod->mesh.edges[e + 1] - rod->mesh.edges[e];
    double weights[STRAIN_STEPS_MAX * STRAIN_STAGES_MAX];
    const along here = strain_element(rod, field, e);
    along a;
    for (int i = 0; i < g->count; i++) {
        double *row = weights + i * n;
        if (integral) {
            gauss_integral(&rod->rule, g->x[i], row);
        } else {
            gauss_lagrange(&rod->rule, g->x[i], row);
        }
        for (int j = 0; j < n && integral; j++) {
            row[j] = h * (rod->rule.weights[j] - row[j]);
        }
    }
    for (int c = 0; c < 3; c++) {
        bool same = g->count == 0 || (ad_rows(here.x[c]) == 1 && !integral);
        a.x[c] = same ? here.x[c] : strain_weigh(g->count, n, weights, here.x[c]);
    }
    return a;
}

static ad_value stack_of(ad_tape *tape, int count, const ad_value *x)
{
    return count > 0 ? ad_stack(count, x) : ad_scalar(tape, 0);
}

/* Poses at places: rotations one after the other, positions as sums of the steps before. */
static void place_all(const strain_rod *rod, const strain_state *state, const steps *all,
                      int places, const int *after, strain_shape *shape)
{
    ad_value turned[4][STRAIN_STEPS_MAX], before[4][STRAIN_STEPS_MAX];
    along shifts[STRAIN_ELEMENTS_MAX];
    int counts[STRAIN_ELEMENTS_MAX];
    along_turn q = strain_turn_rows(rod->start.rotation), start = q;
    for (int e = 0; e < rod->mesh.elements; e++) {
        along_twist a[3];
        along parts[2][3];
        step_terms(rod, all, e, strain_element(rod, state->curvature, e), parts[0]);
        step_terms(rod, all, e, strain_element(rod, state->strain, e), parts[1]);
        for (int k = 0; k < 3; k++) {
            a[k] = (along_twist){parts[0][k], parts[1][k]};
        }
        const along_twist twist = strain_magnus(a);
        const along_turn step = strain_turn_by(twist.turn);
        shifts[e] = strain_twist_shift(twist);
        counts[e] = all->first[e + 1] - all->first[e];
        q = e > 0 ? strain_turn_over(rod, e, q) : q;
        for (int i = 0; i < counts[e]; i++) {
            along_turn one;
            for (int k = 0; k < 4; k++) {
                before[k][all->first[e] + i] = q.x[k];
                one.x[k] = ad_rows(step.x[k]) == 1 ? step.x[k] : ad_row(step.x[k], i);
            }
            q = strain_turn_product(q, one);
            for (int k = 0; k < 4; k++) {
                turned[k][all->first[e] + i] = q.x[k];
            }
        }
    }
    along_turn from;
    for (int k = 0; k < 4; k++) {
        ad_value rows[STRAIN_STEPS_MAX];
        from.x[k] = ad_stack(all->count, before[k]);
        for (int i = 0; i < places; i++) {
            rows[i] = after[i] < 0 ? start.x[k] : turned[k][after[i]];
        }
        shape->rotation[k] = stack_of(rod->tape, places, rows);
    }
    const along_matrix R = strain_turn_matrix(from);
    const along moved = strain_to_world(&R, strain_join(rod->mesh.elements, counts, shifts));
    for (int c = 0; c < 3; c++) {
        ad_value rows[STRAIN_STEPS_MAX], sum = ad_row(rod->start.position, c);
        for (int i = 0, step = 0; i < places; i++) {
            for (; step <= after[i]; step++) {
                sum = ad_add(sum, ad_rows(moved.x[c]) == 1 ? moved.x[c] : ad_row(moved.x[c], step));
            }
            rows[i] = sum;
        }
        shape->position[c] = stack_of(rod->tape, places, rows);
    }
}

strain_shape strain_rod_shape(const strain_rod *rod, ad_value curvature, ad_value vector,
                              int places, const double *s)
{
    steps all;
    int after[STRAIN_STEPS_MAX], counts[STRAIN_ELEMENTS_MAX];
    along parts[4 + SCENE_TUBES_MAX][STRAIN_ELEMENTS_MAX], joined[4 + SCENE_TUBES_MAX];
    strain_state state;
    strain_shape shape = {.position = {{0}}};
    if (places > STRAIN_STEPS_MAX / 2) {
        ad_tape_fail(rod->tape, AD_BAD_ARGUMENT, "a shape at %d places; allowed: up to %d", places,
                     STRAIN_STEPS_MAX / 2);
        return shape;
    }
    strain_state_of(rod, curvature, vector, &state);
    list_steps(rod, places, s, &all, after);
    place_all(rod, &state, &all, places, after, &shape);
    const along rate =
        strain_moment_rate(state.slope, state.force, strain_moment_load(rod, &state));
    for (int e = 0; e < rod->mesh.elements; e++) {
        const group g = group_of(rod, e, places, s);
        counts[e] = g.count;
        parts[0][e] =
            strain_add(state.edge_force[e + 1], at_places(rod, e, state.load_rate[0], &g, true));
        parts[1][e] = strain_add(state.edge_moment[e + 1], at_places(rod, e, rate, &g, true));
        parts[2][e] = at_places(rod, e, state.strain, &g, false);
        parts[3][e] = at_places(rod, e, state.curvature, &g, false);
        for (int i = 0; i < rod->tubes; i++) {
            const along twist = {{state.theta[i], state.torsion[i], ad_scalar(rod->tape, 0)}};
            parts[4 + i][e] = at_places(rod, e, twist, &g, false);
        }
    }
    for (int i = 0; i < 4 + rod->tubes; i++) {
        joined[i] = strain_join(rod->mesh.elements, counts, parts[i]);
    }
    along_turn q;
    memcpy(q.x, shape.rotation, sizeof q.x);
    const along_matrix R = strain_turn_matrix(q);
    joined[0] = strain_to_body(&R, joined[0]);
    joined[1] = strain_to_body(&R, joined[1]);
    ad_value *const to[4] = {shape.force, shape.moment, shape.strain, shape.curvature};
    for (int i = 0; i < 4; i++) {
        for (int c = 0; c < 3; c++) {
            ad_value x = joined[i].x[c];
            to[i][c] = ad_rows(x) == places ? x : ad_repeat(x, places);
        }
    }
    for (int i = 0; i < 2 * rod->tubes; i++) {
        shape.twist[i] = joined[4 + i / 2].x[i % 2];
    }
    return shape;
}

ad_value strain_rod_columns(const strain_rod *rod, ad_value curvature, ad_value state, int places,
                            const double *s, int count, const int *which)
{
    const strain_shape shape = strain_rod_shape(rod, curvature, state, places, s);
    const rod_scales *scale = &rod->rod.scales;
    ad_value growth[STRAIN_STEPS_MAX], over = ad_scalar(rod->tape, 1);
    const bool grows = rod->open.rod.growth.is_given && places <= STRAIN_STEPS_MAX;
    if (grows) {
        for (int i = 0; i < places; i++) {
            growth[i] =
                ad_substitute(rod_growth(&rod->rod), rod->rod.s, ad_scalar(rod->tape, s[i]));
        }
        over = ad_reciprocal(ad_stack(places, growth));
    }
    const struct {
        const ad_value *of;
        int rows;
        double unit;
    } fields[] = {{shape.position, 3, scale->length},
                  {shape.rotation, 4, 1},
                  {shape.strain, 3, 1},
                  {shape.curvature, 3, 1 / scale->length},
                  {shape.force, 3, scale->force},
                  {shape.moment, 3, scale->moment}};
    ad_value all[STRAIN_COLUMNS_MAX], columns[STRAIN_COLUMNS_MAX];
    for (int i = 0; i < 2 * rod->tubes; i++) {
        all[STRAIN_COLUMNS + i] = ad_scale(shape.twist[i], i % 2 ? scale->moment : 1);
    }
    for (int f = 0, c = 0; f < 6; f++) {
        for (int k = 0; k < fields[f].rows; k++) {
            const ad_value of =
                grows && (f == 2 || f == 3) ? ad_mul(over, fields[f].of[k]) : fields[f].of[k];
            all[c++] = ad_scale(ad_rows(of) < places ? ad_repeat(of, places) : of, fields[f].unit);
        }
    }
    for (int i = 0; i < count; i++) {
        columns[i] = all[which[i]];
    }
    return ad_stack(count, columns);
}
