/* Halos: copies of particles of other ranks, and of own particles as periodic images, within reach
   = halo_width + skin of the box of a rank. Within an epoch the list is constant, and a PetscSF
   transports values from owners (roots) to copies (leaves). */
#include "impl.h"

/* A copy that a rank needs: local index of the particle at its owner, and shift in periods. */
typedef struct {
  PetscInt root, is_wall, image[ISPH_MAX_DIM];
} HaloItem;
#define HALO_ITEM_WIDTH ((PetscInt)(sizeof(HaloItem) / sizeof(PetscInt)))

typedef struct {
  HaloItem *item;
  PetscInt *rank; /* receiving rank */
  PetscInt  n, capacity;
} HaloList;

static PetscErrorCode HaloListAppend(HaloList *list, PetscInt rank, HaloItem item)
{
  PetscFunctionBegin;
  if (list->n == list->capacity) {
    list->capacity = 2 * list->capacity + 256;
    PetscCall(PetscRealloc(sizeof(HaloItem) * (size_t)list->capacity, &list->item));
    PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)list->capacity, &list->rank));
  }
  list->item[list->n] = item;
  list->rank[list->n] = rank;
  list->n++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the ranks of [begin, end) whose boxes intersect a cube of half side `reach` around y. */
static void RanksTouched(const Particles *p, const PetscReal y[], PetscReal reach, PetscInt begin,
                         PetscInt end, PetscInt touched[], PetscInt *n)
{
  const PetscInt m = (begin + end) / 2;

  if (end - begin == 1) {
    touched[(*n)++] = begin;
    return;
  }
  if (y[p->cut_axis[m]] - reach < p->cut[m]) RanksTouched(p, y, reach, begin, m, touched, n);
  if (y[p->cut_axis[m]] + reach >= p->cut[m]) RanksTouched(p, y, reach, m, end, touched, n);
}

/* Lists an image of own particle i for all ranks that need it. The image without shift is the
   particle itself, which this rank has. */
