#include "tools/control/equilibria.h"

#include "physics/numerics/vector_size.h"
#include "tools/control/qp.h"
#include "tools/control/small_matrix.h"
#include "tools/control/task.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { POINTS_ON_PATH = 2 * CONTROL_HEIGHTS + 1, STEPS = 12 };

/* A path is judged at so many places around it or along a file, and of each way between set
 * points. */
enum { JUDGED_PLACES = 2 * POINTS_ON_PATH, JUDGED_OF_WAY = 6 };

struct equilibria {
    scene of;
    reduced_rod *rod;
    int inputs;                    /* that are set */
    int which[CONTROL_INPUTS_MAX]; /* of the scene's parameters */
    double low[CONTROL_INPUTS_MAX], high[CONTROL_INPUTS_MAX];
    double middle[SCENE_PARAMETERS_MAX];
    double *state; /* [states] of the last equilibrium */
    double *trial; /* [states] */
    void *program; /* of a qp of `inputs` variables */
    qp *quadratic;
};

ad_status equilibria_create(const scene *of, const surrogate_settings *model,
                            const control_settings *control, equilibria **result, ad_error *error)
{
    equilibria *x = calloc(1, sizeof *x);
    *result = NULL;
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a robot at rest");
    }
    x->of = *of;
    scene_middle_values(of, x->middle);
    for (int k = 0; k < of->parameter_count; k++) {
        if (control_role_of(control, model, of->parameters[k].name) == CONTROL_INPUT) {
            x->low[x->inputs] = control->low[x->inputs];
            x->high[x->inputs] = control->high[x->inputs];
            x->middle[k] = (x->low[x->inputs] + x->high[x->inputs]) / 2;
            x->which[x->inputs++] = k;
        }
    }
    const qp_settings program = {.variables = x->inputs};
    const reduced_settings settings = {
        .modes = {model->modes[0], model->modes[1], model->modes[2], model->modes[3]},
        .count = 1,
        .s = &control->track_at};
    ad_status status = reduced_create(of, &settings, &x->rod, error);
    if (status == AD_OK) {
        const size_t n = (size_t)reduced_all_states(x->rod);
        x->state = calloc(2 * n, sizeof *x->state);
        x->program = malloc(qp_size(&program));
        if (!x->state || !x->program) {
            status = ad_fail(error, AD_NO_MEMORY, "out of memory for a robot at rest");
        } else {
            x->trial = x->state + n;
            x->quadratic = qp_init(x->program, &program);
            reduced_begin(x->rod, x->middle, x->state);
            status = reduced_initial(x->rod, x->middle, x->state, error);
        }
    }
    if (status != AD_OK) {
        equilibria_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}

void equilibria_free(equilibria *equilibria)
{
    if (equilibria) {
        reduced_free(equilibria->rod);
        free(equilibria->state);
        free(equilibria->program);
        free(equilibria);
    }
}

void equilibria_middle(const equilibria *equilibria, double *inputs)
{
    memcpy(inputs, equilibria->middle, (size_t)reduced_inputs(equilibria->rod) * sizeof *inputs);
}

ad_status equilibria_settle(equilibria *equilibria, const double *given, double *state,
                            ad_error *error)
{
    enum { TRIES = 3, MOTION = 50 };
    const size_t bytes = (size_t)reduced_all_states(equilibria->rod) * sizeof *state;
    double inputs[SCENE_PARAMETERS_MAX];
    memcpy(inputs, given, (size_t)reduced_inputs(equilibria->rod) * sizeof *inputs);
    reduced_begin(equilibria->rod, inputs, equilibria->state);
    memcpy(equilibria->trial, equilibria->state, bytes);
    ad_status status = reduced_settle(equilibria->rod, 0, inputs, equilibria->trial, error);
    for (int try = 0; try < TRIES && status == AD_NOT_FINITE; try++) {
        memcpy(equilibria->trial, equilibria->state,
               bytes); /* by its motion, which is damped by the method, too */
        status = AD_OK;
        for (int i = 0; i < MOTION && status == AD_OK; i++) {
            status = reduced_step(equilibria->rod, 0, 0.01 * pow(10, try), equilibria->trial,
                                  inputs, equilibria->trial, NULL, NULL, error);
        }
        status = status == AD_OK
                     ? reduced_settle(equilibria->rod, 0, inputs, equilibria->trial, error)
                     : status;
    }
    if (status == AD_OK) {
        memcpy(equilibria->state, equilibria->trial, bytes);
        if (state) {
            memcpy(state, equilibria->trial, bytes);
        }
    }
    return status;
}

