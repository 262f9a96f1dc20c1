#include "tools/programs/explain.h"

#include "physics/beam.h"
#include "physics/plausible.h"
#include "tools/files/file_bytes.h"
#include "tools/programs/undeformed.h"
#include "tools/train/linear_model.h"
#include "tools/train/trainer.h"

#include <math.h>
#include <string.h>

enum { EXPLAIN_WIDTH = 96 };

/* ---- layout -------------------------------------------------------------------------------- */

static void heading(FILE *file, const char *text)
{
    fprintf(file, "\n%s\n", text);
}

/* A paragraph puts words behind one another and goes on under `indent` when a line is full. */
typedef struct paragraph {
    FILE *file;
    int indent, column;
} paragraph;

static paragraph paragraph_begin(FILE *file, const char *label)
{
    paragraph p = {file, 18, 0};
    fprintf(file, "  %-15s ", label);
    p.column = p.indent;
    return p;
}

static void paragraph_add(paragraph *p, const char *text, bool comma)
{
    int length = (int)strlen(text) + comma;
    if (p->column > p->indent && p->column + 1 + length > EXPLAIN_WIDTH) {
        fprintf(p->file, "\n%*s", p->indent, "");
        p->column = p->indent;
    }
    p->column +=
        fprintf(p->file, "%s%s%s", p->column > p->indent ? " " : "", text, comma ? "," : "");
}

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

/* ---- how hard it is ------------------------------------------------------------------------ */

/* Says what a number means from `from` on. Rows about one number are in rising order. */
typedef struct meaning {
    double from;
    const char *text;
} meaning;

static const meaning stiff_strain[] = {
    {0, "soft: this strain matters for the shape"},
    {1e2, "stiff against bending"},
    {1e4, "very stiff: not for the displacement form; or lock it"},
    {INFINITY, "locked: this strain is no unknown"}};
static const meaning twist_ratio[] = {{0, "twists easily"},
                                      {0.2, "of the order of bending"},
                                      {5, "hard to twist"},
                                      {INFINITY, "twist is locked"}};
static const meaning end_force[] = {{0, "small deflection, nearly linear: easy"},
                                    {0.5, "large deflection"},
                                    {5, "very large: curvature crowds at the clamp"},
                                    {50, "extreme: a boundary layer; more points"}};
static const meaning end_moment[] = {{0, "turns the tip by less than half a radian: easy"},
                                     {0.5, "turns the tip by a large angle"},
                                     {3.2, "more than half a turn: train longer"},
                                     {12.6, "several turns: Fourier features help"}};
static const meaning compression[] = {
    {0, "near Euler's load pi^2/4: may buckle; the seed decides the branch"},
    {2.4674, "above Euler's load pi^2/4: may buckle; the seed decides the branch"}};
static const meaning line_load[] = {{0, "small deflection, nearly linear: easy"},
                                    {2, "large deflection"},
                                    {20, "very large: curvature crowds at the clamp"},
                                    {200, "extreme: a boundary layer; more points"}};
static const meaning line_moment[] = {{0, "turns the tip by less than half a radian: easy"},
                                      {1, "turns the tip by a large angle"},
                                      {6.4, "more than half a turn: train longer"},
                                      {25.2, "several turns: Fourier features help"}};
static const meaning slenderness[] = {{0, "none"},
                                      {1e-300, "slender: the rotary inertia hardly matters"},
                                      {1e-3, "stout: shear and rotary inertia matter"}};
static const meaning damping[] = {{0, "weak: waves live long"},
                                  {0.05, "moderate: waves fade"},
                                  {1, "strong: creeps rather than swings"}};
static const meaning strain_rate[] = {{0, "viscosity of shear and stretch"}};
static const meaning deflection[] = {{0, "small, as the theory asks"},
                                     {0.1, "not small: the theory is linear; see rod.model"}};
