/* What is given along a rod in motion, for quadrature: what it is made of, how it starts; rest
 * shape, loads and actuators at some times. */
#include "physics/local/rod_model.h"

#include <string.h>

/* Formulas of s and t that are narrow at one time are so at others, too, or nearly 0. */
enum { TIMES = 4 };
static const double TIME[TIMES] = {0.03, 0.31, 0.57, 0.93}; /* of the duration, none of it round */

/* Numbers of a section, the initial state; and of each time. */
enum {
    SECTION = 19,
    INITIAL = sizeof(solve_initial) / sizeof(double),
    REST = 6,
    EACH = sizeof(solve_actuator) / sizeof(double)
};

/* One column of rows [n][rows]: `count` numbers of each point, at the row `first`. */
typedef struct columns {
    double *out;
    size_t n, rows, first;
} columns;

static void put(columns *to, size_t point, size_t offset, const double *from, size_t count)
{
    memcpy(to->out + point * to->rows + to->first + offset, from, count * sizeof *from);
}

static ad_status put_sections(const solve_rod *rod, const double *s, columns *to, ad_error *error)
{
    solve_section made[QUADRATURE_BATCH];
    solve_initial initial[QUADRATURE_BATCH];
    ad_status status = solve_rod_sections(rod, to->n, s, made, error);
    status = status == AD_OK ? solve_rod_initial(rod, to->n, s, initial, error) : status;
    for (size_t i = 0; i < to->n && status == AD_OK; i++) {
        put(to, i, 0, made[i].stiffness, 6);
        put(to, i, 6, made[i].damping, 6);
        put(to, i, 12, &made[i].mass, 1);
        put(to, i, 13, made[i].rotary_inertia, 3);
        put(to, i, 16, &made[i].added_mass, 1);
        put(to, i, 17, &made[i].maxwell_ratio, 2);
        put(to, i, SECTION, (const double *)&initial[i], INITIAL);
    }
    to->first += SECTION + INITIAL;
    return status;
}

static ad_status put_loads(const solve_rod *rod, const double *s, double t, columns *to,
                           ad_error *error)
{
    solve_rest rest[QUADRATURE_BATCH];
    double along[QUADRATURE_BATCH * ACTING_ALONG_MAX];
    const size_t numbers = (size_t)rod->along.numbers;
    ad_status status = solve_rod_rest(rod, to->n, s, t, rest, error);
    status = status == AD_OK ? solve_rod_along(rod, to->n, s, t, along, error) : status;
    for (size_t i = 0; i < to->n && status == AD_OK; i++) {
        put(to, i, 0, rest[i].strain, 3);
        put(to, i, 3, rest[i].curvature, 3);
        put(to, i, REST, along + i * numbers, numbers);
    }
    to->first += REST + numbers;
    return status;
}

static ad_status given_at(const void *context, size_t n, const double *s, double *out,
                          ad_error *error)
{
    const solve_rod *rod = context;
    const size_t pulling = (size_t)rod->actuators;
    solve_actuator actuators[QUADRATURE_BATCH * SOLVE_ACTUATORS_MAX];
    columns to = {out, n, (size_t)motion_given(rod).rows, 0};
    ad_status status = put_sections(rod, s, &to, error);
    for (int i = 0; i < TIMES && status == AD_OK; i++) {
        status = put_loads(rod, s, TIME[i] * rod->duration, &to, error);
    }
    if (pulling > 0 && status == AD_OK) {
        status = solve_rod_actuators(rod, n, s, TIME[1] * rod->duration, actuators, error);
    }
    for (size_t i = 0; i < n && status == AD_OK; i++) {
        put(&to, i, 0, (const double *)&actuators[i * pulling], pulling * EACH);
    }
    return status;
}

solve_given motion_given(const solve_rod *rod)
{
    enum { ROWS = SECTION + INITIAL + TIMES * REST };
    _Static_assert(ROWS + TIMES * ACTING_ALONG_MAX + EACH * SOLVE_ACTUATORS_MAX <=
                       QUADRATURE_ROWS_MAX,
                   "too many");
    return (solve_given){.rows = ROWS + TIMES * rod->along.numbers + EACH * rod->actuators,
                         .at = given_at,
                         .context = rod};
}

ad_status motion_places_of(const solve_rod *rod, solve_quadrature **places, ad_error *error)
{
    double jumps[SOLVE_JUMPS_MAX];
    const solve_given given = motion_given(rod);
    solve_jump_places(&rod->jumps, jumps);
    return solve_quadrature_create(&rod->scene, &given, rod->jumps.count, jumps, places, error);
}
