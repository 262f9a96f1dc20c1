#include "physics/solve/static_arc.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { NEWTON_MAX = 12, INVERSE_STEPS = 12 };

/* Of positions and quaternions, and of all relative to the largest: steps converge quadratically,
 * so that the one after it is rounding. */
static const double CONVERGED = 1e-7;

/* Of the load, for derivatives by it, which are exact where the load enters linearly. Newton's
 * method and limit points do not depend on them. */
static const double APART = 1e-5;

struct static_arc {
    static_system *system;
    const path_shape *path;
    size_t unknowns;
    size_t rows;                       /* of y at one place */
    double *s;                         /* [unknowns/rows] */
    double *by_load, *right, *push;    /* [unknowns] */
    double *first, *second, *trial[2]; /* [unknowns + 1] */
    double *memory;
};

void static_arc_free(static_arc *arc)
{
    if (arc) {
        free(arc->memory);
        free(arc);
    }
}

/* Where the search for the weakest direction sets out: a push across the rod that has no symmetry
 * along it, and stays in a plane with the rod. */
static ad_status make_push(static_arc *arc, ad_error *error)
{
    static_path path = static_path_of_load(arc->path, 0);
    size_t n = arc->unknowns;
    ad_status status = static_system_guess(arc->system, arc->first, error);
    for (int i = 0; i < 2 && status == AD_OK; i++) {
        path.perturbation = i;
        static_system_set(arc->system, &path);
        static_system_residual(arc->system, arc->first, i ? arc->push : arc->right);
    }
    for (size_t k = 0; k < n; k++) {
        double s = arc->s[k / arc->rows];
        arc->push[k] = (arc->push[k] - arc->right[k]) * (1 + s - 0.7 * cos(5 * s));
    }
    return status;
}

ad_status static_arc_create(static_system *system, const path_shape *path, static_arc **result,
                            ad_error *error)
{
    size_t rows = (size_t)system->mesh.rows;
    size_t n = elements_unknowns(&system->mesh), points = n / rows;
    static_arc *arc = calloc(1, sizeof *arc);
    double *memory = malloc((points + 3 * n + 4 * (n + 1)) * sizeof *memory);
    *result = NULL;
    if (!arc || !memory) {
        free(arc);
        free(memory);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a path");
    }
    *arc =
        (static_arc){.system = system, .path = path, .unknowns = n, .rows = rows, .memory = memory};
    double **parts[] = {&arc->by_load, &arc->right,    &arc->push,    &arc->first,
                        &arc->second,  &arc->trial[0], &arc->trial[1]};
    arc->s = memory;
    memory += points;
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        *parts[i] = memory;
        memory += i < 3 ? n : n + 1;
    }
    solve_elements_places(&system->mesh, arc->s);
    ad_status status = make_push(arc, error);
    if (status != AD_OK) {
        static_arc_free(arc);
        return status;
    }
    *result = arc;
    return AD_OK;
}

size_t static_arc_size(const static_arc *arc)
{
    return arc->unknowns + 1;
}

/* ---- vectors ------------------------------------------------------------------------------- */

double static_arc_distance(const static_arc *arc, const double *a, const double *b)
{
    return static_path_distance(arc->rows, arc->unknowns, a, b);
}

double static_arc_product(const static_arc *arc, const double *a, const double *b)
{
    size_t n = arc->unknowns;
    double sum = 0;
    for (size_t k = 0; k < n; k += arc->rows) {
        for (int i = 0; i < STATIC_N; i++) {
            sum += a[k + (size_t)i] * b[k + (size_t)i];
        }
    }
    return sum * (double)arc->rows / (double)n + a[n] * b[n];
}

/* to = a + factor b */
static void add(size_t count, const double *a, double factor, const double *b, double *to)
{
    for (size_t i = 0; i < count; i++) {
        to[i] = a[i] + factor * b[i];
    }
}

static void scale(size_t count, double factor, double *x)
{
    for (size_t i = 0; i < count; i++) {
        x[i] *= factor;
    }
}

/* ---- linear algebra ------------------------------------------------------------------------ */

static void set_load(static_arc *arc, double load)
{
    static_path path = static_path_of_load(arc->path, load);
    static_system_set(arc->system, &path);
}

/* Factors F_y at a place and solves F_y first = -F_load; first[unknowns] = 1. Leaves the system at
 * the load. */
static bool factor(static_arc *arc, const double *at)
{
    size_t n = arc->unknowns;
    double load = at[n];
    set_load(arc, load - APART);
    static_system_residual(arc->system, at, arc->by_load);
    set_load(arc, load + APART);
    static_system_residual(arc->system, at, arc->right);
    for (size_t k = 0; k < n; k++) {
        arc->by_load[k] = (arc->by_load[k] - arc->right[k]) / (2 * APART);
    }
    set_load(arc, load);
    static_system_linearise(arc->system, at);
    if (solve_elements_factor(&arc->system->mesh) != 0) {
        return false;
    }
    solve_elements_solve(&arc->system->mesh, arc->by_load, arc->first);
    arc->first[n] = 1;
    return isfinite(static_newton_largest(n, arc->first));
}

/* (F_y F_load; border) step = (right; last), after factor(). */
static bool solve_bordered(static_arc *arc, const double *border, const double *right, double last,
                           double *step)
{
    size_t n = arc->unknowns;
    solve_elements_solve(&arc->system->mesh, right, step);
    step[n] = 0;
    double along = static_arc_product(arc, border, arc->first);
    double share = (last - static_arc_product(arc, border, step)) / along;
    add(n + 1, step, share, arc->first, step);
    return isfinite(static_newton_largest(n + 1, step));
}

