/* From raw network outputs to a beam that meets its ends and its initial state by construction. */
#include "physics/beam/beam_internal.h"
#include "physics/learn/window_state.h"

#include <math.h>

int beam_network_outputs(const scene *beam_scene)
{
    bool mixed = beam_scene->formulation == SCENE_MIXED;
    return mixed ? 4 : beam_scene->rod.model == SCENE_TIMOSHENKO ? 2 : 1;
}

static bool beam_starts_hard(const beam_context *beam)
{
    return beam->dynamic && beam->scene->initial_enforcement == SCENE_HARD;
}

/* ---- ends ------------------------------------------------------------------------------------ */

/* d^order field / ds^order = value at an end, 0 or 1. */
typedef struct beam_condition {
    int end, order;
    ad_value value;
} beam_condition;

enum { CONDITIONS_MAX = 4, DEGREES = 8, WIDTH = DEGREES + CONDITIONS_MAX };

/* d^order s^degree / ds^order at an end */
static double beam_power_at(int degree, int order, int end)
{
    double factor = 1;
    for (int k = 0; k < order; k++) {
        factor *= degree - k;
    }
    return end == 1 || degree == order ? factor : 0;
}

/* Exchange rows so that the largest entry of `column` from row `first` on is in that row. */
static double beam_pivot(double (*rows)[WIDTH], int first, int count, int column)
{
    int best = first;
    for (int i = first + 1; i < count; i++) {
        best = fabs(rows[i][column]) > fabs(rows[best][column]) ? i : best;
    }
    for (int k = 0; k < WIDTH; k++) {
        double other = rows[first][k];
        rows[first][k] = rows[best][k];
        rows[best][k] = other;
    }
    return rows[first][column];
}

/* Polynomials p_i = sum_d dual[i][d] s^d that meet condition i with the value 1 and the others with
 * 0, made of the lowest powers that can: Gauss-Jordan elimination of the conditions on powers,
 * columns in the order of the degree, the unit matrix beside them. */
static void beam_dual(int count, const beam_condition *conditions,
                      double dual[CONDITIONS_MAX][DEGREES])
{
    double rows[CONDITIONS_MAX][WIDTH] = {{0}};
    for (int i = 0; i < count; i++) {
        for (int d = 0; d < DEGREES; d++) {
            rows[i][d] = beam_power_at(d, conditions[i].order, conditions[i].end);
            dual[i][d] = 0;
        }
        rows[i][DEGREES + i] = 1;
    }
    int done = 0, degrees[CONDITIONS_MAX];
    for (int d = 0; d < DEGREES && done < count; d++) {
        double pivot = beam_pivot(rows, done, count, d);
        if (fabs(pivot) < 1e-9) { /* rounding: the entries are integers and their quotients */
            continue;
        }
        for (int k = 0; k < WIDTH; k++) {
            rows[done][k] /= pivot;
        }
        for (int i = 0; i < count; i++) {
            double factor = i == done ? 0 : rows[i][d];
            for (int k = 0; k < WIDTH; k++) {
                rows[i][k] -= factor * rows[done][k];
            }
        }
        degrees[done++] = d;
    }
    for (int r = 0; r < done; r++) {
        for (int i = 0; i < count; i++) {
            dual[i][degrees[r]] = rows[r][DEGREES + i];
        }
    }
}

/* The field with the polynomial added that makes the conditions hold. */
static ad_value beam_meet(const beam_context *beam, ad_value field, int count,
                          const beam_condition *conditions)
{
    double dual[CONDITIONS_MAX][DEGREES];
    ad_value powers[DEGREES] = {ad_scalar(beam->tape, 1)}, met = field;
    for (int d = 1; d < DEGREES; d++) {
        powers[d] = ad_mul(powers[d - 1], beam->s);
    }
    beam_dual(count, conditions, dual);
    for (int i = 0; i < count; i++) {
        const beam_condition *c = &conditions[i];
        ad_value found = ad_substitute(beam_space_derivative(beam, field, c->order), beam->s,
                                       ad_scalar(beam->tape, c->end));
        ad_value polynomial = ad_scalar(beam->tape, 0);
        for (int d = 0; d < DEGREES; d++) {
            polynomial = ad_add(polynomial, ad_scale(powers[d], dual[i][d]));
        }
        met = ad_add(met, ad_mul(polynomial, ad_sub(c->value, found)));
    }
    return met;
}

/* ---- time ------------------------------------------------------------------------------------ */

/* value and rate at the start of the window, all of it and the part that goes on. */
typedef struct beam_start {
    ad_value value, rate, going, going_rate;
} beam_start;

static void beam_starts(const beam_context *beam, beam_start *deflection, beam_start *slope)
{
    if (!beam->at.goes_on) {
        beam_initial initial = beam_initial_of(beam);
        *deflection = (beam_start){.value = initial.deflection, .rate = initial.velocity};
        *slope = (beam_start){.value = initial.slope, .rate = initial.slope_rate};
        return;
    }
    int rows = beam->rotary_inertia > 0 ? 4 : 2;
    ad_value all = window_state_state(&beam->at, rows, false),
             part = window_state_state(&beam->at, rows, true);
    beam_start *fields[2] = {deflection, slope};
    *slope = (beam_start){.value = ad_scalar(beam->tape, 0)}; /* not read without inertia */
    for (int i = 0; i < rows / 2; i++) {
        *fields[i] = (beam_start){ad_row(all, 2 * i), ad_row(all, 2 * i + 1), ad_row(part, 2 * i),
                                  ad_row(part, 2 * i + 1)};
    }
}

