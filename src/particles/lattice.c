/*
  The particles a run begins with. The fluid is a lattice of cell centres; a wall is one layer on
  its plane or some layers of the same lattice behind it. Any index of the lattice can be turned
  into its particle alone, so that each rank makes a contiguous share and nobody holds all.
*/
#include "impl.h"

/* Wall particles lie in slabs of lattice cells, two for each axis with walls. */
typedef struct {
  PetscInt n;                                     /* slabs */
  PetscInt side[2 * ISPH_MAX_DIM];                /* 2 axis + (0 low, 1 high) */
  PetscInt begin[2 * ISPH_MAX_DIM][ISPH_MAX_DIM]; /* first lattice index along each axis */
  PetscInt count[2 * ISPH_MAX_DIM][ISPH_MAX_DIM]; /* cells along each axis */
  PetscInt first[2 * ISPH_MAX_DIM + 1];           /* wall index of the slab's first cell */
} WallSlabs;

static PetscErrorCode CountCells(PetscInt dim, const PetscInt count[], PetscInt *total)
{
  PetscInt64 product = 1;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < dim; a++) {
    product *= count[a];
    UserCheck(product < PETSC_MAX_INT / 8,
              "-n asks for more particles than fit: more than %" PetscInt_FMT, PETSC_MAX_INT / 8);
  }
  *total = (PetscInt)product;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Slab (axis, end) spans the extended lattice in axes below, the interior in axes above, and its own
  layers in `axis`: together the slabs cover each cell outside the box once. One layer on the
  surface needs no corners: there the slab spans the interior in all other axes.
