/*
  Lid-driven cavity: a unit square or cube, the lid y = L moving along x with U. Compared on the
  centrelines with converged reference data; Ghia's tables (cases/reference) are for pictures only.
*/
#include "cases.h"

#define LINE_POINTS 401

PetscErrorCode CavitySetup(Scene *scene)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) scene->hi[a] = scene->length;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The lid is the wall at the high end of y. */
void CavityWallVelocity(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[],
                        PetscReal u[])
{
  if (side == 3) u[0] = scene->speed;
}

/*
  References in 2D: extrema on the centrelines over U, from when to when they hold (t U/L), and the
  files of profiles. The finite-volume data were extrapolated from meshes of
  50^2, 100^2 and 200^2 cells (see the files' heads).
*/
typedef struct {
  PetscReal   reynolds_low, reynolds_high, from, to;
  PetscReal   u_min, v_max, v_min; /* NaN: none */
  const char *u_file, *v_file;
} CavityReference;

static const CavityReference references[] = {
    /* Stokes flow, times in L^2/nu: u_min of converged runs at vanishing Re, see docs/results */
    {0.0, 0.1, 0.2, PETSC_MAX_REAL, -0.2073, NAN, NAN, NULL, NULL},
    /* finite volumes, Richardson extrapolation */
    {99.9, 100.1, 10.0, PETSC_MAX_REAL, -0.21404, 0.17957, -0.25380, "cavity_re100_u.csv",
     "cavity_re100_v.csv"},
    {399.9, 400.1, 40.0, PETSC_MAX_REAL, -0.32873, 0.30383, -0.45407, "cavity_re400_u.csv",
     "cavity_re400_v.csv"},
    /* at t = 40 from rest the flow is not yet steady */
    {999.9, 1000.1, 39.9, 40.1, -0.38730, 0.37541, -0.52594, "cavity_re1000_t40_u.csv",
     "cavity_re1000_t40_v.csv"},
    /* Botella & Peyret, Computers & Fluids 27 (1998) 421-433, spectral */
    {999.9, 1000.1, 40.1, PETSC_MAX_REAL, -0.38857, 0.37694, -0.52708, "cavity_re1000_u.csv",
     "cavity_re1000_v.csv"},
};

/* The reference that holds for this run at its present time, or NULL; a steady state is as good as
 * late. */
static const CavityReference *FindReference(const Scene *scene, const Clock *clock)
{
  const PetscReal reynolds = SceneReynolds(scene);
  const PetscReal unit =
      reynolds < 1.0 ? PetscSqr(scene->length) / scene->nu : scene->length / scene->speed;

  if (scene->dim != 2 || scene->physics != scene->problem->physics) return NULL;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(references); k++) {
    const CavityReference *r = &references[k];

    if (reynolds < r->reynolds_low || reynolds > r->reynolds_high) continue;
    if (clock->t >= r->from * unit && clock->t <= r->to * unit) return r;
    if (clock->steady && r->to == PETSC_MAX_REAL) return r;
  }
  return NULL;
}

