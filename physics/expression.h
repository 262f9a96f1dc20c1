/* Formulas of s and t: `0.02*sin(2*pi*t)`, recorded on the tape and so differentiated like
 * everything else.
 *
 *   numbers  1  2.5e-3        constants  pi
 *   variables  s (arc length, m)  t (time, s)
 *   operators  + - * / ^ ( )   (^ binds to the right and before unary minus; its exponent is
 *              constant)
 *   functions  sin cos tan asin acos atan atan2(y,x) sinh cosh tanh exp log sqrt abs
 *              min(a,b) max(a,b) step(x): 0 for x <= 0, else 1
 *              where(c, a, b): a where c > 0, else b */
#ifndef PHYSICS_EXPRESSION_H
#define PHYSICS_EXPRESSION_H

#include "autodiff/ad.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct expression_use {
    bool s;
    bool t;
} expression_use;

/* Parse without recording: AD_OK, or AD_BAD_INPUT with a message that names the column within the
 * text and what is allowed there. `use` (may be NULL): which variables occur. */
ad_status expression_check(const char *text, expression_use *use, ad_error *error);

/* The number at s (m) and t (s) of a text that passes expression_check; NaN when not finite. */
double expression_evaluate(const char *text, double s, double t);

/* Whether a text uses neither s nor t, and then its value; false for NULL and for a text that does
 * not parse. */
bool expression_is_number(const char *text, double *value);

/* Record on the tape of s and t (scalars, SI). A text that does not parse leaves its error on the
 * tape. */
ad_value expression_record(const char *text, ad_value s, ad_value t);

#ifdef __cplusplus
}
#endif

#endif
