/* ---- the wall ------------------------------------------------------------------------------ */

/* What all of the line from a to b has at least, by points half a cell apart. */
static double line_clear(const double *a, const double *b)
{
    double before = distance_field_at(&wall, a, NULL), least = HUGE_VAL, length = 0;
    int i, k, pieces;
    for (k = 0; k < 3; k++) {
        length += (b[k] - a[k]) * (b[k] - a[k]);
    }
    length = sqrt(length);
    pieces = (int)(2 * length / wall.cell) + 1;
    for (i = 1; i <= pieces; i++) {
        double p[3], now, bound;
        for (k = 0; k < 3; k++) {
            p[k] = a[k] + (b[k] - a[k]) * i / pieces;
        }
        now = distance_field_at(&wall, p, NULL);
        bound = (before + now - length / pieces) / 2;
        least = bound < least ? bound : least;
        before = now;
    }
    return least;
}

/* Of the rod over the line between its ends, both of which may be off: as two threads and a pencil
 * say of an ellipse. */
double model_clear(const model_number *shape, double off)
{
    double least = HUGE_VAL;
    int i, k;
    off += ROUNDED;
    for (k = 0; k + 1 < model_POINTS; k++) {
        const model_number *row = shape + k * model_COLUMNS, *next = row + model_COLUMNS;
        const double a[3] = {row[model_X], row[model_Y], row[model_Z]};
        const double b[3] = {next[model_X], next[model_Y], next[model_Z]};
        double length = (double)model_places[k + 1] - model_places[k], apart = 0, clear;
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
        apart = sqrt(apart) - 2 * off;
        if (!(apart <= length * (1 + 1e-9))) {
            return -HUGE_VAL; /* no numbers, or a rod that is shorter than the line */
        }
        apart = apart > 0 ? apart : 0;
        apart = apart < length ? apart : length;
        clear = line_clear(a, b) - sqrt((length - apart) * (length + apart)) / 2;
        least = clear < least ? clear : least;
    }
    return least - WALL_OFF - WALL_RADIUS - off;
}
