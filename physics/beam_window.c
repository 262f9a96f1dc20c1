/* Moments of time: the state that a window hands on, and whether the ends agree with the one at the
 * beginning. */
#include "physics/beam_internal.h"
#include "physics/chebyshev.h"

#include <math.h>

/* w, w_t, psi, psi_t at one dimensionless time, functions of s. */
static void beam_at_time(const beam_context *beam, rod_state x, double time, ad_value rows[4])
{
    const ad_value moving[4] = {x.position, beam_time_derivative(beam, x.position, 1), x.rotation,
                                beam_time_derivative(beam, x.rotation, 1)};
    for (int i = 0; i < 4; i++) {
        rows[i] = ad_substitute(moving[i], beam->t, ad_scalar(beam->tape, time));
    }
}

ad_status beam_window_end(const scene *beam_scene, const rod_window *window, const nn_mlp *mlp,
                          const double *x, ad_pool *pool, double *end, ad_error *error)
{
    ad_tape *tape = ad_tape_create();
    if (!tape) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a tape");
    }
    ad_value s = ad_input(tape, "s", 1), t = ad_input(tape, "t", 1), rows[4];
    beam_context beam = beam_in_window(beam_scene, window, s, t);
    ad_value outputs = nn_mlp_record(mlp, rod_network_input(beam_scene, window, s, t), 0);
    rod_state state = beam_ansatz(beam_scene, window, outputs, s, t);
    beam_at_time(&beam, state, beam.start + beam.span, rows);
    ad_status status = chebyshev_sample(beam.rotary_inertia > 0 ? 4 : 2, rows, x, pool, end, error);
    ad_tape_free(tape);
    return status;
}

/* ---- ends against the initial state ---------------------------------------------------------- */

/* What the ends make of the initial state, less that state: w, w_t, psi, psi_t. A section without
 * inertia has no initial state; then instead of the last two the slope at the ends that hold it. */
static void beam_shifts(const beam_context *beam, ad_value rows[4])
{
    beam_initial initial = beam_initial_of(beam);
    ad_value still = ad_zeros(beam->tape, beam_network_outputs(beam->scene));
    rod_state state = beam_ansatz(beam->scene, NULL, still, beam->s, beam->t);
    beam_at_time(beam, state, 0, rows);
    rows[0] = ad_sub(rows[0], initial.deflection);
    rows[1] = ad_sub(rows[1], initial.velocity);
    rows[2] = ad_sub(rows[2], initial.slope);
    rows[3] = ad_sub(rows[3], initial.slope_rate);
    for (int i = 0; i <= 1 && beam->rotary_inertia == 0; i++) {
        ad_value there = ad_substitute(initial.slope, beam->s, ad_scalar(beam->tape, i));
        rows[2 + i] = beam_end_of(beam, i).holds_slope ? there : ad_scalar(beam->tape, 0);
    }
}

/* The same as numbers [4][BEAM_CHECKED] at points along the beam. */
enum { BEAM_CHECKED = 9 };

static ad_status beam_shift(const scene *beam_scene, double values[4][BEAM_CHECKED],
                            ad_error *error)
{
    ad_tape *tape = ad_tape_create();
    ad_pool *pool = ad_pool_create(1);
    ad_program *program = NULL;
    double places[BEAM_CHECKED], times[BEAM_CHECKED] = {0};
    ad_status status = tape && pool ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    if (status == AD_OK) {
        ad_value s = ad_input(tape, "s", 1), t = ad_input(tape, "t", 1), rows[4];
        beam_context beam = beam_in_window(beam_scene, NULL, s, t);
        beam_shifts(&beam, rows);
        status = ad_compile(4, rows, NULL, pool, &program, error);
    }
    for (int i = 0; i < BEAM_CHECKED; i++) {
        places[i] = (double)i / (BEAM_CHECKED - 1);
    }
    if (status == AD_OK) {
        ad_run run = {.points = BEAM_CHECKED,
                      .inputs = (const double *const[]){places, times},
                      .outputs = (double *const[]){values[0], values[1], values[2], values[3]}};
        status = ad_execute(program, &run, error);
    }
    ad_program_free(program);
    ad_pool_free(pool);
    ad_tape_free(tape);
    return status;
}

ad_status beam_check(const scene *beam_scene, const char **key, ad_error *error)
{
    static const char *const turning[4] = {"beam.initial.deflection", "beam.initial.velocity",
                                           "beam.initial.slope", "beam.initial.slope_rate"};
    static const char *const bending[4] = {"beam.initial.deflection", "beam.initial.velocity",
                                           "beam.initial.deflection", "beam.initial.deflection"};
    bool turns = scene_properties_of(beam_scene).rotary_inertia[0] > 0;
    static const double SHIFT = 1e-8; /* of the scale; well above rounding */
    double values[4][BEAM_CHECKED] = {{0}};
    if (!scene_is_dynamic(beam_scene) || beam_scene->initial_enforcement == SCENE_SOFT ||
        beam_scene->boundary_enforcement == SCENE_SOFT) {
        return AD_OK;
    }
    ad_status status = beam_shift(beam_scene, values, error);
    for (int row = 0; row < 4 && status == AD_OK; row++) {
        for (int i = 0; i < BEAM_CHECKED && status == AD_OK; i++) {
            if (!(fabs(values[row][i]) <= SHIFT)) {
                if (key) {
                    *key = (turns ? turning : bending)[row];
                }
                status = ad_fail(error, AD_BAD_INPUT,
                                 "does not meet the ends at t = 0; allowed: a state that does%s, "
                                 "or enforcement.initial soft",
                                 beam_scene->formulation == SCENE_MIXED
                                     ? ""
                                     : ", of moment and shear too; formulation mixed, where only "
                                       "held ends count");
            }
        }
    }
    return status;
}
