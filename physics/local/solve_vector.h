/* Vectors for SUNDIALS whose loops this project compiles: those of its library are many times
 * slower where a distribution builds it without optimisation, as Debian does. */
#ifndef PHYSICS_LOCAL_SOLVE_VECTOR_H
#define PHYSICS_LOCAL_SOLVE_VECTOR_H

#include <nvector/nvector_serial.h>

#include <stdbool.h>
#include <stddef.h>

/* Serial, of `rows` numbers; NULL when memory runs out. Clones have the same loops. */
N_Vector solve_vector_create(size_t rows, SUNContext context);

/* Whether there is memory for what SUNDIALS clones of such a vector, which it does without looking:
 * asked before one of its solvers is created. */
bool solve_vectors_fit(size_t rows);

/* weight = 1 / (tolerance (1 + |x|)) */
void solve_vector_weigh(double tolerance, N_Vector x, N_Vector weight);

bool solve_vector_is_finite(N_Vector x);

#endif
