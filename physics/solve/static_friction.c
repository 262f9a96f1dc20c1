#include "physics/solve/static_friction.h"

#include "physics/quaternion.h"
#include "physics/solve/mesh.h"
#include "physics/solve/solve_vector.h"
#include "physics/solve/static_system_internal.h"

#include <kinsol/kinsol.h>
#include <math.h>
#include <nvector/nvector_serial.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS_MAX = 60, DEPTH = 6 };

/* rad; what is reached, and what is accepted where rounding keeps it from that. */
static const double SMALL = 1e-12, ROUNDING = 1e-10;

struct static_friction {
    static_system *system;
    size_t count;
    void *kinsol;
    N_Vector angles, ones;
    double *before; /* [count] */
    /* of the solution under way */
    static_friction_given *solve;
    void *context;
    double *y;
    long *steps;
};

static size_t angle_count(const static_system *x)
{
    return (size_t)x->elements * (x->stages + 2) * x->rod->frictions;
}

/* ---- how tendons turn ---------------------------------------------------------------------- */

/* Of the polynomials of the points c alone. */
typedef struct tangent_rule {
    double slope[GAUSS_STAGES_MAX][GAUSS_STAGES_MAX];
    double at_end[2][GAUSS_STAGES_MAX]; /* at 0 and 1 */
} tangent_rule;

static tangent_rule tangent_rule_of(const gauss_rule *rule)
{
    tangent_rule made;
    gauss_slope(rule, made.slope);
    gauss_lagrange(rule, 0, made.at_end[0]);
    gauss_lagrange(rule, 1, made.at_end[1]);
    return made;
}

static void combine(int count, const double *weights, double (*vectors)[3], double sum[3])
{
    memset(sum, 0, 3 * sizeof *sum);
    for (int j = 0; j < count; j++) {
        for (int k = 0; k < 3; k++) {
            sum[k] += weights[j] * vectors[j][k];
        }
    }
}

/* t in the world at the points of an element. */
static void tangents_of(const static_system *x, int e, int tendon, const double *y,
                        double (*tangents)[3])
{
    for (int i = 0; i < x->stages; i++) {
        const double *at_y = y + edge(x, e) + (size_t)(i + 1) * (size_t)x->rows;
        static_point at = static_system_point(x, (size_t)e * x->stages + i);
        double strains[ACTUATION_ROWS], tangent[3], rotation[3][3];
        static_strains(&at, at_y, strains, strains + 3);
        solve_actuation_tangent(&at.actuation, tendon, strains, tangent);
        rotation_matrix(at_y + STATIC_Q, rotation);
        to_world(rotation, tangent, tangents[i]);
    }
}

/* Whether strains may jump at the edge where an element begins. */
static bool may_jump(const static_system *x, int e)
{
    const solve_quadrature *along = x->rod->quadrature;
    bool found = x->jump[e] >= 0;
    for (int i = 0; i < along->place_count && !found; i++) {
        found = fabs(along->places[i] - x->edges[e]) < SOLVE_SAME_PLACE;
    }
    return found;
}

static double angle_between(const double a[3], const double b[3])
{
    double across[3];
    vector_cross(a, b, across);
    return atan2(sqrt(vector_dot(across, across)), vector_dot(a, b));
}

/* Angles of one tendon, the k-th of those with friction. */
static void measure_tendon(const static_system *x, const tangent_rule *rule, int tendon, int k,
                           const double *y, double *angles)
{
    const solve_extent *extent = &x->rod->extents[tendon];
    int stride = x->rod->frictions;
    double angle = 0, last[3] = {0};
    for (int e = 0; e < x->elements; e++) {
        double tangents[GAUSS_STAGES_MAX][3], turning[GAUSS_STAGES_MAX] = {0}, first[3];
        double *to = angles + e * (x->stages + 2) * stride + k;
        double middle = (x->edges[e] + x->edges[e + 1]) / 2;
        if (middle > extent->start && middle < extent->end) {
            tangents_of(x, e, tendon, y, tangents);
            combine(x->stages, rule->at_end[0], tangents, first);
            bool goes_on = e > 0 && x->edges[e - 1] + x->edges[e] > 2 * extent->start;
            angle += goes_on && may_jump(x, e) ? angle_between(last, first) : 0;
            combine(x->stages, rule->at_end[1], tangents, last);
            for (int i = 0; i < x->stages; i++) {
                double slope[3];
                combine(x->stages, rule->slope[i], tangents, slope);
                turning[i] = sqrt(vector_dot(slope, slope));
            }
        }
        to[0] = angle;
        for (int i = 0; i <= x->stages; i++) { /* the last is the end of the element */
            const double *a = i < x->stages ? x->rule.matrix[i] : x->rule.weights;
            double sum = angle;
            for (int j = 0; j < x->stages; j++) {
                sum += a[j] * turning[j];
            }
            to[(i + 1) * stride] = sum;
        }
        angle = to[(x->stages + 1) * stride];
    }
}

