#include "physics/local/jump.h"

#include "physics/local/mesh.h"

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

static void add_places(const rod_context *rod, int law_count, const rod_acting *laws,
                       solve_jumps *jumps)
{
    const scene *given = rod->scene;
    double s[SOLVE_JUMPS_MAX + SOLVE_LAWS_MAX], length = rod->scales.length;
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
    for (int i = 0; i < law_count; i++) {
        s[count++] = laws[i].s;
    }
    jumps->count = solve_mesh_places(count, s);
    for (int i = 0; i < jumps->count; i++) {
        jumps->at[i] = (solve_jump){.s = s[i], .turn = {1}};
    }
}

/* Numbers of what acts at places, in their order. */
static void record_laws(int within, int count, const rod_acting *laws, solve_jumps *jumps,
                        ad_value *values)
{
    int recorded = 0;
    for (int i = 0; i < jumps->count; i++) {
        solve_jump *place = &jumps->at[i];
        place->first = jumps->numbers;
        for (int k = 0; k < count; k++) {
            if (jump_at(jumps, laws[k].s) == i) {
                acting_add(&place->acting, laws[k].law);
                place->within += k < within;
                values[recorded++] = laws[k].numbers;
            }
        }
        jumps->numbers += place->acting.numbers;
    }
}

/* Numbers of all bodies of a place, place by place; returns how many values. */
static int record_bodies(const rod_context *rod, solve_jumps *jumps, ad_value *values)
{
    ad_value at[SOLVE_JUMPS_MAX];
    int recorded = 0;
    for (int i = 0; i < rod->scene->body_count && rod->dynamic; i++) {
        const rod_body_data body = rod_body_of(rod, i, rod->t);
        const int k = jump_at(jumps, body.s);
        const ad_value own = ad_stack(3, (const ad_value[]){body.mass, body.inertia, body.beside});
        at[k] = jumps->at[k].heavy ? ad_add(at[k], own) : own;
        jumps->at[k].heavy = true;
        jumps->at[k].beside |= body.is_beside;
    }
    for (int k = 0; k < jumps->count; k++) {
        if (jumps->at[k].heavy) {
            jumps->at[k].body = jumps->numbers;
            jumps->numbers += SOLVE_BODY;
            values[recorded++] = at[k];
        }
    }
    return recorded;
}

ad_value solve_jumps_record(const rod_context *rod, solve_jumps *jumps)
{
    rod_acting laws[SOLVE_LAWS_MAX];
    ad_value numbers[SOLVE_LAWS_MAX + SCENE_BODIES_MAX];
    const int within = rod_acting_at_places(rod, laws);
    const int count = within + rod_acting_at_ends(rod, laws + within);
    *jumps = (solve_jumps){.count = 0};
    add_places(rod, count, laws, jumps);
    for (int i = 0; i < rod_joint_count(rod->scene); i++) {
        rod_joint joint = rod_joint_of(rod->scene, i);
        if (joint.turns) {
            solve_jump *place = &jumps->at[jump_at(jumps, joint.s)];
            place->turns = true;
            memcpy(place->turn, joint.turn, sizeof place->turn);
        }
    }
    record_laws(within, count, laws, jumps, numbers);
    const int values = count + record_bodies(rod, jumps, numbers + count);
    const ad_value all = values > 0 ? ad_stack(values, numbers) : ad_zeros(rod->tape, 3);
    jumps->loads_move = ad_uses(1, &all, rod->t);
    return all;
}

void solve_jump_places(const solve_jumps *jumps, double *s)
{
    for (int i = 0; i < jumps->count; i++) {
        s[i] = jumps->at[i].s;
    }
}
