/* Whether the equilibria of an optimum are stable. Members see that by their energy, which loads
 * that follow the rod do not have. */
#include "tools/optimize/optimize.h"

#include "physics/solve/solve.h"

/* Cases that are looked at, spread over all, and how exactly they are solved. */
enum { LOOKED_AT = 8 };
static const double TOLERANCE = 1e-6;

/* true: this one is not stable, and it is said. */
static bool judge(const scene *one, size_t number, verdict *to)
{
    ad_error unused;
    solution *found = NULL;
    solve_report report;
    solve_settings settings = solve_settings_default(one);
    verdict said = {.count = 0};
    settings.tolerance = TOLERANCE;
    if (solution_create(one, &settings, 0, NULL, &found, &report, &unused) == AD_OK) {
        solution_verdict(found, one, &settings, &report, &said);
    }
    solution_free(found);
    for (int i = 0; i < said.count; i++) {
        if (said.findings[i].reason == VERDICT_UNSTABLE) {
            verdict_add(to, VERDICT_UNSTABLE, "case %zu: %.400s", number, said.findings[i].text);
            return true;
        }
    }
    return false;
}

void optimize_judge_stability(const optimization *of, const scene *family, verdict *to)
{
    const size_t cases = optimize_cases(of), count = cases < LOOKED_AT ? cases : LOOKED_AT;
    bool lost = false;
    for (size_t k = 0; k < count && !lost; k++) {
        const size_t i = k * cases / count;
        double values[SCENE_PARAMETERS_MAX];
        scene one;
        for (int p = 0; p < family->parameter_count; p++) {
            values[p] = optimize_parameter(of, i, p);
        }
        scene_member(family, values, &one);
        lost = judge(&one, i + 1, to);
    }
}
