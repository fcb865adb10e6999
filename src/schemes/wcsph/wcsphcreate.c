/* Options and refusals of the weakly compressible scheme. */
#include "wcsph.h"

enum { EQUATION, SOUND, DENSITY, REDUCTION, DIFFUSION, ARTIFICIAL, COURANT };
static const OptionRow options[] = {
    [EQUATION]   = OPTION(NAME, "-equation_of_state",
                          "pressure as a function of density, and of energy for a "
                            "gas",
                          NULL, "tait", .table = &EquationOfStateTable, .where = "-scheme wcsph"),
    [SOUND]      = OPTION(REAL, "-sound_speed", "speed of sound at rest", "m/s",
                          "10 times the largest of U, (nu U/L)^(1/2) and (|f| L)^(1/2)", POSITIVE,
                          .where = "-scheme wcsph"),
    [DENSITY]    = OPTION(NAME, "-density_form",
                          "equation of the density, and the pressure force that belongs to "
                             "it",
                          NULL, "continuity", .table = &DensityFormTable, .where = "-scheme wcsph"),
    [REDUCTION]  = OPTION(NAME, "-pressure_reduction",
                          "pressure that is subtracted before its gradient is computed", NULL,
                          "none", .table = &PressureReductionTable, .where = "-scheme wcsph"),
    [DIFFUSION]  = OPTION(REAL, "-density_diffusion",
                          "delta of the diffusivity delta h c0 of the density; 0: off", "-", "0.1",
                          .expert = PETSC_TRUE, .low = 0.0, .high = 1.0,
                          .where = "-scheme wcsph with -density_form continuity"),
    [ARTIFICIAL] = OPTION(REALS, "-artificial_viscosity",
                          "alpha,beta of Monaghan's viscosity between particles that approach", "-",
                          "0,0", .low = 0.0, .high = 100.0, .where = "-scheme wcsph",
                          .instead = "in an incompressible fluid it acts as a larger -viscosity"),
    [COURANT] =
        OPTION(REAL, "-acoustic_cfl", "largest dt (c0 + U)/h", "-",
               "0.5, or 0.1 with a Runge-Kutta method of second order, which lets sound grow",
               .low = 1e-4, .high = 4.0, .where = "-scheme wcsph"),
};
const OptionTable WcsphOptions = OPTIONS("Weakly compressible flow", options);

/*
  Returns the default speed of sound [m/s]

    c0 = 10 max(U, (nu U/L)^(1/2), (|f| L)^(1/2)),

  with which inertia, viscosity and body force change the density by about one per cent.

  Reference: J. P. Morris, P. J. Fox, Y. Zhu, J. Comput. Phys. 136 (1997), Eq. (4)
*/
static PetscReal DefaultSoundSpeed(const Flow *flow)
{
  const Scene *scene = flow->scene;
  PetscReal most = PetscMax(PetscSqr(scene->speed), flow->scheme->stats.force_max * scene->length);

  if (SceneHas(scene, PHYSICS_VISCOSITY))
    most = PetscMax(most, scene->nu_high * scene->speed / scene->length);
  return 10.0 * PetscSqrtReal(most);
}

