#include "tools/programs/scene_line.h"

#include "physics/beam/beam.h"
#include "physics/check/plausible.h"
#include "physics/rod/rod.h"

#include <math.h>
#include <stdio.h>

static void print_number(const char *name, double value)
{
    if (isinf(value)) {
        printf(", %s locked", name);
    } else if (value > 0) {
        printf(", %s %.4g", name, value);
    }
}

void scene_line_print(const char *scene_name, const scene *of)
{
    rod_numbers n = rod_numbers_of(of);
    printf("%s: %s", scene_name, scene_is_dynamic(of) ? "dynamic" : "static");
    if (scene_is_beam(of)) {
        beam_numbers b = beam_numbers_of(of);
        print_number("shear kGA L^2/EI", b.shear_ratio);
        print_number("foundation k L^4/EI", b.foundation);
        print_number("rotary inertia rhoI/(rhoA L^2)", b.rotary_inertia);
        print_number("duration", n.duration);
        putchar('\n');
        return;
    }
    print_number("shear kGA L^2/EI", n.shear_ratio);
    print_number("stretch EA L^2/EI", n.axial_ratio);
    print_number("tip force F L^2/EI", n.tip_force);
    print_number("tip moment T L/EI", n.tip_moment);
    print_number("line load f L^3/EI", n.distributed_force);
    print_number("line moment l L^2/EI", n.distributed_moment);
    print_number("foundation k L^4/EI", n.foundation);
    print_number("weight rhoA g L^3/EI", n.weight);
    print_number("point force F L^2/EI", n.point_force);
    print_number("point moment T L/EI", n.point_moment);
    print_number("actuation T L/EI", n.actuation);
    print_number("curvature of tubes k L", n.tubes);
    print_number("duration", n.duration);
    putchar('\n');
}

void scene_line_implausible(const scene *of)
{
    const scene_warnings all = scene_implausible(of);
    for (int i = 0; i < all.count; i++) {
        printf("implausible: %s\n", all.texts[i]);
    }
    fflush(stdout);
}
