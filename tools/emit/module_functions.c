
/* ---- for a page ---------------------------------------------------------------------------- */

#define EXPORTED(name) __attribute__((export_name(name)))

static double parameters[model_PARAMETERS], shape[model_POINTS * model_COLUMNS];
static double memory[model_MEMORY], said[3], values[DRAWN + 1], workspace[WORKSPACE + 1];
static double place[3], axes[3][3], box[2 * model_PARAMETERS];

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

EXPORTED("place") double *place_of(void)
{
    return place;
}

EXPORTED("box") double *box_of(void)
{
    return box;
}

EXPORTED("axes") double *axes_of(void)
{
    return axes[0];
}

/* From the parameters on, within the box, towards those whose tip is at the place or nearest, by
 * what is seen of it along so many axes; how far that is, m. */
EXPORTED("reach") double reach(int images, int steps, int most)
{
    optim_seek seek;
    double wanted[3];
    for (int k = 0; k < images; k++) {
        wanted[k] = axes[k][0] * place[0] + axes[k][1] * place[1] + axes[k][2] * place[2];
    }
    optim_seek_start(&seek, model_PARAMETERS, box, box + model_PARAMETERS, images, wanted,
                     parameters);
    for (int i = 0; i < most && !optim_seek_is_over(&seek, REACHED); i++) {
        double tip[model_COLUMNS], tip_by[model_COLUMNS][model_PARAMETERS];
        double image[3], by[3 * model_PARAMETERS];
        model_answer answer;
        model_tip_jacobian(seek.next, steps, tip, tip_by[0], &answer, memory);
        for (int k = 0; k < images; k++) {
            const double *a = axes[k];
            image[k] = a[0] * tip[0] + a[1] * tip[1] + a[2] * tip[2];
            for (int p = 0; p < model_PARAMETERS; p++) {
                by[k * model_PARAMETERS + p] =
                    a[0] * tip_by[0][p] + a[1] * tip_by[1][p] + a[2] * tip_by[2][p];
            }
        }
        optim_seek_tell(&seek, image, by, answer.trusted);
    }
    memcpy(parameters, seek.x, sizeof parameters);
    return seek.distance;
}
