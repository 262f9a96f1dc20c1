/* The page of --explain: how it is laid out, and what training costs. */
#include "tools/programs/explain_parts.h"

#include "physics/beam/beam.h"
#include "tools/files/file_bytes.h"
#include "tools/train/linear_model.h"
#include "tools/train/trainer.h"

#include <math.h>
#include <string.h>

enum { EXPLAIN_WIDTH = 96 };

/* ---- layout -------------------------------------------------------------------------------- */

void explain_heading(FILE *file, const char *text)
{
    fprintf(file, "\n%s\n", text);
}

paragraph explain_paragraph_begin(FILE *file, const char *label)
{
    paragraph p = {file, 18, 0};
    fprintf(file, "  %-15s ", label);
    p.column = p.indent;
    return p;
}

void explain_paragraph_add(paragraph *p, const char *text, bool comma)
{
    int length = (int)strlen(text) + comma;
    if (p->column > p->indent && p->column + 1 + length > EXPLAIN_WIDTH) {
        fprintf(p->file, "\n%*s", p->indent, "");
        p->column = p->indent;
    }
    p->column +=
        fprintf(p->file, "%s%s%s", p->column > p->indent ? " " : "", text, comma ? "," : "");
}

/* "5.9 MiB" */
static void bytes_text(double bytes, char text[32])
{
    static const char *const units[] = {"bytes", "KiB", "MiB", "GiB"};
    int unit = 0;
    while (bytes >= 1024 && unit < 3) {
        bytes /= 1024;
        unit++;
    }
    snprintf(text, 32, unit ? "%.1f %s" : "%.0f %s", bytes, units[unit]);
}

/* ---- what it costs ------------------------------------------------------------------------- */

static void print_compilation(FILE *file)
{
    char folder[4000], compiler[4000];
    if (!trainer_fuse_folder(folder, false)) {
        fprintf(file, "  groups are interpreted: there is no cache folder for compiled ones\n");
        return;
    }
    fprintf(file, "  groups are taken from %s, if an earlier run kept them there;\n",
            file_bytes_shown(folder));
    if (ad_fuse_compiler(compiler, sizeof compiler)) {
        fprintf(file, "  after %d s of training others are compiled by %s\n", TRAINER_FUSE_AFTER,
                file_bytes_shown(compiler));
    } else {
        fprintf(file, "  others are interpreted: there is no cc in PATH\n");
    }
}

static void print_sets(FILE *file, const problem *p)
{
    explain_heading(
        file, "Point sets and their tapes: operations of value and gradient, recorded and left");
    fprintf(file, "  %-9s%8s%9s%10s%8s%8s%8s%10s%10s\n", "set", "points", "held out", "recorded",
            "folded", "shared", "stored", "per set", "per step");
    for (int i = 0; i < problem_sets(p); i++) {
        problem_set_info set = problem_set_inspect(p, i);
        fprintf(file, "  %-9s%8zu%9zu%10zu%8zu%8zu%8zu%10zu%10zu\n", set.name, set.points,
                set.held_out, set.tape.recorded, set.tape.folded, set.tape.shared, set.tape.stored,
                set.fixed_instructions, set.program.instructions);
    }
    fprintf(file,
            "  folded: by the algebra of 0 and 1; shared: found on the tape; per set: once for a\n"
            "  set of points, since they depend on nothing else; per step: what is left\n");
    fprintf(file, "  %-9s%8s%9s%10s%14s%8s%11s\n", "set", "products", "groups", "passes",
            "flops/point", "tile", "workspace");
    for (int i = 0; i < problem_sets(p); i++) {
        problem_set_info set = problem_set_inspect(p, i);
        char workspace[32];
        bytes_text((double)set.program.workspace_bytes, workspace);
        fprintf(file, "  %-9s%8zu%9zu%10zu%14zu%8d%11s\n", set.name, set.program.products,
                set.program.groups, set.program.passes, set.program.flops_per_point,
                set.program.tile, workspace);
    }
    print_compilation(file);
}

