/* Splines on all ranks: their numbers, and the matrices that do not depend on the particles. A rank
   owns the splines whose centres are in its box. */
#include "splines.h"

/* Computes the splines of this rank along each axis: those whose centres are in its box. */
static void OwnBlock(const Splines *s, const Particles *p, SplineBlock *own)
{
  const SplineLattice *l = &s->lattice;

  own->size = 1;
  for (PetscInt a = 0; a < l->dim; a++) {
    PetscInt index[ISPH_MAX_DIM] = {0};

    own->first[a] = own->n[a] = 0;
    for (index[a] = 0; index[a] < l->count[a]; index[a]++) {
      PetscReal x[ISPH_MAX_DIM];

      SplinePlace(l, index, x);
      if (x[a] < p->lo[a]) own->first[a] = index[a] + 1;
      else if (x[a] < p->hi[a]) own->n[a]++;
    }
    own->size *= own->n[a];
  }
}

/* SplinesGlobal - Returns the global number of a spline; not collective */
PetscInt SplinesGlobal(const Splines *s, const Particles *p, const PetscInt index[])
{
  const SplineLattice *l      = &s->lattice;
  const SplineBlock   *b      = &s->own;
  PetscBool            own    = PETSC_TRUE;
  PetscInt             number = 0;

  for (PetscInt a = 0; a < l->dim; a++) {
    if (index[a] < b->first[a] || index[a] >= b->first[a] + b->n[a]) own = PETSC_FALSE;
  }
  if (!own) {
    PetscReal x[ISPH_MAX_DIM];

    SplinePlace(l, index, x);
    b = &s->block[ParticlesRankAt(p, x)];
  }
  for (PetscInt a = l->dim - 1; a >= 0; a--) number = number * b->n[a] + index[a] - b->first[a];
  return b->start + number;
}

/* SplineOwn - Computes the index of own spline k along each axis; returns false if it is no
   unknown; not collective */
PetscBool SplineOwn(const Splines *s, PetscInt k, PetscInt index[])
{
  SplineIndex(s->lattice.dim, s->own.first, s->own.n, k, index);
  return !s->extension || s->extension->slave[SplineNatural(&s->lattice, index)] == SPLINE_FREE;
}

/* SplineMat - Creates a matrix with space for width[r] entries in row r; collective. A row with
   more entries is no error, but PETSc copies the whole matrix for it. */
