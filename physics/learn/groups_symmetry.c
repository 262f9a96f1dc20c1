/* Symmetries of a scene about d3 of its base: found in numbers, used on the tape.
 *
 * A rod that is turned as a whole about d3 of its base by phi, with its loads, is the same rod. Its
 * directors may be named anew, turned back by phi, so that the base lies as before. Then vectors in
 * the frame of the base and of the sections have turned, curvature among them, and actuators have
 * come to other places. Where that is the place of another one, and the section does not tell the
 * turn, it is a member of the family with other pulls and loads; so too for a mirror through d3. */
#include "physics/learn/groups_internal.h"
#include "physics/numerics/constants.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Relative, of numbers that their author wrote to some nine digits. */
static const double SAME = 1e-7;

/* Of what varies, by its own size: draws alone make some 0.1. */
static const double UNLIKE = 0.25;

/* The scene at work: its items in numbers. */
typedef struct finder {
    const group_source *source;
    const group_list *list;
    size_t draws;
    const double *values;
} finder;

/* A turn by an angle, or the mirror through an axis at an angle. */
typedef struct motion {
    bool mirrors;
    double angle;
} motion;

/* [rows][draws] of an item. */
static const double *values_of(const finder *finder, int item)
{
    size_t rows = 0;
    for (int i = 0; i < item; i++) {
        rows += (size_t)finder->list->items[i].rows;
    }
    return finder->values + rows * finder->draws;
}

static bool is_constant(const finder *finder, int item)
{
    const size_t count = (size_t)finder->list->items[item].rows * finder->draws;
    const double *v = values_of(finder, item);
    double size = 0, change = 0;
    for (size_t i = 0; i < count; i++) {
        size = fmax(size, fabs(v[i]));
        change = fmax(change, fabs(v[i] - v[i / finder->draws * finder->draws]));
    }
    return change <= SAME * size;
}

static void move(motion m, bool is_axial, const double from[3], double to[3])
{
    const double c = cos(m.mirrors ? 2 * m.angle : m.angle);
    const double s = sin(m.mirrors ? 2 * m.angle : m.angle);
    const double side = m.mirrors ? -1 : 1, sign = m.mirrors && is_axial ? -1 : 1;
    to[0] = sign * (c * from[0] - side * s * from[1]);
    to[1] = sign * (s * from[0] + side * c * from[1]);
    to[2] = sign * from[2];
}

/* Whether vectors of a [3][draws] become those of b. */
static bool become(const finder *finder, motion m, bool is_axial, const double *a, const double *b)
{
    const size_t n = finder->draws;
    double off = 0, size = 0;
    for (size_t i = 0; i < n; i++) {
        const double from[3] = {a[i], a[n + i], a[2 * n + i]};
        double to[3];
        move(m, is_axial, from, to);
        for (size_t k = 0; k < 3; k++) {
            off = fmax(off, fabs(to[k] - b[k * n + i]));
            size = fmax(size, fabs(to[k]));
        }
    }
    return off <= SAME * size;
}

/* Whether the members' vectors are spread as before, by their mean and second moments across d3 and
 * along it: else what is turned is no member, and a sector is no smaller than the whole. */
static bool is_spread_alike(const finder *finder, motion m, bool is_axial, const double *v)
{
    const size_t n = finder->draws;
    double mean[3] = {0}, second[3][3] = {{0}}, size[3] = {0};
    bool alike = true;
    for (size_t i = 0; i < n; i++) {
        const double from[3] = {v[i], v[n + i], v[2 * n + i]};
        double to[3];
        move(m, is_axial, from, to);
        for (int k = 0; k < 3; k++) {
            mean[k] += (to[k] - from[k]) / (double)n;
            size[k] += from[k] * from[k] / (double)n;
            for (int l = 0; l < 3; l++) {
                second[k][l] += (to[k] * to[l] - from[k] * from[l]) / (double)n;
            }
        }
    }
    const double rounding = SAME * SAME * (size[0] + size[1] + size[2]);
    size[0] = size[1] = size[0] + size[1] + rounding;
    size[2] += rounding;
    for (int k = 0; k < 3; k++) {
        alike = alike && fabs(mean[k]) <= UNLIKE * sqrt(size[k]);
        for (int l = 0; l < 3; l++) {
            alike = alike && fabs(second[k][l]) <= UNLIKE * sqrt(size[k] * size[l]);
        }
    }
    return alike;
}