static const meaning foundation[] = {{0, "soft: the ends carry the load"},
                                     {500, "stiff: waves die out along the beam"},
                                     {1e6, "very stiff: boundary layers at ends and loads"}};
static const meaning seconds_of_motion[] = {{0, "less than one period of the first bending mode"},
                                            {1, "a few periods"},
                                            {4, "many periods: see time.windows, losses.causal"}};

static const double COMPRESSION_TOLD = 1.9; /* three quarters of Euler's load */

typedef struct number_row {
    const char *name, *formula;
    double value;
    const meaning *meanings;
    int count;
    bool shown;
} number_row;

#define VERDICTS(list) list, (int)(sizeof(list) / sizeof *(list))

static const char *judge(const number_row *row)
{
    const char *text = row->meanings[0].text;
    for (int i = 0; i < row->count && row->value >= row->meanings[i].from; i++) {
        text = row->meanings[i].text;
    }
    return text;
}

static void print_rows(FILE *file, const number_row *rows, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (rows[i].shown) {
            fprintf(file, "  %-15s %-16s %-10.4g %s\n", rows[i].name, rows[i].formula,
                    rows[i].value, judge(&rows[i]));
        }
    }
}

/* What resists the motion, and how long it lasts. */
static void print_motion_numbers(FILE *file, const scene *scene, double periods)
{
    rod_term terms[ROD_TERM_MAX];
    int count = scene_physics_of(scene)->terms(scene, terms);
    for (int i = 0; i < count; i++) {
        const number_row row = {terms[i].name, terms[i].formula, terms[i].damping,
                                VERDICTS(damping), terms[i].damping > 0};
        print_rows(file, &row, 1);
    }
    const number_row row = {"first periods", "duration/period", periods,
                            VERDICTS(seconds_of_motion), scene_is_dynamic(scene)};
    print_rows(file, &row, 1);
}

static void print_beam_numbers(FILE *file, const scene *scene)
{
    rod_numbers n = rod_numbers_of(scene);
    beam_numbers b = beam_numbers_of(scene);
    bool moving = scene_is_dynamic(scene);
    const number_row rows[] = {
        {"deflection", "W/L", b.deflection, VERDICTS(deflection), true},
        {"shear", "kGA L^2/EI", b.shear_ratio, VERDICTS(stiff_strain), true},
        {"foundation", "k L^4/EI", b.foundation, VERDICTS(foundation), b.foundation > 0},
        {"rotary inertia", "rhoI/(rhoA L^2)", b.rotary_inertia, VERDICTS(slenderness), moving}};
    heading(file, "How hard it is");
    print_rows(file, rows, sizeof rows / sizeof *rows);
    print_motion_numbers(file, scene, n.periods);
}

static void print_numbers(FILE *file, const scene *scene)
{
    rod_numbers n = rod_numbers_of(scene);
    bool moving = scene_is_dynamic(scene);
    const number_row rows[] = {
        {"shear", "kGA L^2/EI", n.shear_ratio, VERDICTS(stiff_strain), true},
        {"stretch", "EA L^2/EI", n.axial_ratio, VERDICTS(stiff_strain), true},
        {"twist", "GJ/EI", n.torsion_ratio, VERDICTS(twist_ratio), true},
        {"tip force", "F L^2/EI", n.tip_force, VERDICTS(end_force), n.tip_force > 0},
        {"compression", "F L^2/EI", n.compression, VERDICTS(compression),
         n.compression > COMPRESSION_TOLD},
        {"tip moment", "T L/EI", n.tip_moment, VERDICTS(end_moment), n.tip_moment > 0},
        {"line load", "f L^3/EI", n.distributed_force, VERDICTS(line_load),
         n.distributed_force > 0},
        {"line moment", "l L^2/EI", n.distributed_moment, VERDICTS(line_moment),
         n.distributed_moment > 0},
        {"foundation", "k L^4/EI", n.foundation, VERDICTS(foundation), n.foundation > 0},
        {"weight", "rhoA g L^3/EI", n.weight, VERDICTS(line_load), n.weight > 0},
        {"point force", "F L^2/EI", n.point_force, VERDICTS(end_force), n.point_force > 0},
        {"point moment", "T L/EI", n.point_moment, VERDICTS(end_moment), n.point_moment > 0},
        {"actuation", "T L/EI", n.actuation, VERDICTS(end_moment), n.actuation > 0},
        {"tubes", "k L", n.tubes, VERDICTS(end_moment), n.tubes > 0},
        {"rotary inertia", "rhoI/(rhoA L^2)", n.rotary_inertia, VERDICTS(slenderness), moving},
        {"strain damping", "B L^2/(EI T)", n.strain_damping, VERDICTS(strain_rate),
         moving && n.strain_damping > 0},
        {"bending damping", "B w1/(2 EI)", n.curvature_damping, VERDICTS(damping),
         moving && n.curvature_damping > 0}};
    heading(file, "How hard it is");
    print_rows(file, rows, sizeof rows / sizeof *rows);
    print_motion_numbers(file, scene, n.periods);
}

