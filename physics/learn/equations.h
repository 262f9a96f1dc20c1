/* Equations of one's own as text: names, formulas and data, of which a model is made (model.h).
 *
 *   equations_add_coordinate(e, &(equations_coordinate){"x", "", -1, 1}, &error);
 *   equations_add_coordinate(e, &(equations_coordinate){.name = "t", .high = 1, .time = true},
 * ...); equations_add_parameter(e, "nu", "0.01/pi", &error); equations_add_field(e, "u", &error);
 *   equations_add_inside(e, "u_t + u*u_x - nu*u_xx", &error);
 *   equations_add_condition(e, "t", 0, "u", "-sin(pi*x)", &error);
 *   equations_add_condition(e, "x", -1, "u", "0", &error);
 *   equations_add_condition(e, "x", 1, "u", "0", &error);
 *   equations_model(e, &model, &error);
 *
 * Formulas are those of physics/quantity/quantity.h. What they name has to be there before them:
 * coordinates, parameters, unknowns and fields. Derivatives of fields are named by what they are
 * differentiated by, behind an underscore: u_t, u_xx, u_xxt, and u_theta_theta where names have
 * several letters. So are those of parameters that are formulas, as F_x of a flux F. All are in
 * units of the SI, which the model has on its tape, too: its coordinates have the scale 1.
 *
 * Texts and numbers are copied. Every function but these says what is wrong with what it is given,
 * and what is allowed: AD_BAD_INPUT, AD_NO_MEMORY. */
#ifndef PHYSICS_LEARN_EQUATIONS_H
#define PHYSICS_LEARN_EQUATIONS_H

#include "physics/learn/model.h"
#include "physics/quantity/quantity.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { EQUATIONS_ORDER_MAX = 6 }; /* of derivatives, all coordinates together */

typedef struct equations equations;

/* NULL when memory runs out; NULL may be freed. */
equations *equations_create(void);
void equations_free(equations *e);

typedef struct equations_coordinate {
    const char *name, *unit; /* NULL: no unit */
    double low, high;
    bool periodic, time; /* not both; one coordinate may be time */
} equations_coordinate;

ad_status equations_add_coordinate(equations *e, const equations_coordinate *c, ad_error *error);

/* A name for a number or a formula; for an unknown number, which data determine from a guess on.
 * One within a range is one more coordinate: the model is solved for all of it. */
ad_status equations_add_parameter(equations *e, const char *name, const char *formula,
                                  ad_error *error);
ad_status equations_add_unknown(equations *e, const char *name, double guess, ad_error *error);
ad_status equations_add_range(equations *e, const char *name, double low, double high,
                              ad_error *error);

ad_status equations_add_field(equations *e, const char *name, ad_error *error);

/* What is zero inside. */
ad_status equations_add_inside(equations *e, const char *formula, ad_error *error);

/* What is on the face where a coordinate is at its low or high end, `at`: of a field, "u", or of a
 * derivative of it by this coordinate, "u_x". With "zero" it is any formula that is zero there. */
ad_status equations_add_condition(equations *e, const char *coordinate, double at, const char *what,
                                  const char *formula, ad_error *error);

/* Measured numbers: columns [count][rows] that are named, all coordinates and one field at least
 * or a derivative of one. NaN of a field: not measured there. noise: standard deviation of the
 * fields. Columns error_u of fields u, which tables of solutions have, are left out. noise 0: not
 * known, residuals are in units of the root of the mean square of their column. */
ad_status equations_add_data(equations *e, size_t rows, int count, const char *const *names,
                             const double *const *columns, double noise, ad_error *error);

/* What a formula of numbers and parameters is. */
ad_status equations_number(equations *e, const char *formula, double *value, ad_error *error);

/* The model of them, which lives as long; nothing can be added from here on. What is missing, or
 * more than fits, is AD_BAD_INPUT. */
ad_status equations_model(equations *e, const physics_model **model, ad_error *error);

/* The model as far as it is: coordinates, fields and unknowns, of a solution that is read again. */
const physics_model *equations_so_far(const equations *e);

/* Whether a coordinate of the model is a parameter with a range. */
bool equations_is_range(const equations *e, int coordinate);

/* What is asked of a solution: the row of its field and the order by each coordinate of the model,
 * of "u", "u_xt". */
ad_status equations_find(const equations *e, const char *name, int *field,
                         int orders[DOMAIN_COORDINATES_MAX], ad_error *error);

#ifdef __cplusplus
}
#endif

#endif
