/* Distances from surfaces against a search over all triangles by other formulas; files that are
 * refused. */
#include "meshes.h"
#include "near.h"
#include "physics/numerics/triangle.h"
#include "random_numbers.h"
#include "temporary_folder.h"
#include "tools/environment/distance_grid.h"
#include "tools/environment/environment.h"
#include "tools/environment/surface_tree.h"

#include <time.h>

/* ---- the other formulas ---------------------------------------------------------------------- */

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void combine(const double a[3], double v, const double b[3], double w, const double c[3],
                    double out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = a[i] + v * b[i] + w * c[i];
    }
}

/* By Voronoi regions (Ericson, Real-Time Collision Detection, 2005, 5.1.5). */
static double by_regions(const double *const t[3], const double p[3])
{
    double ab[3], ac[3], ap[3], bp[3], cp[3], q[3];
    combine(t[1], -1, t[0], 0, t[0], ab);
    combine(t[2], -1, t[0], 0, t[0], ac);
    combine(p, -1, t[0], 0, t[0], ap);
    combine(p, -1, t[1], 0, t[0], bp);
    combine(p, -1, t[2], 0, t[0], cp);
    const double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp),
                 d5 = dot(ab, cp), d6 = dot(ac, cp);
    const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    double v, w;
    if (d1 <= 0 && d2 <= 0) {
        v = w = 0;
    } else if (d3 >= 0 && d4 <= d3) {
        v = 1, w = 0;
    } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
        v = d1 / (d1 - d3), w = 0;
    } else if (d6 >= 0 && d5 <= d6) {
        v = 0, w = 1;
    } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
        v = 0, w = d2 / (d2 - d6);
    } else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
        w = (d4 - d3) / ((d4 - d3) + (d5 - d6)), v = 1 - w;
    } else {
        v = vb / (va + vb + vc), w = vc / (va + vb + vc);
    }
    combine(t[0], v, ab, w, ac, q);
    combine(p, -1, q, 0, q, q);
    return sqrt(dot(q, q));
}

static double to_all(const mesh *m, const double p[3])
{
    double least = INFINITY;
    for (size_t i = 0; i < m->triangles; i++) {
        const uint32_t *const t = m->triangle[i];
        const double *const corners[3] = {m->corner[t[0]], m->corner[t[1]], m->corner[t[2]]};
        least = fmin(least, by_regions(corners, p));
    }
    return least;
}

/* The distance from a triangle, which is convex, is a convex function along a line: thirds. */
static double by_thirds(const double *const t[3], const double a[3], const double b[3])
{
    double low = 0, high = 1, p[3], along[3], least = INFINITY;
    combine(b, -1, a, 0, a, along);
    for (int k = 0; k < 90; k++) {
        const double one = low + (high - low) / 3, other = high - (high - low) / 3;
        combine(a, one, along, 0, a, p);
        const double left = by_regions(t, p);
        combine(a, other, along, 0, a, p);
        const double right = by_regions(t, p);
        least = fmin(least, fmin(left, right));
        *(left < right ? &high : &low) = left < right ? other : one;
    }
    return fmin(least, fmin(by_regions(t, a), by_regions(t, b)));
}

static double segment_to_all(const mesh *m, const double a[3], const double b[3])
{
    double least = INFINITY;
    for (size_t i = 0; i < m->triangles; i++) {
        const uint32_t *const t = m->triangle[i];
        const double *const corners[3] = {m->corner[t[0]], m->corner[t[1]], m->corner[t[2]]};
        least = fmin(least, by_thirds(corners, a, b));
    }
    return least;
}

/* ---- distances ------------------------------------------------------------------------------- */

