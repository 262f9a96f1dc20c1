/* Panels of a coordinate: between breaks, and short where formulas vary on short lengths. */
#include "physics/numerics/constants.h"
#include "physics/numerics/sort.h"
#include "physics/quantity/kept.h"
#include "physics/scene/breaks.h"
#include "physics/scene/scene_walk.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { PANELS_MAX = SCENE_PANELS_MAX, SAMPLES = 6, OTHERS = 5, PARTS = 8 };

/* A formula is seen where the slopes that it may have differ by no more than so many times those at
 * samples, or change it by no more than a share of all that it varies: the first, or where that
 * takes too many panels, because the formula cancels much of itself, the last. */
static const double MORE = 8, FIRST_SHARE = 1e-4, LAST_SHARE = 1e-2;

/* Of the range: what is looked at one by one, lest much slope elsewhere hide some. */
static const double STRETCH = 1.0 / 128;

/* Or values no more than this. */
static const double ROUNDING = 1e-15;

/* Next to a place where the slope is infinite, as that of a square root of 0, panels of so much of
 * the range are short enough where values do not spread more than so many times those at samples.
 */
static const double SHORT = 1e-3, SPREAD = 2, INFINITE = 1e100;

/* Panels become one where a polynomial is as close to what is on both, of all that it varies, but
 * for rounding, of its values. */
static const double SMOOTH = 1e-6, ROUNDED = 1e-13;

/* Of the range: no panel is shorter; and enclosures keep off the ends of panels by this, where
 * breaks are. */
static const double SHORTEST = 1e-11, INSIDE = 1e-13;

typedef struct seen_formula {
    quantity q;
    quantity_interval s; /* where it counts */
    double variation;
} seen_formula;

typedef struct dividing {
    bool along_s;
    double end;
    quantity_interval s, t; /* of the coordinate: its whole range */
    scene_panels *result;
    int seen_count;
    seen_formula *seen; /* [those of the scene] */
    /* the formula at hand */
    quantity q;
    double variation;
    const char *key;
    double share;
} dividing;

static double width(quantity_interval x)
{
    return x.high - x.low;
}

static quantity_interval hull(quantity_interval a, quantity_interval b)
{
    return (quantity_interval){fmin(a.low, b.low), fmax(a.high, b.high)};
}

/* By parts of the other coordinate, which cancel less. */
static quantity_enclosure over(const dividing *in, quantity_interval panel)
{
    const quantity_interval *other = in->along_s ? &in->t : &in->s;
    const int parts = width(*other) > 0 ? PARTS : 1;
    quantity_enclosure all;
    for (int i = 0; i < parts; i++) {
        const quantity_interval part = {other->low + width(*other) * i / parts,
                                        other->low + width(*other) * (i + 1) / parts};
        quantity_enclosure one = in->along_s ? quantity_enclose_between(in->q, "s", panel, part)
                                             : quantity_enclose_between(in->q, "t", part, panel);
        all.value = i == 0 ? one.value : hull(all.value, one.value);
        all.slope = i == 0 ? one.slope : hull(all.slope, one.slope);
    }
    return all;
}

static quantity_enclosure at(const dividing *in, double place, double share)
{
    const quantity_interval *other = in->along_s ? &in->t : &in->s;
    double value = other->low + share * width(*other);
    quantity_interval x = {place, place}, y = {value, value};
    return in->along_s ? quantity_enclose(in->q, "s", x, y) : quantity_enclose(in->q, "t", y, x);
}

static double value_at(const dividing *in, double place, double share)
{
    const quantity_interval *other = in->along_s ? &in->t : &in->s;
    double value = other->low + share * width(*other);
    return in->along_s ? quantity_value(in->q, place, value) : quantity_value(in->q, value, place);
}

