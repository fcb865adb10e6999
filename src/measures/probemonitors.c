/* Monitors based on probes: points, lines, sections; forces on walls and bodies. */
#include "monitors.h"

/* Writes a row with velocity and pressure for each of n points. After time and step follows the
   given number or, if it is negative, the index of the point. The columns of velocity and pressure
   are empty for points in bodies and outside a free surface. That of the pressure is also empty if
   the run has none. */
static PetscErrorCode WriteProbes(const Flow *flow, Monitor *monitor, PetscInt n,
                                  const PetscReal x[], PetscInt number)
{
  const PetscInt  dim = flow->scene->dim;
  const PetscReal t   = ClockMoment(flow->clock);
  PetscReal      *u, *p, *place;

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(n * dim, &u, n, &p, n * dim, &place));
  PetscCall(PetscArraycpy(place, x, n * dim));
  for (PetscInt k = 0; k < n; k++) ScenePlaceIntoFrame(flow->scene, t, &place[k * dim]);
  PetscCall(ProbePoints(flow, n, place, u, p));
  for (PetscInt k = 0; k < n; k++) SceneOutOfFrame(flow->scene, t, &u[k * dim]);
  for (PetscInt k = 0; k < n; k++) {
    if (!MonitorRow(flow->clock, monitor)) continue;
    (void)fprintf(monitor->stream, ",%" PetscInt_FMT, number < 0 ? k : number);
    MonitorVector(monitor, dim, &x[k * dim]);
    if (ProbeInBody(flow->scene, &place[k * dim]) || PetscIsNanReal(u[k * dim])) {
      (void)fprintf(monitor->stream, ",,,,\n");
      continue;
    }
    MonitorVector(monitor, dim, &u[k * dim]);
    if (PetscIsNanReal(p[k])) (void)fprintf(monitor->stream, ",\n");
    else (void)fprintf(monitor->stream, ",%.12g\n", (double)p[k]);
  }
  PetscCall(PetscFree3(u, p, place));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CheckPoint(const Scene *scene, const char option[], PetscInt k,
                                 const PetscReal x[])
{
  PetscFunctionBegin;
  UserCheck(!ProbeInBody(scene, x), "%s: point %" PetscInt_FMT " at (%.6g, %.6g) lies in a body",
            option, k, (double)x[0], (double)x[1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WritePoints(const Flow *flow, Monitor *monitor)
{
  PetscFunctionBegin;
  PetscCall(WriteProbes(flow, monitor, monitor->n, monitor->parameter, -1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MonitorKind MonitorPoints = {
    .name   = "point",
    .header = "point,x,y,z,u,v,w,p",
    .group  = {2, 3},
    .Check  = CheckPoint,
    .Write  = WritePoints,
};

/* Refuses a line if its last parameter, the number of points, is not a whole number above 1. */
static PetscErrorCode CheckLine(const Scene *scene, const char option[], PetscInt k,
                                const PetscReal number[])
{
  const PetscReal points = number[2 * scene->dim];

  PetscFunctionBegin;
  UserCheck(points >= 2.0 && points <= 1e6 && points == PetscFloorReal(points),
            "%s: the number of points must be a whole number from 2 to 1000000, got %.6g", option,
            (double)points);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes a row for each point of each line. */
static PetscErrorCode WriteLines(const Flow *flow, Monitor *monitor)
{
  const PetscInt dim = flow->scene->dim;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < monitor->n; k++) {
    const PetscReal *end = &monitor->parameter[k * (2 * dim + 1)];
    const PetscInt   n   = (PetscInt)end[2 * dim];
    PetscReal       *x;

    PetscCall(PetscMalloc1(n * dim, &x));
    for (PetscInt q = 0; q < n; q++) {
      const PetscReal s = (PetscReal)q / (PetscReal)(n - 1);

      for (PetscInt a = 0; a < dim; a++) x[q * dim + a] = (1.0 - s) * end[a] + s * end[dim + a];
    }
    PetscCall(WriteProbes(flow, monitor, n, x, k));
    PetscCall(PetscFree(x));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MonitorKind MonitorLines = {
    .name   = "line",
    .header = "line,x,y,z,u,v,w,p",
    .group  = {5, 7},
    .Check  = CheckLine,
    .Write  = WriteLines,
};

/* Computes the flux through the wet parts of a section [m^2/s, m^3/s]. */
static PetscErrorCode SectionFlux(const Flow *flow, const PetscReal corner[], PetscReal *flux)
{
  const PetscInt dim = flow->scene->dim;
  PetscReal      place[3 * ISPH_MAX_DIM];
  Facets         f;

  PetscFunctionBegin;
  PetscCall(PetscArraycpy(place, corner, dim * dim));
  for (PetscInt k = 0; k < dim; k++)
    ScenePlaceIntoFrame(flow->scene, ClockMoment(flow->clock), &place[k * dim]);
  PetscCall(FacetsOfSection(flow->scene, place, &f));
  PetscCall(FacetsKeepWet(flow, &f));
  PetscCall(FacetsFlux(flow, &f, flux, NULL));
  PetscCall(FacetsFree(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes a row for each section. */
static PetscErrorCode WriteFluxes(const Flow *flow, Monitor *monitor)
{
  const PetscInt dim = flow->scene->dim, group = dim == 2 ? 4 : 9;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < monitor->n; k++) {
    PetscReal flux = 0.0;

    PetscCall(SectionFlux(flow, &monitor->parameter[k * group], &flux));
    if (!MonitorRow(flow->clock, monitor)) continue;
    (void)fprintf(monitor->stream, ",%" PetscInt_FMT ",%.12g\n", k, (double)flux);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MonitorKind MonitorFluxes = {
    .name   = "flux",
    .header = "section,flux",
    .group  = {4, 9},
    .Write  = WriteFluxes,
};

/* Writes a row for each boundary that confines the fluid or is an opening: sides of the box, then
   bodies. */
static PetscErrorCode WriteForces(const Flow *flow, Monitor *monitor)
{
  const Scene *scene = flow->scene;
  KeptFits    *kept  = &flow->state->kept_fits;

  PetscFunctionBegin;
  kept->on = SceneMoves(scene) ? PETSC_FALSE : PETSC_TRUE;
  kept->at = 0;
  for (PetscInt side = 0; side < SceneBoundaries(scene); side++) {
    PetscReal force[FORCE_WAYS][2 * ISPH_MAX_DIM];
    char      name[WALL_NAME];

    if (!SceneHas(scene, PHYSICS_WALLS)) continue;
    if (!BoundaryIs(scene, side, BOUNDARY_CONFINES) && !BoundaryIs(scene, side, BOUNDARY_INFLOW) &&
        !BoundaryIs(scene, side, BOUNDARY_OUTFLOW))
      continue;
    PetscCall(WallForce(flow, side, force));
    SceneWallName(scene, side, name);
    if (!MonitorRow(flow->clock, monitor)) continue;
    (void)fprintf(monitor->stream, ",%s", name);
    for (PetscInt k = 0; k < 2; k++) {
      MonitorVector(monitor, scene->dim, force[k]);
      MonitorVector(monitor, 3, &force[k][ISPH_MAX_DIM]);
    }
    (void)fprintf(monitor->stream, "\n");
  }
  kept->on = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes pose, velocity and spin of a body; returns the power of a force and a torque on it [W] (in
   2D per metre of depth). */
static PetscReal WritePose(const Flow *flow, PetscInt side, const PetscReal force[],
                           const Monitor *monitor)
{
  const Scene *scene = flow->scene;
  const Body  *body  = BoundaryBody(scene, side);
  PetscReal    motion[2 * ISPH_MAX_DIM], power = 0.0;
  Pose         pose;

  if (body->pose) pose = *body->pose;
  else PoseStart(body, &pose);
  BodyMotion(scene, side, flow->clock->t, motion, &motion[ISPH_MAX_DIM]);
  if (scene->boundary[side].rides) {
    const PetscReal t                  = ClockMoment(flow->clock),
                    turn[ISPH_MAX_DIM] = {0, 0, SceneFrameAngle(scene, t)};

    SceneFrameVelocity(scene, t, pose.x, motion);
    motion[2 * ISPH_MAX_DIM - 1] = SceneFrameRate(scene, t);
    SceneOutOfFrame(scene, t, motion);
    ScenePlaceOutOfFrame(scene, t, pose.x);
    PoseRotate(turn, &pose);
  }
  for (PetscInt a = 0; a < 2 * ISPH_MAX_DIM; a++) power += force[a] * motion[a];
  MonitorVector(monitor, scene->dim, pose.x);
  (void)fprintf(monitor->stream, ",%.12g", (double)pose.turn[0]);
  MonitorVector(monitor, 3, &pose.turn[1]);
  MonitorVector(monitor, scene->dim, motion);
  MonitorVector(monitor, 3, &motion[ISPH_MAX_DIM]);
  return power;
}

/* Writes a row for each body: its pose and motion, the load of the fluid, its power, and the
   magnitudes of the differences between both ways to measure it and of the lubrication in it. */
static PetscErrorCode WriteBodies(const Flow *flow, Monitor *monitor)
{
  const Scene *scene = flow->scene;
  KeptFits    *kept  = &flow->state->kept_fits;

  PetscFunctionBegin;
  kept->on = SceneMoves(scene) ? PETSC_FALSE : PETSC_TRUE;
  kept->at = 0;
  for (PetscInt k = 0; k < scene->n_bodies; k++) {
    const PetscInt side = SceneBodySide(scene, k);
    PetscReal      force[FORCE_WAYS][2 * ISPH_MAX_DIM], part[FORCE_WAYS], power;

    PetscCall(WallForce(flow, side, force));
    ForceParts(scene, force, part);
    if (!MonitorRow(flow->clock, monitor)) continue;
    (void)fprintf(monitor->stream, ",%" PetscInt_FMT, k + 1);
    power = WritePose(flow, side, force[FORCE_MOMENTUM], monitor);
    MonitorVector(monitor, scene->dim, force[FORCE_MOMENTUM]);
    MonitorVector(monitor, 3, &force[FORCE_MOMENTUM][ISPH_MAX_DIM]);
    (void)fprintf(monitor->stream, ",%.12g,%.6g,%.6g,%.6g\n", (double)power, (double)part[0],
                  (double)part[1], (double)part[2]);
  }
  kept->on = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MonitorKind MonitorForces = {
    .name   = "forces",
    .header = "wall,fx,fy,fz,tx,ty,tz,traction_fx,traction_fy,traction_fz,traction_tx,traction_ty,"
              "traction_tz",
    .Write  = WriteForces,
};

static PetscErrorCode PrepareBodies(Flow *flow, const Monitor *monitor)
{
  PetscFunctionBegin;
  (void)monitor;
  UserCheck(flow->scene->n_bodies > 0,
            "-probe_bodies: this flow has no bodies; -probe_forces has the forces on its sides");
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MonitorKind MonitorBodies = {
    .name    = "bodies",
    .header  = "body,x,y,z,q0,q1,q2,q3,u,v,w,spin_x,spin_y,spin_z,fx,fy,fz,tx,ty,tz,power,"
               "force_error,torque_error,lubrication",
    .Prepare = PrepareBodies,
    .Write   = WriteBodies,
};
