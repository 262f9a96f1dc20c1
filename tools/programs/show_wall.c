/* cpinn-show: the surface of a scene's plan, around the shapes of a table. */
#include "tools/programs/show_source.h"

#include <stdlib.h>

/* More triangles are too slow in a page, and too long in an .svg. */
enum { TRIANGLES_MAX = 60000 };

ad_status show_open_wall(showing *showing, ad_error *error)
{
    config *scene = NULL;
    ad_status status = config_read(showing->wall_path, NULL, showing->overrides.count,
                                   showing->overrides.texts, &scene, error);
    const environment_settings *const of = scene ? &scene->plan.environment : NULL;
    if (status == AD_OK && !of->file) {
        status = config_refuse(scene, "plan.environment.file",
                               "is not given, and --wall shows it; allowed: .stl, .obj", error);
    }
    status = status == AD_OK ? surface_open(of, &showing->wall, error) : status;
    if (status == AD_OK && showing->wall->triangles > TRIANGLES_MAX) {
        status = ad_fail(error, AD_BAD_INPUT, "%.300s: has %zu triangles; allowed for --wall: %d",
                         of->file, showing->wall->triangles, TRIANGLES_MAX);
    }
    config_free(scene);
    return status;
}

ad_status show_put_wall(showing *showing, ad_error *error)
{
    static const char *const names[] = {"x", "y", "z"}, *const ends[] = {"a", "b", "c"};
    const surface *const of = showing->wall;
    json *const to = &showing->to;
    const size_t most = of->corners > of->triangles ? of->corners : of->triangles;
    double *const numbers = malloc(most * sizeof *numbers + 1);
    if (!numbers) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a report");
    }
    json_open(to, "wall", '{');
    json_integer(to, "corners", (int64_t)of->corners);
    json_integer(to, "triangles", (int64_t)of->triangles);
    for (int kind = 0; kind < 2; kind++) {
        const size_t rows = kind ? of->triangles : of->corners;
        json_open(to, kind ? "of" : "places", '[');
        for (size_t k = 0; k < 3; k++) {
            for (size_t i = 0; i < rows; i++) {
                numbers[i] = kind ? of->triangle[3 * i + k] : of->corner[3 * i + k];
            }
            show_column(to, kind ? ends[k] : names[k], kind ? "" : "m", numbers, rows, false);
        }
        json_close(to, ']');
    }
    json_close(to, '}');
    free(numbers);
    return AD_OK;
}
