/* Work in a process of its own: what comes back, and what is said where nothing does. */
#include "tools/judge/child.h"

#include <poll.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/wait.h>
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

/* The end of a program, however it comes, is that of the child it waits for. */
static void test_parent_dies(void **state)
{
    (void)state;
    static result r;
    int ends[2];
    char byte;
    char why[CHILD_WHY];
    assert_int_equal(pipe(ends), 0);
    pid_t parent = fork();
    if (parent == 0) { /* the child inherits the writing end, and holds it while it lives */
        close(ends[0]);
        run(RUN_ON, 60, &r, why);
        _exit(0);
    }
    close(ends[1]);
    struct pollfd waiting = {.fd = ends[0], .events = POLLIN};
    assert_int_equal(poll(&waiting, 1, 300), 0); /* both live */
    kill(parent, SIGKILL);
    waitpid(parent, NULL, 0);
#ifdef __linux__
    assert_int_equal(poll(&waiting, 1, 10000), 1);
    assert_int_equal(read(ends[0], &byte, 1), 0); /* nobody holds it any more */
#else
    (void)byte;
#endif
    close(ends[0]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_child),
                                       cmocka_unit_test(test_parent_dies)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
