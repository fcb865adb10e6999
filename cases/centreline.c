/* Quantities of cavity flows: extrema and profiles of the velocity on the centrelines, and the
   kinetic energy as a function of time from rest. */
#include "cases.h"

#define LINE_POINTS 401

/* Samples velocity component c, divided by U, at n points of the line along axis a through the
   centre. s is the coordinate divided by the width of the box. */
static PetscErrorCode SampleLine(const Flow *flow, PetscInt a, PetscInt c, PetscInt n,
                                 const PetscReal s[], PetscReal value[])
{
  const Scene *scene = flow->scene;
  PetscReal   *x, *u;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(n * scene->dim, &x, n * scene->dim, &u));
  for (PetscInt k = 0; k < n; k++) {
    for (PetscInt b = 0; b < scene->dim; b++)
      x[k * scene->dim + b] = scene->lo[b] + (scene->hi[b] - scene->lo[b]) * (a == b ? s[k] : 0.5);
  }
  PetscCall(ProbePoints(flow, n, x, u, NULL));
  for (PetscInt k = 0; k < n; k++) {
    PetscReal normal[ISPH_MAX_DIM];
    PetscInt  body;

    value[k] = u[k * scene->dim + c] / scene->speed;
    if (SceneDistance(scene, &x[k * scene->dim], &body, normal) < 0.0)
      value[k] = 0.0; /* in a solid */
  }
  PetscCall(PetscFree2(x, u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the maximum (sign = 1) or minimum (-1) of samples, refined by a parabola through it and
   its neighbours. */
static PetscReal Extremum(PetscInt n, const PetscReal value[], PetscReal sign)
{
  PetscInt  best = 1;
  PetscReal slope, bend;

  for (PetscInt k = 1; k < n - 1; k++) best = sign * value[k] > sign * value[best] ? k : best;
  slope = 0.5 * (value[best + 1] - value[best - 1]);
  bend  = value[best + 1] - 2.0 * value[best] + value[best - 1];
  return sign * bend < 0.0 ? value[best] - 0.5 * slope * slope / bend : value[best];
}

/* Reports an extremum of values divided by U, and its reference, times U. */
static PetscErrorCode AddExtremum(const char name[], const PetscReal value[], PetscReal sign,
                                  PetscReal reference, PetscReal U, Report *report)
{
  const PetscReal scale = U * (PetscIsNanReal(reference) ? 1.0 : PetscAbsReal(reference));

  PetscFunctionBegin;
  PetscCall(ReportAddReference(report, name, U * Extremum(LINE_POINTS, value, sign), U * reference,
                               scale));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CentrelineExtrema - Reports u_min on the vertical centreline, v_max and v_min on the horizontal
   centreline [m/s]. Collective. Input: reference of each value over U, NaN without a reference
   [-]. */
PetscErrorCode CentrelineExtrema(const Flow *flow, PetscReal u_min, PetscReal v_max,
                                 PetscReal v_min, Report *report)
{
  const PetscReal U = flow->scene->speed;
  PetscReal       s[LINE_POINTS], value[LINE_POINTS];

  PetscFunctionBegin;
  for (PetscInt k = 0; k < LINE_POINTS; k++) s[k] = (PetscReal)k / (LINE_POINTS - 1);
  PetscCall(SampleLine(flow, 1, 0, LINE_POINTS, s, value));
  PetscCall(AddExtremum("u_min", value, -1.0, u_min, U, report));
  PetscCall(SampleLine(flow, 0, 1, LINE_POINTS, s, value));
  PetscCall(AddExtremum("v_max", value, 1.0, v_max, U, report));
  PetscCall(AddExtremum("v_min", value, -1.0, v_min, U, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CentrelineProfile - Reports the root mean square difference between the profile of a velocity
   component, divided by U, and a reference profile. Collective. Input: a - axis of the line; c -
   component; file - file of the reference profile. The quantity is NaN if the file is absent. */
PetscErrorCode CentrelineProfile(const Flow *flow, PetscInt a, PetscInt c, const char file[],
                                 const char name[], Report *report)
{
  ReferenceData curve;
  PetscReal    *value, sum = 0.0;

  PetscFunctionBegin;
  PetscCall(ReferenceDataRead(file, report, &curve));
  PetscCall(PetscMalloc1(curve.n, &value));
  PetscCall(SampleLine(flow, a, c, curve.n, curve.x, value));
  for (PetscInt k = 0; k < curve.n; k++) sum += PetscSqr(value[k] - curve.y[k]);
  if (curve.n) PetscCall(ReportAddError(report, name, PetscSqrtReal(sum / curve.n)));
  else PetscCall(ReportAddMissing(report, name));
  PetscCall(PetscFree(value));
  PetscCall(ReferenceDataFree(&curve));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ReferenceEnergy - Interpolates the reference kinetic energy at the present time from a file
   [J/m]. Collective. The result is NaN if file is NULL or absent, if the run is in 3D or has other
   physics than the case, and for times beyond the file, such as that of -steady. Input/Output:
   report - see ReferenceDataRead(). */
PetscErrorCode ReferenceEnergy(const Flow *flow, const char file[], Report *report,
                               PetscReal *energy)
{
  const Scene    *scene = flow->scene;
  const PetscReal t     = ClockMoment(flow->clock) * scene->speed / scene->length;
  ReferenceData   curve;

  PetscFunctionBegin;
  *energy = NAN;
  if (!file || scene->dim != 2 || scene->physics != scene->problem->physics) {
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(ReferenceDataRead(file, report, &curve));
  for (PetscInt k = 1; k < curve.n; k++) {
    if (t < curve.x[k - 1] || t > curve.x[k]) continue;
    *energy = curve.y[k - 1] +
              (curve.y[k] - curve.y[k - 1]) * (t - curve.x[k - 1]) / (curve.x[k] - curve.x[k - 1]);
    *energy *= scene->rho * PetscSqr(scene->speed * scene->length);
  }
  PetscCall(ReferenceDataFree(&curve));
  PetscFunctionReturn(PETSC_SUCCESS);
}
