#include "tools/solve/solve.h"

solve_settings solve_settings_default(void)
{
    return (solve_settings){.tolerance = 1e-10};
}
