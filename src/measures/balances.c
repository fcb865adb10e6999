/*
  Balances of the boundaries at the times of the report: the flux through all of them, and the
  equations of momentum and angular momentum of the whole fluid,

    sum F + d/dt int rho u dV - int rho f dV + sum rho u (u.n) dA = 0,

  with the forces F of the fluid on walls, bodies, sides with slip and openings, and n into the
  fluid. Their residuals are relative to the sums of the magnitudes. See theory.md, (forces:mass)
  and (forces:balance).
*/
#include "isph/balance.h"
#include "isph/strain.h"
#include "monitors.h"

#define BESIDE 0.51 /* places beside the middle of a facet [its width] */

enum { FORCE, TORQUE };

/* Sums over all boundaries and the fluid. */
typedef struct {
  PetscReal sum[2][ISPH_MAX_DIM]; /* of forces, and of torques about the middle [N], [N m] */
  PetscReal size[2];              /* sums of their magnitudes */
  PetscReal flux, flux_size;      /* into the fluid; sum of magnitudes on openings [m^dim/s] */
  PetscReal open;                 /* area of openings [m^(dim-1)] */
  PetscReal area, pressure;       /* wet; integral of p [m^(dim-1)], [Pa m^(dim-1)] */
  PetscReal volume;               /* inside the boundaries [m^dim] */
  PetscReal unknown[2];           /* forces and torques of edges where velocities jump [N], [N m] */
  PetscReal error[2];             /* differences of the two ways to measure those of bodies */
  PetscReal middle[ISPH_MAX_DIM];
} Ledger;

/* Loads of a boundary. */
typedef struct {
  Facets     s;
  PetscReal *f, *p, *u; /* viscous forces [N], pressures [Pa], velocities of openings [m/s] */
} Loads;

/* Adds a force at x to the sums. */
static void AddForce(PetscInt dim, const PetscReal x[], const PetscReal f[], Ledger *l)
{
  PetscReal torque[ISPH_MAX_DIM] = {0.0}, square[2] = {0.0};

  AddTorque(dim, l->middle, x, f, torque);
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    if (a < dim) l->sum[FORCE][a] += f[a];
    l->sum[TORQUE][a] += torque[a];
    square[FORCE] += a < dim ? PetscSqr(f[a]) : 0.0;
    square[TORQUE] += PetscSqr(torque[a]);
  }
  for (PetscInt k = 0; k < 2; k++) l->size[k] += PetscSqrtReal(square[k]);
}

/* Returns the first axis that is not periodic, or dim. */
static PetscInt FirstOpenAxis(const Scene *scene)
{
  PetscInt axis = 0;

  while (axis < scene->dim && SceneIsPeriodic(scene, axis)) axis++;
  return axis;
}

static PetscBool IsOpening(const Scene *scene, PetscInt side)
{
  return BoundaryIs(scene, side, BOUNDARY_INFLOW) || BoundaryIs(scene, side, BOUNDARY_OUTFLOW);
}