ad_status equilibria_derivatives(equilibria *equilibria, const double *inputs, const double *state,
                                 int count, const int *which, double *by, ad_error *error)
{
    const int n = reduced_all_states(equilibria->rod);
    double moved[SCENE_PARAMETERS_MAX];
    ad_status status = AD_OK;
    for (int k = 0; k < count && status == AD_OK; k++) {
        const scene_parameter *p = &equilibria->of.parameters[which[k]];
        const double up = 1e-4 * (p->high - p->low);
        const double h = inputs[which[k]] + up <= p->high ? up : -up;
        memcpy(moved, inputs, (size_t)reduced_inputs(equilibria->rod) * sizeof *moved);
        moved[which[k]] += h;
        memcpy(equilibria->state, state, (size_t)n * sizeof *state);
        status = equilibria_settle(equilibria, moved, NULL, error);
        for (int i = 0; i < n && status == AD_OK; i++) {
            by[i * count + k] = (equilibria->state[i] - state[i]) / h;
        }
    }
    memcpy(equilibria->state, state, (size_t)n * sizeof *state);
    return status;
}

/* ---- where a place can be ------------------------------------------------------------------ */

static ad_status see(equilibria *equilibria, const double *inputs, reduced_place *place,
                     ad_error *error)
{
    ad_status status = equilibria_settle(equilibria, inputs, NULL, error);
    return status == AD_OK
               ? reduced_output(equilibria->rod, 0, equilibria->state, inputs, place, NULL, error)
               : status;
}

/* How far the place is from the target in the directions that count [rows][3], and derivatives
 * [rows][inputs] by inputs in parts of their limits. */
static ad_status linearise(equilibria *equilibria, const double *inputs, const double target[3],
                           int rows, double (*directions)[3], double off[3], double *by,
                           ad_error *error)
{
    double moved[SCENE_PARAMETERS_MAX];
    reduced_place at, near;
    ad_status status = see(equilibria, inputs, &at, error);
    for (int r = 0; r < rows && status == AD_OK; r++) {
        off[r] = 0;
        for (int k = 0; k < 3; k++) {
            off[r] += directions[r][k] * (target[k] - at.position[k]);
        }
    }
    for (int i = 0; i < equilibria->inputs && status == AD_OK && by; i++) {
        const double span = equilibria->high[i] - equilibria->low[i];
        const double h =
            inputs[equilibria->which[i]] < equilibria->low[i] + span / 2 ? 1e-3 : -1e-3;
        memcpy(moved, inputs, sizeof moved);
        moved[equilibria->which[i]] += h * span;
        status = see(equilibria, moved, &near, error);
        for (int r = 0; r < rows && status == AD_OK; r++) {
            by[r * equilibria->inputs + i] = 0;
            for (int k = 0; k < 3; k++) {
                by[r * equilibria->inputs + i] +=
                    directions[r][k] * (near.position[k] - at.position[k]) / h;
            }
        }
    }
    return status;
}

/* Inputs [parameter_count], from those that are given, with the place nearest to the target in the
 * directions that count; where several will do, those near the middle. off [rows]: what is left. */
