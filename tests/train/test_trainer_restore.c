/* Checkpoints of training that nobody could have saved, and folders that nothing can be saved to.
 */
#include "trainer_testing.h"

/* ---- checkpoints that cannot be ----------------------------------------------------------------
 */

enum { NUMBERS_MAX = 20000, NAMES_MAX = 32 };

/* What to do with one item: leave it out, give it one number too many, change its first or last,
 * have the coordinates of points, as earlier versions had, where they are drawn again, or have a
 * generator of zeros, which never ends. */
typedef struct tamper {
    const char *name;
    enum { LEAVE_OUT, LENGTHEN, CHANGE, RENAME_COLUMN, AT_COORDINATES, CLEAR } how;
    double value;
} tamper;

/* Copy item `i`, tampered with if it is the one; `numbers` [NUMBERS_MAX + 1] lives until the write.
 */
static void copy_item(const checkpoint *from, size_t i, checkpoint *to, const tamper *change,
                      double *numbers)
{
    const char *name = checkpoint_name(from, i), *text;
    bool chosen = strcmp(name, change->name) == 0;
    int rank;
    size_t shape[CHECKPOINT_MAX_RANK];
    assert_true(checkpoint_shape(from, name, &rank, shape));
    size_t count = shape[0] * shape[1] * shape[2];
    assert_true(count < NUMBERS_MAX);
    if (chosen && change->how == LEAVE_OUT) {
        return;
    }
    size_t longer = count + (chosen && change->how == LENGTHEN);
    if (checkpoint_get_doubles(from, name, numbers, count, NULL) == AD_OK) {
        numbers[0] = chosen && change->how == CHANGE ? change->value : numbers[0];
        numbers[count] = 0.5;
        static const char *columns[NAMES_MAX]; /* there is one table */
        for (size_t k = 0; k < NAMES_MAX && checkpoint_column(from, name, k); k++) {
            columns[k] = checkpoint_column(from, name, k);
        }
        if (checkpoint_column(from, name, 0)) {
            columns[4] = chosen && change->how == RENAME_COLUMN ? "other" : columns[4];
            size_t more = longer > count;
            checkpoint_put_table(to, name, numbers, more ? 1 : shape[0],
                                 more ? shape[1] - 1 : shape[1], columns);
        } else if (longer > count) {
            checkpoint_put_doubles(to, name, numbers, 1, &longer);
        } else {
            checkpoint_put_doubles(to, name, numbers, rank, shape);
        }
    } else if (checkpoint_get_int64(from, name, (int64_t *)numbers, count, NULL) == AD_OK) {
        int64_t *integers = (int64_t *)numbers;
        integers[0] = chosen && change->how == CHANGE ? (int64_t)change->value : integers[0];
        checkpoint_put_int64(to, name, integers, longer > count ? 1 : rank, &longer);
    } else if (checkpoint_get_uint64(from, name, (uint64_t *)numbers, count, NULL) == AD_OK) {
        uint64_t *words = (uint64_t *)numbers;
        if (chosen && change->how == AT_COORDINATES) {
            const size_t points[2] = {2, (size_t)words[count - 1]};
            assert_true(2 * points[1] < NUMBERS_MAX);
            for (size_t k = 0; k < 2 * points[1]; k++) {
                numbers[k] = change->value;
            }
            checkpoint_put_doubles(to, name, numbers, 2, points);
            return;
        }
        words[count] = 1;
        memset(words, 0, chosen && change->how == CLEAR ? 4 * sizeof *words : 0);
        words[count - 1] =
            chosen && change->how == CHANGE ? (uint64_t)change->value : words[count - 1];
        checkpoint_put_uint64(to, name, words, 1, &longer);
    } else {
        assert_int_equal(checkpoint_get_text(from, name, &text, NULL), AD_OK);
        checkpoint_put_text(to, name, text);
    }
}

static ad_status restore_tampered(const checkpoint *good, const tamper *change, ad_error *error)
{
    checkpoint *bad = checkpoint_create("test");
    size_t count = checkpoint_count(good);
    double *numbers = calloc(count * (NUMBERS_MAX + 1), sizeof *numbers);
    assert_true(bad && numbers);
    for (size_t i = 0; i < count; i++) {
        copy_item(good, i, bad, change, numbers + i * (NUMBERS_MAX + 1));
    }
    if (checkpoint_write(bad, &(file_place){.path = in_folder("bad.h5")}, error) != AD_OK) {
        fail_msg("%s", error->message);
    }
    checkpoint_free(bad);
    free(numbers);
    run r = start(DYNAMIC, moving_changes, 1);
    ad_status status = restore(&r, in_folder("bad.h5"), error);
    unlink(in_folder("bad.h5"));
    stop(&r);
    return status;
}

