/* The points of a set: drawn in the unit cube, moved to the domain and to the window at work. */
#include "physics/learn/problem_internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Coordinates that vary over the set, in their order. */
static int varying(const problem *p, const problem_set *set, int *which)
{
    int count = 0;
    for (int i = 0; i < p->model->domain.count; i++) {
        if (!set->about->holds[i]) {
            which[count++] = i;
        }
    }
    return count;
}

/* Where pieces and windows end at jumps points keep off, by more than rounding and less than
 * counts, so that what jumps has the value that it has within. */
double problem_placed(const problem *p, int coordinate, int piece, double x)
{
    static const double OFF = 1e-9;
    const domain *d = &p->model->domain;
    double low = d->coordinates[coordinate].low, high = d->coordinates[coordinate].high;
    bool in_pieces = coordinate == 0 && domain_pieces(d) > 1;
    if (coordinate == d->time) {
        low = domain_window_time(d, p->window);
        high = domain_window_time(d, p->window + 1);
    } else if (in_pieces) {
        domain_piece(d, piece, &low, &high);
    }
    if (in_pieces || (coordinate == d->time && d->divided)) {
        x = fmin(fmax(x, OFF), 1 - OFF);
    }
    return d->coordinates[coordinate].logarithmic
               ? domain_coordinate_at(&d->coordinates[coordinate], x)
               : fmin(low + x * (high - low), high);
}

/* What a coordinate is that does not vary; at the beginning of time, that of the window. */
static double held(const problem *p, const problem_set *set, int coordinate)
{
    bool begins = coordinate == p->model->domain.time && set->about->points == MODEL_INITIAL;
    return begins ? domain_window_time(&p->model->domain, p->window)
                  : set->about->value[coordinate];
}

/* The pieces among which the points of a set are shared out. */
static int pieces_of(const problem *p, const problem_set *set)
{
    return set->about->holds[0] ? 1 : domain_pieces(&p->model->domain);
}

/* Of the points of a cloud those of one piece, where they are between its `first` and `end`. */
static ad_status draw_piece(const problem *p, const problem_set *set, problem_cloud *cloud,
                            int piece, nn_rng *rng, ad_error *error)
{
    int which[DOMAIN_COORDINATES_MAX], dimension = varying(p, set, which);
    const size_t count = cloud->count / (size_t)pieces_of(p, set), start = (size_t)piece * count;
    const size_t first = cloud->first > start ? cloud->first - start : 0,
                 end = cloud->end < start ? 0 : cloud->end - start;
    const size_t from = first < count ? first : count, to = end < count ? end : count;
    double *at[DOMAIN_COORDINATES_MAX];
    for (int i = 0; i < dimension; i++) {
        at[i] = cloud->x + (size_t)which[i] * cloud->count + start;
    }
    ad_status status = dimension > 0 ? sampling_fill_part(cloud->drawn.sampler, rng, dimension,
                                                          count, from, to, at, error)
                                     : AD_OK;
    for (int i = 0; status == AD_OK && i < p->model->domain.count; i++) {
        double *x = cloud->x + (size_t)i * cloud->count + start;
        for (size_t k = from; k < to; k++) {
            x[k] = set->about->holds[i] ? held(p, set, i) : problem_placed(p, i, piece, x[k]);
        }
    }
    return status;
}

static ad_status draw_points(const problem *p, const problem_set *set, problem_cloud *cloud,
                             nn_rng *rng, ad_error *error)
{
    ad_status status = AD_OK;
    for (int piece = 0; status == AD_OK && piece < pieces_of(p, set); piece++) {
        status = draw_piece(p, set, cloud, piece, rng, error);
    }
    return status;
}

ad_status problem_cloud_fill(const problem *p, const problem_set *set, problem_cloud *cloud,
                             sampling_kind kind, nn_rng *rng, ad_error *error)
{
    cloud->drawn = (problem_drawn){.still = true, .sampler = kind, .before = *rng};
    return draw_points(p, set, cloud, rng, error);
}

ad_status problem_cloud_redraw(const problem *p, const problem_set *set, problem_cloud *cloud,
                               ad_error *error)
{
    nn_rng rng = cloud->drawn.before;
    return draw_points(p, set, cloud, &rng, error);
}

ad_status problem_cloud_hold(const problem *p, const problem_set *set, problem_cloud *cloud,
                             size_t first, size_t end, ad_error *error)
{
    if (first >= end || (first >= cloud->first && end <= cloud->end)) {
        return AD_OK;
    }
    const bool some = cloud->end > cloud->first;
    cloud->first = some && cloud->first < first ? cloud->first : first;
    cloud->end = some && cloud->end > end ? cloud->end : end;
    return problem_cloud_redraw(p, set, cloud, error);
}

