/* The symmetry of a robot about its axis, by what its solved steps do.
 *
 * Where a turn of state and inputs gives the turned next state, pairs of modes turn as vectors
 * across the axis: (v1, v2) and (u2, -u1), whose second components change sign in the mirror that
 * leaves the first ones, as the twist u3 does. How inputs turn follows from the forces by which
 * they act on the modes. Candidates are tried in turn; the first that holds is taken. */
#include "autodiff/dense.h"
#include "nn/rng.h"
#include "tools/surrogate/training_parts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* By how much a symmetry may be off, of what a linear map leaves over. */
static const double MOST_OFF = 0.03;

/* Of the usual bending: below, the frame is shortened. Within a few times as much the network is
 * the less exact, and bang-bang leads there: 0.01 costs three times the loss. */
static const double SOFT = 0.001;

/* Relative: rows that depend on each other. */
static const double DEPENDENT = 1e-6;

typedef struct candidate {
    bool turns, mirrors;
    int axis; /* of a mirror alone: which components stay */
    const char *text;
} candidate;

static const candidate candidates[] = {
    {true, true, 0, "turned with the bending, and mirrored"},
    {true, false, 0, "turned with the bending"},
    {false, true, 0, "mirrored about d1"},
    {false, true, 1, "mirrored about d2"},
    {false, false, 0, "none"},
};

typedef struct finder {
    reduced_rod *rod;
    const surrogate_steps *steps;
    surrogate_step *m;
    const scene *open;
    int n, all;     /* states, inputs of both ends */
    double *rest;   /* [n] */
    double *middle; /* [inputs] */
    double *by;     /* [n][inputs] of the rates by inputs at rest */
    double *numbers;
    surrogate_numbers to;
} finder;

surrogate_numbers surrogate_numbers_of(const surrogate_step *of, double *numbers)
{
    const size_t n = (size_t)of->states, m = (size_t)(of->ramps ? 2 : 1) * (size_t)of->inputs;
    const size_t blocks = (size_t)surrogate_step_blocks(of);
    surrogate_numbers x;
    size_t at = 0;
#define SURROGATE_PLACE(name, count)                                                               \
    x.name = numbers + at;                                                                         \
    at += (size_t)(count);
    SURROGATE_STEP_NUMBERS(SURROGATE_PLACE)
#undef SURROGATE_PLACE
    x.network = numbers + at;
    return x;
}

void surrogate_coordinates(const surrogate_step *m, const double *state, const double *inputs,
                           double *z)
{
    const surrogate_numbers from = surrogate_numbers_of(m, (double *)m->numbers);
    const int all = m->ramps ? 2 * m->inputs : m->inputs;
    for (int k = 0; k < m->states; k++) {
        z[m->state_slot[k]] = (state[k] - from.state_center[k]) / from.state_scale[k];
    }
    for (int k = 0; k < all; k++) {
        double sum = 0;
        for (int i = 0; i < all; i++) {
            sum += from.input_map[i * all + k] * (inputs[i] - from.input_center[i]);
        }
        z[m->input_slot[k]] = sum;
    }
}

/* ---- classes of the state ------------------------------------------------------------------ */

typedef enum place { FIRST, SECOND, EVEN, ODD } place;

/* The class of a mode, and the sign of its coordinate. */
static place place_of(const candidate *c, int strain, double *sign)
{
    *sign = strain == 3 ? -1 : 1;
    const bool second = strain == 1 || strain == 3;
    if (strain == 2 || strain < 0) {
        return EVEN;
    }
    if (strain == 5) {
        return c->mirrors ? ODD : EVEN;
    }
    return c->turns     ? (second ? SECOND : FIRST)
           : c->mirrors ? (second == (c->axis == 0) ? ODD : EVEN)
                        : EVEN;
}

/* Slots of the state's numbers by class: pairs that belong together get the same index. False:
 * modes do not come in pairs. */
