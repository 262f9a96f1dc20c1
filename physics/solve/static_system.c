#include "physics/solve/static_system_internal.h"

#include "autodiff/dense.h"
#include "physics/quaternion.h"
#include "physics/rod_internal.h"
#include "physics/solve/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CHORDS = 256 }; /* of the arc along which a turned end moves; any number serves */

size_t static_system_unknowns(const static_system *x)
{
    return (size_t)x->rows + edge(x, x->elements);
}

int static_system_elements(const static_system *x)
{
    return x->elements;
}

const double *static_system_edges(const static_system *x)
{
    return x->edges;
}

const gauss_rule *static_system_rule(const static_system *x)
{
    return &x->rule;
}

int static_system_rows(const static_system *x)
{
    return x->rows;
}

/* ---- making -------------------------------------------------------------------------------- */

void static_system_free(static_system *x)
{
    if (x) {
        free(x->edges);
        free(x->jump);
        free(x->jumps);
        free(x->points);
        free(x->sections);
        free(x->axial);
        free(x->rest);
        free(x->along);
        free(x->actuators);
        free(x->angles);
        free(x->rate);
        free(x->by_y);
        free(x->across);
        free(x->factor);
        free(x->pivots);
        free(x->by_start);
        free(x->inner);
        free(x->chords);
        if (x->band) {
            SUNDlsMat_destroyMat(x->band);
        }
        free(x->band_pivots);
        free(x->right);
        free(x);
    }
}

static bool allocate(static_system *x)
{
    size_t elements = (size_t)x->elements, points = elements * (size_t)x->stages;
    size_t inner = inner_rows(x), rows = (size_t)x->rows, edges = (elements + 1) * rows;
    x->edges = malloc((elements + 1) * sizeof *x->edges);
    x->jump = malloc((elements + 1) * sizeof *x->jump);
    x->jumps = calloc((size_t)x->rod->jumps.count + 1, sizeof *x->jumps);
    x->points = malloc(points * sizeof *x->points);
    x->sections = malloc(points * sizeof *x->sections);
    x->axial = malloc(points * sizeof *x->axial);
    x->rest = malloc(points * sizeof *x->rest);
    x->along = malloc((points * (size_t)x->rod->along.numbers + 1) * sizeof *x->along);
    x->actuators = malloc((points * (size_t)x->rod->actuators + 1) * sizeof *x->actuators);
    x->angles = calloc((points + 2 * elements) * (size_t)x->rod->frictions + 1, sizeof *x->angles);
    x->rate = malloc(points * rows * sizeof *x->rate);
    x->by_y = malloc(points * sizeof *x->by_y);
    x->across = malloc(elements * sizeof *x->across);
    x->factor = malloc(elements * inner * inner * sizeof *x->factor);
    x->pivots = malloc(elements * inner * sizeof *x->pivots);
    x->by_start = malloc(elements * inner * rows * sizeof *x->by_start);
    x->inner = malloc(elements * inner * sizeof *x->inner);
    x->band = SUNDlsMat_newBandMat((sunindextype)edges, x->above, x->lower);
    x->band_pivots = malloc(edges * sizeof *x->band_pivots);
    x->right = malloc(edges * sizeof *x->right);
    return x->edges && x->jump && x->jumps && x->points && x->sections && x->axial && x->rest &&
           x->along && x->actuators && x->angles && x->rate && x->by_y && x->across && x->factor &&
           x->pivots && x->by_start && x->inner && x->band && x->band_pivots && x->right;
}

/* exp(vector), half of whose angle is taken (the exponential of quaternions). */
static void turn_of(const double *vector, double share, double *q)
{
    double half = share * sqrt(vector_dot(vector, vector)) / 2;
    double factor = share / 2 * (half == 0 ? 1 : sin(half) / half);
    q[0] = cos(half);
    for (int i = 0; i < 3; i++) {
        q[1 + i] = factor * vector[i];
    }
}

/* Turns the end s = 1 on about its d3. */
static void twist_end(double angle, double *rotation)
{
    double turn[4], from[4];
    memcpy(from, rotation, sizeof from);
    turn_of((double[]){0, 0, angle}, 1, turn);
    quaternion_product(from, turn, rotation);
}

