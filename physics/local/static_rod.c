#include "physics/local/static_rod.h"

#include "physics/numerics/quaternion.h"

#include <string.h>

typedef double matrix3[3][3];

/* R(q) = (w^2 - |x|^2) I + 2 x x^T + 2 w x^ is quadratic: its derivatives by w and x are linear in
 * q, and R = sum_k q_k R_k/2 (Euler). */
static void rotation_of(const double *q, matrix3 rotation, matrix3 by_q[4])
{
    memset(by_q, 0, 4 * sizeof(matrix3));
    memset(rotation, 0, sizeof(matrix3));
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        by_q[0][i][i] = 2 * q[0];
        by_q[0][k][j] = 2 * q[1 + i]; /* 2 x^ */
        by_q[0][j][k] = -2 * q[1 + i];
        for (int row = 0; row < 3;
             row++) { /* by x_i: -2 x_i I + 2 (e_i x^T + x e_i^T) + 2 w e_i^ */
            by_q[1 + i][row][row] -= 2 * q[1 + i];
            by_q[1 + i][i][row] += 2 * q[1 + row];
            by_q[1 + i][row][i] += 2 * q[1 + row];
        }
        by_q[1 + i][k][j] += 2 * q[0];
        by_q[1 + i][j][k] -= 2 * q[0];
    }
    for (int k = 0; k < 4; k++) {
        for (int i = 0; i < 9; i++) {
            rotation[i / 3][i % 3] += q[k] * by_q[k][i / 3][i % 3] / 2;
        }
    }
}

/* left [4][3]: q (0, x) = left x. */
static void left_product(const double *q, double left[4][3])
{
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        left[0][i] = -q[1 + i];
        left[1 + i][i] = q[0];
        left[1 + k][j] = q[1 + i];
        left[1 + j][k] = -q[1 + i];
    }
}

void static_body_force(const double *y, double *force)
{
    matrix3 rotation, by_q[4];
    rotation_of(y + STATIC_Q, rotation, by_q);
    to_body(rotation, y + STATIC_N, force);
}

solve_actuation static_actuation(const static_point *at, const double *y)
{
    solve_actuation pulling = at->actuation;
    pulling.rest = (const double *)&at->rest;
    pulling.tubes = y + STATIC_TUBES;
    return pulling;
}

/* v and u at a section where n and m are known, and their derivatives by n and m where that is not
 * NULL. */
static void strains_under(const static_point *at, const solve_actuation *pulling,
                          const double *force, const double *moment, double strains[ACTUATION_ROWS],
                          double (*by_wrench)[ACTUATION_ROWS])
{
    double rest[ACTUATION_ROWS], wrench[ACTUATION_ROWS];
    for (int i = 0; i < 3; i++) {
        rest[i] = at->rest.strain[i];
        rest[3 + i] = at->rest.curvature[i];
        wrench[i] = force[i];
        wrench[3 + i] = moment[i];
    }
    solve_actuation_strains(pulling, rest, at->compliance, wrench, strains, by_wrench);
}

void static_strains(const static_point *at, const double *y, double *strain, double *curvature)
{
    double force[3], strains[ACTUATION_ROWS];
    static_body_force(y, force);
    const solve_actuation pulling = static_actuation(at, y);
    strains_under(at, &pulling, force, y + STATIC_M, strains, NULL);
    memcpy(strain, strains, 3 * sizeof *strain);
    memcpy(curvature, strains + 3, 3 * sizeof *curvature);
}

/* A state with what follows from it. */
typedef struct turned_state {
    matrix3 rotation, by_q[4];
    double left[4][3];                                /* q (0, x) = left x */
    double n[3], strains[ACTUATION_ROWS];             /* v, u */
    double by_wrench[ACTUATION_ROWS][ACTUATION_ROWS]; /* of v, u by n, m */
    const double *m;
    double tubes[SCENE_TUBES_MAX][2][5]; /* theta', m_i' by u, theta, m_i */
} turned_state;

/* What changes with one of the unknowns: n and m, and of R, which else stays (NULL), dR; and the
 * moment that tubes add. */
typedef struct unknown_change {
    double wrench[ACTUATION_ROWS], tubes[3];
    double (*turned)[3];
} unknown_change;

