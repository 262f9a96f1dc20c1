#include "physics/scene/scene_values.h"

scene_values scene_values_of(const scene *open)
{
    scene_values names = {.count = open->parameter_count};
    for (int i = 0; i < names.count; i++) {
        names.index[i] = quantities_index(open->names, open->parameters[i].name);
    }
    return names;
}

static void put(const scene_values *names, const double *numbers, double *to)
{
    for (int i = 0; i < names->count; i++) {
        to[names->index[i]] = numbers[i];
    }
}

double scene_value_at(const scene_values *names, quantity q, const double *parameters)
{
    double x[QUANTITY_OPEN_MAX] = {0};
    put(names, parameters, x);
    return quantity_value_at(q, QUANTITY_OPEN_MAX, x);
}

double scene_slope_at(const scene_values *names, quantity q, const double *parameters,
                      const double *direction)
{
    double x[QUANTITY_OPEN_MAX] = {0}, along[QUANTITY_OPEN_MAX] = {0};
    put(names, parameters, x);
    put(names, direction, along);
    return quantity_slope_at(q, QUANTITY_OPEN_MAX, x, along);
}
