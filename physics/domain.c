#include "physics/domain.h"

#include <math.h>
#include <string.h>

double domain_window_time(const domain *d, int index)
{
    if (d->time < 0) {
        return 0;
    }
    const domain_coordinate *t = &d->coordinates[d->time];
    return index == d->windows ? t->high : t->low + (t->high - t->low) * index / d->windows;
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

int domain_find(const domain *d, const char *name)
{
    for (int i = 0; i < d->count; i++) {
        if (strcmp(d->coordinates[i].name, name) == 0) {
            return i;
        }
    }
    return -1;
}

/* ---- places -------------------------------------------------------------------------------- */

domain_place domain_record(const domain *d, const domain_uniforms *uniforms, ad_tape *tape)
{
    double start = domain_window_time(d, 0), span = domain_window_time(d, 1) - start;
    domain_place at = {.tape = tape, .goes_on = uniforms->state > 0};
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

ad_value domain_network_input(const domain *d, const domain_place *at)
{
    ad_value rows[DOMAIN_COORDINATES_MAX], one = ad_scalar(at->tape, 1);
    for (int i = 0; i < d->count; i++) {
        const domain_coordinate *c = &d->coordinates[i];
        ad_value passed = ad_sub(at->x[i], ad_scalar(at->tape, c->low));
        ad_value range = ad_scalar(at->tape, c->high - c->low);
        if (i == d->time) {
            passed = domain_elapsed(d, at);
            range = at->span;
        }
        rows[i] = ad_sub(ad_mul(ad_scale(passed, 2), ad_reciprocal(range)), one);
    }
    return ad_stack(d->count, rows);
}
