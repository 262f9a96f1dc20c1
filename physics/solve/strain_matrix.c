/* The derivatives of the strain form, column by column: what a change of one unknown does to
 * rotations, forces, positions and moments, in that order. Turns of sections are vectors in the
 * world: phi' = R du. */
#include "physics/solve/strain_algebra.h"
#include "physics/solve/strain_form.h"
#include "physics/solve/strain_inline.h"

/* ---- at a point ---------------------------------------------------------------------------- */

/* How v follows n and u, in the body: V_n, V_u, and T_uv V_n, T_uu + T_uv V_u of actuators. */
typedef struct yielding {
    lanes by_n[3][3], by_u[3][3], moment_by_n[3][3], moment_by_u[3][3];
} yielding;

STRAIN_INLINE void yield_at(strain_form *x, int node, yielding *to)
{
    const strain_point *point = &x->points[node];
    memset(to, 0, sizeof *to);
    for (int i = 0; i < 3; i++) {
        to->by_n[i][i] = point->compliance[i];
    }
    if (x->kind.actuators == 0) {
        return;
    }
    lanes soft[3][3], inverse[3][3], turned[3][3], more[3][3];
    pulling pull;
    pull_all(x, node, true, &pull);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            soft[i][j] = (i == j) + point->compliance[i] * pull.by_v[i][j];
            turned[j][i] = pull.by_u[i][j];
        }
    }
    invert(soft, inverse);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            to->by_n[i][j] = inverse[i][j] * point->compliance[j];
        }
    }
    multiply(to->by_n, pull.by_u, to->by_u);
    multiply(turned, to->by_n, to->moment_by_n);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            to->by_u[i][j] = -to->by_u[i][j];
        }
    }
    multiply(turned, to->by_u, more);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            to->moment_by_u[i][j] = pull.turning[i][j] + more[i][j];
        }
    }
}

STRAIN_INLINE void add(lanes to[3][3], lanes from[3][3])
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            to[i][j] += from[i][j];
        }
    }
}

/* r' and the rate of M. */
STRAIN_INLINE void differentiate_rates(strain_form *x, int node, yielding *yield)
{
    strain_node *at = &x->at[node];
    lanes part[3][3];
    cross_matrix(at->slope, -1, at->P);
    cross_matrix(at->slope, 1, at->H);
    if (x->kind.shears) {
        multiply(at->R, yield->by_n, part);
        multiply_turned(part, at->R, at->Q);
        multiply(at->R, yield->by_u, at->S);
        times_cross(at->Q, at->N, part);
        add(at->P, part);
        cross_times(at->N, -1, at->Q, part);
        add(at->H, part);
        cross_times(at->N, -1, at->S, at->K);
    }
    cross_times(at->N, -1, at->P, at->G);
    if (x->kind.follows) {
        lanes body[3];
        lanes_to_world(at->R, x->points[node].load[3], body);
        cross_matrix(body, -1, part);
        add(at->G, part);
    }
}

STRAIN_INLINE void differentiate_point(strain_form *x, int node)
{
    strain_node *at = &x->at[node];
    const strain_point *point = &x->points[node];
    lanes part[3][3];
    yielding yield;
    yield_at(x, node, &yield);
    differentiate_rates(x, node, &yield);
    multiply_turned(yield.moment_by_n, at->R, at->Z);
    for (int i = 0; i < 3; i++) {
        const lanes soft = point->compliance[3 + i];
        for (int j = 0; j < 3; j++) {
            at->T[i][j] = soft * at->R[j][i];
            at->Z[i][j] *= soft;
            at->L[i][j] = (i == j) + soft * yield.moment_by_u[i][j];
        }
    }
    times_cross(at->Z, at->N, at->Y);
    times_cross(at->T, at->M, part);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            at->Y[i][j] -= part[i][j];
        }
    }
}

/* ---- ends ---------------------------------------------------------------------------------- */

/* 2 vec(p* q) by a turn of q in the world: dq = (0, phi) q/2. */
STRAIN_INLINE void quotient_by_turn(const double p[4], const lanes q[4], lanes by[3][3])
{
    lanes from[4];
    for (int i = 0; i < 4; i++) {
        from[i] = NO_LANES + (i == 0 ? p[i] : -p[i]);
    }
    for (int c = 0; c < 3; c++) {
        lanes unit[4] = {NO_LANES, NO_LANES, NO_LANES, NO_LANES}, turned[4], both[4];
        unit[1 + c] += 1;
        lanes_quaternion_product(unit, q, turned);
        lanes_quaternion_product(from, turned, both);
        for (int i = 0; i < 3; i++) {
            by[i][c] = both[1 + i];
        }
    }
}

