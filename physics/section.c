/* Area, second moments, torsion constant and shear correction of the sections a rod may have. */
#include "physics/constants.h"
#include "physics/scene.h"

#include <math.h>

/* Saint-Venant torsion constant of a rectangle (Timoshenko and Goodier, Theory of Elasticity,
 * section 109): with the shorter side c and the longer side d,
 *   J = d c^3 (1/3 - 64/pi^5 (c/d) sum over odd n of tanh(n pi d/(2c)) / n^5).
 * tanh x = 1 - 2/(exp(2x) + 1) splits off sum 1/n^5 = 31/32 zeta(5); the rest has converged to
 * rounding when n reaches 13, since d/c >= 1. */
static double rectangle_torsion(double width, double height)
{
    const double zeta5 = 1.03692775514336992633;
    double shorter = fmin(width, height);
    double longer = fmax(width, height);
    double sum = 31.0 / 32 * zeta5;
    for (int n = 1; n <= 13; n += 2) {
        sum -= 2 / (exp(n * PI * longer / shorter) + 1) / pow(n, 5);
    }
    return longer * pow(shorter, 3) * (1.0 / 3 - 64 / pow(PI, 5) * shorter / longer * sum);
}

static scene_section_geometry annulus(double outer, double inner)
{
    double area = PI * (outer - inner) * (outer + inner);
    double second_moment = area * (outer * outer + inner * inner) / 4;
    return (scene_section_geometry){area, {second_moment, second_moment}, 2 * second_moment};
}

scene_section_geometry scene_section_geometry_of(const scene_rod *rod)
{
    double width = rod->width;
    double height = rod->height;
    switch (rod->section) {
    case SCENE_CIRCLE:
        return annulus(rod->radius, 0);
    case SCENE_TUBE:
        return annulus(rod->radius, rod->inner_radius);
    case SCENE_RECTANGLE:
        return (scene_section_geometry){
            width * height,
            {width * pow(height, 3) / 12, height * pow(width, 3) / 12},
            rectangle_torsion(width, height),
        };
    case SCENE_SECTION_NONE:
        break;
    }
    return (scene_section_geometry){NAN, {NAN, NAN}, NAN};
}

double scene_shear_correction(const scene_rod *rod)
{
    double nu = rod->poissons_ratio;
    double ratio = rod->inner_radius / rod->radius;
    double thick = pow(1 + ratio * ratio, 2);
    switch (rod->section) {
    case SCENE_CIRCLE:
        return 6 * (1 + nu) / (7 + 6 * nu);
    case SCENE_TUBE:
        return 6 * (1 + nu) * thick / ((7 + 6 * nu) * thick + (20 + 12 * nu) * ratio * ratio);
    case SCENE_RECTANGLE:
        return 10 * (1 + nu) / (12 + 11 * nu);
    case SCENE_SECTION_NONE:
        break;
    }
    return NAN;
}
