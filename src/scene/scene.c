/*
  Functions that return properties of a scene: physics, dimensionless numbers, force, and the frame
  of reference. scenecreate.c creates the scene; for its lattice see spacing.c.

  In a frame that turns with the rate w(t) about an axis along z, unknowns are the components of the
  velocity u relative to the laboratory along the axes of the frame. Fixed particles there see

    du/dt + (u - w z x r).grad u + w z x u = f - grad p/rho + nu lap u,   div u = 0,

  r: place relative to the axis. Bodies that turn with the frame, and walls that are round about the
  axis, keep their places in it, so that matrices are built once.
*/
#include "isph/scene.h"
#include <stdint.h>

#define SAMPLES    64 /* times at which an expression is evaluated in a window */
#define PER_PERIOD 16 /* least number of samples in a period */
#define NARROWINGS 10 /* largest number of times that the window shrinks by NARROWER */
#define NARROWER   4.0
#define PLACES     3 /* positions at which an expression of position is evaluated */

const char *const PhysicsNames[PHYSICS_COUNT + 1] = {"viscosity", "pressure",   "convection",
                                                     "walls",     "body_force", NULL};

#define PANELS 64 /* of the integral of the rate of the frame, in L/U */

/* All motions use the same arbitrary Lagrangian-Eulerian step; only the velocity of the particles
   differs. */
static const MotionRow motions[] = {
    {.name           = "lagrangian",
     .brief          = "particles move with the flow and are shifted",
     .particles_move = PETSC_TRUE},
    {
        .name  = "eulerian",
        .brief = "particles stay; du/dt gains -u.grad u; operators are built once",
    },
    {
        .name  = "frame",
        .brief = "particles and bodies that are not round turn with a frame about z; else as "
                 "eulerian",
        .turns = PETSC_TRUE,
    },
};
const Table MotionTable = TABLE("Motions", motions);

/* ScenePlaceText - Writes the coordinates of x, separated by commas; returns the text */
const char *ScenePlaceText(const Scene *scene, const PetscReal x[], char text[PLACE_TEXT])
{
  if (scene->dim == 2) (void)snprintf(text, PLACE_TEXT, "%.4g, %.4g", (double)x[0], (double)x[1]);
  else
    (void)snprintf(text, PLACE_TEXT, "%.4g, %.4g, %.4g", (double)x[0], (double)x[1], (double)x[2]);
  return text;
}

/* SceneHas - Returns true if the run computes this physics */
PetscBool SceneHas(const Scene *scene, Physics what)
{
  return (scene->physics & (unsigned)what) ? PETSC_TRUE : PETSC_FALSE;
}

/* SceneReynolds - Returns the Reynolds number, with the length that the case chooses for it;
   infinite without viscosity */
PetscReal SceneReynolds(const Scene *scene)
{
  if (!SceneHas(scene, PHYSICS_VISCOSITY)) return PETSC_INFINITY;
  return scene->speed * scene->problem->reynolds_length * scene->length / scene->nu;
}

/* SceneIsAsPosed - Returns true if the exact solution of the case holds: the run computes all
   physics of the case and adds no body force. Added pressure or convection does not change the
   exact solution of a case without them. */
PetscBool SceneIsAsPosed(const Scene *scene)
{
  const unsigned posed = scene->problem->physics;

  return !(posed & ~scene->physics) && !(scene->physics & ~posed & (unsigned)PHYSICS_BODY_FORCE);
}

/* SceneMoves - Returns true if particles move with the flow */
PetscBool SceneMoves(const Scene *scene)
{
  return scene->motion && scene->motion->particles_move;
}

/* BoundaryIs - Returns true if the kind of a boundary has all given properties */
PetscBool BoundaryIs(const Scene *scene, PetscInt side, unsigned properties)
{
  return (scene->boundary[side].kind->properties & properties) == properties;
}

/* SceneIsPeriodic - Returns true if the fluid continues at both ends of an axis */
PetscBool SceneIsPeriodic(const Scene *scene, PetscInt axis)
{
  return BoundaryIs(scene, 2 * axis, BOUNDARY_CONTINUES);
}

/* SceneKeepsMomentum - Returns true if no boundary and no body force changes the momentum of the
   fluid: a periodic box without bodies */
