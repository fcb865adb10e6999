/* Operators of a run: creation for given needs, placement of walls, destruction. For their choice
   see choose.c, for their assembly assemble.c, for their products apply.c. */
#include "rows/assembly.h"
#include "walls/boundary_rows.h"
#include "choose.h"
#include "fitted.h"
#include "isph/strain.h"
#include "rows/rows.h"

#define SURFACE_WEAK 1e-2 /* Stencil.weak beside free surfaces: fragments have few particles */

/* OperatorsList - Lists all operators, needed or not, in the order of assembly */
void OperatorsList(Operators *ops, AffineOperator *all[OPERATORS_COUNT])
{
  PetscInt n = 0;

  for (PetscInt c = 0; c < ISPH_MAX_DIM; c++) {
    all[n++] = &ops->velocity[c].visc;
    all[n++] = &ops->velocity[c].filter_u;
    for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) all[n++] = &ops->velocity[c].grad_u[a];
  }
  all[n++] = &ops->ppe;
  all[n++] = &ops->filter_p;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    all[n++] = &ops->grad_p[a];
    all[n++] = &ops->div[a];
  }
}

/* SceneNeeds - Returns the operators that the physics of a scene needs, as bits of Need */
unsigned SceneNeeds(const Scene *scene)
{
  unsigned needs = 0;

  if (SceneHas(scene, PHYSICS_VISCOSITY)) needs |= NEED_VISCOSITY;
  if (SceneHas(scene, PHYSICS_PRESSURE)) needs |= NEED_PRESSURE;
  if (scene->motion || !SceneIsNewtonian(scene)) needs |= NEED_GRADIENT_U;
  return needs;
}

/* Sets the form of the products of an operator and the matrices that it needs. Input: block - the
   matrix couples components, and the products are its own. */
static void ChooseProducts(Operators *ops, PetscBool block, AffineOperator *op)
{
  op->rows         = block ? NULL : &ops->rows;
  op->has_matrices = block || ops->needs & NEED_MATRICES;
}

/* Marks the operators of a velocity component that the run needs. */
static void NeedVelocity(const Scene *scene, Operators *ops, VelocityOperators *of)
{
  ChooseProducts(ops, ops->forms.components_coupled, &of->visc);
  ChooseProducts(ops, PETSC_FALSE, &of->filter_u);
  for (PetscInt a = 0; a < scene->dim; a++) ChooseProducts(ops, PETSC_FALSE, &of->grad_u[a]);
  of->visc.width  = LaplacianWidth(&ops->forms.visc, scene->dim);
  of->visc.needed = ops->needs & NEED_VISCOSITY && ops->forms.visc.row->Row;
  if (ops->forms.components_coupled && of != &ops->velocity[0]) of->visc.needed = PETSC_FALSE;
  of->filter_u.needed = ops->needs & NEED_FILTER_U ? PETSC_TRUE : PETSC_FALSE;
  for (PetscInt a = 0; a < scene->dim; a++)
    of->grad_u[a].needed = ops->needs & NEED_GRADIENT_U ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns true if an operator of the run has the rows of fits of the chosen degree. */
static PetscBool HasFits(const Operators *ops)
{
  const OperatorForms *forms = &ops->forms;

  if (ops->needs & (NEED_FILTER_U | NEED_FILTER_P)) return PETSC_TRUE;
  return (forms->visc.row && forms->visc.row->Row == LaplacianRow_Mls) ||
         (forms->ppe.row && forms->ppe.row->Row == LaplacianRow_Mls) ||
         (forms->gradient && forms->gradient->Row == GradientRow_Mls);
}

/* Lets an operator of a group of operators with equal rows share those of the first that is needed.
   Operators with matrices store all their rows. Input/Output: first - NULL if there is none yet. */
static void ShareRows(AffineOperator *op, const AffineOperator **first)
{
  if (!op->needed || op->has_matrices || !op->rows) return;
  op->twin = *first;
  if (!*first) *first = op;
}

/* Finds the operators whose rows are equal at particles without wall neighbours. There a row
   depends on values of the fluid only, not on the quantity: the gradients of velocity components
   and of the pressure are equal to the divergence, both filters are equal, and so are the operators
   of all velocity components. */
static void ShareAllRows(Operators *ops)
{
  const AffineOperator *visc = NULL, *filter = NULL;

  for (PetscInt c = 0; c < ops->n_velocity; c++) {
    ShareRows(&ops->velocity[c].visc, &visc);
    ShareRows(&ops->velocity[c].filter_u, &filter);
  }
  ShareRows(&ops->filter_p, &filter);
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    const AffineOperator *gradient = NULL;

    for (PetscInt c = 0; c < ops->n_velocity; c++)
      ShareRows(&ops->velocity[c].grad_u[a], &gradient);
    ShareRows(&ops->grad_p[a], &gradient);
    ShareRows(&ops->div[a], &gradient);
  }
}