static environment *open_mesh(const mesh *m, const char *name, double unit, environment_side side)
{
    surface *of = NULL;
    environment *result = NULL;
    ad_error error;
    const char *const dot_at = strrchr(name, '.');
    if (strcmp(dot_at, ".obj") == 0) {
        mesh_write_obj(m, at(name));
    } else if (strncmp(name, "text", 4) == 0) {
        mesh_write_text(m, at(name));
    } else {
        mesh_write_stl(m, at(name));
    }
    assert_int_equal(surface_read(at(name), unit, &of, &error), AD_OK);
    assert_int_equal(of->corners, m->corners);
    assert_int_equal(of->triangles, m->triangles);
    assert_int_equal(environment_create(of, side, &result, &error), AD_OK);
    return result;
}

static surface_tree *tree_of(const environment *of, environment_side side)
{
    surface_tree *tree = NULL;
    assert_int_equal(surface_tree_create(environment_surface(of), side, &tree, NULL), AD_OK);
    return tree;
}

/* What exported C says against Embree's answer: both measure the same triangles but for corners,
 * which are floats in the tree. The side is one where the surface is farther than that. */
static void try_tree(const surface_tree *tree, const double p[3], double found)
{
    double nearest[3], to[3];
    const double said = triangle_tree_distance(&tree->tree, p, INFINITY, nearest);
    assert_near(said, fabs(found), tree->error);
    combine(p, -1, nearest, 0, p, to);
    assert_near(sqrt(dot(to, to)), said, tree->error);
    assert_true(triangle_tree_distance(&tree->tree, p, said / 2, nearest) == said / 2);
    assert_true(triangle_tree_distance(&tree->tree, p, said * 1.5 + 1e-12, nearest) == said);
    if (fabs(found) > tree->error) {
        assert_int_equal(triangle_tree_is_free(&tree->tree, p), found > 0);
    }
}

/* Anywhere; near the surface, by a power of ten; at its corners and the middles of its edges. */
static void draw(const mesh *m, uint64_t *random, double size, double p[3])
{
    const int kind = random_below(random, 4);
    const size_t t = random_bits(random) % m->triangles;
    const double *const a = m->corner[m->triangle[t][0]], *const b = m->corner[m->triangle[t][1]];
    const double off = size * pow(10, -random_in(random, 0, 9));
    for (int i = 0; i < 3; i++) {
        p[i] = kind == 0   ? random_in(random, -2 * size, 2 * size)
               : kind == 1 ? a[i] + off * random_in(random, -1, 1)
               : kind == 2 ? a[i]
                           : (a[i] + b[i]) / 2;
    }
}

/* In doubles both formulas are exact but for some last digits of coordinates, which are at most
 * 2 here. The distance within which it is does not change the answer, also where it is wrong. */
static void try_points(const mesh *m, const environment *of, uint64_t seed, int count, double size)
{
    surface_tree *tree = tree_of(of, ENVIRONMENT_OUTSIDE);
    for (int k = 0; k < count; k++) {
        double p[3];
        draw(m, &seed, size, p);
        const double expected = to_all(m, p), found = environment_distance(of, p, INFINITY);
        assert_near(fabs(found), expected, 1e-12 * fmax(1, size));
        assert_true(environment_distance(of, p, expected) == found);
        assert_true(environment_distance(of, p, expected / 2) == found);
        try_tree(tree, p, found);
        double slope[3], foot[3], beyond[3]; /* back along its derivative the surface is met */
        assert_true(environment_slope(of, p, slope) == found);
        const double rounding = expected < 1e-12 * size ? 0 : 1e-14 / expected; /* of p */
        assert_near(dot(slope, slope), 1, 1e-12 + rounding);
        combine(p, -found, slope, 0, p, foot);
        assert_true(to_all(m, foot) < 1e-12 * fmax(1, size));
        combine(p, 1e-6 * size, slope, 0, p, beyond);
        if (expected < 1e-12 * size) {
            assert_true(environment_distance(of, beyond, INFINITY) > 0);
        }
        if (expected > 1e-9 * size) { /* the sign, where rounding does not decide */
            const double winding = environment_winding(of, p);
            assert_near(winding, found < 0 ? 1 : 0, 1e-6);
        }
    }
    surface_tree_free(tree);
}

