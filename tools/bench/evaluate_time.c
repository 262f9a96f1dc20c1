/* How long a trained model takes to be evaluated: us per point of one value at a time, of many at
 * once, and of the same with first derivatives. Times are of the processor, the least of several
 * rounds, on one thread.
 *   evaluate DIR NAMES     of a run, NAMES "" for all columns */
#include "cpinn.h"

#include <math.h>
#include <stdio.h>
#include <time.h>

enum { ROUNDS = 7, SINGLE = 4000, MANY = 1000 };

typedef struct measure {
    const char *names;
    double one, many; /* us per point */
} measure;

static double processor_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* `batch` points at a time, us per point. */
static double time_of(evaluator *evaluator, size_t batch, const double *s, const double *t,
                      double *values)
{
    double best = INFINITY;
    for (int round = 0; round < ROUNDS; round++) {
        double start = processor_seconds();
        size_t calls = SINGLE / batch;
        for (size_t i = 0; i < calls; i++) {
            size_t first = i * batch % MANY;
            if (evaluator_evaluate(evaluator, batch, s + first, t + first, values, NULL) != AD_OK) {
                return NAN;
            }
        }
        best = fmin(best, (processor_seconds() - start) / (double)(calls * batch));
    }
    return 1e6 * best;
}

static void measure_evaluator(const cpinn_model *model, evaluator *evaluator, measure *m)
{
    const scene *rod = cpinn_scene(model);
    static double s[MANY], t[MANY], values[EVALUATOR_COLUMNS_MAX * MANY];
    double length = quantity_value(rod->rod.length, 0, 0);
    for (int i = 0; i < MANY; i++) { /* a fixed walk over rod and duration */
        s[i] = length * fmod(0.618034 * i, 1);
        t[i] = scene_is_dynamic(rod) ? quantity_value(rod->duration, 0, 0) * i / MANY : 0;
    }
    m->one = time_of(evaluator, 1, s, t, values);
    m->many = time_of(evaluator, MANY, s, t, values);
    evaluator_free(evaluator);
}

static ad_status measure_names(const cpinn_model *model, measure *m, ad_error *error)
{
    evaluator *evaluator;
    ad_status status = cpinn_evaluator(model, m->names, &evaluator, error);
    if (status == AD_OK) {
        measure_evaluator(model, evaluator, m);
    }
    return status;
}

/* The names of columns and of their first derivatives by s and t. */
static ad_status with_derivatives(const cpinn_model *model, const char *names, char *text,
                                  size_t room, ad_error *error)
{
    bool dynamic = scene_is_dynamic(cpinn_scene(model));
    size_t length = 0;
    evaluator *evaluator;
    ad_status status = cpinn_evaluator(model, names, &evaluator, error);
    for (int i = 0; status == AD_OK && i < evaluator_columns(evaluator) && length < room; i++) {
        const char *name = evaluator_column_name(evaluator, i);
        length += (size_t)snprintf(text + length, room - length, "%s %s_s ", name, name);
        if (dynamic && length < room) {
            length += (size_t)snprintf(text + length, room - length, "%s_t ", name);
        }
    }
    if (status == AD_OK) {
        evaluator_free(evaluator);
    }
    return status;
}

int main(int count, char **arguments)
{
    char text[4000];
    cpinn_model *model;
    ad_error error;
    if (count != 3) {
        fprintf(stderr, "usage: evaluate DIR NAMES\n");
        return 2;
    }
    measure plain = {.names = *arguments[2] ? arguments[2] : NULL}, derived = {.names = text};
    if (cpinn_open(arguments[1], &model, &error) != AD_OK ||
        measure_names(model, &plain, &error) != AD_OK ||
        with_derivatives(model, plain.names, text, sizeof text, &error) != AD_OK ||
        measure_names(model, &derived, &error) != AD_OK) {
        fprintf(stderr, "evaluate: %s\n", error.message);
        return 1;
    }
    printf("%.3g %.3g %.3g %.3g\n", plain.one, plain.many, derived.one, derived.many);
    cpinn_free(model);
    return 0;
}
