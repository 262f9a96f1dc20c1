/* What a problem has to know of the physics: coordinates, fields, residuals, and how the numbers of
 * a network become fields.
 *
 * A model is made from a scene of rods or beams (model_of_scene), or put together from one's own
 * equations (model_create and the functions below it), or both: terms may be added to either.
 *
 * Everything on the tape is dimensionless; coordinates in units of their scale. Models of scenes
 * use rod_scales_of. */
#ifndef PHYSICS_LEARN_MODEL_H
#define PHYSICS_LEARN_MODEL_H

#include "nn/nn.h"
#include "physics/rod/rod.h"
#include "physics/scene/domain.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    MODEL_FIELDS_MAX = 8,
    MODEL_SETS_MAX = 16,
    MODEL_TERMS_MAX = 24,
    MODEL_COLUMNS_MAX = 32,
    MODEL_UNKNOWNS_MAX = 8,
    MODEL_NAME = 32,
    MODEL_STATE_ROWS_MAX = 13
};

typedef struct physics_model physics_model;

/* ---- points -------------------------------------------------------------------------------- */

/* Which settings of a problem count for a set of points; none: its places are given by its source.
 */
typedef enum model_points {
    MODEL_INTERIOR,
    MODEL_BOUNDARY,
    MODEL_INITIAL,
    MODEL_GIVEN
} model_points;

/* Points to be filled with data. */
typedef struct model_draw {
    size_t count;
    int window;           /* of time, at work */
    bool held_out;        /* never trained on */
    nn_rng *rng;          /* of these points, for whatever is random */
    double *x;            /* [coordinates][count], dimensionless; may be replaced */
    const double *fields; /* [rows of all fields][count], the network's; NULL: see follows */
    double *data;         /* [rows][count], dimensionless */
} model_draw;

/* What is known of points beside their coordinates: measured, solved, or computed from what the
 * network says of them. Residuals have it as at->data, and it is not differentiated. Points are
 * filled where they are drawn; where `follows` (NULL: never) says so the trained ones before every
 * step, too, and then with the network's fields. What `fill` returns has to be the same for the
 * same draw, since a checkpoint holds the trained points and their data, but not the others. */
typedef struct model_source {
    int rows; /* 0: no data */
    ad_status (*fill)(void *context, const model_draw *draw, ad_error *error);
    bool (*follows)(const void *context);
    void *context; /* borrowed */

    /* Of MODEL_GIVEN points: how many, and steps between new ones, 0: never. Without held-out
     * points their terms are no part of the held-out loss. */
    size_t points, held_out_points;
    int draw_every;
} model_source;

/* Where terms are evaluated: inside, or on the face where some coordinates are held. */
typedef struct model_set {
    char name[MODEL_NAME];
    model_points points;
    bool holds[DOMAIN_COORDINATES_MAX];   /* this coordinate does not vary */
    double value[DOMAIN_COORDINATES_MAX]; /* but is this, dimensionless */
    model_source source;
} model_set;

/* ---- terms --------------------------------------------------------------------------------- */

/* A residual, any number of rows, dimensionless and of order one, recorded at a place from the
 * fields. `context` is borrowed. Errors are sticky on the tape. */
typedef ad_value model_residual(const void *context, const domain_place *at,
                                const ad_value *fields);

/* weight * mean over the points of the set of |residual|^2 is added to the loss. */
typedef struct model_term {
    char name[MODEL_NAME];
    int set;
    double weight; /* 0: left out */
    model_residual *residual;
    const void *context;
} model_term;

/* ---- conditions and unknowns of one's own ------------------------------------------------------
 */

/* What a field or a slope of it is on a face: one row, recorded at a place. `context` is borrowed.
 */
typedef ad_value model_value(const void *context, const domain_place *at);

/* The derivative of that order by the coordinate, dimensionless, of a row of a field on the face
 * that the condition's set is. */
typedef struct model_condition {
    int field, row, coordinate, order;
    model_value *value;
    const void *context;
} model_condition;

/* A number that is found from data with the solution. */
typedef struct model_unknown {
    char name[MODEL_NAME];
    const char *unit; /* of the SI, static text */
    double guess;     /* in this unit */
} model_unknown;

/* ---- observables --------------------------------------------------------------------------- */

/* The name of a column, its unit of the SI, and whether only motion has it. */
typedef struct model_column {
    const char *name, *unit;
    bool of_motion;
} model_column;

/* ---- motions ------------------------------------------------------------------------------- */

/* The largest distance over the length by which places are off, to first order: by all that a
 * motion leaves out, and what of it is the network's of time. */
typedef struct model_motion_error {
    double all, in_time;
} model_motion_error;

/* Residuals that are computed and not recorded, for training: of numbers y that depend on time
 * alone, into which a network of time without hidden layers enters as
 *
 *   y = start + start_t t + t^2 outputs,   t from the start of a window on,
 *
 * (with outputs by combinations of its functions: motion_network.c),
 *
 * so that the state of a window's start is met exactly. Dimensionless, like time. One thread at a
 * time. */
