/* What all forms of a rod share in which solvers find it. */
#ifndef PHYSICS_LOCAL_METHOD_H
#define PHYSICS_LOCAL_METHOD_H

#ifdef __cplusplus
extern "C" {
#endif

/* How equilibria of rods at rest and, the last, motions are found; names of methods in this order,
 * NULL at the end. */
typedef enum solve_method {
    SOLVE_COLLOCATION, /* position, rotation, force and moment at Gauss points */
    SOLVE_MODES        /* strain modes (physics/chain/modes.h) of a rod in motion that is held at
                        * its start alone */
} solve_method;
const char *const *solve_method_names(void);

enum { SOLVE_MODES_MAX = 24 }; /* of one strain and piece of the rod */

/* A rod seen at one s, in SI units: position, rotation, velocity, all in the world, and angular
 * velocity in the body frame; the columns x to w3 of its model. */
typedef struct solve_seen {
    double s, position[3], rotation[4], velocity[3], spin[3];
} solve_seen;

/* Of the whole rod, J. At rest `work` is that of dead forces, at their full size all along the way
 * from the unstressed rod, and of actuators: minus their potential. It is NaN with
 * friction, and under moments and follower loads, which have no potential. */
typedef struct solve_energy {
    double kinetic, strain; /* bodies and springs among them */
    double work;            /* of loads, and of what moves ends and rest shape, since t = 0 */
    double dissipated;      /* by damping and drag since t = 0, >= 0 */
    double mismatch; /* kinetic + strain + dissipated - work, less its value at t = 0: errors of
                      * integration in t; NaN at rest */
} solve_energy;

#ifdef __cplusplus
}
#endif

#endif
