/* Parameters within their ranges. */
static int place(const double *parameters, double *x)
{
    int i, status = 0;
    for (i = 0; i < model_PARAMETERS; i++) {
        const double low = model_lower[i], high = model_upper[i], rounding = (high - low) * 1e-9;
        double value = parameters[i];
        if (!(value >= low - rounding && value <= high + rounding)) {
            status = model_OUT_OF_RANGE;
        }
        value = value >= low ? value : low; /* also what is not a number */
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

/* Gauss' elimination of a [N][N]. A pivot makes way where one below it is a hundred times as
 * large. Returns negative pivots and exchanges, -1: the matrix is singular. */
static int eliminate(double *a, int *rows)
{
    int i, j, k, negative = 0;
    for (k = 0; k < N; k++) {
        int best = k;
        double by;
        for (i = k + 1; i < N; i++) {
            best = fabs(a[i * N + k]) > fabs(a[best * N + k]) ? i : best;
        }
        rows[k] = k;
        if (fabs(a[k * N + k]) < 0.01 * fabs(a[best * N + k])) {
            for (j = k; j < N; j++) {
                const double held = a[k * N + j];
                a[k * N + j] = a[best * N + j];
                a[best * N + j] = held;
            }
            rows[k] = best;
            negative++;
        }
        by = 1 / a[k * N + k];
        if (!(fabs(by) < HUGE_VAL)) {
            return -1;
        }
        negative += by < 0;
        for (i = k + 1; i < N; i++) {
            const double factor = a[i * N + k] * by;
            a[i * N + k] = factor;
            for (j = k + 1; j < N; j++) {
                a[i * N + j] -= factor * a[k * N + j];
            }
        }
    }
    return negative;
}

/* x [N], its numbers `apart` from one another, becomes the solution. */
static void solve(const double *a, const int *rows, int apart, double *x)
{
    int i, k;
    for (k = 0; k < N; k++) {
        const double at = x[rows[k] * apart];
        x[rows[k] * apart] = x[k * apart];
        x[k * apart] = at;
        for (i = k + 1; i < N; i++) {
            x[i * apart] -= a[i * N + k] * at;
        }
    }
    for (k = N - 1; k >= 0; k--) {
        const double at = x[k * apart] / a[k * N + k];
        x[k * apart] = at;
        for (i = 0; i < k; i++) {
            x[i * apart] -= a[i * N + k] * at;
        }
    }
}

/* Memory: inputs, residual and matrix (as newton leaves them), curvature, changes of places,
 * changes of the curvature by parameters, workspace. */
typedef struct room {
    double *x, *residual, *matrix, *curvature, *moved, *by, *w;
} room;

static room divide(double *memory)
{
    room r;
    r.x = memory;
    r.residual = r.x + INPUTS;
    r.matrix = r.residual + N;
    r.curvature = r.matrix + N * N;
    r.moved = r.curvature + N;
    r.by = r.moved + N + 3;
    r.w = r.by + N * P;
    return r;
}

/* Residual, and the matrix eliminated. */
static int linearise(room r, const double *curvature, int *rows)
{
    copy(N, curvature, r.x + P);
    set_unit(N, r.x + P + N);
    newton(r.x, r.residual, r.w);
    return eliminate(r.matrix, rows);
}

/* By how much a step moves the rod, m. */
static double distance(room r, const double *curvature, const double *step)
{
    double most = 0;
    int i;
    copy(N, curvature, r.x + P);
    copy(N, step, r.x + P + N);
    moved(r.x, r.moved, r.w);
    for (i = 0; i < N / 3 + 1; i++) {
        const double *m = r.moved + i;
        const double x = m[0], y = m[N / 3 + 1], z = m[2 * (N / 3 + 1)];
        const double square = x * x + y * y + z * z;
        most = square <= most ? most : square; /* also what is not a number */
    }
    return LENGTH * sqrt(most);
}

static double largest(const double *x)
{
    double most = 0;
    int i;
    for (i = 0; i < N; i++) {
        most = fabs(x[i]) <= most ? most : fabs(x[i]);
    }
    return most;
}

/* Parameters are in r.x. */
static void polish(room r, int steps, double *curvature, model_answer *answer)
{
    int rows[N], i, k;
    double length = 0, before = 0;
    if (answer) {
        answer->stable = 1;
        answer->ratio = -1;
    }
    for (k = 0; k < steps || (k == 0 && answer); k++) {
        const int negative = linearise(r, curvature, rows);
        solve(r.matrix, rows, 1, r.residual);
        length = largest(r.residual);
        if (answer) {
            answer->stable = answer->stable && negative == 0;
            if (k == 0) {
                answer->predicted = distance(r, curvature, r.residual);
            }
        }
        for (i = 0; i < N && k < steps; i++) {
            curvature[i] -= r.residual[i];
        }
    }
    if (!answer) {
        return;
    }
    answer->left = answer->predicted;
    if (steps > 0) { /* one more, with the last matrix */
        before = length;
        copy(N, curvature, r.x + P);
        residual(r.x, r.residual, r.w);
        solve(r.matrix, rows, 1, r.residual);
        answer->left = distance(r, curvature, r.residual);
        answer->ratio = before > 0 ? largest(r.residual) / before : 0;
    }
    answer->trusted = answer->stable && answer->predicted <= 0.05 * LENGTH &&
                      (answer->ratio <= 0.25 || answer->left <= 1e-9 * LENGTH);
}

int model_network(const double *parameters, double *curvature, double *memory)
{
    const room r = divide(memory);
    const int status = place(parameters, r.x);
    network(r.x, curvature, r.w);
    return status;
}

int model_polish(const double *parameters, int steps, double *curvature, model_answer *answer,
                 double *memory)
{
    const room r = divide(memory);
    const int status = place(parameters, r.x);
    polish(r, steps, curvature, answer);
    return status;
}

int model_shape_of(const double *parameters, const double *curvature, double *to, double *memory)
{
    const room r = divide(memory);
    const int status = place(parameters, r.x);
    copy(N, curvature, r.x + P);
    shape(r.x, to, r.w);
    return status;
}

static int find(room r, const double *parameters, int steps, model_answer *answer)
{
    const int status = place(parameters, r.x);
    network(r.x, r.curvature, r.w);
    polish(r, steps, r.curvature, answer);
    copy(N, r.curvature, r.x + P);
    return status;
}

int model_shape(const double *parameters, int steps, double *to, model_answer *answer,
                double *memory)
{
    const room r = divide(memory);
    const int status = find(r, parameters, steps, answer);
    shape(r.x, to, r.w);
    return status;
}

int model_tip(const double *parameters, int steps, double *to, model_answer *answer, double *memory)
{
    const room r = divide(memory);
    const int status = find(r, parameters, steps, answer);
    tip(r.x, to, r.w);
    return status;
}

int model_tip_jacobian(const double *parameters, int steps, double *to, double *jacobian,
                       model_answer *answer, double *memory)
{
    const room r = divide(memory);
    const int status = find(r, parameters, steps, answer);
    int rows[N], i;
    tip(r.x, to, r.w);
    if (steps > 0) { /* residual (p, u) = 0 */
        linearise(r, r.curvature, rows);
        set_unit(P, r.x + P + N);
        residual_by(r.x, r.by, r.w);
        for (i = 0; i < P; i++) {
            solve(r.matrix, rows, P, r.by + i);
        }
        for (i = 0; i < N * P; i++) {
            r.by[i] = -r.by[i];
        }
    } else {
        set_unit(P, r.x + P);
        network_by(r.x, r.by, r.w);
        copy(N, r.curvature, r.x + P);
        set_unit(P, r.x + P + N);
    }
    copy(N * P, r.by, r.x + P + N + P * P);
    tip_by(r.x, jacobian, r.w);
    return status;
}
