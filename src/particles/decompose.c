/* Recursive coordinate bisection: groups of ranks and their regions of space are halved until each
   rank has a box. All boxes then hold about the same work of fluid particles. Histograms of it over
   positions, summed over ranks, determine the cuts of all groups of a level together; no particle
   migrates before all cuts are known. The work is counted, not timed, so that a run can be
   repeated. */
#include "impl.h"

#define BISECT_BINS      64   /* of one round's histogram */
#define BISECT_IMBALANCE 1.1  /* max / mean of the work above which new boxes are computed */
#define BISECT_FINENESS  0.01 /* accuracy of a cut [dx] */

/* A group of ranks [begin, end) whose region is to be cut. */
typedef struct {
  PetscInt  begin, end;
  PetscInt  axis;       /* normal to the cut */
  PetscReal low, width; /* first edge and width of the histogram's bins [m] */
  PetscReal below;      /* work below the first edge */
  PetscReal target;     /* desired work below the cut; negative: unknown */
  PetscReal cut, miss;  /* best edge so far [m], and the deviation of the work from the target */
} Group;

static inline PetscInt MiddleRank(PetscInt begin, PetscInt end)
{
  return (begin + end) / 2;
}

static inline PetscInt OwnerAt(const Particles *p, PetscMPIInt ranks, const PetscReal x[])
{
  PetscInt begin = 0, end = ranks;

  while (end - begin > 1) {
    const PetscInt m = MiddleRank(begin, end);
    if (x[p->cut_axis[m]] < p->cut[m]) end = m;
    else begin = m;
  }
  return begin;
}

static PetscInt OwnerOf(const Particles *p, PetscMPIInt ranks, PetscInt i)
{
  PetscReal x[ISPH_MAX_DIM];

  for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
  return OwnerAt(p, ranks, x);
}

/* ParticlesRankAt - Returns the rank whose box contains a position in the box of the scene */
PetscInt ParticlesRankAt(const Particles *p, const PetscReal x[])
{
  PetscMPIInt ranks;

  if (MPI_Comm_size(p->comm, &ranks)) return 0;
  return OwnerAt(p, ranks, x);
}

/* Restricts the box [lo, hi] to the region that the cuts give to ranks [begin, end). */
static void CutOutBox(const Particles *p, PetscMPIInt ranks, PetscInt begin, PetscInt end,
                      PetscReal lo[], PetscReal hi[])
{
  PetscInt b = 0, e = ranks;

  while (b < begin || e > end) {
    const PetscInt m = MiddleRank(b, e), axis = p->cut_axis[m];
    if (begin < m) {
      hi[axis] = PetscMin(hi[axis], p->cut[m]);
      e        = m;
    } else {
      lo[axis] = PetscMax(lo[axis], p->cut[m]);
      b        = m;
    }
  }
}

/* Chooses for each group the axis of its cut, along the longest side of the box around its
   particles, and the bins of its first histogram. */
static PetscErrorCode GroupsStart(const Scene *scene, const Particles *p, PetscMPIInt ranks,
                                  const PetscInt of[], PetscInt n_groups, Group groups[])
{
  const PetscInt dim = p->dim;
  PetscReal     *bound; /* smallest x, smallest -x of each group */

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(2 * dim * n_groups, &bound));
  for (PetscInt k = 0; k < 2 * dim * n_groups; k++) bound[k] = PETSC_MAX_REAL;
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    if (of[i] < 0) continue;
    for (PetscInt a = 0; a < dim; a++) {
      PetscReal *b = &bound[2 * (dim * of[i] + a)];
      b[0]         = PetscMin(b[0], p->x[a][i]);
      b[1]         = PetscMin(b[1], -p->x[a][i]);
    }
  }
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, bound, 2 * dim * n_groups, MPIU_REAL, MPIU_MIN, p->comm));
  for (PetscInt k = 0; k < n_groups; k++) {
    Group    *g = &groups[k];
    PetscReal lo[ISPH_MAX_DIM], hi[ISPH_MAX_DIM];

    PetscCall(PetscArraycpy(lo, scene->lo, dim));
    PetscCall(PetscArraycpy(hi, scene->hi, dim));
    CutOutBox(p, ranks, g->begin, g->end, lo, hi);
    for (PetscInt a = 0; a < dim && bound[2 * dim * k] < PETSC_MAX_REAL; a++) {
      lo[a] = bound[2 * (dim * k + a)];
      hi[a] = -bound[2 * (dim * k + a) + 1];
    }
    g->axis = 0;
    for (PetscInt a = 1; a < dim; a++) {
      if (hi[a] - lo[a] > (1.0 + 1e-6) * (hi[g->axis] - lo[g->axis])) g->axis = a;
    }
    g->low    = lo[g->axis] - 0.25 * SceneFinest(scene);
    g->width  = (hi[g->axis] - lo[g->axis] + 0.5 * SceneFinest(scene)) / BISECT_BINS;
    g->cut    = 0.5 * (lo[g->axis] + hi[g->axis]);
    g->below  = 0.0;
    g->target = -1.0;
    g->miss   = PETSC_MAX_REAL;
  }
  PetscCall(PetscFree(bound));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the bin that holds x, or -1. Rounding is corrected by a comparison of x with the edges,
   as OwnerOf() compares it with a cut. */