static ad_status reach(equilibria *equilibria, const double target[3], int rows,
                       double (*directions)[3], double *inputs, double off[3], ad_error *error)
{
    const int m = equilibria->inputs, stride = small_matrix_stride(m);
    double by[3 * CONTROL_INPUTS_MAX];
    double H[CONTROL_INPUTS_MAX * (CONTROL_INPUTS_MAX + SMALL_MATRIX_LANES)] = {0};
    double g[CONTROL_INPUTS_MAX], low[CONTROL_INPUTS_MAX], high[CONTROL_INPUTS_MAX];
    double step[CONTROL_INPUTS_MAX];
    const double unit = 1e-2 * scene_length(&equilibria->of), effort = 1e-4;
    ad_status status = AD_OK;
    for (int i = 0; i < STEPS && status == AD_OK; i++) {
        double most = 0;
        status = linearise(equilibria, inputs, target, rows, directions, off, by, error);
        for (int a = 0; a < m && status == AD_OK; a++) {
            const double span = equilibria->high[a] - equilibria->low[a];
            const double at = (inputs[equilibria->which[a]] - equilibria->low[a]) / span;
            g[a] = effort * (at - 0.5);
            low[a] = -at;
            high[a] = 1 - at;
            for (int r = 0; r < rows; r++) {
                g[a] -= by[r * m + a] * off[r] / (unit * unit);
            }
            for (int b = 0; b < m; b++) {
                H[a * stride + b] = a == b ? effort : 0;
                for (int r = 0; r < rows; r++) {
                    H[a * stride + b] += by[r * m + a] * by[r * m + b] / (unit * unit);
                }
            }
        }
        const qp_bounds bounds = {.lower = low, .upper = high};
        if (status != AD_OK || qp_factor(equilibria->quadratic, H) != QP_SOLVED ||
            qp_solve(equilibria->quadratic, g, &bounds, NULL, step) == QP_BAD) {
            break;
        }
        for (int a = 0; a < m; a++) {
            most = fmax(most, fabs(step[a]));
        }
        for (int a = 0; a < m; a++) {
            inputs[equilibria->which[a]] +=
                fmin(1, 0.3 / most) * step[a] * (equilibria->high[a] - equilibria->low[a]);
        }
        if (most < 1e-4) {
            break;
        }
    }
    return status == AD_OK
               ? linearise(equilibria, inputs, target, rows, directions, off, NULL, error)
               : status;
}

/* ---- tasks --------------------------------------------------------------------------------- */

/* Of a circle or an eight, around once. */
static ad_status points_around(const control_task *task, double points[POINTS_ON_PATH][3],
                               ad_error *error)
{
    task_path *path = NULL;
    control_task alone = *task;
    const double start[3] = {0};
    alone.approach = 0;
    const ad_status status = task_path_create(&alone, start, &path, error);
    for (int i = 0; i < POINTS_ON_PATH && status == AD_OK; i++) {
        task_path_at(path, i / (task->frequency * POINTS_ON_PATH), points[i]);
    }
    task_path_free(path);
    return status;
}

/* Heights above the plane at which the place can be over each point of the path. */
static ad_status find_heights(equilibria *equilibria, const control_task *task, double *heights,
                              ad_error *error)
{
    double across[2][3], points[POINTS_ON_PATH][3], off[3], inputs[SCENE_PARAMETERS_MAX];
    ad_status status = points_around(task, points, error);
    task_plane(task->normal, across);
    equilibria_middle(equilibria, inputs);
    for (int i = 0; i < POINTS_ON_PATH && status == AD_OK; i++) {
        reduced_place place;
        status = reach(equilibria, points[i], 2, across, inputs, off, error);
        status = status == AD_OK ? see(equilibria, inputs, &place, error) : status;
        heights[i] = 0;
        for (int k = 0; k < 3 && status == AD_OK; k++) {
            heights[i] += task->normal[k] * (place.position[k] - points[i][k]);
        }
    }
    return status;
}

/* Fourier's coefficients of heights over the phase: mean, then cos, sin. */
static void transform(const double *heights, double *terms)
{
    const double turn = 2 * 3.14159265358979323846 / POINTS_ON_PATH;
    memset(terms, 0, POINTS_ON_PATH * sizeof *terms);
    for (int i = 0; i < POINTS_ON_PATH; i++) {
        terms[0] += heights[i] / POINTS_ON_PATH;
        for (int k = 1; k <= CONTROL_HEIGHTS; k++) {
            terms[2 * k - 1] += 2 * heights[i] * cos(turn * k * i) / POINTS_ON_PATH;
            terms[2 * k] += 2 * heights[i] * sin(turn * k * i) / POINTS_ON_PATH;
        }
    }
}

