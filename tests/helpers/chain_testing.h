/* For tests: a scene at rest by the strain form, as members of families are solved. */
#ifndef TESTS_CHAIN_TESTING_H
#define TESTS_CHAIN_TESTING_H

#include "near.h"

#include "physics/chain/solve_members.h"

/* values [count][SOLVE_MEMBERS_COLUMNS] at s [count], m, ascending. */
static inline void solve_by_chain(const scene *of, double tolerance, size_t count, const double *s,
                                  double *values)
{
    const solve_members_settings settings = {
        .tolerance = tolerance, .threads = 1, .points = count, .s = s};
    ad_error error = {.message = ""};
    solve_members *members = NULL;
    solve_member result;
    if (solve_members_create(of, &settings, &members, &error) != AD_OK ||
        solve_members_solve(members, 1, NULL, values, &result, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    if (!result.solved) {
        fail_msg("%s, estimate %g", solve_member_text(result.end), result.estimate);
    }
    solve_members_free(members);
}

#endif