/* A column of the jacobian, without dq (0, u)/2. */
static void add_column(const static_point *at, turned_state *state, unknown_change *change,
                       int index, double (*jacobian)[STATIC_ROWS_MAX])
{
    double strained[ACTUATION_ROWS], moved[3], turning[3] = {0};
    double terms[4][3], *dn = change->wrench, *dm = dn + 3, *dv = strained, *du = strained + 3;
    for (int i = 0; i < ACTUATION_ROWS; i++) {
        strained[i] = 0;
        for (int k = 0; k < ACTUATION_ROWS; k++) {
            strained[i] += state->by_wrench[i][k] * change->wrench[k];
        }
        for (int k = 0; k < 3 && at->tubes > 0; k++) {
            strained[i] -= state->by_wrench[i][3 + k] * change->tubes[k];
        }
    }
    to_world(state->rotation, dv, moved);
    vector_cross(dv, state->n, terms[0]);
    vector_cross(state->strains, dn, terms[1]);
    vector_cross(du, state->m, terms[2]);
    vector_cross(state->strains + 3, dm, terms[3]);
    if (change->turned) {
        to_world(change->turned, state->strains, turning);
    }
    for (int i = 0; i < 3; i++) {
        jacobian[STATIC_R + i][index] = moved[i] + turning[i];
        jacobian[STATIC_N + i][index] = 0;
        jacobian[STATIC_M + i][index] = -terms[0][i] - terms[1][i] - terms[2][i] - terms[3][i];
    }
    for (int i = 0; i < 4; i++) {
        const double *left = state->left[i];
        jacobian[STATIC_Q + i][index] = (left[0] * du[0] + left[1] * du[1] + left[2] * du[2]) / 2;
    }
    for (int i = 0; i < 2 * at->tubes; i++) {
        jacobian[STATIC_TUBES + i][index] = vector_dot(state->tubes[i / 2][i % 2], du);
    }
}

/* Columns of theta and m_i, which add to the moment by themselves. */
static void add_tubes(const static_point *at, turned_state *state,
                      double (*jacobian)[STATIC_ROWS_MAX])
{
    int first = at->actuation.count - at->tubes;
    for (int i = 0; i < at->tubes; i++) {
        double(*by)[5] = state->tubes[i];
        int row = STATIC_TUBES + 2 * i;
        unknown_change turned = {.tubes = {by[1][0], by[1][1], 0}}, twisted = {.turned = NULL};
        twisted.tubes[2] = solve_tube_is_here(&at->actuation, first + i);
        add_column(at, state, &turned, row, jacobian);
        add_column(at, state, &twisted, row + 1, jacobian);
        for (int k = 0; k < 2; k++) {
            jacobian[row + k][row] += by[k][3];
            jacobian[row + k][row + 1] += by[k][4];
        }
    }
}

static void differentiate(const static_point *at, const double *y, turned_state *state,
                          double (*jacobian)[STATIC_ROWS_MAX])
{
    const double *u = state->strains + 3;
    memset(jacobian, 0, (size_t)(STATIC_TUBES + 2 * at->tubes) * sizeof *jacobian);
    for (int k = 0; k < 4; k++) {
        unknown_change change = {.turned = state->by_q[k]};
        to_body(state->by_q[k], y + STATIC_N, change.wrench);
        add_column(at, state, &change, STATIC_Q + k, jacobian);
    }
    for (int k = 0; k < 3; k++) {
        unknown_change pull = {.turned = NULL}, bend = {.turned = NULL};
        memcpy(pull.wrench, state->rotation[k], 3 * sizeof(double));
        add_column(at, state, &pull, STATIC_N + k, jacobian);
        bend.wrench[3 + k] = 1;
        add_column(at, state, &bend, STATIC_M + k, jacobian);
        /* q (0, u)/2 by q: the product with (0, u) from the right */
        int j = (k + 1) % 3, l = (k + 2) % 3;
        jacobian[STATIC_Q][STATIC_Q + 1 + k] += -u[k] / 2;
        jacobian[STATIC_Q + 1 + k][STATIC_Q] += u[k] / 2;
        jacobian[STATIC_Q + 1 + k][STATIC_Q + 1 + j] += u[l] / 2;
        jacobian[STATIC_Q + 1 + k][STATIC_Q + 1 + l] += -u[j] / 2;
    }
    add_tubes(at, state, jacobian);
}

/* Subtracts from N and m what laws outside do to the rod at y: force F, moment R^T T; and from
 * their derivatives by y, where these are not NULL. */
