#include "physics/local/actuation.h"

#include "autodiff/dense.h"
#include "physics/law/law.h"
#include "physics/law/law_numbers.h"
#include "physics/numerics/quaternion.h"
#include "physics/rod/rod_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ROWS = ACTUATION_ROWS, STEPS_MAX = 60 };

double solve_actuation_pull(const solve_actuation *a, int i)
{
    const solve_extent *extent = &a->extents[i];
    double pull = a->factor * a->actuators[i].pull + (a->tensions ? a->tensions[i] : 0);
    pull *= a->rubbed[i] != 0 ? exp(-a->rubbed[i]) : 1;
    return extent->start <= a->s && a->s <= extent->end ? pull : 0;
}

/* As the laws are given it. */
static void put_actuator(const solve_actuator *at, double pull, double given[5])
{
    memcpy(given, at->offset, sizeof at->offset);
    memcpy(given + 2, at->slope, sizeof at->slope);
    given[4] = pull;
}

/* ---- tubes --------------------------------------------------------------------------------- */

/* What the law of a tube is given: u, its turn, its torsion, its numbers. */
typedef struct tube_given {
    double curvature[3], turn[3], numbers[6];
} tube_given;

static tube_given tube_of(const solve_actuation *a, int i, const double *curvature)
{
    const double *state = a->tubes + 2 * (i - solve_actuation_first_tube(a)), *rest = a->rest + 3;
    const double share = rod_tube_shape_share(a->factor);
    const solve_actuator *at = &a->actuators[i];
    tube_given x = {.turn = {cos(state[0]), sin(state[0]), state[1]},
                    .numbers = {at->bending[0], at->bending[1], [5] = at->softness}};
    memcpy(x.curvature, curvature, sizeof x.curvature);
    for (int k = 0; k < 3; k++) {
        x.numbers[2 + k] = rest[k] + share * (at->curvature[k] - rest[k]);
    }
    return x;
}

/* Its energy, gradient [ROWS] and second derivatives [LAW_STIFFNESS] by u, theta, m_i. */
static double tube_law(const tube_given *given, double *gradient, double *second)
{
    double energy = 0;
    memset(gradient, 0, ROWS * sizeof *gradient);
    memset(second, 0, LAW_STIFFNESS * sizeof *second);
    number_law_tube_with_energy(given->curvature, given->turn, given->numbers, &energy, gradient,
                                second);
    return energy;
}

bool solve_tube_is_here(const solve_actuation *a, int i)
{
    return a->s <= a->extents[i].end;
}

static void add_tube(const solve_actuation *a, int i, const double *strains, double *wrench,
                     double (*by_strains)[ROWS])
{
    const tube_given x = tube_of(a, i, strains + 3);
    double gradient[ROWS], second[LAW_STIFFNESS];
    tube_law(&x, gradient, second);
    for (int k = 0; k < 3; k++) {
        wrench[3 + k] += gradient[k];
        for (int c = 0; c < 3 && by_strains; c++) {
            by_strains[3 + k][3 + c] += second[law_entry(k, c)];
        }
    }
}

void solve_tube_rate(const solve_actuation *a, int i, const double *curvature, double rate[2],
                     double (*by)[5])
{
    double gradient[ROWS] = {0}, second[LAW_STIFFNESS] = {0};
    if (solve_tube_is_here(a, i)) {
        const tube_given x = tube_of(a, i, curvature);
        tube_law(&x, gradient, second);
    }
    rate[0] = -gradient[4];
    rate[1] = gradient[3];
    for (int k = 0; k < 5 && by; k++) {
        by[0][k] = -second[law_entry(4, k)];
        by[1][k] = second[law_entry(3, k)];
    }
}

double solve_tube_energy(const solve_actuation *a, const double *curvature)
{
    double sum = 0;
    for (int i = solve_actuation_first_tube(a); i < a->count; i++) {
        if (solve_tube_is_here(a, i)) {
            const tube_given x = tube_of(a, i, curvature);
            double gradient[ROWS], second[LAW_STIFFNESS];
            sum += tube_law(&x, gradient, second);
            sum -= x.turn[2] * gradient[4];
        }
    }
    return sum;
}

