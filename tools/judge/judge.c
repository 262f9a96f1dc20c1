#include "tools/judge/judge.h"

#include "tools/judge/child.h"
#include "tools/train/clock.h"

#include <math.h>
#include <string.h>

static const struct {
    const char *name, *text;
} measures[JUDGE_MEASURES] = {{"position", "relative L2 error of position"},
                              {"tip", "tip error / length"},
                              {"rotation", "rotation error, rad"}};

const char *judge_method_name(judge_method method)
{
    static const char *const names[JUDGE_METHODS] = {"network", "solver"};
    return names[method];
}

const char *judge_measure_name(judge_measure measure)
{
    return measures[measure].name;
}

const char *judge_measure_text(judge_measure measure)
{
    return measures[measure].text;
}

void judge_measures(const reference_errors *from, double errors[JUDGE_MEASURES])
{
    errors[JUDGE_POSITION] = from->position;
    errors[JUDGE_TIP] = from->tip;
    errors[JUDGE_ROTATION] = from->rotation;
}

void judge_name(char name[JUDGE_NAME], const char *text)
{
    snprintf(name, JUDGE_NAME, "%s", text);
    for (char *byte = name; *byte; byte++) {
        if ((unsigned char)*byte < ' ' || strchr(",\"'/#\x7f", *byte)) {
            *byte = '_';
        }
    }
    for (size_t last = strlen(name); last > 0 && name[last - 1] == ' '; last--) {
        name[last - 1] = '_';
    }
    if (name[0] == '\0') {
        strcpy(name, "_");
    } else if (name[0] == ' ' || name[0] == '.') {
        name[0] = '_';
    }
}

void judge_name_of_file(char name[JUDGE_NAME], const char *path)
{
    const char *slash = strrchr(path, '/');
    judge_name(name, slash ? slash + 1 : path);
    char *dot = strrchr(name, '.');
    if (dot && dot != name) {
        *dot = '\0';
    }
}

/* ---- scenes -------------------------------------------------------------------------------- */

ad_status judge_read(const judge_task *task, config **settings, double *seconds, ad_error *error)
{
    double began = train_seconds();
    ad_status status = prepare_read_member(task->path, NULL, task->override_count, task->overrides,
                                           NULL, settings, error);
    if (seconds) {
        *seconds = train_seconds() - began;
    }
    return status;
}

ad_status judge_open(const judge_task *task, bool own, experiment **e, reference **known,
                     double *seconds, ad_error *error)
{
    config *settings;
    ad_status status = judge_read(task, &settings, seconds, error);
    if (status == AD_OK) {
        status = config_experiment_create(settings, 1, e, error);
    }
    return status == AD_OK && (own || isnan((*e)->settings->reference_tolerance))
               ? reference_create(*e, known, error)
               : status;
}

/* ---- in a process of its own --------------------------------------------------------------- */

judge_row judge_row_empty(void)
{
    return (judge_row){.errors = {NAN, NAN, NAN},
                       .seconds = NAN,
                       .unknowns = NAN,
                       .equations = NAN,
                       .instructions = NAN,
                       .points = NAN,
                       .steps = NAN};
}

static void work(const void *asked, void *result)
{
    const judge_task *task = asked;
    ad_error ignored; /* it is in the verdict */
    if (task->method == JUDGE_NETWORK) {
        judge_by_network(task, result, &ignored);
    } else {
        judge_by_solver(task, result, &ignored);
    }
}

ad_status judge_run(const judge_task *task, judge_row *row, ad_error *error)
{
    child_end end;
    char why[CHILD_WHY];
    double began = train_seconds();
    *row = judge_row_empty();
    ad_status status = child_run(work, task, row, sizeof *row, task->patience, &end, why, error);
    if (status != AD_OK) {
        return status;
    }
    if (end == CHILD_DIED) {
        verdict_add(&row->verdict, VERDICT_DIED, "%s", why);
    } else if (end == CHILD_LATE) { /* only training looks at the clock by itself */
        verdict_add(&row->verdict,
                    task->method == JUDGE_NETWORK ? VERDICT_KILLED : VERDICT_TIME_LIMIT,
                    "killed after %.3g s", task->patience);
    }
    if (end != CHILD_TOLD) {
        row->seconds = train_seconds() - began;
    }
    return AD_OK;
}
