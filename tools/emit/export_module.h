/* A family of rods at rest as a WebAssembly module, for pages that compute shapes by themselves:
 * the C of cpinn-export, compiled by clang. It asks JavaScript's Math for sin and the like, and
 * nobody for anything else. It exports its memory and
 *   parameters(), shape(), said(), drawn()  where these are: [parameters], in SI units,
 *                     [places][STRAIN_COLUMNS], [EXPORT_SAID] as of export_family.h, [drawn]
 *   answer(steps)     fills the others in from the parameters;
 *   place(), axes(), box()  [3], m; [3][3], unit vectors; the least and the largest parameters,
 *                     [2][parameters]; for
 *   reach(images, steps, most)  which brings the tip nearer to the place by so many steps of
 *                     optim/seek.h at most, and returns how far it is, m: along the first axes, as
 *                     many as images, 2 or 3. */
#ifndef TOOLS_EMIT_EXPORT_MODULE_H
#define TOOLS_EMIT_EXPORT_MODULE_H

#include "physics/scene/scene.h"

struct experiment;

/* A quantity at a place, m, that is drawn beside the shape. */
typedef struct export_drawn {
    quantity of;
    double s;
} export_drawn;

/* At places s [places], m, of the strain form; *bytes [*size] to be freed. AD_IO: there is no
 * compiler for it, or it fails, in one line; AD_NO_MEMORY and others of export_family_write. */
ad_status export_module_create(const struct experiment *e, int places, const double *s, int drawn,
                               const export_drawn *list, char **bytes, size_t *size,
                               ad_error *error);

/* What surrounds the C: module_functions.c, module_math.h and optim/seek.c. */
extern const char *const export_module_functions[], *const export_module_math[],
                                                        *const export_module_seek[];

#endif
