/* Rods with tendons and chambers by networks of the default recipe. */
#include "trainer_testing.h"

#include "physics/solve/solve.h"
#include "quantity_testing.h"

/* Rows s, t, x, y, z as reference files have them. */
static void write_places(const char *path, int count, const double (*rows)[5])
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs("s,t,x,y,z\n", file);
    for (int i = 0; i < count; i++) {
        const double *p = rows[i];
        fprintf(file, "%.17g,%.17g,%.17g,%.17g,%.17g\n", p[0], p[1], p[2], p[3], p[4]);
    }
    fclose(file);
}

/* Relative error of positions at the places, by the default recipe. */
static double trained_error(const char *text, int tendons, const scene_tendon *tendon, int count,
                            const double (*rows)[5])
{
    ad_error error = {AD_OK, ""};
    char override[200];
    const char *change = override;
    run r = {.made = {NULL, NULL}};
    config *settings;
    write_places(in_folder("places.csv"), count, rows);
    snprintf(override, sizeof override, "reference={file: %s}", in_folder("places.csv"));
    if (config_read("robot.yaml", text, 1, &change, &settings, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    settings->scene.tendon_count = tendons;
    memcpy(settings->scene.tendons, tendon, (size_t)tendons * sizeof *tendon);
    if (config_experiment_create(settings, 1, &r.made.e, &error) != AD_OK ||
        experiment_problem(r.made.e, &r.made.p, &error) != AD_OK ||
        reference_create(r.made.e, &r.known, &error) != AD_OK ||
        trainer_create(r.made.e, r.made.p, r.known, 0, &r.trainer, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    finish(&r);
    double result = trainer_inspect(r.trainer).errors.position;
    stop(&r);
    assert_int_equal(remove(in_folder("places.csv")), 0);
    print_message("off by %.2e\n", result);
    return result;
}

static void test_bensch(void **state)
{
    (void)state;
    static const char text[] =
        "motion: spatial\n"
        "rod:\n"
        "  length: 0.2\n"
        "  section: {shape: circle, radius: 0.5e-3}\n"
        "  material: {youngs_modulus: 60e9, poissons_ratio: 0.3, shear_correction: 1}\n"
        "loads: {tip: {force: [0, 0.1, 0]}}\n";
    static const double rows[][5] = {
        {0.2, 0, 0.03202773292494256, 0.11956271656625204, 0.1395837564217458}};
    const double lower = 8e-3 * sqrt(3) / 2;
    const scene_tendon tendons[] = {{.offset = {Q(0.0), Q(8e-3)}, .tension = Q(2.0)},
                                    {.offset = {Q(lower), Q(-4e-3)}, .tension = Q(1.0)}};
    double error = trained_error(text, 2, tendons, 1, rows);
    assert_true(error < 1e-10); /* measured: 2e-13 */
}

/* Of spectral elements, to 6e-10 m: t, tip, middle. */
static const double ramp[][7] = {
    {0.05, 0.0033297606636050136, 0, 0.19943684896728783, -0.0006179686656230741, 0,
     0.0998055249045323},
    {0.1, 0.01832147273928049, 0, 0.1954162513534742, -0.004850494975295453, 0,
     0.09946400302389234},
    {0.15, 0.03256146920760809, 0, 0.19229162358325702, -0.0007875461584294158, 0,
     0.09952286632162514},
    {0.2, 0.0455170199849158, 0, 0.19213412968554644, 0.01227082419031583, 0, 0.09871101361488073},
    {0.25, 0.07366058316006663, 0, 0.17847876168285381, 0.017163047563325578, 0,
     0.0975406008166043},
    {0.3, 0.09896679823991827, 0, 0.1590588271455805, 0.024309520411363635, 0, 0.09519109680474605},
    {0.35, 0.11698740793950757, 0, 0.1493747059932455, 0.03808862720483849, 0, 0.08991165876378174},
    {0.4, 0.13188854037799766, 0, 0.1314938554165853, 0.04435181469813947, 0, 0.0860385275538506},
    {0.45, 0.13917914874963766, 0, 0.10891325512839602, 0.044334222134869664, 0,
     0.08484298261352412},
    {0.5, 0.1432533071511709, 0, 0.10482601300667403, 0.04773962230516934, 0, 0.08262081081416231}};

enum { TIMES = sizeof ramp / sizeof *ramp };

static void test_ramp(void **state)
{
    (void)state;
    static const char text[] = "rod:\n"
                               "  length: 0.2\n"
                               "  section: {shape: circle, radius: 0.005}\n"
                               "  material: {youngs_modulus: 1e6, poissons_ratio: 0.45, density: "
                               "1100, shear_correction: 1}\n"
                               "time: {duration: 0.5, windows: 20}\n";
    double rows[2 * TIMES][5];
    for (int i = 0; i < 2 * TIMES; i++) {
        const double *at = ramp[i / 2] + 3 * (i % 2);
        double s = i % 2 ? 0.1 : 0.2;
        memcpy(rows[i], (const double[]){s, ramp[i / 2][0], at[1], at[2], at[3]}, sizeof rows[i]);
    }
    const scene_tendon tendon = {.offset = {Q(8e-3), Q(0.0)},
                                 .tension = Q("0.3*where(0.1-t, sin(5*pi*t)^2, 1)")};
    double error = trained_error(text, 1, &tendon, 2 * TIMES, (const double(*)[5])rows);
    assert_true(error < 1e-6); /* measured: 6e-7 */
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_bensch), cmocka_unit_test(test_ramp)};
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
