#include "physics/scene/scene_memory.h"

#include "physics/scene/scene_field.h"

#include <math.h>
#include <string.h>

/* Turns of an input; of one with parameters, whose states are formulas of all before. */
enum { TURNS_MAX = 400, TURNS_OPEN_MAX = 40, LEVELS = 26, BOXES_MAX = 200000 };

/* Of the input's size: what it goes to and fro by less is one turn. */
static const double NOISE = 1e-14;

/* ---- in motion ----------------------------------------------------------------------------- */

typedef struct turns {
    quantity input;
    quantities *names;
    double duration, size; /* s; of the input */
    int count, boxes;      /* -1: too many */
    double at[2 * TURNS_MAX];
} turns;

static double input_at(const turns *of, double t)
{
    return quantity_value(of->input, 0, t);
}

static void add_box(turns *to, double low, double high)
{
    if (to->count > 1 && to->at[to->count - 1] >= low) {
        to->at[to->count - 1] = high; /* both are one */
    } else if (to->count + 2 > 2 * TURNS_MAX) {
        to->count = -1;
    } else {
        to->at[to->count++] = low;
        to->at[to->count++] = high;
    }
}

/* Ends of short boxes between which the input rises or falls, by interval arithmetic on its slope
 * for all values of parameters. */
static void find_turns(turns *to, double low, double high, int level)
{
    const quantity_interval s = {0, 0}, t = {low, high};
    const quantity_interval slope = quantity_enclose(to->input, "t", s, t).slope;
    if (!(slope.low < 0 && slope.high > 0) || to->count < 0) {
        return;
    }
    if (++to->boxes > BOXES_MAX) {
        to->count = -1;
    } else if (level == LEVELS || (slope.high - slope.low) * (high - low) < NOISE * to->size) {
        add_box(to, low, high);
    } else {
        find_turns(to, low, quantity_middle(t), level + 1);
        find_turns(to, quantity_middle(t), high, level + 1);
    }
}

/* Where in a box sign times the input is largest, by golden sections; `best`: an end of it. */
static double furthest(const turns *of, double low, double high, double best, double sign)
{
    static const double GOLDEN = 0.6180339887498949;
    const double end = best;
    for (int i = 0; i < 80; i++) {
        const double a = high - GOLDEN * (high - low), b = low + GOLDEN * (high - low);
        const bool left = sign * (input_at(of, a) - input_at(of, b)) > 0;
        best = left ? a : b;
        *(left ? &high : &low) = left ? b : a;
    }
    return sign * (input_at(of, best) - input_at(of, end)) > 0 ? best : end;
}

/* Keeps the beginning, and of the others those where it does turn. */
static void keep_turns(turns *to)
{
    int kept = 1;
    double way = 0, last = input_at(to, to->at[0]);
    for (int i = 1; i <= to->count; i++) {
        const double at = i < to->count ? to->at[i] : to->duration, step = input_at(to, at) - last;
        if (step * way < 0) {
            const int low = (i - 2) / 2 * 2 + 1; /* of the box whose end i - 1 is */
            to->at[kept++] = furthest(to, to->at[low], to->at[low + 1], to->at[i - 1], way);
        }
        way = step != 0 ? step : way;
        last += step;
    }
    to->count = kept;
}

static quantity at_instant(quantity q, double t)
{
    const char *name = "t";
    return quantity_with(q, 1, &name, &t);
}

/* A formula of time: states [from, to), each from its turn on. */
static quantity states_in_time(const turns *of, const quantity *states, int from, int to)
{
    const int middle = (from + to) / 2;
    if (to - from == 1) {
        return states[from];
    }
    const quantity since =
        quantity_subtract(quantity_formula(of->names, "t"), quantity_number(of->at[middle]));
    return quantity_call("where", (quantity[]){since, states_in_time(of, states, middle, to),
                                               states_in_time(of, states, from, middle)});
}

/* What a play is, as a formula of time. */
static ad_status follow_time(scene *moving, const quantity_play *play, quantity *formula,
                             ad_error *error)
{
    const quantity input = play->input, value = play->next;
    turns of = {.input = input, .names = moving->names, .duration = scene_duration(moving)};
    quantity states[TURNS_MAX], state = quantity_number(0);
    const quantity_interval span =
        quantity_range(input, (quantity_interval){0, 0}, (quantity_interval){0, of.duration});
    of.size = fmax(fabs(span.low), fabs(span.high));
    of.count = 1; /* at 0 */
    find_turns(&of, 0, of.duration, 0);
    if (of.count > 0) {
        keep_turns(&of);
    }
    bool open = false;
    for (int i = 0; i < moving->parameter_count; i++) {
        const bool uses = quantity_depends_on(value, moving->parameters[i].name);
        moving->timed |= uses ? UINT64_C(1) << i : 0;
        open = open || uses;
    }
    const int most = open ? TURNS_OPEN_MAX : TURNS_MAX;
    if (of.count < 0 || of.count > most) {
        return ad_fail(error, AD_BAD_INPUT,
                       "the input of play turns back more than %d times, or at instants that "
                       "depend on parameters; allowed: fewer turns, at the same instants for all",
                       most);
    }
    for (int i = 0; i < of.count; i++) {
        state = at_instant(quantity_put(value, play->name, state), of.at[i]);
        states[i] = state;
    }
    *formula = quantity_put(value, play->name, states_in_time(&of, states, 0, of.count));
    return quantity_check(*formula, error);
}

/* ---- both ---------------------------------------------------------------------------------- */