static bool place_states(finder *x, const candidate *c, place *places)
{
    surrogate_step *m = x->m;
    const int half = x->n / 2;
    int count[4] = {0};
    for (int k = 0; k < x->n; k++) {
        double sign;
        const reduced_mode mode = reduced_mode_of(x->rod, k % half);
        if (mode.strain < 0 && (c->turns || c->mirrors)) {
            return false;
        }
        places[k] = place_of(c, mode.strain, &sign);
        x->to.state_scale[k] = sign;
        m->state_slot[k] = count[places[k]]++;
    }
    m->out_pairs = count[FIRST];
    m->out_evens = count[EVEN];
    m->out_odds = count[ODD];
    for (int k = 0; k < x->n && c->turns; k++) { /* a second component follows its first one */
        if (places[k] != SECOND) {
            continue;
        }
        const reduced_mode mode = reduced_mode_of(x->rod, k % half);
        int found = -1;
        for (int i = k / half * half; i < (k / half + 1) * half; i++) {
            const reduced_mode other = reduced_mode_of(x->rod, i % half);
            const int wanted = mode.strain == 1 ? 0 : 4;
            found =
                other.strain == wanted && other.degree == mode.degree && other.piece == mode.piece
                    ? i
                    : found;
        }
        if (found < 0) {
            return false;
        }
        m->state_slot[k] = m->state_slot[found];
    }
    return count[FIRST] == count[SECOND];
}

/* ---- classes of the inputs ----------------------------------------------------------------- */

/* Adds a row [size] to the orthonormal rows basis [count][size]; false: it depends on them. */
static bool add_row(double *basis, int count, int size, const double *row)
{
    double *to = basis + count * size, before = 0, after = 0;
    memcpy(to, row, (size_t)size * sizeof *to);
    for (int i = 0; i < size; i++) {
        before += row[i] * row[i];
    }
    for (int turn = 0; turn < 2; turn++) {
        for (int k = 0; k < count; k++) {
            double dot = 0;
            for (int i = 0; i < size; i++) {
                dot += basis[k * size + i] * to[i];
            }
            for (int i = 0; i < size; i++) {
                to[i] -= dot * basis[k * size + i];
            }
        }
    }
    for (int i = 0; i < size; i++) {
        after += to[i] * to[i];
    }
    if (!(after > DEPENDENT * DEPENDENT * before) || !(before > 0)) {
        return false;
    }
    for (int i = 0; i < size; i++) {
        to[i] /= sqrt(after);
    }
    return true;
}

/* Coordinates of the inputs of one end: columns of map [inputs][inputs] and their classes. False:
 * the inputs are not such. */
static bool place_inputs(finder *x, const place *places, place *classes)
{
    const int m = x->m->inputs, half = x->n / 2;
    double *rows = calloc((size_t)(4 * m * m + 4 * m), sizeof *rows);
    double *pairs = rows + m * m, *row = pairs + 2 * m * m; /* of both components */
    int count = 0, pair_count = 0;
    double *map = x->to.input_map;
    const int all = x->all;
    bool fine = rows != NULL;
    memset(map, 0, (size_t)(all * all) * sizeof *map);
    for (int k = half; k < x->n && fine; k++) { /* the second half of the rates: accelerations */
        if (places[k] != FIRST) {
            continue;
        }
        int other = -1;
        for (int i = half; i < x->n; i++) {
            other = places[i] == SECOND && x->m->state_slot[i] == x->m->state_slot[k] ? i : other;
        }
        for (int i = 0; i < m; i++) {
            row[i] = x->by[k * m + i];
            row[m + i] =
                (reduced_mode_of(x->rod, other - half).strain == 3 ? -1 : 1) * x->by[other * m + i];
        }
        if (pair_count == m || !add_row(pairs, pair_count, 2 * m, row)) {
            continue;
        }
        const double *now = pairs + 2 * m * pair_count++;
        for (int part = 0; part < 2 && fine; part++) {
            fine = count < m && add_row(rows, count, m, now + part * m);
            for (int i = 0; i < m && fine; i++) {
                map[i * all + count] = now[part * m + i];
            }
            classes[count < m ? count : 0] = part ? SECOND : FIRST;
            count += fine;
        }
    }
    /* then what acts on odd and even numbers, inputs that do not act across by themselves first;
     * and what is left over */
    for (int turn = 0; turn < 3 && fine; turn++) {
        for (int k = 0; k < (turn == 1 ? half : m) && count < m; k++) {
            place class = EVEN;
            for (int i = 0; i < m; i++) {
                row[i] = turn == 1 ? x->by[(half + k) * m + i] : i == k;
            }
            if (turn == 1) {
                class = places[half + k];
                if (class == FIRST || class == SECOND) {
                    continue;
                }
            }
            double across = 0, along = 0;
            for (int i = 0; i < half && turn == 0; i++) {
                const double by = fabs(x->by[(half + i) * m + k]);
                *(places[half + i] == EVEN ? &along : &across) += by;
            }
            if (turn == 0 && across > DEPENDENT * along) {
                continue;
            }
            if (add_row(rows, count, m, row)) {
                const double *own = turn == 2 ? rows + count * m : row;
                for (int i = 0; i < m; i++) {
                    map[i * all + count] = own[i];
                }
                classes[count++] = class;
            }
        }
    }
    free(rows);
    return fine && count == m;
}

