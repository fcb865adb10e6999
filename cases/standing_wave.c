/* A standing wave of gravity and surface tension, of small amplitude, on a viscous fluid above a
   floor without slip, in a channel with one wave length: the least damped mode of the linear
   equations, an exact solution for small slopes. It begins with a flat surface. g = U^2/L along y,
   wave length L, depth L/2. */
#include "cases.h"
#include "isph/strain.h"

#define DEPTH 0.5  /* [L] */
#define CREST 0.01 /* elevation of the first crest [L] */

/* Mode exp(sigma t) over the height y above the floor, in units of L and L/U. */
typedef struct {
  PetscComplex sigma;     /* growth rate */
  PetscComplex m;         /* wave number of the shear layers along y */
  PetscComplex phi[2];    /* potential: factors of exp(k (y - H)) and exp(-k y) */
  PetscComplex psi[2];    /* stream function: factors of exp(m (y - H)) and exp(-m y) */
  PetscComplex elevation; /* of the surface */
} Mode;

/*
  Computes a mode for a growth rate, k = 2 pi, and returns the residual of its normal stress

    u = Re (-k Phi + Psi') sin kx,   v = Re (Phi' - k Psi) cos kx,   m^2 = k^2 + sigma/nu
    Phi = exp(k (y - H)) + a exp(-k y),   Psi = b exp(m (y - H)) + c exp(-m y)
    floor, y = 0:               u = v = 0 give a and c for any b
    tangential stress, y = H:   Psi'' + k^2 Psi = 2 k Phi' gives b
    normal stress, y = H:       sigma Phi + (1 + T k^2) v/sigma + 2 nu v' = 0 gives sigma

  T is the surface tension over rho U^2 L.
*/
static PetscComplex ModeResidual(PetscReal nu, PetscReal tension, PetscComplex sigma, Mode *mode)
{
  const PetscReal    k = 2.0 * PETSC_PI, e = PetscExpReal(-k * DEPTH);
  const PetscComplex m = PetscSqrtComplex(k * k + sigma / nu), f = PetscExpComplex(-m * DEPTH);
  const PetscComplex a0 = e * (m + k) / (m - k), a1 = -2.0 * m * f / (m - k); /* a = a0 + a1 b */
  const PetscComplex c0 = e - a0, c1 = -f - a1;                               /* c = c0 + c1 b */
  const PetscComplex s = m * m + k * k;
  const PetscComplex b =
      (2.0 * k * k * (1.0 - a0 * e) - s * c0 * f) / (s * (1.0 + c1 * f) + 2.0 * k * k * a1 * e);
  const PetscComplex a = a0 + a1 * b, c = c0 + c1 * b;
  const PetscComplex phi = 1.0 + a * e, psi = b + c * f, slope = m * (b - c * f);
  const PetscComplex v = k * (1.0 - a * e) - k * psi;

  *mode = (Mode){.sigma = sigma, .m = m, .phi = {1.0, a}, .psi = {b, c}, .elevation = v / sigma};
  return sigma * phi + (1.0 + tension * k * k) * v / sigma + 2.0 * nu * (k * k * phi - k * slope);
}

/* Computes the least damped mode by the secant method, from the rate of a thin fluid, and scales it
   to a flat surface at t = 0 and the crest CREST after it. */
static Mode FindMode(const Scene *scene)
{
  const PetscReal k  = 2.0 * PETSC_PI;
  const PetscReal nu = PetscMax(scene->nu / (scene->speed * scene->length), 1e-9);
  const PetscReal T  = scene->tension / (scene->rho * PetscSqr(scene->speed) * scene->length);
  PetscComplex    older, sigma, r_older, r, factor;
  PetscReal       omega, decay, crest; /* rates; time of the first crest */
  Mode            mode;

  older   = PETSC_i * PetscSqrtReal(k * (1.0 + T * k * k) * PetscTanhReal(k * DEPTH)) - nu * k * k;
  sigma   = older * 1.001;
  r_older = ModeResidual(nu, T, older, &mode);
  r       = ModeResidual(nu, T, sigma, &mode);
  for (PetscInt it = 0; it < 50 && PetscAbsComplex(sigma - older) > 1e-13; it++) {
    const PetscComplex next = sigma - r * (sigma - older) / (r - r_older);

    older   = sigma;
    r_older = r;
    sigma   = next;
    r       = ModeResidual(nu, T, sigma, &mode);
    if (r == r_older) break;
  }
  omega  = PetscImaginaryPartComplex(sigma);
  decay  = -PetscRealPartComplex(sigma);
  crest  = PetscAtan2Real(omega, decay) / omega;
  factor = -PETSC_i * CREST * PetscExpReal(decay * crest) /
           (mode.elevation * PetscSinReal(omega * crest));
  for (PetscInt j = 0; j < 2; j++) {
    mode.phi[j] *= factor;
    mode.psi[j] *= factor;
  }
  mode.elevation *= factor;
  return mode;
}

/* Returns the mode that StandingWaveSetup() has stored in the scene. */
static Mode StandingWaveMode(const Scene *scene)
{
  const PetscComplex *s = scene->solution;

  return (Mode){
      .sigma = s[0], .m = s[1], .phi = {s[2], s[3]}, .psi = {s[4], s[5]}, .elevation = s[6]};
}

