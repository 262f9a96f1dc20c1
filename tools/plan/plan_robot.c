#include "tools/plan/plan_robot.h"

#include "physics/numerics/quaternion.h"
#include "physics/numerics/sampling.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- variables ------------------------------------------------------------------------------- */

static ad_status refuse(char key[PLAN_KEY], const char *what, ad_error *error, const char *why,
                        const char *name)
{
    snprintf(key, PLAN_KEY, "%s", what);
    return ad_fail(error, AD_BAD_INPUT, "%.80s%s%s", name, *name ? " " : "", why);
}

static void add(plan_robot *robot, const char *name, int parameter, double low, double high)
{
    const int k = robot->count++;
    snprintf(robot->names[k], sizeof robot->names[k], "%.60s", name);
    robot->parameter[k] = parameter;
    robot->low[k] = low;
    robot->high[k] = high;
}

/* "name=value" of what does not move. */
static ad_status fix(plan_robot *robot, const plan_settings *settings, const scene *of, char *key,
                     ad_error *error)
{
    for (int i = 0; i < of->parameter_count; i++) {
        robot->fixed[i] = NAN;
    }
    for (int k = 0; k < settings->fixed_count; k++) {
        const char *const text = settings->fixed[k] + strspn(settings->fixed[k], " ");
        char name[64];
        double value;
        snprintf(name, sizeof name, "%.*s", (int)strcspn(text, "= "), text);
        const int i = scene_parameter_find(of, name);
        if (i < 0 || scene_member_read(1, &of->parameters[i], true, text, &value, error) != AD_OK) {
            return refuse(key, "plan.fixed", error, "is not NAME=VALUE of a parameter with a range",
                          settings->fixed[k]);
        }
        if (!scene_parameter_holds(&of->parameters[i], value)) {
            return refuse(key, "plan.fixed", error, "is outside the parameter's range",
                          settings->fixed[k]);
        }
        robot->fixed[i] = value;
    }
    for (int k = 0; k < settings->unknown_count; k++) {
        const int i = scene_parameter_find(of, settings->unknown[k]);
        if (i < 0 || !isnan(robot->fixed[i])) {
            return refuse(key, "plan.unknown", error,
                          i < 0 ? "is no parameter with a range" : "is given twice, or fixed",
                          settings->unknown[k]);
        }
        robot->unknown[robot->unknowns] = i;
        robot->half[robot->unknowns++] = (of->parameters[i].high - of->parameters[i].low) / 2;
        robot->fixed[i] = (of->parameters[i].high + of->parameters[i].low) / 2;
    }
    return AD_OK;
}

static ad_status choose(plan_robot *robot, const plan_settings *settings, const scene *of,
                        char *key, ad_error *error)
{
    bool moves[SCENE_PARAMETERS_MAX] = {false};
    for (int k = 0; k < settings->actuator_count; k++) {
        const int i = scene_parameter_find(of, settings->actuators[k]);
        if (i < 0 || moves[i] || !isnan(robot->fixed[i])) {
            return refuse(key, "plan.actuators", error,
                          i < 0      ? "is no parameter with a range"
                          : moves[i] ? "is given twice"
                                     : "is fixed as well",
                          settings->actuators[k]);
        }
        moves[i] = true;
        add(robot, of->parameters[i].name, i, of->parameters[i].low, of->parameters[i].high);
    }
    for (int i = 0; i < of->parameter_count; i++) {
        if (settings->actuator_count == 0 && isnan(robot->fixed[i])) {
            if (robot->count == PLAN_ACTUATORS_MAX) {
                return refuse(key, "plan.actuators", error,
                              "needs to be given: the scene has more than 16 parameters", "");
            }
            add(robot, of->parameters[i].name, i, of->parameters[i].low, of->parameters[i].high);
        } else if (isnan(robot->fixed[i]) && !moves[i]) {
            return refuse(key, "plan.fixed", error,
                          "is neither an actuator nor fixed; give its value here",
                          of->parameters[i].name);
        }
    }
    return AD_OK;
}

static ad_status add_base(plan_robot *robot, const plan_settings *settings, char *key,
                          ad_error *error)
{
    const struct {
        const char *key, *name;
        const double *range;
        int *which;
    } moves[2] = {{"plan.slide", "slide", settings->slide, &robot->slide},
                  {"plan.turn", "turn", settings->turn, &robot->turn}};
    for (int k = 0; k < 2; k++) {
        const double *const range = moves[k].range;
        *moves[k].which = -1;
        if (!isnan(range[0])) {
            if (!(range[0] < range[1])) {
                return refuse(key, moves[k].key, error, "needs two ascending numbers", "");
            }
            *moves[k].which = robot->count;
            add(robot, moves[k].name, -1, range[0], range[1]);
        }
    }
    return robot->count ? AD_OK
                        : refuse(key, "plan.actuators", error,
                                 "has nothing that moves: give parameters a range", "");
}

