/* Box and quantities of plane channel flows. The walls are at y = 0 and y = L; the box is periodic
   along x with a length of 8 dx. */
#include "cases.h"

/* ChannelSetup - Sets the box of a plane channel */
PetscErrorCode ChannelSetup(Scene *scene)
{
  PetscFunctionBegin;
  scene->hi[0] = 8.0 * scene->dx;
  scene->hi[1] = scene->length;
  SceneSetAxis(scene, 0, &BoundaryPeriodic);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ChannelMeasure - Reports norms of the error against the exact velocity; collective

    u_profile_l2   = sqrt(mean (u - U)^2)/max U,  U: exact velocity at the present time
    u_relative_rms = sqrt(mean ((u - U)/U)^2), if `relative`

  Reference of the second norm: M. Basa, N. Quinlan, M. Lastiwka, Int. J. Numer. Meth. Fluids 60
  (2009), Eq. (38)
*/
PetscErrorCode ChannelMeasure(const Flow *flow, PetscBool relative, Report *report)
{
  const Scene     *scene  = flow->scene;
  const Particles *p      = flow->particles;
  PetscReal        sum[2] = {0.0, 0.0}, most = 0.0;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal weight = ParticlesWeight(p, i);
    PetscReal       x[ISPH_MAX_DIM], exact[ISPH_MAX_DIM], pressure;

    for (PetscInt a = 0; a < scene->dim; a++) x[a] = p->x[a][i];
    scene->problem->Exact(scene, ClockMoment(flow->clock), x, exact, &pressure);
    sum[0] += weight * PetscSqr(p->u[0][i] - exact[0]);
    if (relative && exact[0] != 0.0) sum[1] += weight * PetscSqr(p->u[0][i] / exact[0] - 1.0);
    most = PetscMax(most, PetscAbsReal(exact[0]));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, p->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPIU_MAX, p->comm));
  if (SceneIsAsPosed(scene)) {
    if (most > 0.0)
      PetscCall(ReportAddError(report, "u_profile_l2", PetscSqrtReal(sum[0] / p->weight) / most));
    if (most > 0.0 && relative)
      PetscCall(ReportAddError(report, "u_relative_rms", PetscSqrtReal(sum[1] / p->weight)));
    PetscCall(NormsExact(flow, report));
  }
  PetscCall(MeasureCommon(flow, NAN, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}
