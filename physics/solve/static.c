#include "physics/solve/static.h"

#include "physics/solve/quaternion.h"
#include "physics/solve/static_energy.h"
#include "physics/solve/static_newton.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    STAGES = 10,        /* of an element, when the tolerance decides about nodes */
    ELEMENTS_MAX = 600, /* some 300 MB */
    HISTORY = 6         /* points of the path to extrapolate from */
};

/* The path ends where steps become shorter than this. */
static const double SHORTEST = 1e-5;

/* How far a step's extrapolation may be off, in position and quaternion: more could be another
 * equilibrium. */
static const double OFF_MAX = 0.4, OFF_AIM = 0.05;

/* Below this a difference that finer meshes do not halve is rounding. */
static const double ROUNDING = 1e-10;

/* Longest step in the size of the load of a rod that may buckle: on a longer one past the buckling
 * load it would miss the bend of the path and go on with the straight rod. */
static const double PERTURBED = 0.03;

/* Stretch that a rod between two held ends has in addition at the beginning of the path: it can be
 * straight there, and buckles under forces that do not depend on how stiff it is. */
static const double SOFT = 0.02;

struct static_solution {
    const solve_rod *rod;
    static_system *system;
    static_newton *newton;
    double *y; /* [unknowns] */
};

/* A path with parameter first .. last: from -1 to 0 an imperfection grows, to 1 the loads, and it
 * goes away again; beyond that the perturbation does. */
typedef struct path_shape {
    double first, last, perturbation, stretch;
    double longest; /* step */
    bool may_buckle;
    bool known;         /* from a manufactured shape, at full load */
    bool spins, twists; /* no end holds the rotation; and a round, straight rod may also twist */
    int director;
    double size;       /* of the loads: what turns the rod by so many radians */
    double wavenumber; /* of the solution */
} path_shape;

/* ---- how much there is to follow ----------------------------------------------------------- */

enum { SAMPLES = 33 };

static double norm(const double *x)
{
    return sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
}

static bool is_round(const solve_section *section)
{
    return section->curvature_stiffness[0] == section->curvature_stiffness[1] &&
           section->strain_stiffness[0] == section->strain_stiffness[1];
}

/* How much more what bends with so many powers of a lever does here than it does to a rod of the
 * scales' stiffness: 1 where that does not vary. Levers reach from an end that nothing holds. */
static double softness(const solve_rod *rod, const solve_section *sections, int power)
{
    bool start = rod->ends[0].holds_position, end = rod->ends[1].holds_position;
    double bent = 0, total = 0;
    for (int i = 0; i < SAMPLES; i++) {
        const double *bends = sections[i].curvature_compliance;
        double s = (double)i / (SAMPLES - 1), lever = start == end ? 1 : start ? 1 - s : s;
        bent += pow(lever, power) * fmax(bends[0], bends[1]);
        total += pow(lever, power);
    }
    return bent / total;
}

/* Largest loads at SAMPLES points: a force bends over the length sqrt(EI/F), a distributed one over
 * its cube root. */
