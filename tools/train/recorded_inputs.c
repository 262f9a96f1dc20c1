#include "tools/train/recorded_inputs.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct recorded {
    solve_inputs inputs; /* first */
    const char *path;
    struct recorded *next;
    double numbers[]; /* t, values */
} recorded;

struct recorded_inputs {
    int count;
    recorded *first;
};

/* A file being looked at. */
typedef struct looking {
    const scene *open;
    const char *path;
    const double *t, *const *known;
} looking;

ad_status recorded_inputs_create(recorded_inputs **result, ad_error *error)
{
    recorded_inputs *x = *result = calloc(1, sizeof *x);
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for inputs");
    }
    return AD_OK;
}

void recorded_inputs_free(recorded_inputs *x)
{
    for (recorded *r = x ? x->first : NULL; r;) {
        recorded *next = r->next;
        free(r);
        r = next;
    }
    free(x);
}

/* Which parameters vary over rows `from` to before `end`, whose times ascend; 0: none. Two values
 * at one time are those of several experiments, unless they are so at few of the times alone. */
static ad_status find_varying(const looking *l, size_t from, size_t end, uint64_t *which,
                              ad_error *error)
{
    size_t times = 1, twice = 0, row = 0;
    *which = 0;
    for (size_t i = from + 1; i < end; i++) {
        const bool later = l->t[i] != l->t[i - 1];
        bool other = false;
        for (int k = 0; k < scene_known_count(l->open); k++) {
            const bool differs = l->known[k] && l->known[k][i] != l->known[k][i - 1];
            other = other || differs;
            *which |= differs ? UINT64_C(1) << k : 0;
        }
        times += later;
        if (other && !later) {
            row = twice++ ? row : i + 1;
        }
    }
    *which = twice ? 0 : *which;
    return twice == 0 || 2 * twice >= times
               ? AD_OK
               : ad_fail(error, AD_BAD_INPUT,
                         "%s: row %zu has another input than the one before, at the same t = %g s; "
                         "allowed: one value of each input at each instant of a recording",
                         l->path, row, l->t[row - 1]);
}

/* One sample for each time. */
static ad_status take(recorded_inputs *x, const looking *l, size_t from, size_t end, uint64_t which,
                      recorded **result, ad_error *error)
{
    const size_t width = (size_t)l->open->parameter_count;
    recorded *r = calloc(1, sizeof *r + (end - from) * (1 + width) * sizeof(double));
    *result = r;
    if (!r) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu samples", end - from);
    }
    double *t = r->numbers, *values = t + (end - from);
    r->path = l->path;
    r->inputs = (solve_inputs){.number = x->count + 1, .t = t, .values = values, .which = which};
    for (size_t i = from; i < end; i++) {
        if (i > from && l->t[i] == l->t[i - 1]) {
            continue;
        }
        double *to = values + r->inputs.count * width;
        t[r->inputs.count++] = l->t[i];
        for (size_t k = 0; k < width; k++) {
            const bool known = (int)k < scene_known_count(l->open);
            to[k] = known && l->known[k] ? l->known[k][i] : NAN;
            if ((which >> k & 1) && isnan(to[k])) {
                return ad_fail(error, AD_BAD_INPUT,
                               "%s: row %zu has no %s; an input is given in every row", l->path,
                               i + 1, l->open->parameters[k].name);
            }
        }
    }
    return t[0] <= 0 ? AD_OK
                     : ad_fail(error, AD_BAD_INPUT,
                               "%s: inputs begin at t = %g s; allowed: from t = 0 on, where the "
                               "motion begins",
                               l->path, t[0]);
}

static bool same(const recorded *a, const recorded *b, size_t width)
{
    const solve_inputs *x = &a->inputs, *y = &b->inputs;
    return strcmp(a->path, b->path) == 0 && x->count == y->count && x->which == y->which &&
           memcmp(x->t, y->t, x->count * sizeof *x->t) == 0 &&
           memcmp(x->values, y->values, x->count * width * sizeof *x->values) == 0;
}

/* The recording, or the one of another list that is the same. */
static const solve_inputs *keep(recorded_inputs *x, recorded *r, size_t width)
{
    for (const recorded *other = x->first; other; other = other->next) {
        if (same(other, r, width)) {
            free(r);
            return &other->inputs;
        }
    }
    r->next = x->first;
    x->first = r;
    x->count++;
    return &r->inputs;
}

ad_status recorded_inputs_find(recorded_inputs *x, const scene *open, const char *path, size_t rows,
                               const double *t, const double *const *known, const solve_inputs **of,
                               ad_error *error)
{
    const looking l = {open, path, t, known};
    ad_status status = AD_OK;
    for (size_t from = 0, end; from < rows && status == AD_OK; from = end) {
        const solve_inputs *inputs = NULL;
        for (end = from + 1; end < rows && t[end] >= t[end - 1];) {
            end++;
        }
        uint64_t which;
        recorded *r = NULL;
        status = find_varying(&l, from, end, &which, error);
        status = status == AD_OK && which ? take(x, &l, from, end, which, &r, error) : status;
        if (status != AD_OK) {
            free(r);
        } else if (r) {
            inputs = keep(x, r, (size_t)open->parameter_count);
        }
        for (size_t i = from; i < end; i++) {
            of[i] = inputs;
        }
    }
    return status;
}
