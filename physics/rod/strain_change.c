/* What a change of the curvature changes: at each point the derivatives of what is local there by
 * the turn of the section, by N, u and M, from the tape. */
#include "physics/rod/strain_internal.h"

#include <string.h>

enum { TURN, FORCE, CURVATURE, MOMENT, CAUSES, CHANGES = 3 * CAUSES };
enum { OF_SLOPE, OF_LOAD, OF_RATE, OF_MISSING, EFFECTS };

/* by[cause][effect]: component i of the effect by component k of the cause is by[..].x[i][k]. */
typedef struct local_changes {
    along_matrix by[CAUSES][EFFECTS];
} local_changes;

/* Derivatives of `count` vectors, that depend on an input of CHANGES rows which is 0. */
static void differentiate(ad_value changes, int causes, int count, const along *of,
                          along_matrix (*by)[EFFECTS])
{
    ad_value y[3 * EFFECTS], d[3 * EFFECTS];
    const ad_value none = ad_zeros(changes.tape, CHANGES);
    for (int i = 0; i < 3 * count; i++) {
        y[i] = of[i / 3].x[i % 3];
    }
    for (int k = 0; k < 3 * causes; k++) {
        double unit[CHANGES] = {0};
        unit[k] = 1;
        ad_value along_unit = ad_constant(changes.tape, CHANGES, unit);
        if (ad_directional(3 * count, y, 1, &changes, &along_unit, d) != AD_OK) {
            return;
        }
        for (int i = 0; i < 3 * count; i++) {
            by[k / 3][i / 3].x[i % 3][k % 3] = ad_substitute(d[i], changes, none);
        }
    }
}

static along cause(ad_value changes, int which)
{
    return strain_rows(ad_slice(changes, 3 * which, 3));
}

/* (1 + turn^) R */
static along_matrix turned(along turn, const along_matrix *R)
{
    along_matrix to;
    for (int j = 0; j < 3; j++) {
        const along column = {{R->x[0][j], R->x[1][j], R->x[2][j]}};
        const along sum = strain_add(column, strain_cross(turn, column));
        for (int i = 0; i < 3; i++) {
            to.x[i][j] = sum.x[i];
        }
    }
    return to;
}

/* (1, turn/2) q */
static along_turn turned_on(along turn, along_turn q)
{
    const ad_value zero = ad_scalar(turn.x[0].tape, 0), half = ad_scalar(turn.x[0].tape, 0.5);
    const along by = strain_by(half, turn);
    const along_turn more = strain_turn_product((along_turn){{zero, by.x[0], by.x[1], by.x[2]}}, q);
    for (int k = 0; k < 4; k++) {
        q.x[k] = ad_add(q.x[k], more.x[k]);
    }
    return q;
}

static void differentiate_points(const strain_rod *rod, const strain_state *state, ad_value changes,
                                 local_changes *local)
{
    const along_matrix R = turned(cause(changes, TURN), &state->R);
    const along force = strain_add(state->force, cause(changes, FORCE));
    const along curvature = strain_add(state->curvature, cause(changes, CURVATURE));
    const along moment = strain_add(state->moment, cause(changes, MOMENT));
    const along strain = strain_yield_on(rod, state->pull, strain_to_body(&R, force), curvature,
                                         state->strain, state->curvature);
    along effects[EFFECTS], load[2];
    strain_loads(rod, turned_on(cause(changes, TURN), state->turn), load);
    effects[OF_SLOPE] = strain_to_world(&R, strain);
    effects[OF_LOAD] = load[0];
    effects[OF_RATE] = strain_moment_rate(effects[OF_SLOPE], force, load[1]);
    effects[OF_MISSING] = strain_missing(rod, state->pull, &R, strain, curvature, moment);
    differentiate(changes, CAUSES, EFFECTS, effects, local->by);
}

/* Of what acts at an edge by the turn there: force, moment. */
static void differentiate_edge(const strain_rod *rod, const strain_state *state, int edge,
                               ad_value changes, along_matrix by[1][EFFECTS])
{
    const along_turn q = turned_on(cause(changes, TURN), state->edge_turn[edge]);
    along acting[2];
    strain_acting(rod, edge, q, &acting[0], &acting[1]);
    differentiate(changes, 1, 2, acting, by);
}

/* [3][3][nodes] */
static ad_value points_of(const strain_rod *rod, const along_matrix *by)
{
    ad_value all[9];
    for (int i = 0; i < 9; i++) {
        ad_value x = by->x[i / 3][i % 3];
        all[i] = ad_rows(x) == 1 ? ad_repeat(x, rod->nodes) : x;
    }
    return ad_stack(9, all);
}

static bool is_nothing(const along_matrix *by)
{
    bool nothing = true;
    for (int i = 0; i < 9; i++) {
        nothing = nothing && ad_is_constant(by->x[i / 3][i % 3], 0);
    }
    return nothing;
}

strain_blocks strain_rod_blocks(const strain_rod *rod, ad_value curvature, ad_value vector)
{
    static const int of[STRAIN_BLOCKS][2] = {
        [STRAIN_SLOPE_BY_TURN] = {TURN, OF_SLOPE},
        [STRAIN_SLOPE_BY_CURVATURE] = {CURVATURE, OF_SLOPE},
        [STRAIN_RATE_BY_TURN] = {TURN, OF_RATE},
        [STRAIN_RATE_BY_CURVATURE] = {CURVATURE, OF_RATE},
        [STRAIN_MISSING_BY_TURN] = {TURN, OF_MISSING},
        [STRAIN_MISSING_BY_CURVATURE] = {CURVATURE, OF_MISSING},
        [STRAIN_MISSING_BY_MOMENT] = {MOMENT, OF_MISSING},
        [STRAIN_LOAD_BY_TURN] = {TURN, OF_LOAD},
        [STRAIN_SLOPE_BY_FORCE] = {FORCE, OF_SLOPE},
        [STRAIN_RATE_BY_FORCE] = {FORCE, OF_RATE},
        [STRAIN_MISSING_BY_FORCE] = {FORCE, OF_MISSING}};
    const ad_value changes = ad_input(rod->tape, "change", CHANGES);
    strain_state state;
    local_changes local;
    ad_value blocks[STRAIN_BLOCKS], edges[18 * STRAIN_ELEMENTS_MAX];
    strain_state_of(rod, curvature, vector, &state);
    differentiate_points(rod, &state, changes, &local);
    blocks[STRAIN_ROTATION] = points_of(rod, &state.R);
    for (int i = 1; i < STRAIN_BLOCKS; i++) {
        blocks[i] = points_of(rod, &local.by[of[i][0]][of[i][1]]);
    }
    bool follows = !is_nothing(&local.by[TURN][OF_LOAD]);
    for (int e = 1; e <= rod->mesh.elements; e++) {
        along_matrix by[1][EFFECTS];
        memset(by, 0, sizeof by);
        differentiate_edge(rod, &state, e, changes, by);
        follows = follows || !is_nothing(&by[0][0]);
        for (int i = 0; i < 18; i++) {
            edges[18 * (e - 1) + i] = by[0][i / 9].x[i % 9 / 3][i % 3];
        }
    }
    const along missing =
        strain_missing(rod, state.pull, &state.R, state.strain, state.curvature, state.moment);
    return (strain_blocks){.residual = strain_points(rod->nodes, missing),
                           .follows = follows,
                           .blocks =
                               ad_stack(follows ? STRAIN_BLOCKS : STRAIN_LOAD_BY_TURN, blocks),
                           .edges = ad_stack(18 * rod->mesh.elements, edges)};
}
