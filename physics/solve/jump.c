#include "physics/solve/jump.h"

#include "physics/quaternion.h"
#include "physics/solve/mesh.h"

#include <math.h>
#include <string.h>

/* ---- places ---------------------------------------------------------------------------------- */

static int jump_at(const solve_jumps *jumps, double s)
{
    int found = 0;
    while (found + 1 < jumps->count && jumps->at[found].s < s - SOLVE_SAME_PLACE) {
        found++;
    }
    return found;
}

static void add_places(const rod_context *rod, solve_jumps *jumps)
{
    const scene *given = rod->scene;
    double s[SOLVE_JUMPS_MAX], length = rod->scales.length;
    int count = 0;
    for (int i = 0; i < rod_joint_count(given); i++) {
        rod_joint joint = rod_joint_of(given, i);
        s[count] = joint.s;
        count += joint.turns;
    }
    for (int i = 0; i < given->point_count; i++) {
        s[count++] = given->points[i].at.number / length;
    }
    for (int i = 0; i < given->body_count; i++) {
        s[count++] = given->bodies[i].at.number / length;
    }
    for (int i = 0; i < given->spring_count; i++) {
        s[count++] = given->springs[i].at.number / length;
    }
    jumps->count = solve_mesh_places(count, s);
    for (int i = 0; i < jumps->count; i++) {
        jumps->at[i] = (solve_jump){.s = s[i], .turn = {1}};
    }
}

/* Of one place: dead force and moment, follower force and moment. */
typedef struct recorded_load {
    ad_value rows[4];
} recorded_load;

static void add_to(ad_value *sum, ad_value more)
{
    *sum = ad_add(*sum, more);
}

static void record_bodies(const rod_context *rod, solve_jumps *jumps, recorded_load *loads)
{
    for (int i = 0; i < rod->scene->body_count; i++) {
        rod_body_data body = rod_body_of(rod, i, rod->t);
        int place = jump_at(jumps, body.s);
        add_to(&loads[place].rows[0], body.weight);
        jumps->at[place].mass += body.mass;
        for (int k = 0; k < 3; k++) {
            jumps->at[place].inertia[k] += body.inertia[k];
        }
    }
}

/* anchor, unloaded, upright */
static ad_value record_spring(const rod_context *rod, int i, solve_jumps *jumps)
{
    rod_spring_data spring = rod_spring_of(rod, i);
    solve_jump *place = &jumps->at[jump_at(jumps, spring.s)];
    solve_spring *to = &jumps->springs[jumps->spring_count];
    place->springs[place->spring_count++] = jumps->spring_count++;
    memcpy(to->stiffness, spring.stiffness, sizeof to->stiffness);
    memcpy(to->turning, spring.turning, sizeof to->turning);
    ad_value unloaded = rod_undeformed(rod, ad_scalar(rod->tape, spring.s)).position;
    return ad_stack(3, (ad_value[]){spring.anchor, unloaded, spring.upright});
}

ad_value solve_jumps_record(const rod_context *rod, solve_jumps *jumps, bool *any)
{
    ad_value none = ad_zeros(rod->tape, 3), parts[4 * SOLVE_JUMPS_MAX + SCENE_SPRINGS_MAX];
    recorded_load loads[SOLVE_JUMPS_MAX];
    int count = 0;
    *jumps = (solve_jumps){.count = 0};
    add_places(rod, jumps);
    *any = jumps->count > 0;
    if (!*any) {
        return none;
    }
    for (int i = 0; i < jumps->count; i++) {
        loads[i] = (recorded_load){{none, none, none, none}};
    }
    for (int i = 0; i < rod->scene->point_count; i++) {
        rod_point_data point = rod_point_of(rod, i, rod->t);
        ad_value *rows = loads[jump_at(jumps, point.s)].rows + (point.follows ? 2 : 0);
        add_to(&rows[0], point.force);
        add_to(&rows[1], point.moment);
    }
    record_bodies(rod, jumps, loads);
    for (int i = 0; i < jumps->count; i++) {
        for (int k = 0; k < 4; k++) {
            parts[count++] = loads[i].rows[k];
        }
    }
    for (int i = 0; i < rod->scene->spring_count; i++) {
        parts[count++] = record_spring(rod, i, jumps);
    }
    for (int i = 0; i < rod_joint_count(rod->scene); i++) {
        rod_joint joint = rod_joint_of(rod->scene, i);
        if (joint.turns) {
            solve_jump *place = &jumps->at[jump_at(jumps, joint.s)];
            place->turns = true;
            memcpy(place->turn, joint.turn, sizeof place->turn);
        }
    }
    ad_value all = ad_stack(count, parts);
    jumps->loads_move = ad_uses(1, &all, rod->t);
    return all;
}

