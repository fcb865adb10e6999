/* The pressure on splines in a step: its start, the divergence of a velocity, and its values on
   particles. The matrix is in splinematrix.c. */
#include "splines.h"

/* SplinesSet - Sets the lattice of splines, its bodies, and an initial pressure of zero. Collective
   on PETSC_COMM_WORLD. Input: ratio - edge of a cell over the spacing of the particles; degree - of
   fits. Note: the gradient of quadratic splines has an error of second order at particles, whose
   mean over the particles is not zero. So the pressure is of second order, whatever the fits are;
   with cubic splines it is of fourth order. Fits below degree 4 have larger errors than the
   splines. In cells that a body cuts the divergence has linear velocities, so splines beside bodies
   stay quadratic. See theory.md, (splines:errors). */
PetscErrorCode SplinesSet(const Scene *scene, PetscReal ratio, PetscInt degree, Splines *s)
{
  PetscFunctionBegin;
  PetscCall(SplineLatticeSet(scene, ratio, &s->lattice));
  for (PetscInt side = 0; side < 2 * scene->dim && s->in_cells; side++)
    s->lattice.given[side] = PETSC_FALSE; /* cells end there without traction */
  if (!s->in_cells) PetscCall(SplineBodiesCreate(scene, &s->lattice, &s->bodies));
  PetscCall(SplineExtensionCreate(&s->lattice, s->bodies, &s->extension));
  s->pressure = s->lattice;
  s->pressure.degree =
      degree == 4 && !s->bodies && !SceneMixes(scene) && !SplineSideGives(&s->lattice) ? 3 : 2;
  s->scale = 1.0;
  for (PetscInt a = 0; a < scene->dim; a++) s->scale *= s->lattice.side[a];
  s->scale  = PetscPowReal(s->scale, 1.0 / scene->dim);
  s->fluids = s->in_cells ? SceneFluids(scene) : 1;
  PetscCall(VecCreateMPI(PETSC_COMM_WORLD, PETSC_DECIDE, s->fluids * s->lattice.N, &s->natural));
  PetscCall(VecDuplicate(s->natural, &s->kept));
  PetscCall(VecSet(s->kept, 0.0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesCreate - Creates the splines of a flow, with the initial pressure of the case. Collective
   on PETSC_COMM_WORLD. Input: ratio - edge of a cell over the spacing of the particles. */
PetscErrorCode SplinesCreate(Flow *flow, PetscReal ratio, Splines **splines)
{
  PetscInt degree;
  Splines *s;

  PetscFunctionBegin;
  UserCheck(!SceneMixes(flow->scene) || flow->ops->forms.components_coupled,
            "-visc_laplacian %s: fluids of several densities, or with a tension, need the whole "
            "stress; use stress_mls or weak_stress",
            flow->ops->forms.visc.row ? flow->ops->forms.visc.row->name : "");
  PetscCall(OperatorsDegree(flow->scene, &degree));
  PetscCall(PetscNew(&s));
  s->in_cells = flow->ops->cut_surface;
  PetscCall(SplinesSet(flow->scene, ratio, degree, s));
  flow->scheme->kept    = s->kept;
  flow->scheme->splines = *splines = s;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesDestroy - Frees the splines; collective */
PetscErrorCode SplinesDestroy(Splines **splines)
{
  PetscFunctionBegin;
  if (!*splines) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SplinesFree(*splines));
  PetscCall(PetscFree(*splines));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesBegin - Takes the pressure from its kept copy, at the start, after a restart or an undone
   step; collective */
PetscErrorCode SplinesBegin(Splines *s)
{
  PetscFunctionBegin;
  PetscCall(VecScatterBegin(s->renumber, s->kept, s->all, INSERT_VALUES, SCATTER_REVERSE));
  PetscCall(VecScatterEnd(s->renumber, s->kept, s->all, INSERT_VALUES, SCATTER_REVERSE));
  PetscCall(SplinesShareOut(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the outward normal velocity of the boundary at its points at time t [m/s]. */
static PetscErrorCode SetWallFlux(const Flow *flow, PetscReal t, Splines *s)
{
  const SplinePoints *at = &s->boundary;
  PetscScalar        *flux;

  PetscFunctionBegin;
  PetscCall(VecGetArrayWrite(s->wall_flux, &flux));
  for (PetscInt g = 0; g < at->n; g++) {
    PetscReal x[ISPH_MAX_DIM], u[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < s->lattice.dim; a++) x[a] = at->x[a][g];
    SceneWallVelocity(flow->scene, at->side[g], t, x, u);
    flux[g] = 0.0;
    for (PetscInt a = 0; a < s->lattice.dim; a++) flux[g] += at->normal[a][g] * u[a];
  }
  PetscCall(VecRestoreArrayWrite(s->wall_flux, &flux));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SplinesDivergence - Computes the divergence of a velocity at time t

    d_q = -int grad psi_q . u dV + int psi_q u_w.n dA   over the volume of a cell,

  with n out of the fluid; splines that are no unknowns have 0. Collective. Input: u - components at
  particles [m/s]; walls have their values of WallValuesSetVelocity(). Output: d [1/s]; d_q over
  mass_q is the mean of div u.
*/
PetscErrorCode SplinesDivergence(Flow *flow, Splines *s, const Vec u[], PetscReal t, Vec d)
{
  PetscScalar *value;

  PetscFunctionBegin;
  if (s->cut[0]) {
    PetscCall(SplinesOfVelocity(flow, &s->cut[1], u, d));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt a = 0; a < s->lattice.dim; a++)
    PetscCall(
        LocalValues(flow->particles, u[a], flow->walls.u[a], s->lattice.dim, s->fits.value + a));
  PetscCall(SplinesIntegrate(flow->particles, s, d));
  PetscCall(VecScale(d, -1.0));
  if (s->S) {
    PetscCall(SetWallFlux(flow, t, s));
    PetscCall(MatMultTransposeAdd(s->S, s->wall_flux, d, d));
  }
  PetscCall(VecScale(d, 1.0 / s->scale));
  PetscCall(VecGetArray(d, &value));
  for (PetscInt k = 0; k < s->n_unused; k++) value[s->unused[k]] = 0.0;
  PetscCall(VecRestoreArray(d, &value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the pressure that a side gives at the centre of a spline along it [Pa]: beyond the ends
   of the side it continues linearly. */
static PetscReal GivenPressure(const SplineLattice *l, PetscInt side, const PetscInt index[],
                               PetscReal t)
{
  const Scene *scene           = l->scene;
  PetscReal    x[ISPH_MAX_DIM] = {0.0}, on[ISPH_MAX_DIM] = {0.0}, mirrored[ISPH_MAX_DIM] = {0.0};
  PetscReal    normal[ISPH_MAX_DIM] = {0.0}, at_end;
  PetscBool    beyond               = PETSC_FALSE;

  SplineCentre(l, index, x);
  x[side / 2]      = side % 2 ? scene->hi[side / 2] : scene->lo[side / 2];
  normal[side / 2] = side % 2 ? -1.0 : 1.0;
  for (PetscInt a = 0; a < l->dim; a++) {
    on[a]       = PetscMin(PetscMax(x[a], scene->lo[a]), scene->hi[a]);
    mirrored[a] = 2.0 * on[a] - x[a];
    beyond      = beyond || on[a] != x[a];
  }
  at_end = SceneWallPressure(scene, side, t, on, normal);
  return beyond ? 2.0 * at_end - SceneWallPressure(scene, side, t, mirrored, normal) : at_end;
}

/* SplinesStart - Sets the pressure at the start of a run to the exact pressure of the case, if it
   has one, or to the level of the scene; not collective */
PetscErrorCode SplinesStart(const Flow *flow, Splines *s)
{
  const Scene    *scene = flow->scene;
  const PetscBool exact =
      scene->problem->Exact && !scene->velocity.n && !flow->particles->velocity_given;
  PetscScalar *p;
  PetscInt     first, last;

  PetscFunctionBegin;
  PetscCall(VecGetOwnershipRange(s->natural, &first, &last));
  PetscCall(VecGetArray(s->natural, &p));
  for (PetscInt q = first; q < last; q++) {
    PetscInt  index[ISPH_MAX_DIM], side;
    PetscReal x[ISPH_MAX_DIM], u[ISPH_MAX_DIM];
    PetscBool given;

    SplineIndex(scene->dim, NULL, s->lattice.count, q % s->lattice.N, index);
    given        = SplineIsGiven(&s->lattice, index, &side);
    p[q - first] = given ? 2.0 * scene->level : scene->level;
    if (!exact) continue;
    SplineCentre(&s->lattice, index, x);
    if (given) p[q - first] = 2.0 * GivenPressure(&s->lattice, side, index, 0.0);
    else scene->problem->Exact(scene, 0.0, x, u, &p[q - first]);
  }
  PetscCall(VecRestoreArray(s->natural, &p));
  PetscCall(VecCopy(s->natural, s->kept));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesGivePressure - Sets the numbers that sides give to those of the pressure at time t, less
   the present ones for an increment. Not collective. The number of a spline is twice the pressure
   on the side at its centre along the side, see splineextend.c. Input and output: v - the pressure,
   or the right-hand side of its increment. */
PetscErrorCode SplinesGivePressure(PetscReal t, PetscBool increment, const Splines *s, Vec v)
{
  const PetscScalar *now = NULL;
  PetscScalar       *value;

  PetscFunctionBegin;
  if (!SplineSideGives(&s->lattice)) PetscFunctionReturn(PETSC_SUCCESS);
  if (increment) PetscCall(VecGetArrayRead(s->p, &now));
  PetscCall(VecGetArray(v, &value));
  for (PetscInt e = 0; e < s->n_unused; e++) {
    const PetscInt k = s->unused[e];
    PetscInt       index[ISPH_MAX_DIM], side;

    (void)SplineOwn(s, k, index);
    if (!SplineIsGiven(&s->lattice, index, &side)) continue;
    value[k] = 2.0 * GivenPressure(&s->lattice, side, index, t) - (now ? now[k] : 0.0);
  }
  PetscCall(VecRestoreArray(v, &value));
  if (increment) PetscCall(VecRestoreArrayRead(s->p, &now));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a sum of splines to the values at own particles of a fluid; fluid -1: of all. Collective. */
static PetscErrorCode AddIn(const Particles *particles, Splines *s, Vec coefficients,
                            PetscInt fluid, Vec to)
{
  const PetscScalar *from;
  PetscScalar       *sum;
  Vec                value;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(to, &value));
  PetscCall(SplinesValue(s, coefficients, value));
  PetscCall(VecGetArrayRead(value, &from));
  PetscCall(VecGetArray(to, &sum));
  for (PetscInt i = 0; i < particles->n_fluid; i++)
    if (fluid < 0 || (PetscInt)particles->fluid[i] == fluid) sum[i] += from[i];
  PetscCall(VecRestoreArray(to, &sum));
  PetscCall(VecRestoreArrayRead(value, &from));
  PetscCall(VecDestroy(&value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesLayerStress - Creates the stress of the layer below a free surface at own fluid, see
   splinelayer.c; collective */
PetscErrorCode SplinesLayerStress(const Flow *flow, Splines *s, Vec *stress)
{
  const PetscScalar *layer;
  PetscScalar       *to;
  Vec                all, part;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(s->all, &all));
  PetscCall(VecSet(all, 0.0));
  PetscCall(SplineLayerSet(s, 0.0, all));
  PetscCall(VecDuplicate(s->p, &part));
  PetscCall(VecDuplicate(flow->state->p, stress));
  PetscCall(VecSet(*stress, 0.0));
  for (PetscInt f = 0; f < s->fluids; f++) {
    PetscCall(VecGetArrayRead(all, &layer));
    PetscCall(VecGetArray(part, &to));
    PetscCall(PetscArraycpy(to, layer + f * s->own.size, s->own.size));
    PetscCall(VecRestoreArray(part, &to));
    PetscCall(VecRestoreArrayRead(all, &layer));
    PetscCall(AddIn(flow->particles, s, part, s->fluids == 1 ? -1 : f, *stress));
  }
  PetscCall(VecDestroyAll(&all, &part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the kept numbers of splines that have masters to what these give. When a body that moves
   leaves such a spline, it begins with this number. */
static PetscErrorCode KeepSlaves(Splines *s)
{
  const SplineExtension *e = s->extension;
  PetscInt               first, last, n = 0, *master;
  PetscScalar           *number;
  VecScatter             gather;
  Vec                    masters;
  IS                     from;

  PetscFunctionBegin;
  if (!s->lattice.scene->pose || !e) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetOwnershipRange(s->natural, &first, &last));
  PetscCall(PetscMalloc1(e->n * SPLINE_MASTERS, &master));
  for (PetscInt q = first; q < last; q++)
    for (PetscInt k = 0; e->slave[q] >= 0 && k < e->slaves[e->slave[q]].n; k++)
      master[n++] = SplineNatural(&s->lattice, e->slaves[e->slave[q]].master[k]);
  PetscCall(ISCreateGeneral(PETSC_COMM_SELF, n, master, PETSC_OWN_POINTER, &from));
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, n, &masters));
  PetscCall(VecScatterCreate(s->natural, from, masters, NULL, &gather));
  PetscCall(VecScatterBegin(gather, s->natural, masters, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(gather, s->natural, masters, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGetArray(masters, &number));
  n = 0;
  for (PetscInt q = first; q < last; q++) {
    const SplineSlave *slave = e->slave[q] >= 0 ? &e->slaves[e->slave[q]] : NULL;
    PetscScalar        sum   = 0.0;
    PetscInt           index[ISPH_MAX_DIM], side;

    if (!slave) continue;
    for (PetscInt k = 0; k < slave->n; k++) sum += slave->weight[k] * number[n++];
    SplineIndex(s->lattice.dim, NULL, s->lattice.count, q, index);
    if (!SplineIsGiven(&s->lattice, index, &side))
      PetscCall(VecSetValue(s->natural, q, sum, INSERT_VALUES));
  }
  PetscCall(VecRestoreArray(masters, &number));
  PetscCall(VecAssemblyBegin(s->natural));
  PetscCall(VecAssemblyEnd(s->natural));
  PetscCall(VecScatterDestroy(&gather));
  PetscCall(VecDestroy(&masters));
  PetscCall(ISDestroy(&from));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesFollow - Cuts the cells of the splines anew by bodies that move; collective */
PetscErrorCode SplinesFollow(Splines *s)
{
  PetscFunctionBegin;
  if (!s->bodies || !s->lattice.scene->pose) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SplineBodiesDestroy(&s->bodies));
  PetscCall(SplineExtensionDestroy(&s->extension));
  PetscCall(SplineBodiesCreate(s->lattice.scene, &s->lattice, &s->bodies));
  PetscCall(SplineExtensionCreate(&s->lattice, s->bodies, &s->extension));
  s->lo[0] = -PETSC_MAX_REAL; /* all that depends on the numbers of splines is old */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesSpread - Sets the pressure of particles to the splines' and removes an undetermined mean;
   keeps a copy in the order of the lattice; collective */
PetscErrorCode SplinesSpread(Flow *flow, Splines *s)
{
  FlowState *state = flow->state;
  PetscReal  sum;

  PetscFunctionBegin;
  PetscCall(SplinesValue(s, s->p, state->p));
  for (PetscInt f = 0; f < s->n_jumps; f++)
    PetscCall(AddIn(flow->particles, s, s->jumps[f], f + 1, state->p));
  if (ScenePressureFloats(flow->scene)) {
    PetscCall(FluidSum(flow->particles, state->p, PETSC_FALSE, &sum));
    PetscCall(VecShift(s->p, -sum / flow->particles->weight));
    PetscCall(VecShift(state->p, -sum / flow->particles->weight));
  }
  PetscCall(VecScatterBegin(s->renumber, s->all, s->natural, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(s->renumber, s->all, s->natural, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(KeepSlaves(s));
  PetscCall(VecCopy(s->natural, s->kept));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns this rank's part of the jump of the pressure at a place, which has the
   fluid of the nearest particle [Pa]. */
static PetscReal JumpAt(const Splines *s, const Particles *p, const PetscReal x[])
{
  PetscReal          best = PETSC_INFINITY, sum = 0.0;
  PetscInt           fluid = 0;
  SplineRow          at;
  const PetscScalar *z;

  if (!s->n_jumps) return 0.0;
  for (PetscInt j = 0; j < ParticlesAll(p); j++) {
    PetscReal r2 = 0.0;

    if (ParticlesIsWall(p, j)) continue;
    for (PetscInt a = 0; a < p->dim; a++) r2 += PetscSqr(p->x[a][j] - x[a]);
    if (r2 < best) fluid = (PetscInt)p->fluid[j];
    best = PetscMin(best, r2);
  }
  if (!fluid) return 0.0;
  SplineRowAt(s, &s->lattice, p, x, &at);
  if (VecGetArrayRead(s->jumps[fluid - 1], &z)) return 0.0;
  for (PetscInt k = 0; k < at.n; k++) {
    const PetscInt own = at.number[k] - s->own.start;

    if (own >= 0 && own < s->own.size) sum += at.value[k] * z[own];
  }
  return VecRestoreArrayRead(s->jumps[fluid - 1], &z) ? 0.0 : sum;
}

/* SplinesPressure - Computes this rank's part of the pressure at a point [Pa]; the sum over all
   ranks is the pressure; not collective */
PetscErrorCode SplinesPressure(const Splines *s, const Particles *particles, const PetscReal x[],
                               PetscReal *p)
{
  const PetscScalar *coefficient;
  SplineRow          at;

  PetscFunctionBegin;
  SplineRowAt(s, &s->pressure, particles, x, &at);
  *p = JumpAt(s, particles, x);
  PetscCall(VecGetArrayRead(s->p, &coefficient));
  for (PetscInt k = 0; k < at.n; k++) {
    const PetscInt own = at.number[k] - s->own.start;

    if (own >= 0 && own < s->own.size) *p += at.value[k] * coefficient[own];
  }
  PetscCall(VecRestoreArrayRead(s->p, &coefficient));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesView - Prints the splines for the banner; collective */
PetscErrorCode SplinesView(const Splines *s, PetscViewer viewer)
{
  char text[64] = "", part[24];

  PetscFunctionBegin;
  for (PetscInt a = 0; a < s->lattice.dim; a++) {
    PetscCall(
        PetscSNPrintf(part, sizeof(part), "%s%" PetscInt_FMT, a ? " x " : "", s->lattice.cells[a]));
    TextAppend(text, sizeof(text), part);
  }
  PetscCall(
      PetscViewerASCIIPrintf(viewer, "%-11s coarse: %s B-splines on %s cells, fixed in space\n",
                             "pressure", s->pressure.degree == 3 ? "cubic" : "quadratic", text));
  PetscFunctionReturn(PETSC_SUCCESS);
}