static void print_scales(FILE *file, const scene *scene)
{
    rod_scales scales = rod_scales_of(scene);
    heading(file, "Scales (1 of the dimensionless equations)");
    fprintf(file, "  length %.5g m", scales.length);
    if (scene_is_dynamic(scene)) {
        fprintf(file, "   time %.5g s", scales.time);
    }
    if (scene_is_beam(scene)) {
        double ratio = beam_numbers_of(scene).deflection;
        fprintf(file, "   deflection W %.5g m   V %.5g N   M %.5g N m\n", ratio * scales.length,
                ratio * scales.force, ratio * scales.moment);
        return;
    }
    fprintf(file, "   force EI/L^2 %.5g N   moment EI/L %.5g N m\n", scales.force, scales.moment);
}

/* ---- what is solved ------------------------------------------------------------------------ */

/* "end loaded: hard". The displacement form has no force and moment to put into the ansatz. */
static void print_end(FILE *file, const scene *scene, bool at_start)
{
    const scene_end *end = at_start ? &scene->start : &scene->end;
    bool hard = scene->boundary_enforcement == SCENE_HARD;
    bool residual =
        scene_physics_of(scene)->residual_rows(scene, at_start ? ROD_START : ROD_END) > 0;
    const scene_hold hold = scene_hold_of(end);
    fprintf(file, "%s %s", at_start ? "start" : "end", scene_end_names()[end->type]);
    if (hold.directions == 1 || hold.directions == 2) {
        fprintf(file, " %s (%.3g, %.3g, %.3g)", hold.directions == 1 ? "across" : "along",
                hold.axis[0], hold.axis[1], hold.axis[2]);
    }
    fputs(": ", file);
    if (!hard || !residual) {
        fputs(hard ? "hard" : "soft, a loss term", file);
    } else {
        fprintf(file, "%sa loss term (displacement form)",
                end->type == SCENE_PINNED     ? "position hard, moment "
                : scene_end_slides(end->type) ? "what it holds hard, the rest "
                                              : "");
    }
}

/* "the x-z plane", or by the normal for a skew one. */
static void plane_text(const rod_plane *plane, char text[64])
{
    static const char *const names[3] = {"y-z", "x-z", "x-y"};
    const double *n = plane->normal;
    for (int i = 0; i < 3; i++) {
        if (fabs(n[i]) == 1) {
            snprintf(text, 64, "in the %s plane", names[i]);
            return;
        }
    }
    snprintf(text, 64, "in the plane across (%.3g, %.3g, %.3g)", n[0], n[1], n[2]);
}

