#include "tools/plan/certificate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of a variable between two shapes, in parts of its range: what a derivative does between its ends
 * is then seen by several. */
#define STEP_MAX 0.1

const char *certificate_text(certificate_end end)
{
    static const char *const texts[] = {
        "it holds", "a shape is nearer to the surface than promised",
        "the solver finds no equilibrium",
        "shapes of neighbouring configurations are apart: the robot jumps, or passes too closely",
        "the first shape is on the wrong side of the surface"};
    return texts[end];
}

/* One configuration of which the shape is known. */
typedef struct node {
    clearance shape;
    double least;   /* to the next */
    double *q;      /* [variables] */
    double *free;   /* [pieces] */
    double *r;      /* [points][3] */
    double *spread; /* [points] */
    double *moves;  /* [points][3][variables] */
    size_t next;    /* in order; itself: the last */
    bool holds;     /* the way to the next */
} node;

typedef struct certifier {
    plan_exact *exact;
    const environment *of;
    const certificate_settings *asked;
    size_t count; /* of nodes, the first `given` ones in order */
    node *nodes;
    double nearest; /* m, the least that a shape has left */
    double *travel; /* [pieces] */
    ad_error *error;
} certifier;

static size_t pieces_of(const certifier *c)
{
    return c->exact->points - 1;
}

/* ---- one shape ------------------------------------------------------------------------------- */

static ad_status add_node(certifier *c, const double *q)
{
    const size_t variables = (size_t)c->exact->robot->count, points = c->exact->points;
    double *const numbers =
        malloc((variables + 2 * points + 3 * points + 3 * points * variables) * sizeof *numbers);
    if (!numbers) {
        return ad_fail(c->error, AD_NO_MEMORY, "out of memory for a way of %zu shapes", c->count);
    }
    node *const n = &c->nodes[c->count++];
    *n = (node){.q = numbers};
    n->free = n->q + variables;
    n->r = n->free + points;
    n->spread = n->r + 3 * points;
    n->moves = n->spread + points;
    memcpy(n->q, q, variables * sizeof *q);
    return AD_OK;
}

static void judge_shape(certifier *c, node *n, size_t member)
{
    const plan_exact *const e = c->exact;
    const size_t points = e->points, variables = (size_t)e->robot->count;
    memcpy(n->r, &e->r[3 * member * points], 3 * points * sizeof *n->r);
    memcpy(n->moves, &e->moves[3 * member * points * variables],
           3 * points * variables * sizeof *n->moves);
    memcpy(n->spread, &e->spread[member * points], points * sizeof *n->spread);
    const clearance_shape shape = {.points = points,
                                   .spread = e->robot->unknowns ? n->spread : NULL,
                                   .s = e->s,
                                   .r = n->r,
                                   .speed = &e->speed[member * points],
                                   .error = e->error[member],
                                   .radius = c->asked->radius,
                                   .from = c->asked->from};
    if (e->error[member] < INFINITY) {
        clearance_of_shape(c->of, &shape, n->free, &n->shape);
        c->nearest = fmin(c->nearest, n->shape.free);
    } else {
        n->shape = (clearance){.free = -INFINITY, .shape_error = INFINITY};
    }
}

static ad_status judge_new(certifier *c, size_t first)
{
    const size_t variables = (size_t)c->exact->robot->count;
    double q[PLAN_BATCH * PLAN_VARIABLES_MAX];
    ad_status status = AD_OK;
    for (size_t at = first; at < c->count && status == AD_OK; at += PLAN_BATCH) {
        const size_t members = c->count - at < PLAN_BATCH ? c->count - at : PLAN_BATCH;
        for (size_t m = 0; m < members; m++) {
            memcpy(&q[m * variables], c->nodes[at + m].q, variables * sizeof *q);
        }
        status = plan_exact_shapes(c->exact, members, q, c->error);
        for (size_t m = 0; m < members && status == AD_OK; m++) {
            judge_shape(c, &c->nodes[at + m], m);
        }
    }
    return status;
}

/* ---- between two ----------------------------------------------------------------------------- */