static void put(scene *to, const char *name, quantity value)
{
    for (int i = 0; i < scene_field_count; i++) {
        quantity *q = (quantity *)(void *)((char *)to + scene_fields[i].offset);
        for (int k = 0; k < scene_fields[i].count; k++) {
            if (quantity_depends_on(q[k], name)) {
                q[k] = quantity_put_unseen(q[k], name, value);
            }
        }
    }
}

/* The key of the first formula that has the state. */
static const char *key_of(const scene *of, const char *name)
{
    for (int i = 0; i < scene_field_count; i++) {
        if (quantity_any_depends_on(scene_fields[i].count, scene_field_of(of, &scene_fields[i]),
                                    name)) {
            return scene_fields[i].key;
        }
    }
    return NULL;
}

static ad_status check(const scene *of, const quantity_play *play, ad_error *error)
{
    const quantity_interval at = {0, 0};
    const double low = quantity_range(play->constant, at, at).low;
    if (quantity_depends_on(play->input, "s") || quantity_depends_on(play->constant, "s")) {
        return ad_fail(error, AD_BAD_INPUT,
                       "has a %s along the rod; allowed: of inputs, formulas of t and of "
                       "parameters",
                       play->lags ? "lag" : "play");
    }
    if (quantity_depends_on(play->constant, "t") || !(play->lags ? low > 0 : low >= 0)) {
        return ad_fail(error, AD_BAD_INPUT,
                       play->lags ? "has a lag whose time changes, or may be 0 or negative; "
                                    "allowed: a number or a parameter > 0"
                                  : "has a play whose threshold changes in time, or may be "
                                    "negative; allowed: a number or a parameter >= 0");
    }
    if (play->lags && scene_is_dynamic(of) && quantity_depends_on(play->input, "t")) {
        return ad_fail(error, AD_BAD_INPUT,
                       "has a lag of a formula of t; allowed: of parameters, whose values are "
                       "recorded or set");
    }
    return of->parameter_count < SCENE_PARAMETERS_MAX
               ? AD_OK
               : ad_fail(error, AD_BAD_INPUT,
                         "has a play or lag, whose state is one parameter too many; allowed: %d",
                         SCENE_PARAMETERS_MAX);
}

/* Its state becomes a parameter, before those that are to be found. */
static void add_state(scene *to, const char *name, const quantity_play *play)
{
    const int at = scene_known_count(to);
    for (int i = to->parameter_count; i > at; i--) {
        to->parameters[i] = to->parameters[i - 1];
        to->guess[i] = to->guess[i - 1];
    }
    const uint64_t below = (UINT64_C(1) << at) - 1;
    to->timed = (to->timed & below) | (to->timed & ~below) << 1;
    to->parameters[at] = (scene_parameter){name, play->low, play->high, SCENE_LINEAR};
    to->guess[at] = 0;
    to->memory[to->memory_count++] =
        (scene_memory){play->lags, play->next, play->input, play->constant};
    to->parameter_count++;
}

/* Of one play or lag, in which those within are known: a state of that name, which is kept, or the
 * formula that it is; not given: there is none. */
static ad_status place(scene *to, const char *name, const quantity_play *play, quantity *formula,
                       ad_error *error)
{
    const bool moves = scene_is_dynamic(to);
    ad_status status = check(to, play, error);
    if (status == AD_OK && moves && quantity_depends_on(play->input, "t")) {
        return follow_time(to, play, formula, error);
    }
    if (status == AD_OK && play->lags && !moves) {
        *formula = play->input; /* there it has been for long */
        return AD_OK;
    }
    if (status == AD_OK) {
        add_state(to, name, play);
        *formula = moves ? *formula : play->next;
    }
    return status;
}

/* Keys of the formulas that have plays, or others that have them; NULL: none. */
static void find_keys(const scene *of, int others, const quantity *other, int count,
                      const quantity_play *plays, const char **keys)
{
    for (int i = count - 1; i >= 0; i--) {
        keys[i] = key_of(of, plays[i].name);
        if (!keys[i] && quantity_any_depends_on(others, other, plays[i].name)) {
            keys[i] = "residual.inputs";
        }
        for (int k = i + 1; k < count && !keys[i]; k++) {
            keys[i] = quantity_depends_on(plays[k].next, plays[i].name) ||
                              quantity_depends_on(plays[k].constant, plays[i].name)
                          ? keys[k]
                          : NULL;
        }
    }
}

ad_status scene_remember(scene *rod_scene, int others, quantity *other, const char **key,
                         ad_error *error)
{
    int count;
    const quantity_play *plays = quantities_plays(rod_scene->names, &count);
    quantity formula[QUANTITY_PLAYS_MAX] = {{0}};
    const char *keys[QUANTITY_PLAYS_MAX];
    ad_status status = AD_OK;
    rod_scene->timed = 0;
    find_keys(rod_scene, others, other, count, plays, keys);
    for (int i = 0; i < count && status == AD_OK; i++) {
        quantity_play play = plays[i];
        *key = keys[i];
        if (!*key) {
            continue;
        }
        for (int k = 0; k < i; k++) { /* those within others are known */
            if (formula[k].is_given) {
                play.input = quantity_put(play.input, plays[k].name, formula[k]);
                play.next = quantity_put(play.next, plays[k].name, formula[k]);
                play.constant = quantity_put(play.constant, plays[k].name, formula[k]);
            }
        }
        status = place(rod_scene, plays[i].name, &play, &formula[i], error);
        if (status == AD_OK && formula[i].is_given) {
            put(rod_scene, plays[i].name, formula[i]);
            for (int k = 0; k < others; k++) {
                other[k] = quantity_put_unseen(other[k], plays[i].name, formula[i]);
            }
        }
    }
    return status;
}
