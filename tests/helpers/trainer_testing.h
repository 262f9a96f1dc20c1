/* For tests of training: runs of small scenes, step by step, and a folder for their checkpoints. */
#ifndef TESTS_TRAINER_TESTING_H
#define TESTS_TRAINER_TESTING_H

#include "training_testing.h"

#include "tools/train/trainer.h"

#include <unistd.h>

/* ---- runs --------------------------------------------------------------------------------------
 */

#define DYNAMIC  "configs/cantilever_deep.yaml"
#define ELASTICA "configs/elastica_deep.yaml"

/* 25 steps of Adam, 35 of L-BFGS, whose memory is full after 6, 15 of the self-scaled Broyden
 * method. */
#define STAGES                                                                                     \
    "training.stages=[{optimizer: adam, steps: 25, schedule: cosine, warmup_steps: 3}, "           \
    "{optimizer: lbfgs, steps: 35, memory: 6}, {optimizer: ssbroyden, steps: 15}]"

static const char *const static_changes[] = {STAGES, "output.every=4", NULL};
static const char *const moving_changes[] = {STAGES,
                                             "output.every=3",
                                             "enforcement.initial=soft",
                                             "enforcement.boundary=soft",
                                             "losses.interior.sampler=latin_hypercube",
                                             "losses.interior.resample_every=11",
                                             "losses.initial.sampler=uniform",
                                             "losses.initial.resample_every=13",
                                             "losses.causal.slices=3",
                                             "losses.causal.update_every=7",
                                             "losses.causal.epsilon=[1e-6, 1e-4, 1e-2]",
                                             "losses.causal.threshold=0.5",
                                             NULL};
static const char *const balanced_changes[] = {STAGES,
                                               "output.every=3",
                                               "enforcement.initial=soft",
                                               "losses.interior.sampler=uniform",
                                               "losses.interior.resample_every=11",
                                               "losses.causal.slices=3",
                                               "losses.causal.update_every=7",
                                               "losses.balance=gradient_norm",
                                               "losses.balance_every=4",
                                               NULL};

enum { STEPS_MAX = 80 };

typedef struct run {
    made made;
    reference *known;
    trainer *trainer;
} run;

static inline run start(const char *path, const char *const *changes, int threads)
{
    run r = {.made = make_problem(path, changes, threads)};
    ad_error error = {AD_OK, ""};
    if (reference_create(r.made.e, &r.known, &error) != AD_OK ||
        trainer_create(r.made.e, r.made.p, r.known, 0, &r.trainer, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return r;
}

static inline void stop(run *r)
{
    trainer_free(r->trainer);
    reference_free(r->known);
    made_free(&r->made);
}

static inline void step(run *r)
{
    ad_error error = {AD_OK, ""};
    if (trainer_step(r->trainer, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
}

static inline void finish(run *r)
{
    while (trainer_fit(r->trainer)->state == FIT_RUNNING) {
        step(r);
    }
}

static inline ad_status restore(run *r, const char *path, ad_error *error)
{
    checkpoint *file;
    ad_status status = checkpoint_open(path, &file, error);
    if (status == AD_OK) {
        status = fit_restore(trainer_fit(r->trainer), file, error);
        checkpoint_free(file);
    }
    return status;
}

static char folder[64];

static const char *in_folder(const char *name)
{
    static char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static inline int make_folder(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/cpinn_test_trainer_XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static inline int remove_folder(void **state)
{
    (void)state;
    return rmdir(folder); /* every test has cleaned up behind itself */
}

static inline void save(run *r, const char *name)
{
    ad_error error = {AD_OK, ""};
    if (fit_save(trainer_fit(r->trainer), &(file_place){.path = in_folder(name)}, &error) !=
        AD_OK) {
        fail_msg("%s", error.message);
    }
}

#endif
