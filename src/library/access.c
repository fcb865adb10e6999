/* The contents of a flow of include/isph.h: particles and their fields, boundaries and forces,
   values at points, measures, files. */
#include "io/snapshot.h"
#include "isph/options.h"
#include "library.h"
#include "schemes/scalars/scalars.h"
#include <string.h>

/* Names of fields that particles carry under shorter names. */
static const char *const names[][2] = {
    {"position", "x"}, {"velocity", "u"}, {"pressure", "p"}, {"spacing", "dx"}};

/* Returns the field of a name; NULL: there is none. */
static const Field *FieldFind(const Particles *p, const char name[])
{
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(names); k++)
    if (!strcmp(name, names[k][0])) name = names[k][1];
  for (PetscInt f = 0; f < p->n_fields; f++)
    if (!strcmp(name, p->field[f].name)) return &p->field[f];
  return NULL;
}

static PetscErrorCode GetField(IsphFlow f, const char name[], PetscInt *components,
                               PetscReal *component[3])
{
  const Field *field = FieldFind(f->run.flow.particles, name);

  PetscFunctionBegin;
  UserCheck(field, "field %s: this flow has none of this name", name);
  *components = field->components;
  for (PetscInt c = 0; c < 3; c++) component[c] = c < field->components ? *(field->slot + c) : NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode IsphFlowGetField(IsphFlow f, const char name[], PetscInt *components,
                                PetscReal *component[3])
{
  PetscErrorCode failed = CallBegin(f, NEEDS_FLOW);

  if (!failed) failed = GetField(f, name, components, component);
  return CallEnd(f, failed);
}

static PetscErrorCode GetVec(IsphFlow f, const char name[], PetscInt c, Vec *v)
{
  PetscReal *component[3];
  PetscInt   n;

  PetscFunctionBegin;
  PetscCall(GetField(f, name, &n, component));
  UserCheck(c >= 0 && c < n, "field %s: it has no component %" PetscInt_FMT, name, c);
  PetscCall(FluidVec(f->run.flow.particles, component[c], v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode IsphFlowGetVec(IsphFlow f, const char name[], PetscInt component, Vec *v)
{
  PetscErrorCode failed = CallBegin(f, NEEDS_FLOW);

  if (!failed) failed = GetVec(f, name, component, v);
  return CallEnd(f, failed);
}

/* Computes a field of snapshots as real numbers. */
static PetscErrorCode ComputeField(const Flow *flow, const char name[], PetscInt *columns,
                                   PetscReal rows[])
{
  const PetscInt own   = ParticlesOwn(flow->particles);
  PetscBool      found = PETSC_FALSE;
  PetscInt       k     = 0;
  SnapshotField  field;

  PetscFunctionBegin;
  PetscCall(FlowPrepareOutput(flow));
  while (!found && SnapshotNext(flow, &k, &field))
    found = strcmp(field.name, name) ? PETSC_FALSE : PETSC_TRUE;
  UserCheck(found,
            "field %s: this flow does not compute it; vorticity, strain_rate and density need "
            "-output in some",
            name);
  *columns = PetscMax(1, SnapshotColumns(flow, &field));
  PetscCall(SnapshotGather(flow, &field, k == 1 ? PETSC_TRUE : PETSC_FALSE, (double *)rows));
  for (PetscInt i = own - 1; i >= 0; i--) { /* ints fill the first half of the rows */
    if (field.shape == FIELD_LABEL) rows[i] = ((const int *)(void *)rows)[i];
    if (field.shape == FIELD_ID) rows[i] = (PetscReal)((const long long *)(void *)rows)[i];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode IsphFlowComputeField(IsphFlow f, const char name[], PetscInt *columns,
                                    PetscReal rows[])
{
  PetscErrorCode failed = CallBegin(f, NEEDS_FLOW);

  if (!failed) failed = ComputeField(&f->run.flow, name, columns, rows);
  return CallEnd(f, failed);
}

PetscErrorCode IsphFlowGetTime(IsphFlow f, PetscReal *t, PetscReal *dt, PetscInt *step)
{
  PetscErrorCode failed = CallBegin(f, NEEDS_FLOW);

  if (!failed) {
    *t    = f->run.flow.clock->t;
    *dt   = f->run.flow.clock->dt;
    *step = f->run.flow.clock->step;
  }
  return CallEnd(f, failed);
}

PetscErrorCode IsphFlowGetSizes(IsphFlow f, PetscInt *dim, PetscInt *fluid, PetscInt *walls)
{
  PetscErrorCode failed = CallBegin(f, NEEDS_FLOW);

  if (!failed) {
    *dim   = f->run.flow.scene->dim;
    *fluid = f->run.flow.particles->n_fluid;
    *walls = f->run.flow.particles->n_wall;
  }
  return CallEnd(f, failed);
}

PetscErrorCode IsphFlowGetIds(IsphFlow f, const PetscInt64 **id)
{
  PetscErrorCode failed = CallBegin(f, NEEDS_FLOW);

  if (!failed) *id = f->run.flow.particles->id;
  return CallEnd(f, failed);
}

/* Lets the history of the flow end, as at a start: the next step has no earlier velocities, and the
   scheme frees the present one of divergence. */
static PetscErrorCode Changed(Flow *flow)
{
  const Particles *p = flow->particles;
  FlowState       *s = flow->state;

  PetscFunctionBegin;
  for (PetscInt c = 0; c < p->dim; c++) {
    PetscCall(PetscArraycpy(s->u_previous[c], p->u[c], p->n_fluid));
    if (s->u_earlier[c]) PetscCall(PetscArraycpy(s->u_earlier[c], p->u[c], p->n_fluid));
  }
  for (PetscInt k = 0; s->scalars && k < s->scalars->n; k++) {
    const Scalar *scalar = &s->scalars->scalar[k];

    if (scalar->before) PetscCall(PetscArraycpy(scalar->before, scalar->c, p->n_fluid));
  }
  flow->clock->dt_previous = flow->clock->dt_before = 0.0;
  PetscCall(flow->scheme->row->Begin(flow));
  if (flow->scheme->row->Start) PetscCall(flow->scheme->row->Start(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode IsphFlowChanged(IsphFlow f)
{
  PetscErrorCode failed = CallBegin(f, NEEDS_FLOW);

  if (!failed) failed = Changed(&f->run.flow);
  return CallEnd(f, failed);
}

/* Velocities of new particles. */
typedef struct {
  PetscInt   dim;
  PetscReal *u;
} NewVelocities;

/* Sets the present and the earlier velocities, whose fields have names with u. */
static void NewVelocity(const Field *field, PetscInt k, PetscReal value[], void *ctx)
{
  const NewVelocities *new = (const NewVelocities *)ctx;

  if (strcmp(field->name, "u") && strncmp(field->name, "u_", 2)) return;
  for (PetscInt c = 0; c < new->dim; c++) value[c] = new->u[k * new->dim + c];
}

static PetscErrorCode Insert(Flow *flow, PetscInt n, const PetscReal x[], const PetscReal u[])
{
  const PetscInt dim   = flow->scene->dim;
  NewVelocities  given = {.dim = dim};
  NewParticles   added = {.kind = PARTICLE_FLUID, .Value = u ? NewVelocity : NULL, .ctx = &given};
  PetscReal     *place;
  PetscInt       side;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(n * dim, &place, n * dim, &given.u));
  for (PetscInt k = 0; k < n; k++) {
    PetscReal *y = &place[added.n * dim];

    PetscCall(PetscArraycpy(y, &x[k * dim], dim));
    SceneIntoBox(flow->scene, y);
    UserCheck(SceneFluidDistance(flow->scene, y, &side) > 0.0,
              "insertion: place %" PetscInt_FMT " is outside the fluid's room", k);
    if (!ParticlesHolds(flow->particles, y)) continue;
    if (u) PetscCall(PetscArraycpy(&given.u[added.n * dim], &u[k * dim], dim));
    added.n++;
  }
  added.x = place;
  PetscCall(ParticlesInsert(flow->scene, flow->particles, &added, NULL));
  PetscCall(PetscFree2(place, given.u));
  PetscCall(flow->scheme->row->Begin(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode IsphFlowInsert(IsphFlow f, PetscInt n, const PetscReal x[], const PetscReal u[])
{
  PetscErrorCode failed = CallBegin(f, NEEDS_FLOW);

  if (!failed) failed = Insert(&f->run.flow, n, x, u);
  return CallEnd(f, failed);
}

static PetscErrorCode Remove(Flow *flow, PetscInt n, const PetscInt64 id[])
{
  const Particles *p     = flow->particles;
  PetscInt         found = 0, all, *local;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n + 1, &local));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    for (PetscInt k = 0; k < n && found < n; k++)
      if (p->id[i] == id[k]) local[found++] = i;
  }
  PetscCallMPI(MPI_Allreduce(&found, &all, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
  UserCheck(all == n,
            "removal: %" PetscInt_FMT " of %" PetscInt_FMT
            " ids are those of fluid particles, once each",
            all, n);
  PetscCall(ParticlesRemove(flow->scene, flow->particles, found, local));
  PetscCall(PetscFree(local));
  PetscCall(flow->scheme->row->Begin(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode IsphFlowRemove(IsphFlow f, PetscInt n, const PetscInt64 id[])
{
  PetscErrorCode failed = CallBegin(f, NEEDS_FLOW);

  if (!failed) failed = Remove(&f->run.flow, n, id);
  return CallEnd(f, failed);
}

PetscErrorCode IsphFlowGetBoundary(IsphFlow f, PetscInt k, const char **name, const char **kind)
{
  PetscErrorCode failed = CallBegin(f, NEEDS_FLOW);

  *name = *kind = NULL;
  if (!failed && k >= 0 && k < SceneBoundaries(f->run.flow.scene)) {
    SceneWallName(f->run.flow.scene, k, f->boundary);
    *name = f->boundary;
    *kind = f->run.flow.scene->boundary[k].kind->name;
  }
  return CallEnd(f, failed);
}

static PetscErrorCode GetForce(Flow *flow, PetscInt k, PetscReal force[3], PetscReal torque[3],
                               PetscReal error[2])
{
  PetscReal all[FORCE_WAYS][2 * ISPH_MAX_DIM], part[FORCE_WAYS];

  PetscFunctionBegin;
  UserCheck(k >= 0 && k < SceneBoundaries(flow->scene) &&
                BoundaryIs(flow->scene, k, BOUNDARY_CONFINES),
            "boundary %" PetscInt_FMT ": it is none that the fluid presses on", k);
  PetscCall(FlowPrepareOutput(flow));
  PetscCall(WallForce(flow, k, all));
  ForceParts(flow->scene, all, part);
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    force[a]  = all[FORCE_MOMENTUM][a];
    torque[a] = all[FORCE_MOMENTUM][ISPH_MAX_DIM + a];
  }
  for (PetscInt q = 0; q < 2 && error; q++) error[q] = part[q];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode IsphFlowGetForce(IsphFlow f, PetscInt k, PetscReal force[3], PetscReal torque[3],
                                PetscReal error[2])
{
  PetscErrorCode failed = CallBegin(f, NEEDS_FLOW);

  if (!failed) failed = GetForce(&f->run.flow, k, force, torque, error);
  return CallEnd(f, failed);
}

static PetscErrorCode GetPose(const Flow *flow, PetscInt k, Pose *pose)
{
  const Scene *scene = flow->scene;
  const Body  *body  = k >= 0 && k < SceneBoundaries(scene) ? BoundaryBody(scene, k) : NULL;

  PetscFunctionBegin;
  UserCheck(body, "boundary %" PetscInt_FMT ": it is no body", k);
  if (body->pose) {
    *pose = *body->pose;
  } else {
    PoseStart(body, pose);
    BodyMotion(scene, k, flow->clock->t, pose->u, pose->spin);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode IsphFlowGetPose(IsphFlow f, PetscInt k, PetscReal x[3], PetscReal attitude[4],
                               PetscReal velocity[3], PetscReal spin[3])
{
  PetscErrorCode failed = CallBegin(f, NEEDS_FLOW);
  Pose           pose   = {.turn = {1.0}};

  if (!failed) failed = GetPose(&f->run.flow, k, &pose);
  for (PetscInt a = 0; a < 4; a++) attitude[a] = pose.turn[a];
  for (PetscInt a = 0; a < 3; a++) {
    x[a]        = pose.x[a];
    velocity[a] = pose.u[a];
    spin[a]     = pose.spin[a];
  }
  return CallEnd(f, failed);
}

static PetscErrorCode Probe(const Flow *flow, PetscInt n, const PetscReal x[], PetscReal u[],
                            PetscReal p[])
{
  const Scene *scene = flow->scene;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < n * scene->dim; k++) {
    const PetscInt a = k % scene->dim;

    UserCheck(SceneIsPeriodic(scene, a) || (x[k] >= scene->lo[a] && x[k] <= scene->hi[a]),
              "probe: %c = %.6g lies outside the box", "xyz"[a], (double)x[k]);
  }
  PetscCall(FlowPrepareOutput(flow));
  PetscCall(ProbePoints(flow, n, x, u, p));
  for (PetscInt k = 0; k < n; k++) { /* a fit has values in bodies too */
    if (!ProbeInBody(scene, &x[k * scene->dim])) continue;
    for (PetscInt c = 0; c < scene->dim; c++) u[k * scene->dim + c] = NAN;
    if (p) p[k] = NAN;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode IsphFlowProbe(IsphFlow f, PetscInt n, const PetscReal x[], PetscReal u[],
                             PetscReal p[])
{
  PetscErrorCode failed = CallBegin(f, NEEDS_FLOW);

  if (!failed) failed = Probe(&f->run.flow, n, x, u, p);
  return CallEnd(f, failed);
}

PetscErrorCode IsphFlowMeasure(IsphFlow f)
{
  PetscErrorCode failed = CallBegin(f, NEEDS_FLOW);

  if (!failed) failed = RunMeasure(&f->run);
  return CallEnd(f, failed);
}

PetscErrorCode IsphFlowGetQuantity(IsphFlow f, PetscInt k, const char **name, PetscReal *t,
                                   PetscReal value[3])
{
  PetscErrorCode failed = CallBegin(f, NEEDS_FLOW);

  *name = NULL;
  if (!failed && k >= 0 && k < f->run.report->n) {
    const Quantity *q = &f->run.report->quantity[k];

    *name    = q->name;
    *t       = q->t;
    value[0] = q->value;
    value[1] = q->reference;
    value[2] = q->error;
  }
  return CallEnd(f, failed);
}

PetscErrorCode IsphFlowWriteSnapshot(IsphFlow f, const char path[])
{
  PetscErrorCode failed = CallBegin(f, NEEDS_FLOW);

  if (!failed) failed = SnapshotSave(&f->run.flow, path);
  return CallEnd(f, failed);
}

PetscErrorCode IsphFlowWriteCheckpoint(IsphFlow f, const char path[])
{
  PetscErrorCode failed = CallBegin(f, NEEDS_FLOW);

  if (!failed) failed = RunWriteCheckpoint(&f->run, path, f->run.over);
  return CallEnd(f, failed);
}
