/* Where equations and conditions change on short lengths by themselves, whatever the fields are.
 *
 * Residuals and their derivatives by the fields are sampled along lines, with fields that are the
 * same everywhere, so that what varies is written in the formulas. A panel whose samples are no
 * polynomial is halved, and sampled more closely when few are left of it; a jump becomes an edge.
 * Lines are spread over the other coordinates, and go through the places where samples of the
 * whole domain are furthest from their mean. So sources, coefficients and starts that are narrower
 * than the first patches are seen, unless all samples miss them. */
#include "autodiff/memory.h"
#include "physics/learn/patches_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    NODES = 16,
    SAMPLES = 1 << 16, /* of the domain, */
    LINE = 1 << 14,    /* of a line, */
    CLOSER = 1 << 10,  /* of a panel of it */
    FEWEST = 2 * NODES,
    LINES = 8,
    HOT_MAX = 8,  /* lines through places of extremes */
    JUMPS_MAX = 8 /* of an output along a line */
};

typedef struct look {
    const patch_problem *p;
    const patch_law *law;
    patch_panels *panels;
    int d; /* the coordinate of the lines */
    double at[PATCH_DIMS];
    double *x;         /* [dims][SAMPLES] */
    double *constants; /* [2 + unknowns][SAMPLES] */
    double *values;    /* [results][SAMPLES] */
    const double **inputs;
    double **outputs; /* [results]; NULL: the same everywhere */
    int results;
    ad_memory memory;
} look;

static double range_of(const look *l)
{
    const domain_coordinate *c = &l->p->model->domain.coordinates[l->d];
    return c->high - c->low;
}

static void add_edge(look *l, double edge)
{
    patch_panels *panels = l->panels;
    double *edges = panels->edge[l->d];
    int count = panels->count[l->d], i = count;
    const double apart = 1e-9 * range_of(l);
    while (i > 0 && edges[i - 1] > edge) {
        i--;
    }
    if (count < PATCH_PANELS_MAX && (i == 0 || edge - edges[i - 1] > apart) &&
        (i == count || edges[i] - edge > apart)) {
        memmove(edges + i + 1, edges + i, (size_t)(count - i) * sizeof *edges);
        edges[i] = edge;
        panels->count[l->d]++;
    }
}

static bool sample(look *l, size_t count)
{
    ad_error ignored;
    const ad_run run = {.points = count, .inputs = l->inputs, .outputs = l->outputs};
    return ad_execute(l->law->program, &run, &ignored) == AD_OK;
}

static bool sample_line(look *l, double a, double b, size_t count)
{
    for (int d = 0; d < l->p->dims; d++) {
        for (size_t i = 0; i < count; i++) {
            l->x[(size_t)d * SAMPLES + i] =
                d == l->d ? a + (b - a) * ((double)i + 0.5) / (double)count : l->at[d];
        }
    }
    return sample(l, count);
}

/* Whether samples y [count] follow a polynomial within `allowed`. */
static bool is_smooth(const double *y, size_t count, double allowed)
{
    size_t node[NODES];
    double weight[NODES];
    for (int i = 0; i < NODES; i++) {
        const double at = 0.5 - 0.5 * cos(acos(-1) * i / (NODES - 1));
        const size_t near = (size_t)(at * (double)(count - 1) + 0.5);
        node[i] = i > 0 && near <= node[i - 1] ? node[i - 1] + 1 : near;
    }
    for (size_t i = 0; i < NODES; i++) { /* others follow up to the last sample */
        const size_t last = count - (NODES - i);
        node[i] = node[i] < last ? node[i] : last;
    }
    for (int i = 0; i < NODES; i++) {
        weight[i] = 1;
        for (int k = 0; k < NODES; k++) {
            weight[i] /= k == i ? 1 : 4 * ((double)node[i] - (double)node[k]) / (double)count;
        }
    }
    for (size_t q = 0; q < count; q++) {
        double above = 0, below = 0;
        bool at_node = false;
        for (int i = 0; i < NODES && !at_node; i++) {
            at_node = node[i] == q;
            const double part = at_node ? 0 : weight[i] / ((double)q - (double)node[i]);
            above += part * y[node[i]];
            below += part;
        }
        if (!at_node && !(fabs(above / below - y[q]) <= allowed)) {
            return false;
        }
    }
    return true;
}