static void act(const acting *of, const double *numbers, const double *y, double *to,
                double (*by_y)[STATIC_ROWS_MAX])
{
    const double *q = y + STATIC_Q, square = q[0] * q[0] + vector_dot(q + 1, q + 1);
    double unit[4], R[3][3], left[4][3] = {{0}}, moment[3], by[3];
    acting_change x = {.wrench = {0}};
    if (!of || of->count == 0) {
        return;
    }
    memcpy(unit, q, sizeof unit);
    quaternion_normalize(unit);
    rotation_matrix(unit, R);
    acting_differentiate(of, numbers, (acting_on){y + STATIC_R, unit, NULL}, 1, &x);
    to_body(R, x.wrench + 3, moment);
    for (int i = 0; i < 3; i++) {
        to[STATIC_N + i] -= x.wrench[i];
        to[STATIC_M + i] -= moment[i];
    }
    left_product(q, left);
    for (int c = 0; c < 3 && by_y; c++) {
        for (int i = 0; i < 3; i++) {
            by[i] = x.by_position[3 + i][c];
            by_y[STATIC_N + i][STATIC_R + c] -= x.by_position[i][c];
        }
        to_body(R, by, moment);
        for (int i = 0; i < 3; i++) {
            by_y[STATIC_M + i][STATIC_R + c] -= moment[i];
        }
    }
    for (int c = 0; c < 4 && by_y; c++) { /* dq turns by 2 R vec(q* dq) */
        double turn[3], changed[6], cross[3];
        const double body[3] = {2 / square * left[c][0], 2 / square * left[c][1],
                                2 / square * left[c][2]};
        to_world(R, body, turn);
        vector_cross(turn, x.wrench + 3, cross);
        for (int i = 0; i < 6; i++) {
            changed[i] = vector_dot(x.by_turn[i], turn) - (i < 3 ? 0 : cross[i - 3]);
        }
        to_body(R, changed + 3, moment);
        for (int i = 0; i < 3; i++) {
            by_y[STATIC_N + i][STATIC_Q + c] -= changed[i];
            by_y[STATIC_M + i][STATIC_Q + c] -= moment[i];
        }
    }
}

void static_rate(const static_point *at, const double *y, double *rate,
                 double (*jacobian)[STATIC_ROWS_MAX])
{
    turned_state x = {.m = y + STATIC_M};
    double *v = x.strains, *u = x.strains + 3, bending[3], shearing[3];
    rotation_of(y + STATIC_Q, x.rotation, x.by_q);
    left_product(y + STATIC_Q, x.left);
    to_body(x.rotation, y + STATIC_N, x.n);
    const solve_actuation pulling = static_actuation(at, y);
    strains_under(at, &pulling, x.n, x.m, x.strains, jacobian ? x.by_wrench : NULL);
    to_world(x.rotation, v, rate + STATIC_R);
    vector_cross(u, x.m, bending);
    vector_cross(v, x.n, shearing);
    for (int i = 0; i < 4; i++) {
        const double *left = x.left[i];
        rate[STATIC_Q + i] = (left[0] * u[0] + left[1] * u[1] + left[2] * u[2]) / 2;
    }
    for (int i = 0; i < 3; i++) {
        rate[STATIC_N + i] = 0;
        rate[STATIC_M + i] = -bending[i] - shearing[i];
    }
    for (int i = 0; i < at->tubes; i++) {
        solve_tube_rate(&pulling, pulling.count - at->tubes + i, u, rate + STATIC_TUBES + 2 * i,
                        jacobian ? x.tubes[i] : NULL);
    }
    if (jacobian) {
        differentiate(at, y, &x, jacobian);
    }
    act(at->acting, at->numbers, y, rate, jacobian);
}

/* ---- ends ---------------------------------------------------------------------------------- */

/* 2 vec(p* q) times factor [3] added to three rows. */
static void add_turn(const double *p, const double *q, const double *factor, double *rows,
                     double (*jacobian)[STATIC_ROWS_MAX])
{
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        double by[4];
        by[0] = -p[1 + i];
        by[1 + i] = p[0];
        by[1 + j] = p[1 + k];
        by[1 + k] = -p[1 + j];
        for (int c = 0; c < 4; c++) {
            rows[i] += 2 * factor[i] * by[c] * q[c];
            jacobian[i][STATIC_Q + c] += 2 * factor[i] * by[c];
        }
    }
}

/* y[first ..] - given */
static void add_difference(const double *given, int first, const double *y, double *rows,
                           double (*jacobian)[STATIC_ROWS_MAX])
{
    for (int i = 0; i < 3; i++) {
        rows[i] += y[first + i] - given[i];
        jacobian[i][first + i] = 1;
    }
}

