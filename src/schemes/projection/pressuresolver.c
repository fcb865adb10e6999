/* The default solver of the pressure, by the kind and the number of its unknowns. Options of the
   preconditioner or of the matrix ask for AMG. */
#include "projection.h"

#define LU_MOST     25000      /* unknowns up to which LU is faster than AMG */
#define LU_SHORT    5000       /* the same for short steps, where its factors take more memory */
#define GAMG_MOST   10000      /* unknowns of a rank up to which messages count */
#define TENSOR_MOST 1500       /* splines along all axes together */
#define PC_OPTIONS  "-ppe_pc_" /* beginning of the options of the preconditioner */

/* Returns true if the matrix of a flow in 2D stays the same for the whole run. */
static PetscBool IsFlatAndFixed(const Scene *scene)
{
  return !SceneMoves(scene) && scene->dim == 2;
}

/*
  Returns true for LU, if the matrix stays the same for the whole run

  In the cavity at Re = 1000 with n = 150 fixed particles a solve takes 29 ms with AMG, 12 ms with a
  guess from earlier solutions, and 8 ms with LU, whose factors take 0.7 s. In 3D LU takes too much
  memory, and on several ranks PETSc needs another package for it.

  With explicit convection and fits below degree 4 steps are so short that AMG needs two or three
  iterations, and LU is not worth its memory. In the same cavity a step and a particle take:

    n = 100, pressure on particles  LU 0.56 us, 3.5 kB   AMG 0.75 us, 1.6 kB
    n = 300, on coarse points       LU 0.78 us, 2.5 kB   AMG 0.70 us, 1.35 kB

  In the longer steps of implicit convection AMG needs five iterations, and more with degree 4.
*/
static PetscBool TakesLU(const Flow *flow, PetscMPIInt ranks, PetscReal n)
{
  const Scene    *scene = flow->scene;
  const PetscBool brief =
      scene->motion && !flow->state->implicit_convection && flow->ops->forms.degree < 4;

  return IsFlatAndFixed(scene) && ranks == 1 && n <= (brief ? LU_SHORT : LU_MOST);
}

/* Returns true for PETSc's AMG. On several ranks with few unknowns messages take as long as
   arithmetic. PETSc's AMG sends a third of BoomerAMG's at the same arithmetic: its coarse levels
   are on fewer ranks. It needs more memory. */
static PetscBool TakesGAMG(const Flow *flow, PetscMPIInt ranks, PetscReal n)
{
  return IsFlatAndFixed(flow->scene) && ranks > 1 && n <= (PetscReal)ranks * GAMG_MOST;
}

/*
  Returns true for the inverse of the stiffness of splines, see splineinverse.c

  Beside bodies the stiffness is no tensor product. A product with the inverse takes twice as many
  operations for each spline as there are splines along all axes. In the first steps of the cavity
  with moving particles the pressure takes, with this inverse and with AMG:

    2D n = 400   7 iterations     AMG 11, twice the time
    2D n = 1000  7                AMG 11, twice the time
    3D n = 40    9                AMG 17, 2.4 times the time

  At n = 1000 one product takes as long as a cycle of AMG.
*/
static PetscBool TakesTensor(const Splines *sp)
{
  PetscInt sum = 0;

  if (!sp || sp->bodies || SceneMixes(sp->lattice.scene)) return PETSC_FALSE;
  for (PetscInt a = 0; a < sp->lattice.dim; a++) {
    if (sp->lattice.cells[a] < 2) return PETSC_FALSE;
    sum += sp->lattice.count[a];
  }
  return sum <= TENSOR_MOST;
}

/* PressureChoose - Chooses the default solver; collective */
PetscErrorCode PressureChoose(const Flow *flow, PressureSolver *solver)
{
  const Splines *sp = ((const Projection *)flow->scheme->data)->splines;
  PetscReal      n  = 1.0; /* unknowns, which may exceed PetscInt */
  PetscMPIInt    ranks;
  char          *all, *asked;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &ranks));
  PetscCall(PetscOptionsGetAll(NULL, &all));
  PetscCall(PetscStrstr(all, PC_OPTIONS, &asked));
  for (PetscInt a = 0; a < flow->scene->dim; a++) n *= flow->scene->cells[a];
  if (sp) n = sp->lattice.N;
  *solver = PRESSURE_AMG;
  if (!asked) {
    if (TakesLU(flow, ranks, n)) *solver = PRESSURE_LU;
    else if (TakesTensor(sp)) *solver = PRESSURE_TENSOR;
    else if (TakesGAMG(flow, ranks, n)) *solver = PRESSURE_GAMG;
  }
  PetscCall(PetscFree(all));
  PetscFunctionReturn(PETSC_SUCCESS);
}