double solve_tube_variation(const solve_actuation *a, int i, const double *curvature,
                            const double p[5], const double q[5])
{
    static const double stiff = 1e6; /* of bending, in place of one that does not twist */
    const solve_actuator *at = &a->actuators[i];
    const double torsion = fmin(1 / at->softness, stiff * fmin(at->bending[0], at->bending[1]));
    const tube_given x = tube_of(a, i, curvature);
    double gradient[ROWS], second[LAW_STIFFNESS], sum = torsion * (p[2] + p[4]) * (q[2] + q[4]);
    tube_law(&x, gradient, second);
    for (int k = 0; k < 4; k++) {
        for (int c = 0; c < 4; c++) {
            sum += p[k] * second[law_entry(k, c)] * q[c];
        }
    }
    return sum;
}

/* ---- a law ---------------------------------------------------------------------------------- */

double solve_law_energy(const solve_actuation *a, const double *strains, double *wrench,
                        double (*by_strains)[ROWS])
{
    double x[ROWS];
    for (int k = 0; k < ROWS; k++) {
        x[k] = strains[k] - a->rest[k];
    }
    return scene_law_beyond(a->law, a->length, a->unit_force, x, wrench, by_strains);
}

/* ---- all of them --------------------------------------------------------------------------- */

void solve_actuation_wrench(const solve_actuation *a, const double *strains, double *wrench,
                            double (*by_strains)[ROWS])
{
    double stiffness[LAW_STIFFNESS] = {0};
    memset(wrench, 0, ROWS * sizeof *wrench);
    if (by_strains) {
        memset(by_strains, 0, ROWS * sizeof *by_strains);
    }
    if (a->law) {
        solve_law_energy(a, strains, wrench, by_strains);
    }
    for (int i = 0; i < a->count; i++) {
        if (a->extents[i].law == LAW_TUBE) {
            if (a->tubes && solve_tube_is_here(a, i)) {
                add_tube(a, i, strains, wrench, by_strains);
            }
            continue;
        }
        const double pull = solve_actuation_pull(a, i), *v = strains, *u = strains + 3;
        double given[5];
        if (pull == 0) {
            continue;
        }
        put_actuator(&a->actuators[i], pull, given);
        number_law_actuator((int)a->extents[i].law, v, u, given, wrench, stiffness);
    }
    for (int i = 0; i < ROWS && by_strains; i++) {
        for (int k = 0; k < ROWS; k++) {
            by_strains[i][k] += stiffness[law_entry(i, k)];
        }
    }
}

double solve_actuation_energy(const solve_actuation *a, const double *strains)
{
    double sum = 0;
    for (int i = 0; i < solve_actuation_first_tube(a); i++) {
        double given[5];
        put_actuator(&a->actuators[i], solve_actuation_pull(a, i), given);
        number_law_actuator_energy((int)a->extents[i].law, strains, strains + 3, given, &sum);
    }
    return sum;
}

/* The energy of a tension of 1 is the length, its gradient by v the tangent. */
double solve_actuation_tangent(const solve_actuation *a, int i, const double *strains,
                               double tangent[3])
{
    double given[5], length = 0, wrench[ROWS] = {0}, unused[LAW_STIFFNESS];
    put_actuator(&a->actuators[i], 1, given);
    number_law_tendon_energy(strains, strains + 3, given, &length);
    number_law_tendon(strains, strains + 3, given, wrench, unused);
    memcpy(tangent, wrench, 3 * sizeof *tangent);
    return length;
}

double solve_actuation_length(const solve_actuation *a, int i, const double *strains)
{
    const solve_extent *extent = &a->extents[i];
    double given[5], length = 0;
    put_actuator(&a->actuators[i], 1, given);
    number_law_tendon_energy(strains, strains + 3, given, &length);
    return extent->start <= a->s && a->s <= extent->end ? length : 0;
}

/* ---- strains under a wrench ---------------------------------------------------------------- */

