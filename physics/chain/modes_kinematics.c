/* The constants of a reduced rod's kinematics, in SI units. */
#include "physics/chain/modes_internal.h"

#include <stdlib.h>
#include <string.h>

_Static_assert((int)KINEMATICS_STAGES_MAX >= (int)GAUSS_STAGES_MAX, "points of an element");
_Static_assert((int)KINEMATICS_STRAINS == (int)MODES_STRAINS, "strains");

/* m of an element's unit of length: hinges turn by angles over a length of 1. */
static double unit_of(const modes *m, int element)
{
    return element >= m->hinges ? m->rod->scales.length : 1;
}

typedef double step_terms[3][GAUSS_STAGES_MAX];

/* Terms of a step of an element: those of modes that are all 0 [3][3], by each mode [3]. */
static void set_step(const modes *m, int e, step_terms magnus, double *base, double *by)
{
    const modes_element *element = &m->element[e];
    for (int k = 0; k < 3; k++) {
        for (int j = 0; j < m->stages; j++) {
            const int point = e * (m->stages + 1) + j;
            const double weight = element->length * magnus[k][j];
            for (int c = 0; c < 3; c++) {
                base[3 * k + c] += weight * m->point[point].origin[MODES_U + c];
            }
            for (int a = element->own; a < element->end; a++) {
                by[3 * a + k] += weight * m->value[point * m->width + a] * unit_of(m, e);
            }
        }
    }
}

static void set_element(const modes *m, int e, double *joint, double *origin, double *value,
                        double *integral, double *step, double *step_by)
{
    const int n = m->stages, size = m->end.first;
    const double unit = unit_of(m, e);
    joint[0] = 1;
    if (m->turn_at[e] >= 0) {
        memcpy(joint, m->rod->jumps.at[m->turn_at[e]].turn, 4 * sizeof *joint);
    }
    for (int i = 0; i < n; i++) {
        const int point = e * (n + 1) + i;
        memcpy(value + i * size, m->value + point * m->width, (size_t)size * sizeof *value);
        for (int c = 0; c < MODES_STRAINS; c++) {
            origin[i * MODES_STRAINS + c] = m->point[point].origin[c] / (c >= MODES_U ? unit : 1);
        }
    }
    for (int i = 0; i <= n; i++) {
        step_terms terms;
        for (int k = 0; k < 3 * n; k++) {
            terms[k % 3][k / 3] = m->magnus[k % 3][k / 3][i];
            integral[i * n + k / 3] = unit * m->element[e].matrix[i][k / 3];
        }
        set_step(m, e, terms, step + 9 * i, step_by + 3 * size * i);
    }
}

static void set_place(const modes *m, modes_place *at, double *step, double *step_by,
                      double *integral, double *origin, double *value)
{
    const int e = at->element, size = m->end.first;
    set_step(m, e, at->magnus, step, step_by);
    for (int j = 0; j < m->stages; j++) {
        const int point = e * (m->stages + 1) + j;
        integral[j] = at->length * at->integrals[j] * unit_of(m, e);
        for (int c = 0; c < MODES_STRAINS; c++) {
            origin[c] +=
                at->values[j] * m->point[point].origin[c] / (c >= MODES_U ? unit_of(m, e) : 1);
        }
        for (int a = 0; a < size; a++) {
            value[a] += at->values[j] * m->value[point * m->width + a];
        }
    }
}

/* Sizes of the arrays, and where they are in memory that is theirs. */
static ad_status allocate(kinematics *kinematics, int **integers, double **numbers, ad_error *error)
{
    const int modes = kinematics->modes, elements = kinematics->elements,
              stages = kinematics->stages, places = kinematics->places;
    const int rows = kinematics->rows;
    size_t whole = 0, real = 0;
#define COUNT(name, count) whole += (size_t)(count);
    KINEMATICS_INTEGERS(COUNT)
#undef COUNT
#define COUNT(name, count) real += (size_t)(count);
    KINEMATICS_NUMBERS(COUNT)
#undef COUNT
    int *i = *integers = calloc(whole + 1, sizeof *i);
    double *d = *numbers = calloc(real, sizeof *d);
    if (!i || !d) {
        free(i);
        free(d);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for what is seen of a rod");
    }
#define PLACE(name, count)                                                                         \
    kinematics->name = i;                                                                          \
    i += count;
    KINEMATICS_INTEGERS(PLACE)
#undef PLACE
#define PLACE(name, count)                                                                         \
    kinematics->name = d;                                                                          \
    d += count;
    KINEMATICS_NUMBERS(PLACE)
#undef PLACE
    return AD_OK;
}