static ad_status find_base(plan_robot *robot, const scene *of, char *key, ad_error *error)
{
    double rotation[4], matrix[3][3];
    bool known = true;
    for (int i = 0; i < 4; i++) {
        known &= quantity_is_number(of->start.rotation[i], &rotation[i]);
        known &= i == 3 || quantity_is_number(of->start.position[i], &robot->base[i]);
    }
    if (!known && (robot->slide >= 0 || robot->turn >= 0)) {
        return refuse(key, robot->slide >= 0 ? "plan.slide" : "plan.turn", error,
                      "is not for a base that is given by formulas", "");
    }
    if (known) {
        quaternion_normalize(rotation);
        rotation_matrix(rotation, matrix);
        for (int i = 0; i < 3; i++) {
            robot->axis[i] = matrix[i][2];
        }
    }
    return AD_OK;
}

ad_status plan_robot_create(const plan_settings *settings, const scene *of, plan_robot *result,
                            char key[PLAN_KEY], ad_error *error)
{
    memset(result, 0, sizeof *result);
    result->parameters = of->parameter_count;
    ad_status status = fix(result, settings, of, key, error);
    status = status == AD_OK ? choose(result, settings, of, key, error) : status;
    status = status == AD_OK ? add_base(result, settings, key, error) : status;
    return status == AD_OK ? find_base(result, of, key, error) : status;
}

void plan_robot_parameters(const plan_robot *of, const double *configuration, double *parameters)
{
    memcpy(parameters, of->fixed, (size_t)of->parameters * sizeof *parameters);
    for (int k = 0; k < of->count; k++) {
        if (of->parameter[k] >= 0) {
            parameters[of->parameter[k]] = configuration[k];
        }
    }
}

static void turn_vector(const plan_robot *of, double angle, double v[3])
{
    double across[3];
    const double along = vector_dot(of->axis, v);
    vector_cross(of->axis, v, across);
    for (int i = 0; i < 3; i++) {
        v[i] = cos(angle) * v[i] + sin(angle) * across[i] + (1 - cos(angle)) * along * of->axis[i];
    }
}

/* In the scene, where the base has been moved. */
static void move(const plan_robot *of, const double *configuration, double p[3])
{
    if (of->turn >= 0) {
        for (int i = 0; i < 3; i++) {
            p[i] -= of->base[i];
        }
        turn_vector(of, configuration[of->turn], p);
        for (int i = 0; i < 3; i++) {
            p[i] += of->base[i];
        }
    }
    for (int i = 0; i < 3 && of->slide >= 0; i++) {
        p[i] += configuration[of->slide] * of->axis[i];
    }
}

void plan_robot_place(const plan_robot *of, const double *configuration, size_t points,
                      size_t columns, const double *values, double *r)
{
    for (size_t k = 0; k < points; k++) {
        memcpy(&r[3 * k], &values[k * columns], 3 * sizeof *r);
        move(of, configuration, &r[3 * k]);
    }
}

/* ---- exact shapes ---------------------------------------------------------------------------- */

ad_status plan_exact_create(const plan_robot *robot, const scene *of, size_t points, double from,
                            int threads, plan_exact **result, ad_error *error)
{
    *result = NULL;
    plan_exact *const e = calloc(1, sizeof *e);
    double *s = e ? AD_TAKE(e, s, points + 1) : NULL;
    if (!s) {
        free(e);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for shapes");
    }
    e->robot = robot;
    e->of = of;
    e->length = scene_length(of);
    e->points = sampling_along(e->length, points, 1, &from, s);
    const solve_members_settings settings = {
        .tolerance = PLAN_TOLERANCE, .threads = threads, .points = e->points, .s = s};
    ad_status status = solve_members_create(of, &settings, &e->solver, error);
    if (status == AD_OK && (robot->slide >= 0 || robot->turn >= 0) &&
        !solve_members_is_unloaded(e->solver)) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "plan.%s: is for scenes where only actuators act, as shapes would change",
                         robot->slide >= 0 ? "slide" : "turn");
    }
    if (status == AD_OK) {
        const size_t rows = PLAN_BATCH * e->points, count = (size_t)robot->count;
        const size_t parameters = (size_t)robot->parameters + 1;
        AD_TAKE(e, r, 3 * rows);
        AD_TAKE(e, speed, rows);
        AD_TAKE(e, moves, 3 * rows * count);
        AD_TAKE(e, spread, rows);
        AD_TAKE(e, first, 3 * rows);
        AD_TAKE(e, error, PLAN_BATCH);
        AD_TAKE(e, tangent, 3 * PLAN_BATCH);
        AD_TAKE(e, turns, PLAN_BATCH * count * 3);
        AD_TAKE(e, parameters, PLAN_BATCH * parameters);
        AD_TAKE(e, values, rows * SOLVE_MEMBERS_COLUMNS);
        AD_TAKE(e, curvature, PLAN_BATCH * solve_members_numbers(e->solver));
        AD_TAKE(e, jacobian, rows * SOLVE_MEMBERS_COLUMNS * parameters);
        AD_TAKE(e, solved, PLAN_BATCH);
        status = ad_memory_status(&e->memory, error, "out of memory for shapes");
    }
    if (status != AD_OK) {
        plan_exact_free(e);
        return status;
    }
    *result = e;
    return AD_OK;
}