/* Velocity component c over U at n points along axis a through the centre, at s over L. */
static PetscErrorCode SampleLine(const Flow *flow, PetscInt a, PetscInt c, PetscInt n,
                                 const PetscReal s[], PetscReal value[])
{
  const Scene *scene = flow->scene;
  PetscReal   *x, *u;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(n * scene->dim, &x, n * scene->dim, &u));
  for (PetscInt k = 0; k < n; k++) {
    for (PetscInt b = 0; b < scene->dim; b++)
      x[k * scene->dim + b] = scene->length * (a == b ? s[k] : 0.5);
  }
  PetscCall(ProbePoints(flow, n, x, u, NULL));
  for (PetscInt k = 0; k < n; k++) value[k] = u[k * scene->dim + c] / scene->speed;
  PetscCall(PetscFree2(x, u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Extremum of samples, sharpened by the parabola through it and its neighbours. */
static PetscReal Extremum(PetscInt n, const PetscReal value[], PetscReal sign)
{
  PetscInt  best = 1;
  PetscReal slope, bend;

  for (PetscInt k = 1; k < n - 1; k++) best = sign * value[k] > sign * value[best] ? k : best;
  slope = 0.5 * (value[best + 1] - value[best - 1]);
  bend  = value[best + 1] - 2.0 * value[best] + value[best - 1];
  return sign * bend < 0.0 ? value[best] - 0.5 * slope * slope / bend : value[best];
}

static PetscErrorCode AddExtrema(const Flow *flow, const CavityReference *r, Report *report)
{
  PetscReal s[LINE_POINTS], value[LINE_POINTS];

  PetscFunctionBegin;
  for (PetscInt k = 0; k < LINE_POINTS; k++) s[k] = (PetscReal)k / (LINE_POINTS - 1);
  PetscCall(SampleLine(flow, 1, 0, LINE_POINTS, s, value));
  PetscCall(ReportAddReference(report, "u_min", Extremum(LINE_POINTS, value, -1.0),
                               r ? r->u_min : NAN, r ? PetscAbsReal(r->u_min) : 1.0));
  PetscCall(SampleLine(flow, 0, 1, LINE_POINTS, s, value));
  PetscCall(ReportAddReference(report, "v_max", Extremum(LINE_POINTS, value, 1.0),
                               r ? r->v_max : NAN, r ? PetscAbsReal(r->v_max) : 1.0));
  PetscCall(ReportAddReference(report, "v_min", Extremum(LINE_POINTS, value, -1.0),
                               r ? r->v_min : NAN, r ? PetscAbsReal(r->v_min) : 1.0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Root mean square difference over U from a reference profile along axis a. */
static PetscErrorCode AddProfile(const Flow *flow, PetscInt a, PetscInt c, const char file[],
                                 const char name[], Report *report)
{
  Curve      curve;
  PetscReal *value, sum = 0.0;

  PetscFunctionBegin;
  PetscCall(CurveRead(file, &curve));
  PetscCall(PetscMalloc1(curve.n, &value));
  PetscCall(SampleLine(flow, a, c, curve.n, curve.x, value));
  for (PetscInt k = 0; k < curve.n; k++) sum += PetscSqr(value[k] - curve.y[k]);
  PetscCall(ReportAddError(report, name, PetscSqrtReal(sum / curve.n)));
  PetscCall(PetscFree(value));
  PetscCall(CurveFree(&curve));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Kinetic energy from rest at the present time, between the times of the file; NaN where there is
 * none. */
static PetscErrorCode ReferenceEnergy(const Flow *flow, PetscReal *energy)
{
  const Scene    *scene    = flow->scene;
  const PetscReal t        = flow->clock->t * scene->speed / scene->length,
                  reynolds = SceneReynolds(scene);
  const char *file         = PetscAbsReal(reynolds - 100.0) < 0.1    ? "cavity_re100_ke.csv"
                             : PetscAbsReal(reynolds - 1000.0) < 0.1 ? "cavity_re1000_ke.csv"
                                                                     : NULL;
  Curve       curve;

  PetscFunctionBegin;
  *energy = NAN;
  if (!file || scene->dim != 2 || scene->physics != scene->problem->physics) {
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(CurveRead(file, &curve));
  for (PetscInt k = 1; k < curve.n; k++) {
    if (t < curve.x[k - 1] || t > curve.x[k]) continue;
    *energy = curve.y[k - 1] +
              (curve.y[k] - curve.y[k - 1]) * (t - curve.x[k - 1]) / (curve.x[k] - curve.x[k - 1]);
    *energy *= scene->rho * PetscSqr(scene->speed * scene->length);
  }
  PetscCall(CurveFree(&curve));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  CavityJudge - Extrema and profiles of the velocity on the centrelines, in units of U

  u on the line x = L/2 (all other coordinates in the middle too), v on y = L/2.
*/
PetscErrorCode CavityJudge(const Flow *flow, Report *report)
{
  const CavityReference *r = FindReference(flow->scene, flow->clock);
  PetscReal              energy;

  PetscFunctionBegin;
  PetscCall(AddExtrema(flow, r, report));
  if (r && r->u_file) {
    PetscCall(AddProfile(flow, 1, 0, r->u_file, "u_profile_l2", report));
    PetscCall(AddProfile(flow, 0, 1, r->v_file, "v_profile_l2", report));
  }
  PetscCall(ReferenceEnergy(flow, &energy));
  PetscCall(JudgeCommon(flow, energy, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}
