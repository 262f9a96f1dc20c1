#include "physics/solve/static_system.h"

#include "physics/local/mesh.h"
#include "physics/numerics/quaternion.h"
#include "physics/rod/rod_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CHORDS = 256 }; /* of the arc along which a turned end moves; any number serves */

/* ---- making -------------------------------------------------------------------------------- */

void static_system_free(static_system *system)
{
    if (system) {
        solve_elements_clear(&system->mesh);
        solve_rod_points_clear(&system->given);
        ad_memory_free(&system->memory);
        free(system->before);
        free(system);
    }
}

static bool allocate(static_system *system)
{
    const size_t elements = (size_t)system->mesh.count;
    const size_t points = elements * (size_t)system->mesh.stages;
    AD_TAKE(system, jump, elements + 1);
    AD_TAKE(system, jumps, (size_t)system->rod->jumps.count + 1);
    AD_TAKE(system, axial, points);
    AD_TAKE(system, angles, (points + 2 * elements) * (size_t)system->rod->frictions + 1);
    AD_TAKE(system, rate, elements_inner(&system->mesh));
    return !system->memory.is_short;
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
static ad_status set_ends(static_system *system, ad_error *error)
{
    solve_initial unstressed[2];
    ad_status status = solve_rod_initial(system->rod, 2, (double[]){0, 1}, unstressed, error);
    for (int i = 0; i < 2 && status == AD_OK; i++) {
        solve_end_state given;
        status = solve_rod_end(system->rod, i, 0, &given, error);
        static_end *bare = &system->bare[i], *full = &system->full[i];
        *bare = (static_end){.kind = system->rod->ends[i]};
        memcpy(bare->position, unstressed[i].position, sizeof bare->position);
        memcpy(bare->rotation, unstressed[i].rotation, sizeof bare->rotation);
        memcpy(bare->upright, unstressed[i].rotation, sizeof bare->upright);
        *full = *bare;
        memcpy(full->position, given.position, sizeof full->position);
        memcpy(full->rotation, given.rotation, sizeof full->rotation);
    }
    system->twist = static_twist(system->rod);
    if (status == AD_OK && system->twist != 0) {
        twist_end(-system->twist, system->full[1].rotation);
    }
    return status;
}

/* The unstressed rod with each chord turned by share s of the vector: a straight rod becomes an arc
 * that meets the turned end. */
static void turned_arc(const static_system *system, double share, double *sum)
{
    memset(sum, 0, 3 * sizeof *sum);
    for (int i = 0; i < CHORDS; i++) {
        double q[4], rotation[3][3], chord[3];
        turn_of(system->turn, share * (i + 0.5) / CHORDS, q);
        rotation_matrix(q, rotation);
        to_world(rotation, system->chords[i], chord);
        for (int k = 0; k < 3; k++) {
            sum[k] += chord[k];
        }
    }
}

/* The bases of tubes, behind which straight parts twist. */
static ad_status set_bases(static_system *system, ad_error *error)
{
    const solve_rod *rod = system->rod;
    int tubes = rod->tubes, first = rod->actuators - tubes;
    solve_actuator at[SOLVE_ACTUATORS_MAX];
    ad_status status = tubes > 0 ? solve_rod_actuators(rod, 1, (double[]){0}, 0, at, error) : AD_OK;
    for (int end = 0; end < 2 && status == AD_OK; end++) {
        system->full[end].tubes = tubes;
        for (int i = 0; i < tubes; i++) {
            system->full[end].turned[i] = at[first + i].turned;
            system->full[end].softness[i] = at[first + i].yielding;
        }
    }
    return status;
}

/* Of an end that a rotation vector turns. */
static ad_status set_turn(static_system *system, ad_error *error)
{
    const scene_end *end = &system->rod->scene.end;
    if (!system->rod->ends[1].holds_rotation || !end->rotation_vector[0].is_given ||
        scene_is_manufactured(&system->rod->scene)) {
        return AD_OK;
    }
    solve_initial at[CHORDS + 1];
    double s[CHORDS + 1];
    for (int i = 0; i < 3; i++) {
        system->turn[i] =
            quantity_value(end->rotation_vector[i], scene_length(&system->rod->scene), 0);
    }
    for (int i = 0; i <= CHORDS; i++) {
        s[i] = (double)i / CHORDS;
    }
    AD_TAKE(system, chords, CHORDS);
    ad_status status = system->chords ? solve_rod_initial(system->rod, CHORDS + 1, s, at, error)
                                      : ad_fail(error, AD_NO_MEMORY, "out of memory for an arc");
    for (int i = 0; status == AD_OK && i < CHORDS; i++) {
        for (int k = 0; k < 3; k++) {
            system->chords[i][k] = at[i + 1].position[k] - at[i].position[k];
        }
    }
    if (status == AD_OK) {
        turned_arc(system, 1, system->arc);
    }
    return status;
}

/* Each place has to be an edge. */
static ad_status set_jumps(static_system *system, ad_error *error)
{
    const solve_jumps *given = &system->rod->jumps;
    int next = 0;
    for (int e = 0; e <= system->mesh.count; e++) {
        bool here = next < given->count &&
                    fabs(given->at[next].s - system->mesh.edges[e]) < SOLVE_SAME_PLACE;
        system->jump[e] = here ? next++ : -1;
    }
    if (next < given->count) {
        return ad_fail(error, AD_BAD_ARGUMENT, "s = %g, where something acts, is no edge",
                       given->at[next].s);
    }
    for (int k = 0; k < given->count; k++) {
        const solve_jump *from = &given->at[k];
        static_jump *to = &system->jumps[k];
        to->rows = system->mesh.rows;
        to->turn = from->turns ? from->turn : NULL;
        to->acting = &from->acting;
    }
    return AD_OK;
}

static ad_status set_points(static_system *system, ad_error *error)
{
    const size_t count = (size_t)system->mesh.count * (size_t)system->mesh.stages;
    ad_status status =
        solve_rod_points_make(system->rod, count, system->mesh.points, &system->given, error);
    for (size_t i = 0; i < count && status == AD_OK; i++) {
        system->axial[i] = system->given.sections[i].compliance[2];
    }
    return status;
}

ad_status static_system_create(const solve_rod *rod, int stages, int elements, const double *edges,
                               static_system **result, ad_error *error)
{
    *result = NULL;
    static_system *system = calloc(1, sizeof *system);
    if (!system) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %d nodes", stages * elements);
    }
    system->rod = rod;
    system->perturbed = rod->along;
    acting_add(&system->perturbed, LAW_FOLLOWER_FORCE);
    ad_status status = solve_elements_make(static_rows(rod), static_end_rows(rod, 0), stages,
                                           elements, edges, &system->mesh, error);
    if (status == AD_OK && !allocate(system)) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for %d nodes", stages * elements);
    }
    status = status == AD_OK ? set_points(system, error) : status;
    if (status == AD_OK) {
        status = set_ends(system, error);
    }
    status = status == AD_OK ? set_bases(system, error) : status;
    status = status == AD_OK ? set_turn(system, error) : status;
    if (status == AD_OK) {
        status = set_jumps(system, error);
    }
    if (status != AD_OK) {
        static_system_free(system);
        return status;
    }
    static_system_set(system, &(static_path){.load = 1});
    *result = system;
    return AD_OK;
}