PetscBool SceneKeepsMomentum(const Scene *scene)
{
  for (PetscInt a = 0; a < scene->dim; a++) {
    if (!SceneIsPeriodic(scene, a)) return PETSC_FALSE;
  }
  return !(scene->n_bodies || SceneMixes(scene) || SceneHas(scene, PHYSICS_BODY_FORCE));
}

/* SceneIsDrivenInTime - Returns true if a wall's velocity or the body force depends on time, as a
   force of the laboratory does in a turning frame */
PetscBool SceneIsDrivenInTime(const Scene *scene)
{
  return scene->unsteady_walls ||
         (scene->force.n && ExpressionUses(&scene->force, EXPRESSION_TIME)) ||
         (scene->frame && SceneHas(scene, PHYSICS_BODY_FORCE));
}

/* SceneBodyForce - Computes the body force per unit mass at a position and time [m/s^2] */
void SceneBodyForce(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal f[])
{
  PetscReal        y[ISPH_MAX_DIM];
  const PetscReal *place = SceneLaboratoryPlace(scene, t, x, y);

  for (PetscInt a = 0; a < scene->dim; a++)
    f[a] = scene->force.n ? ExpressionValue(&scene->force, a, t, place) : scene->body_force[a];
  SceneIntoFrame(scene, t, f);
}

/* SceneFrameRate - Returns the rotation rate of the frame of reference, 0 in the laboratory
   [rad/s] */
PetscReal SceneFrameRate(const Scene *scene, PetscReal t)
{
  return scene->frame ? ExpressionValue(&scene->frame->rate, 0, t, NULL) : 0.0;
}

/* Returns the integral of the rate from a to b by Gauss' formula with three points. */
static PetscReal Turned(const TurningFrame *frame, PetscReal a, PetscReal b)
{
  const PetscReal middle = 0.5 * (a + b), way = PetscSqrtReal(0.6) * 0.5 * (b - a);

  return (b - a) / 18.0 *
         (5.0 * (ExpressionValue(&frame->rate, 0, middle - way, NULL) +
                 ExpressionValue(&frame->rate, 0, middle + way, NULL)) +
          8.0 * ExpressionValue(&frame->rate, 0, middle, NULL));
}

/* SceneFrameAngle - Returns the angle by which the frame has turned since t = 0, 0 in the
   laboratory [rad]. It depends on t alone, and not on the steps of a run. A steady flow, at t =
   infinity, is that of the frame at t = 0. */
PetscReal SceneFrameAngle(const Scene *scene, PetscReal t)
{
  TurningFrame   *f     = scene->frame;
  const PetscReal panel = scene->length / scene->speed / PANELS;
  PetscInt        whole;

  if (!f || PetscIsInfReal(t)) return 0.0;
  if (!ExpressionUses(&f->rate, EXPRESSION_TIME)) return t * SceneFrameRate(scene, t);
  if (t == f->t) return f->angle;
  whole = PetscMax((PetscInt)(t / panel), 0);
  if (whole >= f->panels) {
    PetscCallAbort(PETSC_COMM_SELF,
                   PetscRealloc(sizeof(PetscReal) * (size_t)(2 * whole + PANELS), &f->sum));
    for (f->panels = PetscMax(f->panels, 1), f->sum[0] = 0.0; f->panels < 2 * whole + PANELS;
         f->panels++)
      f->sum[f->panels] = f->sum[f->panels - 1] + Turned(f, (PetscReal)(f->panels - 1) * panel,
                                                         (PetscReal)f->panels * panel);
  }
  f->t     = t;
  f->angle = f->sum[whole] + Turned(f, (PetscReal)whole * panel, t);
  return f->angle;
}

/* Turns a vector about z by an angle. */
static void Turn(PetscReal angle, PetscReal v[])
{
  const PetscReal c = PetscCosReal(angle), s = PetscSinReal(angle), x = v[0];

  v[0] = c * x - s * v[1];
  v[1] = s * x + c * v[1];
}

/* SceneIntoBox - Moves a place into the box along periodic directions */
void SceneIntoBox(const Scene *scene, PetscReal x[])
{
  for (PetscInt a = 0; a < scene->dim; a++) {
    const PetscReal length = scene->hi[a] - scene->lo[a];

    if (!SceneIsPeriodic(scene, a)) continue;
    while (x[a] < scene->lo[a]) x[a] += length;
    while (x[a] > scene->hi[a]) x[a] -= length;
  }
}

/* SceneIntoFrame - Turns components along the axes of the laboratory into those along the axes of
   the frame */
