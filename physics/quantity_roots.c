/* Where formulas change their sign: bisection that discards what an enclosure keeps from 0. */
#include "physics/quantity.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Halvings of the interval; pieces at a time; values of the other coordinate to look at. */
enum { LEVELS = 44, PIECES_MAX = 1024, OTHERS = 5 };

/* Of a bound of rounding: what stays below is noise, whose signs mean nothing. */
static const double NOISE = 8;

typedef struct pieces {
    int count;
    quantity_interval all[PIECES_MAX];
} pieces;

typedef struct search {
    quantity q;
    bool along_s;
    quantity_interval other;
    int count, max; /* of places; -1: too many */
    double *places;
    pieces last; /* that cannot be halved any more */
} search;

static quantity_enclosure over(const search *x, quantity_interval piece)
{
    return x->along_s ? quantity_enclose(x->q, "s", piece, x->other)
                      : quantity_enclose(x->q, "t", x->other, piece);
}

static double value_at(const search *x, double place, double other)
{
    return x->along_s ? quantity_value(x->q, place, other) : quantity_value(x->q, other, place);
}

static void add_place(search *x, double place)
{
    if (x->count == x->max) {
        x->count = -1;
    } else if (x->count >= 0) {
        x->places[x->count++] = place;
    }
}

static void add_piece(search *x, pieces *to, quantity_interval piece)
{
    if (to->count == PIECES_MAX) {
        x->count = -1;
    } else {
        to->all[to->count++] = piece;
    }
}

/* Whether the sign differs between the ends; then adds the place, of two neighbouring numbers that
 * with the smaller value. */
static bool bisect(search *x, quantity_interval piece, double other)
{
    double low = piece.low, high = piece.high;
    bool before = value_at(x, low, other) > 0;
    if ((value_at(x, high, other) > 0) == before) {
        return false;
    }
    for (double middle = quantity_middle(piece); low < middle && middle < high;
         middle = low + (high - low) / 2) {
        bool same = (value_at(x, middle, other) > 0) == before;
        low = same ? middle : low;
        high = same ? high : middle;
    }
    bool lower = fabs(value_at(x, low, other)) <= fabs(value_at(x, high, other));
    add_place(x, lower ? low : high);
    return true;
}

/* What is left of a piece goes to `next`, in halves. */
static void look_at(search *x, quantity_interval piece, bool is_last, pieces *next)
{
    quantity_enclosure q = over(x, piece);
    double size = fmax(fabs(q.value.low), fabs(q.value.high)), middle = quantity_middle(piece);
    bool at_one = x->other.low == x->other.high;
    bool noise = q.rounding < INFINITY && size <= NOISE * q.rounding;
    if (q.value.low > 0 || q.value.high <= 0) {
        return;
    }
    if (at_one && (q.slope.low > 0 || q.slope.high < 0)) {
        bisect(x, piece, x->other.low);
    } else if (is_last || noise) {
        add_piece(x, &x->last, piece);
    } else {
        add_piece(x, next, (quantity_interval){piece.low, middle});
        add_piece(x, next, (quantity_interval){middle, piece.high});
    }
}

static int ascending(const void *a, const void *b)
{
    double p = ((const quantity_interval *)a)->low, q = ((const quantity_interval *)b)->low;
    return (p > q) - (p < q);
}

/* Pieces that touch are one. Over a stretch of the other coordinate there may be a zero where no
 * sign that is looked at changes. */
static void settle(search *x)
{
    pieces *last = &x->last;
    qsort(last->all, (size_t)last->count, sizeof *last->all, ascending);
    for (int i = 0, end; i < last->count; i = end) {
        quantity_interval piece = last->all[i];
        bool found = false, at_one = x->other.low == x->other.high;
        for (end = i + 1; end < last->count && last->all[end].low <= piece.high; end++) {
            piece.high = fmax(piece.high, last->all[end].high);
        }
        for (int k = 0; k < OTHERS && !found; k++) {
            double share = (double)k / (OTHERS - 1);
            found = bisect(x, piece, (1 - share) * x->other.low + share * x->other.high);
        }
        if (!found && !at_one) {
            add_place(x, quantity_middle(piece));
        }
    }
}

static void find(search *x, quantity_interval whole, pieces *now, pieces *next)
{
    now->all[0] = whole;
    now->count = 1;
    for (int level = 0; level <= LEVELS && x->count >= 0 && now->count > 0; level++) {
        next->count = 0;
        for (int i = 0; i < now->count && x->count >= 0; i++) {
            look_at(x, now->all[i], level == LEVELS, next);
        }
        pieces *swap = now;
        now = next;
        next = swap;
    }
    if (x->count >= 0) {
        settle(x);
    }
}

int quantity_sign_changes(quantity q, const char *coordinate, quantity_interval s,
                          quantity_interval t, int max, double *places)
{
    pieces now, next;
    search x = {.q = q, .along_s = strcmp(coordinate, "s") == 0, .max = max, .places = places};
    quantity_interval whole = x.along_s ? s : t;
    bool depends = quantity_depends_on(q, coordinate);
    x.other = x.along_s ? t : s;
    if (!quantity_depends_on(q, x.along_s ? "t" : "s")) {
        x.other.high = x.other.low;
    }
    if (depends) {
        find(&x, whole, &now, &next);
    }
    return x.count;
}
