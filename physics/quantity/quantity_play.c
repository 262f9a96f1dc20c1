/* Plays and lags: formulas with a memory, of which each has an open name for its state. */
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

static quantity next_of(quantity x, quantity r, quantity before)
{
    const quantity inner[2] = {quantity_add(x, r), before};
    const quantity outer[2] = {quantity_subtract(x, r), quantity_call("min", inner)};
    return quantity_call("max", outer);
}

/* The state stays where x has been, that of a play also at 0, where it begins. */
static quantity create(quantities *names, bool lags, quantity x, quantity constant)
{
    quantity_plays *all = quantities_memory(names);
    quantity_play made = {.lags = lags, .input = x, .constant = constant};
    ad_error error;
    if (all->count == QUANTITY_PLAYS_MAX) {
        return quantity_error(names, AD_BAD_INPUT,
                              "too many different plays and lags; allowed: 16");
    }
    snprintf(made.name, sizeof made.name, "%s.state%d", lags ? "lag" : "play", all->count + 1);
    const quantity_interval at = {0, 0}, range = quantity_range(x, at, at);
    made.low = lags ? range.low : fmin(0, range.low);
    made.high = lags ? range.high : fmax(0, range.high);
    const ad_status status = quantities_parameter(
        names, made.name, made.low, made.high,
        lags && isfinite(range.low + range.high) ? quantity_middle(range) : 0, &error);
    if (status != AD_OK) {
        return quantity_error(names, status, error.message);
    }
    const quantity state = quantities_find(names, made.name, strlen(made.name));
    made.next = lags ? x : next_of(x, constant, state);
    all->play[all->count++] = made;
    return state;
}

quantity quantity_memory_call(quantities *names, bool lags, quantity x, quantity constant)
{
    const quantity_plays *all = quantities_memory(names);
    double number;
    const bool fixed = quantity_is_number(constant, &number);
    if (fixed && !(lags ? number > 0 : number >= 0)) {
        return quantity_error(names, AD_BAD_INPUT,
                              lags ? "the time of lag is not positive; allowed: > 0"
                                   : "the threshold of play is negative; allowed: >= 0");
    }
    if (quantity_is_number(x, NULL) && (lags || fixed)) {
        return lags ? x : next_of(x, constant, quantity_number(0));
    }
    for (int i = 0; i < all->count; i++) {
        const quantity_play *play = &all->play[i];
        if (play->lags == lags && is_same(play->input, x) && is_same(play->constant, constant)) {
            return quantities_find(names, play->name, strlen(play->name));
        }
    }
    return create(names, lags, x, constant);
}
