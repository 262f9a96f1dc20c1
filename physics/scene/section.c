/* Area, second moments, torsion constant and shear correction of the sections a rod may have. */
#include "physics/scene/section.h"
#include "physics/numerics/constants.h"
#include "physics/scene/scene.h"

#include <math.h>

/* Saint-Venant torsion constant of a rectangle (Timoshenko and Goodier, Theory of Elasticity,
 * section 109): with the shorter side c and the longer side d,
 *   J = d c^3 (1/3 - 64/pi^5 (c/d) sum over odd n of tanh(n pi d/(2c)) / n^5).
 * tanh x = 1 - 2/(exp(2x) + 1) splits off sum 1/n^5 = 31/32 zeta(5); the rest has converged to
 * rounding when n reaches 13, since d/c >= 1. */
static quantity rectangle_torsion(quantity width, quantity height)
{
    const double zeta5 = 1.03692775514336992633;
    quantity sides[2] = {width, height};
    quantity shorter = quantity_call("min", sides), longer = quantity_call("max", sides);
    quantity sum = quantity_number(31.0 / 32 * zeta5);
    for (int n = 1; n <= 13; n += 2) {
        quantity turns = quantity_divide(quantity_scale(longer, n * PI), shorter);
        quantity grown = quantity_add(quantity_call("exp", &turns), quantity_number(1));
        quantity rest = quantity_divide(quantity_number(2), grown);
        sum = quantity_subtract(sum, quantity_divide(rest, quantity_number(pow(n, 5))));
    }
    quantity slender = quantity_divide(quantity_scale(shorter, 64 / pow(PI, 5)), longer);
    quantity share = quantity_subtract(quantity_number(1.0 / 3), quantity_multiply(slender, sum));
    return quantity_multiply(quantity_multiply(longer, quantity_power(shorter, 3)), share);
}

static quantity square(quantity x)
{
    return quantity_multiply(x, x);
}

static scene_section_geometry annulus(quantity outer, quantity inner)
{
    quantity area = quantity_multiply(quantity_scale(quantity_subtract(outer, inner), PI),
                                      quantity_add(outer, inner));
    quantity squares = quantity_add(square(outer), square(inner));
    quantity second_moment = quantity_scale(quantity_multiply(area, squares), 0.25);
    return (scene_section_geometry){
        area, {second_moment, second_moment}, quantity_scale(second_moment, 2)};
}

scene_section_geometry scene_section_geometry_of(const scene_rod *rod)
{
    quantity width = rod->width;
    quantity height = rod->height;
    const quantity twelve = quantity_number(12);
    switch (rod->section) {
    case SCENE_CIRCLE:
        return annulus(rod->radius, quantity_number(0));
    case SCENE_TUBE:
        return annulus(rod->radius, rod->inner_radius);
    case SCENE_RECTANGLE:
        return (scene_section_geometry){
            quantity_multiply(width, height),
            {quantity_divide(quantity_multiply(width, quantity_power(height, 3)), twelve),
             quantity_divide(quantity_multiply(height, quantity_power(width, 3)), twelve)},
            rectangle_torsion(width, height),
        };
    case SCENE_SECTION_NONE:
        break;
    }
    return (scene_section_geometry){.area = {.is_given = false}};
}

/* (a + b nu) */
static quantity of_poisson(double a, double b, quantity nu)
{
    return quantity_add(quantity_number(a), quantity_scale(nu, b));
}

quantity scene_shear_correction(const scene_rod *rod)
{
    quantity nu = rod->poissons_ratio;
    quantity above = quantity_scale(of_poisson(1, 1, nu), 6);
    quantity ratio = square(quantity_divide(rod->inner_radius, rod->radius));
    quantity thick = quantity_power(quantity_add(quantity_number(1), ratio), 2);
    switch (rod->section) {
    case SCENE_CIRCLE:
        return quantity_divide(above, of_poisson(7, 6, nu));
    case SCENE_TUBE:
        return quantity_divide(quantity_multiply(above, thick),
                               quantity_add(quantity_multiply(of_poisson(7, 6, nu), thick),
                                            quantity_multiply(of_poisson(20, 12, nu), ratio)));
    case SCENE_RECTANGLE:
        return quantity_divide(quantity_scale(of_poisson(1, 1, nu), 10), of_poisson(12, 11, nu));
    case SCENE_SECTION_NONE:
        break;
    }
    return (quantity){.is_given = false};
}
