/* Particles at the start of a run. Fluid particles are the centres of lattice cells outside bodies,
   at a minimum distance from them, or have positions given by the user. Wall particles form a layer
   on the surface, or several layers of the same lattice behind it (dummies), or both. With both,
   the surface layer represents the half cell between fluid and dummies. Each particle follows from
   its index alone, so each rank creates the particles of a contiguous range of indices. */
#include "start.h"

/* Slabs of lattice cells with the wall particles of the box, a slab for each confining side. */
typedef struct {
  PetscInt n;                                     /* slabs */
  PetscInt side[2 * ISPH_MAX_DIM];                /* 2 axis + (0 low, 1 high) */
  PetscInt begin[2 * ISPH_MAX_DIM][ISPH_MAX_DIM]; /* first lattice index along each axis */
  PetscInt count[2 * ISPH_MAX_DIM][ISPH_MAX_DIM]; /* cells along each axis */
  PetscInt first[2 * ISPH_MAX_DIM + 1];           /* wall index of the slab's first cell */
} WallSlabs;

/* Creates the slabs. The slab of a side spans the wall layers along its own axis, the lattice with
   wall layers along lower axes, and the lattice of the fluid along higher axes: together the slabs
   cover each cell outside the box once. A single layer on the surface needs no corners: then each
   slab spans the lattice of the fluid along all other axes. */
