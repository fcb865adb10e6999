/*
  The scheme of a run: chosen from the tables with the pieces the physics needs.
*/
#include "projection.h"

static const ProjectionRow projections[] = {
    {"rotational", "p = p^n + phi - mu div u*: second order, right in the Stokes limit",
     "Guermond, Minev & Shen, Comput. Methods Appl. Mech. Eng. 195 (2006)", PETSC_TRUE, PETSC_TRUE},
    {"incremental", "p = p^n + phi; wrong steady states at low Reynolds number and large steps",
     "van Kan, SIAM J. Sci. Stat. Comput. 7 (1986)", PETSC_TRUE, PETSC_FALSE},
    {"chorin", "p = phi, no pressure in the predictor: first order",
     "Chorin, Math. Comput. 22 (1968)", PETSC_FALSE, PETSC_FALSE},
};
const Table ProjectionTable = TABLE("-projection", "Projections", projections);

static const SchemeRow schemes[] = {
    {"projection", "implicit viscosity, then a pressure projection",
     "Guermond, Minev & Shen, Comput. Methods Appl. Mech. Eng. 195 (2006)", PETSC_TRUE,
     ProjectionCreate, ProjectionRegister, ProjectionBegin, ProjectionStep, ProjectionDestroy},
    {"coupled", "velocity and pressure in one matrix: no splitting error at any step, or -steady",
     "Elman, Silvester & Wathen, Finite Elements and Fast Iterative Solvers (2014)", PETSC_FALSE,
     ProjectionCreate, ProjectionRegister, ProjectionBegin, CoupledStep, ProjectionDestroy},
};
const Table SchemeTable = TABLE("-scheme", "Schemes", schemes);

/* Whether what drives the flow depends on time. */
static PetscBool IsDrivenInTime(const Scene *scene)
{
  return scene->unsteady_walls || (scene->force.n && ExpressionUses(&scene->force, EXPRESSION_TIME))
             ? PETSC_TRUE
             : PETSC_FALSE;
}

