/* Shooting through a random scene: extrapolated midpoint steps (Hairer, Norsett, Wanner, Solving
 * Ordinary Differential Equations I, II.9) from edge to edge, and Newton's method for what is
 * unknown at s = 0. */
#include "random_scenes.h"

#include <math.h>
#include <string.h>

enum { BEAM = 4, ROD = 13, ROWS_MAX = ROD, UNKNOWN_MAX = 6, COLUMNS = 9, DEPTH = 8, STEPS = 30 };

/* What counts as rounding of a step, and of what is unknown, in units of its scale. */
static const double ROUNDING = 4e-15, ENOUGH = 1e-11;

/* ---- equations ------------------------------------------------------------------------------- */

typedef void equations(const random_scene *x, double s, double inside, const double *y, double *to);

static void cross(const double *a, const double *b, double *to)
{
    to[0] = a[1] * b[2] - a[2] * b[1];
    to[1] = a[2] * b[0] - a[0] * b[2];
    to[2] = a[0] * b[1] - a[1] * b[0];
}

/* a + 2 w (p x a) + 2 p x (p x a) for q = (w, p), turned round by sign -1. */
static void rotate(const double *q, double sign, const double *a, double *to)
{
    double p[3] = {sign * q[1], sign * q[2], sign * q[3]}, once[3], twice[3];
    cross(p, a, once);
    cross(p, once, twice);
    for (int i = 0; i < 3; i++) {
        to[i] = a[i] + 2 * (q[0] * once[i] + twice[i]);
    }
}

/* y: r, q, N in the world, m in the body:
 *   r' = R (e3 + n/K), q' = q (0, u)/2, N' = -f, m' = -u x m - v x n - R^T l (Antman 2005, ch. 8)
 */
static void rod_equations(const random_scene *x, double s, double inside, const double *y,
                          double *to)
{
    const double *q = y + 3, *N = y + 7, *m = y + 10;
    double n[3], v[3], u[3], f[3], l[3], load[3], bent[3], sheared[3];
    const double stiffness[3] = {profile_value(&x->bending[0], s, inside),
                                 profile_value(&x->bending[1], s, inside),
                                 profile_value(&x->torsion, s, inside)};
    rotate(q, -1, N, n);
    for (int i = 0; i < 3; i++) {
        v[i] = (i == 2) + n[i] / (i == 2 ? x->axial : x->shear[i]);
        u[i] = profile_value(&x->curvature[i], s, inside) + m[i] / stiffness[i];
        f[i] = profile_value(&x->force[i], s, inside);
        l[i] = profile_value(&x->moment[i], s, inside);
    }
    rotate(q, 1, v, to);
    to[3] = -(q[1] * u[0] + q[2] * u[1] + q[3] * u[2]) / 2;
    cross(q + 1, u, to + 4);
    for (int i = 0; i < 3; i++) {
        to[4 + i] = (q[0] * u[i] + to[4 + i]) / 2;
    }
    if (x->follower_line) {
        rotate(q, 1, f, load);
        memcpy(f, load, sizeof f);
    } else {
        rotate(q, -1, l, load);
        memcpy(l, load, sizeof l);
    }
    cross(u, m, bent);
    cross(v, n, sheared);
    for (int i = 0; i < 3; i++) {
        to[7 + i] = -f[i];
        to[10 + i] = -bent[i] - sheared[i] - l[i];
    }
}

/* y: w, psi, V, M; physics/beam.h: V = kGA (w' - psi), M = EI psi', V' = k w - q, M' = -V - mu. */
static void beam_equations(const random_scene *x, double s, double inside, const double *y,
                           double *to)
{
    to[0] = y[1] + y[2] / x->shear[0];
    to[1] = y[3] / profile_value(&x->bending[0], s, inside);
    to[2] =
        profile_value(&x->foundation, s, inside) * y[0] - profile_value(&x->force[0], s, inside);
    to[3] = -y[2] - profile_value(&x->moment[0], s, inside);
}

/* ---- integration ----------------------------------------------------------------------------- */

typedef struct shot {
    const random_scene *scene;
    equations *f;
    int rows;
    double scale[ROWS_MAX]; /* of each row: what counts as 1 */
} shot;

