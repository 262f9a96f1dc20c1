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

/* Terms of a step of an element [3][3] of modes that are all 0. */
static void set_base(const modes *m, int e, step_terms magnus, double *base)
{
    memset(base, 0, 9 * sizeof *base);
    for (int i = 0; i < 9 * m->stages; i++) {
        const int k = i % 9 / 3, j = i / 9, c = i % 3;
        base[3 * k + c] += m->element[e].length * magnus[k][j] *
                           m->point[e * (m->stages + 1) + j].origin[MODES_U + c];
    }
}

/* The same by each mode [3]. */
static void set_step(const modes *m, int e, step_terms magnus, double *by)
{
    const modes_element *element = &m->element[e];
    for (int k = 0; k < 3; k++) {
        for (int j = 0; j < m->stages; j++) {
            const int point = e * (m->stages + 1) + j;
            const double weight = element->length * magnus[k][j];
            for (int a = element->own; a < element->end; a++) {
                by[3 * a + k] += weight * m->value[point * m->width + a] * unit_of(m, e);
            }
        }
    }
}

/* Of step i of an element. */
static void take_terms(const modes *m, int i, step_terms terms)
{
    for (int k = 0; k < 3 * m->stages; k++) {
        terms[k % 3][k / 3] = m->magnus[k % 3][k / 3][i];
    }
}

static void set_element(const modes *m, int e, double *joint, double *value, double *integral,
                        double *step_by)
{
    const int n = m->stages, size = m->end.first;
    joint[0] = 1;
    if (m->turn_at[e] >= 0) {
        memcpy(joint, m->rod->jumps.at[m->turn_at[e]].turn, 4 * sizeof *joint);
    }
    for (int i = 0; i < n; i++) {
        memcpy(value + i * size, m->value + (e * (n + 1) + i) * m->width,
               (size_t)size * sizeof *value);
    }
    for (int i = 0; i <= n; i++) {
        step_terms terms;
        take_terms(m, i, terms);
        for (int k = 0; k < n; k++) {
            integral[i * n + k] = unit_of(m, e) * m->element[e].matrix[i][k];
        }
        set_step(m, e, terms, step_by + 3 * size * i);
    }
}

static void set_place(const modes *m, modes_place *at, double *step_by, double *integral,
                      double *value)
{
    const int e = at->element, size = m->end.first;
    set_step(m, e, at->magnus, step_by);
    for (int j = 0; j < m->stages; j++) {
        const int point = e * (m->stages + 1) + j;
        integral[j] = at->length * at->integrals[j] * unit_of(m, e);
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

/* An array of x as one that can be written: it is of the memory from the first on. */
static double *own(const double *array, const kinematics *kinematics)
{
    return (double *)kinematics->start + (array - kinematics->start);
}

/* Strains of modes that are all 0. */
static void set_origin(const modes *m, const modes_places *places, const kinematics *kinematics)
{
    const int n = m->stages;
    double *origin = own(kinematics->origin, kinematics);
    double *place = own(kinematics->place_origin, kinematics);
    for (int e = 0; e < m->elements; e++) {
        for (int i = 0; i < n * MODES_STRAINS; i++) {
            const int c = i % MODES_STRAINS;
            *origin++ = m->point[e * (n + 1) + i / MODES_STRAINS].origin[c] /
                        (c >= MODES_U ? unit_of(m, e) : 1);
        }
        for (int i = 0; i <= n; i++) {
            step_terms terms;
            take_terms(m, i, terms);
            set_base(m, e, terms, own(kinematics->step, kinematics) + (e * (n + 1) + i) * 9);
        }
    }
    for (size_t i = 0; i < places->count; i++, place += MODES_STRAINS) {
        modes_place at = places->at[i];
        set_base(m, at.element, at.magnus, own(kinematics->place_step, kinematics) + 9 * i);
        memset(place, 0, MODES_STRAINS * sizeof *place);
        for (int k = 0; k < n * MODES_STRAINS; k++) {
            const int c = k % MODES_STRAINS, j = k / MODES_STRAINS;
            place[c] += at.values[j] * m->point[at.element * (n + 1) + j].origin[c] /
                        (c >= MODES_U ? unit_of(m, at.element) : 1);
        }
    }
}

static void fill(const modes *m, modes_places *places, const int *row, int *integers,
                 kinematics *kinematics)
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
        set_element(m, e, own(kinematics->joint, kinematics) + 4 * e,
                    own(kinematics->value, kinematics) + e * n * size,
                    own(kinematics->integral, kinematics) + e * (n + 1) * n,
                    own(kinematics->step_by, kinematics) + e * (n + 1) * size * 3);
    }
    for (int i = 0; i < kinematics->places; i++) {
        set_place(m, &places->at[i], own(kinematics->place_step_by, kinematics) + 3 * size * i,
                  own(kinematics->place_integral, kinematics) + n * i,
                  own(kinematics->place_value, kinematics) + size * i);
    }
    set_origin(m, places, kinematics);
}

ad_status modes_kinematics_create(const modes *m, modes_places *places, int rows, const int *row,
                                  kinematics *x, ad_error *error)
{
    int *integers = NULL;
    double *numbers = NULL;
    *x = (kinematics){.modes = m->end.first,
                      .elements = m->elements,
                      .stages = m->stages,
                      .places = (int)places->count,
                      .rows = rows};
    const ad_status status = allocate(x, &integers, &numbers, error);
    if (status == AD_OK) {
        fill(m, places, row, integers, x);
        modes_kinematics_start(m, places, x);
    } else {
        *x = (kinematics){0};
    }
    return status;
}

void modes_kinematics_free(kinematics *kinematics)
{
    free((void *)kinematics->strain); /* the first of each kind */
    free((void *)kinematics->start);
}

void modes_kinematics_start(const modes *m, const modes_places *places, kinematics *kinematics)
{
    const rod_scales *scales = &m->rod->scales;
    double *start = (double *)kinematics->start;
    memcpy(start + 3, m->start.rotation, sizeof m->start.rotation);
    for (int k = 0; k < 3; k++) {
        start[k] = m->start.position[k] * scales->length;
        start[7 + k] = m->start.velocity[k] * scales->length / scales->time;
        start[10 + k] = m->start.spin[k] / scales->time;
    }
    if (m->origin_moves) {
        set_origin(m, places, kinematics);
    }
}
