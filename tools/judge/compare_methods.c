/* Methods and networks by name. */
#include "tools/judge/compare.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

static const char endless[] = "1000000000"; /* the most that training.stages[].steps allows */

/* ---- methods ------------------------------------------------------------------------------- */

/* Every optimiser with the defaults of its stage, up to the end of its learning rate. Those without
 * a rate get a start by Adam, from which they do not fall into a poor minimum. */
static void usual_stages(optim_method method, char stages[COMPARE_NAME])
{
    const optim_needs needs = optim_method_needs(method);
    snprintf(stages, COMPARE_NAME,
             needs == OPTIM_NEEDS_GRADIENTS ? "%s:5000"
             : needs == OPTIM_NEEDS_SQUARES ? "adam:100+%s"
                                            : "adam:300+%s",
             optim_method_name(method));
}

void compare_method_names(char *text, size_t size)
{
    char *to = text;
    optim_method_list(0, 0, text, size);
    for (const char *from = text; *from; from++) {
        *to = *from;
        to += *from != ' ';
    }
    *to = '\0';
}

void compare_method_help(FILE *file)
{
    char names[160], stages[COMPARE_NAME];
    for (int i = 0; i < OPTIM_METHOD_COUNT; i++) {
        usual_stages((optim_method)i, stages);
        fprintf(file, "  %-14s %-24s %s\n", optim_method_name((optim_method)i), stages,
                optim_method_about((optim_method)i));
    }
    fprintf(file, "  %-14s %-24s %s\n", "config", "", "the stages that the config itself has");
    fprintf(file, "  %-14s %-24s %s\n", "solver", "",
            "no network: cpinn-solve, with more and more nodes");
    fprintf(file, "\n  NAME=STAGES defines another: OPTIMIZER:STEPS joined by '+'. Without STEPS a "
                  "stage lasts\n  until it ends by itself or time is up. Optimisers: ");
    optim_method_list(0, 0, names, sizeof names);
    fprintf(file, "%s.\n", names);
}

/* One stage, "adam:300" of `length` bytes, appended to the override. */
static ad_status add_stage(compare_method *method, const char *text, size_t length, ad_error *error)
{
    const char *colon = memchr(text, ':', length);
    size_t name = colon ? (size_t)(colon - text) : length;
    char allowed[160], given[COMPARE_NAME];
    snprintf(given, sizeof given, "%.*s", (int)name, text);
    if (optim_method_of(given) == OPTIM_METHOD_COUNT) {
        optim_method_list(0, 0, allowed, sizeof allowed);
        return ad_fail(error, AD_BAD_INPUT, "--methods %s: '%.*s' is not an optimiser; allowed: %s",
                       method->stages, (int)name, text, allowed);
    }
    char steps[16];
    snprintf(steps, sizeof steps, "%.*s", colon ? (int)(length - name - 1) : (int)strlen(endless),
             colon ? colon + 1 : endless);
    char *end = steps;
    long value = isdigit((unsigned char)steps[0]) ? strtol(steps, &end, 10) : 0;
    if (*end != '\0' || value < 1 || value > 1000000000) {
        return ad_fail(error, AD_BAD_INPUT,
                       "--methods %s: '%.*s' is not a stage; allowed: OPTIMIZER:STEPS with 1 to "
                       "1000000000 steps, as in adam:300+lbfgs:2000",
                       method->stages, (int)length, text);
    }
    size_t at = strlen(method->override);
    snprintf(method->override + at, sizeof method->override - at, "%s{optimizer: %.*s, steps: %ld}",
             strchr(method->override, '{') ? ", " : "", (int)name, text, value);
    return AD_OK;
}

static ad_status define(compare_method *method, ad_error *error)
{
    snprintf(method->override, sizeof method->override, "training.stages=[");
    for (const char *stage = method->stages;; stage++) {
        size_t length = strcspn(stage, "+");
        ad_status status = add_stage(method, stage, length, error);
        if (status != AD_OK) {
            return status;
        }
        stage += length;
        if (*stage == '\0') {
            break;
        }
    }
    strcat(method->override, "]"); /* 63 bytes of stages leave room */
    return AD_OK;
}

/* An optimiser, or config. */
static ad_status look_up(compare_method *method, ad_error *error)
{
    char names[256];
    method->is_solver = strcmp(method->name, "solver") == 0;
    if (method->is_solver || strcmp(method->name, "config") == 0) {
        return AD_OK;
    }
    const optim_method known = optim_method_of(method->name);
    if (known != OPTIM_METHOD_COUNT) {
        usual_stages(known, method->stages);
        return define(method, error);
    }
    compare_method_names(names, sizeof names);
    return ad_fail(
        error, AD_BAD_INPUT,
        "--methods %s: there is no such method; allowed: config,solver,%s, or a definition as "
        "in fast=adam:300+lbfgs:2000",
        method->name, names);
}

/* Entries of a list, separated by commas, into items [most] of `size` bytes that begin with a name
 * of COMPARE_NAME bytes, which no other has. An entry has `length` bytes. */
static ad_status parse_list(const char *option, const char *text,
                            ad_status (*parse)(void *item, const char *text, size_t length,
                                               ad_error *error),
                            void *items, size_t size, int most, int *count, ad_error *error)
{
    for (*count = 0;; text++) {
        size_t length = strcspn(text, ",");
        char *item = (char *)items + (size_t)*count * size;
        if (*count == most) {
            return ad_fail(error, AD_BAD_INPUT, "%s: more than %d are given", option, most);
        }
        ad_status status = parse(item, text, length, error);
        for (char *other = items; status == AD_OK && other < item; other += size) {
            if (strcmp(other, item) == 0) {
                status = ad_fail(error, AD_BAD_INPUT, "%s: %s is there twice", option, item);
            }
        }
        if (status != AD_OK) {
            return status;
        }
        ++*count;
        text += length;
        if (*text == '\0') {
            return AD_OK;
        }
    }
}

