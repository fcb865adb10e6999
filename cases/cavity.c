/* Lid-driven cavity: a square or cube of side L whose lid y = L moves along x with speed U.
   Profiles of the velocity on centrelines are compared with converged reference data; Ghia's tables
   (cases/reference) are for plots only. */
#include "cases.h"

PetscErrorCode CavitySetup(Scene *scene)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) scene->hi[a] = scene->length;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CavityWallVelocity - Computes wall velocities: the lid is the wall at the high end of y */
void CavityWallVelocity(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[],
                        PetscReal u[])
{
  if (side == 3) u[0] = scene->speed;
}

/* References: extrema on the centrelines, divided by U; the time interval in which they are valid
   (in L/U, below Re = 10 in L^2/nu); and the files of profiles. The finite-volume data were
   extrapolated from two or three meshes (see the headers of the files). */
typedef struct {
  PetscInt    dim;
  PetscReal   reynolds_low, reynolds_high, from, to;
  PetscReal   u_min, v_max, v_min; /* NaN: none */
  const char *u_file, *v_file;
} CavityReference;

static const CavityReference references[] = {
    /* Stokes flow: the biharmonic equation, six digits, by studies/stokes_cavity */
    {2, 0.0, 0.1, 0.2, PETSC_MAX_REAL, -0.207756, 0.184445, -0.184445, NULL, NULL},
    /* finite volumes, Richardson extrapolation; after 0.2 L^2/nu the slowest mode has decayed by
       e^-10 */
    {2, 0.999, 1.001, 0.2, PETSC_MAX_REAL, -0.20775, 0.18406, -0.18482, "cavity_re1_u.csv",
     "cavity_re1_v.csv"},
    {2, 99.9, 100.1, 9.99, 10.01, -0.21352, 0.17839, -0.25268, "cavity_re100_t10_u.csv",
     "cavity_re100_t10_v.csv"},
    {2, 99.9, 100.1, 19.9, PETSC_MAX_REAL, -0.21404, 0.17957, -0.25380, "cavity_re100_u.csv",
     "cavity_re100_v.csv"},
    {2, 399.9, 400.1, 40.0, PETSC_MAX_REAL, -0.32873, 0.30383, -0.45407, "cavity_re400_u.csv",
     "cavity_re400_v.csv"},
    /* at t = 40 from rest the flow is not yet steady */
    {2, 999.9, 1000.1, 39.9, 40.1, -0.38730, 0.37541, -0.52594, "cavity_re1000_t40_u.csv",
     "cavity_re1000_t40_v.csv"},
    {3, 99.9, 100.1, 12.0, PETSC_MAX_REAL, -0.21560, 0.15298, -0.24923, "cavity3d_re100_u.csv",
     "cavity3d_re100_v.csv"},
    {3, 399.9, 400.1, 30.0, PETSC_MAX_REAL, -0.23666, 0.20809, -0.38145, "cavity3d_re400_u.csv",
     "cavity3d_re400_v.csv"},
    /* Botella & Peyret, Computers & Fluids 27 (1998) 421-433, spectral */
    {2, 999.9, 1000.1, 40.1, PETSC_MAX_REAL, -0.38857, 0.37694, -0.52708, "cavity_re1000_u.csv",
     "cavity_re1000_v.csv"},
};

/* Returns true if the run has the physics of a reference; a reference of creeping flow also holds
   without convection. */
static PetscBool ReferenceApplies(const Scene *scene, const CavityReference *r)
{
  const unsigned full = scene->problem->physics;

  if (scene->physics == full) return PETSC_TRUE;
  return r->reynolds_low == 0.0 && scene->physics == (full & ~(unsigned)PHYSICS_CONVECTION);
}

/* Returns the reference that is valid at the present time, or NULL; for a steady flow, a reference
   that is valid at all late times. */
static const CavityReference *FindReference(const Scene *scene, const Clock *clock)
{
  const PetscReal reynolds = SceneReynolds(scene);
  const PetscReal unit =
      reynolds < 10.0 ? PetscSqr(scene->length) / scene->nu : scene->length / scene->speed;

  if (!SceneIsNewtonian(scene)) return NULL;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(references); k++) {
    const CavityReference *r = &references[k];

    if (!ReferenceApplies(scene, r)) continue;
    if (r->dim != scene->dim || reynolds < r->reynolds_low || reynolds > r->reynolds_high) continue;
    if (clock->t >= r->from * unit && clock->t <= r->to * unit) return r;
    if (clock->steady && r->to == PETSC_MAX_REAL) return r;
  }
  return NULL;
}

/* Reports extrema and profiles of the velocity on the centrelines, in units of U: u on the line x =
   L/2 and v on the line y = L/2, with all other coordinates in the middle. */
static PetscErrorCode CavityMeasure(const Flow *flow, Report *report)
{
  const CavityReference *r = FindReference(flow->scene, flow->clock);
  const PetscReal reynolds = SceneIsNewtonian(flow->scene) ? SceneReynolds(flow->scene) : NAN;
  PetscReal       energy;

  PetscFunctionBegin;
  PetscCall(
      CentrelineExtrema(flow, r ? r->u_min : NAN, r ? r->v_max : NAN, r ? r->v_min : NAN, report));
  if (r && r->u_file) {
    PetscCall(CentrelineProfile(flow, 1, 0, r->u_file, "u_profile_l2", report));
    PetscCall(CentrelineProfile(flow, 0, 1, r->v_file, "v_profile_l2", report));
  }
  PetscCall(ReferenceEnergy(flow,
                            PetscAbsReal(reynolds - 100.0) < 0.1     ? "cavity_re100_ke.csv"
                            : PetscAbsReal(reynolds - 1000.0) < 0.1  ? "cavity_re1000_ke.csv"
                            : PetscAbsReal(reynolds - 10000.0) < 1.0 ? "cavity_re10000_ke.csv"
                                                                     : NULL,
                            report, &energy));
  PetscCall(MeasureCommon(flow, energy, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const CaseRow CaseCavity = {
    .name            = "cavity",
    .brief           = "lid-driven square or cubic cavity",
    .citation        = "Botella & Peyret, Computers & Fluids 27 (1998)",
    .three_d         = PETSC_TRUE,
    .physics         = NAVIER_STOKES | PHYSICS_WALLS,
    .reynolds        = 100.0,
    .reynolds_length = 1.0,
    .t_end           = 20.0,
    .n               = 50,
    .Setup           = CavitySetup,
    .WallVelocity    = CavityWallVelocity,
    .Measure         = CavityMeasure,
};
