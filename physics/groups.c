/* Which of the numbers that the equations are given say which member it is. */
#include "physics/groups.h"

#include "nn/rng.h"
#include "physics/groups_internal.h"

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
static ad_status evaluate(ad_value value, ad_value parameters, const double *draws, double *out,
                          ad_error *error)
{
    ad_pool *pool = ad_pool_create(1);
    ad_program *program = NULL;
    ad_status status = pool ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for groups");
    /* of every draw, also where it is the same for all */
    const ad_value on_all = ad_stack(2, (ad_value[]){value, ad_row(parameters, 0)});
    double *all = malloc(((size_t)ad_rows(on_all) + 1) * DRAWS * sizeof *all);
    if (status == AD_OK && !all) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for groups");
    }
    status = status == AD_OK ? ad_compile(1, &on_all, NULL, pool, &program, error) : status;
    if (status == AD_OK) {
        const ad_run run = {.points = DRAWS, .inputs = &draws, .outputs = &all};
        status = ad_execute(program, &run, error);
    }
    if (status == AD_OK) {
        memcpy(out, all, (size_t)ad_rows(value) * DRAWS * sizeof *out);
    }
    free(all);
    ad_program_free(program);
    ad_pool_free(pool);
    return status;
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
} search;

static double dot(const double *a, const double *b)
{
    double sum = 0;
    for (int i = 0; i < DRAWS; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

static ad_status make_candidate(search *x, int item, int entry, int index, ad_error *error)
{
    const group_item *of = &x->list.items[item];
    const double *v = x->values + (size_t)index * DRAWS;
    candidate *c = &x->candidates[index];
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
                     .mapped = x->mapped + (size_t)index * DRAWS,
                     .left = x->left + (size_t)index * DRAWS};
    const bool is_left = of->kind == GROUP_PULL && x->x->symmetry.off > 0;
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

static ad_status make_candidates(search *x, ad_error *error)
{
    int index = 0;
    ad_status status = AD_OK;
    for (int i = 0; i < x->list.count; i++) {
        for (int k = 0; k < x->list.items[i].rows && status == AD_OK; k++) {
            status = make_candidate(x, i, k, index++, error);
        }
    }
    return status;
}

/* Gram and Schmidt with the row first that moves the rod most beyond what is known: rows that are
 * linear in others are out. */
static void choose_linear(search *x)
{
    static const double tie = 1 + 1e-6; /* the first of equals, whatever the rounding */
    while (x->chosen < GROUP_ROWS_MAX) {
        double most = 0;
        int best = -1;
        for (int i = 0; i < x->count; i++) {
            candidate *c = &x->candidates[i];
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
        const double *of = x->candidates[best].left, square = dot(of, of);
        x->order[x->chosen++] = best;
        x->candidates[best].is_out = true; /* chosen */
        for (int i = 0; i < x->count; i++) {
            candidate *c = &x->candidates[i];
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
static ad_status find_slopes(search *x, ad_error *error)
{
    const scene *family = &x->x->source.open;
    ad_value rows[GROUP_ROWS_MAX];
    for (int i = 0; i < x->chosen; i++) {
        rows[i] = record_row(&x->candidates[x->order[i]].row, &x->list);
    }
    const ad_value all = ad_stack(x->chosen, rows);
    const size_t block = (size_t)x->chosen * DRAWS;
    ad_status status = AD_OK;
    for (int k = 0; k < family->parameter_count && status == AD_OK; k++) {
        const scene_parameter *p = &family->parameters[k];
        const ad_value range = p->scale == SCENE_LOG
                                   ? ad_scale(ad_row(x->parameters, k), log(p->high / p->low))
                                   : ad_scalar(x->tape, p->high - p->low);
        const ad_value along = ad_pad(range, k, family->parameter_count);
        ad_value slope;
        status = ad_directional(1, &all, 1, &x->parameters, &along, &slope);
        status = status == AD_OK ? ad_tape_status(x->tape, error)
                                 : ad_fail(error, status, "groups: no derivatives");
        status = status == AD_OK ? evaluate(slope, x->parameters, x->draws,
                                            x->slopes + (size_t)k * block, error)
                                 : status;
    }
    return status;
}

static double slope_at(const search *x, int parameter, int chosen, int i)
{
    return x->slopes[((size_t)parameter * (size_t)x->chosen + (size_t)chosen) * DRAWS + (size_t)i];
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
static bool slope_follows(const search *x, const int *kept, int count, int which, int i)
{
    const int n = x->x->source.open.parameter_count;
    double a[SCENE_PARAMETERS_MAX][SCENE_PARAMETERS_MAX], y[SCENE_PARAMETERS_MAX], steep = 0;
    double rest = 0;
    for (int k = 0; k < n; k++) {
        y[k] = slope_at(x, k, which, i);
        for (int l = 0; l < n; l++) {
            a[k][l] = k == l ? SLOPE * SLOPE : 0;
            for (int j = 0; j < count; j++) {
                a[k][l] += slope_at(x, k, kept[j], i) * slope_at(x, l, kept[j], i);
            }
        }
    }
    solve_small(n, a, y);
    for (int j = 0; j < count; j++) {
        double w = 0;
        for (int k = 0; k < n; k++) {
            w += slope_at(x, k, kept[j], i) * y[k];
        }
        steep += w * w;
    }
    for (int k = 0; k < n; k++) {
        rest += SLOPE * SLOPE * y[k] * SLOPE * SLOPE * y[k];
    }
    return sqrt(steep) <= STEEPEST && sqrt(rest) <= SLOPE;
}

/* Whether members that are close by those kept are so by row `which`. */
static bool pair_follows(const search *x, const int *kept, int count, int which, int a, int b)
{
    const double *v = x->candidates[x->order[which]].mapped;
    double square = 0;
    for (int j = 0; j < count; j++) {
        const double *g = x->candidates[x->order[kept[j]]].mapped;
        square += (g[a] - g[b]) * (g[a] - g[b]);
    }
    return fabs(v[a] - v[b]) <= STEEPEST * sqrt(square) + SLOPE;
}

static bool follows(const search *x, const int *kept, int count, int which)
{
    bool result = count > 0;
    for (int i = 0; i < DRAWS && result; i++) {
        result = slope_follows(x, kept, count, which, i);
    }
    for (int i = 0; i < DRAWS && result; i++) {
        for (int k = 0; k < i && result; k++) {
            result = pair_follows(x, kept, count, which, i, k);
        }
    }
    return result;
}

static unsigned parameters_of(const search *x, int which)
{
    unsigned bits = 0;
    for (int k = 0; k < x->x->source.open.parameter_count; k++) {
        for (int i = 0; i < DRAWS; i++) {
            bits |= fabs(slope_at(x, k, which, i)) > CONSTANT ? 1U << k : 0;
        }
    }
    return bits;
}

/* Whether the same of another place differs. */
static bool is_local(const search *x, const group_row *r)
{
    const double *v = NULL;
    bool differs = false;
    for (int pass = 0; pass < 2; pass++) {
        int index = 0;
        for (int i = 0; i < x->list.count; i++) {
            const group_item *other = &x->list.items[i];
            if (strcmp(other->name, r->of.name) == 0 && r->entry < other->rows) {
                const double *w = x->values + (size_t)(index + r->entry) * DRAWS;
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

static void choose(search *x)
{
    groups *g = x->x;
    int kept[GROUP_ROWS_MAX];
    double most = 0;
    for (int i = 0; i < x->chosen; i++) {
        if (!follows(x, kept, g->count, i)) {
            group_row *r = &g->rows[g->count];
            *r = x->candidates[x->order[i]].row;
            r->parameters = parameters_of(x, i);
            r->is_local = is_local(x, r);
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

static ad_status allocate(search *x, ad_error *error)
{
    const size_t parameters = (size_t)x->x->source.open.parameter_count;
    size_t rows = 0;
    for (int i = 0; i < x->list.count; i++) {
        rows += (size_t)x->list.items[i].rows;
    }
    x->count = (int)rows;
    x->values = malloc((rows + 1) * DRAWS * sizeof *x->values);
    x->mapped = malloc((rows + 1) * DRAWS * sizeof *x->mapped);
    x->left = malloc((rows + 1) * DRAWS * sizeof *x->left);
    x->slopes = malloc((parameters * GROUP_ROWS_MAX + 1) * DRAWS * sizeof *x->slopes);
    x->candidates = calloc(rows + 1, sizeof *x->candidates);
    return x->values && x->mapped && x->left && x->slopes && x->candidates
               ? AD_OK
               : ad_fail(error, AD_NO_MEMORY, "out of memory for groups");
}

/* Items, with the symmetry of the groups in them. */
static ad_status record_items(search *x, ad_error *error)
{
    groups_turn turn;
    group_items(&x->x->source, x->parameters, &x->list);
    group_symmetry_apply(&x->x->symmetry, &x->list, &turn);
    return ad_tape_status(x->tape, error);
}

static ad_status find_values(search *x, ad_error *error)
{
    const ad_value all = stack_items(&x->list, x->tape);
    const ad_status status = ad_tape_status(x->tape, error);
    return status == AD_OK ? evaluate(all, x->parameters, x->draws, x->values, error) : status;
}

static void clear(search *x)
{
    free(x->list.items);
    free(x->values);
    free(x->mapped);
    free(x->left);
    free(x->slopes);
    free(x->candidates);
    x->list = (group_list){.count = 0};
    x->values = x->mapped = x->left = x->slopes = NULL;
    x->candidates = NULL;
    x->count = x->chosen = 0;
}

static ad_status find_rows(search *x, ad_error *error)
{
    ad_status status = record_items(x, error);
    status = status == AD_OK ? allocate(x, error) : status;
    status = status == AD_OK ? find_values(x, error) : status;
    status = status == AD_OK ? make_candidates(x, error) : status;
    x->x->count = 0;
    if (status == AD_OK) {
        choose_linear(x);
        status = x->chosen > 0 ? find_slopes(x, error) : AD_OK;
    }
    if (status == AD_OK) {
        choose(x);
    }
    clear(x);
    return status;
}

static ad_status find_symmetry(search *x, bool nearly, ad_error *error)
{
    x->x->symmetry = GROUP_NO_TURN; /* of the items as they are */
    ad_status status = record_items(x, error);
    status = status == AD_OK ? allocate(x, error) : status;
    status = status == AD_OK ? find_values(x, error) : status;
    if (status == AD_OK) {
        group_symmetry_find(nearly, &x->x->source, &x->list, DRAWS, x->values, &x->x->symmetry);
    }
    clear(x);
    return status;
}

/* A parameter among the inputs as it is may say of a vector what a turn changes. */
static bool has_parameter(const groups *x)
{
    bool result = false;
    for (int i = 0; i < x->count; i++) {
        result = result || x->rows[i].of.kind == GROUP_PARAMETER;
    }
    return result;
}

static ad_status find(groups *x, const groups_settings *settings, ad_error *error)
{
    const size_t parameters = (size_t)x->source.open.parameter_count;
    search now = {.x = x, .tape = ad_tape_create()};
    now.draws = malloc((parameters + 1) * DRAWS * sizeof *now.draws);
    ad_status status = AD_OK;
    if (!now.tape || !now.draws) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for groups");
    } else {
        draw(&x->source.open, now.draws);
        now.parameters = ad_input(now.tape, "parameters", (int)parameters);
        const bool any = !x->source.by_parameters && settings->symmetry != GROUPS_NO_SYMMETRY;
        status = any ? find_symmetry(&now, false, error) : AD_OK;
        status = status == AD_OK ? find_rows(&now, error) : status;
        if (status == AD_OK && any && settings->symmetry == GROUPS_SYMMETRY && x->count > FEW) {
            status = find_symmetry(&now, true, error);
            status = status == AD_OK ? find_rows(&now, error) : status;
        }
        if (status == AD_OK && group_symmetry_any(&x->symmetry) && has_parameter(x)) {
            x->symmetry = GROUP_NO_TURN;
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
    *result = x;
    return AD_OK;
}

void groups_free(groups *x)
{
    free(x);
}

int groups_count(const groups *x)
{
    return x->count;
}

double groups_range(const groups *x, int input)
{
    return x->rows[input].scale;
}

ad_value groups_record(const groups *x, ad_value parameters, groups_turn *turn)
{
    group_list list;
    groups_turn unused;
    ad_value inputs[GROUP_ROWS_MAX];
    group_items(&x->source, parameters, &list);
    group_symmetry_apply(&x->symmetry, &list, turn ? turn : &unused);
    for (int i = 0; i < x->count; i++) {
        const group_row *r = &x->rows[i];
        if (r->item >= list.count) { /* out of memory, as the tape says */
            free(list.items);
            return ad_zeros(parameters.tape, x->count);
        }
        inputs[i] = ad_scale(record_row(r, &list), r->scale);
    }
    free(list.items);
    return ad_stack(x->count, inputs);
}
