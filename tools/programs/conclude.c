#include "tools/programs/conclude.h"

#include "tools/programs/cli.h"

static void blame(const conclusion *c, const ad_error *error)
{
    cli_fail_error(c->program, error);
    verdict_add_error(c->verdict, error);
}

int conclude(const conclusion *c, ad_status status, ad_error *error)
{
    if (status != AD_OK) {
        blame(c, error);
    } else if (c->anyhow || (c->quiet && verdict_outcome_of(c->verdict) == VERDICT_WARNING)) {
        char prefix[64];
        snprintf(prefix, sizeof prefix, "%s: ", c->program);
        verdict_print(stderr, prefix, c->verdict);
    }
    if (c->json && c->write_json(c->of, error) != AD_OK) {
        blame(c, error);
    }
    return verdict_exit_status(c->verdict);
}
