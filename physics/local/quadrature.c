#include "physics/local/quadrature.h"

#include "physics/numerics/sort.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Panels; shortest panel and element; how exactly a panel is integrated, of the size of a row. */
enum { PANELS_MAX = SCENE_PANELS_MAX, NARROW_MAX = 64 };
static const double SHORTEST = 1e-11, ROUNDING = 1e-13;

/* A row that amounts to less is compared with this: the far tail of what is narrow may be nothing
 * but rounding. */
static const double TAIL = 1e-6;

/* How much longer a panel may be than one beside it. */
static const double LONGER = 4;

/* Places that are no further apart differ by rounding. */
static const double SAME = 1e-12;

/* Integrals over a stretch: of every row, and of its product with the distance from the beginning.
 */
typedef struct moments {
    double zeroth[QUADRATURE_ROWS_MAX], first[QUADRATURE_ROWS_MAX], size[QUADRATURE_ROWS_MAX];
} moments;

/* Adds those from `first` to `last` by one rule; distances from `origin`. */
static ad_status add_moments(const solve_given *given, const gauss_rule *rule, double first,
                             double last, double origin, moments *sum, ad_error *error)
{
    double s[GAUSS_STAGES_MAX], values[GAUSS_STAGES_MAX * QUADRATURE_ROWS_MAX];
    for (int i = 0; i < rule->stages; i++) {
        s[i] = first + (last - first) * rule->nodes[i];
    }
    ad_status status = given->at(given->context, (size_t)rule->stages, s, values, error);
    for (int i = 0; i < rule->stages && status == AD_OK; i++) {
        double weight = (last - first) * rule->weights[i];
        for (int k = 0; k < given->rows; k++) {
            double part = weight * values[i * given->rows + k];
            sum->zeroth[k] += part;
            sum->first[k] += part * (s[i] - origin);
            sum->size[k] += fabs(part);
        }
    }
    return status;
}

/* ---- panels ---------------------------------------------------------------------------------- */

typedef struct halving {
    solve_quadrature *result;
    const solve_given *given;
    int room;
} halving;

static bool agree(const halving *in, const moments *whole, const moments *halves)
{
    for (int k = 0; k < in->given->rows; k++) {
        double off = fmax(fabs(whole->zeroth[k] - halves->zeroth[k]),
                          fabs(whole->first[k] - halves->first[k]));
        if (!(off <= ROUNDING * fmax(in->result->size[k], TAIL))) {
            return false;
        }
    }
    return true;
}

/* Panels from `first` to `last`, in turn. */
static ad_status halve(halving *in, double first, double last, ad_error *error)
{
    solve_quadrature *quadrature = in->result;
    moments whole = {.zeroth = {0}}, halves = {.zeroth = {0}};
    double middle = first + (last - first) / 2;
    bool possible = last - first > SHORTEST && quadrature->count < in->room;
    ad_status status = add_moments(in->given, &quadrature->rule, first, last, first, &whole, error);
    status = status == AD_OK
                 ? add_moments(in->given, &quadrature->rule, first, middle, first, &halves, error)
                 : status;
    status = status == AD_OK
                 ? add_moments(in->given, &quadrature->rule, middle, last, first, &halves, error)
                 : status;
    if (status != AD_OK) {
        return status;
    }
    bool resolved = agree(in, &whole, &halves);
    if (possible && !resolved) {
        status = halve(in, first, middle, error);
        return status == AD_OK ? halve(in, middle, last, error) : status;
    }
    if (!resolved && !quadrature->unresolved) {
        quadrature->unresolved = "rod";
    }
    quadrature->edges[++quadrature->count] = last;
    return AD_OK;
}

static bool is_place(const solve_quadrature *quadrature, double s)
{
    bool found = s == 0 || s == 1;
    for (int i = 0; i < quadrature->place_count; i++) {
        found = found || fabs(quadrature->places[i] - s) <= SAME;
    }
    return found;
}

/* Halves panels that are much longer than one beside them, where no jump is between: what is narrow
 * there has a tail that neither they nor their halves may see. */
