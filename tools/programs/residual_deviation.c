#include "tools/programs/residual_deviation.h"

#include "physics/chain/solve_members.h"
#include "tools/programs/residual_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { TIP = 3 };

/* Of half of the span of an input where it was trained: beyond this it is said. */
static const double BEYOND = 1.02;

/* Alone a member is the first row of a path: states of plays are 0. */
typedef struct learned_member {
    residual_scene scene;
    const learned_file *file;
    learned_tape *tape;
    size_t known, unknowns, outputs, theta; /* parameters, found numbers, of the network */
    double parameters[SCENE_PARAMETERS_MAX];
    double x[LEARNED_INPUTS_MAX], y[LEARNED_OUTPUTS_MAX];
    double *by; /* [theta][outputs] */
} learned_member;

static void learned_member_free(learned_member *of)
{
    residual_scene_free(&of->scene);
    learned_tape_free(of->tape);
    free(of->by);
}

/* The values of given and found parameters, then what the network says of them. */
static ad_status place(learned_member *to, const char *at, ad_error *error)
{
    const scene *open = &to->scene.open->scene;
    const learned_file *file = to->file;
    const char *names[SCENE_PARAMETERS_MAX];
    ad_status status = scene_member_read(scene_given_count(open), open->parameters, false,
                                         at ? at : "", to->parameters, error);
    for (int i = 0; i < open->parameter_count; i++) {
        names[i] = open->parameters[i].name;
        for (int k = 0; k < file->unknowns.count; k++) {
            if (strcmp(names[i], file->unknowns.name[k]) == 0) {
                to->parameters[i] = file->value[k];
            }
        }
    }
    for (int i = 0; i < file->net.inputs && status == AD_OK; i++) {
        const quantity input = quantity_formula(to->scene.open->names, file->inputs.name[i]);
        to->x[i] = quantity_value_with(input, 0, 0, open->parameter_count - (int)to->outputs, names,
                                       to->parameters);
    }
    if (status == AD_OK) {
        status = learned_tape_run(to->tape, &file->net, 1, to->x, file->theta, to->y, to->by, NULL,
                                  error);
    }
    for (size_t k = 0; k < to->outputs; k++) {
        to->parameters[open->parameter_count - (int)(to->outputs - k)] = to->y[k];
    }
    return status;
}

/* g [unknowns + theta] of one coordinate, of its derivatives by what is found and by outputs. */
static void chain(const learned_member *of, const double *by, double *g)
{
    const scene *open = &of->scene.open->scene;
    for (size_t i = 0; i < of->unknowns; i++) {
        const scene_parameter *p = &open->parameters[of->known + i];
        const double z = scene_parameter_fraction(p, of->parameters[of->known + i]);
        g[i] = by[i] * scene_parameter_slope(p, of->parameters[of->known + i]) * z * (1 - z);
    }
    for (size_t t = 0; t < of->theta; t++) {
        g[of->unknowns + t] = 0;
        for (size_t k = 0; k < of->outputs; k++) {
            g[of->unknowns + t] += by[of->unknowns + k] * of->by[t * of->outputs + k];
        }
    }
}

static double deviation(const learned_member *of, const double *g)
{
    const size_t n = of->unknowns + of->theta;
    double variance = 0;
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < n; k++) {
            variance += g[i] * of->file->covariance[i * n + k] * g[k];
        }
    }
    return sqrt(fmax(0, variance));
}

/* The tip by what is found and by outputs. */
static ad_status differentiate(const learned_member *of, int threads, residual_deviation *result,
                               ad_error *error)
{
    const scene *open = &of->scene.open->scene;
    const double length = scene_length(open);
    const solve_members_settings settings = {
        .tolerance = 1e-8, .threads = threads, .points = 1, .s = &length, .own_curvature = true};
    const size_t width = of->unknowns + of->outputs;
    solve_member solved;
    solve_members *members = NULL;
    ad_error reason;
    if (solve_members_create(open, &settings, &members, &reason) != AD_OK) {
        return reason.status == AD_NO_MEMORY ? ad_fail(error, AD_NO_MEMORY, "%s", reason.message)
                                             : AD_OK;
    }
    double *curvature = malloc(solve_members_numbers(members) * sizeof *curvature);
    double *by = malloc(SOLVE_MEMBERS_COLUMNS * width * sizeof *by);
    double *g = malloc((of->unknowns + of->theta) * sizeof *g);
    ad_status status =
        curvature && by && g
            ? solve_members_curvature(members, 1, of->parameters, NULL, curvature, &solved, error)
            : ad_fail(error, AD_NO_MEMORY, "out of memory for deviations");
    if (status == AD_OK && solved.solved) {
        status = solve_members_jacobian(members, 1, of->parameters, curvature, (int)of->known, by,
                                        error);
        result->known = status == AD_OK;
        for (int c = 0; c < TIP && status == AD_OK; c++) {
            chain(of, by + (size_t)c * width, g);
            result->tip[c] = deviation(of, g);
        }
    }
    solve_members_free(members);
    free(curvature);
    free(by);
    free(g);
    return status;
}