*/
static PetscErrorCode WallSlabsCreate(const Scene *scene, WallPlacement walls, WallSlabs *slabs)
{
  const PetscInt k = walls.layers;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(slabs, sizeof(*slabs)));
  for (PetscInt side = 0; side < 2 * scene->dim; side++) {
    const PetscInt axis = side / 2, s = slabs->n;
    PetscInt       total = 0;

    if (scene->periodic[axis] || !SceneHas(scene, PHYSICS_WALLS)) continue;
    for (PetscInt b = 0; b < scene->dim; b++) {
      const PetscInt extra = b < axis && !scene->periodic[b] ? k : 0;
      slabs->begin[s][b]   = -extra;
      slabs->count[s][b]   = scene->cells[b] + 2 * extra;
    }
    slabs->begin[s][axis] = side % 2 ? scene->cells[axis] : -PetscMax(k, 1);
    slabs->count[s][axis] = PetscMax(k, 1);
    slabs->side[s]        = side;
    PetscCall(CountCells(scene->dim, slabs->count[s], &total));
    slabs->first[s + 1] = slabs->first[s] + total;
    slabs->n++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  LatticeCount - How many particles the scene begins with

  Not collective
*/
PetscErrorCode LatticeCount(const Scene *scene, WallPlacement walls, PetscInt *N_fluid,
                            PetscInt *N_wall)
{
  WallSlabs slabs;

  PetscFunctionBegin;
  PetscCall(CountCells(scene->dim, scene->cells, N_fluid));
  PetscCall(WallSlabsCreate(scene, walls, &slabs));
  *N_wall = slabs.first[slabs.n];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ParticlesHash - A number in (-1, 1) that depends on its arguments only, not on ranks or order

  Not collective. The finaliser of SplitMix64; axis is less than 4.

  Reference: G. L. Steele, D. Lea, C. H. Flood, OOPSLA 2014
*/
PetscReal ParticlesHash(PetscInt seed, PetscInt id, PetscInt axis)
{
  uint64_t z = (uint64_t)seed * 0xD1342543DE82EF95u + (uint64_t)id * 4u + (uint64_t)axis;

  for (int round = 0; round < 2; round++) {
    z += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    z ^= z >> 31;
  }
  return 2.0 * (((PetscReal)(z >> 11) + 0.5) / 9007199254740992.0) - 1.0;
}

/* Turns an index into a block of cells, first axis fastest, into one index along each axis. */
static void CellOf(PetscInt dim, const PetscInt count[], PetscInt index, PetscInt cell[])
{
  for (PetscInt a = 0; a < dim; a++) {
    cell[a] = index % count[a];
    index /= count[a];
  }
}

/* Position of fluid particle id; a jittered one stays 0.3 of a cell away from walls that do not. */
static void FluidPosition(const Scene *scene, WallPlacement walls, PetscInt id, PetscReal x[])
{
  PetscInt cell[ISPH_MAX_DIM];

  CellOf(scene->dim, scene->cells, id, cell);
  for (PetscInt a = 0; a < scene->dim; a++) {
    const PetscReal side = scene->hi[a] - scene->lo[a], h = side / scene->cells[a];

    x[a] = scene->lo[a] + (cell[a] + 0.5) * h;
    if (scene->jitter > 0.0) x[a] += scene->jitter * scene->dx * ParticlesHash(scene->seed, id, a);
    if (scene->periodic[a]) x[a] -= side * PetscFloorReal((x[a] - scene->lo[a]) / side);
    else if (!walls.jittered)
      x[a] = PetscMin(PetscMax(x[a], scene->lo[a] + 0.3 * h), scene->hi[a] - 0.3 * h);
  }
}

/* Writes wall particle `index` of the scene to local place i. */
static void WallParticle(const Scene *scene, WallPlacement walls, const WallSlabs *slabs,
                         PetscInt index, Particles *p, PetscInt i)
{
  PetscInt  s       = 0, cell[ISPH_MAX_DIM], side;
  PetscReal deepest = 0.0;

  while (index >= slabs->first[s + 1]) s++;
  CellOf(scene->dim, slabs->count[s], index - slabs->first[s], cell);
  side = slabs->side[s];
  for (PetscInt a = 0; a < scene->dim; a++) {
    const PetscReal h = (scene->hi[a] - scene->lo[a]) / scene->cells[a];
    PetscReal       below, above;

    p->x[a][i] = scene->lo[a] + (slabs->begin[s][a] + cell[a] + 0.5) * h;
    if (walls.layers == 0 || scene->periodic[a]) continue;
    below = scene->lo[a] - p->x[a][i];
    above = p->x[a][i] - scene->hi[a];
    if (PetscMax(below, above) > deepest + 1e-6 * scene->dx) {
      deepest = PetscMax(below, above);
      side    = 2 * a + (above > below);
    }
  }
  if (walls.layers == 0) p->x[side / 2][i] = side % 2 ? scene->hi[side / 2] : scene->lo[side / 2];
  for (PetscInt a = 0; a < scene->dim; a++) {
    p->normal[a][i] = 0.0;
    if (walls.jittered)
      p->x[a][i] += scene->jitter * scene->dx * ParticlesHash(scene->seed, p->N_fluid + index, a);
  }
  p->normal[side / 2][i] = side % 2 ? -1.0 : 1.0;
  p->depth[i]            = deepest;
  p->side[i]             = (PetscReal)side;
  p->id[i]               = p->N_fluid + index;
}

/*
  LatticeFill - Makes this rank's share of the first particles, a contiguous range of lattice
indices

  Not collective

  Input Parameters:
+ scene - the scene
. walls - placement of wall particles
- p     - N_fluid and N_wall set, own fields registered

  Output Parameter:
. p - own particles with id, x, normal, depth and side; they are not where they belong yet
*/
PetscErrorCode LatticeFill(const Scene *scene, WallPlacement walls, Particles *p)
{
  WallSlabs   slabs;
  PetscMPIInt rank, ranks;
  PetscInt64  fluid, wall;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(p->comm, &rank));
  PetscCallMPI(MPI_Comm_size(p->comm, &ranks));
  PetscCall(WallSlabsCreate(scene, walls, &slabs));
  fluid      = (PetscInt64)p->N_fluid * rank / ranks;
  wall       = (PetscInt64)p->N_wall * rank / ranks;
  p->n_fluid = (PetscInt)((PetscInt64)p->N_fluid * (rank + 1) / ranks - fluid);
  p->n_wall  = (PetscInt)((PetscInt64)p->N_wall * (rank + 1) / ranks - wall);
  PetscCall(ParticlesReserve(p, ParticlesOwn(p)));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM];

    p->id[i] = (PetscInt)fluid + i;
    FluidPosition(scene, walls, p->id[i], x);
    for (PetscInt a = 0; a < p->dim; a++) p->x[a][i] = x[a];
  }
  for (PetscInt w = 0; w < p->n_wall; w++) {
    WallParticle(scene, walls, &slabs, (PetscInt)wall + w, p, p->n_fluid + w);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
