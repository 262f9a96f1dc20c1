/* A nonlinear constitutive law of the section: a potential W of the strains, learned from data,
 * whose gradient is force and moment. Source: Schommartz, Klein, Alzate Cobo and Weeger, Computer
 * Methods in Applied Mechanics and Engineering 435, 2024, 117592.
 *
 * With x = (v - v*, u - u*), six numbers in SI units, x' = x/scale and network units k,
 *
 *   N(x') = 1/2 sum_i c_i x'_i^2 + sum_k a_k log(1 + exp(b_k + w_k . f(x')))
 *   W(x)  = N(x') - N(0) - N'(0) . x'                       energy per length, N
 *   n, m  = dW/dx
 *
 * so that energy, force and moment are 0 at rest whatever the numbers are. Symmetry is exact too:
 *
 *   none     f = x'
 *   point    half a turn about d3 changes nothing: the mean of N over it and the identity
 *   mirrors  nor do the mirrors of the section across d1 and d2: the mean over all four
 *   round    no turn about d3 and no mirror does: f are invariants, with |.| of the first two
 *            components: x'_3, |v'|^2, |u'|^2, u'_3^2, |v' + J u'|^2, |v' - J u'|^2, u'_3 v'.u'
 *            with J a quarter of a turn; both strains across have one scale each
 *
 * W is convex where all a_k >= 0 and, if round, all w_k >= 0 but the first, with the last 0: each f
 * but that is then linear or convex. */
#ifndef PHYSICS_SCENE_SCENE_LAW_H
#define PHYSICS_SCENE_SCENE_LAW_H

#include "autodiff/ad.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SCENE_SYMMETRY_LIST(X)                                                                     \
    X(SCENE_SYMMETRY_NONE, "none")                                                                 \
    X(SCENE_SYMMETRY_POINT, "point")                                                               \
    X(SCENE_SYMMETRY_MIRRORS, "mirrors")                                                           \
    X(SCENE_SYMMETRY_ROUND, "round")
typedef enum scene_symmetry {
#define SCENE_ENUM(name, text) name,
    SCENE_SYMMETRY_LIST(SCENE_ENUM)
#undef SCENE_ENUM
} scene_symmetry;

const char *const *scene_symmetry_names(void); /* NULL at the end */

enum {
    SCENE_LAW_STRAINS = 6,
    SCENE_LAW_FEATURES = 7,
    SCENE_LAW_UNITS_MAX = 64,
    SCENE_LAW_NUMBERS_MAX = 27 + SCENE_LAW_UNITS_MAX * (2 + SCENE_LAW_FEATURES)
};

typedef struct scene_law {
    scene_symmetry symmetry;
    int units;
    double scale[SCENE_LAW_STRAINS];     /* 1, 1/m; infinite: the law does not know this strain,
                                          * which is locked */
    double quadratic[SCENE_LAW_STRAINS]; /* c, N, > 0 */
    double low[SCENE_LAW_STRAINS], high[SCENE_LAW_STRAINS];          /* of x in the data; 1, 1/m */
    double weight[SCENE_LAW_UNITS_MAX], offset[SCENE_LAW_UNITS_MAX]; /* a (N), b */
    double by[SCENE_LAW_UNITS_MAX][SCENE_LAW_FEATURES];              /* w */
    double misfit; /* of forces and moments to data that were held out, root mean square over root
                    * mean square, the largest of the six; NaN: not known */

    /* By scene_law_finish. */
    double energy, slope[SCENE_LAW_STRAINS]; /* N(0), N'(0) */
    double stiffness[SCENE_LAW_STRAINS];     /* diagonal of W'' at rest, SI; infinite: locked */
} scene_law;

/* How many features the units of a symmetry see. */
int scene_law_features(scene_symmetry symmetry);

/* A law as a list of numbers, of a file: symmetry, units, scale, quadratic, low, high, and of each
 * unit weight, offset, by[scene_law_features]; last the misfit, if it is known. */
int scene_law_count(const scene_law *law);
void scene_law_numbers(const scene_law *law, double *numbers);
void scene_law_name(const scene_law *law, int index, char name[32]); /* "unit 3 offset" */

/* Back, and finished. AD_BAD_INPUT: no such law. */
ad_status scene_law_create(int count, const double *numbers, scene_law *law, ad_error *error);

/* The law of a section that is stiffer by so much, as 1.01, with the misfit 0. */
void scene_law_stiffen(scene_law *law, double by);

/* After its numbers have changed. AD_BAD_INPUT: a stiffness at rest that is not positive. */
ad_status scene_law_finish(scene_law *law, ad_error *error);

/* W, its gradient (n, m) and, where that is not NULL, its second derivatives at strains x, SI. */
double scene_law_potential(const scene_law *law, const double *x, double stress[SCENE_LAW_STRAINS],
                           double (*tangent)[SCENE_LAW_STRAINS]);

/* How far strains x, SI, are beyond those of the data, over half of the range of these; and which,
 * from 0. What has a sign by symmetry alone counts by its size, of both strains across if round. */
double scene_law_excess(const scene_law *law, const double *x, int *which);

/* The same of W - 1/2 sum stiffness x^2: what the law is beyond the linear one. Dimensionless, with
 * the scales of a rod; u by 1/length, force in N, moment in force length. */
double scene_law_beyond(const scene_law *law, double length, double force, const double *x,
                        double stress[SCENE_LAW_STRAINS], double (*tangent)[SCENE_LAW_STRAINS]);

/* On a tape: dN/dx' [6] at x' [6], from c [6], a [units], b [units], w [features * units]. */
typedef struct scene_law_values {
    ad_value quadratic, weight, offset, by;
} scene_law_values;

ad_value scene_law_record(scene_symmetry symmetry, const scene_law_values *values, ad_value x);

/* And the stress of scene_law_beyond. */
ad_value scene_law_record_beyond(const scene_law *law, double length, double force, ad_value x);

/* And W, by the same scales. */
ad_value scene_law_record_energy(const scene_law *law, double length, double force, ad_value x);

/* The same of several places, each number a value of one row for each of them or of one for all,
 * with its derivatives by the strains as law_entry (physics/law/law.h) has them, 21. */
void scene_law_record_places(const scene_law *law, double length, double force,
                             const ad_value x[SCENE_LAW_STRAINS],
                             ad_value stress[SCENE_LAW_STRAINS], ad_value *by_strains);

#ifdef __cplusplus
}
#endif

#endif
