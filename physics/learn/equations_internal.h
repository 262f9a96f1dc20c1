/* What the files of equations share; not for others. */
#ifndef PHYSICS_LEARN_EQUATIONS_INTERNAL_H
#define PHYSICS_LEARN_EQUATIONS_INTERNAL_H

#include "physics/learn/equations.h"

enum {
    EQUATIONS_NAME_BYTES = 41,
    EQUATIONS_NAMES_MAX = 128,
    EQUATIONS_LIST_BYTES = 240, /* of names in a message */
    EQUATIONS_CONDITIONS_MAX = 48
};

typedef enum name_kind {
    NAME_COORDINATE = 1,
    NAME_RANGE = 2, /* a coordinate, too */
    NAME_UNKNOWN = 4,
    NAME_FIELD = 8,      /* or a derivative of one, where orders are not all 0 */
    NAME_PARAMETER = 16, /* which formulas put in */
    NAME_DERIVED = 32,   /* a derivative of a parameter that is a formula */
    NAME_ANY = 63
} name_kind;

typedef struct equations_name {
    char text[EQUATIONS_NAME_BYTES];
    name_kind kind;
    int index; /* of the coordinate, the unknown, the field; of what is derived, its name */
    int orders[DOMAIN_COORDINATES_MAX];
    quantity q; /* of a parameter */
} equations_name;

/* A formula as the context of a residual or a value; or measured numbers [rows] of a name at places
 * [coordinates][rows]. */
typedef struct equations_formula {
    struct equations_formula *next;
    const equations *owner;
    quantity q;
    int of; /* measured: the name, and the rest */
    size_t rows;
    double noise, *places, *values;
} equations_formula;

typedef struct equations_condition {
    int coordinate, end, field, order;
} equations_condition;

struct equations {
    physics_model *model;
    quantities *quantities;
    equations_formula *formulas;
    int name_count;
    equations_name names[EQUATIONS_NAMES_MAX];
    char units[DOMAIN_COORDINATES_MAX][EQUATIONS_NAME_BYTES];
    bool is_range[DOMAIN_COORDINATES_MAX];
    int inside_set, inside, zeros, unknowns;
    quantity equation[MODEL_TERMS_MAX];  /* [inside] */
    int face[DOMAIN_COORDINATES_MAX][2]; /* its set and 1; 0: none yet */
    int condition_count;
    equations_condition conditions[EQUATIONS_CONDITIONS_MAX]; /* of fields */
    int at[DOMAIN_COORDINATES_MAX]; /* conditions of all kinds at its faces */
    bool has_data, is_whole;
};

/* The name of that text, -1: there is none. */
int equations_find_name(const equations *e, const char *text, size_t length);

/* Those of some kinds, without derivatives, "x, t". */
const char *equations_list_names(const equations *e, int kinds, char list[EQUATIONS_LIST_BYTES]);

/* AD_OK until the model is made. */
ad_status equations_still_open(const equations *e, ad_error *error);

/* What the model refuses of itself, kept there, too. */
ad_status equations_model_status(const equations *e, ad_error *error);

/* Makes names of the words of a formula that are derivatives; others are left to the formula. */
ad_status equations_know_words(equations *e, const char *text, ad_error *error);

/* A formula that is left with some kinds of names; `q` lives as long as the equations. */
ad_status equations_read_formula(equations *e, const char *text, int kinds, quantity *q,
                                 ad_error *error);
ad_status equations_keep_formula(equations *e, quantity q, equations_formula **kept,
                                 ad_error *error);

/* What a name is at a place; and a formula, as model_residual. */
ad_value equations_record_name(const equations *e, const equations_name *n, const domain_place *at,
                               const ad_value *fields);
ad_value equations_record_formula(const void *context, const domain_place *at,
                                  const ad_value *fields);

/* The highest derivative of a field by a coordinate in a formula; -1: the field is not in it. */
int equations_order(const equations *e, quantity q, int field, int coordinate);

#endif
