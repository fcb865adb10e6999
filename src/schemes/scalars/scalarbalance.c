/* Balances of a scalar: its amount against what enters and is made, its values against bounds. */
#include "isph/balance.h"
#include "scalars.h"

/* ScalarAmount - Computes the amount of a scalar in the fluid, and the volume of the fluid [m^dim];
   collective */
PetscErrorCode ScalarAmount(const Flow *flow, const PetscReal c[], PetscReal amount[2])
{
  const Particles *p      = flow->particles;
  const PetscReal *volume = ScalarVolumes(flow);

  PetscFunctionBegin;
  amount[0] = amount[1] = 0.0;
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    amount[0] += volume[i] * c[i];
    amount[1] += volume[i];
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, amount, 2, MPIU_REAL, MPIU_SUM, p->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if neither sources nor fluxes make values of their own. */
static PetscBool HasBounds(const Scalar *s)
{
  for (PetscInt k = 0; k < s->given->n_boundary; k++)
    if (s->given->boundary[k].law == SCALAR_FLUX) return PETSC_FALSE;
  return s->given->source.n ? PETSC_FALSE : PETSC_TRUE;
}

/* Widens the range of start and boundaries by values of own fluid, or of walls, and outside a free
   surface, whose facets may be near any particle. */
static PetscErrorCode Widen(const Flow *flow, PetscBool fluid, Scalar *s)
{
  const Particles *p        = flow->particles;
  const PetscBool  cut      = flow->ops->cut_surface;
  const PetscInt   first    = fluid || cut ? 0 : p->n_fluid;
  PetscReal        bound[2] = {-s->kept[KEPT_LOW], s->kept[KEPT_HIGH]};

  PetscFunctionBegin;
  for (PetscInt i = first; i < (fluid ? p->n_fluid : ParticlesOwn(p)); i++) {
    const PetscBool       wall            = i >= p->n_fluid;
    const ScalarBoundary *law             = NULL;
    PetscReal             value           = wall ? 0.0 : s->c[i];
    PetscReal             x[ISPH_MAX_DIM] = {0.0};

    if (wall) law = s->law[(PetscInt)p->side[i]];
    else if (!fluid && cut) law = s->law[SceneBoundaries(flow->scene)];
    if (!fluid && (!law || law->law == SCALAR_FLUX)) continue;
    if (wall) ParticlesWallPoint(p, i, x);
    for (PetscInt a = 0; a < p->dim && !wall; a++) x[a] = p->x[a][i];
    if (law)
      value = ExpressionValue(&law->of, law->law == SCALAR_EXCHANGE ? 1 : 0,
                              flow->clock->t + flow->clock->dt, x);
    bound[0] = PetscMax(bound[0], -value);
    bound[1] = PetscMax(bound[1], value);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, bound, 2, MPIU_REAL, MPIU_MAX, p->comm));
  s->kept[KEPT_LOW]  = -bound[0];
  s->kept[KEPT_HIGH] = bound[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ScalarBalanceRegister - Starts the balances, and keeps them in the memory of the scheme;
   collective */
PetscErrorCode ScalarBalanceRegister(Flow *flow, Scalar *s)
{
  BalanceSheet     *sheet   = &flow->scheme->sheet;
  Memory           *memory  = &flow->scheme->memory;
  const BalanceKind kind[2] = {BALANCE_SCALAR, BALANCE_BOUNDS};
  PetscReal         amount[2];

  PetscFunctionBegin;
  PetscCall(ScalarAmount(flow, s->c, amount));
  s->kept[KEPT_AMOUNT] = s->kept[KEPT_BEFORE] = amount[0];
  s->kept[KEPT_LOW]                           = PETSC_MAX_REAL;
  s->kept[KEPT_HIGH]                          = -PETSC_MAX_REAL;
  PetscCall(Widen(flow, PETSC_TRUE, s));
  (void)snprintf(s->kept_name, sizeof(s->kept_name), "%s_kept", s->given->name);
  PetscCall(MemoryAddReals(memory, s->kept_name, KEPT, s->kept));
  (void)snprintf(s->entering_name, sizeof(s->entering_name), "%s_entering", s->given->name);
  PetscCall(
      MemoryAddReals(memory, s->entering_name, SceneBoundaries(flow->scene) + 1, s->entering));
  for (PetscInt k = 0; k < 2 && s == flow->state->scalars->scalar; k++) {
    char name[3][32];

    (void)snprintf(name[0], sizeof(name[0]), "%s", BalanceRows[kind[k]].name);
    (void)snprintf(name[1], sizeof(name[1]), "%s_t", BalanceRows[kind[k]].name);
    (void)snprintf(name[2], sizeof(name[2]), "%s_on", BalanceRows[kind[k]].name);
    PetscCall(MemoryAddReal(memory, name[0], &sheet->value[kind[k]]));
    PetscCall(MemoryAddReal(memory, name[1], &sheet->t[kind[k]]));
    PetscCall(MemoryAddInt(memory, name[2], &sheet->applies[kind[k]]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets a row of the balance sheet if the violation is the largest so far. */
static void Note(const Flow *flow, BalanceKind kind, PetscReal value)
{
  BalanceSheet *sheet = &flow->scheme->sheet;

  if (sheet->applies[kind] && value <= sheet->value[kind]) return;
  BalanceSet(kind, value, value, flow->clock->t + flow->clock->dt, sheet);
}

/* ScalarBalanceStep - Measures the balances of a scalar after a step. Collective. Input: weight -
   of the last two values in the start of the step, see ScalarSolve(); dt - length of the step from
   this start [s]; made - by sources at the end of the step, per time [m^dim/s]. Note: other
   integrators than that with a history add in stages, so that the amount is that of the step only
   to its order; they have no balance. Nor have flows that particles enter or leave. */
PetscErrorCode ScalarBalanceStep(Flow *flow, const PetscReal weight[2], PetscReal dt,
                                 PetscReal made, Scalar *s)
{
  const Particles *p    = flow->particles;
  PetscReal       *kept = s->kept, should, range, amount[2], beyond = 0.0, rate = made;

  PetscFunctionBegin;
  PetscCall(Widen(flow, PETSC_FALSE, s));
  PetscCall(ScalarAmount(flow, s->c, amount));
  for (PetscInt side = 0; side <= SceneBoundaries(flow->scene); side++) rate += s->entering[side];
  should            = weight[0] * kept[KEPT_AMOUNT] + weight[1] * kept[KEPT_BEFORE] + dt * rate;
  kept[KEPT_BEFORE] = kept[KEPT_AMOUNT];
  kept[KEPT_AMOUNT] = should;
  range             = kept[KEPT_HIGH] - kept[KEPT_LOW];
  if (s->row->history && !(flow->state->openings.open && SceneMoves(flow->scene)))
    Note(flow, BALANCE_SCALAR,
         PetscAbsReal(amount[0] - should) /
             PetscMax(PetscMax(range * amount[1], PetscAbsReal(should)), PETSC_MACHINE_EPSILON));
  if (!HasBounds(s) || range <= 0.0) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < p->n_fluid; i++)
    beyond = PetscMax(beyond, PetscMax(kept[KEPT_LOW] - s->c[i], s->c[i] - kept[KEPT_HIGH]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &beyond, 1, MPIU_REAL, MPIU_MAX, p->comm));
  Note(flow, BALANCE_BOUNDS, beyond / range);
  PetscFunctionReturn(PETSC_SUCCESS);
}
