/* Every program that is compiled is verified: by tests, and by programs that are watched. */
#include "verify.h"

static __attribute__((constructor)) void verify_programs(void)
{
    ad_program_check = ad_program_verify;
}
