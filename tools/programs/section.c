#include "tools/programs/section.h"

#include <math.h>

static double size_at(quantity size, double s)
{
    const double value = size.is_given ? quantity_value(size, s, 0) : 0;
    return isfinite(value) ? value : 0;
}

double section_half(const scene *of, double s, bool along_d2)
{
    scene_piece piece = scene_piece_of(of, 0);
    for (int i = 1; i < scene_pieces(of) && s > piece.to; i++) {
        piece = scene_piece_of(of, i);
    }
    const scene_rod *rod = &piece.rod;
    if (rod->section == SCENE_RECTANGLE) {
        return size_at(along_d2 ? rod->height : rod->width, s) / 2;
    }
    double radius = size_at(rod->radius, s);
    for (int i = 0; i < of->tube_count; i++) {
        if (s <= scene_tube_end(of, i)) {
            radius = fmax(radius, size_at(of->tubes[i].rod.radius, s));
        }
    }
    return radius;
}
