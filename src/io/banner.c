/* The banner: the first lines that a run prints. It shows the case, the chosen forms and their
   publications, the physics left out, and the gain of implicit over explicit viscosity. */
#include "isph/solvers.h"
#include "isph/io.h"

#define BANNER_LABEL "%-11s "
#define NARROW       2.0  /* gap from which on particles are in it [spacings] */
#define SURPLUS      1e-5 /* part of a flow: less of it is no news */
#define FAR          10.0 /* largest ratio of given velocities and the default of U [-] */
#define ROUNDED      1e-6 /* difference of two lengths that rounding may make [-] */

/* Returns the largest factor of the velocity of graded particles, SceneMotionFactor() [-]. */
static PetscReal LargestFactor(const Scene *scene)
{
  PetscReal volume = 1.0;

  for (PetscInt a = 0; a < scene->dim; a++)
    volume *= scene->grading.on ? SceneCellSide(scene, a) * (scene->grading.most / scene->dx)
                                : scene->map[a].most;
  return volume / scene->motion_volume;
}

/* SpeedView - Prints a line if -speed is not given and the velocities of boundaries, or those at
   the start, are far from its default: limits of steps and many scales depend on U. Collective on
   the viewer. A body force drives flows whose speed no option gives. */
PetscErrorCode SpeedView(const Flow *flow, PetscViewer viewer)
{
  const Particles *p     = flow->particles;
  const PetscInt   first = flow->clock->step ? p->n_fluid : 0;
  PetscReal        most  = 0.0;
  PetscBool        given;

  PetscFunctionBegin;
  PetscCall(OptionGiven("-speed", &given));
  if (given || SceneHas(flow->scene, PHYSICS_BODY_FORCE)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = first; i < p->n_fluid + p->n_wall; i++) {
    PetscReal speed2 = 0.0;

    for (PetscInt a = 0; a < p->dim; a++) speed2 += PetscSqr(p->u[a][i]);
    most = PetscMax(most, PetscSqrtReal(speed2));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPIU_MAX, p->comm));
  if (!(most > 0.0) || (most * FAR >= flow->scene->speed && most <= FAR * flow->scene->speed))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscViewerASCIIPrintf(viewer,
                                   BANNER_LABEL "largest given velocity %.2g m/s, U = %.4g m/s by "
                                                "default: give -speed %.2g\n",
                                   "speed", (double)most, (double)flow->scene->speed,
                                   (double)most));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints case, fluid and particles. */