/* Decides if rows of particles that do not move are stored once where they repeat: all operators
   are products by rows, and a row depends on the places of its neighbours only. The pressure then
   has no matrix; AffineSystemCreate() makes it while a solver needs it. */
static void ChooseRows(const Scene *scene, Operators *ops)
{
  const LaplacianForm *const form[] = {&ops->forms.visc, &ops->forms.ppe};
  AffineOperator            *all[OPERATORS_COUNT];
  PetscBool                  matrices = ops->forms.components_coupled;

  OperatorsList(ops, all);
  for (PetscInt k = 0; k < OPERATORS_COUNT; k++)
    if (all[k]->needed && all[k]->has_matrices) matrices = PETSC_TRUE;
  ops->rows.repeats = !matrices && !SceneMoves(scene) && !SceneViscosityVaries(scene);
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(form); k++)
    if (form[k]->row && form[k]->row->Factor) ops->rows.repeats = PETSC_FALSE;
  ops->ppe.has_matrices = ops->rows.repeats ? PETSC_FALSE : PETSC_TRUE;
  ops->rows.has_columns = matrices || (ops->ppe.needed && ops->ppe.has_matrices);
}

/* Returns true if none of the gradients has a matrix. */
static PetscBool GradientsAreProducts(const Operators *ops)
{
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    const AffineOperator *const of[] = {&ops->velocity[0].grad_u[a], &ops->grad_p[a], &ops->div[a]};

    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(of); k++)
      if (of[k]->needed && (of[k]->has_matrices || !of[k]->rows)) return PETSC_FALSE;
  }
  return ops->velocity[0].grad_u[0].needed;
}

/* Decides if products make the rows of gradients and filters from fits: those of particles that
   move. Beside walls the operators of several quantities have different equations, and their rows
   are stored. */
