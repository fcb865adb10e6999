/* What a checkpoint holds besides particles: numbers of clock and scheme, and how both are
   verified. */
#include "checkpoint.h"
#include <string.h>

/* CheckpointPack - Numbers of clock and scheme as the file has them; not collective */
void CheckpointPack(const Run *run, double clock[], double stats[])
{
  const Clock     *c           = run->clock;
  const Scheme    *scheme      = run->scheme;
  const StepStats *s           = &scheme->stats;
  const double     c_numbers[] = {c->t,       c->dt,       c->dt_previous, c->step, c->next_report,
                                  c->retries, c->halvings, c->good_needed, c->good};
  const double     s_numbers[] = {s->speed_max,
                                  s->kinetic_energy,
                                  s->divergence,
                                  s->change[0],
                                  s->change[1],
                                  s->change[2],
                                  s->visc_its,
                                  s->ppe_its,
                                  s->visc_its_sum,
                                  s->ppe_its_sum,
                              scheme->visc      ? *ViscosityFalls(scheme->visc)
                                  : scheme->coupled ? *CoupledFalls(scheme->coupled)
                                                    : 0,
                              scheme->ppe ? *PressureFalls(scheme->ppe) : 0,
                                  s->force_max};

  for (PetscInt k = 0; k < CLOCK_NUMBERS; k++) clock[k] = c_numbers[k];
  for (PetscInt k = 0; k < STATS_NUMBERS; k++) stats[k] = s_numbers[k];
}

/*
  The first report to come at or after the clock's time: -report_times need not be those of the run
  that was stopped. One due at this very time has been made if that run had counted it.
*/
static PetscInt NextReport(const Clock *clock, PetscInt counted)
{
  PetscInt k = 0;

  while (k < clock->n_reports && clock->report_time[k] < clock->t * (1.0 - 1e-12)) k++;
  if (k < clock->n_reports && clock->report_time[k] <= clock->t * (1.0 + 1e-12) && counted > k) k++;
  return k;
}

/* CheckpointUnpack - And back; not collective */
void CheckpointUnpack(const double clock[], const double stats[], Run *run)
{
  Clock     *c      = run->clock;
  Scheme    *scheme = run->scheme;
  StepStats *s      = &scheme->stats;

  c->t           = clock[0];
  c->dt          = clock[1];
  c->dt_previous = clock[2];
  c->step        = (PetscInt)clock[3];
  c->t_first     = c->t;
  c->step_first  = c->step;
  c->next_report = NextReport(c, (PetscInt)clock[4]);
  c->retries     = (PetscInt)clock[5];
  c->halvings    = (PetscInt)clock[6];
  c->good_needed = (PetscInt)clock[7];
  c->good        = (PetscInt)clock[8];

  s->speed_max      = stats[0];
  s->kinetic_energy = stats[1];
  s->divergence     = stats[2];
  for (PetscInt k = 0; k < 3; k++) s->change[k] = stats[3 + k];
  s->visc_its     = (PetscInt)stats[6];
  s->ppe_its      = (PetscInt)stats[7];
  s->visc_its_sum = (PetscInt)stats[8];
  s->ppe_its_sum  = (PetscInt)stats[9];
  if (scheme->visc) *ViscosityFalls(scheme->visc) = (PetscInt)stats[10];
  if (scheme->coupled) *CoupledFalls(scheme->coupled) = (PetscInt)stats[10];
  if (scheme->ppe) *PressureFalls(scheme->ppe) = (PetscInt)stats[11];
  s->force_max = stats[12];
}

/* Adds an option of the user's to a sum. */
static PetscErrorCode SumOption(const char option[], uint64_t *sum)
{
  char text[4096] = "";

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetString(NULL, NULL, option, text, sizeof(text), NULL));
  CheckpointSumText(text, sum);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  CheckpointScene - Numbers by which a file's scene is told from the run's

  Collective. Corners of the box and spacing; a sum of the bodies' shapes; and where particles carry
  viscosities of their own, which options at a restart would not change, a sum of those, else zero.
*/
PetscErrorCode CheckpointScene(const Scene *scene, double numbers[SCENE_NUMBERS])
{
  uint64_t sum = 0, bodies = 0;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    numbers[2 * a]     = scene->lo[a];
    numbers[2 * a + 1] = scene->hi[a];
  }
  numbers[SCENE_NUMBERS - 3] = scene->dx;
  for (PetscInt k = 0; k < scene->n_bodies; k++) {
    CheckpointSumText(scene->bodies[k].shape->name, &bodies);
    CheckpointSumNumbers(scene->bodies[k].n, scene->bodies[k].parameter, &bodies);
  }
  numbers[SCENE_NUMBERS - 2] = (double)(bodies >> 16); /* such as a double holds whole */
  if (SceneViscosityVaries(scene) && SceneIsNewtonian(scene)) {
    const double nu = scene->nu;

    CheckpointSumNumbers(1, &nu, &sum);
    PetscCall(SumOption("-viscosity_field", &sum));
    for (PetscInt k = 1; k <= scene->n_regions; k++) {
      char option[64];

      PetscCall(PetscSNPrintf(option, sizeof(option), "-scene_fluid_%" PetscInt_FMT, k));
      PetscCall(SumOption(option, &sum));
      CheckpointSumNumbers(1, &scene->region_nu[k - 1], &sum);
    }
  }
  numbers[SCENE_NUMBERS - 1] = (double)(sum >> 16);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CheckpointRecord - The names of a record's numbers, "id,x:2,u:2,p:1": a file fits a run that
   has the same. */
PetscErrorCode CheckpointRecord(const Particles *p, char names[], size_t length)
{
  PetscFunctionBegin;
  PetscCall(PetscStrncpy(names, "id", length));
  for (PetscInt f = 0; f < p->n_fields; f++) {
    char part[64];

    PetscCall(PetscSNPrintf(part, sizeof(part), ",%s:%" PetscInt_FMT, p->field[f].name,
                            p->field[f].components));
    PetscCall(PetscStrlcat(names, part, length));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A hash with one more word in it: FNV-1a, by words. */
static uint64_t HashWord(uint64_t hash, uint64_t word)
{
  hash = (hash ^ word) * 1099511628211u;
  return hash ^ hash >> 29;
}

#define HASH_OF_NOTHING 14695981039346656037u

/*
  CheckpointSumNumbers - Adds to a sum what any changed bit of some numbers changes

  Not collective. What all ranks have is summed with it, what each has its share of by
  CheckpointSumRecords().
*/
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

/* CheckpointSumText - The same of a text; not collective */
void CheckpointSumText(const char text[], uint64_t *sum)
{
  uint64_t hash = HASH_OF_NOTHING;

  for (const char *c = text; *c; c++) hash = HashWord(hash, (unsigned char)*c);
  *sum += hash;
}

/* CheckpointSumRecords - The same of all records, whichever rank holds them. Collective. */
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
