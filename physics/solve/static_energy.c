#include "physics/solve/static_energy.h"

#include <math.h>
#include <stdlib.h>

/* At all points of the mesh. */
typedef struct at_points {
    size_t count;
    double *s, *weight; /* [count]; the weights are those of the quadrature, 0 between elements */
    solve_section *sections;
    solve_load *load;
    solve_initial *unstressed;
} at_points;

static void points_free(at_points *p)
{
    free(p->s);
    free(p->weight);
    free(p->sections);
    free(p->load);
    free(p->unstressed);
}

static ad_status points_make(const static_system *system, const solve_rod *rod, at_points *p,
                             ad_error *error)
{
    const gauss_rule *rule = static_system_rule(system);
    const double *edges = static_system_edges(system);
    size_t n = p->count = static_system_unknowns(system) / STATIC_ROWS;
    p->s = malloc(n * sizeof *p->s);
    p->weight = calloc(n, sizeof *p->weight);
    p->sections = malloc(n * sizeof *p->sections);
    p->load = malloc(n * sizeof *p->load);
    p->unstressed = malloc(n * sizeof *p->unstressed);
    if (!p->s || !p->weight || !p->sections || !p->load || !p->unstressed) {
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
    status = status == AD_OK ? solve_rod_load(rod, n, p->s, 0, p->load, error) : status;
    return status == AD_OK ? solve_rod_initial(rod, n, p->s, p->unstressed, error) : status;
}

/* Half of force times strain, at a point. */
static double density(const solve_section *section, const double *y)
{
    double force[3], sum = 0;
    static_body_force(y, force);
    for (int i = 0; i < 3; i++) {
        double moment = y[STATIC_M + i];
        sum += 0.5 * section->strain_compliance[i] * force[i] * force[i];
        sum += 0.5 * section->curvature_compliance[i] * moment * moment;
    }
    return sum;
}

static double work_of(const double force[3], const double *y, const solve_initial *unstressed)
{
    double sum = 0;
    for (int i = 0; i < 3; i++) {
        sum += force[i] * (y[STATIC_R + i] - unstressed->position[i]);
    }
    return sum;
}

static bool is_zero(const double a[3])
{
    return a[0] == 0 && a[1] == 0 && a[2] == 0;
}

static bool is_dead_force(const solve_load *load)
{
    return is_zero(load->moment) && is_zero(load->body_force) && is_zero(load->body_moment);
}

/* What an end adds to the work; NaN for moments and followers, which have no potential in space. */
static ad_status work_of_end(const solve_rod *rod, int end, const at_points *p, const double *y,
                             double *work, ad_error *error)
{
    const solve_end *kind = &rod->ends[end];
    size_t at = end ? p->count - 1 : 0;
    solve_end_state given;
    ad_status status = solve_rod_end(rod, end, 0, &given, error);
    if (status != AD_OK) {
        return status;
    }
    if (!kind->holds_position && !is_zero(given.force)) {
        double sign = end ? 1 : -1;
        *work += kind->force_is_body
                     ? NAN
                     : sign * work_of(given.force, y + at * STATIC_ROWS, &p->unstressed[at]);
    }
    if (!kind->holds_rotation && !is_zero(given.moment)) {
        *work = NAN;
    }
    return AD_OK;
}

ad_status static_energy_of(const static_system *system, const solve_rod *rod, const double *y,
                           solve_energy *energy, ad_error *error)
{
    at_points p = {0};
    ad_status status = points_make(system, rod, &p, error);
    *energy = (solve_energy){.mismatch = NAN};
    for (size_t i = 0; status == AD_OK && i < p.count; i++) {
        const double *at = y + i * STATIC_ROWS;
        energy->strain += p.weight[i] * density(&p.sections[i], at);
        energy->work += is_dead_force(&p.load[i])
                            ? p.weight[i] * work_of(p.load[i].force, at, &p.unstressed[i])
                            : NAN;
    }
    for (int end = 0; end < 2 && status == AD_OK; end++) {
        status = work_of_end(rod, end, &p, y, &energy->work, error);
    }
    points_free(&p);
    return status;
}
