/* Equilibria of a robot's members: time of a shape, and errors against the other solver.
 *
 *   members [COUNT [COMPARED [THREADS]]]
 *
 * The robot is that of Bensch et al. (2024): L 0.2 m, radius 0.5 mm, E 60 GPa, G E/2.6, three
 * straight tendons at 8 mm with 0 to 3.5 N each (family A). Family B adds its weight in any
 * direction, a tip force of up to 0.2 N along each axis, and a stiffness of 0.5 to 2 times that;
 * B-mild has a tip force of up to 0.05 N; "tendons" is B without loads, where no point of the rod
 * asks another. Members are random; shapes have 21 points and a tolerance
 * of 1e-3 mm. Times are those of the processor, medians of some rounds. `elsewhere` counts members
 * that are another equilibrium than that of the other solver.
 *
 * Then shapes of B from given curvatures: those of the members, bent by smooth random waves of 1e-4
 * to 0.1 over the length, one size for each member, as networks err. "value" is the shape alone,
 * "step" a step of Newton's method alone, "by all" their derivatives by all parameters, and numbers
 * are steps taken with all that is known after them, against the shapes of a finer tolerance.
 * `wrong` counts members that are trusted and further off than one and a half times what is said to
 * be left and 1e-5 mm; `said/off` the quotient of what is said to be left and what is, of those
 * trusted and less than 5 and more than 1e-3 mm off. */
#include "nn/rng.h"
#include "physics/chain/solve_members.h"
#include "physics/numerics/clock.h"
#include "physics/numerics/sort.h"
#include "physics/solve/solve.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { PARAMETERS = 9, POINTS = 21, ROUNDS = 5 };

static const scene_parameter FAMILY[PARAMETERS] = {
    {"tension_1", 0, 3.5, SCENE_LINEAR}, {"tension_2", 0, 3.5, SCENE_LINEAR},
    {"tension_3", 0, 3.5, SCENE_LINEAR}, {"turned", 0, 6.283185307179586, SCENE_LINEAR},
    {"raised", 0, 3.14, SCENE_LINEAR},   {"tip_x", -0.2, 0.2, SCENE_LINEAR},
    {"tip_y", -0.2, 0.2, SCENE_LINEAR},  {"tip_z", -0.2, 0.2, SCENE_LINEAR},
    {"stiffness", 0.5, 2, SCENE_LOG}};
static const double LENGTH = 0.2;

static quantities *fill(scene *robot, bool loaded)
{
    static const char *const gravity[3] = {"9.81*sin(raised)*cos(turned)",
                                           "9.81*sin(raised)*sin(turned)", "9.81*cos(raised)"};
    quantities *names = quantities_create();
    ad_error error;
    scene_defaults(robot);
    for (int i = 0; i < PARAMETERS; i++) {
        quantities_coordinate(names, FAMILY[i].name, &error);
        robot->parameters[robot->parameter_count++] = FAMILY[i];
    }
    robot->names = names;
    robot->rod.section = SCENE_CIRCLE;
    robot->rod.length = quantity_number(LENGTH);
    robot->rod.radius = quantity_number(0.5e-3);
    robot->rod.youngs_modulus = quantity_formula(names, "60e9*stiffness");
    robot->rod.poissons_ratio = quantity_number(0.3);
    robot->rod.density = quantity_number(6450);
    robot->end.type = loaded ? SCENE_LOADED : SCENE_FREE;
    for (int i = 0; i < 3; i++) {
        const double angle = 2 * 3.14159265358979323846 * i / 3;
        if (loaded) {
            robot->loads.gravity[i] = quantity_formula(names, gravity[i]);
            robot->loads.tip.force[i] = quantity_formula(names, FAMILY[5 + i].name);
        }
        robot->tendons[i] = (scene_tendon){
            .offset = {quantity_number(8e-3 * cos(angle)), quantity_number(8e-3 * sin(angle))},
            .tension = quantity_formula(names, FAMILY[i].name)};
    }
    robot->tendon_count = 3;
    return names;
}

/* Of this process on all its processors: others may be at work there. */
static double cpu_seconds(void)
{
    return clock_seconds(CLOCK_PROCESS_CPUTIME_ID);
}

static double random_number(nn_rng *random, double low, double high)
{
    return low + (high - low) * nn_rng_uniform(random);
}

