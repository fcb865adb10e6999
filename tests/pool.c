/* Fluid with a free surface, for tests of the particles on it. */
#include "isph/start.h"
#include "pool.h"

/* PoolFill - Creates the particles of a scene, its lattices displaced by a jitter */
void PoolFill(PetscReal jitter, Pool *pool)
{
  OperatorForms *forms = &pool->forms;
  Scene         *scene = &pool->s.scene;

  *forms        = (OperatorForms){.h_over_dx = 1.5};
  forms->kernel = (const KernelRow *)(const void *)TableGet(&KernelTable, 0);
  forms->h      = forms->h_over_dx * scene->dx;
  forms->radius = forms->kernel->support * forms->h;
  pool->free    = (FreeSurface){0};
  scene->jitter = jitter;
  ASSERT_OK(ParticlesCreate(scene, forms->radius, &pool->p));
  ASSERT_OK(ParticlesFill(scene, pool->s.walls, NULL, pool->p));
  ASSERT_OK(NeighborsCreate(forms->radius, scene->dx, &pool->nb));
}

/* PoolFind - Finds the particles on the surface */
void PoolFind(Pool *pool)
{
  const KernelSize kernel = FormsKernel(&pool->forms);

  ASSERT_OK(NeighborsUpdate(pool->p, 0.0, pool->nb));
  ASSERT_OK(FreeSurfaceFind(&pool->s.scene, pool->p, pool->nb, &kernel, &pool->free));
}

/* PoolEmpty - Destroys the particles */
void PoolEmpty(Pool *pool)
{
  ASSERT_OK(FreeSurfaceFree(&pool->free));
  ASSERT_OK(NeighborsDestroy(&pool->nb));
  ASSERT_OK(ParticlesDestroy(&pool->p));
}

/* PoolCount - Returns the number of particles of a kind on all ranks for which `on` returns `is` */
PetscInt PoolCount(const Pool *pool, SurfaceKind kind, PetscBool (*on)(const Pool *, PetscInt),
                   PetscBool is)
{
  PetscInt n = 0;

  for (PetscInt i = 0; i < pool->p->n_fluid; i++)
    n += pool->free.kind[i] == kind && on(pool, i) == is ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, &n, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD);
  return n;
}
