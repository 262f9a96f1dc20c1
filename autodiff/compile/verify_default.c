/* Whether every program is verified when it is compiled: in debug builds. A program that defines
 * this number itself, as the tests do, decides for itself; the linker then leaves this file out. */
#include "autodiff/compile/program.h"

#ifdef AD_VERIFY
const int ad_verifies_programs = 1;
#else
const int ad_verifies_programs = 0;
#endif
