/*
  Mode 2 of a viscous drop with a free surface, for amplitudes that leave the disc or ball round:
  the least damped decay without surface tension, an oscillation or a creeping return with it. An
  exact solution with both conditions of the surface: theory.md, (surface:mode) and (surface:ball).

  The flow is proportional to exp(-q nu t/R^2), and both conditions hold if q is a root of
  Condition(). The two roots of least size give a flow that starts from a disc or a ball.
*/
#include "cases.h"

#define TERMS      200   /* largest number of terms of a power series */
#define ITERATIONS 100   /* largest number of iterations for a root */
#define LAPLACE    1.6e6 /* largest sigma R/(rho nu^2): rounding of the series is below 1e-7 */

/* The two roots q. */
typedef struct {
  PetscComplex q[2];
} Roots;

/* A mode with the function F = a r^2 + b r^2 g(q r^2), r in units of R. */
typedef struct {
  PetscComplex q, a, b; /* Scene.solution has them of mode 0, then of mode 1 */
} Mode;

/* Numbers of a dimension. */
typedef struct {
  PetscReal order;   /* e: Bessel functions J_{m+e} */
  PetscReal radial;  /* u_r = radial F/r times the angular function */
  PetscReal tension; /* C = tension sigma R/(rho nu^2) */
  PetscReal t;       /* factor of the tangential stress */
  PetscReal decay;   /* the second root without surface tension, for the first guess */
  PetscReal rest;    /* pressure of the round drop over sigma/R */
} Dimension;
static const Dimension dimensions[] = {{0.0, 2.0, 6.0, 4.0, 5.5408, 1.0},
                                       {0.5, 6.0, 8.0, 6.0, 7.1055, 2.0}};

/* Returns the numbers of the scene's dimension. */
static const Dimension *Numbers(const Scene *scene)
{
  return &dimensions[scene->dim - 2];
}

/* Computes sum_i (-z/4)^i/(i! (2 + e)(3 + e)...(i + m + e)), which is proportional to J_{m+e}(k)
   (2/k)^(m+e) for z = k^2. */
static PetscComplex Series(PetscReal e, PetscInt m, PetscComplex z)
{
  PetscComplex term = 1.0, sum = 0.0;

  for (PetscInt i = 2; i <= m; i++) term /= i + e;
  for (PetscInt i = 1; i < TERMS && PetscAbsComplex(term) > 1e-17 * PetscAbsComplex(sum); i++) {
    sum += term;
    term *= -0.25 * z / (i * (i + m + e));
  }
  return sum;
}

/* Returns g(z): J_2(k r) in 2D, and the spherical j_2(k r) in 3D, are proportional to r^2 g(k^2
   r^2). */
static PetscComplex Radial(const Dimension *d, PetscComplex z)
{
  return Series(d->order, 2, z);
}

/* Returns dg/dz. */
static PetscComplex RadialSlope(const Dimension *d, PetscComplex z)
{
  return -0.25 * Series(d->order, 3, z);
}

/*
  Returns the determinant of the two conditions, with C of sigma R/(rho nu^2)

    tangential stress:   t a + b (t g - q (g + 4 g')) = 0 at r = 1
    normal stress:       a (q - 4 + C/q) + b (-4 (g + 2 q g') + g C/q) = 0
*/
static PetscComplex Condition(const Dimension *d, PetscReal C, PetscComplex q)
{
  const PetscComplex g = Radial(d, q), slope = RadialSlope(d, q);

  return (q - 4.0) * (d->t * g - q * (g + 4.0 * slope)) + 4.0 * d->t * (g + 2.0 * q * slope) -
         C * (g + 4.0 * slope);
}

/* Returns a root near a guess by the secant method, other than the given one if `other`. */
static PetscComplex FindRoot(const Dimension *d, PetscReal C, PetscComplex guess, PetscBool other,
                             PetscComplex given)
{
  PetscComplex q[2] = {guess + 1e-3, guess}, f[2];

  for (PetscInt k = 0; k < 2; k++) f[k] = Condition(d, C, q[k]) / (other ? q[k] - given : 1.0);
  for (PetscInt n = 0;
       n < ITERATIONS && PetscAbsComplex(q[1] - q[0]) > 1e-15 * (1.0 + PetscAbsComplex(q[1]));
       n++) {
    const PetscComplex next = f[1] == f[0] ? q[1] : q[1] - f[1] * (q[1] - q[0]) / (f[1] - f[0]);

    q[0] = q[1];
    f[0] = f[1];
    q[1] = next;
    f[1] = Condition(d, C, next) / (other ? next - given : 1.0);
  }
  return q[1];
}

/* Returns the two roots of least size: conjugate if the drop oscillates. Particles that are fixed
   feel no change of the surface, and have the roots without surface tension. */