typedef struct model_motion {
    int size;            /* of y, the outputs of the network */
    int stride;          /* of the rows of derivatives */
    const double *start; /* [2 size] y, y_t at t = 0 */
    int pieces;          /* of s, within which it is smooth, */
    const double *edges; /* [pieces + 1] from 0 to the length, dimensionless */
    void *context;       /* borrowed, of these: */

    /* residual [size] at y [3][size]: y, y_t, y_tt; by (NULL: not wanted): its derivatives by each
     * of them [size rows of stride], there until the next call. */
    ad_status (*residual)(void *context, double t, const double *y, double *residual,
                          const double *by[3], ad_error *error);

    /* How far a motion is off until the end of a window, by its residual in an equation that is
     * finer than that of `size` numbers. y [count][3][size] is given at the middles of as many
     * equal parts of the window. Windows come one after the other; one that begins earlier begins
     * anew. */
    ad_status (*off)(void *context, double begin, double end, size_t count, const double *y,
                     model_motion_error *off, ad_error *error);

    /* values [columns of the model][stride], in SI units, at s [n], ascending or not. */
    ad_status (*observe)(void *context, double t, const double *y, size_t n, const double *s,
                         size_t stride, double *values, ad_error *error);
} model_motion;

/* ---- models -------------------------------------------------------------------------------- */

/* What differs between a rod, a beam and a model of one's own, from the network to what is seen. */
typedef struct model_functions {
    /* From the outputs of the network at a place to the fields [field_count]. */
    void (*ansatz)(const physics_model *m, const domain_place *at, ad_value outputs,
                   ad_value *fields);

    /* values [column_count], one row each; zeros for those of motion in a static scene. Without a
     * scene the rows of the fields are the columns. */
    void (*observe)(const physics_model *m, const domain_place *at, const ad_value *fields,
                    ad_value *values);

    /* The state, functions of s, one row each [state_rows], at the time of the place. */
    void (*state)(const physics_model *m, const domain_place *at, const ad_value *fields,
                  ad_value *rows);

    /* Highest degree of the polynomials of s in which a state [WINDOW_STATE_POINTS][state_rows]
     * goes on through a window; a divisor of WINDOW_STATE_DEGREE. What is left of it fades away. */
    int (*going_degree)(const physics_model *m, const double *state);

    /* What the network is given at a place, [inputs]; NULL: the coordinates. */
    ad_value (*input)(const physics_model *m, const domain_place *at);
} model_functions;

struct physics_model {
    struct domain domain;
    struct scene scene; /* of models of scenes; else as scene_defaults leaves it */
    bool has_scene;

    int field_count;
    char symbols[MODEL_FIELDS_MAX][8]; /* of the fields: "r", "q", "N", "m" */
    int field_rows[MODEL_FIELDS_MAX];
    int unknowns;        /* the first so many fields come from the network, the others from these */
    int inputs, outputs; /* of the network; inputs 0: the coordinates */
    const double *separate;     /* [outputs], borrowed: the residual of the only term is separate[i]
                                 * times output i, less what the network does not count for; or NULL */
    const void *own;            /* of the functions, borrowed */
    const model_motion *motion; /* in place of the residual of its only term, of the functions and
                                 * of a state that windows hand on; borrowed; NULL: none */

    int set_count;
    model_set sets[MODEL_SETS_MAX];
    int term_count;
    model_term terms[MODEL_TERMS_MAX];
    int condition_count;
    model_condition conditions[MODEL_SETS_MAX];
    int condition_terms[MODEL_SETS_MAX];
    bool exact[MODEL_SETS_MAX]; /* see model_for_network */
    int own_unknown_count;
    model_unknown own_unknowns[MODEL_UNKNOWNS_MAX];

    /* Observables in SI units: position_columns and then rotation_columns come first. */
    const model_column *columns;
    int column_count, position_columns, rotation_columns;

    bool takes_load_factor; /* its loads may come in parts: load_factor is a uniform */
    int state_rows;         /* what a window of time hands to the next; 0: nothing, one window */

    model_functions call;

    model_column own_columns[MODEL_COLUMNS_MAX]; /* without a scene; their names: */
    char own_names[MODEL_COLUMNS_MAX][16];
    struct model_scene_term {
        const physics_model *owner;
        rod_residual_kind kind;
    } scene_terms[ROD_RESIDUAL_COUNT];
    ad_error error; /* the first of those that put it together */
};

/* What is known of the rods or the beams that a scene may have, whatever its numbers. */
enum { SCENE_FIELDS = 4 }; /* and one more of tendons, of tubes: of rods with such */

typedef struct scene_physics {
    const char *fields[SCENE_FIELDS]; /* symbols */
    const model_column
        *columns; /* those of motion last, or of a rod with tubes theta, m_i of each */
    int column_count, position_columns, rotation_columns;
    int (*network_outputs)(const scene *scene);
    int (*state_rows)(const scene *scene);
    int (*residual_rows)(const scene *scene, rod_residual_kind kind);
    model_residual *residual; /* its context: model_scene_term */
    model_functions call;

    /* What only shows when a scene is recorded; see rod_check. */
    ad_status (*check)(const scene *scene, const char **key, ad_error *error);

    /* For people; see rod_terms. */
    int (*terms)(const scene *scene, rod_term *terms);
} scene_physics;

