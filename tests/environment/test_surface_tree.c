/* Sides of a surface where rays meet corners, edges and faces, and of one that cuts itself;
 * test_environment.c has distances. */
#include "meshes.h"
#include "near.h"
#include "temporary_folder.h"
#include "tools/environment/surface_tree.h"

/* Of which all numbers are eighths, as those of the points are. */
static const double boxes[3][2][3] = {{{-1, -1, -1}, {0.5, 1, 0.75}},
                                      {{0, -0.5, -0.25}, {1.5, 0.5, 1.25}},
                                      {{-2, -0.5, -0.5}, {-1.25, 0.5, 0.5}}};

static void add_box(mesh *m, const double box[2][3])
{
    static const int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                    {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    const size_t first = m->corners;
    for (int k = 0; k < 8; k++) {
        mesh_corner(m, box[k & 1][0], box[k >> 1 & 1][1], box[k >> 2][2]);
    }
    for (int f = 0; f < 6; f++) {
        const int *const c = faces[f];
        mesh_triangle(m, first + (size_t)c[0], first + (size_t)c[1], first + (size_t)c[2]);
        mesh_triangle(m, first + (size_t)c[0], first + (size_t)c[2], first + (size_t)c[3]);
    }
}

/* 1 within, 0 on it, -1 outside. */
static int side_of_box(const double box[2][3], const double p[3])
{
    int side = 1;
    for (int i = 0; i < 3; i++) {
        const double off = fmin(p[i] - box[0][i], box[1][i] - p[i]);
        side = off < 0 ? -1 : off == 0 && side > 0 ? 0 : side;
    }
    return side;
}

/* In such numbers nothing is rounded, so all sides are exact. */
static void sides(void **state)
{
    (void)state;
    enum { NODES = 36 };
    mesh m = mesh_make(24, 36);
    surface *of = NULL;
    surface_tree *within = NULL, *outside = NULL;
    for (int k = 0; k < 3; k++) {
        add_box(&m, boxes[k]);
    }
    mesh_write_stl(&m, at("boxes.stl"));
    assert_int_equal(surface_read(at("boxes.stl"), 1, &of, NULL), AD_OK);
    assert_int_equal(surface_check_closed(of, NULL), AD_OK);
    assert_int_equal(surface_tree_create(of, ENVIRONMENT_INSIDE, &within, NULL), AD_OK);
    assert_int_equal(surface_tree_create(of, ENVIRONMENT_OUTSIDE, &outside, NULL), AD_OK);
    assert_true(within->error <= 2e-12); /* all corners are floats */
    int inside = 0, told = 0;
    for (int k = 0; k < NODES * NODES * NODES; k++) {
        const double p[3] = {(k % NODES - 18) / 8.0, (k / NODES % NODES - 18) / 8.0,
                             (k / NODES / NODES - 18) / 8.0};
        int side = -1;
        bool on_one = false;
        for (int b = 0; b < 3; b++) {
            const int here = side_of_box(boxes[b], p);
            side = here > side ? here : side;
            on_one |= here == 0;
        }
        if (!on_one || side > 0) {
            assert_int_equal(triangle_tree_is_free(&within->tree, p), side > 0);
            assert_int_equal(triangle_tree_is_free(&outside->tree, p), side < 0);
            told++;
        }
        inside += side > 0;
    }
    assert_true(inside > 2000 && told > 40000);
    surface_tree_free(within);
    surface_tree_free(outside);
    surface_free(of);
    mesh_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(sides)};
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
