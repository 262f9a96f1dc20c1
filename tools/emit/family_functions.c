/* Parameters within their ranges. */
static int place(const double *parameters, double *x)
{
    int i, status = 0;
    for (i = 0; i < model_PARAMETERS; i++) {
        const double low = model_lower[i], high = model_upper[i],
                     rounding = (high - low) * ROUNDING;
        double value = parameters[i];
        if (!(isgreaterequal(value, low - rounding) && islessequal(value, high + rounding))) {
            status = model_OUT_OF_RANGE;
        }
        value = isgreaterequal(value, low) ? value : low; /* also NaN, without an exception */
        x[i] = value <= high ? value : high;
    }
    return status;
}

static void copy(int count, const double *from, double *to)
{
    int i;
    for (i = 0; i < count; i++) {
        to[i] = from[i];
    }
}

/* The larger of two sizes; not a number where one of them is none. */
static double larger(double one, double other)
{
    return other <= one || one != one ? one : other;
}

static void set_unit(int n, double *x)
{
    int i;
    for (i = 0; i < n * n; i++) {
        x[i] = 0;
    }
    for (i = 0; i < n; i++) {
        x[i * n + i] = 1;
    }
}

/* Memory: inputs p, u, z and, for each parameter, directions of these; residual [N], blocks and
 * edges as newton leaves them; the matrix and its factors; what a change of one point does to
 * forces, to rates and moments; columns of a shape or what they change by; workspace. u is FORCES
 * that depend on the place, the curvature [3][NODES], then HELD numbers of force and moment that
 * hold the end, with TENSIONS as the last. */
typedef struct room {
    double *x, *u, *bent, *z, *dp, *du, *dz, *residual, *blocks, *edges, *matrix, *lower, *force,
        *rate, *moment, *columns, *w;
} room;

static room divide(double *memory)
{
    room r;
    r.x = memory;
    r.u = r.x + P;
    r.bent = r.u + FORCES;
    r.z = r.u + N;
    r.dp = r.z + Z;
    r.du = r.dp + P * P;
    r.dz = r.du + N * P;
    r.residual = r.x + INPUTS;
    r.blocks = r.residual + N;
    r.matrix = r.residual + LINEARISED;
    r.edges = r.matrix - 18 * ELEMENTS;
    r.lower = r.matrix + N * N;
    r.force = r.lower + N * N;
    r.rate = r.force + N * N;
    r.moment = r.rate + N * N;
    r.columns = r.moment + N * (N > P ? N : P);
    r.w = r.columns + model_POINTS * model_COLUMNS * (SHAPE_BY ? P : 1);
    return r;
}

/* x [rows][columns] to [columns][rows]. */
static void transpose(int rows, int columns, const double *x, double *to)
{
    int i, k;
    for (i = 0; i < rows; i++) {
        for (k = 0; k < columns; k++) {
            to[k * rows + i] = x[i * columns + k];
        }
    }
}

/* What all others are from: the state by the curvature. */
static void find_state(room r)
{
    state(r.x, r.z, r.w);
}

/* ---- the linearised equation --------------------------------------------------------------- */

/* Loops of few turns, whose number is known, are what compilers make vectors of. */
enum {
    PART = NODES % 4 == 0 ? 4 : NODES,
    WIDTH = N % 8 == 0   ? 8
            : N % 4 == 0 ? 4
            : N % 3 == 0 ? 3
                         : 1
};

#if !PLACED
/* Blocks [3][3][NODES], effect by cause; the last four where forces follow. Turns, R du integrated,
 * move the slope r', the loads, and the rate of the moment; these in turn the residual. */
enum {
    ROTATION,
    SLOPE_BY_TURN,
    SLOPE_BY_CURVATURE,
    RATE_BY_TURN,
    RATE_BY_CURVATURE,
    BY_TURN,
    BY_CURVATURE,
    BY_MOMENT,
    LOAD_BY_TURN,
    SLOPE_BY_FORCE,
    RATE_BY_FORCE,
    BY_FORCE
};

static const double *block(room r, int which, int i, int k)
{
    return r.blocks + ((which * 3 + i) * 3 + k) * NODES;
}

/* Numbers of points i that are entries [i][k] of 9 matrices [NODES][NODES]. */
static double *entry(double *all, int i, int k, int node)
{
    return all + ((i * 3 + k) * NODES + node) * NODES;
}

