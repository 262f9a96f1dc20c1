
/* ---- along the loads ----------------------------------------------------------------------- */

/* Newton's steps at a load, from u, until what the next ones leave is below the goal; `rows` and
 * the matrix are of the last. Returns how many; 0: they do not settle at once, or a pivot is
 * negative. steps: of all loads. */
static int settle(room r, double load, double goal, int *rows, int *steps)
{
    double length = 0, ratio = 1;
    int tries, i;
    r.x[P] = load;
    for (tries = 1; tries < STEPS_MAX; tries++) {
        const double before = length;
        find_state(r);
        if (linearise(r, rows) != 0) {
            return 0;
        }
        solve(r, rows, 1, r.residual, r.u + FIRM);
        ++*steps;
        length = largest(r.residual);
        ratio = tries > 1 ? length / before : 1;
        if (!(length < LARGE) || (tries > 1 && ratio > (tries == 2 ? FIRST_RATIO : RATIO))) {
            return 0;
        }
        for (i = 0; i < N; i++) {
            r.u[i] = cleared(r.u[i] - r.residual[i]);
        }
        if (length <= goal || length * ratio * ratio <= goal) {
            return tries;
        }
    }
    return 0;
}

/* From the unstressed rod to the whole load; the last two points are continued on the line through
 * them. Returns whether it gets there. */
static int follow(room r, int *rows, int *steps)
{
    double start[N], earlier[N] = {0}, load = 1, done = 0, before = -1;
    int i;
    r.x[P] = 0;
    for (i = 0; i < TORSIONS; i++) {
        r.u[i] = 0;
    }
    network(r.x, r.bent, r.w);
    copy(N, r.u, start);
    for (;;) {
        const int taken = settle(r, load, load < 1 ? ON_THE_WAY : LEAVES * TOLERANCE, rows, steps);
        double step = (load - done) * (taken > 3 ? 1 : taken ? LONGER : SHORTER), share;
        if (taken && load == 1) {
            return 1;
        }
        if (taken) {
            copy(N, start, earlier);
            copy(N, r.u, start);
            before = done;
            done = load;
        } else if (step < SHORTEST) {
            return 0;
        }
        load = done + step > 1 - 0.1 * step ? 1 : done + step;
        share = before < 0 ? 0 : (load - done) / (done - before);
        for (i = 0; i < N; i++) {
            r.u[i] = start[i] + share * (start[i] - earlier[i]);
        }
    }
}

/* ---- for the library ----------------------------------------------------------------------- */

/* The last step has the matrix of the one before; said: how far it moves the rod, m, what the mesh
 * hardly resolves of the curvature, rad, and how many there were. */
static int solve_member(const double *parameters, double *to, double *jacobian, double *said,
                        double *memory)
{
    const room r = divide(memory);
    int rows[N], i, steps = 1, status = place(parameters, r.x);
    if (!follow(r, rows, &steps)) {
        return status | model_SINGULAR;
    }
    find_state(r);
    residual(r.x, r.residual, r.w);
    solve(r, rows, 1, r.residual, r.u + FIRM);
    said[0] = distance(r, r.residual);
    for (i = 0; i < N; i++) {
        r.u[i] -= r.residual[i];
    }
    find_state(r);
    said[1] = mesh_leaves(r);
    said[2] = steps;
    write_shape(r, to);
    return status | (jacobian ? write_shape_by(r, 1, jacobian) : 0);
}

const struct {
    size_t memory;
    int (*solve)(const double *, double *, double *, double *, double *);
} ad_code_table = {model_MEMORY, solve_member};