static ad_status measure(const solve_rod *rod, path_shape *path, ad_error *error)
{
    double s[SAMPLES], force = 0, moment = 0, spread = 0, couple = 0, rest_curvature = 0;
    int held = 0;
    bool straight = true, round = true;
    solve_section sections[SAMPLES];
    solve_rest rest[SAMPLES];
    solve_load load[SAMPLES];
    for (int i = 0; i < SAMPLES; i++) {
        s[i] = (double)i / (SAMPLES - 1);
    }
    ad_status status = solve_rod_sections(rod, SAMPLES, s, sections, error);
    status = status == AD_OK ? solve_rod_rest(rod, SAMPLES, s, 0, rest, error) : status;
    if (status == AD_OK) {
        status = solve_rod_load(rod, SAMPLES, s, 0, load, error);
    }
    for (int end = 0; end < 2 && status == AD_OK; end++) {
        solve_end_state at;
        status = solve_rod_end(rod, end, 0, &at, error);
        force = fmax(force, rod->ends[end].holds_position ? 0 : norm(at.force));
        moment = fmax(moment, rod->ends[end].holds_rotation ? 0 : norm(at.moment));
        held += rod->ends[end].holds_position;
    }
    for (int i = 0; i < SAMPLES && status == AD_OK; i++) {
        round = round && is_round(&sections[i]);
        double sideways = hypot(rest[i].strain[0], rest[i].strain[1]);
        straight = straight && sideways == 0 && norm(rest[i].curvature) == 0 &&
                   norm(load[i].body_force) == 0;
        spread = fmax(spread, norm(load[i].force) + norm(load[i].body_force));
        couple = fmax(couple, norm(load[i].moment) + norm(load[i].body_moment));
        rest_curvature = fmax(rest_curvature, norm(rest[i].curvature));
    }
    if (status != AD_OK) {
        return status;
    }
    double soft[3] = {softness(rod, sections, 0), softness(rod, sections, 1),
                      softness(rod, sections, 2)};
    moment *= soft[0];
    couple *= soft[0];
    force *= soft[1];
    spread *= soft[2];
    path->twists = round && straight && couple == 0;
    path->size = fmax(1e-3, moment + force / 2 + spread / 6 + couple + (held > 1 ? 3 : 0));
    double compression = soft[1] * rod_numbers_of(&rod->scene).compression;
    path->may_buckle = held > 1 || compression > 1;
    bool careful = path->may_buckle || path->perturbation != 0;
    path->longest = careful ? PERTURBED / path->size : path->last;
    path->wavenumber = rest_curvature + moment + sqrt(force) + cbrt(spread) + couple;
    return AD_OK;
}

static ad_status shape_path(const solve_rod *rod, const solve_settings *settings, path_shape *path,
                            ad_error *error)
{
    scene given = rod->scene;
    given.motion = SCENE_AUTOMATIC;
    rod_plane plane = rod_plane_of(&given);
    const solve_end *ends = rod->ends;
    bool squeezed = ends[0].holds_position && ends[1].holds_position;
    *path = (path_shape){.known = scene_is_manufactured(&rod->scene),
                         .first = scene_is_imperfect(&rod->scene) ? -1 : 0,
                         .last = settings->perturbation == 0 ? 1 : 2,
                         .perturbation = settings->perturbation,
                         .spins = !ends[0].holds_rotation && !ends[1].holds_rotation,
                         .stretch = squeezed ? SOFT : 0,
                         .director = plane.is_planar && plane.director == 0};
    return measure(rod, path, error);
}

static static_path path_at(const path_shape *path, double parameter)
{
    double along = fmax(0, parameter), load = fmin(1, along), rest = 1 - load;
    return (static_path){.load = load,
                         .imperfection = path->first < 0 ? fmin(1 + parameter, rest) : 0,
                         .perturbation = path->perturbation * along * (2 - along),
                         .director = path->director,
                         .spring = path->spins && !path->twists ? rest : 0,
                         .twist_spring = path->spins && path->twists ? 1 : 0,
                         .stretch = path->stretch * rest};
}

/* ---- following it -------------------------------------------------------------------------- */

/* Solutions that the path went through, the newest last. */
typedef struct path_history {
    int count;
    double parameter[HISTORY], *y[HISTORY], *memory;
} path_history;

static void remember(path_history *past, double parameter, const double *y, size_t unknowns)
{
    if (past->count == HISTORY) {
        double *oldest = past->y[0];
        for (int i = 1; i < HISTORY; i++) {
            past->y[i - 1] = past->y[i];
            past->parameter[i - 1] = past->parameter[i];
        }
        past->y[HISTORY - 1] = oldest;
        past->count--;
    }
    past->parameter[past->count] = parameter;
    memcpy(past->y[past->count++], y, unknowns * sizeof *y);
}

/* Lagrange's polynomial through the past. */
static void extrapolate(const path_history *past, double parameter, double *y, size_t unknowns)
{
    memset(y, 0, unknowns * sizeof *y);
    for (int i = 0; i < past->count; i++) {
        double weight = 1;
        for (int j = 0; j < past->count; j++) {
            double distance = past->parameter[i] - past->parameter[j];
            weight *= i == j ? 1 : (parameter - past->parameter[j]) / distance;
        }
        for (size_t k = 0; k < unknowns; k++) {
            y[k] += weight * past->y[i][k];
        }
    }
}

/* Largest difference of position and quaternion. */
static double distance(const double *a, const double *b, size_t unknowns)
{
    double result = 0;
    for (size_t k = 0; k < unknowns; k++) {
        if (k % STATIC_ROWS < STATIC_N) {
            double off = fabs(a[k] - b[k]);
            result = off <= result ? result : off;
        }
    }
    return result;
}

