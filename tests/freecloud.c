/* Clouds for tests of forms that couple velocity components: creation with a form, and balls of
   fluid in empty space. */
#include "cloud.h"

/* CloudOfForm - Creates a cloud with a viscous form; more: further options */
Cloud CloudOfForm(const LaplacianRow *form, const CloudBox *box, const char more[])
{
  char  options[128];
  Cloud cloud;

  ASSERT_OK(PetscSNPrintf(options, sizeof(options), "-visc_laplacian %s %s", form->name, more));
  ASSERT_OK(CloudCreate(box, options, &cloud));
  return cloud;
}

/* CloudFree - Creates a ball of fluid in empty space: removes all other particles from a periodic
   box, whose images are then out of reach. */
Cloud CloudFree(const LaplacianRow *form, PetscInt dim)
{
  const CloudBox  box   = CloudPeriodic(dim, 0.25);
  Cloud           cloud = CloudOfForm(form, &box, "");
  Particles      *p     = cloud.particles;
  const PetscReal room  = 0.5 * (box.cells[0] * cloud.scene.dx - cloud.ops->forms.radius);
  PetscInt       *list, n = 0;

  ASSERT_OK(PetscMalloc1(p->n_fluid, &list));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal r2 = 0.0;

    for (PetscInt a = 0; a < dim; a++)
      r2 += PetscSqr(p->x[a][i] - 0.5 * (cloud.scene.lo[a] + cloud.scene.hi[a]));
    if (r2 >= PetscSqr(room)) list[n++] = i;
  }
  ASSERT_OK(ParticlesRemove(&cloud.scene, p, n, list));
  ASSERT_OK(PetscFree(list));
  ASSERT_OK(CloudMove(0.0, PETSC_TRUE, 0.0, &cloud));
  return cloud;
}

/* CloudSetVelocity - Sets `all` to the velocity u of all fluid particles. */
void CloudSetVelocity(const Cloud *cloud, const Quadratic u[], Vec all)
{
  for (PetscInt a = 0; a < cloud->scene.dim; a++) {
    ASSERT_OK(CloudSet(cloud, &u[a], cloud->f[0]));
    ASSERT_OK(VecStrideScatter(cloud->f[0], a, all, INSERT_VALUES));
  }
}