static bool tensor_stays(const finder *finder, motion m, int item)
{
    const double *v = values_of(finder, item);
    double off = 0, size = 0;
    for (size_t i = 0; i < finder->draws; i++) {
        off = fmax(off, fabs(v[i] - v[finder->draws + i]));
        size = fmax(size, fabs(v[i]));
    }
    return off <= SAME * size || fabs(sin(2 * m.angle) * (m.mirrors ? 1 : cos(m.angle))) < SAME;
}

static bool same_place(const group_item *a, const group_item *b)
{
    return (a->s == b->s || (isnan(a->s) && isnan(b->s))) &&
           (a->t == b->t || (isnan(a->t) && isnan(b->t)));
}

/* The item of that kind at the place of `like` that belongs to a tendon; -1: none. */
static int item_of(const group_list *list, const group_item *like, int tendon)
{
    for (int i = 0; i < list->count; i++) {
        const group_item *one = &list->items[i];
        if (one->kind == like->kind && one->tendon == tendon && same_place(one, like)) {
            return i;
        }
    }
    return -1;
}

/* The same of pulls, one number each. */
static bool are_spread_alike(const finder *finder, const double *a, const double *b)
{
    double mean[2] = {0}, square[2] = {0};
    for (size_t i = 0; i < finder->draws; i++) {
        mean[0] += a[i] / (double)finder->draws;
        mean[1] += b[i] / (double)finder->draws;
        square[0] += a[i] * a[i] / (double)finder->draws;
        square[1] += b[i] * b[i] / (double)finder->draws;
    }
    return fabs(mean[0] - mean[1]) <= UNLIKE * sqrt(square[0]) &&
           fabs(square[0] - square[1]) <= UNLIKE * square[0];
}

/* Whether actuator a comes in the place of b, all along, with pulls like those of b. */
static bool comes(const finder *finder, motion m, int a, int b)
{
    const int tendons = finder->source->open.tendon_count;
    bool same = (a < tendons) == (b < tendons);
    int of_a = 0, of_b = 0;
    for (int i = 0; i < finder->list->count && same; i++) {
        const group_item *item = &finder->list->items[i];
        const bool is_pull = item->kind == GROUP_PULL;
        if (!is_pull && item->kind != GROUP_OFFSET) {
            continue;
        }
        of_b += item->tendon == b;
        if (item->tendon != a) {
            continue;
        }
        of_a++;
        const int other = item_of(finder->list, item, b);
        if (other < 0) {
            return false;
        }
        const double *from = values_of(finder, i), *to = values_of(finder, other);
        if (!is_pull) {
            same = become(finder, m, false, from, to);
        } else if (is_constant(finder, i) && is_constant(finder, other)) {
            same = fabs(from[0] - to[0]) <= SAME * fabs(from[0]);
        } else {
            same = are_spread_alike(finder, from, to);
        }
    }
    return same && of_a == of_b;
}

/* Whether it leaves the scene as it is: what is the same for all members, how they are spread, and
 * the set of actuators, of which each comes in the place of another; `nearly`: but for that. */
static bool leaves(const finder *finder, motion m, bool nearly, int places[SCENE_TENDONS_MAX])
{
    const int count = nearly ? 0 : finder->source->open.tendon_count;
    for (int i = 0; i < finder->list->count; i++) {
        const group_item *item = &finder->list->items[i];
        const bool is_vector = item->kind == GROUP_POLAR || item->kind == GROUP_AXIAL;
        const double *v = values_of(finder, i);
        const bool is_axial = item->kind == GROUP_AXIAL;
        if ((item->kind == GROUP_TENSOR && !tensor_stays(finder, m, i)) ||
            (is_vector && !(is_constant(finder, i) ? become(finder, m, is_axial, v, v)
                                                   : is_spread_alike(finder, m, is_axial, v)))) {
            return false;
        }
    }
    for (int a = 0; a < count; a++) {
        places[a] = -1;
        for (int b = 0; b < count && places[a] < 0; b++) {
            bool is_taken = false;
            for (int k = 0; k < a; k++) {
                is_taken = is_taken || places[k] == b;
            }
            places[a] = !is_taken && comes(finder, m, a, b) ? b : -1;
        }
        if (places[a] < 0) {
            return false;
        }
    }
    return true;
}

