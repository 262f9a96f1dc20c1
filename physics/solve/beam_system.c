#include "physics/solve/beam_system.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ROWS = BEAM_ROWS };

/* ---- equations ------------------------------------------------------------------------------- */

/* y_s for loads; y in its units. */
static void rate_of(const double *unit, const beam_section *at, const double *y,
                    const beam_load *load, double *to)
{
    double shear = unit[BEAM_V] * y[BEAM_V];
    to[BEAM_W] = unit[BEAM_PSI] * y[BEAM_PSI] + at->shear_compliance * shear;
    to[BEAM_PSI] = at->bending_compliance * unit[BEAM_M] * y[BEAM_M] / unit[BEAM_PSI];
    to[BEAM_V] = (at->foundation * y[BEAM_W] - load->force) / unit[BEAM_V];
    to[BEAM_M] = (-shear - load->moment) / unit[BEAM_M];
}

static void rate(const beam_system *system, size_t node, const double *y, const beam_load *load,
                 double *to)
{
    rate_of(system->unit, &system->sections[node], y, load, to);
}

/* y beyond what acts at an edge, from y before it. */
static void jump_over(const beam_system *system, int edge, const beam_load *loads, double *y)
{
    int jump = system->jump[edge];
    if (jump >= 0) {
        double force =
            system->jumps[jump].stiffness * system->unit[BEAM_W] * y[BEAM_W] - loads[jump].force;
        double moment =
            system->jumps[jump].turning * system->unit[BEAM_PSI] * y[BEAM_PSI] - loads[jump].moment;
        y[BEAM_V] += force / system->unit[BEAM_V];
        y[BEAM_M] += moment / system->unit[BEAM_M];
    }
}

/* ---- derivatives ----------------------------------------------------------------------------- */

/* Row of y that the `which`-th condition is about. */
static size_t held_row(const beam_system *system, int which)
{
    return which % 2 == 0 ? (system->holds[which] ? BEAM_W : BEAM_V)
                          : (system->holds[which] ? BEAM_PSI : BEAM_M);
}

/* Column by column, as all is linear. */
static void differentiate(beam_system *system)
{
    static const beam_load none = {0, 0}, still[BEAM_JUMPS_MAX];
    solve_elements *mesh = &system->mesh;
    for (int c = 0; c < ROWS; c++) {
        double unit[ROWS] = {0}, y[ROWS];
        unit[c] = 1;
        for (size_t i = 0; i < beam_system_nodes(system); i++) {
            rate(system, i, unit, &none, y);
            for (int r = 0; r < ROWS; r++) {
                mesh->by_y[i][r][c] = y[r];
            }
        }
        for (int e = 0; e < mesh->count; e++) {
            memcpy(y, unit, sizeof y);
            jump_over(system, e, still, y);
            for (int r = 0; r < ROWS; r++) {
                mesh->across[e][r][c] = y[r];
            }
        }
        memcpy(y, unit, sizeof y);
        jump_over(system, mesh->count, still, y);
        for (int i = 0; i < 2; i++) {
            mesh->start[i][c] = unit[held_row(system, i)];
            mesh->end[i][c] = y[held_row(system, 2 + i)];
        }
    }
}

/* ---- making and freeing ---------------------------------------------------------------------- */

void beam_system_free(beam_system *system)
{
    if (system) {
        solve_elements_clear(&system->mesh);
        ad_memory_free(&system->memory);
        free(system);
    }
}

static ad_status allocate(beam_system *system, const solve_beam *beam, ad_error *error)
{
    const size_t edges = (size_t)system->mesh.count + 1,
                 unknowns = elements_unknowns(&system->mesh);
    int next = 0;
    system->jump_count = beam->jump_count;
    memcpy(system->jumps, beam->jumps, sizeof system->jumps);
    AD_TAKE(system, jump, edges);
    AD_TAKE(system, sections, beam_system_nodes(system));
    AD_TAKE(system, right, 2 * unknowns);
    if (system->memory.is_short) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu nodes",
                       beam_system_nodes(system));
    }
    system->step = system->right + unknowns;
    for (size_t e = 0; e < edges; e++) {
        bool here = next < system->jump_count && system->jumps[next].s == system->mesh.edges[e];
        system->jump[e] = here ? next++ : -1;
    }
    return AD_OK;
}

/* By the wavenumber of bending on the foundation, (k/4EI)^(1/4) (Hetenyi 1946). */
static void choose_units(beam_system *system)
{
    double most = 4;
    for (size_t i = 0; i < beam_system_nodes(system); i++) {
        most = fmax(most, system->sections[i].foundation * system->sections[i].bending_compliance);
    }
    double wave = pow(most / 4, 0.25);
    system->unit[BEAM_W] = 1;
    system->unit[BEAM_PSI] = wave;
    system->unit[BEAM_M] = wave * wave;
    system->unit[BEAM_V] = wave * wave * wave;
}

