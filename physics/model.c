#include "physics/model.h"
#include "physics/beam.h"

/* One row per observable of a rod: name and unit of the column, member of rod_observables, its row,
 * whether only motion has it. */
#define ROD_COLUMN_LIST(X)                                                                         \
    X("x", "m", position, 0, false)                                                                \
    X("y", "m", position, 1, false)                                                                \
    X("z", "m", position, 2, false)                                                                \
    X("qw", "", rotation, 0, false)                                                                \
    X("qx", "", rotation, 1, false)                                                                \
    X("qy", "", rotation, 2, false)                                                                \
    X("qz", "", rotation, 3, false)                                                                \
    X("v1", "", strain, 0, false)                                                                  \
    X("v2", "", strain, 1, false)                                                                  \
    X("v3", "", strain, 2, false)                                                                  \
    X("u1", "1/m", curvature, 0, false)                                                            \
    X("u2", "1/m", curvature, 1, false)                                                            \
    X("u3", "1/m", curvature, 2, false)                                                            \
    X("n1", "N", force, 0, false)                                                                  \
    X("n2", "N", force, 1, false)                                                                  \
    X("n3", "N", force, 2, false)                                                                  \
    X("m1", "N m", moment, 0, false)                                                               \
    X("m2", "N m", moment, 1, false)                                                               \
    X("m3", "N m", moment, 2, false)                                                               \
    X("vx", "m/s", velocity, 0, true)                                                              \
    X("vy", "m/s", velocity, 1, true)                                                              \
    X("vz", "m/s", velocity, 2, true)                                                              \
    X("w1", "1/s", angular_velocity, 0, true)                                                      \
    X("w2", "1/s", angular_velocity, 1, true)                                                      \
    X("w3", "1/s", angular_velocity, 2, true)

#define COLUMN(name, unit, member, row, of_motion) {name, unit, of_motion},
static const model_column rod_columns[] = {ROD_COLUMN_LIST(COLUMN)};
#undef COLUMN

static void observe_rod(const scene *scene, rod_state state, ad_value s, ad_value t,
                        ad_value *values)
{
    rod_observables o = rod_observe(scene, state, s, t);
#define VALUE(name, unit, member, row, of_motion) *values++ = ad_row(o.member, row);
    ROD_COLUMN_LIST(VALUE)
#undef VALUE
}

static const physics_model rod_in_space = {.fields = {"r", "q", "N", "m"},
                                           .columns = rod_columns,
                                           .column_count = sizeof rod_columns / sizeof *rod_columns,
                                           .position_columns = 3,
                                           .rotation_columns = 4,
                                           .network_outputs = rod_network_outputs,
                                           .ansatz = rod_ansatz,
                                           .residual_rows = rod_residual_rows,
                                           .residual = rod_residual,
                                           .observe = observe_rod,
                                           .window_end = rod_window_end,
                                           .check = rod_check,
                                           .terms = rod_terms};

static const model_column beam_columns[BEAM_COLUMNS] = {
    {"w", "m", false},   {"slope", "rad", false}, {"V", "N", false},
    {"M", "N m", false}, {"w_t", "m/s", true},    {"slope_t", "rad/s", true}};

static const physics_model beam = {.fields = {"w", "psi", "V", "M"},
                                   .columns = beam_columns,
                                   .column_count = BEAM_COLUMNS,
                                   .position_columns = 1,
                                   .rotation_columns = 1,
                                   .network_outputs = beam_network_outputs,
                                   .ansatz = beam_ansatz,
                                   .residual_rows = beam_residual_rows,
                                   .residual = beam_residual,
                                   .observe = beam_observe,
                                   .window_end = beam_window_end,
                                   .check = beam_check,
                                   .terms = beam_terms};

const physics_model *model_of(const scene *scene)
{
    return scene_is_beam(scene) ? &beam : &rod_in_space;
}
