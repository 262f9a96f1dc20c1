/* The equilibrium from which a motion starts, as formulas of s: polynomials on pieces between the
 * places where anything of the scene jumps. */
#include "physics/numerics/constants.h"
#include "physics/scene/breaks.h"
#include "physics/solve/solve.h"

#include <math.h>
#include <stdlib.h>

/* Points of a piece; pieces are halved until the polynomials are exact between their points, too.
 */
enum { POINTS = 25, COLUMNS_MAX = 7, DEPTH_MAX = 5, PIECES_MAX = 48 };

/* A motion is solved to 1e-6 or 1e-8 of the length at best. */
static const double EXACT = 1e-9;

typedef struct pieces {
    const solution *solved;
    quantities *names;
    int columns, count;
    double size[COLUMNS_MAX];                 /* of a column: what EXACT is relative to */
    double edge[PIECES_MAX + 1];              /* m */
    quantity values[COLUMNS_MAX][PIECES_MAX]; /* [columns][count] */
} pieces;

/* ---- one piece ------------------------------------------------------------------------------- */

/* Chebyshev's points on [-2, 2], where divided differences neither grow nor vanish, in the order of
 * Leja: each the farthest from those before it, so that Newton's form is stable (Reichel, BIT 30,
 * 1990). */
static void leja_points(double *x)
{
    double all[POINTS], product[POINTS];
    for (int i = 0; i < POINTS; i++) {
        all[i] = 2 * cos(PI * (i + 0.5) / POINTS);
        product[i] = fabs(all[i]);
    }
    for (int k = 0; k < POINTS; k++) {
        int next = 0;
        for (int i = 1; i < POINTS; i++) {
            next = product[i] > product[next] ? i : next;
        }
        x[k] = all[next];
        for (int i = 0; i < POINTS; i++) {
            product[i] *= fabs(all[i] - x[k]);
        }
    }
}

/* c [POINTS]: values at x, then divided differences. */
static void divide_differences(const double *x, double *c)
{
    for (int order = 1; order < POINTS; order++) {
        for (int i = POINTS - 1; i >= order; i--) {
            c[i] = (c[i] - c[i - 1]) / (x[i] - x[i - order]);
        }
    }
}

static double newton_form(const double *x, const double *c, double at)
{
    double sum = c[POINTS - 1];
    for (int i = POINTS - 2; i >= 0; i--) {
        sum = c[i] + (at - x[i]) * sum;
    }
    return sum;
}

/* The same as a formula of s on [from, to]. */
static quantity newton_formula(quantities *names, const double *x, const double *c, double from,
                               double to)
{
    double scale = 4 / (to - from), middle = (from + to) / 2;
    quantity s = quantity_formula(names, "s");
    quantity along = quantity_scale(quantity_subtract(s, quantity_number(middle)), scale);
    quantity sum = quantity_number(c[POINTS - 1]);
    for (int i = POINTS - 2; i >= 0; i--) {
        quantity distance = quantity_subtract(along, quantity_number(x[i]));
        sum = quantity_add(quantity_number(c[i]), quantity_multiply(distance, sum));
    }
    return sum;
}

/* Values [columns][points] at places -2 .. 2 of a piece. */
static ad_status sample(const pieces *p, double from, double to, int points, const double *at,
                        double *values, ad_error *error)
{
    double s[2 * POINTS];
    for (int i = 0; i < points; i++) {
        s[i] = (from + to) / 2 + at[i] * (to - from) / 4;
    }
    return solution_evaluate(p->solved, p->columns, (size_t)points, s, NULL, values, error);
}