/* sum: the integral from each point to the end of `rate`, and what acts at edges, by turns there
 * (acting: 0 force, 1 moment). */
static void integrate_back(room r, const double *rate, int acting, double *sum)
{
    int ik, i, j, k, e, n;
    for (ik = 0; ik < 9; ik++) {
        for (i = 0; i < NODES; i++) {
            const int element = i / STAGES;
            for (j = 0; j < NODES; j += PART) {
                double part[PART] = {0};
                for (k = element * STAGES; k < NODES; k++) {
                    const double by = to_edge[ELEMENTS][k] - to_point[i][k];
                    const double *from = rate + (ik * NODES + k) * NODES + j;
                    for (n = 0; n < PART; n++) {
                        part[n] += by * from[n];
                    }
                }
                for (e = element + 1; e <= ELEMENTS; e++) {
                    const double by = r.edges[(e - 1) * 18 + acting * 9 + ik];
                    for (n = 0; n < PART; n++) {
                        part[n] += by * to_edge[e][j + n];
                    }
                }
                for (n = 0; n < PART; n++) {
                    sum[(ik * NODES + i) * NODES + j + n] = part[n];
                }
            }
        }
    }
}

/* Rates of the moment at point i by a turn rate at point j; loads first, where forces follow. */
static void find_rates(room r)
{
    int a, b, c, i, j;
    for (a = 0; a < 3 && FOLLOWS; a++) {
        for (b = 0; b < 3; b++) {
            for (i = 0; i < NODES; i++) {
                for (j = 0; j < NODES; j++) {
                    entry(r.rate, a, b, i)[j] = block(r, LOAD_BY_TURN, a, b)[i] * to_point[i][j];
                }
            }
        }
    }
    if (FOLLOWS) {
        integrate_back(r, r.rate, 0, r.force);
    }
    for (a = 0; a < 3; a++) {
        for (b = 0; b < 3; b++) {
            for (i = 0; i < NODES; i++) {
                const double by = block(r, RATE_BY_TURN, a, b)[i];
                double *to = entry(r.rate, a, b, i);
                for (j = 0; j < NODES; j++) {
                    to[j] = by * to_point[i][j];
                }
                for (c = 0; c < 3 && FOLLOWS; c++) {
                    const double by_force = block(r, RATE_BY_FORCE, a, c)[i];
                    for (j = 0; j < NODES; j++) {
                        to[j] += by_force * entry(r.force, c, b, i)[j];
                    }
                }
            }
        }
    }
}

/* Row a of point i of the matrix, columns of points j on. */
static void fill(room r, int i, int a, int j)
{
    double turned[3][PART], whole[3];
    int b, c, n;
    for (c = 0; c < 3; c++) {
        whole[c] = block(r, BY_MOMENT, a, c)[i];
    }
    for (b = 0; b < 3; b++) { /* the residual by a turn rate */
        const double by = block(r, BY_TURN, a, b)[i];
        const double *m0 = entry(r.moment, 0, b, i) + j, *m1 = entry(r.moment, 1, b, i) + j,
                     *m2 = entry(r.moment, 2, b, i) + j;
        for (n = 0; n < PART; n++) {
            turned[b][n] =
                by * to_point[i][j + n] + whole[0] * m0[n] + whole[1] * m1[n] + whole[2] * m2[n];
        }
        for (c = 0; c < 3 && FOLLOWS; c++) {
            for (n = 0; n < PART; n++) {
                turned[b][n] += block(r, BY_FORCE, a, c)[i] * entry(r.force, c, b, i)[j + n];
            }
        }
    }
    for (c = 0; c < 3; c++) {
        const double *R0 = block(r, ROTATION, 0, c) + j, *R1 = block(r, ROTATION, 1, c) + j,
                     *R2 = block(r, ROTATION, 2, c) + j;
        const double *K0 = block(r, RATE_BY_CURVATURE, 0, c) + j,
                     *K1 = block(r, RATE_BY_CURVATURE, 1, c) + j,
                     *K2 = block(r, RATE_BY_CURVATURE, 2, c) + j;
        double part[PART];
        for (n = 0; n < PART; n++) {
            part[n] = turned[0][n] * R0[n] + turned[1][n] * R1[n] + turned[2][n] * R2[n] +
                      (to_edge[ELEMENTS][j + n] - to_point[i][j + n]) *
                          (whole[0] * K0[n] + whole[1] * K1[n] + whole[2] * K2[n]);
        }
        copy(PART, part, r.matrix + (a * NODES + i) * N + c * NODES + j);
    }
}

