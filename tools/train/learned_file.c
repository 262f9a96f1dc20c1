#include "tools/train/learned_file.h"

#include "tools/files/checkpoint.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void learned_file_free(learned_file *file)
{
    ad_memory_free(&file->memory);
    *file = (learned_file){.texts = NULL};
}

static size_t count_of(const learned_file *file)
{
    return (size_t)file->unknowns.count + learned_net_count(&file->net);
}

/* ---- writing ------------------------------------------------------------------------------- */

static void put_names(checkpoint *to, const char *item, const learned_names *names)
{
    char *text = NULL;
    size_t size = 0;
    FILE *lines = open_memstream(&text, &size);
    for (int i = 0; lines && i < names->count; i++) {
        fprintf(lines, "%s\n", names->name[i]);
    }
    const bool complete = lines && fclose(lines) == 0;
    checkpoint_put_text(to, item, complete ? text : NULL);
    free(text);
}

ad_status learned_file_write(const learned_file *file, const char *path, ad_error *error)
{
    checkpoint *to = checkpoint_create(CPINN_VERSION);
    const learned_net *net = &file->net;
    const size_t inputs = (size_t)net->inputs, outputs = (size_t)net->outputs;
    const size_t layers = (size_t)net->hidden_count, unknowns = (size_t)file->unknowns.count;
    const size_t theta = learned_net_count(net), square[] = {count_of(file), count_of(file)};
    int64_t hidden[LEARNED_LAYERS_MAX] = {0};
    if (!to) {
        return ad_fail(error, AD_NO_MEMORY, "%s: out of memory", path);
    }
    for (size_t i = 0; i < layers; i++) {
        hidden[i] = net->hidden[i];
    }
    put_names(to, "residual/inputs", &file->inputs);
    put_names(to, "residual/outputs", &file->outputs);
    put_names(to, "residual/unknowns", &file->unknowns);
    checkpoint_put_int64(to, "residual/hidden", hidden, 1, &layers);
    checkpoint_put_doubles(to, "residual/middle", net->middle, 1, &inputs);
    checkpoint_put_doubles(to, "residual/half", net->half, 1, &inputs);
    checkpoint_put_doubles(to, "residual/size", net->size, 1, &outputs);
    checkpoint_put_doubles(to, "residual/values", file->value, 1, &unknowns);
    checkpoint_put_doubles(to, "residual/theta", file->theta, 1, &theta);
    checkpoint_put_doubles(to, "residual/covariance", file->covariance, 2, square);
    checkpoint_put_doubles(to, "residual/noise", &file->noise, 1, &(size_t){1});
    if (file->seen_count > 0) {
        const size_t seen[] = {file->seen_count, outputs};
        checkpoint_put_doubles(to, "residual/anew", &file->anew, 1, &(size_t){1});
        checkpoint_put_doubles(to, "residual/trained", &file->trained, 1, &(size_t){1});
        checkpoint_put_doubles(to, "residual/seen", file->seen, 2, seen);
    }
    const file_place place = {.path = path};
    const ad_status status = checkpoint_write(to, &place, error);
    checkpoint_free(to);
    return status;
}

/* ---- reading ------------------------------------------------------------------------------- */

/* Lines of a text, which is cut at their ends. */
static bool cut_names(char *text, learned_names *names, int most)
{
    while (*text && names->count < most) {
        names->name[names->count++] = text;
        text += strcspn(text, "\n");
        if (*text) {
            *text++ = '\0';
        }
    }
    return *text == '\0';
}

static ad_status get_names(const checkpoint *from, learned_file *file, ad_error *error)
{
    static const char *const items[] = {"residual/inputs", "residual/outputs", "residual/unknowns"};
    learned_names *names[] = {&file->inputs, &file->outputs, &file->unknowns};
    const int most[] = {LEARNED_WIDTH_MAX, LEARNED_WIDTH_MAX, LEARNED_COMMON_MAX};
    const char *text[3];
    size_t size = 0;
    for (int i = 0; i < 3; i++) {
        const ad_status status = checkpoint_get_text(from, items[i], &text[i], error);
        if (status != AD_OK) {
            return status;
        }
        size += strlen(text[i]) + 1;
    }
    char *to = AD_TAKE(file, texts, size);
    bool good = true;
    for (int i = 0; to && i < 3; i++) {
        const size_t length = strlen(text[i]) + 1;
        memcpy(to, text[i], length);
        good = cut_names(to, names[i], most[i]) && good;
        to += length;
    }
    return !to    ? ad_fail(error, AD_NO_MEMORY, "out of memory for a residual")
           : good ? AD_OK
                  : ad_fail(error, AD_BAD_INPUT, "has more inputs or outputs than there may be");
}