/* The unstressed rod is where held ends set out from, and where a spring pulls to. */
static ad_status set_ends(static_system *x, ad_error *error)
{
    solve_initial unstressed[2];
    ad_status status = solve_rod_initial(x->rod, 2, (double[]){0, 1}, unstressed, error);
    for (int i = 0; i < 2 && status == AD_OK; i++) {
        solve_end_state given;
        status = solve_rod_end(x->rod, i, 0, &given, error);
        static_end *bare = &x->bare[i], *full = &x->full[i];
        *bare = (static_end){.kind = x->rod->ends[i]};
        memcpy(bare->position, unstressed[i].position, sizeof bare->position);
        memcpy(bare->rotation, unstressed[i].rotation, sizeof bare->rotation);
        memcpy(bare->upright, unstressed[i].rotation, sizeof bare->upright);
        *full = *bare;
        memcpy(full->position, given.position, sizeof full->position);
        memcpy(full->rotation, given.rotation, sizeof full->rotation);
    }
    x->twist = static_twist(x->rod);
    if (status == AD_OK && x->twist != 0) {
        twist_end(-x->twist, x->full[1].rotation);
    }
    return status;
}

/* The unstressed rod with each chord turned by share s of the vector: a straight rod becomes an arc
 * that meets the turned end. */
static void turned_arc(const static_system *x, double share, double *sum)
{
    memset(sum, 0, 3 * sizeof *sum);
    for (int i = 0; i < CHORDS; i++) {
        double q[4], rotation[3][3], chord[3];
        turn_of(x->turn, share * (i + 0.5) / CHORDS, q);
        rotation_matrix(q, rotation);
        to_world(rotation, x->chords[i], chord);
        for (int k = 0; k < 3; k++) {
            sum[k] += chord[k];
        }
    }
}

/* The bases of tubes, behind which straight parts twist. */
static ad_status set_bases(static_system *x, ad_error *error)
{
    const solve_rod *rod = x->rod;
    int tubes = rod->tubes, first = rod->actuators - tubes;
    solve_actuator at[SOLVE_ACTUATORS_MAX];
    ad_status status = tubes > 0 ? solve_rod_actuators(rod, 1, (double[]){0}, 0, at, error) : AD_OK;
    for (int end = 0; end < 2 && status == AD_OK; end++) {
        x->full[end].tubes = tubes;
        for (int i = 0; i < tubes; i++) {
            const solve_extent *extent = &rod->extents[first + i];
            x->full[end].turned[i] = extent->turned;
            x->full[end].softness[i] = extent->transmission * at[first + i].softness;
        }
    }
    return status;
}

/* Of an end that a rotation vector turns. */
static ad_status set_turn(static_system *x, ad_error *error)
{
    const scene_end *end = &x->rod->scene.end;
    if (!x->rod->ends[1].holds_rotation || !end->rotation_vector[0].is_given ||
        scene_is_manufactured(&x->rod->scene)) {
        return AD_OK;
    }
    solve_initial at[CHORDS + 1];
    double s[CHORDS + 1];
    for (int i = 0; i < 3; i++) {
        x->turn[i] = quantity_value(end->rotation_vector[i], scene_length(&x->rod->scene), 0);
    }
    for (int i = 0; i <= CHORDS; i++) {
        s[i] = (double)i / CHORDS;
    }
    x->chords = malloc(CHORDS * sizeof *x->chords);
    ad_status status = x->chords ? solve_rod_initial(x->rod, CHORDS + 1, s, at, error)
                                 : ad_fail(error, AD_NO_MEMORY, "out of memory for an arc");
    for (int i = 0; status == AD_OK && i < CHORDS; i++) {
        for (int k = 0; k < 3; k++) {
            x->chords[i][k] = at[i + 1].position[k] - at[i].position[k];
        }
    }
    if (status == AD_OK) {
        turned_arc(x, 1, x->arc);
    }
    return status;
}

/* Each place has to be an edge. */
static ad_status set_jumps(static_system *x, ad_error *error)
{
    const solve_jumps *given = &x->rod->jumps;
    int next = 0;
    for (int e = 0; e <= x->elements; e++) {
        bool here = next < given->count && fabs(given->at[next].s - x->edges[e]) < SOLVE_SAME_PLACE;
        x->jump[e] = here ? next++ : -1;
    }
    if (next < given->count) {
        return ad_fail(error, AD_BAD_ARGUMENT, "s = %g, where something acts, is no edge",
                       given->at[next].s);
    }
    for (int k = 0; k < given->count; k++) {
        const solve_jump *from = &given->at[k];
        static_jump *to = &x->jumps[k];
        to->rows = x->rows;
        to->turn = from->turns ? from->turn : NULL;
        to->acting = &from->acting;
    }
    return AD_OK;
}