static PetscErrorCode ListImage(const Scene *scene, const Particles *p, PetscReal reach, PetscInt i,
                                const PetscInt image[], PetscInt touched[], HaloList *list)
{
  HaloItem    item = {.root = i, .is_wall = ParticlesIsWall(p, i)};
  PetscReal   y[ISPH_MAX_DIM];
  PetscInt    n = 0, moved = 0;
  PetscMPIInt rank, ranks;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(p->comm, &rank));
  PetscCallMPI(MPI_Comm_size(p->comm, &ranks));
  for (PetscInt a = 0; a < p->dim; a++) {
    y[a]          = p->x[a][i] + image[a] * (scene->hi[a] - scene->lo[a]);
    item.image[a] = image[a];
    moved         = moved || image[a] != 0;
  }
  RanksTouched(p, y, reach, 0, ranks, touched, &n);
  for (PetscInt k = 0; k < n; k++) {
    if (touched[k] != rank || moved) PetscCall(HaloListAppend(list, touched[k], item));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists all copies of own particles. If a period is short, several images are within reach. */
static PetscErrorCode ListImages(const Scene *scene, const Particles *p, HaloList *list)
{
  const PetscReal reach = (1.0 + 1e-9) * (p->halo_width + p->skin);
  PetscInt       *touched, image[ISPH_MAX_DIM];
  PetscMPIInt     ranks;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(p->comm, &ranks));
  PetscCall(PetscMalloc1(ranks, &touched));
  for (PetscInt i = 0; i < ParticlesOwn(p); i++) {
    PetscInt  first[ISPH_MAX_DIM] = {0}, last[ISPH_MAX_DIM] = {0};
    PetscBool inside = PETSC_TRUE;

    for (PetscInt a = 0; a < p->dim; a++) {
      const PetscReal period = scene->hi[a] - scene->lo[a], x = p->x[a][i];

      if (x - reach >= p->lo[a] && x + reach < p->hi[a]) continue;
      inside = PETSC_FALSE;
      if (!SceneIsPeriodic(scene, a)) continue;
      first[a] = (PetscInt)PetscCeilReal((scene->lo[a] - reach - x) / period);
      last[a]  = (PetscInt)PetscFloorReal((scene->hi[a] + reach - x) / period);
    }
    if (inside) continue;
    for (image[2] = first[2]; image[2] <= last[2]; image[2]++) {
      for (image[1] = first[1]; image[1] <= last[1]; image[1]++) {
        for (image[0] = first[0]; image[0] <= last[0]; image[0]++) {
          PetscCall(ListImage(scene, p, reach, i, image, touched, list));
        }
      }
    }
  }
  PetscCall(PetscFree(touched));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sorts the list by rank; the order of particles within a rank stays. */
static PetscErrorCode HaloListPack(const HaloList *list, PetscMPIInt ranks, PetscInt n_to[],
                                   HaloItem **packed)
{
  PetscInt *next;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(list->n, packed));
  PetscCall(PetscCalloc1(ranks + 1, &next));
  for (PetscInt k = 0; k < list->n; k++) n_to[list->rank[k]]++;
  for (PetscMPIInt r = 0; r < ranks; r++) next[r + 1] = next[r] + n_to[r];
  for (PetscInt k = 0; k < list->n; k++) (*packed)[next[list->rank[k]]++] = list->item[k];
  PetscCall(PetscFree(next));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Allocates halo particles for the received items, fluid before walls, and sets up the PetscSF that
   fills them. */
static PetscErrorCode HaloConnect(const Scene *scene, Particles *p, PetscMPIInt n_sources,
                                  const PetscMPIInt source[], const PetscInt n_from[],
                                  const HaloItem items[])
{
  PetscInt     n = 0, k = 0, fluid = 0, wall = 0;
  PetscSFNode *root;

  PetscFunctionBegin;
  for (PetscMPIInt s = 0; s < n_sources; s++) n += n_from[s];
  for (PetscInt j = 0; j < n; j++) wall += items[j].is_wall;
  p->n_halo_fluid = n - wall;
  p->n_halo_wall  = wall;
  wall            = p->n_halo_fluid;
  PetscCall(ParticlesReserve(p, ParticlesAll(p)));
  PetscCall(PetscMalloc1(n, &root));
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(PetscFree(p->halo_shift[a]));
    PetscCall(PetscMalloc1(n, &p->halo_shift[a]));
  }
  for (PetscMPIInt s = 0; s < n_sources; s++) {
    for (PetscInt j = 0; j < n_from[s]; j++, k++) {
      const PetscInt leaf = items[k].is_wall ? wall++ : fluid++;

      root[leaf].rank  = source[s];
      root[leaf].index = items[k].root;
      for (PetscInt a = 0; a < p->dim; a++) {
        p->halo_shift[a][leaf] = items[k].image[a] * (scene->hi[a] - scene->lo[a]);
      }
    }
  }
  PetscCall(
      PetscSFSetGraph(p->sf, ParticlesOwn(p), n, NULL, PETSC_OWN_POINTER, root, PETSC_OWN_POINTER));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies an array from owners to copies. */
static PetscErrorCode HaloCopy(const Particles *p, MPI_Datatype unit, const void *own, void *copies)
{
  PetscFunctionBegin;
  PetscCall(PetscSFBcastBegin(p->sf, unit, own, copies, MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(p->sf, unit, own, copies, MPI_REPLACE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fills halo values that are constant within the epoch, and the positions of the halo. */
static PetscErrorCode HaloFill(Particles *p)
{
  const PetscInt own = ParticlesOwn(p);

  PetscFunctionBegin;
  PetscCall(HaloCopy(p, MPIU_INT64, p->id, p->id + own));
  PetscCall(HaloCopy(p, MPIU_ENUM, p->kind, p->kind + own));
  PetscCall(HaloCopy(p, MPIU_INT, p->row, p->row + own));
  for (PetscInt f = 0; f < p->n_fields; f++) {
    if (p->field[f].halo != HALO_EPOCH) continue;
    for (PetscInt c = 0; c < p->field[f].components; c++) {
      PetscCall(ParticlesHaloField(p, p->field[f].slot[c]));
    }
  }
  PetscCall(ParticlesUpdateHalo(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* HaloBuild - Finds the particles whose copies each rank needs, and copies them. Collective. Input:
   scene - the scene; p - own particles: migrated, sorted and wrapped into periodic boxes. Output: p
   - halo counts, sf, halo_shift; halo values of id, kind, row, x and the fields of HALO_EPOCH. */
PetscErrorCode HaloBuild(const Scene *scene, Particles *p)
{
  HaloList    list = {0};
  HaloItem   *sent, *received;
  PetscMPIInt ranks, n_sources, *source;
  PetscInt   *n_to, *n_from;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(p->comm, &ranks));
  PetscCall(PetscCalloc1(ranks, &n_to));
  PetscCall(ListImages(scene, p, &list));
  PetscCall(HaloListPack(&list, ranks, n_to, &sent));
  PetscCall(ExchangeItems(p->comm, MPIU_INT, HALO_ITEM_WIDTH, n_to, sent, &n_sources, &source,
                          &n_from, &received));
  PetscCall(HaloConnect(scene, p, n_sources, source, n_from, received));
  PetscCall(HaloFill(p));
  PetscCall(FreeAll(&received, &n_from, &source, &sent, &list.item, &list.rank, &n_to));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ParticlesUpdateHalo - Updates positions in the halo from their owners

    x_copy = x_owner + shift

  Collective. Input: particles - the particles, with new positions of own particles. Note: call it
  after each change of own positions that did not start an epoch. It increases the stamp `moved`;
  neighbours and matrices compare it to detect that they are out of date.
*/
PetscErrorCode ParticlesUpdateHalo(Particles *particles)
{
  Particles     *p   = particles;
  const PetscInt own = ParticlesOwn(p), n_halo = ParticlesAll(p) - own;

  PetscFunctionBegin;
  PetscCall(ParticlesHaloComponents(p, p->x));
  for (PetscInt a = 0; a < p->dim; a++)
    for (PetscInt k = 0; k < n_halo; k++) p->x[a][own + k] += p->halo_shift[a][k];
  p->moved++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ParticlesHaloField - Copies values of own particles to the halo. Collective. Input: particles -
   the particles. Input/Output: values - by local index: reads values of own particles, writes
   values of the halo. */
PetscErrorCode ParticlesHaloField(const Particles *particles, PetscReal values[])
{
  PetscFunctionBegin;
  PetscCall(HaloCopy(particles, MPIU_REAL, values, values + ParticlesOwn(particles)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ParticlesHaloVectors - Copies vectors of own particles to the halo: values of component a of
   particle j at [j dim + a], see ParticlesHaloField(); collective */
PetscErrorCode ParticlesHaloVectors(const Particles *p, PetscReal values[])
{
  PetscFunctionBegin;
  PetscCall(HaloCopy(p, p->vector, values, values + p->dim * ParticlesOwn(p)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ParticlesHaloComponents - Copies dim arrays of own particles to the halo, see
   ParticlesHaloField(), with one message to each rank; collective */
PetscErrorCode ParticlesHaloComponents(const Particles *p, PetscReal *const values[])
{
  const PetscInt own = ParticlesOwn(p), all = ParticlesAll(p), d = p->dim;
  PetscReal     *together;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(d * all, &together));
  for (PetscInt a = 0; a < d; a++)
    for (PetscInt i = 0; i < own; i++) together[i * d + a] = values[a][i];
  PetscCall(ParticlesHaloVectors(p, together));
  for (PetscInt a = 0; a < d; a++)
    for (PetscInt i = own; i < all; i++) values[a][i] = together[i * d + a];
  PetscCall(PetscFree(together));
  PetscFunctionReturn(PETSC_SUCCESS);
}
