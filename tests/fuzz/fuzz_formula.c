/* A formula: parsed, its value within its enclosure, and written and read back to the same value.
 */
#include "physics/quantity/quantity.h"
#include "tests/fuzz/fuzz.h"

static void check(quantities *names, quantity q)
{
    static const double places[][2] = {{0, 0}, {1, 1}, {0.3, 0.7}, {0.5, 0.125}};
    const quantity_interval whole = {0, 1};
    const quantity_enclosure bound = quantity_enclose(q, "s", whole, whole);
    char *text = quantity_text(q, false);
    fuzz_require(text);
    const quantity again = quantity_formula(names, text);
    ad_error error = {AD_OK, ""};
    if (quantity_check(again, &error) != AD_OK) { /* it has parentheses where signs stood */
        fuzz_require(strstr(error.message, "nested more than"));
        free(text);
        return;
    }
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        const double s = places[i][0], t = places[i][1], value = quantity_value(q, s, t);
        const double same = quantity_value(again, s, t);
        fuzz_require(value != value ? same != same : memcmp(&value, &same, sizeof value) == 0);
        fuzz_require(!(value < bound.value.low - bound.rounding) &&
                     !(value > bound.value.high + bound.rounding));
    }
    free(text);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    ad_error error = {AD_OK, ""};
    quantities *names = quantities_create();
    char *text = fuzz_text(bytes, size);
    fuzz_require(names && quantities_define(names, "load", quantity_number(0.02), &error) == AD_OK);
    const quantity q = quantity_formula(names, text);
    if (quantity_check(q, &error) == AD_OK) {
        check(names, q);
    } else {
        fuzz_refused(&error);
    }
    quantities_free(names);
    free(text);
    return 0;
}
