#include "physics/solve/static_system.h"

#include "autodiff/dense.h"
#include "physics/solve/mesh.h"
#include "physics/solve/quaternion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sundials/sundials_band.h>

enum { ROWS = STATIC_ROWS, LOWER = 19, UPPER = 18, ABOVE = LOWER + UPPER };

enum { CHORDS = 256 }; /* of the arc along which a turned end moves; any number serves */

typedef double jacobian[ROWS][ROWS];

struct static_system {
    const solve_rod *rod;
    gauss_rule rule;
    int elements, stages;
    double *edges;             /* [elements + 1] */
    double *points;            /* [elements][stages], s */
    solve_section *sections;   /* the same points; with the stretch of the path */
    double *axial;             /* [elements][stages] axial compliance without it */
    solve_rest *rest;          /* the same points */
    solve_load *load;          /* the same, at full load */
    solve_actuator *actuators; /* [elements][stages][those of the rod], at full load */
    static_end full[2];        /* at full load */
    static_end bare[2];        /* unstressed */
    static_end ends[2];        /* where the path is */
    double turn[3];            /* rotation vector of the end s = 1 at full load, world; 0: none */
    double (*chords)[3];       /* [CHORDS] of the unstressed rod, in turn; NULL without a turn */
    double arc[3];             /* their sum, turned in proportion to s */
    int *jump;                 /* [elements + 1] at each edge, index of the rod's; -1: none */
    solve_load *jump_load;     /* [jumps of the rod] at full load */
    static_jump *jumps;        /* the same, where the path is */
    static_path path;
    double tensions[SOLVE_ACTUATORS_MAX]; /* of tendons whose length is given */
    double *rate;                         /* [elements][stages][ROWS] */
    jacobian *by_y;                       /* [elements][stages] */
    double *factor;                       /* [elements][inner][inner], column-major */
    int *pivots;                          /* [elements][inner] */
    double *by_start; /* [elements][ROWS][inner]: how the inner y follow the start */
    double *inner;    /* [elements][inner] */
    jacobian *across; /* [elements] of y beyond the edge where an element begins */
    double start[STATIC_START_ROWS][ROWS], end[STATIC_END_ROWS][ROWS];
    realtype **band; /* of y at the edges */
    sunindextype *band_pivots;
    double *right; /* [elements + 1][ROWS] */
};

static size_t inner_rows(const static_system *x)
{
    return (size_t)x->stages * ROWS;
}

