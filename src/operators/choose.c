/* Choice of the discretisation in space. Options select table rows, the declared properties of
   forms decide the defaults, and combinations that cannot work are refused. */
#include "choose.h"
#include "isph/strain.h"
#include "rows/rows.h"

enum {
  KERNEL,
  MLS_DEGREE,
  H_OVER_DX,
  CORRECTION,
  VISC_LAPLACIAN,
  CLEARY_XI,
  PPE_LAPLACIAN,
  GRADIENT,
  WALL,
  WALL_SURFACE
};
static const OptionRow options[] = {
    [KERNEL] =
        OPTION(NAME, "-kernel", "smoothing kernel", NULL, "wendland_c2", .table = &KernelTable),
    [MLS_DEGREE] =
        OPTION(INT, "-mls_degree",
               "degree of the polynomials of least-squares fits, in all operators named mls", "-",
               "2", .low = 2, .high = MLS_MAX_DEGREE),
    [H_OVER_DX]  = OPTION(REAL, "-h_over_dx", "smoothing length over particle spacing", "-", REGIME,
                          .low = 0.8, .high = 4.0),
    [CORRECTION] = OPTION(
        NAME, "-correction",
        "correction of the kernel in Laplacians that accept it, and in all sums of -scheme wcsph",
        NULL, REGIME, .expert = PETSC_TRUE, .table = &CorrectionTable),
    [VISC_LAPLACIAN] = OPTION(NAME, "-visc_laplacian", "form of the viscous term", NULL, REGIME,
                              .table = &LaplacianTable, .where = "runs with viscosity"),
    [CLEARY_XI]      = OPTION(REAL, "-cleary_xi",
                              "factor xi of the form cleary; published are 4.96333 and "
                                   "4.24",
                              "-", "dimension + 2", .expert = PETSC_TRUE, POSITIVE,
                              .where = "-visc_laplacian cleary"),
    [PPE_LAPLACIAN] =
        OPTION(NAME, "-ppe_laplacian", "form of the Laplacian in the pressure Poisson equation",
               NULL, "mls", .table = &LaplacianTable,
               .where = "flows with pressure, except -pressure_points coarse"),
    [GRADIENT]     = OPTION(NAME, "-gradient", "form of gradients and divergences", NULL, "mls",
                            .table = &GradientTable,
                            .where = "flows with pressure, or convection on fixed particles"),
    [WALL]         = OPTION(NAME, "-wall", "wall treatment", NULL, REGIME, .table = &WallTable,
                            .where = "flows with walls"),
    [WALL_SURFACE] = OPTION(SWITCH, "-wall_surface",
                            "a layer of particles on the walls, before the layers behind them, "
                            "which alone leave a gap at curved walls",
                            NULL, "true with bodies, if -wall has particles behind walls",
                            .expert = PETSC_TRUE, .where = "flows with walls"),
};
const OptionTable OperatorOptions = OPTIONS("Operators", options);