/* How far a point goes on the way, if the derivative is that of either end, m: more than the way
 * as the crow flies; by how much the two differ, and the way as the crow flies exceeds both. */
static double travel_of(const certifier *c, const node *a, const node *b, size_t point,
                        double *differ, double *beyond)
{
    const size_t variables = (size_t)c->exact->robot->count;
    double square[3] = {0, 0, 0}, off = 0;
    for (size_t i = 0; i < 3; i++) {
        const size_t row = (3 * point + i) * variables;
        double one = 0, other = 0;
        for (size_t k = 0; k < variables; k++) {
            one += a->moves[row + k] * (b->q[k] - a->q[k]);
            other += b->moves[row + k] * (b->q[k] - a->q[k]);
        }
        const double straight = b->r[3 * point + i] - a->r[3 * point + i];
        square[0] += one * one;
        square[1] += other * other;
        square[2] += straight * straight;
        off += (one - other) * (one - other);
    }
    *differ = sqrt(off);
    *beyond = sqrt(square[2]) - sqrt(fmax(square[0], square[1]));
    return sqrt(fmax(square[0], fmax(square[1], square[2])));
}

/* The largest step of a variable, in parts of its range. */
static double part_of_ranges(const certifier *c, const node *a, const node *b)
{
    const plan_robot *const robot = c->exact->robot;
    double part = 0;
    for (int k = 0; k < robot->count; k++) {
        part = fmax(part, fabs(b->q[k] - a->q[k]) / (robot->high[k] - robot->low[k]));
    }
    return part;
}

/* Whether the way from a to the next holds, without a jump, which no derivative says, and leaves no
 * less than half of what the nearest of all shapes does, or a thousandth of the length less; false:
 * look half-way. What the derivative changes from end to end is added once, for what it does
 * between them; and what travel bends from point to point a fourth of, twice what a parabola leaves
 * between points. Where unknown parameters move a point by x at a and y at b, they move it by no
 * more than max(x, y) + |x - y| between: as half of travel is taken off and (x + y)/2 was already,
 * that is 3 |x - y|. */
static bool judge_way(certifier *c, node *a, const node *b)
{
    const size_t points = c->exact->points;
    double before = 0, here = 0, largest = 0, change = 0, jump = 0;
    for (size_t k = 0; k < points; k++) {
        double differ, beyond;
        const double travel = travel_of(c, a, b, k, &differ, &beyond);
        jump = fmax(jump, beyond);
        largest = fmax(largest, travel);
        change = fmax(change, differ);
        const double now = travel + differ;
        if (k > 0) {
            c->travel[k - 1] = fmax(here, now);
        }
        if (k > 1) {
            const double bend = fabs(now - 2 * here + before) / 4;
            c->travel[k - 2] += bend;
            c->travel[k - 1] += bend;
        }
        before = here;
        here = now;
    }
    for (size_t k = 0; k + 1 < points; k++) {
        const double apart =
            fmax(fabs(a->spread[k] - b->spread[k]), fabs(a->spread[k + 1] - b->spread[k + 1]));
        c->travel[k] += 3 * apart;
    }
    a->least = clearance_between(pieces_of(c), a->free, b->free, c->travel);
    const bool smooth = (fmax(change, jump) <= largest / 2 || largest < 1e-9 * c->exact->length) &&
                        part_of_ranges(c, a, b) <= STEP_MAX;
    const bool close = c->nearest - a->least <= fmax(c->nearest / 2, 1e-3 * c->exact->length);
    return smooth && close && a->least >= c->asked->promised;
}

/* ---- the way --------------------------------------------------------------------------------- */

