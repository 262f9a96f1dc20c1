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
    for (i = CURVED; i < N - HELD; i++) {
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
                r.matrix[(first + k) * BENT + i] = r.moment[(CURVED + i) * P + k];
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
    copy(BENT, r.residual + CURVED, r.matrix + HELD * BENT);
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

/* Curvature far below its rounding is 0: products of such numbers would be subnormal, and take
 * twenty times as long. */
static double cleared(double x)
{
    return fabs(x) < TINY ? 0 : x;
}

/* The torsion of tubes at s = 0 is that of their polynomial there; numbers are `apart`. */
#if TUBES > 0
static void set_bases(double *u, int apart)
{
    int i, k;
    for (k = 0; k < TUBES; k++) {
        u[(FORCES + k) * apart] = 0;
        for (i = 0; i < STAGES; i++) {
            u[(FORCES + k) * apart] += at_start[i] * u[(TORSIONS + k * NODES + i) * apart];
        }
    }
}
#else
static void set_bases(double *u, int apart)
{
    (void)u;
    (void)apart;
}
#endif

/* Forces that are sought, from the curvature: the shape has those that depend on the place but for
 * the stretch by them, and each pass leaves that share of what was missing. */
static void guess_forces(room r)
{
    enum { PASSES = 3 };
    int i, k;
    for (i = 0; i < N; i++) {
        r.u[i] = i < FORCES || i >= N - HELD ? 0 : cleared(r.u[i]);
    }
    set_bases(r.u, 1);
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
            const double *at = r.u + CURVED + c * NODES + e * STAGES;
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
        answer->why = model_NOT_FINITE;
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
            const double next = r.u[i] - r.residual[i];
            r.u[i] = i < FORCES || i >= N - HELD ? next : cleared(next);
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
    answer->why = !stable                                  ? model_UNSTABLE
                  : !(20 * answer->predicted <= LENGTH)    ? model_TOO_FAR
                  : !(settles || left <= SETTLED * LENGTH) ? model_NOT_SETTLING
                                                           : 0;
    answer->trusted = answer->why == 0;
    return answer->left < HUGE_VAL ? 0 : unknown(answer);
}

int model_network(const double *parameters, double *curvature, double *memory)
{
    const room r = divide(memory);
    const int status = place(parameters, r.x);
    network(r.x, r.bent, r.w);
    give_curvature(r.bent, curvature);
    return status;
}

int model_polish(const double *parameters, int steps, double *curvature, model_answer *answer,
                 double *memory)
{
    const room r = divide(memory);
    int status = place(parameters, r.x);
    take_curvature(curvature, r.bent);
    status |= polish(r, steps, answer);
    give_curvature(r.bent, curvature);
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
    take_curvature(curvature, r.bent);
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
            for (k = TORSIONS; k < N - HELD; k++) {
                r.u[k] += side * step * change[k * P + i];
            }
            guess_forces(r);
            for (k = 0; k < N && side < 0; k++) {
                before[k] = r.u[k];
            }
        }
        for (k = 0; k < N; k++) {
            if (k < TORSIONS || k >= N - HELD) {
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
    for (i = 0; i < P; i++) {
        set_bases(r.du + i, P);
    }
    if (FORCES > 0) {
        state_by(r.x, r.dz, r.w);
        residual_by(r.x, r.moment, r.w);
    }
    for (i = 0; i < FORCES * P; i++) {
        r.du[i] = -r.moment[i];
    }
}
#endif

/* How the unknowns of an equilibrium change with the parameters. The matrix leaves out what steps
 * of finite length along the rod add, changes of the residual do not: what is missing becomes less
 * by the share that is left out, each time. */
static void follow_equilibrium(room r, int *rows)
{
    enum { MOST = 8 };
    double step = HUGE_VAL, size = 0;
    int i, k;
    for (i = 0; i < N * P; i++) {
        r.du[i] = 0;
    }
    for (k = 0; k < MOST && step > ROUNDING * size; k++) {
        const double before = step;
        state_by(r.x, r.dz, r.w);
        residual_by(r.x, r.moment, r.w);
        for (i = 0; i < P; i++) {
            solve(r, rows, P, r.moment + i, NULL);
        }
        step = size = 0;
        for (i = 0; i < N * P; i++) {
            step = larger(step, fabs(r.moment[i]));
        }
        for (i = 0; i < N * P && step < before; i++) { /* else it is rounding */
            r.du[i] -= r.moment[i];
            size = larger(size, fabs(r.du[i]));
        }
    }
}

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
        follow_equilibrium(r, rows);
    } else {
        for (i = 0; i < TORSIONS * P; i++) {
            r.du[i] = 0;
        }
        network_by(r.x, r.du + TORSIONS * P, r.w);
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
static int write_shape_by(room r, int steps, double *jacobian)
{
    int i, c, k;
    if (find_directions(r, steps)) {
        set_unknown(model_POINTS * model_COLUMNS * P, jacobian);
        return model_SINGULAR;
    }
    shape_by(r.x, r.columns, r.w);
    for (i = 0; i < model_POINTS; i++) {
        for (c = 0; c < model_COLUMNS; c++) {
            for (k = 0; k < P; k++) {
                *jacobian++ = r.columns[(c * model_POINTS + i) * P + k];
            }
        }
    }
    return 0;
}

int model_shape_jacobian(const double *parameters, int steps, double *to, double *jacobian,
                         model_answer *answer, double *memory)
{
    const room r = divide(memory);
    const int status = find(r, parameters, steps, answer);
    write_shape(r, to);
    return status | write_shape_by(r, steps, jacobian);
}
#endif
