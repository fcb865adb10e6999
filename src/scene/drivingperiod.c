/*
  The period of what drives a flow: velocities of boundaries and the body force as functions of
  time. They are evaluated ahead of the present time, because steps longer than a period would miss
  it.
*/
#include "isph/scene.h"
#include <stdint.h>

#define SAMPLES    64 /* times at which an expression is evaluated in a window */
#define PER_PERIOD 16 /* least number of samples in a period */
#define NARROWINGS 10 /* largest number of times that the window shrinks by NARROWER */
#define NARROWER   4.0
#define PLACES     3 /* positions at which an expression of position is evaluated */

/* Returns time k of the samples of a window. They are at random places in equal parts of it,
   because regular samples could be in step with the expression. */
static PetscReal SampleTime(PetscReal t, PetscReal window, PetscInt k)
{
  const uint32_t mixed = ((uint32_t)k + 1u) * 2654435761u;
  const uint32_t bits  = (mixed ^ mixed >> 15) * 2246822519u;

  return t + window * (k + (PetscReal)(bits ^ bits >> 13) / 4294967296.0) / SAMPLES;
}

/* Sets position k at which expressions of position are evaluated, inside the box. */
static void SamplePlace(const Scene *scene, PetscInt k, PetscReal x[])
{
  const PetscReal share[PLACES][ISPH_MAX_DIM] = {
      {0.5, 0.5, 0.5}, {0.23, 0.71, 0.37}, {0.83, 0.19, 0.61}};

  for (PetscInt a = 0; a < scene->dim; a++)
    x[a] = scene->lo[a] + share[k][a] * (scene->hi[a] - scene->lo[a]);
}

/* Adds range and total variation of component c in a window to the sums; values that are not
   finite are left out. */
static void AddVariation(const Expression *e, PetscInt c, PetscReal t, PetscReal window,
                         const PetscReal x[], PetscReal *range, PetscReal *variation)
{
  PetscReal low = PETSC_INFINITY, high = -PETSC_INFINITY, last = NAN;

  for (PetscInt k = 0; k < SAMPLES; k++) {
    const PetscReal value = ExpressionProbe(e, c, SampleTime(t, window, k), x);

    if (PetscIsInfOrNanReal(value)) continue;
    if (!PetscIsNanReal(last)) *variation += PetscAbsReal(value - last);
    low  = PetscMin(low, value);
    high = PetscMax(high, value);
    last = value;
  }
  if (high > low) *range += high - low;
}

/*
  Returns the period of an expression in the window [t, t + window]: twice the range of its values
  over their total variation, times the window. Ranges up to `least` count as constant. The window
  shrinks until a period has at least PER_PERIOD samples. Infinite if the window is shorter than a
  period.
*/
static PetscReal ExpressionPeriod(const Scene *scene, const Expression *e, PetscReal t,
                                  PetscReal window, PetscReal least)
{
  PetscReal periods = 0.0;

  if (!ExpressionUses(e, EXPRESSION_TIME)) return PETSC_INFINITY;
  for (PetscInt n = 0; n <= NARROWINGS; n++, window /= NARROWER) {
    const PetscInt places = ExpressionUses(e, EXPRESSION_PLACE) ? PLACES : 1;
    PetscReal      range = 0.0, variation = 0.0;

    for (PetscInt k = 0; k < places; k++) {
      PetscReal x[ISPH_MAX_DIM];

      SamplePlace(scene, k, x);
      for (PetscInt c = 0; c < e->n; c++) {
        if (e->uses[c] & EXPRESSION_TIME) AddVariation(e, c, t, window, x, &range, &variation);
      }
    }
    if (range <= least * places) return PETSC_INFINITY;
    periods = 0.5 * variation / range;
    if (periods * PER_PERIOD <= SAMPLES) break;
  }
  return periods >= 1.0 ? window / periods : PETSC_INFINITY;
}

/*
  SceneDrivingPeriod - Returns the shortest period of the velocities of boundaries and of the body
  force in the window [t, t + window], if it is shorter than the window; otherwise infinity [s]

  Not collective; the same on all ranks. Only expressions are evaluated. Input: least - largest
  change of a velocity, or of a force times the window, that counts as none [m/s].
*/
PetscReal SceneDrivingPeriod(const Scene *scene, PetscReal t, PetscReal window, PetscReal least)
{
  PetscReal period = ExpressionPeriod(scene, &scene->force, t, window, least / window);

  for (PetscInt side = 0; side < SceneBoundaries(scene) && scene->unsteady_walls; side++) {
    const Boundary *boundary = &scene->boundary[side];

    period = PetscMin(period, ExpressionPeriod(scene, &boundary->velocity, t, window, least));
    period = PetscMin(
        period, ExpressionPeriod(scene, &boundary->rotation, t, window, least / scene->length));
  }
  return period;
}
