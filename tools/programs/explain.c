#include "tools/programs/explain_parts.h"

#include "physics/beam/beam.h"
#include "physics/check/plausible.h"
#include "physics/rod/strain.h"
#include "physics/scene/support.h"
#include "physics/solve/modes_model.h"
#include "tools/programs/undeformed.h"
#include "tools/train/linear_model.h"

#include <math.h>
#include <string.h>

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
    explain_heading(file, "How hard it is");
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
    explain_heading(file, "How hard it is");
    print_rows(file, rows, sizeof rows / sizeof *rows);
    print_motion_numbers(file, scene, n.periods);
}

static void print_scales(FILE *file, const scene *scene)
{
    rod_scales scales = rod_scales_of(scene);
    explain_heading(file, "Scales (1 of the dimensionless equations)");
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
        if (scene->formulation == SCENE_STRAIN_FORM) {
            fprintf(file, "planar, %s by symmetry: the strains in it alone\n", where);
            return;
        }
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

/* A family that the strain form would not take. */
static void print_why_mixed(FILE *file, const scene *family)
{
    scene middle;
    ad_error why;
    if (!scene_is_family(family)) {
        return;
    }
    scene_middle(family, &middle);
    if (!scene_is_dynamic(family) && strain_takes(&middle, &why) != AD_OK) {
        fprintf(file, "  %-15s %s\n", "not by members", why.message);
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
    print_why_mixed(file, scene);
}

/* Where the residuals come from, and of a rod in motion which key has the other form. At rest one
 * rod has this form alone. */
static void print_residual(FILE *file, const scene *scene)
{
    ad_error why;
    fprintf(file, "  %-15s by the tape", "residual");
    if (scene_is_dynamic(scene) && !scene_is_beam(scene)) {
        const bool takes = support_check(scene, SUPPORT_STRAIN_MOTION, NULL, &why) == AD_OK;
        fprintf(file, "; formulation: strain, modes of the strain, has it in closed form%s%s",
                takes ? "" : ",\n                  but not here: ", takes ? "" : why.message);
    }
    fputc('\n', file);
}

static void print_fields(FILE *file, const scene *scene, const problem *p)
{
    print_form(file, scene);
    print_residual(file, scene);
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

static void print_modes(FILE *file, const experiment *e)
{
    int of[6];
    modes_model_counts(e->modes, of);
    fprintf(file,
            "  %-15s strain, dynamic: q[%d] modes of time, bending %d, %d, twist %d, stretch %d, "
            "shear %d, %d\n",
            "form", e->model->outputs, of[3], of[4], of[5], of[2], of[0], of[1]);
    fprintf(file,
            "  %-15s in closed form, not by the tape; formulation: mixed has the equations of the\n"
            "  %-15s rod on the tape, and may have hidden layers\n",
            "residual", "");
    print_motion(file, e->scene);
    fprintf(file,
            "  %-15s start, end and initial state: hard; rotation and position by the strains\n",
            "boundary");
    fprintf(file, "  %-15s q_t q_tt; of the residual by q, q_t, q_tt in closed form\n",
            "derivatives");
}

static void print_unknowns(FILE *file, const experiment *e, const problem *p)
{
    explain_heading(file, "Unknowns and equations");
    if (e->modes) {
        print_modes(file, e);
    } else if (e->targets) {
        explain_members(file, e);
    } else {
        print_fields(file, e->scene, p);
    }
    paragraph terms = explain_paragraph_begin(file, "loss terms");
    for (int i = 0; i < problem_terms(p); i++) {
        char text[64];
        snprintf(text, sizeof text, "%s (weight %g)", problem_term_name(p, i),
                 problem_term_weight(p, i));
        explain_paragraph_add(&terms, text, i + 1 < problem_terms(p));
    }
    fputc('\n', file);
}

/* Prints all terms that are left out for the same reason in one paragraph. */
static void print_left_out(FILE *file, const rod_term *terms, int count, int first)
{
    char text[96];
    paragraph line = explain_paragraph_begin(file, "left out");
    for (int i = first; i < count; i++) {
        bool same = !terms[i].present && strcmp(terms[i].reason, terms[first].reason) == 0;
        if (same) {
            bool another = false;
            for (int k = i + 1; k < count; k++) {
                another = another ||
                          (!terms[k].present && strcmp(terms[k].reason, terms[first].reason) == 0);
            }
            snprintf(text, sizeof text, "%s%s", terms[i].name, another ? "" : ":");
            explain_paragraph_add(&line, text, another);
        }
    }
    explain_paragraph_add(&line, terms[first].reason, false);
    fputc('\n', file);
}

static void print_terms(FILE *file, const scene *scene)
{
    rod_term terms[ROD_TERM_MAX];
    int count = scene_physics_of(scene)->terms(scene, terms), left = 0;
    explain_heading(file, "Physics");
    paragraph line = explain_paragraph_begin(file, "present");
    for (int i = 0; i < count; i++) {
        left += terms[i].present;
    }
    for (int i = 0; i < count; i++) {
        if (terms[i].present) {
            explain_paragraph_add(&line, terms[i].name, --left > 0);
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
            explain_heading(file, "Pieces, places and actuators (SI units)");
        }
        paragraph line = explain_paragraph_begin(file, strtok_r(text, ":", &rest));
        for (char *word = strtok_r(NULL, " ", &rest); word; word = strtok_r(NULL, " ", &rest)) {
            explain_paragraph_add(&line, word, false);
        }
        fputc('\n', file);
    }
}

/* ---- the page ------------------------------------------------------------------------------- */

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
    explain_parameters(file, e);
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
    explain_costs(file, e, p, r);
}

ad_status explain_programs(FILE *file, const experiment *e, problem *p, ad_error *error)
{
    ad_status status = AD_OK;
    for (int i = 0; status == AD_OK && i < e->settings->stage_count; i++) {
        linear_model_info plan; /* compiles what it needs */
        if (optim_method_needs(e->settings->stages[i].optim.method) == OPTIM_NEEDS_SQUARES) {
            status = linear_model_plan(p, &e->settings->stages[i], i, &plan, error);
        }
    }
    if (status == AD_OK) {
        problem_print(p, file);
    }
    return status;
}
