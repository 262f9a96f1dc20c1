#include "tools/control/view.h"

#include <string.h>

/* States at once. */
enum { VIEW_STATES = 8 };

static size_t largest_look(const view *view)
{
    int most = 0;
    for (int i = 0; i < view->parts; i++) {
        most = view->part[i].look.values > most ? view->part[i].look.values : most;
    }
    return (size_t)most;
}

size_t view_room(const view *view)
{
    return VIEW_STATES * largest_look(view) * (1 + (size_t)view->part[0].look.states);
}

static int values_of(const view *view)
{
    int count = 0;
    for (int i = 0; i < view->parts; i++) {
        count += view->part[i].count;
    }
    return count;
}

/* Values of one part from `column` on, of at most VIEW_STATES states. */
static int see_part(const view *view, const struct view_part *part, int column, int count,
                    const double *states, const double *inputs, double *values, double *by_state)
{
    const one_look *of = &part->look;
    const size_t n = (size_t)of->states, all = (size_t)values_of(view), taken = (size_t)part->count;
    double *rows = view->room + VIEW_STATES * (size_t)of->values;
    const int bad = of->see(of->context, count, states, inputs, view->room, by_state ? rows : NULL);
    for (size_t i = 0; i < (size_t)count && !bad; i++) {
        const size_t to = i * all + (size_t)column;
        const size_t from = i * (size_t)of->values + (size_t)part->first;
        memcpy(values + to, view->room + from, taken * sizeof *values);
        if (by_state) {
            memcpy(by_state + to * n, rows + from * n, taken * n * sizeof *by_state);
        }
    }
    return bad;
}

static int see_parts(void *context, int count, const double *states, const double *inputs,
                     double *values, double *by_state)
{
    const view *view = context;
    const one_look *first = &view->part[0].look;
    const int all = values_of(view), n = first->states;
    for (int from = 0; from < count; from += VIEW_STATES) {
        const int now = count - from < VIEW_STATES ? count - from : VIEW_STATES;
        for (int i = 0, column = 0; i < view->parts; column += view->part[i++].count) {
            const int bad =
                see_part(view, &view->part[i], column, now, states + from * n,
                         inputs ? inputs + from * view->inputs : NULL, values + from * all,
                         by_state ? by_state + from * all * n : NULL);
            if (bad) {
                return bad;
            }
        }
    }
    return 0;
}

one_look view_of(view *view)
{
    return (one_look){.context = view,
                      .states = view->part[0].look.states,
                      .inputs = view->inputs,
                      .values = values_of(view),
                      .see = see_parts};
}
