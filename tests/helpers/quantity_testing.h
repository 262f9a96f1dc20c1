/* For tests: quantities of numbers and of texts, whose names live as long as the process. */
#ifndef TESTS_QUANTITY_TESTING_H
#define TESTS_QUANTITY_TESTING_H

#include "physics/quantity/quantity.h"

static inline quantity quantity_of_text(const char *text)
{
    static quantities *names;
    names = names ? names : quantities_create();
    return quantity_formula(names, text);
}

static inline quantity quantity_of_nothing(const void *nothing)
{
    (void)nothing;
    return (quantity){.is_given = false};
}

/* The quantity of a number, or of a formula; NULL: not given. */
#define Q(x)                                                                                       \
    _Generic((x), char * : quantity_of_text, const char * : quantity_of_text, void *               \
             : quantity_of_nothing, default                                                        \
             : quantity_number)(x)

static inline void set_quantities(quantity *to, int count, const char *const *texts)
{
    for (int i = 0; i < count; i++) {
        to[i] = quantity_of_text(texts[i]);
    }
}

static inline void set_numbers(quantity *to, int count, const double *numbers)
{
    for (int i = 0; i < count; i++) {
        to[i] = quantity_number(numbers[i]);
    }
}

#endif