static void draw(nn_rng *random, double tip, bool loaded, double *member)
{
    for (int i = 0; i < 3; i++) {
        member[i] = random_number(random, 0, 3.5);
        member[5 + i] = random_number(random, -tip, tip);
    }
    member[3] = random_number(random, 0, 6.283185307179586);
    member[4] = acos(random_number(random, -1, 1));
    member[8] = loaded ? exp2(random_number(random, -1, 1)) : 1;
}

/* Largest distance of a shape from that of the other solver, m; NaN: it has none. */
static double compare(const scene *open, const double *member, const double *s,
                      const double *values, bool *warned)
{
    scene one;
    solution *solution = NULL;
    solve_report report;
    ad_error error;
    double at[3 * POINTS], largest = 0;
    scene_member(open, member, &one);
    solve_settings settings = solve_settings_default(&one);
    settings.tolerance = 1e-8;
    ad_status status = solution_create(&one, &settings, 0, NULL, &solution, &report, &error);
    if (status != AD_OK || report.load_fraction < 1) {
        solution_free(solution);
        return NAN;
    }
    verdict said = {0};
    solution_verdict(solution, &one, &settings, &report, &said);
    *warned = verdict_outcome_of(&said) != VERDICT_SOLVED;
    solution_evaluate(solution, 3, POINTS, s, NULL, at, &error);
    for (int i = 0; i < POINTS; i++) {
        double square = 0;
        for (int c = 0; c < 3; c++) {
            const double off = at[c * POINTS + i] - values[i * SOLVE_MEMBERS_COLUMNS + c];
            square += off * off;
        }
        largest = fmax(largest, sqrt(square));
    }
    solution_free(solution);
    return largest;
}

static int run(const char *name, const scene *robot, double tip, bool loaded, size_t count,
               size_t compared, int threads)
{
    double s[POINTS], seconds[ROUNDS], worst = 0;
    double *members = malloc(count * PARAMETERS * sizeof *members);
    double *values = malloc(count * POINTS * SOLVE_MEMBERS_COLUMNS * sizeof *values);
    solve_member *results = malloc(count * sizeof *results);
    double *errors = malloc((compared + 1) * sizeof *errors);
    nn_rng random = nn_rng_seed(1);
    solve_members *solver = NULL;
    ad_error error = {AD_OK, ""};
    size_t unsolved = 0, other = 0, known = 0, above = 0;
    long steps = 0;
    for (int i = 0; i < POINTS; i++) {
        s[i] = LENGTH * i / (POINTS - 1);
    }
    for (size_t i = 0; i < count; i++) {
        draw(&random, tip, loaded, members + i * PARAMETERS);
    }
    const solve_members_settings settings = {
        .tolerance = 5e-6, .threads = threads, .points = POINTS, .s = s, .own_curvature = true};
    ad_status status = solve_members_create(robot, &settings, &solver, &error);
    for (int i = 0; i < ROUNDS && status == AD_OK; i++) {
        const double start = cpu_seconds();
        status = solve_members_solve(solver, count, members, values, results, &error);
        seconds[i] = cpu_seconds() - start;
    }
    if (status != AD_OK) {
        fprintf(stderr, "members: %s\n", error.message);
        return 2;
    }
    sort_ascending(ROUNDS, seconds);
    for (size_t i = 0; i < count; i++) {
        unsolved += !results[i].solved;
        steps += results[i].steps;
    }
    for (size_t i = 0; i < compared && i < count; i++) {
        bool warned = false;
        const double off = 1e3 * compare(robot, members + i * PARAMETERS, s,
                                         values + i * POINTS * SOLVE_MEMBERS_COLUMNS, &warned);
        if (results[i].solved && !isnan(off)) {
            errors[known++] = off;
            other += off > 1;
            above += off > fmax(1e3 * LENGTH * results[i].estimate, 1e-5);
            worst = fmax(worst, off > 1 ? 0 : off);
            if (off > 1e-3) {
                printf("  member %zu: %.3g mm off, estimate %.2g, %d steps%s\n", i, off,
                       results[i].estimate * LENGTH * 1e3, results[i].steps,
                       warned ? ", the other warns" : "");
            }
        }
    }
    sort_ascending(known, errors);
    printf("%-8s %8.1f %7.1f %12zu %10zu", name, 1e6 * seconds[ROUNDS / 2] / (double)count,
           (double)steps / (double)count, unsolved, known);
    if (known > 0) {
        printf(" %9.1e %9.1e %10zu %15zu", errors[known / 2], worst, other, above);
    }
    putchar('\n');
    free(members);
    free(values);
    free(results);
    free(errors);
    solve_members_free(solver);
    return 0;
}

