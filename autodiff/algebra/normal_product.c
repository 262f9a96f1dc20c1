/* J^T J v on the tape: J v forwards; J^T w backwards, for w that nobody has yet; then J v in its
 * place. */
#include "autodiff/ad.h"

#include <stdlib.h>

static ad_status record(ad_tape *tape, int count, const ad_value *residuals, int wrt_count,
                        const ad_value *wrt, const ad_value *directions, ad_value *moved,
                        ad_value *products)
{
    ad_value all = ad_stack(count, residuals);
    ad_value weight = ad_input(tape, "residual weight", ad_rows(all));
    ad_value root = ad_sum_points(ad_dot(all, weight));
    ad_status status = ad_reverse(root, wrt_count, wrt, AD_SUMMED, products);
    if (status == AD_OK) {
        status = ad_directional(count, residuals, wrt_count, wrt, directions, moved);
    }
    if (status != AD_OK) {
        return status;
    }
    ad_value along = ad_stack(count, moved);
    for (int i = 0; i < wrt_count; i++) {
        products[i] = ad_substitute(products[i], weight, along);
    }
    return ad_tape_status(tape, NULL);
}

ad_status ad_normal_product(int count, const ad_value *residuals, int wrt_count,
                            const ad_value *wrt, const ad_value *directions, ad_value *products)
{
    ad_tape *tape = count > 0 ? residuals[0].tape : NULL;
    if (!tape) {
        return AD_BAD_ARGUMENT;
    }
    ad_value *moved = malloc((size_t)count * sizeof *moved);
    if (!moved) {
        ad_tape_fail(tape, AD_NO_MEMORY, "out of memory for a product with J^T J");
        return AD_NO_MEMORY;
    }
    ad_status status = record(tape, count, residuals, wrt_count, wrt, directions, moved, products);
    free(moved);
    return status;
}