void plan_exact_free(plan_exact *of)
{
    if (of) {
        solve_members_free(of->solver);
        ad_memory_free(&of->memory);
        free(of);
    }
}

/* How an arm of the scene, from the base to a point or a unit vector, goes with each variable;
 * jacobian [3][parameters] of the point or the vector before the base moves. */
static void find_moves(const plan_exact *e, const double *configuration, bool is_point,
                       const double arm[3], const double *jacobian, double *moves)
{
    const plan_robot *const robot = e->robot;
    for (int k = 0; k < robot->count; k++) {
        double v[3];
        for (int i = 0; i < 3; i++) {
            v[i] = k == robot->slide  ? is_point * robot->axis[i]
                   : k == robot->turn ? 0
                                      : jacobian[i * robot->parameters + robot->parameter[k]];
        }
        if (k == robot->turn) {
            vector_cross(robot->axis, arm, v);
        }
        if (robot->turn >= 0 && k != robot->slide) {
            turn_vector(robot, configuration[robot->turn], v);
        }
        for (int i = 0; i < 3; i++) {
            moves[i * robot->count + k] = v[i];
        }
    }
}

/* The direction of the rod at its tip: R v over its length, whose change is R of phi x v + dv, phi
 * twice the vector of q* dq. */
static void find_tangent(plan_exact *e, size_t member, const double *configuration)
{
    enum { Q = 3, V = 7 };
    const size_t row = member * e->points + e->points - 1, columns = SOLVE_MEMBERS_COLUMNS;
    const size_t parameters = (size_t)e->robot->parameters, count = (size_t)e->robot->count;
    const double *const values = &e->values[row * columns], *const v = &values[V];
    double matrix[3][3], t[3], by[3 * SCENE_PARAMETERS_MAX];
    const double length = sqrt(vector_dot(v, v));
    rotation_matrix(&values[Q], matrix);
    to_world(matrix, v, t);
    for (size_t i = 0; i < 3; i++) {
        t[i] /= length;
    }
    for (size_t k = 0; k < parameters; k++) {
        double dq[4], dv[3], phi[4], local[3], change[3];
        for (size_t i = 0; i < 4; i++) {
            dq[i] = e->jacobian[(row * columns + Q + i) * parameters + k];
        }
        for (size_t i = 0; i < 3; i++) {
            dv[i] = e->jacobian[(row * columns + V + i) * parameters + k];
        }
        quaternion_quotient(&values[Q], dq, phi);
        vector_cross(&phi[1], v, local);
        for (size_t i = 0; i < 3; i++) {
            local[i] = 2 * local[i] + dv[i];
        }
        to_world(matrix, local, change);
        const double along = vector_dot(change, t);
        for (size_t i = 0; i < 3; i++) {
            by[i * parameters + k] = (change[i] - along * t[i]) / length;
        }
    }
    find_moves(e, configuration, false, t, by, &e->turns[3 * member * count]);
    if (e->robot->turn >= 0) {
        turn_vector(e->robot, configuration[e->robot->turn], t);
    }
    memcpy(&e->tangent[3 * member], t, sizeof t);
}

/* m, of a member that was solved; infinite where the estimate is no number. */
static double error_of(const plan_exact *of, size_t member)
{
    const double estimate = of->solved[member].estimate;
    return estimate >= 0 ? fmax(PLAN_TOLERANCE, estimate) * of->length : INFINITY;
}

/* Adds what one choice of the unknown parameters moves, part [unknowns] -1, 0 or 1 of each half
 * range; off [members][points] what that differs from the derivative. */
