
/* ---- for the library ----------------------------------------------------------------------- */

/* [POINTS][COLUMNS][P] of the columns, which change by columns [COLUMNS][POINTS][P]. */
static int write_changes(room r, int steps, double *to)
{
    int i, c, k;
    if (find_directions(r, steps)) {
        set_unknown(model_POINTS * model_COLUMNS * P, to);
        return model_SINGULAR;
    }
    shape_by(r.x, r.columns, r.w);
    for (i = 0; i < model_POINTS; i++) {
        for (c = 0; c < model_COLUMNS; c++) {
            for (k = 0; k < P; k++) {
                *to++ = r.columns[(c * model_POINTS + i) * P + k];
            }
        }
    }
    return 0;
}

static int find_answer(const double *parameters, int steps, double *to, double *jacobian,
                       double *said, double *memory)
{
    const room r = divide(memory);
    model_answer answer;
    int status = find(r, parameters, steps, said ? &answer : NULL);
    write_shape(r, to);
    if (jacobian) {
        status |= write_changes(r, steps, jacobian);
    }
    if (said) {
        said[0] = answer.predicted;
        said[1] = answer.left;
        said[2] = answer.ratio;
        said[3] = answer.stable;
        said[4] = answer.trusted;
    }
    return status;
}

const struct {
    size_t memory;
    int (*answer)(const double *, int, double *, double *, double *, double *);
} ad_code_table = {model_MEMORY, find_answer};