/* The pieces of [from, to], in turn. */
static ad_status add_pieces(pieces *p, double from, double to, int depth, ad_error *error)
{
    double x[POINTS], between[POINTS - 1], c[COLUMNS_MAX * POINTS], exact[COLUMNS_MAX * POINTS];
    bool exact_enough = true;
    leja_points(x);
    for (int i = 0; i < POINTS - 1; i++) {
        between[i] = 2 * cos(PI * (i + 1) / POINTS);
    }
    ad_status status = sample(p, from, to, POINTS, x, c, error);
    status = status == AD_OK ? sample(p, from, to, POINTS - 1, between, exact, error) : status;
    for (int k = 0; k < p->columns && status == AD_OK; k++) {
        divide_differences(x, c + k * POINTS);
        for (int i = 0; i < POINTS - 1; i++) {
            double value = newton_form(x, c + k * POINTS, between[i]);
            double off = fabs(value - exact[k * (POINTS - 1) + i]);
            exact_enough = exact_enough && off <= EXACT * p->size[k];
        }
    }
    if (status != AD_OK) {
        return status;
    }
    if (!exact_enough && depth < DEPTH_MAX) {
        double middle = (from + to) / 2;
        status = add_pieces(p, from, middle, depth + 1, error);
        return status == AD_OK ? add_pieces(p, middle, to, depth + 1, error) : status;
    }
    if (!exact_enough || p->count == PIECES_MAX) {
        return ad_fail(error, AD_BAD_INPUT,
                       "the equilibrium bends too suddenly to start from; allowed: a smoother one, "
                       "or initial.position and initial.rotation as formulas");
    }
    for (int k = 0; k < p->columns; k++) {
        p->values[k][p->count] = newton_formula(p->names, x, c + k * POINTS, from, to);
    }
    p->edge[++p->count] = to;
    return AD_OK;
}

/* where(edge - s, first, rest) from the last piece on. */
static quantity join(const pieces *p, int column)
{
    quantity s = quantity_formula(p->names, "s"), sum = p->values[column][p->count - 1];
    for (int i = p->count - 2; i >= 0; i--) {
        quantity before = quantity_subtract(quantity_number(p->edge[i + 1]), s);
        sum = quantity_call("where", (quantity[]){before, p->values[column][i], sum});
    }
    return sum;
}

/* ---- the scene at rest ----------------------------------------------------------------------- */

/* size: of a beam's deflection. */
static ad_status fit(const solution *solved, scene *rod_scene, double size, quantities *names,
                     ad_error *error)
{
    scene_breaks breaks;
    pieces *p = calloc(1, sizeof *p);
    ad_status status = p ? scene_breaks_of(rod_scene, "s", &breaks, error)
                         : ad_fail(error, AD_NO_MEMORY, "out of memory for an equilibrium");
    if (status == AD_OK) {
        p->solved = solved;
        p->names = names;
        p->columns = scene_is_beam(rod_scene) ? 2 : COLUMNS_MAX;
    }
    for (int k = 0; status == AD_OK && k < p->columns; k++) {
        double length = scene_length(rod_scene);
        p->size[k] = p->columns == 2 ? size / (k == 0 ? 1 : length) : k < 3 ? length : 1;
    }
    for (int i = 0; status == AD_OK && i <= breaks.count; i++) {
        double from = i > 0 ? breaks.place[i - 1] : 0;
        double to = i < breaks.count ? breaks.place[i] : scene_length(rod_scene);
        status = add_pieces(p, from, to, 0, error);
    }
    for (int k = 0; status == AD_OK && k < p->columns; k++) {
        rod_scene->initial.settled[k] = join(p, k);
        status = quantity_check(rod_scene->initial.settled[k], error);
    }
    free(p);
    return status;
}

ad_status solve_settle(scene *rod_scene, quantities *names, ad_error *error)
{
    if (rod_scene->initial.state != SCENE_EQUILIBRIUM) {
        return AD_OK;
    }
    if (!names) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "the scene has no names for the formulas of its equilibrium");
    }
    const quantity none = {.is_given = false};
    scene still = *rod_scene;
    solve_settings settings;
    solve_report report;
    solution *solved = NULL;
    verdict found = {0};
    still.initial.state = SCENE_GIVEN;
    still.duration = quantity_number(0);
    still.windows = 1;
    for (int k = 0; k < 3; k++) {
        still.initial.velocity[k] = still.initial.angular_velocity[k] = none;
    }
    still.beam.velocity = still.beam.slope_rate = none;
    for (int i = 0; i < still.tendon_count; i++) { /* in motion they creep until nothing rubs */
        still.tendons[i].friction = none;
    }
    settings = solve_settings_default(&still);
    ad_status status = solution_create(&still, &settings, 0, NULL, &solved, &report, error);
    if (status != AD_OK) {
        return status;
    }
    solution_verdict(solved, &still, &settings, &report, &found);
    if (verdict_outcome_of(&found) != VERDICT_SOLVED) {
        status = ad_fail(error, AD_BAD_INPUT, "no equilibrium to start from is found: %s",
                         verdict_text(&found));
    } else {
        status = fit(solved, rod_scene, report.size, names, error);
    }
    solution_free(solved);
    return status;
}
