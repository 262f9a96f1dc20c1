
static _Alignas(64) unsigned char memory[model_MEMORY];

/* The same as cpinn's loop but for rounding, which the loop makes no larger than that. */
static int differs(double value, double wanted, double scale)
{
    return !(fabs(value - wanted) <= TOLERANCE * scale);
}

int main(void)
{
    double inputs[model_CONTROLLED], worst[2] = {0, 0};
    model_loop *x = model_init(memory, sizeof memory);
    int i, k, s;
    if (!x || model_size() > sizeof memory || model_init(memory, model_size() - 1)) {
        printf("init: the memory is not what it is said to be\n");
        return 1;
    }
    for (i = 0; i < SAMPLES; i++) {
        const double *values = measured[i];
        int flags;
        for (s = 0; s < model_SENSORS; values += sensor_values[s++]) {
            if (!isnan(values[0])) {
                model_measure(x, s, -1, values);
            }
        }
        flags = expected_flags[i] & LATE ? model_late(x, i % 2, inputs)
                                         : model_control(x, paths[i], inputs);
        model_prepare(x);
        for (k = 0; k < model_CONTROLLED + PARAMETERS; k++) {
            const int is_input = k < model_CONTROLLED, p = is_input ? 0 : k - model_CONTROLLED;
            const double value = is_input ? inputs[k] : model_inputs(x)[parameter[p]];
            const int input = is_input ? model_controlled[k] : parameter[p];
            const double scale = model_upper[input] - model_lower[input];
            const double off = fabs(value - expected[i][k]) / scale;
            if (differs(value, expected[i][k], scale)) {
                printf("sample %d: %s is %.17g, not %.17g\n", i, model_input_names[input], value,
                       expected[i][k]);
                return 1;
            }
            worst[!is_input] = off > worst[!is_input] ? off : worst[!is_input];
        }
        if (flags != expected_flags[i]) {
            printf("sample %d: flags are %d, not %d\n", i, flags, expected_flags[i]);
            return 1;
        }
    }
    printf("difference from cpinn in %d samples, by the ranges: inputs %.1e, parameters %.1e\n",
           SAMPLES, worst[0], worst[1]);
    return 0;
}
