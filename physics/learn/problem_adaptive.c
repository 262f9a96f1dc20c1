/* Points inside that go where residuals are large. The three ways stand in problem.h. */
#include "physics/learn/problem_internal.h"

#include <math.h>
#include <stdlib.h>

enum { CANDIDATES = 10, AROUND = 10, ROUNDS = 10 }; /* a point; a centre; of rar_g */

const char *problem_adaptive_check(const problem_settings *settings)
{
    const problem_adaptive *a = &settings->adaptive;
    if ((unsigned)a->kind >= PROBLEM_ADAPTIVE_COUNT || a->every < 1 || a->candidates < 0) {
        return "adaptive: a kind of the list, every: at least 1, candidates: at least 0";
    }
    if (!(a->power > 0 && isfinite(a->power)) || !(a->floor >= 0 && isfinite(a->floor)) ||
        !(a->width > 0 && a->width <= 1)) {
        return "adaptive: power above 0, floor at least 0, width above 0, at most 1";
    }
    if (a->kind && settings->interior.resample_every) {
        return "adaptive: none with interior.resample_every";
    }
    return NULL;
}

void problem_set_forget_candidates(problem_set *set)
{
    free(set->candidates.x);
    free(set->candidate_squares);
    free(set->ranked);
    set->candidates = (problem_cloud){.x = NULL};
    set->candidate_squares = NULL;
    set->ranked = NULL;
}

/* ---- candidates ---------------------------------------------------------------------------- */

static ad_status make_candidates(problem *p, problem_set *set, ad_error *error)
{
    const problem_adaptive *a = &p->settings.adaptive;
    size_t least = set->trained.count, wanted = (size_t)a->candidates;
    wanted = wanted > 0 ? wanted : CANDIDATES * least;
    const problem_points points = {(int)(wanted > least ? wanted : least), SAMPLING_SOBOL, 0};
    ad_status status =
        problem_cloud_make(p, set, &set->candidates, &points, false, &set->rng, error);
    if (status != AD_OK) {
        return status;
    }
    size_t count = set->candidates.count;
    set->candidate_squares =
        malloc((size_t)set->term_count * count * sizeof *set->candidate_squares);
    set->ranked = malloc(count * sizeof *set->ranked);
    if (!set->candidate_squares || !set->ranked) {
        problem_set_forget_candidates(set);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu candidates", count);
    }
    return AD_OK;
}

/* New candidates with their residuals as keys. */
static ad_status draw(problem *p, problem_set *set, const double *x, ad_error *error)
{
    problem_cloud *cloud = &set->candidates;
    ad_status status = cloud->x
                           ? problem_cloud_fill(p, set, cloud, SAMPLING_SOBOL, &set->rng, error)
                           : make_candidates(p, set, error);
    status = status == AD_OK ? problem_set_squares(set, cloud, x, set->candidate_squares, error)
                             : status;
    for (size_t k = 0; status == AD_OK && k < cloud->count; k++) {
        double square = 0;
        for (int i = 0; i < set->term_count; i++) {
            square += p->terms[set->terms[i]]->weight *
                      set->candidate_squares[(size_t)i * cloud->count + k];
        }
        set->ranked[k] = (problem_candidate){sqrt(square), k};
        if (!isfinite(square)) {
            return ad_fail(error, AD_NOT_FINITE,
                           "a residual is not finite at a candidate for adaptive points");
        }
    }
    return status;
}

static int by_key(const void *one, const void *other)
{
    const problem_candidate *a = one, *b = other;
    return a->key != b->key ? (a->key < b->key) - (a->key > b->key)
                            : (a->index > b->index) - (a->index < b->index);
}

static int by_index(const void *one, const void *other)
{
    const problem_candidate *a = one, *b = other;
    return (a->index > b->index) - (a->index < b->index);
}

/* The first `count` of the ranked ones are then those of the largest keys, in the order in which
 * they were drawn. */
static void choose(problem_set *set, size_t count)
{
    qsort(set->ranked, set->candidates.count, sizeof *set->ranked, by_key);
    qsort(set->ranked, count, sizeof *set->ranked, by_index);
}

/* Candidate `chosen` becomes point `to`. */
static void take(const problem *p, problem_set *set, size_t chosen, size_t to)
{
    const problem_cloud *from = &set->candidates;
    for (int i = 0; i < p->model->domain.count; i++) {
        set->trained.x[(size_t)i * set->trained.count + to] =
            from->x[(size_t)i * from->count + set->ranked[chosen].index];
    }
}

/* ---- the three ways ------------------------------------------------------------------------ */

/* Without replacement by weights w: those of the largest log(uniform)/w (Efraimidis and Spirakis
 * 2006). */
