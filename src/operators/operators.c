/*
  The operators of a run: chosen from the tables, checked against each other and against the
  physics, and applied. Assembly is in assemble.c.
*/
#include "boundary_rows.h"

static PetscErrorCode OperatorsChooseLaplacian(PetscOptionItems *PetscOptionsObject,
                                               const char option[], const char text[],
                                               const char           standard[],
                                               const CorrectionRow *correction, LaplacianForm *form)
{
  PetscFunctionBegin;
  PetscCall(TableSelect(&LaplacianTable, option, text, standard, &form->row));
  if (form->row->corrections & correction->bit) form->correction = correction;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  mls, but the whole stress where the viscosity is not the same everywhere and the flow not as
  simple as a channel's, which has no pressure and no bodies: what turns beside another viscosity is
  wrong by tens of per cent in lap u.
*/
static const char *DefaultLaplacian(const Scene *scene)
{
  const PetscBool curved =
      SceneHas(scene, PHYSICS_PRESSURE) || scene->n_bodies ? PETSC_TRUE : PETSC_FALSE;

  return SceneViscosityVaries(scene) && curved ? "stress_mls" : "mls";
}

/* The Laplacians that the physics needs; one correction for both, where they can take it. */
static PetscErrorCode OperatorsChooseLaplacians(PetscOptionItems *PetscOptionsObject,
                                                const Scene *scene, Operators *ops)
{
  const CorrectionRow *correction;

  PetscFunctionBegin;
  PetscCall(TableSelect(&CorrectionTable, "-correction",
                        "Correction of the kernel in Laplacians that can take it", "none",
                        &correction));
  if (SceneHas(scene, PHYSICS_VISCOSITY)) {
    PetscCall(OperatorsChooseLaplacian(PetscOptionsObject, "-visc_laplacian",
                                       "Form of the viscous term", DefaultLaplacian(scene),
                                       correction, &ops->visc_form));
    UserCheck(!SceneViscosityVaries(scene) || LaplacianIs(&ops->visc_form, FORM_VARYING),
              "-visc_laplacian %s: it cannot take a viscosity that varies; use a form that has "
              "varying_viscosity in -catalogue, such as mls or schwaiger",
              ops->visc_form.row->name);
  }
  if (SceneHas(scene, PHYSICS_PRESSURE)) {
    PetscCall(OperatorsChooseLaplacian(PetscOptionsObject, "-ppe_laplacian",
                                       "Form of the pressure Poisson equation", "mls", correction,
                                       &ops->ppe_form));
    UserCheck(LaplacianIs(&ops->ppe_form, FORM_SAFE_IMPLICIT),
              "-ppe_laplacian %s: its matrix has eigenvalues of both signs, so no pressure can be "
              "solved for; use a form that is safe_implicit in -catalogue, such as mls or morris",
              ops->ppe_form.row->name);
    UserCheck(
        !LaplacianIs(&ops->ppe_form, FORM_COUPLES),
        "-ppe_laplacian %s: it is made for the components of a velocity; use mls in its place",
        ops->ppe_form.row->name);
  }
  UserCheck(!correction->Kernel || ops->visc_form.correction || ops->ppe_form.correction,
            "-correction %s: no chosen Laplacian can take it; -catalogue lists those that do",
            correction->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The wall treatment the user chose, or the one that his forms can meet. */
static PetscErrorCode OperatorsChooseWall(PetscOptionItems *PetscOptionsObject, const Scene *scene,
                                          Operators *ops)
{
  const char *blind = NULL; /* a chosen form that cannot do without particles behind walls */
  const char *kind  = "";

  PetscFunctionBegin;
  if (scene->problem->patch) {
    ops->wall = &WallGiven;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (ops->visc_form.row && LaplacianIs(&ops->visc_form, FORM_FULL_SUPPORT)) {
    blind = ops->visc_form.row->name;
    kind  = "-visc_laplacian";
  }
  if (ops->ppe_form.row && LaplacianIs(&ops->ppe_form, FORM_FULL_SUPPORT)) {
    blind = ops->ppe_form.row->name;
    kind  = "-ppe_laplacian";
  }
  if (ops->gradient && (ops->gradient->properties & FORM_FULL_SUPPORT)) {
    blind = ops->gradient->name;
    kind  = "-gradient";
  }
  PetscCall(TableSelect(&WallTable, "-wall",
                        "Wall treatment; by default the one that the chosen forms can meet",
                        blind ? "dummy_linear" : "wall_layer", &ops->wall));
  UserCheck(!blind || !ops->wall->on_surface,
            "-wall %s: %s %s needs particles behind the wall; use -wall dummy_linear, or mls in "
            "its place",
            ops->wall->name, kind, blind);
  if (ops->wall->Check) PetscCall(ops->wall->Check(scene));
  ops->wall_surface = scene->n_bodies > 0 && !ops->wall->on_surface ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(OptionSwitch("-wall_surface",
                         "Particles on walls, before those behind them; by default where there "
                         "are bodies, whose dummies alone leave a gap at curved walls",
                         &ops->wall_surface));
  UserCheck(
      !ops->wall_surface || !ops->wall->on_surface,
      "-wall_surface: -wall %s has its particles on the wall already; choose a treatment with "
      "particles behind it, such as dummy_linear",
      ops->wall->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Smoothing length over spacing: 1.3, but where viscosity smooths the grid scale, U dx/nu <= 5,

    1.5 for particles moving between walls: there the noise of changing neighbours next to walls
        is what is left of the error, and more neighbours halve it;
    1.1 for a flow without walls whose Laplacians are exact for quadratic functions: smaller fits
        have smaller errors, a third of those of 1.3 in Taylor-Green vortices at Re = 100.
*/
static PetscReal DefaultSmoothing(const Scene *scene, const Operators *ops)
{
  if (SceneCellReynolds(scene) > 5.0) return 1.3;
  if (SceneHas(scene, PHYSICS_WALLS)) return SceneMoves(scene) ? 1.5 : 1.3;
  if (!SceneHas(scene, PHYSICS_PRESSURE)) return 1.3;
  return LaplacianIs(&ops->visc_form, FORM_EXACT_QUADRATIC) &&
                 LaplacianIs(&ops->ppe_form, FORM_EXACT_QUADRATIC)
             ? 1.1
             : 1.3;
}

/* OperatorsList - All operators there may be, needed or not, in the order of assembly; not
   collective */
void OperatorsList(Operators *ops, AffineOperator *all[OPERATORS_COUNT])
{
  PetscInt n = 0;

  all[n++] = &ops->visc;
  all[n++] = &ops->ppe;
  all[n++] = &ops->filter_u;
  all[n++] = &ops->filter_p;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    all[n++] = &ops->grad_u[a];
    all[n++] = &ops->grad_p[a];
    all[n++] = &ops->div[a];
  }
}

/* Whether velocity components go together, and what that excludes. */
static PetscErrorCode OperatorsCoupleComponents(const Scene *scene, Operators *ops)
{
  const PetscBool couple = ops->visc_form.row && LaplacianIs(&ops->visc_form, FORM_COUPLES);
  AffineOperator *all[OPERATORS_COUNT];

  PetscFunctionBegin;
  OperatorsList(ops, all);
  for (PetscInt k = 0; k < OPERATORS_COUNT; k++) all[k]->width = 1;
  ops->visc.width         = LaplacianWidth(&ops->visc_form, scene->dim);
  ops->visc_is_laplacian  = !couple && !SceneViscosityVaries(scene) ? PETSC_TRUE : PETSC_FALSE;
  ops->components_coupled = couple || !SceneIsNewtonian(scene) ? PETSC_TRUE : PETSC_FALSE;
  UserCheck(
      !couple || !scene->problem->patch,
      "-visc_laplacian %s: a patch test is of scalars; use a form that does not couple components",
      ops->visc_form.row->name);
  UserCheck(!ops->components_coupled || !ops->wall || !ops->wall->Extend,
            "-wall %s: with %s walls must give their own velocity; use -wall %s", ops->wall->name,
            couple ? ops->visc_form.row->name : "-rheology",
            couple ? "dummy_linear" : "wall_layer or dummy_linear");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Filter of grid-scale velocities: on where the flow cannot do without, by the cell Reynolds number
  R = U dx/nu. Where it is not needed it takes from boundary layers: a quarter of the cavity's
  energy at Re = 1000, n = 25. Without it moving particles held at R = 20 and died at 25, at CFL
  numbers of 0.1 and less (Re = 1000, n = 40); they need 0.2 at R = 40 and 1 at 200 (Re = 10,000, n
  = 50). Fixed ones held up to 6 and died at 7 (Re = 100 in 3D).
*/
static PetscReal DefaultVelocityFilter(const Scene *scene)
{
  const PetscReal R = SceneCellReynolds(scene);

  if (!SceneMoves(scene)) return R > 5.0 ? 1.0 : 0.0;
  return PetscMin(1.0, PetscMax(0.0, (R - 20.0) / 40.0));
}

/*
  OperatorsCreate - Chooses the operators of a run

  Collective on PETSC_COMM_WORLD. Nothing is assembled yet; what the physics does not need never is.

  Options Database Keys:
+ -kernel name         - row of the kernel table
. -h_over_dx ratio     - smoothing length over particle spacing; see DefaultSmoothing()
. -visc_laplacian name - form of the viscous term
. -ppe_laplacian name  - form of the pressure Poisson equation
. -correction name     - of the kernel that these Laplacians read
. -gradient name       - form of gradients and divergences
. -wall name           - wall treatment
. -velocity_filter S   - strength of the filter of velocities that change from particle to particle,
                         for ConvectionApply() and ParticlesMove()
- -wall_surface        - a layer of particles on the walls before the layers behind them; by
                         default with bodies

  Errors: forms that need particles behind walls are refused with a treatment that has none,
  corrections with forms that do not read the kernel's slope, anti-diffusive forms for the pressure,
  treatments with scenes they cannot take
*/
PetscErrorCode OperatorsCreate(const Scene *scene, Operators **operators)
{
  Operators *ops;
  PetscReal  h_over_dx;

  PetscFunctionBegin;
  PetscCall(PetscNew(&ops));
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "Operators", "");
  PetscCall(TableSelect(&KernelTable, "-kernel", "Smoothing kernel", "wendland_c2", &ops->kernel));
  PetscCall(OperatorsChooseLaplacians(PetscOptionsObject, scene, ops));
  h_over_dx = DefaultSmoothing(scene, ops);
  PetscCall(OptionReal("-h_over_dx", "Smoothing length over particle spacing [-]", 0.8, 4.0,
                       &h_over_dx, NULL));
  if (SceneHas(scene, PHYSICS_PRESSURE) || SceneHas(scene, PHYSICS_CONVECTION) ||
      !SceneIsNewtonian(scene)) {
    PetscCall(TableSelect(&GradientTable, "-gradient", "Form of gradients and divergences", "mls",
                          &ops->gradient));
  }
  if (SceneHas(scene, PHYSICS_CONVECTION)) {
    ops->velocity_filter = DefaultVelocityFilter(scene);
    PetscCall(
        OptionReal("-velocity_filter",
                   "Strength of the grid-scale filter of velocities; 0: off; by default it "
                   "grows from 0 to 1 between U dx/nu = 20 and 60, with fixed particles it is "
                   "1 above 5 [-]",
                   0.0, 1.0, &ops->velocity_filter, NULL));
  }
  if (SceneHas(scene, PHYSICS_WALLS))
    PetscCall(OperatorsChooseWall(PetscOptionsObject, scene, ops));
  PetscOptionsEnd();
  ops->h      = h_over_dx * scene->dx;
  ops->radius = ops->reach = ops->kernel->support * ops->h;
  if (ops->wall && ops->wall->Extend) {
    ops->reach =
        PetscMax(ops->radius, ops->wall->radii * ops->radius + ops->wall->spacings * scene->dx);
    ops->visc_form.extended = PETSC_TRUE;
  }
  ops->visc.needed     = SceneHas(scene, PHYSICS_VISCOSITY);
  ops->filter_u.needed = ops->velocity_filter > 0.0 ? PETSC_TRUE : PETSC_FALSE;
  ops->ppe.needed      = SceneHas(scene, PHYSICS_PRESSURE);
  for (PetscInt a = 0; a < scene->dim; a++) {
    ops->grad_p[a].needed = ops->div[a].needed = SceneHas(scene, PHYSICS_PRESSURE);
    ops->grad_u[a].needed = SceneHas(scene, PHYSICS_CONVECTION) || !SceneIsNewtonian(scene);
  }
  PetscCall(OperatorsCoupleComponents(scene, ops));
  PetscCall(StencilCreate(scene->dim, ops->radius, 0.5 * ops->radius, &ops->stencil));
  ops->stencil->fits_walls = ops->wall ? ops->wall->on_surface : PETSC_FALSE;
  KernelEvaluate(ops->kernel, scene->dim, ops->h, 0.0, ops->stencil->self);
  ops->stencil->volume = SceneVolume(scene);
  *operators           = ops;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AffineFree(AffineOperator *op)
{
  PetscFunctionBegin;
  PetscCall(MatDestroy(&op->A));
  PetscCall(MatDestroy(&op->B));
  PetscCall(PetscFree2(op->a, op->b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OperatorsDestroy(Operators **operators)
{
  Operators      *ops = *operators;
  AffineOperator *all[OPERATORS_COUNT];

  PetscFunctionBegin;
  if (!ops) PetscFunctionReturn(PETSC_SUCCESS);
  OperatorsList(ops, all);
  for (PetscInt k = 0; k < OPERATORS_COUNT; k++) PetscCall(AffineFree(all[k]));
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    PetscCall(VecDestroy(&ops->wall_u[a]));
    PetscCall(PetscFree(ops->gradient_c[a]));
    PetscCall(PetscFree(ops->g[a]));
  }
  PetscCall(VecDestroy(&ops->wall_dpdn));
  PetscCall(VecDestroy(&ops->wall_dpdn_step));
  PetscCall(PetscFree(ops->concentration));
  PetscCall(PetscFree4(ops->slot, ops->w, ops->m, ops->wall_w));
  PetscCall(PetscFree(ops->neighbor_of_slot));
  PetscCall(PatternFree(&ops->fluid));
  PetscCall(PatternFree(&ops->walls));
  PetscCall(StencilDestroy(&ops->stencil));
  PetscCall(PetscFree(*operators));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OperatorsPlacement - Where the wall treatment wants its particles; not collective */
PetscErrorCode OperatorsPlacement(const Scene *scene, const Operators *ops, WallPlacement *walls)
{
  PetscFunctionBegin;
  walls->layers   = 0;
  walls->surface  = ops->wall_surface;
  walls->jittered = scene->problem->patch;
  if (ops->wall && !ops->wall->on_surface) {
    walls->layers = (PetscInt)PetscCeilReal(ops->radius / scene->dx - 1e-9);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  OperatorsSetWallVelocity - Gives the own wall particles their velocity at time t

    u_w = u_wall(t) + projection_factor (d(n.grad p)) n

  Not collective. The wall's own velocity is the one of the surface point nearest to the particle.
  The second term belongs to a predicted velocity, which the pressure step will correct by
  -projection_factor grad phi where n.grad phi is known and not zero; a projection_factor of 0
  [m^3 s/kg] leaves it out. ops->wall_speed_bound follows.
*/
PetscErrorCode OperatorsSetWallVelocity(const Scene *scene, const Particles *p, PetscReal t,
                                        PetscReal projection_factor, Operators *ops)
{
  PetscReal       *u[ISPH_MAX_DIM];
  const PetscReal *slope = NULL;

  PetscFunctionBegin;
  if (!ops->wall) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArrayRead(ops->wall_dpdn_step, &slope));
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecGetArray(ops->wall_u[a], &u[a]));
  for (PetscInt k = 0; k < p->n_wall; k++) {
    const PetscInt i = p->n_fluid + k;
    PetscReal      x[ISPH_MAX_DIM], velocity[ISPH_MAX_DIM], normal[ISPH_MAX_DIM];

    ParticlesWallPoint(p, i, x);
    SceneWallVelocity(scene, (PetscInt)p->side[i], t, x, velocity);
    for (PetscInt a = 0; a < scene->dim; a++) {
      p->u[a][i] = velocity[a];
      u[a][k]    = velocity[a] + projection_factor * slope[k] * p->normal[a][i];
      normal[a]  = p->normal[a][i];
    }
    ops->wall_speed_bound =
        PetscMax(ops->wall_speed_bound,
                 SceneWallSpeedBound(scene, (PetscInt)p->side[i], x, normal, velocity));
  }
  PetscCall(VecRestoreArrayRead(ops->wall_dpdn_step, &slope));
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecRestoreArray(ops->wall_u[a], &u[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  AffineApply - y = A f + B e

  Collective. Input: f over fluid, walls the wall data e (ignored without walls).
*/
PetscErrorCode AffineApply(const AffineOperator *op, Vec f, Vec walls, Vec y)
{
  PetscFunctionBegin;
  PetscCall(MatMult(op->A, f, y));
  if (op->B) PetscCall(MatMultAdd(op->B, walls, y, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* AffineApplyAdd - y += A f + B e; collective */
PetscErrorCode AffineApplyAdd(const AffineOperator *op, Vec f, Vec walls, Vec y)
{
  PetscFunctionBegin;
  PetscCall(MatMultAdd(op->A, f, y, y));
  if (op->B) PetscCall(MatMultAdd(op->B, walls, y, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}
