/* A checkpoint is complete whatever stops the writer: a kill, a full disk, no memory. All
 * comparisons are of bytes, so there are no tolerances. */
#include "checkpoint_example.h"

/* ---- the n-th allocation fails: glibc only, and not under a sanitizer with its own malloc ---- */

#if defined(__SANITIZE_ADDRESS__)
#define OWN_MALLOC 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define OWN_MALLOC 0
#endif
#endif
#if !defined(OWN_MALLOC) && defined(__GLIBC__)
#define OWN_MALLOC 1
#endif

#if OWN_MALLOC
static long allocations_left = -1; /* negative: no limit */
static long allocations_seen;

void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *old, size_t size);
extern char __executable_start, etext; /* set by the linker around this program's code */

/* HDF5 1.10 itself crashes without memory, so only calls from this program's code fail. */
static int allocation_fails(const void *caller)
{
    if (allocations_left < 0 || (const char *)caller < &__executable_start ||
        (const char *)caller > &etext) {
        return 0;
    }
    allocations_seen++;
    return allocations_left == 0 || allocations_left-- == 0;
}

void *malloc(size_t size)
{
    return allocation_fails(__builtin_return_address(0)) ? NULL : __libc_malloc(size);
}

void *calloc(size_t count, size_t size)
{
    return allocation_fails(__builtin_return_address(0)) ? NULL : __libc_calloc(count, size);
}

void *realloc(void *old, size_t size)
{
    return allocation_fails(__builtin_return_address(0)) ? NULL : __libc_realloc(old, size);
}
#endif

/* ---- the disk ---- */

static void generations_are_kept(void **state)
{
    (void)state;
    for (int k = 1; k <= 5; k++) {
        write_example(at("checkpoint.h5"), k, 3);
    }
    assert_int_equal(entries(0), 3);
    assert_true(stamp_of(at("checkpoint.h5")) == 5.0);
    assert_true(stamp_of(at("checkpoint.1.h5")) == 4.0);
    assert_true(stamp_of(at("checkpoint.2.h5")) == 3.0);
    /* A kill before link(2) leaves a gap; nothing behind it is lost. */
    assert_int_equal(unlink(at("checkpoint.1.h5")), 0);
    write_example(at("checkpoint.h5"), 6, 3);
    assert_true(stamp_of(at("checkpoint.1.h5")) == 5.0);
    assert_true(stamp_of(at("checkpoint.2.h5")) == 3.0);
    /* A kill after link(2) leaves two names of one file; it is not kept twice. */
    assert_int_equal(unlink(at("checkpoint.1.h5")), 0);
    assert_int_equal(link(at("checkpoint.h5"), at("checkpoint.1.h5")), 0);
    write_example(at("checkpoint.h5"), 7, 3);
    assert_true(stamp_of(at("checkpoint.h5")) == 7.0);
    assert_true(stamp_of(at("checkpoint.1.h5")) == 6.0);
    assert_true(stamp_of(at("checkpoint.2.h5")) == 3.0);
    write_example(at("checkpoint.h5"), 8, 1); /* the older ones are left alone */
    assert_true(stamp_of(at("checkpoint.1.h5")) == 6.0);
    write_example(at("checkpoint.h5"), 9, 2);
    assert_true(stamp_of(at("checkpoint.1.h5")) == 8.0);

    ad_error error = {AD_OK, ""};
    checkpoint *cp = checkpoint_create("v");
    assert_int_equal(
        checkpoint_write(cp, &(file_place){.path = at("checkpoint.h5"), .older = -1}, &error),
        AD_BAD_ARGUMENT);
    checkpoint_free(cp);
    char *older = file_bytes_older("run.d/.hidden", 2);
    assert_string_equal(older, "run.d/.hidden.2");
    free(older);
}