/* Residual and matrix at the state. */
static void make_matrix(room r)
{
    int i, j, a, c;
    newton(r.x, r.residual, r.w);
    find_rates(r);
    integrate_back(r, r.rate, 1, r.moment);
    for (a = 0; a < 3; a++) {
        for (i = 0; i < NODES; i++) {
            for (j = 0; j < NODES; j += PART) {
                fill(r, i, a, j);
            }
            for (c = 0; c < 3; c++) {
                r.matrix[(a * NODES + i) * N + c * NODES + i] += block(r, BY_CURVATURE, a, c)[i];
            }
        }
    }
}

/* to [3][NODES] += a block times x */
static void add_block(room r, int which, const double *x, double *to)
{
    int a, c, i;
    for (a = 0; a < 3; a++) {
        for (c = 0; c < 3; c++) {
            const double *by = block(r, which, a, c);
            for (i = 0; i < NODES; i++) {
                to[a * NODES + i] += by[i] * x[c * NODES + i];
            }
        }
    }
}

/* Sum over points of row [NODES] times x. */
static double weigh(const double *row, const double *x)
{
    double sum = 0;
    int j;
    for (j = 0; j < NODES; j++) {
        sum += row[j] * x[j];
    }
    return sum;
}

/* Changes of forces by turns at points and, by their rates, at edges. */
static void change_forces(room r, const double *turn, const double *rate, double *force)
{
    double load[N] = {0};
    int a, c, i, k, e;
    add_block(r, LOAD_BY_TURN, turn, load);
    for (a = 0; a < 3; a++) {
        for (i = 0; i < NODES; i++) {
            double sum = 0;
            for (k = 0; k < NODES; k++) {
                sum += (to_edge[ELEMENTS][k] - to_point[i][k]) * load[a * NODES + k];
            }
            for (e = i / STAGES + 1; e <= ELEMENTS; e++) {
                for (c = 0; c < 3; c++) {
                    sum += r.edges[(e - 1) * 18 + a * 3 + c] * weigh(to_edge[e], rate + c * NODES);
                }
            }
            force[a * NODES + i] = sum;
        }
    }
}

/* By how much a step moves the rod, m. */
static double distance(room r, const double *step)
{
    double rate[N] = {0}, turn[N], force[N], slope[N] = {0}, most = 0;
    int c, i;
    add_block(r, ROTATION, step, rate);
    for (i = 0; i < N; i++) {
        turn[i] = weigh(to_point[i % NODES], rate + i / NODES * NODES);
    }
    add_block(r, SLOPE_BY_TURN, turn, slope);
    add_block(r, SLOPE_BY_CURVATURE, step, slope);
    if (FOLLOWS) {
        change_forces(r, turn, rate, force);
        add_block(r, SLOPE_BY_FORCE, force, slope);
    }
    for (i = 0; i <= NODES; i++) {
        double square = 0;
        for (c = 0; c < 3; c++) {
            const double moved =
                weigh(i < NODES ? to_point[i] : to_edge[ELEMENTS], slope + c * NODES);
            square += moved * moved;
        }
        most = larger(most, square);
    }
    return LENGTH * sqrt(most);
}

#else
/* What directions du, one for each parameter, and no change of parameters do to the state. */
static void move_state(room r, int first, const double *step)
{
    int i;
    for (i = 0; i < P * P; i++) {
        r.dp[i] = 0;
    }
    for (i = 0; i < N * P; i++) {
        r.du[i] = 0;
    }
    for (i = 0; i < P && first + i < N && !step; i++) {
        r.du[(first + i) * P + i] = 1;
    }
    for (i = 0; i < N && step; i++) {
        r.du[i * P] = step[i];
    }
    state_by(r.x, r.dz, r.w);
}

