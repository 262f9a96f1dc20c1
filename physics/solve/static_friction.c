#include "physics/solve/static_friction.h"

#include "physics/local/mesh.h"
#include "physics/local/solve_vector.h"
#include "physics/numerics/quaternion.h"
#include "physics/solve/static_system.h"

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

static size_t angle_count(const static_system *system)
{
    return (size_t)system->mesh.count * (system->mesh.stages + 2) * system->rod->frictions;
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
static void tangents_of(const static_system *system, int e, int tendon, const double *y,
                        double (*tangents)[3])
{
    for (int i = 0; i < system->mesh.stages; i++) {
        const double *at_y =
            y + elements_edge(&system->mesh, e) + (size_t)(i + 1) * (size_t)system->mesh.rows;
        static_point at = static_system_point(system, (size_t)e * system->mesh.stages + i);
        double strains[ACTUATION_ROWS], tangent[3], rotation[3][3];
        static_strains(&at, at_y, strains, strains + 3);
        solve_actuation_tangent(&at.actuation, tendon, strains, tangent);
        rotation_matrix(at_y + STATIC_Q, rotation);
        to_world(rotation, tangent, tangents[i]);
    }
}

/* Whether strains may jump at the edge where an element begins. */
static bool may_jump(const static_system *system, int e)
{
    const solve_quadrature *along = system->rod->quadrature;
    bool found = system->jump[e] >= 0;
    for (int i = 0; i < along->place_count && !found; i++) {
        found = fabs(along->places[i] - system->mesh.edges[e]) < SOLVE_SAME_PLACE;
    }
    return found;
}

static double angle_between(const double a[3], const double b[3])
{
    double across[3];
    vector_cross(a, b, across);
    return atan2(sqrt(vector_dot(across, across)), vector_dot(a, b));
}

/* How strongly a tendon pulls where it begins. */
static double pull_of(const static_system *system, int tendon)
{
    return system->path.load * system->given.actuators[tendon].pull + system->tensions[tendon];
}

/* Angles turned become those of the law: where a tendon has a tension from before, it keeps that
 * as far as friction holds it against what is next to it, on the side of its beginning. */
static void remember(const static_system *system, int tendon, int k, double *angles)
{
    const int stride = system->rod->frictions,
              points = system->mesh.count * (system->mesh.stages + 2);
    const double friction = system->given.actuators[tendon].friction;
    const double pull = pull_of(system, tendon);
    double turned = 0, slid = 0;
    for (int i = 0; i < points; i++) {
        double *angle = &angles[i * stride + k];
        const double before = system->before[i * stride + k], step = *angle - turned;
        const double kept = (log(pull) - before) / friction;
        turned = *angle;
        slid = pull > 0 ? fmax(slid - step, fmin(slid + step, kept)) : turned;
        *angle = slid;
    }
}

/* Angles of one tendon, the k-th of those with friction. */
static void measure_tendon(const static_system *system, const tangent_rule *rule, int tendon, int k,
                           const double *y, double *angles)
{
    const solve_extent *extent = &system->rod->extents[tendon];
    int stride = system->rod->frictions;
    double angle = 0, last[3] = {0};
    for (int e = 0; e < system->mesh.count; e++) {
        double tangents[GAUSS_STAGES_MAX][3], turning[GAUSS_STAGES_MAX] = {0}, first[3];
        double *to = angles + e * (system->mesh.stages + 2) * stride + k;
        double middle = (system->mesh.edges[e] + system->mesh.edges[e + 1]) / 2;
        if (middle > extent->start && middle < extent->end) {
            tangents_of(system, e, tendon, y, tangents);
            combine(system->mesh.stages, rule->at_end[0], tangents, first);
            bool goes_on =
                e > 0 && system->mesh.edges[e - 1] + system->mesh.edges[e] > 2 * extent->start;
            angle += goes_on && may_jump(system, e) ? angle_between(last, first) : 0;
            combine(system->mesh.stages, rule->at_end[1], tangents, last);
            for (int i = 0; i < system->mesh.stages; i++) {
                double slope[3];
                combine(system->mesh.stages, rule->slope[i], tangents, slope);
                turning[i] = sqrt(vector_dot(slope, slope));
            }
        }
        to[0] = angle;
        for (int i = 0; i <= system->mesh.stages; i++) { /* the last is the end of the element */
            const double *a =
                i < system->mesh.stages ? system->mesh.rule.matrix[i] : system->mesh.rule.weights;
            double sum = angle;
            for (int j = 0; j < system->mesh.stages; j++) {
                sum += a[j] * turning[j];
            }
            to[(i + 1) * stride] = sum;
        }
        angle = to[(system->mesh.stages + 1) * stride];
    }
}

/* angles of y under the tensions of now. */
static void measure(const static_system *system, const double *y, double *angles)
{
    tangent_rule rule = tangent_rule_of(&system->mesh.rule);
    for (int i = 0, k = 0; i < system->rod->actuators; i++) {
        if (system->rod->extents[i].rubs) {
            measure_tendon(system, &rule, i, k, y, angles);
            if (system->before) {
                remember(system, i, k, angles);
            }
            k++;
        }
    }
}

void static_friction_refine(static_system *coarse, static_system *fine)
{
    const size_t count = (size_t)fine->rod->frictions, points = (size_t)fine->mesh.stages + 2;
    for (int e = 0; e < fine->mesh.count && count > 0; e++) {
        const double *edges = fine->mesh.edges + e;
        const int from = solve_elements_at(&coarse->mesh, (edges[0] + edges[1]) / 2);
        const double *old = coarse->angles + (size_t)from * points * count;
        for (size_t i = 0; i < points; i++) {
            const double c = i == 0 ? 0 : i == points - 1 ? 1 : fine->mesh.rule.nodes[i - 1];
            const double s = edges[0] + c * elements_width(&fine->mesh, e);
            solve_elements_interpolate(&coarse->mesh, from, s, count, count, old,
                                       fine->angles + ((size_t)e * points + i) * count);
        }
    }
}

/* The logarithm of a tendon's tension at s, by a cubic through the points around it in an element.
 */
static double tension_at(const static_system *system, int e, double s, int tendon, int k)
{
    enum { AROUND = 4 };
    const int points = system->mesh.stages + 2, stride = system->rod->frictions;
    const int most = points < AROUND ? points : AROUND;
    const double *angles = system->angles + (size_t)(e * points * stride + k);
    const double x = (s - system->mesh.edges[e]) / elements_width(&system->mesh, e);
    double at[GAUSS_STAGES_MAX + 2] = {0}, sum = 0;
    int first = 0;
    memcpy(at + 1, system->mesh.rule.nodes, (size_t)system->mesh.stages * sizeof *at);
    at[points - 1] = 1;
    while (first + most < points && at[first + most / 2] < x) {
        first++;
    }
    for (int i = first; i < first + most; i++) {
        double weight = 1;
        for (int j = first; j < first + most; j++) {
            weight *= j == i ? 1 : (x - at[j]) / (at[i] - at[j]);
        }
        sum += weight * angles[i * stride];
    }
    return log(pull_of(system, tendon)) - system->given.actuators[tendon].friction * sum;
}

double static_friction_tension(const static_system *system, int tendon, double s)
{
    const solve_extent *extents = system->rod->extents;
    int k = 0;
    for (int i = 0; i < tendon; i++) {
        k += extents[i].rubs;
    }
    return !extents[tendon].rubs
               ? pull_of(system, tendon)
               : exp(tension_at(system, solve_elements_at(&system->mesh, s), s, tendon, k));
}

ad_status static_friction_follow(static_system *system, const static_system *earlier,
                                 ad_error *error)
{
    const int points = system->mesh.stages + 2, stride = system->rod->frictions;
    if (earlier->rod->frictions != stride || earlier->rod->actuators != system->rod->actuators) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "what was before has %d tendons with friction, and this scene %d; allowed: "
                       "an equilibrium of the same robot",
                       earlier->rod->frictions, stride);
    }
    const double unit = log(earlier->rod->scales.force / system->rod->scales.force);
    system->earlier = earlier;
    system->before = malloc((angle_count(system) + 1) * sizeof *system->before);
    if (!system->before) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the friction of tendons");
    }
    for (int i = 0; i < system->mesh.count * points; i++) {
        const int e = i / points, c = i % points;
        const double *edges = system->mesh.edges + e, middle = (edges[0] + edges[1]) / 2;
        const double part = c == 0 ? 0 : c == points - 1 ? 1 : system->mesh.rule.nodes[c - 1];
        const double s = edges[0] + part * (edges[1] - edges[0]);
        const int from = solve_elements_at(&earlier->mesh, s + 1e-9 * (middle - s));
        for (int tendon = 0, k = 0; tendon < system->rod->actuators; tendon++) {
            if (system->rod->extents[tendon].rubs) {
                system->before[i * stride + k] = unit + tension_at(earlier, from, s, tendon, k);
                k++;
            }
        }
    }
    return AD_OK;
}

