#include "tools/programs/control_replay.h"

#include "tools/files/file_bytes.h"
#include "tools/programs/control_judge.h"
#include "tools/programs/estimates.h"
#include "tools/train/measurements.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double MILLI = 1e3, MICRO = 1e6;

/* ---- running ------------------------------------------------------------------------------- */

/* The inputs of recording `number`, and the first set that has rows of it; NULL: there is none. */
static const solve_inputs *find_recording(int sets, const solve_measured *all, int number, int *set)
{
    for (*set = 0; *set < sets; ++*set) {
        const solve_measured *of = &all[*set];
        for (size_t row = 0; of->inputs && row < of->rows; row++) {
            if (of->inputs[row] && of->inputs[row]->number == number) {
                return of->inputs[row];
            }
        }
    }
    return NULL;
}

static ad_status run_all(const config *of, const loop_setup *setup, const measurements *data,
                         const replay_settings *settings, replays *x, ad_error *error)
{
    const solve_measured *all = measurements_sets(data);
    const int fitted = measurements_count(data), sets = fitted + measurements_held_out(data);
    ad_status status = AD_OK;
    int set;
    for (int number = 1; status == AD_OK; number++) {
        const solve_inputs *inputs = find_recording(sets, all, number, &set);
        if (!inputs || x->count == REPLAYS_MAX) {
            break;
        }
        const char *file = of->settings.data[measurements_entry(data, set)].file;
        snprintf(x->name[x->count], sizeof x->name[0], "%.79s", file_bytes_name(file));
        x->held_out[x->count] = set >= fitted;
        status = replay_run(setup, sets, all, inputs, settings, &x->report[x->count], error);
        x->count += status == AD_OK;
    }
    return status != AD_OK || x->count > 0
               ? status
               : ad_fail(error, AD_BAD_INPUT,
                         "no file has inputs over time; a replay needs recordings, in which "
                         "parameters with a range have several values");
}

ad_status replays_run(const config *of, const loop_setup *setup, const replay_settings *settings,
                      replays *result, ad_error *error)
{
    measurements *data = NULL;
    char key[TRAIN_KEY_MAX] = "data";
    ad_error reason = {.message = ""};
    *result = (replays){.ahead = settings->ahead, .estimates = setup->control->estimate_count};
    ad_status status = measurements_take_squares(&of->settings, key, &reason);
    status = status != AD_OK
                 ? status
                 : measurements_read_beside(&of->scene, &of->settings, result->estimates,
                                            setup->control->estimate, &data, key, &reason);
    if (status == AD_OK) {
        snprintf(key, sizeof key, "data");
        status = run_all(of, setup, data, settings, result, &reason);
    }
    measurements_free(data);
    return status == AD_BAD_INPUT || status == AD_IO ? config_refuse(of, key, reason.message, error)
           : status == AD_OK                         ? AD_OK
                                                     : ad_fail(error, status, "%s", reason.message);
}

/* ---- for people ---------------------------------------------------------------------------- */

void replays_print(const config *of, const replays *x, const char *model)
{
    printf("%s: %d recording%s; model %s\n\n", of->settings.name, x->count,
           x->count == 1 ? "" : "s", model);
    printf("%-34s %17s  %17s  %8s\n", "", "a sample ahead", "", "filter");
    printf("%-34s %8s %8s  %8s %8s  %8s  %s\n", "distance of markers, rms (mm)", "model", "still",
           "model", "still", "(us)", "estimate (recorded)");
    for (int i = 0; i < x->count; i++) {
        const replay_report *r = &x->report[i];
        printf("%-24.24s %9s %8.3g %8.3g  %8.3g %8.3g  %8.3g ", x->name[i],
               x->held_out[i] ? "held out" : "", MILLI * r->step, MILLI * r->step_still,
               MILLI * r->ahead, MILLI * r->ahead_still, MICRO * r->seconds);
        for (int k = 0; k < x->estimates; k++) {
            printf("%s %s %.4g +- %.2g", k ? "," : "", of->control.estimate[k], r->estimate[k],
                   r->deviation[k]);
            if (!isnan(r->recorded[k])) {
                printf(" (%.4g)", r->recorded[k]);
            }
        }
        putchar('\n');
    }
    printf("\n  the right columns are %.4g s ahead, with the inputs that were recorded\n",
           x->ahead);
}

void replays_json(const config *of, const replays *x, json *to)
{
    json_number(to, "ahead", x->ahead);
    json_open(to, "recordings", '[');
    for (int i = 0; i < x->count; i++) {
        const replay_report *r = &x->report[i];
        json_open(to, NULL, '{');
        json_text(to, "name", x->name[i]);
        json_integer(to, "held_out", x->held_out[i]);
        json_integer(to, "samples", (long)r->samples);
        json_number(to, "period", r->period);
        json_number(to, "step", r->step);
        json_number(to, "step_still", r->step_still);
        json_number(to, "ahead", r->ahead);
        json_number(to, "ahead_still", r->ahead_still);
        json_integer(to, "refused", r->refused);
        json_number(to, "doubt", r->doubt);
        control_residual_json(&r->residual, to);
        json_number(to, "filter_seconds", r->seconds);
        estimates_json(to, x->estimates, of->control.estimate, r->estimate, r->deviation,
                       "recorded", r->recorded);
        json_close(to, '}');
    }
    json_close(to, ']');
}

/* ---- judging ------------------------------------------------------------------------------- */

void replays_judge(const config *of, const replays *x, verdict *to)
{
    static const double ESTIMATE_OFF = 5, DOUBT = 2; /* as of simulated loops */
    for (int i = 0; i < x->count; i++) {
        const replay_report *r = &x->report[i];
        control_judge_residual(&r->residual, x->name[i], to);
        if (r->doubt > DOUBT) {
            verdict_add(to, VERDICT_INNOVATIONS,
                        "%s: innovations are not those of the model: what it leaves out is %.3g "
                        "times what it was said to; deviations of what is estimated are taken as "
                        "many times",
                        x->name[i], r->doubt);
        }
        for (int k = 0; k < x->estimates; k++) {
            const double off = fabs(r->estimate[k] - r->recorded[k]);
            if (off > ESTIMATE_OFF * r->deviation[k]) {
                verdict_add(to, VERDICT_ESTIMATE_OFF,
                            "%s: %.60s is found as %.4g, %.2g standard deviations off what the "
                            "file says, %.4g: the robot differs from the model in something else",
                            x->name[i], of->control.estimate[k], r->estimate[k],
                            off / r->deviation[k], r->recorded[k]);
            }
        }
    }
}