static double largest(const double *x)
{
    double result = 0;
    for (int k = 0; k < ROWS; k++) {
        result = fabs(x[k]) <= result ? result : fabs(x[k]);
    }
    return result;
}

/* missing = x - rest - compliance (wrench - actuation(x)), and its derivatives by x, column-major,
 * where that is not NULL. */
static void miss(const solve_actuation *a, const double *rest, const double *compliance,
                 const double *wrench, const double *x, double *missing, double *by_x)
{
    double pull[ROWS], by_strains[ROWS][ROWS];
    solve_actuation_wrench(a, x, pull, by_x ? by_strains : NULL);
    for (int k = 0; k < ROWS; k++) {
        missing[k] = x[k] - rest[k] - compliance[k] * (wrench[k] - pull[k]);
        for (int c = 0; c < ROWS && by_x; c++) {
            by_x[c * ROWS + k] = (k == c) + compliance[k] * by_strains[k][c];
        }
    }
}

/* Newton's method, with steps shortened until less is missing. */
static bool find(const solve_actuation *a, const double *rest, const double *compliance,
                 const double *wrench, double *x)
{
    static const double last = 1e-9; /* a step after which the next is below rounding */
    double missing[ROWS], step[ROWS], next[ROWS], factor[ROWS * ROWS];
    int pivots[ROWS];
    for (int i = 0; i < STEPS_MAX; i++) {
        miss(a, rest, compliance, wrench, x, step, factor);
        double before = largest(step), share = 1;
        if (ad_dense_lu(ROWS, factor, pivots) != 0) {
            return false;
        }
        ad_dense_lu_solve(ROWS, 1, factor, pivots, step);
        bool done = largest(step) <= last * (1 + largest(x));
        do {
            for (int k = 0; k < ROWS; k++) {
                next[k] = x[k] - share * step[k];
            }
            miss(a, rest, compliance, wrench, next, missing, NULL);
            share /= 2;
        } while (!done && !(largest(missing) < before) && share > 1e-9);
        memcpy(x, next, sizeof next);
        if (done || !(share > 1e-9)) {
            return done;
        }
    }
    return false;
}

/* (1 + compliance d actuation/d x)^-1 compliance; false: it does not exist. */
static bool differentiate(const solve_actuation *a, const double *compliance, const double *x,
                          double (*by_wrench)[ROWS])
{
    double unused[ROWS], factor[ROWS * ROWS], columns[ROWS * ROWS] = {0};
    int pivots[ROWS];
    miss(a, x, compliance, x, x, unused, factor);
    if (ad_dense_lu(ROWS, factor, pivots) != 0) {
        return false;
    }
    for (int k = 0; k < ROWS; k++) {
        columns[k * ROWS + k] = compliance[k];
    }
    ad_dense_lu_solve(ROWS, ROWS, factor, pivots, columns);
    for (int k = 0; k < ROWS; k++) {
        for (int c = 0; c < ROWS; c++) {
            by_wrench[k][c] = columns[c * ROWS + k];
        }
    }
    return true;
}

static void fill_nan(size_t count, double *x)
{
    for (size_t k = 0; k < count; k++) {
        x[k] = NAN;
    }
}

void solve_actuation_strains(const solve_actuation *a, const double *rest, const double *compliance,
                             const double *wrench, double *strains, double (*by_wrench)[ROWS])
{
    for (int k = 0; k < ROWS; k++) {
        strains[k] = rest[k] + compliance[k] * wrench[k];
    }
    if (solve_actuation_pulls(a)) {
        bool found = find(a, rest, compliance, wrench, strains) &&
                     (!by_wrench || differentiate(a, compliance, strains, by_wrench));
        if (!found) {
            fill_nan(ROWS, strains);
            fill_nan(by_wrench ? ROWS * ROWS : 0, (double *)by_wrench);
        }
    } else if (by_wrench) {
        memset(by_wrench, 0, ROWS * sizeof *by_wrench);
        for (int k = 0; k < ROWS; k++) {
            by_wrench[k][k] = compliance[k];
        }
    }
}

