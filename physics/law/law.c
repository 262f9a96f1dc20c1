#include "physics/law/law.h"

/* ---- the laws ------------------------------------------------------------------------------ */

/* p' = v + u x r + r' of a line at r = (x, y, 0) in the section; a: x, y, x', y'. */
static void record_path(const ad_value *v, const ad_value *u, const ad_value *a, ad_value path[3])
{
    path[0] = ad_add(ad_sub(v[0], ad_mul(u[2], a[1])), a[2]);
    path[1] = ad_add(ad_add(v[1], ad_mul(u[2], a[0])), a[3]);
    path[2] = ad_sub(ad_add(v[2], ad_mul(u[0], a[1])), ad_mul(u[1], a[0]));
}

static ad_value length(const ad_value x[3])
{
    return ad_sqrt(ad_add(ad_add(ad_square(x[0]), ad_square(x[1])), ad_square(x[2])));
}

static void record_tendon(const ad_value *given, ad_value *value)
{
    ad_value path[3];
    record_path(given, given + 3, given + 6, path);
    *value = ad_mul(given[10], length(path));
}

static void record_chamber(const ad_value *given, ad_value *value)
{
    ad_value path[3];
    record_path(given, given + 3, given + 6, path);
    *value = ad_mul(given[10], path[2]);
}

static void record_resistance(const ad_value *given, ad_value *value)
{
    const ad_value speed = length(given);
    const ad_value by = ad_add(given[3], ad_mul(given[4], speed));
    for (int i = 0; i < 3; i++) {
        value[i] = ad_mul(by, given[i]);
    }
}

/* actuator: offset x, y, slope x', y', pull */
#define ACTUATED                                                                                   \
    {                                                                                              \
        {"v", 3}, {"u", 3},                                                                        \
        {                                                                                          \
            "actuator", 5                                                                          \
        }                                                                                          \
    }

const law law_table[LAW_COUNT] = {
    [LAW_TENDON] = {"tendon", "A tendon: pull |p'|, p' = v + u x r + r'.", ACTUATED, 6, 1, true,
                    record_tendon},
    [LAW_CHAMBER] = {"chamber", "A fluid chamber: pull p'_3.", ACTUATED, 6, 1, true,
                     record_chamber},
    [LAW_RESISTANCE] = {"resistance",
                        "What surrounds the rod, against its velocity: (c_1 + c_2 |V|) V.",
                        {{"velocity", 3}, {"coefficients", 2}},
                        3,
                        3,
                        false,
                        record_resistance}};

/* ---- sizes --------------------------------------------------------------------------------- */

int law_given(const law *of)
{
    int count = 0;
    for (int i = 0; i < LAW_GROUPS_MAX; i++) {
        count += of->given[i].count;
    }
    return count;
}

int law_first(const law *of)
{
    return of->rows * of->variables;
}

int law_second(const law *of)
{
    return of->is_energy ? of->variables * (of->variables + 1) / 2 : 0;
}

/* ---- formulas ------------------------------------------------------------------------------ */

law_formula law_formula_create(law_name name)
{
    const law *of = &law_table[name];
    law_formula x = {.tape = ad_tape_create()};
    if (!x.tape) {
        return x;
    }
    for (int i = 0, g = 0, k = 0; i < law_given(of); i++, k++) {
        for (; k == of->given[g].count; g++) {
            k = 0;
        }
        x.given[i] = ad_input(x.tape, of->given[g].name, 1);
    }
    of->record(x.given, x.value);
    for (int i = 0; i < of->rows; i++) {
        ad_reverse(x.value[i], of->variables, x.given, AD_PER_POINT, x.first + i * of->variables);
    }
    for (int i = 0, k = 0; i < of->variables && of->is_energy; i++) {
        for (int j = i; j < of->variables; j++) {
            x.second[k++] = ad_derivative(x.first[i], x.given[j], 1);
        }
    }
    return x;
}

void law_formula_free(law_formula *formula)
{
    ad_tape_free(formula->tape);
    formula->tape = NULL;
}

void law_record(law_name name, ad_tape *tape, const ad_value *given, ad_value *value,
                ad_value *first, ad_value *second)
{
    const law *of = &law_table[name];
    law_formula x = law_formula_create(name);
    if (!x.tape) {
        ad_tape_fail(tape, AD_NO_MEMORY, "out of memory for a law");
    }
    const struct {
        const ad_value *formula;
        ad_value *to;
        int count;
    } all[] = {{x.value, value, of->rows},
               {x.first, first, law_first(of)},
               {x.second, second, law_second(of)}};
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < all[i].count && all[i].to && !x.tape; k++) {
            all[i].to[k] = (ad_value){tape, -1};
        }
        if (all[i].to && all[i].count > 0 && x.tape) {
            ad_call(all[i].count, all[i].formula, law_given(of), x.given, tape, given, all[i].to);
        }
    }
    law_formula_free(&x);
}