/* Computes the loads of a boundary, and adds flux, area, pressure and volume. */
static PetscErrorCode LoadsOf(const Flow *flow, PetscInt side, Loads *of, Ledger *l)
{
  const Scene   *scene = flow->scene;
  const PetscInt dim = scene->dim, axis = FirstOpenAxis(scene) % dim;
  PetscReal      flux, size;

  PetscFunctionBegin;
  PetscCall(WallLoads(flow, side, &of->s, &of->f, &of->p));
  PetscCall(PetscMalloc1(of->s.n * dim, &of->u));
  if (IsOpening(scene, side)) {
    PetscCall(ProbePoints(flow, of->s.n, of->s.x, of->u, NULL));
    PetscCall(FacetsFlux(flow, &of->s, &flux, &size));
    l->flux += flux;
    l->flux_size += size;
  } else PetscCall(PetscArrayzero(of->u, of->s.n * dim));
  for (PetscInt k = 0; k < of->s.n && scene->boundary[side].rides; k++)
    SceneFrameVelocity(scene, flow->clock->t, &of->s.x[k * dim], &of->u[k * dim]);
  for (PetscInt k = 0; k < of->s.n; k++) {
    const PetscReal *x = &of->s.x[k * dim], *n = &of->s.normal[k * dim];

    l->volume -= of->s.area[k] * x[axis] * n[axis];
    if (BoundaryIs(scene, side, BOUNDARY_OUTFLOW) || BoundaryIsOpen(scene, side, x))
      l->open += of->s.area[k];
    if (PetscIsNanReal(of->f[k * dim])) continue;
    l->area += of->s.area[k];
    if (!PetscIsNanReal(of->p[k])) l->pressure += of->s.area[k] * of->p[k];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the forces of the loads, with pressures relative to `level`, and the momentum that leaves
   fixed particles through the boundary. Without convection a body that rides leaves its momentum.
 */
static void AddLoads(const Flow *flow, const Loads *of, PetscReal level, Ledger *l)
{
  const Scene    *scene    = flow->scene;
  const PetscInt  dim      = scene->dim;
  const PetscBool convects = SceneHas(scene, PHYSICS_CONVECTION);
  const PetscReal carries = scene->frame ? (convects ? 0.0 : -1.0) : convects && !SceneMoves(scene);

  for (PetscInt k = 0; k < of->s.n; k++) {
    const PetscReal *n = &of->s.normal[k * dim], *u = &of->u[k * dim];
    PetscReal        load[ISPH_MAX_DIM], flux       = 0.0;

    if (PetscIsNanReal(of->f[k * dim]) || flow->ops->cut_surface) continue;
    for (PetscInt a = 0; a < dim; a++) flux += carries * scene->rho * n[a] * u[a];
    for (PetscInt a = 0; a < dim; a++)
      load[a] = of->f[k * dim + a] - of->s.area[k] * ((of->p[k] - level) * n[a] + flux * u[a]);
    AddForce(dim, &of->s.x[k * dim], load, l);
  }
}

/* Adds the sums of another ledger on all ranks. */
static PetscErrorCode AddLedger(const Flow *flow, const Ledger *own, Ledger *l)
{
  PetscReal all[2][ISPH_MAX_DIM + 1];

  PetscFunctionBegin;
  for (PetscInt k = 0; k < 2; k++) {
    PetscCall(PetscArraycpy(all[k], own->sum[k], ISPH_MAX_DIM));
    all[k][ISPH_MAX_DIM] = own->size[k];
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, all, 2 * (ISPH_MAX_DIM + 1), MPIU_REAL, MPIU_SUM,
                             flow->particles->comm));
  for (PetscInt k = 0; k < 2; k++) {
    for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) l->sum[k][a] += all[k][a];
    l->size[k] += all[k][ISPH_MAX_DIM];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the body force of fluid that has entered since the last particles. */
static void AddWaiting(const Flow *flow, Ledger *l)
{
  const Particles *p               = flow->particles;
  const Scene     *scene           = flow->scene;
  PetscReal        x[ISPH_MAX_DIM] = {0.0}, f[ISPH_MAX_DIM] = {0.0}, length;

  for (PetscInt w = p->n_fluid; flow->ops->cut_surface && w < ParticlesOwn(p); w++) {
    if (!StrainWaits(scene, p, w, x, &length)) continue;
    if (SceneHas(scene, PHYSICS_BODY_FORCE)) SceneBodyForce(scene, flow->clock->t, x, f);
    for (PetscInt a = 0; a < p->dim; a++) {
      x[a] += 0.5 * length * p->normal[a][w];
      f[a] *= -scene->rho * StrainVolumeOf(scene, p, w);
    }
    AddForce(p->dim, x, f, l);
  }
}

/* Adds inertia and body force of the fluid. In a turning frame inertia is d/dt int rho u dV in its
   axes plus w z x int rho u dV, and the same of angular momenta. In a full box the volumes of the
   particles are scaled to that inside the boundaries: particles beside curved walls have parts of
   cells. */
static PetscErrorCode AddFluid(const Flow *flow, Ledger *l)
{
  const Particles *p       = flow->particles;
  const Scene     *scene   = flow->scene;
  const PetscReal  full    = p->weight * p->cell_volume;
  const PetscReal  share   = SceneHasFreeSurface(scene) ? 1.0 : l->volume / full;
  Ledger           inertia = {.volume = 0.0}, weight = {.volume = 0.0};
  const PetscReal  origin[ISPH_MAX_DIM] = {0.0}, turn = SceneFrameRate(scene, flow->clock->t);
  PetscReal       *rate[ISPH_MAX_DIM];

  PetscFunctionBegin;
  for (PetscInt a = 0; a < p->dim; a++) {
    inertia.middle[a] = weight.middle[a] = l->middle[a];
    PetscCall(PetscMalloc1(p->n_fluid, &rate[a]));
  }
  PetscCall(AccelerationGet(flow, rate));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal mass =
        ParticlesDensity(scene, p, i) * share * ParticlesWeight(p, i) * p->cell_volume;
    PetscReal x[ISPH_MAX_DIM] = {0.0}, f[ISPH_MAX_DIM] = {0.0}, a[ISPH_MAX_DIM] = {0.0};
    PetscReal u[ISPH_MAX_DIM] = {0.0}, w[ISPH_MAX_DIM] = {0.0};

    for (PetscInt c = 0; c < p->dim; c++) {
      x[c] = p->x[c][i];
      u[c] = mass * p->u[c][i];
    }
    if (SceneHas(scene, PHYSICS_BODY_FORCE)) SceneBodyForce(scene, flow->clock->t, x, f);
    for (PetscInt c = 0; c < p->dim; c++) {
      a[c] = mass * rate[c][i];
      if (c < 2) a[c] += (c ? turn : -turn) * u[1 - c];
      f[c] *= -mass;
    }
    SceneFrameVelocity(scene, flow->clock->t, x, w);
    AddTorque(p->dim, origin, w, u, inertia.sum[TORQUE]);
    AddForce(p->dim, x, a, &inertia);
    AddForce(p->dim, x, f, &weight);
  }
  for (PetscInt a = 0; a < p->dim; a++) PetscCall(PetscFree(rate[a]));
  AddWaiting(flow, &weight);
  PetscCall(AddLedger(flow, &weight, l));
  PetscCall(AddLedger(flow, &inertia, l));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the forces of the cells of a free surface on walls. */
static PetscErrorCode AddCells(const Flow *flow, Ledger *l)
{
  const Particles *p     = flow->particles;
  Ledger           walls = {.volume = 0.0};
  PetscReal       *force;

  PetscFunctionBegin;
  if (!flow->ops->cut_surface) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < p->dim; a++) walls.middle[a] = l->middle[a];
  PetscCall(CellForces(flow, &force));
  for (PetscInt j = 0; j < ParticlesAll(p); j++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0};

    if (!ParticlesIsWall(p, j)) continue;
    ParticlesWallPoint(p, j, x);
    AddForce(p->dim, x, &force[p->dim * j], &walls);
  }
  PetscCall(PetscFree(force));
  PetscCall(AddLedger(flow, &walls, l));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the forces that are not known at the edge between two sides of the box, or in 2D the corner,
   with given velocities that differ by J. The traction beside it is about 2 mu J/r at the distance
   r, and has no integral. */
static void AddEdge(const Scene *scene, PetscReal t, PetscInt side, PetscInt other, Ledger *l)
{
  const PetscInt beside[2]       = {side, other};
  PetscReal      x[ISPH_MAX_DIM] = {0.0}, u[2][ISPH_MAX_DIM], J = 0.0, arm = 0.0, length = 1.0;

  for (PetscInt a = 0; a < scene->dim; a++) {
    x[a] = l->middle[a];
    if (a == side / 2) x[a] = side % 2 ? scene->hi[a] : scene->lo[a];
    else if (a == other / 2) x[a] = other % 2 ? scene->hi[a] : scene->lo[a];
    else length *= scene->hi[a] - scene->lo[a];
    arm += PetscSqr(x[a] - l->middle[a]);
  }
  for (PetscInt k = 0; k < 2; k++) SceneWallVelocity(scene, beside[k], t, x, u[k]);
  for (PetscInt a = 0; a < scene->dim; a++) J += PetscSqr(u[0][a] - u[1][a]);
  J = 2.0 * scene->rho * scene->nu_high * length * PetscSqrtReal(J);
  l->unknown[FORCE] += J;
  l->unknown[TORQUE] += J * PetscSqrtReal(arm);
}

/* Adds AddEdge() of all pairs of sides that meet. */
static void AddEdges(const Scene *scene, PetscReal t, Ledger *l)
{
  for (PetscInt side = 0; side < 2 * scene->dim; side++) {
    for (PetscInt other = 0; other < side / 2 * 2; other++) {
      if (BoundaryIs(scene, side, BOUNDARY_NO_SLIP) && BoundaryIs(scene, other, BOUNDARY_NO_SLIP))
        AddEdge(scene, t, side, other, l);
    }
  }
}

/* Computes the forces that are not known where the velocity jumps along the surface of a body, as
   AddEdge(): at ends of a part with its own velocity, and where another boundary meets it. */
static void FindJumps(const Scene *scene, PetscReal t, const Facets *s, const Ledger *l,
                      PetscReal unknown[2])
{
  const PetscInt dim = s->dim;

  for (PetscInt k = 0; k < s->n; k++) {
    const PetscReal *x = &s->x[k * dim], size = dim == 2 ? s->area[k] : PetscSqrtReal(s->area[k]);
    PetscReal        tangent[2][ISPH_MAX_DIM], arm = 0.0;

    (void)SurfaceTangents(dim, &s->normal[k * dim], tangent);
    for (PetscInt a = 0; a < dim; a++) arm += PetscSqr(x[a] - l->middle[a]);
    for (PetscInt m = 0; m < dim - 1; m++) {
      const SurfacePart *part[2];
      PetscInt           side[2];
      PetscReal          u[2][ISPH_MAX_DIM], J = 0.0;

      for (PetscInt end = 0; end < 2; end++) {
        PetscReal y[ISPH_MAX_DIM] = {0.0};

        for (PetscInt a = 0; a < dim; a++)
          y[a] = x[a] + (end ? BESIDE : -BESIDE) * size * tangent[m][a];
        (void)SceneDistanceTo(scene, BOUNDARY_PARTICLES | BOUNDARY_NO_SLIP, y, &side[end]);
        SceneWallVelocity(scene, side[end], t, y, u[end]);
        part[end] = ScenePart(scene, y);
      }
      if (side[0] == side[1] && part[0] == part[1]) continue;
      for (PetscInt a = 0; a < dim; a++) J += PetscSqr(u[0][a] - u[1][a]);
      J = 2.0 * scene->rho * scene->nu_high * PetscSqrtReal(J) * (dim == 3 ? size : 1.0);
      unknown[FORCE] += J;
      unknown[TORQUE] += J * PetscSqrtReal(arm);
    }
  }
}

/* Adds the difference of forces on a body by momentum and by tractions, and that of torques, less
   what is not known. */
static PetscErrorCode AddDifference(const Flow *flow, PetscInt side, const Facets *s, Ledger *l)
{
  PetscReal force[FORCE_WAYS][2 * ISPH_MAX_DIM], part[FORCE_WAYS], unknown[2] = {0.0};

  PetscFunctionBegin;
  FindJumps(flow->scene, flow->clock->t, s, l, unknown);
  PetscCall(WallForce(flow, side, force));
  ForceParts(flow->scene, force, part);
  for (PetscInt k = 0; k < 2; k++) {
    l->error[k] += PetscMax(part[k] - unknown[k], 0.0);
    l->unknown[k] += unknown[k];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the row of forces or of torques from the square of the residual. noise: a magnitude of
   rounding. */
static void SetRow(Flow *flow, PetscInt of, PetscReal square, PetscReal noise, const Ledger *l)
{
  const BalanceKind kind = of == FORCE ? BALANCE_FORCE : BALANCE_TORQUE;
  const PetscReal   size = l->size[of] + noise, all = PetscSqrtReal(square);
  const PetscReal   rest = PetscMax(all - l->unknown[of], 0.0);

  BalanceSet(kind, PetscMax(all, l->error[of]) / size, PetscMax(rest, l->error[of]) / size,
             flow->clock->t, &flow->scheme->sheet);
}

/* Sets the row of mass. Moving particles carry their volume, and half a layer of them at each
   opening may have passed it or not. */
static void SetMass(Flow *flow, const Ledger *l)
{
  const Openings *o      = &flow->state->openings;
  const PetscReal gained = o->volume_in - o->volume_out;
  const PetscReal start  = flow->particles->weight * flow->particles->cell_volume - gained;
  PetscReal       error = 0.5 * flow->scene->dx * l->open / start, all = gained / start;

  if (SceneHasFreeSurface(flow->scene) || l->flux_size == 0.0) return;
  if (!SceneMoves(flow->scene)) {
    all   = 2.0 * l->flux / l->flux_size;
    error = 0.0;
  }
  BalanceSet(BALANCE_MASS, all, PetscMax(PetscAbsReal(all) - error, 0.0), flow->clock->t,
             &flow->scheme->sheet);
}

/* Returns the least scale of forces on an area: the stress of the velocity over the length of the
   scene, which a rigid rotation has not, and rounding [Pa]. */
static PetscReal ForceScale(const Flow *flow)
{
  const Scene    *scene  = flow->scene;
  const PetscReal stress = scene->nu_low * FlowRmsSpeed(flow) / scene->length;

  return scene->rho * (stress + 1e-12 * PetscSqr(scene->speed));
}

/* Sets the rows of forces and torques. A periodic axis has no middle, so that torques about the
   others have no balance. */
static void SetForces(Flow *flow, const Ledger *l)
{
  const Scene    *scene     = flow->scene;
  const PetscReal noise     = ForceScale(flow) * l->area;
  PetscReal       square[2] = {0.0};
  PetscBool       turns     = PETSC_FALSE;

  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    const PetscInt b = (a + 1) % 3, c = (a + 2) % 3;

    square[FORCE] += PetscSqr(l->sum[FORCE][a]);
    if (b >= scene->dim || c >= scene->dim) continue;
    if (SceneIsPeriodic(scene, b) || SceneIsPeriodic(scene, c)) continue;
    square[TORQUE] += PetscSqr(l->sum[TORQUE][a]);
    turns = PETSC_TRUE;
  }
  SetRow(flow, FORCE, square[FORCE], noise, l);
  if (turns) SetRow(flow, TORQUE, square[TORQUE], noise * scene->length, l);
}

/* Measures fluxes and forces of the boundaries. */
static PetscErrorCode MeasureBoundaries(Flow *flow)
{
  const Scene    *scene = flow->scene;
  const PetscInt  n     = SceneBoundaries(scene);
  const PetscReal box   = (scene->hi[0] - scene->lo[0]) * (scene->hi[1] - scene->lo[1]) *
                        (scene->dim == 3 ? scene->hi[2] - scene->lo[2] : 1.0);
  Ledger l = {.volume = FirstOpenAxis(scene) < scene->dim ? 0.0 : box};
  Loads *of;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n, &of));
  for (PetscInt a = 0; a < scene->dim; a++) l.middle[a] = 0.5 * (scene->lo[a] + scene->hi[a]);
  for (PetscInt side = 0; side < n; side++) {
    of[side].s.n = 0;
    if (BoundaryIs(scene, side, BOUNDARY_CONTINUES)) continue;
    PetscCall(LoadsOf(flow, side, &of[side], &l));
    if (BoundaryBody(scene, side) && !SceneHasFreeSurface(scene))
      PetscCall(AddDifference(flow, side, &of[side].s, &l));
  }
  SetMass(flow, &l);
  for (PetscInt side = 0; side < n; side++) {
    if (BoundaryIs(scene, side, BOUNDARY_CONTINUES)) continue;
    AddLoads(flow, &of[side],
             SceneHasFreeSurface(scene) && !flow->ops->cut_surface ? scene->outside
                                                                   : l.pressure / l.area,
             &l);
    PetscCall(FreeAll(&of[side].f, &of[side].p, &of[side].u));
    PetscCall(FacetsFree(&of[side].s));
  }
  PetscCall(PetscFree(of));
  if (l.area == 0.0 || flow->clock->step == 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(AddFluid(flow, &l));
  PetscCall(AddCells(flow, &l));
  AddEdges(scene, flow->clock->t, &l);
  SetForces(flow, &l);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if the momentum of the fluid follows from the loads of boundaries: there are some,
   pressure acts, and no surface tension pulls at contact lines, but in cells that have its force.
 */
static PetscBool HasLoads(const Flow *flow)
{
  if (!SceneHas(flow->scene, PHYSICS_PRESSURE) ||
      (flow->scene->tension > 0.0 && !flow->ops->cut_surface))
    return PETSC_FALSE;
  for (PetscInt side = 0; side < SceneBoundaries(flow->scene); side++)
    if (!BoundaryIs(flow->scene, side, BOUNDARY_CONTINUES)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Sets the energy from the steps, and reports all rows of the sheet that apply. */
static PetscErrorCode ReportRows(Flow *flow, Report *report)
{
  const BalanceSheet *sheet = &flow->scheme->sheet;
  const char         *name;
  PetscReal           value, bound;

  PetscFunctionBegin;
  if (SceneHasFreeSurface(flow->scene) && SceneMoves(flow->scene))
    BalanceSet(BALANCE_ENERGY, flow->scheme->energy.gain, PetscAbsReal(flow->scheme->energy.gain),
               flow->scheme->energy.gain_t, &flow->scheme->sheet);
  for (PetscInt k = 0; k < BALANCES; k++) {
    if (sheet->applies[k] && k != BALANCE_VOLUME) /* MeasureFree() reports it with its reference */
      PetscCall(ReportAddBeyond(report, BalanceRows[k].name,
                                PetscMax(sheet->residual[k], sheet->value[k]), sheet->value[k]));
  }
  if (BalanceWorst(flow, &name, &value, &bound))
    PetscCall(ReportAddError(report, "balance", value / bound));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* BalancesOfFailed - Reports the balances of a run that has failed, as far as its steps measured
   them, and prints the volume of its fluid. Collective on the viewer. Its fields are invalid, so
   that boundaries have no balance. */
PetscErrorCode BalancesOfFailed(Flow *flow, Report *report, PetscViewer viewer)
{
  const Particles *p = flow->particles;
  const Openings  *o = &flow->state->openings;

  PetscFunctionBegin;
  flow->scheme->sheet.applies[BALANCE_FORCE]  = PETSC_FALSE;
  flow->scheme->sheet.applies[BALANCE_TORQUE] = PETSC_FALSE;
  if (!SceneHasFreeSurface(flow->scene) && !o->open) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ReportRows(flow, report));
  PetscCall(PetscViewerASCIIPrintf(
      viewer, "at t = %.6g the fluid had the volume %.6g: %.6g entered, %.6g left",
      (double)flow->clock->t, (double)(p->weight * p->cell_volume), (double)o->volume_in,
      (double)o->volume_out));
  for (PetscInt k = 0; k < BALANCES; k++) {
    if (!flow->scheme->sheet.applies[k]) continue;
    PetscCall(PetscViewerASCIIPrintf(viewer, ", %s %.2g %%", BalanceRows[k].name,
                                     100.0 * (double)flow->scheme->sheet.value[k]));
  }
  PetscCall(PetscViewerASCIIPrintf(viewer, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* BalancesMeasure - Measures the balances of boundaries, and reports all rows of the sheet that
   apply; collective */
PetscErrorCode BalancesMeasure(Flow *flow, Report *report)
{
  PetscFunctionBegin;
  if (HasLoads(flow)) PetscCall(MeasureBoundaries(flow));
  PetscCall(ReportRows(flow, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* BalancesView - Prints a line for each balance out of its bound; collective on the viewer */
PetscErrorCode BalancesView(const Flow *flow, PetscViewer viewer)
{
  const BalanceSheet *sheet = &flow->scheme->sheet;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < BALANCES; k++) {
    const BalanceRow *row = &BalanceRows[k];

    if (!sheet->applies[k] || sheet->value[k] <= row->bound) continue;
    PetscCall(PetscViewerASCIIPrintf(viewer,
                                     "%s (%s %.2g %% at t = %.3g, should be at most %.2g %%); %s\n",
                                     row->what, row->name, 100.0 * (double)sheet->value[k],
                                     (double)sheet->t[k], 100.0 * (double)row->bound, row->remedy));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
