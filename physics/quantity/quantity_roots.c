/* Where formulas change their sign: bisection that discards what an enclosure keeps from 0. */
#include "physics/quantity/quantity.h"

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

static quantity_enclosure over(const search *search, quantity_interval piece)
{
    return search->along_s ? quantity_enclose(search->q, "s", piece, search->other)
                           : quantity_enclose(search->q, "t", search->other, piece);
}

static double value_at(const search *search, double place, double other)
{
    return search->along_s ? quantity_value(search->q, place, other)
                           : quantity_value(search->q, other, place);
}

static void add_place(search *search, double place)
{
    if (search->count == search->max) {
        search->count = -1;
    } else if (search->count >= 0) {
        search->places[search->count++] = place;
    }
}

static void add_piece(search *search, pieces *to, quantity_interval piece)
{
    if (to->count == PIECES_MAX) {
        search->count = -1;
    } else {
        to->all[to->count++] = piece;
    }
}

/* Whether the sign differs between the ends; then adds the place, of two neighbouring numbers that
 * with the smaller value. */
static bool bisect(search *search, quantity_interval piece, double other)
{
    double low = piece.low, high = piece.high;
    bool before = value_at(search, low, other) > 0;
    if ((value_at(search, high, other) > 0) == before) {
        return false;
    }
    for (double middle = quantity_middle(piece); low < middle && middle < high;
         middle = low + (high - low) / 2) {
        bool same = (value_at(search, middle, other) > 0) == before;
        low = same ? middle : low;
        high = same ? high : middle;
    }
    bool lower = fabs(value_at(search, low, other)) <= fabs(value_at(search, high, other));
    add_place(search, lower ? low : high);
    return true;
}

/* What is left of a piece goes to `next`, in halves. */
static void look_at(search *search, quantity_interval piece, bool is_last, pieces *next)
{
    quantity_enclosure q = over(search, piece);
    double size = fmax(fabs(q.value.low), fabs(q.value.high)), middle = quantity_middle(piece);
    bool at_one = search->other.low == search->other.high;
    bool noise = q.rounding < INFINITY && size <= NOISE * q.rounding;
    if (q.value.low > 0 || q.value.high <= 0) {
        return;
    }
    if (at_one && (q.slope.low > 0 || q.slope.high < 0)) {
        bisect(search, piece, search->other.low);
    } else if (is_last || noise) {
        add_piece(search, &search->last, piece);
    } else {
        add_piece(search, next, (quantity_interval){piece.low, middle});
        add_piece(search, next, (quantity_interval){middle, piece.high});
    }
}

static int ascending(const void *a, const void *b)
{
    double p = ((const quantity_interval *)a)->low, q = ((const quantity_interval *)b)->low;
    return (p > q) - (p < q);
}

/* Pieces that touch are one. Over a stretch of the other coordinate there may be a zero where no
 * sign that is looked at changes. */
static void settle(search *search)
{
    pieces *last = &search->last;
    qsort(last->all, (size_t)last->count, sizeof *last->all, ascending);
    for (int i = 0, end; i < last->count; i = end) {
        quantity_interval piece = last->all[i];
        bool found = false, at_one = search->other.low == search->other.high;
        for (end = i + 1; end < last->count && last->all[end].low <= piece.high; end++) {
            piece.high = fmax(piece.high, last->all[end].high);
        }
        for (int k = 0; k < OTHERS && !found; k++) {
            double share = (double)k / (OTHERS - 1);
            found =
                bisect(search, piece, (1 - share) * search->other.low + share * search->other.high);
        }
        if (!found && !at_one) {
            add_place(search, quantity_middle(piece));
        }
    }
}

static void find(search *search, quantity_interval whole, pieces *now, pieces *next)
{
    now->all[0] = whole;
    now->count = 1;
    for (int level = 0; level <= LEVELS && search->count >= 0 && now->count > 0; level++) {
        next->count = 0;
        for (int i = 0; i < now->count && search->count >= 0; i++) {
            look_at(search, now->all[i], level == LEVELS, next);
        }
        pieces *swap = now;
        now = next;
        next = swap;
    }
    if (search->count >= 0) {
        settle(search);
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
