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
  PetscCall(VecDestroyAll(&own, &all));
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

/* SplineSurfaceExtend - Computes the extension E of the splines, and lists the own splines that are
   no unknowns. Collective. */
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

/* Adds the equation q = 0 of splines that are no unknowns to a matrix. */
static PetscErrorCode UnusedRows(const Splines *s, Mat A)
{
  const PetscScalar *value;
  Vec                diagonal;
  Mat                rest; /* an entry set in A itself would move all that follow it */

  PetscFunctionBegin;
  PetscCall(MatCreateVecs(A, NULL, &diagonal));
  PetscCall(MatGetDiagonal(A, diagonal));
  PetscCall(MatCreateAIJ(PetscObjectComm((PetscObject)A), s->own.size, s->own.size, PETSC_DETERMINE,
                         PETSC_DETERMINE, 1, NULL, 0, NULL, &rest));
  PetscCall(VecGetArrayRead(diagonal, &value));
  for (PetscInt k = 0; k < s->own.size; k++) {
    const PetscInt row = s->own.start + k;

    if (s->slave[k]) PetscCall(MatSetValue(rest, row, row, 1.0 - value[k], INSERT_VALUES));
  }
  for (PetscInt k = 0; k < s->n_unused; k++) {
    const PetscInt own = s->unused[k], row = s->own.start + own;

    PetscCall(MatSetValue(rest, row, row, 1.0 - value[own], INSERT_VALUES));
  }
  PetscCall(VecRestoreArrayRead(diagonal, &value));
  PetscCall(SplineMatFinish(rest));
  PetscCall(MatAXPY(A, 1.0, rest, DIFFERENT_NONZERO_PATTERN));
  PetscCall(MatDestroy(&rest));
  PetscCall(VecDestroy(&diagonal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the products of extended splines to their integrals over the cells, E^T P^T V P E. */
static PetscErrorCode ExtendProducts(const Particles *p, Mat all, Vec volume, Splines *s)
{
  Mat extended, weighted;

  PetscFunctionBegin;
  PetscCall(MatDestroy(&s->M));
  PetscCall(SplineProductMat(all, s->surface, &extended));
  PetscCall(MatDuplicate(extended, MAT_COPY_VALUES, &weighted));
  PetscCall(MatDiagonalScale(weighted, volume, NULL));
  PetscCall(MatScale(weighted, PetscPowReal(s->scale, -(PetscReal)p->dim)));
  PetscCall(SplineGathered(extended, weighted, &s->M));
  PetscCall(UnusedRows(s, s->M));
  PetscCall(MatDestroyAll(&extended, &weighted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Assembles the derivatives of extended splines along an axis in own cells, so that they vanish on
   walls: the gradient in cell c of a velocity with the values psi_q(x_i) at fluid, and 0 at walls,
   is about grad psi_q(x_c) + psi_q(x_c) sum_i g_ci. */
static PetscErrorCode CellSlopesMat(const Particles *p, const Splines *s, const StrainCells *cells,
                                    PetscInt n, PetscInt a, Mat *B)
{
  PetscInt  row, *width;
  PetscReal x[ISPH_MAX_DIM];
  Mat       slopes;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n, &width));
  for (PetscInt k = 0; k < n; k++) width[k] = SplinesAtPoint(&s->lattice);
  PetscCall(SplineMat(p->comm, n, s->own.size, width, &slopes));
  PetscCall(PetscFree(width));
  PetscCall(MatGetOwnershipRange(slopes, &row, NULL));
  for (PetscInt c = 0; c < cells->n; c++) {
    SplineRow at;
    PetscReal wall = 0.0;

    if (!SplineHasCell(p, cells, c, x)) continue;
    SplineRowAt(s, &s->lattice, p, x, &at);
    for (PetscInt e = cells->first[0][c]; e < cells->first[0][c + 1]; e++)
      if (!ParticlesIsWall(p, cells->j[0][e])) wall += cells->g[0][a][e];
    for (PetscInt q = 0; q < at.n; q++) at.gradient[a][q] += wall * at.value[q];
    PetscCall(MatSetValues(slopes, 1, &row, at.n, at.number, at.gradient[a], ADD_VALUES));
    row++;
  }
  PetscCall(SplineMatFinish(slopes));
  PetscCall(SplineProductMat(slopes, s->surface, B));
  PetscCall(MatDestroy(&slopes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the values of extended splines at own fluid, and the stiffness of velocities on them,
   sum_c V_c nu_c/nu_0 grad psi . grad psi over the volume of a cell [1/m^2]. */
static PetscErrorCode VelocitiesOnSplines(const Scene *scene, const Particles *p,
                                          const StrainCells *cells, PetscInt n, Vec volume,
                                          Splines *s)
{
  PetscScalar *weight;
  PetscInt     row = 0, *width;
  PetscReal    x[ISPH_MAX_DIM];
  Mat          values, B, weighted, part;
  Vec          factor;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(p->n_fluid, &width));
  for (PetscInt i = 0; i < p->n_fluid; i++) width[i] = SplinesAtPoint(&s->lattice);
  PetscCall(SplineMat(p->comm, p->n_fluid, s->own.size, width, &values));
  PetscCall(PetscFree(width));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    SplineRow at;

    for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
    SplineRowAt(s, &s->lattice, p, x, &at);
    PetscCall(MatSetValues(values, 1, &p->row[i], at.n, at.number, at.value, ADD_VALUES));
  }
  PetscCall(SplineMatFinish(values));
  PetscCall(SplineProductMat(values, s->surface, &s->values));
  PetscCall(MatDestroy(&values));
  PetscCall(VecDuplicate(volume, &factor));
  PetscCall(VecCopy(volume, factor));
  PetscCall(VecGetArray(factor, &weight));
  for (PetscInt c = 0; c < cells->n; c++)
    if (SplineHasCell(p, cells, c, x)) weight[row++] *= cells->nu[c] / scene->nu;
  PetscCall(VecRestoreArray(factor, &weight));
  PetscCall(VecScale(factor, PetscPowReal(s->scale, -(PetscReal)p->dim)));
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(CellSlopesMat(p, s, cells, n, a, &B));
    PetscCall(MatDuplicate(B, MAT_COPY_VALUES, &weighted));
    PetscCall(MatDiagonalScale(weighted, factor, NULL));
    PetscCall(SplineGathered(B, weighted, a ? &part : &s->slopes));
    PetscCall(MatDestroyAll(&weighted, &B));
    if (!a) continue;
    PetscCall(MatAXPY(s->slopes, 1.0, part, SAME_NONZERO_PATTERN));
    PetscCall(MatDestroy(&part));
  }
  PetscCall(VecDestroy(&factor));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineSurfaceStiffness - Sets the stiffness to that of the fluid below the free surface,
   -scale^2 D G; collective */
PetscErrorCode SplineSurfaceStiffness(Splines *s)
{
  PetscFunctionBegin;
  PetscCall(MatDestroy(&s->K));
  PetscCall(SplineProductMat(s->cut[1], s->cut[0], &s->K));
  PetscCall(MatScale(s->K, -PetscSqr(s->scale)));
  PetscCall(UnusedRows(s, s->K));
  s->products++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineSurfaceRows - Replaces the rows of splines at the free surface by E^T D, and computes data
   of preconditioners; collective. Input: n - own cells; all - values of splines in them. */
PetscErrorCode SplineSurfaceRows(const Flow *flow, PetscInt n, Mat all, Splines *s)
{
  const Particles   *p     = flow->particles;
  const StrainCells *cells = flow->ops->strain;
  Vec                volume;
  Mat                D;

  PetscFunctionBegin;
  PetscCall(SplineCellVolumes(p, cells, all, &volume));
  PetscCall(SplineSurfaceExtend(p, cells, s));
  if (s->has_products) PetscCall(ExtendProducts(p, all, volume, s));
  if (s->has_products && p->dim == 3)
    PetscCall(VelocitiesOnSplines(flow->scene, p, cells, n, volume, s));
  PetscCall(VecDestroy(&volume));
  for (PetscInt k = 1; k < 3; k++) {
    if (!s->cut[k]) continue;
    PetscCall(SplineGathered(s->surface, s->cut[k], &D));
    PetscCall(MatDestroy(&s->cut[k]));
    s->cut[k] = D;
  }
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

/* Adds a matrix to one that may have products only. */
static PetscErrorCode AddMatrix(Mat X, Mat *Y)
{
  PetscBool products;
  Mat       sum;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)*Y, MATSHELL, &products));
  if (!products) {
    PetscCall(SparseAdd(X, Y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MatCreateComposite(PetscObjectComm((PetscObject)X), 2, (Mat[]){*Y, X}, &sum));
  PetscCall(MatDestroy(Y));
  *Y = sum;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the area of the sides across an axis [m^(dim-1)]. */
static PetscReal BoxArea(const Scene *scene, PetscInt axis)
{
  PetscReal area = 1.0;

  for (PetscInt a = 0; a < scene->dim; a++) area *= a == axis ? 1.0 : scene->hi[a] - scene->lo[a];
  return area;
}

/* SplineSurfaceTension - Computes the force of the tension of the free surface, and adds its change
   in a step to the viscous matrix. Collective. Output: state->interface - force per unit mass
   [m/s^2]; state->tension_energy. */
PetscErrorCode SplineSurfaceTension(Flow *flow)
{
  const Scene       *scene  = flow->scene;
  const Particles   *p      = flow->particles;
  const StrainCells *cells  = flow->ops->strain;
  AffineOperator    *visc   = &flow->ops->velocity[0].visc;
  PetscReal *const   mass[] = {p->volume, p->volume, p->volume};
  PetscReal         *force, area;
  PetscScalar       *to;
  Mat                K;

  PetscFunctionBegin;
  if (scene->tension == 0.0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FlowStateRenumber(flow));
  PetscCall(PetscCalloc1(p->dim * p->n_fluid, &force));
  PetscCall(StrainTension(scene, p, cells, force, &area));
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(VecGetArrayWrite(flow->state->interface[a], &to));
    for (PetscInt i = 0; i < p->n_fluid; i++)
      to[i] = scene->tension / scene->rho * force[p->dim * i + a] / p->volume[i];
    PetscCall(VecRestoreArrayWrite(flow->state->interface[a], &to));
  }
  PetscCall(PetscFree(force));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &area, 1, MPIU_REAL, MPIU_SUM, p->comm));
  for (PetscInt side = 0; side < 2 * p->dim; side++) /* dry walls that fluid wets have energy */
    area += PetscMax(scene->boundary[side].contact, 0.0) * BoxArea(scene, side / 2);
  flow->state->tension_energy =
      2.0 * scene->tension * area / (scene->rho * p->weight * p->cell_volume);
  PetscCall(StrainTensionMatrix(p, cells, &K));
  PetscCall(
      VelocityRowsDivide(p, mass, -flow->clock->dt * scene->tension / (scene->rho * scene->nu), K));
  if (SceneViscosityVaries(scene) && p->dim == 2) {
    PetscCall(PetscObjectReference((PetscObject)K));
    flow->ops->cut_part[0] = visc->A;
    flow->ops->cut_part[1] = K;
    PetscCall(MatDuplicate(flow->ops->cut_part[0], MAT_COPY_VALUES, &visc->A));
  }
  PetscCall(AddMatrix(K, &visc->A));
  PetscCall(MatDestroy(&K));
  PetscFunctionReturn(PETSC_SUCCESS);
}
