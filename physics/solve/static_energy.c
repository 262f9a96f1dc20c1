#include "physics/solve/static_energy.h"

#include "autodiff/memory.h"
#include "physics/law/law_numbers.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* At all points of the mesh. */
typedef struct at_points {
    size_t count;       /* points */
    double *s, *weight; /* [count]; the weights are those of the quadrature, 0 between elements */
    solve_initial *unstressed;
    solve_rod_points given;
    ad_memory memory;
} at_points;

static void points_free(at_points *p)
{
    ad_memory_free(&p->memory);
    solve_rod_points_clear(&p->given);
}

static ad_status points_make(const static_system *system, at_points *p, ad_error *error)
{
    const solve_elements *mesh = &system->mesh;
    size_t n = p->count = elements_unknowns(mesh) / (size_t)mesh->rows;
    AD_TAKE(p, s, n);
    AD_TAKE(p, weight, n);
    AD_TAKE(p, unstressed, n);
    if (p->memory.is_short) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", n);
    }
    solve_elements_places(mesh, p->s);
    for (int e = 0; e < mesh->count; e++) {
        for (int k = 0; k < mesh->stages; k++) {
            p->weight[1 + e * (mesh->stages + 1) + k] =
                elements_width(mesh, e) * mesh->rule.weights[k];
        }
    }
    ad_status status = solve_rod_points_make(system->rod, n, p->s, &p->given, error);
    return status == AD_OK ? solve_rod_initial(system->rod, n, p->s, p->unstressed, error) : status;
}

/* What actuators do from the unstressed rod to state y at point i, per length; takes
 * their wrench and that of tubes from that of the section, [ACTUATION_ROWS], and adds the energy of
 * tubes; the same of what a law is beyond the linear one. */
static double take_actuation(const at_points *p, size_t i, const static_system *system,
                             const double *y, double *wrench, double *energy)
{
    const static_point at = static_system_given(system, &p->given, i, p->s[i]);
    solve_actuation given = static_actuation(&at, y);
    double strains[ACTUATION_ROWS], rest[ACTUATION_ROWS], pull[ACTUATION_ROWS];
    static_strains(&at, y, strains, strains + 3);
    solve_actuation_wrench(&given, strains, pull, NULL);
    *energy += solve_tube_energy(&given, strains + 3);
    *energy += given.law ? solve_law_energy(&given, strains, (double[ACTUATION_ROWS]){0}, NULL) : 0;
    for (int k = 0; k < 3; k++) {
        rest[k] = at.rest.strain[k];
        rest[3 + k] = at.rest.curvature[k];
    }
    for (int k = 0; k < ACTUATION_ROWS; k++) {
        wrench[k] -= pull[k];
    }
    given.tensions = NULL; /* a length does no work */
    return solve_actuation_energy(&given, rest) - solve_actuation_energy(&given, strains);
}

/* Half of the elastic force times strain, and what laws outside store, at a point; adds what loads
 * and actuators do to the work. */
static double density(const at_points *p, size_t i, const static_system *system, const double *y,
                      double *work)
{
    const solve_section *section = &p->given.sections[i];
    const acting *along = &system->rod->along;
    const solve_initial *unstressed = &p->unstressed[i];
    const acting_on from = {unstressed->position, unstressed->rotation, NULL};
    const acting_on at = {y + STATIC_R, y + STATIC_Q, NULL};
    const double *numbers = p->given.along + i * (size_t)along->numbers;
    double wrench[ACTUATION_ROWS], sum = acting_energy(along, numbers, at);
    *work += acting_work(along, numbers, from, at);
    static_body_force(y, wrench);
    memcpy(wrench + 3, y + STATIC_M, 3 * sizeof *wrench);
    if (system->rod->actuators > 0 || system->rod->scene.rod.law) {
        *work += take_actuation(p, i, system, y, wrench, &sum);
        *work = system->rod->frictions > 0 ? NAN : *work; /* it depends on the way */
    }
    /* k x^2/2 of x = C n, k = 1/C is C n^2/2, also of a locked strain */
    number_law_elastic_energy(wrench, wrench + 3, section->compliance, &sum);
    return sum;
}

/* What acts at places: work of loads, and what else stores energy. */
static void add_jumps(const static_system *system, const at_points *p, const double *y,
                      solve_energy *energy)
{
    const solve_rod *rod = system->rod;
    const solve_jumps *jumps = &rod->jumps;
    const size_t points = (size_t)system->mesh.stages + 1;
    for (int e = 0; e <= system->mesh.count; e++) {
        const size_t node = (size_t)e * points;
        const double *at = y + node * (size_t)system->mesh.rows;
        const solve_initial *unstressed = &p->unstressed[node];
        const int i = system->jump[e];
        if (i >= 0) {
            const acting *of = &jumps->at[i].acting;
            const double *numbers = solve_jump_numbers(jumps, jumps->number, i);
            const acting_on from = {unstressed->position, unstressed->rotation, NULL};
            const acting_on to = {at + STATIC_R, at + STATIC_Q, NULL};
            const bool is_end = e == 0 || e == system->mesh.count;
            double moved[3], held[3] = {0}, r[3];
            for (int k = 0; k < 3; k++) {
                moved[k] = to.position[k] - from.position[k];
            }
            if (is_end) { /* in directions that it holds, an end bears the load */
                scene_hold_part(&rod->ends[e > 0].hold, moved, held);
            }
            for (int k = 0; k < 3; k++) {
                r[k] = to.position[k] - held[k];
            }
            energy->work += acting_work(of, numbers, from, (acting_on){r, to.rotation, NULL});
            energy->strain += acting_energy(of, numbers, to);
        }
    }
}

ad_status static_energy_of(const static_system *system, const double *y, solve_energy *energy,
                           ad_error *error)
{
    at_points p = {0};
    ad_status status = points_make(system, &p, error);
    *energy = (solve_energy){.mismatch = NAN};
    for (size_t i = 0; status == AD_OK && i < p.count; i++) {
        const double *at = y + i * (size_t)system->mesh.rows;
        double done = 0;
        energy->strain += p.weight[i] * density(&p, i, system, at, &done);
        energy->work += p.weight[i] * done;
    }
    if (status == AD_OK) {
        add_jumps(system, &p, y, energy);
    }
    points_free(&p);
    return status;
}