static void print_network(FILE *file, const experiment *e, const problem *p)
{
    static const char *const activations[] = {
#define TEXT(name, text) text,
        NN_ACTIVATION_LIST(TEXT)
#undef TEXT
    };
    const nn_mlp_settings *network = &e->settings->network;
    char bytes[32];
    explain_heading(file, "Network and memory");
    fprintf(file, "  %-15s %d", "network", network->inputs);
    if (network->fourier_features) {
        fprintf(file, " + 2 x %d Fourier", network->fourier_features);
    }
    if (network->degree) {
        fprintf(file, ", %d polynomials of degree %d%s", nn_mlp_features(e->mlp), network->degree,
                e->modes ? " of time" : "");
    }
    for (int i = 0; i < network->hidden_count; i++) {
        fprintf(file, " - %d", network->hidden[i]);
    }
    fprintf(file, " - %d, %s, %zu parameters\n", network->outputs,
            network->hidden_count ? activations[network->activation] : "linear", e->count);
    bytes_text((double)problem_bytes(p), bytes);
    fprintf(file, "  %-15s %s for the loss and its gradient, on %d thread%s\n", "memory", bytes,
            ad_pool_threads(e->pool), ad_pool_threads(e->pool) == 1 ? "" : "s");
}

/* Prints the matrices that Gauss-Newton needs beside the memory of the loss. */
static void print_linear_algebra(FILE *file, const train_settings *settings, problem *p)
{
    for (int i = 0; i < settings->stage_count; i++) {
        linear_model_info plan;
        ad_error error = {AD_OK, ""};
        char text[160];
        if (optim_method_needs(settings->stages[i].optim.method) != OPTIM_NEEDS_SQUARES) {
            continue;
        }
        if (linear_model_plan(p, &settings->stages[i], i, &plan, &error) == AD_OK) {
            linear_model_describe(&plan, text);
        }
        fprintf(file, "  %-15s %s\n", optim_method_name(settings->stages[i].optim.method),
                error.status == AD_OK ? text : error.message);
        if (error.status == AD_OK) {
            fprintf(file, "  %-15s a step takes up to %.2g Gflop\n", "",
                    1e-9 * linear_model_flops(&plan));
        }
    }
}

/* Prints which weights follow the training, if any do. */
static void print_weights(FILE *file, const problem_settings *losses)
{
    if (losses->causal_slices) {
        fprintf(file, "  %-15s causal: by %d slices of time, new every %d steps\n", "weights",
                losses->causal_slices, losses->causal_update_every);
    }
    if (losses->balance) {
        fprintf(file,
                "  %-15s balanced: loss terms by the lengths of their gradients, every %d steps of "
                "adam\n",
                "weights", losses->balance_every);
    }
}

static void print_plan(FILE *file, const experiment *e, problem *p, const reference *r)
{
    const train_settings *settings = e->settings;
    int windows = e->scene->windows;
    if (windows > 1) {
        fprintf(
            file,
            "  %-15s %d of %.4g s, %.3g first periods each, trained in turn; each starts where\n"
            "  %-15s the one before ends, and has a network of its own\n",
            "windows", windows, scene_duration(e->scene) / windows,
            rod_numbers_of(e->scene).periods / windows, "");
    }
    paragraph line = explain_paragraph_begin(file, windows > 1 ? "in each window" : "training");
    for (int i = 0; i < settings->stage_count; i++) {
        char text[64];
        const train_stage *stage = &settings->stages[i];
        snprintf(text, sizeof text, "%s %d steps%s%s", optim_method_name(stage->optim.method),
                 stage->steps, e->targets ? ", targets " : "",
                 e->targets ? train_targets_names()[stage->targets] : "");
        explain_paragraph_add(&line, text, i + 1 < settings->stage_count);
    }
    fputc('\n', file);
    print_linear_algebra(file, settings, p);
    print_weights(file, &settings->losses);
    if (!r && e->targets) {
        fprintf(file, "  %-15s %d fresh members\n", "reference", TARGETS_FRESH);
        return;
    }
    if (!r) {
        fprintf(file, "  %-15s none\n", "reference");
        return;
    }
    fprintf(file, "  %-15s %s, %zu points", "reference", reference_name(r), reference_points(r));
    if (reference_left_out(r)) {
        fprintf(file, " (%zu outside the scene, or without a number, left out)",
                reference_left_out(r));
    }
    double estimate = reference_estimates(r).position_max;
    if (!isnan(estimate)) {
        fprintf(file, ", estimated error %.1e of the length", estimate);
    }
    fputc('\n', file);
}

void explain_costs(FILE *file, const experiment *e, problem *p, const reference *r)
{
    if (!e->modes) { /* the residual of a motion has no tape */
        print_sets(file, p);
    }
    print_network(file, e, p);
    print_plan(file, e, p, r);
}
