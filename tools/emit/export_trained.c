/* Families in the strain form: from a run to what is written as C. */
#include "tools/emit/export_family.h"

#include "physics/learn/model.h"
#include "tools/train/experiment.h"
#include "tools/train/targets.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Curvature [3][nodes] times the length, as the run's network says it. */
static ad_value record_network(const void *context, ad_tape *tape, const ad_value *x)
{
    const experiment *e = context;
    const physics_model *physics = e->model;
    domain_place at = {.tape = tape, .over = &physics->domain, .load_factor = ad_scalar(tape, 1)};
    ad_value fields[MODEL_FIELDS_MAX];
    memcpy(at.x, x, (size_t)physics->domain.count * sizeof *x);
    ad_value input = physics->call.input ? physics->call.input(physics, &at)
                                         : domain_network_input(&physics->domain, &at);
    ad_value outputs = nn_mlp_record(e->mlp, input, 0);
    physics->call.ansatz(physics, &at, outputs, fields);
    return fields[FAMILY_CURVATURE];
}

static ad_status find_mesh(export_family *f, const solve_members *solver, ad_error *error)
{
    const size_t nodes = solve_members_nodes(solver);
    scene middle;
    double *s = malloc((nodes + 1) * sizeof *s);
    if (!s) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a mesh");
    }
    scene_middle(f->open, &middle);
    solve_members_places(solver, s);
    for (size_t i = 0; i < nodes; i++) {
        s[i] /= scene_length(&middle);
    }
    ad_status status = strain_check(&middle, true, error);
    status = status == AD_OK ? strain_mesh_at(f->open, (int)nodes, s, &f->mesh, error) : status;
    free(s);
    return status;
}

void export_family_judged(const scene *open, double *parameters)
{
    static const double primes[] = {2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43};
    const int count = open->parameter_count;
    for (int i = 0; i < count * EXPORT_JUDGED; i++) {
        parameters[i] = scene_parameter_at(&open->parameters[i % count],
                                           fmod((i / count + 1) * sqrt(primes[i % count]), 1));
    }
}

/* said [nodes][3] of each, 1/m: the network's curvature of members over the ranges. */
static ad_status ask_network(const experiment *e, const export_family *f, double *parameters,
                             double *said, ad_error *error)
{
    family_network *network = NULL;
    export_family_judged(f->open, parameters);
    for (int i = 0; i < f->open->parameter_count * EXPORT_JUDGED && f->single; i++) {
        parameters[i] = (double)(float)parameters[i];
    }
    ad_status status =
        family_network_create(targets_family(e->targets), e->mlp, e->pool, &network, error);
    if (status == AD_OK) {
        status = family_network_run(network, f->weights, EXPORT_JUDGED, parameters, said, error);
    }
    family_network_free(network);
    return status;
}

/* What Newton's method leaves when it has settled is the error of the mesh: the most of it for what
 * the mesh hardly resolves of a curvature. Of thousands of members of six families the most was up
 * to twice that of the first 64. */
static ad_status judge_mesh(solve_members *solver, export_family *f, const double *parameters,
                            const double *said, ad_error *error)
{
    solve_answer answers[EXPORT_JUDGED];
    const double length = scene_length(f->open);
    const size_t numbers = solve_members_numbers(solver);
    double *polished = malloc(EXPORT_JUDGED * numbers * sizeof *polished);
    ad_status status = polished ? solve_members_refine(solver, EXPORT_JUDGED, parameters, said, 2,
                                                       NULL, polished, NULL, error)
                                : ad_fail(error, AD_NO_MEMORY, "out of memory for a mesh");
    if (status == AD_OK) {
        status = solve_members_refine(solver, EXPORT_JUDGED, parameters, polished, 1, NULL, NULL,
                                      answers, error);
    }
    f->mesh_error = 0;
    for (int i = 0; i < EXPORT_JUDGED && status == AD_OK; i++) {
        const double unresolved = strain_mesh_unresolved(
            &f->mesh, length, (int)solve_members_width(solver), polished + (size_t)i * numbers);
        if (answers[i].trusted) {
            f->mesh_error = fmax(f->mesh_error, answers[i].left / unresolved);
        }
    }
    free(polished);
    return status;
}

ad_status export_family_of(const experiment *e, export_family *f, double *parameters, double *said,
                           ad_error *error)
{
    solve_members *solver = targets_solver(e->targets);
    f->open = e->scene;
    f->about = e->settings->name;
    f->network = record_network;
    f->context = e;
    f->weights = experiment_parameters(e);
    ad_status status = find_mesh(f, solver, error);
    status = status == AD_OK ? ask_network(e, f, parameters, said, error) : status;
    return status == AD_OK ? judge_mesh(solver, f, parameters, said, error) : status;
}

/* *numbers: their places, and `more`. */
static ad_status place_shapes(export_family *f, int columns, int places, const double *s,
                              size_t more, double **numbers, ad_error *error)
{
    static const double unmeasured = NAN;
    double *room = malloc(((size_t)places + more + 1) * sizeof *room);
    *numbers = room;
    if (!room) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory while writing C");
    }
    for (int i = 0; i < places; i++) {
        room[i] = fmin(s[i] / scene_length(f->open), 1);
    }
    f->places = places;
    f->s = room;
    f->values = f->derivatives = &unmeasured;
    for (f->columns = 0; f->columns < columns; f->columns++) {
        f->which[f->columns] = f->columns;
    }
    return AD_OK;
}

ad_status export_family_at(const experiment *e, int columns, int places, const double *s,
                           export_family *f, double **numbers, ad_error *error)
{
    const size_t bent = solve_members_numbers(targets_solver(e->targets));
    const size_t count = EXPORT_JUDGED * (size_t)e->scene->parameter_count;
    f->open = e->scene;
    ad_status status =
        place_shapes(f, columns, places, s, count + EXPORT_JUDGED * bent, numbers, error);
    return status == AD_OK
               ? export_family_of(e, f, *numbers + places, *numbers + places + count, error)
               : status;
}

ad_status export_family_solved(const scene *open, const solve_members *solver, double tolerance,
                               int columns, int places, const double *s, export_family *f,
                               double **numbers, ad_error *error)
{
    f->open = open;
    f->about = "members";
    f->network = NULL;
    f->tolerance = tolerance;
    f->mesh_error = 1;
    ad_status status = place_shapes(f, columns, places, s, 0, numbers, error);
    return status == AD_OK ? find_mesh(f, solver, error) : status;
}
