/* The start of MPI for a program without a launcher, which has a single rank. Open MPI starts a
   daemon beside it, and searches for networks, displays, graphics processors and the parts of the
   computer, none of which it uses afterwards: together two thirds of the start of the program. */
#include "isph/base.h"
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

extern char **environ;

/* Variables with these beginnings are from launchers of several ranks, or of a single one. */
static const char *const launchers[] = {"OMPI_COMM_WORLD_",
                                        "PMIX_",
                                        "PMI_",
                                        "PMI2_",
                                        "SLURM_PROCID=",
                                        "FLUX_",
                                        "PALS_",
                                        "ALPS_",
                                        "JSM_"};

/* The parameters of Open MPI and of hwloc, which other implementations of MPI do not read. */
static const char *const settings[][2] = {
    {"OMPI_MCA_ess_singleton_isolated", "1"}, /* no daemon, which only MPI_Comm_spawn() uses */
    {"OMPI_MCA_pml", "ob1"},
    {"OMPI_MCA_btl", "self"},
    /* Parts for several ranks, shared memory, daemons and launchers. Loading them takes 3 ms. */
    {"OMPI_MCA_coll", "^tuned,han,adapt,sm,monitoring,sync,inter"},
    {"OMPI_MCA_osc", "^ucx,pt2pt,monitoring"},
    {"OMPI_MCA_op", "^avx"},
    {"OMPI_MCA_mpool", "^hugepage"},
    {"OMPI_MCA_rcache", "^grdma"},
    {"OMPI_MCA_shmem", "^posix,sysv"},
    {"OMPI_MCA_reachable", "^netlink"},
    {"OMPI_MCA_state", "^orted,hnp,novm,tool"},
    {"OMPI_MCA_errmgr", "^default_tool,default_orted,default_hnp"},
    {"OMPI_MCA_schizo", "^slurm,jsm,flux"},
    /* hwloc */
    {"HWLOC_COMPONENTS", "no_os,stop"},  /* no search for the parts of the computer */
    {"HWLOC_PLUGINS_PATH", "/dev/null"}, /* nor for the programs that search for them */
};

/* HasLauncher - Returns true if a launcher such as mpiexec has started the program */
PetscBool HasLauncher(void)
{
  for (char **variable = environ; variable && *variable; variable++) {
    for (size_t k = 0; k < sizeof(launchers) / sizeof(launchers[0]); k++)
      if (!strncmp(*variable, launchers[k], strlen(launchers[k]))) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

static const char *TemporaryFolder(void)
{
  static const char *const names[] = {"OMPI_MCA_orte_tmpdir_base", "TMPDIR", "TEMP", "TMP"};

  for (size_t k = 0; k < sizeof(names) / sizeof(names[0]); k++) {
    const char *folder = getenv(names[k]);

    if (folder && *folder) return folder;
  }
  return "/tmp";
}

/* Names the folder of MPI's files. Without the daemon its usual name is the same in all programs,
   and the first that ends would remove the files of others. */
static void NameFolder(void)
{
  char            path[PETSC_MAX_PATH_LEN];
  struct timespec now = {0};
  int             length;

  (void)clock_gettime(CLOCK_REALTIME, &now);
  length = snprintf(path, sizeof(path), "%s/isph-mpi-%ld-%ld", TemporaryFolder(), (long)getpid(),
                    now.tv_nsec);
  if (length < (int)sizeof(path)) (void)setenv("OMPI_MCA_orte_jobfam_session_dir", path, 0);
}

/* PrepareMpi - Restricts the start of MPI: to no locks that the computer shares, and without a
   launcher to the parts that a single rank uses. Called before MPI_Init(). Variables that the user
   has set stay. */
void PrepareMpi(void)
{
  /* It locks each file by a semaphore of the computer with the file's name, whatever its folder:
     two users with equal names disturb each other, and a killed run blocks all later ones. */
  (void)setenv("OMPI_MCA_sharedfp", "^sm", 0);
  if (HasLauncher()) return;
  if (!getenv(settings[0][0])) NameFolder();
  for (size_t k = 0; k < sizeof(settings) / sizeof(settings[0]); k++)
    (void)setenv(settings[k][0], settings[k][1], 0);
}
