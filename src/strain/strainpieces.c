/* The pieces of the fluid, or of a fluid: strain cells that touch by their sides. A piece has the
   least id of its particles as its name, which is the same on all ranks and goes from rank to rank
   by the halo. Single particles have no cells, and are in no piece. */
#include "strain.h"

/* Returns the root of a cell in a forest of cells that touch. */
static PetscInt RootOf(PetscInt c, PetscInt parent[])
{
  while (parent[c] != c) c = parent[c] = parent[parent[c]];
  return c;
}

/* Computes the place in the block of the lattice cell at x. */
static PetscInt PlaceOf(const Scene *scene, const StrainLattice *l, const PetscReal x[])
{
  PetscInt k = 0;

  for (PetscInt a = l->dim - 1; a >= 0; a--) k = k * l->n[a] + StrainIndexAlong(scene, l, a, x[a]);
  return k;
}

/* Joins the lattice cells of this rank that have fluid and touch. Output: parent - forest. */
static void Join(const StrainLattice *l, PetscInt all, const PetscBool wet[], PetscInt parent[])
{
  for (PetscInt k = 0; k < all; k++) {
    PetscInt step = 1;

    parent[k] = k;
    for (PetscInt a = 0; a < l->dim && wet[k]; step *= l->n[a++]) /* earlier cells */
      if (k / step % l->n[a] > 0 && wet[k - step])
        parent[RootOf(k, parent)] = RootOf(k - step, parent);
  }
}

/* Returns the place of the wet lattice cell nearest to x, within half a spacing, which a particle
   there reaches; -1: none. */
static PetscInt WetPlace(const Scene *scene, const StrainLattice *l, const PetscBool wet[],
                         const PetscReal x[])
{
  PetscReal near = PetscSqr(0.5 * scene->dx);
  PetscInt  best = -1, all = 1;

  for (PetscInt a = 0; a < l->dim; a++) all *= 3;
  for (PetscInt m = 0; m < all; m++) {
    PetscReal far   = 0.0;
    PetscInt  place = 0;

    for (PetscInt a = l->dim - 1, of = m; a >= 0; a--, of /= 3) {
      const PetscInt  k  = StrainIndexAlong(scene, l, a, x[a]) + of % 3 - 1;
      const PetscReal lo = scene->lo[a] + (l->first[a] + k) * l->edge[a];

      if (k < 0 || k >= l->n[a]) far = PETSC_INFINITY;
      far += PetscSqr(PetscMax(PetscMax(lo - x[a], x[a] - lo - l->edge[a]), 0.0));
      place = place * l->n[a] + k;
    }
    if (far > near || !wet[place] || (best >= 0 && far == near)) continue;
    near = far;
    best = place;
  }
  return best;
}

/* Sets the names of pieces of a fluid. Output: piece - by lattice cell, -1 without particles; of -
   by particle that is no wall, -1 without a cell, and of fluid that waits at own walls; NULL: not
   wanted. */
