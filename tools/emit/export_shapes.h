/* Shapes of members of a given curvature, by the tape of the strain form: what C that is written
 * from that tape is compared with. */
#ifndef TOOLS_EMIT_EXPORT_SHAPES_H
#define TOOLS_EMIT_EXPORT_SHAPES_H

#include "physics/rod/strain.h"

typedef struct export_shapes {
    const scene *open;
    const strain_mesh *mesh; /* of the curvature */
    size_t points;
    const double *s; /* [points] over the length */
    ad_pool *pool;
    size_t members;
    const double *parameters, *curvature; /* [members][count], [members][nodes][3 + tubes], 1/m */
} export_shapes;

/* values [members][points][strain_columns]. AD_BAD_ARGUMENT: what the strain form on a tape does
 * not know (strain_check); AD_NO_MEMORY. */
ad_status export_shapes_find(const export_shapes *asked, double *values, ad_error *error);

#endif
