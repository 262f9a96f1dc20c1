/* Parameters of a scene, what a family depends on and what it is learnt from, in words. */
#include "tools/programs/explain.h"

#include <string.h>

enum { WIDTH = 96, INDENT = 6 };

/* A line of words, which goes on behind an indent. */
static void print_line(FILE *file, char *text)
{
    char *rest = NULL;
    int column = 1;
    fputc(' ', file);
    for (char *word = strtok_r(text, " ", &rest); word; word = strtok_r(NULL, " ", &rest)) {
        const int length = (int)strlen(word);
        if (column + 1 + length > WIDTH) {
            fprintf(file, "\n%*s", INDENT - 1, "");
            column = INDENT - 1;
        }
        column += fprintf(file, " %s", word);
    }
    fputc('\n', file);
}

void explain_groups(FILE *file, const scene *family, const groups_settings *settings)
{
    groups *groups;
    ad_error error = {.message = ""};
    char line[600];
    fputs("\nGroups, dimensionless numbers on which the shapes of the family depend\n", file);
    if (groups_find(family, settings, &groups, &error) != AD_OK) {
        fprintf(file, "  %s\n", error.message);
        return;
    }
    for (int i = 0; groups_text(groups, i, line, sizeof line); i++) {
        print_line(file, line);
    }
    groups_free(groups);
}

static void print_family(FILE *file, const scene *scene)
{
    for (int i = 0; i < scene_known_count(scene); i++) {
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

/* What is to be found, and what from. */
static void print_sought(FILE *file, const experiment *e)
{
    const scene *scene = e->scene;
    for (int i = scene_known_count(scene); i < scene->parameter_count; i++) {
        const scene_parameter *parameter = &scene->parameters[i];
        fprintf(file, "  to be found: %s from %g on, within %g to %g%s\n", parameter->name,
                scene->guess[i], parameter->low, parameter->high,
                parameter->scale == SCENE_LOG ? " by its logarithm" : "");
    }
    for (int i = 0; scene->unknown_count > 0 && i < e->settings->data_count; i++) {
        const train_data *data = &e->settings->data[i];
        fprintf(file, "  measured: %s of %s", train_quantity_names()[data->quantity], data->file);
        fprintf(file, data->noise > 0 ? ", noise %g\n" : ", noise not known\n", data->noise);
    }
}

void explain_parameters(FILE *file, const experiment *e)
{
    print_family(file, e->scene);
    print_sought(file, e);
}

void explain_members(FILE *file, const experiment *e)
{
    const targets_account drawn = targets_drawn(e->targets);
    const family *f = targets_family(e->targets);
    const train_settings *settings = e->settings;
    const char *given = settings->members_file;
    const size_t solved = drawn.ends[SOLVE_MEMBER_SOLVED];
    char why[TARGETS_TEXT];
    targets_unsolved_text(e->targets, why);
    char torsion[40] = "";
    if (e->scene->tube_count > 0) {
        snprintf(torsion, sizeof torsion, ", m[%d] torsion of tubes", e->scene->tube_count);
    }
    fprintf(file,
            "  %-15s strain, static: u[3] curvature%s at %zu places, of %d parameters alone;\n"
            "  %-15s rotation and position follow exactly, the clamp is met exactly\n",
            "form", torsion, family_nodes(f), e->scene->parameter_count, "");
    fprintf(file,
            "  %-15s none: members are solved without the tape, and learnt; formulation: mixed\n"
            "  %-15s has the equations of the rod on the tape\n",
            "residual", "");
    fprintf(file,
            "  %-15s %d principal components of what is not affine in the inputs, %.2g of the\n"
            "  %-15s length; all others are worth %.1g of it\n",
            "modes", family_modes(f), family_spread(f), "", family_missed(f));
    fprintf(file, "  %-15s %zu to learn, %s %s; %d others are drawn by uniform to measure by\n",
            "members", drawn.solved, given ? "of" : "drawn by",
            given ? given : sampling_kind_text(settings->losses.interior.sampler), TARGETS_FRESH);
    fprintf(file,
            "  %-15s %zu solved in %.2g s, %.2g us each on %d thread%s\n"
            "  %-15s %zu not solved, and left out%s\n",
            "", solved, drawn.seconds, 1e6 * drawn.seconds / (double)drawn.drawn,
            ad_pool_threads(e->pool), ad_pool_threads(e->pool) == 1 ? "" : "s", "",
            drawn.drawn - solved, why);
    if (solve_members_is_unloaded(targets_solver(e->targets)) && e->scene->tube_count == 0) {
        fprintf(
            file,
            "  %-15s nothing acts but tendons and chambers, so each point of the rod is solved\n"
            "  %-15s by itself: a network is hardly faster, and not worth its training\n",
            "", "");
    }
}
