#include "tools/programs/residual_rest.h"

#include "physics/numerics/sort.h"
#include "tools/files/json.h"
#include "tools/programs/estimates.h"
#include "tools/programs/residual_scene.h"
#include "tools/train/learned_rest.h"
#include "tools/train/measurements.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const names[LEARNED_KINDS] = {"physics alone", "network alone", "both"};

typedef struct resting {
    const residual_rest_asked *asked;
    residual_scene scene;
    config *open; /* its outputs are unknowns */
    int outputs, inputs;
    const char *input[LEARNED_INPUTS_MAX];
    quantity formula[LEARNED_INPUTS_MAX];
    least_squares_runner runner;
    measurements *data;
    learned_rest *rest;
    learned_result result[LEARNED_KINDS];
} resting;

bool residual_rest_is_meant(const config *settings)
{
    return settings->residual.outputs && !scene_is_dynamic(&settings->scene);
}

/* ---- the scene ----------------------------------------------------------------------------- */

/* Formulas of the inputs, by default all parameters that are known. */
static ad_status read_inputs(resting *x, ad_error *error)
{
    const config_residual *residual = &x->open->residual;
    const scene *open = &x->open->scene;
    x->inputs = residual->input_count ? residual->input_count : scene_given_count(open);
    for (int i = 0; i < x->inputs; i++) {
        char key[40];
        snprintf(key, sizeof key, "residual.inputs[%d]", i);
        x->input[i] = residual->input_count ? residual->inputs[i] : open->parameters[i].name;
        x->formula[i] = residual->input_count ? residual->formula[i]
                                              : quantity_formula(x->open->names, x->input[i]);
        for (int k = open->parameter_count - x->outputs; k < open->parameter_count; k++) {
            const char *name = open->parameters[k].name;
            if (quantity_depends_on(x->formula[i], name) || scene_memory_uses(open, name)) {
                return config_refuse(x->open, key,
                                     "depends on what it says, or a play does; allowed: formulas "
                                     "of the other parameters with a range",
                                     error);
            }
        }
    }
    return x->inputs > 0 ? AD_OK
                         : config_refuse(x->open, "residual.inputs",
                                         "there are none; allowed: formulas of parameters with a "
                                         "range, of which a row of data has the values",
                                         error);
}

/* ---- the search ---------------------------------------------------------------------------- */

static ad_status make(resting *x, ad_error *error)
{
    char key[TRAIN_KEY_MAX] = "data";
    ad_error reason = {.message = ""};
    const scene *open = &x->open->scene;
    ad_status status = measurements_take_squares(&x->open->settings, key, &reason);
    if (status == AD_OK) {
        status = measurements_read(open, &x->open->settings, &x->data, key, &reason);
    }
    if (status == AD_OK) {
        const learned_asked asked = {
            .outputs = x->outputs,
            .inputs = x->inputs,
            .input = x->formula,
            .hidden_count = x->open->residual.hidden_count,
            .hidden = x->open->residual.hidden,
            .common = open->guess + scene_known_count(open),
            .sets = measurements_count(x->data),
            .held_out = measurements_held_out(x->data),
            .measured = measurements_sets(x->data),
            .threads = x->asked->threads,
            .fit = {x->asked->seed, x->asked->folds, x->asked->steps, true, &x->runner}};
        snprintf(key, sizeof key, "data");
        status = learned_rest_create(open, &asked, &x->rest, &reason);
    }
    return status == AD_BAD_INPUT || status == AD_IO
               ? config_refuse(x->open, key, reason.message, error)
           : status != AD_OK ? ad_fail(error, status, "%s", reason.message)
                             : AD_OK;
}

/* ---- for people ---------------------------------------------------------------------------- */

static void print_score(const learned_score *score)
{
    if (score->rows > 0) {
        printf("  %-9.3e %-9.3e %-9.3e %-9.3e %3.0f %3.0f %%", score->mean, score->median,
               score->rms, score->deviation, 100 * score->covered[0], 100 * score->covered[1]);
    } else {
        printf("  %-9s %-9s %-9s %-9s %9s", "-", "-", "-", "-", "-");
    }
}

