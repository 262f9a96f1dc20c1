#include "rod_case.h"

#include <stdlib.h>
#include <string.h>

/* A round rod of length / radius = 20 with nu = 0.3, as in configs/cantilever_dynamic.yaml. */
const rod_case_constants rod_case_numbers = {
    .strain_stiffness = {545.4545454545455, 545.4545454545455, 1600},
    .curvature_stiffness = {1, 1, 0.7692307692307692},
    .rotary_inertia = {0.000625, 0.000625, 0.00125},
    .weight = {0.5, -1, 0.25},
    .duration = 1,
    .force_weight = 1,
    .moment_weight = 2};

static scene rod_case_scene(void)
{
    const rod_case_constants *numbers = &rod_case_numbers;
    scene rod;
    scene_defaults(&rod);
    rod.rod.length = rod.rod.mass_per_length = quantity_number(1);
    for (int i = 0; i < 3; i++) {
        if (i < 2) {
            rod.rod.shear_stiffness[i] = quantity_number(numbers->strain_stiffness[i]);
            rod.rod.bending_stiffness[i] = quantity_number(numbers->curvature_stiffness[i]);
        }
        rod.rod.rotary_inertia[i] = quantity_number(numbers->rotary_inertia[i]);
        rod.loads.gravity[i] = quantity_number(numbers->weight[i]);
        rod.end.position[i] = quantity_number(i == 2);
    }
    rod.rod.axial_stiffness = quantity_number(numbers->strain_stiffness[2]);
    rod.rod.torsional_stiffness = quantity_number(numbers->curvature_stiffness[2]);
    rod.duration = quantity_number(numbers->duration);
    rod.formulation = SCENE_DISPLACEMENT;
    rod.end.type = SCENE_CLAMPED;
    for (int i = 0; i < 4; i++) {
        rod.end.rotation[i] = quantity_number(i == 0);
    }
    return rod;
}

/* Uniform within 0.2 of 0, from Knuth's MMIX generator: the same for every side and machine. */
static void rod_case_parameters(double *x, size_t count)
{
    unsigned long long seed = 1;
    for (size_t i = 0; i < count; i++) {
        seed = seed * 6364136223846793005u + 1442695040888963407u;
        x[i] = 0.4 * ((double)(seed >> 11) * 0x1p-53 - 0.5);
    }
}

static ad_status rod_case_network(rod_case *c, ad_error *error)
{
    nn_mlp_settings settings = nn_mlp_settings_default();
    nn_rng rng = nn_rng_seed(1);
    settings.inputs = 2;
    settings.outputs = ROD_CASE_OUTPUTS;
    settings.hidden_count = c->hidden_count;
    for (int i = 0; i < c->hidden_count; i++) {
        settings.hidden[i] = c->width;
    }
    settings.activation = NN_TANH;
    ad_status status = nn_mlp_create(&settings, &rng, &c->mlp, error);
    if (status != AD_OK) {
        return status;
    }
    c->parameters = nn_mlp_parameters(c->mlp);
    c->x = malloc(c->parameters * sizeof *c->x);
    if (!c->x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory");
    }
    rod_case_parameters(c->x, c->parameters);
    return AD_OK;
}

static ad_status rod_case_problem(rod_case *c, ad_error *error)
{
    const scene rod = rod_case_scene();
    problem_settings settings = problem_settings_default();
    settings.interior.points = (int)c->points;
    settings.held_out_points = 1;
    rod_weights weights = rod_weights_default();
    weights.force = rod_case_numbers.force_weight;
    weights.moment = rod_case_numbers.moment_weight;
    ad_status status = model_of_scene(&rod, &weights, &c->model, error);
    if (status == AD_OK) {
        status = problem_create(c->model, c->mlp, &settings, 1, c->pool, &c->problem, error);
    }
    if (status != AD_OK) {
        return status;
    }
    problem_array arrays[PROBLEM_STATE_MAX];
    problem_generator generators[PROBLEM_STATE_MAX];
    int generator_count;
    problem_state(c->problem, arrays, generators, &generator_count);
    c->s = arrays[0].data; /* points/interior [2][points] */
    c->t = c->s + c->points;
    return AD_OK;
}

ad_status rod_case_create(rod_case *c, int hidden_count, int width, int points, int threads,
                          ad_error *error)
{
    *c = (rod_case){.hidden_count = hidden_count, .width = width, .points = (size_t)points};
    c->pool = ad_pool_create(threads);
    ad_status status =
        c->pool ? AD_OK : ad_fail(error, AD_NO_MEMORY, "cannot start %d threads", threads);
    if (status == AD_OK) {
        status = rod_case_network(c, error);
    }
    if (status == AD_OK) {
        status = rod_case_problem(c, error);
    }
    if (status != AD_OK) {
        rod_case_free(c);
    }
    return status;
}

void rod_case_free(rod_case *c)
{
    problem_free(c->problem);
    nn_mlp_free(c->mlp);
    model_free(c->model);
    ad_pool_free(c->pool);
    free(c->x);
    *c = (rod_case){0};
}
