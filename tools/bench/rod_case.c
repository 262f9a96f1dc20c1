#include "rod_case.h"

#include "tools/prepare/config_experiment.h"

#include <stdio.h>
#include <stdlib.h>

/* A round rod of length / radius = 20 with nu = 0.3, as in configs/cantilever_dynamic.yaml. */
const rod_case_constants rod_case_numbers = {
    .strain_stiffness = {545.4545454545455, 545.4545454545455, 1600},
    .curvature_stiffness = {1, 1, 0.7692307692307692},
    .rotary_inertia = {0.000625, 0.000625, 0.00125},
    .weight = {0.5, -1, 0.25},
    .duration = 1,
    .force_weight = 1,
    .moment_weight = 2};

/* Uniform within 0.2 of 0, from Knuth's MMIX generator: the same for every side and machine. */
static void rod_case_parameters(double *x, size_t count)
{
    unsigned long long seed = 1;
    for (size_t i = 0; i < count; i++) {
        seed = seed * 6364136223846793005u + 1442695040888963407u;
        x[i] = 0.4 * ((double)(seed >> 11) * 0x1p-53 - 0.5);
    }
}

/* Of the file that it stands for. */
static void write_scene(FILE *file, int hidden_count, int width, int points)
{
    const rod_case_constants *n = &rod_case_numbers;
    const double *k = n->strain_stiffness, *c = n->curvature_stiffness, *j = n->rotary_inertia;
    fprintf(file,
            "rod:\n  model: cosserat\n  length: 1\n"
            "  stiffness: {shear: [%.17g, %.17g], axial: %.17g, bending: [%.17g, %.17g], torsion: "
            "%.17g}\n  inertia: {mass_per_length: 1, rotary: [%.17g, %.17g, %.17g]}\n",
            k[0], k[1], k[2], c[0], c[1], c[2], j[0], j[1], j[2]);
    fprintf(file,
            "boundary: {end: {type: clamped, position: [0, 0, 1], rotation: [1, 0, 0, 0]}}\n"
            "loads: {gravity: [%.17g, %.17g, %.17g]}\ntime: {duration: %.17g, windows: 1}\n"
            "formulation: displacement\nlosses: {held_out_points: 1, interior: {points: %d, "
            "weights: {force: %.17g, moment: %.17g}}}\nnetwork: {activation: tanh, hidden: [",
            n->weight[0], n->weight[1], n->weight[2], n->duration, points, n->force_weight,
            n->moment_weight);
    for (int i = 0; i < hidden_count; i++) {
        fprintf(file, "%s%d", i ? ", " : "", width);
    }
    fputs("]}\n", file);
}

static ad_status open_scene(rod_case *c, int threads, ad_error *error)
{
    char *text = NULL;
    size_t size;
    config *settings;
    FILE *file = open_memstream(&text, &size);
    if (file) {
        write_scene(file, c->hidden_count, c->width, (int)c->points);
    }
    ad_status status = file && fclose(file) == 0
                           ? prepare_read("step.yaml", text, 0, NULL, &settings, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory");
    free(text);
    status = status == AD_OK ? config_experiment_create(settings, threads, &c->e, error) : status;
    return status == AD_OK ? experiment_problem(c->e, &c->problem, error) : status;
}

ad_status rod_case_create(rod_case *c, int hidden_count, int width, int points, int threads,
                          ad_error *error)
{
    *c = (rod_case){.hidden_count = hidden_count, .width = width, .points = (size_t)points};
    const ad_status status = open_scene(c, threads, error);
    if (status != AD_OK) {
        rod_case_free(c);
        return status;
    }
    problem_array arrays[PROBLEM_STATE_MAX];
    problem_generator generators[PROBLEM_STATE_MAX];
    int generator_count;
    problem_state(c->problem, arrays, generators, &generator_count);
    c->s = arrays[0].data; /* points/interior [2][points] */
    c->t = c->s + c->points;
    c->parameters = c->e->count;
    c->pool = c->e->pool;
    c->x = experiment_parameters(c->e);
    rod_case_parameters(c->x, c->parameters);
    return AD_OK;
}

void rod_case_free(rod_case *c)
{
    problem_free(c->problem);
    experiment_free(c->e);
    *c = (rod_case){0};
}
