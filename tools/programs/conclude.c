#include "tools/programs/conclude.h"

#include "tools/programs/cli.h"
#include "tools/train/report.h"

static void blame(const conclusion *c, const ad_error *error)
{
    cli_fail_error(c->program, error);
    verdict_add_error(c->verdict, error);
}

static ad_status write_json(const conclusion *c, ad_error *error)
{
    json to;
    json_begin(&to);
    json_text(&to, "program", c->program);
    json_text(&to, "version", cli_version());
    json_text(&to, "name", c->name);
    report_verdict(&to, c->verdict);
    c->tell(c->of, &to);
    return json_end(&to, c->json, error);
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
    if (c->json && write_json(c, error) != AD_OK) {
        blame(c, error);
    }
    return verdict_exit_status(c->verdict);
}
