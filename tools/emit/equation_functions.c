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
 * that depend on the place, the torsion of TUBES at s = 0, from TORSIONS on those at points
 * [TUBES][NODES], from CURVED on the curvature [3][NODES], then HELD numbers of force and moment
 * that hold the end, with TENSIONS as the last. */
typedef struct room {
    double *x, *u, *bent, *z, *dp, *du, *dz, *residual, *blocks, *edges, *matrix, *lower, *force,
        *rate, *moment, *columns, *w;
} room;

static room divide(double *memory)
{
    room r;
    r.x = memory;
    r.u = r.x + GIVEN;
    r.bent = r.u + TORSIONS;
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

/* Torsions and curvature, of a curvature [NODES][WIDTH] with torsions; and back. */
static void take_curvature(const double *x, double *bent)
{
    int i, k;
    for (i = 0; i < NODES; i++) {
        for (k = 0; k < model_WIDTH; k++) {
            bent[k * NODES + i] = x[i * model_WIDTH + (k + 3) % model_WIDTH];
        }
    }
}

static void give_curvature(const double *bent, double *x)
{
    int i, k;
    for (i = 0; i < NODES; i++) {
        for (k = 0; k < model_WIDTH; k++) {
            x[i * model_WIDTH + (k + 3) % model_WIDTH] = bent[k * NODES + i];
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
