/* How long a trained model takes to be evaluated, one point at a time and many at once.
 *   evaluate [FILE.csv]     prints a table; the file gets the same numbers, when and on what they
 *                           were measured
 *   evaluate --run DIR NAMES   of a run, NAMES "" for all columns: value one at a time, many at
 * once, and the same with first derivatives Scenes of configs/ with their default networks, trained
 * here by the default recipe; run from the root of the project. Times are of the processor, the
 * least of several rounds, on one thread. */
#include "cpinn.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { ROUNDS = 7, SINGLE = 4000, MANY = 1000 };

typedef struct measure {
    const char *path, *names;
    int columns;
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
    m->columns = evaluator_columns(evaluator);
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

static int measure_run(const char *folder, const char *names)
{
    char text[4000];
    cpinn_model *model;
    ad_error error;
    measure plain = {.names = *names ? names : NULL}, derived = {.names = text};
    if (cpinn_open(folder, &model, &error) != AD_OK ||
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

static void processor_name(char text[128])
{
    char line[256];
    FILE *file = fopen("/proc/cpuinfo", "r");
    snprintf(text, 128, "unknown processor");
    while (file && fgets(line, sizeof line, file)) {
        char *colon = strchr(line, ':');
        if (strncmp(line, "model name", 10) == 0 && colon) {
            line[strcspn(line, "\n")] = '\0';
            snprintf(text, 128, "%s", colon + 2);
            break;
        }
    }
    if (file) {
        fclose(file);
    }
}

static int write_table(FILE *file, const measure *rows, int count)
{
    char processor[128], day[32];
    time_t now = time(NULL);
    strftime(day, sizeof day, "%Y-%m-%d", gmtime(&now));
    processor_name(processor);
    fprintf(file, "# cpinn %s, %s, %s, 1 thread; microseconds per point\n", cpinn_version(), day,
            processor);
    fprintf(file, "scene,evaluated,columns,one_at_a_time,%d_at_once\n", MANY);
    for (int i = 0; i < count; i++) {
        fprintf(file, "%s,%s,%d,%.3g,%.3g\n", rows[i].path, rows[i].names ? rows[i].names : "all",
                rows[i].columns, rows[i].one, rows[i].many);
    }
    return ferror(file) ? 1 : 0;
}

int main(int count, char **arguments)
{
    measure rows[] = {{.path = "configs/elastica.yaml", .names = "r q"},
                      {.path = "configs/elastica.yaml"},
                      {.path = "configs/cantilever_dynamic.yaml", .names = "r q"},
                      {.path = "configs/cantilever_dynamic.yaml", .names = "r r_t r_tt"},
                      {.path = "configs/cantilever_dynamic.yaml"}};
    const int row_count = sizeof rows / sizeof *rows;
    cpinn_model *model = NULL;
    ad_error error = {AD_OK, ""};
    const char *ending = count > 1 ? strrchr(arguments[1], '.') : ".csv";
    if (count == 4 && strcmp(arguments[1], "--run") == 0) {
        return measure_run(arguments[2], arguments[3]);
    }
    if (count > 2 || !ending || strcmp(ending, ".csv") != 0) {
        fprintf(stderr, "usage: evaluate [FILE.csv], from the root of the project\n");
        return 2;
    }
    for (int i = 0; i < row_count; i++) {
        bool other = i == 0 || strcmp(rows[i].path, rows[i - 1].path) != 0;
        if (other) {
            cpinn_free(model);
        }
        if ((other && cpinn_train_file(rows[i].path, 0, NULL, NULL, &model, &error) != AD_OK) ||
            measure_names(model, &rows[i], &error) != AD_OK) {
            fprintf(stderr, "evaluate: %s\n", error.message);
            return 1;
        }
    }
    cpinn_free(model);
    FILE *file = count > 1 ? fopen(arguments[1], "w") : NULL;
    int failed = write_table(stdout, rows, row_count);
    if (count > 1 && (!file || write_table(file, rows, row_count) != 0 || fclose(file) != 0)) {
        fprintf(stderr, "evaluate: %s cannot be written\n", arguments[1]);
        failed = 1;
    }
    return failed;
}
