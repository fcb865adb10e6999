/*
  Insertion and removal of particles: each step inserts and removes some of both kinds. Ids, kinds,
  fields and neighbours of all particles are compared with a record, also in files and after a
  restart.
*/
/* RANKS: 1 2 3 */
#include "isph/start.h"
#include "crowd.h"
#include "../src/run/checkpoint.h"

#define STEPS   6
#define PLACES  7 /* positions of insertions in a step */
#define UNIFORM 3.5

/* A population and the record that the test keeps of it, the same on all ranks. */
typedef struct {
  Particles *p;
  Neighbors *nb;
  PetscReal *tag[2], *uniform;
  PetscInt   n, *alive; /* by id: 0 gone, 1 fluid, 2 wall */
} Population;

/* Data of the callback NewValue(): the first id of new particles on this rank. */
typedef struct {
  PetscInt first;
} NewIds;

/* Sets the tags of a new particle, which follow from its id; other fields keep the default value of
   their policy. */
static void NewValue(const Field *field, PetscInt k, PetscReal value[], void *ctx)
{
  const PetscInt id = ((const NewIds *)ctx)->first + k;

  if (field->components != 2 || field->name[0] != 't') return;
  for (PetscInt c = 0; c < 2; c++) value[c] = CrowdTag(id, c);
}

static void PopulationFields(Particles *p, Population *pop)
{
  pop->p = p;
  ASSERT_OK(ParticlesRegister(p, "tag", 2, HALO_EPOCH, ENTRY_ZERO, pop->tag));
  ASSERT_OK(ParticlesRegister(p, "uniform", 1, HALO_NONE, ENTRY_MEAN, &pop->uniform));
}

static void PopulationCreate(const Setting *s, Population *pop)
{
  Particles *p;

  ASSERT_OK(ParticlesCreate(&s->scene, RADIUS * s->scene.dx, &p));
  ASSERT_OK(ParticlesFill(&s->scene, s->walls, NULL, p));
  ASSERT_OK(NeighborsCreate(RADIUS * s->scene.dx, s->scene.dx, &pop->nb));
  PopulationFields(p, pop);
  for (PetscInt i = 0; i < ParticlesOwn(p); i++) {
    for (PetscInt c = 0; c < 2; c++) pop->tag[c][i] = CrowdTag(p->id[i], c);
    pop->uniform[i] = UNIFORM;
  }
  ASSERT_OK(ParticlesUpdateEpoch(&s->scene, p, PETSC_TRUE, NULL));
  pop->n = (PetscInt)p->next_id;
  PetscCallVoid(PetscMalloc1(pop->n + 2 * STEPS * PLACES, &pop->alive));
  for (PetscInt id = 0; id < pop->n; id++) pop->alive[id] = id < p->N_fluid ? 1 : 2;
}

static void PopulationDestroy(Population *pop)
{
  PetscCallVoid(PetscFree(pop->alive));
  ASSERT_OK(NeighborsDestroy(&pop->nb));
  ASSERT_OK(ParticlesDestroy(&pop->p));
}

/* Inserts particles of a kind at PLACES positions, each on the rank whose box holds it. */
static void Insert(const Setting *s, ParticleKind kind, PetscInt step, Population *pop)
{
  const Scene *scene = &s->scene;
  Particles   *p     = pop->p;
  PetscReal    x[PLACES * ISPH_MAX_DIM];
  NewIds       ids   = {0};
  NewParticles added = {.kind = kind, .x = x, .Value = NewValue, .ctx = &ids};
  PetscInt64   first, before = p->next_id;

  for (PetscInt j = 0; j < PLACES; j++) {
    for (PetscInt a = 0; a < p->dim; a++) {
      const PetscReal share = 0.5 + 0.48 * CrowdNoise(100 * step + 10 * j + kind, a);

      x[added.n * p->dim + a] = scene->lo[a] + share * (scene->hi[a] - scene->lo[a]);
    }
    if (ParticlesHolds(p, &x[added.n * p->dim])) added.n++;
  }
  MPI_Exscan(&added.n, &ids.first, 1, MPIU_INT, MPI_SUM, p->comm);
  ids.first += (PetscInt)before;
  ASSERT_OK(ParticlesInsert(scene, p, &added, &first));
  CloudAssertNone("the first id", s->name, first != ids.first);
  CloudAssertNone("places on one rank each", s->name, p->next_id != before + PLACES);
  for (PetscInt j = 0; j < PLACES; j++) pop->alive[pop->n++] = kind == PARTICLE_FLUID ? 1 : 2;
}

/* Removes about a twentieth of all particles, which are chosen by id. */
static void Remove(const Setting *s, PetscInt step, Population *pop)
{
  Particles *p = pop->p;
  PetscInt   n = 0, *list;

  PetscCallVoid(PetscMalloc1(ParticlesOwn(p), &list));
  for (PetscInt i = ParticlesOwn(p) - 1; i >= 0; i--) {
    if (CrowdNoise((PetscInt)p->id[i], 20 + step) > 0.9) list[n++] = i;
  }
  ASSERT_OK(ParticlesRemove(&s->scene, p, n, list));
  PetscCallVoid(PetscFree(list));
  for (PetscInt id = 0; id < pop->n; id++) {
    if (CrowdNoise(id, 20 + step) > 0.9) pop->alive[id] = 0;
  }
}

