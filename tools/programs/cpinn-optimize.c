/* cpinn-optimize: the best values of parameters of a rod at rest; see --help. */
#include "tools/config/config.h"
#include "tools/files/json.h"
#include "tools/files/table_file.h"
#include "tools/library/trained_family.h"
#include "tools/optimize/motion.h"
#include "tools/optimize/optimize.h"
#include "tools/prepare/prepare.h"
#include "tools/programs/cli.h"
#include "tools/programs/conclude.h"
#include "tools/programs/help.h"
#include "tools/programs/scene_line.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char program[] = "cpinn-optimize";

/* The optimum is looked at by a solver this much more exact, at so many points. */
static const double CLOSER = 1e-2, CLOSEST = 1e-13;
enum { CLOSE_POINTS = 241 };

typedef struct options {
    const char *config, *out, *json;
    cli_list overrides;
    bool quiet;
    int threads;
} options;

/* An optimisation with the members that it asks for. */
typedef struct asked_members {
    optimization *of;
    optimize_settings settings;
    cpinn_family *members;
    cpinn_answer *answers;
    size_t room;
} asked_members;

typedef struct optimizing {
    options asked;
    config *settings;
    const scene *family;
    environment *around;
    asked_members way, end; /* on the way; at the end, more exactly */
    optimize_report report, close;
    optimize_motion *motion;
    optimize_motion_report moved;
    verdict verdict;
} optimizing;

/* ---- members ------------------------------------------------------------------------------- */

static ad_status solve(void *of, size_t members, const double *parameters, double *values,
                       double *jacobian, bool *solved, ad_error *error)
{
    const cpinn_polish alone = {.alone = true}; /* another solver would have no derivatives */
    asked_members *by = of;
    if (members > by->room) {
        cpinn_answer *more = realloc(by->answers, members * sizeof *more);
        if (!more) {
            return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu members", members);
        }
        by->answers = more;
        by->room = members;
    }
    const ad_status status = cpinn_family_answer(by->members, &alone, members, parameters, values,
                                                 jacobian, by->answers, error);
    for (size_t i = 0; i < members; i++) {
        solved[i] = by->answers[i].trusted && by->answers[i].source == CPINN_FROM_MEMBERS;
    }
    return status;
}

static ad_status find_margin(void *of, size_t members, const double *parameters, double *margin,
                             double *by, ad_error *error)
{
    const asked_members *x = of;
    return cpinn_family_margin(x->members, members, parameters, margin, by, error);
}

static ad_status ask(optimizing *x, asked_members *to, ad_error *error)
{
    const options *o = &x->asked;
    char key[64] = "";
    size_t points = 0;
    const ad_status asked =
        optimize_create(&to->settings, x->family, x->around, &to->of, key, error);
    if (asked != AD_OK) {
        return asked == AD_BAD_INPUT ? config_refuse(x->settings, key, error->message, error)
                                     : asked;
    }
    const double *s = optimize_places(to->of, &points);
    const cpinn_family_settings settings = {.extrapolate = true, /* by rounding, beyond an end */
                                            .threads = o->threads,
                                            .points = points,
                                            .s = s};
    return cpinn_family_of_scene(x->family, to->settings.tolerance, &settings, &to->members, error);
}

static void put_back(asked_members *by)
{
    optimize_free(by->of);
    cpinn_family_free(by->members);
    free(by->answers);
}

/* ---- what is printed ----------------------------------------------------------------------- */

static void print_head(const optimizing *x)
{
    const optimize_settings *s = &x->way.settings;
    size_t variables;
    optimize_variables(x->way.of, &variables);
    printf("%s: %s %s\n", x->settings->settings.name, s->minimize ? "minimize" : "maximize",
           s->minimize ? s->minimize : s->maximize);
    printf("  %zu variables, %zu cases%s, %d constraints; the solver's tolerance is %.2g of the "
           "length\n\n",
           variables, optimize_cases(x->way.of), s->box_count > 0 ? " and a box" : "",
           s->constraint_count, s->tolerance);
    printf("start    objective  violation  steps\n");
}