/* Of both ends of a step alike. */
static void place_all(finder *x, const place *places, const place *classes)
{
    surrogate_step *m = x->m;
    const int ends = m->ramps ? 2 : 1, given = m->inputs, all = x->all;
    double *map = x->to.input_map;
    int count[4] = {m->out_pairs, m->out_pairs, m->out_evens, m->out_odds};
    for (int end = 0; end < ends; end++) {
        for (int k = 0; k < given; k++) {
            m->input_slot[end * given + k] = count[classes[k]]++;
            for (int i = 0; i < given && end; i++) {
                map[(given + i) * all + given + k] = map[i * all + k];
            }
        }
    }
    m->pairs = count[FIRST];
    m->evens = count[EVEN];
    m->odds = count[ODD];
    const int from[4] = {0, m->pairs, 2 * m->pairs, 2 * m->pairs + m->evens};
    for (int k = 0; k < x->n; k++) {
        m->state_slot[k] += from[places[k]];
    }
    for (int k = 0; k < all; k++) {
        m->input_slot[k] += from[classes[k % given]];
    }
}

/* ---- scales -------------------------------------------------------------------------------- */

static int partner(const surrogate_step *m, int slot)
{
    return slot < m->pairs ? slot + m->pairs : slot < 2 * m->pairs ? slot - m->pairs : slot;
}

/* Centers: rest for what changes its sign, else the mean; scales: what is usual over the steps. */
static void scale(finder *x)
{
    surrogate_step *m = x->m;
    const size_t count = x->steps->count;
    const int n = x->n, all = x->all;
    double square[2 * SURROGATE_STATES_MAX + 2 * SURROGATE_INPUTS_MAX] = {0};
    double z[2 * SURROGATE_STATES_MAX + 2 * SURROGATE_INPUTS_MAX];
    for (int k = 0; k < n; k++) {
        const int slot = m->state_slot[k];
        const bool stays = slot >= 2 * m->pairs && slot < 2 * m->pairs + m->evens;
        double mean = 0;
        for (size_t i = 0; i < count; i++) {
            mean += x->steps->state[i * (size_t)n + (size_t)k] / (double)count;
        }
        x->to.state_center[k] = stays ? mean : x->rest[k];
    }
    for (int i = 0; i < all; i++) {
        x->to.input_center[i] = x->middle[i % m->inputs];
    }
    m->numbers = x->numbers;
    for (size_t i = 0; i < count; i++) {
        surrogate_coordinates(m, x->steps->state + i * (size_t)n, x->steps->input + i * (size_t)all,
                              z);
        for (int k = 0; k < n + all; k++) {
            square[k] += z[k] * z[k] / (double)count;
        }
    }
    for (int k = 0; k < n + all; k++) {
        const int slot = k < n ? m->state_slot[k] : m->input_slot[k - n];
        const double both = square[slot] + square[partner(m, slot)];
        const double size = both > 0 ? sqrt(both / 2) : 1;
        if (k < n) {
            x->to.state_scale[k] *= size;
        }
        for (int i = 0; i < all && k >= n; i++) {
            x->to.input_map[i * all + k - n] /= size;
        }
    }
    for (int k = 0; k < n; k++) {
        double most = 0;
        for (size_t i = 0; i < count; i++) {
            most = fmax(most,
                        fabs(x->steps->state[i * (size_t)n + (size_t)k] - x->to.state_center[k]));
        }
        x->to.state_range[k] = most > 0 ? most : 1;
    }
}

