/* Without MPI. */
#include "tools/programs/launcher.h"
#include "tools/programs/program_ranks.h"

ad_status ranks_begin(int count, char **arguments, const ad_ranks **ranks, ad_error *error)
{
    int rank, processes = launcher_processes(&rank);
    (void)count, (void)arguments;
    *ranks = NULL;
    launcher_share();
    return processes > 1
               ? ad_fail(error, AD_BAD_INPUT,
                         "mpirun or srun: started as %d processes, but built without MPI: install "
                         "libopenmpi-dev or libmpich-dev and build again, or start one",
                         processes)
               : AD_OK;
}

int ranks_threads(int asked)
{
    return asked;
}

double ranks_waited(void)
{
    return 0;
}

int ranks_end(const char *program, int exit_status)
{
    (void)program;
    return exit_status;
}