static bool print_start(void *context, const optimize_report *now)
{
    const optimizing *x = context;
    const optimize_start *end = &now->start[now->starts - 1];
    if (!x->asked.quiet) {
        printf("%5d  %11.5g  %9.1e  %5d%s\n", now->starts, end->objective, end->violation,
               end->steps, end->converged ? "" : "  not converged");
        fflush(stdout);
    }
    return true;
}

static void print_parameters(const optimizing *x)
{
    const optimization *o = x->way.of;
    printf("\nvariable           value        range\n");
    for (int p = 0; p < x->family->parameter_count; p++) {
        const scene_parameter *of = &x->family->parameters[p];
        const optimize_role role = optimize_role_of(o, p);
        if (role == OPTIMIZE_SHARED || (role == OPTIMIZE_EACH && optimize_cases(o) == 1)) {
            const double value = optimize_parameter(o, 0, p),
                         z = scene_parameter_fraction(of, value);
            printf("%-16s  %-11.6g  %.4g .. %.4g%s\n", of->name, value, of->low, of->high,
                   z < 1e-6 || z > 1 - 1e-6 ? "  at the end of its range" : "");
        }
    }
}

static void print_cases(const optimizing *x)
{
    const optimization *o = x->way.of;
    const size_t count = optimize_cases(o);
    if (count == 1) {
        return;
    }
    printf("\n case    objective");
    for (int p = 0; p < x->family->parameter_count; p++) {
        if (optimize_role_of(o, p) == OPTIMIZE_EACH) {
            printf("  %11.11s", x->family->parameters[p].name);
        }
    }
    printf("\n");
    for (size_t i = 0; i < count; i++) {
        printf("%5zu  %11.5g", i + 1, optimize_case_objective(o, i));
        for (int p = 0; p < x->family->parameter_count; p++) {
            if (optimize_role_of(o, p) == OPTIMIZE_EACH) {
                printf("  %11.6g", optimize_parameter(o, i, p));
            }
        }
        printf("\n");
    }
}

static void print_bounds(const optimize_report *r)
{
    if (r->bounds > 0) {
        printf(
            "\nconstraint                      values                    active in  multiplier\n");
    }
    for (int i = 0; i < r->bounds; i++) {
        const optimize_bound *b = &r->bound[i];
        printf("%-30.30s  %-11.5g %-11.5g  %9d  %10.3g%s\n", b->text, b->least, b->most, b->active,
               b->multiplier, b->kept ? "" : "  not kept");
    }
}

/* How far the objective is off: what the descent leaves, what a more exact solver says, and for
 * what is then missed of constraints. */
static double objective_error(const optimizing *x)
{
    double error = fabs(x->close.objective - x->report.objective) + x->report.left;
    for (int i = 0; i < x->report.bounds; i++) {
        const optimize_bound *b = &x->close.bound[i];
        const double missed = fmax(0, fmax(b->low - b->least, b->most - b->high));
        error += x->report.bound[i].weight * missed;
    }
    return error;
}

static void print_end(const optimizing *x)
{
    const optimize_report *r = &x->report;
    print_parameters(x);
    print_cases(x);
    print_bounds(r);
    printf("\nobjective  %.9g, off by %.1e (solved again with %.2g of the length at %d points)\n",
           r->objective, objective_error(x), x->end.settings.tolerance, CLOSE_POINTS);
    if (r->rounds > 0) {
        printf("box        %zu members of it count, in %d rounds\n", r->cases, r->rounds);
    }
    printf("cost       %zu members solved, %.2f s\n", r->members, r->seconds);
}

/* ---- files --------------------------------------------------------------------------------- */

