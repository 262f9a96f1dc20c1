/* The list of all quantities of a scene, made of the rows in physics/scene/scene_rows.h: what each
 * may depend on, its range, its default, and how it behaves in the mirror of a plane. Defaults,
 * checks and the search for a plane walk this list, in which every entry of every list of a scene
 * has rows of its own: whoever walks it sees them all. */
#ifndef PHYSICS_SCENE_SCENE_FIELD_H
#define PHYSICS_SCENE_SCENE_FIELD_H

#include "physics/scene/scene.h"

/* To which part of a scene it belongs. */
typedef enum scene_part {
    SCENE_OF_EXTENT, /* length and duration, over which all else is sampled */
    SCENE_OF_ROD,    /* of rods and beams */
    SCENE_OF_LOADS,  /* of rods in space, as the rest up to the beam */
    SCENE_OF_START,
    SCENE_OF_END,
    SCENE_OF_BASE,
    SCENE_OF_TIP,
    SCENE_OF_INITIAL,
    SCENE_OF_EXACT, /* manufactured */
    SCENE_OF_LISTS, /* points, actuators, tubes */
    SCENE_OF_BEAM
} scene_part;

/* What it may depend on; scene_check says the same in sentences. */
typedef enum scene_rule {
    SCENE_ONE_NUMBER,
    SCENE_EACH_NUMBER, /* the same, of each member of a family; not of beams */
    SCENE_LENGTH,      /* one number, or one of each member of a family (scene_map) */
    SCENE_PLACE,       /* the same, a place along the rod where something begins, acts or ends */
    SCENE_ALONG,       /* s */
    SCENE_IN_TIME,     /* t, the same all along */
    SCENE_AT_END,      /* t, at one end */
    SCENE_AT_PLACE,    /* t, at one place */
    SCENE_HELD,        /* t, if the end is driven */
    SCENE_AT_START,    /* s, at t = 0 */
    SCENE_EVERYWHERE   /* s and t */
} scene_rule;

typedef enum scene_bounds {
    SCENE_ANY,
    SCENE_FINITE,
    SCENE_POSITIVE,
    SCENE_NOT_NEGATIVE,
    SCENE_STIFFNESS, /* > 0 or the number infinity */
    SCENE_POISSON    /* > -1, <= 0.5 */
} scene_bounds;

typedef enum scene_geometry {
    SCENE_SCALAR,
    SCENE_POLAR_VECTOR, /* a force, a velocity: mirrored, its part across the plane turns round */
    SCENE_AXIAL_VECTOR, /* a moment, a curvature, a spin: only its part across the plane stays */
    SCENE_POSITION_VECTOR, /* a vector from the origin */
    SCENE_SECTION_POINT,   /* two numbers, a place in the section: mirrored, one of them turns round
                            */
    SCENE_TENSOR,          /* diagonal: mirrored the same if the normal is one of its axes */
    SCENE_GRADIENT,   /* of a vector, symmetric and without trace, xx, yy, xy, xz, yz: the same, and
                         in the plane the vector stays in it */
    SCENE_ORIENTATION /* a quaternion */
} scene_geometry;

/* In which frame its entries are. */
typedef enum scene_axes {
    SCENE_WORLD,
    SCENE_BODY,
    SCENE_BY_LOAD /* as the frame of its load */
} scene_axes;

/* Its value where it is not given. */
typedef enum scene_otherwise {
    SCENE_NOTHING,  /* still not given */
    SCENE_ZERO,     /* 0 in every entry */
    SCENE_STRAIGHT, /* (0, 0, 1) */
    SCENE_UPRIGHT   /* (1, 0, 0, 0), the identity */
} scene_otherwise;

typedef struct scene_field {
    const char *key; /* dotted YAML key, "loads.points[2].force" */
    int count;       /* of quantities in turn: all of them are given or none */
    size_t offset;   /* into scene */
    scene_part part;
    scene_rule rule;
    scene_bounds bounds;
    scene_geometry geometry;
    scene_axes axes;
    scene_otherwise otherwise;
} scene_field;

enum { SCENE_FIELDS_MAX = 1000 };

extern const scene_field scene_fields[];
extern const int scene_field_count;

/* What a scene may have several of. */
typedef struct scene_list {
    const char *key; /* "loads.points" */
    size_t offset, stride, count_offset;
    int most;
} scene_list;

extern const scene_list scene_lists[];
extern const int scene_list_count;

int scene_list_length(const scene *rod_scene, const scene_list *list);

/* The list to whose entry *index the field belongs; NULL: it stands alone. */
const scene_list *scene_field_list(const scene_field *field, int *index);

/* [count]; those of an entry beyond the length of its list are not given. */
const quantity *scene_field_of(const scene *rod_scene, const scene_field *field);

/* Whether it holds for a part of the rod alone, that of its segment, actuator or tube; from,
 * to in m. */
bool scene_field_span(const scene *rod_scene, const scene_field *field, double *from, double *to);

/* The key of a quantity within the scene. */
const char *scene_key_of(const scene *rod_scene, const quantity *q);

/* The key of segment `index` that answers to a key "rod...."; that one itself where segments have
 * none. */
const char *scene_key_in_segment(int index, const char *key);

/* The default of one entry. */
quantity scene_field_otherwise(const scene_field *field, int entry);

/* Whether the scene gives it, and as something else than its default. */
bool scene_field_says(const scene *rod_scene, const scene_field *field);

#endif
