/* Plays: formulas with a memory, of which each has an open name for what it was before. */
#include "physics/quantity/quantity_internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

void quantities_know_plays(quantities *names, bool known)
{
    quantities_memory(names)->known = known;
}

const quantity_play *quantities_plays(quantities *names, int *count)
{
    const quantity_plays *all = quantities_memory(names);
    *count = all->count;
    return all->play;
}

static bool is_same(quantity a, quantity b)
{
    return a.node == b.node && (a.node || a.number == b.number);
}

static quantity value_of(quantity x, quantity r, quantity before)
{
    const quantity inner[2] = {quantity_add(x, r), before};
    const quantity outer[2] = {quantity_subtract(x, r), quantity_call("min", inner)};
    return quantity_call("max", outer);
}

/* The state stays where x has been, and 0, where it begins. */
static quantity create(quantities *names, quantity x, quantity r)
{
    quantity_plays *all = quantities_memory(names);
    quantity_play made = {.input = x, .threshold = r};
    ad_error error;
    if (all->count == QUANTITY_PLAYS_MAX) {
        return quantity_error(names, AD_BAD_INPUT, "too many different plays; allowed: 16");
    }
    snprintf(made.before, sizeof made.before, "play.before%d", all->count + 1);
    const quantity_interval at = {0, 0}, range = quantity_range(x, at, at);
    made.low = fmin(0, range.low);
    made.high = fmax(0, range.high);
    const ad_status status =
        quantities_parameter(names, made.before, made.low, made.high, 0, &error);
    if (status != AD_OK) {
        return quantity_error(names, status, error.message);
    }
    made.value = value_of(x, r, quantities_find(names, made.before, strlen(made.before)));
    all->play[all->count++] = made;
    return made.value;
}

quantity quantity_play_call(quantities *names, quantity x, quantity r)
{
    const quantity_plays *all = quantities_memory(names);
    double threshold;
    if (quantity_is_number(r, &threshold) && !(threshold >= 0)) {
        return quantity_error(names, AD_BAD_INPUT,
                              "the threshold of play is negative; allowed: >= 0");
    }
    if (quantity_is_number(x, NULL) && quantity_is_number(r, NULL)) {
        return value_of(x, r, quantity_number(0));
    }
    for (int i = 0; i < all->count; i++) {
        if (is_same(all->play[i].input, x) && is_same(all->play[i].threshold, r)) {
            return all->play[i].value;
        }
    }
    return create(names, x, r);
}