static void grade(solve_quadrature *quadrature, double *edges)
{
    for (int i = 0; i < quadrature->count; i++) {
        double width = edges[i + 1] - edges[i], beside = width;
        if (!is_place(quadrature, edges[i])) {
            beside = fmin(beside, edges[i] - edges[i - 1]);
        }
        if (!is_place(quadrature, edges[i + 1])) {
            beside = fmin(beside, edges[i + 2] - edges[i + 1]);
        }
        if (width > LONGER * beside && width > SHORTEST && quadrature->count < PANELS_MAX) {
            memmove(edges + i + 2, edges + i + 1, (size_t)(quadrature->count - i) * sizeof *edges);
            edges[i + 1] = edges[i] + width / 2;
            quadrature->count++;
            i = i > 1 ? i - 2 : -1; /* the one before has a shorter one beside it now */
        }
    }
}

/* In place of quadrature->edges. */
static ad_status refine(solve_quadrature *quadrature, const solve_given *given, ad_error *error)
{
    grade(quadrature, quadrature->edges);
    int count = quadrature->count;
    double *coarse = quadrature->edges;
    halving in = {quadrature, given, PANELS_MAX};
    moments all = {.zeroth = {0}};
    ad_status status = AD_OK;
    for (int i = 0; i < count && status == AD_OK; i++) {
        status =
            add_moments(given, &quadrature->rule, coarse[i], coarse[i + 1], coarse[i], &all, error);
    }
    memcpy(quadrature->size, all.size, sizeof quadrature->size);
    quadrature->edges = malloc((size_t)(count + PANELS_MAX + 64) * sizeof *quadrature->edges);
    if (status == AD_OK && !quadrature->edges) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for panels");
    }
    if (status == AD_OK) {
        quadrature->edges[0] = 0;
        quadrature->count = 0;
    }
    for (int i = 0; i < count && status == AD_OK; i++) {
        in.room = PANELS_MAX + i;
        status = halve(&in, coarse[i], coarse[i + 1], error);
    }
    free(coarse);
    return status;
}

/* ---- making ---------------------------------------------------------------------------------- */

void solve_quadrature_free(solve_quadrature *quadrature)
{
    if (quadrature) {
        free(quadrature->edges);
        free(quadrature->places);
        free(quadrature);
    }
}

/* A break near one of the places is that one. */
static void gather_places(solve_quadrature *quadrature, const scene_breaks *breaks, double length,
                          int count, const double *places)
{
    int next = 0;
    for (int i = 0; i <= breaks->count; i++) {
        double place = i < breaks->count ? breaks->place[i] / length : 1;
        for (; next < count && places[next] <= place + SAME; next++) {
            if (places[next] > 0 && places[next] < 1) {
                quadrature->places[quadrature->place_count++] = places[next];
            }
        }
        bool known = quadrature->place_count > 0 &&
                     place - quadrature->places[quadrature->place_count - 1] <= SAME;
        if (i < breaks->count && !known) {
            quadrature->places[quadrature->place_count++] = place;
        }
    }
}

/* With room for PANELS_MAX. */
static ad_status fill_panels(solve_quadrature *quadrature, const scene *of, ad_error *error)
{
    scene_panels panels;
    ad_status status = scene_panels_of(of, "s", &panels, error);
    if (status != AD_OK) {
        return status;
    }
    quadrature->edges = malloc((PANELS_MAX + 1) * sizeof *quadrature->edges);
    quadrature->count = panels.count;
    quadrature->unresolved = panels.unresolved;
    for (int i = 0; i <= panels.count && quadrature->edges; i++) {
        quadrature->edges[i] = i == panels.count ? 1 : panels.edges[i] / scene_length(of);
    }
    scene_panels_free(&panels);
    return quadrature->edges ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for panels");
}

/* Whether any two places, or ends of the range, are so close that an element of high degree between
 * others would not see what is there. */
static bool are_narrow(const scene_breaks *places, double length)
{
    const double close = length / 32;
    double before = 0, least = length;
    for (int i = 0; i <= places->count; i++) {
        double place = i < places->count ? places->place[i] : length;
        least = fmin(least, place - before);
        before = place;
    }
    return least < close;
}