static ad_status get_shape(const checkpoint *from, learned_file *file, ad_error *error)
{
    learned_net *net = &file->net;
    int64_t hidden[LEARNED_LAYERS_MAX];
    size_t shape[CHECKPOINT_MAX_RANK] = {0};
    int rank;
    if (!checkpoint_shape(from, "residual/hidden", &rank, shape) || shape[0] > LEARNED_LAYERS_MAX) {
        return ad_fail(error, AD_BAD_INPUT, "has no residual; allowed: what cpinn-residual wrote");
    }
    net->inputs = file->inputs.count;
    net->outputs = file->outputs.count;
    net->hidden_count = (int)shape[0];
    const ad_status status = checkpoint_get_int64(from, "residual/hidden", hidden, shape[0], error);
    for (int i = 0; status == AD_OK && i < net->hidden_count; i++) {
        if (hidden[i] < 1 || hidden[i] > LEARNED_OUTPUTS_MAX) {
            return ad_fail(error, AD_BAD_INPUT, "has a layer of %lld units; allowed: 1 to %d",
                           (long long)hidden[i], LEARNED_OUTPUTS_MAX);
        }
        net->hidden[i] = (int)hidden[i];
    }
    return status == AD_OK && net->inputs > 0 && net->outputs > 0
               ? AD_OK
               : ad_fail(error, AD_BAD_INPUT, "has no inputs or no outputs");
}

/* A number; of files before it was written NaN. */
static ad_status get_if_there(const checkpoint *from, const char *item, double *to, ad_error *error)
{
    int rank;
    size_t shape[CHECKPOINT_MAX_RANK] = {0};
    *to = NAN;
    return checkpoint_shape(from, item, &rank, shape)
               ? checkpoint_get_doubles(from, item, to, 1, error)
               : AD_OK;
}

/* What a residual in motion has beside one at rest. */
static ad_status get_motion(const checkpoint *from, learned_file *file, ad_error *error)
{
    int rank;
    size_t shape[CHECKPOINT_MAX_RANK] = {0};
    ad_status status = get_if_there(from, "residual/anew", &file->anew, error);
    status =
        status == AD_OK ? get_if_there(from, "residual/trained", &file->trained, error) : status;
    if (status != AD_OK || !checkpoint_shape(from, "residual/seen", &rank, shape)) {
        return status;
    }
    const size_t outputs = (size_t)file->net.outputs;
    file->seen_count = shape[0];
    AD_TAKE(file, seen, shape[0] * outputs);
    return file->seen ? checkpoint_get_doubles(from, "residual/seen", file->seen,
                                               shape[0] * outputs, error)
                      : ad_fail(error, AD_NO_MEMORY, "out of memory for a residual");
}

static ad_status get_numbers(const checkpoint *from, learned_file *file, ad_error *error)
{
    const size_t n = count_of(file), theta = learned_net_count(&file->net);
    AD_TAKE(file, theta, theta);
    AD_TAKE(file, covariance, n * n);
    if (file->memory.is_short) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a residual");
    }
    const struct {
        const char *item;
        double *to;
        size_t count;
    } all[] = {{"residual/middle", file->net.middle, (size_t)file->net.inputs},
               {"residual/half", file->net.half, (size_t)file->net.inputs},
               {"residual/size", file->net.size, (size_t)file->net.outputs},
               {"residual/values", file->value, (size_t)file->unknowns.count},
               {"residual/theta", file->theta, theta},
               {"residual/covariance", file->covariance, n * n}};
    ad_status status = get_if_there(from, "residual/noise", &file->noise, error);
    status = status == AD_OK ? get_motion(from, file, error) : status;
    for (size_t i = 0; i < sizeof all / sizeof *all && status == AD_OK; i++) {
        status = checkpoint_get_doubles(from, all[i].item, all[i].to, all[i].count, error);
    }
    return status;
}

ad_status learned_file_read(const char *path, learned_file *file, ad_error *error)
{
    checkpoint *from = NULL;
    ad_error reason;
    *file = (learned_file){.texts = NULL};
    ad_status status = checkpoint_open(path, &from, error);
    if (status != AD_OK) {
        return status;
    }
    status = get_names(from, file, &reason);
    status = status == AD_OK ? get_shape(from, file, &reason) : status;
    status = status == AD_OK ? get_numbers(from, file, &reason) : status;
    checkpoint_free(from);
    if (status != AD_OK) {
        learned_file_free(file);
        const bool named = strncmp(reason.message, path, strlen(path)) == 0;
        return ad_fail(error, status, "%s%s%s", named ? "" : path, named ? "" : ": ",
                       reason.message);
    }
    return AD_OK;
}
