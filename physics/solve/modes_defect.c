#include "physics/solve/modes_defect.h"

#include "autodiff/dense.h"
#include "physics/chain/modes_internal.h"
#include "physics/solve/motion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of errors: by the whole residual, and by that of the motion's own modes alone. */
enum { ALL, OWN, PARTS };

struct modes_defect {
    modes *m;
    int own, *place;        /* [own] where modes of the motion stand among those of m */
    const double *start;    /* [2 own] of the motion */
    int *pivots;            /* [size] */
    double *y;              /* [3][size] */
    double *residual;       /* [size] */
    double *by_q, *by_v;    /* [size rows of width] */
    double *matrix;         /* [size][size] */
    double *e, *v, *change; /* [PARTS][size] the errors and their rates; accelerations */
    double reached;         /* the end of the last window */
    model_motion_error off; /* the largest until then */
};

/* Where a mode stands among those of a finer rod: the pieces are the same, not their elements. */
static ad_status find_places(modes_defect *defect, const modes *own, ad_error *error)
{
    const modes *m = defect->m;
    for (int a = 0; a < own->size; a++) {
        const modes_mode *mode = &own->mode[a];
        const double from = own->s[mode->first_element * (own->stages + 1)];
        const double end = own->s[(mode->last_element + 1) * (own->stages + 1) - 1];
        defect->place[a] = a < own->hinges ? a : -1;
        for (int b = m->hinges; b < m->size && defect->place[a] < 0; b++) {
            const modes_mode *other = &m->mode[b];
            const double to = m->s[(other->last_element + 1) * (m->stages + 1) - 1];
            if (other->strain == mode->strain && other->degree == mode->degree &&
                m->s[other->first_element * (m->stages + 1)] < end && to > from) {
                defect->place[a] = b;
            }
        }
        if (defect->place[a] < 0) {
            return ad_fail(error, AD_BAD_ARGUMENT, "finer modes of a motion have other pieces");
        }
    }
    return AD_OK;
}

ad_status modes_defect_create(solve_rod *rod, const modes *own, const double *initial,
                              const modes_counts *counts, modes_defect **result, ad_error *error)
{
    modes_defect *defect = calloc(1, sizeof *defect);
    *result = NULL;
    if (!defect) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the error of a motion");
    }
    defect->own = own->size;
    defect->start = initial;
    ad_status status = modes_create(rod, NULL, counts, 0, &defect->m, error);
    if (status == AD_OK) {
        const size_t n = (size_t)defect->m->size, width = (size_t)defect->m->width;
        defect->place = malloc((size_t)own->size * sizeof *defect->place);
        defect->pivots = malloc(n * sizeof *defect->pivots);
        defect->y = calloc(4 * n + 2 * n * width + n * n + n * 3 * PARTS, sizeof *defect->y);
        if (!defect->place || !defect->pivots || !defect->y) {
            status = ad_fail(error, AD_NO_MEMORY, "out of memory for %zu modes", n);
        } else {
            defect->residual = defect->y + 3 * n;
            defect->by_q = defect->residual + n;
            defect->by_v = defect->by_q + n * width;
            defect->matrix = defect->by_v + n * width;
            defect->e = defect->matrix + n * n;
            defect->v = defect->e + PARTS * n;
            defect->change = defect->v + PARTS * n;
            status = find_places(defect, own, error);
        }
    }
    if (status != AD_OK) {
        modes_defect_free(defect);
        return status;
    }
    *result = defect;
    return AD_OK;
}

void modes_defect_free(modes_defect *defect)
{
    if (defect) {
        modes_free(defect->m);
        free(defect->place);
        free(defect->pivots);
        free(defect->y);
        free(defect);
    }
}

/* The residual of a motion y [3][own] of the modes, and its derivatives if they are wanted. */
static ad_status look(modes_defect *defect, double t, const double *y, bool derive, ad_error *error)
{
    modes *m = defect->m;
    const int n = m->size;
    for (int k = 0; k < 3; k++) {
        for (int a = 0; a < defect->own; a++) {
            defect->y[k * n + defect->place[a]] = y[k * defect->own + a];
        }
    }
    ad_status status = modes_at(m, t, NULL, error);
    if (status == AD_OK && derive) {
        modes_linearise(m, defect->y, defect->y + n, defect->y + 2 * n, defect->residual,
                        defect->by_q, defect->by_v);
    } else if (status == AD_OK) {
        modes_shape(m, defect->y, defect->y + n, defect->y + 2 * n);
        modes_forces(m, false, defect->residual);
    }
    return status;
}

