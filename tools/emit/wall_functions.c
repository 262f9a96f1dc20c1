/* ---- the wall ------------------------------------------------------------------------------ */

/* Of a place, negative where it is not free. */
static double place_clear(const double *p)
{
    double nearest[3];
    const double distance = triangle_tree_distance(&wall, p, HUGE_VAL, nearest);
    return triangle_tree_is_free(&wall, p) ? distance : -distance;
}

/* Of the rod over the line between its ends, both of which may be off: as two threads and a pencil
 * say of an ellipse. */
double model_clear(const model_number *shape, double off, double enough)
{
    double least = enough + WALL_OFF + WALL_RADIUS + off + ROUNDED;
    int is_free = 0, i, k; /* where the last line ends */
    off += ROUNDED;
    for (k = 0; k + 1 < model_POINTS; k++) {
        const model_number *row = shape + k * model_COLUMNS, *next = row + model_COLUMNS;
        const double a[3] = {row[model_X], row[model_Y], row[model_Z]};
        const double b[3] = {next[model_X], next[model_Y], next[model_Z]};
        double length = (double)model_places[k + 1] - model_places[k], apart = 0, line, bend, clear;
        if (model_places[k + 1] <= WALL_FROM) {
            continue;
        }
#if STRETCHES
        {
            double speed[2] = {0, 0};
            for (i = 0; i < 2; i++) {
                const model_number *v = i ? next : row;
                speed[i] =
                    sqrt((double)v[model_V1] * v[model_V1] + (double)v[model_V2] * v[model_V2] +
                         (double)v[model_V3] * v[model_V3]);
            }
            length *= (speed[0] > speed[1] ? speed[0] : speed[1]) + fabs(speed[1] - speed[0]);
        }
#endif
        for (i = 0; i < 3; i++) {
            apart += (b[i] - a[i]) * (b[i] - a[i]);
        }
        line = sqrt(apart);
        apart = line - 2 * off;
        if (!(apart <= length * (1 + 1e-9))) {
            return -HUGE_VAL; /* no numbers, or a rod that is shorter than the line */
        }
        apart = apart > 0 ? apart : 0;
        apart = apart < length ? apart : length;
        bend = sqrt((length - apart) * (length + apart)) / 2;
        clear = -1;
        if (is_free || triangle_tree_is_free(&wall, a)) {
            clear = triangle_tree_segment(&wall, a, b, least + bend > 0 ? least + bend : 0);
        }
        is_free = clear > WALL_OFF;
        if (!is_free) { /* distances differ no more than places do */
            clear = (place_clear(a) + place_clear(b) - line) / 2;
        }
        least = clear - bend < least ? clear - bend : least;
    }
    return least - WALL_OFF - WALL_RADIUS - off;
}