/* ---- from a given curvature ---------------------------------------------------------------- */

/* Curvatures [count][nodes][3] off by waves. */
static void perturb(const solve_members *members, size_t count, double *curvature)
{
    enum { WAVES = 4 };
    const size_t nodes = solve_members_nodes(members);
    nn_rng random = nn_rng_seed(2);
    double *s = malloc(nodes * sizeof *s);
    solve_members_places(members, s);
    for (size_t i = 0; i < count; i++) {
        const double size = pow(10, random_number(&random, -4, -1)) / LENGTH;
        for (int c = 0; c < 3; c++) {
            for (int w = 0; w < WAVES; w++) {
                const double high = random_number(&random, -1, 1) * size * (c < 2 ? 1 : 0.1);
                for (size_t k = 0; k < nodes; k++) {
                    curvature[(i * nodes + k) * 3 + (size_t)c] +=
                        high / (1 + w) * cos(3.14159265358979323846 * w * s[k] / LENGTH);
                }
            }
        }
    }
    free(s);
}

static double distance(const double *a, const double *b)
{
    double largest = 0;
    for (int i = 0; i < POINTS * SOLVE_MEMBERS_COLUMNS; i += SOLVE_MEMBERS_COLUMNS) {
        largest = fmax(largest, sqrt(pow(a[i] - b[i], 2) + pow(a[i + 1] - b[i + 1], 2) +
                                     pow(a[i + 2] - b[i + 2], 2)));
    }
    return largest;
}

typedef struct answering {
    solve_members *members;
    size_t count;
    const double *parameters, *curvature, *truth;
    double *values, *refined;
    const solve_member *solved; /* truth is known of those */
    solve_answer *answers;
} answering;

/* Microseconds a shape. */
static double time_of(const answering *of, int steps, double *values, double *refined,
                      solve_answer *answers)
{
    double seconds[ROUNDS];
    ad_error error;
    for (int i = 0; i < ROUNDS; i++) {
        const double start = cpu_seconds();
        if (solve_members_refine(of->members, of->count, of->parameters, of->curvature, steps,
                                 values, refined, answers, &error) != AD_OK) {
            return NAN;
        }
        seconds[i] = cpu_seconds() - start;
    }
    sort_ascending(ROUNDS, seconds);
    return 1e6 * seconds[ROUNDS / 2] / (double)of->count;
}

/* Of all derivatives by the parameters. */
static double time_of_derivatives(const answering *of, double *jacobian)
{
    double seconds[ROUNDS];
    ad_error error;
    for (int i = 0; i < ROUNDS; i++) {
        const double start = cpu_seconds();
        if (solve_members_jacobian(of->members, of->count, of->parameters, of->curvature, 0,
                                   jacobian, &error) != AD_OK) {
            return NAN;
        }
        seconds[i] = cpu_seconds() - start;
    }
    sort_ascending(ROUNDS, seconds);
    return 1e6 * seconds[ROUNDS / 2] / (double)of->count;
}

static void print_answers(const answering *of, int steps)
{
    double *off = malloc(of->count * sizeof *off), *ratio = malloc(of->count * sizeof *ratio);
    size_t trusted = 0, wrong = 0, known = 0, said = 0;
    const double time = time_of(of, steps, of->values, NULL, of->answers);
    for (size_t i = 0; i < of->count; i++) {
        const size_t at = i * POINTS * SOLVE_MEMBERS_COLUMNS;
        if (!of->solved[i].solved) {
            continue;
        }
        const double is = distance(of->values + at, of->truth + at), left = of->answers[i].left;
        known++;
        if (of->answers[i].trusted) {
            off[trusted++] = is;
            wrong += is > 1.5 * left + 1e-8;
        }
        if (of->answers[i].trusted && is < 5e-3 && is > 1e-6) {
            ratio[said++] = left / is;
        }
    }
    sort_ascending(trusted, off);
    sort_ascending(said, ratio);
    printf("%-8d %8.2f %12zu %7zu", steps, time, known - trusted, wrong);
    if (trusted > 0) {
        printf(" %9.1e %9.1e %9.1e", 1e3 * off[trusted / 2], 1e3 * off[trusted * 95 / 100],
               1e3 * off[trusted - 1]);
    }
    if (said > 0) {
        printf(" %9.3f %9.3f %9zu", ratio[said / 100], ratio[said * 99 / 100], said);
    }
    putchar('\n');
    free(off);
    free(ratio);
}