/* How far inputs are from what it was trained on. */
static void look_beyond(const learned_member *of, residual_deviation *result)
{
    const learned_net *net = &of->file->net;
    double most = BEYOND;
    for (int i = 0; i < net->inputs; i++) {
        const double off = fabs(of->x[i] - net->middle[i]) / net->half[i];
        result->beyond += off > BEYOND;
        if (off > most) {
            most = off;
            snprintf(result->text, sizeof result->text, "%s is %.4g, trained from %.4g to %.4g",
                     of->file->inputs.name[i], of->x[i], net->middle[i] - net->half[i],
                     net->middle[i] + net->half[i]);
        }
    }
}

/* Whether unknowns are those of the file: a scene may have values of its own for some. */
static bool fits(const learned_member *of)
{
    const scene *open = &of->scene.open->scene;
    bool same = of->outputs == (size_t)of->scene.outputs &&
                (size_t)open->unknown_count == of->unknowns + of->outputs;
    for (size_t i = 0; same && i < of->unknowns; i++) {
        same = strcmp(open->parameters[of->known + i].name, of->file->unknowns.name[i]) == 0;
    }
    for (size_t k = 0; same && k < of->outputs; k++) {
        same = strcmp(of->scene.name[k], of->file->outputs.name[k]) == 0;
    }
    return same;
}

ad_status residual_deviation_find(const config *settings, const char *path,
                                  const cli_list *overrides, const char *at, int threads,
                                  residual_deviation *result, ad_error *error)
{
    learned_member of = {.file = settings->residual.saved};
    *result = (residual_deviation){.noise = NAN};
    if (!of.file || scene_is_dynamic(&settings->scene)) {
        return AD_OK;
    }
    ad_status status = residual_scene_open(path, overrides, &of.scene, error);
    if (status == AD_OK) {
        of.known = (size_t)scene_known_count(&of.scene.open->scene);
        of.unknowns = (size_t)of.file->unknowns.count;
        of.outputs = (size_t)of.file->net.outputs;
        of.theta = learned_net_count(&of.file->net);
        of.by = malloc(of.outputs * of.theta * sizeof *of.by);
        status = of.by ? learned_tape_create(&of.file->net, &of.tape, error)
                       : ad_fail(error, AD_NO_MEMORY, "out of memory for deviations");
    }
    if (status == AD_OK && fits(&of)) {
        result->noise = of.file->noise;
        status = place(&of, at, error);
        look_beyond(&of, result);
        status = status == AD_OK ? differentiate(&of, threads, result, error) : status;
    }
    learned_member_free(&of);
    return status;
}

void residual_deviation_judge(const residual_deviation *of, verdict *to)
{
    if (of->beyond > 0) {
        verdict_add(to, VERDICT_OUTSIDE_DATA,
                    "%d input%s of the learned residual %s beyond what it was trained on: %s",
                    of->beyond, of->beyond > 1 ? "s" : "", of->beyond > 1 ? "are" : "is", of->text);
    }
}

void residual_deviation_print(const residual_deviation *of)
{
    if (of->known) {
        printf("  tip, deviation of what was learned  %.3g %.3g %.3g m", of->tip[0], of->tip[1],
               of->tip[2]);
        if (isfinite(of->noise)) {
            printf("; of what is measured beside it %.3g", of->noise);
        }
        printf("\n");
    }
}

void residual_deviation_json(const residual_deviation *of, json *to)
{
    if (!of->known) {
        json_null(to, "residual");
        return;
    }
    json_open(to, "residual", '{');
    json_open(to, "tip_standard_deviation", '[');
    for (int c = 0; c < TIP; c++) {
        json_number(to, NULL, of->tip[c]);
    }
    json_close(to, ']');
    json_number(to, "measured_standard_deviation", of->noise);
    json_integer(to, "inputs_beyond", of->beyond);
    json_close(to, '}');
}
