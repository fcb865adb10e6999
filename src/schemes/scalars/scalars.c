/* Scalars of a run: their creation, their fields, and the stage of a step that advances them. */
#include "scalars.h"

/* ScalarBoundaryName - Writes the name of a boundary, "surface" for the free one, which is the
   last */
void ScalarBoundaryName(const Scene *scene, PetscInt side, char name[])
{
  if (side < SceneBoundaries(scene)) SceneWallName(scene, side, name);
  else (void)snprintf(name, WALL_NAME, "surface");
}

/* Sets the laws of a scalar at the boundaries that its options name, the free surface last. */
static PetscErrorCode SetLaws(const Scene *scene, Scalar *s)
{
  const PetscInt  n    = SceneBoundaries(scene);
  const PetscBool free = SceneHasFreeSurface(scene);

  PetscFunctionBegin;
  PetscCall(PetscCalloc3(n + 1, &s->law, n + 1, &s->gives, n + 1, &s->entering));
  for (PetscInt k = 0; k < s->given->n_boundary; k++) {
    const ScalarBoundary *law = &s->given->boundary[k];
    PetscBool             all, found = PETSC_FALSE;

    PetscCall(PetscStrcmp(law->place, "walls", &all));
    for (PetscInt side = 0; side < (free ? n + 1 : n); side++) {
      char      name[WALL_NAME];
      PetscBool same;

      ScalarBoundaryName(scene, side, name);
      PetscCall(PetscStrcmp(law->place, name, &same));
      if (!same && (!all || side == n || !BoundaryIs(scene, side, BOUNDARY_PARTICLES))) continue;
      if (side < n && !BoundaryIs(scene, side, BOUNDARY_PARTICLES)) continue;
      UserCheck(side < n || law->law != SCALAR_VALUE,
                "%s: particles carry the surface; give a flux, or an exchange with a large h",
                law->of.option);
      UserCheck(all || !s->law[side], "%s: %s has a value, flux or exchange already",
                law->of.option, name);
      found = PETSC_TRUE;
      if (!s->law[side]) s->law[side] = law;
    }
    UserCheck(
        found || all,
        "%s: there is no boundary %s; allowed are left, right, bottom, top, back, front, "
        "domain and body_<k> of this scene that are not periodic, walls, and surface if it is free",
        law->of.option, law->place);
  }
  for (PetscInt side = 0; side < n; side++)
    s->gives[side] = s->law[side] && s->law[side]->law == SCALAR_VALUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses flows whose scalars would be wrong. */
static PetscErrorCode Refuse(const Flow *flow)
{
  const Scene        *scene = flow->scene;
  const Stage *const *stage = flow->scheme->row->stages;

  PetscFunctionBegin;
  while (*stage && *stage != &StageScalars) stage++;
  UserCheck(*stage, "-scheme %s: it carries no scalars; use projection or coupled",
            flow->scheme->row->name);
  UserCheck(!SceneIsGraded(scene),
            "-scene_scalar_1_name: cells of scalars need a uniform spacing; drop -spacing options");
  UserCheck(!flow->clock->steady_solve,
            "-steady: scalars have no steady solve; run to a late -t_end, or until -steady_tol");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ScalarsCreate - Creates the scalars of the scene, before operators exist. Collective. Output:
   flow->state->scalars, NULL without scalars; scheme->needs. */
PetscErrorCode ScalarsCreate(Flow *flow)
{
  const Scene *scene = flow->scene;
  Scalars     *all;

  PetscFunctionBegin;
  if (!scene->n_scalars) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Refuse(flow));
  PetscCall(PetscNew(&all));
  flow->state->scalars = all;
  all->n               = scene->n_scalars;
  PetscCall(PetscCalloc1(all->n, &all->scalar));
  for (PetscInt k = 0; k < all->n; k++) {
    Scalar *s = &all->scalar[k];

    s->given = &scene->scalar[k];
    PetscCall(SetLaws(scene, s));
    s->is_nonlinear = ExpressionUses(&s->given->source, EXPRESSION_FIELDS);
    s->active = ExpressionIsGiven(&s->given->diffusivity) || ExpressionIsGiven(&s->given->source) ||
                !SceneMoves(scene);
    for (PetscInt q = 0; q < 2; q++) {
      const Expression *e = q ? &s->given->source : &s->given->diffusivity;

      UserCheck(e->n <= 1 || e->n == SceneFluids(scene),
                "%s: it has %" PetscInt_FMT
                " components; allowed are 1, or one of each of the %" PetscInt_FMT " fluids",
                e->option, e->n, SceneFluids(scene));
    }
    UserCheck(s->active || !s->given->n_boundary,
              "%s: without -scene_scalar_%" PetscInt_FMT "_diffusivity nothing enters there",
              s->given->boundary[0].of.option, k + 1);
    if (ExpressionUses(&s->given->source, EXPRESSION_STRAIN)) all->strain = PETSC_TRUE;
    (void)snprintf(s->prefix, sizeof(s->prefix), "scalar_%" PetscInt_FMT "_", k + 1);
    (void)snprintf(s->label, sizeof(s->label), "%s solver", s->given->name);
    (void)snprintf(s->option, sizeof(s->option), "-%sts_type", s->prefix);
  }
  if (all->strain) flow->scheme->needs |= NEED_GRADIENT_U;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ScalarsSetUp - Creates the solvers; collective */
PetscErrorCode ScalarsSetUp(Flow *flow)
{
  Scalars *all = flow->state->scalars;

  PetscFunctionBegin;
  for (PetscInt k = 0; all && k < all->n; k++)
    if (all->scalar[k].active) PetscCall(ScalarCreateSolver(flow, &all->scalar[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ScalarsRegister - Adds the fields of the scalars to the particles, with the values at the start;
   collective */
PetscErrorCode ScalarsRegister(Flow *flow)
{
  Scalars   *all = flow->state->scalars;
  Particles *p   = flow->particles;

  PetscFunctionBegin;
  if (!all) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < all->n; k++) {
    Scalar *s = &all->scalar[k];
    char   *name;

    for (PetscInt f = 0; f < p->n_fields; f++) {
      PetscBool same;

      PetscCall(PetscStrcmp(p->field[f].name, s->given->name, &same));
      UserCheck(!same, "-scene_scalar_%" PetscInt_FMT "_name %s: particles have this field already",
                k + 1, s->given->name);
    }
    PetscCall(ParticlesRegister(p, s->given->name, 1, HALO_NONE, ENTRY_NEAREST, &s->c));
    name = s->before_name;
    (void)snprintf(name, sizeof(s->before_name), "%s_before", s->given->name);
    if (s->active) PetscCall(ParticlesRegister(p, name, 1, HALO_NONE, ENTRY_NEAREST, &s->before));
    for (PetscInt i = 0; i < p->n_fluid; i++) {
      PetscReal x[ISPH_MAX_DIM] = {0.0};

      for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
      s->c[i] = ScalarAtStart(s->given, x);
      if (s->active) s->before[i] = s->c[i];
    }
    PetscCall(ScalarBalanceRegister(flow, s));
  }
  if (flow->scene->scope) ExpressionScopeFieldsAt(flow->scene->scope, ScalarsAt, flow);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Builds the cells of the present places, if expressions ask for scalars at any place, or walls for
   the velocity of the fluid beside them. */
static PetscErrorCode FindPlaces(Flow *flow)
{
  const Scene *scene = flow->scene;
  PetscBool    slips = PETSC_FALSE;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < SceneBoundaries(scene) * scene->dim && !SceneMoves(scene); k++)
    if (BoundaryVelocityEquation(scene, k / scene->dim, k % scene->dim) != EQUATION_VALUE)
      slips = PETSC_TRUE;
  if (slips || ExpressionUses(&flow->scene->force, EXPRESSION_FIELDS) ||
      (flow->scene->rheology.typed &&
       ExpressionUses(flow->scene->rheology.typed, EXPRESSION_FIELDS)))
    PetscCall(CellsBuild(flow->particles, flow->particles->dx[0], &flow->state->scalars->cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the bounds of the viscosity to those of the particles. */
static PetscErrorCode BoundViscosity(Flow *flow)
{
  Scene           *scene    = flow->scene;
  const Particles *p        = flow->particles;
  PetscReal        bound[2] = {-PETSC_INFINITY, -PETSC_INFINITY};

  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    bound[0] = PetscMax(bound[0], -p->nu[i]);
    bound[1] = PetscMax(bound[1], p->nu[i]);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, bound, 2, MPIU_REAL, MPIU_MAX, p->comm));
  if (-bound[0] <= 0.0) PetscCall(ExpressionScopeCheck(scene->scope));
  UserCheck(-bound[0] > 0.0, "%s: it is %.6g in the fluid, and must be positive",
            scene->nu_field.option, (double)-bound[0]);
  scene->nu_low  = -bound[0];
  scene->nu_high = bound[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ScalarsBegin - Computes from the fields what a finished step leaves, at the start of a run, after
   a restart or an undone step; collective */
PetscErrorCode ScalarsBegin(Flow *flow)
{
  Scalars *all = flow->state->scalars;

  PetscFunctionBegin;
  if (!all) PetscFunctionReturn(PETSC_SUCCESS);
  all->next_id = flow->particles->next_id;
  PetscCall(FindPlaces(flow));
  for (PetscInt k = 0; k < all->n; k++) {
    PetscCall(ScalarSetWalls(flow, flow->clock->t, &all->scalar[k]));
    PetscCall(ScalarValues(flow, all->scalar[k].c, 1.0, &all->scalar[k]));
  }
  if (!ExpressionUses(&flow->scene->nu_field, EXPRESSION_FIELDS))
    PetscFunctionReturn(PETSC_SUCCESS);
  if (SceneIsNewtonian(flow->scene)) PetscCall(BoundViscosity(flow));
  else
    PetscCall(OperatorsFollowStrain(flow->scene, flow->particles, &flow->walls, flow->state->u,
                                    flow->ops));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives particles that have entered the values of the inflow. */
static void EnterParticles(const Flow *flow)
{
  const Particles *p   = flow->particles;
  Scalars         *all = flow->state->scalars;

  for (PetscInt i = 0; i < p->n_fluid && p->next_id > all->next_id; i++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0};
    PetscInt  side;

    if (p->id[i] < all->next_id) continue;
    for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
    (void)SceneDistanceTo(flow->scene, BOUNDARY_INFLOW | BOUNDARY_OUTFLOW, x, &side);
    for (PetscInt k = 0; side >= 0 && k < all->n; k++) {
      Scalar *s = &all->scalar[k];

      if (!s->gives[side]) continue;
      s->c[i] = ExpressionValue(&s->law[side]->of, 0, flow->clock->t + flow->clock->dt, x);
      if (s->active) s->before[i] = s->c[i];
    }
  }
  all->next_id = p->next_id;
}

/* Computes the velocity past fixed particles, and the strain rate, at the end of the step. */
static PetscErrorCode SetFlow(Flow *flow)
{
  Scalars         *all             = flow->state->scalars;
  const Particles *p               = flow->particles;
  const PetscInt   d               = p->dim;
  Vec              v[ISPH_MAX_DIM] = {NULL};

  PetscFunctionBegin;
  if (SceneMoves(flow->scene) && !all->strain) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < d; a++) PetscCall(FlowGetWork(flow, &v[a]));
  PetscCall(VelocityExtrapolate(flow, 1.0, v));
  PetscCall(WallValuesSetVelocity(flow->scene, flow->particles, flow->clock->t + flow->clock->dt,
                                  0.0, &flow->walls));
  if (all->strain) {
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)(p->n_fluid + 1), &all->g));
    PetscCall(OperatorsStrainRate(flow->ops, p, v, flow->walls.u, all->g));
  }
  if (!SceneMoves(flow->scene)) {
    PetscCall(PetscFree(all->flow));
    PetscCall(FlowAllVelocities(flow, v, &all->flow));
    for (PetscInt i = p->n_fluid; i < ParticlesOwn(p); i++)
      for (PetscInt a = 0; a < d; a++) all->flow[i * d + a] = p->u[a][i];
    PetscCall(ScalarSlip(flow, all->flow));
    PetscCall(ParticlesHaloVectors(p, all->flow));
  }
  for (PetscInt a = 0; a < d; a++) PetscCall(FlowRestoreWork(flow, &v[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets all values by local index to those that are extrapolated to the end of the step. */
static PetscErrorCode Extrapolate(Flow *flow)
{
  Scalars         *all = flow->state->scalars;
  const Particles *p   = flow->particles;
  const PetscReal  w   = ClockRatio(flow->clock);
  PetscReal       *ahead;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(p->n_fluid, &ahead));
  for (PetscInt k = 0; k < all->n; k++) {
    Scalar *s = &all->scalar[k];

    for (PetscInt i = 0; i < p->n_fluid; i++)
      ahead[i] = s->active ? s->c[i] + w * (s->c[i] - s->before[i]) : s->c[i];
    PetscCall(ScalarSetWalls(flow, flow->clock->t + flow->clock->dt, s));
    PetscCall(ScalarValues(flow, ahead, 1.0, s));
  }
  PetscCall(PetscFree(ahead));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the viscosities of the particles to those of the present scalars, and their operator. */
static PetscErrorCode FollowViscosity(Flow *flow)
{
  Scene     *scene = flow->scene;
  Particles *p     = flow->particles;

  PetscFunctionBegin;
  if (!ExpressionUses(&scene->nu_field, EXPRESSION_FIELDS) || !SceneIsNewtonian(scene))
    PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0}, field[SCALARS_MOST] = {0.0};

    if (p->fluid && p->fluid[i] > 0.0) continue; /* of a region, with its own viscosity */
    for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
    for (PetscInt k = 0; k < flow->state->scalars->n; k++)
      field[k] = flow->state->scalars->scalar[k].c[i];
    p->nu[i] = ExpressionOf(&scene->nu_field, 0, 0.0, x, field, 0.0);
  }
  PetscCall(BoundViscosity(flow));
  PetscCall(ParticlesHaloField(p, p->nu));
  if (flow->ops->strain) StrainViscosities(scene, p, flow->ops->strain);
  PetscCall(OperatorsScaleViscosity(scene, p, flow->ops));
  flow->ops->assemblies++; /* solvers take the new matrices */
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ScalarsStep(Flow *flow)
{
  Scalars *all = flow->state->scalars;

  PetscFunctionBegin;
  if (SceneMoves(flow->scene)) PetscCall(FindPlaces(flow));
  EnterParticles(flow);
  PetscCall(SetFlow(flow));
  PetscCall(Extrapolate(flow));
  for (PetscInt k = 0; k < all->n && !flow->scheme->failure.code; k++)
    if (all->scalar[k].active) PetscCall(ScalarSolve(flow, &all->scalar[k]));
  if (!flow->scheme->failure.code) PetscCall(FollowViscosity(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool HasScalars(const Flow *flow)
{
  return flow->state->scalars ? PETSC_TRUE : PETSC_FALSE;
}

const Stage StageScalars = {.name    = "scalars",
                            .brief   = "temperature and other scalars that the fluid carries",
                            .Applies = HasScalars,
                            .Do      = ScalarsStep};

/* ScalarsDestroy - Frees the scalars; collective */
PetscErrorCode ScalarsDestroy(Flow *flow)
{
  Scalars *all = flow->state->scalars;

  PetscFunctionBegin;
  if (!all) PetscFunctionReturn(PETSC_SUCCESS);
  if (flow->scene->scope) ExpressionScopeFieldsAt(flow->scene->scope, NULL, NULL);
  for (PetscInt k = 0; k < all->n; k++) {
    Scalar *s = &all->scalar[k];

    PetscCall(ScalarFree(s));
    PetscCall(ScalarFreeVectors(s));
    if (s->guard.solve.ksp) PetscCall(GuardDetach(&s->guard));
    PetscCall(TSDestroy(&s->ts));
    PetscCall(PetscFree3(s->law, s->gives, s->entering));
  }
  PetscCall(CellsFree(&all->cells));
  PetscCall(FreeAll(&all->g, &all->flow, &all->scalar, &flow->state->scalars));
  PetscFunctionReturn(PETSC_SUCCESS);
}
