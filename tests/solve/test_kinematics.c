/* What is seen of reduced rods. */
#include "modes_testing.h"

#include <stdlib.h>
#include <string.h>

/* Kinematics of many states at once are what samples of a shape are, curvature too; derivatives
 * against difference quotients. A joint, a start that moves; three hinges. */
static void assert_kinematics(const char *text)
{
    enum { PLACES = 4, COUNT = 11, MODES = 32, ROWS = PLACES * KINEMATICS_ROWS };
    const double places[PLACES] = {0, 0.3, 0.6, 1}, h = 1e-6;
    ad_error error = {.message = ""};
    reduced_test x = make("kinematics.yaml", text, modes_counts_of(2, 1, 1, 1), 2);
    const rod_scales *scales = &x.rod->scales;
    const int n = modes_size(x.m), size = 2 * n;
    double worst[2] = {0, 0};
    double *all = malloc(sizeof(double[COUNT][2 * MODES])), q[MODES], v[MODES], residual[MODES];
    double *by = malloc(sizeof(double[COUNT][ROWS][2 * MODES])), moved[2][PLACES][KINEMATICS_SEEN];
    double(*see)[PLACES][KINEMATICS_SEEN] = malloc(COUNT * sizeof *see);
    int rows[ROWS];
    unsigned seed = 5;
    modes_places *at;
    kinematics observation;
    solve_state here[PLACES];
    assert_true(n <= MODES);
    for (int i = 0; i < ROWS; i++) {
        rows[i] = i;
    }
    assert_int_equal(modes_at(x.m, 0.3, NULL, &error), AD_OK);
    assert_int_equal(modes_places_create(x.m, PLACES, places, &at, &error), AD_OK);
    assert_int_equal(modes_kinematics_create(x.m, at, ROWS, rows, &observation, &error), AD_OK);
    double *room = malloc(kinematics_room(&observation) * sizeof *room);
    for (int i = 0; i < COUNT * size; i++) {
        all[i] = 0.3 * noise(&seed);
    }
    kinematics_see(&observation, COUNT, all, see[0][0], by, room);
    for (int i = 0; i < COUNT; i++) {
        for (int a = 0; a < n; a++) {
            const double unit =
                x.m->mode[a].strain >= MODES_U && a >= x.m->hinges ? scales->length : 1;
            q[a] = all[i * size + a] * unit;
            v[a] = all[i * size + n + a] * unit * scales->time;
        }
        modes_shape(x.m, q, v, NULL);
        modes_forces(x.m, false, residual);
        modes_samples(x.m, at, here);
        for (int p = 0; p < PLACES; p++) {
            const double *now = see[i][p], *turn = here[p].rotation;
            for (int k = 0; k < 3; k++) {
                const double off[5] = {
                    now[k] - here[p].position[k] * scales->length,
                    now[7 + k] - here[p].velocity[k] * scales->length / scales->time,
                    now[10 + k] - here[p].spin[k] / scales->time, now[13 + k] - here[p].strain[k],
                    now[16 + k] - here[p].curvature[k] / scales->length};
                for (int c = 0; c < 5; c++) {
                    worst[0] = fmax(worst[0], fabs(off[c]));
                }
            }
            for (int k = 0; k < 4; k++) {
                worst[0] = fmax(worst[0], fabs(now[3 + k] - turn[k]));
            }
        }
    }
    for (int c = 0; c < size; c++) { /* of the last state */
        double *last = all + (COUNT - 1) * size, kept = last[c], quotient[KINEMATICS_ROWS];
        for (int side = 0; side < 2; side++) {
            last[c] = kept + (side ? h : -h);
            kinematics_see(&observation, 1, last, moved[side][0], NULL, room);
        }
        last[c] = kept;
        for (int p = 0; p < PLACES; p++) {
            double R[3][3], turn[4];
            for (int k = 0; k < KINEMATICS_ROWS - 3; k++) {
                const int from = k < 3 ? k : 4 + k;
                quotient[k < 3 ? k : 3 + k] = (moved[1][p][from] - moved[0][p][from]) / (2 * h);
            }
            quaternion_quotient(moved[0][p] + 3, moved[1][p] + 3, turn);
            rotation_matrix(see[COUNT - 1][p] + 3, R);
            for (int k = 0; k < 3; k++) {
                turn[1 + k] /= h;
            }
            to_world(R, turn + 1, quotient + 3);
            for (int k = 0; k < KINEMATICS_ROWS; k++) {
                const int row = (COUNT - 1) * ROWS + p * KINEMATICS_ROWS + k;
                worst[1] = fmax(worst[1], fabs(quotient[k] - by[row * size + c]));
            }
        }
    }
    print_message("kinematics: %.1e from samples, derivatives %.1e\n", worst[0], worst[1]);
    assert_true(worst[0] < 1e-13);
    assert_true(worst[1] < 1e-8); /* turns between points leave 1e-9, quotients as much */
    free(room);
    free(all);
    free(by);
    free(see);
    modes_places_free(at);
    modes_kinematics_free(&observation);
    discard(&x);
}

static void test_kinematics(void **state)
{
    (void)state;
    assert_kinematics(everything);
    assert_kinematics("rod: {length: 2, stiffness: {shear: [30, 40], axial: 50, bending: [1, 1],\n"
                      "      torsion: 0.8}, rest: {curvature: [0.2, 0, 0.1*s]},\n"
                      "      inertia: {mass_per_length: 1, rotary: [0.01, 0.01, 0.02]}}\n"
                      "boundary: {start: {type: pinned}}\n"
                      "initial: {position: [s, 0, 0], rotation: [1, 0, 1, 0]}\n"
                      "time: {duration: 2, windows: 1}\n");
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_kinematics)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