/*
  A projection creeps towards the Stokes limit by what it is not rotational for: all of the
  viscosity, or what exceeds the least. At large steps that is so slow that any steadiness test is
  met far from it: the incremental cavity at Re = 0.01, nu dt/L^2 = 100 passes 1e-3 with u_min 31 %
  off.
*/
static PetscErrorCode SchemeRefuseCreep(const Scene *scene, const Clock *clock,
                                        const ProjectionRow *projection)
{
  const PetscReal left =
      scene->nu_high - (projection && projection->rotational ? scene->nu_low : 0.0);
  const PetscReal number = left * clock->dt / PetscSqr(scene->length);

  PetscFunctionBegin;
  UserCheck(
      clock->steady_tol == 0.0 || !IsDrivenInTime(scene),
      "-steady_tol: a wall's velocity or the body force depends on t, and a flow that is steady "
      "for now would end the run; use -t_end");
  UserCheck(
      clock->steady_tol == 0.0 || !projection || !SceneHas(scene, PHYSICS_VISCOSITY) ||
          number <= 0.01,
      "-steady_tol with -projection %s at nu dt/L^2 = %.2g: it creeps too slowly for a "
      "steady state to be told; use -projection rotational with one viscosity, or -dt below %.2g",
      projection->name, (double)number, (double)(0.01 * clock->dt / number));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What the coupled scheme cannot be made of. */
static PetscErrorCode SchemeRefuseCoupled(const Scene *scene, const Operators *ops)
{
  const PetscBool viscous = SceneHas(scene, PHYSICS_VISCOSITY);

  PetscFunctionBegin;
  UserCheck(viscous && SceneHas(scene, PHYSICS_PRESSURE),
            "-scheme coupled: it solves for velocity and pressure together, and case %s has no %s "
            "here; add -with %s, or use -scheme projection",
            scene->problem->name, viscous ? "pressure" : "viscosity",
            viscous ? "pressure" : "viscosity");
  UserCheck(ops->gradient->DivergenceFit,
            "-gradient %s: -scheme coupled takes grad p from the fluid alone beside walls, which "
            "only -gradient mls can",
            ops->gradient->name);
  UserCheck(LaplacianIs(&ops->visc_form, FORM_SAFE_IMPLICIT),
            "-visc_laplacian %s: its matrix has eigenvalues of both signs, and -scheme coupled has "
            "no solver for it; use a form that is safe_implicit in -catalogue",
            ops->visc_form.row->name);
  UserCheck(!ops->components_coupled && !SceneViscosityVaries(scene),
            "-scheme coupled: it takes one viscosity, the same matrix for each component, and not "
            "%s; use -scheme projection",
            !SceneIsNewtonian(scene)      ? "-rheology"
            : SceneViscosityVaries(scene) ? "fluids of several"
                                          : ops->visc_form.row->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What has no steady flow, or none that one system gives. */
static PetscErrorCode SchemeRefuseSteady(const Scene *scene, const SchemeRow *row)
{
  PetscFunctionBegin;
  UserCheck(!row->splits,
            "-steady: -scheme %s advances in time; use -scheme coupled, or -steady_tol", row->name);
  UserCheck(!SceneMoves(scene),
            "-steady: particles that move never come to rest; use -motion eulerian, or "
            "-without convection for creeping flow");
  UserCheck(SceneHas(scene, PHYSICS_WALLS),
            "-steady: case %s has no walls, and without them any uniform velocity is a solution",
            scene->problem->name);
  UserCheck(!IsDrivenInTime(scene) &&
                !(scene->exact.n && ExpressionUses(&scene->exact, EXPRESSION_TIME)),
            "-steady: a wall's velocity, the body force or -scene_exact depends on t; advance in "
            "time, with -coupled_ts_type rosw in steps of any length");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Whether particles are and stay on a lattice that no body cuts. */
static PetscErrorCode OnLattice(const Scene *scene, PetscBool *on)
{
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(OptionGiven("-particles", &given));
  *on = !SceneMoves(scene) && scene->jitter == 0.0 && !scene->n_bodies && !given ? PETSC_TRUE
                                                                                 : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The solver of velocity and pressure together. */
static PetscErrorCode SchemeCreateCoupled(const Scene *scene, const Clock *clock, Operators *ops,
                                          Scheme *s)
{
  const PetscBool             moves = SceneMoves(scene);
  const CoupledIntegratorRow *time;
  PetscBool                   filter, order;

  PetscFunctionBegin;
  ops->grad_p_without_walls = ops->filter_p.needed = PETSC_TRUE;
  PetscCall(CoupledCreate(scene, clock->dt, scene->motion && !moves ? PETSC_TRUE : PETSC_FALSE,
                          &s->coupled));
  time = CoupledIntegrator(s->coupled);
  UserCheck(!moves || !time->substeps,
            "-coupled_ts_type %s: particles that move leave its substeps nothing to begin from; "
            "use beuler, or -motion eulerian",
            time->name);
  if (!clock->steady_solve && !time->substeps) PetscFunctionReturn(PETSC_SUCCESS);
  if (scene->motion) {
    PetscCall(OptionGiven("-velocity_filter", &filter));
    UserCheck(!filter, "-velocity_filter: %s takes convection as it is, unfiltered",
              clock->steady_solve ? "-steady" : "this -coupled_ts_type");
  }
  PetscCall(OptionGiven("-time_order", &order));
  UserCheck(!order, "-time_order: -coupled_ts_type %s has its own order", time->name);
  ops->filter_u.needed = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Chorin's projection between walls on fixed particles feeds energy into what viscosity does not
  damp from one particle to the next: the cavity (n = 32, t = 4) has 1, 7, 20, 43 % more than by the
  rotational one at U dx/nu = 6, 8, 10, 12, 5 times as much at 31 and 8 times at 312.
*/
static PetscErrorCode SchemeRefuseGain(const Scene *scene, const ProjectionRow *projection)
{
  const PetscReal R = SceneCellReynolds(scene);

  PetscFunctionBegin;
  UserCheck(
      !projection || projection->incremental || SceneMoves(scene) ||
          !SceneHas(scene, PHYSICS_WALLS) || !SceneHas(scene, PHYSICS_CONVECTION) || R <= 10.0,
      "-projection %s: on fixed particles between walls it feeds energy where U dx/nu is above "
      "10, here %.3g; use rotational or incremental, or a larger -n",
      projection->name, (double)R);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SchemeCreate - Chooses the scheme and makes its solvers

  Collective on PETSC_COMM_WORLD.

  Options Database Keys:
+ -scheme, -projection, -shift - rows of their tables
. -shift_strength S - factor of the diffusivity of -shift
. -time_order 1|2   - order of the time integration
. -ppe_alpha A      - share of the density error in the pressure source (Zheng et al. 2018, Eq. 13)
- -ppe_filter S     - strength of the grid-scale pressure filter, by default 1, on lattices 0.1; see
                      FilterShare()
*/
PetscErrorCode SchemeCreate(const Scene *scene, const Clock *clock, Operators *ops, Scheme **scheme)
{
  const PetscBool moves = SceneMoves(scene);
  Scheme         *s;

  PetscFunctionBegin;
  PetscCall(PetscNew(&s));
  s->time_order = 2;
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "Scheme", "");
  PetscCall(TableSelect(&SchemeTable, "-scheme", "How velocity and pressure are advanced",
                        "projection", &s->row));
  PetscCall(OptionInt("-time_order", "Order of the time integration", 1, 2, &s->time_order, NULL));
  if (SceneHas(scene, PHYSICS_PRESSURE) && s->row->splits) {
    PetscBool lattice = PETSC_FALSE;

    PetscCall(OnLattice(scene, &lattice));
    s->filter = lattice ? 0.1 : 1.0;
    PetscCall(TableSelect(&ProjectionTable, "-projection",
                          "How the pressure follows from its increment", "rotational",
                          &s->projection));
    PetscCall(OptionReal("-ppe_alpha", "Share of the density error in the pressure source [-]", 0.0,
                         1.0, &s->alpha, NULL));
    PetscCall(OptionReal("-ppe_filter",
                         "Strength of the grid-scale pressure filter; 0: off; by default 1, on "
                         "lattices that stay 0.1 [-]",
                         0.0, 2.0, &s->filter, NULL));
    ops->filter_p.needed = s->filter > 0.0 ? PETSC_TRUE : PETSC_FALSE;
  }
  if (moves) {
    PetscCall(TableSelect(&ShiftTable, "-shift", "Particle shifting", "fickian", &s->shift));
    if (s->shift->Displace) {
      s->shift_strength = 1.0;
      PetscCall(OptionReal("-shift_strength", "Factor of the diffusivity of -shift [-]", 1e-3,
                           100.0, &s->shift_strength, NULL));
    }
  }
  PetscOptionsEnd();
  if (!s->row->splits) PetscCall(SchemeRefuseCoupled(scene, ops));
  if (clock->steady_solve) PetscCall(SchemeRefuseSteady(scene, s->row));
  PetscCall(SchemeRefuseCreep(scene, clock, s->projection));
  PetscCall(SchemeRefuseGain(scene, s->projection));
  ops->need_concentration =
      (s->alpha > 0.0 || (s->shift && s->shift->Displace)) ? PETSC_TRUE : PETSC_FALSE;
  if (SceneHas(scene, PHYSICS_VISCOSITY) && s->row->splits)
    PetscCall(ViscosityCreate(scene, clock->dt, ops, &s->visc));
  UserCheck(
      !s->visc || !ViscosityIntegrator(s->visc)->multistep || !moves,
      "-visc_ts_type %s: its own history cannot follow particles that move; use beuler, which "
      "is BDF2 with the history on particles, or -motion eulerian",
      ViscosityIntegrator(s->visc)->name);
  UserCheck(
      !s->visc || !ViscosityIntegrator(s->visc)->multistep || !clock->adapt->retries,
      "-visc_ts_type %s: its own history cannot be undone with a step, as -dt_adapt retry wants; "
      "use beuler",
      ViscosityIntegrator(s->visc)->name);
  if (SceneHas(scene, PHYSICS_PRESSURE) && s->row->splits) PetscCall(PressureCreate(ops, &s->ppe));
  if (!s->row->splits) PetscCall(SchemeCreateCoupled(scene, clock, ops, s));
  PetscCall(s->row->Create(scene, clock, ops, s));
  *scheme = s;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SchemeRegister - Gives the particles the fields the scheme carries, and the initial values */
PetscErrorCode SchemeRegister(const Scene *scene, Particles *particles, Scheme *scheme)
{
  PetscFunctionBegin;
  PetscCall(scheme->row->Register(scene, particles, scheme));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SchemeDestroy(Scheme **scheme)
{
  PetscFunctionBegin;
  if (!*scheme) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall((*scheme)->row->Destroy(*scheme));
  PetscCall(ViscosityDestroy(&(*scheme)->visc));
  PetscCall(PressureDestroy(&(*scheme)->ppe));
  PetscCall(CoupledDestroy(&(*scheme)->coupled));
  PetscCall(PetscFree(*scheme));
  PetscFunctionReturn(PETSC_SUCCESS);
}