/* angles of y under the tensions of now. */
static void measure(const static_system *x, const double *y, double *angles)
{
    tangent_rule rule = tangent_rule_of(&x->rule);
    for (int i = 0, k = 0; i < x->rod->actuators; i++) {
        if (x->rod->extents[i].rubs) {
            measure_tendon(x, &rule, i, k++, y, angles);
        }
    }
}

void static_friction_refine(static_system *coarse, static_system *fine)
{
    int count = fine->rod->frictions, points = fine->stages + 2;
    for (int e = 0; e < fine->elements && count > 0; e++) {
        int from = static_system_element(coarse, (fine->edges[e] + fine->edges[e + 1]) / 2);
        const double *old = coarse->angles + from * (coarse->stages + 2) * count;
        for (int i = 0; i < points; i++) {
            double c = i == 0 ? 0 : i == points - 1 ? 1 : fine->rule.nodes[i - 1];
            double s = fine->edges[e] + c * width(fine, e), weights[GAUSS_STAGES_MAX + 2];
            solve_gauss_lagrange(&coarse->rule, (s - coarse->edges[from]) / width(coarse, from),
                                 weights);
            for (int k = 0; k < count; k++) {
                double sum = 0;
                for (int j = 0; j < coarse->stages + 2; j++) {
                    sum += weights[j] * old[j * count + k];
                }
                fine->angles[(e * points + i) * count + k] = sum;
            }
        }
    }
}

/* ---- the fixed point ----------------------------------------------------------------------- */

/* The angles of the equilibrium under given ones. */
static int follow(N_Vector given, N_Vector found, void *context)
{
    static_friction *x = context;
    memcpy(x->system->angles, N_VGetArrayPointer(given), x->count * sizeof(double));
    if (!x->solve(x->context, x->y, x->steps)) {
        return -1;
    }
    measure(x->system, x->y, N_VGetArrayPointer(found));
    return 0;
}

void static_kinsol_say_nothing(int code, const char *module, const char *function, char *text,
                               void *context)
{
    (void)code, (void)module, (void)function, (void)text, (void)context;
}

static_friction *static_friction_create(static_system *system, SUNContext sundials)
{
    static_friction *x = calloc(1, sizeof *x);
    if (!x) {
        return NULL;
    }
    x->system = system;
    x->count = angle_count(system);
    x->before = malloc(x->count * sizeof *x->before);
    x->angles = N_VNew_Serial((sunindextype)x->count, sundials);
    x->ones = N_VNew_Serial((sunindextype)x->count, sundials);
    x->kinsol = KINCreate(sundials);
    if (!x->before || !x->angles || !x->ones || !x->kinsol || !solve_vectors_fit(x->count) ||
        KINSetErrHandlerFn(x->kinsol, static_kinsol_say_nothing, NULL) != 0 ||
        KINSetMAA(x->kinsol, DEPTH) != 0 || KINSetNumMaxIters(x->kinsol, STEPS_MAX) != 0 ||
        KINInit(x->kinsol, follow, x->angles) != 0 || KINSetUserData(x->kinsol, x) != 0 ||
        KINSetFuncNormTol(x->kinsol, SMALL) != 0) {
        static_friction_free(x);
        return NULL;
    }
    N_VConst(1, x->ones);
    return x;
}

void static_friction_free(static_friction *x)
{
    if (x) {
        KINFree(&x->kinsol);
        if (x->angles) {
            N_VDestroy(x->angles);
        }
        if (x->ones) {
            N_VDestroy(x->ones);
        }
        free(x->before);
        free(x);
    }
}

bool static_friction_solve(static_friction *x, static_friction_given *solve, void *context,
                           double *y, long *steps)
{
    size_t size = x->count * sizeof *x->before;
    double off = INFINITY;
    x->solve = solve;
    x->context = context;
    x->y = y;
    x->steps = steps;
    memcpy(x->before, x->system->angles, size);
    memcpy(N_VGetArrayPointer(x->angles), x->system->angles, size);
    int status = KINSol(x->kinsol, x->angles, KIN_FP, x->ones, x->ones);
    KINGetFuncNorm(x->kinsol, &off);
    bool found = status == KIN_SUCCESS || (status == KIN_MAXITER_REACHED && off < ROUNDING);
    if (found) {
        memcpy(x->system->angles, N_VGetArrayPointer(x->angles), size);
        found = solve(context, y, steps);
    }
    if (!found) {
        memcpy(x->system->angles, x->before, size);
    }
    return found;
}