static ad_status write_table(const optimizing *x, ad_error *error)
{
    const optimization *o = x->way.of;
    const size_t rows = optimize_cases(o);
    const int parameters = x->family->parameter_count, columns = optimize_columns(o);
    double *numbers = malloc((size_t)(parameters + columns + 1) * rows * sizeof *numbers);
    table_build *table = malloc(sizeof *table);
    ad_status status = numbers && table ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    if (status == AD_OK) {
        double *to = numbers;
        table_begin(table, rows);
        for (int p = 0; p < parameters; p++, to += rows) {
            for (size_t i = 0; i < rows; i++) {
                to[i] = optimize_parameter(o, i, p);
            }
            table_add(table, x->family->parameters[p].name, NULL, to, NULL);
        }
        for (int c = 0; c < columns; c++, to += rows) {
            for (size_t i = 0; i < rows; i++) {
                to[i] = optimize_column(o, i, c);
            }
            if (!optimize_column_is_parameter(o, c)) {
                table_add(table, optimize_column_name(o, c), NULL, to, NULL);
            }
        }
        for (size_t i = 0; i < rows; i++) {
            to[i] = optimize_case_objective(o, i);
        }
        table_add(table, "objective", NULL, to, NULL);
        status = table_write(x->asked.out, &table->table, error);
    }
    free(numbers);
    free(table);
    return status;
}

static void json_cases(const optimizing *x, json *to)
{
    const optimization *o = x->way.of;
    json_open(to, "cases", '[');
    for (size_t i = 0; i < optimize_cases(o); i++) {
        json_open(to, NULL, '{');
        json_number(to, "objective", optimize_case_objective(o, i));
        json_open(to, "parameters", '{');
        for (int p = 0; p < x->family->parameter_count; p++) {
            json_number(to, x->family->parameters[p].name, optimize_parameter(o, i, p));
        }
        json_close(to, '}');
        json_close(to, '}');
    }
    json_close(to, ']');
}

static void json_replay(json *to, const char *name, const optimize_replay *replay, int bounds)
{
    json_open(to, name, '{');
    json_number(to, "off", replay->off);
    json_number(to, "speed", replay->speed);
    json_open(to, "beyond", '[');
    for (int i = 0; i < bounds; i++) {
        json_number(to, NULL, replay->beyond[i]);
    }
    json_close(to, ']');
    json_close(to, '}');
}

static void json_motion(const optimizing *x, json *to)
{
    const optimize_motion_report *r = &x->moved;
    json_number(to, "duration", r->duration);
    json_number(to, "effort", r->effort);
    json_number(to, "error", r->error);
    json_number(to, "violation", r->violation);
    json_number(to, "way", r->way);
    json_replay(to, "same_modes", &r->same, r->bounds);
    json_replay(to, "more_modes", &r->finer, r->bounds);
    json_integer(to, "steps", r->steps);
    json_number(to, "seconds", r->seconds);
}

static void tell(const void *of, json *to)
{
    const optimizing *x = of;
    const optimize_report *r = &x->report;
    if (x->moved.starts > 0) {
        json_motion(x, to);
    }
    if (r->starts > 0) {
        json_number(to, "objective", r->objective);
        json_number(to, "objective_error", objective_error(x));
        json_number(to, "violation", fmax(r->violation, x->close.violation));
        json_integer(to, "starts", r->starts);
        json_integer(to, "agreeing", r->agreeing);
        json_integer(to, "members", (int64_t)r->members);
        json_number(to, "seconds", r->seconds);
        json_cases(x, to);
        json_open(to, "constraints", '[');
        for (int i = 0; i < r->bounds; i++) {
            const optimize_bound *b = &r->bound[i];
            json_open(to, NULL, '{');
            json_text(to, "constraint", b->text);
            json_number(to, "least", b->least);
            json_number(to, "most", b->most);
            json_integer(to, "active", b->active);
            json_number(to, "multiplier", b->multiplier);
            json_close(to, '}');
        }
        json_close(to, ']');
    }
}

/* ---- running ------------------------------------------------------------------------------- */

/* Of what is bounded, over its spread, by which the exact solver may find more. */
static const double BEYOND = 1e-4;

