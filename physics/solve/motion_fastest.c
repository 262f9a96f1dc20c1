#include "physics/solve/motion_fastest.h"

#include <math.h>
#include <stdlib.h>

struct fastest {
    motion *motion;
    size_t rows;
    double *direction, *its_rate, *moved, *state; /* [rows] */
};

ad_status motion_fastest_create(motion *m, fastest **result, ad_error *error)
{
    size_t rows = motion_size(m);
    fastest *f = calloc(1, sizeof *f);
    double *all = malloc(4 * rows * sizeof *all);
    *result = NULL;
    if (!f || !all) {
        free(f);
        free(all);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu rows", rows);
    }
    *f = (fastest){m, rows, all, all + rows, all + 2 * rows, all + 3 * rows};
    for (size_t i = 0; i < rows; i++) {
        f->direction[i] = 0.01 * sin((double)(i * i));
    }
    *result = f;
    return AD_OK;
}

void motion_fastest_free(fastest *f)
{
    if (f) {
        free(f->direction);
        free(f);
    }
}

/* d = J d, with J = d rate/d state; returns how much longer it is, and gives it length 1 again. */
static double apply_jacobian(fastest *f, const double *state)
{
    const double by = 1e-7;
    double length = 0, *d = f->direction;
    for (size_t i = 0; i < f->rows; i++) {
        f->moved[i] = state[i] + by * d[i];
    }
    motion_rate(f->motion, f->moved, d);
    for (size_t i = 0; i < f->rows; i++) {
        d[i] = (d[i] - f->its_rate[i]) / by;
        length += d[i] * d[i];
    }
    length = sqrt(length);
    for (size_t i = 0; i < f->rows && length > 0; i++) {
        d[i] /= length;
    }
    return length;
}

double motion_fastest_at(fastest *f, const double *state, int rounds)
{
    double growth = 0;
    motion_rate(f->motion, state, f->its_rate);
    for (int i = 0; i < rounds; i++) { /* twice each: eigenvalues come as +-i omega */
        growth = apply_jacobian(f, state);
        growth *= apply_jacobian(f, state);
    }
    return sqrt(growth);
}

ad_status motion_fastest_at_start(fastest *f, double *frequency, ad_error *error)
{
    ad_status status = motion_initial(f->motion, f->state, error);
    status = status == AD_OK ? motion_at(f->motion, 0, error) : status;
    if (status == AD_OK) {
        *frequency = motion_fastest_at(f, f->state, 20);
    }
    return status;
}
