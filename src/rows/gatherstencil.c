/* The stencil of a particle: its neighbours within the support, with the data of walls that rows
   read. Assembly and streams gather it for each particle. */
#include "assembly.h"
#include "rows.h"

/* Sets the data of wall neighbour k, particle j. */
static void GatherWall(const Scene *scene, const Particles *p, const Operators *ops, PetscInt k,
                       Stencil *st)
{
  const PetscInt j      = st->j[k];
  PetscReal      height = 0.0;

  for (PetscInt a = 0; a < scene->dim; a++) {
    st->normal[a][k] = p->normal[a][j];
    height -= st->X[a][k] * p->normal[a][j];
  }
  st->beta[k] = ops->forms.wall->Beta(scene, height - p->depth[j], p->depth[j]);
  st->side[k] = (PetscInt)p->side[j];
}

/* Keeps the candidates that are closer than the radius: their indices in j, places relative to x in
   X, squares of distances in r; returns their number. j may be the candidates. Inlined for each
   dimension, with pointers that the compiler can keep in registers. */
static inline PetscInt KeepClose(PetscInt dim, const Particles *p, PetscInt n,
                                 const PetscInt candidate[], const PetscReal x[],
                                 const PetscReal stretch[], PetscReal radius2, Stencil *st)
{
  const PetscReal *px[ISPH_MAX_DIM] = {p->x[0], p->x[1], p->x[2]};
  PetscReal       *X[ISPH_MAX_DIM] = {st->X[0], st->X[1], st->X[2]}, *r = st->r;
  const PetscReal  origin[ISPH_MAX_DIM] = {x[0], x[1], x[dim - 1]};
  const PetscReal  times[ISPH_MAX_DIM]  = {stretch[0], stretch[1], stretch[dim - 1]};
  PetscInt        *j                    = st->j;
  size_t           kept                 = 0;

  for (PetscInt q = 0; q < n; q++) {
    const PetscInt c  = candidate[q];
    PetscReal      r2 = 0.0;

    for (PetscInt a = 0; a < dim; a++) {
      const PetscReal difference = times[a] * (px[a][c] - origin[a]);

      X[a][kept] = difference;
      r2 += difference * difference;
    }
    j[kept] = c;
    r[kept] = r2;
    kept += (r2 < radius2) & (r2 > 0.0);
  }
  return (PetscInt)kept;
}

/* Sets distances from their squares, volumes, kinds and equations of the first n neighbours, which
   ascend: own fluid comes first. Roots come last: KeepClose() stored the squares one by one, and a
   vector of them would wait for these stores. */
static ISPH_WIDE void FillNeighbors(const Particles *p, PetscInt n, Stencil *st)
{
  const PetscReal *volume = p->volume;
  const PetscInt  *j      = st->j;

  for (PetscInt k = 0; k < n; k++) st->V[k] = volume[j[k]];
  for (PetscInt k = 0; k < n; k++) st->equation[k] = EQUATION_VALUE;
  if (n > 0 && j[n - 1] < p->n_fluid) {
    for (PetscInt k = 0; k < n; k++) st->wall[k] = PETSC_FALSE;
  } else {
    for (PetscInt k = 0; k < n; k++) st->wall[k] = ParticlesIsWall(p, j[k]);
  }
  for (PetscInt k = 0; k < n; k++) st->r[k] = PetscSqrtReal(st->r[k]);
}

/* GatherStencil - Gathers the neighbours of own fluid particle i with the quantities that row
   functions read */
PetscErrorCode GatherStencil(const Scene *scene, const Particles *p, const Neighbors *nb,
                             const Operators *ops, PetscInt i, Stencil *st)
{
  const PetscInt  d = scene->dim, first = nb->row[i], last = nb->row[i + 1];
  const PetscInt *candidate = nb->col + first;
  PetscReal       radius2, x[ISPH_MAX_DIM];
  PetscInt        n;

  PetscFunctionBegin;
  PetscCall(StencilReserve(st, last - first));
  StencilSetSize(ops->forms.kernel, ops->forms.h_over_dx, p->dx[i], st);
  radius2             = PetscSqr(st->radius);
  st->i               = i;
  st->volume          = p->volume[i];
  st->fit.wanted      = 0;
  st->fit.coefficient = NULL;
  st->fit.fitted      = PETSC_FALSE;
  st->sloped          = SLOPE_NONE;
  for (PetscInt a = 0; a < d; a++) {
    x[a]           = p->x[a][i];
    st->stretch[a] = ParticlesStretch(p, a, i);
  }
  if (d == 2) n = KeepClose(2, p, last - first, candidate, x, st->stretch, radius2, st);
  else n = KeepClose(3, p, last - first, candidate, x, st->stretch, radius2, st);
  st->n = n;
  FillNeighbors(p, n, st);
  StencilFinish(st);
  st->scene = scene;
  st->slips = PETSC_FALSE;
  for (PetscInt q = 0; q < st->n_wall; q++) {
    const PetscInt k = st->walls[q];

    GatherWall(scene, p, ops, k, st);
    if (!BoundaryIs(scene, st->side[k], BOUNDARY_NO_SLIP)) st->slips = PETSC_TRUE;
  }
  KernelEvaluateAll(ops->forms.kernel, d, st->h, LanesPadded(n), st->r, st->W, st->dW, st->ddW);
  PetscFunctionReturn(PETSC_SUCCESS);
}
