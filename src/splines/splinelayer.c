/*
  The layer below the free surface that its level feels. It has a normal stress of its own, by which
  its fluid has no divergence: theory.md, (strain:layer). The stress is on splines that are no
  unknowns of the pressure, of each fluid its own.
*/
#include "isph/operators.h"
#include "splines.h"

#define LAYER_SHARE 0.3  /* least share in the fluid of splines of the layer: one in a column */
#define LAYER_LEAST 0.05 /* least integral of such a spline in it, over the volume of a cell */

/* SplineCollect - Collects a number of each spline in the order of the lattice; collective */
PetscErrorCode SplineCollect(const Particles *p, const Splines *s, Vec own, PetscReal to[])
{
  const SplineLattice *l = &s->lattice;
  const PetscScalar   *from;
  VecScatter           collect;
  Vec                  all;

  PetscFunctionBegin;
  PetscCall(VecScatterCreateToAll(own, &collect, &all));
  PetscCall(VecScatterBegin(collect, own, all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(collect, own, all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGetArrayRead(all, &from));
  for (PetscInt q = 0; q < l->N; q++) {
    PetscInt index[ISPH_MAX_DIM];

    SplineIndex(l->dim, NULL, l->count, q, index);
    to[q] = PetscRealPart(from[SplinesGlobal(s, p, index)]);
  }
  PetscCall(VecRestoreArrayRead(all, &from));
  PetscCall(VecScatterDestroy(&collect));
  PetscCall(VecDestroy(&all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineJoinFluids - Joins the matrices of fluids, which it destroys: below each other, or along
   the diagonal; collective */
PetscErrorCode SplineJoinFluids(const Splines *s, PetscBool diagonal, Mat part[], Mat *whole)
{
  const PetscInt n                                                      = s->fluids;
  Mat            block[(SCENE_MAX_FLUIDS + 1) * (SCENE_MAX_FLUIDS + 1)] = {NULL}, nest;

  PetscFunctionBegin;
  if (n == 1) {
    *whole = part[0];
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt f = 0; f < n; f++) block[diagonal ? f * n + f : f] = part[f];
  PetscCall(MatCreateNest(PetscObjectComm((PetscObject)part[0]), n, NULL, diagonal ? n : 1, NULL,
                          block, &nest));
  PetscCall(MatConvert(nest, MATAIJ, MAT_INITIAL_MATRIX, whole));
  PetscCall(MatDestroy(&nest));
  for (PetscInt f = 0; f < n; f++) PetscCall(MatDestroy(&part[f]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the corners of the layer of fluid f in a cell if it is an own one. */
static PetscInt LayerCorners(const Particles *p, const Splines *s, const StrainCells *cells,
                             PetscInt f, PetscInt c)
{
  const StrainBlocks *layer = &cells->surface.layer;
  PetscReal           x[ISPH_MAX_DIM];

  if (!SplineIsOf(s, cells, c, f) || !StrainHasCell(p, cells, c, x)) return 0;
  return layer->start[c + 1] - layer->start[c];
}

/* Assembles the splines of the layer of fluid f at its corners in own cells, and the parts of their
   cells in it over the volume of a cell of the splines. */
static PetscErrorCode LayerMat(const Particles *p, const Splines *s, const StrainCells *cells,
                               PetscInt f, Mat *V, Vec *part)
{
  const StrainBlocks *layer = &cells->surface.layer;
  const PetscReal     cell  = PetscPowReal(s->scale, (PetscReal)p->dim);
  PetscInt            n     = 0, row, *width;

  PetscFunctionBegin;
  for (PetscInt c = 0; c < cells->n; c++) n += LayerCorners(p, s, cells, f, c);
  PetscCall(PetscMalloc1(n, &width));
  for (PetscInt k = 0; k < n; k++) width[k] = SplinesAtPoint(&s->lattice);
  PetscCall(SplineMat(p->comm, n, s->own.size, width, V));
  PetscCall(PetscFree(width));
  PetscCall(MatCreateVecs(*V, NULL, part));
  PetscCall(MatGetOwnershipRange(*V, &row, NULL));
  for (PetscInt c = 0; c < cells->n; c++)
    for (PetscInt k = 0; k < LayerCorners(p, s, cells, f, c); k++, row++) {
      const PetscReal *of = &layer->w[(layer->start[c] + k) * layer->size];
      SplineValues     at;

      SplinesAt(&s->lattice, of + 1, &at);
      for (PetscInt q = 0; q < at.n; q++)
        if (s->layered[f * s->lattice.N + SplineNatural(&s->lattice, at.index[q])])
          PetscCall(
              MatSetValue(*V, row, SplinesGlobal(s, p, at.index[q]), at.value[q], ADD_VALUES));
      PetscCall(VecSetValue(*part, row, cells->volume[c] / cell * of[0], INSERT_VALUES));
    }
  PetscCall(SplineMatFinish(*V));
  PetscCall(VecAssemblyBegin(*part));
  PetscCall(VecAssemblyEnd(*part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Assembles the divergence of the cells of these corners: interlaced components over fluid, or over
   walls. */
static PetscErrorCode LayerDivergence(const Particles *p, const Splines *s,
                                      const StrainCells *cells, PetscInt f, PetscBool walls, Mat *T)
{
  const PetscInt d = p->dim;
  PetscInt       n = 0, row, *width;

  PetscFunctionBegin;
  for (PetscInt c = 0; c < cells->n; c++) n += LayerCorners(p, s, cells, f, c);
  PetscCall(PetscCalloc1(n, &width));
  n = 0;
  for (PetscInt c = 0; c < cells->n; c++)
    for (PetscInt k = 0; k < LayerCorners(p, s, cells, f, c); k++, n++)
      for (PetscInt a = 0; a < d; a++) {
        const PetscInt q = cells->sets == 1 ? 0 : a;

        width[n] += cells->first[q][c + 1] - cells->first[q][c];
      }
  PetscCall(SplineMat(p->comm, n, d * (walls ? p->n_wall : p->n_fluid), width, T));
  PetscCall(PetscFree(width));
  PetscCall(MatGetOwnershipRange(*T, &row, NULL));
  for (PetscInt c = 0; c < cells->n; c++)
    for (PetscInt k = 0; k < LayerCorners(p, s, cells, f, c); k++, row++)
      for (PetscInt a = 0; a < d; a++) {
        const PetscInt q = cells->sets == 1 ? 0 : a;

        for (PetscInt e = cells->first[q][c]; e < cells->first[q][c + 1]; e++) {
          const PetscInt j = cells->j[q][e];

          if (ParticlesIsWall(p, j) == walls)
            PetscCall(MatSetValue(*T, row, d * p->row[j] + a, cells->g[q][a][e], ADD_VALUES));
        }
      }
  PetscCall(SplineMatFinish(*T));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineLayerChoose - Chooses the splines of the layer of fluid f: of those that are no unknowns,
   the nearest to the surface. Collective. Input: share - of the fluid in each, in the order of the
   lattice; enough - the unknowns. */
PetscErrorCode SplineLayerChoose(const Particles *p, const StrainCells *cells, PetscInt f,
                                 const PetscReal share[], const PetscBool enough[], Splines *s)
{
  const PetscInt N       = s->lattice.N;
  PetscBool     *layered = &s->layered[f * N];
  PetscReal     *integral;
  Mat            V;
  Vec            part, own;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(N, &integral));
  for (PetscInt q = 0; q < N; q++) layered[q] = !enough[q] && share[q] >= LAYER_SHARE;
  PetscCall(LayerMat(p, s, cells, f, &V, &part));
  PetscCall(VecDuplicate(s->mass, &own));
  PetscCall(MatMultTranspose(V, part, own));
  PetscCall(SplineCollect(p, s, own, integral));
  for (PetscInt q = 0; q < N; q++) layered[q] = layered[q] && integral[q] >= LAYER_LEAST;
  PetscCall(PetscFree(integral));
  PetscCall(VecDestroyAll(&part, &own));
  PetscCall(MatDestroy(&V));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineLayersAdd - Adds the integrals over the layers of all fluids to a matrix, times a factor:
   of splines times the divergence by velocities of fluid or walls, or of products of splines.
   Collective. */
PetscErrorCode SplineLayersAdd(const Particles *p, const Splines *s, const StrainCells *cells,
                               PetscReal factor, PetscBool products, PetscBool walls, Mat *to)
{
  Mat V, T, of[SCENE_MAX_FLUIDS + 1], sum;
  Vec part;

  PetscFunctionBegin;
  for (PetscInt f = 0; f < s->fluids; f++) {
    PetscCall(LayerMat(p, s, cells, f, &V, &part));
    PetscCall(VecScale(part, factor));
    if (products) PetscCall(MatDuplicate(V, MAT_COPY_VALUES, &T));
    else PetscCall(LayerDivergence(p, s, cells, f, walls, &T));
    PetscCall(MatDiagonalScale(T, part, NULL));
    PetscCall(SplineGathered(V, T, &of[f]));
    PetscCall(MatDestroyAll(&V, &T));
    PetscCall(VecDestroy(&part));
  }
  PetscCall(SplineJoinFluids(s, products, of, &sum));
  PetscCall(SparseAdd(sum, to));
  PetscCall(MatDestroy(&sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}
