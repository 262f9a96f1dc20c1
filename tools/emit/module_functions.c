
/* ---- for a page ---------------------------------------------------------------------------- */

#define EXPORTED(name) __attribute__((export_name(name)))

static double parameters[model_PARAMETERS], shape[model_POINTS * model_COLUMNS];
static double memory[model_MEMORY], said[3], values[DRAWN + 1], workspace[WORKSPACE + 1];

EXPORTED("parameters") double *parameters_of(void)
{
    return parameters;
}

EXPORTED("shape") double *shape_of(void)
{
    return shape;
}

EXPORTED("said") double *said_of(void)
{
    return said;
}

EXPORTED("drawn") double *drawn_of(void)
{
    return values;
}

/* Of the parameters: the shape, what is known of it, and what is drawn beside it. */
EXPORTED("answer") void find_answer(int steps)
{
    model_answer answer;
    model_shape(parameters, steps, shape, &answer, memory);
    said[0] = answer.predicted;
    said[1] = answer.left;
    said[2] = answer.why;
#if DRAWN > 0
    drawn(parameters, values, workspace);
#endif
}
