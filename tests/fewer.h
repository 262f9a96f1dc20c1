/* How often something is tried that goes the same ways through the code every time: under
 * sanitizers, where it takes ten times as long, a quarter as often. */
#ifndef TESTS_FEWER_H
#define TESTS_FEWER_H

#ifdef CPINN_SANITIZED
#define FEWER(n) (((n) + 3) / 4)
#else
#define FEWER(n) (n)
#endif

#endif