static PetscErrorCode BannerCase(const Flow *flow, PetscViewer viewer)
{
  static const char *const degrees[] = {"", "", "", ", cubic fits", ", quartic fits"};
  const Scene             *scene     = flow->scene;
  const CaseRow           *row       = scene->problem;
  PetscMPIInt              ranks;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &ranks));
  PetscCall(PetscViewerASCIIPrintf(
      viewer, "isph %s, incompressible viscous SPH on PETSc %d.%d.%d\n", ISPH_VERSION,
      PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR));
  PetscCall(PetscViewerASCIIPrintf(viewer, BANNER_LABEL "%s: %s", "case", row->name, row->brief));
  if (row->citation) PetscCall(PetscViewerASCIIPrintf(viewer, " [%s]", row->citation));
  PetscCall(
      PetscViewerASCIIPrintf(viewer, "\n" BANNER_LABEL "%" PetscInt_FMT "D, ", "flow", scene->dim));
  if (SceneHas(scene, PHYSICS_VISCOSITY)) {
    PetscCall(PetscViewerASCIIPrintf(viewer, "Re = %.6g, nu = %.6g m^2/s, ",
                                     (double)SceneReynolds(scene), (double)scene->nu));
  }
  PetscCall(PetscViewerASCIIPrintf(viewer, "L = %.4g m, U = %.4g m/s\n", (double)scene->length,
                                   (double)scene->speed));
  PetscCall(SpeedView(flow, viewer));
  PetscCall(PetscViewerASCIIPrintf(viewer,
                                   BANNER_LABEL "%" PetscInt_FMT " fluid + %" PetscInt_FMT
                                                " wall, dx = %.4g m, h/dx = %.3g%s; "
                                                "%d rank%s\n",
                                   "particles", flow->particles->N_fluid, flow->particles->N_wall,
                                   (double)scene->dx, (double)(flow->ops->forms.h_over_dx),
                                   degrees[flow->ops->forms.degree], ranks, ranks == 1 ? "" : "s"));
  if (PetscAbsReal(scene->surplus) > SURPLUS) {
    PetscCall(PetscViewerASCIIPrintf(
        viewer,
        BANNER_LABEL "the given velocities let %.2g %% of the flow more %s: it is removed where "
                     "fluid passes\n",
        "openings", (double)(100.0 * PetscAbsReal(scene->surplus)),
        scene->surplus > 0.0 ? "in than out" : "out than in"));
  }
  if (SceneIsGraded(scene)) {
    PetscCall(PetscViewerASCIIPrintf(
        viewer, BANNER_LABEL "from %.3g to %.3g dx, growing by at most %.2g %% a particle%s\n",
        "spacing", (double)(SceneFinest(scene) / scene->dx),
        (double)(SceneCoarsest(scene) / scene->dx), (double)(100.0 * SceneGrowth(scene)),
        scene->grading.on
            ? SceneGrowth(scene) > 0.151 ? "; no lattice; above 15 % errors vary" : "; no lattice"
            : ""));
  }
  if (SceneMovesGraded(scene)) {
    PetscCall(PetscViewerASCIIPrintf(viewer,
                                     BANNER_LABEL
                                     "particles have up to %.3g times the velocity of the flow, in "
                                     "proportion to their volumes\n",
                                     "grading", (double)LargestFactor(scene)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the rheology and, of a fluid that yields, the Bingham number and the regularisation. */
static PetscErrorCode BannerRheology(const Scene *scene, PetscViewer viewer)
{
  const Rheology *r    = &scene->rheology;
  const PetscReal time = scene->length / scene->speed;

  PetscFunctionBegin;
  PetscCall(TableViewRow("rheology", r->row, viewer));
  if (!(r->row->takes & RHEOLOGY_BIT(RHEOLOGY_YIELD))) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscViewerASCIIPrintf(
      viewer,
      BANNER_LABEL "at tau_0 = %.4g m^2/s^2, Bn = tau_0 L/(nu U) = %.4g; rigid parts creep, m = "
                   "%.4g L/U\n",
      "yields", (double)r->parameter[RHEOLOGY_YIELD],
      (double)(r->parameter[RHEOLOGY_YIELD] * time / scene->nu),
      (double)(r->parameter[RHEOLOGY_REGULARISATION] / time)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the range of a viscosity that varies. */
static PetscErrorCode BannerViscosity(const Scene *scene, PetscViewer viewer)
{
  PetscFunctionBegin;
  if (!SceneViscosityVaries(scene)) PetscFunctionReturn(PETSC_SUCCESS);
  if (!SceneIsNewtonian(scene)) PetscCall(BannerRheology(scene, viewer));
  PetscCall(PetscViewerASCIIPrintf(
      viewer,
      BANNER_LABEL "nu from %.4g to %.4g m^2/s, harmonic means of pairs; Re belongs to %.4g\n",
      "varies", (double)scene->nu_low, (double)scene->nu_high, (double)scene->nu));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns about bodies thinner than the kernel support: particles on opposite sides interact. */
static PetscErrorCode BannerThinBodies(const Flow *flow, PetscViewer viewer)
{
  const Scene *scene = flow->scene;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < scene->n_bodies; k++) {
    const Body     *body = SceneBody(scene, k);
    PetscReal       place[ISPH_MAX_DIM];
    char            text[PLACE_TEXT];
    const PetscReal reach = flow->ops->forms.radius,
                    thin  = BodyThickness(body, BodySpacing(scene, body), reach, place);

    if (thin > (1.0 - ROUNDED) * reach) continue;
    PetscCall(PetscViewerASCIIPrintf(
        viewer,
        BANNER_LABEL "body %" PetscInt_FMT
                     " is %.2g dx thick at (%s); particles on opposite sides interact "
                     "below %.2g dx, and forces on it are wrong; use a larger -n\n",
        "thin", k + 1, (double)(thin / scene->dx), ScenePlaceText(scene, place, text),
        (double)(reach / scene->dx)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Says which gap is too narrow for particles in it. */
static PetscErrorCode BannerGap(const Scene *scene, PetscViewer viewer)
{
  PetscInt  between[2];
  PetscReal x[ISPH_MAX_DIM], gap;
  char      name[2][WALL_NAME], place[PLACE_TEXT];

  PetscFunctionBegin;
  gap = SceneNarrowestGap(scene, between, x);
  if (gap >= NARROW) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < 2; k++) SceneWallName(scene, between[k], name[k]);
  PetscCall(PetscViewerASCIIPrintf(viewer,
                                   BANNER_LABEL "%.2g dx between %s and %s at (%s); the flow in "
                                                "gaps below %.2g dx is not resolved\n",
                                   "gap", (double)gap, name[0], name[1],
                                   ScenePlaceText(scene, x, place), NARROW));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the physics of the run and the physics left out. */
static PetscErrorCode BannerPhysics(const Scene *scene, PetscViewer viewer)
{
  char names[2][128] = {"", ""}; /* left out, active */

  PetscFunctionBegin;
  for (PetscInt k = 0; k < PHYSICS_COUNT; k++)
    AppendWord(names[SceneHas(scene, (Physics)(1u << k)) ? 1 : 0], sizeof(names[0]),
               PhysicsNames[k]);
  PetscCall(PetscViewerASCIIPrintf(viewer, BANNER_LABEL "%s; left out: %s\n", "physics", names[1],
                                   names[0][0] ? names[0] : "nothing"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if a scheme has a velocity solve without a KSP. */
static PetscBool IsExplicit(const Scheme *scheme)
{
  for (PetscInt k = 0; k < scheme->n_solves; k++) {
    if (scheme->solve[k]->column == SOLVE_VELOCITY && !scheme->solve[k]->ksp) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Compares implicit with explicit viscosity. Advection limits implicit steps (default CFL number),
   and dt_explicit limits explicit steps. A solve costs about as much as another step, so implicit
   steps below twice dt_explicit are no gain (results/implicit.md). */
static PetscErrorCode BannerPays(const Flow *flow, PetscReal dt, PetscReal dt_explicit,
                                 PetscViewer viewer)
{
  const Scene    *scene  = flow->scene;
  const PetscReal advect = CLOCK_CFL * scene->dx / scene->speed;

  PetscFunctionBegin;
  PetscCall(PetscViewerASCIIPrintf(viewer, BANNER_LABEL "dt = %.3g dt_explicit (%.3g s): ",
                                   "viscosity", (double)(dt / dt_explicit), (double)dt_explicit));
  if (IsExplicit(flow->scheme) && dt > dt_explicit) {
    PetscCall(PetscViewerASCIIPrintf(viewer, "too long for explicit viscosity\n"));
  } else if (!SceneHas(scene, PHYSICS_CONVECTION)) {
    PetscCall(
        PetscViewerASCIIPrintf(viewer, "without convection only accuracy limits implicit steps\n"));
  } else if (advect > 2.0 * dt_explicit) {
    PetscCall(PetscViewerASCIIPrintf(
        viewer, "implicit steps are faster here, advection allows %.3g dt_explicit\n",
        (double)(advect / dt_explicit)));
  } else {
    PetscCall(PetscViewerASCIIPrintf(
        viewer, "implicit steps are no faster here, advection allows %.2g dt_explicit\n",
        (double)(advect / dt_explicit)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns about long steps of moving particles: in results/stability.md, runs of the cavity ended
   early at CFL numbers of 1 and more if viscosity did not smooth the grid scale. */
static PetscErrorCode BannerAdvection(const Flow *flow, PetscReal dt, PetscViewer viewer)
{
  const Scene    *scene = flow->scene;
  const PetscReal R = scene->regime->number[NUMBER_CELL], cfl = scene->speed * dt / scene->dx;
  const PetscReal most = RegimeValue(scene->regime, REGIME_STEP_HOLDS);

  PetscFunctionBegin;
  if (cfl <= most) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscViewerASCIIPrintf(viewer,
                                   BANNER_LABEL
                                   "U dx/nu = %.3g: moving particles may be unstable above a CFL "
                                   "number of %.2g; -dt_adapt retry shortens failed steps\n",
                                   "advection", (double)R, (double)most));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the control of the step length by the error in time, and the limit of the present step. */
static PetscErrorCode BannerControl(const Flow *flow, PetscViewer viewer)
{
  const Clock *clock = flow->clock;
  StepLimit    limit;

  PetscFunctionBegin;
  if (!clock->adapt->estimates) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SchemeLimit(flow, &limit));
  PetscCall(PetscViewerASCIIPrintf(
      viewer, BANNER_LABEL "error in time below %.3g of the velocity, dt at most %.4g s by %s\n",
      "step control", (double)clock->control.rtol, (double)limit.dt, limit.reason));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the time step and its limits. */
static PetscErrorCode BannerTime(const Flow *flow, PetscViewer viewer)
{
  const Scene    *scene = flow->scene;
  const PetscReal dt = flow->clock->dt, h = flow->ops->forms.h;

  PetscFunctionBegin;
  if (flow->clock->steady_solve) {
    PetscCall(PetscViewerASCIIPrintf(viewer, BANNER_LABEL "none, steady flow\n", "time"));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscViewerASCIIPrintf(
      viewer, BANNER_LABEL "t_end = %.6g s, dt = %.4g s, CFL U dt/dx = %.3g", "time",
      (double)flow->clock->t_end, (double)dt, (double)(scene->speed * dt / scene->dx)));
  if (SceneHas(scene, PHYSICS_VISCOSITY)) {
    PetscCall(PetscViewerASCIIPrintf(viewer, ", nu dt/h^2 = %.3g",
                                     (double)(scene->nu * dt / PetscSqr(h))));
  }
  PetscCall(PetscViewerASCIIPrintf(viewer, "\n"));
  if (flow->clock->order > 2)
    PetscCall(PetscViewerASCIIPrintf(
        viewer, BANNER_LABEL "3: BDF3 and Adams-Bashforth%s\n", "time order",
        flow->clock->adapt->estimates ? "" : "; the first steps are shorter"));
  PetscCall(BannerControl(flow, viewer));
  PetscCall(BannerAdvection(flow, dt, viewer));
  if (SceneHas(scene, PHYSICS_VISCOSITY))
    PetscCall(BannerPays(flow, dt, ClockExplicitLimit(scene, flow->ops->forms.radius), viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the pressure outside free surfaces, surface tension, the Ohnesorge number of the reference
   length, and the longest step of surface waves. */
static PetscErrorCode BannerTension(const Flow *flow, PetscViewer viewer)
{
  const Scene    *scene = flow->scene;
  const PetscReal sigma = scene->tension, limit = CapillaryLimit(scene);

  PetscFunctionBegin;
  if (scene->outside != 0.0)
    PetscCall(PetscViewerASCIIPrintf(viewer, BANNER_LABEL "p = %.6g Pa outside free surfaces\n",
                                     "surface", (double)scene->outside));
  if (sigma == 0.0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
      PetscViewerASCIIPrintf(viewer, BANNER_LABEL "sigma = %.6g N/m", "tension", (double)sigma));
  if (scene->tension_field.n) PetscCall(PetscViewerASCIIPrintf(viewer, " at most, it varies"));
  if (SceneHas(scene, PHYSICS_VISCOSITY))
    PetscCall(PetscViewerASCIIPrintf(
        viewer, ", Oh = %.3g",
        (double)(scene->nu * PetscSqrtReal(scene->rho / (sigma * scene->length)))));
  if (limit < PETSC_INFINITY)
    PetscCall(PetscViewerASCIIPrintf(viewer, ", dt = %.3g dt_capillary (%.3g s)",
                                     (double)(flow->clock->dt / limit), (double)limit));
  PetscCall(PetscViewerASCIIPrintf(viewer, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints densities and tensions of fluids, and the longest step of waves of their interfaces. */
static PetscErrorCode BannerFluids(const Flow *flow, PetscViewer viewer)
{
  const Scene    *scene = flow->scene;
  const PetscReal limit = InterfaceLimit(scene);

  PetscFunctionBegin;
  if (!SceneMixes(scene)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < SceneFluids(scene); k++) {
    PetscCall(PetscViewerASCIIPrintf(
        viewer, BANNER_LABEL "%" PetscInt_FMT ": rho = %.6g kg/m^3, mu = %.3g Pa s", "fluid", k,
        (double)(scene->rho * SceneFluidDensity(scene, k)),
        (double)(scene->rho * SceneFluidViscosity(scene, k, NULL))));
    if (k && scene->region_tension[k - 1] > 0.0)
      PetscCall(PetscViewerASCIIPrintf(viewer, ", sigma = %.6g N/m",
                                       (double)scene->region_tension[k - 1]));
    if (k == SceneFluids(scene) - 1 && limit < PETSC_INFINITY)
      PetscCall(PetscViewerASCIIPrintf(viewer, "; dt = %.3g of that of waves (%.3g s)",
                                       (double)(flow->clock->dt / limit), (double)limit));
    PetscCall(PetscViewerASCIIPrintf(viewer, "\n"));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode BannerStages(const Scheme *scheme, PetscViewer viewer)
{
  PetscFunctionBegin;
  PetscCall(PetscViewerASCIIPrintf(viewer, BANNER_LABEL, "step"));
  for (PetscInt k = 0; k < scheme->n_stages; k++)
    PetscCall(PetscViewerASCIIPrintf(viewer, "%s%s", k ? ", " : "", scheme->stage[k]->name));
  PetscCall(PetscViewerASCIIPrintf(viewer, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the forms of the discretisation in space. */
static PetscErrorCode BannerForms(const Flow *flow, PetscViewer viewer)
{
  const Operators *ops = flow->ops;

  PetscFunctionBegin;
  PetscCall(TableViewRow("scheme", flow->scheme->row, viewer));
  PetscCall(BannerStages(flow->scheme, viewer));
  PetscCall(TableViewRow("motion", flow->scene->motion, viewer));
  PetscCall(TableViewRow("shift", flow->state->shift, viewer));
  PetscCall(TableViewRow("kernel", ops->forms.kernel, viewer));
  PetscCall(TableViewRow("visc lap.", ops->forms.visc.row, viewer));
  PetscCall(TableViewRow("ppe lap.", ops->forms.ppe.row, viewer));
  PetscCall(TableViewRow("correction", ops->forms.visc.correction, viewer));
  if (!ops->forms.visc.correction)
    PetscCall(TableViewRow("correction", ops->forms.ppe.correction, viewer));
  PetscCall(TableViewRow("gradient", FlowGradient(flow), viewer));
  PetscCall(TableViewRow("wall", ops->forms.wall, viewer));
  if (ops->forms.wall_surface)
    PetscCall(PetscViewerASCIIPrintf(
        viewer, BANNER_LABEL "a layer of particles before the dummies\n", "on the wall"));
  PetscCall(BannerThinBodies(flow, viewer));
  PetscCall(BannerGap(flow->scene, viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the lines of the scheme, then its linear solves; an explicit step has none. */
static PetscErrorCode BannerScheme(const Flow *flow, PetscViewer viewer)
{
  const Scheme *scheme = flow->scheme;

  PetscFunctionBegin;
  PetscCall(scheme->row->View(flow, viewer));
  for (PetscInt k = 0; k < scheme->n_solves; k++) {
    const LinearSolve *solve = scheme->solve[k];
    const char        *ksp, *pc;

    if (!solve->ksp) continue;
    PetscCall(SolverNames(solve->ksp, &ksp, &pc));
    PetscCall(PetscViewerASCIIPrintf(viewer, BANNER_LABEL "KSP %s, PC %s\n", solve->label, ksp,
                                     pc ? pc : "none"));
    if (solve->note[0])
      PetscCall(PetscViewerASCIIPrintf(viewer, BANNER_LABEL "%s\n", "unwise", solve->note));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* BannerView - Prints the choices of the run before its first step. Collective on the viewer.
   Called when all options are read and the clock has chosen the length of the first step. Input:
   need - memory, of MachineMemoryCheck(). */
PetscErrorCode BannerView(const Flow *flow, const MachineMemory *need, PetscViewer viewer)
{
  PetscFunctionBegin;
  PetscCall(BannerCase(flow, viewer));
  PetscCall(PetscViewerASCIIPrintf(
      viewer, BANNER_LABEL "about %.3g GB of the machine's %.3g GB, %.3g kB a particle\n", "memory",
      (double)(1e-9 * need->run), (double)(1e-9 * need->machine), (double)(1e-3 * need->particle)));
  PetscCall(BannerViscosity(flow->scene, viewer));
  PetscCall(BannerPhysics(flow->scene, viewer));
  PetscCall(RegimeView(flow->scene->regime, viewer));
  PetscCall(BannerTime(flow, viewer));
  PetscCall(BannerTension(flow, viewer));
  PetscCall(BannerFluids(flow, viewer));
  PetscCall(BannerForms(flow, viewer));
  PetscCall(BannerScheme(flow, viewer));
  PetscCall(PetscViewerASCIIPrintf(viewer, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}
