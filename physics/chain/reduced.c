#include "physics/chain/reduced_internal.h"

#include "autodiff/dense.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of a step: of order 5. */
enum { STAGES = 3 };

/* Of each place: position, turn, velocity, angular velocity. */
enum { OUTPUT_ROWS = 12 };

_Static_assert(offsetof(reduced_place, angular_velocity) == 10 * sizeof(double) &&
                   sizeof(reduced_place) == 13 * sizeof(double),
               "as kinematics.h has them");

/* ---- making -------------------------------------------------------------------------------- */

static bool end_depends_on(const scene_end *end, const char *name)
{
    const scene_hold hold = scene_hold_of(end);
    return (hold.directions > 0 && quantity_any_depends_on(3, end->position, name)) ||
           (scene_end_holds_rotation(end->type) &&
            (quantity_any_depends_on(4, end->rotation, name) ||
             quantity_any_depends_on(3, end->rotation_vector, name) ||
             quantity_depends_on(end->twist, name)));
}

/* Not the input that a drive follows, of which the angle is a mode. */
static void find_followed(reduced_rod *rod)
{
    const scene *open = &rod->open;
    for (int k = 0; k < open->parameter_count; k++) {
        const char *name = open->parameters[k].name;
        if (k != rod->m->turn.input &&
            (end_depends_on(&open->start, name) || end_depends_on(&open->end, name))) {
            rod->path.which |= UINT64_C(1) << k;
        }
    }
}

static ad_status create_model(reduced_rod *rod, const reduced_settings *settings, ad_error *error)
{
    const int *given = settings->modes;
    const bool is_given = given[0] + given[1] + given[2] + given[3] > 0;
    const modes_counts counts = is_given ? modes_counts_of(given[0], given[1], given[2], given[3])
                                         : modes_counts_of(3, 1, 2, 1);
    return modes_create_open(&rod->open, settings->follows, settings->staying, &counts, 0,
                             &rod->rod, &rod->m, error);
}

static ad_status place(reduced_rod *rod, const reduced_settings *settings, ad_error *error)
{
    const double length = rod->rod->scales.length;
    const size_t places = (size_t)settings->count;
    double *s = malloc((places + 1) * sizeof *s);
    int *rows = malloc((OUTPUT_ROWS * places + 1) * sizeof *rows);
    ad_status status = s && rows ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for places");
    rod->count = settings->count;
    for (int i = 0; i < rod->count && status == AD_OK; i++) {
        s[i] = settings->s[i] / length;
        for (int k = 0; k < OUTPUT_ROWS; k++) {
            rows[i * OUTPUT_ROWS + k] = i * KINEMATICS_ROWS + k;
        }
        if (!(s[i] >= 0 && s[i] <= 1 + 1e-12)) {
            status = ad_fail(error, AD_BAD_ARGUMENT, "s[%d] = %g; allowed: 0 to %g", i,
                             settings->s[i], length);
        }
    }
    if (status == AD_OK) {
        status = modes_places_create(rod->m, places, s, &rod->places, error);
    }
    if (status == AD_OK) {
        status = modes_kinematics_create(rod->m, rod->places, OUTPUT_ROWS * settings->count, rows,
                                         &rod->look, error);
    }
    free(s);
    free(rows);
    return status;
}

static ad_status allocate(reduced_rod *rod, ad_error *error)
{
    const modes *m = rod->m;
    const size_t n = (size_t)m->size, width = (size_t)m->width, inputs = (size_t)m->inputs;
    const size_t square = (n + QUAD) * width, states = (size_t)reduced_states(rod);
    const size_t moving = (size_t)m->end.first, memory = (size_t)rod->open.memory_count,
                 most = states + memory + inputs, rows = most + 2 * (n - moving);
    AD_TAKE(rod, unit, states);
    AD_TAKE(rod, q, n);
    AD_TAKE(rod, v, n);
    AD_TAKE(rod, a, n);
    AD_TAKE(rod, residual, n);
    AD_TAKE(rod, start, 3 * n);
    AD_TAKE(rod, by_q, square);
    AD_TAKE(rod, by_v, square);
    AD_TAKE(rod, by, rows * most);
    AD_TAKE(rod, mass, square);
    AD_TAKE(rod, room, collocation_along_room(rod->step, (int)memory, (int)most));
    AD_TAKE(rod, seen, KINEMATICS_SEEN * (size_t)rod->count);
    AD_TAKE(rod, look_room, kinematics_room(&rod->look));
    AD_TAKE(rod, along, most * most);
    AD_TAKE(rod, change[0], most * inputs);
    AD_TAKE(rod, change[1], most * inputs);
    AD_TAKE(rod, d, n);
    AD_TAKE(rod, branch_by, 2 * inputs * n);
    AD_TAKE(rod, pivots, n);
    AD_TAKE(rod, rates, 4 * inputs);
    if (rod->memory.is_short) {
        return ad_memory_status(&rod->memory, error, "out of memory for a reduced rod");
    }
    for (size_t k = 0; k < moving; k++) {
        const bool bends = m->mode[k].strain >= MODES_U && k >= (size_t)m->hinges;
        rod->unit[k] = bends ? 1 / rod->rod->scales.length : 1;
        rod->unit[moving + k] = rod->unit[k] / rod->rod->scales.time;
    }
    for (int k = 0; k < m->branch.count; k++) {
        rod->unit[2 * moving + (size_t)k] = rod->unit[m->branch.mode[k]];
    }
    return AD_OK;
}

