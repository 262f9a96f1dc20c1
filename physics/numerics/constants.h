/* Numbers of mathematics that several files need; not for others. */
#ifndef PHYSICS_NUMERICS_CONSTANTS_H
#define PHYSICS_NUMERICS_CONSTANTS_H

static const double PI = 3.14159265358979323846;

#endif
