/* How often something is tried that goes the same ways through the code every time: under
 * sanitizers, where it takes ten times as long, a quarter as often. */
#ifndef TESTS_FEWER_H
#define TESTS_FEWER_H

#ifdef CPINN_SANITIZED
#define WATCHED       1
#define FEWER(n)      (((n) + 3) / 4)
#define FARTHER(step) (4 * (step)) /* from one that is tried to the next */
#else
#define WATCHED       0
#define FEWER(n)      (n)
#define FARTHER(step) (step)
#endif

/* The tests, and unless sanitizers watch those that are alike: every function and branch that these
 * pass, others that are watched pass as well, counted test by test in a build by clang with
 * -fprofile-instr-generate -DCPINN_SANITIZED. */
#define run_with_alike(tests, alike, setup, teardown)                                              \
    (cmocka_run_group_tests(tests, setup, teardown) +                                              \
     (WATCHED ? 0 : cmocka_run_group_tests(alike, setup, teardown)))

#endif