static void judge(optimizing *x)
{
    const optimize_report *r = &x->report;
    if (!r->found) {
        const optimize_start *best = &r->start[r->best];
        if (best->violation > BEYOND) {
            verdict_add(&x->verdict, VERDICT_INFEASIBLE,
                        "no start meets all constraints; the nearest misses them by %.2g of what "
                        "they vary by",
                        best->violation);
        } else {
            verdict_add(&x->verdict, VERDICT_NO_OPTIMUM,
                        "no start ends where the objective cannot become better; try other ranges, "
                        "or more optimize.starts");
        }
        return;
    }
    if (x->close.violation > BEYOND) {
        verdict_add(&x->verdict, VERDICT_INFEASIBLE,
                    "between the points of the rod constraints are missed by %.2g of what they "
                    "vary by; more optimize.points show it",
                    x->close.violation);
    }
    if (!isfinite(x->close.objective)) {
        verdict_add(&x->verdict, VERDICT_NO_OPTIMUM,
                    "the exact solver does not find the equilibria of the optimum");
    }
    if (r->box_open) {
        verdict_add(&x->verdict, VERDICT_NO_OPTIMUM,
                    "after %d rounds random members of the box are still worse than those that "
                    "count",
                    r->rounds);
    }
    optimize_judge_stability(x->way.of, x->family, &x->verdict);
    verdict_add(&x->verdict, VERDICT_LOCAL_OPTIMUM,
                "%d of %d starts end at this optimum, none at a better one; whether there is one "
                "elsewhere is not known%s",
                r->agreeing, r->starts,
                r->start[r->best].converged
                    ? ""
                    : "; it is taken for one as they agree: the objective has a kink there, as a "
                      "distance has at 0 and its square has not");
}

static ad_status look_closer(optimizing *x, ad_error *error)
{
    x->end.settings = x->way.settings;
    x->end.settings.points = CLOSE_POINTS;
    x->end.settings.tolerance = fmax(CLOSEST, CLOSER * x->way.settings.tolerance);
    const optimize_solver solver = {solve, find_margin, &x->end};
    ad_status status = ask(x, &x->end, error);
    if (status == AD_OK) {
        status = optimize_take(x->end.of, x->way.of, error);
    }
    return status == AD_OK ? optimize_evaluate(x->end.of, &solver, &x->close, error) : status;
}

static ad_status open_environment(optimizing *x, ad_error *error)
{
    const optimize_settings *s = &x->settings->optimize;
    if (!s->environment.file) {
        return AD_OK;
    }
    if (isnan(s->radius)) {
        return config_refuse(x->settings, "optimize.radius",
                             "is not given; allowed: a number >= 0 (m)", error);
    }
    if (s->environment.side == ENVIRONMENT_ANY) {
        return config_refuse(x->settings, "optimize.environment.side",
                             "is any, of which no clearance is negative; allowed: inside, outside",
                             error);
    }
    return environment_open(&s->environment, scene_length(x->family), &x->around, error);
}

static ad_status read_scene(optimizing *x, ad_error *error)
{
    const options *o = &x->asked;
    ad_status status = o->out ? table_check_path(o->out, error) : AD_OK;
    status = status == AD_OK ? json_check_path(o->json, error) : status;
    if (status == AD_OK && !optimize_has_ipopt()) {
        status = ad_fail(error, AD_BAD_ARGUMENT,
                         "built without IPOPT; install coinor-libipopt-dev and build again");
    }
    if (status == AD_OK) {
        status = prepare_read(o->config, NULL, o->overrides.count, o->overrides.texts, &x->settings,
                              error);
    }
    if (status != AD_OK) {
        return status;
    }
    x->family = &x->settings->scene;
    x->way.settings = x->settings->optimize;
    const bool moves = optimize_motion_is_given(&x->way.settings);
    if (moves && optimize_is_given(&x->way.settings)) {
        return config_refuse(x->settings, "optimize.motion",
                             "stands beside optimize.minimize or maximize; give one of them",
                             error);
    }
    if (!moves && !optimize_is_given(&x->way.settings)) {
        return config_refuse(x->settings, "optimize",
                             "says neither what to minimize nor what to maximize; allowed: a "
                             "formula for one of them",
                             error);
    }
    if (!o->quiet) {
        scene_line_implausible(x->family);
    }
    return AD_OK;
}

/* ---- motions ------------------------------------------------------------------------------- */

/* Of the way of the tip, by which a rod with more modes, or one with shorter steps, may miss the
 * end. */
static const double MISSED = 0.05, COARSE = 0.01;

/* Of what a constraint's formula varies by, by which it may be missed between the points. */
static const double BETWEEN = 1e-3;