static Roots FindRoots(const Scene *scene)
{
  const Dimension   *d    = Numbers(scene);
  const PetscReal    C    = SceneMoves(scene) ? d->tension * scene->tension * scene->length /
                                              (scene->rho * PetscSqr(scene->nu))
                                              : 0.0;
  const PetscComplex root = PetscSqrtComplex(PetscSqr(0.5 * d->decay) - d->decay * C / d->tension);
  Roots              roots;

  roots.q[0] = FindRoot(d, C, 0.5 * d->decay - root, PETSC_FALSE, 0.0);
  if (PetscAbsReal(PetscImaginaryPartComplex(roots.q[0])) > 1e-9 * PetscAbsComplex(roots.q[0]))
    roots.q[1] = PetscConjComplex(roots.q[0]);
  else roots.q[1] = FindRoot(d, C, 0.5 * d->decay + root, PETSC_TRUE, roots.q[0]);
  return roots;
}

/* Returns mode k of the flow that starts from a disc or a ball, with u_r = U times the angular
   function at r = 1. */
static Mode FindMode(const Scene *scene, const Roots *roots, PetscInt k)
{
  const Dimension   *d = Numbers(scene);
  const PetscComplex q = roots->q[k], g = Radial(d, q), slope = RadialSlope(d, q);
  Mode               mode = {.q = q};

  mode.b = scene->speed * d->t / (d->radial * (q - roots->q[1 - k]) * (g + 4.0 * slope));
  mode.a = -mode.b * (g - q / d->t * (g + 4.0 * slope));
  return mode;
}

/* Computes the modes and stores them in the scene. */
static void StoreModes(Scene *scene)
{
  const Roots roots = FindRoots(scene);

  for (PetscInt k = 0; k < 2; k++) {
    const Mode mode = FindMode(scene, &roots, k);

    scene->solution[3 * k]     = mode.q;
    scene->solution[3 * k + 1] = mode.a;
    scene->solution[3 * k + 2] = mode.b;
  }
}

static PetscErrorCode DropModeSetup(Scene *scene)
{
  const PetscReal R = scene->length, centre[ISPH_MAX_DIM] = {0.0},
                  most = LAPLACE * scene->rho * PetscSqr(scene->nu) / R;

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
  BodyBall(scene, centre, R, SceneAddFilled(scene));
  StoreModes(scene);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Computes velocity and pressure of both modes, with r in units of R and n = x/r

    2D: psi = F sin(2 theta) exp(-q nu t/R^2), u_r = psi_theta/r, u_theta = -psi_r, Y = cos(2 theta)
    3D: u = curl curl (x F Y exp(-q nu t/R^2)), Y = (3 n_z^2 - 1)/2
    p = p_0 + sigma (d - 1)/R + rho nu q a c r^2 Y exp(...)/R,   c = 1 in 2D, 3 in 3D

  u_r is U Y at r = 1 and t = 0. With the surface gradient G of Y on the unit circle or sphere, u =
  radial F/r Y n + T G, T = F'/2 in 2D and F' + F/r in 3D; radial and c are of dimensions[].
*/
static void DropModeExact(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[],
                          PetscReal *p)
{
  const Dimension *d      = Numbers(scene);
  const PetscInt   dim    = scene->dim;
  const PetscReal  R      = scene->length;
  PetscReal        radial = 0.0, along = 0.0, r = 0.0, n[ISPH_MAX_DIM], Y;

  for (PetscInt a = 0; a < dim; a++) r += PetscSqr(x[a]);
  r = PetscMax(PetscSqrtReal(r) / R, 1e-12);
  for (PetscInt a = 0; a < dim; a++) n[a] = x[a] / (R * r);
  Y  = dim == 2 ? n[0] * n[0] - n[1] * n[1] : 1.5 * n[2] * n[2] - 0.5;
  *p = scene->outside + d->rest * scene->tension / R;
  for (PetscInt k = 0; k < 2; k++) {
    const Mode         mode  = {scene->solution[3 * k], scene->solution[3 * k + 1],
                                scene->solution[3 * k + 2]};
    const PetscComplex z     = mode.q * r * r;
    const PetscComplex decay = PetscExpComplex(-mode.q * scene->nu * t / (R * R));
    const PetscComplex both  = mode.a + mode.b * Radial(d, z);

    radial += d->radial * r * PetscRealPartComplex(decay * both);
    along += (dim == 2 ? 0.5 : 1.0) * r *
             PetscRealPartComplex(decay * (dim * both + 2.0 * mode.b * z * RadialSlope(d, z)));
    *p += (2 * dim - 3) * scene->rho * scene->nu / R *
          PetscRealPartComplex(decay * mode.q * mode.a) * r * r * Y;
  }
  for (PetscInt a = 0; a < dim; a++) {
    const PetscReal slope = dim == 2 ? (a == 0 ? 2.0 : -2.0) * n[a] - 2.0 * Y * n[a]
                                     : 3.0 * n[2] * ((a == 2) - n[2] * n[a]);

    u[a] = radial * Y * n[a] + along * slope;
  }
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
    .three_d         = PETSC_TRUE,
    .Setup           = DropModeSetup,
    .Velocity        = VelocityExact,
    .Exact           = DropModeExact,
    .Measure         = MeasureExact,
};
