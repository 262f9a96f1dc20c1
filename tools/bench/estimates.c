/* estimates [--short] [SCENE.yaml]...
 *
 * How well the error of a network with hidden layers is estimated: such networks are trained on
 * scenes at rest and in motion, rods and beams, and looked at again and again on the way, from the
 * first steps of Adam to those of Broyden's method. Each time the estimate (error_estimate.h),
 * which sees the network and the equations, is compared with the largest distance to the scene's
 * closed form, or to its classical solution from the unstressed rod; motions are solved by spectral
 * elements for this, and by strain modes for the estimate. --short: some scenes, few steps.
 *
 * Exit status: 1 where an estimate is further than a factor 10 from the error, is not known, or
 * would let a network pass whose error is ten times the tolerance of its verdict. */
#include "tools/prepare/config_session.h"
#include "tools/programs/cli.h"
#include "tools/train/learnt_balance.h"
#include "tools/train/session.h"
#include "tools/train/trainer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LOOKS = 5 };

static const char program[] = "estimates";

/* What nobody sees is smaller; the least that references resolve in motion. */
static const double FACTOR = 10, TOLERANCE = 1e-3;

/* After so many steps of both stages. */
static const int AT[LOOKS] = {20, 300, 600, 1200, 2500};

static const struct {
    const char *file; /* which names a reference */
    bool is_short;
} scenes[] = {{"configs/elastica.yaml", true},
              {"configs/heavy_cantilever.yaml", false},
              {"configs/helix.yaml", true},
              {"configs/rollup.yaml", false},
              {"configs/tapered_arm.yaml", false},
              {"configs/cases/follower_5.yaml", false},
              {"configs/cases/bend_45.yaml", false},
              {"configs/cases/shear_stretch.yaml", false},
              {"configs/robots/tendon_one_segment.yaml", true},
              {"configs/robots/soft_arm_three_chambers.yaml", false},
              {"configs/robots/catheter_routed_tendon.yaml", false},
              {"configs/robots/concentric.yaml", false},
              {"configs/beam_cantilever.yaml", true},
              {"configs/cases/timoshenko_tip_force.yaml", false},
              {"configs/cantilever_dynamic.yaml", true},
              {"configs/soft_arm.yaml", false},
              {"configs/robots/tendon_in_motion.yaml", false},
              {"configs/cases/spinning.yaml", false},
              {"configs/cases/release.yaml", false},
              {"configs/beam_vibration.yaml", true},
              {"configs/timoshenko_vibration.yaml", false},
              {"configs/cases/beam_step.yaml", false},
              {"configs/cases/beam_mode_pinned.yaml", false},
              {"configs/cases/travelling_helix.yaml", false},
              {"configs/cases/torsion_wave.yaml", false}};
enum { SCENES = sizeof scenes / sizeof *scenes };

typedef struct tally {
    int runs, off, silent, unknown;
    double least, most; /* estimate over error */
} tally;

static ad_status open(const char *path, session *s, ad_error *error)
{
    static const char training[] =
        "training={seed: 1, stages: [{optimizer: adam, steps: 400, learning_rate: 5.0e-3}, "
        "{optimizer: ssbroyden, steps: 2100}]}";
    static const char *const changes[] = {"formulation=mixed", "network=null",
                                          "network={hidden: [20, 20]}", training,
                                          "losses={interior: {points: 256}}"};
    config *settings;
    ad_status status =
        prepare_read(path, NULL, sizeof changes / sizeof *changes, changes, &settings, error);
    return status == AD_OK ? config_session_create(settings, 0, s, error) : status;
}

/* Of the network as it is. */
static ad_status compare(const session *s, const char *scene, tally *all, ad_error *error)
{
    experiment *e = s->e;
    double *x = experiment_parameters(e), *kept = malloc(e->count * sizeof *kept), estimate;
    ad_error why = {.message = ""};
    reference_errors errors;
    if (!kept) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory");
    }
    memcpy(kept, x, e->count * sizeof *x);
    memcpy(x, trainer_parameters(s->trainer), e->count * sizeof *x);
    ad_status status = reference_compare(s->known, x, &errors, error);
    status = status == AD_OK ? experiment_error(e, NULL, &estimate, &why) : status;
    memcpy(x, kept, e->count * sizeof *x);
    free(kept);
    if (status != AD_OK) {
        return status;
    }
    /* The largest is over the length, also of beams, whose estimate is over the deflection. */
    const double off_by = scene_is_beam(e->scene) ? errors.position : errors.position_max;
    const double ratio = estimate / off_by;
    const bool silent = estimate <= TOLERANCE && off_by > FACTOR * TOLERANCE;
    const bool off = !(ratio <= FACTOR && ratio >= 1 / FACTOR);
    printf("%-26s %6lld   %.2e   %.2e   %6.3f%s%s%s%s\n", scene,
           (long long)trainer_fit(s->trainer)->at.step, off_by, estimate, ratio,
           off ? "   OFF" : "", silent ? "   SILENT" : "", isnan(estimate) ? "   " : "",
           isnan(estimate) ? why.message : "");
    all->runs++;
    all->off += off;
    all->silent += silent;
    all->unknown += isnan(estimate);
    all->least = fmin(all->least, ratio);
    all->most = fmax(all->most, ratio);
    return AD_OK;
}

static bool goes_on(const session *s, int step)
{
    const fit *f = trainer_fit(s->trainer);
    return f->state == FIT_RUNNING && f->at.step < step;
}

static ad_status follow(const char *path, bool is_short, tally *all, ad_error *error)
{
    const char *slash = strrchr(path, '/');
    session s = {.e = NULL};
    ad_status status = open(path, &s, error);
    if (status == AD_OK && !s.known) {
        status = ad_fail(error, AD_BAD_INPUT, "%s: names no reference to compare with", path);
    }
    for (int i = 0; i < (is_short ? 3 : LOOKS) && status == AD_OK; i++) {
        while (status == AD_OK && goes_on(&s, AT[i])) {
            status = trainer_step(s.trainer, error);
        }
        status = status == AD_OK ? compare(&s, slash ? slash + 1 : path, all, error) : status;
        fflush(stdout);
    }
    session_free(&s);
    return status;
}

static bool print_tally(const tally *all)
{
    printf("%d networks: estimate over error %.3f to %.3f; %d further off than a factor %g, "
           "%d silent, %d unknown\n",
           all->runs, all->least, all->most, all->off, FACTOR, all->silent, all->unknown);
    return all->runs > 0 && all->off == 0 && all->silent == 0 && all->unknown == 0;
}

int main(int count, char **arguments)
{
    tally all = {.least = INFINITY};
    ad_error error = {.message = ""};
    ad_status status = AD_OK;
    const bool is_short = count > 1 && strcmp(arguments[1], "--short") == 0;
    const int first = is_short ? 2 : 1;
    printf("scene                        step   error      estimate     ratio\n");
    for (int i = first; i < count && status == AD_OK; i++) {
        status = follow(arguments[i], is_short, &all, &error);
    }
    for (int i = 0; i < SCENES && first >= count && status == AD_OK; i++) {
        if (!is_short || scenes[i].is_short) {
            status = follow(scenes[i].file, is_short, &all, &error);
        }
    }
    if (status != AD_OK) {
        return cli_fail_error(program, &error);
    }
    return print_tally(&all) ? 0 : 1;
}