static PetscErrorCode WallSlabsCreate(const Scene *scene, WallPlacement walls, WallSlabs *slabs)
{
  const PetscInt k = walls.layers;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(slabs, sizeof(*slabs)));
  for (PetscInt side = 0; side < 2 * scene->dim; side++) {
    const PetscInt axis = side / 2, s = slabs->n;
    PetscInt       total = 0;

    if (!BoundaryIs(scene, side, BOUNDARY_PARTICLES) || !SceneHas(scene, PHYSICS_WALLS)) continue;
    for (PetscInt b = 0; b < scene->dim; b++) {
      const PetscInt extra = b < axis && !SceneIsPeriodic(scene, b) ? k : 0;
      slabs->begin[s][b]   = -extra;
      slabs->count[s][b]   = scene->cells[b] + 2 * extra;
    }
    slabs->begin[s][axis] = side % 2 ? scene->cells[axis] : -PetscMax(k, 1);
    slabs->count[s][axis] = PetscMax(k, 1);
    slabs->side[s]        = side;
    PetscCall(SceneCountCells(scene->dim, slabs->count[s], &total));
    slabs->first[s + 1] = slabs->first[s] + total;
    slabs->n++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Converts the index of a cell in a block, first axis fastest, to an index along each axis. */
static void CellOf(PetscInt dim, const PetscInt count[], PetscInt index, PetscInt cell[])
{
  for (PetscInt a = 0; a < dim; a++) {
    cell[a] = index % count[a];
    index /= count[a];
  }
}

/* Contents of a cell of the lattice. */
typedef enum { CELL_FLUID, CELL_DUMMY, CELL_EMPTY } CellKind;

/* Returns the distance from the surface of a body that the centre of a fluid cell must have; it is
   smaller if dummies, not particles on the surface, represent the wall [m]. */
static PetscReal FluidClearance(WallPlacement walls, PetscReal dx)
{
  return (walls.layers && !walls.surface ? 0.25 : 0.4) * dx;
}

/* Returns the distance from the surface of a body that the centre of a dummy cell must have [m]. */
static PetscReal DummyClearance(WallPlacement walls, PetscReal dx)
{
  return (walls.surface ? 0.5 : 0.25) * dx;
}

/* Determines the contents of a cell from the distance of its centre x to the nearest body; for a
   dummy also its body, depth and normal. */
static CellKind ClassifyCell(const Scene *scene, WallPlacement walls, PetscInt index, PetscReal x[],
                             PetscInt *body, PetscReal *depth, PetscReal normal[])
{
  PetscInt  cell[ISPH_MAX_DIM];
  PetscReal dx;

  CellOf(scene->dim, scene->cells, index, cell);
  for (PetscInt a = 0; a < scene->dim; a++) x[a] = SceneLatticePlace(scene, a, cell[a] + 0.5);
  dx     = SceneSpacing(scene, x);
  *depth = -SceneDistance(scene, x, body, normal);
  if (*depth <= -FluidClearance(walls, dx)) return CELL_FLUID;
  if (*depth < DummyClearance(walls, dx)) return CELL_EMPTY;
  return *depth < walls.layers * dx ? CELL_DUMMY : CELL_EMPTY;
}

/* Displaces a fluid particle at random. It stays 0.25 dx away from bodies, and 0.3 of a cell away
   from walls of the box if their particles are not displaced. */
static void JitterFluid(const Scene *scene, WallPlacement walls, PetscInt64 id, PetscReal x[])
{
  const PetscReal dx = SceneSpacing(scene, x);
  PetscReal       normal[ISPH_MAX_DIM], edge[ISPH_MAX_DIM], stretch[ISPH_MAX_DIM], distance;
  PetscInt        body;

  if (scene->jitter == 0.0) return;
  SceneEdges(scene, x, edge);
  SceneStretch(scene, x, stretch);
  for (PetscInt a = 0; a < scene->dim; a++) {
    const PetscReal side = scene->hi[a] - scene->lo[a], h = edge[a];

    x[a] += scene->jitter * (dx / stretch[a]) * ParticlesHash(scene->seed, id, a);
    if (SceneIsPeriodic(scene, a)) x[a] -= side * PetscFloorReal((x[a] - scene->lo[a]) / side);
    else if (!walls.jittered)
      x[a] = PetscMin(PetscMax(x[a], scene->lo[a] + 0.3 * h), scene->hi[a] - 0.3 * h);
  }
  distance = SceneDistance(scene, x, &body, normal);
  for (PetscInt a = 0; distance < 0.25 * dx && a < scene->dim; a++)
    x[a] += (0.25 * dx - distance) * normal[a];
}

/* Returns the coordinate of the particle of lattice cell c along axis a. If the first wall layer
   lies on the surface, particles beyond a side of the box are half a cell nearer to it. Output:
   share - fraction of the cell that belongs to the particle. */
static PetscReal WallCoordinate(const Scene *scene, WallPlacement walls, PetscInt a, PetscInt c,
                                PetscReal *share)
{
  PetscReal place = c + 0.5;

  *share = 1.0;
  if (walls.surface && (c < 0 || c >= scene->cells[a])) {
    place += c < 0 ? 0.5 : -0.5;
    if (c == -1 || c == scene->cells[a]) *share = 0.5;
  }
  return SceneLatticePlace(scene, a, place);
}

/* Stretches the support of local particle i as its cell at x; does nothing on uniform lattices. */
static void SetStretch(const Scene *scene, const PetscReal x[], Particles *p, PetscInt i)
{
  PetscReal stretch[ISPH_MAX_DIM];

  if (!p->stretch[0]) return;
  SceneStretch(scene, x, stretch);
  for (PetscInt a = 0; a < p->dim; a++) p->stretch[a][i] = stretch[a];
}

/* Writes wall particle `index` of the slabs to local index i. */
static void WallParticle(const Scene *scene, WallPlacement walls, const WallSlabs *slabs,
                         PetscInt index, Particles *p, PetscInt i)
{
  PetscInt  s       = 0, cell[ISPH_MAX_DIM], side;
  PetscReal deepest = 0.0, shares = 1.0, x[ISPH_MAX_DIM], dx;

  while (index >= slabs->first[s + 1]) s++;
  CellOf(scene->dim, slabs->count[s], index - slabs->first[s], cell);
  side = slabs->side[s];
  for (PetscInt a = 0; a < scene->dim; a++) {
    PetscReal below, above, share;

    p->x[a][i] = WallCoordinate(scene, walls, a, slabs->begin[s][a] + cell[a], &share);
    shares *= share;
    if (walls.layers == 0 || SceneIsPeriodic(scene, a)) continue;
    below = scene->lo[a] - p->x[a][i];
    above = p->x[a][i] - scene->hi[a];
    if (PetscMax(below, above) > deepest + 1e-6 * SceneTolerance(scene)) {
      deepest = PetscMax(below, above);
      side    = 2 * a + (above > below);
    }
  }
  if (walls.layers == 0) p->x[side / 2][i] = side % 2 ? scene->hi[side / 2] : scene->lo[side / 2];
  for (PetscInt a = 0; a < scene->dim; a++) x[a] = p->x[a][i];
  dx = SceneSpacing(scene, x);
  for (PetscInt a = 0; a < scene->dim; a++) {
    p->normal[a][i] = 0.0;
    if (walls.jittered)
      p->x[a][i] += scene->jitter * dx * ParticlesHash(scene->seed, p->N_fluid + index, a);
  }
  p->normal[side / 2][i] = side % 2 ? -1.0 : 1.0;
  p->depth[i]            = deepest;
  p->side[i]             = (PetscReal)side;
  p->id[i]               = p->N_fluid + index;
  p->kind[i]             = PARTICLE_WALL;
  p->dx[i]               = dx;
  p->volume[i]           = shares * SceneVolumeAt(scene, x);
  SetStretch(scene, x, p, i);
}

/* Counts fluid and dummies (index 0 and 1) among the lattice cells [first, last) of this rank, of
   lower ranks (start) and of all ranks. */
static PetscErrorCode CountShare(const Scene *scene, WallPlacement walls, PetscInt first,
                                 PetscInt last, MPI_Comm comm, PetscInt own[2], PetscInt start[2],
                                 PetscInt all[2])
{
  PetscReal x[ISPH_MAX_DIM], depth, normal[ISPH_MAX_DIM];
  PetscInt  body;

  PetscFunctionBegin;
  own[0] = own[1] = start[0] = start[1] = 0;
  for (PetscInt c = first; c < last; c++) {
    const CellKind kind = ClassifyCell(scene, walls, c, x, &body, &depth, normal);

    if (kind != CELL_EMPTY) own[kind == CELL_FLUID ? 0 : 1]++;
  }
  PetscCallMPI(MPI_Exscan(own, start, 2, MPIU_INT, MPI_SUM, comm));
  PetscCallMPI(MPI_Allreduce(own, all, 2, MPIU_INT, MPI_SUM, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes a wall particle of a body at x to local index i. */
static void BodyParticle(const Scene *scene, PetscInt body, const PetscReal x[], PetscReal depth,
                         const PetscReal normal[], PetscReal volume, PetscInt id, Particles *p,
                         PetscInt i)
{
  for (PetscInt a = 0; a < scene->dim; a++) {
    p->x[a][i]      = x[a];
    p->normal[a][i] = normal[a];
  }
  p->depth[i]  = depth;
  p->side[i]   = (PetscReal)SceneBodySide(scene, body);
  p->id[i]     = id;
  p->kind[i]   = PARTICLE_WALL;
  p->dx[i]     = SceneSpacing(scene, x);
  p->volume[i] = volume;
}

/* Returns the number of wall particles on the surfaces of bodies; zero if all layers are behind the
   surface. */
static PetscInt SurfacePoints(const Scene *scene, WallPlacement walls)
{
  PetscInt n = 0;

  if (walls.layers && !walls.surface) return 0;
  for (PetscInt k = 0; k < scene->n_bodies; k++)
    n += BodyPoints(SceneBody(scene, k), BodySpacing(scene, SceneBody(scene, k)));
  return n;
}

/* Writes the wall particle at surface point `index`, counted over all bodies, to local index i.
   With dummies behind it, the particle represents the band between fluid cells and dummy cells,
   otherwise a cell. */
static void SurfaceParticle(const Scene *scene, WallPlacement walls, PetscInt index, PetscInt id,
                            Particles *p, PetscInt i)
{
  PetscReal x[ISPH_MAX_DIM] = {0.0}, normal[ISPH_MAX_DIM], length, dx, volume;
  PetscInt  k               = 0;

  while (index >= BodyPoints(SceneBody(scene, k), BodySpacing(scene, SceneBody(scene, k)))) {
    index -= BodyPoints(SceneBody(scene, k), BodySpacing(scene, SceneBody(scene, k)));
    k++;
  }
  dx     = BodySpacing(scene, SceneBody(scene, k));
  length = BodyPoint(SceneBody(scene, k), index, dx, x, normal);
  volume = length * (FluidClearance(walls, dx) + DummyClearance(walls, dx));
  if (!walls.surface) volume = SceneVolumeAt(scene, x);
  BodyParticle(scene, k, x, 0.0, normal, volume, id, p, i);
}

/* Creates the particles of lattice cells [first, last): fluid with ids from `fluid` on, or no fluid
   if `fluid` is negative, and dummies at local indices from `wall` on with ids from `dummy` on. */
static void FillCells(const Scene *scene, WallPlacement walls, PetscInt first, PetscInt last,
                      PetscInt fluid, PetscInt wall, PetscInt dummy, Particles *p)
{
  PetscReal x[ISPH_MAX_DIM], depth, normal[ISPH_MAX_DIM];
  PetscInt  body, i = 0;

  for (PetscInt c = first; c < last; c++) {
    const CellKind kind = ClassifyCell(scene, walls, c, x, &body, &depth, normal);

    if (kind == CELL_DUMMY)
      BodyParticle(scene, body, x, depth, normal, SceneVolumeAt(scene, x), dummy++, p, wall++);
    if (kind != CELL_FLUID || fluid < 0) continue;
    p->id[i]     = fluid + i;
    p->kind[i]   = PARTICLE_FLUID;
    p->dx[i]     = SceneSpacing(scene, x);
    p->volume[i] = SceneVolumeAt(scene, x);
    SetStretch(scene, x, p, i);
    JitterFluid(scene, walls, p->id[i], x);
    for (PetscInt a = 0; a < p->dim; a++) p->x[a][i] = x[a];
    i++;
  }
}

/* Checks, for each body that has the fluid inside, that the wall layers behind its surface fit into
   the box. */
static PetscErrorCode CheckRoom(const Scene *scene, WallPlacement walls)
{
  PetscFunctionBegin;
  for (PetscInt pair = 0; walls.layers && pair < PetscSqr(scene->n_bodies); pair++) {
    const PetscInt side  = SceneBodySide(scene, pair / scene->n_bodies),
                   other = SceneBodySide(scene, pair % scene->n_bodies);
    const Body *body     = BoundaryBody(scene, side);

    for (PetscInt k = 0; k < BodyPoints(body, BodySpacing(scene, body)); k++) {
      PetscReal x[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];
      char      name[2][WALL_NAME];

      (void)BodyPoint(body, k, BodySpacing(scene, body), x, normal);
      SceneWallName(scene, side, name[0]);
      SceneWallName(scene, other, name[1]);
      UserCheck(!SceneBuries(scene, other, side, x),
                "-scene_%s: it touches %s, and this -wall has particles behind surfaces, with one "
                "nearest surface; use -wall wall_layer",
                name[0], name[1]);
    }
  }
  for (PetscInt k = 0; k < scene->n_bodies; k++) {
    const Body     *body = SceneBody(scene, k);
    const PetscReal want = walls.layers * BodySpacing(scene, body);

    for (PetscInt a = 0; a < scene->dim && body->around; a++) {
      const char *const larger = scene->problem->typed ? "a larger -scene_box or " : "";
      PetscReal         span[2], room;

      if (BodyReachesThrough(body, a)) continue;
      BodySpan(body, a, span);
      room = PetscMin(span[0] - scene->lo[a], scene->hi[a] - span[1]);
      UserCheck(walls.layers == 0 || room >= want - 1e-9 * SceneTolerance(scene),
                "the box leaves %.4g m behind the domain along %c; its wall takes %.4g m; use %sa "
                "smaller -h_over_dx",
                (double)room, "xyz"[a], (double)want, larger);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* LatticeWallCount - Computes the number of wall particles at the sides of the box */
PetscErrorCode LatticeWallCount(const Scene *scene, WallPlacement walls, PetscInt *count)
{
  WallSlabs slabs;

  PetscFunctionBegin;
  PetscCall(WallSlabsCreate(scene, walls, &slabs));
  *count = slabs.first[slabs.n];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* LatticeWalls - Creates wall particles [first, last) of the sides of the box at local indices from
   `at` on. Their ids follow those of p->N_fluid fluid particles. */
PetscErrorCode LatticeWalls(const Scene *scene, WallPlacement walls, PetscInt first, PetscInt last,
                            Particles *p, PetscInt at)
{
  WallSlabs slabs;

  PetscFunctionBegin;
  PetscCall(WallSlabsCreate(scene, walls, &slabs));
  for (PetscInt k = first; k < last; k++) WallParticle(scene, walls, &slabs, k, p, at++);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* LatticeFill - Creates the particles at the start of a run. Collective. Each rank creates the
   particles of a contiguous range of lattice indices. They are sent to their owners later, when the
   first epoch starts. Input: scene - the scene; walls - placement of wall particles; start - given
   positions of the fluid; NULL: the fluid fills the lattice; p - empty particles, with all fields
   of this module registered. Output: p - the particles, with counts, next_id, and id, kind, x, dx,
   volume, normal, depth and side of each. Ids are given to the fluid first, then to walls of the
   box, then to walls of bodies. */
PetscErrorCode LatticeFill(const Scene *scene, WallPlacement walls, const FluidStart *start,
                           Particles *p)
{
  WallSlabs slabs;
  PetscInt  cells = 0, first, last, own[2], before[2], all[2], slab[2], point[2], wall, dummy;

  PetscFunctionBegin;
  PetscCall(CheckRoom(scene, walls));
  PetscCall(SceneCountCells(scene->dim, scene->cells, &cells));
  ParticlesShare(p->comm, cells, &first, &last);
  PetscCall(CountShare(scene, walls, first, last, p->comm, own, before, all));
  PetscCall(WallSlabsCreate(scene, walls, &slabs));
  ParticlesShare(p->comm, slabs.first[slabs.n], &slab[0], &slab[1]);
  ParticlesShare(p->comm, SurfacePoints(scene, walls), &point[0], &point[1]);
  UserCheck(all[0] > 0, "the bodies leave no room for fluid at dx = %.4g", (double)scene->dx);
  p->N_lattice      = all[0];
  p->N_fluid        = start ? start->N : all[0];
  p->N_wall         = slabs.first[slabs.n] + all[1] + SurfacePoints(scene, walls);
  p->n_fluid        = start ? start->n : own[0];
  p->n_wall         = slab[1] - slab[0] + own[1] + point[1] - point[0];
  p->N_start[0]     = p->N_fluid;
  p->N_start[1]     = p->N_wall;
  p->next_id        = (PetscInt64)p->N_fluid + p->N_wall;
  p->velocity_given = start && start->u;
  PetscCall(ParticlesReserve(p, ParticlesOwn(p)));
  wall = p->n_fluid;
  for (PetscInt k = slab[0]; k < slab[1]; k++) WallParticle(scene, walls, &slabs, k, p, wall++);
  for (PetscInt k = point[0]; k < point[1]; k++)
    SurfaceParticle(scene, walls, k, p->N_fluid + slabs.first[slabs.n] + k, p, wall++);
  dummy = p->N_fluid + slabs.first[slabs.n] + SurfacePoints(scene, walls) + before[1];
  FillCells(scene, walls, first, last, start ? -1 : before[0], wall, dummy, p);
  if (start) PetscCall(GivenFill(scene, start, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}