/* Residual and matrix at the state, P columns at a time. */
static void make_matrix(room r)
{
    int first, i, k;
    residual(r.x, r.residual, r.w);
    for (first = 0; first < N; first += P) {
        move_state(r, first, NULL);
        residual_by(r.x, r.moment, r.w);
        for (i = 0; i < N; i++) {
            for (k = 0; k < P && first + k < N; k++) {
                r.matrix[i * N + first + k] = r.moment[i * P + k];
            }
        }
    }
}

/* By how much a step moves the rod, m. */
static double distance(room r, const double *step)
{
    double most = 0;
    int c, i;
    move_state(r, 0, step);
    places_by(r.x, r.force, r.w);
    for (i = 0; i <= NODES; i++) {
        double square = 0;
        for (c = 0; c < 3; c++) {
            const double moved = r.force[(c * (NODES + 1) + i) * P];
            square += moved * moved;
        }
        most = larger(most, square);
    }
    return LENGTH * sqrt(most);
}
#endif

#if HELD > 0
/* ---- tensions ------------------------------------------------------------------------------ */

/* x [count] with `matrix`, whose last column is the right side: of active rows, 0 of others. */
static void meet(int count, double (*matrix)[HELD + 1], const int *active, double *x)
{
    double left[HELD][HELD + 1];
    int a, b, k;
    copy(HELD * (HELD + 1), matrix[0], left[0]);
    for (k = 0; k < count; k++) {
        for (a = 0; a < count && active[k]; a++) {
            const double factor = a == k ? 0 : left[a][k] / left[k][k];
            for (b = k; b <= HELD; b++) {
                left[a][b] -= factor * left[k][b];
            }
        }
    }
    for (a = 0; a < count; a++) {
        x[a] = active[a] ? left[a][HELD] / left[a][a] : 0;
    }
}

/* Lets go of active rows but for the first `open` whose numbers would be negative; returns how many
 * are. */
static int let_go(int count, int open, const double *wanted, int *active, double *x)
{
    double share = 1;
    int i, negative = 0;
    for (i = open; i < count; i++) {
        if (active[i] && !(wanted[i] > 0)) {
            const double part = x[i] / (x[i] - wanted[i]);
            share = part < share ? part : share;
            negative++;
        }
    }
    for (i = 0; i < count; i++) {
        x[i] += share * (wanted[i] - x[i]);
        active[i] = active[i] && (i < open || !negative || x[i] > ROUNDING * ROUNDING);
        x[i] = active[i] ? x[i] : 0;
    }
    return negative;
}

/* x [count] that is not negative but for the first `open`, with rows of the matrix that are met, or
 * right sides, its last column, that are less and x of 0: by active sets (Lawson and Hanson 1974,
 * ch. 23). Not numbers where none are found. */
static void complement(int count, int open, double (*matrix)[HELD + 1], double *x)
{
    double wanted[HELD];
    int active[HELD], i, j, rounds;
    for (i = 0; i < count; i++) {
        active[i] = i < open;
        x[i] = 0;
    }
    for (rounds = 0; rounds < 4 * HELD + 4; rounds++) {
        double largest = ROUNDING / 1000;
        int next = -1;
        do {
            meet(count, matrix, active, wanted);
        } while (let_go(count, open, wanted, active, x));
        for (i = open; i < count; i++) {
            double left = matrix[i][HELD];
            for (j = 0; j < count; j++) {
                left -= matrix[i][j] * x[j];
            }
            if (!active[i] && left > largest) {
                next = i;
                largest = left;
            }
        }
        if (next < 0) {
            return;
        }
        active[next] = 1;
    }
    for (i = 0; i < count; i++) {
        x[i] = NAN;
    }
}
#endif

/* ---- steps --------------------------------------------------------------------------------- */

/* Of a matrix with tensions the rows that are eliminated; the block that is left says by how much
 * tendons become shorter with tensions, and no tendon with tension is slack, and none without is
 * too long. */
enum { FIRM = N - TENSIONS };

/* Gauss' elimination of the matrix. A pivot makes way where one below it is a hundred times as
 * large. Returns negative pivots and exchanges, more than 0: not stable. A negative pivot of what
 * holds the end takes away a direction in which the rod would give way. NOT_REGULAR: the matrix is
 * singular or has what is not a number, and cannot be solved with. */