/* ---- whether it holds ---------------------------------------------------------------------- */

/* Coordinates turned by an angle, mirrored first. */
static void move(const surrogate_step *m, bool mirrors, double angle, double *z)
{
    const double c = cos(angle), s = sin(angle);
    for (int k = 0; k < m->odds && mirrors; k++) {
        z[2 * m->pairs + m->evens + k] *= -1;
    }
    for (int k = 0; k < m->pairs; k++) {
        const double p = z[k], q = z[m->pairs + k] * (mirrors ? -1 : 1);
        z[k] = c * p - s * q;
        z[m->pairs + k] = s * p + c * q;
    }
}

/* The state and inputs of coordinates; inverse [all][all] of the map, column-major. */
static void from_coordinates(const finder *x, const double *z, const double *inverse, double *state,
                             double *inputs)
{
    const surrogate_step *m = x->m;
    for (int k = 0; k < x->n; k++) {
        state[k] = x->to.state_center[k] + x->to.state_scale[k] * z[m->state_slot[k]];
    }
    for (int i = 0; i < x->all && inputs; i++) {
        inputs[i] = x->to.input_center[i];
        for (int k = 0; k < x->all; k++) {
            inputs[i] += inverse[k * x->all + i] * z[m->input_slot[k]];
        }
    }
}

static ad_status solve(finder *x, const double *state, const double *inputs, double *next,
                       ad_error *error)
{
    return reduced_step_linear(x->rod, 0, x->m->step, state, inputs,
                               x->m->ramps ? inputs + x->m->inputs : NULL, next, NULL, NULL, error);
}

/* By how much steps of moved states are off the moved steps, of what states change in a step:
 * coordinates of rates and modes alike. Not a number: no step was solved. */
static double measure(finder *x, const candidate *c)
{
    enum { TRIALS = 64, MOST = 2 * SURROGATE_STATES_MAX + 2 * SURROGATE_INPUTS_MAX };
    const surrogate_step *m = x->m;
    const int n = x->n, all = x->all;
    nn_rng random = nn_rng_split(1, "symmetry");
    double z[MOST], state[SURROGATE_STATES_MAX], inputs[2 * SURROGATE_INPUTS_MAX];
    double next[SURROGATE_STATES_MAX], other[SURROGATE_STATES_MAX], off = 0, size = 0;
    double *inverse = calloc((size_t)(2 * all * all) + 1, sizeof *inverse);
    int *pivots = calloc((size_t)all + 1, sizeof *pivots);
    if (!inverse || !pivots) {
        free(inverse);
        free(pivots);
        return NAN;
    }
    double *copy = inverse + all * all;
    for (int i = 0; i < all; i++) { /* z = map^T u: row k of the matrix is column k of the map */
        for (int k = 0; k < all; k++) {
            copy[i * all + k] = x->to.input_map[i * all + k];
        }
        inverse[i * all + i] = 1;
    }
    bool fine = ad_dense_lu((size_t)all, copy, pivots) == 0;
    if (fine) {
        ad_dense_lu_solve((size_t)all, (size_t)all, copy, pivots, inverse);
    }
    for (int t = 0; t < TRIALS && fine; t++) {
        const size_t i = (size_t)nn_rng_below(&random, x->steps->count);
        const double angle = c->turns ? 6.283185307179586 * nn_rng_uniform(&random) : 0;
        const double *from = x->steps->state + i * (size_t)n;
        const double *u = x->steps->input + i * (size_t)all;
        if (solve(x, from, u, next, NULL) != AD_OK) {
            continue;
        }
        surrogate_coordinates(m, from, u, z);
        move(m, c->mirrors, angle, z);
        from_coordinates(x, z, inverse, state, inputs);
        if (solve(x, state, inputs, other, NULL) != AD_OK) {
            continue;
        }
        surrogate_coordinates(m, next, u, z);
        move(m, c->mirrors, angle, z);
        from_coordinates(x, z, inverse, state, NULL);
        for (int k = 0; k < n / 2; k++) {
            const double unit = x->to.state_scale[k], gap = (state[k] - other[k]) / unit;
            const double moved = (next[k] - from[k]) / unit;
            off += gap * gap;
            size += moved * moved;
        }
    }
    free(inverse);
    free(pivots);
    return fine && size > 0 ? sqrt(off / size) : NAN;
}

