#include "physics/local/formula.h"

#include <stdlib.h>

struct formula {
    ad_program *program;
    size_t rows, more;
    double *memory; /* [2 + more + rows][capacity]: s, t, the third input, values */
    size_t capacity;
};

ad_status solve_formula_create(ad_value value, int more, ad_pool *pool, formula **result,
                               ad_error *error)
{
    *result = NULL;
    formula *f = calloc(1, sizeof *f);
    if (!f) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a formula");
    }
    f->rows = (size_t)ad_rows(value);
    f->more = (size_t)more;
    ad_status status = ad_compile(1, &value, NULL, pool, &f->program, error);
    if (status != AD_OK) {
        free(f);
        return status;
    }
    *result = f;
    return AD_OK;
}

void solve_formula_free(formula *f)
{
    if (f) {
        ad_program_free(f->program);
        free(f->memory);
        free(f);
    }
}

ad_status solve_formula_evaluate_of(formula *f, size_t n, const double *s, double t,
                                    const double *third, double *out, ad_error *error)
{
    if (n > f->capacity) {
        double *memory = realloc(f->memory, (2 + f->more + f->rows) * n * sizeof *memory);
        if (!memory) {
            return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", n);
        }
        f->memory = memory;
        f->capacity = n;
    }
    double *points = f->memory, *times = points + n, *more = times + n;
    double *values = more + f->more * n;
    for (size_t i = 0; i < n; i++) {
        points[i] = s[i];
        times[i] = t;
        for (size_t row = 0; row < f->more; row++) {
            more[row * n + i] = third[i * f->more + row];
        }
    }
    const double *inputs[3] = {points, times, more};
    const ad_run run = {.points = n, .inputs = inputs, .outputs = &values, .everywhere = true};
    ad_status status = ad_execute(f->program, &run, error);
    for (size_t i = 0; status == AD_OK && i < n; i++) {
        for (size_t row = 0; row < f->rows; row++) {
            out[i * f->rows + row] = values[row * n + i];
        }
    }
    return status;
}

ad_status solve_formula_evaluate(formula *f, size_t n, const double *s, double t, double *out,
                                 ad_error *error)
{
    return solve_formula_evaluate_of(f, n, s, t, NULL, out, error);
}