size_t static_system_unknowns(const static_system *x)
{
    return ROWS + (size_t)x->elements * (inner_rows(x) + ROWS);
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

static double width(const static_system *x, int element)
{
    return x->edges[element + 1] - x->edges[element];
}

/* Index of the y at edge `element`; the inner ones of the element follow. */
static size_t edge(const static_system *x, int element)
{
    return (size_t)element * (inner_rows(x) + ROWS);
}

/* ---- making -------------------------------------------------------------------------------- */

void static_system_free(static_system *x)
{
    if (x) {
        free(x->edges);
        free(x->jump);
        free(x->jump_load);
        free(x->jumps);
        free(x->points);
        free(x->sections);
        free(x->axial);
        free(x->rest);
        free(x->load);
        free(x->actuators);
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
    size_t inner = inner_rows(x), edges = (elements + 1) * ROWS;
    x->edges = malloc((elements + 1) * sizeof *x->edges);
    x->jump = malloc((elements + 1) * sizeof *x->jump);
    x->jump_load = calloc((size_t)x->rod->jumps.count + 1, sizeof *x->jump_load);
    x->jumps = calloc((size_t)x->rod->jumps.count + 1, sizeof *x->jumps);
    x->points = malloc(points * sizeof *x->points);
    x->sections = malloc(points * sizeof *x->sections);
    x->axial = malloc(points * sizeof *x->axial);
    x->rest = malloc(points * sizeof *x->rest);
    x->load = malloc(points * sizeof *x->load);
    x->actuators = malloc((points * (size_t)x->rod->actuators + 1) * sizeof *x->actuators);
    x->rate = malloc(points * ROWS * sizeof *x->rate);
    x->by_y = malloc(points * sizeof *x->by_y);
    x->across = malloc(elements * sizeof *x->across);
    x->factor = malloc(elements * inner * inner * sizeof *x->factor);
    x->pivots = malloc(elements * inner * sizeof *x->pivots);
    x->by_start = malloc(elements * inner * ROWS * sizeof *x->by_start);
    x->inner = malloc(elements * inner * sizeof *x->inner);
    x->band = SUNDlsMat_newBandMat((sunindextype)edges, ABOVE, LOWER);
    x->band_pivots = malloc(edges * sizeof *x->band_pivots);
    x->right = malloc(edges * sizeof *x->right);
    return x->edges && x->jump && x->jump_load && x->jumps && x->points && x->sections &&
           x->axial && x->rest && x->load && x->actuators && x->rate && x->by_y && x->across &&
           x->factor && x->pivots && x->by_start && x->inner && x->band && x->band_pivots &&
           x->right;
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
        memcpy(full->force, given.force, sizeof full->force);
        memcpy(full->moment, given.moment, sizeof full->moment);
    }
    return status;
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
        to->turn = from->turns ? from->turn : NULL;
        to->springs = from->spring_count;
        for (int i = 0; i < from->spring_count; i++) {
            to->spring[i] = &given->springs[from->springs[i]];
        }
    }
    return solve_rod_jump_loads(x->rod, 0, x->jump_load, error);
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
        x->axial[i] = x->sections[i].strain_compliance[2];
    }
    status = status == AD_OK ? solve_rod_rest(x->rod, count, x->points, 0, x->rest, error) : status;
    status = status == AD_OK ? solve_rod_load(x->rod, count, x->points, 0, x->load, error) : status;
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
        *x = (static_system){.rod = rod,
                             .rule = solve_gauss_rule_of(stages),
                             .elements = elements,
                             .stages = stages};
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
    size_t count = static_system_unknowns(x) / ROWS;
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
        double *to = y + i * ROWS;
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

static solve_load part_of(const solve_load *full, double share)
{
    solve_load load;
    for (int k = 0; k < 3; k++) {
        load.force[k] = share * full->force[k];
        load.moment[k] = share * full->moment[k];
        load.body_force[k] = share * full->body_force[k];
        load.body_moment[k] = share * full->body_moment[k];
    }
    return load;
}

/* Springs do not grow with the load; the places that they pull to move as held ends do. */
static void set_path_jumps(static_system *x)
{
    double load = x->path.load;
    for (int k = 0; k < x->rod->jumps.count; k++) {
        static_jump *at = &x->jumps[k];
        at->load = part_of(&x->jump_load[k], load);
        for (int i = 0; i < at->springs; i++) {
            for (int c = 0; c < 3; c++) {
                const solve_spring *spring = at->spring[i];
                at->anchor[i][c] = (1 - load) * spring->unloaded[c] + load * spring->anchor[c];
            }
        }
    }
}

