#include "physics/solve/static_path.h"

#include "physics/numerics/quaternion.h"
#include "physics/numerics/vector_size.h"
#include "physics/solve/static_survey.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { HISTORY = 6 }; /* points of the path to extrapolate from */

/* The path ends where steps become shorter than this. */
static const double SHORTEST = 1e-5;

/* How far a step's extrapolation is meant to be off, in position and quaternion. */
static const double OFF_AIM = 0.05;

/* A step is a leap where it is off by this share of how far it goes, and goes as far as this. */
static const double LEAP_SHARE = 0.3, LEAP_LEAST = 1e-4;

/* Longest step in the size of the load of a rod that may buckle: on a longer one past the buckling
 * load it would miss the bend of the path and go on with the straight rod. */
static const double PERTURBED = 0.03;

/* Stretch that a rod between two held ends has in addition at the beginning of the path: it can be
 * straight there, and buckles under forces that do not depend on how stiff it is. */
static const double SOFT = 0.02;

/* ---- how much there is to follow ----------------------------------------------------------- */

enum { SAMPLES = 33 }; /* of what actuators pull */

/* By how much a rotation vector, and the twist, turn the end that is held; rad. */
static double held_turn(const solve_rod *rod)
{
    const quantity *given = rod->scene.end.rotation_vector;
    double vector[3] = {0};
    for (int i = 0; i < 3 && rod->ends[1].holds_rotation && given[i].is_given; i++) {
        vector[i] = quantity_value(given[i], scene_length(&rod->scene), 0);
    }
    return vector_length(vector) + fabs(static_twist(rod));
}

/* What acts at single places. */
typedef struct single_loads {
    acting_size size;
    double compression; /* by Euler's load of the part between the place and the end that holds */
} single_loads;

/* Of a force along the tangent at s. */
static double compression_at(const solve_rod *rod, double s, double along)
{
    bool from_start = rod->ends[0].holds_rotation, from_end = rod->ends[1].holds_rotation;
    double lever = from_start ? s : from_end ? 1 - s : 1;
    double push = from_start ? -along : from_end ? along : fabs(along); /* springs alone hold it */
    return lever * lever * fmax(0, push);
}

static ad_status measure_jumps(const solve_rod *rod, single_loads *sum, ad_error *error)
{
    const solve_jumps *jumps = &rod->jumps;
    double s[SOLVE_JUMPS_MAX];
    solve_initial unstressed[SOLVE_JUMPS_MAX];
    *sum = (single_loads){.compression = 0};
    solve_jump_places(jumps, s);
    ad_status status = jumps->count > 0
                           ? solve_rod_initial(rod, (size_t)jumps->count, s, unstressed, error)
                           : AD_OK;
    for (int i = 0; i < jumps->count && status == AD_OK; i++) {
        acting of = jumps->at[i].acting;
        of.count = jumps->at[i].within;
        const double *numbers = solve_jump_numbers(jumps, jumps->number, i);
        const acting_on at = {unstressed[i].position, unstressed[i].rotation, NULL};
        double R[3][3], along[3], wrench[6] = {0};
        acting_measure(&of, numbers, at, &sum->size);
        acting_wrench(&of, numbers, at, ACTING_ALL, 1, wrench);
        rotation_matrix(unstressed[i].rotation, R);
        to_body(R, wrench, along);
        sum->compression += compression_at(rod, s[i], along[2]);
    }
    return status;
}