/* The direction across d3 of a vector, as one of a force. */
static void direction_of(const finder *finder, int item, size_t draw, double d[2])
{
    const double *v = values_of(finder, item);
    const double a = v[draw], b = v[finder->draws + draw];
    const bool is_axial = finder->list->items[item].kind == GROUP_AXIAL;
    d[0] = is_axial ? -b : a;
    d[1] = is_axial ? a : b;
}

/* Axes that a mirror may have: those of the section, of actuators, between two of them, of what is
 * the same for all members. */
static bool find_mirror(const finder *finder, group_symmetry *result)
{
    double angles[2 + SCENE_TENDONS_MAX];
    double first = NAN;
    int count = 1;
    angles[0] = 0;
    for (int i = 0; i < finder->list->count && count < 2 + SCENE_TENDONS_MAX; i++) {
        const group_item *item = &finder->list->items[i];
        first = isnan(first) && item->kind == GROUP_OFFSET ? item->s : first;
        const bool is_first = item->kind == GROUP_OFFSET && item->s == first;
        const bool is_vector = item->kind == GROUP_POLAR || item->kind == GROUP_AXIAL;
        double d[2] = {0, 0};
        if (is_first || (is_vector && is_constant(finder, i))) {
            direction_of(finder, i, 0, d);
        }
        if (hypot(d[0], d[1]) > 0) {
            angles[count++] = atan2(d[1], d[0]);
        }
    }
    for (int i = 0; i < count; i++) {
        for (int k = 0; k <= i; k++) {
            for (int across = 0; across < 2; across++) {
                const double angle = (angles[i] + angles[k]) / 2 + across * PI / 2;
                if (leaves(finder, (motion){true, angle}, false, result->mirrored)) {
                    result->angle = angle;
                    return true;
                }
            }
        }
    }
    return false;
}

/* What part of a vector counts: all across d3, that across the mirror, or across another one. */
typedef enum side { WHOLE, ACROSS_MIRROR, ACROSS_BY } side;

static double side_of(const finder *finder, const group_symmetry *symmetry, side which, int item,
                      size_t draw)
{
    double d[2], axis[2] = {cos(symmetry->angle), sin(symmetry->angle)};
    direction_of(finder, item, draw, d);
    const double size = hypot(d[0], d[1]);
    if (which == ACROSS_BY) {
        direction_of(finder, symmetry->by, draw, axis);
    }
    const double length = hypot(axis[0], axis[1]);
    const double across = length > 0 ? (d[1] * axis[0] - d[0] * axis[1]) / length : 0;
    return which == WHOLE ? size : fabs(across) > SAME * size ? across : 0;
}

/* The vector that varies and by that part moves the rod most; -1: none does. */
static int find_direction(const finder *finder, const group_symmetry *symmetry, side which)
{
    double most = 0;
    int found = -1;
    for (int i = 0; i < finder->list->count; i++) {
        const group_item *item = &finder->list->items[i];
        double square = 0;
        if ((item->kind != GROUP_POLAR && item->kind != GROUP_AXIAL) || is_constant(finder, i)) {
            continue;
        }
        for (size_t k = 0; k < finder->draws; k++) {
            const double part = side_of(finder, symmetry, which, i, k);
            square += part * part;
        }
        const double now = item->effect[0] * sqrt(square);
        if (now > most * (1 + SAME)) {
            most = now;
            found = i;
        }
    }
    return found;
}

/* How far the rod is moved by what tendons do beyond force, moment and resistance to twist, about.
 * With the strains u of the rod and the offset r of a tendon, its resistance to twist is not the
 * same all around by a part (u r)^2. The factor is that of 95 of 100 members of a robot of three
 * tendons with loads in any direction. */