/* ---- steps --------------------------------------------------------------------------------- */

bool static_arc_correct(static_arc *arc, const double *border, double *at, long *steps)
{
    size_t n = arc->unknowns;
    double before = INFINITY;
    for (int i = 0; i < NEWTON_MAX; i++) {
        if (!factor(arc, at)) {
            return false;
        }
        static_system_residual(arc->system, at, arc->right);
        if (!solve_bordered(arc, border, arc->right, 0, arc->second)) {
            return false;
        }
        add(n + 1, at, -1, arc->second, at);
        ++*steps;
        double moved = fmax(static_arc_distance(arc, arc->second, NULL), fabs(arc->second[n]));
        if (moved <= CONVERGED && static_newton_largest(n, arc->second) <=
                                      CONVERGED * fmax(1, static_newton_largest(n, at))) {
            return true;
        }
        if (!(moved <= 2 * before)) { /* forces of stiff rods may go far astray, and come back */
            return false;
        }
        before = moved;
    }
    return false;
}

/* From the last factors. */
static bool set_tangent(static_arc *arc, const double *forward, arc_place *place)
{
    double size = sqrt(static_arc_product(arc, arc->first, arc->first));
    double side = static_arc_product(arc, arc->first, forward) < 0 ? -1 : 1;
    memcpy(place->tangent, arc->first, (arc->unknowns + 1) * sizeof *arc->first);
    scale(arc->unknowns + 1, side / size, place->tangent);
    return isfinite(size);
}

bool static_arc_tangent(static_arc *arc, const double *forward, arc_place *place)
{
    return factor(arc, place->at) && set_tangent(arc, forward, place);
}

bool static_arc_step(static_arc *arc, const arc_place *before, double distance,
                     const arc_place *from, double length, arc_place *to, double *off, long *steps)
{
    size_t count = arc->unknowns + 1;
    double *guess = arc->trial[0];
    add(count, from->at, length, from->tangent, guess);
    if (before) {
        double bend = length * length / (2 * distance);
        add(count, guess, bend, from->tangent, guess);
        add(count, guess, -bend, before->tangent, guess);
        /* the part of it along the tangent would change the length */
        add(count, guess, -1, from->at, arc->trial[1]);
        double along = static_arc_product(arc, from->tangent, arc->trial[1]);
        add(count, guess, length - along, from->tangent, guess);
    }
    memcpy(to->at, guess, count * sizeof *guess);
    if (!static_arc_correct(arc, from->tangent, to->at, steps)) {
        return false;
    }
    *off = static_arc_distance(arc, to->at, guess);
    return set_tangent(arc, from->tangent, to); /* the last step was too short to matter */
}

/* ---- where paths cross --------------------------------------------------------------------- */

/* Right sides of a rod that is loaded by the displacements of a direction: what static_system_
 * residual would have more under such a load. */
static void load_by(const static_arc *arc, const double *direction, double *right)
{
    static const double none[(GAUSS_STAGES_MAX + 1) * STATIC_ROWS_MAX];
    const solve_elements *mesh = &arc->system->mesh;
    const size_t rows = arc->rows;
    double pushed[GAUSS_STAGES_MAX * STATIC_ROWS_MAX] = {0}; /* rates of N */
    memset(right, 0, arc->unknowns * sizeof *right);
    for (int e = 0; e < mesh->count; e++) {
        const double *inner = direction + elements_edge(mesh, e) + rows;
        for (size_t i = 0; i < elements_inner(mesh); i += rows) {
            for (int k = 0; k < 3; k++) {
                pushed[i + STATIC_N + (size_t)k] = -inner[i + STATIC_R + (size_t)k];
            }
        }
        solve_elements_residual(mesh, e, none, none, pushed,
                                right + mesh->start_rows + elements_edge(mesh, e));
    }
}

bool static_arc_weakest(static_arc *arc, const arc_place *place, double *direction)
{
    size_t n = arc->unknowns;
    if (!factor(arc, place->at)) {
        return false;
    }
    bool solved = solve_bordered(arc, place->tangent, arc->push, 0, direction);
    for (int i = 0; i < INVERSE_STEPS && solved; i++) {
        scale(n + 1, 1 / static_newton_largest(n, direction), direction);
        load_by(arc, direction, arc->right);
        solved = solve_bordered(arc, place->tangent, arc->right, 0, direction);
    }
    double size = sqrt(static_arc_product(arc, direction, direction)), big = 0;
    for (size_t k = 0; k < n; k++) {
        bool moves = k % arc->rows < STATIC_Q && fabs(direction[k]) > 1.01 * fabs(big);
        big = moves ? direction[k] : big;
    }
    scale(n + 1, (big < 0 ? -1 : 1) / size, direction);
    return solved && size > 0;
}

double static_arc_resistance(static_arc *arc, const arc_place *place, const double *direction)
{
    double *answer = arc->trial[0];
    if (!factor(arc, place->at)) {
        return NAN;
    }
    load_by(arc, direction, arc->right);
    if (!solve_bordered(arc, place->tangent, arc->right, 0, answer)) {
        return NAN;
    }
    return 1 / static_arc_product(arc, direction, answer);
}