/* The place of a jump between a and b, or NAN where values differ less the closer they are. */
static double find_jump(look *l, int output, double a, double b, double size)
{
    enum { PIECES = 32, ROUNDS = 9 };
    for (int round = 0; round < ROUNDS; round++) {
        const double step = (b - a) / PIECES;
        const double *y = l->values + (size_t)output * SAMPLES;
        int most = 0;
        if (!sample_line(l, a - step / 2, b + step / 2, PIECES + 1)) {
            return NAN;
        }
        for (int i = 1; i < PIECES; i++) {
            most = fabs(y[i + 1] - y[i]) > fabs(y[most + 1] - y[most]) ? i : most;
        }
        if (!(fabs(y[most + 1] - y[most]) > 0.5 * size)) {
            return NAN;
        }
        a += step * most;
        b = a + step;
    }
    return (a + b) / 2;
}

/* Of y [count] between a and b; allowed: what is no change. */
static void find_panels(look *l, int output, const double *y, size_t count, double a, double b,
                        double allowed)
{
    double jump[JUMPS_MAX], *own = NULL;
    size_t before[JUMPS_MAX]; /* the sample before it */
    int jumps = 0;
    if (b - a < 1e-8 * range_of(l) || is_smooth(y, count, allowed)) {
        return;
    }
    own = malloc(count * sizeof *own); /* samples are taken again meanwhile */
    if (!own) {
        return;
    }
    memcpy(own, y, count * sizeof *own);
    const double step = (b - a) / (double)count;
    for (size_t i = 1; i + 2 < count && jumps < JUMPS_MAX; i++) {
        const double size = fabs(own[i + 1] - own[i]);
        const double beside = fmax(fabs(own[i] - own[i - 1]), fabs(own[i + 2] - own[i + 1]));
        if (size > allowed && size > 8 * beside) {
            const double from = a + ((double)i + 0.5) * step;
            const double place = find_jump(l, output, from, from + step, size);
            if (isfinite(place)) {
                before[jumps] = i;
                jump[jumps++] = place;
            }
        }
    }
    bool smooth = jumps > 0;
    for (int i = 0; i <= jumps && smooth; i++) {
        const size_t low = i == 0 ? 0 : before[i - 1] + 1;
        const size_t high = i == jumps ? count : before[i] + 1;
        smooth = high - low < FEWEST || is_smooth(own + low, high - low, allowed);
    }
    for (int i = 0; i < jumps; i++) {
        add_edge(l, jump[i]);
    }
    if (!smooth && count / 2 >= FEWEST) {
        add_edge(l, (a + b) / 2);
        find_panels(l, output, own, count / 2, a, (a + b) / 2, allowed);
        find_panels(l, output, own + count / 2, count / 2, (a + b) / 2, b, allowed);
    } else if (!smooth && sample_line(l, a, b, CLOSER)) {
        double *closer = malloc(CLOSER * sizeof *closer);
        if (closer) {
            memcpy(closer, l->values + (size_t)output * SAMPLES, CLOSER * sizeof *closer);
            add_edge(l, (a + b) / 2);
            find_panels(l, output, closer, CLOSER / 2, a, (a + b) / 2, allowed);
            find_panels(l, output, closer + CLOSER / 2, CLOSER / 2, (a + b) / 2, b, allowed);
        }
        free(closer);
    }
    free(own);
}

/* Along d through l->at. */
static void look_along(look *l, int d)
{
    const domain_coordinate *c = &l->p->model->domain.coordinates[d];
    double *line = malloc(LINE * sizeof *line);
    l->d = d;
    for (int k = 0; k < l->results && line; k++) {
        double low = INFINITY, high = -INFINITY, size = 0;
        if (!l->outputs[k] || !sample_line(l, c->low, c->high, LINE)) {
            continue;
        }
        memcpy(line, l->values + (size_t)k * SAMPLES, LINE * sizeof *line);
        for (int i = 0; i < LINE; i++) {
            low = fmin(low, line[i]);
            high = fmax(high, line[i]);
            size = fmax(size, isfinite(line[i]) ? fabs(line[i]) : INFINITY);
        }
        if (isfinite(size) && high - low > 1e-12 * size) {
            const double tolerance = fmin(1e-3, fmax(1e-9, l->p->settings->tolerance));
            find_panels(l, k, line, LINE, c->low, c->high, tolerance * (high - low) + 1e-14 * size);
        }
    }
    free(line);
}

/* Where an output is furthest from its mean. */
static bool hottest(const look *l, int output, double *at)
{
    const double *y = l->values + (size_t)output * SAMPLES;
    double mean = 0;
    size_t most = 0;
    for (size_t i = 0; i < SAMPLES; i++) {
        mean += y[i] / SAMPLES;
    }
    if (!isfinite(mean)) {
        return false;
    }
    for (size_t i = 0; i < SAMPLES; i++) {
        most = fabs(y[i] - mean) > fabs(y[most] - mean) ? i : most;
    }
    for (int d = 0; d < l->p->dims; d++) {
        at[d] = l->x[(size_t)d * SAMPLES + most];
    }
    return fabs(y[most] - mean) > 1e-12 * fabs(mean);
}