/* The modified midpoint rule with so many steps. */
static void midpoint(const shot *by, const double *y, double s, double h, int steps, double *to)
{
    double inside = s + h / 2, before[ROWS_MAX], now[ROWS_MAX], rate[ROWS_MAX], step = h / steps;
    memcpy(before, y, sizeof before);
    by->f(by->scene, s, inside, y, rate);
    for (int k = 0; k < by->rows; k++) {
        now[k] = y[k] + step * rate[k];
    }
    for (int i = 1; i < steps; i++) {
        by->f(by->scene, s + i * step, inside, now, rate);
        for (int k = 0; k < by->rows; k++) {
            double next = before[k] + 2 * step * rate[k];
            before[k] = now[k];
            now[k] = next;
        }
    }
    by->f(by->scene, s + h, inside, now, rate);
    for (int k = 0; k < by->rows; k++) {
        to[k] = (before[k] + now[k] + step * rate[k]) / 2;
    }
}

/* From s to s + h in place; in halves where the last two of the extrapolation do not agree. */
static void integrate(const shot *by, double *y, double s, double h, int depth)
{
    double table[2][COLUMNS][ROWS_MAX], off = INFINITY;
    for (int j = 0; j < COLUMNS && off > ROUNDING; j++) {
        double(*now)[ROWS_MAX] = table[j % 2], (*before)[ROWS_MAX] = table[(j + 1) % 2];
        midpoint(by, y, s, h, 2 * (j + 1), now[0]);
        for (int k = 1; k <= j; k++) {
            double ratio = (j + 1.0) / (j + 1 - k);
            off = 0;
            for (int i = 0; i < by->rows; i++) {
                double change = (now[k - 1][i] - before[k - 1][i]) / (ratio * ratio - 1);
                now[k][i] = now[k - 1][i] + change;
                off = fmax(off, fabs(change) / (by->scale[i] + fabs(now[k][i])));
            }
        }
        if (off <= ROUNDING || (depth == 0 && j == COLUMNS - 1)) {
            memcpy(y, now[j], (size_t)by->rows * sizeof *y);
            return;
        }
    }
    integrate(by, y, s, h / 2, depth - 1);
    integrate(by, y, s + h / 2, h - h / 2, depth - 1);
}

/* Through the whole rod in place, with the first three rows at s [count] in between. */
static void shoot(const shot *by, double *y, int count, const double *s, double (*position)[3])
{
    const random_scene *x = by->scene;
    double from = 0;
    int next = 0;
    for (int i = 0; i < x->edge_count; i++) {
        for (;;) {
            bool here = next < count && s[next] <= x->edges[i];
            double to = here ? s[next] : x->edges[i];
            if (to > from) {
                integrate(by, y, from, to - from, DEPTH);
                from = to;
            }
            if (!here) {
                break;
            }
            memcpy(position[next++], y, sizeof *position);
        }
    }
}

/* ---- shooting -------------------------------------------------------------------------------- */

/* y at s = 0, clamped there. */
static void start(const shot *by, const double *unknown, double *y)
{
    memset(y, 0, ROWS_MAX * sizeof *y);
    if (by->rows == BEAM) {
        memcpy(y + 2, unknown, 2 * sizeof *y);
    } else {
        memcpy(y + 3, by->scene->rotation, 4 * sizeof *y);
        memcpy(y + 7, unknown, 6 * sizeof *y);
    }
}

/* What is left at the other end, which is free or pulled. */
static void miss(const shot *by, const double *unknown, double *rest)
{
    const random_scene *x = by->scene;
    double y[ROWS_MAX], force[3];
    start(by, unknown, y);
    shoot(by, y, 0, NULL, NULL);
    if (by->rows == BEAM) {
        rest[0] = y[2] - x->tip_force[0];
        rest[1] = y[3];
        return;
    }
    memcpy(force, x->tip_force, sizeof force);
    if (x->follower_tip) {
        rotate(y + 3, 1, x->tip_force, force);
    }
    for (int i = 0; i < 3; i++) {
        rest[i] = y[7 + i] - force[i];
        rest[3 + i] = y[10 + i];
    }
}