static PetscErrorCode NamePieces(const Scene *scene, const Particles *p, const StrainLattice *l,
                                 const PetscBool wet[], PetscInt fluid, PetscInt piece[],
                                 PetscInt of[])
{
  const PetscInt all = StrainCellCount(l);
  PetscInt      *parent;
  PetscReal     *name;
  int            changed = 1;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(all, &parent, ParticlesAll(p), &name));
  Join(l, all, wet, parent);
  for (PetscInt k = 0; k < all; k++) piece[k] = PETSC_MAX_INT;
  for (PetscInt i = 0; i < ParticlesAll(p); i++) name[i] = (PetscReal)p->id[i];
  while (changed) {
    changed = 0;
    PetscCall(ParticlesHaloField(p, name));
    for (PetscInt pass = 0; pass < 2; pass++) {
      for (PetscInt i = 0; i < ParticlesAll(p); i++) {
        PetscReal x[ISPH_MAX_DIM];
        PetscInt  k;

        if (ParticlesIsWall(p, i) || (fluid >= 0 && (PetscInt)p->fluid[i] != fluid)) continue;
        for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
        k = WetPlace(scene, l, wet, x);
        if (k < 0) continue;
        k = RootOf(k, parent);
        if (!pass) piece[k] = PetscMin(piece[k], (PetscInt)name[i]);
        else if (i < p->n_fluid && (PetscReal)piece[k] < name[i]) {
          name[i] = (PetscReal)piece[k];
          changed = 1;
        }
      }
    }
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &changed, 1, MPI_INT, MPI_MAX, p->comm));
  }
  for (PetscInt k = 0; k < all; k++) piece[k] = piece[RootOf(k, parent)];
  for (PetscInt k = 0; k < all; k++)
    if (piece[k] == PETSC_MAX_INT) piece[k] = -1;
  for (PetscInt i = 0; of && i < ParticlesOwn(p); i++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0}, length;
    PetscInt  k;

    of[i] = -1;
    if (i >= p->n_fluid && !StrainWaits(scene, p, i, x, &length)) continue;
    for (PetscInt a = 0; a < p->dim && i < p->n_fluid; a++) x[a] = p->x[a][i];
    k = WetPlace(scene, l, wet, x);
    if (k >= 0) of[i] = piece[k];
  }
  PetscCall(PetscFree2(parent, name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StrainPieces - Computes the name of the piece of a fluid of each cell, -1 without its particles.
   Collective. Input: fluid - of the pieces; -1: of all together. Output: piece - by cell. */
PetscErrorCode StrainPieces(const Scene *scene, const Particles *p, const StrainCells *s,
                            PetscInt fluid, PetscInt piece[])
{
  const PetscInt all = StrainCellCount(&s->lattice);
  PetscBool     *wet;
  PetscInt      *name;

  PetscFunctionBegin;
  PetscCall(PetscCalloc2(all, &wet, all, &name));
  for (PetscInt pass = 0; pass < 2; pass++) {
    for (PetscInt c = 0; c < s->n; c++) {
      PetscReal x[ISPH_MAX_DIM];
      PetscInt  k;

      for (PetscInt a = 0; a < p->dim; a++) x[a] = s->centre[a][c];
      k = PlaceOf(scene, &s->lattice, x);
      if (pass) piece[c] = fluid < 0 || s->fluid[c] == fluid ? name[k] : -1;
      else if (fluid < 0 || s->fluid[c] == fluid) wet[k] = PETSC_TRUE;
    }
    if (!pass) PetscCall(NamePieces(scene, p, &s->lattice, wet, fluid, name, NULL));
  }
  PetscCall(PetscFree2(wet, name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StrainPiecesNumber - Numbers the pieces of the fluid by their names. Collective. Input: wet -
   lattice cells that have fluid. Output: piece - of particles and of fluid that waits at walls, by
   local index, n of those in no piece; n - pieces; single - particles in none. */
PetscErrorCode StrainPiecesNumber(const Scene *scene, const Particles *p, const StrainLattice *l,
                                  const PetscBool wet[], PetscReal piece[], PetscInt *n,
                                  PetscInt *single)
{
  const PetscInt own  = ParticlesOwn(p);
  PetscInt       here = 0, *name, *of, *all, *sorted;
  PetscMPIInt    ranks, mine, *count, *first;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(p->comm, &ranks));
  PetscCall(PetscMalloc5(StrainCellCount(l), &name, own, &of, own, &sorted, ranks, &count,
                         ranks + 1, &first));
  PetscCall(NamePieces(scene, p, l, wet, -1, name, of));
  for (PetscInt i = 0; i < own; i++)
    if (of[i] >= 0) sorted[here++] = of[i];
  PetscCall(PetscSortRemoveDupsInt(&here, sorted));
  mine = (PetscMPIInt)here;
  PetscCallMPI(MPI_Allgather(&mine, 1, MPI_INT, count, 1, MPI_INT, p->comm));
  *single = 0;
  for (PetscInt i = 0; i < p->n_fluid; i++) *single += of[i] < 0 ? 1 : 0;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, single, 1, MPIU_INT, MPI_SUM, p->comm));
  first[0] = 0;
  for (PetscMPIInt r = 0; r < ranks; r++) first[r + 1] = first[r] + count[r];
  PetscCall(PetscMalloc1(first[ranks] + 1, &all));
  PetscCallMPI(MPI_Allgatherv(sorted, mine, MPIU_INT, all, count, first, MPIU_INT, p->comm));
  *n = first[ranks];
  PetscCall(PetscSortRemoveDupsInt(n, all));
  for (PetscInt i = 0; i < ParticlesAll(p); i++) {
    PetscInt at = *n;

    if (i < own && of[i] >= 0) PetscCall(PetscFindInt(of[i], *n, all, &at));
    piece[i] = (PetscReal)at;
  }
  PetscCall(ParticlesHaloField(p, piece));
  PetscCall(PetscFree(all));
  PetscCall(PetscFree5(name, of, sorted, count, first));
  PetscFunctionReturn(PETSC_SUCCESS);
}
