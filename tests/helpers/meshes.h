/* For tests: surfaces of triangles, written as files. */
#ifndef TESTS_MESHES_H
#define TESTS_MESHES_H

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct mesh {
    size_t corners, triangles;
    double (*corner)[3];
    uint32_t (*triangle)[3];
} mesh;

static inline mesh mesh_make(size_t corners, size_t triangles)
{
    return (mesh){0, 0, malloc(corners * sizeof(double[3])),
                  malloc(triangles * sizeof(uint32_t[3]))};
}

static inline void mesh_free(mesh *m)
{
    free(m->corner);
    free(m->triangle);
}

static inline uint32_t mesh_corner(mesh *m, double x, double y, double z)
{
    const double place[3] = {x, y, z};
    for (int i = 0; i < 3; i++) { /* as a binary file has them; GCC 12 leaves a mere cast out */
        const volatile float kept = (float)place[i];
        m->corner[m->corners][i] = kept;
    }
    return (uint32_t)m->corners++;
}

static inline void mesh_triangle(mesh *m, size_t a, size_t b, size_t c)
{
    m->triangle[m->triangles][0] = (uint32_t)a;
    m->triangle[m->triangles][1] = (uint32_t)b;
    m->triangle[m->triangles++][2] = (uint32_t)c;
}

/* A torus around z, with waves. */
static inline mesh mesh_torus(double large, double small, size_t along, size_t across)
{
    mesh m = mesh_make(along * across, 2 * along * across);
    const double turn = 2 * acos(-1);
    for (size_t i = 0; i < along; i++) {
        for (size_t j = 0; j < across; j++) {
            const double u = turn * (double)i / (double)along,
                         v = turn * (double)j / (double)across;
            const double r = small * (1 + 0.2 * sin(5 * u) * cos(3 * v));
            mesh_corner(&m, (large + r * cos(v)) * cos(u), (large + r * cos(v)) * sin(u),
                        r * sin(v));
        }
    }
    for (size_t i = 0; i < along; i++) {
        for (size_t j = 0; j < across; j++) {
            const size_t k = (i + 1) % along, l = (j + 1) % across;
            mesh_triangle(&m, i * across + j, k * across + j, k * across + l);
            mesh_triangle(&m, i * across + j, k * across + l, i * across + l);
        }
    }
    return m;
}

/* A tube of that radius along an arc in the plane of x and z that starts at `from` before the
 * origin along z and turns by `angle` over the length; its ends are closed. */
static inline mesh mesh_tube(double radius, double from, double length, double angle, size_t along,
                             size_t across)
{
    mesh m = mesh_make((along + 1) * across + 2, 2 * (along + 1) * across);
    const double turn = 2 * acos(-1);
    for (size_t i = 0; i <= along; i++) {
        const double s = length * (double)i / (double)along;
        const double k = angle / length, b = k * s;
        const double x = k != 0 ? (1 - cos(b)) / k : 0, z = (k != 0 ? sin(b) / k : s) - from;
        for (size_t j = 0; j < across; j++) {
            const double v = turn * (double)j / (double)across;
            mesh_corner(&m, x + radius * cos(v) * cos(b), radius * sin(v),
                        z - radius * cos(v) * sin(b));
        }
    }
    const double k = angle / length;
    const size_t start = mesh_corner(&m, 0, 0, -from);
    const size_t end = mesh_corner(&m, k != 0 ? (1 - cos(angle)) / k : 0, 0,
                                   (k != 0 ? sin(angle) / k : length) - from);
    for (size_t j = 0; j < across; j++) {
        const size_t l = (j + 1) % across;
        for (size_t i = 0; i < along; i++) {
            mesh_triangle(&m, i * across + j, i * across + l, (i + 1) * across + l);
            mesh_triangle(&m, i * across + j, (i + 1) * across + l, (i + 1) * across + j);
        }
        mesh_triangle(&m, start, l, j);
        mesh_triangle(&m, end, along * across + j, along * across + l);
    }
    return m;
}

static inline void mesh_write_stl(const mesh *m, const char *path)
{
    FILE *const file = fopen(path, "wb");
    const char head[80] = "made by a test";
    const uint32_t count = (uint32_t)m->triangles;
    fwrite(head, 1, sizeof head, file);
    fwrite(&count, 4, 1, file);
    for (size_t i = 0; i < m->triangles; i++) {
        float numbers[12] = {0};
        const uint16_t nothing = 0;
        for (size_t k = 0; k < 9; k++) {
            numbers[3 + k] = (float)m->corner[m->triangle[i][k / 3]][k % 3];
        }
        fwrite(numbers, sizeof numbers, 1, file);
        fwrite(&nothing, 2, 1, file);
    }
    fclose(file);
}

static inline void mesh_write_text(const mesh *m, const char *path)
{
    FILE *const file = fopen(path, "w");
    fprintf(file, "solid made by a test\n");
    for (size_t i = 0; i < m->triangles; i++) {
        fprintf(file, "facet normal 0 0 0\n  outer loop\n");
        for (size_t k = 0; k < 3; k++) {
            const double *const p = m->corner[m->triangle[i][k]];
            fprintf(file, "    vertex %.17g %.17g %.17g\n", p[0], p[1], p[2]);
        }
        fprintf(file, "  endloop\nendfacet\n");
    }
    fprintf(file, "endsolid\n");
    fclose(file);
}

static inline void mesh_write_obj(const mesh *m, const char *path)
{
    FILE *const file = fopen(path, "w");
    fprintf(file, "# made by a test\no thing\n");
    for (size_t i = 0; i < m->corners; i++) {
        fprintf(file, "v %.17g %.17g %.17g\n", m->corner[i][0], m->corner[i][1], m->corner[i][2]);
    }
    for (size_t i = 0; i < m->triangles; i++) {
        fprintf(file, "f %u//1 %u/2 %u/2/3\n", m->triangle[i][0] + 1, m->triangle[i][1] + 1,
                m->triangle[i][2] + 1);
    }
    fclose(file);
}

#endif