ad_status reduced_create(const scene *rod_scene, const reduced_settings *settings,
                         reduced_rod **result, ad_error *error)
{
    reduced_rod *rod = calloc(1, sizeof *rod);
    *result = NULL;
    if (!rod) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a reduced rod");
    }
    rod->open = *rod_scene;
    if (rod_scene->memory_count > 0) {
        rod->values = scene_values_of(rod_scene);
    }
    rod->newton = settings->newton > 0 ? settings->newton : 1e-5; /* errors of a step are larger */
    ad_status status = create_model(rod, settings, error);
    status = status == AD_OK ? collocation_create(rod->m, STAGES, &rod->step, error) : status;
    status = status == AD_OK ? place(rod, settings, error) : status;
    status = status == AD_OK ? allocate(rod, error) : status;
    if (status != AD_OK) {
        reduced_free(rod);
        return status;
    }
    find_followed(rod);
    *result = rod;
    return AD_OK;
}

void reduced_free(reduced_rod *rod)
{
    if (rod) {
        modes_kinematics_free(&rod->look);
        modes_places_free(rod->places);
        collocation_free(rod->step);
        modes_free(rod->m);
        solve_rod_free(rod->rod);
        ad_memory_free(&rod->memory);
        free(rod);
    }
}

int reduced_modes(const reduced_rod *rod)
{
    return rod->m->end.first;
}

int reduced_states(const reduced_rod *rod)
{
    return 2 * reduced_modes(rod) + rod->m->branch.count;
}

int reduced_inputs(const reduced_rod *rod)
{
    return rod->m->inputs;
}

const scene_parameter *reduced_input(const reduced_rod *rod, int i)
{
    return &rod->open.parameters[i];
}

reduced_mode reduced_mode_of(const reduced_rod *rod, int k)
{
    const modes *m = rod->m;
    const int n = reduced_modes(rod), which = k < 2 * n ? k % n : m->branch.mode[k - 2 * n];
    const modes_mode *mode = &m->mode[which];
    return (reduced_mode){which < m->hinges ? -1 : mode->strain, mode->degree, mode->first_element};
}

/* ---- inputs that ends follow --------------------------------------------------------------- */

uint64_t reduced_followed(const reduced_rod *rod)
{
    return rod->path.which;
}

void reduced_follow(reduced_rod *rod, const double *before, const double *after)
{
    const int count = rod->m->inputs;
    const double time = rod->rod->scales.time;
    double *now = rod->rates, *sides = now + 2 * count;
    for (int k = 0; k < count; k++) {
        const bool follows = before && (rod->path.which >> k & 1);
        now[k] = sides[k] = follows ? before[k] * time : 0;
        sides[count + k] = follows ? after[k] * time : 0;
    }
    rod->m->unasked = before ? rod->path.which : 0;
    rod->path.before = sides;
    rod->path.after = sides + count;
    modes_move(rod->m, before ? now : NULL);
    collocation_follow(rod->step, before ? &rod->path : NULL);
}

/* ---- states -------------------------------------------------------------------------------- */

void reduced_take_state(reduced_rod *rod, const double *state)
{
    const int n = reduced_modes(rod);
    for (int k = 0; k < n; k++) {
        rod->q[k] = state[k] / rod->unit[k];
        rod->v[k] = state[n + k] / rod->unit[n + k];
    }
    for (int k = 0; k < rod->m->branch.count; k++) {
        rod->d[rod->m->branch.mode[k]] = state[2 * n + k] / rod->unit[2 * n + k];
    }
}