static void print_table(const resting *x)
{
    printf("%zu poses fitted, %zu rows; %zu rows held out; %d outputs of %d inputs, %zu numbers\n",
           learned_rest_experiments(x->rest), x->result[0].trained.rows, x->result[0].held_out.rows,
           x->outputs, x->inputs, learned_net_count(learned_rest_net(x->rest)));
    printf("%-13s  %-49s  %-49s  seconds\n", "distances, SI",
           "fitted: mean, median, rms, predicted, within 1, 2", "held out");
    for (int i = 0; i < LEARNED_KINDS; i++) {
        const learned_result *result = &x->result[i];
        printf("%-13s", names[i]);
        if (result->made) {
            print_score(&result->trained);
            print_score(&result->held_out);
            printf("  %.1f\n", result->seconds);
        } else {
            puts("  poses have not the same places");
        }
    }
    const learned_report *report = &x->result[LEARNED_BOTH].report;
    printf("ridge %.3g, by poses left out, which miss by %.3g; the measurements determine %.1f "
           "numbers; deviations times %.2f\n",
           report->ridge, report->validation, report->effective, report->calibration);
    for (int i = 0; i < x->open->scene.unknown_count - x->outputs; i++) {
        printf("  %-24s %.6g +- %.2g\n",
               x->open->scene.parameters[scene_known_count(&x->open->scene) + i].name,
               learned_rest_common(x->rest)[i], learned_rest_common_deviation(x->rest, i));
    }
}

/* ---- as JSON ------------------------------------------------------------------------------- */

static void write_score(const char *name, const learned_score *score, json *to)
{
    json_open(to, name, '{');
    json_integer(to, "rows", (long long)score->rows);
    json_number(to, "mean", score->mean);
    json_number(to, "median", score->median);
    json_number(to, "rms", score->rms);
    json_number(to, "predicted", score->deviation);
    json_number(to, "within_1", score->covered[0]);
    json_number(to, "within_2", score->covered[1]);
    json_close(to, '}');
}

static void write_kinds(const resting *x, json *to)
{
    static const char *const kinds[LEARNED_KINDS] = {"physics", "network", "both"};
    for (int i = 0; i < LEARNED_KINDS; i++) {
        const learned_result *result = &x->result[i];
        json_open(to, kinds[i], '{');
        if (result->made) {
            write_score("fitted", &result->trained, to);
            write_score("held_out", &result->held_out, to);
            json_number(to, "seconds", result->seconds);
        }
        json_close(to, '}');
    }
}

static void write_unknowns(const resting *x, json *to)
{
    const scene *open = &x->open->scene;
    json_open(to, "unknowns", '[');
    for (int i = 0; i < open->unknown_count - x->outputs; i++) {
        estimate_open(to, open->parameters[scene_known_count(open) + i].name,
                      learned_rest_common(x->rest)[i], learned_rest_common_deviation(x->rest, i));
        json_close(to, '}');
    }
    json_close(to, ']');
}

static ad_status write_json(const resting *x, ad_error *error)
{
    const learned_report *report = &x->result[LEARNED_BOTH].report;
    json to;
    json_begin(&to);
    json_text(&to, "program", "cpinn-residual");
    json_text(&to, "version", CPINN_VERSION);
    json_text(&to, "scene", x->asked->scene);
    json_integer(&to, "outputs", x->outputs);
    json_integer(&to, "inputs", x->inputs);
    write_kinds(x, &to);
    json_number(&to, "ridge", report->ridge);
    json_number(&to, "effective", report->effective);
    json_number(&to, "calibration", report->calibration);
    json_number(&to, "validation", report->validation);
    write_unknowns(x, &to);
    json_text(&to, "out", x->asked->out);
    return json_end(&to, x->asked->json, error);
}