/* N and M at s = 1 by a turn, or the condition of the turn. */
STRAIN_INLINE void differentiate_end(strain_form *x)
{
    strain_edge *edge = &x->edges[x->kind.elements];
    const solve_end *end = &x->kind.end;
    lanes given[3], world[3], turn[3], by[3][3];
    memset(x->by_end, 0, sizeof x->by_end);
    if (end->force_is_body) { /* of a held end in the directions that are free */
        for (int i = 0; i < 3; i++) {
            given[i] = x->end_force[i];
            if (x->force_at >= 0) {
                given[i] = NO_LANES + x->last.force[i];
            }
        }
        lanes_to_world(edge->R, given, world);
        cross_matrix(world, -1, x->by_end[0]);
    }
    if (x->moment_at >= 0) {
        quotient_by_turn(x->last.rotation, edge->q, x->held);
        return;
    }
    quotient_by_turn(x->last.upright, edge->q, by); /* M = R (given - spring 2 vec(p* q)) */
    turned_from(x->last.upright, edge->q, turn);
    for (int i = 0; i < 3; i++) {
        given[i] = -2 * x->last.spring[i] * turn[i];
        given[i] += (end->moment_is_body ? 1.0 : 0.0) * x->end_moment[i];
        for (int j = 0; j < 3; j++) {
            by[i][j] *= -x->last.spring[i];
        }
    }
    multiply(edge->R, by, x->by_end[1]);
    lanes_to_world(edge->R, given, world);
    cross_matrix(world, -1, by);
    add(x->by_end[1], by);
}

/* Of the condition of the moment at s = 0, in the body: m by a turn and by dM is R^T (dM + M x
 * phi). */
STRAIN_INLINE void differentiate_start(strain_form *x)
{
    strain_edge *edge = &x->edges[0];
    lanes by[3][3], beyond[3], cross[3][3];
    quotient_by_turn(x->start.upright, edge->q, by);
    for (int i = 0; i < 3; i++) {
        beyond[i] = edge->M[i] - (x->start.kind.moment_is_body ? 0 : x->start.moment[i]);
    }
    cross_matrix(beyond, 1, cross);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            x->stood[i][j] = -x->start.spring[i] * by[i][j];
            for (int k = 0; k < 3; k++) {
                x->stood[i][j] += edge->R[k][i] * cross[k][j];
            }
        }
    }
}

/* ---- columns ------------------------------------------------------------------------------- */

/* Whether N at a point depends on the shape, or M of an end or an edge does. */
static bool forces_move(const strain_form *x)
{
    bool moves = x->kind.follows || x->unknowns > x->elastic || x->kind.end.force_is_body ||
                 x->kind.end.moment_is_body || x->kind.springs > 0 || x->last.spring[0] != 0 ||
                 x->last.spring[1] != 0 || x->last.spring[2] != 0;
    for (int e = 0; e <= x->kind.elements && !moves; e++) {
        moves = x->edges[e].follows;
    }
    return moves;
}