PetscErrorCode SplineMat(MPI_Comm comm, PetscInt rows, PetscInt cols, const PetscInt width[],
                         Mat *A)
{
  PetscInt all, *own, *other;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Allreduce(&cols, &all, 1, MPIU_INT, MPI_SUM, comm));
  PetscCall(PetscMalloc2(rows, &own, rows, &other));
  for (PetscInt r = 0; r < rows; r++) {
    own[r]   = PetscMin(width[r], cols);
    other[r] = PetscMin(width[r], all - cols);
  }
  PetscCall(MatCreateAIJ(comm, rows, cols, PETSC_DETERMINE, PETSC_DETERMINE, 0, own, 0, other, A));
  PetscCall(MatSetOption(*A, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
  PetscCall(PetscFree2(own, other));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineMatFinish - Ends the assembly of a matrix; collective */
PetscErrorCode SplineMatFinish(Mat A)
{
  PetscFunctionBegin;
  PetscCall(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineClear - Sets the rows of splines that are no unknowns to a diagonal, and their columns to
   zero if asked, so that a symmetric matrix stays so; collective */
PetscErrorCode SplineClear(const Splines *s, PetscBool columns, PetscReal diagonal, Mat A)
{
  PetscInt *row;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(s->n_unused, &row));
  for (PetscInt k = 0; k < s->n_unused; k++) row[k] = s->own.start + s->unused[k];
  if (columns) PetscCall(MatZeroRowsColumns(A, s->n_unused, row, diagonal, NULL, NULL));
  else PetscCall(MatZeroRows(A, s->n_unused, row, diagonal, NULL, NULL));
  PetscCall(PetscFree(row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesOfVelocity - Computes d = D[0] u + D[1] u_w of a velocity over fluid and walls; D[1] NULL:
   walls take no part; collective */
PetscErrorCode SplinesOfVelocity(const Flow *flow, const Mat D[2], const Vec u[], Vec d)
{
  const Particles *p = flow->particles;
  Vec              all;

  PetscFunctionBegin;
  PetscCall(VelocityVec(p, &all));
  for (PetscInt a = 0; a < p->dim; a++) PetscCall(VecStrideScatter(u[a], a, all, INSERT_VALUES));
  PetscCall(MatMult(D[0], all, d));
  PetscCall(VecDestroy(&all));
  if (!D[1]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WallVelocityVec(p, &all));
  for (PetscInt a = 0; a < p->dim; a++)
    PetscCall(VecStrideScatter(flow->walls.u[a], a, all, INSERT_VALUES));
  PetscCall(MatMultAdd(D[1], all, d, d));
  PetscCall(VecDestroy(&all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Assembles S from the points on the boundary. */
static PetscErrorCode AssembleBoundary(Splines *s, const Particles *p)
{
  const SplineLattice *l   = &s->lattice;
  PetscBool            any = s->bodies ? PETSC_TRUE : PETSC_FALSE;
  PetscInt             row, *width;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < l->dim; a++) any = any || !l->periodic[a];
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(s->boundary.n, &width));
  for (PetscInt g = 0; g < s->boundary.n; g++) {
    PetscReal x[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < l->dim; a++) x[a] = s->boundary.x[a][g];
    width[g] = SplineRowWidth(s, l, x);
  }
  PetscCall(SplineMat(p->comm, s->boundary.n, s->own.size, width, &s->S));
  PetscCall(PetscFree(width));
  PetscCall(MatGetOwnershipRange(s->S, &row, NULL));
  for (PetscInt g = 0; g < s->boundary.n; g++, row++) {
    PetscReal x[ISPH_MAX_DIM], entry[SPLINES_EXTENDED];
    SplineRow at;

    for (PetscInt a = 0; a < l->dim; a++) x[a] = s->boundary.x[a][g];
    if (s->boundary.patch[g] >= 0) SplineRowOfPatch(s, p, s->boundary.patch[g], &at);
    else SplineRowAt(s, l, p, x, &at);
    for (PetscInt k = 0; k < at.n; k++) entry[k] = s->boundary.weight[g] * at.value[k];
    PetscCall(MatSetValues(s->S, 1, &row, at.n, at.number, entry, ADD_VALUES));
  }
  PetscCall(SplineMatFinish(s->S));
  PetscCall(MatCreateVecs(s->S, NULL, &s->wall_flux));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the vectors of coefficients, and takes the pressure from its kept copy. */
static PetscErrorCode CreateVectors(Splines *s, const Particles *p)
{
  const SplineBlock *b = &s->own;
  PetscInt          *natural;
  IS                 from, to;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(s->mass, &s->p));
  PetscCall(VecDuplicate(s->mass, &s->phi));
  PetscCall(VecDuplicate(s->mass, &s->divergence));
  s->all = s->p;
  if (s->fluids == 1) PetscCall(PetscObjectReference((PetscObject)s->p));
  else PetscCall(VecCreateMPI(p->comm, s->fluids * b->size, PETSC_DETERMINE, &s->all));
  PetscCall(VecDuplicate(s->all, &s->b));
  PetscCall(PetscMalloc1(s->fluids * b->size, &natural));
  for (PetscInt k = 0; k < s->fluids * b->size; k++) {
    PetscInt index[ISPH_MAX_DIM];

    (void)SplineOwn(s, k % b->size, index);
    natural[k] = k / b->size * s->lattice.N + SplineNatural(&s->lattice, index);
  }
  PetscCall(ISCreateStride(p->comm, s->fluids * b->size, s->fluids * b->start, 1, &from));
  PetscCall(ISCreateGeneral(p->comm, s->fluids * b->size, natural, PETSC_OWN_POINTER, &to));
  PetscCall(VecScatterCreate(s->all, from, s->natural, to, &s->renumber));
  PetscCall(ISDestroy(&from));
  PetscCall(ISDestroy(&to));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesShareOut - Sets pressure and jumps from those of all fluids; collective */
PetscErrorCode SplinesShareOut(Splines *s)
{
  const PetscScalar *all, *first;
  PetscScalar       *to;

  PetscFunctionBegin;
  if (s->fluids == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArrayRead(s->all, &all));
  PetscCall(VecGetArray(s->p, &to));
  PetscCall(PetscArraycpy(to, all, s->own.size));
  PetscCall(VecRestoreArray(s->p, &to));
  PetscCall(VecGetArrayRead(s->p, &first));
  for (PetscInt f = 0; f < s->n_jumps; f++) {
    PetscCall(VecGetArray(s->jumps[f], &to));
    for (PetscInt k = 0; k < s->own.size; k++) to[k] = all[(f + 1) * s->own.size + k] - first[k];
    PetscCall(VecRestoreArray(s->jumps[f], &to));
  }
  PetscCall(VecRestoreArrayRead(s->p, &first));
  PetscCall(VecRestoreArrayRead(s->all, &all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesSumFluids - Sums numbers of the splines of all fluids, such as divergences; collective */
PetscErrorCode SplinesSumFluids(const Splines *s, Vec all, Vec sum)
{
  const PetscScalar *from;
  PetscScalar       *to;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(all, &from));
  PetscCall(VecGetArrayWrite(sum, &to));
  for (PetscInt k = 0; k < s->own.size; k++) {
    to[k] = from[k];
    for (PetscInt f = 1; f < s->fluids; f++) to[k] += from[f * s->own.size + k];
  }
  PetscCall(VecRestoreArrayWrite(sum, &to));
  PetscCall(VecRestoreArrayRead(all, &from));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineLayerSet - Sets the numbers of the layers in those of all splines, to their stress and
   `base`; not collective */
PetscErrorCode SplineLayerSet(const Splines *s, PetscReal base, Vec all)
{
  const PetscScalar *layer;
  PetscScalar       *to;

  PetscFunctionBegin;
  if (!s->layer) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArrayRead(s->layer, &layer));
  PetscCall(VecGetArray(all, &to));
  for (PetscInt k = 0; k < s->fluids * s->own.size; k++) {
    PetscInt index[ISPH_MAX_DIM];

    if (!SplineOwn(s, k % s->own.size, index)) continue;
    if (s->layered[k / s->own.size * s->lattice.N + SplineNatural(&s->lattice, index)])
      to[k] = base + layer[k];
  }
  PetscCall(VecRestoreArray(all, &to));
  PetscCall(VecRestoreArrayRead(s->layer, &layer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesExcess - Creates the vector of a pressure less that outside a free surface, whose force is
   that of the fluid's cells; collective */
PetscErrorCode SplinesExcess(const Splines *s, Vec p, Vec *excess)
{
  PetscFunctionBegin;
  PetscCall(VecDuplicate(p, excess));
  PetscCall(VecCopy(p, *excess));
  if (s->surface) PetscCall(VecShift(*excess, -s->lattice.scene->level));
  if (s->surface) PetscCall(SplineLayerSet(s, 0.0, *excess));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesCutFree - Frees the results of SplinesCutAssemble(); collective */
PetscErrorCode SplinesCutFree(Splines *s)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < 3; k++) PetscCall(MatDestroy(&s->cut[k]));
  PetscCall(MatDestroyAll(&s->joint, &s->surface, &s->values, &s->slopes));
  PetscCall(PetscFree(s->slave));
  PetscCall(PetscFree(s->layered));
  PetscCall(VecDestroy(&s->layer));
  PetscCall(VecDestroy(&s->cut_gradient));
  for (PetscInt f = 0; f < s->n_jumps; f++) {
    PetscCall(MatDestroyAll(&s->jump[f][0], &s->jump[f][1]));
    PetscCall(VecDestroy(&s->jumps[f]));
  }
  PetscCall(PetscFree2(s->jump, s->jumps));
  s->n_jumps = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees all that depends on the numbers of the splines. */
static PetscErrorCode FreeNumbered(Splines *s)
{
  PetscFunctionBegin;
  PetscCall(SplineWindowFree(&s->window));
  PetscCall(MatDestroyAll(&s->S, &s->K, &s->M, &s->A));
  PetscCall(SplinesCutFree(s));
  PetscCall(VecDestroyAll(&s->mass, &s->p, &s->all, &s->phi, &s->b, &s->divergence, &s->wall_flux));
  PetscCall(VecScatterDestroy(&s->renumber));
  PetscCall(PetscFree(s->unused));
  PetscCall(SplinePointsFree(&s->inside));
  PetscCall(SplinePointsFree(&s->boundary));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers the splines for the present boxes of the ranks, and assembles all that does not depend on
   the particles. Collective. Does nothing unless the box of a rank has changed. */
static PetscErrorCode NumberSplines(const Particles *p, Splines *s)
{
  int         old = s->K ? 1 : 0;
  PetscMPIInt ranks, rank;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < p->dim; a++) old = old && s->lo[a] == p->lo[a] && s->hi[a] == p->hi[a];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &old, 1, MPI_INT, MPI_MIN, p->comm));
  if (old) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FreeNumbered(s));
  PetscCallMPI(MPI_Comm_size(p->comm, &ranks));
  PetscCallMPI(MPI_Comm_rank(p->comm, &rank));
  if (!s->block) PetscCall(PetscMalloc1(ranks, &s->block));
  OwnBlock(s, p, &s->own);
  PetscCallMPI(MPI_Scan(&s->own.size, &s->own.start, 1, MPIU_INT, MPI_SUM, p->comm));
  s->own.start -= s->own.size;
  PetscCallMPI(MPI_Allgather(&s->own, (int)sizeof(s->own), MPI_BYTE, s->block, (int)sizeof(s->own),
                             MPI_BYTE, p->comm));
  for (PetscInt a = 0; a < p->dim; a++) {
    s->lo[a] = p->lo[a];
    s->hi[a] = p->hi[a];
  }
  PetscCall(SplinePointsSet(s, p));
  PetscCall(SplineStiffness(s, p));
  PetscCall(AssembleBoundary(s, p));
  PetscCall(CreateVectors(s, p));
  PetscCall(SplineWindowSet(s, p));
  PetscCall(SplinePointPlacesSet(s));
  s->numbering++;
  PetscCall(SplinesBegin(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesAssemble - Computes all that depends on the positions of particles, and numbers the
   splines anew if the box of a rank has changed. Collective. Does nothing if positions and
   numbering have not changed since the last assembly. */
PetscErrorCode SplinesAssemble(Flow *flow, Splines *s)
{
  const Particles *p = flow->particles;

  PetscFunctionBegin;
  if (s->epoch == p->epoch && s->moved == p->moved) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SplinesFollow(s));
  if (s->epoch != p->epoch || s->lattice.scene->pose)
    PetscCall(NumberSplines(p, s)); /* boxes may be new */
  PetscCall(SplinePlacesSet(p, s));
  PetscCall(SplineFitsAssemble(flow, s));
  s->epoch = p->epoch;
  s->moved = p->moved;
  s->assemblies++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineMixtureFree - Frees the mixture; collective */
PetscErrorCode SplineMixtureFree(SplineMixture *m)
{
  PetscFunctionBegin;
  PetscCall(VecDestroyAll(&m->volume, &m->share, &m->density, &m->potential, &m->all));
  PetscCall(VecScatterDestroy(&m->collect));
  PetscCall(PetscFree(m->inertia));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesFree - Frees the splines; collective */
PetscErrorCode SplinesFree(Splines *s)
{
  PetscFunctionBegin;
  PetscCall(FreeNumbered(s));
  PetscCall(SplineFitsFree(&s->fits));
  PetscCall(SplineMixtureFree(&s->mixture));
  PetscCall(SplinePlacesFree(&s->at));
  PetscCall(SplinePlacesFree(&s->inside_at));
  PetscCall(SplineBodiesDestroy(&s->bodies));
  PetscCall(SplineExtensionDestroy(&s->extension));
  PetscCall(VecDestroyAll(&s->kept, &s->natural));
  PetscCall(PetscFree(s->block));
  PetscFunctionReturn(PETSC_SUCCESS);
}
