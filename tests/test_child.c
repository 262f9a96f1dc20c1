/* Work in a process of its own: what comes back, and what is said where nothing does. */
#include "tools/judge/child.h"

#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

typedef enum task { DOUBLE_IT, KILL_ITSELF, EXIT, RUN_ON } task;

enum { NUMBERS = 30000 }; /* more than a pipe holds */

typedef struct result {
    double numbers[NUMBERS];
} result;

static void work(const void *asked, void *to)
{
    result *r = to;
    for (int i = 0; i < NUMBERS; i++) {
        r->numbers[i] *= 2;
    }
    switch (*(const task *)asked) {
    case KILL_ITSELF:
        raise(SIGKILL);
        break;
    case EXIT:
        _exit(3);
    case RUN_ON:
        for (;;) {
            pause();
        }
    default:
        break;
    }
}

static child_end run(task asked, double seconds, result *r, char why[CHILD_WHY])
{
    ad_error error;
    child_end end;
    for (int i = 0; i < NUMBERS; i++) {
        r->numbers[i] = i;
    }
    assert_int_equal(child_run(work, &asked, r, sizeof *r, seconds, &end, why, &error), AD_OK);
    for (int i = 0; i < NUMBERS; i++) {
        assert_true(r->numbers[i] == (end == CHILD_TOLD ? 2 * i : i));
    }
    return end;
}

static void test_child(void **state)
{
    (void)state;
    static result r;
    char why[CHILD_WHY];
    assert_int_equal(run(DOUBLE_IT, 60, &r, why), CHILD_TOLD);
    assert_int_equal(run(KILL_ITSELF, 60, &r, why), CHILD_DIED);
    assert_string_equal(why, "signal 9");
    assert_int_equal(run(EXIT, 60, &r, why), CHILD_DIED);
    assert_string_equal(why, "exit status 3");
    assert_int_equal(run(RUN_ON, 0.05, &r, why), CHILD_LATE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_child)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
