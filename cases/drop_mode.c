/*
  Mode 2 of a viscous drop with a free surface, for amplitudes that leave the disc round: the least
  damped decay without surface tension, an oscillation or a creeping return with it. An exact
  solution with both conditions of the surface: docs/theory.md, (166).

  The flow is proportional to exp(-q nu t/R^2), and both conditions hold if q is a root of
  Condition(). The two roots of least size give a flow that starts from a disc.
*/
#include "cases.h"

#define TERMS      200    /* largest number of terms of a power series */
#define ITERATIONS 100    /* largest number of iterations for a root */
#define LAPLACE    1.6e6  /* largest sigma R/(rho nu^2): rounding of the series is below 1e-7 */
#define DECAY      5.5408 /* the second root without surface tension, for the first guess */

/* The two roots q. */
typedef struct {
  PetscComplex q[2];
} Roots;

/* A mode with the stream function (a r^2 + b r^2 g(q r^2)) sin(2 theta), r in units of R. */
typedef struct {
  PetscComplex q, a, b;
} Mode;

/* Computes sum_i (-z/4)^i/(i! (i + m)!), which is J_m(k) (2/k)^m for z = k^2. */
static PetscComplex Series(PetscInt m, PetscComplex z)
{
  PetscComplex term = 1.0, sum = 0.0;

  for (PetscInt i = 2; i <= m; i++) term /= (PetscReal)i;
  for (PetscInt i = 1; i < TERMS && PetscAbsComplex(term) > 1e-17 * PetscAbsComplex(sum); i++) {
    sum += term;
    term *= -0.25 * z / (PetscReal)(i * (i + m));
  }
  return sum;
}

/* Returns g(z): J_2(k r) is proportional to r^2 g(k^2 r^2). */
static PetscComplex Radial(PetscComplex z)
{
  return Series(2, z);
}

/* Returns dg/dz. */
static PetscComplex RadialSlope(PetscComplex z)
{
  return -0.25 * Series(3, z);
}

/*
  Returns the determinant of the two conditions over q, with C = 6 sigma R/(rho nu^2)

    tangential stress:   4 a + b (4 g - q (g + 4 g')) = 0 at r = 1
    normal stress:       a (q - 4 + C/q) + b (-4 (g + 2 q g') + g C/q) = 0
*/
static PetscComplex Condition(PetscReal C, PetscComplex q)
{
  const PetscComplex g = Radial(q), slope = RadialSlope(q);

  return (q - 4.0) * (4.0 * g - q * (g + 4.0 * slope)) + 16.0 * (g + 2.0 * q * slope) -
         C * (g + 4.0 * slope);
}

/* Returns a root near a guess by the secant method, other than the given one if `other`. */
static PetscComplex FindRoot(PetscReal C, PetscComplex guess, PetscBool other, PetscComplex given)
{
  PetscComplex q[2] = {guess + 1e-3, guess}, f[2];

  for (PetscInt k = 0; k < 2; k++) f[k] = Condition(C, q[k]) / (other ? q[k] - given : 1.0);
  for (PetscInt n = 0;
       n < ITERATIONS && PetscAbsComplex(q[1] - q[0]) > 1e-15 * (1.0 + PetscAbsComplex(q[1]));
       n++) {
    const PetscComplex next = f[1] == f[0] ? q[1] : q[1] - f[1] * (q[1] - q[0]) / (f[1] - f[0]);

    q[0] = q[1];
    f[0] = f[1];
    q[1] = next;
    f[1] = Condition(C, next) / (other ? next - given : 1.0);
  }
  return q[1];
}

/* Returns the two roots of least size: conjugate if the drop oscillates. Particles that are fixed
   feel no change of the surface, and have the roots without surface tension. */
static Roots FindRoots(const Scene *scene)
{
  const PetscReal C =
      SceneMoves(scene) ? 6.0 * scene->tension * scene->length / (scene->rho * PetscSqr(scene->nu))
                        : 0.0;
  const PetscComplex root = PetscSqrtComplex(PetscSqr(0.5 * DECAY) - DECAY * C / 6.0);
  Roots              roots;

  roots.q[0] = FindRoot(C, 0.5 * DECAY - root, PETSC_FALSE, 0.0);
  if (PetscAbsReal(PetscImaginaryPartComplex(roots.q[0])) > 1e-9 * PetscAbsComplex(roots.q[0]))
    roots.q[1] = PetscConjComplex(roots.q[0]);
  else roots.q[1] = FindRoot(C, 0.5 * DECAY + root, PETSC_TRUE, roots.q[0]);
  return roots;
}