void static_system_set(static_system *x, const static_path *path)
{
    double load = path->load;
    x->path = *path;
    for (int end = 0; end < 2; end++) {
        const static_end *bare = &x->bare[end], *full = &x->full[end];
        static_end *at = &x->ends[end];
        *at = *full;
        at->spring[0] = at->spring[1] = path->spring;
        at->spring[path->director] += path->plane_spring;
        at->spring[2] = path->spring + path->twist_spring + path->plane_spring;
        part_way(bare->rotation, full->rotation, load, at->rotation);
        for (int i = 0; i < 3; i++) {
            at->position[i] = (1 - load) * bare->position[i] + load * full->position[i];
            at->force[i] = load * full->force[i];
            at->moment[i] = load * full->moment[i];
        }
    }
    if (x->chords) {
        turn_end(x, load, &x->ends[1]);
    }
    set_path_jumps(x);
    for (int i = 0; i < x->elements * x->stages; i++) {
        x->sections[i].strain_compliance[2] = x->axial[i] + path->stretch;
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

solve_actuation static_system_actuation(const static_system *x, const solve_actuator *actuators,
                                        size_t point, double s)
{
    solve_actuation pulling = solve_actuation_at(x->rod, actuators, point, s, x->path.load);
    pulling.tensions = x->tensions;
    return pulling;
}

double static_system_imperfection(const static_system *x)
{
    return x->path.imperfection;
}

/* What is given at one s where the path is; the section is that with its stretch. */
static static_point point_from(const static_system *x, double s, const solve_section *section,
                               const solve_rest *rest, const solve_load *load,
                               const solve_actuator *actuators)
{
    static_point at = {.rest = *rest,
                       .load = part_of(load, x->path.load),
                       .strain_compliance = section->strain_compliance,
                       .curvature_compliance = section->curvature_compliance,
                       .actuation = static_system_actuation(x, actuators, 0, s)};
    for (int k = 0; k < 3; k++) {
        at.rest.curvature[k] += x->path.imperfection * at.rest.imperfection[k];
    }
    at.load.body_force[x->path.director] += x->path.perturbation;
    return at;
}

static static_point point_of(const static_system *x, size_t i)
{
    return point_from(x, x->points[i], &x->sections[i], &x->rest[i], &x->load[i],
                      x->actuators + i * (size_t)x->rod->actuators);
}

ad_status static_system_rates(const static_system *x, size_t n, const double *s, const double *y,
                              double *rate, ad_error *error)
{
    size_t pulling = (size_t)x->rod->actuators;
    solve_section *sections = malloc(n * sizeof *sections);
    solve_rest *rest = malloc(n * sizeof *rest);
    solve_load *load = malloc(n * sizeof *load);
    solve_actuator *actuators = malloc((n * pulling + 1) * sizeof *actuators);
    ad_status status = sections && rest && load && actuators
                           ? solve_rod_sections(x->rod, n, s, sections, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", n);
    status = status == AD_OK ? solve_rod_rest(x->rod, n, s, 0, rest, error) : status;
    status = status == AD_OK ? solve_rod_load(x->rod, n, s, 0, load, error) : status;
    if (status == AD_OK && pulling > 0) {
        status = solve_rod_actuators(x->rod, n, s, 0, actuators, error);
    }
    for (size_t i = 0; i < n && status == AD_OK; i++) {
        sections[i].strain_compliance[2] += x->path.stretch;
        static_point at =
            point_from(x, s[i], &sections[i], &rest[i], &load[i], actuators + i * pulling);
        static_rate(&at, y + i * ROWS, rate + i * ROWS, NULL);
    }
    free(sections);
    free(rest);
    free(load);
    free(actuators);
    return status;
}

static void add_length(const static_system *x, size_t point, double weight, const double *y,
                       double *excess)
{
    static_point at = point_of(x, point);
    double strains[ACTUATION_ROWS], rest[ACTUATION_ROWS];
    static_strains(&at, y, strains, strains + 3);
    memcpy(rest, x->rest[point].strain, 3 * sizeof *rest);
    memcpy(rest + 3, x->rest[point].curvature, 3 * sizeof *rest);
    for (int i = 0; i < x->rod->actuators; i++) {
        if (x->rod->extents[i].has_length) {
            excess[i] += weight * (solve_actuation_length(&at.actuation, i, strains) -
                                   solve_actuation_length(&at.actuation, i, rest));
        }
    }
}

void static_system_excess(const static_system *x, const double *y, double *excess)
{
    for (int i = 0; i < x->rod->actuators; i++) {
        excess[i] = x->path.load * x->rod->extents[i].displacement;
    }
    for (int e = 0; e < x->elements; e++) {
        for (int i = 0; i < x->stages; i++) {
            add_length(x, (size_t)(e * x->stages + i), width(x, e) * x->rule.weights[i],
                       y + edge(x, e) + (i + 1) * ROWS, excess);
        }
    }
}

/* ---- single places ------------------------------------------------------------------------- */

/* y beyond what acts at edge e, and its derivative by y there where by_y is not NULL. */
static void jump_over(const static_system *x, int e, const double *y, double *after, jacobian by_y)
{
    if (x->jump[e] >= 0) {
        static_jump_over(&x->jumps[x->jump[e]], y, after, by_y);
        return;
    }
    memcpy(after, y, ROWS * sizeof *after);
    for (int r = 0; r < ROWS && by_y; r++) {
        for (int c = 0; c < ROWS; c++) {
            by_y[r][c] = r == c;
        }
    }
}

int static_system_jump(const static_system *x, int edge)
{
    return x->jump[edge];
}

void static_system_start(const static_system *x, const double *y, int element, double *start)
{
    jump_over(x, element, y + edge(x, element), start, NULL);
}

/* Rows of the conditions at s = 1, which are about y beyond what acts there. */
static void end_residual(const static_system *x, const double *y, double *rows,
                         double (*by_y)[ROWS])
{
    double after[ROWS];
    jacobian across, by_after;
    jump_over(x, x->elements, y + edge(x, x->elements), after, by_y ? across : NULL);
    static_end_residual(&x->ends[1], 1, after, rows, by_after);
    for (int r = 0; r < STATIC_END_ROWS && by_y; r++) {
        for (int c = 0; c < ROWS; c++) {
            by_y[r][c] = 0;
            for (int k = 0; k < ROWS; k++) {
                by_y[r][c] += by_after[r][k] * across[k][c];
            }
        }
    }
}

/* ---- residual and derivatives -------------------------------------------------------------- */

void static_system_residual(static_system *x, const double *y, double *residual)
{
    double unused[STATIC_START_ROWS][ROWS], *to = residual + STATIC_START_ROWS;
    static_end_residual(&x->ends[0], 0, y, residual, unused);
    for (int e = 0; e < x->elements; e++) {
        const double *inner = y + edge(x, e) + ROWS;
        double start[ROWS], h = width(x, e), *rate = x->rate + (size_t)e * inner_rows(x);
        jump_over(x, e, y + edge(x, e), start, NULL);
        for (int i = 0; i < x->stages; i++) {
            static_point at = point_of(x, (size_t)(e * x->stages + i));
            static_rate(&at, inner + i * ROWS, rate + i * ROWS, NULL);
        }
        for (int i = 0; i <= x->stages; i++) { /* the last is the end of the element */
            const double *a = i < x->stages ? x->rule.matrix[i] : x->rule.weights;
            for (int k = 0; k < ROWS; k++) {
                double sum = 0;
                for (int j = 0; j < x->stages; j++) {
                    sum += a[j] * rate[j * ROWS + k];
                }
                *to++ = inner[i * ROWS + k] - start[k] - h * sum;
            }
        }
    }
    end_residual(x, y, to, NULL);
}

void static_system_linearise(static_system *x, const double *y)
{
    double rows[STATIC_START_ROWS], rate[ROWS];
    static_end_residual(&x->ends[0], 0, y, rows, x->start);
    end_residual(x, y, rows, x->end);
    for (int e = 0; e < x->elements; e++) {
        jump_over(x, e, y + edge(x, e), rate, x->across[e]);
        const double *inner = y + edge(x, e) + ROWS;
        for (int i = 0; i < x->stages; i++) {
            size_t p = (size_t)(e * x->stages + i);
            static_point at = point_of(x, p);
            static_rate(&at, inner + i * ROWS, rate, x->by_y[p]);
        }
    }
}

/* I - h a_ij J_j, column-major. */
static void fill_inner(const static_system *x, int e, double *matrix)
{
    size_t n = inner_rows(x);
    double h = width(x, e);
    jacobian *by_y = x->by_y + e * x->stages;
    for (int j = 0; j < x->stages; j++) {
        for (int c = 0; c < ROWS; c++) {
            double *to = matrix + (size_t)(j * ROWS + c) * n;
            for (int i = 0; i < x->stages; i++) {
                double factor = -h * x->rule.matrix[i][j];
                for (int r = 0; r < ROWS; r++) {
                    *to++ = factor * by_y[j][r][c] + (i == j && r == c);
                }
            }
        }
    }
}

/* to[ROWS] += h sum_j b_j J_j inner_j */
static void add_end(const static_system *x, int e, const double *inner, double *to)
{
    double h = width(x, e);
    for (int j = 0; j < x->stages; j++) {
        const double *from = inner + j * ROWS, factor = h * x->rule.weights[j];
        for (int r = 0; r < ROWS; r++) {
            const double *row = x->by_y[e * x->stages + j][r];
            double sum = 0;
            for (int c = 0; c < ROWS; c++) {
                sum += row[c] * from[c];
            }
            to[r] += factor * sum;
        }
    }
}

static void put(static_system *x, int row, int column, double value)
{
    x->band[column][row - column + ABOVE] = value;
}

static int factor_element(static_system *x, int e)
{
    size_t n = inner_rows(x);
    double *matrix = x->factor + (size_t)e * n * n, *by_start = x->by_start + (size_t)e * n * ROWS;
    int *pivots = x->pivots + (size_t)e * n, row = STATIC_START_ROWS + e * ROWS, column = e * ROWS;
    fill_inner(x, e, matrix);
    if (ad_dense_lu(n, matrix, pivots) != 0) {
        return 1;
    }
    for (int c = 0; c < ROWS; c++) {
        for (size_t i = 0; i < n; i++) {
            by_start[(size_t)c * n + i] = x->across[e][i % ROWS][c];
        }
    }
    ad_dense_lu_solve(n, ROWS, matrix, pivots, by_start);
    for (int c = 0; c < ROWS; c++) {
        double end[ROWS];
        for (int r = 0; r < ROWS; r++) {
            end[r] = x->across[e][r][c];
        }
        add_end(x, e, by_start + (size_t)c * n, end);
        for (int r = 0; r < ROWS; r++) {
            put(x, row + r, column + c, -end[r]);
            put(x, row + r, column + ROWS + c, r == c);
        }
    }
    return 0;
}

int static_system_factor(static_system *x)
{
    int size = (x->elements + 1) * ROWS, last = size - ROWS;
    for (int c = 0; c < size; c++) {
        memset(x->band[c], 0, (ABOVE + LOWER + 1) * sizeof **x->band);
    }
    for (int c = 0; c < ROWS; c++) {
        for (int r = 0; r < STATIC_START_ROWS; r++) {
            put(x, r, c, x->start[r][c]);
        }
        for (int r = 0; r < STATIC_END_ROWS; r++) {
            put(x, last + STATIC_START_ROWS + r, last + c, x->end[r][c]);
        }
    }
    for (int e = 0; e < x->elements; e++) {
        if (factor_element(x, e) != 0) {
            return 1;
        }
    }
    return SUNDlsMat_bandGBTRF(x->band, size, UPPER, LOWER, ABOVE, x->band_pivots) != 0;
}

void static_system_solve(static_system *x, const double *right, double *step)
{
    size_t n = inner_rows(x);
    int size = (x->elements + 1) * ROWS;
    const double *from = right + STATIC_START_ROWS;
    double *to = x->right + STATIC_START_ROWS;
    memcpy(x->right, right, STATIC_START_ROWS * sizeof *right);
    for (int e = 0; e < x->elements; e++, from += n + ROWS, to += ROWS) {
        double *inner = x->inner + (size_t)e * n;
        memcpy(inner, from, n * sizeof *from);
        ad_dense_lu_solve(n, 1, x->factor + (size_t)e * n * n, x->pivots + (size_t)e * n, inner);
        memcpy(to, from + n, ROWS * sizeof *from);
        add_end(x, e, inner, to);
    }
    memcpy(to, from, STATIC_END_ROWS * sizeof *from);
    SUNDlsMat_bandGBTRS(x->band, size, ABOVE, LOWER, x->band_pivots, x->right);
    for (int e = 0; e <= x->elements; e++) {
        const double *start = x->right + (size_t)e * ROWS;
        memcpy(step + edge(x, e), start, ROWS * sizeof *start);
        for (size_t i = 0; e < x->elements && i < n; i++) {
            double sum = x->inner[(size_t)e * n + i];
            for (int c = 0; c < ROWS; c++) {
                sum += x->by_start[((size_t)e * ROWS + (size_t)c) * n + i] * start[c];
            }
            step[edge(x, e) + ROWS + i] = sum;
        }
    }
}