static double most_beyond(const optimize_motion_report *r, const optimize_replay *of)
{
    double most = 0;
    for (int i = 0; i < r->bounds; i++) {
        most = fmax(most, of->beyond[i] / r->spread[i]);
    }
    return most;
}

static void print_motion(const optimizing *x)
{
    const optimize_motion_report *r = &x->moved;
    const int *own = x->settings->optimize.motion.modes;
    printf("%s: from rest to rest\n", x->settings->settings.name);
    printf("  %d intervals, %d inputs, %s; modes %d, %d, %d, %d\n\n",
           optimize_motion_intervals(x->motion), optimize_motion_inputs(x->motion),
           optimize_motion_is_linear(x->motion) ? "linear in each" : "held in each", own[0], own[1],
           own[2], own[3]);
    printf("duration   %.9g s\neffort     %.9g s\n", r->duration, r->effort);
    if (r->found) {
        printf("error      %.1e s of the %s, by inputs that change twice as often\n", r->error,
               x->settings->optimize.motion.minimize == OPTIMIZE_TIME ? "duration" : "effort");
        printf("again      with steps a fourth as long the tip, which goes %.4g m, ends %.1e m off "
               "at %.1e m/s\n",
               r->way, r->same.off, r->same.speed);
        printf("           and with modes %d, %d, %d, %d it ends %.1e m off at %.1e m/s\n",
               r->modes[0], r->modes[1], r->modes[2], r->modes[3], r->finer.off, r->finer.speed);
        for (int i = 0; i < r->bounds; i++) {
            printf("%s%-34s missed by %.1e between the points, by %.1e with more modes\n",
                   i ? "           " : "kept       ", x->way.settings.constraints[i],
                   r->same.beyond[i], r->finer.beyond[i]);
        }
    }
    printf("cost       %d steps, %.2f s\n", r->steps, r->seconds);
}

static ad_status write_motion(const optimizing *x, ad_error *error)
{
    const int inputs = optimize_motion_inputs(x->motion);
    const size_t rows = (size_t)optimize_motion_intervals(x->motion) + 1;
    static const char *const places[3] = {"x", "y", "z"};
    double *numbers = malloc((size_t)(inputs + 4) * rows * sizeof *numbers);
    table_build *table = malloc(sizeof *table);
    ad_status status = numbers && table ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    for (size_t k = 0; k < rows && status == AD_OK; k++) {
        double values[SCENE_PARAMETERS_MAX], tip[3];
        status = optimize_motion_at(x->motion, (int)k, &numbers[k], values, tip, error);
        for (int i = 0; i < inputs; i++) {
            numbers[(size_t)(1 + i) * rows + k] = values[i];
        }
        for (int i = 0; i < 3; i++) {
            numbers[(size_t)(1 + inputs + i) * rows + k] = tip[i];
        }
    }
    if (status == AD_OK) {
        table_begin(table, rows);
        for (int i = 0; i < inputs + 4; i++) {
            const char *name = i == 0        ? "t"
                               : i <= inputs ? x->family->parameters[i - 1].name
                                             : places[i - 1 - inputs];
            table_add(table, name, NULL, numbers + (size_t)i * rows, NULL);
        }
        status = table_write(x->asked.out, &table->table, error);
    }
    free(numbers);
    free(table);
    return status;
}

