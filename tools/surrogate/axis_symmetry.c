/* The symmetry of a robot about its axis, by what its solved steps do.
 *
 * Where a turn of state and inputs gives the turned next state, pairs of modes turn as vectors
 * across the axis: (v1, v2) and (u2, -u1), whose second components change sign in the mirror that
 * leaves the first ones, as the twist u3 does. How inputs turn follows from the forces by which
 * they act on the modes of the robot at rest: each force that is another combination of the inputs
 * is a coordinate of its own. Two tendons at right angles give three, a pair and their sum.
 * Candidates are tried in turn; the first that holds is taken. */
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

enum { DRIVES_MAX = SURROGATE_INPUTS_MAX / 2 }; /* of one end of a step */

typedef struct finder {
    reduced_rod *rod;
    const surrogate_steps *steps;
    surrogate_step *m;
    const scene *open;
    int n, all; /* states, inputs of both ends */
    double rest[SURROGATE_STATES_MAX];
    double middle[SURROGATE_INPUTS_MAX];
    double *by; /* [n][inputs] of the rates by inputs at rest */
    double *numbers;
    surrogate_numbers to;
    /* of one end: coordinates and how they are made of the inputs; which inputs are not tried, as
     * they do not act across or are slow */
    int drives;
    double column[DRIVES_MAX][SURROGATE_INPUTS_MAX];
    bool held[SURROGATE_INPUTS_MAX];
} finder;