static double beyond_moment(const finder *finder)
{
    static const double factor = 1e-2;
    double moment = 0, twist = 0, offset = 0;
    for (int i = 0; i < finder->list->count; i++) {
        const group_item *item = &finder->list->items[i];
        double *to = item->kind == GROUP_OFFSET                  ? &offset
                     : strcmp(item->name, GROUP_MOMENT) == 0     ? &moment
                     : strcmp(item->name, GROUP_RESISTANCE) == 0 ? &twist
                                                                 : NULL;
        const double *v = values_of(finder, i);
        for (size_t k = 0; to && k < finder->draws; k++) {
            const double across = item->rows > 1 ? v[finder->draws + k] : 0;
            *to = fmax(*to, hypot(v[k], across));
        }
    }
    const double part = moment * offset, torsion = finder->source->numbers.torsion_ratio;
    return factor * part * part * twist / torsion;
}

/* The order of turns: 0, or the sides of a polygon. */
static void find_order(const finder *finder, bool nearly, group_symmetry *result)
{
    static const double any_angle = 1, most_off = 2e-4; /* an angle that no polygon has */
    const int count = finder->source->open.tendon_count;
    result->order = 1;
    if (leaves(finder, (motion){false, any_angle}, false, result->turned)) {
        result->order = 0;
    }
    for (int n = count > 2 ? count : 2; n > 1 && result->order == 1; n--) {
        if (leaves(finder, (motion){false, 2 * PI / n}, false, result->turned)) {
            result->order = n;
        }
    }
    const double off = beyond_moment(finder);
    if (nearly && result->order > 2 && off < most_off &&
        leaves(finder, (motion){false, any_angle}, true, result->turned)) {
        result->order = 0;
        result->off = off;
    }
}

void group_symmetry_find(bool nearly, const group_source *source, const group_list *list,
                         size_t draws, const double *values, group_symmetry *result)
{
    const finder x = {source, list, draws, values};
    *result = GROUP_NO_TURN;
    if (!source->turnable) {
        return;
    }
    find_order(&x, nearly, result);
    result->mirrors = find_mirror(&x, result);
    const bool turns = result->order != 1;
    result->by =
        turns || result->mirrors ? find_direction(&x, result, turns ? WHOLE : ACROSS_MIRROR) : -1;
    if (result->by < 0) {
        *result = GROUP_NO_TURN;
    } else if (result->order == 0 && result->mirrors) {
        result->second = find_direction(&x, result, ACROSS_BY);
        result->mirrors = result->second >= 0;
    }
}

/* ---- on the tape ----------------------------------------------------------------------------- */

/* a turned back about d3; entries of any rows. */
static void turn_back(const groups_turn *turn, ad_value a[3])
{
    const ad_value x = a[0], y = a[1];
    a[0] = ad_add(ad_mul(turn->cosine, x), ad_mul(turn->sine, y));
    a[1] = ad_sub(ad_mul(turn->cosine, y), ad_mul(turn->sine, x));
}

static void turn_on(const groups_turn *turn, ad_value a[3])
{
    const ad_value x = a[0], y = a[1];
    a[0] = ad_sub(ad_mul(turn->cosine, x), ad_mul(turn->sine, y));
    a[1] = ad_add(ad_mul(turn->cosine, y), ad_mul(turn->sine, x));
}

static void mirror(const groups_turn *turn, bool is_axial, ad_value a[3])
{
    for (int i = 0; i < 3 && turn->mirrors; i++) {
        if ((i == 1) != is_axial) {
            a[i] = ad_mul(turn->sign, a[i]);
        }
    }
}

/* The direction of an item, see direction_of. */
static void record_direction(const group_item *item, ad_value d[3])
{
    const bool is_axial = item->kind == GROUP_AXIAL;
    const ad_value a = ad_row(item->value, 0), b = ad_row(item->value, 1);
    d[0] = is_axial ? ad_neg(b) : a;
    d[1] = is_axial ? a : b;
    d[2] = ad_scalar(a.tape, 0);
}

/* The item takes part in what turns. */
static bool is_turned(const group_item *item)
{
    return item->kind == GROUP_POLAR || item->kind == GROUP_AXIAL;
}

/* Every actuator has the pull of the one that comes in its place, where the condition holds; pulls
 * [items] are as they were before. */