static void judge_motion(optimizing *x)
{
    const optimize_motion_report *r = &x->moved;
    if (!r->found) {
        verdict_add(&x->verdict, r->violation > BEYOND ? VERDICT_INFEASIBLE : VERDICT_NO_OPTIMUM,
                    "no motion is found; the nearest misses its equations by %.2g of what states "
                    "vary by; try a longer time.duration, or more optimize.motion.intervals",
                    r->violation);
        return;
    }
    if (!isfinite(r->error)) {
        verdict_add(&x->verdict, VERDICT_ERROR_UNKNOWN,
                    "no motion is found whose inputs change twice as often, so what more "
                    "optimize.motion.intervals save is not known");
    }
    if (!(r->same.off <= COARSE * r->way)) {
        verdict_add(&x->verdict, VERDICT_INFEASIBLE,
                    "steps a fourth as long end %.2g of the way off; take more "
                    "optimize.motion.intervals",
                    r->same.off / r->way);
    }
    if (!(r->finer.off <= MISSED * r->way)) {
        verdict_add(&x->verdict, VERDICT_INFEASIBLE,
                    "a rod with more modes ends %.2g of the way off; more optimize.motion.modes "
                    "show them, and damping quiets them",
                    r->finer.off / r->way);
    }
    if (!(most_beyond(r, &r->same) <= BETWEEN)) {
        verdict_add(&x->verdict, VERDICT_INFEASIBLE,
                    "between its points constraints are missed by up to %.2g of what they vary "
                    "by; take more optimize.motion.intervals",
                    most_beyond(r, &r->same));
    }
    if (!(most_beyond(r, &r->finer) <= MISSED)) {
        verdict_add(&x->verdict, VERDICT_INFEASIBLE,
                    "with more modes constraints are missed by up to %.2g of what they vary by; "
                    "more optimize.motion.modes show it",
                    most_beyond(r, &r->finer));
    }
    verdict_add(&x->verdict, VERDICT_LOCAL_OPTIMUM,
                "no other motion was looked for; whether there is a better one elsewhere is not "
                "known");
}

static ad_status run_motion(optimizing *x, ad_error *error)
{
    const options *o = &x->asked;
    char key[64] = "";
    ad_status status =
        optimize_motion_create(&x->way.settings, x->family, x->around, &x->motion, key, error);
    if (status == AD_BAD_INPUT) {
        return config_refuse(x->settings, key, error->message, error);
    }
    status = status == AD_OK ? optimize_motion_run(x->motion, &x->moved, error) : status;
    if (status != AD_OK) {
        return status;
    }
    judge_motion(x);
    if (!o->quiet) {
        print_motion(x);
        verdict_print(stdout, "", &x->verdict);
    }
    return o->out && x->moved.found ? write_motion(x, error) : AD_OK;
}

static ad_status run(optimizing *x, ad_error *error)
{
    const options *o = &x->asked;
    ad_status status = read_scene(x, error);
    status = status == AD_OK ? open_environment(x, error) : status;
    if (status == AD_OK && optimize_motion_is_given(&x->way.settings)) {
        return run_motion(x, error);
    }
    status = status == AD_OK ? ask(x, &x->way, error) : status;
    if (status != AD_OK) {
        return status;
    }
    if (status == AD_OK && !o->quiet) {
        print_head(x);
    }
    const optimize_solver solver = {solve, find_margin, &x->way};
    if (status == AD_OK) {
        status = optimize_run(x->way.of, &solver, print_start, x, &x->report, error);
    }
    status = status == AD_OK ? look_closer(x, error) : status;
    if (status != AD_OK) {
        return status;
    }
    judge(x);
    if (!o->quiet) {
        print_end(x);
        verdict_print(stdout, "", &x->verdict);
    }
    return o->out ? write_table(x, error) : AD_OK;
}

int main(int argc, char **argv)
{
    optimizing x = {.report = {.best = -1}};
    options *o = &x.asked;
    const cli_option list[] = {
        CLI_OUT(&o->out),   CLI_SET(&o->overrides), CLI_THREADS(&o->threads),
        CLI_JSON(&o->json), CLI_QUIET(&o->quiet),
    };
    const cli_program about = {program, "CONFIG.yaml", help_optimize, verdict_help, NULL};
    int status = cli_parse(&about, list, sizeof list / sizeof *list, argc, argv, &o->config);
    if (status != CLI_RUN) {
        return status;
    }
    o->quiet = o->quiet || json_is_printed(o->json);
    ad_error error = {.message = ""};
    const ad_status ran = run(&x, &error);
    const conclusion end = {.program = program,
                            .quiet = o->quiet,
                            .json = o->json,
                            .name = x.settings ? x.settings->settings.name : NULL,
                            .tell = tell,
                            .of = &x,
                            .verdict = &x.verdict};
    status = conclude(&end, ran, &error);
    put_back(&x.way);
    put_back(&x.end);
    environment_free(x.around);
    optimize_motion_free(x.motion);
    config_free(x.settings);
    return status;
}
