#include "physics/scene/domain.h"

#include <math.h>
#include <string.h>

/* ---- windows --------------------------------------------------------------------------------- */

/* One more window for whichever stretch has the longest ones, until there are no more. */
static void share_windows(int windows, int stretches, const double *edges, int *share)
{
    for (int i = 0; i < stretches; i++) {
        share[i] = 1;
    }
    for (int given = stretches; given < windows; given++) {
        int longest = 0;
        for (int i = 1; i < stretches; i++) {
            double here = (edges[i + 1] - edges[i]) / share[i];
            double there = (edges[longest + 1] - edges[longest]) / share[longest];
            longest = here > there ? i : longest;
        }
        share[longest]++;
    }
}

void domain_divide_time(domain *d, int count, const double *times)
{
    double edges[DOMAIN_WINDOWS_MAX + 1];
    int share[DOMAIN_WINDOWS_MAX], stretches = count + 1, window = 0;
    if (d->time < 0 || count == 0 || d->windows < stretches) {
        return;
    }
    const domain_coordinate *t = &d->coordinates[d->time];
    edges[0] = t->low;
    edges[stretches] = t->high;
    memcpy(edges + 1, times, (size_t)count * sizeof *times);
    share_windows(d->windows, stretches, edges, share);
    for (int i = 0; i < stretches; i++) {
        for (int k = 0; k < share[i]; k++) {
            d->window_edge[window++] = edges[i] + (edges[i + 1] - edges[i]) * k / share[i];
        }
    }
    d->window_edge[window] = t->high;
    d->divided = true;
}

double domain_window_time(const domain *d, int index)
{
    if (d->time < 0) {
        return 0;
    }
    if (d->divided) {
        return d->window_edge[index];
    }
    const domain_coordinate *t = &d->coordinates[d->time];
    return index == d->windows ? t->high : t->low + (t->high - t->low) * index / d->windows;
}

double domain_longest_window(const domain *d)
{
    double longest = 0;
    for (int i = 0; i < d->windows; i++) {
        longest = fmax(longest, domain_window_time(d, i + 1) - domain_window_time(d, i));
    }
    return longest;
}

int domain_window_at(const domain *d, double time)
{
    int last = d->windows - 1;
    if (last == 0) {
        return 0;
    }
    double begin = domain_window_time(d, 0), span = domain_window_time(d, d->windows) - begin;
    double passed = ceil((time - begin) / span * d->windows) - 1;
    int index = passed >= last ? last : passed > 0 ? (int)passed : 0;
    while (index > 0 && time <= domain_window_time(d, index)) {
        index--;
    }
    while (index < last && time > domain_window_time(d, index + 1)) {
        index++;
    }
    return index;
}

/* ---- pieces ---------------------------------------------------------------------------------- */

int domain_pieces(const domain *d)
{
    return d->pieces > 1 ? d->pieces : 1;
}

void domain_piece(const domain *d, int piece, double *low, double *high)
{
    bool several = domain_pieces(d) > 1;
    *low = several ? d->edge[piece] : d->coordinates[0].low;
    *high = several ? d->edge[piece + 1] : d->coordinates[0].high;
}

double domain_coordinate_at(const domain_coordinate *c, double fraction)
{
    double at = c->logarithmic ? c->low * pow(c->high / c->low, fraction)
                               : c->low + fraction * (c->high - c->low);
    return fmin(fmax(at, c->low), c->high);
}

int domain_find(const domain *d, const char *name)
{
    for (int i = 0; i < d->count; i++) {
        if (strcmp(d->coordinates[i].name, name) == 0) {
            return i;
        }
    }
    return -1;
}

/* The coordinate with the longest name that `text` begins with, and how long it is; one of several
 * letters ends with the text or at an underscore. -1: none. */
static int begins_with(const domain *d, const char *text, size_t length, size_t *taken)
{
    int found = -1;
    *taken = 0;
    for (int i = 0; i < d->count; i++) {
        const char *name = d->coordinates[i].name;
        const size_t size = strlen(name);
        const bool ends = size == 1 || size == length || (size < length && text[size] == '_');
        if (size > *taken && size <= length && strncmp(text, name, size) == 0 && ends) {
            found = i;
            *taken = size;
        }
    }
    return found;
}

bool domain_read_orders(const domain *d, const char *names, size_t length, int most, int *orders)
{
    int sum = 0;
    memset(orders, 0, (size_t)d->count * sizeof *orders);
    for (size_t k = 0, taken; k < length; k += taken, sum++) {
        k += sum > 0 && names[k] == '_';
        int coordinate = begins_with(d, names + k, length - k, &taken);
        if (coordinate < 0) {
            return false;
        }
        orders[coordinate]++;
    }
    return sum > 0 && sum <= most;
}

/* ---- places -------------------------------------------------------------------------------- */

