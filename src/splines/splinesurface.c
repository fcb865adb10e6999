/*
  Splines at the free surface, which moves through their lattice. A spline with less fluid than a
  share of its support is no unknown: its coefficient is extrapolated from the nearest block of
  splines with enough, p = E q with the weights of Lagrange's polynomials. Each of several fluids
  has splines of its own, which end at its interfaces as at the surface: the pressure jumps there,
  and its gradient follows the density. So the divergence of the others is E^T D, and the gradient
  remains the adjoint. In films and fragments that have no such block the splines with the most
  fluid are unknowns. Of the others those nearest to the surface have the normal stress of the
  layer that its level feels, whose divergence vanishes too: docs/developers/theory.md,
  (strain:layer).

  Source: K. Hoellig, U. Reif, J. Wipper, SIAM J. Numer. Anal. 39 (2001) 442-462
*/
#include "isph/operators.h"
#include "splines.h"

#define SURFACE_ENOUGH 0.9   /* of a spline in the box that is in the fluid or in bodies [-] */
#define SOLID_ENOUGH   0.027 /* in the fluid, as of the spline in the corner of a box */
#define SURFACE_LEAST  1e-3  /* below it a spline has no fluid */
#define LINEAR_LEAST   0.3   /* of splines across thin layers */
#define LAYER_PRODUCTS 2.0   /* of the integrals of layers, in the preconditioner */

/* Computes the parts of the splines that are in fluid f, or in solids if it is negative, over a
   cell. */