/* Checks ids, kinds and fields against the record. */
static void CheckRecord(const Setting *s, const Population *pop)
{
  const Particles *p     = pop->p;
  PetscInt         wrong = 0, kinds = 0, mean = 0, n_fluid = 0;
  All              all;

  CloudAssertNone("next id", s->name, p->next_id != pop->n);
  CrowdGather(p, &all);
  for (PetscInt id = 0; id < pop->n; id++) wrong += all.found[id] != (pop->alive[id] ? 1.0 : 0.0);
  CrowdFree(&all);
  for (PetscInt i = 0; i < ParticlesAll(p); i++)
    kinds += pop->alive[p->id[i]] != (p->kind[i] == PARTICLE_FLUID ? 1 : 2);
  for (PetscInt i = 0; i < ParticlesOwn(p); i++)
    mean += PetscAbsReal(pop->uniform[i] - UNIFORM) > 1e-13;
  for (PetscInt id = 0; id < pop->n; id++) n_fluid += pop->alive[id] == 1;
  CloudAssertNone("only those that are alive", s->name, wrong);
  CloudAssertNone("kinds", s->name, kinds);
  CloudAssertNone("means of a uniform field", s->name, mean);
  CloudAssertNone("fluid", s->name, n_fluid != p->N_fluid);
}

/* Counts repeated ids: none in the records of the particles, then one for each rank that gives its
   first particle the smallest id. */
static void CheckIds(const Setting *s, const Population *pop)
{
  const Particles *p     = pop->p;
  const PetscInt   width = ParticlesRecordWidth(p);
  PetscInt         id    = 0, changed, repeated;
  PetscReal       *record;

  while (!pop->alive[id]) id++;
  changed = ParticlesOwn(p) && p->id[0] != id;
  MPI_Allreduce(MPI_IN_PLACE, &changed, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD);
  PetscCallVoid(PetscMalloc1(ParticlesOwn(p) * width + 1, &record));
  ASSERT_OK(ParticlesPack(p, record));
  ASSERT_OK(ParticlesCountRepeated(p, ParticlesOwn(p), record, &repeated));
  CloudAssertNone("repeated ids", s->name, repeated);
  record[0] = (PetscReal)id;
  ASSERT_OK(ParticlesCountRepeated(p, ParticlesOwn(p), record, &repeated));
  CloudAssertNone("unnoticed repeated ids", s->name, changed - repeated);
  PetscCallVoid(PetscFree(record));
}

static void CheckAll(const Setting *s, const Population *pop)
{
  ASSERT_OK(NeighborsUpdate(pop->p, 0.0, pop->nb));
  CrowdCheckParticles(s, pop->p, pop->tag);
  CrowdCheckNeighbors(s, pop->p, pop->nb);
  CheckRecord(s, pop);
  CheckIds(s, pop);
}

/* Moves, inserts and removes particles, and checks them after each change of their number. */
static void Step(const Setting *s, PetscInt step, Population *pop)
{
  PetscBool started;

  CrowdMove(&s->scene, pop->p, 0.4 * s->scene.dx);
  ASSERT_OK(ParticlesUpdateEpoch(&s->scene, pop->p, PETSC_FALSE, &started));
  if (!started) ASSERT_OK(ParticlesUpdateHalo(pop->p));
  Insert(s, PARTICLE_FLUID, step, pop);
  if (pop->p->depth) Insert(s, PARTICLE_WALL, step, pop);
  CheckAll(s, pop);
  Remove(s, step, pop);
  CheckAll(s, pop);
}

static void ComeAndGo(const Setting *s)
{
  Population pop;

  PopulationCreate(s, &pop);
  for (PetscInt step = 0; step < STEPS; step++) Step(s, step, &pop);
  PopulationDestroy(&pop);
}

static void test_come_and_go(void **state)
{
  const Setting cavity   = CrowdBox("2D cavity", 2, 15, 11, 1, 0, 3);
  const Setting channel  = CrowdBox("2D channel", 2, 12, 10, 1, 1, 0);
  const Setting periodic = CrowdBox("3D periodic", 3, 7, 7, 7, 3, 0);

  (void)state;
  ComeAndGo(&cavity);
  ComeAndGo(&channel);
  ComeAndGo(&periodic);
}

static PetscErrorCode BeginNothing(Flow *flow)
{
  return PETSC_SUCCESS;
}

/* Creates a run that has particles but no flow; it reads -output, -checkpoint and -restart. */
static void MakeRun(Scene *scene, Particles *p, Scheme *scheme, Clock *clock, Operators *ops,
                    Run *run)
{
  static FlowState state;

  run->flow = (Flow){.scene     = scene,
                     .particles = p,
                     .state     = &state,
                     .scheme    = scheme,
                     .clock     = clock,
                     .ops       = ops};
  ASSERT_OK(ClockRemember(clock, &scheme->memory));
  ASSERT_OK(ReportCreate(&run->report));
  ASSERT_OK(SnapshotsCreate(scene, &run->snapshots));
  ASSERT_OK(MonitorsCreate(&run->flow, &run->monitors));
  ASSERT_OK(CheckpointsCreate(&run->checkpoints));
}