/* By component c of u at a point, where all forces are dead: N stays. */
STRAIN_INLINE void dead_column(strain_form *x, int node, int c, lanes *to)
{
    const int n = x->kind.stages, first = node / n, own = node % n;
    const lanes a[3] = {x->at[node].R[0][c], x->at[node].R[1][c], x->at[node].R[2][c]};
    lanes end[3] = {NO_LANES, NO_LANES, NO_LANES};
    for (int e = x->kind.elements - 1; e >= 0; e--) {
        strain_node *at = x->at + e * n;
        const double h = x->width[e], reach = x->width[first];
        lanes rate[GAUSS_STAGES_MAX][3], sum[3];
        double turned[GAUSS_STAGES_MAX];
        for (int j = 0; j < n && e >= first; j++) {
            turned[j] = reach * (e > first ? x->rule.weights[own] : x->rule.matrix[j][own]);
            apply(at[j].G, a, rate[j]);
            for (int k = 0; k < 3; k++) {
                rate[j][k] *= turned[j];
                if (x->kind.shears && e == first && j == own) {
                    rate[j][k] += at[j].K[k][c];
                }
            }
        }
        for (int i = 0; i < n; i++) {
            lanes *row = to + 3 * (e * n + i), moved[3];
            memcpy(sum, end, sizeof sum);
            for (int j = 0; j < n && e >= first; j++) {
                const double weight = h * x->tail[i][j];
                for (int k = 0; k < 3; k++) {
                    sum[k] += weight * rate[j][k];
                }
            }
            apply(at[i].T, sum, moved);
            for (int k = 0; k < 3; k++) {
                row[k] = -moved[k];
            }
            if (e >= first) {
                apply(at[i].Y, a, moved);
                for (int k = 0; k < 3; k++) {
                    row[k] += turned[i] * moved[k];
                }
            }
        }
        for (int j = 0; j < n && e >= first; j++) {
            for (int k = 0; k < 3; k++) {
                end[k] += h * x->rule.weights[j] * rate[j][k];
            }
        }
    }
    for (int k = 0; k < 3; k++) {
        to[3 * node + k] += x->at[node].L[k][c];
    }
}

/* One unknown that changes by 1: which of its kind, and which component. */
typedef enum change_kind {
    CHANGE_BEND,
    CHANGE_FORCE,
    CHANGE_MOMENT,
    CHANGE_SHIFT,
    CHANGE_TURN,
    CHANGE_PUSH,
    CHANGE_SPRING
} change_kind;

typedef struct change {
    change_kind kind;
    int index, c;
} change;

static change change_of(const strain_form *x, int column)
{
    const int first[] = {x->force_at, x->moment_at, x->shift_at, x->turn_at, x->push_at};
    const int count[] = {3, 3, 3, 3, 3 * x->nodes};
    if (column < x->elastic) {
        return (change){CHANGE_BEND, column / 3, column % 3};
    }
    for (int i = 0; i < 5; i++) {
        int at = column - first[i];
        if (first[i] >= 0 && at >= 0 && at < count[i]) {
            return (change){(change_kind)(CHANGE_FORCE + i), at / 3, at % 3};
        }
    }
    int k = 0;
    while (x->springs[k].unknown < 0 || column - x->springs[k].unknown > 2) {
        k++;
    }
    return (change){CHANGE_SPRING, k, column - x->springs[k].unknown};
}

/* What changes at a point, and at an edge before what acts there. */
typedef struct changed {
    lanes turn[3], force[3], slope[3], position[3], moment[3];
} changed;

STRAIN_INLINE void turn_column(strain_form *x, const change *by, changed *points, changed *edges)
{
    const int n = x->kind.stages;
    lanes turn[3] = {NO_LANES, NO_LANES, NO_LANES};
    if (by->kind == CHANGE_TURN) {
        turn[by->c] += 1;
    }
    for (int e = 0; e <= x->kind.elements; e++) {
        bool here = by->kind == CHANGE_BEND && by->index / n == e;
        memcpy(edges[e].turn, turn, sizeof turn);
        for (int i = 0; i < n && e < x->kind.elements; i++) {
            for (int k = 0; k < 3; k++) {
                points[e * n + i].turn[k] = turn[k];
                if (here) {
                    points[e * n + i].turn[k] += x->width[e] * x->rule.matrix[i][by->index % n] *
                                                 x->at[by->index].R[k][by->c];
                }
            }
        }
        for (int k = 0; k < 3 && here; k++) {
            turn[k] += x->width[e] * x->rule.weights[by->index % n] * x->at[by->index].R[k][by->c];
        }
    }
}

/* Integrals over an element from its points and its beginning to its end: of rate [stages][3], to
 * to[..][3], by strides of a changed. */
STRAIN_INLINE void integrate_back(strain_form *x, int e, lanes (*rate)[3], const lanes end[3],
                                  lanes (*to)[3], lanes start[3])
{
    const int n = x->kind.stages;
    for (int k = 0; k < 3; k++) {
        start[k] = end[k];
        for (int i = 0; i < n; i++) {
            to[i][k] = end[k];
            for (int j = 0; j < n; j++) {
                to[i][k] += x->width[e] * x->tail[i][j] * rate[j][k];
            }
            start[k] += x->width[e] * x->rule.weights[i] * rate[i][k];
        }
    }
}

