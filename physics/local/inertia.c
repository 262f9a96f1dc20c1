#include "physics/local/inertia.h"

enum { PARTS = 4 }; /* velocity, spin, acceleration, rate of the spin */

typedef struct in_body {
    double part[PARTS][3];
} in_body;

static in_body to_section(inertia_motion at)
{
    const double *part[PARTS] = {at.velocity, at.spin, at.acceleration, at.spin_rate};
    in_body x = {{{0}}};
    for (int i = 0; i < PARTS; i++) {
        for (int k = 0; k < 3 && part[i]; k++) {
            const double *world = part[i];
            x.part[i][k] = at.R[0][k] * world[0] + at.R[1][k] * world[1] + at.R[2][k] * world[2];
        }
    }
    return x;
}

#define GIVEN(x) (x).part[0], (x).part[1], (x).part[2], (x).part[3]

static void to_world_wrench(const double (*R)[3], const double body[6], double wrench[6])
{
    for (int k = 0; k < 3; k++) {
        wrench[k] = vector_dot(R[k], body);
        wrench[3 + k] = vector_dot(R[k], body + 3);
    }
}

void inertia_wrench_coupled(const inertia *what, inertia_motion at, double wrench[6])
{
    const in_body x = to_section(at);
    double body[6] = {0};
    if (inertia_turns(what)) {
        number_law_rotary_inertia_wrench(GIVEN(x), what->rotary, body);
    }
    if (what->added != 0) {
        number_law_added_mass_wrench(GIVEN(x), &what->added, body);
    }
    if (what->is_beside) {
        number_law_eccentricity_wrench(GIVEN(x), what->eccentric, body);
    }
    to_world_wrench(at.R, body, wrench);
    for (int k = 0; k < 3 && at.acceleration; k++) {
        wrench[k] -= what->mass * at.acceleration[k];
    }
}

double inertia_energy(const inertia *what, inertia_motion at)
{
    const in_body x = to_section((inertia_motion){at.R, at.velocity, at.spin, NULL, NULL});
    double energy = 0.5 * what->mass * vector_dot(at.velocity, at.velocity);
    number_law_rotary_inertia_energy(GIVEN(x), what->rotary, &energy);
    number_law_added_mass_energy(GIVEN(x), &what->added, &energy);
    if (what->is_beside) {
        number_law_eccentricity_energy(GIVEN(x), what->eccentric, &energy);
    }
    return energy;
}

/* to += block (x phi), as a vector x that is seen from a section that turns by phi in the world
 * changes by x cross phi. */
static void add_seen(double (*block)[3], const double x[3], double (*to)[3])
{
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            const int a = (k + 1) % 3, b = (k + 2) % 3;
            to[i][k] += block[i][a] * x[b] - block[i][b] * x[a];
        }
    }
}

void inertia_differentiate(const inertia *what, inertia_motion at, inertia_change *to)
{
    double(*blocks[PARTS])[3] = {to->by_velocity, to->by_spin, to->by_acceleration,
                                 to->by_spin_rate};
    const double *part[PARTS] = {at.velocity, at.spin, at.acceleration, at.spin_rate};
    const in_body x = to_section(at);
    const bool couples = inertia_couples(what);
    double body[6] = {0}, by[LAW_BY_MOTION] = {0}, wrench[6] = {0};
    memset(to->by_turn, 0, sizeof to->by_turn);
    number_law_rotary_inertia(GIVEN(x), what->rotary, body, by);
    if (couples) {
        number_law_added_mass(GIVEN(x), &what->added, body, by);
    }
    if (what->is_beside) {
        number_law_eccentricity(GIVEN(x), what->eccentric, body, by);
    }
    to_world_wrench(at.R, body, wrench);
    for (int row = couples ? 0 : 3; row < 6; row += 3) {
        for (int i = 0; i < PARTS; i++) {
            if (couples || i == 1 || i == 3) {
                inertia_turn_block(at.R, by + 18 * i + 3 * row, blocks[i] + row);
                add_seen(blocks[i] + row, part[i], to->by_turn + row);
            }
        }
        for (int k = 0; k < 3; k++) { /* what it gives turns with the section */
            const int a = (k + 1) % 3, b = (k + 2) % 3;
            to->by_turn[row + a][b] += wrench[row + k];
            to->by_turn[row + b][a] -= wrench[row + k];
        }
    }
}

/* to -= R block R^T */
static void take_turned(const double (*R)[3], const double *block, double (*to)[3])
{
    double turned[3][3];
    inertia_turn_block(R, block, turned);
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            to[i][k] -= turned[i][k];
        }
    }
}

inertia_matrix inertia_matrix_coupled(const inertia *what, const double (*R)[3])
{
    static const double still[3] = {0};
    double unused[6] = {0}, by[LAW_BY_MOTION] = {0};
    const double *acceleration = by + 18 * 2, *spin_rate = by + 18 * 3;
    inertia_matrix to = {.mass = {{what->mass}, {0, what->mass}, {0, 0, what->mass}}};
    if (what->added != 0) {
        number_law_added_mass(still, still, still, still, &what->added, unused, by);
        take_turned(R, acceleration, to.mass);
    }
    if (what->is_beside) {
        number_law_eccentricity(still, still, still, still, what->eccentric, unused, by);
        take_turned(R, spin_rate, to.coupling);
    }
    if (what->is_beside || inertia_turns(what)) {
        number_law_rotary_inertia(still, still, still, still, what->rotary, unused, by);
        take_turned(R, spin_rate + 9, to.rotary);
    }
    return to;
}