static ad_status place_plane(equilibria *equilibria, control_task *task, ad_error *error)
{
    const bool open = isnan(task->centre[0]);
    double heights[POINTS_ON_PATH], inputs[SCENE_PARAMETERS_MAX], terms[POINTS_ON_PATH];
    reduced_place middle;
    equilibria_middle(equilibria, inputs);
    ad_status status = see(equilibria, inputs, &middle, error);
    if (status == AD_OK && isnan(task->normal[0])) {
        const double *q = middle.rotation;
        task->normal[0] = 2 * (q[1] * q[3] + q[0] * q[2]);
        task->normal[1] = 2 * (q[2] * q[3] - q[0] * q[1]);
        task->normal[2] = 1 - 2 * (q[1] * q[1] + q[2] * q[2]);
    }
    if (status == AD_OK && open) {
        memcpy(task->centre, middle.position, sizeof task->centre);
    }
    const double size = vector_length(task->normal);
    for (int k = 0; k < 3; k++) {
        task->normal[k] /= size;
    }
    const bool wanted = open || task->surface == CONTROL_REACHABLE;
    status = status == AD_OK && wanted ? find_heights(equilibria, task, heights, error) : status;
    if (status == AD_OK && wanted) {
        transform(heights, terms);
        for (int k = 0; k < 3 && open; k++) {
            task->centre[k] += terms[0] * task->normal[k];
        }
        if (task->surface == CONTROL_REACHABLE) {
            memcpy(task->heights, terms, sizeof task->heights);
            task->heights[0] = open ? 0 : terms[0];
        }
    }
    return status;
}

/* Every so many-th place that is judged is held; others lie on the way from one to the next. */
static int ways_of(const control_task *task)
{
    return task->path == CONTROL_POINTS && task->travel > 0 ? JUDGED_OF_WAY : 1;
}

/* The time of the i-th of the places at which a path without approach is judged; false: there are
 * no more. Ways between set points that are gone in jumps have none but their ends. */
static bool judged_at(const control_task *task, const task_path *path, int i, double *t)
{
    if (task->path == CONTROL_POINTS) {
        const int ways = ways_of(task), point = i / ways;
        *t = (i % ways) * task->travel / ways;
        for (int k = 0; k <= point && k < task->point_count; k++) {
            *t += k < point ? task->points[k].stay + task->travel : task->points[k].stay;
        }
        return i <= (task->point_count - 1) * ways;
    }
    *t = task->path == CONTROL_FILE ? i * task_path_end(path) / (JUDGED_PLACES - 1)
                                    : i / (task->frequency * JUDGED_PLACES);
    return i < JUDGED_PLACES;
}

ad_status equilibria_place_task(equilibria *equilibria, control_task *task, equilibria_reach *found,
                                ad_error *error)
{
    double point[3], off[3], inputs[SCENE_PARAMETERS_MAX], sum = 0, held = 0, t;
    double world[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const bool plane = task->path != CONTROL_POINTS && task->path != CONTROL_FILE;
    const int ways = ways_of(task);
    task_path *path = NULL;
    int count = 0;
    ad_status status = plane ? place_plane(equilibria, task, error) : AD_OK;
    control_task alone = *task;
    const double start[3] = {0};
    alone.approach = 0;
    status = status == AD_OK ? task_path_create(&alone, start, &path, error) : status;
    equilibria_middle(equilibria, inputs);
    *found = (equilibria_reach){0};
    for (; status == AD_OK && judged_at(&alone, path, count, &t); count++) {
        task_path_at(path, t, point);
        status = reach(equilibria, point, 3, world, inputs, off, error);
        const double size = vector_dot(off, off);
        sum += size;
        held += count % ways == 0 ? size : 0;
        found->worst = fmax(found->worst, sqrt(size));
    }
    found->rms = sqrt(sum / fmax(count, 1));
    found->held = sqrt(held / fmax((count + ways - 1) / ways, 1));
    task_path_free(path);
    return status;
}