/* A folder that is open is written to, and not the one that has taken its name. */
static void an_open_folder_is_kept_to(void **state)
{
    (void)state;
    char run[4096], aside[4096], within[4200], beside[4200];
    snprintf(run, sizeof run, "%s", at("run"));
    snprintf(aside, sizeof aside, "%s", at("aside"));
    assert_int_equal(mkdir(run, 0777), 0);
    const int folder = open(run, O_RDONLY | O_DIRECTORY);
    assert_true(folder > 0);
    assert_int_equal(rename(run, aside), 0);
    assert_int_equal(mkdir(run, 0777), 0);
    snprintf(within, sizeof within, "%s/checkpoint.h5", run);
    for (int k = 1; k <= 3; k++) {
        checkpoint *cp = example(k);
        const file_place place = {within, 1, folder};
        assert_int_equal(checkpoint_write(cp, &place, NULL), AD_OK);
        checkpoint_free(cp);
    }
    close(folder);
    assert_int_equal(rmdir(run), 0); /* it is empty */
    for (int k = 0; k < 2; k++) {
        snprintf(beside, sizeof beside, "%s/checkpoint%s.h5", aside, k ? ".1" : "");
        assert_true(stamp_of(beside) == 3.0 - k);
        assert_int_equal(unlink(beside), 0);
    }
    assert_int_equal(rmdir(aside), 0); /* nothing partial is left */
}

static void assert_write_fails(const char *path, const char *reason)
{
    ad_error error = {AD_OK, ""};
    checkpoint *cp = example(2.0);
    assert_int_equal(checkpoint_write(cp, &(file_place){.path = path, .older = 1}, &error), AD_IO);
    checkpoint_free(cp);
    assert_null(strchr(error.message, '\n'));
    if (!strstr(error.message, path) || !strstr(error.message, reason)) {
        fail_msg("'%s' names neither '%s' nor '%s'", error.message, path, reason);
    }
}

static void failed_writes_change_nothing(void **state)
{
    (void)state;
    char longest[300];
    write_example(at("checkpoint.h5"), 1.0, 1);
    assert_write_fails(at("no/such/checkpoint.h5"), "directory must exist");
    assert_write_fails(at("checkpoint.h5/below.h5"), "Not a directory");
    assert_int_equal(mkdir(at("folder.h5"), 0700), 0);
    assert_write_fails(at("folder.h5"), "a directory is there");
    memset(longest, 'n', sizeof longest);
    strcpy(longest + 250, ".h5");
    ad_error error = {AD_OK, ""};
    checkpoint *cp = example(2.0);
    assert_int_equal(checkpoint_write(cp, &(file_place){.path = at(longest)}, &error), AD_IO);
    checkpoint_free(cp);
    if (geteuid() != 0) {
        chmod(directory, 0500);
        assert_write_fails(at("checkpoint.h5"), "Permission denied");
        chmod(directory, 0700);
    }

    /* A limit on the size of files stands for a full disk. */
    struct rlimit old, small;
    getrlimit(RLIMIT_FSIZE, &old);
    small = old;
    small.rlim_cur = 1000;
    signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &small);
    error.message[0] = 0;
    cp = example(2.0);
    ad_status status =
        checkpoint_write(cp, &(file_place){.path = at("checkpoint.h5"), .older = 1}, &error);
    setrlimit(RLIMIT_FSIZE, &old);
    signal(SIGXFSZ, SIG_DFL);
    checkpoint_free(cp);
    assert_int_equal(status, AD_NOT_WRITTEN);
    assert_non_null(strstr(error.message, "free some space"));
    assert_true(stamp_of(at("checkpoint.h5")) == 1.0);
    assert_int_equal(entries(0), 2); /* checkpoint.h5 and folder.h5, no partial file */
}

static void a_second_writer_is_refused(void **state)
{
    (void)state;
    int ready[2];
    char byte = 0;
    write_example(at("checkpoint.h5"), 1.0, 1);
    assert_int_equal(pipe(ready), 0);
    pid_t child = fork();
    if (child == 0) {
        struct flock lock = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
        int file = open(at("checkpoint.h5.partial"), O_RDWR | O_CREAT, 0600);
        fcntl(file, F_SETLK, &lock);
        if (write(ready[1], &byte, 1) == 1) {
            pause();
        }
        _exit(0);
    }
    assert_int_equal(read(ready[0], &byte, 1), 1);
    assert_write_fails(at("checkpoint.h5"), "another process is writing it");
    kill(child, SIGKILL);
    waitpid(child, NULL, 0);
    close(ready[0]);
    close(ready[1]);
    /* The stale partial file it left is reused. */
    write_example(at("checkpoint.h5"), 2.0, 1);
    assert_true(stamp_of(at("checkpoint.h5")) == 2.0);
    assert_int_equal(entries(0), 1);
}