STRAIN_INLINE void force_column(strain_form *x, const change *by, changed *points, changed *edges)
{
    const int n = x->kind.stages;
    lanes N[3], start[3], rate[GAUSS_STAGES_MAX][3], at[GAUSS_STAGES_MAX][3];
    apply(x->by_end[0], edges[x->kind.elements].turn, N);
    if (x->force_at >= 0) { /* given forces are in the condition of the end */
        for (int k = 0; k < 3; k++) {
            N[k] = NO_LANES + (by->kind == CHANGE_FORCE && by->c == k);
        }
    }
    for (int e = x->kind.elements; e >= 0; e--) {
        add_applied(x->edges[e].by_turn[0], edges[e].turn, N);
        if (by->kind == CHANGE_SPRING && x->springs[by->index].edge == e) {
            N[by->c] += 1;
        }
        memcpy(edges[e].force, N, sizeof N);
        if (e == 0) {
            break;
        }
        for (int j = 0; j < n; j++) {
            const int node = (e - 1) * n + j;
            memset(rate[j], 0, sizeof rate[j]);
            if (x->kind.follows) {
                lanes body[3];
                lanes_to_world(x->at[node].R, x->points[node].load[2], body);
                lanes_vector_cross(points[node].turn, body, rate[j]);
            }
            if (by->kind == CHANGE_PUSH && by->index == node) {
                rate[j][by->c] += 1;
            }
        }
        integrate_back(x, e - 1, rate, N, at, start);
        for (int j = 0; j < n; j++) {
            memcpy(points[(e - 1) * n + j].force, at[j], sizeof at[j]);
        }
        memcpy(N, start, sizeof N);
    }
}

STRAIN_INLINE void place_column(strain_form *x, const change *by, changed *points, changed *edges)
{
    const int n = x->kind.stages;
    lanes r[3] = {NO_LANES, NO_LANES, NO_LANES};
    if (by->kind == CHANGE_SHIFT) {
        r[by->c] += 1;
    }
    for (int i = 0; i < x->nodes; i++) {
        strain_node *at = &x->at[i];
        apply(at->P, points[i].turn, points[i].slope);
        if (x->kind.shears) {
            add_applied(at->Q, points[i].force, points[i].slope);
        }
        for (int k = 0; k < 3 && by->kind == CHANGE_BEND && by->index == i; k++) {
            points[i].slope[k] += at->S[k][by->c];
        }
    }
    for (int e = 0; e <= x->kind.elements; e++) {
        memcpy(edges[e].position, r, sizeof r);
        for (int k = 0; k < 3 && e < x->kind.elements; k++) {
            for (int i = 0; i < n; i++) {
                lanes sum = r[k];
                for (int j = 0; j < n; j++) {
                    sum += x->width[e] * x->rule.matrix[i][j] * points[e * n + j].slope[k];
                }
                points[e * n + i].position[k] = sum;
            }
            for (int j = 0; j < n; j++) {
                r[k] += x->width[e] * x->rule.weights[j] * points[e * n + j].slope[k];
            }
        }
    }
}

STRAIN_INLINE void moment_column(strain_form *x, const change *by, changed *points, changed *edges)
{
    const int n = x->kind.stages;
    lanes M[3], start[3], rate[GAUSS_STAGES_MAX][3], at[GAUSS_STAGES_MAX][3];
    apply(x->by_end[1], edges[x->kind.elements].turn, M);
    if (by->kind == CHANGE_MOMENT) {
        M[by->c] += 1;
    }
    for (int e = x->kind.elements; e >= 0; e--) {
        add_applied(x->edges[e].by_turn[1], edges[e].turn, M);
        memcpy(edges[e].moment, M, sizeof M);
        if (e == 0) {
            break;
        }
        for (int j = 0; j < n; j++) {
            const int node = (e - 1) * n + j;
            apply(x->at[node].G, points[node].turn, rate[j]);
            add_applied(x->at[node].H, points[node].force, rate[j]);
            for (int k = 0; k < 3 && by->kind == CHANGE_BEND && by->index == node; k++) {
                rate[j][k] += x->at[node].K[k][by->c];
            }
        }
        integrate_back(x, e - 1, rate, M, at, start);
        for (int j = 0; j < n; j++) {
            memcpy(points[(e - 1) * n + j].moment, at[j], sizeof at[j]);
        }
        memcpy(M, start, sizeof M);
    }
}

