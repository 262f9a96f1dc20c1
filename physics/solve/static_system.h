/* The static rod on a mesh: collocation at Gauss points of elements, and one Newton step of it. The
 * points within an element are eliminated element by element, what remains is a band matrix. */
#ifndef PHYSICS_SOLVE_STATIC_SYSTEM_H
#define PHYSICS_SOLVE_STATIC_SYSTEM_H

#include "physics/local/static_rod.h"
#include "physics/numerics/gauss.h"

/* Where the path from the unstressed rod to the loaded one has arrived. */
typedef struct static_path {
    double load;         /* of the loads, and of the way of held ends from the unstressed shape */
    double ahead;        /* share of that way that they have gone before the loads */
    double imperfection; /* factor of the one that the scene names */
    double perturbation; /* body force per length */
    int director;        /* along d1 (0) or d2 (1) */
    double spring;       /* at the ends of a rod whose rotation none of them holds; EI/L */
    double twist_spring; /* the same about the tangent alone */
    double plane_spring; /* the same about the axes in the plane of the tangent and the director */
    double stretch;      /* axial compliance added; L^2/EI */
} static_path;

typedef struct static_system static_system;

/* Elements between edges [elements + 1] from 0 to 1, each place of rod->jumps among them; the rod
 * must outlive the system. */
ad_status static_system_create(const solve_rod *rod, int stages, int elements, const double *edges,
                               static_system **result, ad_error *error);
void static_system_free(static_system *system);

int static_system_rows(const static_system *system); /* of y at one place */
int static_system_elements(const static_system *system);
const double *static_system_edges(const static_system *system);
const gauss_rule *static_system_rule(const static_system *system);

/* Unknowns: y at s = 0; then for each element y at its points and at its end. Where something acts
 * at an edge (physics/local/jump.h) that y is the one before it, at s = 0 outside of the rod. */
size_t static_system_unknowns(const static_system *system);

/* s of all of them, [unknowns/rows]. */
void static_system_points(const static_system *system, double *s);

/* y of the unstressed rod; of a manufactured scene its solution. */
ad_status static_system_guess(const static_system *system, double *y, ad_error *error);

/* Which of rod->jumps is at an edge; -1: none. */
int static_system_jump(const static_system *system, int edge);

/* start [rows]: y with which an element begins, beyond what acts there. */
void static_system_start(const static_system *system, const double *y, int element, double *start);

void static_system_set(static_system *system, const static_path *path);
double static_system_imperfection(const static_system *system); /* of that path */
double static_system_load(const static_system *system);         /* the same */

const solve_rod *static_system_rod(const static_system *system);

/* Tensions [SOLVE_ACTUATORS_MAX] of tendons whose length is given, by EI/L^2; 0 at first. */
double *static_system_tensions(static_system *system);

/* Of the `point`th of actuators [..][those of the rod], at s, where the path is. */
solve_actuation static_system_actuation(const static_system *system,
                                        const solve_actuator *actuators, size_t point, double s);

/* The element that ends at s or goes on there. */
int static_system_element(const static_system *system, double s);

/* excess [actuators of the rod]: by how much a tendon whose length is given is longer at y, 0 of
 * the others. */
void static_system_excess(const static_system *system, const double *y, double *excess);

/* Left minus right sides [unknowns]: conditions at s = 0, equations of each element, conditions at
 * s = 1. */
void static_system_residual(static_system *system, const double *y, double *residual);

/* y_s [n][rows] for y at any s [n] in [0, 1], where the path is. */
ad_status static_system_rates(const static_system *system, size_t n, const double *s,
                              const double *y, double *rate, ad_error *error);

/* Derivatives at y; factored: 0, or not when they are singular. */
void static_system_linearise(static_system *system, const double *y);
int static_system_factor(static_system *system);

/* The step [unknowns] with J step = right. */
void static_system_solve(static_system *system, const double *right, double *step);

#endif