static ad_status fill_places(solve_quadrature *quadrature, const scene *of, bool narrow, int count,
                             const double *places, ad_error *error)
{
    scene_breaks breaks;
    ad_status status = narrow ? scene_divisions_of(of, "s", NARROW_MAX, &breaks, error) : AD_OK;
    if (status == AD_OK && (!narrow || !are_narrow(&breaks, scene_length(of)))) {
        status = scene_breaks_of(of, "s", &breaks, error);
    }
    if (status != AD_OK) {
        return status;
    }
    quadrature->unresolved = breaks.unresolved;
    quadrature->places = malloc((size_t)(breaks.count + count + 1) * sizeof *quadrature->places);
    if (!quadrature->places) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for places along the rod");
    }
    gather_places(quadrature, &breaks, scene_length(of), count, places);
    return AD_OK;
}

ad_status solve_quadrature_create(const scene *of, const solve_given *given, int count,
                                  const double *places, solve_quadrature **result, ad_error *error)
{
    *result = NULL;
    solve_quadrature *quadrature = calloc(1, sizeof *quadrature);
    if (!quadrature) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a quadrature");
    }
    quadrature->rule = solve_gauss_rule_of(QUADRATURE_POINTS);
    ad_status status = fill_places(quadrature, of, given->rows == 0, count, places, error);
    if (status == AD_OK && given->rows > 0) {
        status = fill_panels(quadrature, of, error);
        status = status == AD_OK ? refine(quadrature, given, error) : status;
    }
    if (status != AD_OK) {
        solve_quadrature_free(quadrature);
        return status;
    }
    *result = quadrature;
    return AD_OK;
}

/* ---- elements -------------------------------------------------------------------------------- */

int solve_quadrature_panel(const solve_quadrature *quadrature, double s)
{
    return (int)sort_cell((size_t)quadrature->count, quadrature->edges, s, false);
}

/* Whether a rule on one element is as good as the panels. */
static ad_status fits(const solve_quadrature *quadrature, const solve_given *given,
                      const gauss_rule *rule, double tolerance, const double *element, bool *result,
                      ad_error *error)
{
    moments own = {.zeroth = {0}}, panels = {.zeroth = {0}};
    double first = element[0], last = element[1];
    ad_status status = add_moments(given, rule, first, last, first, &own, error);
    for (double at = first, next; at < last && status == AD_OK; at = next) {
        next = fmin(last, quadrature->edges[solve_quadrature_panel(quadrature, at) + 1]);
        status = add_moments(given, &quadrature->rule, at, next, first, &panels, error);
    }
    *result = true;
    for (int k = 0; k < given->rows && status == AD_OK; k++) {
        double off =
            fmax(fabs(own.zeroth[k] - panels.zeroth[k]), fabs(own.first[k] - panels.first[k]));
        *result = *result && off <= tolerance * fmax(1, quadrature->size[k]);
    }
    return status;
}

ad_status solve_quadrature_divide(const solve_quadrature *quadrature, const solve_given *given,
                                  int stages, double tolerance, int most, int *elements,
                                  double *edges, bool *done, ad_error *error)
{
    const gauss_rule rule = solve_gauss_rule_of(stages);
    ad_status status = AD_OK;
    int settled = 0; /* elements from the left that fit */
    *done = true;
    while (status == AD_OK && settled < *elements) {
        double *element = edges + settled, middle = element[0] + (element[1] - element[0]) / 2;
        bool fit = true;
        status = fits(quadrature, given, &rule, tolerance, element, &fit, error);
        bool possible = *elements < most && element[1] - element[0] > SHORTEST;
        *done = *done && (fit || element[1] - element[0] <= SHORTEST || possible);
        if (fit || !possible) {
            settled++;
            continue;
        }
        memmove(element + 2, element + 1, (size_t)(*elements - settled) * sizeof *element);
        element[1] = middle;
        (*elements)++;
    }
    return status;
}
