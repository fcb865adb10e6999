/* The pieces of the fluid, or of a fluid: strain cells that touch by their sides. A piece has the
   least id of its particles as its name, which is the same on all ranks and goes from rank to rank
   by the halo. */
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

/* Returns true if a cell is in a fluid; -1: in any. */
static PetscBool IsIn(const StrainCells *s, PetscInt fluid, PetscInt c)
{
  return fluid < 0 || s->fluid[c] == fluid ? PETSC_TRUE : PETSC_FALSE;
}

/* Joins the cells of this rank that touch. Output: at - a cell by its place in the block, -1: none;
   parent - forest. */
static void Join(const Scene *scene, const StrainCells *s, PetscInt fluid, PetscInt all,
                 PetscInt at[], PetscInt parent[])
{
  const StrainLattice *l = &s->lattice;

  for (PetscInt k = 0; k < all; k++) at[k] = -1;
  for (PetscInt c = 0; c < s->n; c++) {
    PetscReal x[ISPH_MAX_DIM];
    PetscInt  k, step = 1;

    parent[c] = c;
    if (!IsIn(s, fluid, c)) continue;
    for (PetscInt a = 0; a < l->dim; a++) x[a] = s->centre[a][c];
    k         = PlaceOf(scene, l, x);
    parent[c] = at[k] < 0 ? c : at[k]; /* of several fluids in a lattice cell */
    at[k]     = parent[c];
    for (PetscInt a = 0; a < l->dim; step *= l->n[a++]) /* earlier cells */
      if (k / step % l->n[a] > 0 && at[k - step] >= 0)
        parent[RootOf(c, parent)] = RootOf(at[k - step], parent);
  }
}

/* StrainPieces - Computes the name of the piece of a fluid of each cell, -1 without its particles.
   Collective. Input: fluid - of the pieces; -1: of all together. Output: piece - by cell. */
PetscErrorCode StrainPieces(const Scene *scene, const Particles *p, const StrainCells *s,
                            PetscInt fluid, PetscInt piece[])
{
  const StrainLattice *l   = &s->lattice;
  PetscInt             all = 1, *at, *parent;
  PetscReal           *name;
  int                  changed = 1;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < l->dim; a++) all *= l->n[a];
  PetscCall(PetscMalloc3(all, &at, s->n, &parent, ParticlesAll(p), &name));
  Join(scene, s, fluid, all, at, parent);
  for (PetscInt c = 0; c < s->n; c++) piece[c] = PETSC_MAX_INT;
  for (PetscInt i = 0; i < ParticlesAll(p); i++) name[i] = (PetscReal)p->id[i];
  while (changed) {
    changed = 0;
    PetscCall(ParticlesHaloField(p, name));
    for (PetscInt pass = 0; pass < 2; pass++) {
      for (PetscInt i = 0; i < ParticlesAll(p); i++) {
        PetscReal x[ISPH_MAX_DIM];
        PetscInt  c;

        if (ParticlesIsWall(p, i) || (fluid >= 0 && (PetscInt)p->fluid[i] != fluid)) continue;
        for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
        c = at[PlaceOf(scene, l, x)];
        if (c < 0) continue;
        c = RootOf(c, parent);
        if (!pass) piece[c] = PetscMin(piece[c], (PetscInt)name[i]);
        else if (i < p->n_fluid && (PetscReal)piece[c] < name[i]) {
          name[i] = (PetscReal)piece[c];
          changed = 1;
        }
      }
    }
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &changed, 1, MPI_INT, MPI_MAX, p->comm));
  }
  for (PetscInt c = 0; c < s->n; c++) {
    const PetscInt root = RootOf(c, parent);

    if (root != c) piece[c] = piece[root];
  }
  for (PetscInt c = 0; c < s->n; c++)
    if (piece[c] == PETSC_MAX_INT) piece[c] = -1;
  PetscCall(PetscFree3(at, parent, name));
  PetscFunctionReturn(PETSC_SUCCESS);
}