enum { NOT_REGULAR = -2 * N };
static int eliminate(double *a, double *lower, int *rows)
{
    double pivot[N];
    int i, j, k, n, negative = 0;
    for (k = 0; k < FIRM; k++) {
        int best = k;
        double by;
        for (i = k + 1; i < FIRM; i++) {
            best = fabs(a[i * N + k]) > fabs(a[best * N + k]) ? i : best;
        }
        rows[k] = k;
        if (100 * fabs(a[k * N + k]) < fabs(a[best * N + k])) {
            for (j = k; j < N; j++) { /* factors of columns before stay where they were found */
                const double held = a[k * N + j];
                a[k * N + j] = a[best * N + j];
                a[best * N + j] = held;
            }
            rows[k] = best;
            negative++;
        }
        by = 1 / a[k * N + k];
        if (!(fabs(by) < HUGE_VAL)) {
            return NOT_REGULAR;
        }
        negative += by < 0 ? (k < N - HELD ? 1 : -1) : 0;
        copy(N, a + k * N, pivot);
        for (i = k + 1; i < N; i++) {
            const double factor = a[i * N + k] * by;
            lower[i * N + k] = factor;
            for (j = k / WIDTH * WIDTH; j < N; j += WIDTH) { /* from the diagonal on is used */
                double *to = a + i * N + j;
                for (n = 0; n < WIDTH; n++) {
                    to[n] -= factor * pivot[j + n];
                }
            }
        }
    }
    return negative;
}

#if TENSIONS > 0
/* Steps of tensions in x, from those of now to where none is slack or too long; NULL: changes of
 * those that pull after the last step, which rows [FIRM on] says. */
static void solve_tensions(room r, int *rows, int apart, double *x, const double *now)
{
    double matrix[HELD][HELD + 1], found[HELD];
    int i, k;
    for (i = 0; i < TENSIONS; i++) {
        matrix[i][HELD] = now ? -x[(FIRM + i) * apart] : x[(FIRM + i) * apart];
        for (k = 0; k < TENSIONS; k++) {
            matrix[i][k] = r.matrix[(FIRM + i) * N + FIRM + k];
            matrix[i][HELD] += now ? matrix[i][k] * now[k] : 0;
        }
    }
    if (now) {
        complement(TENSIONS, 0, matrix, found);
    } else {
        meet(TENSIONS, matrix, rows + FIRM, found);
    }
    for (i = 0; i < TENSIONS; i++) {
        rows[FIRM + i] = now ? found[i] > 0 : rows[FIRM + i];
        x[(FIRM + i) * apart] = now ? now[i] - found[i] : found[i];
    }
}

/* Negative pivots of tensions that pull: each takes away a direction in which the rod would give
 * way. */
static int negative_of(room r, const int *rows)
{
    double a[TENSIONS][TENSIONS];
    int i, j, k, negative = 0;
    for (i = 0; i < TENSIONS; i++) {
        copy(TENSIONS, r.matrix + (FIRM + i) * N + FIRM, a[i]);
    }
    for (k = 0; k < TENSIONS; k++) {
        negative += rows[FIRM + k] && a[k][k] < 0;
        for (i = k + 1; i < TENSIONS && rows[FIRM + k]; i++) {
            const double factor = a[i][k] / a[k][k];
            for (j = k + 1; j < TENSIONS; j++) {
                a[i][j] -= factor * a[k][j];
            }
        }
    }
    return negative;
}
#else
static void solve_tensions(room r, int *rows, int apart, double *x, const double *now)
{
    (void)r;
    (void)rows;
    (void)apart;
    (void)x;
    (void)now;
}

static int negative_of(room r, const int *rows)
{
    (void)r;
    (void)rows;
    return 0;
}
#endif

/* x [N], its numbers `apart` from one another, becomes the solution: the step from tensions of now,
 * or NULL: a change. */
static void solve(room r, int *rows, int apart, double *x, const double *now)
{
    int i, k;
    for (k = 0; k < FIRM; k++) {
        const double at = x[rows[k] * apart];
        x[rows[k] * apart] = x[k * apart];
        x[k * apart] = at;
        for (i = k + 1; i < N; i++) {
            x[i * apart] -= r.lower[i * N + k] * at;
        }
    }
    solve_tensions(r, rows, apart, x, now);
    for (k = N - 1; k >= 0; k--) {
        const double at = k < FIRM ? x[k * apart] / r.matrix[k * N + k] : x[k * apart];
        x[k * apart] = at;
        for (i = 0; i < (k < FIRM ? k : FIRM); i++) {
            x[i * apart] -= r.matrix[i * N + k] * at;
        }
    }
}