static void print_motion(FILE *file, const scene *scene)
{
    rod_plane plane = rod_plane_of(scene);
    bool both = rod_residual_rows(scene, ROD_STRAIN) > 0; /* balances and strains */
    struct scene spatial = *scene;
    spatial.motion = SCENE_SPATIAL;
    char where[64];
    fprintf(file, "  %-15s ", "motion");
    if (plane.is_planar) {
        plane_text(&plane, where);
        int tendons = rod_residual_rows(scene, ROD_TENDON);
        fprintf(file, "planar, %s by symmetry: %d unknowns of %d, %d equations of %d\n", where,
                rod_network_outputs(scene), rod_network_outputs(&spatial), (both ? 6 : 3) + tendons,
                (both ? 12 : 6) + tendons);
    } else if (strcmp(plane.leaves, "motion") == 0 || scene_is_manufactured(scene)) {
        fprintf(file, "spatial: %s\n",
                scene_is_manufactured(scene) ? "a manufactured solution is not looked into"
                                             : "as the scene says");
    } else {
        fprintf(file, "spatial: %s leaves each plane across d1 or d2\n", plane.leaves);
    }
}

static void print_form(FILE *file, const scene *scene)
{
    bool moving = scene_is_dynamic(scene), mixed = scene->formulation == SCENE_MIXED;
    fprintf(file, "  %-15s %s, %s: ", "form", scene_formulation_names()[scene->formulation],
            moving ? "dynamic" : "static");
    if (scene_is_beam(scene)) {
        fprintf(file, "w deflection%s%s", beam_network_outputs(scene) > 1 ? ", psi rotation" : "",
                mixed ? ", V shear, M moment" : "");
    } else {
        bool planar = rod_plane_of(scene).is_planar;
        fprintf(file, "r[%d] position, %s", planar ? 2 : 3, rod_head_of(scene)->name);
        if (scene->formulation == SCENE_POSE_STRAIN) {
            fprintf(file, ", v[%d] strain, u[%d] curvature", planar ? 2 : 3, planar ? 1 : 3);
        }
        if (mixed) {
            fprintf(file, ", N[%d] force, m[%d] moment", planar ? 2 : 3, planar ? 1 : 3);
        }
        if (rod_residual_rows(scene, ROD_TENDON) > 0) {
            fprintf(file, ", tau[%d] of tendons", rod_residual_rows(scene, ROD_TENDON));
        }
        if (scene->tube_count > 0) {
            fprintf(file, ", theta, m_i of %d tube%s", scene->tube_count,
                    scene->tube_count > 1 ? "s" : "");
        }
    }
    fprintf(file, " of s%s\n", moving ? " and t" : "");
}

/* Of a family in the strain form. */
static void print_members(FILE *file, const experiment *e)
{
    const targets_account drawn = targets_drawn(e->targets);
    const family *f = targets_family(e->targets);
    char where[512];
    targets_unsolved_text(e->targets, where, sizeof where);
    fprintf(file,
            "  %-15s strain, static: u[3] curvature at %zu places, of %d parameters alone;\n"
            "  %-15s rotation and position follow exactly, the clamp is met exactly\n",
            "form", family_nodes(f), e->scene->parameter_count, "");
    fprintf(file,
            "  %-15s %d principal components of what is not affine in the inputs, %.2g of the\n"
            "  %-15s length; all others are worth %.1g of it\n",
            "modes", family_modes(f), family_spread(f), "", family_missed(f));
    fprintf(file,
            "  %-15s %zu drawn and solved in %.2g s, %.2g us each on %d thread%s; %zu without a\n"
            "  %-15s stable equilibrium that continues the unstressed rod, left out%s\n",
            "members", drawn.drawn, drawn.seconds, 1e6 * drawn.seconds / (double)drawn.drawn,
            ad_pool_threads(e->pool), ad_pool_threads(e->pool) == 1 ? "" : "s", drawn.unsolved, "",
            where);
}