/* The field that starts like this, and goes on as the network says, like that of a rod. */
static ad_value beam_begin(const beam_context *beam, const beam_start *start, ad_value network)
{
    ad_value one = ad_scalar(beam->tape, 1);
    ad_value t = domain_elapsed(&beam->domain, &beam->at);
    ad_value x = ad_mul(t, ad_reciprocal(beam->at.span)), moved = ad_mul(ad_square(x), network);
    if (!beam->at.goes_on) {
        return ad_add(ad_add(start->value, ad_mul(t, start->rate)), moved);
    }
    ad_value left = ad_square(ad_sub(one, x));
    ad_value keep = ad_mul(left, ad_add(one, ad_scale(x, 2)));
    ad_value push = ad_mul(ad_mul(x, left), beam->at.span);
    ad_value drift = ad_add(start->going, ad_mul(t, start->going_rate));
    ad_value rest = ad_add(ad_mul(keep, ad_sub(start->value, start->going)),
                           ad_mul(push, ad_sub(start->rate, start->going_rate)));
    return ad_add(ad_add(drift, rest), moved);
}

/* ---- states ---------------------------------------------------------------------------------- */

/* What the two ends give of one field of the mixed form; nothing where ends are soft. */
typedef struct beam_given {
    bool given[2];
    ad_value value[2];
} beam_given;

/* fields [4]: w, psi, V, M */
static void beam_given_of(const beam_context *beam, beam_given fields[4])
{
    bool hard = beam->scene->boundary_enforcement == SCENE_HARD;
    for (int i = 0; i <= 1; i++) {
        beam_end end = beam_end_of(beam, i);
        const bool given[4] = {end.holds_deflection, end.holds_slope, !end.holds_deflection,
                               !end.holds_slope};
        const ad_value values[4] = {end.deflection, end.slope, end.shear, end.moment};
        for (int k = 0; k < 4; k++) {
            fields[k].given[i] = hard && given[k];
            fields[k].value[i] = values[k];
        }
    }
}

/* Times s, 1 - s or both: 0 where an end gives the field, so that the network itself need not be
 * evaluated there. */
static ad_value beam_vanish(const beam_context *beam, ad_value network, const beam_given *ends)
{
    network = ends->given[0] ? ad_mul(domain_vanish(&beam->at, 0), network) : network;
    return ends->given[1] ? ad_mul(domain_vanish(&beam->at, 1), network) : network;
}

static ad_value beam_hold(const beam_context *beam, ad_value field, const beam_given *ends)
{
    beam_condition conditions[2];
    int count = 0;
    for (int i = 0; i <= 1; i++) {
        if (ends->given[i]) {
            conditions[count++] = (beam_condition){i, 0, ends->value[i]};
        }
    }
    return beam_meet(beam, field, count, conditions);
}

/* A field that falls by `value` within the beam beyond s. */
static ad_value beam_drop(const beam_context *beam, ad_value field, double s, ad_value value)
{
    ad_value zero = ad_scalar(beam->tape, 0), past = ad_sub(beam->s, ad_scalar(beam->tape, s));
    return s > 0 && s < 1 ? ad_sub(field, ad_select(past, value, zero)) : field;
}

/* V and M of a field whose ends have the values beyond what acts there: at s = 0 it begins behind
 * that, at s = 1 it ends before. */
static ad_value beam_inside(const beam_context *beam, ad_value field, double s, ad_value value)
{
    ad_value rest = ad_sub(ad_scalar(beam->tape, 1), beam->s);
    return s <= 0   ? ad_sub(field, ad_mul(rest, value))
           : s >= 1 ? ad_add(field, ad_mul(beam->s, value))
                    : field;
}

static beam_state beam_mixed_state(const beam_context *beam, const ad_value *fields,
                                   const beam_given *ends)
{
    beam_state x = {.deflection = beam_hold(beam, fields[0], &ends[0]),
                    .slope = beam_hold(beam, fields[1], &ends[1]),
                    .shear = fields[2],
                    .moment = fields[3]};
    beam_force_at acting[BEAM_PLACES_MAX];
    int count = beam_forces_at(beam, x.deflection, x.slope, acting);
    for (int i = 0; i < count; i++) {
        x.shear = beam_drop(beam, x.shear, acting[i].s, acting[i].force);
        x.moment = beam_drop(beam, x.moment, acting[i].s, acting[i].moment);
    }
    x.shear = beam_hold(beam, x.shear, &ends[2]);
    x.moment = beam_hold(beam, x.moment, &ends[3]);
    for (int i = 0; i < count; i++) {
        x.shear = beam_inside(beam, x.shear, acting[i].s, acting[i].force);
        x.moment = beam_inside(beam, x.moment, acting[i].s, acting[i].moment);
    }
    return x;
}

