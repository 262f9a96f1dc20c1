/* Coordinates in units of their scales, within their ranges. */
static int place(const model_number *in, model_number *x)
{
    int i, status = 0;
    for (i = 0; i < model_INPUTS; i++) {
        const double low = model_lower[i], high = model_upper[i];
        const double rounding = (high - low) * (sizeof *x == sizeof(float) ? 1e-6 : 1e-9);
        double value = in[i];
        if (!(isgreaterequal(value, low - rounding) && islessequal(value, high + rounding))) {
            status = model_OUT_OF_RANGE;
        }
        /* also what is not a number, without an exception */
        value = isgreaterequal(value, low) ? value : low;
        value = value <= high ? value : high;
        x[i] = (model_number)(value / coordinate_scale[i]);
    }
    return status;
}

int model_eval(const model_number *in, model_number *out, model_number *memory)
{
    model_number x[model_INPUTS];
    const int status = place(in, x);
    values_at(x, out, memory);
    return status;
}

int model_jacobian(const model_number *in, model_number *out, model_number *jacobian,
                   model_number *memory)
{
    model_number x[model_INPUTS], *const y = memory + JACOBIAN_AT;
    const int status = place(in, x);
    int i;
    jacobian_at(x, y, memory);
    for (i = 0; i < model_OUTPUTS; i++) {
        out[i] = y[i];
    }
    for (i = 0; i < model_OUTPUTS * model_INPUTS; i++) {
        jacobian[i] = y[model_OUTPUTS + i];
    }
    return status;
}

int model_eval_batch(size_t n, const model_number *in, model_number *out, model_number *memory)
{
    int status = 0;
    for (; n > 0; n--) {
        status |= model_eval(in, out, memory);
        in += model_INPUTS;
        out += model_OUTPUTS;
    }
    return status;
}

int model_jacobian_batch(size_t n, const model_number *in, model_number *out,
                         model_number *jacobian, model_number *memory)
{
    int status = 0;
    for (; n > 0; n--) {
        status |= model_jacobian(in, out, jacobian, memory);
        in += model_INPUTS;
        out += model_OUTPUTS;
        jacobian += model_OUTPUTS * model_INPUTS;
    }
    return status;
}