static PetscErrorCode ChooseFitted(const Scene *scene, Operators *ops)
{
  const PetscBool filters  = ops->forms.degree % 2 == 0;
  const PetscBool filter_u = filters && ops->velocity[0].filter_u.needed,
                  filter_p = filters && ops->filter_p.needed;

  PetscFunctionBegin;
  if (!SceneMoves(scene) || !GradientsAreProducts(ops)) PetscFunctionReturn(PETSC_SUCCESS);
  if (ops->forms.gradient->Row != GradientRow_Mls) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt c = 0; c < ops->n_velocity; c++) {
    if (filter_u) ops->velocity[c].filter_u.fitted = FIT_FILTER;
    for (PetscInt a = 0; a < scene->dim; a++)
      ops->velocity[c].grad_u[a].fitted = (FitRow)(FIT_GRADIENT + a);
  }
  if (filter_p) ops->filter_p.fitted = FIT_FILTER;
  for (PetscInt a = 0; a < scene->dim; a++)
    ops->grad_p[a].fitted = ops->div[a].fitted = (FitRow)(FIT_GRADIENT + a);
  ops->work->fits_walls = ops->forms.wall && ops->forms.wall->on_surface && ops->n_velocity == 1 &&
                          !ops->grad_p[0].needed && !ops->filter_p.needed;
  PetscCall(FittedCreate(&ops->forms, scene->dim, filter_u || filter_p, &ops->rows.fitted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the stencils of a batch of particles. */
static PetscErrorCode CreateWorkspace(const Scene *scene, Operators *ops)
{
  Assembly *work = ops->work;

  PetscFunctionBegin;
  for (PetscInt l = 0; l < MLS_BATCH; l++) {
    PetscCall(StencilCreate(scene->dim, &work->batch[l]));
    work->batch[l]->degree     = ops->forms.degree;
    work->batch[l]->fits_walls = ops->forms.wall ? ops->forms.wall->on_surface : PETSC_FALSE;
    if (!SceneHasFreeSurface(scene)) continue;
    work->batch[l]->least_degree = 1;
    work->batch[l]->weak         = SURFACE_WEAK;
  }
  work->stencil  = work->batch[0];
  work->has_fits = HasFits(ops);
  PetscCall(MlsBatchCreate(scene->dim, &work->fits));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OperatorsCreate - Creates the operators that a run needs. Collective on PETSC_COMM_WORLD. Nothing
   is assembled yet. Input: needs - bits of Need; an operator that is not needed is neither chosen
   nor assembled. */
PetscErrorCode OperatorsCreate(const Scene *scene, unsigned needs, Operators **operators)
{
  const PetscBool pressure = needs & NEED_PRESSURE ? PETSC_TRUE : PETSC_FALSE;
  Operators      *ops;
  AffineOperator *all[OPERATORS_COUNT];

  PetscFunctionBegin;
  PetscCall(PetscNew(&ops));
  PetscCall(PetscNew(&ops->work));
  ops->needs = needs;
  PetscCall(OperatorsChoose(scene, needs, &ops->forms));
  OperatorsList(ops, all);
  for (PetscInt k = 0; k < OPERATORS_COUNT; k++) all[k]->width = 1;
  ops->n_velocity = SceneSlipKind(scene) ? scene->dim : 1;
  for (PetscInt c = 0; c < ops->n_velocity; c++) NeedVelocity(scene, ops, &ops->velocity[c]);
  ops->filter_p.needed = needs & NEED_FILTER_P ? PETSC_TRUE : PETSC_FALSE;
  ops->ppe.needed      = pressure;
  ChooseProducts(ops, PETSC_FALSE, &ops->filter_p);
  ChooseProducts(ops, PETSC_FALSE, &ops->ppe);
  for (PetscInt a = 0; a < scene->dim; a++) {
    ops->grad_p[a].needed = ops->div[a].needed = pressure;
    ChooseProducts(ops, PETSC_FALSE, &ops->grad_p[a]);
    ChooseProducts(ops, PETSC_FALSE, &ops->div[a]);
  }
  ops->cut_surface = SceneHasFreeSurface(scene) && ops->forms.visc.row && ops->forms.visc.row->weak;
  ShareAllRows(ops);
  ChooseRows(scene, ops);
  PetscCall(ChooseFitted(scene, ops));
  PetscCall(CreateWorkspace(scene, ops));
  *operators = ops;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AffineFree(AffineOperator *op)
{
  PetscFunctionBegin;
  PetscCall(MatDestroyAll(&op->A, &op->B));
  PetscCall(FreeAll(&op->a, &op->b, &op->apart));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OperatorsDestroy - Frees the operators and their matrices; collective */
PetscErrorCode OperatorsDestroy(Operators **operators)
{
  Operators      *ops = *operators;
  AffineOperator *all[OPERATORS_COUNT];

  PetscFunctionBegin;
  if (!ops) PetscFunctionReturn(PETSC_SUCCESS);
  OperatorsList(ops, all);
  for (PetscInt k = 0; k < OPERATORS_COUNT; k++) PetscCall(AffineFree(all[k]));
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    PetscCall(FreeAll(&ops->concentration.gradient[a], &ops->work->g[a]));
  }
  PetscCall(FreeAll(&ops->concentration.value, &ops->forms.visc.factor, &ops->forms.ppe.factor));
  PetscCall(VecDestroy(&ops->ppe_scale));
  PetscCall(StrainDestroy(&ops->strain));
  for (PetscInt k = 0; k < 2; k++) PetscCall(MatDestroy(&ops->cut_part[k]));
  PetscCall(PetscFree5(ops->work->slot, ops->work->w, ops->work->m, ops->work->wall_w,
                       ops->work->excess));
  for (PetscInt l = 0; l < MLS_BATCH; l++) PetscCall(StencilDestroy(&ops->work->batch[l]));
  PetscCall(MlsBatchDestroy(&ops->work->fits));
  PetscCall(PetscFree(ops->work));
  if (ops->rows.repeats) PetscCall(PetscFree(ops->rows.first));
  PetscCall(PetscFree(ops->rows.run));
  PetscCall(PatternFree(&ops->rows.fluid));
  PetscCall(PatternFree(&ops->rows.walls));
  PetscCall(FreeAll(&ops->rows.apart, &ops->rows.value));
  PetscCall(FittedDestroy(&ops->rows.fitted));
  PetscCall(PetscFree(*operators));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OperatorsPlacement - Returns the layers of wall particles that the wall treatment needs */
PetscErrorCode OperatorsPlacement(const Scene *scene, const Operators *ops, WallPlacement *walls)
{
  PetscFunctionBegin;
  walls->layers   = 0;
  walls->surface  = ops->forms.wall_surface;
  walls->jittered = scene->problem->patch;
  if (ops->forms.wall && !ops->forms.wall->on_surface) {
    walls->layers = (PetscInt)PetscCeilReal(ops->forms.radius / SceneCoarsest(scene) - 1e-9);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
