/*
  Pressures whose columns of G oppose their equations. The equation of mass of particle j acts on
  velocities by its reaction,

    (grad p)_ia = -1/V_i V_j D_j,ia p_j

  G of fits is more accurate, but no equation has the reaction as its column of G. Beside rough
  surfaces and walls, where neighbours are few or lie on one side, a column may be across the
  reaction or oppose it. The equation is then met by a flow that its pressure drives, and not by the
  least change of the flow: the coupled system has an eigenvalue of the wrong sign. Such a column is
  replaced: by the reaction inside the fluid, and on a surface, where q = Z u, by the force along
  the normal on the particle itself. The rows of rough particles are those of the reactions, as pair
  forces and fits together may drive a flow. With -coupled_gradient adjoint all equations of mass
  have their reactions, and with -coupled_gradient natural those of particles off walls: pair forces
  and reactions together have no stress on a free surface. See theory.md, (surface:adjoint),
  (surface:share), (surface:work) and (surface:natural) and (surface:rough).
*/
#include "saddle.h"

#define OBLIQUE 0.25 /* least cosine between a column of G and its row of -D or Z */
#define ALIGNED 0.9  /* least cosine between their parts of the particle itself, on surfaces */

/* Computes the transposed reactions in the units of the blocks: row j has -V_j D_j,ia T_i/(V_i
   T_j), on surfaces a positive multiple of Z. Input: momentum - T_i/T of momentum rows. */
static PetscErrorCode CreateReactions(const Flow *flow, Vec momentum, const Saddle *s,
                                      Mat *reactions)
{
  const Particles *p = flow->particles;
  PetscScalar     *mass, *velocity;
  Vec              of_mass, of_velocity, columns;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(s->pressure, &of_mass));
  PetscCall(VecDuplicate(s->pressure, &of_velocity));
  PetscCall(VecDuplicate(momentum, &columns));
  PetscCall(VecCopy(s->pressure, of_mass));
  PetscCall(VecGetArray(of_mass, &mass));
  PetscCall(VecGetArrayWrite(of_velocity, &velocity));
  for (PetscInt i = 0; i < s->n; i++) {
    mass[i] *= p->volume[i] * flow->scene->dx / p->dx[i];
    velocity[i] = -1.0 / (p->volume[i] * LaplacianShare(&flow->ops->forms.visc, i));
  }
  PetscCall(VecRestoreArray(of_mass, &mass));
  PetscCall(VecRestoreArrayWrite(of_velocity, &velocity));
  for (PetscInt c = 0; c < s->dim; c++)
    PetscCall(VecStrideScatter(of_velocity, c, columns, INSERT_VALUES));
  PetscCall(VecPointwiseMult(columns, columns, momentum));
  PetscCall(MatDuplicate(s->D, MAT_COPY_VALUES, reactions));
  PetscCall(MatDiagonalScale(*reactions, of_mass, columns));
  PetscCall(VecDestroy(&columns));
  PetscCall(VecDestroy(&of_velocity));
  PetscCall(VecDestroy(&of_mass));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the cosine of two vectors from their products; 1 if one of them vanishes. */
static PetscReal Cosine(PetscReal aa, PetscReal ab, PetscReal bb)
{
  return aa > 0.0 && bb > 0.0 ? ab / PetscSqrtReal(aa * bb) : 1.0;
}

/* Computes the cosine between row `row` of A and of B, and that between their entries of particle
   `row` alone; 1 if a row vanishes. */