/* Nodes evenly between a node and the next, so many pieces. */
static ad_status divide(certifier *c, size_t at, size_t pieces)
{
    const size_t variables = (size_t)c->exact->robot->count;
    const node *const a = &c->nodes[at], *const b = &c->nodes[a->next];
    ad_status status = AD_OK;
    for (size_t i = 1, last = at; i < pieces && status == AD_OK; i++, last = c->count - 1) {
        const double part = (double)i / (double)pieces;
        double q[PLAN_VARIABLES_MAX];
        for (size_t k = 0; k < variables; k++) {
            q[k] = a->q[k] + part * (b->q[k] - a->q[k]);
        }
        status = add_node(c, q);
        if (status == AD_OK) {
            c->nodes[c->count - 1].next = c->nodes[last].next;
            c->nodes[last].next = c->count - 1;
        }
    }
    return status;
}

/* Between those that are given, as many as there are at least. */
static ad_status divide_all(certifier *c)
{
    const size_t given = c->count;
    ad_status status = AD_OK;
    for (size_t i = 0; i + 1 < given && status == AD_OK; i++) {
        const double steps = part_of_ranges(c, &c->nodes[i], &c->nodes[i + 1]) / STEP_MAX;
        const size_t pieces = (size_t)ceil(steps * (1 + 1e-9));
        status = c->count + pieces <= c->asked->shapes_max ? divide(c, i, pieces) : status;
    }
    return status;
}

/* Half-way between a node and the next, for each that does not hold. */
static ad_status split(certifier *c, bool *jumps, size_t *where)
{
    const size_t before = c->count;
    for (size_t i = 0; i < before; i++) {
        const node *const a = &c->nodes[i];
        if (a->holds) {
            continue;
        }
        if (part_of_ranges(c, a, &c->nodes[a->next]) < 1e-6 || c->count >= c->asked->shapes_max) {
            *jumps = true;
            *where = i;
            return AD_OK;
        }
        const ad_status status = divide(c, i, 2);
        if (status != AD_OK) {
            return status;
        }
    }
    return AD_OK;
}

static certificate_end find_fault(const certifier *c, size_t first, size_t *where)
{
    for (size_t i = first; i < c->count; i++) {
        const clearance *const shape = &c->nodes[i].shape;
        if (!(shape->free >= c->asked->promised)) {
            *where = i;
            return isinf(shape->shape_error) ? CERTIFICATE_NO_EQUILIBRIUM : CERTIFICATE_TOO_NEAR;
        }
    }
    return CERTIFICATE_HOLDS;
}

/* A robot that touches nothing is on one side all the way, and so with all its length. */
static bool is_on_its_side(const certifier *c, environment_side side)
{
    const size_t last = c->exact->points - 1;
    const double around = environment_winding(c->of, &c->nodes[0].r[3 * last]);
    return side == ENVIRONMENT_ANY || fabs(around - (side == ENVIRONMENT_INSIDE ? 1 : 0)) < 0.5;
}

static ad_status certify(certifier *c, environment_side side, certificate_end *end, size_t *where)
{
    size_t judged = 0;
    ad_status status = AD_OK;
    *end = CERTIFICATE_HOLDS;
    while (status == AD_OK && judged < c->count) {
        bool jumps = false;
        status = judge_new(c, judged);
        *end = status == AD_OK ? find_fault(c, judged, where) : *end;
        if (status == AD_OK && *end == CERTIFICATE_HOLDS && judged == 0 &&
            !is_on_its_side(c, side)) {
            *end = CERTIFICATE_OTHER_SIDE;
            *where = 0;
        }
        if (status != AD_OK || *end != CERTIFICATE_HOLDS) {
            break;
        }
        judged = c->count;
        for (size_t i = 0; i < c->count; i++) {
            node *const a = &c->nodes[i];
            if (a->next == i) {
                a->holds = true;
                a->least = a->shape.free;
            } else if (!a->holds) {
                a->holds = judge_way(c, a, &c->nodes[a->next]);
            }
        }
        status = split(c, &jumps, where);
        if (jumps) {
            *end = CERTIFICATE_JUMPS;
            break;
        }
    }
    return status;
}