static void points_of_three_formats(void **state)
{
    (void)state;
    mesh m = mesh_torus(0.7, 0.25, 40, 20);
    static const char *const names[] = {"binary.stl", "text.stl", "mesh.obj"};
    for (int k = 0; k < 3; k++) {
        environment *of = open_mesh(&m, names[k], 1, ENVIRONMENT_OUTSIDE);
        try_points(&m, of, (uint64_t)k, 700, 1);
        environment_free(of);
    }
    mesh_free(&m);
}

/* Far from the origin, and small: floats there are coarse. */
static void points_of_a_mesh_far_away(void **state)
{
    (void)state;
    mesh m = mesh_torus(1.5e-3, 0.4e-3, 50, 30);
    for (size_t i = 0; i < m.corners; i++) {
        m.corner[i][0] += 1.75;
        m.corner[i][1] -= 1.5;
    }
    environment *of = open_mesh(&m, "far.obj", 1, ENVIRONMENT_OUTSIDE);
    try_points(&m, of, 5, 500, 2e-3);
    environment_free(of);
    mesh_free(&m);
}

static void lines(void **state)
{
    (void)state;
    mesh m = mesh_torus(0.7, 0.25, 24, 12);
    environment *of = open_mesh(&m, "torus.stl", 1, ENVIRONMENT_OUTSIDE);
    surface_tree *tree = tree_of(of, ENVIRONMENT_ANY);
    uint64_t random = 9;
    int meet = 0;
    for (int k = 0; k < 300; k++) {
        double a[3], b[3];
        draw(&m, &random, 1, a);
        draw(&m, &random, 1, b);
        if (k % 2) { /* short ones, as between points of a rod */
            combine(a, random_in(&random, 0, 0.05), b, 0, a, b);
        }
        const double expected = segment_to_all(&m, a, b);
        const double found = environment_segment(of, a, b, INFINITY);
        /* thirds end at rounding of a place; where lines and triangles meet the distance is 0 */
        assert_near(fabs(found), expected, 1e-12);
        assert_true(environment_segment(of, a, b, fmax(expected, fabs(found))) == found);
        assert_near(triangle_tree_segment(&tree->tree, a, b, INFINITY), fabs(found), tree->error);
        assert_near(triangle_tree_segment(&tree->tree, a, b, 0.01), fmin(fabs(found), 0.01),
                    tree->error);
        assert_true(environment_is_beyond(of, a, b, 0.999 * expected - 1e-9));
        assert_false(environment_is_beyond(of, a, b, 1.001 * expected + 1e-9));
        meet += expected < 1e-12;
    }
    assert_true(meet > 20 && meet < 280);
    surface_tree_free(tree);
    environment_free(of);
    mesh_free(&m);
}