/* ---- the search ---------------------------------------------------------------------------- */

/* What the frame turns with: the bending without ends of higher degree, of all pieces. */
static void lead(finder *x)
{
    const int half = x->n / 2;
    memset(x->to.lead, 0, (size_t)(x->n + x->all) * sizeof *x->to.lead);
    for (int k = 0; k < half; k++) {
        const reduced_mode mode = reduced_mode_of(x->rod, k);
        if (mode.strain == 4 && mode.degree == 0) {
            x->to.lead[x->m->state_slot[k]] = 1;
        }
    }
}

static bool try_one(finder *x, const candidate *c, double *off)
{
    place places[SURROGATE_STATES_MAX], classes[SURROGATE_INPUTS_MAX] = {EVEN};
    surrogate_step *m = x->m;
    m->turns = c->turns;
    m->mirrors = c->mirrors;
    m->pairs = m->evens = m->odds = 0;
    if (!place_states(x, c, places) || !place_inputs(x, places, classes)) {
        return false;
    }
    place_all(x, places, classes);
    scale(x);
    *off = c->turns || c->mirrors ? measure(x, c) : 0;
    return *off <= MOST_OFF;
}

static ad_status rest(finder *x, ad_error *error)
{
    double rate[SURROGATE_STATES_MAX];
    scene_middle_values(x->open, x->middle);
    ad_status status = reduced_initial(x->rod, x->middle, x->rest, error);
    if (status == AD_OK && reduced_settle(x->rod, 0, x->middle, x->rest, NULL) != AD_OK) {
        status = reduced_initial(x->rod, x->middle, x->rest, error);
    }
    return status == AD_OK ? reduced_rate(x->rod, 0, x->rest, x->middle, rate, NULL, x->by, error)
                           : status;
}

ad_status surrogate_find_frame(reduced_rod *rod, const surrogate_settings *settings,
                               const scene *open, const surrogate_steps *steps, surrogate_step *m,
                               double **numbers, char text[256], ad_error *error)
{
    const int n = reduced_states(rod), inputs = reduced_inputs(rod);
    double by[SURROGATE_STATES_MAX * SURROGATE_INPUTS_MAX], at_rest[SURROGATE_STATES_MAX];
    double middle[SURROGATE_INPUTS_MAX];
    *m = (surrogate_step){.kind = (int)settings->kind,
                          .states = n,
                          .inputs = inputs,
                          .ramps = settings->hold == SURROGATE_RAMP,
                          .step = settings->step,
                          .soft = SOFT};
    for (int i = 0; i < inputs && m->slow_count < SURROGATE_SLOW_MAX; i++) {
        if (surrogate_names_parameter(settings, open->parameters[i].name)) {
            m->slow[m->slow_count++] = i;
        }
    }
    finder x = {.rod = rod,
                .steps = steps,
                .m = m,
                .open = open,
                .n = n,
                .rest = at_rest,
                .middle = middle,
                .by = by,
                .all = m->ramps ? 2 * inputs : inputs};
    *numbers = x.numbers = calloc(surrogate_step_numbers(m), sizeof *x.numbers);
    if (!x.numbers) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a one-step model");
    }
    x.to = surrogate_numbers_of(m, x.numbers);
    ad_status status = rest(&x, error);
    for (size_t i = 0; i < sizeof candidates / sizeof *candidates && status == AD_OK; i++) {
        double off = 0;
        if (try_one(&x, &candidates[i], &off)) {
            snprintf(text, 256, "frame: %s (within %.1e of a step)", candidates[i].text, off);
            break;
        }
    }
    lead(&x);
    for (int i = 0; i < x.all; i++) {
        x.to.input_low[i] = open->parameters[i % inputs].low;
        x.to.input_high[i] = open->parameters[i % inputs].high;
    }
    m->numbers = x.numbers;
    return status;
}
