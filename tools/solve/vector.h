/* Vectors for SUNDIALS whose loops this project compiles: those of its library are many times
 * slower where a distribution builds it without optimisation, as Debian does. */
#ifndef TOOLS_SOLVE_VECTOR_H
#define TOOLS_SOLVE_VECTOR_H

#include <nvector/nvector_serial.h>

#include <stddef.h>

/* Serial, of `rows` numbers; NULL when memory runs out. Clones have the same loops. */
N_Vector vector_create(size_t rows, SUNContext context);

#endif