ad_status static_system_guess(const static_system *system, double *y, ad_error *error)
{
    size_t rows = (size_t)system->mesh.rows, count = elements_unknowns(&system->mesh) / rows;
    double *s = malloc(count * sizeof *s);
    solve_initial *shape = malloc(count * sizeof *shape);
    solve_end_state *exact = calloc(count, sizeof *exact);
    ad_status status = s && shape && exact ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    if (status == AD_OK) {
        solve_elements_places(&system->mesh, s);
        status = solve_rod_initial(system->rod, count, s, shape, error);
    }
    if (status == AD_OK && scene_is_manufactured(&system->rod->scene)) {
        status = solve_rod_manufactured(system->rod, count, s, 0, exact, error);
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
static void turn_end(const static_system *system, double share, static_end *at)
{
    double turn[4], arc[3];
    const double *start = system->ends[0].position,
                 *held[2] = {system->full[0].position, system->full[1].position};
    turn_of(system->turn, share, turn);
    quaternion_product(turn, system->bare[1].rotation, at->rotation);
    turned_arc(system, share, arc);
    for (int k = 0; k < 3; k++) {
        double rest = held[1][k] - held[0][k] - system->arc[k];
        at->position[k] = start[k] + arc[k] + share * rest;
    }
}

static void set_path_jumps(static_system *system)
{
    double load = system->path.load, way = way_of(&system->path);
    for (int k = 0; k < system->rod->jumps.count; k++) {
        static_jump *at = &system->jumps[k];
        acting_on_way(at->acting,
                      solve_jump_numbers(&system->rod->jumps, system->rod->jumps.number, k), load,
                      way, at->numbers);
    }
}

void static_system_set(static_system *system, const static_path *path)
{
    double load = path->load, way = way_of(path);
    system->path = *path;
    for (int end = 0; end < 2; end++) {
        const static_end *bare = &system->bare[end], *full = &system->full[end];
        static_end *at = &system->ends[end];
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
    if (system->chords) {
        turn_end(system, way, &system->ends[1]);
    }
    if (system->twist != 0) {
        twist_end(load * system->twist, system->ends[1].rotation);
    }
    set_path_jumps(system);
    for (int i = 0; i < system->mesh.count * system->mesh.stages; i++) {
        system->given.sections[i].compliance[2] = system->axial[i] + path->stretch;
    }
}

/* Of the angles, by the polynomials of the element. */
static void set_rubbed(const static_system *system, double s, solve_actuation *pulling)
{
    const int e = solve_elements_at(&system->mesh, s), points = system->mesh.stages + 2;
    const size_t count = (size_t)system->rod->frictions;
    double angles[SCENE_TENDONS_MAX];
    solve_elements_interpolate(&system->mesh, e, s, count, count,
                               system->angles + (size_t)(e * points) * count, angles);
    for (int i = 0, k = 0; i < system->rod->actuators; i++) {
        if (system->rod->extents[i].rubs) {
            pulling->rubbed[i] = pulling->actuators[i].friction * angles[k++];
        }
    }
}

solve_actuation static_system_actuation(const static_system *system,
                                        const solve_actuator *actuators, size_t point, double s)
{
    solve_actuation pulling =
        solve_actuation_at(system->rod, actuators, point, s, system->path.load);
    pulling.tensions = system->tensions;
    if (system->rod->frictions > 0) {
        set_rubbed(system, s, &pulling);
    }
    return pulling;
}
