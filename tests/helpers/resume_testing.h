/* Fits by least squares that are left after a step and gone on with from a file, by another process
 * as far as they can tell: every number is the same as of one that was never stopped. */
#ifndef TESTS_RESUME_TESTING_H
#define TESTS_RESUME_TESTING_H

#include "near.h"
#include "temporary_folder.h"

#include "tools/train/least_squares.h"

static inline void go_on(fit *f, int64_t until)
{
    ad_error error = {.message = ""};
    while (f->state == FIT_RUNNING && f->at.step < until) {
        if (fit_step(f, &error) != AD_OK) {
            fail_msg("%s", error.message);
        }
    }
}

/* A runner that leaves a fit after so many steps, or goes on with it. The first one trains without
 * a stop. */
typedef struct stops {
    int64_t after; /* < 0: to the end */
    bool resumes;
    history whole;
    fit_place end;
} stops;

static inline void compare(const stops *x, const fit *f)
{
    const size_t columns = (size_t)f->rows.columns;
    assert_true(f->at.step == x->end.step && f->at.window == x->end.window);
    assert_int_equal(f->rows.count, x->whole.count);
    for (size_t i = 0; i < f->rows.count * columns; i++) {
        const bool is_time = strcmp(f->rows.names[i % columns], "seconds") == 0;
        assert_true(is_time || memcmp(&f->rows.rows[i], &x->whole.rows[i], sizeof(double)) == 0);
    }
}

static inline ad_status run_and_stop(void *context, least_squares *ls, ad_error *error)
{
    stops *x = context;
    checkpoint *file = NULL;
    if (x->resumes) {
        assert_int_equal(checkpoint_open(at("left.h5"), &file, error), AD_OK);
        if (fit_restore(&ls->fit, file, error) != AD_OK) {
            fail_msg("%s", error->message);
        }
        go_on(&ls->fit, INT64_MAX);
        compare(x, &ls->fit);
    } else {
        assert_int_equal(fit_start(&ls->fit, error), AD_OK);
        go_on(&ls->fit, x->after < 0 ? INT64_MAX : x->after);
    }
    if (x->after < 0) {
        x->whole = ls->fit.rows;
        x->end = ls->fit.at;
        ls->fit.rows = (history){.rows = NULL};
    } else if (!x->resumes) {
        assert_int_equal(fit_save(&ls->fit, &(file_place){.path = at("left.h5")}, error), AD_OK);
    }
    checkpoint_free(file);
    return AD_OK;
}

#endif