/* From the unstressed rod to the end of the path, or as far as it goes. */
static ad_status follow(static_solution *x, const path_shape *path, solve_report *report,
                        ad_error *error)
{
    size_t unknowns = static_system_unknowns(x->system);
    path_history past = {.memory = malloc((HISTORY + 1) * unknowns * sizeof(double))};
    if (!past.memory) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory");
    }
    double *guess = past.memory + HISTORY * unknowns, at;
    double step = fmin(path->longest, 1 / path->size);
    for (int i = 0; i < HISTORY; i++) {
        past.y[i] = past.memory + (size_t)i * unknowns;
    }
    ad_status status = static_system_guess(x->system, x->y, error);
    report->load_fraction = 0;
    at = path->known ? path->last : path->first;
    static_path here = path_at(path, at);
    static_system_set(x->system, &here);
    bool going = status == AD_OK && static_newton_solve(x->newton, x->y, &report->newton_steps);
    while (going && at < path->last) {
        remember(&past, at, x->y, unknowns);
        bool accepted = false;
        while (!accepted && step >= SHORTEST) {
            double left = path->last - at, next = step > 0.9 * left ? path->last : at + step;
            extrapolate(&past, next, guess, unknowns);
            memcpy(x->y, guess, unknowns * sizeof *guess);
            here = path_at(path, next);
            static_system_set(x->system, &here);
            bool solved = static_newton_solve(x->newton, x->y, &report->newton_steps);
            double off = solved ? distance(x->y, guess, unknowns) : 1;
            accepted = solved && off <= OFF_MAX;
            double factor = accepted ? pow(OFF_AIM / fmax(off, 1e-9), 1.0 / past.count) : 0.4;
            at = accepted ? next : at;
            double longest = at < 1 ? path->longest : path->last;
            step = fmin(longest, step * fmin(4, fmax(0.3, factor)));
            report->load_steps += accepted;
        }
        going = accepted;
    }
    if (status == AD_OK && !going && past.count > 0) { /* back to where the path ended */
        memcpy(x->y, past.y[past.count - 1], unknowns * sizeof *x->y);
    }
    here = path_at(path, at);
    static_system_set(x->system, &here);
    report->load_fraction = going ? 1 : fmin(fmax(at, 0), 1 - 1e-9);
    free(past.memory);
    return status;
}

/* ---- meshes -------------------------------------------------------------------------------- */

void static_free(static_solution *x)
{
    if (x) {
        static_newton_free(x->newton);
        static_system_free(x->system);
        free(x->y);
        free(x);
    }
}

static ad_status create(const solve_rod *rod, int stages, int elements, const double *edges,
                        static_solution **result, ad_error *error)
{
    static_solution *x = calloc(1, sizeof *x);
    *result = x;
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory");
    }
    x->rod = rod;
    ad_status status = static_system_create(rod, stages, elements, edges, &x->system, error);
    if (status == AD_OK) {
        status = static_newton_create(x->system, &x->newton, error);
    }
    if (status == AD_OK) {
        x->y = malloc(static_system_unknowns(x->system) * sizeof *x->y);
        status = x->y ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    }
    if (status != AD_OK) {
        static_free(x);
        *result = NULL;
    }
    return status;
}

/* y at s, by the polynomial of its element. */
static void interpolate(const static_solution *x, double s, double *y)
{
    const gauss_rule *rule = static_system_rule(x->system);
    const double *edges = static_system_edges(x->system);
    double weights[GAUSS_STAGES_MAX + 2];
    int first = 0, last = static_system_elements(x->system) - 1;
    while (first < last) {
        int middle = (first + last + 1) / 2;
        if (edges[middle] <= s) {
            first = middle;
        } else {
            last = middle - 1;
        }
    }
    solve_gauss_lagrange(rule, (s - edges[first]) / (edges[first + 1] - edges[first]), weights);
    const double *from = x->y + (size_t)first * ((size_t)rule->stages + 1) * STATIC_ROWS;
    memset(y, 0, STATIC_ROWS * sizeof *y);
    for (int i = 0; i < rule->stages + 2; i++) {
        for (int k = 0; k < STATIC_ROWS; k++) {
            y[k] += weights[i] * from[i * STATIC_ROWS + k];
        }
    }
}

