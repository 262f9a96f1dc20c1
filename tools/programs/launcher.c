#include "tools/programs/launcher.h"

#include "tools/programs/cli.h"

#include <stdlib.h>

/* Open MPI; MPICH, Intel MPI and srun --mpi=pmi2; srun. */
static const char *const names[][2] = {{"OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"},
                                       {"PMI_SIZE", "PMI_RANK"},
                                       {"SLURM_STEP_NUM_TASKS", "SLURM_PROCID"}};

static bool shares; /* since main has begun */

void launcher_share(void)
{
    shares = true;
}

bool launcher_is_shared(void)
{
    return shares;
}

int launcher_processes(int *rank)
{
    *rank = 0;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        const char *count = getenv(names[i][0]), *number = getenv(names[i][1]);
        if (count && number && atoi(count) > 1) {
            *rank = atoi(number);
            return atoi(count);
        }
    }
    return 1;
}

int launcher_refuse(const char *program, const char *what)
{
    int rank, count = launcher_processes(&rank);
    return rank > 0 ? CLI_BAD
                    : cli_fail(program,
                               "%s, and would run %d times: start it without mpirun or srun, or "
                               "with one process",
                               what, count);
}
