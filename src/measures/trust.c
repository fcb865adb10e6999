/*
  How far the velocity of a report can be trusted: an estimate of its error, and the cause of most
  of it.

    space     the gradients of two fits (resolution.c)
    operator  the defect of momentum and mass (defect.c), which sees inconsistent forms, varying
              viscosities and boundaries; below a free surface of strain cells the response of the
              flow to wider fits (src/schemes/coupled/velocityerror.c)
    time      the steps (src/flow/acceleration.c; of moving particles, their paths too)
    balance   the worst row of the balance sheet, if it is out of its bound
    layer     sheared layers of a fluid that yields, if they have less than LAYER_LEAST particles

  Space and operator see the same error where the form is consistent. The defect is the better
  estimate if it is larger; otherwise their geometric mean stands, because both are logarithmically
  spread about the true error. results/trust.md compares them with the true errors of flows.

  The pressure below a free surface tends to that of the tension there: the normal stress of the
  surface, which it lacks, is the layer's own, (strain:layer). The stress at the particles over the
  pressure, root mean squares, is reported as the estimate of its error.
*/
#include "defect.h"
#include "isph/balance.h"
#include "isph/strain.h"
#include "splines/splines.h"

#define TRUSTED      0.05 /* largest estimated error that can be trusted [-] */
#define LAYER_LEAST  2.0  /* least thickness of a sheared layer [dx] */
#define LAYER_WANTED 3.0  /* thickness that is advised [dx] */
#define SLIP_LEAST   2.0  /* least slip length of a contact line that a wall drags [dx] */
#define CUT          0.01 /* share of the fluid [-] */
#define SPLIT        5e-3 /* nu dt/L^2 of a projection from which its splitting may err [-] */
#define APART        3.0  /* ratio of errors that no resolution explains [-] */
#define CURVED       0.02 /* share of the edge of a surface that is across the rest of it [-] */
#define AT_REST      1e-2 /* least speed of a moving fluid over that which drives it [-] */
#define SLOW         1e-6 /* 1/T of a steady solve [U/L] */

static const char *const names[TRUST_BALANCE] = {"error_space", "error_operator", "error_time"};
static const char *const words[TRUST_PARTS]   = {"space", "operator", "time", "balance", "layer"};

/* Combines the parts to the error of the velocity. */
static void Combine(Trust *trust)
{
  const PetscReal *part  = trust->part;
  PetscReal        space = part[TRUST_OPERATOR];

  if (space < part[TRUST_SPACE]) space = PetscSqrtReal(space * part[TRUST_SPACE]);
  trust->error = space + part[TRUST_TIME];
  trust->worst = part[TRUST_OPERATOR] > part[TRUST_SPACE] ? TRUST_OPERATOR : TRUST_SPACE;
  if (part[TRUST_TIME] > space) trust->worst = TRUST_TIME;
  if (part[TRUST_BALANCE] > trust->error) {
    trust->error = part[TRUST_BALANCE];
    trust->worst = TRUST_BALANCE;
  }
  if (part[TRUST_LAYER] > trust->error) {
    trust->error = part[TRUST_LAYER];
    trust->worst = TRUST_LAYER;
  }
}

/* Returns the largest violation of a balance that an error of the velocity makes, at least an error
   that cannot be trusted; zero if these balances are kept. Forces may err where the velocity does
   not: their balances have notes of their own. */
static PetscReal BalanceError(const Flow *flow)
{
  const BalanceSheet *sheet = &flow->scheme->sheet;
  PetscReal           most  = 0.0;

  for (PetscInt k = 0; k < BALANCES; k++) {
    const PetscReal value = sheet->value[k], bound = BalanceRows[k].bound;

    if (k == BALANCE_FORCE || k == BALANCE_TORQUE) continue;
    if (!sheet->applies[k] || !(value > bound)) continue;
    most = PetscMax(most, PetscMax(value, TRUSTED * value / bound));
  }
  return most;
}

/* Returns the speed to which errors are relative: that of the fluid, at least AT_REST of the speed
   that its walls, its start and its force can give it, or of U. A fluid that is pushed has a
   velocity of its own to err from, however slow it is beside U. */
