/* What an answer is called: the form of its equations. */
#ifndef TOOLS_PROGRAMS_FORM_H
#define TOOLS_PROGRAMS_FORM_H

#include "tools/train/experiment.h"
#include "tools/train/reference.h"

enum { FORM_TEXT = 40 }; /* bytes of a form, the end included */

/* Form of the equations and functions by which a network answers: "strain modes by polynomials",
 * "mixed form by random waves", "mixed form by a network" (with hidden layers). */
void form_of_network(const experiment *e, char text[FORM_TEXT]);

/* And the solver, by its method: "spectral elements", "collocation", "strain modes". */
const char *form_of_solver(const scene *rod_scene, solve_method method);

/* Outputs of the network and equations at a point inside. */
int form_unknowns(const experiment *e);
int form_equations(const experiment *e);

#endif
