/* Formulas over shapes, with their derivatives: what an optimisation makes small and what it
 * keeps.
 *
 *   (tip.x-0.1)^2 + tip.y^2      at places of the rod: tip is its end, others have names
 *   max(curvature)               over all of the rod; min, mean likewise
 *
 * A formula knows all that those of a scene know (physics/quantity/quantity.h), the parameters of
 * the scene, the columns of cases and, at a place or along the rod,
 *   x y z          position, m                     qw qx qy qz   rotation, unit quaternion
 *   v1 v2 v3       stretch and shear, 1 at rest    u1 u2 u3      curvature and twist, 1/m
 *   tx ty tz       direction of the section's axis d3
 *   curvature      sqrt(u1^2 + u2^2), 1/m          shear         sqrt(v1^2 + v2^2)
 *   n1 .. m3       force and moment, body, N, N m; energy_density J/m and strain likewise as in
 *                  physics/rod/rod_section.h
 *   clearance      of the centre line from a surface, m, less a radius
 *
 * in motion also
 *   vx vy vz       velocity, world, m/s            w1 w2 w3      angular velocity, body, 1/s
 *   speed          sqrt(vx^2 + vy^2 + vz^2)
 * but not n1 .. m3, and of all of the rod its elastic energy, J: its density integrated; at rest
 * its stability margin, `stability` (physics/chain/solve_members.h). min(stability) is it with the
 * next that bounds it, without the kink where the two are the same. What the shape is where
 * something jumps is that before. */
#ifndef TOOLS_OPTIMIZE_RESPONSE_H
#define TOOLS_OPTIMIZE_RESPONSE_H

#include "physics/chain/solve_members.h"
#include "physics/learn/model.h"
#include "tools/environment/environment.h"

/* Of shapes in motion: behind those of shapes at rest velocity and angular velocity. */
enum { RESPONSE_MOTION_COLUMNS = SOLVE_MEMBERS_COLUMNS + 6 };

/* How the values along the rod become one. */
typedef enum response_kind {
    RESPONSE_AT_PLACES,
    RESPONSE_MAX,
    RESPONSE_MIN,
    RESPONSE_MEAN
} response_kind;

typedef struct response_scope {
    const scene *family;             /* whose columns shapes have, the first */
    int parameters, columns, places; /* numbers of names, which are borrowed */
    const char *const *parameter;    /* of the scene, and others behind them */
    const char *const *column;       /* of the cases */
    const char *const *place;        /* "tip" */
    const double *at;                /* [places] m, where they are */
    const double *s;                 /* [points] of shapes, ascending, m */
    const environment *around;       /* of clearances; NULL: there are none */
    double radius;
    bool moves; /* of shapes in motion */
    int more;   /* directions of derivatives behind those of parameters */
} response_scope;

/* A shape with its derivatives; borrowed. */
typedef struct response_shape {
    size_t points;
    const size_t *place;      /* [places], which point each is */
    const double *values;     /* [points][SOLVE_MEMBERS_COLUMNS or RESPONSE_MOTION_COLUMNS] */
    const double *jacobian;   /* [points][columns][parameters + more] */
    const double *parameters; /* [parameters] */
    const double *columns;    /* [columns] */
    const double *margin;     /* [SOLVE_MARGINS] and */
    const double *by_margin;  /* [][parameters], of formulas that need stability */
} response_shape;

typedef struct response response;

/* The formula of what is to be large: min(stability) in place of the stability alone. */
const char *response_raised(const char *text);

/* AD_BAD_INPUT: what is wrong with the formula; AD_NO_MEMORY. For shapes of that many points. */
ad_status response_create(const char *text, const response_scope *scope, size_t points,
                          response **result, ad_error *error);
void response_free(response *r);

response_kind response_kind_of(const response *r);

/* Whether the formula has the shape, or one of the first parameters other than `which`. */
bool response_needs_shape(const response *r);
bool response_needs_stability(const response *r);
bool response_needs_parameter(const response *r, int which);

/* One value, or of max and min as many as there are points, each with its derivatives by all
 * parameters and by what is more: values [rows], by [rows][parameters + more], which may be NULL.
 * Does not allocate. */
size_t response_rows(const response *r);
ad_status response_evaluate(const response *r, const response_shape *shape, double *values,
                            double *by, ad_error *error);

/* weights [points] of the mean over 0 to 1 of what is known at points s, ascending, with so many
 * places `at` between them where it jumps: what is at such a place is that before. A piece without
 * a point has the value of the nearest. They are added to; kept [points] is room. */
void response_weights(size_t points, const double *s, int breaks, const double *at, size_t *kept,
                      double *weights);

#endif
