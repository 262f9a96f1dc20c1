#include "physics/solve/static_survey.h"

#include "physics/numerics/quaternion.h"
#include "physics/numerics/vector_size.h"

#include <math.h>

enum { SAMPLES = 33, POWERS = 3 };

static bool is_round(const solve_section *section)
{
    const double *k = section->stiffness;
    return k[3] == k[4] && k[0] == k[1];
}

typedef struct sums {
    static_survey result;
    double bent[POWERS], total[POWERS];
    bool by_panels;
} sums;

/* What is given at s, which stands for so much of the rod. */
static void add_point(sums *sum, double lever, double weight, const solve_section *section,
                      const solve_rest *rest, const acting_size *load)
{
    static_survey *to = &sum->result;
    double curvature = vector_length(rest->curvature),
           sideways = hypot(rest->strain[0], rest->strain[1]);
    const double *bends = section->compliance + 3;
    for (int power = 0; power < POWERS; power++) {
        sum->bent[power] += weight * (pow(lever, power) * fmax(bends[0], bends[1]));
        sum->total[power] += weight * pow(lever, power);
    }
    to->round = to->round && is_round(section);
    to->straight = to->straight && sideways == 0 && curvature == 0 && !load->follows;
    if (sum->by_panels) {
        to->force += weight * load->force;
        to->moment += weight * load->moment;
        to->curvature += weight * curvature;
    } else {
        to->spread = fmax(to->spread, load->force);
        to->couple = fmax(to->couple, load->moment);
        to->curvature = fmax(to->curvature, curvature);
    }
}

/* n <= SAMPLES */
static ad_status add_points(const solve_rod *rod, int n, const double *s, const double *weight,
                            sums *sum, ad_error *error)
{
    bool start = rod->ends[0].hold.directions > 0, end = rod->ends[1].hold.directions > 0;
    solve_section sections[SAMPLES];
    solve_rest rest[SAMPLES];
    solve_initial shape[SAMPLES];
    double along[SAMPLES * ACTING_ALONG_MAX];
    ad_status status = solve_rod_sections(rod, (size_t)n, s, sections, error);
    status = status == AD_OK ? solve_rod_rest(rod, (size_t)n, s, 0, rest, error) : status;
    status = status == AD_OK ? solve_rod_initial(rod, (size_t)n, s, shape, error) : status;
    status = status == AD_OK ? solve_rod_along(rod, (size_t)n, s, 0, along, error) : status;
    for (int i = 0; i < n && status == AD_OK; i++) {
        double lever = start == end ? 1 : start ? 1 - s[i] : s[i];
        acting_size load = {.force = 0};
        acting_measure(&rod->along, along + i * rod->along.numbers,
                       (acting_on){shape[i].position, shape[i].rotation, NULL}, &load);
        add_point(sum, lever, weight[i], &sections[i], &rest[i], &load);
    }
    return status;
}

ad_status static_survey_of(const solve_rod *rod, static_survey *result, ad_error *error)
{
    const solve_quadrature *along = rod->quadrature;
    sums sum = {.result = {.straight = true, .round = true}, .by_panels = along->count > 1};
    double s[SAMPLES], weight[SAMPLES];
    ad_status status = AD_OK;
    if (!sum.by_panels) {
        for (int i = 0; i < SAMPLES; i++) {
            s[i] = (double)i / (SAMPLES - 1);
            weight[i] = 1;
        }
        status = add_points(rod, SAMPLES, s, weight, &sum, error);
    }
    for (int p = 0; sum.by_panels && p < along->count && status == AD_OK; p++) {
        double first = along->edges[p], width = along->edges[p + 1] - first;
        for (int i = 0; i < along->rule.stages; i++) {
            s[i] = first + width * along->rule.nodes[i];
            weight[i] = width * along->rule.weights[i];
        }
        status = add_points(rod, along->rule.stages, s, weight, &sum, error);
    }
    for (int power = 0; power < POWERS; power++) {
        sum.result.softness[power] = sum.bent[power] / sum.total[power];
    }
    *result = sum.result;
    return status;
}
