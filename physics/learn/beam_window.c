/* Moments of time: the state that a window hands on, and whether the ends agree with the one at the
 * beginning. */
#include "physics/beam/beam_internal.h"

#include <math.h>

/* w, w_t, psi, psi_t. */
static void beam_motion_of(const beam_context *beam, beam_state x, ad_value rows[4])
{
    rows[0] = x.deflection;
    rows[1] = beam_time_derivative(beam, x.deflection, 1);
    rows[2] = x.slope;
    rows[3] = beam_time_derivative(beam, x.slope, 1);
}

int beam_state_rows(const scene *beam_scene)
{
    bool turns = beam_turns(beam_scene);
    return !scene_is_dynamic(beam_scene) ? 0 : turns ? 4 : 2;
}

void beam_moving_state(const scene *beam_scene, const domain_place *at, beam_state state,
                       ad_value *rows)
{
    beam_context beam = beam_context_of(beam_scene, at);
    ad_value all[4];
    beam_motion_of(&beam, state, all);
    for (int i = 0; i < beam_state_rows(beam_scene); i++) {
        rows[i] = all[i];
    }
}

/* ---- ends against the initial state ---------------------------------------------------------- */

/* What the ends make of the initial state, less that state: w, w_t, psi, psi_t. A section without
 * inertia has no initial state; then instead of the last two the slope at the ends that hold it. */
static void beam_shifts(const beam_context *beam, ad_value rows[4])
{
    beam_initial initial = beam_initial_of(beam);
    ad_value still = ad_zeros(beam->tape, beam_network_outputs(beam->scene));
    beam_state state = beam_ansatz(beam->scene, &beam->at, still);
    beam_motion_of(beam, state, rows);
    for (int i = 0; i < 4; i++) {
        rows[i] = ad_substitute(rows[i], beam->t, ad_scalar(beam->tape, 0));
    }
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
    double places[BEAM_CHECKED], times[BEAM_CHECKED] = {0};
    ad_value s = ad_input(tape, "s", 1), t = ad_input(tape, "t", 1), rows[4];
    const domain_place at = rod_place(beam_scene, s, t);
    beam_context beam = beam_context_of(beam_scene, &at);
    beam_shifts(&beam, rows);
    for (int i = 0; i < BEAM_CHECKED; i++) {
        places[i] = (double)i / (BEAM_CHECKED - 1);
    }
    const ad_run run = {.points = BEAM_CHECKED,
                        .inputs = (const double *const[]){places, times},
                        .outputs = (double *const[]){values[0], values[1], values[2], values[3]},
                        .everywhere = true};
    const ad_status status = ad_evaluate(4, rows, NULL, &run, error);
    ad_tape_free(tape);
    return status;
}

ad_status beam_check(const scene *beam_scene, const char **key, ad_error *error)
{
    static const char *const turning[4] = {"beam.initial.deflection", "beam.initial.velocity",
                                           "beam.initial.slope", "beam.initial.slope_rate"};
    static const char *const bending[4] = {"beam.initial.deflection", "beam.initial.velocity",
                                           "beam.initial.deflection", "beam.initial.deflection"};
    bool turns = beam_turns(beam_scene);
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
