/* The smooth solenoidal part of a velocity field. Its scalar products with solenoidal fields that
   do not cross walls contain no gradient of a pressure, and its smooth part contains no detail on
   the scale of the grid. Both vary from step to step where particles move, as a noise that is no
   error in time. */
#include "isph/flow.h"

#define MODES_2D 7   /* modes along each axis */
#define MODES_3D 5   /* */
#define MODES    7   /* the larger of both */
#define TERMS    384 /* at least 3 MODES_3D^3 + 3, MODES_2D^2 + 2 */
#define CUTOFF   0.1 /* distance from bodies in which the fields fall to zero [L] */

/* Values and derivatives of the factors of the stream functions at a particle. */
typedef struct {
  PetscReal value[ISPH_MAX_DIM][MODES], slope[ISPH_MAX_DIM][MODES]; /* [-], [1/m] */
  PetscReal height[ISPH_MAX_DIM];                                   /* from the middle [m] */
  PetscReal cutoff, cutoff_slope[ISPH_MAX_DIM]; /* 1 far from bodies, 0 on them [-], [1/m] */
} Factors;

static PetscInt ModesOf(const Scene *scene)
{
  return scene->dim == 2 ? MODES_2D : MODES_3D;
}

/* Returns the wave number of mode k along an axis [1/m]: 0, 1, 1, 2, 2, ... times 2 pi/period, or
   1, 2, 3, ... times pi/width between walls. */
static PetscReal WaveNumber(const Scene *scene, PetscInt axis, PetscInt k)
{
  const PetscReal width = scene->hi[axis] - scene->lo[axis];

  return SceneIsPeriodic(scene, axis) ? 2.0 * PETSC_PI * (PetscReal)((k + 1) / 2) / width
                                      : PETSC_PI * (k + 1.0) / width;
}

/* Sets the cutoff and its gradient at x. */
static void SetCutoff(const Scene *scene, const PetscReal x[], Factors *f)
{
  const PetscReal reach = CUTOFF * scene->length;
  WallPlane       planes[WALL_PLANES];
  PetscInt        n = 0;

  f->cutoff = 1.0;
  for (PetscInt a = 0; a < scene->dim; a++) f->cutoff_slope[a] = 0.0;
  if (scene->n_bodies) SceneWallPlanes(scene, x, reach, planes, &n);
  for (PetscInt q = 0; q < n; q++) {
    const PetscReal s = PetscMax(0.0, planes[q].distance / reach), m = s * s * (3.0 - 2.0 * s);

    if (!BoundaryBody(scene, planes[q].side)) continue;
    for (PetscInt a = 0; a < scene->dim; a++) {
      f->cutoff_slope[a] =
          m * f->cutoff_slope[a] + f->cutoff * 6.0 * s * (1.0 - s) / reach * planes[q].normal[a];
    }
    f->cutoff *= m;
  }
}

/* Sets the factors at x: sin(pi k y/width) between walls, 1, cos, sin, ... along periodic axes. */
static void SetFactors(const Scene *scene, const PetscReal x[], Factors *f)
{
  for (PetscInt a = 0; a < scene->dim; a++) {
    const PetscBool periodic = SceneIsPeriodic(scene, a);

    f->height[a] = x[a] - 0.5 * (scene->lo[a] + scene->hi[a]);
    for (PetscInt k = 0; k < ModesOf(scene); k++) {
      const PetscReal w = WaveNumber(scene, a, k), phase = w * (x[a] - scene->lo[a]);
      const PetscBool sine = !periodic || k % 2 == 0;

      f->value[a][k] =
          w > 0.0 ? PETSC_SQRT2 * (sine ? PetscSinReal(phase) : PetscCosReal(phase)) : 1.0;
      f->slope[a][k] = PETSC_SQRT2 * w * (sine ? PetscCosReal(phase) : -PetscSinReal(phase));
    }
  }
  SetCutoff(scene, x, f);
}

/* Returns e.curl(cutoff S) in the plane of axes a and b, for a stream function S with the gradient
   (along_a, along_b). */
static PetscReal TimesCurl(const Factors *f, PetscInt a, PetscInt b, const PetscReal e[],
                           PetscReal S, PetscReal along_a, PetscReal along_b)
{
  return e[a] * (f->cutoff * along_b + S * f->cutoff_slope[b]) -
         e[b] * (f->cutoff * along_a + S * f->cutoff_slope[a]);
}

/* Adds the products of a weighted velocity e with all fields in the plane of axes a and b. */
static void AddPlane(const Scene *scene, const Factors *f, PetscInt a, PetscInt b,
                     const PetscReal e[], PetscReal sum[], PetscInt *n)
{
  const PetscInt modes = ModesOf(scene), c = ISPH_MAX_DIM - a - b;

  for (PetscInt k = 0; k < modes; k++) {
    for (PetscInt l = 0; l < modes; l++) {
      const PetscReal size =
          PetscSqrtReal(PetscSqr(WaveNumber(scene, a, k)) + PetscSqr(WaveNumber(scene, b, l)));
      PetscReal product;

      if (size == 0.0) continue;
      product =
          TimesCurl(f, a, b, e, f->value[a][k] * f->value[b][l] / size,
                    f->slope[a][k] * f->value[b][l] / size, f->value[a][k] * f->slope[b][l] / size);
      if (scene->dim == 2) sum[(*n)++] += product;
      for (PetscInt m = 0; m < modes && scene->dim == 3; m++)
        sum[(*n)++] += product * f->value[c][m];
    }
  }
}

/*
  SolenoidalNorm - Computes the root mean square over the fluid of the smooth solenoidal part of a
  velocity field [m/s]

    |e| = (sum_q (sum_i V_i e_i.psi_q(x_i)/sum_i V_i)^2)^(1/2)

  Collective. The fields psi_q are normalised curls of stream functions: products of sines between
  walls and of harmonics along periodic axes, and uniform velocities along periodic axes. They are
  tangential to all sides, and stream functions vanish on bodies, so that gradients have no product
  with them. See theory.md, (time:norm).
*/
PetscErrorCode SolenoidalNorm(const Scene *scene, const Particles *p, const Vec e[],
                              PetscReal *norm)
{
  const PetscScalar *value[ISPH_MAX_DIM];
  PetscReal          sum[TERMS] = {0.0}, square = 0.0;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecGetArrayRead(e[a], &value[a]));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0}, weighted[ISPH_MAX_DIM] = {0.0};
    Factors   factors;
    PetscInt  n = 0;

    for (PetscInt a = 0; a < scene->dim; a++) {
      x[a]        = p->x[a][i];
      weighted[a] = ParticlesWeight(p, i) * value[a][i];
    }
    SetFactors(scene, x, &factors);
    for (PetscInt a = 0; a < scene->dim; a++) {
      const PetscInt b = (a + 1) % scene->dim;

      if (SceneIsPeriodic(scene, a))
        sum[n++] += TimesCurl(&factors, a, b, weighted, factors.height[b], 0.0, 1.0);
      if (a < b || scene->dim == 3) AddPlane(scene, &factors, a, b, weighted, sum, &n);
    }
  }
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecRestoreArrayRead(e[a], &value[a]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, TERMS, MPIU_REAL, MPIU_SUM, p->comm));
  for (PetscInt k = 0; k < TERMS; k++) square += PetscSqr(sum[k] / p->weight);
  *norm = PetscSqrtReal(square);
  PetscFunctionReturn(PETSC_SUCCESS);
}