void reduced_give_state(const reduced_rod *rod, double *state)
{
    const int n = reduced_modes(rod);
    for (int k = 0; k < n; k++) {
        state[k] = rod->q[k] * rod->unit[k];
        state[n + k] = rod->v[k] * rod->unit[n + k];
    }
    for (int k = 0; k < rod->m->branch.count; k++) {
        state[2 * n + k] = rod->d[rod->m->branch.mode[k]] * rod->unit[2 * n + k];
    }
}

/* The same where springs of branches have relaxed. */
static void give_relaxed(reduced_rod *rod, double *state)
{
    memset(rod->d, 0, (size_t)rod->m->size * sizeof *rod->d);
    reduced_give_state(rod, state);
}

/* The model at a time and inputs, with the state in rod->q, rod->v. */
static ad_status go_to(reduced_rod *rod, double t, const double *state, const double *inputs,
                       ad_error *error)
{
    reduced_take_state(rod, state);
    modes_move(rod->m, rod->rates);
    return modes_at(rod->m, t / rod->rod->scales.time, inputs, error);
}

ad_status reduced_initial(reduced_rod *rod, const double *inputs, double *state, ad_error *error)
{
    const modes_linear room = {rod->q,    rod->v,    rod->a,    rod->residual,
                               rod->by_q, rod->by_v, rod->mass, rod->pivots};
    const ad_status status = modes_begin_open(rod->m, &rod->open, inputs, rod->rates, &room, error);
    if (status == AD_OK) {
        give_relaxed(rod, state);
    }
    return status;
}

ad_status reduced_settle(reduced_rod *rod, double t, const double *inputs, double *state,
                         ad_error *error)
{
    const modes_linear room = {rod->q,    rod->v,    rod->a,    rod->residual,
                               rod->by_q, rod->by_v, rod->mass, rod->pivots};
    ad_status status = go_to(rod, t, state, inputs, error);
    status = status == AD_OK ? modes_settle(rod->m, &room, error) : status;
    if (status == AD_OK) {
        give_relaxed(rod, state);
    }
    return status;
}

/* ---- rates --------------------------------------------------------------------------------- */

/* Of row r of the residual, with accelerations held: by the state, then by inputs. */
static double residual_by(const reduced_rod *rod, int r, int c)
{
    const modes *m = rod->m;
    const int n = m->size, states = reduced_states(rod), at = r * m->width;
    return c < n        ? rod->by_q[at + c]
           : c < 2 * n  ? rod->by_v[at + c - n]
           : c < states ? m->branch.by[at + m->branch.mode[c - 2 * n]]
                        : rod->room[r * m->inputs + c - states];
}

/* rod->by [.][states + inputs]: derivatives of the accelerations by the state, and inputs where
 * these are wanted, in the model's units. */
static ad_status differentiate(reduced_rod *rod, double t, bool by_inputs, ad_error *error)
{
    modes *m = rod->m;
    const int n = m->size, width = m->width, columns = reduced_states(rod) + m->inputs;
    const int wanted = by_inputs ? columns : reduced_states(rod);
    ad_status status = AD_OK;
    memcpy(rod->mass, m->mass, (size_t)(n * width) * sizeof *rod->mass); /* its factor */
    modes_linearise(m, rod->q, rod->v, rod->a, rod->residual, rod->by_q, rod->by_v);
    for (int i = 0; i < MODES_DRIVES; i++) { /* whose accelerations move the others */
        const int driven = modes_driven(m, i);
        for (int r = 0; r < n; r++) {
            rod->start[i * n + r] = driven < 0 || r == driven ? 0 : m->mass[r * width + driven];
        }
    }
    if (by_inputs) {
        status =
            modes_by_inputs(m, t / rod->rod->scales.time, rod->q, rod->v, rod->a, rod->room, error);
    }
    for (int c = 0; c < wanted; c++) {
        for (int r = 0; r < n; r++) {
            rod->residual[r] = -residual_by(rod, r, c);
        }
        for (int i = 0; i < MODES_DRIVES; i++) {
            const int driven = modes_driven(m, i);
            for (int r = 0; r < n && driven >= 0; r++) {
                rod->residual[r] -= rod->start[i * n + r] * rod->residual[driven];
            }
        }
        modes_solve_factored(m, rod->mass, rod->residual);
        for (int r = 0; r < n; r++) {
            rod->by[r * columns + c] = rod->residual[r];
        }
    }
    return status;
}