static PetscErrorCode Parts(const Particles *p, const Splines *s, const StrainCells *cells,
                            PetscInt f, Vec part)
{
  const PetscBool solid = f < 0 ? PETSC_TRUE : PETSC_FALSE;

  const PetscReal one = PetscPowReal(s->scale, -(PetscReal)p->dim);
  PetscReal       x[ISPH_MAX_DIM], volume;
  SplineRow       at;

  PetscFunctionBegin;
  PetscCall(VecSet(part, 0.0));
  for (PetscInt k = 0; solid ? StrainSolid(s->lattice.scene, cells, k, x, &volume) : k < cells->n;
       k++) {
    for (PetscInt a = 0; !solid && a < p->dim; a++) x[a] = cells->centre[a][k];
    if (!solid) volume = cells->volume[k];
    if (volume == 0.0 || (!solid && !SplineIsOf(s, cells, k, f)) || !ParticlesHolds(p, x)) continue;
    SplineRowAt(s, &s->lattice, p, x, &at);
    for (PetscInt e = 0; e < at.n; e++)
      PetscCall(VecSetValue(part, at.number[e], one * volume * at.value[e], ADD_VALUES));
  }
  PetscCall(VecAssemblyBegin(part));
  PetscCall(VecAssemblyEnd(part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the share of fluid f in all splines, or of solids if it is negative, by their number in
   the order of the lattice. */
static PetscErrorCode Shares(const Particles *p, const Splines *s, const StrainCells *cells,
                             PetscInt f, PetscReal share[])
{
  Vec own;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(s->mass, &own));
  PetscCall(Parts(p, s, cells, f, own));
  PetscCall(VecPointwiseDivide(own, own, s->mass));
  PetscCall(SplineCollect(p, s, own, share));
  PetscCall(VecDestroy(&own));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the piece of fluid f that is nearest to the centre of each spline; -1: none is in it. */
static PetscErrorCode FindPieces(const Particles *p, const Splines *s, const StrainCells *cells,
                                 PetscInt f, PetscInt piece[])
{
  const SplineLattice *l = &s->lattice;
  PetscInt            *of_cell;
  struct {
    double far;
    int    piece;
  } * nearest;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(cells->n, &of_cell, l->N, &nearest));
  PetscCall(StrainPieces(l->scene, p, cells, s->fluids == 1 || f == s->fluids ? -1 : f, of_cell));
  for (PetscInt q = 0; q < l->N; q++) {
    nearest[q].far   = PETSC_MAX_REAL;
    nearest[q].piece = -1;
  }
  for (PetscInt c = 0; c < cells->n; c++) {
    PetscReal    x[ISPH_MAX_DIM];
    SplineValues at;

    if (of_cell[c] < 0 || !SplineIsOf(s, cells, c, f) || !StrainHasCell(p, cells, c, x)) continue;
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

/* Returns true if masters are not all in a row, or in 3D in a plane: their fit is linear. */
static PetscBool AreSpread(PetscInt dim, const SplineSlave *s)
{
  PetscReal mean[ISPH_MAX_DIM] = {0.0}, M[ISPH_MAX_DIM * ISPH_MAX_DIM] = {0.0};

  for (PetscInt m = 0; m < s->n; m++)
    for (PetscInt a = 0; a < dim; a++) mean[a] += (PetscReal)s->step[m][a] / s->n;
  for (PetscInt m = 0; m < s->n; m++)
    for (PetscInt e = 0; e < dim * dim; e++)
      M[e] += (s->step[m][e / dim] - mean[e / dim]) * (s->step[m][e % dim] - mean[e % dim]);
  return DenseCholesky(dim, M) == 0 ? PETSC_TRUE : PETSC_FALSE;
}

/* Adds splines to those with enough fluid where none is near: those with the most around. Layers
   with a single row of them get another: a pressure that is constant across them holds no
   weight. */
static void AddLocal(const SplineLattice *l, const PetscReal share[], const PetscInt piece[],
                     PetscBool enough[], PetscBool add[])
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
  for (PetscInt q = 0; q < l->N; q++) {
    SplineSlave slave;

    add[q] = PETSC_FALSE;
    if (enough[q] || share[q] < LINEAR_LEAST || !SplineNearMasters(l, enough, piece, q, &slave))
      continue;
    add[q] = !AreSpread(l->dim, &slave);
  }
  for (PetscInt q = 0; q < l->N; q++) enough[q] = enough[q] || add[q];
}

/* Computes the extension of the splines of fluid f, and lists the own splines that are no unknowns;
   collective */
static PetscErrorCode ExtendFluid(const Particles *p, const StrainCells *cells, PetscInt f,
                                  Splines *s, Mat *E)
{
  const SplineLattice *l = &s->lattice;
  PetscReal           *share, *solid;
  PetscBool           *enough, *add;
  PetscInt            *piece;

  PetscFunctionBegin;
  PetscCall(PetscMalloc5(l->N, &share, l->N, &solid, l->N, &enough, l->N, &add, l->N, &piece));
  PetscCall(Shares(p, s, cells, f, share));
  PetscCall(Shares(p, s, cells, -1, solid));
  for (PetscInt q = 0; q < l->N; q++)
    enough[q] = share[q] >= SOLID_ENOUGH && share[q] + solid[q] >= SURFACE_ENOUGH;
  PetscCall(FindPieces(p, s, cells, f, piece));
  AddLocal(l, share, piece, enough, add);
  if (f < s->fluids) PetscCall(SplineLayerChoose(p, cells, f, share, enough, s));
  PetscCall(MatCreateAIJ(p->comm, s->own.size, s->own.size, PETSC_DETERMINE, PETSC_DETERMINE, 12,
                         NULL, 12, NULL, E));
  PetscCall(MatSetOption(*E, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
  for (PetscInt k = 0; k < s->own.size; k++) {
    const PetscInt row = s->own.start + k;
    PetscInt       index[ISPH_MAX_DIM], q;
    SplineSlave    slave;

    if (!SplineOwn(s, k, index)) continue;
    q = SplineNatural(l, index);
    if (enough[q]) {
      PetscCall(MatSetValue(*E, row, row, 1.0, INSERT_VALUES));
      continue;
    }
    s->slave[f * s->own.size + k] =
        f < s->fluids && s->layered[f * l->N + q] ? PETSC_FALSE : PETSC_TRUE;
    if (!SplineNearMasters(l, enough, piece, q, &slave)) continue;
    for (PetscInt m = 0; m < slave.n; m++)
      PetscCall(MatSetValue(*E, row, SplinesGlobal(s, p, slave.master[m]), slave.weight[m],
                            INSERT_VALUES));
  }
  PetscCall(SplineMatFinish(*E));
  PetscCall(PetscFree5(share, solid, enough, add, piece));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the extension E of the splines, of each fluid its own, and lists
   the own splines that are no unknowns. Collective. */
static PetscErrorCode ExtendOnSurface(const Particles *p, const StrainCells *cells, Splines *s)
{
  Mat E[SCENE_MAX_FLUIDS + 1];

  PetscFunctionBegin;
  PetscCall(MatDestroy(&s->surface));
  PetscCall(FreeAll(&s->slave, &s->layered));
  PetscCall(PetscCalloc1((s->fluids + 1) * s->own.size, &s->slave));
  PetscCall(PetscCalloc1(s->fluids * s->lattice.N, &s->layered));
  PetscCall(VecDestroy(&s->layer));
  PetscCall(VecDuplicate(s->all, &s->layer));
  PetscCall(VecSet(s->layer, 0.0));
  for (PetscInt f = 0; f < s->fluids; f++) PetscCall(ExtendFluid(p, cells, f, s, &E[f]));
  PetscCall(SplineJoinFluids(s, PETSC_TRUE, E, &s->surface));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the equation q = 0 of splines that are no unknowns, by flags, to a matrix over the splines
   of several fluids. */
static PetscErrorCode UnusedRows(const Splines *s, PetscInt fluids, const PetscBool slave[], Mat A)
{
  const PetscInt     n = fluids * s->own.size;
  const PetscScalar *value;
  Vec                diagonal;
  Mat                rest; /* an entry set in A itself would move all that follow it */

  PetscFunctionBegin;
  PetscCall(MatCreateVecs(A, NULL, &diagonal));
  PetscCall(MatGetDiagonal(A, diagonal));
  PetscCall(MatCreateAIJ(PetscObjectComm((PetscObject)A), n, n, PETSC_DETERMINE, PETSC_DETERMINE, 1,
                         NULL, 0, NULL, &rest));
  PetscCall(VecGetArrayRead(diagonal, &value));
  for (PetscInt k = 0; k < n; k++) {
    const PetscInt row = fluids * s->own.start + k;

    if (slave[k]) PetscCall(MatSetValue(rest, row, row, 1.0 - value[k], INSERT_VALUES));
  }
  for (PetscInt k = 0; k < s->n_unused; k++) {
    const PetscInt own = s->unused[k], row = fluids * s->own.start + own;

    PetscCall(MatSetValue(rest, row, row, 1.0 - value[own], INSERT_VALUES));
  }
  PetscCall(VecRestoreArrayRead(diagonal, &value));
  PetscCall(SplineMatFinish(rest));
  PetscCall(MatAXPY(A, 1.0, rest, DIFFERENT_NONZERO_PATTERN));
  PetscCall(MatDestroy(&rest));
  PetscCall(VecDestroy(&diagonal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the products of extended splines to their integrals over the cells, E^T P^T V P E. Input:
   all - values of the splines of each fluid in its cells. */
static PetscErrorCode ExtendProducts(const Particles *p, Mat all, Mat E, Vec volume,
                                     const Splines *s, Mat *M)
{
  Mat extended, weighted;

  PetscFunctionBegin;
  PetscCall(MatDestroy(M));
  PetscCall(SplineProductMat(all, E, &extended));
  PetscCall(MatDuplicate(extended, MAT_COPY_VALUES, &weighted));
  PetscCall(MatDiagonalScale(weighted, volume, NULL));
  PetscCall(MatScale(weighted, PetscPowReal(s->scale, -(PetscReal)p->dim)));
  PetscCall(SplineGathered(extended, weighted, M));
  PetscCall(MatDestroyAll(&extended, &weighted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Assembles the derivatives of extended splines along an axis in own cells, so that they vanish on
   walls: the gradient in cell c of a velocity with the values psi_q(x_i) at fluid, and 0 at walls,
   is about grad psi_q(x_c) + psi_q(x_c) sum_i g_ci. */
static PetscErrorCode CellSlopesMat(const Particles *p, const Splines *s, const StrainCells *cells,
                                    PetscInt n, PetscInt a, Mat E, Mat *B)
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

    if (!StrainHasCell(p, cells, c, x)) continue;
    SplineRowAt(s, &s->lattice, p, x, &at);
    for (PetscInt e = cells->first[0][c]; e < cells->first[0][c + 1]; e++)
      if (!ParticlesIsWall(p, cells->j[0][e])) wall += cells->g[0][a][e];
    for (PetscInt q = 0; q < at.n; q++) at.gradient[a][q] += wall * at.value[q];
    PetscCall(MatSetValues(slopes, 1, &row, at.n, at.number, at.gradient[a], ADD_VALUES));
    row++;
  }
  PetscCall(SplineMatFinish(slopes));
  PetscCall(SplineProductMat(slopes, E, B));
  PetscCall(MatDestroy(&slopes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the values of extended splines at own fluid, and the stiffness of velocities on them,
   sum_c V_c nu_c/nu_0 grad psi . grad psi over the volume of a cell [1/m^2]. */
static PetscErrorCode VelocitiesOnSplines(const Scene *scene, const Particles *p,
                                          const StrainCells *cells, PetscInt n, Mat E, Vec volume,
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
  PetscCall(SplineProductMat(values, E, &s->values));
  PetscCall(MatDestroy(&values));
  PetscCall(VecDuplicate(volume, &factor));
  PetscCall(VecCopy(volume, factor));
  PetscCall(VecGetArray(factor, &weight));
  for (PetscInt c = 0; c < cells->n; c++)
    if (StrainHasCell(p, cells, c, x)) weight[row++] *= cells->nu[c] / scene->nu;
  PetscCall(VecRestoreArray(factor, &weight));
  PetscCall(VecScale(factor, PetscPowReal(s->scale, -(PetscReal)p->dim)));
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(CellSlopesMat(p, s, cells, n, a, E, &B));
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
  PetscCall(UnusedRows(s, s->fluids, s->slave, s->K));
  s->products++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes data of the preconditioner of velocities, whose splines all fluids share. Input: all -
   values of splines in own cells. */
static PetscErrorCode JoinVelocities(const Flow *flow, PetscInt n, Mat all, Vec volume, Splines *s)
{
  const Particles   *p     = flow->particles;
  const StrainCells *cells = flow->ops->strain;
  Mat                E     = s->surface;

  PetscFunctionBegin;
  if (s->fluids > 1) {
    PetscCall(ExtendFluid(p, cells, s->fluids, s, &E));
    PetscCall(ExtendProducts(p, all, E, volume, s, &s->joint));
    PetscCall(UnusedRows(s, 1, s->slave + s->fluids * s->own.size, s->joint));
  }
  PetscCall(VelocitiesOnSplines(flow->scene, p, cells, n, E, volume, s));
  if (s->fluids > 1) PetscCall(MatDestroy(&E));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineSurfaceRows - Computes the rows of the divergence of the splines of each fluid at the free
   surface, E^T D, and data of preconditioners; collective. Input: n - own cells; of_fluid - values
   of splines in the cells of each, and in all; T - V_c div u by velocities of fluid and walls. */
PetscErrorCode SplineSurfaceRows(const Flow *flow, PetscInt n, const Mat of_fluid[], const Mat T[2],
                                 Splines *s)
{
  const Particles   *p     = flow->particles;
  const StrainCells *cells = flow->ops->strain;
  Mat                part[SCENE_MAX_FLUIDS + 1], all, D;
  Vec                volume;

  PetscFunctionBegin;
  PetscCall(SplineCellVolumes(p, cells, of_fluid[0], &volume));
  PetscCall(ExtendOnSurface(p, cells, s));
  for (PetscInt w = 0; w < 2; w++) {
    if (!T[w]) continue;
    for (PetscInt f = 0; f < s->fluids; f++) PetscCall(SplineGathered(of_fluid[f], T[w], &part[f]));
    PetscCall(SplineJoinFluids(s, PETSC_FALSE, part, &D));
    PetscCall(SplineGathered(s->surface, D, &s->cut[1 + w]));
    PetscCall(MatDestroy(&D));
    PetscCall(SplineLayersAdd(p, s, cells, 1.0, PETSC_FALSE, w == 1, &s->cut[1 + w]));
  }
  all = of_fluid[0];
  if (s->fluids > 1) {
    PetscCall(MatCreateNest(p->comm, 1, NULL, s->fluids, NULL, of_fluid, &D));
    PetscCall(MatConvert(D, MATAIJ, MAT_INITIAL_MATRIX, &all));
    PetscCall(MatDestroy(&D));
  }
  if (s->has_products) {
    PetscCall(ExtendProducts(p, all, s->surface, volume, s, &s->M));
    PetscCall(UnusedRows(s, s->fluids, s->slave, s->M));
    PetscCall(SplineLayersAdd(p, s, cells, LAYER_PRODUCTS, PETSC_TRUE, PETSC_FALSE, &s->M));
  }
  if (s->fluids > 1) PetscCall(MatDestroy(&all));
  if (s->has_products && p->dim == 3)
    PetscCall(JoinVelocities(flow, n, of_fluid[s->fluids == 1 ? 0 : s->fluids], volume, s));
  PetscCall(VecDestroy(&volume));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineSurfaceFill - Sets the coefficients of splines that are no unknowns; collective */
PetscErrorCode SplineSurfaceFill(Splines *s, Vec p)
{
  Vec all;

  PetscFunctionBegin;
  if (!s->surface) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecCopy(p, s->layer));
  PetscCall(VecShift(s->layer, -s->lattice.scene->level));
  PetscCall(VecDuplicate(p, &all));
  PetscCall(MatMult(s->surface, p, all));
  PetscCall(VecCopy(all, p));
  PetscCall(VecDestroy(&all));
  PetscFunctionReturn(PETSC_SUCCESS);
}
