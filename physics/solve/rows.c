#include "physics/solve/rows.h"

ad_status solve_rows(const scene *open, const solve_settings *settings, size_t rows,
                     const double *parameters, solve_row_taken *take, void *context,
                     ad_error *error)
{
    solve_settings asked = *settings;
    solution *last = NULL;
    ad_status status = AD_OK;
    for (size_t i = 0; i < rows && status == AD_OK; i++) {
        scene member;
        solution *here = NULL;
        solve_report report;
        scene_member(open, parameters + i * (size_t)open->parameter_count, &member);
        asked.before = last;
        status = solution_create(&member, &asked, 0, NULL, &here, &report, error);
        status = status == AD_OK ? take(context, i, &member, here, &report, error) : status;
        const bool goes_on = status == AD_OK && report.load_fraction == 1;
        solution_free(goes_on ? last : here);
        last = goes_on ? here : last;
    }
    solution_free(last);
    return status;
}
