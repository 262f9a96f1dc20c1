/* A residual as a file of a learned network, whose outputs are rates of states. */
#include "tools/control/residual_internal.h"

#include "physics/numerics/vector_size.h"
#include "tools/train/learned_file.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Names of what a network of so many states and inputs sees, of which the first are its outputs. */
typedef struct seen_names {
    char text[LEARNED_WIDTH_MAX][32];
} seen_names;

static void name_all(size_t states, size_t seen, seen_names *names)
{
    for (size_t i = 0; i < seen; i++) {
        const bool is_state = i < states;
        snprintf(names->text[i], sizeof names->text[i], "%s %zu", is_state ? "state" : "input",
                 1 + i - (is_state ? 0 : states));
    }
}

ad_status residual_write(const residual *residual, const char *path, ad_error *error)
{
    seen_names names;
    learned_file file = {.net = residual->net,
                         .inputs.count = residual->net.inputs,
                         .outputs.count = residual->net.outputs,
                         .theta = residual->theta,
                         .covariance = residual->covariance,
                         .noise = residual->noise,
                         .seen_count = residual->values,
                         .seen = residual->sight,
                         .anew = residual->anew,
                         .trained = residual->reach.trained};
    name_all(residual->states, residual->seen, &names);
    for (int i = 0; i < file.inputs.count; i++) {
        file.inputs.name[i] = file.outputs.name[i] = names.text[i];
    }
    return learned_file_write(&file, path, error);
}

/* Whether it sees these states, and inputs of these ranges. */
static bool fits(const learned_file *file, const one_step *of, const scene_parameter *ranges)
{
    const learned_net *net = &file->net;
    const int n = of->states, m = of->inputs;
    const size_t count = learned_net_count(net);
    bool same =
        net->outputs == n && net->inputs == n + m && net->hidden_count == 1 &&
        file->unknowns.count == 0 && file->seen_count > 0 && file->seen_count <= count &&
        file->anew > 0 && isfinite(file->anew) && file->noise >= 0 && file->trained > 0 &&
        isfinite(file->trained) && vector_is_finite(file->seen_count * (size_t)n, file->seen) &&
        vector_is_finite(count, file->theta) && vector_is_finite(count * count, file->covariance) &&
        vector_is_finite((size_t)n, net->size);
    seen_names names;
    if (same) {
        name_all((size_t)n, (size_t)n + (size_t)m, &names);
    }
    for (int i = 0; same && i < n + m; i++) {
        same = strcmp(file->inputs.name[i], names.text[i]) == 0 && net->half[i] > 0 &&
               isfinite(net->half[i]);
    }
    for (int i = 0; same && i < m; i++) {
        const double low = net->middle[n + i] - net->half[n + i];
        const double high = net->middle[n + i] + net->half[n + i];
        const double slack = 1e-9 * (ranges[i].high - ranges[i].low);
        same = fabs(low - ranges[i].low) <= slack && fabs(high - ranges[i].high) <= slack;
    }
    return same;
}

ad_status residual_read(const char *path, const one_step *of, const scene_parameter *ranges,
                        residual **result, ad_error *error)
{
    learned_file file;
    const size_t length = strlen(path);
    *result = NULL;
    if (length > 4 && strcmp(path + length - 4, ".csv") == 0) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%s: residuals were tables before they had deviations; allowed: an .h5 that "
                       "cpinn-residual has learned anew",
                       path);
    }
    ad_status status = learned_file_read(path, &file, error);
    if (status != AD_OK) {
        return status;
    }
    const learned_net *net = &file.net;
    if (!fits(&file, of, ranges)) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "%s: is no residual of a model of %d states and %d inputs of these "
                         "ranges; allowed: one that cpinn-residual has learned for this scene and "
                         "these modes",
                         path, of->states, of->inputs);
    } else {
        status = residual_create(of, net->hidden[0], net->half, net->middle + of->states,
                                 net->half + of->states, result, error);
    }
    if (status == AD_OK) {
        status = residual_see(*result, file.seen_count, error);
    }
    if (status == AD_OK) {
        residual *to = *result;
        memcpy(to->sight, file.seen, to->values * to->states * sizeof *to->sight);
        memcpy(to->net.size, net->size, to->states * sizeof *net->size);
        memcpy(to->theta, file.theta, to->count * sizeof *to->theta);
        memcpy(to->covariance, file.covariance, to->count * to->count * sizeof *to->covariance);
        to->noise = file.noise;
        to->anew = file.anew;
        to->reach.trained = file.trained;
    }
    if (status == AD_OK && !residual_turn(*result)) {
        status = ad_fail(error, AD_BAD_INPUT, "%s: has seen nothing that moves", path);
    }
    if (status != AD_OK) {
        residual_free(*result);
        *result = NULL;
    }
    learned_file_free(&file);
    return status;
}
