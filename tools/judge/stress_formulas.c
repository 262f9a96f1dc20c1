/* References in closed form, as files beside a scene. */
#include "tools/judge/stress.h"

#include "physics/learn/analytic.h"

#include <math.h>
#include <string.h>

static void write_elastica(FILE *file)
{
    const analytic_clamp clamp = {{0, 0, 0}, {sqrt(0.5), 0, sqrt(0.5), 0}};
    const double force[3] = {0, 0, -4};
    analytic_elastica elastica;
    ad_error error;
    if (analytic_elastica_create(&clamp, 1, 1, force, &elastica, &error) != AD_OK) {
        return; /* an empty file is refused */
    }
    fprintf(file, "s,x,y,z\n");
    for (int i = 0; i <= 20; i++) {
        analytic_state state;
        analytic_elastica_at(&elastica, i / 20.0, &state);
        fprintf(file, "%.17g,%.17g,%.17g,%.17g\n", i / 20.0, state.position[0], state.position[1],
                state.position[2]);
    }
}

/* ---- small vibrations of a cantilever -------------------------------------------------------- */

enum { MODES = 40, INSTANTS = 20 };

static double mode_frequency(int mode)
{
    static const double first[] = {1.8751040687119611, 4.6940911329741746, 7.8547574382376126,
                                   10.995540734875467};
    double beta = mode < 4 ? first[mode] : (mode + 0.5) * acos(-1); /* cos beta cosh beta = -1 */
    return beta * beta;
}

/* The tip's deflection, t after a unit force has come to it for good. Modes of norm 1 have the
 * value 2 there. */
static double step_response(double t)
{
    double sum = 0;
    for (int mode = MODES - 1; mode >= 0 && t > 0; mode--) {
        double frequency = mode_frequency(mode);
        sum += 4 / (frequency * frequency) * (1 - cos(frequency * t));
    }
    return sum;
}

static double step_at_once(double t)
{
    return 1e-3 * step_response(t);
}

static double step_later(double t)
{
    return 1e-3 * step_response(t - 0.1);
}

static double push(double t)
{
    return 1e-2 * (step_response(t - 0.1) - step_response(t - 0.2));
}

static double blow(double t)
{
    return 0.1 * (step_response(t - 0.1) - step_response(t - 0.11));
}

/* w + 10 w_t = force / 3 */
static double creep(double t)
{
    return 1e-2 / 3 * (t / 10 - (1 - exp(-t / 10)));
}

static void write_deflection(FILE *file, double duration, double (*deflection)(double t))
{
    fprintf(file, "s,t,x,y,z\n");
    for (int i = 0; i <= INSTANTS; i++) {
        double t = duration * i / INSTANTS;
        fprintf(file, "1,%.17g,%.17g,0,1\n", t, deflection(t));
    }
}

static void write_step_at_once(FILE *file)
{
    write_deflection(file, 1, step_at_once);
}

static void write_step(FILE *file)
{
    write_deflection(file, 1, step_later);
}

static void write_push(FILE *file)
{
    write_deflection(file, 1, push);
}

static void write_blow(FILE *file)
{
    write_deflection(file, 1, blow);
}

static void write_creep(FILE *file)
{
    write_deflection(file, 10, creep);
}

/* ---- a motion in other units ----------------------------------------------------------------- */

/* The tip of configs/reference/slender_100.csv, which says how it was computed. */
static void write_scaled(FILE *file, double length, double time)
{
    static const double rows[][3] = {{0, 1, 0},
                                     {0.2, 0.9987606079, -0.0322121322},
                                     {0.4, 0.9475101849, -0.2752857074},
                                     {0.6, 0.6306007611, -0.7096354092},
                                     {0.8, 0.1877552241, -0.8617899806},
                                     {1, 0.3097811115, -0.8494051796}};
    fprintf(file, "s,t,x,y,z\n");
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        fprintf(file, "%.17g,%.17g,%.17g,0,%.17g\n", length, time * rows[i][0], length * rows[i][1],
                length * rows[i][2]);
    }
}

static void write_small(FILE *file)
{
    write_scaled(file, 1e-3, 1e-3);
}

static void write_large(FILE *file)
{
    write_scaled(file, 1e3, 3600);
}

stress_write *stress_formula(const char *name)
{
    static const struct {
        const char *name;
        stress_write *write;
    } all[] = {{"elastica", write_elastica}, {"step_at_once", write_step_at_once},
               {"step", write_step},         {"push", write_push},
               {"blow", write_blow},         {"creep", write_creep},
               {"small", write_small},       {"large", write_large}};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        if (strcmp(all[i].name, name) == 0) {
            return all[i].write;
        }
    }
    return NULL;
}