surrogate_numbers surrogate_numbers_of(const surrogate_step *of, double *numbers)
{
    const size_t n = (size_t)of->states, m = (size_t)(of->ramps ? 2 : 1) * (size_t)of->inputs;
    const size_t blocks = 1 + 2 * (size_t)of->slow_count, c = (size_t)of->drives;
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
    for (int k = 0; k < m->drives; k++) {
        double sum = 0;
        for (int i = 0; i < all; i++) {
            sum += from.input_map[i * m->drives + k] * (inputs[i] - from.input_center[i]);
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
static bool place_states(finder *finder, const candidate *c, place *places)
{
    surrogate_step *m = finder->m;
    const int half = finder->n / 2;
    int count[4] = {0};
    for (int k = 0; k < finder->n; k++) {
        double sign;
        const reduced_mode mode = reduced_mode_of(finder->rod, k % half);
        if (mode.strain < 0 && (c->turns || c->mirrors)) {
            return false;
        }
        places[k] = place_of(c, mode.strain, &sign);
        finder->to.state_scale[k] = sign;
        m->state_slot[k] = count[places[k]]++;
    }
    m->out_pairs = count[FIRST];
    m->out_evens = count[EVEN];
    m->out_odds = count[ODD];
    for (int k = 0; k < finder->n && c->turns; k++) { /* a second component follows its first one */
        if (places[k] != SECOND) {
            continue;
        }
        const reduced_mode mode = reduced_mode_of(finder->rod, k % half);
        int found = -1;
        for (int i = k / half * half; i < (k / half + 1) * half; i++) {
            const reduced_mode other = reduced_mode_of(finder->rod, i % half);
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

/* Takes from a row [size] what orthonormal rows basis [count][size] have of it. */
static void leave_out(const double *basis, int count, int size, double *row)
{
    for (int k = 0; k < count; k++) {
        double dot = 0;
        for (int i = 0; i < size; i++) {
            dot += basis[k * size + i] * row[i];
        }
        for (int i = 0; i < size; i++) {
            row[i] -= dot * basis[k * size + i];
        }
    }
}

/* Adds a row [size] to the orthonormal rows basis [count][size]; false: it depends on them. */
static bool add_row(double *basis, int count, int size, const double *row)
{
    double *to = basis + count * size, before = 0, after = 0;
    memcpy(to, row, (size_t)size * sizeof *to);
    for (int i = 0; i < size; i++) {
        before += row[i] * row[i];
    }
    leave_out(basis, count, size, to);
    leave_out(basis, count, size, to); /* again, of rounding */
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

/* Adds a coordinate of the inputs; false: there are too many. */
static bool add_drive(finder *finder, const double *column, place class, place *classes)
{
    if (finder->drives == DRIVES_MAX) {
        return false;
    }
    memcpy(finder->column[finder->drives], column, (size_t)finder->m->inputs * sizeof *column);
    classes[finder->drives++] = class;
    return true;
}

/* What acts across: rows of both components, as they accelerate a pair of modes. */
static bool place_pairs(finder *finder, const place *places, place *classes, double *basis)
{
    const int m = finder->m->inputs, half = finder->n / 2;
    double row[2 * SURROGATE_INPUTS_MAX];
    int count = 0;
    bool fine = true;
    for (int k = half; k < finder->n && fine;
         k++) { /* the second half of the rates: accelerations */
        int other = -1;
        for (int i = half; i < finder->n && places[k] == FIRST; i++) {
            other = places[i] == SECOND && finder->m->state_slot[i] == finder->m->state_slot[k]
                        ? i
                        : other;
        }
        for (int i = 0; i < m && other >= 0; i++) {
            row[i] = finder->by[k * m + i];
            row[m + i] = finder->to.state_scale[other] * finder->by[other * m + i];
        }
        if (other >= 0 && count < 2 * m && add_row(basis, count, 2 * m, row)) {
            const double *now = basis + 2 * m * count++;
            fine = add_drive(finder, now, FIRST, classes) &&
                   add_drive(finder, now + m, SECOND, classes);
        }
    }
    return fine;
}

/* Coordinates of the inputs of one end and their classes: what acts across, inputs that do not by
 * themselves, what acts on even and on odd numbers, and what is left over. False: there are too
 * many. */
static bool place_inputs(finder *finder, const place *places, place *classes)
{
    const int m = finder->m->inputs, half = finder->n / 2;
    double row[SURROGATE_INPUTS_MAX], *basis = calloc((size_t)(4 * m * m) + 1, sizeof *basis);
    finder->drives = 0;
    bool fine = basis && place_pairs(finder, places, classes, basis);
    for (int k = 0; k < m; k++) {
        double across = 0, along = 0;
        for (int i = half; i < finder->n; i++) {
            *(places[i] == EVEN ? &along : &across) += fabs(finder->by[i * m + k]);
        }
        finder->held[k] = across <= DEPENDENT * along;
    }
    for (int class = EVEN; class <= ODD && fine; class ++) {
        int count = 0;
        for (int k = class == EVEN ? -m : 0; k < half && fine; k++) {
            if (k < 0 ? !finder->held[m + k] : places[half + k] != (place) class) {
                continue;
            }
            for (int i = 0; i < m; i++) {
                row[i] = k < 0 ? i == m + k : finder->by[(half + k) * m + i];
            }
            if (count < m && add_row(basis, count, m, row)) {
                fine = add_drive(finder, basis + m * count++, (place) class, classes);
            }
        }
    }
    int count = 0;
    for (int k = 0; k < finder->m->slow_count; k++) {
        finder->held[finder->m->slow[k]] = true;
    }
    for (int k = 0; k < finder->drives && count < m && fine; k++) {
        count += add_row(basis, count, m, finder->column[k]);
    }
    for (int k = 0; k < m && count < m && fine; k++) {
        memset(row, 0, sizeof row);
        row[k] = 1;
        if (add_row(basis, count, m, row)) {
            fine = add_drive(finder, basis + m * count++, EVEN, classes);
        }
    }
    free(basis);
    return fine;
}

/* Inputs nearest to the middle of their ranges at which what changes its sign is 0. */
static void center_inputs(finder *finder, const place *classes)
{
    const int m = finder->m->inputs;
    double basis[SURROGATE_INPUTS_MAX * SURROGATE_INPUTS_MAX];
    int count = 0;
    memcpy(finder->to.input_center, finder->middle, (size_t)m * sizeof *finder->middle);
    for (int k = 0; k < finder->drives && count < m; k++) {
        if (classes[k] == EVEN || !add_row(basis, count, m, finder->column[k])) {
            continue;
        }
        const double *row = basis + m * count++;
        double dot = 0;
        for (int i = 0; i < m; i++) {
            dot += row[i] * finder->to.input_center[i];
        }
        for (int i = 0; i < m; i++) {
            finder->to.input_center[i] -= dot * row[i];
        }
    }
    memmove(finder->to.input_center + finder->all - m, finder->to.input_center,
            (size_t)m * sizeof *basis);
}

/* Of both ends of a step alike. */
static void place_all(finder *finder, const place *places, const place *classes)
{
    surrogate_step *m = finder->m;
    const int ends = m->ramps ? 2 : 1, given = m->inputs, own = finder->drives;
    int count[4] = {m->out_pairs, m->out_pairs, m->out_evens, m->out_odds};
    m->drives = ends * own;
    finder->to = surrogate_numbers_of(m, finder->numbers);
    memset(finder->to.input_map, 0,
           (size_t)(finder->all * m->drives) * sizeof *finder->to.input_map);
    for (int end = 0; end < ends; end++) {
        for (int k = 0; k < own; k++) {
            m->input_slot[end * own + k] = count[classes[k]]++;
            for (int i = 0; i < given; i++) {
                finder->to.input_map[(end * given + i) * m->drives + end * own + k] =
                    finder->column[k][i];
            }
        }
    }
    m->pairs = count[FIRST];
    m->evens = count[EVEN];
    m->odds = count[ODD];
    const int from[4] = {0, m->pairs, 2 * m->pairs, 2 * m->pairs + m->evens};
    for (int k = 0; k < finder->n; k++) {
        m->state_slot[k] += from[places[k]];
    }
    for (int k = 0; k < m->drives; k++) {
        m->input_slot[k] += from[classes[k % own]];
    }
    center_inputs(finder, classes);
}

/* ---- scales -------------------------------------------------------------------------------- */

static int partner(const surrogate_step *m, int slot)
{
    return slot < m->pairs ? slot + m->pairs : slot < 2 * m->pairs ? slot - m->pairs : slot;
}

/* Centers: rest for what changes its sign, else the mean; scales: what is usual over the steps. */
static void scale(finder *finder)
{
    surrogate_step *m = finder->m;
    const size_t count = finder->steps->count;
    const int n = finder->n, all = finder->all;
    double square[2 * SURROGATE_STATES_MAX + 2 * SURROGATE_INPUTS_MAX] = {0};
    double z[2 * SURROGATE_STATES_MAX + 2 * SURROGATE_INPUTS_MAX];
    for (int k = 0; k < n; k++) {
        const int slot = m->state_slot[k];
        const bool stays = slot >= 2 * m->pairs && slot < 2 * m->pairs + m->evens;
        double mean = 0;
        for (size_t i = 0; i < count; i++) {
            mean += finder->steps->state[i * (size_t)n + (size_t)k] / (double)count;
        }
        finder->to.state_center[k] = stays ? mean : finder->rest[k];
    }
    m->numbers = finder->numbers;
    for (size_t i = 0; i < count; i++) {
        surrogate_coordinates(m, finder->steps->state + i * (size_t)n,
                              finder->steps->input + i * (size_t)all, z);
        for (int k = 0; k < n + m->drives; k++) {
            square[k] += z[k] * z[k] / (double)count;
        }
    }
    double largest = 0; /* of states */
    for (int k = 0; k < n; k++) {
        largest = fmax(largest, sqrt(square[m->state_slot[k]]));
    }
    for (int k = 0; k < n + m->drives; k++) {
        const int slot = k < n ? m->state_slot[k] : m->input_slot[k - n];
        const double both = square[slot] + square[partner(m, slot)];
        const double usual = sqrt(both / 2);
        const double size = usual > (k < n ? EXCITATION_STAYS * largest : 0) ? usual : 1;
        if (k < n) {
            finder->to.state_scale[k] *= size;
        }
        for (int i = 0; i < all && k >= n; i++) {
            finder->to.input_map[i * m->drives + k - n] /= size;
        }
    }
    for (int k = 0; k < n; k++) {
        double most = 0;
        for (size_t i = 0; i < count; i++) {
            most = fmax(most, fabs(finder->steps->state[i * (size_t)n + (size_t)k] -
                                   finder->to.state_center[k]));
        }
        finder->to.state_range[k] = most > EXCITATION_STAYS * largest ? most : 1;
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

/* The rates of a state that is moved, with those inputs, moved back and scaled to `rate`, and the
 * coordinates of the inputs moved back, `drives`. */
static ad_status rate_of_moved(finder *finder, bool mirrors, double angle, const double *state,
                               const double *inputs, double *rate, double *drives)
{
    enum { MOST = 2 * SURROGATE_STATES_MAX + 2 * SURROGATE_INPUTS_MAX };
    const surrogate_step *m = finder->m;
    double z[MOST], moved[SURROGATE_STATES_MAX];
    const double back = mirrors ? angle : -angle; /* a mirror is its own inverse */
    surrogate_coordinates(m, state, inputs, z);
    move(m, mirrors, back, z);
    for (int k = 0; k < finder->drives; k++) {
        drives[k] = z[m->input_slot[k]];
    }
    surrogate_coordinates(m, state, inputs, z);
    move(m, mirrors, angle, z);
    for (int k = 0; k < finder->n; k++) {
        moved[k] = finder->to.state_center[k] + finder->to.state_scale[k] * z[m->state_slot[k]];
    }
    const ad_status status = reduced_rate(finder->rod, 0, moved, inputs, rate, NULL, NULL, NULL);
    for (int k = 0; k < finder->n; k++) {
        z[m->state_slot[k]] = rate[k] / finder->to.state_scale[k];
    }
    move(m, mirrors, back, z);
    for (int k = 0; k < finder->n; k++) {
        rate[k] = finder->to.state_scale[k] * z[m->state_slot[k]];
    }
    return status;
}

/* What copies [copies][n] of the rates of one state are off being affine in their inputs' drives
 * [copies][finder->drives]; adds squares of it and of the copies, of modes in their scales. */
static void add_misfit(const finder *finder, int copies, const double *rates, const double *drives,
                       double *basis, double *off, double *size)
{
    double *row = basis + copies * copies;
    int rank = 0;
    for (int k = -1; k < finder->drives; k++) {
        for (int j = 0; j < copies; j++) {
            row[j] = k < 0 ? 1 : drives[j * finder->drives + k];
        }
        rank += add_row(basis, rank, copies, row);
    }
    for (int k = 0; k < finder->n / 2; k++) {
        double all = 0, left = 0;
        for (int j = 0; j < copies; j++) {
            row[j] = rates[j * finder->n + k] / finder->to.state_scale[k];
            all += row[j] * row[j];
        }
        leave_out(basis, rank, copies, row);
        for (int j = 0; j < copies; j++) {
            left += row[j] * row[j];
        }
        *off += left * copies / (copies - rank);
        *size += all;
    }
}

/* by_state [n][n] row by row becomes 1 - h by_state, column by column, as LU factors take it. */
static void form_euler(int n, double h, double *matrix)
{
    for (int i = 0; i < n; i++) {
        matrix[i * (n + 1)] = 1 - h * matrix[i * (n + 1)];
        for (int j = 0; j < i; j++) {
            const double below = matrix[i * n + j];
            matrix[i * n + j] = -h * matrix[j * n + i];
            matrix[j * n + i] = -h * below;
        }
    }
}

/* By how much a symmetry is off, of what states change in a step: a state's rates, when it is moved
 * and they are moved back, are the same but for the inputs, in whose drives, moved back, they are
 * affine. Rates become changes in a step by Euler's implicit rule, linear, as stiff ones matter
 * little. Not a number: no rates were found. */
static double measure(finder *finder, const candidate *c)
{
    enum { TRIALS = 64 };
    const int n = finder->n, all = finder->all, copies = 2 * finder->drives + 4,
              given = finder->m->inputs;
    nn_rng random = nn_rng_split(1, "symmetry");
    double inputs[SURROGATE_INPUTS_MAX], off = 0, size = 0;
    const int room = n * (n + 1) + copies * (n + finder->drives + copies + 1);
    double *euler = calloc((size_t)room, sizeof *euler);
    double *rates = euler + n * n, *drives = rates + (copies + 1) * n;
    int *pivots = calloc((size_t)n + 1, sizeof *pivots);
    for (int t = 0; t < TRIALS && euler && pivots; t++) {
        const size_t i = (size_t)nn_rng_below(&random, finder->steps->count);
        const double *state = finder->steps->state + i * (size_t)n;
        const double *u = finder->steps->input + i * (size_t)all;
        bool fine = reduced_rate(finder->rod, 0, state, u, rates, euler, NULL, NULL) == AD_OK;
        form_euler(n, finder->m->step, euler);
        fine = fine && ad_dense_lu((size_t)n, euler, pivots) == 0;
        for (int j = 0; j < copies && fine; j++) {
            const bool mirrors = c->mirrors && nn_rng_uniform(&random) < 0.5;
            const double angle = c->turns ? 6.283185307179586 * nn_rng_uniform(&random) : 0;
            for (int k = 0; k < all; k++) {
                const scene_parameter *of = &finder->open->parameters[k % given];
                const double drawn = of->low + nn_rng_uniform(&random) * (of->high - of->low);
                inputs[k] = finder->held[k % given] ? u[k] : k < given ? drawn : inputs[k - given];
            }
            fine = rate_of_moved(finder, mirrors, angle, state, inputs, rates + j * n,
                                 drives + j * finder->drives) == AD_OK;
            ad_dense_lu_solve((size_t)n, 1, euler, pivots, rates + j * n);
        }
        if (fine) {
            add_misfit(finder, copies, rates, drives, drives + copies * finder->drives, &off,
                       &size);
        }
    }
    free(euler);
    free(pivots);
    return size > 0 ? sqrt(off / size) : NAN;
}

/* ---- the search ---------------------------------------------------------------------------- */

/* What the frame turns with: the bending without ends of higher degree, of all pieces. */
static void lead(finder *finder)
{
    const int half = finder->n / 2;
    memset(finder->to.lead, 0, (size_t)(finder->n + finder->m->drives) * sizeof *finder->to.lead);
    for (int k = 0; k < half; k++) {
        const reduced_mode mode = reduced_mode_of(finder->rod, k);
        if (mode.strain == 4 && mode.degree == 0) {
            finder->to.lead[finder->m->state_slot[k]] = 1;
        }
    }
}

static bool try_one(finder *finder, const candidate *c, double *off)
{
    place places[SURROGATE_STATES_MAX], classes[DRIVES_MAX] = {EVEN};
    surrogate_step *m = finder->m;
    m->turns = c->turns;
    m->mirrors = c->mirrors;
    m->pairs = m->evens = m->odds = 0;
    if (!place_states(finder, c, places) || !place_inputs(finder, places, classes)) {
        return false;
    }
    place_all(finder, places, classes);
    scale(finder);
    *off = c->turns || c->mirrors ? measure(finder, c) : 0;
    return *off <= MOST_OFF;
}

/* The robot at rest without its actuators, as far as their ranges go: even unequal ones leave it
 * straight. */
static ad_status rest(finder *finder, ad_error *error)
{
    double rate[SURROGATE_STATES_MAX], inputs[SURROGATE_INPUTS_MAX];
    scene_middle_values(finder->open, finder->middle);
    for (int i = 0; i < finder->m->inputs; i++) {
        const scene_parameter *of = &finder->open->parameters[i];
        inputs[i] = fmin(fmax(0, of->low), of->high);
    }
    for (int k = 0; k < finder->m->slow_count; k++) {
        inputs[finder->m->slow[k]] = finder->middle[finder->m->slow[k]];
    }
    const ad_status status = reduced_initial(finder->rod, inputs, finder->rest, error);
    if (status == AD_OK) { /* leaves the state where it finds none */
        (void)reduced_settle(finder->rod, 0, inputs, finder->rest, NULL);
    }
    return status == AD_OK
               ? reduced_rate(finder->rod, 0, finder->rest, inputs, rate, NULL, finder->by, error)
               : status;
}

ad_status surrogate_find_symmetry(reduced_rod *rod, const surrogate_settings *settings,
                                  const scene *open, const surrogate_steps *steps,
                                  surrogate_step *m, double **numbers, char text[256],
                                  ad_error *error)
{
    const int n = reduced_states(rod), inputs = reduced_inputs(rod);
    double by[SURROGATE_STATES_MAX * SURROGATE_INPUTS_MAX];
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
                .by = by,
                .all = m->ramps ? 2 * inputs : inputs};
    m->drives = (m->ramps ? 2 : 1) * DRIVES_MAX; /* the most */
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