/* Returns mode k of the flow that starts from a disc with u_r = U cos(2 theta) at r = 1. */
static Mode FindMode(const Scene *scene, const Roots *roots, PetscInt k)
{
  const PetscComplex q = roots->q[k], g = Radial(q), slope = RadialSlope(q);
  Mode               mode = {.q = q};

  mode.b = 0.5 * scene->speed / ((q - roots->q[1 - k]) * (0.25 * g + slope));
  mode.a = -mode.b * (g - q * (0.25 * g + slope));
  return mode;
}

static PetscErrorCode DropModeSetup(Scene *scene)
{
  const PetscReal R = scene->length, most = LAPLACE * scene->rho * PetscSqr(scene->nu) / R;

  PetscFunctionBegin;
  UserCheck(scene->tension <= most,
            "-surface_tension %.6g: case %s has its exact solution up to %.3g N/m, the Ohnesorge "
            "number %.2g; use a larger viscosity",
            (double)scene->tension, scene->problem->name, (double)most,
            (double)(1.0 / PetscSqrtReal(LAPLACE)));
  for (PetscInt a = 0; a < scene->dim; a++) {
    scene->lo[a] = -1.5 * R;
    scene->hi[a] = 1.5 * R;
  }
  SceneSetSides(scene, &BoundaryNone);
  BodyCircle(SceneAddFilled(scene), 0.0, 0.0, R);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Computes velocity and pressure from the stream functions of both modes, with r in units of R

    psi = (a r^2 + b r^2 g(q r^2)) sin(2 theta) exp(-q nu t/R^2)
    u_r = psi_theta/r,   u_theta = -psi_r
    p = p_0 + sigma/R + rho nu q a r^2 cos(2 theta) exp(...)/R

  u_r is U cos(2 theta) at r = 1 and t = 0.
*/
static void DropModeExact(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[],
                          PetscReal *p)
{
  const PetscReal R      = scene->length;
  const PetscReal r      = PetscMax(PetscSqrtReal(x[0] * x[0] + x[1] * x[1]) / R, 1e-12);
  const PetscReal cosine = x[0] / (R * r), sine = x[1] / (R * r);
  const PetscReal cos2 = cosine * cosine - sine * sine, sin2 = 2.0 * sine * cosine;
  const Roots     roots  = FindRoots(scene);
  PetscReal       radial = 0.0, along = 0.0;

  *p = scene->outside + scene->tension / R;
  for (PetscInt k = 0; k < 2; k++) {
    const Mode         mode  = FindMode(scene, &roots, k);
    const PetscComplex z     = mode.q * r * r;
    const PetscComplex decay = PetscExpComplex(-mode.q * scene->nu * t / (R * R));
    const PetscComplex both  = mode.a + mode.b * Radial(z);

    radial += 2.0 * r * PetscRealPartComplex(decay * both) * cos2;
    along -= 2.0 * r * PetscRealPartComplex(decay * (both + mode.b * z * RadialSlope(z))) * sin2;
    *p += scene->rho * scene->nu / R * PetscRealPartComplex(decay * mode.q * mode.a) * r * r * cos2;
  }
  u[0] = radial * cosine - along * sine;
  u[1] = radial * sine + along * cosine;
}

const CaseRow CaseDropMode = {
    .name            = "drop_mode",
    .brief           = "mode 2 of a drop with a free surface, which surface tension lets oscillate",
    .citation        = "exact solution of the Stokes equations",
    .physics         = PHYSICS_VISCOSITY | PHYSICS_PRESSURE,
    .reynolds        = 1.0,
    .reynolds_length = 1.0,
    .t_end           = 0.1,
    .n               = 16,
    .Setup           = DropModeSetup,
    .Velocity        = VelocityExact,
    .Exact           = DropModeExact,
    .Measure         = MeasureExact,
};