STRAIN_INLINE void row_of_points(strain_form *x, const change *by, const changed *points, lanes *to)
{
    for (int i = 0; i < x->nodes; i++) {
        strain_node *at = &x->at[i];
        lanes row[3], moved[3];
        apply(at->Y, points[i].turn, row);
        add_applied(at->Z, points[i].force, row);
        apply(at->T, points[i].moment, moved);
        for (int k = 0; k < 3; k++) {
            to[3 * i + k] = row[k] - moved[k];
            if (by->kind == CHANGE_BEND && by->index == i) {
                to[3 * i + k] += at->L[k][by->c];
            }
            if (x->push_at >= 0) {
                to[x->push_at + 3 * i + k] =
                    x->points[i].stiffness[k] * points[i].position[k] +
                    (by->kind == CHANGE_PUSH && by->index == i && by->c == k);
            }
        }
    }
    for (int i = 0; i < x->kind.springs; i++) {
        const strain_spring *spring = &x->springs[i];
        for (int k = 0; k < 3 && spring->unknown >= 0; k++) {
            to[spring->unknown + k] =
                NO_LANES + (by->kind == CHANGE_SPRING && by->index == i && by->c == k);
        }
    }
}

/* Springs and ends, whose conditions are about edges. */
STRAIN_INLINE void row_of_edges(strain_form *x, const change *by, const changed *edges, lanes *to)
{
    const changed *last = &edges[x->kind.elements];
    lanes beyond[3], given[3];
    for (int i = 0; i < x->kind.springs; i++) {
        const strain_spring *spring = &x->springs[i];
        for (int k = 0; k < 3 && spring->unknown >= 0; k++) {
            to[spring->unknown + k] +=
                spring->given->stiffness[k] * edges[spring->edge].position[k];
        }
    }
    if (x->force_at >= 0) {
        apply(x->by_end[0], last->turn, given);
        for (int k = 0; k < 3; k++) {
            beyond[k] = (by->kind == CHANGE_FORCE && by->c == k) - given[k];
        }
        hold_row(&x->kind.end.hold, last->position, beyond, to + x->force_at);
    }
    if (x->moment_at >= 0) {
        apply(x->held, last->turn, to + x->moment_at);
    }
    if (x->shift_at >= 0) {
        lanes world[3], force[3];
        memset(given, 0, sizeof given);
        if (x->start.kind.force_is_body) {
            for (int k = 0; k < 3; k++) {
                force[k] = NO_LANES + x->start.force[k];
            }
            lanes_to_world(x->edges[0].R, force, world);
            lanes_vector_cross(edges[0].turn, world, given);
        }
        for (int k = 0; k < 3; k++) {
            beyond[k] = edges[0].force[k] - given[k];
        }
        hold_row(&x->start.kind.hold, edges[0].position, beyond, to + x->shift_at);
    }
    if (x->turn_at >= 0) {
        apply(x->stood, edges[0].turn, to + x->turn_at);
        for (int k = 0; k < 3; k++) {
            for (int i = 0; i < 3; i++) {
                to[x->turn_at + k] += x->edges[0].R[i][k] * edges[0].moment[i];
            }
        }
    }
}

STRAIN_INLINE void moving_column(strain_form *x, const change *by, lanes *to)
{
    changed *points = x->columns, *edges = points + x->nodes;
    turn_column(x, by, points, edges);
    force_column(x, by, points, edges);
    place_column(x, by, points, edges);
    moment_column(x, by, points, edges);
    row_of_points(x, by, points, to);
    row_of_edges(x, by, edges, to);
}

FOR_EACH_PROCESSOR static void fill(strain_form *x, bool moves)
{
    const size_t n = (size_t)x->unknowns;
    for (int i = 0; i < x->nodes; i++) {
        differentiate_point(x, i);
    }
    differentiate_end(x);
    if (x->turn_at >= 0) {
        differentiate_start(x);
    }
    for (int k = 0; k < x->unknowns; k++) {
        const change by = change_of(x, k);
        if (moves) {
            moving_column(x, &by, x->matrix + (size_t)k * n);
        } else {
            dead_column(x, by.index, by.c, x->matrix + (size_t)k * n);
        }
    }
}

void strain_form_linearise(strain_form *x)
{
    fill(x, forces_move(x));
}
