#include "tools/programs/cli.h"

#include "physics/scene/verdict.h"
#include "tools/files/checkpoint.h"
#include "tools/programs/help.h"
#include "tools/programs/launcher.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <math.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

const char *cli_version(void)
{
    return CPINN_VERSION;
}

static void print_line(const char *program, const char *middle, const char *format,
                       va_list arguments)
{
    char text[4096];
    vsnprintf(text, sizeof text, format, arguments);
    ad_one_line(text);
    fflush(stdout);
    fprintf(stderr, "%s: %s%s\n", program, middle, text);
}

int cli_fail(const char *program, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    print_line(program, "", format, arguments);
    va_end(arguments);
    return CLI_BAD;
}

int cli_fail_error(const char *program, const ad_error *error)
{
    verdict blamed = {.count = 0};
    if (error->status == AD_BAD_INPUT) {
        fflush(stdout);
        fprintf(stderr, "%s\n", error->message);
    } else {
        cli_fail(program, "%s", error->message);
    }
    verdict_add_error(&blamed, error);
    return verdict_exit_status(&blamed);
}

void cli_warn(const char *program, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    print_line(program, "warning: ", format, arguments);
    va_end(arguments);
}

/* ---- the end ------------------------------------------------------------------------------- */

static const char *program_name; /* for check_output, which takes no arguments */

static void check_output(void)
{
    int reason = fflush(stdout) != 0 ? errno : 0; /* 0 also where an earlier write has failed */
    if (reason || ferror(stdout)) {
        fprintf(stderr, "%s: what it prints could not be written%s%s\n", program_name,
                reason ? ": " : "", reason ? strerror(reason) : "");
        _exit(1);
    }
}

static void check_output_at_exit(const char *name)
{
    bool first = !program_name;
    program_name = name;
    if (first && atexit(check_output) != 0) {
        cli_warn(name, "no memory to check what it prints");
    }
}

/* Descriptors 0 to 2 that a caller has closed would be those of the next files that are opened,
 * into which messages would go. Now reading or writing them fails as before. */
static void occupy_standard_files(void)
{
    for (int file = 0; file <= 2; file++) {
        if (fcntl(file, F_GETFD) < 0 &&
            open("/dev/null", file == 0 ? O_WRONLY : O_RDONLY) != file) {
            _exit(1);
        }
    }
}

/* ---- help ---------------------------------------------------------------------------------- */

/* The line "@set" stands for the lines behind it in help/shared.txt. */
static void print_shared(const char *name)
{
    bool on = false;
    for (int i = 0; help_shared[i]; i++) {
        const char *line = help_shared[i];
        if (*line == '@') {
            on = strcmp(line, name) == 0;
        } else if (on) {
            fputs(line, stdout);
        }
    }
}

static void print_help(const cli_program *program)
{
    printf("usage: %s %s%s[options]\n\n", program->name, program->operand ? program->operand : "",
           program->operands  ? "... "
           : program->operand ? " "
                              : "");
    for (const char *const *line = program->help; *line; line++) {
        if (**line == '@') {
            print_shared(*line);
        } else {
            fputs(*line, stdout);
        }
    }
    if (program->more) {
        putchar('\n');
        program->more(stdout);
    }
}

/* ---- parsing ------------------------------------------------------------------------------- */

static bool parse_number(const char *text, double *value)
{
    char *end;
    errno = 0;
    *value = strtod(text, &end);
    return end != text && *end == '\0' && errno == 0 && isfinite(*value);
}

/* One of "program|support". */
static bool is_choice(const char *choices, const char *text)
{
    const size_t length = strlen(text);
    for (const char *at = choices; *at; at += strspn(at, "|")) {
        const size_t word = strcspn(at, "|");
        if (word == length && strncmp(at, text, word) == 0) {
            return true;
        }
        at += word;
    }
    return false;
}

/* The folder becomes an override of where data are. */
static int store_folder(const char *program, const cli_option *option, const char *text)
{
    static char override[4 * PATH_MAX + 20]; /* as long as the program runs */
    char here[PATH_MAX] = "", folder[2 * PATH_MAX];
    struct stat status;
    cli_list *list = option->target;
    const bool is_placed = *text == '/' || getcwd(here, sizeof here);
    snprintf(folder, sizeof folder, "%s%s%s", here, *here ? "/" : "", text);
    if (!is_placed || stat(folder, &status) != 0 || !S_ISDIR(status.st_mode)) {
        return cli_fail(program, "%s %s: allowed: a folder that is there", option->name, text);
    }
    char *to = stpcpy(override, "data_folder='");
    for (const char *from = folder; *from; from++) {
        *to++ = *from;
        if (*from == '\'') {
            *to++ = *from; /* as YAML has it */
        }
    }
    stpcpy(to, "'");
    if (list->count == CLI_LIST_MAX) {
        return cli_fail(program, "%s: --set is given more than %d times", option->name,
                        CLI_LIST_MAX - 1);
    }
    list->texts[list->count++] = override;
    return CLI_RUN;
}