static inline PetscInt BinOf(const Group *g, PetscReal x)
{
  const PetscReal s = (x - g->low) / g->width;
  PetscInt        k;

  if (!(s > -1.0 && s < BISECT_BINS + 1.0)) return -1;
  k = (PetscInt)PetscFloorReal(s);
  if (x < g->low + k * g->width) k--;
  else if (x >= g->low + (k + 1) * g->width) k++;
  return k < 0 || k >= BISECT_BINS ? -1 : k;
}

/* Selects as the cut of a group the edge of its histogram below which the work is nearest to the
   target, and restricts the next histogram to the bin that holds the target. */
static void GroupZoom(Group *g, const PetscInt histogram[])
{
  PetscReal below = g->below, next_low = g->low, next_below = g->below;

  if (g->target < 0.0) {
    PetscReal total = 0.0;
    for (PetscInt k = 0; k < BISECT_BINS; k++) total += histogram[k];
    g->target = total * (MiddleRank(g->begin, g->end) - g->begin) / (g->end - g->begin);
    if (total == 0.0) g->miss = 0.0; /* no particles: keep the middle */
  }
  for (PetscInt k = 0; k <= BISECT_BINS; k++) {
    const PetscReal edge = g->low + k * g->width, miss = PetscAbsReal(below - g->target);

    if (miss < g->miss) {
      g->miss = miss;
      g->cut  = edge;
    }
    if (k == BISECT_BINS) break;
    if (below <= g->target) {
      next_low   = edge;
      next_below = below;
    }
    below += histogram[k];
  }
  g->low   = next_low;
  g->below = next_below;
  g->width /= BISECT_BINS;
}

/* Computes a histogram for all groups and refines their cuts. */
static PetscErrorCode GroupsZoom(const Particles *p, const PetscInt of[], PetscInt n_groups,
                                 Group groups[])
{
  PetscInt *histogram;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(n_groups * BISECT_BINS, &histogram));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscInt bin;

    if (of[i] < 0) continue;
    bin = BinOf(&groups[of[i]], p->x[groups[of[i]].axis][i]);
    if (bin >= 0) histogram[of[i] * BISECT_BINS + bin]++;
  }
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, histogram, n_groups * BISECT_BINS, MPIU_INT, MPI_SUM, p->comm));
  for (PetscInt k = 0; k < n_groups; k++) GroupZoom(&groups[k], &histogram[k * BISECT_BINS]);
  PetscCall(PetscFree(histogram));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Records the cuts of a level; halves with more than a single rank become groups of the next
   level. */