/* A coordinate of place i: of a sequence that fills the domain evenly. */
static double spread(const look *l, size_t i, int d)
{
    static const double step[PATCH_DIMS] = {0.8566748838545029, 0.733891856627126,
                                            0.6287067210378087, 0.5385972572236101};
    const domain_coordinate *c = &l->p->model->domain.coordinates[d];
    const model_set *set = l->law->set;
    double part = 0.5 + (double)(i + 1) * step[d];
    part -= floor(part);
    return set->holds[d] ? set->value[d] : c->low + (c->high - c->low) * part;
}

static void look_through(look *l)
{
    double hot[HOT_MAX][PATCH_DIMS];
    const model_set *set = l->law->set;
    int hots = 0, free_coordinates = 0;
    for (int d = 0; d < l->p->dims; d++) {
        free_coordinates += !set->holds[d];
        for (size_t i = 0; i < SAMPLES; i++) {
            l->x[(size_t)d * SAMPLES + i] = spread(l, i, d);
        }
    }
    if (free_coordinates > 1 && sample(l, SAMPLES)) {
        for (int k = 0; k < l->results && hots < HOT_MAX; k++) {
            hots += l->outputs[k] && hottest(l, k, hot[hots]);
        }
    }
    const int lines = free_coordinates > 1 ? LINES : 1;
    for (int i = 0; i < lines + hots; i++) {
        for (int d = 0; d < l->p->dims; d++) {
            if (!set->holds[d]) {
                for (int k = 0; k < l->p->dims; k++) {
                    l->at[k] = i < lines ? spread(l, (size_t)i, k) : hot[i - lines][k];
                }
                look_along(l, d);
            }
        }
    }
}

static bool look_open(look *l)
{
    const patch_problem *p = l->p;
    const size_t constants = 2 + (size_t)p->unknowns;
    const size_t jets = (size_t)p->outputs * (size_t)p->jets.count;
    l->results = l->law->rows + l->law->entry_count;
    AD_TAKE(l, x, (size_t)p->dims * SAMPLES);
    AD_TAKE(l, constants, constants * SAMPLES);
    AD_TAKE(l, values, (size_t)l->results * SAMPLES);
    AD_TAKE(l, inputs, patch_inputs(p, l->law));
    AD_TAKE(l, outputs, (size_t)l->results);
    if (l->memory.is_short) {
        return false;
    }
    for (int d = 0; d < p->dims; d++) {
        l->inputs[d] = l->inputs[patch_input_about(p, l->law, d)] = l->x + (size_t)d * SAMPLES;
    }
    for (size_t i = 0; i < jets; i++) {
        l->inputs[patch_input_jet(p, i)] = l->constants + i % 2 * SAMPLES;
    }
    for (int i = 0; i < p->unknowns; i++) {
        l->inputs[patch_input_unknown(p, i)] = l->constants + (size_t)(2 + i) * SAMPLES;
        for (size_t q = 0; q < SAMPLES; q++) {
            l->constants[(size_t)(2 + i) * SAMPLES + q] = p->unknown[i];
        }
    }
    for (int i = 0; i < l->results; i++) {
        const bool same =
            i < l->law->rows ? l->law->same[i] : l->law->entries[i - l->law->rows].same;
        l->outputs[i] = same ? NULL : l->values + (size_t)i * SAMPLES;
    }
    return true;
}

static void look_close(look *l)
{
    ad_memory_free(&l->memory);
}

bool patch_look(const patch_problem *p, patch_panels *panels)
{
    static const double fields[2][2] = {{0, 0}, {0.37, 0.59}};
    for (int i = 0; i < p->law_count; i++) {
        look l = {.p = p, .law = &p->laws[i], .panels = panels};
        bool varies = false;
        for (int k = 0; k < l.law->rows; k++) {
            varies = varies || !l.law->same[k];
        }
        if (l.law->set->source.rows > 0 || !varies) {
            continue;
        }
        const bool opened = look_open(&l);
        for (int kind = 0; kind < 2 && opened; kind++) {
            for (size_t q = 0; q < (size_t)2 * SAMPLES; q++) {
                l.constants[q] = fields[kind][q / SAMPLES];
            }
            look_through(&l);
        }
        look_close(&l);
        if (!opened) {
            return false;
        }
    }
    return true;
}
