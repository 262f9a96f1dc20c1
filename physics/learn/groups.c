/* Which of the numbers that the equations are given say which member it is. */
#include "physics/learn/groups.h"

#include "autodiff/memory.h"
#include "nn/rng.h"
#include "physics/learn/groups_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Networks of more inputs miss shapes by more than a symmetry that holds nearly. */
enum { DRAWS = 512, FEW = 5 };

/* Relative: numbers that change by less are the same for all members. */
static const double CONSTANT = 1e-9;
/* Of its change, what is left of a number that is linear in others. */
static const double LINEAR = 1e-6;
/* A number that follows from others smoothly has no steeper slopes by them, all mapped to -1 .. 1,
 * and its own is theirs up to a part. */
static const double STEEPEST = 6, SLOPE = 1e-3;
/* A positive number that changes by this factor is taken by its logarithm. */
static const double DECADES = 8;
/* Of the length: what moves the rod by less is left out. */
static const double UNMOVED = 1e-7;
/* What moves the rod less is mapped to less, by this power, but not to less than the least; few
 * inputs, many. Random waves of a few want them as weak as they are: errors are four times smaller
 * than by the square root; deep networks of many are a third worse by that. */
static const double WEAKER[2] = {1, 0.5}, WEAKEST[2] = {0.05, 0.25};

/* ---- members --------------------------------------------------------------------------------- */

/* values [parameters][DRAWS]: all at one end of their ranges, each at one end with the others in
 * the middle, then any. */
static void draw(const scene *family, double *values)
{
    const int count = family->parameter_count;
    nn_rng random = nn_rng_split(0, "groups");
    for (int i = 0; i < DRAWS; i++) {
        for (int k = 0; k < count; k++) {
            const double any = nn_rng_uniform(&random), end = i % 2;
            const double fraction = i < 2                ? end
                                    : i >= 2 + 2 * count ? any
                                    : i / 2 == 1 + k     ? end
                                                         : 0.5;
            values[k * DRAWS + i] = scene_parameter_at(&family->parameters[k], fraction);
        }
    }
}

/* out [ad_rows][DRAWS] */
static ad_status evaluate(ad_value value, const double *draws, double *out, ad_error *error)
{
    const ad_run run = {.points = DRAWS, .inputs = &draws, .outputs = &out, .everywhere = true};
    return ad_evaluate(1, &value, NULL, &run, error);
}

/* All rows of all items. */
static ad_value stack_items(const group_list *list, ad_tape *tape)
{
    ad_value *parts = malloc(((size_t)list->count + 1) * sizeof *parts);
    ad_value all = ad_zeros(tape, 1);
    if (!parts) {
        ad_tape_fail(tape, AD_NO_MEMORY, "out of memory for groups");
        return all;
    }
    for (int i = 0; i < list->count; i++) {
        parts[i] = list->items[i].value;
    }
    all = ad_stack(list->count, parts);
    free(parts);
    return all;
}

/* ---- finding them ---------------------------------------------------------------------------- */

/* A row of an item in numbers. */
typedef struct candidate {
    group_row row;
    double *mapped; /* [DRAWS] -1 .. 1 */
    double *left;   /* [DRAWS] what is not linear in those that are chosen */
    double size;    /* of it before any is chosen */
    bool is_out;
} candidate;

typedef struct search {
    groups *x;
    ad_tape *tape;
    ad_value parameters;
    group_list list;
    double *draws;  /* [parameters][DRAWS] */
    double *values; /* [rows of all items][DRAWS] */
    double *mapped, *left;
    int count, chosen;
    candidate *candidates;     /* [count] */
    int order[GROUP_ROWS_MAX]; /* [chosen] candidates */
    double *slopes; /* [parameters][chosen][DRAWS] of what is mapped, by a unit of the range */
    ad_memory memory;
} search;

