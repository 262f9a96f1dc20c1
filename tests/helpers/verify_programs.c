/* Every program that a test compiles is verified, in release builds as well. */
#include "autodiff/compile/program.h"

const int ad_verifies_programs = 1;