/* The rates of stretches of branches, behind those of modes. */
static ad_status branch_rate(reduced_rod *rod, double t, double *rate, double *by_state,
                             double *by_inputs, ad_error *error)
{
    modes *m = rod->m;
    const int n = m->size, states = reduced_states(rod), count = m->inputs;
    const double time = rod->rod->scales.time;
    double *rate_by = rod->branch_by, *rest_by = rate_by + count * n;
    const ad_status status = by_inputs && m->branch.count > 0
                                 ? modes_branch_by_inputs(m, t / time, rate_by, rest_by, error)
                                 : AD_OK;
    for (int b = 0; b < m->branch.count && status == AD_OK; b++) {
        const int k = m->branch.mode[b], r = 2 * n + b;
        const double unit = rod->unit[r] / time, d = rod->d[k];
        rate[r] = (rod->v[k] + m->branch.rest_rate[k] - m->branch.rate[k] * d) * unit;
        for (int c = 0; c < states && by_state; c++) {
            by_state[r * states + c] = c == n + k ? 1 : c == r ? -m->branch.rate[k] / time : 0;
        }
        for (int c = 0; c < count && by_inputs; c++) {
            by_inputs[r * count + c] = (rest_by[c * n + k] - rate_by[c * n + k] * d) * unit;
        }
    }
    return status;
}

ad_status reduced_rate(reduced_rod *rod, double t, const double *state, const double *inputs,
                       double *rate, double *by_state, double *by_inputs, ad_error *error)
{
    const int n = rod->m->size, states = reduced_states(rod), count = rod->m->inputs;
    const int wanted = states + count;
    const double time = rod->rod->scales.time;
    ad_status status = rod->m->end.count > 0
                           ? ad_fail(error, AD_BAD_ARGUMENT,
                                     "rates of a reduced rod whose end is held are not built; "
                                     "allowed: steps")
                           : go_to(rod, t, state, inputs, error);
    modes_stretch(rod->m, rod->d);
    if (status == AD_OK && !modes_accelerations(rod->m, rod->q, rod->v, rod->a)) {
        status = modes_accelerations_fail(rod->m, error);
    }
    if (status == AD_OK && (by_state || by_inputs)) {
        status = differentiate(rod, t, by_inputs != NULL, error);
    }
    status = status == AD_OK ? branch_rate(rod, t, rate, by_state, by_inputs, error) : status;
    for (int r = 0; r < n && status == AD_OK; r++) {
        const double unit = rod->unit[n + r] / time;
        rate[r] = rod->v[r] * rod->unit[n + r];
        rate[n + r] = rod->a[r] * unit;
        for (int c = 0; c < states && by_state; c++) {
            by_state[r * states + c] = c == n + r;
            by_state[(n + r) * states + c] = rod->by[r * wanted + c] * unit / rod->unit[c];
        }
        for (int c = 0; c < count && by_inputs; c++) {
            by_inputs[r * count + c] = 0;
            by_inputs[(n + r) * count + c] = rod->by[r * wanted + states + c] * unit;
        }
    }
    return status;
}

/* ---- what is seen -------------------------------------------------------------------------- */

ad_status reduced_output(reduced_rod *rod, double t, const double *state, const double *inputs,
                         reduced_place *places, double *by_state, ad_error *error)
{
    modes_move(rod->m, rod->rates);
    ad_status status = modes_at(rod->m, t / rod->rod->scales.time, inputs, error);
    if (status != AD_OK) {
        return status;
    }
    modes_kinematics_start(rod->m, rod->places, &rod->look);
    kinematics_see(&rod->look, 1, state, rod->seen, by_state, rod->look_room);
    for (int i = 0; i < rod->count; i++) {
        memcpy(&places[i], rod->seen + i * KINEMATICS_SEEN, sizeof places[i]);
    }
    return AD_OK;
}

const kinematics *reduced_kinematics(const reduced_rod *rod)
{
    return &rod->look;
}

bool reduced_is_placed(const reduced_rod *rod)
{
    const solve_part_kind kind = solve_rod_part_kind(rod->rod, SOLVE_START);
    return !kind.by_t && (!kind.by_parameters || rod->m->turn.mode >= 0) && !rod->m->origin_moves;
}