/* An array of x as one that can be written: it is of the memory from `numbers` on. */
static double *own(const double *array, double *numbers, const kinematics *kinematics)
{
    return numbers + (array - kinematics->start);
}

static void fill(const modes *m, modes_places *places, const int *row, int *integers,
                 double *numbers, kinematics *kinematics)
{
    const int n = m->stages, size = m->end.first;
    int *whole = integers;
    for (int a = 0; a < size; a++) {
        *whole++ = m->mode[a].strain;
    }
    for (int side = 0; side < 2; side++) {
        for (int e = 0; e < m->elements; e++) {
            *whole++ = side ? m->element[e].end : m->element[e].own;
        }
    }
    for (int side = 0; side < 2; side++) {
        for (int i = 0; i < kinematics->places; i++) {
            *whole++ = side ? places->at[i].before : places->at[i].element;
        }
    }
    for (int i = 0; i < kinematics->rows; i++) {
        *whole++ = row[i];
    }
    for (int e = 0; e < m->elements; e++) {
        set_element(m, e, own(kinematics->joint, numbers, kinematics) + 4 * e,
                    own(kinematics->origin, numbers, kinematics) + e * n * MODES_STRAINS,
                    own(kinematics->value, numbers, kinematics) + e * n * size,
                    own(kinematics->integral, numbers, kinematics) + e * (n + 1) * n,
                    own(kinematics->step, numbers, kinematics) + e * (n + 1) * 9,
                    own(kinematics->step_by, numbers, kinematics) + e * (n + 1) * size * 3);
    }
    for (int i = 0; i < kinematics->places; i++) {
        set_place(m, &places->at[i], own(kinematics->place_step, numbers, kinematics) + 9 * i,
                  own(kinematics->place_step_by, numbers, kinematics) + 3 * size * i,
                  own(kinematics->place_integral, numbers, kinematics) + n * i,
                  own(kinematics->place_origin, numbers, kinematics) + MODES_STRAINS * i,
                  own(kinematics->place_value, numbers, kinematics) + size * i);
    }
}

ad_status modes_kinematics_create(const modes *m, size_t places, const double *s, int rows,
                                  const int *row, kinematics *x, ad_error *error)
{
    modes_places *at = NULL;
    int *integers = NULL;
    double *numbers = NULL;
    *x = (kinematics){.modes = m->end.first,
                      .elements = m->elements,
                      .stages = m->stages,
                      .places = (int)places,
                      .rows = rows};
    ad_status status = modes_places_create(m, places, s, &at, error);
    status = status == AD_OK ? allocate(x, &integers, &numbers, error) : status;
    if (status == AD_OK) {
        fill(m, at, row, integers, numbers, x);
        modes_kinematics_start(m, x);
    } else {
        *x = (kinematics){0};
    }
    modes_places_free(at);
    return status;
}

void modes_kinematics_free(kinematics *kinematics)
{
    free((void *)kinematics->strain); /* the first of each kind */
    free((void *)kinematics->start);
}

void modes_kinematics_start(const modes *m, kinematics *kinematics)
{
    const rod_scales *scales = &m->rod->scales;
    double *start = (double *)kinematics->start;
    memcpy(start + 3, m->start.rotation, sizeof m->start.rotation);
    for (int k = 0; k < 3; k++) {
        start[k] = m->start.position[k] * scales->length;
        start[7 + k] = m->start.velocity[k] * scales->length / scales->time;
        start[10 + k] = m->start.spin[k] / scales->time;
    }
}