/* ---- springs --------------------------------------------------------------------------------- */

void solve_spring_force(const solve_spring *x, const double anchor[3], const double r[3],
                        double force[3])
{
    for (int i = 0; i < 3; i++) {
        force[i] = -x->stiffness[i] * (r[i] - anchor[i]);
    }
}

/* Rotation vector from `upright` to q, on from 0 to a whole turn. */
static void rotation_vector(const double upright[4], const double q[4], double phi[3])
{
    double p[4];
    quaternion_quotient(upright, q, p);
    double size = sqrt(p[1] * p[1] + p[2] * p[2] + p[3] * p[3]);
    double by = size > 0 ? 2 * atan2(size, p[0]) / size : 0;
    for (int i = 0; i < 3; i++) {
        phi[i] = by * p[i + 1];
    }
}

/* (1 - b cot b)/(4 b^2) at b = angle/2 */
static double cotangent_term(double angle)
{
    double b = angle / 2, square = b * b;
    if (b > 0.3) {
        return (1 - b / tan(b)) / (4 * square);
    }
    return (1.0 / 3 +
            square *
                (1.0 / 45 +
                 square * (2.0 / 945 + square * (1.0 / 4725 +
                                                 square * (2.0 / 93555 +
                                                           square * (1382.0 / 638512875 +
                                                                     square * 4.0 / 18243225)))))) /
           4;
}

/* -(d phi/d eta)^T K phi with d phi/d eta = 1 + phi^/2 + c phi^ phi^ */
static void moment_of(const solve_spring *x, const double q[4], double moment[3])
{
    double phi[3], pull[3], once[3], again[3];
    rotation_vector(x->upright, q, phi);
    for (int i = 0; i < 3; i++) {
        pull[i] = x->turning[i] * phi[i];
    }
    vector_cross(phi, pull, once);
    vector_cross(phi, once, again);
    double c = cotangent_term(sqrt(vector_dot(phi, phi)));
    for (int i = 0; i < 3; i++) {
        moment[i] = -(pull[i] - 0.5 * once[i] + c * again[i]);
    }
}

static void moment_after(const solve_spring *x, const double q[4], int axis, double angle,
                         double moment[3])
{
    double turn[4] = {cos(angle / 2)}, turned[4];
    turn[1 + axis] = sin(angle / 2);
    quaternion_product(q, turn, turned);
    moment_of(x, turned, moment);
}

void solve_spring_moment(const solve_spring *x, const double q[4], double moment[3],
                         double (*by_turn)[3])
{
    /* Central differences of order 4: of this length, errors of rounding and of the formula are
     * both 1e-13 of the stiffness. */
    static const double length = 1e-3;
    moment_of(x, q, moment);
    for (int j = 0; j < 3 && by_turn; j++) {
        double near[2][3], far[2][3];
        for (int side = 0; side < 2; side++) {
            double angle = side ? length : -length;
            moment_after(x, q, j, angle, near[side]);
            moment_after(x, q, j, 2 * angle, far[side]);
        }
        for (int i = 0; i < 3; i++) {
            by_turn[i][j] =
                (8 * (near[1][i] - near[0][i]) - (far[1][i] - far[0][i])) / (12 * length);
        }
    }
}

double solve_spring_energy(const solve_spring *x, const double anchor[3], const double r[3],
                           const double q[4])
{
    double phi[3], energy = 0;
    rotation_vector(x->upright, q, phi);
    for (int i = 0; i < 3; i++) {
        double off = r[i] - anchor[i];
        energy += 0.5 * (x->stiffness[i] * off * off + x->turning[i] * phi[i] * phi[i]);
    }
    return energy;
}

void solve_jump_places(const solve_jumps *jumps, double *s)
{
    for (int i = 0; i < jumps->count; i++) {
        s[i] = jumps->at[i].s;
    }
}