static ad_status set_points(static_system *x, ad_error *error)
{
    size_t count = 0;
    for (int e = 0; e < x->elements; e++) {
        for (int i = 0; i < x->stages; i++) {
            x->points[count++] = x->edges[e] + width(x, e) * x->rule.nodes[i];
        }
    }
    ad_status status = solve_rod_sections(x->rod, count, x->points, x->sections, error);
    for (size_t i = 0; i < count; i++) {
        x->axial[i] = x->sections[i].compliance[2];
    }
    status = status == AD_OK ? solve_rod_rest(x->rod, count, x->points, 0, x->rest, error) : status;
    status =
        status == AD_OK ? solve_rod_along(x->rod, count, x->points, 0, x->along, error) : status;
    return status == AD_OK && x->rod->actuators > 0
               ? solve_rod_actuators(x->rod, count, x->points, 0, x->actuators, error)
               : status;
}

ad_status static_system_create(const solve_rod *rod, int stages, int elements, const double *edges,
                               static_system **result, ad_error *error)
{
    *result = NULL;
    ad_status status = ad_dense_load(error);
    if (status != AD_OK) {
        return status;
    }
    static_system *x = calloc(1, sizeof *x);
    if (x) {
        int rows = static_rows(rod), first = static_end_rows(rod, 0);
        *x = (static_system){.rod = rod,
                             .rule = solve_gauss_rule_of(stages),
                             .elements = elements,
                             .stages = stages,
                             .rows = rows,
                             .start_rows = first,
                             .end_rows = static_end_rows(rod, 1),
                             .lower = first + rows - 1,
                             .above = 3 * rows - 2, /* and 2 rows - 1 - first without pivoting */
                             .perturbed = rod->along};
        acting_add(&x->perturbed, LAW_FOLLOWER_FORCE);
    }
    if (!x || !allocate(x)) {
        static_system_free(x);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %d nodes", stages * elements);
    }
    memcpy(x->edges, edges, ((size_t)elements + 1) * sizeof *edges);
    status = set_points(x, error);
    if (status == AD_OK) {
        status = set_ends(x, error);
    }
    status = status == AD_OK ? set_bases(x, error) : status;
    status = status == AD_OK ? set_turn(x, error) : status;
    if (status == AD_OK) {
        status = set_jumps(x, error);
    }
    if (status != AD_OK) {
        static_system_free(x);
        return status;
    }
    static_system_set(x, &(static_path){.load = 1});
    *result = x;
    return AD_OK;
}

void static_system_points(const static_system *x, double *s)
{
    const double *from = x->points;
    *s++ = 0;
    for (int e = 0; e < x->elements; e++) {
        for (int i = 0; i < x->stages; i++) {
            *s++ = *from++;
        }
        *s++ = x->edges[e + 1];
    }
}

ad_status static_system_guess(const static_system *x, double *y, ad_error *error)
{
    size_t rows = (size_t)x->rows, count = static_system_unknowns(x) / rows;
    double *s = malloc(count * sizeof *s);
    solve_initial *shape = malloc(count * sizeof *shape);
    solve_end_state *exact = calloc(count, sizeof *exact);
    ad_status status = s && shape && exact ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    if (status == AD_OK) {
        static_system_points(x, s);
        status = solve_rod_initial(x->rod, count, s, shape, error);
    }
    if (status == AD_OK && scene_is_manufactured(&x->rod->scene)) {
        status = solve_rod_manufactured(x->rod, count, s, 0, exact, error);
    }
    for (size_t i = 0; status == AD_OK && i < count; i++) {
        double *to = y + i * rows;
        memset(to, 0, rows * sizeof *to);
        memcpy(to + STATIC_R, shape[i].position, sizeof shape[i].position);
        memcpy(to + STATIC_Q, shape[i].rotation, sizeof shape[i].rotation);
        memcpy(to + STATIC_N, exact[i].force, sizeof exact[i].force);
        memcpy(to + STATIC_M, exact[i].moment, sizeof exact[i].moment);
    }
    free(s);
    free(shape);
    free(exact);
    return status;
}

/* ---- the path ------------------------------------------------------------------------------ */