static void DestroyRun(Run *run)
{
  ASSERT_OK(CheckpointsDestroy(&run->checkpoints));
  ASSERT_OK(MonitorsDestroy(&run->monitors));
  ASSERT_OK(SnapshotsDestroy(&run->snapshots));
  ASSERT_OK(ReportDestroy(&run->report));
}

/* Checks that a snapshot has a row for each particle: each living id once, and no other id. */
static void CheckSnapshot(const Setting *s, const char path[], const Population *pop)
{
  const PetscInt N = pop->p->N_fluid + pop->p->N_wall;
  PetscInt       rows, columns, wrong = 0;
  long long     *id;
  int           *type, *found;
  Hdf5File       file;
  PetscBool      good;

  PetscCallVoid(PetscMalloc3(N, &id, N, &type, pop->n, &found));
  PetscCallVoid(PetscArrayzero(found, pop->n));
  ASSERT_OK(Hdf5FileOpen(PETSC_COMM_WORLD, path, HDF5_READ, &file));
  ASSERT_OK(Hdf5CountRows(&file, "id", &rows, &columns));
  CloudAssertNone("rows of the file", s->name, rows != N);
  file.start = 0;
  file.own = file.N = N;
  ASSERT_OK(Hdf5ReadRows(&file, "id", 0, H5T_NATIVE_LLONG, id));
  ASSERT_OK(Hdf5ReadRows(&file, "type", 0, H5T_NATIVE_INT, type));
  ASSERT_OK(Hdf5FileClose(&file, &good));
  CloudAssertNone("the file", s->name, !good);
  for (PetscInt k = 0; k < N; k++) {
    wrong += id[k] < 0 || id[k] >= pop->n || pop->alive[id[k]] != type[k] + 1;
    wrong += id[k] >= 0 && id[k] < pop->n && found[id[k]]++ > 0;
  }
  PetscCallVoid(PetscFree3(id, type, found));
  CloudAssertNone("rows of the file are those alive", s->name, wrong);
}

/*
  A run whose ids have gaps writes a snapshot and a checkpoint. Another run restarts from the
  checkpoint, has the same particles, and gives new particles ids that were never used.
*/
static void test_files(void **state)
{
  Setting          s     = CrowdBox("files", 2, 14, 11, 1, 1, 3);
  const SchemeRow  row   = {.name = "nothing", .Begin = BeginNothing};
  const DtAdaptRow adapt = {.name = "none"};
  Scheme           first = {.row = &row}, second = {.row = &row};
  Clock            clock = {.t_end = 1.0, .adapt = &adapt}, later = {.t_end = 1.0, .adapt = &adapt};
  Operators        none = {.needs = 0};
  Population       pop, again;
  Particles       *p;
  Run              run;
  PetscBool        restarted;

  (void)state;
  s.scene.length = s.scene.speed = s.scene.rho = s.scene.nu = 1.0;
  ASSERT_OK(PetscOptionsInsertString(NULL, "-output flow.h5 -checkpoint c.h5"));
  PopulationCreate(&s, &pop);
  for (PetscInt step = 0; step < 3; step++) Step(&s, step, &pop);
  clock.t    = 0.25;
  clock.step = 3;
  MakeRun(&s.scene, pop.p, &first, &clock, &none, &run);
  ASSERT_OK(SnapshotsWrite(&run.flow, PETSC_TRUE, run.snapshots));
  CheckSnapshot(&s, "flow_0000.h5", &pop);
  ASSERT_OK(CheckpointsUpdate(PETSC_TRUE, &run));
  DestroyRun(&run);
  ASSERT_OK(PetscOptionsClearValue(NULL, "-output"));
  ASSERT_OK(PetscOptionsClearValue(NULL, "-checkpoint"));

  ASSERT_OK(PetscOptionsInsertString(NULL, "-restart c.h5"));
  ASSERT_OK(ParticlesCreate(&s.scene, RADIUS * s.scene.dx, &p));
  ASSERT_OK(ParticlesFill(&s.scene, s.walls, NULL, p));
  again = pop;
  PopulationFields(p, &again);
  MakeRun(&s.scene, p, &second, &later, &none, &run);
  ASSERT_OK(CheckpointsRestart(&run, &restarted));
  CloudAssertNone("restarted", s.name,
                  !restarted || later.t != clock.t || later.step != clock.step);
  DestroyRun(&run);
  ASSERT_OK(PetscOptionsClearValue(NULL, "-restart"));
  CheckAll(&s, &again);
  for (PetscInt step = 3; step < STEPS; step++) Step(&s, step, &again);
  ASSERT_OK(ParticlesDestroy(&p));
  PopulationDestroy(&pop);
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_come_and_go),
      cmocka_unit_test(test_files),
  };
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
