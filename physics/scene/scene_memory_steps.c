/* States of inputs with a memory, from row to row and from sample to sample. */
#include "physics/scene/scene_memory.h"
#include "physics/scene/scene_values.h"

#include <math.h>
#include <string.h>

/* ---- rows ---------------------------------------------------------------------------------- */

static void follow_slopes(const scene *open, const scene_values *names, const double *parameters,
                          const double *slopes, double *next)
{
    const int states = open->memory_count, first = scene_given_count(open);
    for (int u = scene_known_count(open); u < open->parameter_count; u++) {
        double along[SCENE_PARAMETERS_MAX] = {0};
        along[u] = 1;
        for (int m = 0; m < states; m++) {
            along[first + m] = slopes[m * open->parameter_count + u];
        }
        for (int m = 0; m < states; m++) {
            next[m * open->parameter_count + u] =
                scene_slope_at(names, open->memory[m].next, parameters, along);
        }
    }
}

/* Of rows that are motions. */
static void start_rows(const scene *open, const scene_values *names, size_t rows,
                       double *parameters, double *slopes)
{
    const size_t count = (size_t)open->parameter_count, states = (size_t)open->memory_count;
    const size_t first = (size_t)scene_given_count(open), known = first + states;
    double by[SCENE_PARAMETERS_MAX * SCENE_PARAMETERS_MAX];
    for (size_t row = 0; row < rows; row++) {
        memset(by, 0, sizeof by);
        for (size_t u = known; u < count; u++) {
            by[(u - known) * count + u] = 1;
        }
        scene_memory_start(open, names, parameters + row * count, slopes ? open->unknown_count : 0,
                           by);
        for (size_t m = 0; slopes && m < states; m++) {
            for (size_t u = known; u < count; u++) {
                slopes[(row * states + m) * count + u] = by[(u - known) * count + first + m];
            }
        }
    }
}

void scene_remember_path(const scene *open, size_t rows, double *parameters, double *slopes)
{
    const int count = open->parameter_count, states = open->memory_count;
    const size_t width = (size_t)states * (size_t)count;
    const scene_values names = scene_values_of(open);
    double *next = parameters + scene_given_count(open);
    for (size_t k = 0; slopes && k < rows * width; k++) {
        slopes[k] = 0;
    }
    if (scene_is_dynamic(open)) {
        start_rows(open, &names, rows, parameters, slopes);
        return;
    }
    for (int m = 0; m < states && rows > 0; m++) {
        next[m] = 0;
    }
    for (size_t row = 0; row + 1 < rows; row++) {
        const double *at = parameters + row * (size_t)count;
        next += count;
        for (int m = 0; m < states; m++) {
            next[m] = scene_value_at(&names, open->memory[m].next, at);
        }
        if (slopes) {
            follow_slopes(open, &names, at, slopes + row * width, slopes + (row + 1) * width);
        }
    }
}

/* ---- samples ------------------------------------------------------------------------------- */

void scene_memory_start(const scene *open, const scene_values *names, double *parameters,
                        int directions, double *by)
{
    const int count = open->parameter_count, first = scene_given_count(open);
    for (int m = 0; m < open->memory_count; m++) {
        const quantity next = open->memory[m].next;
        parameters[first + m] = 0;
        for (int i = 0; i < directions; i++) {
            double *along = by + i * count;
            along[first + m] = 0;
            along[first + m] = scene_slope_at(names, next, parameters, along);
        }
        parameters[first + m] = scene_value_at(names, next, parameters);
    }
}

/* A lag by the closed form, tau z' = x - z, and its derivatives by z, x before and after, tau. */
static double lag(double h, double z, double before, double after, double time, double by[4])
{
    const double e = exp(-h / time), part = -expm1(-h / time) * time / h;
    const double part_by = -expm1(-h / time) / h - e / time, e_by = e * h / (time * time);
    by[0] = e;
    by[1] = part - e;
    by[2] = 1 - part;
    by[3] = z * e_by + before * (part_by - e_by) - after * part_by;
    return z * by[0] + before * by[1] + after * by[2];
}

void scene_memory_step(const scene *open, const scene_values *names, double h, const double *now,
                       double *after, int directions, const double *by_now, double *by_after)
{
    const int count = open->parameter_count, first = scene_given_count(open);
    for (int m = 0; m < open->memory_count; m++) {
        const scene_memory *memory = &open->memory[m];
        double *state = &after[first + m], by[4] = {1};
        *state = now[first + m];
        const double begin = memory->lags ? scene_value_at(names, memory->input, now) : 0;
        const double end = memory->lags ? scene_value_at(names, memory->input, after) : 0;
        const double time = memory->lags ? scene_value_at(names, memory->time, after) : 0;
        const double value = memory->lags ? lag(h, *state, begin, end, time, by)
                                          : scene_value_at(names, memory->next, after);
        for (int i = 0; i < directions; i++) {
            const double *along = by_now + i * count;
            double *to = by_after + i * count;
            to[first + m] = along[first + m];
            to[first + m] = memory->lags
                                ? by[0] * along[first + m] +
                                      by[1] * scene_slope_at(names, memory->input, now, along) +
                                      by[2] * scene_slope_at(names, memory->input, after, to) +
                                      by[3] * scene_slope_at(names, memory->time, after, to)
                                : scene_slope_at(names, memory->next, after, to);
        }
        *state = value;
    }
}
