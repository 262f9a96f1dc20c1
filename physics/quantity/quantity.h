/* Numbers of a scene: a plain number, or a formula such as `0.02*sin(2*pi*t)` that is parsed once.
 *
 *   s.rod.length = quantity_number(0.3);
 *   quantities_define(names, "load", quantity_number(0.02), &error);
 *   s.loads.tip.force[2] = quantity_formula(names, "-load*where(0.5-t, sin(pi*t)^2, 1)");
 *
 * A formula knows
 *   numbers  1  2.5e-3        constants  pi        whatever the locale of the program
 *   names      the coordinates s (arc length, m) and t (time, s), and those that are defined
 *   operators  + - * / ^ ( )   (^ binds to the right and before unary minus; its exponent is
 *              constant)
 *   functions  sin cos tan asin acos atan atan2(y,x) sinh cosh tanh exp log sqrt abs
 *              min(a,b) max(a,b) step(x): 0 for x <= 0, else 1
 *              where(c, a, b): a where c > 0, else b
 *              within(x, a, b): x, which is not a number where it is not in [a, b]
 *              play(x, r), lag(x, tau): x with the memory of quantity_play, where names know it
 *              and those that are defined by tables
 *
 * A quantity is a small value that is copied freely. A plain number needs no memory, so that what
 * follows from numbers is computed as fast as with numbers alone. The nodes of formulas never
 * change; they belong to the `quantities` whose names they were read with, and live as long. The
 * same formula made twice is one node. A zeroed quantity is not given, and whatever is computed
 * from one that is not given is not given either.
 *
 * A name plays a role. A defined name is a fixed number or formula and folds away while parsing. A
 * coordinate stays open: quantity_value puts numbers in its place, quantity_record what the
 * bindings say, an input of the tape, a uniform, a parameter or a number. A role that is new needs
 * another binding and nothing else.
 *
 * Errors stay with the quantity: one that cannot be parsed says so in quantity_check, whatever is
 * computed from it is the same error, its value is NaN, and its record fails on the tape. Any
 * number of threads may use quantities of one `quantities` at a time, but for defining names. */
#ifndef PHYSICS_QUANTITY_QUANTITY_H
#define PHYSICS_QUANTITY_QUANTITY_H

#include "autodiff/ad.h"

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct quantities quantities;

typedef struct quantity {
    double number;                    /* its value where it depends on no coordinate */
    const struct quantity_node *node; /* of a formula; NULL: a number */
    bool is_given;
} quantity;

/* NULL when memory runs out. */
quantities *quantities_create(void);

/* The same without s and t, for formulas that are checked and recorded and nothing else. */
quantities *quantities_create_open(void);
void quantities_free(quantities *names);

/* Define a name for the formulas parsed from here on; its value may be a formula of s and t. The
 * name: letters, digits, _, up to 40, and not one that formulas know already. */
ad_status quantities_define(quantities *names, const char *name, quantity value, ad_error *error);

/* Whether a formula that was parsed has used the name. */
bool quantities_used(const quantities *names, const char *name);

/* Add another open name beside s and t, a coordinate of a domain; it may have points, "tip.x". */
enum { QUANTITY_OPEN_MAX = 64 }; /* with these two */
ad_status quantities_coordinate(quantities *names, const char *name, ad_error *error);

/* The same of one within a range, of which `usual` stands for it where one number is asked for
 * (quantity_value); enclosures hold over all of the range. */
ad_status quantities_parameter(quantities *names, const char *name, double low, double high,
                               double usual, ad_error *error);

/* Define a function of one argument by a table: name(x) goes through all (x[i], y[i]), i < count,
 * x ascending, 2 to QUANTITY_TABLE_MAX of them. It is a cubic between each two, with a continuous
 * slope and without overshoot: it rises and falls where the numbers do (Fritsch, Carlson, SIAM J.
 * Numer. Anal. 17, 1980). Beyond the first and the last x it is not a number. Both are copied. */
enum { QUANTITY_TABLE_MAX = 200 };

ad_status quantities_define_table(quantities *names, const char *name, int count, const double *x,
                                  const double *y, ad_error *error);

/* ---- memory ---------------------------------------------------------------------------------- */