domain_place domain_record(const domain *d, const domain_uniforms *uniforms, ad_tape *tape)
{
    double start = domain_window_time(d, 0), span = domain_window_time(d, 1) - start;
    domain_place at = {.tape = tape, .over = d, .goes_on = uniforms->state > 0};
    for (int i = 0; i < d->count; i++) {
        at.x[i] = ad_input(tape, d->coordinates[i].name, 1);
    }
    at.start = ad_scalar(tape, start);
    at.span = ad_scalar(tape, span);
    at.load_factor = ad_scalar(tape, 1);
    if (uniforms->window) {
        ad_value window = ad_uniform(tape, "window", 2);
        at.start = ad_row(window, 0);
        at.span = ad_row(window, 1);
    }
    if (uniforms->state > 0) {
        at.state = ad_uniform(tape, "state", uniforms->state);
    }
    if (uniforms->load_factor) {
        at.load_factor = ad_uniform(tape, "load factor", 1);
    }
    return at;
}

domain_setting domain_setting_of(const domain *d, int window, const double *state,
                                 double load_factor)
{
    const double begin = domain_window_time(d, window);
    return (domain_setting){{begin, domain_window_time(d, window + 1) - begin}, state, load_factor};
}

int domain_list_uniforms(const domain_uniforms *uniforms, const domain_setting *setting,
                         const double **list)
{
    int count = 0;
    if (uniforms->window) {
        list[count++] = setting->window;
    }
    if (uniforms->state > 0) {
        list[count++] = setting->state;
    }
    if (uniforms->load_factor) {
        list[count++] = &setting->load_factor;
    }
    return count;
}

ad_value domain_elapsed(const domain *d, const domain_place *at)
{
    return ad_sub(at->x[d->time], at->start);
}

domain_local domain_local_of(const domain *d, ad_value s)
{
    ad_value one = ad_scalar(s.tape, 1), zero = ad_scalar(s.tape, 0), begun = one;
    domain_local local = {.pieces = domain_pieces(d), .x = zero, .bubble = zero};
    for (int k = 0; k < local.pieces; k++) {
        double low, high;
        domain_piece(d, k, &low, &high);
        ad_value passed = ad_sub(s, ad_scalar(s.tape, low));
        ad_value left = ad_sub(ad_scalar(s.tape, high), s);
        ad_value over = k + 1 < local.pieces ? ad_select(ad_neg(left), one, zero) : zero;
        ad_value mask = ad_sub(begun, over);
        ad_value x = ad_sub(ad_scale(passed, 2 / (high - low)), one);
        ad_value bubble = ad_scale(ad_mul(passed, left), 1 / (high - low));
        local.mask[k] = mask;
        local.ramp[k] = ad_add(ad_mul(mask, passed), ad_scale(over, high - low));
        local.x = ad_add(local.x, ad_mul(mask, x));
        local.bubble = ad_add(local.bubble, ad_mul(mask, bubble));
        begun = over;
    }
    return local;
}

ad_value domain_vanish(const domain_place *at, int end)
{
    double low, high;
    int pieces = at->over ? domain_pieces(at->over) : 1;
    ad_value s = at->x[0], one = ad_scalar(s.tape, 1);
    if (pieces == 1) {
        return end ? ad_sub(one, s) : s;
    }
    domain_piece(at->over, end ? pieces - 1 : 0, &low, &high);
    ad_value passed = end ? ad_sub(ad_scalar(s.tape, high), s) : ad_sub(s, ad_scalar(s.tape, low));
    ad_value beyond = ad_sub(passed, ad_scalar(s.tape, high - low));
    return ad_select(beyond, one, ad_scale(passed, 1 / (high - low)));
}

ad_value domain_unit(const domain *d, const domain_place *at, int coordinate)
{
    const domain_coordinate *c = &d->coordinates[coordinate];
    ad_value x = at->x[coordinate], one = ad_scalar(at->tape, 1);
    ad_value passed = ad_sub(x, ad_scalar(at->tape, c->low));
    ad_value range = ad_scalar(at->tape, c->high - c->low);
    if (c->logarithmic) {
        passed = ad_log(ad_scale(x, 1 / c->low));
        range = ad_scalar(at->tape, log(c->high / c->low));
    } else if (coordinate == d->time) {
        passed = domain_elapsed(d, at);
        range = at->span;
    }
    return ad_sub(ad_mul(ad_scale(passed, 2), ad_reciprocal(range)), one);
}

ad_value domain_network_input(const domain *d, const domain_place *at)
{
    ad_value rows[DOMAIN_COORDINATES_MAX + 1 + 2 * DOMAIN_PIECES_MAX];
    for (int i = 0; i < d->count; i++) {
        rows[i] = domain_unit(d, at, i);
    }
    if (domain_pieces(d) == 1) {
        return ad_stack(d->count, rows);
    }
    domain_local local = domain_local_of(d, at->x[0]);
    int count = d->count;
    rows[0] = local.x;
    rows[count++] = local.bubble;
    for (int k = 0; k < local.pieces; k++) {
        rows[count + k] = local.mask[k];
        rows[count + local.pieces + k] = local.ramp[k];
    }
    return ad_stack(count + 2 * local.pieces, rows);
}
