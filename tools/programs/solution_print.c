#include "tools/programs/solution_print.h"

#include "physics/learn/model.h"
#include "tools/programs/cli.h"

#include <math.h>
#include <stdio.h>

/* What the solver's estimate is relative to. */
static const char *estimate_unit(const scene *of)
{
    return scene_is_beam(of)      ? "of the deflection"
           : scene_is_dynamic(of) ? "of the position"
                                  : "of the length";
}

/* What was found of tendons whose displacement is given. */
static void print_tensions(const solution *solved, const scene *of)
{
    for (int i = 0; i < of->tendon_count && !scene_is_dynamic(of); i++) {
        if (of->tendons[i].displacement.is_given) {
            char name[32];
            snprintf(name, sizeof name, "tendons[%d].tension", i);
            double tension = solution_tension(solved, i);
            printf("  %-24s %.9g N%s\n", name, tension, tension > 0 ? "" : ", slack");
        }
    }
}

/* Prints the energy at the end of the motion, or at rest. */
static ad_status print_energy(const solution *solved, const scene *of, double mismatch,
                              ad_error *error)
{
    solve_energy e;
    ad_status status = solution_energy(solved, scene_duration(of), &e, error);
    if (status != AD_OK) {
        return status;
    }
    if (scene_is_dynamic(of)) {
        printf("  %-24s kinetic %.9g, strain %.9g, work of loads %.9g, dissipated %.9g J\n",
               "energy", e.kinetic, e.strain, e.work, e.dissipated);
        cli_print_error("energy out of balance", mismatch, " of the largest");
        return AD_OK;
    }
    printf("  %-24s strain %.9g", "energy", e.strain);
    if (!isnan(e.work)) {
        printf(", potential of loads %.9g", -e.work + 0.0);
    }
    puts(" J");
    return AD_OK;
}

ad_status solution_print(const solution *solved, const scene *of, const solve_report *r,
                         double seconds, ad_error *error)
{
    const bool moves = scene_is_dynamic(of) && !scene_is_beam(of);
    double tip[MODEL_COLUMNS_MAX];
    double length = scene_length(of), duration = scene_duration(of);
    const double *s = &length, *t = &duration;
    int columns = scene_physics_of(of)->position_columns;
    ad_status status = solution_evaluate(solved, columns, 1, s, t, tip, error);
    if (status != AD_OK) {
        return status;
    }
    printf("solved: %d nodes, ", r->nodes);
    if (r->mode_count > 0) {
        const int *modes = r->modes; /* v, u */
        printf("%d modes (bending %d, %d, twist %d, stretch %d, shear %d, %d), ", r->mode_count,
               modes[3], modes[4], modes[5], modes[2], modes[0], modes[1]);
    }
    if (scene_is_dynamic(of)) {
        printf("%ld steps of time, ", r->time_steps);
    } else if (!scene_is_beam(of)) {
        printf("load in %ld step%s, %ld Newton steps, ", r->load_steps,
               r->load_steps == 1 ? "" : "s", r->newton_steps);
    }
    printf("%.1f ms", 1e3 * seconds);
    if (r->mode_count > 0) {
        printf(", %.2g times real time", scene_duration(of) / seconds);
    }
    putchar('\n');
    if (!isnan(r->estimate)) {
        const double misfit = solve_misfit(r);
        printf("  %-24s %.3e %s", "estimated error", r->estimate_l2 + misfit, estimate_unit(of));
        if (moves) {
            printf(", relative L2; at most %.1e of the length", r->estimate + misfit);
        }
        if (misfit > 0) {
            printf("; %.1e of it is by the misfit of rod.law", misfit);
        }
        putchar('\n');
    }
    if (!isnan(r->balance)) {
        printf("  %-24s %.3e\n", "loads out of balance", r->balance);
    }
    printf("  %-24s", "tip");
    for (int i = 0; i < columns; i++) {
        printf(" %.15g", tip[i]);
    }
    puts(" m");
    print_tensions(solved, of);
    return scene_is_beam(of) ? AD_OK : print_energy(solved, of, r->energy_mismatch, error);
}

void solution_print_errors(const char *title, const reference *known,
                           const reference_errors *errors)
{
    printf("%s %s (%zu points", title, reference_name(known), reference_points(known));
    if (reference_left_out(known)) {
        printf("; %zu outside the scene, or without a number, left out", reference_left_out(known));
    }
    puts(")");
    cli_print_error("position, relative L2", errors->position, "");
    cli_print_error("position, largest", errors->position_max, " of the length");
    cli_print_error("tip", errors->tip, " of the length");
    cli_print_error("rotation, rms", errors->rotation, " rad");
    cli_print_error("rotation, largest", errors->rotation_max, " rad");
    if (isnan(errors->position)) {
        puts("  the position is not a number");
    }
}