static void move_by_density(problem *p, problem_set *set)
{
    const problem_adaptive *a = &p->settings.adaptive;
    size_t count = set->candidates.count;
    double mean = 0;
    for (size_t k = 0; k < count; k++) {
        set->ranked[k].key = pow(set->ranked[k].key, a->power);
        mean += set->ranked[k].key / (double)count;
    }
    for (size_t k = 0; k < count; k++) {
        double weight = (mean > 0 ? set->ranked[k].key / mean : 1) + a->floor;
        double chance = log(1 - nn_rng_uniform(&set->rng));
        set->ranked[k].key = weight > 0 ? chance / weight : -INFINITY;
    }
    choose(set, set->trained.count);
    for (size_t k = 0; k < set->trained.count; k++) {
        take(p, set, k, k);
    }
}

/* Half of the points of each piece may move, so that the others still cover it: the second half of
 * a sequence, of which every other point leaves parts of a cube empty, and every other one of a
 * grid. movable_point: the index of one of them, 0 to movable_count - 1, pieces in turn. */
static size_t movable_count(const problem *p, const problem_set *set)
{
    size_t pieces = (size_t)domain_pieces(&p->model->domain);
    return pieces * (set->trained.count / pieces / 2);
}

static size_t movable_point(const problem *p, const problem_set *set, size_t which)
{
    size_t pieces = (size_t)domain_pieces(&p->model->domain), each = set->trained.count / pieces;
    bool grid = sampling_kind_is_tensor(p->settings.interior.sampler);
    size_t within = grid ? 2 * (which / pieces) + 1 : each - each / 2 + which / pieces;
    return which % pieces * each + within;
}

/* The next tenth of those that may move. */
static void move_by_greed(const problem *p, problem_set *set, int64_t round)
{
    size_t half = movable_count(p, set);
    size_t first = half * (size_t)(round - 1) / ROUNDS, last = half * (size_t)round / ROUNDS;
    choose(set, last - first);
    for (size_t k = first; k < last; k++) {
        take(p, set, k - first, movable_point(p, set, k));
    }
}

/* The piece of the first coordinate that x lies in. */
static int piece_at(const domain *d, double x)
{
    int piece = 0;
    double low, high;
    for (int i = 1; i < domain_pieces(d); i++) {
        domain_piece(d, i, &low, &high);
        piece = x > low ? i : piece;
    }
    return piece;
}

/* Around x; what falls outside is reflected, and put at the edge if it lies far outside. */
static double around(problem *p, problem_set *set, int coordinate, double x)
{
    const domain *d = &p->model->domain;
    int last = domain_pieces(d) - 1, piece = coordinate == 0 ? piece_at(d, x) : 0;
    double range = problem_placed(p, coordinate, last, 1) - problem_placed(p, coordinate, 0, 0);
    double low = problem_placed(p, coordinate, piece, 0);
    double high = problem_placed(p, coordinate, piece, 1);
    x += p->settings.adaptive.width * range * nn_rng_normal(&set->rng);
    x = x < low ? 2 * low - x : x > high ? 2 * high - x : x;
    return fmin(fmax(x, low), high);
}

static void move_by_gaussians(problem *p, problem_set *set)
{
    size_t half = movable_count(p, set), centres = (half + AROUND - 1) / AROUND;
    choose(set, centres);
    for (size_t k = 0; k < half; k++) {
        size_t to = movable_point(p, set, k), count = set->trained.count;
        take(p, set, k / AROUND, to);
        for (int i = 0; i < p->model->domain.count; i++) {
            double *x = &set->trained.x[(size_t)i * count + to];
            *x = around(p, set, i, *x);
        }
    }
}

/* What is known of points beside their coordinates is not known of candidates. */
bool problem_set_adapts(const problem *p, const problem_set *set, int64_t step)
{
    const problem_adaptive *a = &p->settings.adaptive;
    bool due = step > 1 && (step - 1) % a->every == 0;
    bool settled = a->kind == PROBLEM_ADAPTIVE_RAR_G && (step - 1) / a->every > ROUNDS;
    bool inside = set->about->points == MODEL_INTERIOR && !set->about->source.fill;
    return a->kind && due && !settled && inside;
}

ad_status problem_set_adapt(problem *p, problem_set *set, int64_t step, const double *x,
                            ad_error *error)
{
    ad_status status = draw(p, set, x, error);
    if (status != AD_OK) {
        return status;
    }
    switch (p->settings.adaptive.kind) {
    case PROBLEM_ADAPTIVE_RAD:
        move_by_density(p, set);
        break;
    case PROBLEM_ADAPTIVE_RAR_G:
        move_by_greed(p, set, (step - 1) / p->settings.adaptive.every);
        break;
    default:
        move_by_gaussians(p, set);
    }
    set->trained.drawn.still = false;
    problem_set_refresh(set);
    return AD_OK;
}
