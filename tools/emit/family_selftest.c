/* Largest differences: of the curvature by the network and after STEPS, by its largest; of each
 * column and its derivatives over the ranges, by the scale. Not a number where one is none. */
static double off[1 + model_COLUMNS][2];
static int failures;

/* Derivatives are those of a matrix that leaves out what steps of finite length along the rod add.
 */
static void compare(const char *what, int member, int row, int which, double is, double wanted,
                    double unit)
{
    const double by = fabs(is - wanted) / unit;
    if (!(by <= (row > 0 && which == 1 ? 0.05 : TOLERANCE)) && failures++ == 0) {
        printf("%s: %.9g, not %.9g, at member %d\n", what, is, wanted, member);
    }
    off[row][which] =
        by <= off[row][which] || off[row][which] != off[row][which] ? off[row][which] : by;
}

static void compare_place(int member, int place, const model_number *is, const model_number *by)
{
    int i, k;
    for (i = 0; i < model_COLUMNS; i++) {
        const int at = place * model_COLUMNS + i;
        compare(model_column_names[i], member, 1 + i, 0, is[i], columns[member][at], scale[0][i]);
        for (k = 0; k < P; k++) {
            const double range = model_upper[k] - model_lower[k];
            compare(model_column_names[i], member, 1 + i, 1, by[i * P + k] * range,
                    derivatives[member][at * P + k] * range, scale[0][i]);
        }
    }
}

static void check_member(int member)
{
    static model_number memory[model_MEMORY];
    model_number at[N], tip[model_COLUMNS], jacobian[model_COLUMNS * P];
#if SHAPE_BY
    static model_number shape[model_POINTS][model_COLUMNS];
    static model_number changes[model_POINTS][model_COLUMNS * P];
#endif
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
    model_tip_jacobian(parameters[member], STEPS, tip, jacobian, NULL, memory);
    compare_place(member, COMPARED - 1, tip, jacobian);
#if SHAPE_BY
    model_shape_jacobian(parameters[member], STEPS, shape[0], changes[0], NULL, memory);
    for (i = 0; i < COMPARED; i++) {
        compare_place(member, i, shape[places[i]], changes[places[i]]);
    }
#endif
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