/* Refuses scenes and options that the scheme has no equations for. */
static PetscErrorCode Refuse(const Flow *flow)
{
  const Scene       *scene = flow->scene;
  const Clock       *clock = flow->clock;
  const BoundaryRow *fits  = SceneFitKind(scene);
  PetscBool          order;

  PetscFunctionBegin;
  PetscCall(OptionGiven("-time_order", &order));
  UserCheck(!order, "-time_order: -wcsph_ts_rk_type gives the order of -scheme wcsph");
  UserCheck(SceneHas(scene, PHYSICS_PRESSURE),
            "-scheme wcsph: it needs a pressure; add -with pressure,convection");
  UserCheck(SceneMoves(scene),
            "-scheme wcsph: its particles move; use -motion lagrangian and -with convection");
  UserCheck(!fits, "-scheme wcsph: its walls have no slip, which excludes %s", fits->option.name);
  UserCheck(!scene->pose, "-scheme wcsph: bodies stay where they are, which excludes a motion of "
                          "their own; use -scheme projection or coupled");
  UserCheck(!SceneHasOpenings(scene), "-scheme wcsph: fluid does not enter, which excludes "
                                      "-scene_inflow; use -scheme projection or coupled");
  UserCheck(!SceneIsGraded(scene) && !SceneMovesGraded(scene),
            "-scheme wcsph: its particles have one size, which excludes -spacing and "
            "-spacing_wall");
  UserCheck(!SceneHasFreeSurface(scene) || scene->n_bodies == 0,
            "-scheme wcsph: with a free surface its walls are the sides of the box, which excludes "
            "-scene_body_1");
  UserCheck(!SceneViscosityVaries(scene),
            "-scheme wcsph: it has a uniform viscosity; use -scheme projection");
  UserCheck(scene->tension == 0.0,
            "-surface_tension: -scheme wcsph has none; use -scheme projection or coupled");
  UserCheck(!clock->steady_solve, "-steady: -scheme wcsph advances in time; use -scheme coupled");
  UserCheck(clock->steady_tol == 0.0,
            "-steady_tol: sound waves of -scheme wcsph never come to rest; use -t_end");
  UserCheck(!clock->adapt->estimates,
            "-dt_adapt error: sound limits the steps of -scheme wcsph; use -dt_adapt retry");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the default of -acoustic_cfl [-]. Runge-Kutta methods of second order have no interval of
   stability on the imaginary axis: without viscosity each step of dt = 0.25 h/c0 feeds waves of the
   grid scale. In the cavity at Re = 100, n = 25, all runs with midpoint and 0.25 were lost before t
   = 5, and none with 0.1. Methods of third order are stable up to 1.7 over the largest
   frequency. */
static PetscErrorCode DefaultCourant(PetscReal *courant)
{
  const char *const second[] = {"midpoint", "2a", "2b"};
  char              type[32];
  PetscBool         given, same = PETSC_FALSE;

  PetscFunctionBegin;
  *courant = 0.5;
  PetscCall(PetscOptionsGetString(NULL, "wcsph_", "-ts_rk_type", type, sizeof(type), &given));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(second) && given && !same; k++)
    PetscCall(PetscStrcmp(type, second[k], &same));
  if (same) *courant = 0.1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Chooses the shift, and with it the default correction of the kernel. */
static PetscErrorCode ChooseShift(const Flow *flow, const Wcsph *w)
{
  const PetscBool free   = SceneHasFreeSurface(flow->scene);
  Regime         *regime = flow->scene->regime;
  const TableRow *row;
  FlowState      *state = flow->state;
  PetscBool       given;

  PetscFunctionBegin;
  RegimeSetFact(regime, FACT_WCSPH, PETSC_TRUE);
  RegimeSetFact(regime, FACT_SUMS, w->density->sums);
  PetscCall(OptionGiven("-shift", &given));
  UserCheck(!free || !given || !state->shift->Displace,
            "-shift %s: with -scheme wcsph it would move the free surface; use none",
            state->shift->name);
  if (!given) {
    PetscCall(TableFind(&ShiftTable, RegimeWord(regime, REGIME_SHIFT), &row));
    state->shift = (const ShiftRow *)(const void *)row;
  }
  if (!state->shift->Displace) PetscFunctionReturn(PETSC_SUCCESS);
  flow->scheme->needs |= NEED_CORRECTION;
  PetscCall(OptionGiven("-shift_strength", &given));
  if (!given) state->shift_strength = RegimeValue(regime, REGIME_SHIFT_STRENGTH);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses equations that are not zero on a free surface, where sums see half of the fluid. */
static PetscErrorCode RefuseFreeSurface(const Scene *scene, const Wcsph *w)
{
  PetscFunctionBegin;
  if (!SceneHasFreeSurface(scene)) PetscFunctionReturn(PETSC_SUCCESS);
  UserCheck(!w->density->sums,
            "-density_form %s: at a free surface the sum has half of the density; use continuity",
            w->density->name);
  UserCheck(!w->equation->has_energy,
            "-equation_of_state %s: a gas expands through a free surface; use tait or linear",
            w->equation->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadFluid(const Flow *flow, Wcsph *w)
{
  const Scene *scene = flow->scene;
  PetscInt     n     = 0;

  PetscFunctionBegin;
  w->c0 = DefaultSoundSpeed(flow);
  PetscCall(OptionGetReal(&options[SOUND], &w->c0, NULL));
  if (w->equation->has_energy) {
    w->p_rest = scene->rho * PetscSqr(w->c0) / w->equation->exponent;
    w->e_rest = w->p_rest / ((w->equation->exponent - 1.0) * scene->rho);
  }
  if (!w->density->sums) {
    w->diffusion = 0.1;
    PetscCall(OptionGetReal(&options[DIFFUSION], &w->diffusion, NULL));
  }
  PetscCall(OptionGetReals(&options[ARTIFICIAL], 2, w->artificial, &n, NULL));
  PetscCall(DefaultCourant(&w->courant));
  PetscCall(OptionGetReal(&options[COURANT], &w->courant, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the largest Mach number and change of density to report, memory and checkpoints, and the
   artificial viscosity to the report. */
static PetscErrorCode AddFigures(Scheme *scheme, Wcsph *w)
{
  PetscFunctionBegin;
  PetscCall(MemoryAddReal(&scheme->memory, "mach", &w->mach));
  PetscCall(MemoryAddReal(&scheme->memory, "density_variation", &w->variation));
  PetscCall(SchemeAddFigure(
      (SchemeFigure){
          .name   = "mach",
          .value  = &w->mach,
          .most   = WCSPH_MACH,
          .remedy = "the fluid is not nearly incompressible; try a larger -sound_speed",
      },
      scheme));
  PetscCall(SchemeAddFigure(
      (SchemeFigure){
          .name   = "density_variation",
          .value  = &w->variation,
          .most   = WCSPH_VARIATION,
          .remedy = "the fluid is not nearly incompressible; try a larger -sound_speed",
      },
      scheme));
  if (SceneHas(w->flow->scene, PHYSICS_WALLS)) {
    PetscCall(MemoryAddReal(&scheme->memory, "sound_passage", &w->passage));
    PetscCall(SchemeAddFigure(
        (SchemeFigure){
            .name   = "sound_passage",
            .value  = &w->passage,
            .most   = 1.0,
            .remedy = "sound has not yet crossed the fluid, which the walls still compress; try a "
                      "longer -t_end, more -max_steps, or a larger -sound_speed",
        },
        scheme));
  }
  if (!SceneHas(w->flow->scene, PHYSICS_VISCOSITY) || w->artificial[0] + w->artificial[1] == 0.0)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SchemeAddFigure(
      (SchemeFigure){
          .name   = "artificial_over_nu",
          .value  = &w->artificial_over_nu,
          .most   = 1.0,
          .remedy = "the flow has the Reynolds number of the artificial viscosity; try a smaller "
                    "-artificial_viscosity or a larger -n",
      },
      scheme));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WcsphCreate - Reads the options of the weakly compressible scheme; collective */
PetscErrorCode WcsphCreate(Flow *flow)
{
  Wcsph *w;

  PetscFunctionBegin;
  PetscCall(PetscNew(&w));
  flow->scheme->data = w;
  w->flow            = flow;
  PetscCall(Refuse(flow));
  PetscCall(OptionGetRow(&options[EQUATION], NULL, &w->equation));
  PetscCall(OptionGetRow(&options[DENSITY], NULL, &w->density));
  PetscCall(OptionGetRow(&options[REDUCTION], NULL, &w->reduction));
  PetscCall(RefuseFreeSurface(flow->scene, w));
  PetscCall(ReadFluid(flow, w));
  flow->scheme->needs &= ~(unsigned)(NEED_PRESSURE | NEED_VISCOSITY | NEED_GRADIENT_U |
                                     NEED_FILTER_U | NEED_CONCENTRATION);
  flow->scheme->needs |= NEED_STREAMS;
  PetscCall(ChooseShift(flow, w));
  PetscCall(AddFigures(flow->scheme, w));
  flow->scheme->density    = &w->rho;
  flow->scheme->Accelerate = WcsphAccelerate;
  flow->scheme->variant    = (const TableRow *)(const void *)w->equation;
  PetscFunctionReturn(PETSC_SUCCESS);
}
