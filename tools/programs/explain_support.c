/* The table of support as a page. */
#include "tools/programs/explain.h"

#include "physics/scene/support.h"

static const char *const answers[] = {[SUPPORT_TAKEN] = "yes",
                                      [SUPPORT_WITHOUT_EFFECT] = "no effect",
                                      [SUPPORT_NOT_BUILT] = "**not yet**",
                                      [SUPPORT_IMPOSSIBLE] = "never"};

static void print_table(FILE *file, bool moves)
{
    fprintf(file, "\n## %s\n\n| |", moves ? "In motion" : "At rest");
    for (int k = 0; k < SUPPORT_FORMS; k++) {
        if (support_form_moves((support_form)k) == moves) {
            fprintf(file, " %s |", support_form_name((support_form)k));
        }
    }
    fputs("\n|---|", file);
    for (int k = 0; k < SUPPORT_FORMS; k++) {
        fputs(support_form_moves((support_form)k) == moves ? "---|" : "", file);
    }
    for (int i = 0; i < support_feature_count(); i++) {
        fprintf(file, "\n| %s |", support_feature_name(i));
        for (int k = 0; k < SUPPORT_FORMS; k++) {
            if (support_form_moves((support_form)k) == moves) {
                fprintf(file, " %s |", answers[support_of(i, (support_form)k)]);
            }
        }
    }
    fputc('\n', file);
}

static bool is_never(int feature, bool moves)
{
    bool found = false;
    for (int k = 0; k < SUPPORT_FORMS; k++) {
        found |= support_form_moves((support_form)k) == moves &&
                 support_of(feature, (support_form)k) == SUPPORT_IMPOSSIBLE;
    }
    return found;
}

void explain_support(FILE *file)
{
    fputs(
        "# What each form takes\n\n"
        "`cpinn-train --explain=support` writes this page. The programs refuse what is not taken "
        "by "
        "the same table, and a\ntest runs a scene of every feature in every form.\n\n"
        "- *yes*: it is taken.\n"
        "- *no effect*: it is accepted, and the answer is the same without it.\n"
        "- *not yet*: it is refused, because it is not built.\n"
        "- *never*: it is refused, because mechanics does not allow it. The reasons are below.\n\n"
        "`mixed`, `displacement`, `pose_strain`, `strain family` and `strain modes` are networks, "
        "by their `formulation`. The\nmethods of `cpinn-solve` are collocation, nodes (its default "
        "in motion unless strains are locked), modes\n"
        "(`--method modes`) and path (`--path`, `--branch`). One-step models are those of "
        "`surrogate` and `control`.\n",
        file);
    print_table(file, false);
    print_table(file, true);
    fputs("\n## Why never\n\n", file);
    for (int i = 0; i < support_feature_count(); i++) {
        for (int moves = 0; moves < 2; moves++) {
            const char *reason = support_feature_reason(i, moves);
            const bool again = moves && is_never(i, false);
            if (is_never(i, moves) && !(again && reason == support_feature_reason(i, false))) {
                fprintf(file, "- %s%s: %s.\n", support_feature_name(i), again ? ", in motion" : "",
                        reason);
            }
        }
    }
}