/* The last Chebyshev coefficient over an element: of position and quaternion, and of force and
 * moment relative to the largest, `size`. */
static double last_term(const static_solution *x, int element, double size)
{
    const gauss_rule *rule = static_system_rule(x->system);
    int stages = rule->stages;
    const double *y = x->y + (size_t)element * ((size_t)stages + 1) * STATIC_ROWS;
    double result = 0;
    for (int k = 0; k < STATIC_ROWS; k++) {
        double sum = 0; /* the divided difference of the points 0, c; that of 0, c, 1 is 0 */
        for (int i = 0; i <= stages; i++) {
            double point = i == 0 ? 0 : rule->nodes[i - 1];
            sum += rule->barycentric[i] * 2 * (point - 1) * y[i * STATIC_ROWS + k];
        }
        result = fmax(result, fabs(sum) / (k < STATIC_N ? 1 : size));
    }
    return ldexp(result, 1 - stages);
}

/* Halves elements whose last term is above the threshold, or all when there are none. Returns how
 * many elements there are then; edges [that + 1], allocated. */
static int halve(const static_solution *x, double threshold, double **edges)
{
    int elements = static_system_elements(x->system), count = 0, halved = 0;
    const double *from = static_system_edges(x->system);
    double size = 1;
    double *to = malloc((2 * (size_t)elements + 1) * sizeof *to);
    *edges = to;
    for (size_t k = 0; k < static_system_unknowns(x->system); k++) {
        size = fmax(size, fabs(x->y[k]));
    }
    for (int e = 0; e < elements; e++) {
        halved += last_term(x, e, size) > threshold;
    }
    for (int e = 0; e < elements && to; e++) {
        to[count++] = from[e];
        if (halved == 0 || last_term(x, e, size) > threshold) {
            to[count++] = (from[e] + from[e + 1]) / 2;
        }
    }
    if (to) {
        to[count] = 1;
    }
    return count;
}

/* *fine with the solution of `coarse` as a guess, at *points, allocated. */
static ad_status refine(const static_solution *coarse, double threshold, static_solution **fine,
                        double **points, ad_error *error)
{
    double *edges;
    int elements = halve(coarse, threshold, &edges);
    int stages = static_system_rule(coarse->system)->stages;
    *fine = NULL;
    *points = NULL;
    ad_status status = edges ? create(coarse->rod, stages, elements, edges, fine, error)
                             : ad_fail(error, AD_NO_MEMORY, "out of memory");
    free(edges);
    if (status != AD_OK) {
        return status;
    }
    size_t count = static_system_unknowns((*fine)->system) / STATIC_ROWS;
    *points = malloc(count * sizeof **points);
    if (!*points) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory");
    }
    static_system_points((*fine)->system, *points);
    for (size_t i = 0; i < count; i++) {
        interpolate(coarse, (*points)[i], (*fine)->y + i * STATIC_ROWS);
    }
    return AD_OK;
}

/* Largest distance of the positions at the nodes of the finer one, and largest turn about the
 * tangent, rad, which positions do not show. */
static double difference(const static_solution *coarse, const static_solution *fine,
                         const double *points)
{
    size_t count = static_system_unknowns(fine->system) / STATIC_ROWS;
    double result = 0, y[STATIC_ROWS], off[3];
    for (size_t i = 0; i < count; i++) {
        interpolate(coarse, points[i], y);
        for (int k = 0; k < 3; k++) {
            off[k] = y[k] - fine->y[i * STATIC_ROWS + (size_t)k];
        }
        double turn[4];
        quaternion_quotient(y + STATIC_Q, fine->y + i * STATIC_ROWS + STATIC_Q, turn);
        result = fmax(result, fmax(norm(off), 2 * fabs(turn[3])));
    }
    return result;
}

/* A finer solution in place of *x, and how far the two are apart. */
static ad_status improve(static_solution **x, const path_shape *path, double tolerance,
                         solve_report *report, ad_error *error)
{
    static_solution *fine;
    double *points;
    ad_status status = refine(*x, tolerance / 10, &fine, &points, error);
    if (status == AD_OK) {
        static_path end = path_at(path, path->last);
        static_system_set(fine->system, &end);
        bool solved = static_newton_solve(fine->newton, fine->y, &report->newton_steps);
        double off = solved ? difference(*x, fine, points) : INFINITY;
        if (off > OFF_MAX) { /* the coarse mesh was no guide */
            status = follow(fine, path, report, error);
            off = INFINITY;
        }
        report->estimate = off;
    }
    free(points);
    if (status == AD_OK) {
        static_free(*x);
        *x = fine;
    } else {
        static_free(fine);
    }
    return status;
}