/* How far slopes, and values, at samples are apart. */
static void sample(const dividing *in, quantity_interval panel, double *slopes, double *values)
{
    quantity_interval slope = {INFINITY, -INFINITY}, value = slope;
    bool at_one = in->along_s ? width(in->t) == 0 : width(in->s) == 0;
    for (int i = 0; i < SAMPLES; i++) {
        double place = panel.low + width(panel) * (i + 0.5) / SAMPLES;
        for (int k = 0; k < (at_one ? 1 : OTHERS); k++) {
            quantity_enclosure here = at(in, place, (k + 0.5) / OTHERS);
            double rise = (here.slope.low + here.slope.high) / 2;
            slope.low = fmin(slope.low, rise);
            slope.high = fmax(slope.high, rise);
            value.low = fmin(value.low, here.value.low);
            value.high = fmax(value.high, here.value.high);
        }
    }
    *slopes = width(slope);
    *values = width(value);
}

static bool is_seen(const dividing *in, double low, double high)
{
    double inside = INSIDE * in->end, length = high - low;
    const quantity_interval panel = {low + inside, high - inside};
    if (length <= SHORTEST * in->end) {
        return true;
    }
    quantity_enclosure all = over(in, panel);
    double slopes = width(all.slope), sampled_slopes, sampled_values;
    if (slopes == 0 || width(all.value) <= ROUNDING * in->variation ||
        length * slopes <= in->share * in->variation) {
        return true;
    }
    if (length > STRETCH * in->end) {
        return false;
    }
    sample(in, panel, &sampled_slopes, &sampled_values);
    bool infinite = length <= SHORT * in->end &&
                    !(width(over(in, (quantity_interval){low, high}).slope) < INFINITE);
    return infinite ? width(all.value) <= SPREAD * sampled_values : slopes <= MORE * sampled_slopes;
}

static bool has_room(dividing *in)
{
    scene_panels *to = in->result;
    if (to->count == PANELS_MAX && !to->unresolved) {
        to->unresolved = in->key;
    }
    return to->count < PANELS_MAX;
}

/* Edges within it, in turn. */
static void divide(dividing *in, double low, double high)
{
    double middle = low + (high - low) / 2;
    if (is_seen(in, low, high) || !has_room(in)) {
        return;
    }
    divide(in, low, middle);
    if (has_room(in)) {
        in->result->edges[++in->result->count] = middle;
    }
    divide(in, middle, high);
}

/* Of its enclosure, or where that says nothing of samples. */
static double variation_of(const dividing *in)
{
    enum { MANY = 64 };
    quantity_interval whole = in->along_s ? in->s : in->t, all = {INFINITY, -INFINITY};
    double of_all = width(quantity_range(in->q, in->s, in->t));
    for (int i = 0; i < MANY && !(of_all < INFINITE); i++) {
        double place = whole.low + width(whole) * (i + 0.5) / MANY;
        quantity_interval value = at(in, place, 0.5).value;
        bool finite = isfinite(value.low) && isfinite(value.high);
        all.low = finite ? fmin(all.low, value.low) : all.low;
        all.high = finite ? fmax(all.high, value.high) : all.high;
    }
    return of_all < INFINITE ? of_all : fmax(0, width(all));
}

static void look_into(void *context, const char *key, quantity q, quantity_interval s)
{
    dividing *in = context;
    scene_panels *panels = in->result;
    int before = panels->count;
    for (int i = 0; i < in->seen_count; i++) {
        if (in->seen[i].q.node == q.node && in->seen[i].s.low == s.low) {
            return;
        }
    }
    in->q = q;
    in->key = key;
    in->variation = variation_of(in);
    in->seen[in->seen_count++] = (seen_formula){q, s, in->variation};
    for (int i = 0; i < before; i++) {
        double low = panels->edges[i], high = panels->edges[i + 1];
        if (!in->along_s || (low < s.high && high > s.low)) {
            divide(in, low, high);
        }
    }
    sort_ascending((size_t)panels->count + 1, panels->edges);
}

/* ---- joining --------------------------------------------------------------------------------- */

/* Whether the polynomial through Chebyshev points of low .. high goes through as many in either
 * part of it, of the formula at hand. */