void SceneIntoFrame(const Scene *scene, PetscReal t, PetscReal v[])
{
  if (scene->frame) Turn(-SceneFrameAngle(scene, t), v);
}

/* SceneOutOfFrame - Turns components along the axes of the frame into those along the axes of the
   laboratory */
void SceneOutOfFrame(const Scene *scene, PetscReal t, PetscReal v[])
{
  if (scene->frame) Turn(SceneFrameAngle(scene, t), v);
}

/* Turns a place about the axis of the frame by an angle. */
static void TurnPlace(const TurningFrame *frame, PetscReal angle, PetscReal x[])
{
  PetscReal r[2];

  for (PetscInt a = 0; a < 2; a++) r[a] = x[a] - frame->centre[a];
  Turn(angle, r);
  for (PetscInt a = 0; a < 2; a++) x[a] = r[a] + frame->centre[a];
}

/* ScenePlaceIntoFrame - Turns a place of the laboratory into one of the frame [m] */
void ScenePlaceIntoFrame(const Scene *scene, PetscReal t, PetscReal x[])
{
  if (scene->frame) TurnPlace(scene->frame, -SceneFrameAngle(scene, t), x);
}

/* ScenePlaceOutOfFrame - Turns a place of the frame into one of the laboratory [m] */
void ScenePlaceOutOfFrame(const Scene *scene, PetscReal t, PetscReal x[])
{
  if (scene->frame) TurnPlace(scene->frame, SceneFrameAngle(scene, t), x);
}

/* SceneLaboratoryPlace - Returns the place in the laboratory of a place of the frame: x, or y after
   it is set [m] */
const PetscReal *SceneLaboratoryPlace(const Scene *scene, PetscReal t, const PetscReal x[],
                                      PetscReal y[ISPH_MAX_DIM])
{
  if (!scene->frame) return x;
  for (PetscInt a = 0; a < scene->dim; a++) y[a] = x[a];
  ScenePlaceOutOfFrame(scene, t, y);
  return y;
}

/* SceneFrameVelocity - Computes the velocity w z x r of a point that turns with the frame, 0 in the
   laboratory [m/s] */
void SceneFrameVelocity(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal w[])
{
  const PetscReal rate = SceneFrameRate(scene, t);

  for (PetscInt a = 0; a < scene->dim; a++) w[a] = 0.0;
  if (!scene->frame) return;
  w[0] = -rate * (x[1] - scene->frame->centre[1]);
  w[1] = rate * (x[0] - scene->frame->centre[0]);
}

/* ScenePassing - Changes the velocity of the fluid at x into the one with which it convects past
   fixed particles: less that of the frame, and without convection that alone [m/s] */
void ScenePassing(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal v[])
{
  PetscReal w[ISPH_MAX_DIM];

  if (!scene->frame) return;
  SceneFrameVelocity(scene, t, x, w);
  for (PetscInt a = 0; a < scene->dim; a++)
    v[a] = (SceneHas(scene, PHYSICS_CONVECTION) ? v[a] : 0.0) - w[a];
}

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

/* Returns the period of an expression in the window [t, t + window]: twice the range of its values
   over their total variation, times the window. Ranges up to `least` count as constant. The window
   shrinks until a period has at least PER_PERIOD samples. Infinite if the window is shorter than a
   period. */
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

/* SceneDrivingPeriod - Returns the shortest period of the velocities of boundaries and of the body
   force in the window [t, t + window], if it is shorter than the window; otherwise infinity [s].
   The same on all ranks. Only expressions are evaluated. Input: least - largest change of a
   velocity, or of a force times the window, that counts as none [m/s]. */
PetscReal SceneDrivingPeriod(const Scene *scene, PetscReal t, PetscReal window, PetscReal least)
{
  PetscReal period = ExpressionPeriod(scene, &scene->force, t, window, least / window);

  for (PetscInt side = 0; side < 2 * scene->dim + scene->n_bodies && scene->unsteady_walls;
       side++) {
    const Boundary *boundary = &scene->boundary[side];

    period = PetscMin(period, ExpressionPeriod(scene, &boundary->velocity, t, window, least));
    period = PetscMin(
        period, ExpressionPeriod(scene, &boundary->rotation, t, window, least / scene->length));
  }
  for (PetscInt k = 0; k < scene->n_parts; k++)
    period = PetscMin(period, ExpressionPeriod(scene, &scene->part[k].velocity, t, window, least));
  return period;
}
