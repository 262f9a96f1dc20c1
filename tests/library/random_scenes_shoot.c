/* Shooting through a random scene: extrapolated midpoint steps (Hairer, Norsett, Wanner, Solving
 * Ordinary Differential Equations I, II.9) from edge to edge, and Newton's method for what is
 * unknown at s = 0. */
#include "random_scenes.h"

#include <math.h>
#include <string.h>

enum { BEAM = 4, ROD = RANDOM_ROWS, ROWS_MAX = ROD, UNKNOWN_MAX = 6, COLUMNS = 9, DEPTH = 8 };
enum { STEPS = 20, STRAIN_STEPS = 40 };

/* What counts as rounding of a step, and of what is unknown, in units of its scale; where rounding
 * keeps Newton's method from that, what is closer than NEAR has converged, too. */
static const double ROUNDING = 4e-15, ENOUGH = 1e-11, NEAR = 1e-8;

typedef struct shot shot;
typedef void equations(const shot *by, double s, double inside, const double *y, double *to);

struct shot {
    const random_scene *scene;
    equations *f;
    bool bare; /* without loads, and unstressed */
    int rows;
    double scale[ROWS_MAX]; /* of each row: what counts as 1 */
};

/* ---- algebra --------------------------------------------------------------------------------- */

static void cross(const double *a, const double *b, double *to)
{
    to[0] = a[1] * b[2] - a[2] * b[1];
    to[1] = a[2] * b[0] - a[0] * b[2];
    to[2] = a[0] * b[1] - a[1] * b[0];
}

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
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

/* p* q for sign -1, p q for 1. */
static void multiply(const double *p, double sign, const double *q, double *to)
{
    const double a[3] = {sign * p[1], sign * p[2], sign * p[3]};
    double turned[3];
    cross(a, q + 1, turned);
    to[0] = p[0] * q[0] - dot(a, q + 1);
    for (int i = 0; i < 3; i++) {
        to[1 + i] = p[0] * q[1 + i] + q[0] * a[i] + turned[i];
    }
}