static PetscReal ErrorScale(const Flow *flow)
{
  const Scene      *scene  = flow->scene;
  const SpeedBound *bound  = &flow->scheme->bound;
  const PetscReal   L      = scene->length;
  PetscReal         driven = bound->start + bound->walls;

  if (SceneHas(scene, PHYSICS_VISCOSITY)) driven += bound->force * PetscSqr(L) / scene->nu_low;
  else driven += PetscSqrtReal(bound->force * L);
  if (!(driven > 0.0) || driven > scene->speed) driven = scene->speed;
  return PetscMax(FlowRmsSpeed(flow), AT_REST * driven);
}

/* Returns the error by sheared layers of a fluid that yields, at most 1: by those that are too
   thin, of order dx^2 as the errors of the operators are, and in flows that forces drive by the
   error of stresses, which is that of their balance: only the excess over the yield stress shears
   the fluid */
static PetscReal LayerError(const Flow *flow, const Resolution *resolution)
{
  const BalanceSheet *sheet = &flow->scheme->sheet;
  const SpeedBound   *bound = &flow->scheme->bound;
  PetscReal           error = 0.0;

  if (!(resolution->layer > 0.0)) return 0.0;
  if (resolution->layer < LAYER_LEAST) error = TRUSTED * PetscSqr(LAYER_LEAST / resolution->layer);
  if (sheet->applies[BALANCE_FORCE] && bound->force > 0.0 && !(bound->walls > 0.0))
    error = PetscMax(error, sheet->value[BALANCE_FORCE] / resolution->excess);
  return PetscMin(error, 1.0);
}

/* Computes the stress of the layer below a free surface over the pressure beyond that outside; zero
   without a layer. Collective. */
static PetscErrorCode SurfaceStress(const Flow *flow, PetscReal *share)
{
  Splines  *s = flow->scheme->splines;
  PetscReal sum[2];
  Vec       stress, excess;

  PetscFunctionBegin;
  *share = 0.0;
  if (!s || !s->layer) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SplinesLayerStress(flow, s, &stress));
  PetscCall(VecDuplicate(stress, &excess));
  PetscCall(VecCopy(flow->state->p, excess));
  PetscCall(VecShift(excess, -flow->scene->level));
  PetscCall(FluidSum(flow->particles, stress, PETSC_TRUE, &sum[0]));
  PetscCall(FluidSum(flow->particles, excess, PETSC_TRUE, &sum[1]));
  if (sum[1] > 0.0) *share = PetscSqrtReal(sum[0] / sum[1]);
  PetscCall(VecDestroyAll(&stress, &excess));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds to the errors of forces and torques on bodies those that they have with the velocity. */