static bool is_smooth(const dividing *in, double low, double middle, double high, double share)
{
    enum { POINTS = 24 };
    double place[POINTS], value[POINTS], weight[POINTS];
    for (int i = 0; i < POINTS; i++) { /* Berrut, Trefethen, SIAM Review 46 (2004) */
        double angle = PI * (i + 0.5) / POINTS;
        place[i] = (low + high - (high - low) * cos(angle)) / 2;
        value[i] = value_at(in, place[i], share);
        weight[i] = (i % 2 ? -1 : 1) * sin(angle);
    }
    for (int i = 0; i < 2 * POINTS; i++) {
        double first = i < POINTS ? low : middle, last = i < POINTS ? middle : high;
        double x = first + (last - first) * (i % POINTS + 0.5) / POINTS, above = 0, below = 0;
        for (int k = 0; k < POINTS; k++) {
            double factor = weight[k] / (x - place[k]);
            above += factor * value[k];
            below += factor;
        }
        const double is = value_at(in, x, share), off = fabs(above / below - is);
        if (isfinite(below) && !(off <= SMOOTH * in->variation + ROUNDED * fabs(is))) {
            return false;
        }
    }
    return true;
}

static bool may_join(dividing *in, double low, double middle, double high)
{
    bool at_one = in->along_s ? width(in->t) == 0 : width(in->s) == 0;
    for (int i = 0; i < in->seen_count; i++) {
        quantity_interval s = in->seen[i].s;
        in->q = in->seen[i].q;
        in->variation = in->seen[i].variation;
        bool counts = !in->along_s || (low < s.high && high > s.low);
        for (int k = 0; counts && k < (at_one ? 1 : OTHERS); k++) {
            if (!is_smooth(in, low, middle, high, (k + 0.5) / OTHERS)) {
                return false;
            }
        }
    }
    return true;
}

/* Panels without which all is smooth become one with their neighbours, but for breaks. */
static void join(dividing *in, const scene_breaks *breaks)
{
    double *edges = in->result->edges;
    int kept = 0, next = 0; /* edges[kept] is the last of those that stay */
    for (int i = 1; i <= in->result->count; i++) {
        while (next < breaks->count && breaks->place[next] < edges[kept]) {
            next++;
        }
        bool is_break = next < breaks->count && breaks->place[next] == edges[kept];
        bool joins = kept > 0 && !is_break && may_join(in, edges[kept - 1], edges[kept], edges[i]);
        kept += !joins;
        edges[kept] = edges[i];
    }
    in->result->count = kept;
}

void scene_panels_free(scene_panels *panels)
{
    if (panels) {
        free(panels->edges);
        panels->edges = NULL;
    }
}

/* From the breaks on. */
static void fill(dividing *in, const scene *rod_scene, const scene_breaks *breaks, double share)
{
    const scene_walker walker = {.formula = look_into, .context = in};
    scene_panels *to = in->result;
    in->share = share;
    in->seen_count = 0;
    to->unresolved = breaks->unresolved;
    to->count = 0;
    for (int i = 0; i < breaks->count; i++) {
        to->edges[++to->count] = breaks->place[i];
    }
    to->edges[++to->count] = in->end;
    scene_walk(rod_scene, in->along_s ? "s" : "t", &walker);
}

static ad_status find_panels(const scene *rod_scene, const char *coordinate, scene_panels *result,
                             ad_error *error)
{
    scene_breaks breaks;
    dividing in = {.along_s = strcmp(coordinate, "s") == 0,
                   .s = {0, scene_length(rod_scene)},
                   .t = {0, scene_duration(rod_scene)},
                   .result = result};
    in.end = in.along_s ? in.s.high : in.t.high;
    result->edges = calloc(PANELS_MAX + 2, sizeof *result->edges);
    in.seen = malloc((scene_walk_formulas(rod_scene, coordinate) + 1) * sizeof *in.seen);
    ad_status status =
        result->edges && in.seen
            ? scene_breaks_of(rod_scene, coordinate, &breaks, error)
            : ad_fail(error, AD_NO_MEMORY, "out of memory for %d panels", PANELS_MAX);
    if (status == AD_OK) {
        fill(&in, rod_scene, &breaks, FIRST_SHARE);
        if (result->unresolved && !breaks.unresolved) {
            fill(&in, rod_scene, &breaks, LAST_SHARE);
        }
        if (!result->unresolved) {
            join(&in, &breaks);
        }
    }
    free(in.seen);
    return status;
}

/* ---- once for each scene --------------------------------------------------------------------- */