static PetscErrorCode GroupsSplit(Particles *p, PetscInt of[], PetscInt *n_groups, Group groups[])
{
  PetscInt n = 0, *child;
  Group   *parents;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(2 * *n_groups, &child, *n_groups, &parents));
  PetscCall(PetscArraycpy(parents, groups, *n_groups));
  for (PetscInt k = 0; k < 2 * *n_groups; k++) {
    const Group   *g     = &parents[k / 2];
    const PetscInt m     = MiddleRank(g->begin, g->end);
    const PetscInt begin = k % 2 ? m : g->begin, end = k % 2 ? g->end : m;

    p->cut_axis[m] = g->axis;
    p->cut[m]      = g->cut;
    child[k]       = end - begin > 1 ? n : -1;
    if (child[k] >= 0) groups[n++] = (Group){.begin = begin, .end = end};
  }
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    if (of[i] < 0) continue;
    of[i] = child[2 * of[i] + (p->x[parents[of[i]].axis][i] < parents[of[i]].cut ? 0 : 1)];
  }
  *n_groups = n;
  PetscCall(PetscFree2(child, parents));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Bisect(const Scene *scene, Particles *p, PetscMPIInt ranks)
{
  PetscInt n_groups = ranks > 1 ? 1 : 0, *of;
  Group   *groups;

  PetscFunctionBegin;
  PetscCall(PetscCalloc2(p->n_fluid, &of, ranks, &groups));
  groups[0] = (Group){.begin = 0, .end = ranks};
  while (n_groups > 0) {
    PetscReal widest = PETSC_MAX_REAL;

    PetscCall(GroupsStart(scene, p, ranks, of, n_groups, groups));
    while (widest > BISECT_FINENESS * SceneFinest(scene)) {
      PetscCall(GroupsZoom(p, of, n_groups, groups));
      widest = 0.0;
      for (PetscInt k = 0; k < n_groups; k++) {
        widest = PetscMax(widest, groups[k].width * BISECT_BINS);
      }
    }
    PetscCall(GroupsSplit(p, of, &n_groups, groups));
  }
  PetscCall(PetscFree2(of, groups));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the owners of own particles by the present boxes, and the imbalance: the largest over the
   mean work of the fluid in a box. */
static PetscErrorCode FindOwners(const Particles *p, PetscMPIInt ranks, PetscInt owner[],
                                 PetscReal *imbalance)
{
  PetscInt *load, most = 0, all = 0;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(ranks, &load));
  for (PetscInt i = 0; i < ParticlesOwn(p); i++) {
    owner[i] = OwnerOf(p, ranks, i);
    if (i < p->n_fluid) load[owner[i]]++;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, load, ranks, MPIU_INT, MPI_SUM, p->comm));
  for (PetscMPIInt r = 0; r < ranks; r++) {
    most = PetscMax(most, load[r]);
    all += load[r];
  }
  *imbalance = (PetscReal)most * ranks / PetscMax(all, 1);
  PetscCall(PetscFree(load));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ParticlesDecompose - Finds the new owner of each own particle, and sets the box of this rank.
   Collective. Input: scene - the scene; p - the particles, wrapped into periodic boxes. Output:
   owner - new owner of each own particle, fluid and wall; p - cut_axis, cut, lo and hi are set.
   Notes: New boxes are computed in the first epoch, if p->redraw is set, and if a box holds more
   than 1.1 times the mean work of fluid particles. Along axes that are not periodic the outer boxes
   are infinite, because walls lie outside the scene's box. */
PetscErrorCode ParticlesDecompose(const Scene *scene, Particles *p, PetscInt owner[])
{
  PetscMPIInt rank, ranks;
  PetscReal   imbalance = PETSC_MAX_REAL;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(p->comm, &rank));
  PetscCallMPI(MPI_Comm_size(p->comm, &ranks));
  if (p->epoch > 0 && !p->redraw) PetscCall(FindOwners(p, ranks, owner, &imbalance));
  if (imbalance > BISECT_IMBALANCE) {
    PetscCall(Bisect(scene, p, ranks));
    p->redraw = PETSC_FALSE;
    PetscCall(FindOwners(p, ranks, owner, &imbalance));
  }
  for (PetscInt a = 0; a < p->dim; a++) {
    p->lo[a] = SceneIsPeriodic(scene, a) ? scene->lo[a] : PETSC_NINFINITY;
    p->hi[a] = SceneIsPeriodic(scene, a) ? scene->hi[a] : PETSC_INFINITY;
  }
  CutOutBox(p, ranks, rank, rank + 1, p->lo, p->hi);
  PetscFunctionReturn(PETSC_SUCCESS);
}