ad_status beam_system_create(const solve_beam *beam, int stages, int elements, const double *edges,
                             double stiffening, beam_system **result, ad_error *error)
{
    *result = NULL;
    beam_system *system = calloc(1, sizeof *system);
    if (!system) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a beam");
    }
    for (int i = 0; i < 4; i++) {
        system->holds[i] =
            i % 2 == 0 ? beam->ends[i / 2].holds_deflection : beam->ends[i / 2].holds_slope;
    }
    ad_status status = solve_elements_make(ROWS, 2, stages, elements, edges, &system->mesh, error);
    status = status == AD_OK ? allocate(system, beam, error) : status;
    if (status == AD_OK) {
        status = solve_beam_sections(beam, beam_system_nodes(system), system->mesh.points,
                                     system->sections, error);
    }
    if (status == AD_OK) {
        for (size_t i = 0; i < beam_system_nodes(system); i++) {
            system->sections[i].foundation += stiffening;
        }
        choose_units(system);
        differentiate(system);
        status = solve_elements_factor(&system->mesh) == 0
                     ? AD_OK
                     : ad_fail(error, AD_BAD_ARGUMENT, "the beam is free to move");
    }
    if (status != AD_OK) {
        beam_system_free(system);
        return status;
    }
    *result = system;
    return AD_OK;
}

/* ---- places ---------------------------------------------------------------------------------- */

size_t beam_system_nodes(const beam_system *system)
{
    return (size_t)system->mesh.count * (size_t)system->mesh.stages;
}

size_t beam_system_places(const beam_system *system)
{
    return beam_system_nodes(system) + 2 * (size_t)system->mesh.count;
}

size_t beam_system_place(const beam_system *system, size_t node)
{
    return node + 2 * (node / (size_t)system->mesh.stages) + 1;
}

size_t beam_system_jump_place(const beam_system *system, int jump)
{
    size_t stride = (size_t)system->mesh.stages + 2;
    int edge = 0;
    while (system->jump[edge] != jump) {
        edge++;
    }
    return edge < system->mesh.count ? (size_t)edge * stride : beam_system_places(system) - 1;
}

/* ---- solving --------------------------------------------------------------------------------- */

/* loads: NULL for none; more [elements][stages + 1][ROWS] is added to the equations of the points
 * and the end of every element, or NULL. */
static void solve_for(beam_system *system, const beam_load *loads, const double *more,
                      const beam_load *jump_loads, const double ends[4], double *y)
{
    static const double none[(GAUSS_STAGES_MAX + 1) * ROWS];
    solve_elements *mesh = &system->mesh;
    const size_t stages = (size_t)mesh->stages, each = (stages + 1) * ROWS;
    double *to = system->right + mesh->start_rows, last[ROWS] = {0};
    for (int e = 0; e < mesh->count; e++, to += each) {
        double start[ROWS] = {0}, rates[GAUSS_STAGES_MAX * ROWS] = {0};
        jump_over(system, e, jump_loads, start);
        for (size_t j = 0; j < stages && loads; j++) {
            const size_t node = (size_t)e * stages + j;
            rate(system, node, none, &loads[node], rates + j * ROWS);
        }
        solve_elements_residual(mesh, e, start, none, rates, to);
        for (size_t i = 0; i < each; i++) {
            to[i] = (more ? more[(size_t)e * each + i] / system->unit[i % ROWS] : 0) - to[i];
        }
    }
    jump_over(system, mesh->count, jump_loads, last);
    for (int i = 0; i < 2; i++) {
        const size_t row = held_row(system, 2 + i);
        system->right[i] = ends[i] / system->unit[held_row(system, i)];
        to[i] = ends[2 + i] / system->unit[row] - last[row];
    }
    solve_elements_solve(mesh, system->right, system->step);
    for (int e = 0; e < mesh->count; e++, y += each + ROWS) {
        memcpy(y, system->step + elements_edge(mesh, e), (each + ROWS) * sizeof *y);
        jump_over(system, e, jump_loads, y);
        for (size_t i = 0; i < each + ROWS; i++) {
            y[i] *= system->unit[i % ROWS];
        }
    }
}

void beam_system_solve(beam_system *system, const beam_load *loads, const beam_load *jump_loads,
                       const double ends[4], double *y)
{
    solve_for(system, loads, NULL, jump_loads, ends, y);
}

void beam_system_correct(beam_system *system, const double *residual, double *step)
{
    static const beam_load still[BEAM_JUMPS_MAX];
    static const double none[4];
    solve_for(system, NULL, residual, still, none, step);
}

void beam_system_rate(const beam_section *at, const double *y, const beam_load *load, double *to)
{
    static const double unit[ROWS] = {1, 1, 1, 1};
    rate_of(unit, at, y, load, to);
}

void beam_system_at(const beam_system *system, const double *y, double s, double *at)
{
    const int element = solve_elements_at(&system->mesh, s);
    const size_t each = ((size_t)system->mesh.stages + 2) * ROWS;
    solve_elements_interpolate(&system->mesh, element, s, ROWS, ROWS, y + (size_t)element * each,
                               at);
}