static ad_status try_unknown(plan_exact *of, size_t members, const int *part, double *off,
                             ad_error *error)
{
    const plan_robot *const robot = of->robot;
    const size_t parameters = (size_t)robot->parameters, columns = SOLVE_MEMBERS_COLUMNS;
    for (size_t m = 0; m < members; m++) {
        for (int k = 0; k < robot->unknowns; k++) {
            const int i = robot->unknown[k];
            of->parameters[m * parameters + (size_t)i] = robot->fixed[i] + part[k] * robot->half[k];
        }
    }
    ad_status status =
        solve_members_solve(of->solver, members, of->parameters, of->values, of->solved, error);
    for (size_t row = 0; row < members * of->points && status == AD_OK; row++) {
        double moved = 0, linear = 0, differs = 0;
        for (size_t i = 0; i < 3; i++) {
            const double *const by = &of->jacobian[(row * columns + i) * parameters];
            const double change = of->values[row * columns + i] - of->first[3 * row + i];
            double expected = 0;
            for (int k = 0; k < robot->unknowns; k++) {
                expected += by[robot->unknown[k]] * part[k] * robot->half[k];
            }
            moved += change * change;
            linear += expected * expected;
            differs += (change - expected) * (change - expected);
        }
        of->spread[row] = fmax(of->spread[row], sqrt(fmax(moved, linear)));
        off[row] = fmax(off[row], sqrt(differs));
    }
    for (size_t m = 0; m < members && status == AD_OK; m++) {
        of->error[m] = fmax(of->error[m], error_of(of, m));
    }
    return status;
}

static ad_status find_spread(plan_exact *of, size_t members, ad_error *error)
{
    const size_t rows = members * of->points;
    double *const off = calloc(rows, sizeof *off);
    ad_status status =
        off ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for unknown parameters");
    int choices = 1;
    for (int k = 0; k < of->robot->unknowns; k++) {
        choices *= 3;
    }
    memset(of->spread, 0, rows * sizeof *of->spread);
    for (size_t row = 0; row < rows; row++) {
        memcpy(&of->first[3 * row], &of->values[row * SOLVE_MEMBERS_COLUMNS],
               3 * sizeof *of->first);
    }
    for (int choice = 0; choice < choices && status == AD_OK; choice++) {
        int part[PLAN_UNKNOWN_MAX];
        for (int k = 0, rest = choice; k < of->robot->unknowns; k++, rest /= 3) {
            part[k] = rest % 3 - 1;
        }
        if (choice != choices / 2) { /* all in the middle */
            status = try_unknown(of, members, part, off, error);
        }
    }
    for (size_t row = 0; row < rows && status == AD_OK; row++) {
        of->spread[row] += off[row];
    }
    free(off);
    return status;
}

/* |dr/ds| from strains, which are by metres of the rod as it is written (scene_map). */
static ad_status find_speeds(plan_exact *of, size_t members, ad_error *error)
{
    const size_t parameters = (size_t)of->robot->parameters;
    scene *const member = malloc(sizeof *member);
    if (!member) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a member");
    }
    for (size_t row = 0; row < members * of->points; row++) {
        const double *const v = &of->values[row * SOLVE_MEMBERS_COLUMNS + 7];
        const size_t point = row % of->points;
        if (point == 0 && of->of->rod.growth.is_given) {
            scene_member(of->of, &of->parameters[row / of->points * parameters], member);
        }
        of->speed[row] = sqrt(vector_dot(v, v));
        if (of->of->rod.growth.is_given) {
            of->speed[row] *= scene_growth_at(member, NULL, of->s[point], 0);
        }
    }
    free(member);
    return AD_OK;
}

ad_status plan_exact_shapes(plan_exact *of, size_t members, const double *configurations,
                            ad_error *error)
{
    const plan_robot *const robot = of->robot;
    const size_t count = (size_t)robot->count, parameters = (size_t)robot->parameters;
    const size_t columns = SOLVE_MEMBERS_COLUMNS;
    for (size_t m = 0; m < members; m++) {
        plan_robot_parameters(robot, &configurations[m * count], &of->parameters[m * parameters]);
    }
    ad_status status = solve_members_curvature(of->solver, members, of->parameters, of->values,
                                               of->curvature, of->solved, error);
    if (status == AD_OK && parameters > 0) {
        status = solve_members_jacobian(of->solver, members, of->parameters, of->curvature, 0,
                                        of->jacobian, error);
    }
    for (size_t m = 0; m < members && status == AD_OK; m++) {
        const double *const values = &of->values[m * of->points * columns];
        const double *const q = &configurations[m * count];
        of->error[m] = error_of(of, m);
        plan_robot_place(robot, q, of->points, columns, values, &of->r[3 * m * of->points]);
        for (size_t k = 0; k < of->points; k++) {
            const size_t row = m * of->points + k;
            double arm[3];
            for (size_t i = 0; i < 3; i++) {
                arm[i] = values[k * columns + i] - robot->base[i];
            }
            find_moves(of, q, true, arm, &of->jacobian[row * columns * parameters],
                       &of->moves[3 * row * count]);
        }
        find_tangent(of, m, q);
    }
    status = status == AD_OK ? find_speeds(of, members, error) : status;
    return status == AD_OK && robot->unknowns > 0 ? find_spread(of, members, error) : status;
}