/* What an input does that has a memory. A play of threshold r is a state that follows x within r,
 * as a drive of backlash 2 r does (Krasnosel'skii, Pokrovskii, Systems with Hysteresis, 1989;
 * Visintin, Differential Models of Hysteresis, 1994). A lag of first order is that of a motor, or
 * of a chamber that fills:
 *
 *   play: z = max(x - r, min(x + r, z before)), from 0 on;   lag: tau z' = x - z, from x on
 *
 * `name` is the open name of z in formulas. Each pair of x and r, or tau, in the formulas of
 * `names` is one; who evaluates them says z (physics/scene/scene_memory.h). */
typedef struct quantity_play {
    char name[32];
    bool lags;
    quantity input, constant; /* x; r or tau */
    quantity next;            /* z of a play by x, r, and z before under its name */
    double low, high;         /* where z stays while x is that of t = 0; may be infinite */
} quantity_play;

enum { QUANTITY_PLAYS_MAX = 16 };

/* Whether formulas that are read from here on may have them. */
void quantities_know_plays(quantities *names, bool known);

/* [*count], in the order in which their arguments were read, those within others first. */
const quantity_play *quantities_plays(quantities *names, int *count);

/* ---- making ---------------------------------------------------------------------------------- */

static inline quantity quantity_number(double number)
{
    quantity made = {number, NULL, true};
    return made;
}

/* NULL text: not given. The text is kept, to be written again as it was. */
quantity quantity_formula(quantities *names, const char *text);

/* A formula to be parsed later by quantity_parsed, when all names are defined. Until then it counts
 * as an error. quantity_parsed returns what is no such formula as it is. */
quantity quantity_unparsed(quantities *names, const char *text);
quantity quantity_parsed(quantity q);

/* Constants fold, in the order in which they are written here. */
quantity quantity_add(quantity a, quantity b);
quantity quantity_subtract(quantity a, quantity b);
quantity quantity_multiply(quantity a, quantity b);
quantity quantity_divide(quantity a, quantity b);
quantity quantity_power(quantity a, double exponent);

/* A function of formulas by its name, with as many arguments as it takes. */
quantity quantity_call(const char *function, const quantity *arguments);

static inline quantity quantity_scale(quantity a, double factor)
{
    return quantity_multiply(a, quantity_number(factor));
}

static inline quantity quantity_or(quantity a, quantity otherwise)
{
    return a.is_given ? a : otherwise;
}

/* Of what is one number. */
static inline double quantity_number_or(quantity a, double otherwise)
{
    return a.is_given ? a.number : otherwise;
}

/* With numbers in place of open names: values [count] of names [count], of which each is an open
 * name of its `quantities` or occurs nowhere. */
quantity quantity_with(quantity q, int count, const char *const *names, const double *values);

/* With a formula in place of one, and that as text as it was written. */
quantity quantity_put(quantity q, const char *name, quantity value);
quantity quantity_put_unseen(quantity q, const char *name, quantity value);

/* ---- asking ---------------------------------------------------------------------------------- */

/* AD_OK, also of what is not given; else what is wrong with the formula: AD_BAD_INPUT with the
 * column within its text and what is allowed there, AD_NO_MEMORY. */
ad_status quantity_check(quantity q, ad_error *error);

/* Whether it is given and depends on no coordinate; then its value (may be NULL). */
bool quantity_is_number(quantity q, double *value);

/* Whether it is given and is that number for all s and t. */
bool quantity_is(quantity q, double number);

/* Whether it is given and not the number 0. */
bool quantity_is_something(quantity q);

/* The same of `count` quantities, of any. */
bool quantity_any_given(int count, const quantity *q);
bool quantity_any_something(int count, const quantity *q);

bool quantity_depends_on(quantity q, const char *coordinate);
bool quantity_any_depends_on(int count, const quantity *q, const char *coordinate);

/* Whether it calls a function, as "within", by which tables bound their argument. */
bool quantity_calls(quantity q, const char *function);

/* Its value at s (m), t (s), of other open names the usual one; NaN when it is not given. Does not
 * allocate. */
double quantity_value(quantity q, double s, double t);

/* The same with values [count] of open names [count]. */
double quantity_value_with(quantity q, double s, double t, int count, const char *const *names,
                           const double *values);

/* The same many times: the index of an open name, s has 0 and t 1 (-1: there is none), and the
 * value for x [count] of those names by their indices. */
