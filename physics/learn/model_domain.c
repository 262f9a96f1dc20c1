/* The coordinates of a scene's model: pieces along s and windows of time that end where something
 * of the scene jumps; and pieces so short that what is given is smooth in each on its own length.
 */
#include "physics/learn/model.h"
#include "physics/numerics/constants.h"
#include "physics/scene/breaks.h"
#include "physics/scene/scene_walk.h"

#include <math.h>
#include <stdlib.h>

/* What is given in a piece should be polynomials of this degree to a share of its size: the least
 * of what networks span in a piece. */
enum { DEGREE = 14 };
static const double MISFIT = 1e-7;

enum {
    TIMES = 5,        /* at which formulas of t are looked at, too */
    PLACES = 3,       /* of a part of a panel */
    PARTS = 4,        /* of a panel, between which it may be divided */
    PARTED_MOST = 512 /* of more panels there is one part each */
};

/* Of the range: in motion only where there are shorter panels a piece is divided. */
static const double SHORT = 1.0 / 32;

typedef struct given_formula {
    quantity q;
    quantity_interval counts; /* where along the rod */
    double size;
} given_formula;

typedef struct dividing {
    double duration;
    int formula_count;
    given_formula *formulas;
    const scene_panels *panels; /* divided into parts */
    int parts;
    int pieces, most; /* so far, and with those that are `to_come` */
    int to_come;
    double edges[DOMAIN_PIECES_MAX + 1]; /* m */
} dividing;

/* ---- formulas ------------------------------------------------------------------------------ */

static double time_of(const dividing *in, int i)
{
    return in->duration * (i + 0.5) / TIMES;
}

static int times(const dividing *in, quantity q)
{
    return in->duration > 0 && quantity_depends_on(q, "t") ? TIMES : 1;
}

static double panel_place(const scene_panels *panels, int panel, int i)
{
    double low = panels->edges[panel], high = panels->edges[panel + 1];
    return low + (high - low) * (i + 0.5) / PLACES;
}

static void take_formula(void *context, const char *key, quantity q, quantity_interval s)
{
    dividing *in = context;
    given_formula *formula = &in->formulas[in->formula_count++];
    (void)key;
    *formula = (given_formula){.q = q, .counts = s};
    for (int i = 0; i < in->panels->count * PLACES; i++) {
        double at = panel_place(in->panels, i / PLACES, i % PLACES);
        for (int k = 0; k < times(in, q) && at >= s.low && at <= s.high; k++) {
            formula->size = fmax(formula->size, fabs(quantity_value(q, at, time_of(in, k))));
        }
    }
}

/* ---- polynomials --------------------------------------------------------------------------- */

/* Chebyshev's points of [low, high]; none is an edge, where formulas may switch. */
static double chebyshev_point(double low, double high, int j)
{
    return low + (high - low) * pow(sin(PI * (2 * j + 1) / (4.0 * (DEGREE + 1))), 2);
}

/* Through values at those points, by the barycentric formula (Berrut & Trefethen 2004, SIAM Review
 * 46). */
static double interpolate(const double *values, double low, double high, double s)
{
    double above = 0, below = 0;
    for (int j = 0; j <= DEGREE; j++) {
        double off = s - chebyshev_point(low, high, j);
        double weight = (j % 2 ? -1 : 1) * sin(PI * (2 * j + 1) / (2.0 * (DEGREE + 1)));
        if (off == 0) {
            return values[j];
        }
        above += weight / off * values[j];
        below += weight / off;
    }
    return above / below;
}

static bool fits_formula(const dividing *in, const given_formula *formula, double t, int first,
                         int last)
{
    double low = in->panels->edges[first], high = in->panels->edges[last], values[DEGREE + 1];
    quantity q = formula->q;
    for (int j = 0; j <= DEGREE; j++) {
        values[j] = quantity_value(q, chebyshev_point(low, high, j), t);
    }
    for (int i = first * PLACES; i < last * PLACES; i++) {
        double s = panel_place(in->panels, i / PLACES, i % PLACES);
        double off = interpolate(values, low, high, s) - quantity_value(q, s, t);
        if (!(fabs(off) <= MISFIT * formula->size)) {
            return false;
        }
    }
    return true;
}

/* ---- pieces -------------------------------------------------------------------------------- */

/* Whether all that is given fits from panel `first` to before `last`. */
static bool fits(const dividing *in, int first, int last)
{
    double low = in->panels->edges[first], high = in->panels->edges[last];
    for (int i = 0; i < in->formula_count; i++) {
        const given_formula *formula = &in->formulas[i];
        bool counts = low < formula->counts.high && high > formula->counts.low;
        for (int k = 0; counts && k < times(in, formula->q); k++) {
            if (!fits_formula(in, formula, time_of(in, k), first, last)) {
                return false;
            }
        }
    }
    return true;
}

