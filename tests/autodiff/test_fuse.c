/* Compiled groups of a program: the files that are kept of them, compilers that are missing, wrong
 * or hang. Skipped (77) where there is no compiler. */
#include "fewer.h"
#include "random_graphs.h"

#include <signal.h>
#include <stdio.h>
#include <sys/wait.h>
#include <unistd.h>

static garden graph;
static ad_value outputs[OUTPUTS];
static run_data data;
static compiled interpreted;
static char folder[64];

static int make_graph(void **state)
{
    (void)state;
    uint64_t random = 3;
    strcpy(folder, "/tmp/cpinn_test_XXXXXX");
    assert_non_null(mkdtemp(folder));
    garden_plant(&graph, 5, 12, true);
    int count = garden_outputs(&graph, outputs);
    data_fill(&data, graph.tape, 40, -1, 1, &random);
    interpreted = run_compiled(count, outputs, NULL, 1, &data);
    return 0;
}

/* %1$s in `format` is a path in the folder of this test. */
static void shell(const char *format, const char *name)
{
    char path[128], command[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    snprintf(command, sizeof command, format, path);
    if (system(command) != 0)
        fail_msg("fails: %s", command);
}

static int free_graph(void **state)
{
    (void)state;
    compiled_free(&interpreted);
    data_free(&data);
    ad_tape_free(graph.tape);
    shell("rm -r %1$s", "");
    return 0;
}

static ad_program *new_program(void)
{
    ad_program *program = NULL;
    ad_error error;
    if (ad_compile(interpreted.count, outputs, NULL, interpreted.pool, &program, &error) != AD_OK)
        fail_msg("%s", error.message);
    return program;
}

static ad_status begin(ad_program *program, const char *name, bool compile)
{
    char path[128];
    ad_error error;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return ad_fuse_begin(program, data.points, 1, path, compile, &error);
}

static ad_fuse_state finish(ad_program *program, bool wait, ad_status expected)
{
    ad_fuse_state is;
    ad_error error;
    assert_int_equal(ad_fuse_finish(program, wait, &is, &error), expected);
    return is;
}

/* It computes what it did, to the last bit. */
static void check_numbers(ad_program *program)
{
    compiled now = {.program = program, .pool = interpreted.pool, .count = interpreted.count};
    compiled_execute(&now, outputs, &data);
    for (int i = 0; i < now.count; i++) {
        assert_memory_equal(now.results[i], interpreted.results[i], now.sizes[i] * sizeof(double));
        free(now.results[i]);
    }
}

/* ---- files --------------------------------------------------------------------------------------
 */

/* What is kept is taken again, unless it is damaged, cut, not this user's alone or not a file. */
static void test_kept_files(void **state)
{
    (void)state;
    static const char *const changes[] = {
        "test ! -e %1$s",
        "test -d %1$s",
        "set -- %1$s/*; test $# = 1 && printf x | dd of=$1 bs=1 seek=4000 conv=notrunc 2>/dev/null",
        "set -- %1$s/*; head -c 5000 $1 >%1$s.x && chmod 600 %1$s.x && mv %1$s.x $1",
        "set -- %1$s/*; chmod g+w $1",
        "set -- %1$s/*; mv $1 %1$s.x && ln -s %1$s.x $1",
        "set -- %1$s/*; rm $1 && mkfifo -m 600 $1",
        "set -- %1$s/*; rm $1 && ln -s /dev/zero $1"};
    for (int round = 0; round < (int)(sizeof changes / sizeof *changes); round++) {
        shell(changes[round], "kept");
        ad_program *program = new_program();
        assert_int_equal(begin(program, "kept", false), AD_OK);
        assert_int_equal(finish(program, false, AD_OK), round == 1 ? AD_FUSED : AD_INTERPRETED);
        assert_int_equal(begin(program, "kept", true), AD_OK);
        assert_int_equal(finish(program, true, AD_OK), AD_FUSED);
        check_numbers(program);
        ad_program_free(program);
    }
}

/* Another program's file under this one's name is not taken. */
static void test_file_of_another(void **state)
{
    (void)state;
    ad_tape *tape = ad_tape_create();
    ad_value x = ad_input(tape, "x", 1), y = ad_tanh(x);
    compiled other = compile_values(1, &y, NULL, 1);
    ad_program *program = new_program();
    assert_int_equal(begin(program, "one", true), AD_OK);
    assert_int_equal(finish(program, true, AD_OK), AD_FUSED);
    ad_program_free(program);
    assert_int_equal(begin(other.program, "two", true), AD_OK);
    assert_int_equal(finish(other.program, true, AD_OK), AD_FUSED);
    shell("cp $(dirname %1$s)/two/* %1$s/*", "one");
    program = new_program();
    assert_int_equal(begin(program, "one", false), AD_OK);
    assert_int_equal(finish(program, false, AD_OK), AD_INTERPRETED);
    ad_program_free(program);
    compiled_free(&other);
    ad_tape_free(tape);
}

static void test_folders(void **state)
{
    (void)state;
    static const char *const folders[] = {"mkdir -m 770 %1$s", "mkdir -m 707 %1$s", ": >%1$s",
                                          "ln -s /no/such/folder %1$s", "ln -s /tmp %1$s"};
    ad_program *program;
    for (int i = 0; i < (int)(sizeof folders / sizeof *folders); i++) {
        shell(folders[i], "bad");
        program = new_program();
        assert_int_equal(begin(program, "bad", true), AD_IO);
        assert_int_equal(finish(program, true, AD_OK), AD_INTERPRETED);
        check_numbers(program);
        ad_program_free(program);
        shell("rm -r %1$s", "bad");
    }
}

/* Nobody else may be able to put a folder in the place of one above. */
static void test_folders_above(void **state)
{
    (void)state;
    static const struct {
        const char *change;
        bool taken;
    } changes[] = {
        {"chmod 755 %1$s", true},  {"chmod 777 %1$s", false}, {"chmod 775 %1$s", false},
        {"chmod 1777 %1$s", true}, {"chown 1 %1$s", false},
    };
    ad_program *program;
    shell("mkdir -m 755 %1$s %1$s/parent", "above");
    for (int i = 0; i < (int)(sizeof changes / sizeof *changes); i++) {
        if (strstr(changes[i].change, "chown") && geteuid() != 0)
            continue; /* only root can give folders away */
        shell(changes[i].change, "above");
        program = new_program();
        assert_int_equal(begin(program, "above/parent/kept", true),
                         changes[i].taken ? AD_OK : AD_IO);
        assert_int_equal(finish(program, true, AD_OK),
                         changes[i].taken ? AD_FUSED : AD_INTERPRETED);
        ad_program_free(program);
    }
    shell("rm -r %1$s", "above");
}

/* Puts `%1$s/now` in turns in the place of the one and of the other, until it is killed. */
static pid_t start_swapping(const char *one, const char *other)
{
    pid_t child = fork();
    if (child != 0)
        return child;
    for (int i = 0; chdir(folder) == 0 && getppid() != 1; i++) {
        unlink("swap/next");
        if (symlink(i % 2 ? other : one, "swap/next") == 0)
            rename("swap/next", "swap/now");
    }
    _exit(0);
}

/* While what is at the path changes all the time, code is taken that was checked, or none. */
static void test_swapped(void **state)
{
    (void)state;
    enum { ROUNDS = 600, MOST = 100 * ROUNDS }; /* what opens the file twice runs the wrong one */
    int seen[AD_FUSED + 1] = {0};
    bool both = false; /* the other process swaps when it has a processor */
    shell("mkdir -m 700 %1$s %1$s/bad && ln -s good %1$s/now", "swap");
    ad_program *program = new_program();
    assert_int_equal(begin(program, "swap/good", true), AD_OK);
    assert_int_equal(finish(program, true, AD_OK), AD_FUSED);
    ad_program_free(program);
    shell("echo '#include <stdio.h>\n__attribute__((constructor)) static void run(void)"
          "{ fclose(fopen(\"%1$s/ran\", \"w\")); }' >%1$s/bad.c &&"
          "cc -shared -fPIC -o %1$s/bad/$(ls %1$s/good) %1$s/bad.c && chmod 700 %1$s/bad/*",
          "swap");
    pid_t child = start_swapping("good", "bad");
    for (int i = 0; i < ROUNDS || (!both && i < MOST); i++) {
        program = new_program();
        assert_int_equal(begin(program, "swap/now", false), AD_OK);
        seen[finish(program, false, AD_OK)]++;
        ad_program_free(program);
        both = seen[AD_FUSED] > ROUNDS / 20 && seen[AD_INTERPRETED] > ROUNDS / 20;
    }
    kill(child, SIGKILL);
    waitpid(child, NULL, 0);
    shell("test ! -e %1$s/ran", "swap");
    assert_true(both);
}

/* Files of programs that are loaded at once are opened by the same number, one after the other:
 * each program has its own code. */
static void test_many_at_once(void **state)
{
    (void)state;
    ad_tape *tape = ad_tape_create();
    ad_value x = ad_input(tape, "x", 1), y = ad_tanh(x);
    compiled one = compile_values(1, &y, NULL, 1), two = compile_values(1, &y, NULL, 1);
    ad_program *program = new_program(), *next = new_program();
    assert_int_equal(begin(one.program, "many", true), AD_OK);
    assert_int_equal(finish(one.program, true, AD_OK), AD_FUSED);
    assert_int_equal(begin(two.program, "many", false), AD_OK);
    assert_int_equal(finish(two.program, false, AD_OK), AD_FUSED);
    assert_int_equal(begin(program, "many", true), AD_OK);
    assert_int_equal(finish(program, true, AD_OK), AD_FUSED);
    compiled_free(&one);
    assert_int_equal(begin(next, "many", false), AD_OK);
    assert_int_equal(finish(next, false, AD_OK), AD_FUSED);
    check_numbers(program);
    check_numbers(next);
    ad_program_free(program);
    ad_program_free(next);
    compiled_free(&two);
    ad_tape_free(tape);
}

/* ---- compilers ----------------------------------------------------------------------------------
 */

/* `script` is what cc does from now on; "": as it was, NULL: there is none but in the folder at
 * hand, which does not count. */
static void set_compiler(const char *script)
{
    static char before[4096];
    char path[4400], name[128];
    if (!*before)
        snprintf(before, sizeof before, "%s", getenv("PATH"));
    snprintf(name, sizeof name, "%s/bin/cc", folder);
    if (script && *script) {
        shell("mkdir -p %1$s", "bin");
        FILE *file = fopen(name, "w");
        assert_non_null(file);
        fprintf(file, "#!/bin/sh\n%s\n", script);
        assert_int_equal(fclose(file), 0);
        shell("chmod +x %1$s", "bin/cc");
    }
    snprintf(path, sizeof path, "%s/bin:%s", folder, before);
    setenv("PATH", !script ? ":.:bin:/no/such/folder" : *script ? path : before, 1);
}

/* Without a compiler, and with commands that are none, the program goes on as it was. */
static void test_bad_compilers(void **state)
{
    (void)state;
    static const char *const scripts[] = {
        NULL, "exit 1", "exit 0", "kill -9 $$",
        "while [ \"$1\" != -o ]; do shift; done; echo no code >$2"};
    for (int i = 0; i < (int)(sizeof scripts / sizeof *scripts); i++) {
        ad_program *program = new_program();
        set_compiler(scripts[i]);
        ad_status began = begin(program, "none", true);
        set_compiler("");
        assert_int_equal(began, scripts[i] ? AD_OK : AD_IO);
        assert_int_equal(finish(program, true, scripts[i] ? AD_IO : AD_OK), AD_INTERPRETED);
        check_numbers(program);
        ad_program_free(program);
    }
}

/* One that hangs ends with the program, with all that it has started, and leaves nothing; what a
 * killed process left is removed, once it is old. */
static void test_compiler_that_hangs(void **state)
{
    (void)state;
    ad_program *program = new_program();
    char script[256];
    snprintf(script, sizeof script,
             "trap '' TERM\nwhile :; do echo >%s/beat; sleep 0.1; done &\nwait\nwait", folder);
    shell("mkdir -m 700 %1$s && touch -d '3 hours ago' %1$s/0123.4-0x5.c", "hangs");
    set_compiler(script);
    assert_int_equal(begin(program, "hangs", true), AD_OK);
    set_compiler("");
    assert_int_equal(finish(program, false, AD_OK), AD_FUSING);
    check_numbers(program);
    shell("for i in $(seq 100); do test -e %1$s && exit; sleep 0.1; done; exit 1", "beat");
    shell("set -- %1$s/*; test $# = 1", "hangs");
    ad_program_free(program);
    shell("rm -f %1$s; sleep 0.5; test ! -e %1$s", "beat");
    shell("rmdir %1$s", "hangs");
}

int main(void)
{
    if (system("cc --version > /dev/null 2>&1") != 0)
        return 77;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_kept_files),          cmocka_unit_test(test_folders),
        cmocka_unit_test(test_folders_above),       cmocka_unit_test(test_bad_compilers),
        cmocka_unit_test(test_compiler_that_hangs),
    };
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_swapped),
                                       cmocka_unit_test(test_file_of_another),
                                       cmocka_unit_test(test_many_at_once)};
    return run_with_alike(tests, alike, make_graph, free_graph);
}
