/*
  Graded particles that move: the factor of their velocity keeps the wanted spacing in a flow that
  mixes the box, their sizes follow the place on all ranks, and rows of neighbours stay complete
  although radii change.
*/
/* RANKS: 2 */
#include "isph/start.h"
#include "crowd.h"

#define BLOCKS 4 /* along an axis */

/* Computes the velocity of two vortices side by side, with the stream function sin(2 s) sin(t) of
   the coordinates s and t from 0 to pi, times the factor of the motion if `follows`. It has no
   divergence and is parallel to the sides of the box. */
static void Velocity(const Scene *scene, PetscBool follows, const PetscReal x[], PetscReal w[])
{
  const PetscReal factor = follows ? SceneMotionFactor(scene, x) : 1.0;
  PetscReal       s[2], length[2];

  for (PetscInt a = 0; a < 2; a++) {
    length[a] = scene->hi[a] - scene->lo[a];
    s[a]      = PETSC_PI * (x[a] - scene->lo[a]) / length[a];
  }
  w[0] = factor * length[0] * PetscSinReal(2.0 * s[0]) * PetscCosReal(s[1]);
  w[1] = -2.0 * factor * length[1] * PetscCosReal(2.0 * s[0]) * PetscSinReal(s[1]);
  for (PetscInt a = 2; a < scene->dim; a++) w[a] = 0.0;
}

/* Moves own fluid particles by midpoint steps. */
static void Move(const Scene *scene, PetscBool follows, PetscReal dt, Particles *p)
{
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0}, w[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
    Velocity(scene, follows, x, w);
    for (PetscInt a = 0; a < p->dim; a++) x[a] += 0.5 * dt * w[a];
    Velocity(scene, follows, x, w);
    for (PetscInt a = 0; a < p->dim; a++) p->x[a][i] += dt * w[a];
  }
}

/* Returns the largest deviation of the number of particles in a block of the uniform coordinates
   from its mean, over the mean. */
static PetscReal Unevenness(const Scene *scene, const Particles *p)
{
  PetscReal       count[BLOCKS * BLOCKS] = {0.0}, most = 0.0;
  const PetscReal mean = (PetscReal)p->N_fluid / (BLOCKS * BLOCKS);

  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscInt block = 0;

    for (PetscInt a = 0; a < 2; a++) {
      const PetscReal y = SceneToUniform(scene, a, p->x[a][i]);
      const PetscReal s = (y - scene->lo[a]) / (scene->hi[a] - scene->lo[a]);

      block = block * BLOCKS + PetscMin(PetscMax((PetscInt)(s * BLOCKS), 0), BLOCKS - 1);
    }
    count[block] += 1.0;
  }
  MPI_Allreduce(MPI_IN_PLACE, count, BLOCKS * BLOCKS, MPIU_REAL, MPI_SUM, p->comm);
  for (PetscInt k = 0; k < BLOCKS * BLOCKS; k++)
    most = PetscMax(most, PetscAbsReal(count[k] - mean) / mean);
  return most;
}

/* Moves particles for the time of several turns of the vortices; returns the unevenness, and the
   error of the sum of volumes by place. */
static PetscReal MoveLong(Setting *s, PetscBool follows, PetscReal *volume)
{
  const Scene *scene = &s->scene;
  Particles   *p;
  PetscReal    uneven;

  ASSERT_OK(ParticlesCreate(scene, RADIUS * SceneCoarsest(scene), &p));
  ASSERT_OK(ParticlesFill(scene, s->walls, NULL, p));
  for (PetscInt step = 0; step < 500; step++) {
    Move(scene, follows, 0.004, p);
    ASSERT_OK(ParticlesUpdateEpoch(scene, p, PETSC_TRUE, NULL));
    ASSERT_OK(ParticlesResize(scene, p));
  }
  uneven  = Unevenness(scene, p);
  *volume = p->weight_resized / p->weight_start - 1.0;
  ASSERT_OK(ParticlesDestroy(&p));
  return uneven;
}

/*
  Particles keep the wanted density. The boundary of a block of 64 crosses 32 cells, and a particle
  beside it is in one block or the next by chance: 8 particles or 12.5 %. Volumes are those of
  cells, which are constant beside walls, not those of the map. Particles with the velocity of the
  flow carry their density with them.
*/
static void test_density(void **state)
{
  Setting   box = CrowdBox("2D closed", 2, 32, 32, 1, 0, 0);
  PetscReal volume;

  (void)state;
  CrowdReadSpacing("-spacing_wall 0.3", &box.scene);
  CloudAssertNone("even", box.name, MoveLong(&box, PETSC_TRUE, &volume) > 0.2);
  CloudAssertNone("volume", box.name, PetscAbsReal(volume) > 0.02);
  CloudAssertNone("uneven with the flow", box.name, MoveLong(&box, PETSC_FALSE, &volume) < 0.4);
  CloudAssertNone("volume with the flow", box.name, PetscAbsReal(volume) < 0.2);
}

/* Computes int V dV and int V^2 dV by the midpoint rule in uniform coordinates; returns the second
   over the first, along an axis. */