/* A force bends over the length sqrt(EI/F), a distributed one over its cube root. */
static ad_status measure(const solve_rod *rod, path_shape *path, ad_error *error)
{
    double s[SAMPLES], force = 0, moment = 0;
    int held = 0;
    static_survey along = {.straight = false};
    solve_actuation_size pull = {0};
    for (int i = 0; i < SAMPLES; i++) {
        s[i] = (double)i / (SAMPLES - 1);
    }
    ad_status status = static_survey_of(rod, &along, error);
    if (status == AD_OK) {
        status = solve_actuation_measure(rod, SAMPLES, s, 0, &pull, error);
    }
    for (int end = 0; end < 2 && status == AD_OK; end++) {
        solve_end_state at;
        status = solve_rod_end(rod, end, 0, &at, error);
        const scene_hold *hold = &rod->ends[end].hold;
        force = fmax(force, hold->directions == 3 ? 0 : vector_length(at.force));
        moment = fmax(moment, rod->ends[end].holds_rotation ? 0 : vector_length(at.moment));
        held += hold->directions > 0;
    }
    single_loads single;
    status = status == AD_OK ? measure_jumps(rod, &single, error) : status;
    if (status != AD_OK) {
        return status;
    }
    force += along.force + single.size.force;
    moment += along.moment + single.size.moment;
    bool straight = along.straight, loaded = false;
    for (int i = 0; i < rod->jumps.count; i++) {
        const solve_jump *at = &rod->jumps.at[i];
        loaded = loaded || at->within == at->acting.count;
        straight = straight && !at->turns;
        for (int k = 0; k < at->within; k++) { /* it holds the twist */
            straight = straight && !law_table[at->acting.law[k]].by_rotation;
        }
    }
    bool couples =
        along.couple > 0 || along.moment > 0 || single.size.moment > 0 || single.size.follows;
    double couple = along.softness[0] * along.couple, spread = along.softness[2] * along.spread;
    double tubes = rod_numbers_of(&rod->scene).tubes, turned = 0;
    for (int i = 0; i < rod->scene.tube_count; i++) {
        turned = fmax(turned, fabs(quantity_value(rod->scene.tubes[i].turned, 0, 0)));
    }
    moment = along.softness[0] * (moment + pull.moment);
    force *= along.softness[1];
    const scene_law *law = rod->scene.rod.law;
    bool round = along.round && (!law || law->symmetry == SCENE_SYMMETRY_ROUND);
    path->twists = round && straight && !couples && rod->actuators == 0;
    path->size = fmax(1e-3, moment + force / 2 + spread / 6 + couple + (held > 1 ? 3 : 0) +
                                3 * single.size.pulled + tubes + turned);
    loaded = loaded || spread > 0 || couples || rod->actuators > 0;
    path->may_snap = path->squeezed && !path->known && path->perturbation == 0 &&
                     (!straight || loaded || scene_is_imperfect(&rod->scene));
    double compression = rod_numbers_of(&rod->scene).compression + single.compression;
    compression *= along.softness[1];
    path->may_buckle = held > 1 || compression > 1;
    bool careful = path->may_buckle || path->perturbation != 0;
    path->longest = careful ? PERTURBED / path->size : path->last;
    path->turn = held_turn(rod);
    double founded = pow(rod_numbers_of(&rod->scene).foundation / 4, 0.25); /* Hetenyi's */
    path->wavenumber = path->turn + along.curvature + moment + sqrt(force) + cbrt(spread) + couple +
                       pull.winding + founded + 2 * tubes;
    return AD_OK;
}

ad_status static_path_shape(const solve_rod *rod, const solve_settings *settings, path_shape *path,
                            ad_error *error)
{
    scene given = rod->scene;
    given.motion = SCENE_AUTOMATIC;
    rod_plane plane = rod_plane_of(&given);
    const solve_end *ends = rod->ends;
    bool squeezed = ends[0].hold.directions > 0 && ends[1].hold.directions > 0;
    bool twisted = static_twist(rod) != 0;
    *path = (path_shape){.known = scene_is_manufactured(&rod->scene),
                         .first = scene_is_imperfect(&rod->scene) || twisted ? -1 : 0,
                         .last = settings->perturbation == 0 ? 1 : 2,
                         .perturbation = settings->perturbation,
                         .spins = !ends[0].holds_rotation && !ends[1].holds_rotation,
                         .stretch = squeezed ? SOFT : 0,
                         .twisted = twisted,
                         .planar = plane.is_planar,
                         .squeezed = squeezed,
                         .director = plane.is_planar && plane.director == 0};
    return measure(rod, path, error);
}

static_path static_path_at(const path_shape *path, double parameter)
{
    double along = fmax(0, parameter), load = fmin(1, along), rest = 1 - load;
    return (static_path){.load = load,
                         .ahead = path->twisted ? fmin(1, 1 + parameter) : 0,
                         .imperfection = path->first < 0 ? fmin(1 + parameter, rest) : 0,
                         .perturbation = path->perturbation * along * (2 - along),
                         .director = path->director,
                         .spring = path->spins && !path->twists ? rest : 0,
                         .twist_spring = path->spins && path->twists ? 1 : 0,
                         .stretch = path->stretch * rest};
}