int quantities_index(const quantities *names, const char *name);
double quantity_value_at(quantity q, int count, const double *x);

/* Its derivative there along a direction [count], exact but for rounding; where it has a kink, the
 * mean of both sides. */
double quantity_slope_at(quantity q, int count, const double *x, const double *direction);

/* ---- enclosures ------------------------------------------------------------------------------ */

/* All numbers from low to high; the whole line, -infinity to infinity, says nothing and holds
 * what is not a number, too. */
typedef struct quantity_interval {
    double low, high;
} quantity_interval;

static inline double quantity_middle(quantity_interval x)
{
    return x.low + (x.high - x.low) / 2;
}

typedef struct quantity_enclosure {
    quantity_interval value;
    quantity_interval slope; /* by the coordinate; the whole line where it may jump */
    double rounding;         /* no value is further than this from its exact one */
} quantity_enclosure;

/* Encloses what quantity_value gives at all s and t of two intervals, by interval arithmetic
 * (Moore, Kearfott, Cloud, Introduction to Interval Analysis, 2009, ch. 5, 6): exact but for what
 * appears in a formula more than once, and the narrower the intervals the closer. */
quantity_interval quantity_range(quantity q, quantity_interval s, quantity_interval t);

/* Encloses its values at one s and t over the ranges of its parameters; without parameters, or
 * where no finite interval does, the value alone. */
quantity_interval quantity_span(quantity q, double s, double t);

static inline double quantity_largest(quantity q, double s, double t)
{
    const quantity_interval span = quantity_span(q, s, t);
    return span.high > -span.low ? span.high : -span.low;
}

/* The same with all slopes by a coordinate, "s" or "t", for s and t fixed in turn. Where it has a
 * kink the slope encloses those of both sides. */
quantity_enclosure quantity_enclose(quantity q, const char *coordinate, quantity_interval s,
                                    quantity_interval t);

/* The same between two places where it switches: no expression of the coordinate alone that
 * quantity_switches visits changes its sign within, so that it has that of the middle. */
quantity_enclosure quantity_enclose_between(quantity q, const char *coordinate, quantity_interval s,
                                            quantity_interval t);

/* Calls `visit` for every expression in a formula at whose change of sign it jumps or kinks:
 * conditions of where, arguments of step and abs, differences of those of min and max. So it does
 * where functions begin to be defined, as sqrt does at 0. Each is a quantity by itself, with an
 * error when memory ran out. The same one may come several times. */
typedef void quantity_visitor(quantity expression, void *context);
void quantity_switches(quantity q, quantity_visitor *visit, void *context);

/* Where its sign changes along a coordinate, between > 0 and what is not, for s and t in two
 * intervals: places [at most max], not in order, each exact to rounding. It misses none that is
 * further from another than 1e-13 of the interval. Where the other interval is no point, a place is
 * one for every value of it. Returns how many; -1 when there are more than max, or when zeros
 * cannot be told apart: a sign that changes along a curve, or a zero on a stretch. */
int quantity_sign_changes(quantity q, const char *coordinate, quantity_interval s,
                          quantity_interval t, int max, double *places);

/* ---- as text --------------------------------------------------------------------------------- */

/* As text that quantity_formula reads back to the same quantity: as its author wrote it, or from
 * its nodes, with defined names put in. The latter is the same however it was written, and may be
 * nested more deeply than quantity_formula reads. NULL when memory runs out; the caller frees
 * it. */
char *quantity_text(quantity q, bool as_written);

/* Shortest decimal text that reads back as the same number, with a point or an exponent that YAML
 * takes for a number. */
void quantity_number_text(double number, char text[32]);

/* ---- on the tape ----------------------------------------------------------------------------- */

typedef struct quantity_binding {
    const char *name; /* "s" */
    ad_value value;   /* one row: an input, a uniform, a parameter or a constant */
} quantity_binding;

/* One row; a number is a constant of the tape. An open name without a binding, a formula with an
 * error and a quantity that is not given leave an error on the tape. */
ad_value quantity_record(quantity q, ad_tape *tape, int count, const quantity_binding *bindings);

/* The same of a formula of s and t (m, s). */
ad_value quantity_record_at(quantity q, ad_value s, ad_value t);

#ifdef __cplusplus
}
#endif

#endif
