/* State and functions of the weakly compressible scheme. wcsphcreate.c reads its options,
   equations.c has the equations of state, rates.c the rates of change, pairs.c the sums over
   neighbours, dynamicwalls.c the densities of walls, and integrate.c the TS. */
#ifndef ISPH_SCHEMES_WCSPH_H
#define ISPH_SCHEMES_WCSPH_H

#include "isph/motion.h"
#include "isph/solvers.h"

extern const Table       EquationOfStateTable, DensityFormTable, PressureReductionTable;
extern const OptionTable WcsphOptions;

#define WCSPH_MOVE_MOST  0.2  /* of a particle in a step, for halos that serve all stages [dx] */
#define WCSPH_SOUND      1e-3 /* rms of velocities by sound that the bound allows [c0] */
#define WCSPH_MACH       0.2  /* Mach number above which the run prints a note [-] */
#define WCSPH_VARIATION  0.03 /* |rho/rho_0 - 1| above which it does [-] */
#define WCSPH_COMPONENTS (2 * ISPH_MAX_DIM + 2)

typedef struct Wcsph Wcsph;

/* Equations of state. Pressures are differences to the pressure at rest, Wcsph.p_rest. */
typedef struct {
  const char *name, *brief, *citation;
  PetscReal   exponent;   /* gamma [-] */
  PetscBool   has_energy; /* depends on the internal energy */
  PetscReal (*Pressure)(const Wcsph *w, PetscReal rho, PetscReal e); /* [Pa] */
  PetscReal (*Density)(const Wcsph *w, PetscReal p);                 /* [kg/m^3] */
} EquationOfStateRow;

/* The density: an unknown of the TS, or a sum over neighbours; with the pressure force that belongs
   to it. */
typedef struct {
  const char *name, *brief, *citation;
  PetscBool   sums;
} DensityFormRow;

/* Pressures that are subtracted before the pressure gradient is computed. */
typedef struct {
  const char *name, *brief, *citation;
  PetscBool   mean; /* of the neighbours */
} PressureReductionRow;

/* The rates of change of a particle. */
typedef struct {
  PetscReal u[ISPH_MAX_DIM]; /* acceleration [m/s^2] */
  PetscReal rho;             /* [kg/(m^3 s)] */
  PetscReal e;               /* of the internal energy [J/(kg s)] */
} Rates;

/* Quantities of the neighbours of a particle; arrays of the stencil's capacity. */
typedef struct {
  PetscInt          capacity;
  PetscReal *const *c;                /* slope of the stencil, see StencilGradients() [1/m] */
  PetscReal        *du[ISPH_MAX_DIM]; /* u_k - u_i [m/s] */
  PetscReal        *p, *rho;          /* [Pa], [kg/m^3] */
  PetscReal        *w;                /* weights of the viscous form; workspace */
} Pairs;

/* The particle and the form of its pressure force in PairsSum(). */
typedef struct {
  PetscBool by_sums;   /* the force that belongs to -density_form summation */
  PetscBool corrected; /* the kernel has a correction */
  PetscReal rho, p;    /* [kg/m^3], [Pa] */
} PairTerms;

typedef struct {
  PetscReal divergence;              /* [1/s] */
  PetscReal diffusion;               /* [kg/m^5] */
  PetscReal laplacian[ISPH_MAX_DIM]; /* of the velocity [1/(m s)] */
  PetscReal pressure[ISPH_MAX_DIM];  /* acceleration [m/s^2] */
} PairSums;

/* Values by local index, with the halo. */
typedef struct {
  PetscInt   capacity;
  PetscReal *u[ISPH_MAX_DIM], *rho, *p, *e;       /* e: NULL without energy */
  PetscReal *stress[ISPH_MAX_DIM * ISPH_MAX_DIM]; /* of a composed form, else NULL [Pa] */
  PetscReal *divergence;                          /* beside it, own particles [1/s] */
  PetscInt  *found;                               /* beside dynamic walls: fluid near a place */
  PetscReal *packed; /* V, rho, p and u of each particle, side by side for WcsphSetPairs() */
} LocalFlow;

struct Wcsph {
  const EquationOfStateRow   *equation;
  const DensityFormRow       *density;
  const PressureReductionRow *reduction;
  PetscBool                   follows; /* viscosity is PairSums.laplacian */
  PetscReal                   c0;      /* speed of sound at rest [m/s] */
  PetscReal                   p_rest;  /* pressure at rest, not zero for a gas [Pa] */
  PetscReal                   e_rest;  /* internal energy at rest [J/kg] */
  PetscReal                   courant; /* of sound [-] */
  PetscReal                   lattice; /* WcsphLatticeSum() [-] */
  PetscReal                   volume;  /* of the fluid at the start, if it stays [m^dim] */
  PetscReal                   diffusion;
  PetscReal                   artificial[2]; /* alpha, beta [-] */

