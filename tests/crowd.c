/* Creates, gathers and moves the crowd of crowd.h, and compares its neighbours with a search over
   all pairs. */
#include "crowd.h"

static const CaseRow problem = {.name = "test", .brief = "", .citation = ""};

Setting CrowdBox(const char *name, PetscInt dim, PetscInt nx, PetscInt ny, PetscInt nz,
                 PetscInt n_periodic, PetscInt layers)
{
  Setting        s     = {.name = name, .walls = {.layers = layers}};
  const PetscInt n[3]  = {nx, ny, nz};
  Scene         *scene = &s.scene;

  scene->problem = &problem;
  scene->physics = PHYSICS_PRESSURE | (n_periodic < dim ? PHYSICS_WALLS : 0);
  scene->dim     = dim;
  scene->n       = nx;
  scene->dx      = 0.1;
  scene->jitter  = 0.2;
  scene->seed    = 7;
  for (PetscInt a = 0; a < dim; a++) {
    scene->lo[a]    = -0.3 + 0.7 * a;
    scene->hi[a]    = scene->lo[a] + n[a] * scene->dx;
    scene->cells[a] = n[a];
    SceneSetAxis(scene, a, a < n_periodic ? &BoundaryPeriodic : &BoundaryWall);
  }
  return s;
}

void CrowdGather(const Particles *p, All *all)
{
  all->n = (PetscInt)p->next_id;
  PetscCallVoid(PetscCalloc3(all->n * p->dim, &all->x, all->n, &all->found, all->n, &all->edge));
  for (PetscInt i = 0; i < ParticlesOwn(p); i++) {
    all->found[p->id[i]] += 1.0;
    all->edge[p->id[i]] = ParticlesLargestEdge(p, i);
    for (PetscInt a = 0; a < p->dim; a++) all->x[p->dim * p->id[i] + a] = p->x[a][i];
  }
  MPI_Allreduce(MPI_IN_PLACE, all->x, (int)(all->n * p->dim), MPIU_REAL, MPI_SUM, p->comm);
  MPI_Allreduce(MPI_IN_PLACE, all->found, (int)all->n, MPIU_REAL, MPI_SUM, p->comm);
  MPI_Allreduce(MPI_IN_PLACE, all->edge, (int)all->n, MPIU_REAL, MPI_SUM, p->comm);
}

void CrowdFree(All *all)
{
  PetscCallVoid(PetscFree3(all->x, all->found, all->edge));
}

/* Returns the square of the larger of the radii of two particles, which follow from the largest
   edges of their cells. */
static PetscReal PairRadius2(const Neighbors *nb, PetscReal edge, PetscReal other)
{
  return PetscSqr(nb->radius * (PetscMax(edge, other) / nb->spacing));
}

/* Returns a fixed pseudo-random number in (-1, 1) for each particle and k. */
PetscReal CrowdNoise(PetscInt id, PetscInt k)
{
  const PetscReal s = PetscSinReal(12.9898 * (id + 1) + 78.233 * (k + 1)) * 43758.5453;
  return 2.0 * (s - PetscFloorReal(s)) - 1.0;
}

/* Moves each fluid particle by at most `length` along each axis and keeps it inside the walls. */
void CrowdMove(const Scene *scene, Particles *p, PetscReal length)
{
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    for (PetscInt a = 0; a < p->dim; a++) {
      const PetscReal margin = 0.3 * scene->dx;

      p->x[a][i] += length * CrowdNoise(p->id[i], a);
      if (SceneIsPeriodic(scene, a)) continue;
      p->x[a][i] = PetscMin(PetscMax(p->x[a][i], scene->lo[a] + margin), scene->hi[a] - margin);
    }
  }
}

PetscReal CrowdTag(PetscInt id, PetscInt c)
{
  return 3.0 * id + 0.25 * c;
}

/* Checks that each id occurs once, that numbers ascend, that values of fields stay with their
   particles, and that the position of each copy is the position of the owner plus its shift. */
void CrowdCheckParticles(const Setting *s, const Particles *p, PetscReal *const tag[])
{
  const PetscInt own = ParticlesOwn(p), dim = p->dim;
  const PetscInt N    = p->N_fluid + p->N_wall;
  PetscInt       lost = 0, strayed = 0, misplaced = 0, kinds = 0, unordered = 0, count[2];
  PetscReal     *numbered, found = 0.0;
  All            all;

  CrowdGather(p, &all);
  PetscCallVoid(PetscCalloc1(N, &numbered));
  for (PetscInt k = 0; k < all.n; k++) {
    lost += all.found[k] > 1.0;
    found += all.found[k];
  }
  lost += found != (PetscReal)N;
  for (PetscInt i = 0; i < own; i++) {
    numbered[p->row[i] + (i < p->n_fluid ? 0 : p->N_fluid)] += 1.0;
    unordered +=
        p->row[i] != (i < p->n_fluid ? p->fluid_start + i : p->wall_start + i - p->n_fluid);
  }
  MPI_Allreduce(MPI_IN_PLACE, numbered, (int)N, MPIU_REAL, MPI_SUM, p->comm);
  for (PetscInt k = 0; k < N; k++) lost += numbered[k] != 1.0;
  for (PetscInt i = 0; i < ParticlesAll(p); i++) {
    kinds += ParticlesIsWall(p, i) != (p->kind[i] == PARTICLE_WALL);
    for (PetscInt c = 0; c < 2; c++) strayed += tag[c][i] != CrowdTag(p->id[i], c);
    for (PetscInt a = 0; a < dim; a++) {
      const PetscReal shift = i < own ? 0.0 : p->halo_shift[a][i - own];
      const PetscReal error = p->x[a][i] - all.x[dim * p->id[i] + a] - shift;

      misplaced += PetscAbsReal(error) > 1e-13;
      if (!SceneIsPeriodic(&s->scene, a)) misplaced += shift != 0.0;
    }
  }
  count[0] = p->n_fluid;
  count[1] = p->n_wall;
  MPI_Allreduce(MPI_IN_PLACE, count, 2, MPIU_INT, MPI_SUM, p->comm);
  PetscCallVoid(PetscFree(numbered));
  CrowdFree(&all);
  CloudAssertNone("ids and numbers occur once", s->name, lost);
  CloudAssertNone("numbers ascend", s->name, unordered);
  CloudAssertNone("fields follow", s->name, strayed);
  CloudAssertNone("halo is owner plus shift", s->name, misplaced);
  CloudAssertNone("fluid or wall", s->name, kinds);
  CloudAssertNone("counts", s->name, (count[0] != p->N_fluid) + (count[1] != p->N_wall));
}

