#include "physics/solve/static_energy.h"

#include "physics/law/law_numbers.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* At all points of the mesh. */
typedef struct at_points {
    size_t count, rows; /* points; rows of y at each */
    double *s, *weight; /* [count]; the weights are those of the quadrature, 0 between elements */
    solve_section *sections;
    solve_initial *unstressed;
    double *along;             /* [count][numbers of what acts along the rod] */
    solve_rest *rest;          /* of rods with actuators, as the next */
    solve_actuator *actuators; /* [count][those of the rod] */
} at_points;

static void points_free(at_points *p)
{
    free(p->s);
    free(p->weight);
    free(p->sections);
    free(p->unstressed);
    free(p->along);
    free(p->rest);
    free(p->actuators);
}

static ad_status add_actuators(const solve_rod *rod, at_points *p, ad_error *error)
{
    size_t n = p->count;
    p->rest = malloc(n * sizeof *p->rest);
    p->actuators = malloc((n * (size_t)rod->actuators + 1) * sizeof *p->actuators);
    if (!p->rest || !p->actuators) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", n);
    }
    ad_status status = solve_rod_rest(rod, n, p->s, 0, p->rest, error);
    return status == AD_OK ? solve_rod_actuators(rod, n, p->s, 0, p->actuators, error) : status;
}

static ad_status points_make(const static_system *system, const solve_rod *rod, at_points *p,
                             ad_error *error)
{
    const gauss_rule *rule = static_system_rule(system);
    const double *edges = static_system_edges(system);
    p->rows = (size_t)static_system_rows(system);
    size_t n = p->count = static_system_unknowns(system) / p->rows;
    p->s = malloc(n * sizeof *p->s);
    p->weight = calloc(n, sizeof *p->weight);
    p->sections = malloc(n * sizeof *p->sections);
    p->unstressed = malloc(n * sizeof *p->unstressed);
    p->along = malloc((n * (size_t)rod->along.numbers + 1) * sizeof *p->along);
    if (!p->s || !p->weight || !p->sections || !p->unstressed || !p->along) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", n);
    }
    static_system_points(system, p->s);
    for (int e = 0; e < static_system_elements(system); e++) {
        for (int k = 0; k < rule->stages; k++) {
            p->weight[1 + e * (rule->stages + 1) + k] =
                (edges[e + 1] - edges[e]) * rule->weights[k];
        }
    }
    ad_status status = solve_rod_sections(rod, n, p->s, p->sections, error);
    status = status == AD_OK ? solve_rod_initial(rod, n, p->s, p->unstressed, error) : status;
    status = status == AD_OK ? solve_rod_along(rod, n, p->s, 0, p->along, error) : status;
    return status == AD_OK && (rod->actuators > 0 || rod->scene.rod.law)
               ? add_actuators(rod, p, error)
               : status;
}

/* What actuators do from the unstressed rod to state y at point i, per length; takes
 * their wrench and that of tubes from that of the section, [ACTUATION_ROWS], and adds the energy of
 * tubes; the same of what a law is beyond the linear one. */
static double take_actuation(const at_points *p, size_t i, const static_system *system,
                             const double *y, double *wrench, double *energy)
{
    const static_point at = {.rest = p->rest[i],
                             .compliance = p->sections[i].compliance,
                             .actuation =
                                 static_system_actuation(system, p->actuators, i, p->s[i])};
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
    const solve_section *section = &p->sections[i];
    const acting *along = &static_system_rod(system)->along;
    const solve_initial *unstressed = &p->unstressed[i];
    const acting_on from = {unstressed->position, unstressed->rotation, NULL};
    const acting_on at = {y + STATIC_R, y + STATIC_Q, NULL};
    const double *numbers = p->along + i * (size_t)along->numbers;
    double wrench[ACTUATION_ROWS], sum = acting_energy(along, numbers, at);
    *work += acting_work(along, numbers, from, at);
    static_body_force(y, wrench);
    memcpy(wrench + 3, y + STATIC_M, 3 * sizeof *wrench);
    if (p->rest) {
        *work += take_actuation(p, i, system, y, wrench, &sum);
        *work = static_system_rod(system)->frictions > 0 ? NAN : *work; /* it depends on the way */
    }
    /* k x^2/2 of x = C n, k = 1/C is C n^2/2, also of a locked strain */
    number_law_elastic_energy(wrench, wrench + 3, section->compliance, &sum);
    return sum;
}

/* What acts at places: work of loads, and what else stores energy. */
static void add_jumps(const static_system *system, const solve_rod *rod, const at_points *p,
                      const double *y, solve_energy *energy)
{
    const solve_jumps *jumps = &rod->jumps;
    const size_t points = (size_t)static_system_rule(system)->stages + 1;
    for (int e = 0; e <= static_system_elements(system); e++) {
        const size_t node = (size_t)e * points;
        const double *at = y + node * p->rows;
        const solve_initial *unstressed = &p->unstressed[node];
        const int i = static_system_jump(system, e);
        if (i >= 0) {
            const acting *of = &jumps->at[i].acting;
            const double *numbers = solve_jump_numbers(jumps, jumps->number, i);
            const acting_on from = {unstressed->position, unstressed->rotation, NULL};
            const acting_on to = {at + STATIC_R, at + STATIC_Q, NULL};
            const bool is_end = e == 0 || e == static_system_elements(system);
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

ad_status static_energy_of(const static_system *system, const solve_rod *rod, const double *y,
                           solve_energy *energy, ad_error *error)
{
    at_points p = {0};
    ad_status status = points_make(system, rod, &p, error);
    *energy = (solve_energy){.mismatch = NAN};
    for (size_t i = 0; status == AD_OK && i < p.count; i++) {
        const double *at = y + i * p.rows;
        double done = 0;
        energy->strain += p.weight[i] * density(&p, i, system, at, &done);
        energy->work += p.weight[i] * done;
    }
    if (status == AD_OK) {
        add_jumps(system, rod, &p, y, energy);
    }
    points_free(&p);
    return status;
}