/* The file is read and checked, the tree and the grid are made. */
static void a_large_mesh(void **state)
{
    (void)state;
    mesh m = mesh_torus(0.1, 0.03, 500, 100);
    struct timespec start, end;
    clock_gettime(CLOCK_MONOTONIC, &start);
    environment *of = open_mesh(&m, "large.stl", 1, ENVIRONMENT_INSIDE);
    distance_grid *grid = NULL, *again = NULL;
    assert_int_equal(
        distance_grid_create(of, ENVIRONMENT_INSIDE, 400000, at("large.h5"), &grid, NULL), AD_OK);
    clock_gettime(CLOCK_MONOTONIC, &end);
    print_message("100,000 triangles prepared in %.2f s\n",
                  (double)(end.tv_sec - start.tv_sec) +
                      1e-9 * (double)(end.tv_nsec - start.tv_nsec));
    uint64_t random = 3;
    for (int k = 0; k < 40; k++) {
        double p[3];
        draw(&m, &random, 0.1, p);
        assert_near(fabs(environment_distance(of, p, INFINITY)), to_all(&m, p), 1e-12);
    }
    double worst = 0;
    for (int k = 0; k < 20000; k++) {
        double p[3];
        draw(&m, &random, 0.1, p);
        const double exact = environment_distance(of, p, INFINITY);
        const double kept = distance_field_at(&grid->field, p);
        const double least = distance_field_least(&grid->field, p);
        if (fabs(p[0]) < 0.12 && fabs(p[1]) < 0.12 && fabs(p[2]) < 0.02) {
            worst = fmax(worst, fabs(kept - exact));
            assert_true(least <= exact); /* a bound, and no worse than that of the nearest node */
            assert_true(least >= exact - 2 * distance_grid_error(grid));
        } else { /* beyond the grid nothing is inside */
            assert_true(exact <= 0 ? kept <= distance_grid_error(grid) : true);
        }
    }
    assert_true(worst <= distance_grid_error(grid));
    assert_int_equal(
        distance_grid_create(of, ENVIRONMENT_INSIDE, 400000, at("large.h5"), &again, NULL), AD_OK);
    assert_true(!grid->was_kept && again->was_kept);
    const int *const count = grid->field.count;
    assert_memory_equal(grid->value, again->value,
                        (size_t)(count[0] * count[1] * count[2]) * sizeof(float));
    distance_grid_free(again); /* what is kept of another side is made anew */
    assert_int_equal(
        distance_grid_create(of, ENVIRONMENT_OUTSIDE, 1000, at("large.h5"), &again, NULL), AD_OK);
    assert_false(again->was_kept);
    distance_grid_free(grid);
    distance_grid_free(again);
    environment_free(of);
    mesh_free(&m);
}

/* ---- what is refused ------------------------------------------------------------------------- */

static void refused(const char *name, environment_side side, double length, const char *why)
{
    surface *of = NULL;
    environment *e = NULL;
    ad_error error = {.message = ""};
    ad_status status = surface_read(at(name), 1, &of, &error);
    if (status == AD_OK) {
        status = surface_check_size(of, length, &error);
        if (status == AD_OK) {
            status = environment_create(of, side, &e, &error);
        } else {
            surface_free(of);
        }
    }
    environment_free(e);
    if (status != AD_BAD_INPUT || !strstr(error.message, why) || strchr(error.message, '\n')) {
        fail_msg("'%s' is not '...%s...'", error.message, why);
    }
}

static void write_text(const char *name, const char *text)
{
    FILE *const file = fopen(at(name), "w");
    fputs(text, file);
    fclose(file);
}