/* The rotation a share of the way from p to q, on the shorter arc (Shoemake 1985). */
static void part_way(const double *p, const double *q, double share, double *result)
{
    double dot = 0, square = 0;
    for (int i = 0; i < 4; i++) {
        dot += p[i] * q[i];
    }
    double sign = dot < 0 ? -1 : 1, angle = acos(fmin(1, fabs(dot)));
    double from = 1 - share, to = share;
    if (angle > 1e-6) {
        from = sin(from * angle) / sin(angle);
        to = sin(to * angle) / sin(angle);
    }
    for (int i = 0; i < 4; i++) {
        result[i] = from * p[i] + sign * to * q[i];
        square += result[i] * result[i];
    }
    for (int i = 0; i < 4; i++) {
        result[i] /= sqrt(square);
    }
}

/* The end s = 1 on its way, turned by a share of its vector: along the arc that the rod would make
 * there, as the straight way would squash it, and by the rest of the way to where it is held. */
static void turn_end(const static_system *x, double share, static_end *at)
{
    double turn[4], arc[3];
    const double *start = x->ends[0].position,
                 *held[2] = {x->full[0].position, x->full[1].position};
    turn_of(x->turn, share, turn);
    quaternion_product(turn, x->bare[1].rotation, at->rotation);
    turned_arc(x, share, arc);
    for (int k = 0; k < 3; k++) {
        double rest = held[1][k] - held[0][k] - x->arc[k];
        at->position[k] = start[k] + arc[k] + share * rest;
    }
}

static void set_path_jumps(static_system *x)
{
    double load = x->path.load, way = way_of(&x->path);
    for (int k = 0; k < x->rod->jumps.count; k++) {
        static_jump *at = &x->jumps[k];
        acting_on_way(at->acting, solve_jump_numbers(&x->rod->jumps, x->rod->jumps.number, k), load,
                      way, at->numbers);
    }
}

void static_system_set(static_system *x, const static_path *path)
{
    double load = path->load, way = way_of(path);
    x->path = *path;
    for (int end = 0; end < 2; end++) {
        const static_end *bare = &x->bare[end], *full = &x->full[end];
        static_end *at = &x->ends[end];
        *at = *full;
        at->spring[0] = at->spring[1] = path->spring;
        at->spring[path->director] += path->plane_spring;
        at->spring[2] = path->spring + path->twist_spring + path->plane_spring;
        part_way(bare->rotation, full->rotation, way, at->rotation);
        for (int i = 0; i < 3; i++) {
            at->position[i] = (1 - way) * bare->position[i] + way * full->position[i];
        }
        for (int i = 0; i < at->tubes; i++) {
            at->turned[i] = rod_tube_turn_share(load) * full->turned[i];
        }
    }
    if (x->chords) {
        turn_end(x, way, &x->ends[1]);
    }
    if (x->twist != 0) {
        twist_end(load * x->twist, x->ends[1].rotation);
    }
    set_path_jumps(x);
    for (int i = 0; i < x->elements * x->stages; i++) {
        x->sections[i].compliance[2] = x->axial[i] + path->stretch;
    }
}

const solve_rod *static_system_rod(const static_system *x)
{
    return x->rod;
}

double *static_system_tensions(static_system *x)
{
    return x->tensions;
}

int static_system_element(const static_system *x, double s)
{
    int first = 0, last = x->elements - 1;
    while (first < last) {
        int middle = (first + last + 1) / 2;
        if (x->edges[middle] < s) {
            first = middle;
        } else {
            last = middle - 1;
        }
    }
    return first;
}

/* Of the angles, by the polynomials of the element. */
static void set_rubbed(const static_system *x, double s, solve_actuation *pulling)
{
    int e = static_system_element(x, s), points = x->stages + 2, count = x->rod->frictions;
    const double *angles = x->angles + e * points * count;
    double weights[GAUSS_STAGES_MAX + 2];
    solve_gauss_lagrange(&x->rule, (s - x->edges[e]) / width(x, e), weights);
    for (int i = 0, k = 0; i < x->rod->actuators; i++) {
        const bool rubs = x->rod->extents[i].rubs;
        for (int j = 0; j < points && rubs; j++) {
            pulling->rubbed[i] +=
                pulling->actuators[i].friction * weights[j] * angles[j * count + k];
        }
        k += rubs;
    }
}

solve_actuation static_system_actuation(const static_system *x, const solve_actuator *actuators,
                                        size_t point, double s)
{
    solve_actuation pulling = solve_actuation_at(x->rod, actuators, point, s, x->path.load);
    pulling.tensions = x->tensions;
    if (x->rod->frictions > 0) {
        set_rubbed(x, s, &pulling);
    }
    return pulling;
}

double static_system_imperfection(const static_system *x)
{
    return x->path.imperfection;
}

double static_system_load(const static_system *x)
{
    return x->path.load;
}
