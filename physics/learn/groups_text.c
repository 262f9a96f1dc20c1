/* Groups in words. */
#include "physics/learn/groups_internal.h"

#include <math.h>
#include <stdio.h>

static void name_of(const group_row *r, char *text, size_t size)
{
    static const char *const axes[3] = {"d1", "d2", "d3"};
    const group_kind kind = r->of.kind;
    const char *how = kind == GROUP_AXIAL ? " about " : r->of.rows == 3 ? " along " : "";
    int at = snprintf(text, size, "%s%s%s", r->of.name, how, r->of.rows == 3 ? axes[r->entry] : "");
    if (r->is_local && !isnan(r->of.s)) {
        at += snprintf(text + at, size - (size_t)at, " at s = %.3g m", r->of.s);
    }
    if (r->is_local && !isnan(r->of.t)) {
        snprintf(text + at, size - (size_t)at, " at t = %.3g s", r->of.t);
    }
}

static void group_text(const groups *groups, const group_row *r, char *text, size_t size)
{
    char name[2 * GROUP_NAME + 32];
    const scene *family = &groups->source.open;
    int others = 0;
    name_of(r, name, sizeof name);
    const double low = r->is_log ? exp(r->low) : r->low, high = r->is_log ? exp(r->high) : r->high;
    int at = snprintf(text, size, "%s: %.3g to %.3g%s%s%s, input to %.2g", name, low, high,
                      *r->of.unit ? " " : "", r->of.unit, r->is_log ? " by its logarithm" : "",
                      r->scale);
    for (int k = 0; k < family->parameter_count && (size_t)at < size; k++) {
        if (!r->of.as_it_is && r->parameters >> k & 1) {
            at += snprintf(text + at, size - (size_t)at, "%s %s", others++ ? "," : "; of",
                           family->parameters[k].name);
        }
    }
}

static void symmetry_text(const groups *groups, char *text, size_t size)
{
    const group_symmetry *s = &groups->symmetry;
    char turns[64] = "";
    if (s->order != 1) {
        snprintf(turns, sizeof turns, s->order == 0 ? "any turn about d3" : "a turn by %d degrees",
                 360 / (s->order > 0 ? s->order : 1));
    }
    char off[64] = "";
    if (s->off > 0) {
        snprintf(off, sizeof off, ", but for some %.1g of the length", s->off);
    }
    snprintf(text, size, "symmetry: %s%s%s%s", turns, s->order != 1 && s->mirrors ? " and " : "",
             s->mirrors ? "a mirror" : "", off);
}

bool groups_text(const groups *groups, int index, char *text, size_t size)
{
    const scene *family = &groups->source.open;
    unsigned used = 0;
    for (int i = 0; i < groups->count; i++) {
        used |= groups->rows[i].parameters;
    }
    if (index < groups->count) {
        group_text(groups, &groups->rows[index], text, size);
        return true;
    }
    index -= groups->count;
    if (group_symmetry_any(&groups->symmetry) && index-- == 0) {
        symmetry_text(groups, text, size);
        return true;
    }
    for (int k = 0; k < family->parameter_count; k++) {
        if (!(used >> k & 1) && index-- == 0) {
            const char *name = family->parameters[k].name;
            const bool moves = quantity_any_depends_on(3, family->start.position, name) ||
                               quantity_any_depends_on(4, family->start.rotation, name);
            snprintf(text, size, moves ? "%s moves the base alone" : "%s does not change the shape",
                     name);
            return true;
        }
    }
    return false;
}
