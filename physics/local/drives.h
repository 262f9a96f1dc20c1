/* What drives a rod in time: every formula of t that its scene has, whatever its key, by the list
 * of all quantities of a scene. Solvers keep no list of their own of what may vary. */
#ifndef PHYSICS_LOCAL_DRIVES_H
#define PHYSICS_LOCAL_DRIVES_H

#include "physics/local/rod_model.h"

/* A formula of s and t counts at several places, each of them a drive. */
typedef struct solve_drive {
    const char *key; /* dotted YAML key, static text */
    quantity q;
    double s;     /* m */
    double range; /* its largest value less its smallest, at samples */
    double size;  /* the integral of how far it is from its value at the start, over time */
} solve_drive;

typedef struct solve_drives {
    double unit, end; /* s: of the times below; and how long the motion takes */
    double duration;  /* the same in units */
    size_t count;
    solve_drive *all; /* [count] */
    int panels;       /* on each of which polynomials follow all drives, but for jumps; */
    double *edges;    /* [panels + 1] ascending, from 0 to the duration */
    int breaks;
    double *places;         /* [breaks] which edges are breaks */
    const char *unresolved; /* the key of a formula for which panels are not found; NULL: none */
} solve_drives;

/* Of a rod in motion; the rod must outlive it. AD_NO_MEMORY; AD_NOT_FINITE, with key and time,
 * where one is not finite; errors of formulas. */
ad_status solve_drives_create(const solve_rod *rod, solve_drives **result, ad_error *error);
void solve_drives_free(solve_drives *d);

double solve_drive_at(const solve_drives *d, size_t which, double t);

/* So many equal parts of a panel show all that drives do on it. */
int solve_drives_parts(const solve_drives *d, int panel);

/* How far inside a panel its ends are taken, on their side of a jump there. */
double solve_drives_inside(const solve_drives *d);

#endif