/* All that panels follow from. */
typedef struct panels_key {
    quantities *names; /* of all its formulas */
    bool has_several;
    size_t count;
    uint64_t *words; /* [count]; NULL: they are counted only */
} panels_key;

static void add_word(panels_key *to, const void *word, size_t size)
{
    if (to->words) {
        to->words[to->count] = 0;
        memcpy(&to->words[to->count], word, size);
    }
    to->count++;
}

static void key_formula(void *context, const char *key, quantity q, quantity_interval s)
{
    panels_key *to = context;
    quantities *names = quantity_names(q);
    to->has_several |= to->names && names != to->names;
    to->names = names;
    add_word(to, &key, sizeof key);
    add_word(to, &q.node, sizeof q.node);
    add_word(to, &s.low, sizeof s.low);
    add_word(to, &s.high, sizeof s.high);
}

static void key_place(void *context, const char *key, double s)
{
    add_word(context, &key, sizeof key);
    add_word(context, &s, sizeof s);
}

static void make_key(const scene *rod_scene, const char *coordinate, panels_key *to)
{
    const scene_walker walker = {.formula = key_formula, .place = key_place, .context = to};
    const double ends[2] = {scene_length(rod_scene), scene_duration(rod_scene)};
    to->count = 0;
    add_word(to, coordinate, 1);
    add_word(to, &ends[0], sizeof ends[0]);
    add_word(to, &ends[1], sizeof ends[1]);
    scene_walk(rod_scene, coordinate, &walker);
}

/* Kept as edges, and behind them the key of what is unresolved. */
static ad_status recall(const panels_key *key, scene_panels *result, ad_error *error)
{
    size_t size = 0;
    void *found;
    ad_status status = quantities_recall(key->names, key->count * sizeof *key->words, key->words,
                                         &size, &found, error);
    if (status == AD_OK && found) {
        result->edges = found;
        result->count = (int)(size / sizeof *result->edges) - 2;
        memcpy(&result->unresolved, &result->edges[result->count + 1], sizeof result->unresolved);
    }
    return status;
}

static ad_status keep(const panels_key *key, const scene_panels *panels, ad_error *error)
{
    memcpy(&panels->edges[panels->count + 1], &panels->unresolved, sizeof panels->unresolved);
    return quantities_keep(key->names, key->count * sizeof *key->words, key->words,
                           ((size_t)panels->count + 2) * sizeof *panels->edges, panels->edges,
                           error);
}

ad_status scene_panels_of(const scene *rod_scene, const char *coordinate, scene_panels *result,
                          ad_error *error)
{
    panels_key key = {.names = NULL};
    ad_status status = AD_OK;
    *result = (scene_panels){.edges = NULL};
    make_key(rod_scene, coordinate, &key);
    const bool kept = key.names && !key.has_several;
    if (kept) {
        key.words = malloc(key.count * sizeof *key.words);
        if (!key.words) {
            return ad_fail(error, AD_NO_MEMORY, "out of memory for the key of panels");
        }
        make_key(rod_scene, coordinate, &key);
        status = recall(&key, result, error);
    }
    if (status == AD_OK && !result->edges) {
        status = find_panels(rod_scene, coordinate, result, error);
        status = status == AD_OK && kept ? keep(&key, result, error) : status;
    }
    free(key.words);
    if (status != AD_OK) {
        scene_panels_free(result);
    }
    return status;
}

ad_status scene_divisions_of(const scene *rod_scene, const char *coordinate, int most,
                             scene_breaks *result, ad_error *error)
{
    scene_panels panels;
    ad_status status = scene_breaks_of(rod_scene, coordinate, result, error);
    bool moves = strcmp(coordinate, "s") == 0 || scene_is_dynamic(rod_scene);
    if (status != AD_OK || result->unresolved || !moves) {
        return status;
    }
    status = scene_panels_of(rod_scene, coordinate, &panels, error);
    if (status == AD_OK && !panels.unresolved && panels.count <= most &&
        panels.count <= BREAKS_MAX) {
        result->count = panels.count - 1;
        memcpy(result->place, panels.edges + 1, (size_t)result->count * sizeof *result->place);
    }
    if (status == AD_OK) {
        scene_panels_free(&panels);
    }
    return status;
}
