/* What a change of the curvature changes: at each point the derivatives of what is local there by
 * the turn of the section, by N, u and M, from the tape; along the rod their integrals. */
#include "physics/strain_internal.h"

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

static void differentiate_points(const strain_rod *rod, const strain_state *state, ad_value changes,
                                 local_changes *local)
{
    const along_matrix R = turned(cause(changes, TURN), &state->R);
    const along force = strain_add(state->force, cause(changes, FORCE));
    const along curvature = strain_add(state->curvature, cause(changes, CURVATURE));
    const along moment = strain_add(state->moment, cause(changes, MOMENT));
    const along strain =
        strain_yield_on(rod, strain_to_body(&R, force), curvature, state->strain, state->curvature);
    along effects[EFFECTS], load[2];
    strain_loads(rod, &R, load);
    effects[OF_SLOPE] = strain_to_world(&R, strain);
    effects[OF_LOAD] = load[0];
    effects[OF_RATE] = strain_moment_rate(effects[OF_SLOPE], force, load[1]);
    effects[OF_MISSING] = strain_missing(rod, &R, strain, curvature, moment);
    differentiate(changes, CAUSES, EFFECTS, effects, local->by);
}

/* Of what acts at an edge by the turn there: force, moment. */
static void differentiate_edge(const strain_rod *rod, const strain_state *state, int edge,
                               ad_value changes, along_matrix by[1][EFFECTS])
{
    const ad_value zero = ad_scalar(rod->tape, 0), half = ad_scalar(rod->tape, 0.5);
    const along turn = strain_by(half, cause(changes, TURN));
    along_turn q = state->edge_turn[edge];
    along_turn more = {{zero, turn.x[0], turn.x[1], turn.x[2]}};
    more = strain_turn_product(more, q);
    for (int k = 0; k < 4; k++) {
        q.x[k] = ad_add(q.x[k], more.x[k]);
    }
    along acting[2];
    strain_acting(rod, edge, q, &acting[0], &acting[1]);
    differentiate(changes, 1, 2, acting, by);
}

static along add_changed(along sum, const along_matrix *by, along cause)
{
    return strain_add(sum, strain_to_world(by, cause));
}

/* An effect of all that changes at points. */
static along effect_of(const strain_rod *rod, const local_changes *local, int effect,
                       const along *causes, int count)
{
    along sum = strain_zeros(rod->tape);
    for (int k = 0; k < count; k++) {
        sum = add_changed(sum, &local->by[k][effect], causes[k]);
    }
    return sum;
}

strain_change strain_rod_change(const strain_rod *rod, ad_value curvature, ad_value direction)
{
    const int elements = rod->mesh.elements;
    const ad_value changes = ad_input(rod->tape, "change", CHANGES);
    const along none = strain_zeros(rod->tape);
    strain_state state;
    local_changes local;
    along causes[CAUSES], edges[STRAIN_ELEMENTS_MAX + 1], acting[2][STRAIN_ELEMENTS_MAX + 1];
    strain_state_of(rod, curvature, &state);
    differentiate_points(rod, &state, changes, &local);
    causes[CURVATURE] = strain_of_points(rod->nodes, direction);
    causes[FORCE] = causes[MOMENT] = none;
    causes[TURN] = strain_integrate_on(rod, strain_to_world(&state.R, causes[CURVATURE]), edges);
    for (int e = 0; e <= elements; e++) {
        along_matrix by[1][EFFECTS];
        memset(by, 0, sizeof by);
        differentiate_edge(rod, &state, e, changes, by);
        acting[0][e] = add_changed(none, &by[0][0], edges[e]);
        acting[1][e] = add_changed(none, &by[0][1], edges[e]);
    }
    causes[FORCE] = strain_integrate_back(rod, effect_of(rod, &local, OF_LOAD, causes, CAUSES),
                                          acting[0], edges);
    const along slope = effect_of(rod, &local, OF_SLOPE, causes, CAUSES);
    causes[MOMENT] = strain_integrate_back(rod, effect_of(rod, &local, OF_RATE, causes, CAUSES),
                                           acting[1], edges);
    const along missing = effect_of(rod, &local, OF_MISSING, causes, CAUSES);
    const along moved = strain_integrate_on(rod, slope, edges);
    strain_change result = {.residual = strain_points(rod->nodes, missing)};
    for (int c = 0; c < 3; c++) {
        ad_value at = moved.x[c], end = edges[elements].x[c];
        at = ad_rows(at) == 1 ? ad_repeat(at, rod->nodes) : at;
        result.places[c] = ad_stack(2, (ad_value[]){at, end});
    }
    return result;
}
