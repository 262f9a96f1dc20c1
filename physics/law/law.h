/* The law at a point: what acts on a rod there, as formulas of the state of the section that are
 * recorded once. Equations on a tape call them (law_record); solvers call C that is written from
 * them when the project is built (law_functions.h), for numbers and for vectors of numbers; their
 * derivatives are made by the tape's transforms alone.
 *
 * A law is the energy of a section per length, of which the wrench is the gradient and the
 * stiffness the second derivative, or, where there is no energy, a force with its derivatives. The
 * first `variables` scalars of what it is given are those by which it is differentiated. */
#ifndef PHYSICS_LAW_LAW_H
#define PHYSICS_LAW_LAW_H

#include "autodiff/ad.h"

typedef enum law_name {
    LAW_TENDON,     /* energy: tension |p'|, p' = v + u x r + r', (Rucker, Webster 2011) */
    LAW_CHAMBER,    /* energy: minus pressure times area times p'_3, here `pull` p'_3 */
    LAW_RESISTANCE, /* force per length against the velocity: (c_1 + c_2 |V|) V */
    LAW_COUNT
} law_name;

enum { LAW_GROUPS_MAX = 4, LAW_GIVEN_MAX = 16, LAW_VARIABLES_MAX = 6, LAW_FIRST_MAX = 9 };
enum { LAW_SECOND_MAX = LAW_VARIABLES_MAX * (LAW_VARIABLES_MAX + 1) / 2 };

typedef struct law_group {
    const char *name;
    int count; /* scalars */
} law_group;

typedef struct law {
    const char *name, *about;
    law_group given[LAW_GROUPS_MAX]; /* ends at a count of 0 */
    int variables, rows;
    bool is_energy; /* rows = 1 */
    void (*record)(const ad_value *given, ad_value *value);
} law;

extern const law law_table[LAW_COUNT];

int law_given(const law *of); /* scalars in all groups */

/* Numbers of derivatives: of an energy its gradient [variables] and the upper triangle of its
 * second derivatives, row by row; of a force [rows][variables], and none. */
int law_first(const law *of);
int law_second(const law *of);

/* Entry (i, j) of the upper triangle of a symmetric 6 x 6. */
static inline int law_entry(int i, int j)
{
    return i <= j ? i * (2 * LAW_VARIABLES_MAX - 1 - i) / 2 + j
                  : j * (2 * LAW_VARIABLES_MAX - 1 - j) / 2 + i;
}

/* A law on a tape of its own, with its derivatives. */
typedef struct law_formula {
    ad_tape *tape;
    ad_value given[LAW_GIVEN_MAX], value[3], first[LAW_FIRST_MAX], second[LAW_SECOND_MAX];
} law_formula;

/* NULL tape: out of memory; errors of recording are on the tape. */
law_formula law_formula_create(law_name name);
void law_formula_free(law_formula *formula);

/* A law of values [law_given] of a tape, each of one row or of one row a point; value, first and
 * second may be NULL. Errors are noted on the tape. */
void law_record(law_name name, ad_tape *tape, const ad_value *given, ad_value *value,
                ad_value *first, ad_value *second);

#endif
