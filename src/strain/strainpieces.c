/* The pieces of the fluid, or of a fluid: strain cells that touch by their sides. A piece has the
   least id of its particles as its name, which is the same on all ranks and goes from rank to rank
   by the halo. One level holds the volume of all pieces, not that of each: small drops are smaller
   than their particles, and single particles have no cells. */
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

/* Sets the names of pieces of a fluid. Output: piece - by cell, -1 without particles; of - by
   particle that is no wall, -1 without a cell, and of fluid that waits at own walls; NULL: not
   wanted. */
static PetscErrorCode NamePieces(const Scene *scene, const Particles *p, const StrainCells *s,
                                 PetscInt fluid, PetscInt piece[], PetscInt of[])
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
  for (PetscInt i = 0; of && i < ParticlesOwn(p); i++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0}, length;
    PetscInt  c;

    of[i] = -1;
    if (i >= p->n_fluid && !StrainWaits(scene, p, i, x, &length)) continue;
    for (PetscInt a = 0; a < p->dim && i < p->n_fluid; a++) x[a] = p->x[a][i];
    c = at[PlaceOf(scene, l, x)];
    if (c >= 0) of[i] = piece[c];
  }
  PetscCall(PetscFree3(at, parent, name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StrainPieces - Computes the name of the piece of a fluid of each cell, -1 without its particles.
   Collective. Input: fluid - of the pieces; -1: of all together. Output: piece - by cell. */
PetscErrorCode StrainPieces(const Scene *scene, const Particles *p, const StrainCells *s,
                            PetscInt fluid, PetscInt piece[])
{
  PetscFunctionBegin;
  PetscCall(NamePieces(scene, p, s, fluid, piece, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the volume that own particle i stands for: its own or, if it is a wall particle of an
   inflow, that of the fluid that waits there. */
static PetscReal VolumeOf(const Scene *scene, const Particles *p, PetscInt i)
{
  PetscReal x[ISPH_MAX_DIM] = {0.0}, length;

  if (i < p->n_fluid) return p->volume[i];
  if (!StrainWaits(scene, p, i, x, &length)) return 0.0;
  return p->cell_volume * length / SceneCellSide(scene, (PetscInt)p->side[i] / 2);
}

/* StrainShares - Compares the volumes of the pieces of the fluid with those of their particles.
   Collective. Output: share - volume of the particles of a piece over that of its cells, by cell;
   cells->apart, cells->astray. */
PetscErrorCode StrainShares(const Scene *scene, const Particles *p, StrainCells *s,
                            PetscReal share[])
{
  PetscInt *piece, *of, last = -1, next;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(s->n + 1, &piece, ParticlesOwn(p) + 1, &of));
  PetscCall(NamePieces(scene, p, s, -1, piece, of));
  PetscCall(PetscRealloc(sizeof(PetscBool) * (size_t)(p->n_fluid + 1), &s->apart));
  for (PetscInt i = 0; i < p->n_fluid; i++) s->apart[i] = of[i] < 0 ? PETSC_TRUE : PETSC_FALSE;
  s->astray = 0.0;
  do { /* the piece whose name is next on all ranks; at first cells without particles, -1 */
    PetscReal volume[2] = {0.0, 0.0}; /* of cells, of particles */

    next = PETSC_MAX_INT;
    for (PetscInt c = 0; c < s->n; c++) {
      PetscReal x[ISPH_MAX_DIM];

      if (piece[c] == last && StrainHasCell(p, s, c, x)) volume[0] += s->volume[c];
      if (piece[c] > last) next = PetscMin(next, piece[c]);
    }
    for (PetscInt i = 0; i < ParticlesOwn(p) && last >= 0; i++)
      if (of[i] == last) volume[1] += VolumeOf(scene, p, i);
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, volume, 2, MPIU_REAL, MPIU_SUM, p->comm));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &next, 1, MPIU_INT, MPI_MIN, p->comm));
    for (PetscInt c = 0; c < s->n; c++)
      if (piece[c] == last) share[c] = volume[0] > 0.0 ? volume[1] / volume[0] : 1.0;
    s->astray += PetscMax(volume[0] - volume[1], 0.0);
    last = next;
  } while (next < PETSC_MAX_INT);
  PetscCall(PetscFree2(piece, of));
  PetscFunctionReturn(PETSC_SUCCESS);
}
