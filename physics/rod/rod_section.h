/* What follows at a section from its strains alone: what it stores and carries, on the tape. */
#ifndef PHYSICS_ROD_ROD_SECTION_H
#define PHYSICS_ROD_ROD_SECTION_H

#include "physics/scene/scene.h"

/* n, m are those of rod and actuators together, body, as in physics/rod/rod.h: N and N m. */
#define ROD_SECTION_LIST(X)                                                                        \
    X(ROD_SECTION_N1, "n1")                                                                        \
    X(ROD_SECTION_N2, "n2")                                                                        \
    X(ROD_SECTION_N3, "n3")                                                                        \
    X(ROD_SECTION_M1, "m1")                                                                        \
    X(ROD_SECTION_M2, "m2")                                                                        \
    X(ROD_SECTION_M3, "m3")                                                                        \
    X(ROD_SECTION_ENERGY, "energy_density") /* elastic, J for each m of s */                       \
    X(ROD_SECTION_STRAIN, "strain")         /* the largest of all fibres along the rod, by size */ \
    X(ROD_SECTION_CURVATURE, "curvature")   /* of bending, 1/m */                                  \
    X(ROD_SECTION_SHEAR, "shear")
typedef enum rod_section {
#define ROD_SECTION_ENUM(value, name) value,
    ROD_SECTION_LIST(ROD_SECTION_ENUM)
#undef ROD_SECTION_ENUM
        ROD_SECTION_COUNT
} rod_section;

const char *rod_section_name(rod_section which);

/* Of a rod at rest with parameters [parameter_count], each of one row. s: an input of the tape of
 * one row, over the length; shape: v, u [6] by the columns of cpinn-eval, 1 and 1/m. Errors are
 * noted on the tape. AD_BAD_INPUT: what does not follow from strains, as reactions of what is
 * locked. */
ad_value rod_section_record(const scene *family, rod_section which, ad_value s,
                            const ad_value *parameters, ad_value strains);

#endif