/* What the motion's start leaves out of the rod's, at t = 0. */
static ad_status begin_anew(modes_defect *defect, ad_error *error)
{
    const int n = defect->m->size;
    ad_status status = modes_initial(defect->m, defect->e, defect->v, error);
    memset(defect->e + OWN * n, 0, (size_t)n * sizeof *defect->e);
    memset(defect->v + OWN * n, 0, (size_t)n * sizeof *defect->v);
    for (int a = 0; a < defect->own; a++) {
        defect->e[defect->place[a]] -= defect->start[a];
        defect->v[defect->place[a]] -= defect->start[defect->own + a];
    }
    defect->off = (model_motion_error){0};
    return status;
}

/* The largest displacement by the modes, to first order. */
static double displacement(const modes *m, const double *e)
{
    double most = 0;
    for (int p = 0; p < m->points; p++) {
        double square = 0;
        for (int k = 0; k < 3; k++) {
            const double *row = m->rho + (p * 3 + k) * m->width;
            double sum = 0;
            for (int a = 0; a < m->size; a++) {
                sum += row[a] * e[a];
            }
            square += sum * sum;
        }
        most = isnan(square) ? NAN : fmax(most, sqrt(square));
    }
    return most;
}

/* Of a little more than 1/2, so that waves too short for the steps fade. */
static const double IMPLICIT = 0.6;

/* M + h D + h^2 K, of the derivatives found last. */
static bool factor(modes_defect *defect, double h)
{
    const modes *m = defect->m;
    const int n = m->size, width = m->width;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            defect->matrix[j * n + i] = m->mass[i * width + j] + h * defect->by_v[i * width + j] +
                                        h * h * defect->by_q[i * width + j];
        }
    }
    return ad_dense_lu((size_t)n, defect->matrix, defect->pivots) == 0;
}

/* A step h of the errors, M e_tt + D e_t + K e = -residual, at its implicit point. */
static void advance(modes_defect *defect, double h)
{
    const modes *m = defect->m;
    const int n = m->size, width = m->width;
    const double part = IMPLICIT * h;
    double *change = defect->change;
    for (int i = 0; i < PARTS * n; i++) {
        change[i] = i < n ? -defect->residual[i] : 0;
    }
    for (int a = 0; a < defect->own; a++) {
        change[OWN * n + defect->place[a]] = -defect->residual[defect->place[a]];
    }
    for (int k = 0; k < PARTS; k++) {
        const double *e = defect->e + k * n, *v = defect->v + k * n;
        for (int i = 0; i < n; i++) {
            double sum = 0;
            for (int j = 0; j < n; j++) {
                sum += defect->by_v[i * width + j] * v[j] +
                       defect->by_q[i * width + j] * (e[j] + part * v[j]);
            }
            change[k * n + i] -= sum;
        }
    }
    ad_dense_lu_solve((size_t)n, PARTS, defect->matrix, defect->pivots, change);
    for (int i = 0; i < PARTS * n; i++) {
        defect->e[i] += h * (defect->v[i] + part * change[i]);
        defect->v[i] += h * change[i];
    }
}

ad_status modes_defect_follow(modes_defect *defect, double begin, double end, size_t count,
                              const double *y, model_motion_error *off, ad_error *error)
{
    const double h = (end - begin) / (double)count;
    const size_t numbers = 3 * (size_t)defect->own, middle = count / 2;
    const int n = defect->m->size;
    ad_status status = begin < defect->reached || begin == 0 ? begin_anew(defect, error) : AD_OK;
    defect->reached = end;
    if (status == AD_OK) {
        status =
            look(defect, begin + h * ((double)middle + 0.5), y + middle * numbers, true, error);
    }
    const bool regular = status == AD_OK && factor(defect, IMPLICIT * h);
    for (size_t i = 0; i < count && regular && status == AD_OK; i++) {
        status = look(defect, begin + h * ((double)i + 0.5), y + i * numbers, false, error);
        advance(defect, h);
        defect->off.all = motion_larger(defect->off.all, displacement(defect->m, defect->e));
        defect->off.in_time =
            motion_larger(defect->off.in_time, displacement(defect->m, defect->e + OWN * n));
    }
    *off = regular ? defect->off : (model_motion_error){NAN, NAN};
    return status;
}
