/* Writes the C of all laws, law_functions.h: run when the project is built. */
#include "physics/law/law.h"

#include <stdio.h>

static const char *const HEAD =
    "/* Laws at a point, written from physics/law/law.c when the project is built; do not edit.\n"
    " * Each adds to its outputs; derivatives that nobody reads cost nothing, as calls are "
    "inlined.\n"
    " * Needs NUMBER, ALGEBRA(name), ALGEBRA_INLINE, ALGEBRA(sqrt), ALGEBRA(inverse_root),\n"
    " * ALGEBRA(exp), ALGEBRA(log). */\n\n";

typedef struct writer {
    FILE *file;
    ad_status status;
    ad_error *error;
} writer;

static void write_function(writer *w, law_name name, const char *ending, int groups,
                           const ad_inline_argument *input, int outputs,
                           const ad_inline_argument *output)
{
    char function[64];
    snprintf(function, sizeof function, "law_%s%s", law_table[name].name, ending);
    if (w->status == AD_OK) {
        w->status = ad_write_inline(function, groups, input, outputs, output, w->file, w->error);
    }
}

/* What the law is given, as arguments; how many. */
static int arguments_of(law_name name, const law_formula *formula,
                        ad_inline_argument input[LAW_GROUPS_MAX])
{
    law_group groups[LAW_GROUPS_MAX];
    const int count = law_groups(name, groups);
    for (int i = 0, k = 0; i < count; k += groups[i++].count) {
        input[i] = (ad_inline_argument){groups[i].name, groups[i].count, formula->given + k};
    }
    return count;
}

/* What energy and wrench change by with a change of its numbers. */
static void write_change(writer *w, law_name name, const law_formula *formula)
{
    const int numbers = law_table[name].numbers, first = law_given(name) - numbers;
    ad_value of[1 + LAW_WRENCH] = {formula->energy}, by[1 + LAW_WRENCH], change[LAW_NUMBERS_MAX];
    ad_inline_argument input[LAW_GROUPS_MAX + 1];
    const int groups = arguments_of(name, formula, input);
    for (int i = 0; i < LAW_WRENCH; i++) {
        of[1 + i] = formula->wrench[i];
    }
    for (int i = 0; i < numbers; i++) {
        change[i] = ad_input(formula->tape, "change", 1);
    }
    ad_directional(1 + LAW_WRENCH, of, numbers, formula->given + first, change, by);
    input[groups] = (ad_inline_argument){"change", numbers, change};
    const ad_inline_argument energy = {"energy", 1, by}, wrench = {"wrench", LAW_WRENCH, by + 1};
    if (law_table[name].state == LAW_WITHIN) {
        write_function(w, name, "_energy_change", groups + 1, input, 1, &energy);
    }
    write_function(w, name, "_wrench_change", groups + 1, input, 1, &wrench);
}

static void write_within(writer *w, law_name name, const law_formula *formula)
{
    ad_value by_v[6]; /* without the rest, for section by section */
    ad_inline_argument input[LAW_GROUPS_MAX];
    const int groups = arguments_of(name, formula, input);
    const ad_inline_argument energy = {"energy", 1, &formula->energy};
    const ad_inline_argument all[2] = {{"wrench", LAW_WRENCH, formula->wrench},
                                       {"stiffness", LAW_STIFFNESS, formula->by}};
    const ad_inline_argument some[2] = {all[0], {"stiffness", 6, by_v}};
    const ad_inline_argument every[3] = {energy, all[0], all[1]};
    for (int i = 0, k = 0; i < 3; i++) {
        for (int j = i; j < 3; j++) {
            by_v[k++] = formula->by[law_entry(i, j)];
        }
    }
    write_function(w, name, "_energy", groups, input, 1, &energy);
    write_function(w, name, "_wrench", groups, input, 1, all);
    if (law_table[name].state == LAW_WITHIN) {
        write_function(w, name, "_by_v", groups, input, 2, some);
    }
    write_function(w, name, "", groups, input, 2, all);
    write_function(w, name, "_with_energy", groups, input, 3, every);
    if (name < LAW_ACTUATORS || law_table[name].state == LAW_TURNED) {
        write_change(w, name, formula);
    }
}

#define STRAINS "const NUMBER v[3], const NUMBER u[3], const NUMBER *actuator"
#define STATE                                                                                      \
    "const NUMBER position[3], const NUMBER rotation[4],\n"                                        \
    "    const NUMBER velocity[3], const NUMBER *numbers"