static void print_fields(FILE *file, const scene *scene, const problem *p)
{
    print_form(file, scene);
    if (!scene_is_beam(scene)) {
        print_motion(file, scene);
    }
    fprintf(file, "  %-15s ", "boundary");
    print_end(file, scene, true);
    fputs("; ", file);
    print_end(file, scene, false);
    if (scene_is_dynamic(scene)) {
        fprintf(file, "; initial state: %s", scene_enforcement_names()[scene->initial_enforcement]);
    }
    fputc('\n', file);
    fprintf(file, "  %-15s %s\n", "derivatives", problem_derivatives(p));
}

static void print_unknowns(FILE *file, const experiment *e, const problem *p)
{
    heading(file, "Unknowns and equations");
    if (e->targets) {
        print_members(file, e);
    } else {
        print_fields(file, e->scene, p);
    }
    paragraph terms = paragraph_begin(file, "loss terms");
    for (int i = 0; i < problem_terms(p); i++) {
        char text[64];
        snprintf(text, sizeof text, "%s (weight %g)", problem_term_name(p, i),
                 problem_term_weight(p, i));
        paragraph_add(&terms, text, i + 1 < problem_terms(p));
    }
    fputc('\n', file);
}

/* Prints all terms that are left out for the same reason in one paragraph. */
static void print_left_out(FILE *file, const rod_term *terms, int count, int first)
{
    char text[96];
    paragraph line = paragraph_begin(file, "left out");
    for (int i = first; i < count; i++) {
        bool same = !terms[i].present && strcmp(terms[i].reason, terms[first].reason) == 0;
        if (same) {
            bool another = false;
            for (int k = i + 1; k < count; k++) {
                another = another ||
                          (!terms[k].present && strcmp(terms[k].reason, terms[first].reason) == 0);
            }
            snprintf(text, sizeof text, "%s%s", terms[i].name, another ? "" : ":");
            paragraph_add(&line, text, another);
        }
    }
    paragraph_add(&line, terms[first].reason, false);
    fputc('\n', file);
}

static void print_terms(FILE *file, const scene *scene)
{
    rod_term terms[ROD_TERM_MAX];
    int count = scene_physics_of(scene)->terms(scene, terms), left = 0;
    heading(file, "Physics");
    paragraph line = paragraph_begin(file, "present");
    for (int i = 0; i < count; i++) {
        left += terms[i].present;
    }
    for (int i = 0; i < count; i++) {
        if (terms[i].present) {
            paragraph_add(&line, terms[i].name, --left > 0);
        }
    }
    fputc('\n', file);
    for (int i = 0; i < count; i++) {
        bool told = terms[i].present;
        for (int k = 0; k < i && !told; k++) {
            told = !terms[k].present && strcmp(terms[k].reason, terms[i].reason) == 0;
        }
        if (!told) {
            print_left_out(file, terms, count, i);
        }
    }
}