/* ---- the fixed point ----------------------------------------------------------------------- */

/* The angles of the equilibrium under given ones. */
static int follow(N_Vector given, N_Vector found, void *context)
{
    static_friction *friction = context;
    memcpy(friction->system->angles, N_VGetArrayPointer(given), friction->count * sizeof(double));
    if (!friction->solve(friction->context, friction->y, friction->steps)) {
        return -1;
    }
    measure(friction->system, friction->y, N_VGetArrayPointer(found));
    return 0;
}

void static_kinsol_say_nothing(int code, const char *module, const char *function, char *text,
                               void *context)
{
    (void)code, (void)module, (void)function, (void)text, (void)context;
}

static_friction *static_friction_create(static_system *system, SUNContext sundials)
{
    static_friction *friction = calloc(1, sizeof *friction);
    if (!friction) {
        return NULL;
    }
    friction->system = system;
    friction->count = angle_count(system);
    friction->before = malloc(friction->count * sizeof *friction->before);
    friction->angles = N_VNew_Serial((sunindextype)friction->count, sundials);
    friction->ones = N_VNew_Serial((sunindextype)friction->count, sundials);
    friction->kinsol = KINCreate(sundials);
    if (!friction->before || !friction->angles || !friction->ones || !friction->kinsol ||
        !solve_vectors_fit(friction->count) ||
        KINSetErrHandlerFn(friction->kinsol, static_kinsol_say_nothing, NULL) != 0 ||
        KINSetMAA(friction->kinsol, DEPTH) != 0 ||
        KINSetNumMaxIters(friction->kinsol, STEPS_MAX) != 0 ||
        KINInit(friction->kinsol, follow, friction->angles) != 0 ||
        KINSetUserData(friction->kinsol, friction) != 0 ||
        KINSetFuncNormTol(friction->kinsol, SMALL) != 0) {
        static_friction_free(friction);
        return NULL;
    }
    N_VConst(1, friction->ones);
    return friction;
}