static bool has_short(const dividing *in, int first, int last)
{
    const double *edges = in->panels->edges;
    for (int i = first; i < last; i++) {
        if (in->parts * (edges[i + 1] - edges[i]) < SHORT * edges[in->panels->count]) {
            return true;
        }
    }
    return false;
}

/* Halved as long as it does not fit, between panels: where panels are short, so are the pieces. */
static void divide(dividing *in, int first, int last)
{
    bool may = in->pieces + in->to_come + 2 <= in->most && last - first > 1;
    if (may && (in->duration == 0 || has_short(in, first, last)) && !fits(in, first, last)) {
        int middle = first + (last - first) / 2;
        in->to_come++;
        divide(in, first, middle);
        in->to_come--;
        divide(in, middle, last);
        return;
    }
    in->edges[++in->pieces] = in->panels->edges[last];
}

/* From break to break. */
static void divide_stretches(dividing *in, const scene_breaks *breaks)
{
    int first = 0;
    for (int i = 0; i <= breaks->count; i++) {
        int last = in->panels->count;
        for (int k = first + 1; i < breaks->count && k < last; k++) {
            last = in->panels->edges[k] >= breaks->place[i] ? k : last;
        }
        in->most = DOMAIN_PIECES_MAX - (breaks->count - i);
        divide(in, first, last);
        first = last;
    }
}

/* Every panel in so many equal parts. */
static ad_status part_panels(scene_panels *panels, int parts, ad_error *error)
{
    double *edges = malloc(((size_t)panels->count * (size_t)parts + 1) * sizeof *edges);
    if (!edges) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the pieces of a scene");
    }
    for (int i = 0; i < panels->count * parts; i++) {
        double low = panels->edges[i / parts], high = panels->edges[i / parts + 1];
        edges[i] = low + (high - low) * (i % parts) / parts;
    }
    edges[panels->count * parts] = panels->edges[panels->count];
    free(panels->edges);
    panels->edges = edges;
    panels->count *= parts;
    return AD_OK;
}

/* Pieces along s, which the displacement form has not. */
static ad_status divide_length(const scene *scene, domain *d, ad_error *error)
{
    scene_breaks breaks;
    scene_panels panels = {.edges = NULL};
    dividing in = {.duration = scene_duration(scene), .panels = &panels};
    const scene_walker walker = {.formula = take_formula, .context = &in};
    if (scene->formulation != SCENE_MIXED) {
        return AD_OK;
    }
    ad_status status = scene_breaks_of(scene, "s", &breaks, error);
    if (status != AD_OK || breaks.count >= DOMAIN_PIECES_MAX) {
        return status;
    }
    status = scene_panels_of(scene, "s", &panels, error);
    in.parts = panels.count <= PARTED_MOST ? PARTS : 1;
    status = status == AD_OK ? part_panels(&panels, in.parts, error) : status;
    in.formulas = malloc((scene_walk_formulas(scene, "s") + 1) * sizeof *in.formulas);
    if (status == AD_OK && !in.formulas) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for the formulas of a scene");
    }
    if (status == AD_OK) {
        scene_walk(scene, "s", &walker);
        divide_stretches(&in, &breaks);
    }
    free(in.formulas);
    scene_panels_free(&panels);
    d->pieces = in.pieces > 1 ? in.pieces : 0;
    for (int i = 1; i < d->pieces; i++) {
        d->edge[i] = in.edges[i] / d->coordinates[0].scale;
    }
    d->edge[0] = d->coordinates[0].low;
    d->edge[d->pieces] = d->coordinates[0].high;
    return status;
}

/* ---- windows ------------------------------------------------------------------------------- */

static ad_status divide_time(const scene *scene, domain *d, ad_error *error)
{
    scene_breaks breaks;
    if (d->windows <= 1) {
        return AD_OK;
    }
    ad_status status = scene_breaks_of(scene, "t", &breaks, error);
    for (int i = 0; status == AD_OK && i < breaks.count; i++) {
        breaks.place[i] /= d->coordinates[d->time].scale;
    }
    if (status == AD_OK) {
        domain_divide_time(d, breaks.count, breaks.place);
    }
    return status;
}

ad_status model_domain_of(const scene *scene, domain *d, ad_error *error)
{
    *d = rod_domain_of(scene);
    if (scene_is_manufactured(scene)) {
        return AD_OK;
    }
    ad_status status = divide_length(scene, d, error);
    return status == AD_OK ? divide_time(scene, d, error) : status;
}