/* Sets the channel; refuses viscosities without waves, whose modes decay without a crest. */
static PetscErrorCode StandingWaveSetup(Scene *scene)
{
  const Mode         mode    = FindMode(scene);
  const PetscComplex store[] = {mode.sigma,  mode.m,      mode.phi[0],   mode.phi[1],
                                mode.psi[0], mode.psi[1], mode.elevation};

  PetscFunctionBegin;
  PetscCall(PetscArraycpy(scene->solution, store, SCENE_SOLUTION));
  scene->hi[0] = scene->length;
  scene->hi[1] = DEPTH * scene->length;
  SceneSetAxis(scene, 0, &BoundaryPeriodic);
  SceneFillUpTo(scene, 1u << 3);
  scene->body_force[1] = -PetscSqr(scene->speed) / scene->length;
  UserCheck(PetscImaginaryPartComplex(mode.sigma) > 0.1,
            "-reynolds: case standing_wave has no wave at %g; give 15 or more",
            (double)(scene->speed * scene->length / scene->nu));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes velocity and pressure rho (g (H - y) - Re (sigma Phi cos kx)), see ModeResidual(). */
static void StandingWaveExact(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[],
                              PetscReal *p)
{
  const Mode         mode = StandingWaveMode(scene);
  const PetscReal    L = scene->length, U = scene->speed, k = 2.0 * PETSC_PI, y = x[1] / L;
  const PetscReal    cosine = PetscCosReal(k * x[0] / L), sine = PetscSinReal(k * x[0] / L);
  const PetscComplex growth = PetscExpComplex(mode.sigma * t * U / L);
  const PetscComplex up     = mode.phi[0] * PetscExpReal(k * (y - DEPTH)) * growth,
                     down   = mode.phi[1] * PetscExpReal(-k * y) * growth,
                     upper  = mode.psi[0] * PetscExpComplex(mode.m * (y - DEPTH)) * growth,
                     lower  = mode.psi[1] * PetscExpComplex(-mode.m * y) * growth;

  u[0] = U * sine * PetscRealPartComplex(-k * (up + down) + mode.m * (upper - lower));
  u[1] = U * cosine * PetscRealPartComplex(k * (up - down) - k * (upper + lower));
  *p   = scene->outside +
       scene->rho * U * U * (DEPTH - y - cosine * PetscRealPartComplex(mode.sigma * (up + down)));
}

/* Adds a point of the surface to the normal equations of a fit of its height. */
static void AddHeight(PetscReal k, PetscReal x, PetscReal y, PetscReal sum[12])
{
  const PetscReal basis[] = {PetscCosReal(k * x), PetscSinReal(k * x), 1.0};

  for (PetscInt r = 0; r < 3; r++) {
    for (PetscInt c = 0; c < 3; c++) sum[3 * r + c] += basis[r] * basis[c];
    sum[9 + r] += basis[r] * y;
  }
}

/* Computes the amplitude of the surface: the factor of cos kx in a least-squares fit of its height
   by 1, cos kx and sin kx at the middles of facets; leaves it without three of them. */
static PetscErrorCode SurfaceAmplitude(const Flow *flow, PetscReal *amplitude)
{
  const Particles *p       = flow->particles;
  const PetscReal  k       = 2.0 * PETSC_PI / flow->scene->length;
  PetscReal        sum[12] = {0.0}; /* normal equations by rows, then their right-hand side */

  PetscFunctionBegin;
  for (PetscInt f = 0; flow->ops->strain && f < flow->ops->strain->surface.n; f++) {
    const PetscReal *x       = &flow->ops->strain->surface.x[4 * f],
                    middle[] = {0.5 * (x[0] + x[2]), 0.5 * (x[1] + x[3])};

    if (ParticlesHolds(p, middle)) AddHeight(k, middle[0], middle[1], sum);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 12, MPIU_REAL, MPIU_SUM, p->comm));
  if (!DenseCholesky(3, sum)) {
    DenseCholeskySolve(3, sum, &sum[9]);
    *amplitude = sum[9];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reports the amplitude of the surface, its error relative to the first crest, and the errors
   against the exact solution. */
static PetscErrorCode StandingWaveMeasure(const Flow *flow, Report *report)
{
  const Scene    *scene     = flow->scene;
  const Mode      mode      = StandingWaveMode(scene);
  const PetscReal t         = ClockMoment(flow->clock) * scene->speed / scene->length;
  PetscReal       amplitude = NAN, exact;

  PetscFunctionBegin;
  PetscCall(SurfaceAmplitude(flow, &amplitude));
  exact = PetscRealPartComplex(mode.elevation * PetscExpComplex(mode.sigma * t));
  if (SceneIsAsPosed(scene) && SceneIsNewtonian(scene)) {
    PetscCall(ReportAddReference(report, "amplitude", amplitude, exact * scene->length,
                                 CREST * scene->length));
  } else {
    PetscCall(ReportAdd(report, "amplitude", amplitude));
  }
  PetscCall(MeasureExact(flow, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const CaseRow CaseStandingWave = {
    .name  = "standing_wave",
    .brief = "viscous wave of small amplitude, with surface tension if given, from a flat surface",
    .citation        = "exact solution of the linear equations; H. Lamb, Hydrodynamics (1932), 349",
    .physics         = NAVIER_STOKES | PHYSICS_WALLS | PHYSICS_BODY_FORCE,
    .reynolds        = 50.0,
    .reynolds_length = 1.0,
    .t_end           = 2.5,
    .n               = 24,
    .Setup           = StandingWaveSetup,
    .Velocity        = VelocityExact,
    .Exact           = StandingWaveExact,
    .Measure         = StandingWaveMeasure,
};