/* ---- data ---- */

static bool cloud_has_data(const problem_set *set, problem_cloud *cloud)
{
    size_t rows = (size_t)set->about->source.rows;
    cloud->data = rows > 0 ? calloc(rows * cloud->count, sizeof *cloud->data) : NULL;
    return rows == 0 || cloud->data;
}

static ad_status cloud_supply(const problem_set *set, problem_cloud *cloud, bool held_out,
                              const double *fields, nn_rng *rng, ad_error *error)
{
    const model_source *source = &set->about->source;
    const model_draw draw = {.count = cloud->count,
                             .window = set->problem->window,
                             .held_out = held_out,
                             .rng = rng,
                             .x = cloud->x,
                             .fields = fields,
                             .data = cloud->data};
    if (!source->fill) {
        return AD_OK;
    }
    cloud->drawn.still = false; /* the source may move them, as that of members does */
    return source->fill(source->context, &draw, error);
}

bool problem_set_follows(const problem_set *set)
{
    const model_source *source = &set->about->source;
    return source->fill && source->follows && source->follows(source->context);
}

ad_status problem_set_supply(problem *p, problem_set *set, const double *x, ad_error *error)
{
    bool follows = problem_set_follows(set);
    ad_status status = follows ? problem_set_fields(p, set, x, error) : AD_OK;
    problem_set_refresh(set);
    return status == AD_OK ? cloud_supply(set, &set->trained, false,
                                          follows ? set->field_values : NULL, &set->rng, error)
                           : status;
}

ad_status problem_cloud_make(const problem *p, const problem_set *set, problem_cloud *cloud,
                             const problem_points *points, bool none, nn_rng *rng, ad_error *error)
{
    bool given = set->about->points == MODEL_GIVEN;
    int which[DOMAIN_COORDINATES_MAX], dimension = varying(p, set, which);
    int pieces = pieces_of(p, set);
    size_t each = 1;
    if (given) {
        each = (size_t)points->points;
        pieces = 1;
    } else if (dimension > 0) {
        size_t wanted = (size_t)((points->points + pieces - 1) / pieces);
        ad_status status = sampling_count(points->sampler, dimension, wanted, &each, error);
        if (status != AD_OK) {
            return status;
        }
    }
    cloud->count = each * (size_t)pieces;
    cloud->first = 0;
    cloud->end = none ? 0 : cloud->count;
    cloud->drawn.still = false;
    cloud->x = calloc((size_t)p->model->domain.count * cloud->count, sizeof *cloud->x);
    if (!cloud->x || !cloud_has_data(set, cloud)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", cloud->count);
    }
    return given ? AD_OK : problem_cloud_fill(p, set, cloud, points->sampler, rng, error);
}

problem_points problem_points_of(const problem *p, const problem_set *set)
{
    const model_source *source = &set->about->source;
    switch (set->about->points) {
    case MODEL_INTERIOR:
        return p->settings.interior;
    case MODEL_INITIAL:
        return p->settings.initial;
    case MODEL_GIVEN:
        return (problem_points){(int)source->points, SAMPLING_UNIFORM, source->draw_every};
    case MODEL_BOUNDARY:
        break;
    }
    return p->settings.boundary;
}

/* ---- points in short panels ---- */

enum { PANEL_POINTS = 3, PANEL_OTHERS = 4 }; /* in each, and for each of these of the other */

/* A panel along s or t that is a small part of the range, within the window at work. */
static bool short_panel(const problem *p, int coordinate, int panel, double *low, double *high)
{
    static const double SHORT = 1.0 / 32;
    const domain *d = &p->model->domain;
    const scene_panels *panels = &p->panels[coordinate];
    double scale = d->coordinates[coordinate].scale, all = d->coordinates[coordinate].high;
    *low = panels->edges[panel] / scale;
    *high = panels->edges[panel + 1] / scale;
    if (coordinate == d->time) {
        *low = fmax(*low, domain_window_time(d, p->window));
        *high = fmin(*high, domain_window_time(d, p->window + 1));
        all = domain_window_time(d, p->window + 1) - domain_window_time(d, p->window);
    }
    return *high > *low && *high - *low < SHORT * all;
}

/* Points of the two coordinates of a scene, or of one; appended to [coordinates][room] if x is not
 * NULL; returns how many. Of the other coordinate they take the places of the cloud in turn. */