static PetscErrorCode ChooseLaplacian(const OptionRow *option, const char standard[],
                                      const OperatorForms *forms, LaplacianForm *form)
{
  const CorrectionRow *correction = forms->correction;

  PetscFunctionBegin;
  PetscCall(OptionGetRow(option, standard, &form->row));
  if (form->row->corrections & correction->bit) form->correction = correction;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the factor of the form cleary, whose weights are those of the factor dim + 2. */
static PetscErrorCode ChooseClearyFactor(const Scene *scene, LaplacianForm *form)
{
  PetscReal xi = (PetscReal)scene->dim + 2.0;

  PetscFunctionBegin;
  if (form->row->Row != LaplacianRow_Cleary) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(OptionGetReal(&options[CLEARY_XI], &xi, NULL));
  form->scale = xi / ((PetscReal)scene->dim + 2.0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Chooses the Laplacians that the run needs; the correction applies to those that accept it. */
static PetscErrorCode ChooseLaplacians(const Scene *scene, unsigned needs, OperatorForms *forms)
{
  const CorrectionRow *correction;

  PetscFunctionBegin;
  PetscCall(OptionGetRow(&options[CORRECTION], RegimeWord(scene->regime, REGIME_CORRECTION),
                         &correction));
  forms->correction = correction;
  if (needs & NEED_VISCOSITY || (needs & NEED_STREAMS && SceneHas(scene, PHYSICS_VISCOSITY))) {
    PetscCall(ChooseLaplacian(&options[VISC_LAPLACIAN], RegimeWord(scene->regime, REGIME_LAPLACIAN),
                              forms, &forms->visc));
    PetscCall(ChooseClearyFactor(scene, &forms->visc));
    UserCheck(!SceneViscosityVaries(scene) || LaplacianIs(&forms->visc, FORM_VARYING),
              "-visc_laplacian %s: this form has no varying viscosity; use a form with "
              "varying_viscosity in -catalogue, such as mls or schwaiger",
              forms->visc.row->name);
    UserCheck(!forms->visc.row->composed || needs & NEED_STREAMS,
              "-visc_laplacian %s: its two passes are for the explicit steps of -scheme wcsph; use "
              "pairwise_stress or cleary, whose forces keep momentum too",
              forms->visc.row->name);
  }
  if (needs & NEED_PRESSURE) {
    PetscCall(ChooseLaplacian(&options[PPE_LAPLACIAN], NULL, forms, &forms->ppe));
    UserCheck(!LaplacianIs(&forms->ppe, FORM_COUPLES),
              "-ppe_laplacian %s: this form couples velocity components; use mls instead",
              forms->ppe.row->name);
    UserCheck(
        LaplacianIs(&forms->ppe, FORM_SAFE_IMPLICIT),
        "-ppe_laplacian %s: its matrix has eigenvalues of both signs, so the pressure equation "
        "cannot be solved; use a form with safe_implicit in -catalogue, such as mls or morris",
        forms->ppe.row->name);
  }
  UserCheck(!correction->Kernel || forms->visc.correction || forms->ppe.correction ||
                needs & NEED_STREAMS,
            "-correction %s: no chosen Laplacian accepts it; -catalogue lists the forms that do",
            correction->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Chooses the wall treatment from the options; the default works with all chosen forms. */
static PetscErrorCode ChooseWall(const Scene *scene, unsigned needs, OperatorForms *forms)
{
  const char *blind = NULL; /* a chosen form that needs particles behind walls */
  const char *kind  = "";

  PetscFunctionBegin;
  if (scene->problem->patch) {
    forms->wall = &WallGiven;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (needs & NEED_STREAMS) {
    blind = "wcsph";
    kind  = "-scheme";
  } else if (forms->visc.row && LaplacianIs(&forms->visc, FORM_FULL_SUPPORT)) {
    blind = forms->visc.row->name;
    kind  = "-visc_laplacian";
  }
  if (forms->ppe.row && LaplacianIs(&forms->ppe, FORM_FULL_SUPPORT)) {
    blind = forms->ppe.row->name;
    kind  = "-ppe_laplacian";
  }
  if (forms->gradient && (forms->gradient->properties & FORM_FULL_SUPPORT)) {
    blind = forms->gradient->name;
    kind  = "-gradient";
  }
  RegimeSetFact(scene->regime, FACT_BLIND, blind ? PETSC_TRUE : PETSC_FALSE);
  PetscCall(OptionGetRow(&options[WALL], RegimeWord(scene->regime, REGIME_WALL), &forms->wall));
  UserCheck(
      !blind || !forms->wall->on_surface,
      "-wall %s: %s %s needs particles behind the wall; use -wall dummy_linear, or mls instead",
      forms->wall->name, kind, blind);
  UserCheck((needs & NEED_STREAMS) || !forms->wall->dynamic,
            "-wall %s: only -scheme wcsph gives walls a density; use dummy_linear or wall_layer",
            forms->wall->name);
  forms->wall_surface = scene->n_bodies > 0 && !forms->wall->on_surface;
  PetscCall(OptionGetSwitch(&options[WALL_SURFACE], &forms->wall_surface, NULL));
  UserCheck(
      !forms->wall_surface || !forms->wall->on_surface,
      "-wall_surface: -wall %s has its particles on the wall already; choose a treatment with "
      "particles behind it, such as dummy_linear",
      forms->wall->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if both Laplacians are exact for quadratic functions. */
static PetscBool AreExact(const OperatorForms *forms)
{
  return forms->visc.row && LaplacianIs(&forms->visc, FORM_EXACT_QUADRATIC) &&
         (!forms->ppe.row || LaplacianIs(&forms->ppe, FORM_EXACT_QUADRATIC));
}

/* Sets visc_is_laplacian and components_coupled, and refuses options that coupled components
   exclude. */
static PetscErrorCode ChooseCoupling(const Scene *scene, OperatorForms *forms)
{
  const PetscBool couple = forms->visc.row && LaplacianIs(&forms->visc, FORM_COUPLES);

  PetscFunctionBegin;
  forms->visc_is_laplacian  = !couple && !SceneViscosityVaries(scene);
  forms->components_coupled = couple || !SceneIsNewtonian(scene);
  UserCheck(!couple || !scene->problem->patch,
            "-visc_laplacian %s: a patch test has a scalar field; use a form that does not couple "
            "components",
            forms->visc.row->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses boundaries with other equations than walls, such as planes of symmetry, if the chosen
   forms cannot satisfy them. */
static PetscErrorCode RefuseEquations(const Scene *scene, const OperatorForms *forms)
{
  const BoundaryRow *kind = SceneFitKind(scene);

  PetscFunctionBegin;
  if (!kind) PetscFunctionReturn(PETSC_SUCCESS);
  UserCheck(forms->wall->on_surface,
            "%s: its equations are those of fits, and -wall %s has none; use -wall wall_layer and "
            "forms without full_support in -catalogue, such as mls",
            kind->option.name, forms->wall->name);
  UserCheck(!forms->components_coupled || forms->visc.row->weak,
            "%s: each velocity component has equations of its own there, and %s couples them; use "
            "a newtonian fluid and -visc_laplacian mls",
            kind->option.name, SceneIsNewtonian(scene) ? forms->visc.row->name : "-rheology");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses pressures of outflows other than that outside the surface, whose cells end at outflows
   without traction. */
static PetscErrorCode RefuseOutflows(const Scene *scene)
{
  const PetscReal origin[ISPH_MAX_DIM] = {0.0};

  PetscFunctionBegin;
  for (PetscInt side = 0; side < 2 * scene->dim; side++) {
    const Expression *pressure = &scene->boundary[side].pressure;

    if (!BoundaryIs(scene, side, BOUNDARY_OUTFLOW)) continue;
    UserCheck(!ExpressionUses(pressure, ~0u) &&
                  ExpressionValue(pressure, 0, 0.0, origin) == scene->outside,
              "-scene_outflow_%s_pressure: with a free surface it must be that outside, "
              "-surface_pressure %g",
              BoxSides[side], (double)scene->outside);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses contact angles of surfaces that have none, and forms whose walls do not slip. */
static PetscErrorCode RefuseContacts(const Scene *scene, const OperatorForms *forms)
{
  const LaplacianRow *visc = forms->visc.row;

  PetscFunctionBegin;
  for (PetscInt side = 0; side < 2 * scene->dim; side++) {
    UserCheck(scene->boundary[side].slip == 0.0 || (visc && visc->weak),
              "-scene_wall_%s_slip: walls of -visc_laplacian %s have no friction; use weak_stress",
              BoxSides[side], visc ? visc->name : "(none)");
    UserCheck(scene->boundary[side].contact == 0.0 || scene->tension > 0.0,
              "-scene_wall_%s_angle: only a free surface with a tension has contact angles; give "
              "-surface_tension",
              BoxSides[side]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses a tension that varies without a free surface that has one, and a tension between fluids
   below a free surface: the planes that particles carry move otherwise than facets do, and the flow
   is lost in noise. */
static PetscErrorCode RefuseTension(const Scene *scene)
{
  PetscFunctionBegin;
  UserCheck(
      !scene->tension_field.n || scene->tension > 0.0,
      "-surface_tension_field: give its largest value as -surface_tension, and a free surface "
      "by -scene_free or -scene_filled_1");
  for (PetscInt k = 0; k < scene->n_regions && SceneHasFreeSurface(scene); k++)
    UserCheck(scene->region_tension[k] == 0.0,
              "-scene_fluid_%" PetscInt_FMT "_tension: interfaces have no tension below a free "
              "surface; let a fluid of small density fill the box",
              k + 1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses options that a free surface of strain cells excludes. */
static PetscErrorCode RefuseSurface(const Scene *scene, unsigned needs, const OperatorForms *forms)
{
  PetscFunctionBegin;
  PetscCall(RefuseContacts(scene, forms));
  PetscCall(RefuseTension(scene));
  if (!SceneHasFreeSurface(scene) || needs & NEED_STREAMS) PetscFunctionReturn(PETSC_SUCCESS);
  UserCheck(forms->visc.row->weak,
            "-visc_laplacian %s: it has no condition for the stress on a free surface; use "
            "weak_stress",
            forms->visc.row->name);
  UserCheck(!forms->wall || forms->wall->on_surface,
            "-wall %s: with a free surface, fits have the equations of walls; use wall_layer",
            forms->wall->name);
  PetscCall(RefuseOutflows(scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OperatorsDegree - Reads -mls_degree, the degree of least-squares fits, into the regime too;
   collective */
PetscErrorCode OperatorsDegree(const Scene *scene, PetscInt *degree)
{
  PetscFunctionBegin;
  *degree = 2;
  PetscCall(OptionGetInt(&options[MLS_DEGREE], degree, NULL));
  RegimeSetFact(scene->regime, FACT_CUBIC, *degree == 3);
  RegimeSetFact(scene->regime, FACT_QUARTIC, *degree == 4);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OperatorsChoose - Chooses the discretisation in space. Collective on PETSC_COMM_WORLD. Input:
   needs - bits of Need, the operators of the run; forms for other operators are not chosen. Output:
   forms - the choice: table rows, lengths [m] and coupling of velocity components. */
PetscErrorCode OperatorsChoose(const Scene *scene, unsigned needs, OperatorForms *forms)
{
  Regime   *regime = scene->regime;
  PetscReal h_over_dx;

  PetscFunctionBegin;
  RegimeSetFact(regime, FACT_WCSPH, needs & NEED_STREAMS ? PETSC_TRUE : PETSC_FALSE);
  RegimeSetFact(regime, FACT_SHIFTS, needs & NEED_CORRECTION ? PETSC_TRUE : PETSC_FALSE);
  PetscCall(OptionGetRow(&options[KERNEL], NULL, &forms->kernel));
  PetscCall(ChooseLaplacians(scene, needs, forms));
  PetscCall(OperatorsDegree(scene, &forms->degree));
  RegimeSetFact(regime, FACT_EXACT, AreExact(forms));
  h_over_dx = RegimeValue(regime, REGIME_KERNEL);
  PetscCall(OptionGetReal(&options[H_OVER_DX], &h_over_dx, NULL));
  if (needs & (NEED_PRESSURE | NEED_GRADIENT_U)) {
    PetscCall(OptionGetRow(&options[GRADIENT], NULL, &forms->gradient));
  }
  if (SceneHas(scene, PHYSICS_WALLS)) PetscCall(ChooseWall(scene, needs, forms));
  forms->visc.graded = SceneFinest(scene) < SceneCoarsest(scene);
  forms->ppe.graded  = forms->visc.graded;
  forms->h_over_dx   = h_over_dx;
  forms->h           = h_over_dx * SceneCoarsest(scene);
  forms->radius = forms->reach = forms->kernel->support * forms->h;
  if (needs & NEED_STREAMS) forms->reach += STREAM_MARGIN * SceneCoarsest(scene);
  if (forms->wall && forms->wall->dynamic) forms->reach += forms->radius;
  if ((forms->visc.row && forms->visc.row->weak) || scene->n_scalars)
    forms->reach = PetscMax(forms->reach, StrainReach(scene));
  UserCheck(!SceneIsGraded(scene) || !forms->wall || forms->wall->on_surface,
            "-wall %s: its particles behind the wall need a uniform lattice; with %s use -wall "
            "wall_layer and forms without full_support in -catalogue, such as mls",
            forms->wall->name, scene->grading.spacing.n ? "-spacing" : "-spacing_wall");
  PetscCall(RefuseSurface(scene, needs, forms));
  PetscCall(ChooseCoupling(scene, forms));
  PetscCall(RefuseEquations(scene, forms));
  PetscFunctionReturn(PETSC_SUCCESS);
}
