
static _Alignas(64) unsigned char memory[model_MEMORY];

/* The same as cpinn's loop but for rounding, which the loop makes no larger than that. */
static int differs(double value, double wanted, double allowed)
{
    return !(fabs(value - wanted) <= allowed);
}

/* How far the place is from where it was to be, over how far that is from the origin, a while after
 * an answer that is held. */
static double off_place(model_loop *x, const double *answer, const double *wanted)
{
    double state[model_STATES], next[model_STATES], inputs[model_INPUTS], place[3], size = 0,
                                                                                    off = 0;
    int i, k;
    for (k = 0; k < model_STATES; k++) {
        state[k] = model_state(x)[k];
    }
    for (k = 0; k < model_INPUTS; k++) {
        inputs[k] = model_inputs(x)[k];
    }
    for (k = 0; k < model_CONTROLLED; k++) {
        inputs[model_controlled[k]] = answer[k];
    }
    for (i = 0; i < HELD; i++) {
        if (model_step(x, state, inputs, next, 0, 0)) {
            return HUGE_VAL;
        }
        for (k = 0; k < model_STATES; k++) {
            state[k] = next[k];
        }
    }
    if (model_place(x, state, place, 0)) {
        return HUGE_VAL;
    }
    for (k = 0; k < 3; k++) {
        off += (place[k] - wanted[k]) * (place[k] - wanted[k]);
        size += wanted[k] * wanted[k];
    }
    return sqrt(off / size);
}

int main(void)
{
    double inputs[model_CONTROLLED], worst[3] = {0, 0, 0}, off;
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
            const double allowed = is_input ? OF_INPUTS : TOLERANCE;
            off = fabs(value - expected[i][k]) / scale;
            if (differs(value, expected[i][k], allowed * scale)) {
                printf("sample %d: %s is %.17g, not %.17g\n", i, model_input_names[input], value,
                       expected[i][k]);
                return 1;
            }
            worst[!is_input] = off > worst[!is_input] ? off : worst[!is_input];
        }
        off = off_place(x, inputs, reached[i]);
        if (!(off <= TOLERANCE)) {
            printf("sample %d: the place is off by %.3g of what it is to be\n", i, off);
            return 1;
        }
        worst[2] = off > worst[2] ? off : worst[2];
        if (flags != expected_flags[i]) {
            printf("sample %d: flags are %d, not %d\n", i, flags, expected_flags[i]);
            return 1;
        }
    }
    printf("difference from cpinn in %d samples, by the ranges: inputs %.1e, parameters %.1e; "
           "place %.1e\n",
           SAMPLES, worst[0], worst[1], worst[2]);
    return 0;
}