static void bad_files(void **state)
{
    (void)state;
    mesh m = mesh_torus(0.1, 0.03, 20, 10);
    mesh_write_stl(&m, at("good.stl"));
    refused("good.stl", ENVIRONMENT_INSIDE, 1e-3, "is 0.37");
    refused("good.stl", ENVIRONMENT_INSIDE, 1e-3, "is its unit another?");
    refused("good.stl", ENVIRONMENT_INSIDE, 1e3, "is its unit another?");
    truncate(at("good.stl"), 9000);
    refused("good.stl", ENVIRONMENT_INSIDE, 0.2, "good.stl: has 9000 bytes");
    m.triangles--;
    mesh_write_text(&m, at("open.stl"));
    refused("open.stl", ENVIRONMENT_INSIDE, 0.2, "the surface is open");
    refused("open.stl", ENVIRONMENT_INSIDE, 0.2, "open.stl:2652:");
    m.triangles++;
    const uint32_t before = m.triangle[7][0];
    m.triangle[7][0] = m.triangle[7][1];
    m.triangle[7][1] = before;
    mesh_write_obj(&m, at("turned.obj"));
    refused("turned.obj", ENVIRONMENT_OUTSIDE, 0.2, "turn different ways");
    mesh_free(&m);
    m = mesh_torus(0.1, 0.03, 20, 10);
    for (size_t i = 0; i < m.triangles; i++) {
        const uint32_t a = m.triangle[i][0];
        m.triangle[i][0] = m.triangle[i][1];
        m.triangle[i][1] = a;
    }
    mesh_write_stl(&m, at("inverted.stl"));
    refused("inverted.stl", ENVIRONMENT_OUTSIDE, 0.2, "is inside out");
    mesh_free(&m);
    write_text("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 4\nf 1 2 3\n");
    refused("flat.obj", ENVIRONMENT_ANY, 1, "flat.obj:6: the triangle has no area");
    write_text("word.obj", "v 0 0 zero\n");
    refused("word.obj", ENVIRONMENT_ANY, 1, "word.obj:1: v: needs three numbers");
    write_text("far.obj", "v 0 0 0\nv 1 0 0\nf 1 2 3\n");
    refused("far.obj", ENVIRONMENT_ANY, 1, "far.obj:3: f: needs numbers of corners");
    write_text("huge.obj", "v 0 0 1e999\n");
    refused("huge.obj", ENVIRONMENT_ANY, 1, "huge.obj:1: a coordinate is not finite");
    write_text("empty.stl", "solid nothing\nendsolid\n");
    refused("empty.stl", ENVIRONMENT_ANY, 1, "empty.stl: has no triangles");
    write_text("words.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n");
    refused("words.stl", ENVIRONMENT_ANY, 1, "words.stl:4: vertex: needs three numbers");
    write_text("more.stl", "solid x\nhallo\n");
    refused("more.stl", ENVIRONMENT_ANY, 1, "more.stl:2: is no line of STL");
    write_text("mesh.ply", "ply\n");
    refused("mesh.ply", ENVIRONMENT_ANY, 1, "mesh.ply: has another ending");
    write_text("three.obj",
               "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\nf 1 3 2\nf 1 2 4\nf 1 5 2\n");
    refused("three.obj", ENVIRONMENT_INSIDE, 1, "three.obj:6:");
}

/* A third of a turn about the diagonal takes x to y, y to z, z to x; then it is moved. The grid of
 * another place is another. */
static void places(void **state)
{
    (void)state;
    const double third[4] = {2, 2, 2, 2}, position[3] = {0, 0.125, 0}, no_turn[4] = {1, 0, 0, 0};
    surface *of = NULL, *same = NULL;
    write_text("placed.obj", "v 1 2 3\nv 4 5 7\nv 6 9 8\nf 1 2 3\n");
    assert_int_equal(surface_read(at("placed.obj"), 1, &of, NULL), AD_OK);
    assert_int_equal(surface_read(at("placed.obj"), 1, &same, NULL), AD_OK);
    surface_place(of, position, third);
    surface_place(same, position, no_turn);
    for (size_t i = 0; i < 3; i++) {
        const double *const p = &same->corner[3 * i], *const q = &of->corner[3 * i];
        assert_near(q[0], p[2], 1e-14);
        assert_near(q[1], p[0] + 0.125, 1e-14);
        assert_near(q[2], p[1] - 0.125, 1e-14);
    }
    assert_near(of->low[0], 3, 1e-14);
    assert_near(of->high[2], 9, 1e-14);
    assert_true(of->hash != same->hash);
    surface_free(of);
    surface_free(same);
}

int main(void)
{
    const struct CMUnitTest distances[] = {cmocka_unit_test(points_of_three_formats),
                                           cmocka_unit_test(points_of_a_mesh_far_away),
                                           cmocka_unit_test(lines),
                                           cmocka_unit_test(a_large_mesh),
                                           cmocka_unit_test(bad_files),
                                           cmocka_unit_test(places)};
    return environment_is_built()
               ? cmocka_run_group_tests(distances, make_directory, remove_directory)
               : 77;
}
