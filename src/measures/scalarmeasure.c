/* Scalars in the report. */
#include "isph/io.h"
#include "schemes/scalars/scalars.h"

/* Adds a quantity that has the name of the scalar first. */
static PetscErrorCode Add(Report *report, const Scalar *s, const char what[], PetscReal value)
{
  char name[96];

  PetscFunctionBegin;
  (void)snprintf(name, sizeof(name), "%s_%s", s->given->name, what);
  PetscCall(ReportAdd(report, name, value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the relative error of a scalar against its reference solution, in the L2 norm. */
static PetscErrorCode MeasureError(const Flow *flow, const Scalar *s, Report *report)
{
  const Particles *p      = flow->particles;
  const PetscReal  t      = ClockMoment(flow->clock);
  PetscReal        sum[2] = {0.0, 0.0};
  char             name[96];

  PetscFunctionBegin;
  if (!s->given->exact.n) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0}, exact;

    for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
    exact = ExpressionValue(&s->given->exact, 0, t, x);
    sum[0] += ScalarVolumes(flow)[i] * PetscSqr(s->c[i] - exact);
    sum[1] += ScalarVolumes(flow)[i] * PetscSqr(exact);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, p->comm));
  (void)snprintf(name, sizeof(name), "%s_l2", s->given->name);
  PetscCall(ReportAddError(report, name, PetscSqrtReal(sum[1] > 0.0 ? sum[0] / sum[1] : sum[0])));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ScalarsMeasure - Adds the scalars to the report: of each its mean, least and largest value, its
   error against the reference solution, and what enters per time through boundaries with a law.
   Collective. */
PetscErrorCode ScalarsMeasure(const Flow *flow, Report *report)
{
  const Scalars   *all = flow->state->scalars;
  const Particles *p   = flow->particles;

  PetscFunctionBegin;
  for (PetscInt k = 0; all && k < all->n; k++) {
    const Scalar *s = &all->scalar[k];
    PetscReal     amount[2], bound[2] = {-PETSC_INFINITY, -PETSC_INFINITY};

    for (PetscInt i = 0; i < p->n_fluid; i++) {
      bound[0] = PetscMax(bound[0], -s->c[i]);
      bound[1] = PetscMax(bound[1], s->c[i]);
    }
    PetscCall(ScalarAmount(flow, s->c, amount));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, bound, 2, MPIU_REAL, MPIU_MAX, p->comm));
    PetscCall(Add(report, s, "mean", amount[0] / amount[1]));
    PetscCall(Add(report, s, "min", -bound[0]));
    PetscCall(Add(report, s, "max", bound[1]));
    PetscCall(MeasureError(flow, s, report));
    for (PetscInt side = 0; s->active && side <= SceneBoundaries(flow->scene); side++) {
      char wall[WALL_NAME], what[48];

      if (!s->law[side]) continue;
      ScalarBoundaryName(flow->scene, side, wall);
      (void)snprintf(what, sizeof(what), "flux_%s", wall);
      PetscCall(Add(report, s, what, s->entering[side]));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
