/* Equations of one's own: read, and each residual recorded. */
#include "tests/fuzz/fuzz.h"
#include "tools/config/config_equations.h"

static void record(const physics_model *m)
{
    ad_tape *tape = ad_tape_create();
    domain_place at = {.tape = tape, .over = &m->domain};
    ad_value fields[MODEL_FIELDS_MAX];
    fuzz_require(tape != NULL);
    for (int i = 0; i < m->domain.count; i++) {
        at.x[i] = ad_input(tape, m->domain.coordinates[i].name, 1);
    }
    at.data = ad_input(tape, "data", 1);
    at.unknowns = ad_input(tape, "unknowns", MODEL_UNKNOWNS_MAX);
    for (int i = 0; i < m->field_count; i++) {
        fields[i] = ad_sin(at.x[i % m->domain.count]);
    }
    for (int i = 0; i < m->term_count; i++) {
        const ad_value value = m->terms[i].residual(m->terms[i].context, &at, fields);
        fuzz_require(ad_rows(value) == 1);
    }
    ad_tape_free(tape);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    char *text = fuzz_text(bytes, size);
    ad_error error = {AD_OK, ""};
    config_equations *c;
    if (config_equations_read("fuzz.yaml", text, 0, NULL, &c, &error) == AD_OK) {
        record(c->model);
        config_equations_free(c);
    } else {
        fuzz_refused(&error);
    }
    free(text);
    return 0;
}