static double dot(const double *a, const double *b)
{
    double sum = 0;
    for (int i = 0; i < DRAWS; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

static ad_status make_candidate(search *search, int item, int entry, int index, ad_error *error)
{
    const group_item *of = &search->list.items[item];
    const double *v = search->values + (size_t)index * DRAWS;
    candidate *c = &search->candidates[index];
    double low = v[0], high = v[0], mean = 0;
    for (int i = 0; i < DRAWS; i++) {
        if (!isfinite(v[i])) {
            return ad_fail(error, AD_BAD_INPUT,
                           "groups: %s is not a number for members within the ranges", of->name);
        }
        low = fmin(low, v[i]);
        high = fmax(high, v[i]);
    }
    const bool is_number = of->kind == GROUP_SCALAR || of->kind == GROUP_TENSOR;
    const bool is_wide = is_number && low > 0 && high > DECADES * low;
    const bool is_log = of->as_it_is ? of->is_log : is_wide;
    const double change = (high - low) / 2, size = fmax(fabs(low), fabs(high));
    low = is_log ? log(low) : low;
    high = is_log ? log(high) : high;
    const double half = (high - low) / 2;
    *c = (candidate){.row = {.item = item,
                             .entry = entry,
                             .is_log = is_log,
                             .low = low,
                             .high = high,
                             .effect = of->effect[entry < 3 ? entry : 2] * change,
                             .of = *of},
                     .mapped = search->mapped + (size_t)index * DRAWS,
                     .left = search->left + (size_t)index * DRAWS};
    const bool is_left = of->kind == GROUP_PULL && search->x->symmetry.off > 0;
    c->is_out = is_left || !(change > CONSTANT * size) || !(c->row.effect > UNMOVED);
    for (int i = 0; i < DRAWS; i++) {
        c->mapped[i] = c->is_out ? 0 : ((is_log ? log(v[i]) : v[i]) - low) / half - 1;
        mean += c->mapped[i] / DRAWS;
    }
    for (int i = 0; i < DRAWS; i++) {
        c->left[i] = c->mapped[i] - mean;
    }
    c->size = sqrt(dot(c->left, c->left));
    return AD_OK;
}

static ad_status make_candidates(search *search, ad_error *error)
{
    int index = 0;
    ad_status status = AD_OK;
    for (int i = 0; i < search->list.count; i++) {
        for (int k = 0; k < search->list.items[i].rows && status == AD_OK; k++) {
            status = make_candidate(search, i, k, index++, error);
        }
    }
    return status;
}

/* Gram and Schmidt with the row first that moves the rod most beyond what is known: rows that are
 * linear in others are out. */
static void choose_linear(search *search)
{
    static const double tie = 1 + 1e-6; /* the first of equals, whatever the rounding */
    while (search->chosen < GROUP_ROWS_MAX) {
        double most = 0;
        int best = -1;
        for (int i = 0; i < search->count; i++) {
            candidate *c = &search->candidates[i];
            const double share = c->is_out ? 0 : sqrt(dot(c->left, c->left)) / c->size;
            c->is_out = c->is_out || share < LINEAR || share * c->row.effect < UNMOVED;
            if (!c->is_out && share * c->row.effect > most * tie) {
                most = share * c->row.effect;
                best = i;
            }
        }
        if (best < 0) {
            return;
        }
        const double *of = search->candidates[best].left, square = dot(of, of);
        search->order[search->chosen++] = best;
        search->candidates[best].is_out = true; /* chosen */
        for (int i = 0; i < search->count; i++) {
            candidate *c = &search->candidates[i];
            const double part = c->is_out ? 0 : dot(c->left, of) / square;
            for (int k = 0; k < DRAWS && !c->is_out; k++) {
                c->left[k] -= part * of[k];
            }
        }
    }
}

/* What a row is, mapped to -1 .. 1. */
static ad_value record_row(const group_row *r, const group_list *list)
{
    const ad_value value = ad_row(list->items[r->item].value, r->entry);
    const ad_value middle = ad_scalar(value.tape, (r->low + r->high) / 2);
    return ad_scale(ad_sub(r->is_log ? ad_log(value) : value, middle), 2 / (r->high - r->low));
}

/* By a step of parameter k over its whole range. */
static ad_status find_slopes(search *search, ad_error *error)
{
    const scene *family = &search->x->source.open;
    ad_value rows[GROUP_ROWS_MAX];
    for (int i = 0; i < search->chosen; i++) {
        rows[i] = record_row(&search->candidates[search->order[i]].row, &search->list);
    }
    const ad_value all = ad_stack(search->chosen, rows);
    const size_t block = (size_t)search->chosen * DRAWS;
    ad_status status = AD_OK;
    for (int k = 0; k < family->parameter_count && status == AD_OK; k++) {
        const scene_parameter *p = &family->parameters[k];
        const ad_value range = p->scale == SCENE_LOG
                                   ? ad_scale(ad_row(search->parameters, k), log(p->high / p->low))
                                   : ad_scalar(search->tape, p->high - p->low);
        const ad_value along = ad_pad(range, k, family->parameter_count);
        ad_value slope;
        status = ad_directional(1, &all, 1, &search->parameters, &along, &slope);
        status = status == AD_OK ? ad_tape_status(search->tape, error)
                                 : ad_fail(error, status, "groups: no derivatives");
        status = status == AD_OK
                     ? evaluate(slope, search->draws, search->slopes + (size_t)k * block, error)
                     : status;
    }
    return status;
}

static double slope_at(const search *search, int parameter, int chosen, int i)
{
    return search
        ->slopes[((size_t)parameter * (size_t)search->chosen + (size_t)chosen) * DRAWS + (size_t)i];
}

/* Symmetric and positive definite [n][n], overwritten; b becomes the solution. */
static void solve_small(int n, double a[SCENE_PARAMETERS_MAX][SCENE_PARAMETERS_MAX], double *b)
{
    for (int k = 0; k < n; k++) {
        for (int i = k + 1; i < n; i++) {
            const double by = a[i][k] / a[k][k];
            for (int j = k; j < n; j++) {
                a[i][j] -= by * a[k][j];
            }
            b[i] -= by * b[k];
        }
    }
    for (int i = n; i-- > 0;) {
        for (int j = i + 1; j < n; j++) {
            b[i] -= a[i][j] * b[j];
        }
        b[i] /= a[i][i];
    }
}

/* Whether the slopes of row `which` are combinations w of those kept, none steep: of the least
 * |w|, by (G G^T + SLOPE^2) y = g, w = G^T y, with what is left of g, SLOPE^2 y. */
static bool slope_follows(const search *search, const int *kept, int count, int which, int i)
{
    const int n = search->x->source.open.parameter_count;
    double a[SCENE_PARAMETERS_MAX][SCENE_PARAMETERS_MAX], y[SCENE_PARAMETERS_MAX], steep = 0;
    double rest = 0;
    for (int k = 0; k < n; k++) {
        y[k] = slope_at(search, k, which, i);
        for (int l = 0; l < n; l++) {
            a[k][l] = k == l ? SLOPE * SLOPE : 0;
            for (int j = 0; j < count; j++) {
                a[k][l] += slope_at(search, k, kept[j], i) * slope_at(search, l, kept[j], i);
            }
        }
    }
    solve_small(n, a, y);
    for (int j = 0; j < count; j++) {
        double w = 0;
        for (int k = 0; k < n; k++) {
            w += slope_at(search, k, kept[j], i) * y[k];
        }
        steep += w * w;
    }
    for (int k = 0; k < n; k++) {
        rest += SLOPE * SLOPE * y[k] * SLOPE * SLOPE * y[k];
    }
    return sqrt(steep) <= STEEPEST && sqrt(rest) <= SLOPE;
}

/* Whether members that are close by those kept are so by row `which`. */
static bool pair_follows(const search *search, const int *kept, int count, int which, int a, int b)
{
    const double *v = search->candidates[search->order[which]].mapped;
    double square = 0;
    for (int j = 0; j < count; j++) {
        const double *g = search->candidates[search->order[kept[j]]].mapped;
        square += (g[a] - g[b]) * (g[a] - g[b]);
    }
    return fabs(v[a] - v[b]) <= STEEPEST * sqrt(square) + SLOPE;
}

static bool follows(const search *search, const int *kept, int count, int which)
{
    bool result = count > 0;
    for (int i = 0; i < DRAWS && result; i++) {
        result = slope_follows(search, kept, count, which, i);
    }
    for (int i = 0; i < DRAWS && result; i++) {
        for (int k = 0; k < i && result; k++) {
            result = pair_follows(search, kept, count, which, i, k);
        }
    }
    return result;
}

static unsigned parameters_of(const search *search, int which)
{
    unsigned bits = 0;
    for (int k = 0; k < search->x->source.open.parameter_count; k++) {
        for (int i = 0; i < DRAWS; i++) {
            bits |= fabs(slope_at(search, k, which, i)) > CONSTANT ? 1U << k : 0;
        }
    }
    return bits;
}

/* Whether the same of another place differs. */
static bool is_local(const search *search, const group_row *r)
{
    const double *v = NULL;
    bool differs = false;
    for (int pass = 0; pass < 2; pass++) {
        int index = 0;
        for (int i = 0; i < search->list.count; i++) {
            const group_item *other = &search->list.items[i];
            if (strcmp(other->name, r->of.name) == 0 && r->entry < other->rows) {
                const double *w = search->values + (size_t)(index + r->entry) * DRAWS;
                for (int k = 0; k < DRAWS && pass == 1; k++) {
                    differs = differs || fabs(w[k] - v[k]) > CONSTANT * fabs(v[k]);
                }
                v = i == r->item ? w : v;
            }
            index += other->rows;
        }
    }
    return differs;
}

static void choose(search *search)
{
    groups *g = search->x;
    int kept[GROUP_ROWS_MAX];
    double most = 0;
    for (int i = 0; i < search->chosen; i++) {
        if (!follows(search, kept, g->count, i)) {
            group_row *r = &g->rows[g->count];
            *r = search->candidates[search->order[i]].row;
            r->parameters = parameters_of(search, i);
            r->is_local = is_local(search, r);
            most = fmax(most, r->effect);
            kept[g->count++] = i;
        }
    }
    const bool many = g->count > FEW;
    for (int i = 0; i < g->count; i++) {
        g->rows[i].scale = fmax(WEAKEST[many], pow(g->rows[i].effect / most, WEAKER[many]));
    }
}

/* ---- making ---------------------------------------------------------------------------------- */

static ad_status allocate(search *search, ad_error *error)
{
    const size_t parameters = (size_t)search->x->source.open.parameter_count;
    size_t rows = 0;
    for (int i = 0; i < search->list.count; i++) {
        rows += (size_t)search->list.items[i].rows;
    }
    search->count = (int)rows;
    AD_TAKE(search, values, (rows + 1) * DRAWS);
    AD_TAKE(search, mapped, (rows + 1) * DRAWS);
    AD_TAKE(search, left, (rows + 1) * DRAWS);
    AD_TAKE(search, slopes, (parameters * GROUP_ROWS_MAX + 1) * DRAWS);
    AD_TAKE(search, candidates, rows + 1);
    return ad_memory_status(&search->memory, error, "out of memory for groups");
}

/* Items, with the symmetry of the groups in them. */
static ad_status record_items(search *search, ad_error *error)
{
    groups_turn turn;
    group_items(&search->x->source, search->parameters, &search->list);
    group_symmetry_apply(&search->x->symmetry, &search->list, &turn);
    return ad_tape_status(search->tape, error);
}

static ad_status find_values(search *search, ad_error *error)
{
    const ad_value all = stack_items(&search->list, search->tape);
    const ad_status status = ad_tape_status(search->tape, error);
    return status == AD_OK ? evaluate(all, search->draws, search->values, error) : status;
}

static void clear(search *search)
{
    free(search->list.items);
    ad_memory_free(&search->memory);
    search->list = (group_list){.count = 0};
    search->values = search->mapped = search->left = search->slopes = NULL;
    search->candidates = NULL;
    search->count = search->chosen = 0;
}

static ad_status find_rows(search *search, ad_error *error)
{
    ad_status status = record_items(search, error);
    status = status == AD_OK ? allocate(search, error) : status;
    status = status == AD_OK ? find_values(search, error) : status;
    status = status == AD_OK ? make_candidates(search, error) : status;
    search->x->count = 0;
    if (status == AD_OK) {
        choose_linear(search);
        status = search->chosen > 0 ? find_slopes(search, error) : AD_OK;
    }
    if (status == AD_OK) {
        choose(search);
    }
    clear(search);
    return status;
}

static ad_status find_symmetry(search *search, bool nearly, ad_error *error)
{
    search->x->symmetry = GROUP_NO_TURN; /* of the items as they are */
    ad_status status = record_items(search, error);
    status = status == AD_OK ? allocate(search, error) : status;
    status = status == AD_OK ? find_values(search, error) : status;
    if (status == AD_OK) {
        group_symmetry_find(nearly, &search->x->source, &search->list, DRAWS, search->values,
                            &search->x->symmetry);
    }
    clear(search);
    return status;
}

/* A parameter among the inputs as it is may say of a vector what a turn changes. */
static bool has_parameter(const groups *groups)
{
    bool result = false;
    for (int i = 0; i < groups->count; i++) {
        result = result || groups->rows[i].of.kind == GROUP_PARAMETER;
    }
    return result;
}

static ad_status find(groups *groups, const groups_settings *settings, ad_error *error)
{
    const size_t parameters = (size_t)groups->source.open.parameter_count;
    search now = {.x = groups, .tape = ad_tape_create()};
    now.draws = malloc((parameters + 1) * DRAWS * sizeof *now.draws);
    ad_status status = AD_OK;
    if (!now.tape || !now.draws) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for groups");
    } else {
        draw(&groups->source.open, now.draws);
        now.parameters = ad_input(now.tape, "parameters", (int)parameters);
        const bool any = !groups->source.by_parameters && settings->symmetry != GROUPS_NO_SYMMETRY;
        status = any ? find_symmetry(&now, false, error) : AD_OK;
        status = status == AD_OK ? find_rows(&now, error) : status;
        if (status == AD_OK && any && settings->symmetry == GROUPS_SYMMETRY &&
            groups->count > FEW) {
            status = find_symmetry(&now, true, error);
            status = status == AD_OK ? find_rows(&now, error) : status;
        }
        if (status == AD_OK && group_symmetry_any(&groups->symmetry) && has_parameter(groups)) {
            groups->symmetry = GROUP_NO_TURN;
            status = find_rows(&now, error);
        }
    }
    free(now.draws);
    ad_tape_free(now.tape);
    return status;
}

ad_status groups_find(const scene *family, const groups_settings *settings, groups **result,
                      ad_error *error)
{
    *result = NULL;
    if (family->parameter_count == 0) {
        return ad_fail(error, AD_BAD_ARGUMENT, "groups: a scene without parameters");
    }
    groups *x = calloc(1, sizeof *x);
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for groups");
    }
    x->symmetry = GROUP_NO_TURN;
    ad_status status =
        group_source_fill(family, settings->inputs == GROUPS_PARAMETERS, &x->source, error);
    status = status == AD_OK ? find(x, settings, error) : status;
    if (status != AD_OK) {
        groups_free(x);
        return status;
    }
    if (x->count == 0 &&
        !x->source.by_parameters) { /* nothing bends the rod: a network has inputs */
        const groups_settings own = {.inputs = GROUPS_PARAMETERS, .symmetry = GROUPS_NO_SYMMETRY};
        groups_free(x);
        return groups_find(family, &own, result, error);
    }
    *result = x;
    return AD_OK;
}

void groups_free(groups *groups)
{
    free(groups);
}

int groups_count(const groups *groups)
{
    return groups->count;
}

double groups_range(const groups *groups, int input)
{
    return groups->rows[input].scale;
}

ad_value groups_record(const groups *groups, ad_value parameters, groups_turn *turn)
{
    group_list list;
    groups_turn unused;
    ad_value inputs[GROUP_ROWS_MAX];
    group_items(&groups->source, parameters, &list);
    group_symmetry_apply(&groups->symmetry, &list, turn ? turn : &unused);
    for (int i = 0; i < groups->count; i++) {
        const group_row *r = &groups->rows[i];
        if (r->item >= list.count) { /* out of memory, as the tape says */
            free(list.items);
            return ad_zeros(parameters.tape, groups->count);
        }
        inputs[i] = ad_scale(record_row(r, &list), r->scale);
    }
    free(list.items);
    return ad_stack(groups->count, inputs);
}