static PetscReal MotionEdge(const Scene *scene, PetscInt axis)
{
  const PetscInt  n      = 4000;
  const PetscReal length = scene->hi[axis] - scene->lo[axis];
  PetscReal       sum[2] = {0.0, 0.0};

  for (PetscInt k = 0; k < n; k++) {
    PetscReal slope;

    SceneFromUniform(scene, axis, scene->lo[axis] + (k + 0.5) / n * length, &slope);
    sum[0] += PetscSqr(slope);
    sum[1] += PetscSqr(slope) * slope;
  }
  return SceneCellSide(scene, axis) * sum[1] / sum[0];
}

/* The particles whose volume is the mean of V^2 over the mean of V have the velocity of the flow;
   with equal sizes all have. */
static void test_factor(void **state)
{
  Setting         box             = CrowdBox("2D closed", 2, 20, 24, 1, 0, 0);
  Setting         channel         = CrowdBox("2D channel", 2, 20, 24, 1, 1, 0);
  const PetscReal x[ISPH_MAX_DIM] = {0.3, 0.4};

  (void)state;
  CloudAssertNone("uniform", box.name, SceneMotionFactor(&box.scene, x) != 1.0);
  CrowdReadSpacing("-spacing_wall 0.4", &box.scene);
  CrowdReadSpacing("-spacing_wall 0.4", &channel.scene);
  for (PetscInt a = 0; a < 2; a++) {
    CloudAssertNone(
        "edge", box.name,
        PetscAbsReal(LatticeMotionEdge(&box.scene, a) / MotionEdge(&box.scene, a) - 1.0) > 1e-6);
    CloudAssertNone(
        "edge", channel.name,
        PetscAbsReal(LatticeMotionEdge(&channel.scene, a) / MotionEdge(&channel.scene, a) - 1.0) >
            1e-6);
  }
  CloudAssertNone("volume", box.name,
                  PetscAbsReal(SceneMotionFactor(&box.scene, x) * MotionEdge(&box.scene, 0) *
                                   MotionEdge(&box.scene, 1) / SceneVolumeAt(&box.scene, x) -
                               1.0) > 1e-6);
}

/* Checks sizes of all local fluid particles, and that own volumes fill the box. */
static void CheckSizes(const Setting *s, const Particles *p)
{
  const Scene *scene = &s->scene;
  PetscReal    sum = 0.0, box = 1.0;
  PetscInt     wrong = 0;

  for (PetscInt i = 0; i < ParticlesAll(p); i++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0}, stretch[ISPH_MAX_DIM];

    if (ParticlesIsWall(p, i)) continue;
    for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
    SceneStretch(scene, x, stretch);
    for (PetscInt a = 0; a < p->dim; a++) wrong += p->stretch[a][i] != stretch[a];
    wrong += p->dx[i] != SceneSpacing(scene, x);
    if (i < p->n_fluid) sum += p->volume[i];
  }
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPIU_REAL, MPI_SUM, p->comm);
  for (PetscInt a = 0; a < p->dim; a++) box *= scene->hi[a] - scene->lo[a];
  CloudAssertNone("sizes follow the place", s->name, wrong);
  CloudAssertNone("volumes fill the box", s->name, PetscAbsReal(sum - box) > 1e-12 * box);
}

/* In steps that use up the margin, rows are kept or built anew, and hold all pairs. */
static void CheckPairs(Setting *s, const char options[])
{
  const Scene    *scene = &s->scene;
  const PetscReal step  = 0.02 * scene->dx;
  Particles      *p;
  Neighbors      *nb;

  CrowdReadSpacing(options, &s->scene);
  ASSERT_OK(ParticlesCreate(scene, RADIUS * SceneCoarsest(scene), &p));
  ASSERT_OK(ParticlesFill(scene, s->walls, NULL, p));
  ASSERT_OK(NeighborsCreate(RADIUS * SceneCoarsest(scene), SceneCoarsest(scene), &nb));
  nb->slope = RADIUS * SceneGrowth(scene);
  for (PetscInt k = 0; k < 20; k++) {
    ASSERT_OK(ParticlesResize(scene, p));
    CheckSizes(s, p);
    ASSERT_OK(NeighborsUpdate(p, step, nb));
    CrowdCheckNeighbors(s, p, nb);
    Move(scene, PETSC_TRUE, 0.001, p);
    ASSERT_OK(ParticlesUpdateHalo(p));
  }
  CloudAssertNone("some rows are kept", s->name, nb->builds >= 20);
  ASSERT_OK(NeighborsDestroy(&nb));
  ASSERT_OK(ParticlesDestroy(&p));
}

static void test_pairs(void **state)
{
  Setting plane = CrowdBox("2D closed", 2, 24, 20, 1, 0, 0);
  Setting space = CrowdBox("3D closed", 3, 10, 10, 10, 0, 0);

  (void)state;
  CheckPairs(&plane, "-spacing_wall 0.4");
  CheckPairs(&space, "-spacing_wall 0.7");
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_factor), cmocka_unit_test(test_density),
                                     cmocka_unit_test(test_pairs)};
  int                     failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