/* q exp(vector/2) */
static void turn_by(const double *q, const double *vector, double *to)
{
    double angle = sqrt(dot(vector, vector)), ratio = angle > 0 ? sin(angle / 2) / angle : 0.5;
    const double turn[4] = {cos(angle / 2), ratio * vector[0], ratio * vector[1],
                            ratio * vector[2]};
    multiply(q, 1, turn, to);
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

/* ---- tendons and chambers -------------------------------------------------------------------- */

/* What they add to (n, m) at strains x = (v, u), and its derivatives by them: a tendon along
 * p' = v + u x r + r' pulls by its tension along p', at r; a chamber along d3. */
static void pulls(const random_scene *of, double s, double inside, const double *x, double *wrench,
                  double (*by)[UNKNOWN_MAX])
{
    memset(wrench, 0, UNKNOWN_MAX * sizeof *wrench);
    memset(by, 0, UNKNOWN_MAX * sizeof *by);
    for (int i = 0; i < of->pull_count; i++) {
        const random_pull *at = &of->pulls[i];
        double angle = at->winding * s + at->phase, rate = at->radius * at->winding;
        double r[3] = {at->radius * cos(angle), at->radius * sin(angle), 0};
        double along[3] = {0, 0, 1}, moment[3], pull = at->tension;
        if (inside < at->from || inside > at->to) {
            continue;
        }
        if (at->is_chamber) {
            pull = -pull * (1 + at->taper * s / of->length);
        } else {
            cross(x + 3, r, along);
            along[0] += x[0] - rate * sin(angle);
            along[1] += x[1] + rate * cos(angle);
            along[2] += x[2];
        }
        double length = sqrt(dot(along, along));
        for (int k = 0; k < 3; k++) {
            along[k] /= length;
        }
        cross(r, along, moment);
        for (int k = 0; k < 3; k++) {
            wrench[k] += pull * along[k];
            wrench[3 + k] += pull * moment[k];
        }
        for (int c = 0; c < UNKNOWN_MAX && !at->is_chamber; c++) {
            double unit[3] = {c % 3 == 0, c % 3 == 1, c % 3 == 2}, change[3];
            if (c < 3) {
                memcpy(change, unit, sizeof change);
            } else {
                cross(unit, r, change);
            }
            double part = dot(along, change);
            for (int k = 0; k < 3; k++) {
                change[k] = pull / length * (change[k] - part * along[k]);
            }
            cross(r, change, moment);
            for (int k = 0; k < 3; k++) {
                by[k][c] += change[k];
                by[3 + k][c] += moment[k];
            }
        }
    }
}

/* off = x - rest - compliance (wrench - pulls(x)); returns its size, and the derivatives by x. */
static double strain_miss(const random_scene *of, double s, double inside, const double *given,
                          const double *x, double *off, double (*by)[UNKNOWN_MAX])
{
    const double *rest = given, *compliance = given + 6, *wrench = given + 12;
    double pulled[UNKNOWN_MAX], size = 0;
    pulls(of, s, inside, x, pulled, by);
    for (int k = 0; k < UNKNOWN_MAX; k++) {
        off[k] = x[k] - rest[k] - compliance[k] * (wrench[k] - pulled[k]);
        size += off[k] * off[k] * (k < 3 ? 1 : of->length * of->length);
        for (int c = 0; c < UNKNOWN_MAX; c++) {
            by[k][c] = (k == c) + compliance[k] * by[k][c];
        }
    }
    return sqrt(size);
}

/* The strains x of rest, compliance and wrench, 6 each: a minimum of a convex energy, by Newton's
 * method with steps that are shortened until less is missing. */
static void strains_of(const random_scene *of, double s, double inside, const double *given,
                       double *x)
{
    double by[UNKNOWN_MAX][UNKNOWN_MAX], step[UNKNOWN_MAX], next[UNKNOWN_MAX], size = 0;
    for (int k = 0; k < UNKNOWN_MAX; k++) {
        x[k] = given[k] + given[6 + k] * given[12 + k];
    }
    if (of->pull_count > 0) {
        size = strain_miss(of, s, inside, given, x, step, by);
    }
    for (int i = 0; i < STRAIN_STEPS && size > 0; i++) {
        double share = 1, before = size, move = 0;
        eliminate(UNKNOWN_MAX, by, step);
        for (int k = 0; k < UNKNOWN_MAX; k++) {
            move = fmax(move, fabs(step[k]) * (k < 3 ? 1 : of->length));
        }
        do {
            double unused[UNKNOWN_MAX];
            for (int k = 0; k < UNKNOWN_MAX; k++) {
                next[k] = x[k] - share * step[k];
            }
            size = strain_miss(of, s, inside, given, next, unused, by);
            share /= 2;
        } while (move > 1e-9 && !(size < before) && share > 1e-9);
        memcpy(x, next, sizeof next);
        size = move > 1e-9 ? strain_miss(of, s, inside, given, x, step, by) : 0;
    }
}

/* ---- equations ------------------------------------------------------------------------------- */

static const random_piece *piece_at(const random_scene *x, double inside)
{
    int i = 0;
    while (i + 1 < x->piece_count && inside > x->pieces[i].to) {
        i++;
    }
    return &x->pieces[i];
}

/* y: r, q, N in the world, m in the body:
 *   r' = R v, q' = q (0, u)/2, N' = -f, m' = -u x m - v x n - R^T l (Antman 2005, ch. 8)
 */
static void rod_equations(const shot *by, double s, double inside, const double *y, double *to)
{
    const random_scene *x = by->scene;
    const random_piece *piece = piece_at(x, inside);
    const double *q = y + 3, *N = y + 7, *m = y + 10;
    double given[18], strains[6], f[3], l[3], load[3], bent[3], sheared[3];
    double *rest = given, *compliance = given + 6, *wrench = given + 12;
    double *n = wrench, *v = strains, *u = strains + 3;
    rotate(q, -1, N, n);
    for (int i = 0; i < 3; i++) {
        const profile *stiffness = i < 2 ? &piece->bending[i] : &piece->torsion;
        wrench[3 + i] = m[i];
        rest[i] = i < 2 ? 0 : x->stretch.count > 0 ? profile_value(&x->stretch, s, inside) : 1;
        rest[3 + i] = profile_value(&piece->curvature[i], s, inside);
        compliance[i] = 1 / (i < 2 ? x->shear[i] : x->axial);
        compliance[3 + i] = 1 / profile_value(stiffness, s, inside);
        f[i] = profile_value(&x->force[i], s, inside);
        l[i] = profile_value(&x->moment[i], s, inside);
    }
    memcpy(strains, rest, sizeof strains);
    if (!by->bare) {
        strains_of(x, s, inside, given, strains);
    }
    memset(to, 0, ROD * sizeof *to);
    rotate(q, 1, v, to);
    cross(q + 1, u, to + 4);
    to[3] = -dot(q + 1, u) / 2;
    for (int i = 0; i < 3; i++) {
        to[4 + i] = (q[0] * u[i] + to[4 + i]) / 2;
    }
    if (by->bare) {
        return;
    }
    if (x->follows) {
        rotate(q, 1, f, load);
        memcpy(f, load, sizeof f);
    } else {
        rotate(q, -1, l, load);
        memcpy(l, load, sizeof l);
    }
    cross(u, m, bent);
    cross(v, n, sheared);
    for (int i = 0; i < 3; i++) {
        to[7 + i] = -f[i] - x->mass * x->gravity[i];
        to[10 + i] = -bent[i] - sheared[i] - l[i];
    }
}

/* y: w, psi, V, M; physics/beam/beam.h: V = kGA (w' - psi), M = EI psi', V' = k w - q, M' = -V -
 * mu. */
static void beam_equations(const shot *by, double s, double inside, const double *y, double *to)
{
    const random_scene *x = by->scene;
    to[0] = y[1] + y[2] / x->shear[0];
    to[1] = y[3] / profile_value(&piece_at(x, inside)->bending[0], s, inside);
    to[2] =
        profile_value(&x->foundation, s, inside) * y[0] - profile_value(&x->force[0], s, inside);
    to[3] = -y[2] - profile_value(&x->moment[0], s, inside);
}

/* ---- single places --------------------------------------------------------------------------- */

/* Of the energy 1/2 turning phi^2, phi the rotation vector from upright to q: by the inverse of
 * the derivative of the exponential (Iserles et al., Acta Numerica 9, 2000), transposed,
 * (1 - phi/2 x + c phi x phi x). */
static void spring_moment(const random_spring *spring, const double *q, double *moment)
{
    double off[4], phi[3], pull[3], once[3], twice[3];
    multiply(spring->upright, -1, q, off);
    double sine = sqrt(dot(off + 1, off + 1)), sign = off[0] < 0 ? -1 : 1;
    double angle = 2 * atan2(sine, sign * off[0]);
    double c = angle > 1e-2 ? (1 - angle / 2 / tan(angle / 2)) / (angle * angle)
                            : 1.0 / 12 + angle * angle / 720;
    for (int i = 0; i < 3; i++) {
        phi[i] = sine > 0 ? sign * off[1 + i] * angle / sine : 0;
        pull[i] = spring->turning[i] * phi[i];
    }
    cross(phi, pull, once);
    cross(phi, once, twice);
    for (int i = 0; i < 3; i++) {
        moment[i] = -(pull[i] - once[i] / 2 + c * twice[i]);
    }
}

static void take(double *y, const double *force, const double *moment)
{
    for (int i = 0; i < 3; i++) {
        y[7 + i] -= force[i];
        y[10 + i] -= moment[i];
    }
}

/* Over what acts at s; a joint comes last. */
static void jump(const shot *by, double s, double *y)
{
    const random_scene *x = by->scene;
    double force[3], moment[3];
    for (int i = 0; i < x->load_count && !by->bare; i++) {
        const random_load *load = &x->loads[i];
        if (load->at != s) {
            continue;
        }
        if (x->is_beam) {
            y[2] -= load->force[0];
            y[3] -= load->moment[0];
            continue;
        }
        memcpy(force, load->force, sizeof force);
        memcpy(moment, load->moment, sizeof moment);
        if (load->follows) {
            rotate(y + 3, 1, load->force, force);
        } else {
            rotate(y + 3, -1, load->moment, moment);
        }
        take(y, force, moment);
    }
    for (int i = 0; i < x->spring_count && !by->bare; i++) {
        const random_spring *spring = &x->springs[i];
        if (spring->at != s) {
            continue;
        }
        if (x->is_beam) {
            y[2] += spring->stiffness[1] * y[0];
            y[3] += spring->turning[0] * y[1];
            continue;
        }
        for (int k = 0; k < 3; k++) {
            force[k] = spring->stiffness[k] * (spring->anchor[k] - y[k]);
        }
        spring_moment(spring, y + 3, moment);
        take(y, force, moment);
    }
    for (int i = 1; i < x->piece_count && !x->is_beam; i++) {
        if (x->pieces[i - 1].to == s) {
            const double none[4] = {1};
            double turn[4], q[4];
            turn_by(none, x->pieces[i].turn, turn);
            multiply(y + 3, 1, turn, q);
            memcpy(y + 3, q, sizeof q);
            rotate(turn, -1, y + 10, moment);
            memcpy(y + 10, moment, sizeof moment);
        }
    }
}

/* What s = 0 does not hold follows from what acts there. */
static void begin(const shot *by, double *y)
{
    const random_end *end = &by->scene->ends[0];
    int first = by->rows == BEAM ? 2 : 7, many = by->rows == BEAM ? 1 : 3;
    double free[ROWS_MAX];
    memcpy(free, y, sizeof free);
    memset(free + first, 0, 2 * (size_t)many * sizeof *free);
    jump(by, 0, free);
    if (!end->holds_position) {
        memcpy(y + first, free + first, (size_t)many * sizeof *y);
    }
    if (!end->holds_rotation) {
        memcpy(y + first + many, free + first + many, (size_t)many * sizeof *y);
    }
}

/* ---- integration ----------------------------------------------------------------------------- */

/* The modified midpoint rule with so many steps. */
static void midpoint(const shot *by, const double *y, double s, double h, int steps, double *to)
{
    double inside = s + h / 2, before[ROWS_MAX], now[ROWS_MAX], rate[ROWS_MAX], step = h / steps;
    memcpy(before, y, sizeof before);
    by->f(by, s, inside, y, rate);
    for (int k = 0; k < by->rows; k++) {
        now[k] = y[k] + step * rate[k];
    }
    for (int i = 1; i < steps; i++) {
        by->f(by, s + i * step, inside, now, rate);
        for (int k = 0; k < by->rows; k++) {
            double next = before[k] + 2 * step * rate[k];
            before[k] = now[k];
            now[k] = next;
        }
    }
    by->f(by, s + h, inside, now, rate);
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

/* From s = 0 to another place in place, beyond what acts there where that is the end of the rod,
 * with the first three rows at s [count] in between. */
static void shoot(const shot *by, double until, double *y, int count, const double *s,
                  double (*position)[3])
{
    const random_scene *x = by->scene;
    double from = 0;
    int next = 0;
    for (int i = 0; i < x->edge_count && from < until; i++) {
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
        if (x->edges[i] > 0 && (from < until || until == x->length)) {
            jump(by, x->edges[i], y);
        }
    }
}

/* ---- shooting -------------------------------------------------------------------------------- */

/* Of a beam everything is as small as its loads; so much of the loads is lost by levers. */
static shot shot_of(const random_scene *x, const double *guess)
{
    static const double LEVER = 1e-2;
    double L = x->length, force = x->stiffness / (L * L), moment = x->stiffness / L;
    shot by = {.scene = x, .rows = x->is_beam ? BEAM : ROD};
    by.f = x->is_beam ? beam_equations : rod_equations;
    for (int i = 0; i < 3; i++) {
        by.scale[i] = L;
        by.scale[7 + i] = force;
        by.scale[10 + i] = moment;
    }
    for (int i = 3; i < 7; i++) {
        by.scale[i] = 1;
    }
    if (x->is_beam) {
        double small = fabs(guess[0]) / L + fabs(guess[1]) +
                       LEVER * (fabs(guess[2]) / force + fabs(guess[3]) / moment);
        const double of_beam[BEAM] = {L * small, small, force * small, moment * small};
        memcpy(by.scale, of_beam, sizeof of_beam);
    }
    return by;
}

void random_scene_carry(const random_scene *x, bool bare, double to, double *y)
{
    shot by = shot_of(x, y);
    by.bare = bare;
    if (!bare) {
        begin(&by, y);
    }
    shoot(&by, to, y, 0, NULL, NULL);
}

/* Of each pair of pose and wrench at s = 0 the one that the end leaves open. */
static int unknown_rows(const shot *by, int *rows)
{
    const random_end *end = &by->scene->ends[0];
    if (by->rows == BEAM) {
        rows[0] = end->holds_position ? 2 : 0;
        rows[1] = end->holds_rotation ? 3 : 1;
        return 2;
    }
    for (int i = 0; i < 3; i++) { /* a rotation is counted from that of the guess */
        rows[i] = end->holds_position ? 7 + i : i;
        rows[3 + i] = end->holds_rotation ? 10 + i : 3 + i;
    }
    return 6;
}

/* y at s = 0. */
static void start(const shot *by, const double *guess, const double *unknown, double *y)
{
    const random_end *end = &by->scene->ends[0];
    int rows[UNKNOWN_MAX], n = unknown_rows(by, rows);
    memset(y, 0, ROWS_MAX * sizeof *y);
    for (int i = 0; i < n; i++) {
        y[rows[i]] = unknown[i];
    }
    if (by->rows == ROD && end->holds_rotation) {
        memcpy(y + 3, end->rotation, sizeof end->rotation);
    } else if (by->rows == ROD) {
        turn_by(guess + 3, unknown + 3, y + 3);
    }
    if (by->rows == ROD && end->holds_position) {
        memcpy(y, end->position, sizeof end->position);
    }
    begin(by, y);
}

/* What is left at the other end. */
static void miss(const shot *by, const double *guess, const double *unknown, double *rest)
{
    const random_end *end = &by->scene->ends[1];
    double y[ROWS_MAX], off[4];
    start(by, guess, unknown, y);
    shoot(by, by->scene->length, y, 0, NULL, NULL);
    if (by->rows == BEAM) {
        rest[0] = y[end->holds_position ? 0 : 2];
        rest[1] = y[end->holds_rotation ? 1 : 3];
        return;
    }
    multiply(end->rotation, -1, y + 3, off);
    for (int i = 0; i < 3; i++) {
        rest[i] = end->holds_position ? y[i] - end->position[i] : y[7 + i];
        rest[3 + i] = end->holds_rotation ? 2 * off[1 + i] : y[10 + i];
    }
}

/* By differences. */
static void differentiate(const shot *by, const double *guess, const double *unknown,
                          const double *rest, double (*by_unknown)[UNKNOWN_MAX])
{
    int rows[UNKNOWN_MAX], n = unknown_rows(by, rows);
    for (int k = 0; k < n; k++) {
        double moved[UNKNOWN_MAX], other[UNKNOWN_MAX], step = 1e-6 * by->scale[rows[k]];
        memcpy(moved, unknown, sizeof moved);
        moved[k] += step;
        miss(by, guess, moved, other);
        for (int i = 0; i < n; i++) {
            by_unknown[i][k] = (other[i] - rest[i]) / step;
        }
    }
}

bool random_scene_shoot(const random_scene *x, const double *guess, int count, const double *s,
                        double (*position)[3])
{
    const shot by = shot_of(x, guess);
    int rows[UNKNOWN_MAX], n = unknown_rows(&by, rows);
    double unknown[UNKNOWN_MAX] = {0}, rest[UNKNOWN_MAX], y[ROWS_MAX], last = INFINITY;
    double jacobian[UNKNOWN_MAX][UNKNOWN_MAX], copy[UNKNOWN_MAX][UNKNOWN_MAX];
    for (int i = 0; i < n; i++) {
        bool turns = by.rows == ROD && rows[i] >= 3 && rows[i] < 7;
        unknown[i] = turns ? 0 : guess[rows[i]];
    }
    miss(&by, guess, unknown, rest);
    differentiate(&by, guess, unknown, rest, jacobian);
    for (int i = 0; i < STEPS && last > ENOUGH; i++) {
        memcpy(copy, jacobian, sizeof copy);
        eliminate(n, copy, rest);
        double before = last;
        last = 0;
        for (int k = 0; k < n; k++) {
            unknown[k] -= rest[k];
            last = fmax(last, fabs(rest[k]) / by.scale[rows[k]]);
        }
        miss(&by, guess, unknown, rest);
        if (last > 1e-6 || last > before / 4) {
            differentiate(&by, guess, unknown, rest, jacobian);
        }
    }
    start(&by, guess, unknown, y);
    shoot(&by, x->length, y, count, s, position);
    return last <= NEAR;
}