/* The matrix at the state, eliminated; returns what that returns. */
static int linearise(room r, int *rows)
{
    make_matrix(r);
    return eliminate(r.matrix, r.lower, rows);
}

/* Of the curvature. */
static double largest(const double *x)
{
    double most = 0;
    int i;
    for (i = FORCES; i < N - HELD; i++) {
        most = larger(most, fabs(x[i]));
    }
    return most;
}

#if HELD > 0
enum { BENT = 3 * NODES };

/* What each number that holds the end, and each tension, does to the equations of the curvature:
 * HELD columns [BENT] in the place of the matrix. */
static void find_holding(room r)
{
    int first, i, k;
    for (first = 0; first < HELD; first += P) {
        move_state(r, N - HELD + first, NULL);
        residual_by(r.x, r.moment, r.w);
        for (k = 0; k < P && first + k < HELD; k++) {
            for (i = 0; i < BENT; i++) {
                r.matrix[(first + k) * BENT + i] = r.moment[(FORCES + i) * P + k];
            }
        }
    }
}

/* Those with which these equations, of which the residual is known, are met best. The last are
 * tensions, which are not negative. */
static void hold_end(room r)
{
    double normal[HELD][HELD + 1], found[HELD];
    double *now = r.u + N - HELD;
    int a, b, i;
    copy(BENT, r.residual + FORCES, r.matrix + HELD * BENT);
    for (a = 0; a < HELD; a++) {
        normal[a][HELD] = 0;
        for (b = 0; b <= HELD; b++) {
            double sum = a == b ? ROUNDING / 1000 : 0;
            for (i = 0; i < BENT; i++) {
                sum += r.matrix[a * BENT + i] * r.matrix[b * BENT + i];
            }
            normal[a][HELD] += b < HELD ? sum * now[b] : -sum;
            if (b < HELD) {
                normal[a][b] = sum;
            }
        }
    }
    complement(HELD, HELD - TENSIONS, normal, found);
    for (a = 0; a < HELD; a++) {
        now[a] = fabs(found[a]) < LARGE ? found[a] : now[a];
    }
}
#endif

/* Forces that are sought, from the curvature: the shape has those that depend on the place but for
 * the stretch by them, and each pass leaves that share of what was missing. */
static void guess_forces(room r)
{
    enum { PASSES = 3 };
    int i, k;
    for (i = 0; i < N; i++) {
        r.u[i] = i < FORCES || i >= N - HELD ? 0 : r.u[i];
    }
    for (k = 0; k < PASSES && FORCES + HELD > 0; k++) {
        find_state(r);
        residual(r.x, r.residual, r.w);
        for (i = 0; i < FORCES; i++) {
            r.u[i] -= r.residual[i];
        }
#if HELD > 0
        if (k == 0) {
            find_holding(r);
        }
        hold_end(r);
#endif
    }
}

/* What the mesh leaves, m, by how much it hardly resolves of the curvature. */
static double mesh_leaves(room r)
{
    double turn = RESOLVED;
    int e, c, k, j;
    for (c = 0; c < 3; c++) {
        for (e = 0; e < ELEMENTS; e++) {
            const double *at = r.bent + c * NODES + e * STAGES;
            for (k = 0; k < 2; k++) {
                double sum = 0;
                for (j = 0; j < STAGES; j++) {
                    sum += modes[k][j] * at[j];
                }
                turn += fabs(sum) * widths[e];
            }
        }
    }
    return MESH * turn;
}

/* What is known before a step, or where none can be taken. */
static int unknown(model_answer *answer)
{
    if (answer) {
        answer->stable = answer->trusted = 0;
        answer->predicted = answer->left = HUGE_VAL;
        answer->ratio = -1;
    }
    return model_SINGULAR;
}

/* By how much the step beyond that in `residual` moves the rod, m, with the last matrix: along what
 * a held end leaves free it may be soft, and far from linear. left: by how much both do. */