static void check_tampered(const checkpoint *good, tamper change)
{
    ad_error error = {AD_OK, ""};
    ad_status status = restore_tampered(good, &change, &error);
    if (status != AD_BAD_INPUT || strchr(error.message, '\n') || strlen(error.message) < 15) {
        fail_msg("%s (%d, %g): status %d, '%s'", change.name, (int)change.how, change.value,
                 (int)status, error.message);
    }
}

static checkpoint *saved_after(int steps)
{
    run r = start(DYNAMIC, moving_changes, 1);
    for (int i = 0; i < steps; i++) {
        step(&r);
    }
    save(&r, "good.h5");
    stop(&r);
    checkpoint *good = NULL;
    assert_int_equal(checkpoint_open(in_folder("good.h5"), &good, NULL), AD_OK);
    unlink(in_folder("good.h5"));
    return good;
}

static void test_items(void **state)
{
    (void)state;
    for (int steps = 10; steps <= 70; steps += 30) { /* of Adam, L-BFGS, Broyden */
        checkpoint *good = saved_after(steps);
        ad_error error = {AD_OK, ""};
        assert_int_equal(restore_tampered(good, &(tamper){"no such item", LEAVE_OUT, 0}, &error),
                         AD_OK);
        for (size_t i = 0; i < checkpoint_count(good); i++) {
            const char *name = checkpoint_name(good, i);
            /* Whoever opens the file has read the first; the others are found anew. */
            if (strcmp(name, "scene/yaml") == 0 || strcmp(name, "verdict") == 0 ||
                strcmp(name, "estimate") == 0) {
                continue;
            }
            check_tampered(good, (tamper){name, LEAVE_OUT, 0});
            if (strcmp(name, "training/kernels") != 0) { /* texts have no length to be wrong */
                check_tampered(good, (tamper){name, LENGTHEN, 0});
            }
        }
        checkpoint_free(good);
    }
}

static void test_values(void **state)
{
    (void)state;
    static const tamper changes[] = {
        {"training/stage", CHANGE, -1},
        {"training/stage", CHANGE, 4},
        {"training/stage", CHANGE, 3}, /* done, but with an optimiser at work */
        {"training/stage", CHANGE, 0}, /* the state of L-BFGS for Adam */
        {"training/stage", CHANGE, 2}, /* ... for the self-scaled Broyden method */
        {"training/stage_step", CHANGE, -1},
        {"training/stage_step", CHANGE, 41},
        {"training/step", CHANGE, -1},
        {"training/optimizer", CHANGE, 0},
        {"training/optimizer", CHANGE, 2},
        {"training/seconds", CHANGE, -1},
        {"training/seconds", CHANGE, NAN},
        {"training/stage_seconds", CHANGE, INFINITY},
        {"parameters/network/layer0/weight", CHANGE, NAN},
        {"parameters/network/layer0/bias", CHANGE, INFINITY},
        {"optimizer/x", CHANGE, NAN},
        {"optimizer/gradient", CHANGE, INFINITY},
        {"points/interior", CHANGE, 7},
        {"points/initial", CHANGE, 1e9},
        {"points/interior", CLEAR, 0},
        {"generators/interior", CLEAR, 0},
        {"points/interior", AT_COORDINATES, 1.5},
        {"points/initial", AT_COORDINATES, NAN},
        {"causal/weights", CHANGE, 2},
        {"causal/epsilon_index", CHANGE, 3},
        {"history/table", RENAME_COLUMN, 0},
    };
    checkpoint *good = saved_after(40);
    for (size_t i = 0; i < sizeof changes / sizeof *changes; i++) {
        assert_true(checkpoint_has(good, changes[i].name));
        check_tampered(good, changes[i]);
    }
    ad_error error = {AD_OK, ""};
    assert_int_equal(
        restore_tampered(good, &(tamper){"points/interior", AT_COORDINATES, 0.25}, &error), AD_OK);
    checkpoint_free(good);
}

/* Where nothing can be written the run itself goes on. */
static void test_save_fails(void **state)
{
    (void)state;
    run r = start(ELASTICA, static_changes, 1);
    ad_error error = {AD_OK, ""};
    step(&r);
    assert_int_equal(
        fit_save(trainer_fit(r.trainer), &(file_place){.path = in_folder("nowhere/a.h5")}, &error),
        AD_IO);
    assert_non_null(strstr(error.message, "nowhere"));
    step(&r);
    stop(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_items),
        cmocka_unit_test(test_values),
        cmocka_unit_test(test_save_fails),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
