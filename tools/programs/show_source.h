/* What the sources of cpinn-show share: a report in the making. */
#ifndef TOOLS_PROGRAMS_SHOW_SOURCE_H
#define TOOLS_PROGRAMS_SHOW_SOURCE_H

#include "tools/environment/environment.h"
#include "tools/prepare/config_experiment.h"
#include "tools/programs/cli.h"
#include "tools/programs/samples.h"
#include "tools/programs/show.h"
#include "tools/train/reference.h"

typedef struct showing {
    const char *source, *out, *scene_path, *reference_path, *grid, *at, *workspace, *by, *wall_path;
    double slow; /* movies take that many times as long as motions */
    cli_list overrides;
    bool quiet;
    char title[160];
    json to;
    config *settings;
    experiment *e;
    checkpoint *file;
    field *field;
    reference *known;
    solution *solved;
    samples samples;
    table_file *table, *ghost;
    show_kept kept;
    surface *wall;      /* of --wall; NULL: none */
    bool has_workspace; /* what --workspace and --by ask for is found */
} showing;

/* Members of "curves", open until show_close_curve. */
void show_open_curve(json *to, const char *title, const char *x, const char *x_unit,
                     const char *y_unit, bool log);
void show_close_curve(json *to);

/* A member of "facts"; format is that of one double. */
void show_fact(json *to, const char *name, const char *format, double value);
void show_scene_facts(json *to, const scene *of);

/* A member of "texts". */
void show_text(json *to, const char *title, const char *text);

/* "texts" with all keys of a file. */
void show_settings(json *to, const config *settings);

/* What a training wrote of its losses, as a member of "curves". */
ad_status show_history(json *to, const checkpoint *file, ad_error *error);

/* The unit of a column of the scene's model, "" of others. */
const char *show_unit(const char *name, const scene *of);

/* A table that was read, as one to be written, to be freed; NULL: out of memory. `of` (NULL: a rod)
 * is the scene whose units its columns have. */
table_build *show_read_table_of(const table_file *from, const scene *of);

/* The surface of the section plan of --wall, into showing->wall; and as the member "wall". */
ad_status show_open_wall(showing *showing, ad_error *error);
ad_status show_put_wall(showing *showing, ad_error *error);

/* The motion of a table beside that of --reference, or else `ghost` (NULL: none). */
ad_status show_put_motion(showing *showing, const table_source *table, const char *const *labels,
                          const table_source *ghost, const char *ghost_name, ad_error *error);

/* The points of --grid, or as many as a report has. */
ad_status show_choose_points(showing *showing, const scene *of, double until, ad_error *error);

/* The shapes of showing->samples, in the scene that they are of. */
ad_status show_put_shapes(showing *showing, const scene *of, const char *const *labels,
                          const table_source *ghost, const char *ghost_name, ad_error *error);

/* Whether that file is to be a picture, .svg, .png, .gif, .mp4 or .webm; and the picture of what
 * has been put into showing->to: cpinn-picture takes the place of this program, which returns only
 * where it cannot be started. AD_BAD_INPUT: there is no Python; AD_IO, AD_NO_MEMORY. */
bool show_is_picture(const char *path);
ad_status show_picture(showing *showing, ad_error *error);

/* The whole of a source, title included. AD_BAD_INPUT and others with one line. */
ad_status show_run(showing *showing, ad_error *error);
ad_status show_folder(showing *showing, ad_error *error);

/* Tables without shapes: of numbers with a curve of each column over the first, or as a text. */
ad_status show_numbers(showing *showing, const table_source *table, ad_error *error);
ad_status show_csv(showing *showing, ad_error *error);
ad_status show_surrogate(showing *showing, ad_error *error);
/* Members of showing->settings, a family at rest. */
ad_status show_members(showing *showing, ad_error *error);
/* By the network of showing->e every parameter through its range, the others in the middle of
 * theirs; or one member. */
ad_status show_family(showing *showing, const double *member, ad_error *error);

/* Members [members][parameters] of one parameter through its range; of several evenly throughout
 * all ranges: multiples of powers of g, where g^(n + 1) = g + 1 (Roberts' additive sequence). */
void show_spread(const scene *of, int members, double *parameters);

/* Shapes at s [points] that the page computes, "live" and "scene"; where it cannot, *is_live is
 * false, and "advice" says why. */
ad_status show_live(showing *showing, cpinn_family *family, size_t points, const double *s,
                    bool *is_live, ad_error *error);

/* Tips of members all over the ranges, "workspace" and "tables", and the file of --workspace;
 * nothing of families without predicted errors. At s [points] of the family, the last of them its
 * tip. */
ad_status show_workspace(showing *showing, cpinn_family *family, size_t points, const double *s,
                         ad_error *error);

/* Rows of cpinn-solve --residuals, with the shapes beside them if they are there. */
bool show_is_residuals(const table_file *table);
ad_status show_residuals(showing *showing, const table_source *table, ad_error *error);

ad_status show_loop(showing *showing, const table_source *table, ad_error *error);

/* "name" of "folder/name.yaml". */
void show_title_of(showing *showing, const char *path);

#endif
