/* Runs a patch test: sets a field on particles in a box and around it, compares the Laplacian of a
   form with the exact Laplacian, and measures its cost. */
#include "isph/start.h"
#include "isph/patch.h"

/* Prints the banner of a patch test. */
static PetscErrorCode PatchBanner(const Patch *patch)
{
  const Scene         *scene = patch->scene;
  const LaplacianForm *form  = &patch->ops->forms.visc;
  const PetscViewer    out   = PETSC_VIEWER_STDOUT_WORLD;

  PetscFunctionBegin;
  PetscCall(PetscViewerASCIIPrintf(out, "isph %s, patch test: no flow\n", ISPH_VERSION));
  PetscCall(
      PetscViewerASCIIPrintf(out, "field       %s: %s\n", patch->field->name, patch->field->brief));
  PetscCall(PetscViewerASCIIPrintf(out,
                                   "particles   %" PetscInt_FMT "D, %" PetscInt_FMT
                                   " measured + %" PetscInt_FMT
                                   " around them, dx = %.4g, jitter %.3g dx\n",
                                   scene->dim, patch->particles->N_fluid, patch->particles->N_wall,
                                   (double)scene->dx, (double)scene->jitter));
  PetscCall(PetscViewerASCIIPrintf(out, "kernel      %s, h/dx = %.4g\n",
                                   patch->ops->forms.kernel->name,
                                   (double)(patch->ops->forms.h_over_dx)));
  PetscCall(PetscViewerASCIIPrintf(out, "form        %s: %s\n", form->row->name, form->row->brief));
  PetscCall(PetscViewerASCIIPrintf(out, "correction  %s\n", OperatorsCorrection(patch->ops)));
  if (patch->ops->regularised_rows) {
    PetscCall(PetscViewerASCIIPrintf(
        out, "regularised %" PetscInt_FMT " rows whose neighbours do not determine the form\n",
        patch->ops->regularised_rows));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

enum { FIELD, REPEATS, SPECTRUM, SOLVE };
static const OptionRow options[] = {
    [FIELD] = OPTION(NAME, "-patch_field", "field that the operators are applied to", NULL, "mixed",
                     .table = &FieldTable, .where = "-case patch"),
    [REPEATS] =
        OPTION(INT, "-patch_repeats", "repetitions of timed work; the least time is reported", NULL,
               "3", .expert = PETSC_TRUE, .low = 1, .high = 1000, .where = "-case patch"),
    [SPECTRUM] =
        OPTION(SWITCH, "-patch_spectrum", "report eigenvalues and the condition number of -L", NULL,
               "false", .where = "-case patch"),
    [SOLVE] = OPTION(SWITCH, "-patch_solve",
                     "solve a Poisson problem with L, by the solver with prefix ppe_", NULL,
                     "false", .where = "-case patch"),
};
const OptionTable PatchOptions = OPTIONS("Patch test", options);

static PetscErrorCode PatchReadOptions(Patch *patch)
{
  PetscFunctionBegin;
  PetscCall(OptionGetRow(&options[FIELD], NULL, &patch->field));
  PetscCall(OptionGetInt(&options[REPEATS], &patch->repeats, NULL));
  PetscCall(OptionGetSwitch(&options[SPECTRUM], &patch->spectrum, NULL));
  PetscCall(OptionGetSwitch(&options[SOLVE], &patch->solve, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the field inside and around the box, and its exact Laplacian. */
static PetscErrorCode PatchSetField(Patch *patch)
{
  const Particles *p     = patch->particles;
  const FieldRow  *field = patch->field;
  const PetscInt   dim = patch->scene->dim, seed = patch->scene->seed;
  PetscReal       *f, *around, *exact, x[ISPH_MAX_DIM];

  PetscFunctionBegin;
  PetscCall(FluidVec(p, NULL, &patch->f));
  PetscCall(FluidVec(p, NULL, &patch->exact));
  PetscCall(WallVec(p, &patch->f_around));
  PetscCall(VecGetArray(patch->f, &f));
  PetscCall(VecGetArray(patch->exact, &exact));
  PetscCall(VecGetArray(patch->f_around, &around));
  for (PetscInt i = 0; i < ParticlesOwn(p); i++) {
    for (PetscInt a = 0; a < dim; a++) x[a] = p->x[a][i];
    if (i < p->n_fluid) {
      f[i]     = field->Value(field, dim, seed, x);
      exact[i] = field->Laplacian(field, dim, seed, x);
    } else {
      around[i - p->n_fluid] = field->Value(field, dim, seed, x);
    }
  }
  PetscCall(VecRestoreArray(patch->f, &f));
  PetscCall(VecRestoreArray(patch->exact, &exact));
  PetscCall(VecRestoreArray(patch->f_around, &around));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the truncation error L f - lap f in three relative norms, and zheng_err, the relative L1
   norm divided by the number of particles, as Zheng, Ma & Shao (2018) print it. If the exact lap f
   is zero, the error is absolute, in units of the field divided by the square of the side. */
static PetscErrorCode PatchCompare(const Patch *patch, Vec lap, Report *report)
{
  const NormType    type[3] = {NORM_1, NORM_2, NORM_INFINITY};
  const char *const name[3] = {"laplacian_l1", "laplacian_l2", "laplacian_linf"};
  PetscReal         l1      = 0.0;
  Vec               error;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(lap, &error));
  PetscCall(VecWAXPY(error, -1.0, patch->exact, lap));
  for (PetscInt k = 0; k < 3; k++) {
    PetscReal e, scale;

    PetscCall(VecNorm(error, type[k], &e));
    PetscCall(VecNorm(patch->exact, type[k], &scale));
    if (scale > 0.0) e /= scale;
    else if (type[k] == NORM_1) e /= (PetscReal)patch->particles->N_fluid;
    else if (type[k] == NORM_2) e /= PetscSqrtReal((PetscReal)patch->particles->N_fluid);
    if (type[k] == NORM_1) l1 = e;
    PetscCall(ReportAddError(report, name[k], e));
  }
  PetscCall(ReportAddError(report, "zheng_err", l1 / (PetscReal)patch->particles->N_fluid));
  PetscCall(VecDestroy(&error));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Assembles and applies the Laplacian L repeatedly; reports its error and the least times. */
static PetscErrorCode PatchMeasure(Patch *patch, Report *report)
{
  PetscReal assemble = PETSC_MAX_REAL, apply = PETSC_MAX_REAL;
  Vec       lap;

  PetscFunctionBegin;
  PetscCall(FluidVec(patch->particles, NULL, &lap));
  for (PetscInt k = 0; k < patch->repeats; k++) {
    PetscLogDouble start, assembled, applied;
    PetscBool      changed;

    PetscCall(ParticlesUpdateHalo(patch->particles)); /* marks positions as new */
    PetscCall(PetscTime(&start));
    PetscCall(
        OperatorsAssemble(patch->scene, patch->particles, patch->neighbors, patch->ops, &changed));
    PetscCall(PetscTime(&assembled));
    PetscCall(AffineApply(&patch->ops->velocity[0].visc, patch->f, patch->f_around, lap));
    PetscCall(PetscTime(&applied));
    assemble = PetscMin(assemble, assembled - start);
    apply    = PetscMin(apply, applied - assembled);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &assemble, 1, MPIU_REAL, MPIU_MAX, PETSC_COMM_WORLD));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &apply, 1, MPIU_REAL, MPIU_MAX, PETSC_COMM_WORLD));
  PetscCall(PatchCompare(patch, lap, report));
  PetscCall(ReportAdd(report, "assemble_s", assemble));
  PetscCall(ReportAdd(report, "apply_s", apply));
  PetscCall(VecDestroy(&lap));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PatchCreate(Scene *scene, Patch *patch)
{
  WallPlacement around;

  PetscFunctionBegin;
  patch->scene = scene;
  PetscCall(OperatorsCreate(scene, NEED_VISCOSITY | NEED_MATRICES, &patch->ops));
  PetscCall(PatchReadOptions(patch));
  PetscCall(OperatorsPlacement(scene, patch->ops, &around));
  PetscCall(ParticlesCreate(scene, patch->ops->forms.reach, &patch->particles));
  PetscCall(ParticlesFill(scene, around, NULL, patch->particles));
  PetscCall(NeighborsCreate(patch->ops->forms.radius, SceneCoarsest(scene), &patch->neighbors));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PatchDestroy(Patch *patch)
{
  PetscFunctionBegin;
  PetscCall(VecDestroyAll(&patch->f, &patch->f_around, &patch->exact));
  PetscCall(NeighborsDestroy(&patch->neighbors));
  PetscCall(ParticlesDestroy(&patch->particles));
  PetscCall(OperatorsDestroy(&patch->ops));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PatchRun - Runs a patch test from its scene to its report; collective on PETSC_COMM_WORLD. Notes:
   lengths are in units of the side of the square or cube. */
PetscErrorCode PatchRun(Scene *scene)
{
  Patch          patch = {0};
  Report        *report;
  Flow           flow = {.scene = scene};
  PetscBool      changed, wants_help;
  PetscLogDouble start, end;

  PetscFunctionBegin;
  PetscCall(PetscTime(&start));
  PetscCall(PatchCreate(scene, &patch));
  PetscCall(ReportCreate(&report));
  PetscCall(OptionGiven("-help", &wants_help));
  if (!wants_help) {
    if (!patch.solve) PetscCall(OptionsRefuseUnknown(PETSC_FALSE));
    PetscCall(NeighborsUpdate(patch.particles, 0.0, patch.neighbors));
    PetscCall(OperatorsAssemble(scene, patch.particles, patch.neighbors, patch.ops, &changed));
    PetscCall(PatchBanner(&patch));
    PetscCall(PatchSetField(&patch));
    PetscCall(PatchMeasure(&patch, report));
    PetscCall(PatchStructure(&patch, report));
    if (patch.spectrum) PetscCall(PatchSpectrum(&patch, report));
    if (patch.solve) PetscCall(PatchSolve(&patch, report));
    PetscCall(OptionsRefuseUnknown(PETSC_TRUE));
    PetscCall(PetscTime(&end));
    flow.particles = patch.particles;
    flow.neighbors = patch.neighbors;
    flow.ops       = patch.ops;
    PetscCall(ReportView(report, end - start, PETSC_VIEWER_STDOUT_WORLD));
    PetscCall(ReportWrite(&flow, report, end - start, "ok"));
    PetscCall(ReportCheck(report));
  }
  PetscCall(ReportDestroy(&report));
  PetscCall(PatchDestroy(&patch));
  PetscFunctionReturn(PETSC_SUCCESS);
}