/* Segments and what acts at places, each in one paragraph. */
static void print_entries(FILE *file, const scene *scene)
{
    char text[400];
    for (int i = 0; scene_entry_text(scene, i, text, sizeof text); i++) {
        char *rest = NULL;
        if (i == 0) {
            heading(file, "Pieces, places and actuators (SI units)");
        }
        paragraph line = paragraph_begin(file, strtok_r(text, ":", &rest));
        for (char *word = strtok_r(NULL, " ", &rest); word; word = strtok_r(NULL, " ", &rest)) {
            paragraph_add(&line, word, false);
        }
        fputc('\n', file);
    }
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
    heading(file,
            "Point sets and their tapes: operations of value and gradient, recorded and left");
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
    heading(file, "Network and memory");
    fprintf(file, "  %-15s %d", "network", network->inputs);
    if (network->fourier_features) {
        fprintf(file, " + 2 x %d Fourier", network->fourier_features);
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
        if (settings->stages[i].optimizer != OPTIM_GAUSS_NEWTON) {
            continue;
        }
        if (linear_model_plan(p, &settings->stages[i], i, &plan, &error) == AD_OK) {
            linear_model_describe(&plan, text);
        }
        fprintf(file, "  %-15s %s\n", "gauss_newton", error.status == AD_OK ? text : error.message);
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
    if (losses->self_adaptive_rate > 0) {
        fprintf(file, "  %-15s self-adaptive: one for every point, climbing in stages of adam\n",
                "weights");
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
    paragraph line = paragraph_begin(file, windows > 1 ? "in each window" : "training");
    for (int i = 0; i < settings->stage_count; i++) {
        char text[64];
        const train_stage *stage = &settings->stages[i];
        snprintf(text, sizeof text, "%s %d steps%s%s", optim_method_name(stage->optimizer),
                 stage->steps, e->targets ? ", targets " : "",
                 e->targets ? train_targets_names()[stage->targets] : "");
        paragraph_add(&line, text, i + 1 < settings->stage_count);
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
        fprintf(file, " (%zu outside the scene left out)", reference_left_out(r));
    }
    double estimate = reference_estimates(r).position_max;
    if (!isnan(estimate)) {
        fprintf(file, ", estimated error %.1e of the length", estimate);
    }
    fputc('\n', file);
}

static void print_family(FILE *file, const scene *scene)
{
    for (int i = 0; i < scene->parameter_count; i++) {
        const scene_parameter *parameter = &scene->parameters[i];
        fprintf(file, "%s%s %g to %g%s", i ? ", " : "  a family of members with ", parameter->name,
                parameter->low, parameter->high,
                parameter->scale == SCENE_LOG ? " by its logarithm" : "");
    }
    if (scene_is_family(scene)) {
        fprintf(file,
                "\n  loads are the largest of all members; shapes, masses and stiffness those "
                "of the middle one\n");
    }
}

static void print_place(FILE *file, const scene *scene)
{
    char text[UNDEFORMED_TEXT];
    ad_error error = {AD_OK, ""};
    const char *when = scene_is_dynamic(scene) ? "at t = 0" : "undeformed";
    if (undeformed_describe(scene, text, &error) != AD_OK) {
        fprintf(file, "  %s: %s\n", when, error.message);
    } else if (*text) {
        fprintf(file, "  %s: %s\n", when, text);
    }
}

static void print_implausible(FILE *file, const scene *scene)
{
    scene_warnings all = scene_implausible(scene);
    for (int i = 0; i < all.count; i++) {
        fprintf(file, "  implausible: %s\n", all.texts[i]);
    }
}

void explain_print(FILE *file, const experiment *e, problem *p, const reference *r)
{
    const scene *scene = e->scene;
    struct scene middle;
    scene_middle(scene, &middle);
    fprintf(file, "%s: %s %s%s%s\n", e->settings->name, scene_model_names()[scene->rod.model],
            scene_is_beam(scene) ? "beam" : "rod",
            scene_is_dynamic(scene) ? " in motion" : " at rest",
            scene_is_manufactured(scene) ? ", manufactured solution" : "");
    print_family(file, scene);
    print_place(file, &middle);
    print_implausible(file, scene);
    if (scene_is_beam(scene)) {
        print_beam_numbers(file, scene);
    } else {
        print_numbers(file, scene);
    }
    print_scales(file, scene);
    print_unknowns(file, e, p);
    print_terms(file, scene);
    print_entries(file, scene);
    if (scene_is_family(scene)) {
        explain_groups(file, scene, &e->settings->groups);
    }
    print_sets(file, p);
    print_network(file, e, p);
    print_plan(file, e, p, r);
}

ad_status explain_programs(FILE *file, const experiment *e, problem *p, ad_error *error)
{
    ad_status status = AD_OK;
    for (int i = 0; status == AD_OK && i < e->settings->stage_count; i++) {
        linear_model_info plan; /* compiles what it needs */
        if (e->settings->stages[i].optimizer == OPTIM_GAUSS_NEWTON) {
            status = linear_model_plan(p, &e->settings->stages[i], i, &plan, error);
        }
    }
    if (status == AD_OK) {
        problem_print(p, file);
    }
    return status;
}