static int store(const char *program, const cli_option *option, const char *text)
{
    double value;
    bool whole = option->kind == CLI_INTEGER;
    cli_list *list = option->target;
    switch (option->kind) {
    case CLI_FLAG:
        *(bool *)option->target = true;
        return CLI_RUN;
    case CLI_CHOICE:
        if (text && !is_choice(option->value, text)) {
            return cli_fail(program, "%s=%s: allowed: %s, or %s=%s", option->name, text,
                            option->name, option->name, option->value);
        }
        *(const char **)option->target = text ? text : "";
        return CLI_RUN;
    case CLI_TEXT:
        *(const char **)option->target = text;
        return CLI_RUN;
    case CLI_FOLDER:
        return store_folder(program, option, text);
    case CLI_LIST:
        if (list->count == CLI_LIST_MAX) {
            return cli_fail(program, "%s: given more than %d times", option->name, CLI_LIST_MAX);
        }
        list->texts[list->count++] = text;
        return CLI_RUN;
    default:
        break;
    }
    if (!parse_number(text, &value) || value < option->low || value > option->high ||
        (whole && value != floor(value))) {
        return cli_fail(program, "%s %s: allowed: %s, %g to %g", option->name, text,
                        whole ? "an integer" : "a number", option->low, option->high);
    }
    if (whole) {
        *(int *)option->target = (int)value;
    } else {
        *(double *)option->target = value;
    }
    return CLI_RUN;
}

static const cli_option *find(const cli_option *options, int count, const char *name, size_t length)
{
    for (int i = 0; i < count; i++) {
        if (strlen(options[i].name) == length && strncmp(options[i].name, name, length) == 0) {
            return &options[i];
        }
    }
    return NULL;
}

/* Stores the option at argv[*at] with its value, which may be the next argument. */
static int take_option(const char *program, const cli_option *options, int count, int argc,
                       char **argv, int *at)
{
    const char *name = argv[*at];
    const char *equals = strchr(name, '=');
    size_t length = equals ? (size_t)(equals - name) : strlen(name);
    const cli_option *option = find(options, count, name, length);
    if (!option) {
        return cli_fail(program, "unknown option %s; --help lists the options", name);
    }
    if (option->kind == CLI_CHOICE) {
        return store(program, option, equals ? equals + 1 : NULL);
    }
    if (!option->value) {
        return equals ? cli_fail(program, "%s takes no value", option->name)
                      : store(program, option, NULL);
    }
    if (!equals && *at + 1 >= argc) {
        return cli_fail(program, "%s: a value is missing: %s %s", name, name, option->value);
    }
    return store(program, option, equals ? equals + 1 : argv[++*at]);
}

static bool asked_for(int argc, char **argv, const char *name)
{
    for (int i = 1; i < argc && strcmp(argv[i], "--") != 0; i++) {
        if (strcmp(argv[i], name) == 0) {
            return true;
        }
    }
    return false;
}

int cli_parse(const cli_program *program, const cli_option *options, int count, int argc,
              char **argv, const char **operand)
{
    bool only_operands = false;
    occupy_standard_files();
    signal(SIGXFSZ, SIG_IGN); /* a file above the limit is an error, in one line */
    checkpoint_at_exit();
    check_output_at_exit(program->name);
    *operand = NULL;
    if (asked_for(argc, argv, "--help") || asked_for(argc, argv, "-h")) {
        print_help(program);
        return 0;
    }
    if (asked_for(argc, argv, "--version")) {
        printf("%s %s\n", program->name, cli_version());
        return 0;
    }
    int rank;
    if (launcher_processes(&rank) > 1 && !launcher_is_shared()) {
        return launcher_refuse(program->name, "does not share its work among processes");
    }
    for (int i = 1; i < argc; i++) {
        int status = CLI_RUN;
        if (!only_operands && strcmp(argv[i], "--") == 0) {
            only_operands = true;
        } else if (!only_operands && argv[i][0] == '-' && argv[i][1]) {
            status = take_option(program->name, options, count, argc, argv, &i);
        } else if (!program->operand) {
            status = cli_fail(program->name, "%s: only options are expected", argv[i]);
        } else if (program->operands && program->operands->count == CLI_LIST_MAX) {
            status = cli_fail(program->name, "%s: more than %d are given", program->operand,
                              CLI_LIST_MAX);
        } else if (program->operands) {
            *operand = program->operands->texts[program->operands->count++] = argv[i];
        } else if (*operand) {
            status = cli_fail(program->name, "%s: one %s is expected, %s is the second", argv[i],
                              program->operand, argv[i]);
        } else {
            *operand = argv[i];
        }
        if (status != CLI_RUN) {
            return status;
        }
    }
    if (program->operand && !*operand) {
        return cli_fail(program->name, "%s is missing; --help explains", program->operand);
    }
    return CLI_RUN;
}

void cli_print_error(const char *name, double value, const char *unit)
{
    if (!isnan(value)) {
        printf("  %-24s %.3e%s\n", name, value, unit);
    }
}

bool cli_grid(const char *text, bool dynamic, long *ns, long *nt)
{
    char *end;
    *nt = dynamic ? 0 : 1;
    *ns = strtol(text, &end, 10);
    if (*end == 'x' && end[1] >= '0' && end[1] <= '9') {
        *nt = strtol(end + 1, &end, 10);
    }
    return *text >= '0' && *text <= '9' && *end == '\0' && *ns > 0 && *nt > 0 &&
           *ns <= CLI_GRID_MAX && *nt <= CLI_GRID_MAX / *ns && (dynamic || *nt == 1);
}