static_path static_path_of_load(const path_shape *path, double load)
{
    return (static_path){.load = load,
                         .ahead = path->twisted,
                         .imperfection = path->first < 0 ? 1 - load : 0,
                         .director = path->director,
                         .plane_spring = path->spins && !path->twists ? 1 : 0,
                         .twist_spring = path->spins && path->twists ? 1 : 0};
}

bool static_path_is_true(const path_shape *path)
{
    bool turns_freely = path->spins && !(path->squeezed && (path->planar || path->twists));
    return !path->known && path->perturbation == 0 && !turns_freely;
}

/* ---- following it -------------------------------------------------------------------------- */

/* Solutions that the path went through, the newest last. */
typedef struct path_history {
    int count;
    size_t rows; /* of y at one place */
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

double static_path_distance(size_t rows, size_t unknowns, const double *a, const double *b)
{
    double result = 0;
    for (size_t k = 0; k < unknowns && !isnan(result); k++) {
        double off = k % rows < STATIC_N ? fabs(a[k] - (b ? b[k] : 0)) : 0;
        result = off <= result ? result : off;
    }
    return result;
}

/* Whether a step went elsewhere than the past does, and not by rounding alone. */
static bool is_leap(const path_history *past, const double *y, double off, size_t unknowns)
{
    enum { SMOOTH = 3 }; /* so many points show where the path goes */
    double moved = static_path_distance(past->rows, unknowns, y, past->y[past->count - 1]);
    return past->count >= SMOOTH && moved > LEAP_LEAST && off > LEAP_SHARE * moved;
}

ad_status static_path_follow(static_system *system, static_newton *newton, const path_shape *path,
                             double *y, bool *leaps, solve_report *report, ad_error *error)
{
    size_t unknowns = elements_unknowns(&system->mesh);
    path_history past = {.rows = (size_t)system->mesh.rows,
                         .memory = malloc((HISTORY + 1) * unknowns * sizeof(double))};
    if (!past.memory) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory");
    }
    double *guess = past.memory + HISTORY * unknowns, at;
    double step = fmin(path->longest, 1 / (path->size + path->turn));
    for (int i = 0; i < HISTORY; i++) {
        past.y[i] = past.memory + (size_t)i * unknowns;
    }
    ad_status status = static_system_guess(system, y, error);
    report->load_fraction = 0;
    *leaps = false;
    at = path->known ? path->last : path->first;
    static_path here = static_path_at(path, at);
    static_system_set(system, &here);
    bool going = status == AD_OK && static_newton_solve(newton, y, &report->newton_steps);
    while (going && at < path->last) {
        remember(&past, at, y, unknowns);
        bool accepted = false;
        while (!accepted && step >= SHORTEST) {
            double left = path->last - at, next = step > 0.9 * left ? path->last : at + step;
            extrapolate(&past, next, guess, unknowns);
            memcpy(y, guess, unknowns * sizeof *guess);
            here = static_path_at(path, next);
            static_system_set(system, &here);
            bool solved = static_newton_solve(newton, y, &report->newton_steps);
            double off = solved ? static_path_distance(past.rows, unknowns, y, guess) : 1;
            accepted = solved && off <= PATH_OFF_MAX;
            *leaps = *leaps || (accepted && is_leap(&past, y, off, unknowns));
            double factor = accepted ? pow(OFF_AIM / fmax(off, 1e-9), 1.0 / past.count) : 0.4;
            at = accepted ? next : at;
            double longest = at < 1 ? path->longest : path->last;
            step = fmin(longest, step * fmin(4, fmax(0.3, factor)));
            report->load_steps += accepted;
        }
        going = accepted;
    }
    if (status == AD_OK && !going && past.count > 0) { /* back to where the path ended */
        memcpy(y, past.y[past.count - 1], unknowns * sizeof *y);
    }
    here = static_path_at(path, at);
    static_system_set(system, &here);
    if (status == AD_OK && !going && past.count > 0 &&
        system->rod->lengths + system->rod->frictions > 0) {
        /* and the tensions to what they were */
        static_newton_solve(newton, y, &report->newton_steps);
    }
    report->load_fraction = going ? 1 : fmin(fmax(at, 0), 1 - 1e-9);
    free(past.memory);
    return status;
}
