/* Numbers that verify a checkpoint: names, checksums, and the table of numbers that identify a
   scene. */
#include "checkpoint.h"
#include <string.h>

/* CheckpointMemory - Lists the names of the numbers that a run keeps from step to step, "t,dt,...";
   not collective */
PetscErrorCode CheckpointMemory(const Memory *memory, char names[], size_t length)
{
  PetscFunctionBegin;
  names[0] = '\0';
  for (PetscInt k = 0; k < memory->n; k++) {
    if (k) TextAppend(names, length, ",");
    TextAppend(names, length, memory->item[k].name);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the text of an option to a checksum. */
static PetscErrorCode SumOption(const char option[], uint64_t *sum)
{
  const char *text;
  PetscBool   given;

  PetscFunctionBegin;
  PetscCall(OptionTyped(option, &text, &given));
  CheckpointSumText(text, sum);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CheckpointRecord - Lists the fields of a particle's record and their components,
   "id,kind,x:2,u:2,p:1"; not collective */
PetscErrorCode CheckpointRecord(const Particles *p, char names[], size_t length)
{
  PetscFunctionBegin;
  PetscCall(PetscStrncpy(names, "id,kind", length));
  for (PetscInt f = 0; f < p->n_fields; f++) {
    char part[64];

    PetscCall(PetscSNPrintf(part, sizeof(part), ",%s:%" PetscInt_FMT, p->field[f].name,
                            p->field[f].components));
    TextAppend(names, length, part);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a word to a hash: FNV-1a for words instead of bytes, with a shift added. */
static uint64_t HashWord(uint64_t hash, uint64_t word)
{
  hash = (hash ^ word) * 1099511628211u;
  return hash ^ hash >> 29;
}

#define HASH_OF_NOTHING 14695981039346656037u

/* CheckpointSumNumbers - Adds a checksum of n numbers. Not collective. For numbers that are equal
   on all ranks; for distributed records see CheckpointSumRecords(). */
void CheckpointSumNumbers(PetscInt n, const double numbers[], uint64_t *sum)
{
  uint64_t hash = HASH_OF_NOTHING;

  for (PetscInt k = 0; k < n; k++) {
    uint64_t word;

    memcpy(&word, &numbers[k], sizeof(word));
    hash = HashWord(hash, word);
  }
  *sum += hash;
}

/* CheckpointSumText - Adds a checksum of a text; not collective */
void CheckpointSumText(const char text[], uint64_t *sum)
{
  uint64_t hash = HASH_OF_NOTHING;

  for (const char *c = text; *c; c++) hash = HashWord(hash, (unsigned char)*c);
  *sum += hash;
}

/* CheckpointSumRecords - Adds a checksum of the records of all ranks, which is the same in any
   order; collective */
PetscErrorCode CheckpointSumRecords(PetscInt n, PetscInt width, const PetscReal record[],
                                    uint64_t *sum)
{
  uint64_t records = 0;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; i++)
    CheckpointSumNumbers(width, &record[(size_t)i * width], &records);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &records, 1, MPI_UINT64_T, MPI_SUM, PETSC_COMM_WORLD));
  *sum += records;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CheckpointSumKept - Adds a checksum of the n numbers of this rank, the first of which has the
   number `start`; collective */
PetscErrorCode CheckpointSumKept(PetscInt start, PetscInt n, const PetscReal values[],
                                 uint64_t *sum)
{
  PetscReal *pair;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(2 * (size_t)n, &pair));
  for (PetscInt i = 0; i < n; i++) {
    pair[2 * i]     = (PetscReal)(start + i);
    pair[2 * i + 1] = values[i];
  }
  PetscCall(CheckpointSumRecords(n, 2, pair, sum));
  PetscCall(PetscFree(pair));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SceneBox(const Scene *scene, double value[])
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    value[2 * a]     = scene->lo[a];
    value[2 * a + 1] = scene->hi[a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SceneSpacings(const Scene *scene, double value[])
{
  PetscFunctionBegin;
  value[0] = scene->dx;
  value[1] = scene->dx * scene->spacing_wall;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes a checksum of isotropic grading, zero without it: a restart would not move particles. */
static PetscErrorCode SceneGrading(const Scene *scene, double value[])
{
  uint64_t sum = 0;

  PetscFunctionBegin;
  value[0] = 0.0;
  if (!scene->grading.on) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SumOption("-spacing", &sum));
  CheckpointSumNumbers(1, &scene->grading.growth, &sum);
  value[0] = (double)(sum >> 16);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a shape to a checksum. */
static void SumShape(const Body *body, uint64_t *sum)
{
  CheckpointSumText(body->shape->name, sum);
  CheckpointSumNumbers(body->n, body->parameter, sum);
  if (body->shape->ends) CheckpointSumNumbers(2, body->ends, sum);
}

/* Computes a checksum of the shapes of all bodies and of the regions filled at the start. */
static PetscErrorCode SceneShapes(const Scene *scene, double value[])
{
  uint64_t sum = 0;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < scene->n_bodies; k++) {
    char option[64], name[WALL_NAME];

    SumShape(SceneBody(scene, k), &sum);
    SceneWallName(scene, SceneBodySide(scene, k), name);
    PetscCall(PetscSNPrintf(option, sizeof(option), "-scene_%s_place", name));
    if (SceneBody(scene, k)->pose) PetscCall(SumOption(option, &sum));
  }
  for (PetscInt k = 0; k < scene->n_filled; k++) SumShape(&scene->filled[k], &sum);
  value[0] = (double)(sum >> 16); /* a double holds 48 bits exactly */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes a checksum of the viscosities if each particle stores its own, otherwise zero. The
   options of a restart would not change stored viscosities. */
static PetscErrorCode SceneViscosities(const Scene *scene, double value[])
{
  const double nu  = scene->nu;
  uint64_t     sum = 0;

  PetscFunctionBegin;
  value[0] = 0.0;
  if (!SceneViscosityVaries(scene) || !SceneIsNewtonian(scene)) PetscFunctionReturn(PETSC_SUCCESS);
  CheckpointSumNumbers(1, &nu, &sum);
  PetscCall(SumOption("-viscosity_field", &sum));
  for (PetscInt k = 1; k <= scene->n_regions; k++) {
    char option[64];

    PetscCall(PetscSNPrintf(option, sizeof(option), "-scene_fluid_%" PetscInt_FMT, k));
    PetscCall(SumOption(option, &sum));
    CheckpointSumNumbers(1, &scene->region_nu[k - 1], &sum);
    CheckpointSumNumbers(1, &scene->region_density[k - 1], &sum);
    CheckpointSumNumbers(1, &scene->region_tension[k - 1], &sum);
    SumShape(&scene->region[k - 1], &sum);
  }
  value[0] = (double)(sum >> 16);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SceneDensity(const Scene *scene, double value[])
{
  PetscFunctionBegin;
  value[0] = scene->rho;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies the random displacement of the lattice at the start, and a flag for given particles; a
   restart would repeat neither. */
static PetscErrorCode SceneStart(const Scene *scene, double value[])
{
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(OptionGiven("-particles", &given));
  value[0] = scene->jitter;
  value[1] = scene->jitter > 0.0 ? (double)scene->seed : 0.0;
  value[2] = given ? 1.0 : 0.0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const SceneEntry entries[] = {
    {.name      = "scene_box",
     .n         = 2 * ISPH_MAX_DIM,
     .tolerance = 1e-9,
     .refusal   = "the file has another box or spacing",
     .Compute   = SceneBox},
    {.name      = "scene_spacing",
     .n         = 2,
     .tolerance = 1e-9,
     .refusal   = "the file has another box or spacing",
     .Compute   = SceneSpacings},
    {.name    = "scene_grading",
     .n       = 1,
     .refusal = "the file has another spacing; use the same -spacing and -spacing_growth",
     .Compute = SceneGrading},
    {.name    = "scene_bodies",
     .n       = 1,
     .refusal = "the file has other bodies",
     .Compute = SceneShapes},
    {.name    = "scene_viscosities",
     .n       = 1,
     .refusal = "particles carry the viscosities of the file's run; use the same -viscosity "
                "(or -reynolds), -viscosity_field and -scene_fluid_ options",
     .Compute = SceneViscosities},
    {.name    = "scene_density",
     .n       = 1,
     .refusal = "the file has another density; use the same -density",
     .Compute = SceneDensity},
    {.name = "scene_start",
     .n    = 3,
     .refusal =
         "particles of the file's run started from other places; use the same -jitter, -seed "
         "and -particles",
     .Compute = SceneStart},
};

/* CheckpointSceneEntry - Returns entry k of the numbers that identify a scene, NULL after the last;
   not collective */
const SceneEntry *CheckpointSceneEntry(PetscInt k)
{
  return k < (PetscInt)PETSC_STATIC_ARRAY_LENGTH(entries) ? &entries[k] : NULL;
}