static int nodes_of(const static_solution *x)
{
    return static_system_elements(x->system) * static_system_rule(x->system)->stages;
}

/* The first mesh: as many nodes as asked for, or enough for the waves that the loads make. */
static ad_status begin(const solve_rod *rod, const solve_settings *settings, const path_shape *path,
                       static_solution **result, ad_error *error)
{
    int nodes = settings->nodes, stages = STAGES,
        elements = 1 + (int)fmin(path->wavenumber / 4, 63);
    double edges[ELEMENTS_MAX + 1];
    if (nodes > 0) {
        elements = (nodes + GAUSS_STAGES_MAX - 1) / GAUSS_STAGES_MAX;
        elements = elements < ELEMENTS_MAX ? elements : ELEMENTS_MAX;
        stages = (nodes + elements - 1) / elements;
        stages = stages < GAUSS_STAGES_MAX ? stages : GAUSS_STAGES_MAX;
    }
    for (int e = 0; e <= elements; e++) {
        edges[e] = (double)e / elements;
    }
    return create(rod, stages, elements, edges, result, error);
}

ad_status static_solve(const solve_rod *rod, const solve_settings *settings,
                       static_solution **result, solve_report *report, ad_error *error)
{
    path_shape path;
    static_solution *x = NULL;
    *report = (solve_report){.estimate = NAN, .energy_mismatch = NAN};
    *result = NULL;
    ad_status status = shape_path(rod, settings, &path, error);
    if (status == AD_OK) {
        status = begin(rod, settings, &path, &x, error);
    }
    if (status == AD_OK) {
        status = follow(x, &path, report, error);
    }
    bool done = settings->nodes > 0;
    while (status == AD_OK && !done && report->load_fraction == 1 &&
           2 * static_system_elements(x->system) <= ELEMENTS_MAX) {
        double before = report->estimate;
        status = improve(&x, &path, settings->tolerance, report, error);
        bool rounding = report->estimate < ROUNDING && report->estimate > before / 2;
        done = report->estimate <= settings->tolerance || rounding;
    }
    if (status != AD_OK) {
        static_free(x);
        return status;
    }
    report->nodes = nodes_of(x);
    report->may_buckle = path.may_buckle;
    *result = x;
    return AD_OK;
}

/* ---- the solution at a point --------------------------------------------------------------- */

ad_status static_at(const static_solution *x, size_t n, const double *s, solve_state *out,
                    ad_error *error)
{
    solve_rest *rest = malloc(n * sizeof *rest);
    solve_section *sections = malloc(n * sizeof *sections);
    ad_status status = rest && sections
                           ? solve_rod_rest(x->rod, n, s, 0, rest, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", n);
    status = status == AD_OK ? solve_rod_sections(x->rod, n, s, sections, error) : status;
    for (size_t i = 0; i < n && status == AD_OK; i++) {
        const static_point at = {.rest = rest[i],
                                 .strain_compliance = sections[i].strain_compliance,
                                 .curvature_compliance = sections[i].curvature_compliance};
        double y[STATIC_ROWS], square = 0;
        interpolate(x, s[i], y);
        for (int k = 0; k < 4; k++) {
            square += y[STATIC_Q + k] * y[STATIC_Q + k];
        }
        for (int k = 0; k < 4; k++) {
            y[STATIC_Q + k] /= sqrt(square);
        }
        out[i] = (solve_state){.velocity = {0}};
        memcpy(out[i].position, y + STATIC_R, sizeof out[i].position);
        memcpy(out[i].rotation, y + STATIC_Q, sizeof out[i].rotation);
        memcpy(out[i].moment, y + STATIC_M, sizeof out[i].moment);
        static_body_force(y, out[i].force);
        static_strains(&at, y, out[i].strain, out[i].curvature);
    }
    free(rest);
    free(sections);
    return status;
}

ad_status static_energy(const static_solution *x, solve_energy *energy, ad_error *error)
{
    return static_energy_of(x->system, x->rod, x->y, energy, error);
}