void solve_actuation_stiffen(const solve_actuation *a, const double *strains,
                             double stiffness[3][3], double softness[3][3], double coupling[3][3])
{
    double unused[ROWS], by[ROWS][ROWS], factor[9], soft[9] = {0};
    int pivots[3];
    solve_actuation_wrench(a, strains, unused, by);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            stiffness[i][j] += by[3 + i][3 + j];
            coupling[i][j] = by[i][3 + j];
            factor[j * 3 + i] = (i == j) + softness[i][i] * by[i][j];
        }
        soft[i * 3 + i] = softness[i][i];
    }
    if (ad_dense_lu(3, factor, pivots) == 0) {
        ad_dense_lu_solve(3, 3, factor, pivots, soft);
    } else {
        fill_nan(9, soft);
    }
    for (int i = 0; i < 9; i++) {
        softness[i % 3][i / 3] = soft[i];
    }
}

/* ---- along the rod ------------------------------------------------------------------------- */

ad_status solve_actuation_measure(const solve_rod *rod, size_t n, const double *s, double t,
                                  solve_actuation_size *size, ad_error *error)
{
    size_t count = (size_t)rod->actuators;
    *size = (solve_actuation_size){0};
    if (count == 0) {
        return AD_OK;
    }
    solve_actuator *all = malloc(n * count * sizeof *all);
    ad_status status = all ? solve_rod_actuators(rod, n, s, t, all, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", n);
    for (size_t i = 0; i < n && status == AD_OK; i++) {
        double moment = 0;
        for (size_t j = 0; j < count; j++) {
            if (rod->extents[j].law == LAW_TUBE) {
                continue;
            }
            const solve_actuator *at = &all[i * count + j];
            double distance = hypot(at->offset[0], at->offset[1]);
            moment += fabs(at->pull) * distance;
            if (rod->extents[j].has_length && distance > 0) {
                moment += fabs(solve_rod_displacement(rod, (int)j, t)) / distance;
            }
            size->winding = fmax(size->winding,
                                 distance > 0 ? hypot(at->slope[0], at->slope[1]) / distance : 0);
        }
        size->moment = fmax(size->moment, moment);
    }
    free(all);
    return status;
}

ad_status solve_actuation_in_si(const scene *rod_scene, size_t n, const double *s, solve_rod **rod,
                                solve_actuator **actuators, ad_error *error)
{
    double *scaled = malloc(n * sizeof *scaled);
    *rod = NULL;
    *actuators = NULL;
    ad_status status =
        scaled ? ad_dense_load(error) : ad_fail(error, AD_NO_MEMORY, "out of memory for tendons");
    status = status == AD_OK ? solve_rod_create(rod_scene, rod, error) : status;
    size_t count = status == AD_OK ? n * (size_t)(*rod)->actuators : 0;
    if (status == AD_OK) {
        *actuators = malloc((count + 1) * sizeof **actuators);
        status = *actuators ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for tendons");
    }
    for (size_t i = 0; i < n && status == AD_OK; i++) {
        scaled[i] = s[i] / (*rod)->scales.length;
    }
    status = status == AD_OK ? solve_rod_actuators(*rod, n, scaled, 0, *actuators, error) : status;
    for (size_t i = 0; status == AD_OK && i < count; i++) {
        if ((*rod)->extents[i % (size_t)(*rod)->actuators].law == LAW_TUBE) {
            solve_actuator *tube = &(*actuators)[i];
            double unit = (*rod)->scales.moment * (*rod)->scales.length;
            for (int k = 0; k < 3; k++) {
                tube->curvature[k] /= (*rod)->scales.length;
            }
            tube->bending[0] *= unit;
            tube->bending[1] *= unit;
            tube->softness /= unit;
            continue;
        }
        for (int k = 0; k < 2; k++) {
            (*actuators)[i].offset[k] *= (*rod)->scales.length;
        }
        (*actuators)[i].pull *= (*rod)->scales.force;
    }
    free(scaled);
    return status;
}