/* w_sss where the end gives shear and moment: -(V + mu) = EI_s w_ss + EI w_sss, w_ss = M/EI. */
static beam_condition beam_sheared(const beam_context *beam, const beam_end *end, int at)
{
    ad_value mu = beam_there(beam, beam_line_moment(beam), at);
    ad_value softness = beam_there(beam, beam->softness, at);
    ad_value slope = beam_there(beam, beam_space_derivative(beam, beam->bending, 1), at);
    ad_value turned = ad_mul(slope, ad_mul(softness, end->moment));
    ad_value bent = ad_neg(ad_add(ad_add(end->shear, mu), turned));
    return (beam_condition){at, 3, ad_mul(softness, bent)};
}

/* w alone: psi = w_s, M = EI w_ss, V = -(M_s + mu). An end that gives the shear gives the moment.
 */
static beam_state beam_bending_state(const beam_context *beam, ad_value w)
{
    beam_condition conditions[4];
    bool hard = beam->scene->boundary_enforcement == SCENE_HARD;
    for (int i = 0; i <= 1; i++) {
        beam_end end = beam_end_of(beam, i);
        ad_value bent = ad_mul(beam_there(beam, beam->softness, i), end.moment);
        conditions[2 * i] = end.holds_deflection ? (beam_condition){i, 0, end.deflection}
                                                 : beam_sheared(beam, &end, i);
        conditions[2 * i + 1] =
            end.holds_slope ? (beam_condition){i, 1, end.slope} : (beam_condition){i, 2, bent};
    }
    w = beam_meet(beam, w, hard ? 4 : 0, conditions);
    return (beam_state){.deflection = w,
                        .slope = beam_space_derivative(beam, w, 1),
                        .shear = ad_neg(ad_add(beam_bent(beam, w, 1), beam_line_moment(beam))),
                        .moment = beam_bent(beam, w, 0)};
}

/* w and psi: M = EI psi_s, V = kGA (w_s - psi). */
static beam_state beam_shearing_state(const beam_context *beam, ad_value w, ad_value psi)
{
    beam_condition conditions[2];
    beam_end ends[2] = {beam_end_of(beam, 0), beam_end_of(beam, 1)};
    int count = beam->scene->boundary_enforcement == SCENE_HARD ? 2 : 0;
    for (int i = 0; i <= 1; i++) {
        ad_value bent = ad_mul(beam_there(beam, beam->softness, i), ends[i].moment);
        conditions[i] = ends[i].holds_slope ? (beam_condition){i, 0, ends[i].slope}
                                            : (beam_condition){i, 1, bent};
    }
    psi = beam_meet(beam, psi, count, conditions);
    for (int i = 0; i <= 1; i++) {
        ad_value there = beam_there(beam, psi, i);
        ad_value sheared = ad_mul(beam_there(beam, beam->shear_compliance, i), ends[i].shear);
        conditions[i] = ends[i].holds_deflection ? (beam_condition){i, 0, ends[i].deflection}
                                                 : (beam_condition){i, 1, ad_add(there, sheared)};
    }
    w = beam_meet(beam, w, count, conditions);
    ad_value shear = ad_sub(beam_space_derivative(beam, w, 1), psi);
    return (beam_state){.deflection = w,
                        .slope = psi,
                        .shear = ad_mul(ad_reciprocal(beam->shear_compliance), shear),
                        .moment = ad_mul(beam->bending, beam_space_derivative(beam, psi, 1))};
}

static beam_state beam_fields(const beam_context *beam, ad_value outputs)
{
    ad_value fields[4];
    beam_given ends[4];
    int count = beam_network_outputs(beam->scene);
    beam_given_of(beam, ends);
    for (int i = 0; i < count; i++) {
        fields[i] = beam_vanish(beam, ad_row(outputs, i), &ends[i]);
    }
    if (count == 1) {
        fields[0] = beam_vanish(beam, fields[0], &ends[1]); /* with its slope */
    }
    if (beam_starts_hard(beam)) {
        beam_start deflection, slope;
        beam_starts(beam, &deflection, &slope);
        fields[0] = beam_begin(beam, &deflection, fields[0]);
        if (beam->rotary_inertia > 0) {
            fields[1] = beam_begin(beam, &slope, fields[1]);
        }
    }
    return beam->mixed  ? beam_mixed_state(beam, fields, ends)
           : count == 2 ? beam_shearing_state(beam, fields[0], fields[1])
                        : beam_bending_state(beam, fields[0]);
}

beam_state beam_ansatz(const scene *beam_scene, const domain_place *at, ad_value outputs)
{
    beam_context beam = beam_context_of(beam_scene, at);
    int rows = beam_network_outputs(beam_scene);
    if (ad_is_valid(outputs) && ad_rows(outputs) != rows) {
        ad_tape_fail(at->tape, AD_BAD_SHAPE, "the network has %d outputs, %d are needed",
                     ad_rows(outputs), rows);
    }
    return beam_fields(&beam, outputs);
}