/* Gauss's elimination with pivots, in place; x: the right side, then the solution. */
static void eliminate(int n, double a[UNKNOWN_MAX][UNKNOWN_MAX], double *x)
{
    for (int k = 0; k < n; k++) {
        int pivot = k;
        for (int i = k + 1; i < n; i++) {
            pivot = fabs(a[i][k]) > fabs(a[pivot][k]) ? i : pivot;
        }
        for (int j = 0; j < n; j++) {
            double swap = a[k][j];
            a[k][j] = a[pivot][j];
            a[pivot][j] = swap;
        }
        double swap = x[k];
        x[k] = x[pivot];
        x[pivot] = swap;
        for (int i = k + 1; i < n; i++) {
            double factor = a[i][k] / a[k][k];
            for (int j = k; j < n; j++) {
                a[i][j] -= factor * a[k][j];
            }
            x[i] -= factor * x[k];
        }
    }
    for (int k = n - 1; k >= 0; k--) {
        for (int j = k + 1; j < n; j++) {
            x[k] -= a[k][j] * x[j];
        }
        x[k] /= a[k][k];
    }
}

/* By differences. */
static void differentiate(const shot *by, int n, const double *unknown, const double *rest,
                          double (*by_unknown)[UNKNOWN_MAX])
{
    for (int k = 0; k < n; k++) {
        double moved[UNKNOWN_MAX], other[UNKNOWN_MAX];
        double step = 1e-6 * by->scale[by->rows == BEAM ? 2 + k : 7 + k];
        memcpy(moved, unknown, sizeof moved);
        moved[k] += step;
        miss(by, moved, other);
        for (int i = 0; i < n; i++) {
            by_unknown[i][k] = (other[i] - rest[i]) / step;
        }
    }
}

/* Of a beam everything is as small as its loads; so much of the loads is lost by levers. */
static shot shot_of(const random_scene *x, const double *guess)
{
    static const double LEVER = 1e-2;
    bool is_beam = x->bending[1].count == 0;
    double L = x->length, stiffness = x->bending[0].parts[0].value;
    double force = stiffness / (L * L), moment = stiffness / L;
    shot by = {.scene = x, .rows = is_beam ? BEAM : ROD};
    by.f = is_beam ? beam_equations : rod_equations;
    for (int i = 0; i < 3; i++) {
        by.scale[i] = L;
        by.scale[7 + i] = force;
        by.scale[10 + i] = moment;
    }
    for (int i = 3; i < 7; i++) {
        by.scale[i] = 1;
    }
    if (is_beam) {
        double small = LEVER * (fabs(guess[0]) / force + fabs(guess[1]) / moment);
        const double of_beam[BEAM] = {L * small, small, force * small, moment * small};
        memcpy(by.scale, of_beam, sizeof of_beam);
    }
    return by;
}

bool random_scene_shoot(const random_scene *x, const double *guess, int count, const double *s,
                        double (*position)[3])
{
    const shot by = shot_of(x, guess);
    int n = by.rows == BEAM ? 2 : 6, first = by.rows == BEAM ? 2 : 7;
    double unknown[UNKNOWN_MAX] = {0}, rest[UNKNOWN_MAX], y[ROWS_MAX], last = INFINITY;
    double jacobian[UNKNOWN_MAX][UNKNOWN_MAX], copy[UNKNOWN_MAX][UNKNOWN_MAX];
    memcpy(unknown, guess, (size_t)n * sizeof *unknown);
    miss(&by, unknown, rest);
    differentiate(&by, n, unknown, rest, jacobian);
    for (int i = 0; i < STEPS && last > ENOUGH; i++) {
        memcpy(copy, jacobian, sizeof copy);
        eliminate(n, copy, rest);
        double before = last;
        last = 0;
        for (int k = 0; k < n; k++) {
            unknown[k] -= rest[k];
            last = fmax(last, fabs(rest[k]) / by.scale[first + k]);
        }
        miss(&by, unknown, rest);
        if (last > 1e-6 || last > before / 4) {
            differentiate(&by, n, unknown, rest, jacobian);
        }
    }
    start(&by, unknown, y);
    shoot(&by, y, count, s, position);
    return last <= ENOUGH;
}