static ad_status tell(const certifier *c, certificate *to)
{
    const size_t variables = (size_t)to->variables, last = c->exact->points - 1;
    to->configuration = malloc(c->count * variables * sizeof(double));
    to->shape = malloc(c->count * sizeof *to->shape);
    to->least = malloc(c->count * sizeof(double));
    to->tip = malloc(3 * c->count * sizeof(double));
    if (!to->configuration || !to->shape || !to->least || !to->tip) {
        return ad_fail(c->error, AD_NO_MEMORY, "out of memory for a way of %zu shapes", c->count);
    }
    const size_t fault = to->which;
    to->all.free = INFINITY;
    for (size_t i = 0;; i = c->nodes[i].next) {
        const node *const n = &c->nodes[i];
        const size_t k = to->count++;
        memcpy(&to->configuration[k * variables], n->q, variables * sizeof(double));
        memcpy(&to->tip[3 * k], &n->r[3 * last], 3 * sizeof(double));
        to->shape[k] = n->shape;
        to->least[k] = n->holds ? n->least : NAN;
        to->which = i == fault ? k : to->which;
        if (n->holds && n->least < to->all.free) {
            const clearance *const next = &c->nodes[n->next].shape;
            to->all = next->free < n->shape.free ? *next : n->shape;
            to->all.between_configurations = to->all.free - n->least;
            to->all.free = n->least;
        }
        if (n->next == i) {
            return AD_OK;
        }
    }
}

ad_status certificate_create(plan_exact *shapes, const environment *of, environment_side side,
                             const certificate_settings *settings, size_t count,
                             const double *configurations, certificate **result, ad_error *error)
{
    *result = NULL;
    certifier c = {
        .exact = shapes, .of = of, .asked = settings, .nearest = INFINITY, .error = error};
    const size_t most = settings->shapes_max > count ? settings->shapes_max : count;
    certificate *const to = calloc(1, sizeof *to);
    c.nodes = malloc(most * sizeof *c.nodes);
    c.travel = malloc(shapes->points * sizeof *c.travel);
    ad_status status = to && c.nodes && c.travel
                           ? AD_OK
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for a certificate");
    for (size_t i = 0; i < count && status == AD_OK; i++) {
        status = add_node(&c, &configurations[i * (size_t)shapes->robot->count]);
        if (status == AD_OK) {
            c.nodes[i].next = i + 1 < count ? i + 1 : i;
        }
    }
    if (status == AD_OK) {
        to->variables = shapes->robot->count;
        status = divide_all(&c);
    }
    if (status == AD_OK) {
        status = certify(&c, side, &to->end, &to->which);
    }
    status = status == AD_OK ? tell(&c, to) : status;
    for (size_t i = 0; i < c.count; i++) {
        free(c.nodes[i].q);
    }
    free(c.nodes);
    free(c.travel);
    if (status != AD_OK) {
        certificate_free(to);
        return status;
    }
    *result = to;
    return AD_OK;
}

static bool append(double **to, size_t before, const double *from, size_t count)
{
    double *const all = realloc(*to, (before + count) * sizeof *all);
    if (all) {
        memcpy(all + before, from, count * sizeof *all);
        *to = all;
    }
    return all != NULL;
}

ad_status certificate_join(certificate **to, certificate *next, ad_error *error)
{
    certificate *const t = *to;
    if (!t) {
        *to = next;
        return AD_OK;
    }
    const size_t keep = t->count - 1, n = (size_t)t->variables;
    clearance *const shape = realloc(t->shape, (keep + next->count) * sizeof *shape);
    t->shape = shape ? shape : t->shape;
    if (!shape || !append(&t->configuration, keep * n, next->configuration, next->count * n) ||
        !append(&t->least, keep, next->least, next->count) ||
        !append(&t->tip, 3 * keep, next->tip, 3 * next->count)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a way of %zu shapes",
                       keep + next->count);
    }
    memcpy(shape + keep, next->shape, next->count * sizeof *shape);
    t->count = keep + next->count;
    t->which = keep + next->which;
    t->end = next->end;
    t->all = next->all.free < t->all.free ? next->all : t->all;
    certificate_free(next);
    return AD_OK;
}

void certificate_free(certificate *of)
{
    if (of) {
        free(of->configuration);
        free(of->shape);
        free(of->least);
        free(of->tip);
        free(of);
    }
}