static double look_ahead(room r, int *rows, double *left)
{
    double next, before[N], step[N];
    int i;
    copy(N, r.u, before);
    copy(N, r.residual, step);
    for (i = 0; i < N; i++) {
        r.u[i] -= step[i];
    }
    find_state(r);
    residual(r.x, r.residual, r.w);
    solve(r, rows, 1, r.residual, r.u + FIRM);
    next = distance(r, r.residual);
    copy(N, before, r.u);
    find_state(r);
    for (i = 0; i < N; i++) {
        r.residual[i] += step[i];
    }
    *left = distance(r, r.residual);
    return next;
}

/* Parameters and curvature are in r.x. Where there is no step, the curvature is as the one before
 * left it. With an answer the state is that of the curvature at the end. */
static int polish(room r, int steps, model_answer *answer)
{
    int rows[N], i, k, settles, stable = 1;
    double length = 0, before, predicted = 0, left = 0, ratio = -1, mesh;
    guess_forces(r);
    for (k = 0; k < steps || (k == 0 && answer); k++) {
        int negative;
        find_state(r);
        negative = linearise(r, rows);
        if (negative == NOT_REGULAR) {
            return unknown(answer);
        }
        solve(r, rows, 1, r.residual, r.u + FIRM);
        negative -= negative_of(r, rows);
        length = largest(r.residual);
        if (!(length < LARGE)) { /* nor would the curvature be finite for ever */
            return unknown(answer);
        }
        stable = stable && negative == 0;
        if (k == 0 && answer) {
            predicted = left = distance(r, r.residual);
        }
        for (i = 0; i < N && k < steps; i++) {
            r.u[i] -= r.residual[i];
        }
    }
    if (!answer) {
        return 0;
    }
    if (steps > 0) { /* one more, with the last matrix */
        before = length;
        find_state(r);
        residual(r.x, r.residual, r.w);
        solve(r, rows, 1, r.residual, r.u + FIRM);
        left = distance(r, r.residual);
        ratio = before > 0 ? largest(r.residual) / before : 0;
    }
    settles = 4 * ratio <= 1;
    if (HELD > 0) {
        const double first = left;
        settles = 4 * look_ahead(r, rows, &left) <= first && settles;
        predicted = steps > 0 ? predicted : left;
    }
    answer->stable = stable;
    mesh = mesh_leaves(r);
    answer->predicted = predicted + mesh;
    answer->left = left + mesh;
    answer->ratio = ratio;
    answer->trusted =
        stable && 20 * answer->predicted <= LENGTH && (settles || left <= SETTLED * LENGTH);
    return answer->left < HUGE_VAL ? 0 : unknown(answer);
}

int model_network(const double *parameters, double *curvature, double *memory)
{
    const room r = divide(memory);
    const int status = place(parameters, r.x);
    network(r.x, r.bent, r.w);
    transpose(3, NODES, r.bent, curvature);
    return status;
}

int model_polish(const double *parameters, int steps, double *curvature, model_answer *answer,
                 double *memory)
{
    const room r = divide(memory);
    int status = place(parameters, r.x);
    transpose(NODES, 3, curvature, r.bent);
    status |= polish(r, steps, answer);
    transpose(3, NODES, r.bent, curvature);
    return status;
}

/* Columns of each place in turn. */
static void write_shape(room r, double *to)
{
    shape(r.x, r.columns, r.w);
    transpose(model_COLUMNS, model_POINTS, r.columns, to);
}

int model_shape_of(const double *parameters, const double *curvature, double *to, double *memory)
{
    const room r = divide(memory);
    const int status = place(parameters, r.x);
    transpose(NODES, 3, curvature, r.bent);
    guess_forces(r);
    find_state(r);
    write_shape(r, to);
    return status;
}

/* The curvature and its state. */
static int find(room r, const double *parameters, int steps, model_answer *answer)
{
    int status = place(parameters, r.x);
    network(r.x, r.bent, r.w);
    status |= polish(r, steps, answer);
    if (!answer) {
        find_state(r);
    }
    return status;
}

int model_shape(const double *parameters, int steps, double *to, model_answer *answer,
                double *memory)
{
    const room r = divide(memory);
    const int status = find(r, parameters, steps, answer);
    write_shape(r, to);
    return status;
}

#if TIP
int model_tip(const double *parameters, int steps, double *to, model_answer *answer, double *memory)
{
    const room r = divide(memory);
    const int status = find(r, parameters, steps, answer);
    tip(r.x, to, r.w);
    return status;
}
#endif