/* ---- leaving out --------------------------------------------------------------------------- */

static ad_status leave_out(const resting *x, ad_error *error)
{
    const residual_rest_asked *asked = x->asked;
    double *distance = NULL, *one = NULL;
    int count = 0;
    ad_status status = AD_OK;
    if (asked->left_out > 0) {
        status = learned_rest_leave_out(x->rest, asked->left_out, asked->choices, &distance, &count,
                                        error);
        one = malloc(((size_t)count + 1) * sizeof *one);
    }
    for (int kind = 0; kind < LEARNED_KINDS && status == AD_OK && one; kind++) {
        double sum = 0;
        for (int i = 0; i < count; i++) {
            one[i] = distance[i * LEARNED_KINDS + kind];
            sum += one[i] / count;
        }
        const double median = sort_median((size_t)count, one);
        printf("%d poses left out, %d choices, %-13s  mean %.3e, median %.3e, largest %.3e\n",
               asked->left_out, count, names[kind], sum, median, one[count - 1]);
    }
    free(distance);
    free(one);
    return status;
}

/* ---- all of it ----------------------------------------------------------------------------- */

static ad_status save(const resting *x, ad_error *error)
{
    learned_file file = {.net = *learned_rest_net(x->rest), .anew = NAN};
    const scene *open = &x->open->scene;
    const int unknowns = open->unknown_count - x->outputs;
    file.inputs.count = x->inputs;
    file.outputs.count = x->outputs;
    file.unknowns.count = unknowns;
    for (int i = 0; i < x->inputs; i++) {
        file.inputs.name[i] = x->input[i];
    }
    for (int i = 0; i < x->outputs; i++) {
        file.outputs.name[i] = x->scene.name[i];
    }
    for (int i = 0; i < unknowns; i++) {
        file.unknowns.name[i] = open->parameters[scene_known_count(open) + i].name;
        file.value[i] = learned_rest_common(x->rest)[i];
    }
    file.noise = learned_rest_noise(x->rest);
    file.theta = learned_rest_theta(x->rest);
    file.covariance = learned_rest_covariance(x->rest);
    return learned_file_write(&file, x->asked->out, error);
}

static ad_status learn(resting *x, ad_error *error)
{
    bool over = true;
    ad_status status = AD_OK;
    for (int i = 0; i < LEARNED_KINDS && status == AD_OK && over; i++) {
        status = learned_rest_run(x->rest, (learned_kind)i, &x->result[i], &over, error);
    }
    if (status != AD_OK || !over) {
        return status;
    }
    const bool quiet = json_is_printed(x->asked->json);
    if (!quiet) {
        print_table(x);
    }
    status = save(x, error);
    if (status == AD_OK && !quiet) {
        printf("wrote %s, for residual.file\n", x->asked->out);
    }
    status = status == AD_OK && x->asked->json ? write_json(x, error) : status;
    return status == AD_OK ? leave_out(x, error) : status;
}

ad_status residual_rest(const residual_rest_asked *asked, ad_error *error)
{
    resting *x = calloc(1, sizeof *x);
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a residual");
    }
    x->asked = asked;
    x->runner = fit_run_by(asked->run);
    ad_status status = residual_scene_open(asked->scene, asked->overrides, &x->scene, error);
    x->open = x->scene.open;
    x->outputs = x->scene.outputs;
    status = status == AD_OK ? read_inputs(x, error) : status;
    status = status == AD_OK
                 ? fit_run_ask(asked->run, x->open, error,
                               "# residual at rest: steps %d, folds %d, seed %llu\n", asked->steps,
                               asked->folds, (unsigned long long)asked->seed)
                 : status;
    status = status == AD_OK ? make(x, error) : status;
    status = status == AD_OK ? learn(x, error) : status;
    learned_rest_free(x->rest);
    measurements_free(x->data);
    residual_scene_free(&x->scene);
    free(x);
    return status;
}
