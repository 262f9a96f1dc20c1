/* Largest differences: of the curvature by the network and after STEPS, by its largest; of each
 * column and its derivatives over the ranges, by the scale. Not a number where one is none. */
static double off[1 + model_COLUMNS][2];
static int failures;

static void compare(const char *what, int member, int row, int which, double is, double wanted,
                    double unit)
{
    const double by = fabs(is - wanted) / unit;
    if (!(by <= (row > 0 && which == 1 ? DIFFERENCES : TOLERANCE)) && failures++ == 0) {
        printf("%s: %.9g, not %.9g, at member %d\n", what, is, wanted, member);
    }
    off[row][which] =
        by <= off[row][which] || off[row][which] != off[row][which] ? off[row][which] : by;
}

static void put_place(const model_number *is, const model_number *changes, double *to, double *by)
{
    int i;
    for (i = 0; i < model_COLUMNS; i++) {
        to[i] = is[i];
    }
    for (i = 0; by && i < model_COLUMNS * P; i++) {
        by[i] = changes[i];
    }
}

/* Columns of the shape at places that are compared, and of the tip; unless `by` is NULL their
 * derivatives; whether they are trusted. */
static int find_columns(const model_number *p, int steps, double *to, double *by)
{
    static model_number memory[model_MEMORY];
    const int last = ROWS - model_COLUMNS;
    model_number tip[model_COLUMNS], changes[model_COLUMNS * P];
    model_answer answer;
#if SHAPE_BY
    static model_number shape[model_POINTS][model_COLUMNS];
    static model_number shape_changes[model_POINTS][model_COLUMNS * P];
    int i;
    if (by) {
        model_shape_jacobian(p, steps, shape[0], shape_changes[0], NULL, memory);
    } else {
        model_shape(p, steps, shape[0], NULL, memory);
    }
    for (i = 0; i < COMPARED; i++) {
        put_place(shape[places[i]], shape_changes[places[i]], to + i * model_COLUMNS,
                  by ? by + i * model_COLUMNS * P : NULL);
    }
#endif
    if (by) {
        model_tip_jacobian(p, steps, tip, changes, &answer, memory);
    } else {
        model_tip(p, steps, tip, &answer, memory);
    }
    put_place(tip, changes, to + last, by ? by + last * P : NULL);
    return answer.trusted;
}

/* Over the ranges, beside differences, where steps have settled: by five values of a parameter,
 * STEP of its range apart, or of itself where that is less and never 0. The nearest of a difference
 * of order 4 and of those of order 2 to both sides counts, as a tendon that gets slack leaves a
 * kink. */
static void check_derivatives(int member)
{
    static const double weights[3][5] = {
        {1.0 / 12, -8.0 / 12, 0, 8.0 / 12, -1.0 / 12}, {0.5, -2, 1.5, 0, 0}, {0, 0, -1.5, 2, -0.5}};
    static double by[ROWS * P];
    double moved[ROWS], difference[3][ROWS], wide[P];
    model_number at[P], there[P];
    int i, k, m, side, trusted;
    for (k = 0; k < P; k++) {
        wide[k] = model_upper[k] - model_lower[k];
        wide[k] = model_lower[k] > 0 ? fmin(wide[k], parameters[member][k]) : wide[k];
        at[k] = (model_number)fmin(fmax(parameters[member][k], model_lower[k] + 2 * STEP * wide[k]),
                                   model_upper[k] - 2 * STEP * wide[k]);
    }
    trusted = find_columns(at, SETTLED, moved, by);
    for (k = 0; k < P && trusted; k++) {
        const double range = model_upper[k] - model_lower[k];
        memset(difference, 0, sizeof difference);
        for (side = 0; side < 5; side++) {
            memcpy(there, at, sizeof there);
            there[k] = (model_number)(at[k] + (side - 2) * STEP * wide[k]);
            trusted = find_columns(there, SETTLED, moved, NULL) && trusted;
            for (i = 0; i < 3 * ROWS; i++) {
                difference[i / ROWS][i % ROWS] +=
                    weights[i / ROWS][side] * moved[i % ROWS] / STEP * range / wide[k];
            }
        }
        for (i = 0; i < ROWS && trusted; i++) {
            const double is = by[i * P + k] * range;
            double near = difference[0][i];
            for (m = 1; m < 3; m++) {
                near = fabs(difference[m][i] - is) < fabs(near - is) ? difference[m][i] : near;
            }
            compare(model_column_names[i % model_COLUMNS], member, 1 + i % model_COLUMNS, 1, is,
                    near, scale[0][i % model_COLUMNS]);
        }
    }
}

static void check_member(int member)
{
    static model_number memory[model_MEMORY];
    model_number at[N];
    double is[ROWS];
    model_answer answer;
    int i;
    model_network(parameters[member], at, memory);
    for (i = 0; i < N; i++) {
        compare("the network's curvature", member, 0, 0, at[i], curvature[member][i], LARGEST);
    }
    model_polish(parameters[member], STEPS, at, &answer, memory);
    if (!answer.trusted) { /* small differences may be large ones after a step */
        return;
    }
    for (i = 0; i < N; i++) {
        compare("the curvature after steps", member, 0, 1, at[i], polished[member][i], LARGEST);
    }
    find_columns(parameters[member], STEPS, is, NULL);
    for (i = 0; i < ROWS; i++) {
        compare(model_column_names[i % model_COLUMNS], member, 1 + i % model_COLUMNS, 0, is[i],
                columns[member][i < COMPARED * model_COLUMNS ? i : i - model_COLUMNS],
                scale[0][i % model_COLUMNS]);
    }
    check_derivatives(member);
}

static void check_range(void)
{
    static model_number memory[model_MEMORY];
    model_number tip[model_COLUMNS], again[model_COLUMNS], beyond[P];
    int k, status = model_tip(model_upper, 1, again, NULL, memory);
    for (k = 0; k < P; k++) {
        beyond[k] = 2 * model_upper[k] - model_lower[k];
    }
    failures += status != 0;
    failures += model_tip(beyond, 1, tip, NULL, memory) != model_OUT_OF_RANGE;
    for (k = 0; k < model_COLUMNS; k++) {
        failures += !(fabs((double)tip[k] - again[k]) <= 0);
    }
    if (failures > 0) {
        printf("beyond its range: not the end of it\n");
    }
}

int main(void)
{
    int i;
    check_range();
    for (i = 0; i < MEMBERS; i++) {
        check_member(i);
    }
    if (failures > 0) {
        return 1;
    }
    printf("difference from cpinn, of curvature by the network and after steps by its largest; of "
           "the tip\nand its derivatives after steps, over the ranges, by the scale\n");
    printf("curvature  %.1e %.1e\n", off[0][0], off[0][1]);
    for (i = 0; i < model_COLUMNS; i++) {
        printf("%-10s %.1e %.1e\n", model_column_names[i], off[1 + i][0], off[1 + i][1]);
    }
    return 0;
}