static void write_beyond(writer *w, law_name name, const law_formula *formula)
{
    ad_inline_argument input[LAW_GROUPS_MAX];
    const int groups = arguments_of(name, formula, input);
    const ad_inline_argument energy = {"energy", 1, &formula->energy};
    const ad_inline_argument all[2] = {{"wrench", LAW_WRENCH, formula->wrench},
                                       {"by", law_derivatives(name), formula->by}};
    write_function(w, name, "_energy", groups, input, 1, &energy);
    write_function(w, name, "_wrench", groups, input, 1, all);
    write_function(w, name, "", groups, input, 2, all);
    if (law_table[name].state == LAW_OUTSIDE) {
        write_change(w, name, formula);
    }
}

/* One function for any law of a state, up to one of them, by its number. */
static void write_choice(writer *w, const char *of, law_state from, int to, const char *state,
                         const char *given, const char *ending, const char *outputs,
                         const char *passed)
{
    fprintf(w->file, "ALGEBRA_INLINE void ALGEBRA(law_%s%s)(int law, %s, %s)\n{\n", of, ending,
            state, outputs);
    fputs("    switch (law) {\n", w->file);
    for (int i = 0; i < to; i++) {
        if (law_table[i].state == from) {
            fprintf(w->file, "    case %d:\n        ALGEBRA(law_%s%s)(%s, %s);\n        break;\n",
                    i, law_table[i].name, ending, given, passed);
        }
    }
    fputs("    default:\n        break;\n    }\n}\n\n", w->file);
}

static void write_choices(writer *w)
{
    static const struct {
        const char *ending, *outputs, *passed;
    } outside[3] = {{"_energy", "NUMBER energy[1]", "energy"},
                    {"_wrench", "NUMBER wrench[6]", "wrench"},
                    {"", "NUMBER wrench[6], NUMBER by[54]", "wrench, by"}},
      within[4] = {{"_energy", "NUMBER energy[1]", "energy"},
                   {"_wrench", "NUMBER wrench[6]", "wrench"},
                   {"_by_v", "NUMBER wrench[6], NUMBER stiffness[6]", "wrench, stiffness"},
                   {"", "NUMBER wrench[6], NUMBER stiffness[21]", "wrench, stiffness"}};
    for (size_t i = 0; i < sizeof within / sizeof *within; i++) {
        write_choice(w, "actuator", LAW_WITHIN, LAW_ACTUATORS, STRAINS, "v, u, actuator",
                     within[i].ending, within[i].outputs, within[i].passed);
    }
    for (size_t i = 0; i < sizeof outside / sizeof *outside; i++) {
        write_choice(w, "outside", LAW_OUTSIDE, LAW_COUNT, STATE,
                     "position, rotation, velocity, numbers", outside[i].ending, outside[i].outputs,
                     outside[i].passed);
    }
    write_choice(w, "actuator", LAW_WITHIN, LAW_ACTUATORS, STRAINS ", const NUMBER *change",
                 "v, u, actuator, change", "_wrench_change", "NUMBER wrench[6]", "wrench");
    write_choice(w, "outside", LAW_OUTSIDE, LAW_COUNT, STATE ",\n    const NUMBER *change",
                 "position, rotation, velocity, numbers, change", "_wrench_change",
                 "NUMBER wrench[6]", "wrench");
}

static void write_law(writer *w, law_name name)
{
    law_formula x = law_formula_create(name);
    fprintf(w->file, "/* %s */\n", law_table[name].about);
    const law_state state = law_table[name].state;
    const bool within = state == LAW_WITHIN || state == LAW_TURNED;
    (within ? write_within : write_beyond)(w, name, &x);
    law_formula_free(&x);
}

int main(int count, char **arguments)
{
    ad_error error;
    writer w = {count == 2 ? fopen(arguments[1], "w") : NULL, AD_OK, &error};
    if (!w.file) {
        fputs("write_law FILE\n", stderr);
        return 1;
    }
    fputs(HEAD, w.file);
    for (int i = 0; i < LAW_COUNT && w.status == AD_OK; i++) {
        write_law(&w, (law_name)i);
    }
    write_choices(&w);
    if (fclose(w.file) != 0 && w.status == AD_OK) {
        w.status = ad_fail(&error, AD_IO, "%s: cannot be written", arguments[1]);
    }
    if (w.status != AD_OK) {
        fprintf(stderr, "%s\n", error.message);
    }
    return w.status != AD_OK;
}