static PetscErrorCode RowCosines(PetscInt dim, Mat A, Mat B, PetscInt row, PetscReal cosine[])
{
  const PetscInt    *i, *j;
  const PetscScalar *a, *b;
  PetscInt           m, n;
  PetscReal          aa[2] = {0.0, 0.0}, ab[2] = {0.0, 0.0}, bb[2] = {0.0, 0.0};

  PetscFunctionBegin;
  PetscCall(MatGetRow(A, row, &m, &i, &a));
  PetscCall(MatGetRow(B, row, &n, &j, &b));
  for (PetscInt k = 0; k < m; k++) {
    aa[0] += PetscSqr(a[k]);
    if (i[k] / dim == row) aa[1] += PetscSqr(a[k]);
  }
  for (PetscInt k = 0, l = 0; k < n; k++) { /* columns ascend */
    bb[0] += PetscSqr(b[k]);
    if (j[k] / dim == row) bb[1] += PetscSqr(b[k]);
    while (l < m && i[l] < j[k]) l++;
    if (l == m || i[l] > j[k]) continue;
    ab[0] += a[l] * b[k];
    if (j[k] / dim == row) ab[1] += a[l] * b[k];
  }
  PetscCall(MatRestoreRow(B, row, &n, &j, &b));
  PetscCall(MatRestoreRow(A, row, &m, &i, &a));
  for (PetscInt e = 0; e < 2; e++) cosine[e] = Cosine(aa[e], ab[e], bb[e]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Replaces rows of the reactions by the forces of pressures on their own surface particles: that on
   the face of a cell, n p/(rho dx_i), which is n in the units of the blocks. */
static PetscErrorCode SetNormalForces(const FreeSurface *free, PetscInt dim, PetscInt n,
                                      const PetscInt rows[], Mat reactions)
{
  PetscInt first;

  PetscFunctionBegin;
  PetscCall(MatGetOwnershipRange(reactions, &first, NULL));
  PetscCall(MatSetOption(reactions, MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE));
  PetscCall(MatZeroRows(reactions, n, rows, 0.0, NULL, NULL));
  for (PetscInt r = 0; r < n; r++) {
    const PetscReal *normal = &free->normal[(rows[r] - first) * dim];

    for (PetscInt a = 0; a < dim; a++)
      PetscCall(MatSetValue(reactions, rows[r], dim * rows[r] + a, normal[a], INSERT_VALUES));
  }
  PetscCall(MatAssemblyBegin(reactions, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(reactions, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if a side along which the fluid slides, or an inflow, is within the support of own
   particle i. G has no condition there, and D and Z have one: they differ even where particles are
   even. At an outflow D has none in fluids with a free surface. */
static PetscBool IsBesideSlip(const Flow *flow, PetscInt i)
{
  const Particles *p = flow->particles;
  WallPlane        planes[WALL_PLANES];
  PetscReal        x[ISPH_MAX_DIM];
  PetscInt         n;

  for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
  SceneWallPlanes(flow->scene, x, flow->ops->forms.radius, planes, &n);
  for (PetscInt k = 0; k < n; k++)
    if (!BoundaryIs(flow->scene, planes[k].side, BOUNDARY_NO_SLIP) &&
        !BoundaryIs(flow->scene, planes[k].side, BOUNDARY_OUTFLOW))
      return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Returns true if the column of own particle i stays whatever its cosine is: beside a side along
   which the fluid slides or enters, and away from free surfaces, as in a fluid without one. Beside
   corners of walls and inflows a reaction would have an error as large as the pressure. */
static PetscBool KeepsColumn(const Flow *flow, PetscInt i)
{
  return IsBesideSlip(flow, i) || !OperatorsBesideSurface(flow->ops, i);
}

/* Scales the columns of the transposed G and of the reactions by factors of momentum rows. */
static PetscErrorCode ScaleBoth(Vec factors, Mat GT, Mat reactions)
{
  PetscFunctionBegin;
  PetscCall(MatDiagonalScale(GT, NULL, factors));
  PetscCall(MatDiagonalScale(reactions, NULL, factors));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets `fits` to 1 for the pressures that keep their columns of G, and to 0 for those whose columns
   are replaced by the rows of the reactions; counts the latter on all ranks. The cosines are those
   of accelerations, without the units of the blocks: in a rheology these follow the viscosity, and
   columns that change in the iteration keep it from its end. */
static PetscErrorCode ChooseColumns(const Flow *flow, const Saddle *s, Vec momentum, Mat reactions,
                                    Vec fits, PetscInt *replaced)
{
  const PetscBool scaled = flow->particles->nu ? PETSC_TRUE : PETSC_FALSE;
  PetscScalar    *keeps;
  PetscInt        first, n = 0, *surface;
  Mat             GT = NULL;

  PetscFunctionBegin;
  *replaced = 0;
  PetscCall(PetscMalloc1(s->n, &surface));
  if (!s->adjoint) PetscCall(MatTranspose(s->G, MAT_INITIAL_MATRIX, &GT));
  if (GT && scaled) {
    PetscCall(VecReciprocal(momentum));
    PetscCall(ScaleBoth(momentum, GT, reactions));
    PetscCall(VecReciprocal(momentum));
  }
  PetscCall(MatGetOwnershipRange(reactions, &first, NULL));
  PetscCall(VecGetArrayWrite(fits, &keeps));
  for (PetscInt i = 0; i < s->n; i++) {
    const PetscBool held      = FreeSurfaceHolds(flow->ops->free, i);
    PetscReal       cosine[2] = {held ? 1.0 : 0.0, 1.0};

    if (GT) PetscCall(RowCosines(s->dim, GT, reactions, first + i, cosine));
    keeps[i] = cosine[0] >= OBLIQUE && (!held || cosine[1] >= ALIGNED) ? 1.0 : 0.0;
    if (GT && keeps[i] == 0.0 && KeepsColumn(flow, i)) keeps[i] = 1.0;
    if (keeps[i] > 0.0) continue;
    if (held) surface[n++] = first + i;
    (*replaced)++;
  }
  PetscCall(VecRestoreArrayWrite(fits, &keeps));
  if (GT && scaled) PetscCall(ScaleBoth(momentum, GT, reactions));
  if (GT) PetscCall(SetNormalForces(flow->ops->free, s->dim, n, surface, reactions));
  PetscCall(MatDestroy(&GT));
  PetscCall(PetscFree(surface));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, replaced, 1, MPIU_INT, MPI_SUM, flow->particles->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if a wall that fluid touches is within the support of own particle i. */
static PetscBool IsBesideWall(const Flow *flow, PetscInt i)
{
  const Particles *p  = flow->particles;
  const Neighbors *nb = flow->neighbors;

  for (PetscInt q = nb->row[i]; q < nb->row[i + 1]; q++) {
    const PetscInt j = nb->col[q];

    if (ParticlesIsWall(p, j) &&
        ParticlesSquareDistance(p, i, j) < PetscSqr(flow->ops->forms.radius) &&
        FreeSurfaceTouches(flow->scene, p, nb, NULL, i, j))
      return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Returns true if the row of G of own particle i is that of the reactions. Pair forces and
   reactions belong together: neither adds energy to any velocity. With a gradient of fits rough
   particles and those of a burst have both. With -coupled_gradient natural all particles off walls
   have both, and then the pressure and the pair forces have no stress on a free surface; beside
   walls reactions have an error of order 0, and the large pressures of narrow slits would compress
   the fluid. */
static PetscBool HasReactions(const Flow *flow, const Saddle *s, PetscInt i)
{
  const FreeSurface *free = flow->ops->free;

  if (s->natural) return IsBesideWall(flow, i) ? PETSC_FALSE : PETSC_TRUE;
  return FreeSurfaceIsRough(free, i) || FreeSurfaceIsPaired(free, i);
}

/* Replaces rows of G by those of the reactions. */
static PetscErrorCode ReplaceRows(const Flow *flow, Mat reactions, Saddle *s)
{
  PetscScalar *of;
  Vec          particles, rows;
  Mat          columns;

  PetscFunctionBegin;
  PetscCall(FluidVec(flow->particles, NULL, &particles));
  PetscCall(VecGetArrayWrite(particles, &of));
  for (PetscInt i = 0; i < s->n; i++) of[i] = HasReactions(flow, s, i) ? 1.0 : 0.0;
  PetscCall(VecRestoreArrayWrite(particles, &of));
  PetscCall(VelocityVecRepeat(flow->particles, particles, &rows));
  PetscCall(MatTranspose(reactions, MAT_INITIAL_MATRIX, &columns));
  PetscCall(MatDiagonalScale(columns, rows, NULL));
  PetscCall(VecScale(rows, -1.0));
  PetscCall(VecShift(rows, 1.0));
  PetscCall(MatDiagonalScale(s->G, rows, NULL));
  PetscCall(SparseAdd(columns, &s->G));
  PetscCall(MatDestroy(&columns));
  PetscCall(VecDestroy(&rows));
  PetscCall(VecDestroy(&particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SaddleReplaceGradient - Replaces columns of G by reactions: those of all equations of mass if
   s->adjoint is set, otherwise those that oppose their equations in fluids with a free surface and
   no surface tension; replaces rows of G off walls before if s->natural is set. Collective. Input:
   momentum - T_i/T of momentum rows. Notes: with the columns of all equations of mass replaced the
   sum of V_i grad p_i is zero, as D is zero for constant velocities, and so is that of V_i x_i x
   grad p_i if D is exact for linear ones. Without viscosity, force and C the kinetic energy is
   constant. Single replaced columns give a uniform pressure a force, so that a drop which surface
   tension holds would not be at rest. */
PetscErrorCode SaddleReplaceGradient(const Flow *flow, Vec momentum, Saddle *s)
{
  PetscInt replaced;
  Vec      fits;
  Mat      reactions, columns;

  PetscFunctionBegin;
  if (!s->adjoint && (!flow->ops->free || flow->scene->tension > 0.0))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(CreateReactions(flow, momentum, s, &reactions));
  if (s->natural || (!s->adjoint && flow->ops->free->has_rough))
    PetscCall(ReplaceRows(flow, reactions, s));
  PetscCall(VecDuplicate(s->pressure, &fits));
  PetscCall(ChooseColumns(flow, s, momentum, reactions, fits, &replaced));
  if (replaced) {
    PetscCall(MatDiagonalScale(s->G, NULL, fits));
    PetscCall(VecScale(fits, -1.0));
    PetscCall(VecShift(fits, 1.0));
    PetscCall(MatDiagonalScale(reactions, fits, NULL));
    PetscCall(MatTranspose(reactions, MAT_INITIAL_MATRIX, &columns));
    PetscCall(SparseAdd(columns, &s->G));
    PetscCall(MatDestroy(&columns));
  }
  PetscCall(VecDestroy(&fits));
  PetscCall(MatDestroy(&reactions));
  PetscFunctionReturn(PETSC_SUCCESS);
}