static PetscErrorCode AddForceErrors(const Scene *scene, PetscReal error, Report *report)
{
  static const char *const rows[2][4] = {{"fx", "fy", "fz", "force_error"},
                                         {"torque_x", "torque_y", "torque", "torque_error"}};

  PetscFunctionBegin;
  for (PetscInt k = 0; k < 2 * scene->n_bodies; k++) {
    Quantity *row  = NULL;
    PetscReal size = 0.0;
    char      name[WALL_NAME + 32], body[WALL_NAME];

    SceneWallName(scene, SceneBodySide(scene, k / 2), body);
    for (PetscInt a = 0; a < 4; a++) {
      PetscCall(PetscSNPrintf(name, sizeof(name), "%s_%s", body, rows[k % 2][a]));
      row = ReportFind(report, name);
      if (row && a < 3) size += PetscSqr(row->value);
    }
    if (row) row->value += error * PetscSqrtReal(size);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns 1/T of the age T of the flow [1/s]. */
static PetscReal AgeRate(const Flow *flow)
{
  const PetscReal age = ClockMoment(flow->clock), least = SLOW * flow->scene->speed;

  if (flow->clock->steady_solve || !(age > 0.0)) return least / flow->scene->length;
  return 1.0 / age;
}

/* Computes the root mean square error of the velocity by its operators [m/s]. */
static PetscErrorCode OperatorError(Flow *flow, PetscReal *error)
{
  Defect defect;

  PetscFunctionBegin;
  if (flow->ops->cut_surface) {
    PetscCall(flow->scheme->row->Error(flow, AgeRate(flow), error));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(DefectCreate(flow, &defect));
  PetscCall(DefectError(flow, AgeRate(flow), &defect, error));
  PetscCall(DefectDestroy(&defect));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TrustMeasure - Estimates the error of the velocity, and reports it with its parts, and 1 if it is
   at most TRUSTED, otherwise 0. Collective. Errors are root mean squares over ErrorScale(). That of
   the operators is over the sum of both, the most that the true velocity can be. */
PetscErrorCode TrustMeasure(Flow *flow, Report *report)
{
  const PetscReal scale = ErrorScale(flow);
  Trust          *trust = &report->trust;
  Resolution      resolution;
  PetscReal       error;

  PetscFunctionBegin;
  PetscCall(ResolutionEstimate(flow, &resolution));
  PetscCall(OperatorError(flow, &error));
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) trust->x[a] = resolution.x[a];
  trust->part[TRUST_SPACE]    = resolution.error;
  trust->part[TRUST_OPERATOR] = error / (scale + error);
  trust->part[TRUST_TIME]     = resolution.path + flow->state->acceleration.time_error / scale;
  trust->part[TRUST_BALANCE]  = BalanceError(flow);
  trust->part[TRUST_LAYER]    = LayerError(flow, &resolution);
  trust->layer                = resolution.layer;
  Combine(trust);
  PetscCall(SurfaceStress(flow, &trust->surface));
  PetscCall(ReportAddError(report, "velocity_l2_estimate", trust->error));
  for (PetscInt k = 0; k < TRUST_BALANCE; k++) /* the sheet reports its own */
    PetscCall(ReportAddError(report, names[k], trust->part[k]));
  if (trust->layer > 0.0) PetscCall(ReportAdd(report, "sheared_layer", trust->layer));
  if (trust->surface > 0.0)
    PetscCall(ReportAddError(report, "pressure_l2_estimate", trust->surface));
  PetscCall(ReportAdd(report, "trust", trust->error <= TRUSTED ? 1.0 : 0.0));
  PetscCall(AddForceErrors(flow->scene, trust->error, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns nu dt/L^2 of a projection, whose splitting of velocity and pressure errs with it while
   the pressure changes; zero of other schemes. */
static PetscReal Splitting(const Flow *flow)
{
  const Scene *scene = flow->scene;

  if (!flow->scheme->variant || !SceneHas(scene, PHYSICS_VISCOSITY)) return 0.0;
  return scene->nu * flow->clock->dt / PetscSqr(scene->length);
}

/* Returns true if the splitting of a projection explains a defect of the momentum that gradients do
   not: the velocity slips along walls by dt grad phi. The error in time of the steps, which follows
   from the changes of the velocity, has no part of it. */
static PetscBool SplittingErrs(const Flow *flow, const Trust *trust)
{
  return trust->worst == TRUST_OPERATOR && Splitting(flow) > SPLIT &&
         trust->part[TRUST_OPERATOR] > APART * trust->part[TRUST_SPACE];
}

/* Writes the advice that follows from the cause of the error. */
static PetscErrorCode Advise(const Flow *flow, const Trust *trust, char text[], size_t length)
{
  const LaplacianRow *row = flow->ops->forms.visc.row;
  char                place[128];
  PetscBool           typed;

  PetscFunctionBegin;
  PetscCall(OptionGiven("-visc_laplacian", &typed));
  if (trust->layer > 0.0 && trust->layer < LAYER_LEAST) {
    PetscCall(PetscSNPrintf(text, length,
                            "sheared layers beside rigid parts are %.2g particles thick, and need "
                            "at least %.0f; try -n %.0f",
                            (double)trust->layer, LAYER_LEAST,
                            PetscCeilReal(flow->scene->n * LAYER_WANTED / trust->layer)));
  } else if (trust->worst == TRUST_BALANCE) {
    PetscCall(PetscStrncpy(text, "see the balances below", length));
  } else if (trust->worst == TRUST_TIME) {
    PetscCall(PetscStrncpy(text, "try a smaller -dt or -cfl", length));
  } else if (trust->worst == TRUST_OPERATOR && typed && row &&
             !(row->properties & FORM_EXACT_QUADRATIC)) {
    PetscCall(PetscSNPrintf(text, length,
                            "-visc_laplacian %s does not follow every velocity; try its default, "
                            "or a larger -n",
                            row->name));
  } else if (SplittingErrs(flow, trust)) {
    PetscCall(PetscSNPrintf(text, length,
                            "gradients are resolved to %.2g %%, and the projection splits velocity "
                            "and pressure at nu dt/L^2 = %.2g; try -dt %.2g or -scheme coupled",
                            100.0 * (double)trust->part[TRUST_SPACE], (double)Splitting(flow),
                            (double)(flow->clock->dt * TRUSTED / trust->error)));
  } else {
    PetscCall(PetscSNPrintf(text, length, "gradients are worst near (%s); try -n %.0f",
                            ScenePlaceText(flow->scene, trust->x, place),
                            PetscCeilReal(flow->scene->n * PetscSqrtReal(trust->error / TRUSTED))));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints a line if bounds cut a typed viscosity in more than CUT of the fluid. */
static PetscErrorCode ViewBounds(const Flow *flow, PetscViewer viewer)
{
  const Particles *p      = flow->particles;
  const Rheology  *r      = &flow->scene->rheology;
  PetscReal        sum[2] = {0.0, 0.0};

  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->n_fluid && r->typed; i++) {
    if (p->nu[i] <= 1.001 * r->low || p->nu[i] >= 0.999 * r->high) sum[0] += p->volume[i];
    sum[1] += p->volume[i];
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, p->comm));
  if (!(sum[0] > CUT * sum[1])) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscViewerASCIIPrintf(
      viewer,
      "viscosity cut: %.2g %% of the fluid have a viscosity outside %.3g to %.3g m^2/s; give "
      "-rheology_viscosity_min and -rheology_viscosity_max\n",
      100.0 * (double)(sum[0] / sum[1]), (double)r->low, (double)r->high));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the area of each boundary by which the line of a free surface has passed since the
   start, by own wall particles [m^(dim-1)]. */
static void AddPassed(const Particles *p, PetscReal area[])
{
  for (PetscInt w = p->n_fluid; p->wetness && w < ParticlesOwn(p); w++)
    if (p->wetness[w] == LINE_PASSED)
      area[(PetscInt)p->side[w]] += PetscPowRealInt(p->dx[w], (int)p->dim - 1);
}

/* Returns true if fluid wets a part of a side of the box, and not the whole. */
static PetscBool PartlyWet(const Scene *scene, PetscInt side, PetscReal wet)
{
  PetscReal area = 1.0;

  for (PetscInt a = 0; a < scene->dim; a++)
    if (a != side / 2) area *= scene->hi[a] - scene->lo[a];
  return wet > 0.0 && wet < 0.999 * area ? PETSC_TRUE : PETSC_FALSE;
}

/* Prints a line for each wall along which a contact line has moved, or which drags it along or lets
   it slip, if the wall slips over a length that has few particles: the line then moves as if the
   wall slipped over about dx. */
static PetscErrorCode ViewLines(const Flow *flow, PetscViewer viewer)
{
  const Scene   *scene                 = flow->scene;
  const PetscInt n                     = SceneBoundaries(scene);
  PetscReal      wet[2 * ISPH_MAX_DIM] = {0.0}, *passed;

  PetscFunctionBegin;
  if (!flow->ops->cut_surface) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(n, &passed));
  AddPassed(flow->particles, passed);
  PetscCallMPI(MPI_Allreduce(flow->ops->strain->surface.wet, wet, 2 * ISPH_MAX_DIM, MPIU_REAL,
                             MPIU_SUM, flow->particles->comm));
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, passed, (int)n, MPIU_REAL, MPIU_SUM, flow->particles->comm));
  for (PetscInt side = 0; side < n; side++) {
    const Boundary *wall  = &scene->boundary[side];
    const PetscBool drags = side < 2 * scene->dim && (wall->velocity.n || wall->slip > 0.0) &&
                                    BoundaryIs(scene, side, BOUNDARY_CONFINES) &&
                                    PartlyWet(scene, side, wet[side])
                                ? PETSC_TRUE
                                : PETSC_FALSE;
    char            name[WALL_NAME], how[48] = "moves along", cure[80] = "compare two -n";

    if (wall->slip >= SLIP_LEAST * scene->dx || !BoundaryIs(scene, side, BOUNDARY_NO_SLIP) ||
        !(drags || passed[side] > 0.0))
      continue;
    SceneWallName(scene, side, name);
    if (passed[side] > 0.0)
      PetscCall(PetscSNPrintf(how, sizeof(how), "has moved over %.2g m%s of", (double)passed[side],
                              scene->dim == 3 ? "^2" : ""));
    if (side < 2 * scene->dim && BoundaryIs(scene, side, BOUNDARY_CONFINES))
      PetscCall(PetscSNPrintf(cure, sizeof(cure), "give -scene_wall_%s_slip of %.3g m or more",
                              name, (double)(SLIP_LEAST * scene->dx)));
    PetscCall(PetscViewerASCIIPrintf(
        viewer,
        "contact line: the surface %s the %s wall, which slips over %.2g dx, and fewer than %.0f "
        "do not resolve how fast it moves; %s\n",
        how, name, (double)(wall->slip / scene->dx), SLIP_LEAST, cure));
  }
  PetscCall(PetscFree(passed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds t t^T over the edges of facets on an outflow: a, b, c of [a c; c b] along the side [m]. */
static void AddEdges(const Scene *scene, const StrainSurface *s, PetscInt side, PetscReal sum[])
{
  const PetscInt axis[] = {(side / 2 + 1) % 3, (side / 2 + 2) % 3};

  for (PetscInt k = 0; k < 3 * s->n; k++) {
    const PetscReal *x = &s->x[3 * k], *y = &s->x[3 * (k % 3 == 2 ? k - 2 : k + 1)];
    const PetscReal  t[]    = {y[axis[0]] - x[axis[0]], y[axis[1]] - x[axis[1]]};
    const PetscReal  length = PetscSqrtReal(PetscSqr(t[0]) + PetscSqr(t[1]));

    if (s->between[k / 3] || length == 0.0 || !StrainOnSide(scene, side, x) ||
        !StrainOnSide(scene, side, y))
      continue;
    sum[0] += PetscSqr(t[0]) / length;
    sum[1] += PetscSqr(t[1]) / length;
    sum[2] += t[0] * t[1] / length;
  }
}

/* Prints a line for each outflow in 3D through which a curved surface leaves: the pressure there is
   that outside, without that of the tension. */
static PetscErrorCode ViewOutflows(const Flow *flow, PetscViewer viewer)
{
  const Scene *scene = flow->scene;

  PetscFunctionBegin;
  if (!flow->ops->cut_surface || scene->dim != 3 || !(scene->tension > 0.0))
    PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt side = 0; side < 2 * scene->dim; side++) {
    PetscReal sum[3] = {0.0}, across;

    if (!BoundaryIs(scene, side, BOUNDARY_OUTFLOW)) continue;
    AddEdges(scene, &flow->ops->strain->surface, side, sum);
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 3, MPIU_REAL, MPIU_SUM, flow->particles->comm));
    across = 0.5 * (sum[0] + sum[1]) -
             PetscSqrtReal(0.25 * PetscSqr(sum[0] - sum[1]) + PetscSqr(sum[2]));
    if (!(across > CURVED * (sum[0] + sum[1]))) continue;
    PetscCall(PetscViewerASCIIPrintf(
        viewer,
        "outflow not trusted: the surface that leaves through the %s side is curved there, and has "
        "no pressure of its tension; give a smaller -surface_tension, or a surface that is flat "
        "across the side\n",
        BoxSides[side]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TrustView - Prints a line if the velocity of the last measurement cannot be trusted, and others
   if bounds cut its viscosity, contact lines slip over few particles, curved surfaces leave, or the
   pressure beside a free surface cannot be trusted. Collective on the viewer. The error is of order
   dx^2, which gives the number -n of the line. */
PetscErrorCode TrustView(const Flow *flow, const Report *report, PetscViewer viewer)
{
  const Trust *trust = &report->trust;
  char         advice[256];

  PetscFunctionBegin;
  PetscCall(ViewBounds(flow, viewer));
  PetscCall(ViewLines(flow, viewer));
  PetscCall(ViewOutflows(flow, viewer));
  if (trust->surface > TRUSTED)
    PetscCall(PetscViewerASCIIPrintf(
        viewer,
        "pressure not trusted: within 3 dx of the free surface it lacks the normal stress of the "
        "surface, which is %.2g %% of the pressure in the root mean square; try a larger -n\n",
        100.0 * (double)trust->surface));
  if (trust->error <= TRUSTED) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Advise(flow, trust, advice, sizeof(advice)));
  PetscCall(PetscViewerASCIIPrintf(viewer,
                                   "not trusted: the estimated error of the velocity is %.2g %%, "
                                   "most of it by %s, and should be "
                                   "at most %.0f %%; %s\n",
                                   100.0 * (double)trust->error, words[trust->worst],
                                   100.0 * TRUSTED, advice));
  PetscFunctionReturn(PETSC_SUCCESS);
}