static void exchange(group_list *list, const ad_value *pulls, const int *from, ad_value condition)
{
    for (int i = 0; i < list->count; i++) {
        group_item *item = &list->items[i];
        const int other = item->kind == GROUP_PULL ? item_of(list, item, from[item->tendon]) : -1;
        if (other >= 0 && other != i) {
            item->value = ad_select(condition, pulls[other], item->value);
        }
    }
}

static bool keep_pulls(const group_list *list, ad_value **pulls)
{
    *pulls = malloc(((size_t)list->count + 1) * sizeof **pulls);
    for (int i = 0; *pulls && i < list->count; i++) {
        (*pulls)[i] = list->items[i].value;
    }
    return *pulls;
}

/* Cosine and sine of the sector of a polygon that d points into, and pulls of its actuators. */
static void record_sector(const group_symmetry *symmetry, const ad_value d[3],
                          const ad_value *pulls, group_list *list, groups_turn *turn)
{
    ad_tape *tape = d[0].tape;
    ad_value most = ad_scalar(tape, 0);
    int from[SCENE_TENDONS_MAX];
    for (int i = 0; i < SCENE_TENDONS_MAX; i++) {
        from[i] = i;
    }
    for (int k = 0; k < symmetry->order; k++) {
        const double angle = symmetry->angle + 2 * PI * k / symmetry->order;
        const ad_value c = ad_scalar(tape, cos(angle)), s = ad_scalar(tape, sin(angle));
        const ad_value along = ad_add(ad_mul(c, d[0]), ad_mul(s, d[1]));
        const ad_value nearer = ad_sub(along, most);
        turn->cosine = k > 0 ? ad_select(nearer, c, turn->cosine) : c;
        turn->sine = k > 0 ? ad_select(nearer, s, turn->sine) : s;
        if (k > 0) {
            for (int i = 0; i < SCENE_TENDONS_MAX; i++) {
                from[i] = symmetry->turned[from[i]];
            }
            exchange(list, pulls, from, nearer);
        }
        most = k > 0 ? ad_max(most, along) : along;
    }
}

/* The direction itself; where there is none, none is better than another. */
static void record_direct(const ad_value d[3], groups_turn *turn)
{
    ad_tape *tape = d[0].tape;
    const ad_value square = ad_add(ad_square(d[0]), ad_square(d[1])), one = ad_scalar(tape, 1);
    const ad_value by = ad_reciprocal(ad_sqrt(ad_select(square, square, one)));
    turn->cosine = ad_select(square, ad_mul(d[0], by), one);
    turn->sine = ad_mul(d[1], by);
}

void group_symmetry_apply(const group_symmetry *symmetry, group_list *list, groups_turn *turn)
{
    ad_value d[3], side[3], *pulls;
    *turn = (groups_turn){.turns = group_symmetry_any(symmetry), .mirrors = symmetry->mirrors};
    if (!turn->turns || list->count == 0) {
        return;
    }
    ad_tape *tape = list->items[0].value.tape;
    record_direction(&list->items[symmetry->by], d);
    record_direction(&list->items[symmetry->second >= 0 ? symmetry->second : symmetry->by], side);
    if (!keep_pulls(list, &pulls)) {
        ad_tape_fail(tape, AD_NO_MEMORY, "out of memory for groups");
        return;
    }
    if (symmetry->order == 0) {
        record_direct(d, turn);
    } else {
        record_sector(symmetry, d, pulls, list, turn);
    }
    free(pulls);
    turn_back(turn, side);
    if (turn->mirrors && keep_pulls(list, &pulls)) {
        const ad_value one = ad_scalar(tape, 1), other = ad_neg(side[1]);
        turn->sign = ad_select(other, ad_neg(one), one);
        exchange(list, pulls, symmetry->mirrored, other);
        free(pulls);
    }
    for (int i = 0; i < list->count; i++) {
        group_item *item = &list->items[i];
        ad_value a[3];
        for (int k = 0; k < 3 && is_turned(item); k++) {
            a[k] = ad_row(item->value, k);
        }
        if (is_turned(item)) {
            turn_back(turn, a);
            mirror(turn, item->kind == GROUP_AXIAL, a);
            item->value = ad_stack(3, a);
        }
    }
}

void groups_restore(const groups_turn *turn, ad_value vector[3])
{
    if (turn->turns) {
        mirror(turn, true, vector);
        turn_on(turn, vector);
    }
}
