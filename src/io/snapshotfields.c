/* The fields of snapshots: values stored with particles, and vorticity, strain rate and density,
   which are computed for the file. A new field needs a function and a row of the table. Wall
   particles have zeros in fields of the fluid. */
#include "schemes/scalars/scalars.h"
#include "snapshot.h"

/* Copies positions, wrapped into a periodic box, which particles may leave within an epoch. */
static PetscErrorCode Gather_Position(const Flow *flow, void *rows)
{
  const Scene     *scene = flow->scene;
  const Particles *p     = flow->particles;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < ParticlesOwn(p); i++) {
    for (PetscInt a = 0; a < p->dim; a++) {
      const PetscReal lo = scene->lo[a], period = scene->hi[a] - lo, x = p->x[a][i];
      const PetscReal turns = SceneIsPeriodic(scene, a) ? PetscFloorReal((x - lo) / period) : 0.0;

      ((double *)rows)[i * p->dim + a] = (double)(x - turns * period);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Gather_Velocity(const Flow *flow, void *rows)
{
  const Particles *p = flow->particles;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < ParticlesOwn(p); i++) {
    for (PetscInt c = 0; c < p->dim; c++) ((double *)rows)[i * p->dim + c] = (double)p->u[c][i];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies `values` of the fluid, multiplied by `scale`, and zeros for walls. */
static void GatherFluid(const Particles *p, PetscReal scale, const PetscReal values[],
                        double rows[])
{
  for (PetscInt i = 0; i < ParticlesOwn(p); i++)
    rows[i] = i < p->n_fluid ? (double)(scale * values[i]) : 0.0;
}

static const PetscReal *Fluid_Pressure(const Flow *flow)
{
  return SceneHas(flow->scene, PHYSICS_PRESSURE) ? flow->particles->p : NULL;
}

static const PetscReal *Fluid_Viscosity(const Flow *flow)
{
  return flow->particles->nu;
}

static const PetscReal *Fluid_Volume(const Flow *flow)
{
  return SceneIsGraded(flow->scene) ? flow->particles->volume : NULL;
}

static PetscBool Has_Density(const Flow *flow)
{
  return flow->scheme->density || flow->ops->needs & NEED_CONCENTRATION;
}

/* Copies the density of the scheme, or computes it from the masses of particles, rho sum_j V_j W_ij
   [kg/m^3]. */
static PetscErrorCode Gather_Density(const Flow *flow, void *rows)
{
  PetscFunctionBegin;
  if (flow->scheme->density)
    GatherFluid(flow->particles, 1.0, *flow->scheme->density, (double *)rows);
  else
    GatherFluid(flow->particles, flow->scene->rho, flow->ops->concentration.value, (double *)rows);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool Has_Gradient(const Flow *flow)
{
  return flow->ops->needs & NEED_GRADIENT_U ? PETSC_TRUE : PETSC_FALSE;
}

/* Creates vectors of the velocity components of wall particles; NULL without walls. */
static PetscErrorCode WallVelocities(const Particles *p, Vec walls[])
{
  PetscScalar *u;

  PetscFunctionBegin;
  for (PetscInt c = 0; c < p->dim; c++) {
    walls[c] = NULL;
    if (!p->N_wall) continue;
    PetscCall(WallVec(p, &walls[c]));
    PetscCall(VecGetArrayWrite(walls[c], &u));
    PetscCall(PetscArraycpy(u, p->u[c] + p->n_fluid, p->n_wall));
    PetscCall(VecRestoreArrayWrite(walls[c], &u));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the vorticity, w_e = du_b/dx_a - du_a/dx_b for (a, b, e) in cyclic order [1/s]; in 2D
   the component out of the plane. */
static PetscErrorCode Gather_Vorticity(const Flow *flow, void *rows)
{
  const Particles   *p       = flow->particles;
  const Vec         *u       = flow->state->u;
  const PetscInt     columns = p->dim == 2 ? 1 : 3;
  double            *w       = (double *)rows;
  Vec                walls[ISPH_MAX_DIM], slope[2];
  const PetscScalar *s[2];

  PetscFunctionBegin;
  for (PetscInt q = 0; q < ParticlesOwn(p) * columns; q++) w[q] = 0.0;
  PetscCall(WallVelocities(p, walls));
  for (PetscInt k = 0; k < 2; k++) PetscCall(FluidVec(p, NULL, &slope[k]));
  for (PetscInt e = 0; e < columns; e++) {
    const PetscInt a = p->dim == 2 ? 0 : (e + 1) % 3, b = p->dim == 2 ? 1 : (e + 2) % 3;

    PetscCall(AffineApply(&OperatorsOfVelocity(flow->ops, b)->grad_u[a], u[b], walls[b], slope[0]));
    PetscCall(AffineApply(&OperatorsOfVelocity(flow->ops, a)->grad_u[b], u[a], walls[a], slope[1]));
    for (PetscInt k = 0; k < 2; k++) PetscCall(VecGetArrayRead(slope[k], &s[k]));
    for (PetscInt i = 0; i < p->n_fluid; i++) w[i * columns + e] = (double)(s[0][i] - s[1][i]);
    for (PetscInt k = 0; k < 2; k++) PetscCall(VecRestoreArrayRead(slope[k], &s[k]));
  }
  for (PetscInt k = 0; k < 2; k++) PetscCall(VecDestroy(&slope[k]));
  for (PetscInt c = 0; c < p->dim; c++) PetscCall(VecDestroy(&walls[c]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Gather_StrainRate(const Flow *flow, void *rows)
{
  const Particles *p = flow->particles;
  Vec              walls[ISPH_MAX_DIM];
  PetscReal       *g;

  PetscFunctionBegin;
  PetscCall(WallVelocities(p, walls));
  PetscCall(PetscMalloc1(p->n_fluid, &g));
  PetscCall(OperatorsStrainRate(flow->ops, p, flow->state->u, walls, g));
  GatherFluid(p, 1.0, g, (double *)rows);
  PetscCall(PetscFree(g));
  for (PetscInt c = 0; c < p->dim; c++) PetscCall(VecDestroy(&walls[c]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static int Label_Type(const Flow *flow, PetscInt i)
{
  return (int)flow->particles->kind[i];
}

/* Returns the boundary number of a wall particle; -1 for fluid. */
static int Label_Boundary(const Flow *flow, PetscInt i)
{
  return i < flow->particles->n_fluid ? -1 : (int)flow->particles->side[i];
}

static PetscBool Has_Fluids(const Flow *flow)
{
  return flow->particles->fluid ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns the number of the fluid of a particle; 0 for walls. */
static int Label_Fluid(const Flow *flow, PetscInt i)
{
  return i < flow->particles->n_fluid ? (int)flow->particles->fluid[i] : 0;
}

static PetscErrorCode Gather_Id(const Flow *flow, void *rows)
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < ParticlesOwn(flow->particles); i++)
    ((long long *)rows)[i] = (long long)flow->particles->id[i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The first field is the position. */
static const SnapshotField fields[] = {
    {.name = "position", .units = "m", .shape = FIELD_VECTOR, .Gather = Gather_Position},
    {.name = "velocity", .units = "m/s", .shape = FIELD_VECTOR, .Gather = Gather_Velocity},
    {.name = "pressure", .units = "Pa", .shape = FIELD_SCALAR, .Fluid = Fluid_Pressure},
    {.name = "viscosity", .units = "m^2/s", .shape = FIELD_SCALAR, .Fluid = Fluid_Viscosity},
    {.name   = "density",
     .units  = "kg/m^3",
     .shape  = FIELD_SCALAR,
     .Has    = Has_Density,
     .Gather = Gather_Density},
    {.name   = "vorticity",
     .units  = "1/s",
     .shape  = FIELD_AXIAL,
     .Has    = Has_Gradient,
     .Gather = Gather_Vorticity},
    {.name   = "strain_rate",
     .units  = "1/s",
     .shape  = FIELD_SCALAR,
     .Has    = Has_Gradient,
     .Gather = Gather_StrainRate},
    {.name = "volume", .units = "m^dim", .shape = FIELD_SCALAR, .Fluid = Fluid_Volume},
    {.name = "type", .units = "0 fluid, 1 wall", .shape = FIELD_LABEL, .Label = Label_Type},
    {.name = "boundary", .units = "-1 fluid", .shape = FIELD_LABEL, .Label = Label_Boundary},
    {.name  = "fluid",
     .units = "k of -scene_fluid_k, 0 elsewhere",
     .shape = FIELD_LABEL,
     .Has   = Has_Fluids,
     .Label = Label_Fluid},
    {.name = "id", .units = "1", .shape = FIELD_ID, .Gather = Gather_Id},
};

/* SnapshotFieldsCheck - Refuses a scalar with the name of a field */
PetscErrorCode SnapshotFieldsCheck(const Scene *scene)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < scene->n_scalars; k++) {
    for (size_t f = 0; f < PETSC_STATIC_ARRAY_LENGTH(fields); f++) {
      PetscBool same;

      PetscCall(PetscStrcmp(fields[f].name, scene->scalar[k].name, &same));
      UserCheck(!same, "-scene_scalar_%" PetscInt_FMT "_name %s: snapshots have this field already",
                k + 1, fields[f].name);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SnapshotNext - Finds field *k of the run, or the next after it, and sets k to the number behind
   it. The first, with k = 0, is the position. Returns false after the last */
PetscBool SnapshotNext(const Flow *flow, PetscInt *k, SnapshotField *field)
{
  const PetscInt n       = (PetscInt)PETSC_STATIC_ARRAY_LENGTH(fields);
  const Scalars *scalars = flow->state->scalars;

  while (*k < n &&
         (fields[*k].Fluid ? !fields[*k].Fluid(flow) : fields[*k].Has && !fields[*k].Has(flow)))
    *k += 1;
  if (*k < n) {
    *field = fields[(*k)++];
    return PETSC_TRUE;
  }
  if (!scalars || *k - n >= scalars->n) return PETSC_FALSE;
  *field = (SnapshotField){.name   = scalars->scalar[*k - n].given->name,
                           .units  = "1",
                           .shape  = FIELD_SCALAR,
                           .values = scalars->scalar[*k - n].c};
  *k += 1;
  return PETSC_TRUE;
}

/* SnapshotColumns - Returns the number of columns of a field, 0 for a one-dimensional data set */
PetscInt SnapshotColumns(const Flow *flow, const SnapshotField *field)
{
  if (field->shape == FIELD_VECTOR) return flow->particles->dim;
  return field->shape == FIELD_AXIAL && flow->particles->dim == 3 ? 3 : 0;
}

/* Turns the rows of a field, places or vectors, out of a turning frame of reference. */
static void RowsOutOfFrame(const Flow *flow, PetscBool places, const SnapshotField *field,
                           double rows[])
{
  const PetscInt  columns = SnapshotColumns(flow, field);
  const PetscReal t       = ClockMoment(flow->clock);

  for (PetscInt i = 0; flow->scene->frame && columns && i < ParticlesOwn(flow->particles); i++) {
    PetscReal v[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < columns; a++) v[a] = (PetscReal)rows[i * columns + a];
    if (places) ScenePlaceOutOfFrame(flow->scene, t, v);
    else SceneOutOfFrame(flow->scene, t, v);
    for (PetscInt a = 0; a < columns; a++) rows[i * columns + a] = (double)v[a];
  }
}

/* SnapshotGather - Computes the rows of a field, of ints with a label, of long longs with ids and
   else of doubles, no longer than those; collective. Input: first - it is the position. */
PetscErrorCode SnapshotGather(const Flow *flow, const SnapshotField *field, PetscBool first,
                              double rows[])
{
  const Particles *p = flow->particles;

  PetscFunctionBegin;
  for (PetscInt i = 0; field->Label && i < ParticlesOwn(p); i++)
    ((int *)rows)[i] = field->Label(flow, i);
  if (field->Fluid) GatherFluid(p, 1.0, field->Fluid(flow), rows);
  if (field->values) GatherFluid(p, 1.0, field->values, rows);
  if (field->Gather) PetscCall(field->Gather(flow, rows));
  RowsOutOfFrame(flow, first, field, rows);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SnapshotFieldsWrite - Writes all fields; the fluid of a rank precedes its walls and the fluid of
   the next rank; collective */
PetscErrorCode SnapshotFieldsWrite(const Flow *flow, Hdf5File *file)
{
  const Particles *p = flow->particles;
  double          *rows; /* no value of a field is longer than a double */
  SnapshotField    field;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(3 * ParticlesOwn(p) + 1, &rows));
  file->start = p->fluid_start + p->wall_start;
  file->own   = ParticlesOwn(p);
  file->N     = p->N_fluid + p->N_wall;
  for (PetscInt k = 0; SnapshotNext(flow, &k, &field);) {
    hid_t stored = H5T_IEEE_F64LE, given = H5T_NATIVE_DOUBLE;

    if (field.shape == FIELD_LABEL) {
      stored = H5T_STD_I32LE;
      given  = H5T_NATIVE_INT;
    } else if (field.shape == FIELD_ID) {
      stored = H5T_STD_I64LE;
      given  = H5T_NATIVE_LLONG;
    }
    PetscCall(SnapshotGather(flow, &field, k == 1 ? PETSC_TRUE : PETSC_FALSE, rows));
    PetscCall(Hdf5WriteRows(file, field.name, SnapshotColumns(flow, &field), stored, given, rows,
                            field.units));
  }
  PetscCall(PetscFree(rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SnapshotBytes - Returns an upper bound of the size of a snapshot, with the metadata of HDF5
   [bytes] */
size_t SnapshotBytes(const Flow *flow)
{
  const size_t N   = (size_t)(flow->particles->N_fluid + flow->particles->N_wall);
  size_t       row = 8; /* the list of vertices of the group VTKHDF */

  SnapshotField field;

  for (PetscInt k = 0; SnapshotNext(flow, &k, &field);)
    row += 8 * (size_t)PetscMax(1, SnapshotColumns(flow, &field));
  return N * row + (size_t)131072;
}