static void a_killed_writer_leaves_a_checkpoint(void **state)
{
    (void)state;
    double last = 0.0;
    write_example(at("checkpoint.h5"), last, 3);
    for (int round = 0; round < 30; round++) {
        pid_t child = fork();
        if (child == 0) {
            for (double stamp = last + 1.0;; stamp += 1.0) {
                checkpoint *cp = example(stamp);
                if (checkpoint_write(cp, &(file_place){.path = at("checkpoint.h5"), .older = 2},
                                     NULL) != AD_OK) {
                    _exit(1);
                }
                checkpoint_free(cp);
            }
        }
        /* Complete at every instant, also while it is being replaced. */
        long microseconds = 2000 + (long)(next_random() % 20000);
        struct timespec pause_time = {0, microseconds * 1000 / 4};
        for (int look = 0; look < 4; look++) {
            nanosleep(&pause_time, NULL);
            assert_false(isnan(stamp_of(at("checkpoint.h5"))));
        }
        int status = 0;
        assert_int_equal(kill(child, SIGKILL), 0);
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_true(WIFSIGNALED(status)); /* it never failed to write */
        double stamp = stamp_of(at("checkpoint.h5"));
        assert_true(stamp >= last);
        last = stamp;
        if (access(at("checkpoint.1.h5"), F_OK) == 0) {
            double older = stamp_of(at("checkpoint.1.h5"));
            assert_true(older == last || older == last - 1.0);
        }
    }
    assert_true(last > 0.0);
    assert_true(entries(0) <= 4); /* three generations, one partial file */
    write_example(at("checkpoint.h5"), last + 1.0, 3);
    assert_true(stamp_of(at("checkpoint.1.h5")) == last);
}

#if OWN_MALLOC
static ad_status write_with(long allocations, ad_error *error)
{
    allocations_left = allocations;
    checkpoint *cp = example(2.0);
    ad_status status = AD_NO_MEMORY;
    if (cp) {
        status =
            checkpoint_write(cp, &(file_place){.path = at("checkpoint.h5"), .older = 2}, error);
    } else {
        strcpy(error->message, "memory");
    }
    allocations_left = -1;
    checkpoint_free(cp);
    return status;
}

/* All allocations from the n-th on fail, n = 0, 1, 2, ... */
static void writing_survives_no_memory(void **state)
{
    (void)state;
    ad_error error = {AD_OK, ""};
    write_example(at("checkpoint.h5"), 1.0, 1);
    write_example(at("checkpoint.h5"), 1.0, 2);
    assert_int_equal(write_with(1000000, &error), AD_OK);
    if (allocations_seen == 0) {
        skip(); /* linked so that the library's calls cannot be told apart */
    }
    write_example(at("checkpoint.h5"), 1.0, 1);
    long left = 0;
    while (write_with(left, &error) != AD_OK) {
        assert_non_null(strstr(error.message, "memory"));
        assert_true(stamp_of(at("checkpoint.h5")) == 1.0);
        assert_int_not_equal(access(at("checkpoint.h5.partial"), F_OK), 0);
        error.message[0] = 0;
        left++;
    }
    assert_true(left > 20);
    assert_true(stamp_of(at("checkpoint.h5")) == 2.0);
}

static void reading_survives_no_memory(void **state)
{
    (void)state;
    ad_error error = {AD_OK, ""};
    checkpoint *cp = NULL;
    write_example(at("checkpoint.h5"), 1.0, 1);
    ad_status status = AD_NO_MEMORY;
    long left = 0;
    allocations_seen = 0;
    for (; status != AD_OK; left++) {
        allocations_left = left;
        status = checkpoint_open(at("checkpoint.h5"), &cp, &error);
        allocations_left = -1;
        if (allocations_seen == 0) {
            checkpoint_free(cp);
            skip();
        }
        if (status != AD_OK) {
            assert_int_equal(status, AD_NO_MEMORY);
            assert_non_null(strstr(error.message, "memory"));
            assert_null(cp);
        }
    }
    assert_true(left > 20);
    assert_example(cp);
    checkpoint_free(cp);
}
#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(generations_are_kept),
        TEST(an_open_folder_is_kept_to),
        TEST(failed_writes_change_nothing),
        TEST(a_second_writer_is_refused),
        TEST(a_killed_writer_leaves_a_checkpoint),
#if OWN_MALLOC
        TEST(writing_survives_no_memory),
        TEST(reading_survives_no_memory),
#endif
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
