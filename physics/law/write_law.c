/* Writes the C of all laws, law_functions.h: run when the project is built. */
#include "physics/law/law.h"

#include <stdio.h>

static const char *const HEAD =
    "/* Laws at a point, written from physics/law/law.c when the project is built; do not edit.\n"
    " * Each adds to its outputs; derivatives that nobody reads cost nothing, as calls are "
    "inlined.\n"
    " * Needs NUMBER, ALGEBRA(name), ALGEBRA_INLINE, ALGEBRA(sqrt), ALGEBRA(inverse_root). */\n\n";

static ad_status write_law(law_name name, FILE *file, ad_error *error)
{
    const law *of = &law_table[name];
    law_formula x = law_formula_create(name);
    if (!x.tape) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory");
    }
    ad_inline_argument input[LAW_GROUPS_MAX];
    ad_status status = AD_OK;
    char function[64];
    int groups = 0;
    for (const ad_value *next = x.given; groups < LAW_GROUPS_MAX && of->given[groups].count > 0;
         groups++) {
        input[groups] = (ad_inline_argument){of->given[groups].name, of->given[groups].count, next};
        next += of->given[groups].count;
    }
    const ad_inline_argument value = {of->is_energy ? "energy" : "force", of->rows, x.value};
    const ad_inline_argument first = {of->is_energy ? "wrench" : "by_variables", law_first(of),
                                      x.first};
    const ad_inline_argument second = {"stiffness", law_second(of), x.second};
    const ad_inline_argument derived[2] = {of->is_energy ? first : value,
                                           of->is_energy ? second : first};
    fprintf(file, "/* %s */\n", of->about);
    if (of->is_energy) {
        snprintf(function, sizeof function, "law_%s_energy", of->name);
        status = ad_write_inline(function, groups, input, 1, &value, file, error);
    }
    ad_value by_v[6]; /* of energies of v and u: without the rest, for section by section */
    const ad_inline_argument derived_v[2] = {first, {"stiffness", 6, by_v}};
    for (int i = 0, k = 0; i < 3 && of->is_energy; i++) {
        for (int j = i; j < 3; j++) {
            by_v[k++] = x.second[law_entry(i, j)];
        }
    }
    snprintf(function, sizeof function, "law_%s_by_v", of->name);
    if (of->is_energy && status == AD_OK) {
        status = ad_write_inline(function, groups, input, 2, derived_v, file, error);
    }
    snprintf(function, sizeof function, "law_%s", of->name);
    if (status == AD_OK) {
        status = ad_write_inline(function, groups, input, 2, derived, file, error);
    }
    law_formula_free(&x);
    return status;
}

int main(int count, char **arguments)
{
    ad_error error;
    FILE *file = count == 2 ? fopen(arguments[1], "w") : NULL;
    ad_status status = file ? AD_OK : ad_fail(&error, AD_IO, "write_law FILE");
    if (file) {
        fputs(HEAD, file);
    }
    for (int i = 0; i < LAW_COUNT && status == AD_OK; i++) {
        status = write_law((law_name)i, file, &error);
    }
    if (file && fclose(file) != 0 && status == AD_OK) {
        status = ad_fail(&error, AD_IO, "%s: cannot be written", arguments[1]);
    }
    if (status != AD_OK) {
        fprintf(stderr, "%s\n", error.message);
    }
    return status != AD_OK;
}