const scene_physics *scene_physics_of(const scene *scene);

/* The coordinates of a scene as its model has them: in pieces along s that end where something of
 * the scene jumps (physics/scene/breaks.h), and in windows of time that do. The displacement form,
 * whose derivatives would jump, has one piece; so has a scene with more than a network can have. Of
 * fewer windows than there are stretches between jumps all are equal. AD_NO_MEMORY. */
ad_status model_domain_of(const scene *scene, domain *d, ad_error *error);

/* The model of a scene that passes scene_check, which is copied (its texts must live on); weights:
 * NULL for the defaults. AD_NO_MEMORY. */
ad_status model_of_scene(const scene *scene, const rod_weights *weights, physics_model **result,
                         ad_error *error);

/* A model without anything, for equations of one's own; NULL when memory runs out. */
physics_model *model_create(void);
void model_free(physics_model *m);

/* The functions below return the index of what they add. Their first error is kept, and
 * problem_create reports it: AD_BAD_ARGUMENT with what is allowed. */

/* A coordinate from low to high in its unit of the SI (static text, may be ""). On the tape it is
 * dimensionless, at->x[index]: divided by `scale`, 0: by its range. */
int model_add_coordinate(physics_model *m, const char *name, const char *unit, double low,
                         double high, double scale);

/* Says that a coordinate is time: causal weights and `initial` points follow it. */
void model_set_time(physics_model *m, int coordinate);

/* A field of so many rows. Its columns are named by the symbol, with a number from 1 on behind it
 * where rows are several, and are in whatever unit the residuals take it to be. A model takes its
 * fields from the outputs of the network, in their order, unless `call.ansatz` is set to a function
 * that makes them of the outputs and the place: so conditions are met exactly. */
int model_add_field(physics_model *m, const char *symbol, int rows);

/* All of the domain; or the face where `coordinate` is at its low (0) or high (1) end. */
int model_add_interior(physics_model *m, const char *name);
int model_add_face(physics_model *m, const char *name, int coordinate, int end);

/* Points of all of the domain whose places and data `source` gives. */
int model_add_given(physics_model *m, const char *name, const model_source *source);

int model_add_term(physics_model *m, const char *name, int set, double weight,
                   model_residual *residual, const void *context);

/* A coordinate without ends: what is at its low end is at its high one, with all derivatives. */
void model_set_periodic(physics_model *m, int coordinate);

/* On the face where `coordinate` is at its low (0) or high (1) end `value` records what a row of a
 * field is, or the derivative of that order by this coordinate. It is a face
 * and a term, of weight 100, with this name; the index is that of the term. */
int model_add_condition(physics_model *m, const char *name, model_condition condition, int end);

/* A number that is found from data; residuals have it as row `index` of at->unknowns, in its unit
 * of the SI (static text, may be ""). Models with such numbers are solved by patches_fit. */
int model_add_unknown(physics_model *m, const char *name, const char *unit, double guess);

/* The model as networks have it, which points into this one; training makes it by itself.
 * Conditions are built into its fields, and their terms left out by weight 0, where a row is given
 * on faces with all slopes below the highest, the third at most. Faces have to agree where they
 * meet, and with periodic coordinates. Others stay terms. So do all of a row of which one changes
 * within a tenth of a range, a front: networks would have to take it away again. What is periodic
 * enters a network by its sine and cosine. */
ad_status model_for_network(const physics_model *m, physics_model **result, ad_error *error);

/* Of such a model: whether a term is a condition that its fields meet whatever the network is. */
bool model_condition_is_exact(const physics_model *m, int term);

/* Whether its fields are other than the outputs of the network. */
bool model_has_ansatz(const physics_model *m);

/* AD_OK, or why the model is not one: an error of the functions above, no field, no term. */
ad_status model_check(const physics_model *m, ad_error *error);

/* ---- recording ----------------------------------------------------------------------------- */

/* What is set before a run of the model's programs: in window 0 or in a later one. */
domain_uniforms model_uniforms(const physics_model *m, int window);

/* Inputs and uniforms on a new tape, the network of `mlp` (its parameters from 0 on) and the fields
 * that it stands for. A model of a manufactured scene has its exact fields without a network. */
domain_place model_record(const physics_model *m, int window, const nn_mlp *mlp, ad_tape *tape,
                          ad_value *fields);

/* The unknowns of its scene by the network's scalars, at a place; nothing where there are none. */
void model_record_unknowns(const physics_model *m, const nn_mlp *mlp, bool combined,
                           domain_place *at);

/* How many columns there are to be had: those of motion come last and only motion has them. */
int model_columns(const physics_model *m);

#ifdef __cplusplus
}
#endif

#endif
