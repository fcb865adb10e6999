/* Strains of cells for a velocity, and their viscosities. */
#include "isph/fits.h"
#include "strain.h"

#define RIDGE 1e-8 /* of the moments of a linear fit, over their trace */

/* StrainOfValues - Computes the strains of the cells and their rates from velocities by local
   index; not collective */
PetscErrorCode StrainOfValues(const Particles *p, PetscReal *const value[], StrainCells *s)
{
  const PetscInt d = p->dim;

  PetscFunctionBegin;
  PetscCall(FreeAll(&s->strain, &s->rate));
  PetscCall(PetscMalloc1(s->all * d * d + 1, &s->strain));
  PetscCall(PetscMalloc1(s->all + 1, &s->rate));
  for (PetscInt c = 0; c < s->all; c++) {
    PetscReal *E = &s->strain[c * d * d], G[STRAIN_TENSOR] = {0.0}, square = 0.0;

    for (PetscInt a = 0; a < d; a++) {
      const PetscInt q = s->sets == 1 ? 0 : a;

      for (PetscInt e = s->first[q][c]; e < s->first[q][c + 1]; e++)
        for (PetscInt b = 0; b < d; b++) G[a * d + b] += s->g[q][b][e] * value[a][s->j[q][e]];
    }
    for (PetscInt a = 0; a < d; a++) {
      for (PetscInt b = 0; b < d; b++) {
        E[a * d + b] = 0.5 * (G[a * d + b] + G[b * d + a]);
        square += PetscSqr(E[a * d + b]);
      }
    }
    s->rate[c] = PetscSqrtReal(2.0 * square);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StrainOfVelocity - Computes the strains of the cells and their rates, sqrt(2 E:E); collective.
   Input: u - velocity components over the fluid; walls - those of walls, NULL entries without
   walls. */
PetscErrorCode StrainOfVelocity(const Particles *p, const Vec u[], const Vec walls[],
                                StrainCells *s)
{
  PetscReal *value[ISPH_MAX_DIM];

  PetscFunctionBegin;
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(PetscMalloc1(ParticlesAll(p), &value[a]));
    PetscCall(LocalValues(p, u[a], walls ? walls[a] : NULL, 1, value[a]));
    PetscCall(ParticlesHaloField(p, value[a]));
  }
  PetscCall(StrainOfValues(p, value, s));
  for (PetscInt a = 0; a < p->dim; a++) PetscCall(PetscFree(value[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StrainAddForce - Adds scale times the viscous force of the present strains to own fluid [m/s^2];
   not collective */
void StrainAddForce(const Particles *p, const StrainCells *s, PetscReal scale,
                    PetscReal *const to[])
{
  const PetscInt d = p->dim;

  for (PetscInt c = 0; c < s->all; c++) {
    for (PetscInt a = 0; a < d; a++) {
      const PetscInt q = s->sets == 1 ? 0 : a;

      for (PetscInt e = s->first[q][c]; e < s->first[q][c + 1]; e++) {
        const PetscInt j   = s->j[q][e];
        PetscReal      sum = 0.0;

        if (j >= p->n_fluid) continue;
        for (PetscInt b = 0; b < d; b++) sum += s->strain[(c * d + a) * d + b] * s->g[q][b][e];
        to[a][j] -= scale * 2.0 * s->volume[c] * s->nu[c] * sum / s->mass[q][j];
      }
    }
  }
}

/* StrainRheology - Sets the viscosities of the cells to those of the rheology at the present
   strains; not collective */
void StrainRheology(const Scene *scene, StrainCells *s)
{
  for (PetscInt c = 0; c < s->all; c++) {
    const FluidPlace at = RheologyAt(scene, s->centre, c);

    s->nu[c] = RheologyViscosity(&scene->rheology, &at, s->rate[c]);
  }
}

/*
  StrainForceError - Estimates the error of the viscous force of the present velocity by cells twice
  as large

    error = (F_2h - F_h)/3,   F_h the force with cells of edge h, of second order

  Collective. Input: cells - those of the run; velocities of particles with their halo. Output:
  error - components at own fluid [m/s^2].
*/
PetscErrorCode StrainForceError(const Scene *scene, const Particles *p, const Neighbors *nb,
                                PetscInt degree, StrainCells *cells, PetscReal *const error[])
{
  const StrainQuantity velocity = {.sets = cells->sets};
  StrainCells         *of[2]    = {cells, NULL};

  PetscFunctionBegin;
  PetscCall(StrainAssemble(scene, p, nb, 2.0 * StrainEdge(scene), degree, &velocity, &of[1]));
  StrainViscosities(scene, p, of[1]);
  for (PetscInt a = 0; a < p->dim; a++) PetscCall(PetscArrayzero(error[a], p->n_fluid));
  for (PetscInt k = 0; k < 2; k++) {
    PetscCall(StrainOfValues(p, p->u, of[k]));
    if (!SceneIsNewtonian(scene)) StrainRheology(scene, of[k]);
    StrainAddForce(p, of[k], k ? 1.0 / 3.0 : -1.0 / 3.0, error);
  }
  PetscCall(StrainDestroy(&of[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the value at a cell of the linear fit of log nu of the particles of its fluid there. */
static PetscReal FittedViscosity(const Particles *p, const StrainCells *s, PetscInt c)
{
  const PetscInt d = p->dim, terms = d + 1;
  PetscReal      M[16] = {0.0}, b[4] = {0.0}, factor[16], R2 = 0.0;

  for (PetscInt pass = 0; pass < 2; pass++) {
    for (PetscInt e = s->first[0][c]; e < s->first[0][c + 1]; e++) {
      const PetscInt j      = s->j[0][e];
      PetscReal      phi[4] = {1.0}, r2 = 0.0, W;

      if (ParticlesIsWall(p, j) || (p->fluid && (PetscInt)p->fluid[j] != s->fluid[c])) continue;
      for (PetscInt a = 0; a < d; a++) {
        phi[1 + a] = p->x[a][j] - s->centre[a][c];
        r2 += PetscSqr(phi[1 + a]);
      }
      if (!pass) {
        R2 = PetscMax(R2, 1.1 * r2);
        continue;
      }
      W = PetscSqr(1.0 - r2 / R2);
      for (PetscInt a = 0; a < d; a++) phi[1 + a] /= PetscSqrtReal(R2);
      for (PetscInt t = 0; t < terms; t++) {
        b[t] += W * phi[t] * PetscLogReal(p->nu[j]);
        for (PetscInt q = 0; q < terms; q++) M[t * terms + q] += W * phi[t] * phi[q];
      }
    }
  }
  if (M[0] <= 0.0) return 0.0;
  DenseCholeskyRidge(terms, M, RIDGE, factor);
  DenseCholeskySolve(terms, factor, b);
  return PetscExpReal(b[0]);
}

/* StrainViscosities - Sets the viscosities of the cells from those of fluids, or of the particles
   where they vary in a fluid; not collective */
void StrainViscosities(const Scene *scene, const Particles *p, StrainCells *s)
{
  for (PetscInt c = 0; c < s->n; c++) {
    const PetscBool varies = p->nu && s->fluid[c] == 0 && (scene->nu_field.n || !scene->n_regions);

    s->nu[c] = varies ? FittedViscosity(p, s, c) : SceneFluidViscosity(scene, s->fluid[c], NULL);
    if (s->nu[c] <= 0.0) s->nu[c] = SceneFluidViscosity(scene, s->fluid[c], NULL);
  }
  for (PetscInt c = s->n; c < s->all; c++) s->nu[c] = s->nu[s->beside[c]];
}

/* StrainSpread - Sets the viscosities of particles to means over their cells; collective */
PetscErrorCode StrainSpread(Particles *p, const StrainCells *s)
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal sum = 0.0, weight = 0.0;

    for (PetscInt k = s->of[0][i]; k < s->of[0][i + 1]; k++) {
      const PetscInt c  = s->cell[0][k];
      PetscReal      r2 = 0.0, W;

      if (c >= s->n) continue;
      for (PetscInt a = 0; a < p->dim; a++) r2 += PetscSqr(p->x[a][i] - s->centre[a][c]);
      W = s->volume[c] * PetscExpReal(-4.0 * r2 / PetscSqr(p->dx[i]));
      sum += W * PetscLogReal(s->nu[c]);
      weight += W;
    }
    if (weight > 0.0) p->nu[i] = PetscExpReal(sum / weight);
  }
  PetscCall(ParticlesHaloField(p, p->nu));
  PetscFunctionReturn(PETSC_SUCCESS);
}
