/*
  The first lines of a run: what is computed, with what, by whose formulas, what was left out, and
  whether implicit viscosity pays.
*/
#include "isph/io.h"

#define BANNER_LABEL "%-11s "

/* Case, fluid and particles. */
static PetscErrorCode BannerCase(const Flow *flow, PetscViewer viewer)
{
  const Scene   *scene = flow->scene;
  const CaseRow *row   = scene->problem;
  PetscMPIInt    ranks;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &ranks));
  PetscCall(PetscViewerASCIIPrintf(
      viewer, "isph %s, incompressible viscous SPH on PETSc %d.%d.%d\n", ISPH_VERSION,
      PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR));
  PetscCall(PetscViewerASCIIPrintf(viewer, BANNER_LABEL "%s: %s", "case", row->name, row->brief));
  if (row->citation[0]) PetscCall(PetscViewerASCIIPrintf(viewer, " [%s]", row->citation));
  PetscCall(
      PetscViewerASCIIPrintf(viewer, "\n" BANNER_LABEL "%" PetscInt_FMT "D, ", "flow", scene->dim));
  if (SceneHas(scene, PHYSICS_VISCOSITY)) {
    PetscCall(PetscViewerASCIIPrintf(viewer, "Re = %.6g, nu = %.6g m^2/s, ",
                                     (double)SceneReynolds(scene), (double)scene->nu));
  }
  PetscCall(PetscViewerASCIIPrintf(viewer, "L = %.4g m, U = %.4g m/s\n", (double)scene->length,
                                   (double)scene->speed));
  PetscCall(PetscViewerASCIIPrintf(
      viewer,
      BANNER_LABEL "%" PetscInt_FMT " fluid + %" PetscInt_FMT " wall, dx = %.4g m, h/dx = %.3g; "
                   "%d rank%s\n",
      "particles", flow->particles->N_fluid, flow->particles->N_wall, (double)scene->dx,
      (double)(flow->ops->h / scene->dx), ranks, ranks == 1 ? "" : "s"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One chosen row; what it is where that fits the line; nothing where the run has none. */
static PetscErrorCode BannerRow(const char label[], const void *row, PetscViewer viewer)
{
  const TableRow *r = row;
  char            line[512];
  size_t          length;

  PetscFunctionBegin;
  if (!r) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(line, sizeof(line), BANNER_LABEL "%s: %s%s%s%s", label, r->name, r->brief,
                          r->citation[0] ? " [" : "", r->citation, r->citation[0] ? "]" : ""));
  PetscCall(PetscStrlen(line, &length));
  if (length > 100 && r->citation[0]) {
    PetscCall(
        PetscSNPrintf(line, sizeof(line), BANNER_LABEL "%s [%s]", label, r->name, r->citation));
  }
  PetscCall(PetscViewerASCIIPrintf(viewer, "%s\n", line));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where the viscosity varies: by how much, and what pairs of particles make of it. */
static PetscErrorCode BannerViscosity(const Scene *scene, PetscViewer viewer)
{
  PetscFunctionBegin;
  if (!SceneViscosityVaries(scene)) PetscFunctionReturn(PETSC_SUCCESS);
  if (!SceneIsNewtonian(scene)) PetscCall(BannerRow("rheology", scene->rheology.row, viewer));
  PetscCall(PetscViewerASCIIPrintf(
      viewer, BANNER_LABEL "nu from %.4g to %.4g m^2/s, harmonic means of pairs; Re is of %.4g\n",
      "varies", (double)scene->nu_low, (double)scene->nu_high, (double)scene->nu));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Bodies through which fluid sees fluid: an operator knows distances, not what is in between. */
static PetscErrorCode BannerThinBodies(const Flow *flow, PetscViewer viewer)
{
  const Scene *scene = flow->scene;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < scene->n_bodies; k++) {
    PetscReal       place[2];
    const PetscReal reach = flow->ops->radius,
                    thin  = BodyThickness(&scene->bodies[k], scene->dx, reach, place);

    if (thin >= reach) continue;
    PetscCall(PetscViewerASCIIPrintf(
        viewer,
        BANNER_LABEL "body %" PetscInt_FMT " is %.2g dx thick at (%.4g, %.4g); fluid on its two "
                     "sides is not kept apart below the kernel's %.2g dx, use a larger -n\n",
        "thin", k + 1, (double)(thin / scene->dx), (double)place[0], (double)place[1],
        (double)(reach / scene->dx)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What is computed, and what of the program is left out. */
static PetscErrorCode BannerPhysics(const Scene *scene, PetscViewer viewer)
{
  char names[2][128] = {"", ""}; /* left out, active */

  PetscFunctionBegin;
  for (PetscInt k = 0; k < PHYSICS_COUNT; k++) {
    char *list = names[SceneHas(scene, (Physics)(1u << k)) ? 1 : 0];

    if (list[0]) PetscCall(PetscStrlcat(list, ", ", sizeof(names[0])));
    PetscCall(PetscStrlcat(list, PhysicsNames[k], sizeof(names[0])));
  }
  PetscCall(PetscViewerASCIIPrintf(viewer, BANNER_LABEL "%s; left out: %s\n", "physics", names[1],
                                   names[0][0] ? names[0] : "nothing"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Whether implicit viscosity pays: it allows steps up to the advective limit, the default CFL
  number, explicit viscosity those up to dt_explicit. A solve costs about as much as one more step,
  and steps of less than twice dt_explicit do not pay for it (docs/results/implicit.md).
*/
static PetscErrorCode BannerPays(const Flow *flow, PetscReal dt, PetscReal dt_explicit,
                                 PetscViewer viewer)
{
  const Scene    *scene  = flow->scene;
  const PetscReal advect = CLOCK_CFL * scene->dx / scene->speed;
  const PetscBool explicit =
      flow->scheme->visc && ViscosityIntegrator(flow->scheme->visc)->kind == TIME_EXPLICIT;

  PetscFunctionBegin;
  PetscCall(PetscViewerASCIIPrintf(viewer, BANNER_LABEL "dt = %.3g dt_explicit (%.3g s): ",
                                   "viscosity", (double)(dt / dt_explicit), (double)dt_explicit));
  if (explicit && dt > dt_explicit) {
    PetscCall(PetscViewerASCIIPrintf(viewer, "too long for explicit viscosity\n"));
  } else if (!SceneHas(scene, PHYSICS_CONVECTION)) {
    PetscCall(PetscViewerASCIIPrintf(
        viewer, "nothing is advected, accuracy alone limits implicit steps\n"));
  } else if (advect > 2.0 * dt_explicit) {
    PetscCall(PetscViewerASCIIPrintf(viewer,
                                     "implicit pays here, advection allows %.3g dt_explicit\n",
                                     (double)(advect / dt_explicit)));
  } else {
    PetscCall(PetscViewerASCIIPrintf(
        viewer, "implicit does not pay here, advection allows %.2g dt_explicit\n",
        (double)(advect / dt_explicit)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where steps are so long against diffusion that splitting velocity from pressure limits them. */
static PetscErrorCode BannerSplitting(const Flow *flow, PetscReal dt, PetscViewer viewer)
{
  const Scene    *scene  = flow->scene;
  const PetscReal number = scene->nu * dt / PetscSqr(scene->length);

  PetscFunctionBegin;
  if (!flow->scheme->projection || number <= 0.02) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscViewerASCIIPrintf(viewer,
                                   BANNER_LABEL
                                   "nu dt/L^2 = %.2g: first order in dt until the flow "
                                   "is steady; -scheme coupled has no such error\n",
                                   "splitting", (double)number));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Where particles may not be able to go so far in a step: the cavity ended at CFL numbers of 1 and
  more where viscosity does not smooth the grid scale (studies/stability).
*/
static PetscErrorCode BannerAdvection(const Flow *flow, PetscReal dt, PetscViewer viewer)
{
  const Scene    *scene = flow->scene;
  const PetscReal R = SceneCellReynolds(scene), cfl = scene->speed * dt / scene->dx;

  PetscFunctionBegin;
  if (!SceneMoves(scene) || R <= 20.0 || cfl <= 0.5) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscViewerASCIIPrintf(viewer,
                                   BANNER_LABEL
                                   "U dx/nu = %.3g: moving particles may not hold beyond a CFL "
                                   "number of 0.5; -dt_adapt retry shortens steps that fail\n",
                                   "advection", (double)R));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The time step and its limits. */
static PetscErrorCode BannerTime(const Flow *flow, PetscViewer viewer)
{
  const Scene    *scene = flow->scene;
  const PetscReal dt = flow->clock->dt, h = flow->ops->h;

  PetscFunctionBegin;
  if (flow->clock->steady_solve) {
    PetscCall(PetscViewerASCIIPrintf(viewer, BANNER_LABEL "none: the steady flow\n", "time"));
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
  PetscCall(BannerAdvection(flow, dt, viewer));
  if (flow->scheme->visc || flow->scheme->coupled) {
    PetscCall(BannerPays(flow, dt, ClockExplicitLimit(scene, flow->ops->radius), viewer));
    PetscCall(BannerSplitting(flow, dt, viewer));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The forms of space, then those of time. */
static PetscErrorCode BannerForms(const Flow *flow, PetscViewer viewer)
{
  const Operators *ops    = flow->ops;
  const Scheme    *scheme = flow->scheme;

  PetscFunctionBegin;
  PetscCall(BannerRow("scheme", scheme->row, viewer));
  PetscCall(BannerRow("projection", scheme->projection, viewer));
  PetscCall(BannerRow("motion", flow->scene->motion, viewer));
  if (SceneMoves(flow->scene)) PetscCall(BannerRow("shift", scheme->shift, viewer));
  PetscCall(BannerRow("kernel", ops->kernel, viewer));
  PetscCall(BannerRow("visc lap.", ops->visc_form.row, viewer));
  PetscCall(BannerRow("ppe lap.", ops->ppe_form.row, viewer));
  PetscCall(BannerRow("correction", ops->visc_form.correction, viewer));
  if (!ops->visc_form.correction)
    PetscCall(BannerRow("correction", ops->ppe_form.correction, viewer));
  PetscCall(BannerRow("gradient", ops->gradient, viewer));
  PetscCall(BannerRow("wall", ops->wall, viewer));
  if (ops->wall_surface)
    PetscCall(PetscViewerASCIIPrintf(viewer, BANNER_LABEL "particles, before those behind\n",
                                     "on the wall"));
  PetscCall(BannerThinBodies(flow, viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* How the linear systems are solved; what is not solved for has no line. */
static PetscErrorCode BannerSolver(const char label[], const char ksp[], const char pc[],
                                   PetscViewer viewer)
{
  PetscFunctionBegin;
  if (ksp) {
    PetscCall(PetscViewerASCIIPrintf(viewer, BANNER_LABEL "KSP %s, PC %s\n", label, ksp,
                                     pc ? pc : "none"));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What is legal but unwise. */
static PetscErrorCode BannerNote(const char note[], PetscViewer viewer)
{
  PetscFunctionBegin;
  if (note[0]) PetscCall(PetscViewerASCIIPrintf(viewer, BANNER_LABEL "%s\n", "unwise", note));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode BannerSolvers(const Flow *flow, PetscViewer viewer)
{
  const Scheme *scheme = flow->scheme;
  const char   *ts = NULL, *ksp = NULL, *pc = NULL, *snes = NULL, *search = NULL;

  PetscFunctionBegin;
  if (scheme->visc) {
    PetscCall(BannerRow("visc TS", ViscosityIntegrator(scheme->visc), viewer));
    PetscCall(ViscosityNames(scheme->visc, &ts, &ksp, &pc));
    PetscCall(ViscosityIteration(scheme->visc, &snes, &search));
    if (snes)
      PetscCall(PetscViewerASCIIPrintf(viewer, BANNER_LABEL "SNES %s, line search %s\n",
                                       "nonlinear", snes, search));
    PetscCall(BannerSolver("visc solver", ksp, pc, viewer));
    PetscCall(BannerNote(ViscosityNote(scheme->visc), viewer));
  }
  if (scheme->coupled) {
    if (!flow->clock->steady_solve)
      PetscCall(BannerRow("coupled TS", CoupledIntegrator(scheme->coupled), viewer));
    PetscCall(CoupledNames(scheme->coupled, &ts, &ksp, &pc));
    PetscCall(BannerSolver("solver", ksp, pc, viewer));
    PetscCall(BannerRow("schur", CoupledSchur(scheme->coupled), viewer));
    PetscCall(BannerNote(CoupledNote(scheme->coupled), viewer));
  }
  if (scheme->ppe) {
    PetscCall(PressureNames(scheme->ppe, &ksp, &pc));
    PetscCall(BannerSolver("ppe solver", ksp, pc, viewer));
    PetscCall(BannerNote(PressureNote(scheme->ppe), viewer));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  BannerView - Prints what the run is going to do

  Collective on the viewer. Called when all is configured and the Clock has chosen its first step.
*/
PetscErrorCode BannerView(const Flow *flow, PetscViewer viewer)
{
  PetscFunctionBegin;
  PetscCall(BannerCase(flow, viewer));
  PetscCall(BannerViscosity(flow->scene, viewer));
  PetscCall(BannerPhysics(flow->scene, viewer));
  PetscCall(BannerTime(flow, viewer));
  PetscCall(BannerForms(flow, viewer));
  PetscCall(BannerSolvers(flow, viewer));
  PetscCall(PetscViewerASCIIPrintf(viewer, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}