/* Computes the images along each axis, first to last, that may be within the radius of a particle;
   returns false if there is none. The others, most of 125 in a periodic box, take all the time. */
static PetscBool ImagesWithin(const Scene *scene, const PetscReal x[], const PetscReal centre[],
                              PetscReal radius, PetscInt first[], PetscInt last[])
{
  for (PetscInt a = 0; a < scene->dim; a++) {
    const PetscReal length = scene->hi[a] - scene->lo[a], d = x[a] - centre[a];

    if (SceneIsPeriodic(scene, a)) {
      first[a] = (PetscInt)PetscCeilReal(-(d + radius) / length);
      last[a]  = (PetscInt)PetscFloorReal((radius - d) / length);
    } else if (PetscAbsReal(d) > radius) {
      return PETSC_FALSE;
    }
    if (first[a] > last[a]) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Compares row i with all particles and images within the radius: their number, and a sum of
   distances weighted by ids. Returns the number of differences. */
static PetscInt RowErrors(const Scene *scene, const Particles *p, const Neighbors *nb,
                          const All *all, PetscInt i)
{
  const PetscInt dim   = p->dim;
  PetscInt       wrong = 0, close = 0, in_row = 0;
  PetscReal      sum_row = 0.0, sum_all = 0.0, edge = ParticlesLargestEdge(p, i);
  PetscReal      centre[3] = {0.0};

  for (PetscInt k = nb->row[i]; k < nb->row[i + 1]; k++) {
    const PetscInt j  = nb->col[k];
    PetscReal      r2 = 0.0;

    wrong += j == i || (k > nb->row[i] && nb->col[k - 1] >= j);
    for (PetscInt a = 0; a < dim; a++) r2 += PetscSqr(p->x[a][j] - p->x[a][i]);
    if (r2 >= PairRadius2(nb, edge, ParticlesLargestEdge(p, j))) continue;
    in_row++;
    sum_row += PetscSqrtReal(r2) * (1 + p->id[j]);
  }
  for (PetscInt a = 0; a < dim; a++) centre[a] = p->x[a][i];
  for (PetscInt id = 0; id < all->n; id++) {
    const PetscReal radius2 = PairRadius2(nb, edge, all->edge[id]), more = 1.001;
    PetscInt        first[3] = {0, 0, 0}, last[3] = {0, 0, 0};

    if (all->found[id] == 0.0 ||
        !ImagesWithin(scene, &all->x[dim * id], centre, more * PetscSqrtReal(radius2), first, last))
      continue;
    for (PetscInt c2 = first[2]; c2 <= last[2]; c2++) {
      for (PetscInt c1 = first[1]; c1 <= last[1]; c1++) {
        for (PetscInt c0 = first[0]; c0 <= last[0]; c0++) {
          const PetscInt image[3] = {c0, c1, c2};
          PetscReal      r2       = 0.0;

          if (id == p->id[i] && !c0 && !c1 && !c2) continue;
          for (PetscInt a = 0; a < dim; a++) {
            r2 += PetscSqr(all->x[dim * id + a] + image[a] * (scene->hi[a] - scene->lo[a]) -
                           centre[a]);
          }
          if (r2 >= radius2) continue;
          close++;
          sum_all += PetscSqrtReal(r2) * (1 + id);
        }
      }
    }
  }
  wrong += close != in_row || PetscAbsReal(sum_row - sum_all) > 1e-10 * (1.0 + sum_all);
  return wrong;
}

void CrowdCheckNeighbors(const Setting *s, const Particles *p, const Neighbors *nb)
{
  PetscInt wrong = 0;
  All      all;

  CrowdGather(p, &all);
  for (PetscInt i = 0; i < p->n_fluid; i++) wrong += RowErrors(&s->scene, p, nb, &all, i);
  CrowdFree(&all);
  CloudAssertNone("rows equal brute force", s->name, wrong);
}

/* Reads a scene's spacing from options. */
void CrowdReadSpacing(const char options[], Scene *scene)
{
  PetscOptions database;

  ASSERT_OK(PetscOptionsCreate(&database));
  ASSERT_OK(PetscOptionsInsertString(database, options));
  ASSERT_OK(PetscOptionsPush(database));
  ASSERT_OK(SceneReadSpacing(scene));
  ASSERT_OK(PetscOptionsPop());
  ASSERT_OK(PetscOptionsDestroy(&database));
}