#if HELD > 0
/* How the forces change with the curvature and the parameters: what holds the end is by least
 * squares, whose matrix changes, too; by differences along each direction. */
static void follow_forces(room r)
{
    double at[P + N], before[N] = {0};
    double *change = r.lower; /* [N][P] */
    int i, k, side;
    copy(P + N, r.x, at);
    copy(N * P, r.du, change);
    for (i = 0; i < P; i++) {
        const double step = DIFFERENCE * (model_upper[i] - model_lower[i]);
        for (side = -1; side <= 1; side += 2) {
            copy(P + N, at, r.x);
            r.x[i] += side * step;
            for (k = FORCES; k < N - HELD; k++) {
                r.u[k] += side * step * change[k * P + i];
            }
            guess_forces(r);
            for (k = 0; k < N && side < 0; k++) {
                before[k] = r.u[k];
            }
        }
        for (k = 0; k < N; k++) {
            if (k < FORCES || k >= N - HELD) {
                change[k * P + i] = (r.u[k] - before[k]) / (2 * step);
            }
        }
    }
    copy(P + N, at, r.x);
    copy(N * P, change, r.du);
    set_unit(P, r.dp);
    find_state(r);
}
#else
/* How the forces change with the curvature and the parameters. */
static void follow_forces(room r)
{
    int i;
    if (FORCES > 0) {
        state_by(r.x, r.dz, r.w);
        residual_by(r.x, r.moment, r.w);
    }
    for (i = 0; i < FORCES * P; i++) {
        r.du[i] = -r.moment[i];
    }
}
#endif

/* Directions of curvature and state for each parameter: of the network where no steps are taken,
 * else of the equilibrium. */
static int find_directions(room r, int steps)
{
    int rows[N], i;
    if (steps > 0 && linearise(r, rows) == NOT_REGULAR) {
        return model_SINGULAR;
    }
    set_unit(P, r.dp);
    if (steps > 0) {                               /* residual (p, u) = 0 */
        solve(r, rows, 1, r.residual, r.u + FIRM); /* which tensions pull */
        for (i = 0; i < N * P; i++) {
            r.du[i] = 0;
        }
        state_by(r.x, r.dz, r.w);
        residual_by(r.x, r.du, r.w);
        for (i = 0; i < P; i++) {
            solve(r, rows, P, r.du + i, NULL);
        }
        for (i = 0; i < N * P; i++) {
            r.du[i] = -r.du[i];
        }
    } else {
        for (i = 0; i < FORCES * P; i++) {
            r.du[i] = 0;
        }
        network_by(r.x, r.du + FORCES * P, r.w);
        follow_forces(r);
    }
    state_by(r.x, r.dz, r.w);
    return 0;
}

static void set_unknown(int n, double *x)
{
    int i;
    for (i = 0; i < n; i++) {
        x[i] = NAN;
    }
}

#if TIP
int model_tip_jacobian(const double *parameters, int steps, double *to, double *jacobian,
                       model_answer *answer, double *memory)
{
    const room r = divide(memory);
    int status = find(r, parameters, steps, answer), singular;
    tip(r.x, to, r.w);
    singular = find_directions(r, steps);
    if (singular) {
        set_unknown(model_COLUMNS * P, jacobian);
    } else {
        tip_by(r.x, jacobian, r.w);
    }
    return status | singular;
}
#endif

#if SHAPE_BY
/* The columns change by columns [COLUMNS][POINTS][P]. */
int model_shape_jacobian(const double *parameters, int steps, double *to, double *jacobian,
                         model_answer *answer, double *memory)
{
    const room r = divide(memory);
    int status = find(r, parameters, steps, answer), singular, i, c, k;
    write_shape(r, to);
    singular = find_directions(r, steps);
    if (singular) {
        set_unknown(model_POINTS * model_COLUMNS * P, jacobian);
        return status | singular;
    }
    shape_by(r.x, r.columns, r.w);
    for (i = 0; i < model_POINTS; i++) {
        for (c = 0; c < model_COLUMNS; c++) {
            for (k = 0; k < P; k++) {
                *jacobian++ = r.columns[(c * model_POINTS + i) * P + k];
            }
        }
    }
    return status;
}
#endif
