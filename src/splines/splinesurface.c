/*
  Splines at the free surface, which moves through their lattice. A spline with less fluid than a
  share of its support is no unknown: its coefficient is extrapolated from the nearest block of
  splines with enough, p = E q with the weights of Lagrange's polynomials. So the divergence of the
  others is E^T D, and the gradient remains the adjoint. In films and fragments that have no such
  block the splines with the most fluid are unknowns.

  Source: K. Hoellig, U. Reif, J. Wipper, SIAM J. Numer. Anal. 39 (2001) 442-462
*/
#include "isph/operators.h"
#include "splines.h"

#define SURFACE_ENOUGH 0.9   /* of a spline in the box that is in the fluid or in bodies [-] */
#define SOLID_ENOUGH   0.027 /* in the fluid, as of the spline in the corner of a box */
#define SURFACE_LEAST  1e-3  /* below it a spline has no fluid */

/* Computes the parts of the splines that are in the fluid, or in solids, over a cell. */
static PetscErrorCode Parts(const Particles *p, const Splines *s, const StrainCells *cells,
                            PetscBool solid, Vec part)
{
  const PetscReal one = PetscPowReal(s->scale, -(PetscReal)p->dim);
  PetscReal       x[ISPH_MAX_DIM], volume;
  SplineRow       at;

  PetscFunctionBegin;
  PetscCall(VecSet(part, 0.0));
  for (PetscInt k = 0; solid ? StrainSolid(s->lattice.scene, cells, k, x, &volume) : k < cells->n;
       k++) {
    for (PetscInt a = 0; !solid && a < p->dim; a++) x[a] = cells->centre[a][k];
    if (!solid) volume = cells->volume[k];
    if (volume == 0.0 || !ParticlesHolds(p, x)) continue;
    SplineRowAt(s, &s->lattice, p, x, &at);
    for (PetscInt e = 0; e < at.n; e++)
      PetscCall(VecSetValue(part, at.number[e], one * volume * at.value[e], ADD_VALUES));
  }
  PetscCall(VecAssemblyBegin(part));
  PetscCall(VecAssemblyEnd(part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the share of the fluid in all splines, or of solids, by their number in the order of the
   lattice. */
static PetscErrorCode Shares(const Particles *p, const Splines *s, const StrainCells *cells,
                             PetscBool solid, PetscReal share[])
{
  const SplineLattice *l = &s->lattice;
  const PetscScalar   *from;
  VecScatter           collect;
  Vec                  own, all;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(s->mass, &own));
  PetscCall(Parts(p, s, cells, solid, own));
  PetscCall(VecPointwiseDivide(own, own, s->mass));
  PetscCall(VecScatterCreateToAll(own, &collect, &all));
  PetscCall(VecScatterBegin(collect, own, all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(collect, own, all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGetArrayRead(all, &from));
  for (PetscInt q = 0; q < l->N; q++) {
    PetscInt index[ISPH_MAX_DIM];

    SplineIndex(l->dim, NULL, l->count, q, index);
    share[q] = PetscRealPart(from[SplinesGlobal(s, p, index)]);
  }
  PetscCall(VecRestoreArrayRead(all, &from));
  PetscCall(VecScatterDestroy(&collect));
  PetscCall(VecDestroy(&own));
  PetscCall(VecDestroy(&all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the piece of the fluid that is nearest to the centre of each spline; -1: none is in it. */
static PetscErrorCode FindPieces(const Particles *p, const Splines *s, const StrainCells *cells,
                                 PetscInt piece[])
{
  const SplineLattice *l = &s->lattice;
  PetscInt            *of_cell;
  struct {
    double far;
    int    piece;
  } * nearest;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(cells->n, &of_cell, l->N, &nearest));
  PetscCall(StrainPieces(l->scene, p, cells, of_cell));
  for (PetscInt q = 0; q < l->N; q++) {
    nearest[q].far   = PETSC_MAX_REAL;
    nearest[q].piece = -1;
  }
  for (PetscInt c = 0; c < cells->n; c++) {
    PetscReal    x[ISPH_MAX_DIM];
    SplineValues at;

    for (PetscInt a = 0; a < p->dim; a++) x[a] = cells->centre[a][c];
    if (of_cell[c] < 0 || !ParticlesHolds(p, x)) continue;
    SplinesAt(l, x, &at);
    for (PetscInt k = 0; k < at.n; k++) { /* the largest value is the nearest */
      const PetscInt q = SplineNatural(l, at.index[k]);

      if (-at.value[k] >= nearest[q].far) continue;
      nearest[q].far   = -at.value[k];
      nearest[q].piece = (int)of_cell[c];
    }
  }
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, nearest, (int)l->N, MPI_DOUBLE_INT, MPI_MINLOC, p->comm));
  for (PetscInt q = 0; q < l->N; q++) piece[q] = nearest[q].piece;
  PetscCall(PetscFree2(of_cell, nearest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds splines to those with enough fluid where none is near: those with the most around. */
static void AddLocal(const SplineLattice *l, const PetscReal share[], const PetscInt piece[],
                     PetscBool enough[])
{
  PetscBool more = PETSC_TRUE;

  while (more) {
    PetscInt best = -1;

    for (PetscInt q = 0; q < l->N; q++) {
      SplineSlave slave;

      if (enough[q] || share[q] < SURFACE_LEAST || (best >= 0 && share[q] <= share[best])) continue;
      if (!SplineNearMasters(l, enough, piece, q, &slave)) best = q;
    }
    more = best >= 0;
    if (more) enough[best] = PETSC_TRUE;
  }
}

/*
  SplineSurfaceExtend - Computes the extension E of the splines, and lists the own splines that are
  no unknowns

  Collective
*/
PetscErrorCode SplineSurfaceExtend(const Particles *p, const StrainCells *cells, Splines *s)
{
  const SplineLattice *l = &s->lattice;
  PetscReal           *share, *solid;
  PetscBool           *enough;
  PetscInt            *piece;

  PetscFunctionBegin;
  PetscCall(PetscMalloc4(l->N, &share, l->N, &solid, l->N, &enough, l->N, &piece));
  PetscCall(Shares(p, s, cells, PETSC_FALSE, share));
  PetscCall(Shares(p, s, cells, PETSC_TRUE, solid));
  for (PetscInt q = 0; q < l->N; q++)
    enough[q] = share[q] >= SOLID_ENOUGH && share[q] + solid[q] >= SURFACE_ENOUGH;
  PetscCall(FindPieces(p, s, cells, piece));
  AddLocal(l, share, piece, enough);
  PetscCall(MatDestroy(&s->surface));
  PetscCall(PetscFree(s->slave));
  PetscCall(PetscCalloc1(s->own.size, &s->slave));
  PetscCall(MatCreateAIJ(p->comm, s->own.size, s->own.size, PETSC_DETERMINE, PETSC_DETERMINE, 12,
                         NULL, 12, NULL, &s->surface));
  PetscCall(MatSetOption(s->surface, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
  for (PetscInt k = 0; k < s->own.size; k++) {
    const PetscInt row = s->own.start + k;
    PetscInt       index[ISPH_MAX_DIM], q;
    SplineSlave    slave;

    if (!SplineOwn(s, k, index)) continue;
    q = SplineNatural(l, index);
    if (enough[q]) {
      PetscCall(MatSetValue(s->surface, row, row, 1.0, INSERT_VALUES));
      continue;
    }
    s->slave[k] = PETSC_TRUE;
    if (!SplineNearMasters(l, enough, piece, q, &slave)) continue;
    for (PetscInt m = 0; m < slave.n; m++)
      PetscCall(MatSetValue(s->surface, row, SplinesGlobal(s, p, slave.master[m]), slave.weight[m],
                            INSERT_VALUES));
  }
  PetscCall(SplineMatFinish(s->surface));
  PetscCall(PetscFree4(share, solid, enough, piece));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineSurfaceRows - Adds the equation q = 0 of splines that are no unknowns to a matrix;
   collective */
PetscErrorCode SplineSurfaceRows(const Splines *s, Mat A)
{
  Vec diagonal;

  PetscFunctionBegin;
  PetscCall(MatCreateVecs(A, NULL, &diagonal));
  PetscCall(MatGetDiagonal(A, diagonal));
  for (PetscInt k = 0; k < s->own.size; k++)
    if (s->slave[k]) PetscCall(VecSetValue(diagonal, s->own.start + k, 1.0, INSERT_VALUES));
  PetscCall(VecAssemblyBegin(diagonal));
  PetscCall(VecAssemblyEnd(diagonal));
  PetscCall(MatSetOption(A, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
  PetscCall(MatDiagonalSet(A, diagonal, INSERT_VALUES));
  PetscCall(VecDestroy(&diagonal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineSurfaceFill - Sets the coefficients of splines that are no unknowns; collective */
PetscErrorCode SplineSurfaceFill(const Splines *s, Vec p)
{
  Vec all;

  PetscFunctionBegin;
  if (!s->surface) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecDuplicate(p, &all));
  PetscCall(MatMult(s->surface, p, all));
  PetscCall(VecCopy(all, p));
  PetscCall(VecDestroy(&all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SplineSurfaceTension - Computes the force of the tension of the free surface, and adds its change
  in a step to the viscous matrix

  Collective. Output: state->interface - force per unit mass [m/s^2]; state->tension_energy.
*/
PetscErrorCode SplineSurfaceTension(Flow *flow)
{
  const Scene       *scene  = flow->scene;
  const Particles   *p      = flow->particles;
  const StrainCells *cells  = flow->ops->strain;
  AffineOperator    *visc   = &flow->ops->velocity[0].visc;
  PetscReal *const   mass[] = {p->volume, p->volume, p->volume};
  PetscReal         *force, area;
  PetscScalar       *to;
  Mat                Q, back, K;

  PetscFunctionBegin;
  if (scene->tension == 0.0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FlowStateRenumber(flow));
  PetscCall(PetscCalloc1(p->dim * p->n_fluid, &force));
  PetscCall(StrainTension(p, cells, force, &area));
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(VecGetArrayWrite(flow->state->interface[a], &to));
    for (PetscInt i = 0; i < p->n_fluid; i++)
      to[i] = scene->tension / scene->rho * force[p->dim * i + a] / p->volume[i];
    PetscCall(VecRestoreArrayWrite(flow->state->interface[a], &to));
  }
  PetscCall(PetscFree(force));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &area, 1, MPIU_REAL, MPIU_SUM, p->comm));
  flow->state->tension_energy =
      2.0 * scene->tension * area / (scene->rho * p->weight * p->cell_volume);
  PetscCall(StrainTensionSlopes(p, cells, &Q));
  PetscCall(MatTranspose(Q, MAT_INITIAL_MATRIX, &back));
  PetscCall(MatMatMult(back, Q, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &K));
  PetscCall(MatProductClear(K));
  PetscCall(
      VelocityRowsDivide(p, mass, -flow->clock->dt * scene->tension / (scene->rho * scene->nu), K));
  PetscCall(SparseAdd(K, &visc->A));
  PetscCall(MatDestroy(&K));
  PetscCall(MatDestroy(&back));
  PetscCall(MatDestroy(&Q));
  PetscFunctionReturn(PETSC_SUCCESS);
}
