static model_number memory[model_MEMORY], batch[POINTS][model_OUTPUTS];
static model_number batch_jacobian[POINTS][model_OUTPUTS * model_INPUTS];
static double worst[COLUMNS];
static int failures;

static void compare(const char *function, int point, int column, double value)
{
    const double off = fabs(value - expected[point][column]);
    const double size = scale[column] > 0 ? scale[column] : 1;
    if (!(off <= tolerance[column]) && failures++ == 0) {
        printf("%s: column %d at point %d is %.17g, not %.17g\n", function, column, point, value,
               expected[point][column]);
    }
    worst[column] = off / size > worst[column] ? off / size : worst[column];
}

static void check_status(const char *function, int point, int status, int wanted)
{
    if (status != wanted && failures++ == 0) {
        printf("%s: returns %d at point %d, not %d\n", function, status, point, wanted);
    }
}

static void check_point(int point)
{
    model_number out[model_OUTPUTS], jacobian[model_OUTPUTS * model_INPUTS];
    int i;
    check_status("eval", point, model_eval(at[point], out, memory), beyond[point]);
    for (i = 0; i < model_OUTPUTS; i++) {
        compare("eval", point, i, out[i]);
    }
    check_status("jacobian", point, model_jacobian(at[point], out, jacobian, memory),
                 beyond[point]);
    for (i = 0; i < model_OUTPUTS; i++) {
        compare("jacobian", point, i, out[i]);
    }
    for (i = model_OUTPUTS; i < COLUMNS; i++) {
        compare("jacobian", point, i, jacobian[i - model_OUTPUTS]);
    }
}

static void check_batches(void)
{
    int point, i;
    check_status("eval_batch", 0, model_eval_batch(POINTS, at[0], batch[0], memory), 1);
    for (point = 0; point < POINTS; point++) {
        for (i = 0; i < model_OUTPUTS; i++) {
            compare("eval_batch", point, i, batch[point][i]);
        }
    }
    check_status("jacobian_batch", 0,
                 model_jacobian_batch(POINTS, at[0], batch[0], batch_jacobian[0], memory), 1);
    for (point = 0; point < POINTS; point++) {
        for (i = 0; i < COLUMNS; i++) {
            compare("jacobian_batch", point, i,
                    i < model_OUTPUTS ? batch[point][i] : batch_jacobian[point][i - model_OUTPUTS]);
        }
    }
}

/* What is not a number is out of range, and the result is one. */
static void check_not_a_number(void)
{
    int input, i;
    for (input = 0; input < model_INPUTS; input++) {
        model_number in[model_INPUTS], out[model_OUTPUTS];
        for (i = 0; i < model_INPUTS; i++) {
            in[i] = at[0][i];
        }
        in[input] = (model_number)NAN;
        check_status("not a number", 0, model_eval(in, out, memory), model_OUT_OF_RANGE);
        for (i = 0; i < model_OUTPUTS; i++) {
            if (!(fabs((double)out[i]) <= HUGE_VAL) && failures++ == 0) {
                printf("output %d of an input that is not a number is none either\n", i);
            }
        }
    }
}

int main(void)
{
    int point, i, k;
    for (point = 0; point < POINTS; point++) {
        check_point(point);
    }
    check_batches();
    check_not_a_number();
    if (failures > 0) {
        return 1;
    }
    printf("difference from cpinn, by the scale: output, its derivatives\n");
    for (i = 0; i < model_OUTPUTS; i++) {
        double most = 0;
        for (k = 0; k < model_INPUTS; k++) {
            const double off = worst[model_OUTPUTS + i * model_INPUTS + k];
            most = off > most ? off : most;
        }
        printf("%-10s %.1e %.1e\n", model_output_names[i], worst[i], most);
    }
    return 0;
}