/* Three rows of the position and three of the force, each as far as the end holds or frees it. */
static void add_hold(const scene_hold *hold, double values[2][3],
                     double by_y[2][3][STATIC_ROWS_MAX], double *rows,
                     double (*jacobian)[STATIC_ROWS_MAX])
{
    double held[2][3];
    scene_hold_part(hold, values[0], held[0]);
    scene_hold_part(hold, values[1], held[1]);
    for (int i = 0; i < 3; i++) {
        rows[i] = held[0][i] + values[1][i] - held[1][i];
    }
    for (int c = 0; c < STATIC_TUBES; c++) {
        const double moved[3] = {by_y[0][0][c], by_y[0][1][c], by_y[0][2][c]};
        const double pulled[3] = {by_y[1][0][c], by_y[1][1][c], by_y[1][2][c]};
        scene_hold_part(hold, moved, held[0]);
        scene_hold_part(hold, pulled, held[1]);
        for (int i = 0; i < 3; i++) {
            jacobian[i][c] = held[0][i] + pulled[i] - held[1][i];
        }
    }
}

void static_end_residual(const static_end *at, int end, const double *y, double *rows,
                         double (*jacobian)[STATIC_ROWS_MAX])
{
    static const double none[3] = {0};
    const double *q = y + STATIC_Q, ones[3] = {1, 1, 1};
    int own = end ? STATIC_END_ROWS : STATIC_START_ROWS, count = own + at->tubes;
    memset(rows, 0, (size_t)count * sizeof *rows);
    memset(jacobian, 0, (size_t)count * sizeof *jacobian);
    double values[2][3] = {{0}}, by_y[2][3][STATIC_ROWS_MAX] = {{{0}}};
    add_difference(at->position, STATIC_R, y, values[0], by_y[0]);
    add_difference(none, STATIC_N, y, values[1], by_y[1]);
    add_hold(&at->kind.hold, values, by_y, rows, jacobian);
    if (at->kind.holds_rotation) {
        add_turn(at->rotation, q, ones, rows + 3, jacobian + 3);
    } else {
        add_difference(none, STATIC_M, y, rows + 3, jacobian + 3);
        double sign = end ? 1 : -1;
        const double spring[3] = {sign * at->spring[0], sign * at->spring[1], sign * at->spring[2]};
        add_turn(at->upright, q, spring, rows + 3, jacobian + 3);
    }
    if (!end) { /* |q| is the same everywhere */
        rows[6] = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1;
        for (int k = 0; k < 4; k++) {
            jacobian[6][STATIC_Q + k] = 2 * q[k];
        }
    }
    for (int i = 0; i < at->tubes; i++) {
        const double *theta = y + STATIC_TUBES + 2 * i, *torsion = theta + 1;
        rows[own + i] = end ? *torsion : *theta - at->turned[i] - at->softness[i] * *torsion;
        jacobian[own + i][STATIC_TUBES + 2 * i] = end ? 0 : 1;
        jacobian[own + i][STATIC_TUBES + 2 * i + 1] = end ? 1 : -at->softness[i];
    }
}

double static_twist(const solve_rod *rod)
{
    const quantity twist = rod->scene.end.twist;
    return rod->ends[1].holds_rotation && twist.is_given
               ? quantity_value(twist, scene_length(&rod->scene), 0)
               : 0;
}

/* ---- single places ------------------------------------------------------------------------- */

/* What comes after a joint: the rows of q times the turn from the right, those of m in its frame.
 */
static void turn_rows(const double *turn, double *after, double (*by_y)[STATIC_ROWS_MAX])
{
    matrix3 rotation, unused[4];
    double q[4], m[3];
    rotation_of(turn, rotation, unused);
    quaternion_product(after + STATIC_Q, turn, q);
    to_body(rotation, after + STATIC_M, m);
    memcpy(after + STATIC_Q, q, sizeof q);
    memcpy(after + STATIC_M, m, sizeof m);
    for (int c = 0; c < STATIC_TUBES && by_y; c++) {
        double column_q[4], column_m[3];
        for (int i = 0; i < 4; i++) {
            column_q[i] = by_y[STATIC_Q + i][c];
        }
        for (int i = 0; i < 3; i++) {
            column_m[i] = by_y[STATIC_M + i][c];
        }
        quaternion_product(column_q, turn, q);
        to_body(rotation, column_m, m);
        for (int i = 0; i < 4; i++) {
            by_y[STATIC_Q + i][c] = q[i];
        }
        for (int i = 0; i < 3; i++) {
            by_y[STATIC_M + i][c] = m[i];
        }
    }
}

void static_jump_over(const static_jump *at, const double *before, double *after,
                      double (*by_y)[STATIC_ROWS_MAX])
{
    for (int r = 0; r < at->rows && by_y; r++) {
        for (int c = 0; c < at->rows; c++) {
            by_y[r][c] = r == c;
        }
    }
    memcpy(after, before, (size_t)at->rows * sizeof *after);
    act(at->acting, at->numbers, before, after, by_y);
    if (at->turn) {
        turn_rows(at->turn, after, by_y);
    }
}