  PetscReal *rho, *e;    /* fields of the particles; e NULL: no energy */
  PetscReal *wall_start; /* field of dynamic walls: see WallDensities() [kg/m^3]; NULL: none */
  PetscReal *surface;    /* field: 1 beside a free surface at the start; NULL: not needed */

  Guard      guard; /* names the TS in messages; it has no KSP */
  TS         ts;
  Vec        y;     /* components of all own particles, one component after the other */
  PetscInt   epoch; /* of y */
  PetscInt   components;
  PetscReal *start[ISPH_MAX_DIM]; /* positions at the start of the step [m] */
  PetscReal *shift; /* changes of the unknowns by shifting, in the order of y; NULL without */

  /* of the present rates */
  Flow      *flow;
  PetscReal  t;
  LocalFlow  local;
  Pairs      pairs;
  PetscReal *rate;        /* of the TS: where the rates go */
  PetscBool  first_stage; /* of the step */
  PetscReal  divergence;  /* largest |drho/dt|/rho [1/s] */

  PetscReal     mach, variation; /* largest of the run [-] */
  PetscReal     passage; /* time in which sound crosses L over that of the run, if walls move [-] */
  PetscReal     artificial_over_nu; /* see ArtificialShare() [-] */
  PetscLogEvent event;
};

/* wcsphcreate.c */
PetscErrorCode WcsphCreate(Flow *flow);

/* equations.c */
void WcsphListUnknowns(Wcsph *w, PetscReal *const x[], PetscReal *const u[], PetscReal *rho,
                       PetscReal *e, PetscReal *of[]);
void WcsphComponents(Wcsph *w, PetscReal *of[]);

/* step.c */
extern const Stage *const WcsphStages[];
PetscBool                 WcsphKeepsVolume(const Flow *flow);
PetscErrorCode            WcsphVolume(const Flow *flow, PetscReal *volume);
PetscErrorCode            WcsphSetPressure(Flow *flow);

/* integrate.c */
PetscErrorCode WcsphCreateIntegrator(Flow *flow, Wcsph *w);
PetscErrorCode WcsphIntegrate(Flow *flow);
PetscErrorCode WcsphFree(Wcsph *w);

/* rates.c */
PetscErrorCode WcsphFindSurface(Flow *flow, Wcsph *w);
PetscReal      WcsphLatticeSum(const Flow *flow);
PetscErrorCode WcsphReserve(const Flow *flow, Wcsph *w);
PetscErrorCode WcsphSetDensity(Flow *flow, Wcsph *w);
PetscErrorCode WcsphRates(Flow *flow, Wcsph *w);
PetscErrorCode WcsphAccelerate(const Flow *flow, PetscReal *const rate[]);

/* stress.c */
const ComposedForm *WcsphComposed(const Wcsph *w);
PetscErrorCode      WcsphStresses(Flow *flow, Wcsph *w);
void                StressForce(const Wcsph *w, const Stencil *stencil, PetscReal acceleration[]);

/* shift.c */
PetscBool      WcsphShifts(const Wcsph *w);
void           WcsphShiftRow(Wcsph *w, Stencil *stencil, const PetscReal slope[]);
PetscErrorCode WcsphShift(Flow *flow);

/* dynamicwalls.c */
PetscErrorCode WallStart(Wcsph *w);
PetscErrorCode WallDensities(const Wcsph *w, PetscReal rho[]);
PetscErrorCode WallVelocities(Wcsph *w);

/* pairs.c */
#define PACKED(dim) (3 + (dim)) /* values of a particle in LocalFlow.packed */
PetscErrorCode WcsphSetPairs(Wcsph *w, const PetscReal force[], Stencil *stencil);
PetscErrorCode PairsReserve(PetscInt capacity, Pairs *pairs);
PetscErrorCode PairsFree(Pairs *pairs);
void           PairsFinish(PetscReal rho, const Stencil *stencil, Pairs *pairs);
void PairsSum(const Stencil *stencil, const Pairs *pairs, const PairTerms *own, PairSums *sums);
PetscReal PairsEnergy(const Stencil *stencil, const Pairs *pairs, PetscReal rho, PetscReal p);
void ArtificialViscosity(const Stencil *stencil, const Pairs *pairs, const PetscReal artificial[],
                         PetscReal c0, PetscReal rho, PetscReal acceleration[]);
PetscReal HydrostaticRise(const Stencil *stencil, const PetscReal slope[]);

#endif