void static_friction_free(static_friction *friction)
{
    if (friction) {
        KINFree(&friction->kinsol);
        if (friction->angles) {
            N_VDestroy(friction->angles);
        }
        if (friction->ones) {
            N_VDestroy(friction->ones);
        }
        free(friction->before);
        free(friction);
    }
}

bool static_friction_solve(static_friction *friction, static_friction_given *solve, void *context,
                           double *y, long *steps)
{
    size_t size = friction->count * sizeof *friction->before;
    double off = INFINITY;
    friction->solve = solve;
    friction->context = context;
    friction->y = y;
    friction->steps = steps;
    memcpy(friction->before, friction->system->angles, size);
    memcpy(N_VGetArrayPointer(friction->angles), friction->system->angles, size);
    int status = KINSol(friction->kinsol, friction->angles, KIN_FP, friction->ones, friction->ones);
    KINGetFuncNorm(friction->kinsol, &off);
    bool found = status == KIN_SUCCESS || (status == KIN_MAXITER_REACHED && off < ROUNDING);
    if (found) {
        memcpy(friction->system->angles, N_VGetArrayPointer(friction->angles), size);
        found = solve(context, y, steps);
    }
    if (!found) {
        memcpy(friction->system->angles, friction->before, size);
    }
    return found;
}