static int run_answers(const scene *robot, size_t count, int threads)
{
    double s[POINTS];
    const size_t width = POINTS * SOLVE_MEMBERS_COLUMNS;
    ad_error error = {AD_OK, ""};
    solve_members *exact = NULL;
    nn_rng random = nn_rng_seed(3);
    double *parameters = malloc(count * PARAMETERS * sizeof *parameters);
    double *truth = malloc(count * width * sizeof *truth);
    solve_member *solved = malloc(count * sizeof *solved);
    answering of = {.count = count, .parameters = parameters, .truth = truth, .solved = solved};
    of.values = malloc(count * width * sizeof *of.values);
    of.answers = malloc(count * sizeof *of.answers);
    for (int i = 0; i < POINTS; i++) {
        s[i] = LENGTH * i / (POINTS - 1);
    }
    for (size_t i = 0; i < count; i++) {
        draw(&random, 0.2, true, parameters + i * PARAMETERS);
    }
    solve_members_settings settings = {
        .tolerance = 5e-6, .threads = threads, .points = POINTS, .s = s};
    ad_status status = solve_members_create(robot, &settings, &of.members, &error);
    settings.tolerance = 5e-8;
    status = status == AD_OK ? solve_members_create(robot, &settings, &exact, &error) : status;
    if (status == AD_OK) {
        double *curvature = malloc(count * solve_members_nodes(of.members) * 3 * sizeof *curvature);
        status =
            solve_members_curvature(of.members, count, parameters, NULL, curvature, solved, &error);
        status = status == AD_OK
                     ? solve_members_solve(exact, count, parameters, truth, solved, &error)
                     : status;
        perturb(of.members, count, curvature);
        of.curvature = curvature;
        of.refined = malloc(count * solve_members_nodes(of.members) * 3 * sizeof *of.refined);
        printf("\nsteps    us/shape  not trusted   wrong    median      95 %%     worst  said/off "
               "1 %%      99 %%   of so many\n");
        printf("%-8s %8.2f\n", "value", time_of(&of, 0, of.values, NULL, NULL));
        printf("%-8s %8.2f\n", "step", time_of(&of, -1, NULL, of.refined, NULL));
        for (int steps = 0; steps <= 2; steps++) {
            print_answers(&of, steps);
        }
        double *jacobian = malloc(count * width * PARAMETERS * sizeof *jacobian);
        printf("%-8s %8.2f\n", "by all", time_of_derivatives(&of, jacobian));
        free(jacobian);
        free(of.refined);
        free(curvature);
    } else {
        fprintf(stderr, "members: %s\n", error.message);
    }
    solve_members_free(of.members);
    solve_members_free(exact);
    free(parameters);
    free(truth);
    free(solved);
    free(of.values);
    free(of.answers);
    return status == AD_OK ? 0 : 2;
}

int main(int count, char **arguments)
{
    const size_t members = count > 1 ? strtoul(arguments[1], NULL, 10) : 4000;
    const size_t compared = count > 2 ? strtoul(arguments[2], NULL, 10) : 100;
    const int threads = count > 3 ? atoi(arguments[3]) : 1;
    scene bare, robot;
    quantities *few = fill(&bare, false), *names = fill(&robot, true);
    printf("family   us/shape   steps   not solved   compared    median  worst, mm  elsewhere  "
           "above estimate\n");
    int status = run("tendons", &bare, 0, true, members, compared, threads);
    status = status == 0 ? run("A", &robot, 0, false, members, compared, threads) : status;
    status = status == 0 ? run("B-mild", &robot, 0.05, true, members, compared, threads) : status;
    status = status == 0 ? run("B", &robot, 0.2, true, members, compared, threads) : status;
    status = status == 0 ? run_answers(&robot, members, threads) : status;
    quantities_free(few);
    quantities_free(names);
    return status;
}