static ad_status parse_method(void *to, const char *text, size_t length, ad_error *error)
{
    compare_method *method = to;
    const char *equals = memchr(text, '=', length);
    bool bare = !equals && (memchr(text, ':', length) || memchr(text, '+', length));
    size_t name = equals ? (size_t)(equals - text) : length;
    size_t rest = equals ? length - name - 1 : length;
    if (length == 0 || name == 0 || name >= COMPARE_NAME || rest == 0 || rest >= COMPARE_NAME) {
        return ad_fail(error, AD_BAD_INPUT,
                       "--methods %.*s: allowed: names and stages of 1 to %d bytes, separated by "
                       "commas",
                       (int)(length < 200 ? length : 200), text, COMPARE_NAME - 1);
    }
    char given[COMPARE_NAME];
    snprintf(given, sizeof given, "%.*s", (int)name, text);
    *method = (compare_method){.name = ""};
    judge_name(method->name, given);
    if (!equals && !bare) {
        return look_up(method, error);
    }
    snprintf(method->stages, sizeof method->stages, "%.*s", (int)rest, equals ? equals + 1 : text);
    return define(method, error);
}

ad_status compare_methods_parse(const char *text, compare_method methods[COMPARE_METHODS_MAX],
                                int *count, ad_error *error)
{
    return parse_list("--methods", text, parse_method, methods, sizeof *methods,
                      COMPARE_METHODS_MAX, count, error);
}

/* ---- networks ------------------------------------------------------------------------------ */

enum { FEATURES_MAX = 1024 }; /* that network.fourier.features allows */

/* A whole number from `low` to `high` at *text, which moves behind it; 0: there is none. */
static int take_number(const char **text, int low, int high)
{
    char *end;
    if (!isdigit((unsigned char)**text)) {
        return 0;
    }
    long value = strtol(*text, &end, 10);
    *text = end;
    return value >= low && value <= high ? (int)value : 0;
}

/* "2x16", "f64" or "2x16+f8" into name and overrides; false: it is none of these. */
static bool read_network(compare_network *network, const char *text)
{
    size_t at = (size_t)snprintf(network->hidden, sizeof network->hidden, "network.hidden=[");
    network->features[0] = '\0';
    snprintf(network->name, sizeof network->name, "%s", text);
    if (*text != 'f') {
        int layers = take_number(&text, 1, NN_HIDDEN_MAX), width = 0;
        if (layers && *text == 'x') {
            text++;
            width = take_number(&text, 1, 4096);
        }
        for (int i = 0; width && i < layers; i++) {
            at += (size_t)snprintf(network->hidden + at, sizeof network->hidden - at, "%s%d",
                                   i ? ", " : "", width);
        }
        if (!width || (*text != '\0' && strncmp(text, "+f", 2) != 0)) {
            return false;
        }
        text += *text == '+';
    }
    strcat(network->hidden, "]");
    if (*text == '\0') {
        return true;
    }
    text++;
    int features = take_number(&text, 1, FEATURES_MAX);
    snprintf(network->features, sizeof network->features, "network.fourier.features=%d", features);
    return features && *text == '\0';
}

static ad_status parse_network(void *to, const char *text, size_t length, ad_error *error)
{
    compare_network *network = to;
    char copy[COMPARE_NAME];
    snprintf(copy, sizeof copy, "%.*s", (int)(length < sizeof copy ? length : sizeof copy), text);
    if (length == 0 || length >= sizeof copy || !read_network(network, copy)) {
        return ad_fail(
            error, AD_BAD_INPUT,
            "--networks %s: allowed: LAYERSxWIDTH, 1 to %d layers of 1 to 4096; fN, 1 "
            "to %d random features without hidden layers; or both, as in 2x16,f64,2x16+f8",
            copy, NN_HIDDEN_MAX, FEATURES_MAX);
    }
    return AD_OK;
}

ad_status compare_networks_parse(const char *text, compare_network networks[COMPARE_NETWORKS_MAX],
                                 int *count, ad_error *error)
{
    *count = 0;
    if (!text) {
        networks[0] = (compare_network){.hidden = ""};
        *count = 1;
        return AD_OK;
    }
    return parse_list("--networks", text, parse_network, networks, sizeof *networks,
                      COMPARE_NETWORKS_MAX, count, error);
}

void compare_network_name(char name[COMPARE_NAME], const nn_mlp_settings *network)
{
    size_t at = 0;
    bool equal = network->hidden_count > 0;
    for (int i = 1; i < network->hidden_count; i++) {
        equal = equal && network->hidden[i] == network->hidden[0];
    }
    name[0] = '\0';
    if (equal) {
        at = (size_t)snprintf(name, COMPARE_NAME, "%dx%d", network->hidden_count,
                              network->hidden[0]);
    }
    for (int i = 0; !equal && i < network->hidden_count && at < COMPARE_NAME; i++) {
        at += (size_t)snprintf(name + at, COMPARE_NAME - at, "%s%d", i ? "-" : "",
                               network->hidden[i]);
    }
    if (at == 0 && network->degree > 0) {
        snprintf(name, COMPARE_NAME, "p%d", network->degree);
    } else if (at < COMPARE_NAME && (at == 0 || network->fourier_features > 0)) {
        snprintf(name + at, COMPARE_NAME - at, "%sf%d", at ? "+" : "", network->fourier_features);
    }
}
