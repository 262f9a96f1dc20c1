/* Where something acts at single places of a rod, in numbers: concentrated loads, joints, rigid
 * bodies, laws outside of the rod; at s = 0, at s = 1, or within. With F, T what the outside does
 * to the rod there,
 *
 *   N(s+) = N(s-) - F,   m(s+) = turn* (m(s-) - T) turn,   q(s+) = q(s-) turn
 *
 * F in the world, T and m in body components, T that of the rotation before the joint. Sources and
 * dimensionless units: physics/rod/rod_internal.h (rod_points.c), physics/local/rod_model.h. */
#ifndef PHYSICS_LOCAL_JUMP_H
#define PHYSICS_LOCAL_JUMP_H

#include "physics/local/acting.h"
#include "physics/local/inertia.h"

enum {
    SOLVE_JUMPS_MAX =
        SCENE_SEGMENTS_MAX + SCENE_POINTS_MAX + SCENE_BODIES_MAX + SCENE_SPRINGS_MAX + 2
};

/* All that acts at one s. */
typedef struct solve_jump {
    double s;
    bool turns;     /* false: turn is 1 */
    double turn[4]; /* of a joint, from the frame before to the frame after */
    bool heavy;     /* bodies of a rod in motion are here; */
    bool beside;    /* some of them beside the axis */
    int body; /* of their mass, inertia about the directors, and numbers of LAW_ECCENTRICITY */
    acting acting;
    int first;  /* of its numbers */
    int within; /* so many of its laws are of the place; then those of what loads an end */
} solve_jump;

enum { SOLVE_BODY = 1 + 3 + 6 };
enum { SOLVE_LAWS_MAX = ROD_AT_PLACES_MAX + ROD_AT_ENDS_MAX };
enum { SOLVE_JUMP_NUMBERS_MAX = SOLVE_LAWS_MAX * LAW_NUMBERS_MAX + SOLVE_BODY * SCENE_BODIES_MAX };

typedef struct solve_jumps {
    int count, numbers;
    bool loads_move;                       /* with t */
    solve_jump at[SOLVE_JUMPS_MAX];        /* s ascending, each once */
    double number[SOLVE_JUMP_NUMBERS_MAX]; /* of what acts at them, at full load, and of bodies */
} solve_jumps;

/* s [count] of them. */
void solve_jump_places(const solve_jumps *jumps, double *s);

/* Fills all but the numbers. Returns these, of t, as rows: of what acts at each place, in turn. */
ad_value solve_jumps_record(const rod_context *rod, solve_jumps *jumps);

/* The numbers of a place, of all. */
static inline const double *solve_jump_numbers(const solve_jumps *jumps, const double *all,
                                               int place)
{
    return all + jumps->at[place].first;
}

/* What the bodies of a place are made of, by all numbers; 0 without. */
static inline inertia solve_jump_body(const solve_jumps *jumps, const double *all, int place)
{
    inertia what = {.is_beside = jumps->at[place].beside};
    if (jumps->at[place].heavy) {
        const double *body = all + jumps->at[place].body;
        what.mass = body[0];
        memcpy(what.rotary, body + 1, sizeof what.rotary);
        memcpy(what.eccentric, body + 4, sizeof what.eccentric);
    }
    return what;
}

#endif