static size_t panel_points(const problem *p, const problem_cloud *from, size_t room, double *x)
{
    size_t count = 0;
    int coordinates = p->model->domain.count;
    for (int i = 0; i < coordinates && i < 2 && p->panels[i].edges; i++) {
        for (int panel = 0; panel < p->panels[i].count; panel++) {
            double low, high;
            int points = PANEL_POINTS * (coordinates > 1 ? PANEL_OTHERS : 1);
            for (int k = 0; k < points && short_panel(p, i, panel, &low, &high); k++, count++) {
                for (int j = 0; x && j < coordinates; j++) {
                    size_t other = count % from->count;
                    x[(size_t)j * room + count] =
                        j == i ? low + (high - low) * (k % PANEL_POINTS + 0.5) / PANEL_POINTS
                               : from->x[(size_t)j * from->count + other];
                }
            }
        }
    }
    return count;
}

/* Held-out points also where formulas vary on short lengths. */
static ad_status cloud_extend(const problem *p, problem_cloud *cloud, ad_error *error)
{
    size_t more = panel_points(p, cloud, 0, NULL), room = cloud->count + more;
    size_t coordinates = (size_t)p->model->domain.count;
    if (more == 0) {
        return AD_OK;
    }
    double *x = malloc(coordinates * room * sizeof *x);
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", room);
    }
    for (size_t i = 0; i < coordinates; i++) {
        memcpy(x + i * room, cloud->x + i * cloud->count, cloud->count * sizeof *x);
    }
    panel_points(p, cloud, room, x + cloud->count);
    free(cloud->x);
    cloud->x = x;
    cloud->count = cloud->end = room;
    cloud->drawn.still = false;
    return AD_OK;
}

/* Every set has a generator of its own, and its held-out points another. */
ad_status problem_set_sample(problem *p, problem_set *set, ad_error *error)
{
    char stream[MODEL_NAME + 16];
    problem_set_forget_points(set);
    snprintf(stream, sizeof stream, "points/%s", set->about->name);
    set->rng = nn_rng_split(p->seed, stream);
    snprintf(stream, sizeof stream, "held_out/%s", set->about->name);
    nn_rng held_out = nn_rng_split(p->seed, stream);
    problem_points trained = problem_points_of(p, set);
    problem_points unseen = {p->settings.held_out_points, SAMPLING_SOBOL, 0};
    if (set->about->points == MODEL_GIVEN) {
        unseen.points = (int)set->about->source.held_out_points;
    }
    ad_status status = problem_cloud_make(p, set, &set->trained, &trained,
                                          ad_pool_ranks(p->pool) && problem_set_is_shared(p, set),
                                          &set->rng, error);
    if (status == AD_OK) {
        status = cloud_supply(set, &set->trained, false, NULL, &set->rng, error);
    }
    bool watched = unseen.points > 0;
    if (status == AD_OK && watched) {
        status = problem_cloud_make(p, set, &set->held_out, &unseen, false, &held_out, error);
    }
    if (status == AD_OK && watched) {
        status = cloud_supply(set, &set->held_out, true, NULL, &held_out, error);
    }
    if (status == AD_OK && set->about->points == MODEL_INTERIOR) {
        status = cloud_extend(p, &set->held_out, error);
    }
    problem_set_refresh(set);
    return status == AD_OK ? problem_set_weigh_points(p, set, error) : status;
}

ad_status problem_set_resample(problem *p, problem_set *set, ad_error *error)
{
    problem_set_refresh(set);
    return set->about->points == MODEL_GIVEN
               ? AD_OK
               : problem_cloud_fill(p, set, &set->trained, problem_points_of(p, set).sampler,
                                    &set->rng, error);
}

void problem_set_forget_points(problem_set *set)
{
    free(set->trained.x);
    free(set->held_out.x);
    free(set->trained.data);
    free(set->held_out.data);
    free(set->field_values);
    free(set->point_weights);
    free(set->point_losses);
    problem_set_forget_candidates(set);
    set->trained.x = set->held_out.x = set->trained.data = set->held_out.data = NULL;
    set->field_values = NULL;
    set->point_weights = set->point_losses = NULL;
}

double problem_time_of(const problem *p, const problem_cloud *cloud, size_t point)
{
    int time = p->model->domain.time;
    return time < 0 ? 0 : cloud->x[(size_t)time * cloud->count + point];
}

bool problem_points_are_inside(const problem *p, const problem_cloud *cloud)
{
    const domain *d = &p->model->domain;
    for (int i = 0; i < d->count; i++) {
        double low = problem_placed(p, i, 0, 0),
               high = problem_placed(p, i, domain_pieces(d) - 1, 1);
        for (size_t k = 0; k < cloud->count; k++) {
            double x = cloud->x[(size_t)i * cloud->count + k];
            if (!(x >= low && x <= high)) {
                return false;
            }
        }
    }
    return true;
}
