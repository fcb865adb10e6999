/* The scene: a complete and checked description of the flow, made before any particle exists. It
   has the domain, the fluid, the forces and the physics of the case, and nothing about its
   numerical solution. */
#ifndef ISPH_SCENE_H
#define ISPH_SCENE_H

#include "isph/mesh.h"
#include "isph/quantities.h"
#include "isph/regime.h"

typedef struct Scene  Scene;
typedef struct Flow   Flow;
typedef struct Report Report;

/* Physics of a case. Absent physics is neither allocated nor computed, written or printed. */
typedef enum {
  PHYSICS_VISCOSITY  = 1 << 0, /* nu lap u */
  PHYSICS_PRESSURE   = 1 << 1, /* div u = 0 and its pressure */
  PHYSICS_CONVECTION = 1 << 2, /* u.grad u: particles move, or the term of the fixed ones */
  PHYSICS_WALLS      = 1 << 3, /* solid boundaries */
  PHYSICS_BODY_FORCE = 1 << 4  /* a force per unit mass */
} Physics;
#define PHYSICS_COUNT 5
extern const char *const PhysicsNames[PHYSICS_COUNT + 1]; /* in the order of bits; ends with NULL */

#define WALL_PLANES      24 /* most boundaries near a place: the nearest */
#define WALL_NAME        24 /* size of a wall name */
#define PLACE_TEXT       48 /* size of the text of a place */
#define KIND_NAME        32 /* size of the name of a kind of boundaries, with a comma */
#define SCENE_MAX_FLUIDS 8
#define SCENE_MAX_FILLED 16
#define SCENE_MAX_PARTS  16
#define SCENE_ON_SURFACE 1e-9 /* rounding of distances from a surface [dx] */

/* Properties of a kind of boundary; all other code depends on these instead of the kind. */
typedef enum {
  BOUNDARY_CONTINUES = 1 << 0, /* the fluid continues at the opposite side */
  BOUNDARY_PARTICLES = 1 << 1, /* wall particles on or behind it bring its equations into fits */
  BOUNDARY_CONFINES  = 1 << 2, /* impermeable */
  BOUNDARY_NO_SLIP   = 1 << 3, /* the fluid has the velocity of the boundary */
  BOUNDARY_INFLOW    = 1 << 5, /* fluid enters or leaves with the velocity of the boundary */
  BOUNDARY_OUTFLOW   = 1 << 6  /* fluid leaves or returns at a given pressure */
} BoundaryProperty;

/* The equation that a particle on a boundary gives to a least-squares fit of a quantity f. */
typedef enum {
  EQUATION_NONE,             /* no equation: the fit uses the fluid alone */
  EQUATION_VALUE,            /* f is given */
  EQUATION_NORMAL_DERIVATIVE /* n.grad f is given */
} Equation;

/* Quantities of a fit for which a kind of boundary may have different equations. */
typedef enum {
  FIT_VELOCITY_NORMAL,     /* component of the velocity along the normal */
  FIT_VELOCITY_TANGENTIAL, /* component along the boundary */
  FIT_PRESSURE,            /* n.grad p follows from the momentum, or the boundary gives p */
  FIT_PRESSURE_FREE,       /* pressure where n.grad p is not known before the solve */
  FIT_QUANTITIES
} FitQuantity;

typedef struct {
  const char *name, *brief, *citation;
  OptionRow   option;     /* of typed boxes: its words are BoxSides, or BoxAxes for both sides of an
                             axis; without name: the kind follows from the geometry */
  unsigned    properties; /* bits of BoundaryProperty */
  Equation    equation[FIT_QUANTITIES]; /* for each quantity; EQUATION_NONE where none stands */
  PetscReal (*Pressure)(const Scene *scene, PetscInt side, PetscReal t,
                        const PetscReal x[]); /* of EQUATION_VALUE; NULL: 0 [Pa] */
} BoundaryRow;
extern const Table       BoundaryTable;
extern const char *const BoxAxes[], *const BoxSides[]; /* NULL after the last */
extern const BoundaryRow BoundaryWall, BoundaryPeriodic, BoundarySymmetry, BoundarySlip,
    BoundaryNone, BoundaryInflow; /* kinds that cases and options set */

/* The freedom of a body that moves by the forces on it, see src/scene/freebodies.c; in 2D per metre
   of depth. */
#define FREEDOM_SPIN 3 /* number of the first component of the spin, after those of the velocity */
typedef struct {
  PetscReal  mass, volume;                        /* mass 0: the body is not free [kg], [m^dim] */
  PetscReal  inertia[ISPH_MAX_DIM][ISPH_MAX_DIM]; /* about the centre, as typed [kg m^2] */
  unsigned   held;          /* bits of the components of velocity and spin that no force changes */
  Expression force, torque; /* besides those of the fluid, of t; n = 0: none [N], [N m] */
  PetscReal  spring[ISPH_MAX_DIM]; /* stiffness along each axis [N/m] */
} Freedom;

/* A boundary of the fluid: a side of the box, or a body. */
typedef struct {
  const BoundaryRow *kind;
  Body               body;       /* its geometry; unused by sides of the box */
  PetscBool          moves;      /* a body that changes its place, see Body.pose */
  PetscBool          free;       /* it moves by Newton's law: its pose has the motion */
  Expression         velocity;   /* function of place and t on a side, of t on a body [m/s] */
  Expression         rotation;   /* of a body about its centre, function of t: about z, or about
                                    three axes in 3D [rad/s] */
  Expression         position;   /* of the centre of a body, function of t; n = 0: not given [m] */
  Expression         turn;       /* of a body from where it was typed, function of t: an angle times
                                    a constant axis; n = 0: it follows from rotation [rad] */
  PetscBool          rides;      /* a body that turns with Scene.frame */
  Expression         pressure;   /* on an outflow, function of place, t; n = 0: zero [Pa] */
  Freedom            freedom;    /* of a body */
  PetscReal          slip;       /* depth behind the side at which fluid would stick [m] */
  PetscReal          contact;    /* cosine of the angle in the fluid between it and a surface [-] */
  PetscReal          opening[2]; /* part of an inflow side through which fluid enters, in 2D [m] */
  Body               hole; /* the same in 3D, in the axes along the side; without shape: all */
} Boundary;

/* A part of the surface of the domain: inside a shape, with a velocity of its own. */
typedef struct {
  Body       shape;
  Expression velocity; /* function of place and t [m/s] */
} SurfacePart;

/* A tangent plane of a boundary at its point nearest to a position x. */
typedef struct {
  PetscReal distance;             /* of x from the boundary, positive in the fluid [m] */
  PetscReal normal[ISPH_MAX_DIM]; /* unit, into the fluid */
  PetscInt  side;                 /* the number of the boundary in Scene.boundary */
} WallPlane;

/* A case: geometry, initial and boundary values, exact solution or reference data, but no time loop
   and no scheme. */
typedef struct {
  const char *name, *brief, *citation;
  PetscBool   three_d;                   /* -dim 3 allowed */
  unsigned    physics;                   /* bits of Physics */
  PetscReal   reynolds;                  /* default [-] */
  PetscReal   reynolds_length;           /* its length, Re = U length/nu [reference lengths] */
  PetscReal   t_end;                     /* default [L/U] */
  PetscInt    n;                         /* default particles along the reference length */
  PetscErrorCode (*Setup)(Scene *scene); /* box, boundaries, length, speed, nu, force */
  void (*Velocity)(const Scene *scene, PetscReal t, const PetscReal x[],
                   PetscReal u[]); /* at t=0 */
  void (*WallVelocity)(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[],
                       PetscReal u[]); /* of sides; NULL: Boundary.velocity, 0 if not given */
  void (*Exact)(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[],
                PetscReal *p);                                 /* NULL: none; need not set p */
  PetscErrorCode (*Measure)(const Flow *flow, Report *report); /* adds the quantities of the case */
  PetscReal solid_fraction; /* default, of an array of bodies; 0: no array [-] */
  PetscBool typed;          /* the geometry comes from -scene_ options */
  PetscBool patch;          /* patch test: no flow, operators only, given values around the box */
} CaseRow;

/* Motion of particles with the flow, or fixed particles. */
typedef struct {
  const char *name, *brief, *citation;
  PetscBool   particles_move, turns; /* with the flow; they are fixed in Scene.frame */
} MotionRow;
extern const Table MotionTable;

/* Parameters of the kinematic viscosity as a function of the strain rate g = sqrt(2 E:E).
   Parameters with mass in their unit are divided by the density. */
typedef enum {
  RHEOLOGY_CONSISTENCY,    /* K [m^2 s^(n-2)] */
  RHEOLOGY_EXPONENT,       /* n [-] */
  RHEOLOGY_TIME,           /* lambda [s] */
  RHEOLOGY_INFINITE,       /* nu_inf [m^2/s] */
  RHEOLOGY_YIELD,          /* tau_0 [m^2/s^2] */
  RHEOLOGY_REGULARISATION, /* m [s] */
  RHEOLOGY_PARAMETERS
} RheologyParameter;
#define RHEOLOGY_BIT(parameter) (1u << (parameter))
typedef struct Rheology Rheology;
/* A place of the fluid, with the present scalars there. */
typedef struct {
  PetscReal x[ISPH_MAX_DIM], field[EXPRESSION_FIELDS_MOST]; /* [m] */
} FluidPlace;
typedef struct {
  const char *name, *brief, *citation;
  unsigned    takes, wants; /* RHEOLOGY_BIT()s; `wants` have no default */
  /* NULL: Newtonian [m^2/s] */
  PetscReal (*Nu)(const Rheology *rheology, const FluidPlace *at, PetscReal rate);
  PetscReal (*Rate)(const Rheology *rheology,
                    PetscReal       stress); /* see RheologyRate(); NULL: by bisection [1/s] */
} RheologyRow;
extern const Table RheologyTable;
struct Rheology {
  const RheologyRow *row; /* NULL: newtonian */
  PetscReal          nu;  /* Scene.nu [m^2/s] */
  PetscReal          parameter[RHEOLOGY_PARAMETERS];
  PetscReal          low, high; /* bounds of the viscosity [m^2/s] */
  const Expression  *typed;     /* NULL: the viscosity depends on the strain rate only [m^2/s] */
  PetscReal          t;         /* present time [s] */
};

/* Map of the lattice along an axis, whose cells are smaller at walls: theory.md,
   (particles:stretched). */
typedef struct {
  PetscReal strength;    /* beta of the map; 0: uniform [-] */
  PetscReal end;         /* tanh(beta) */
  PetscBool wall[2];     /* cells are smaller at the low and at the high end */
  PetscReal least, most; /* edges of the smallest and the largest cell [m] */
} LatticeMap;

#define GRADING_ROWS 2 /* ordered rows of particles along walls, with the spacing of the wall */

/* Isotropic grading: the spacing as a function of place, theory.md, (particles:spacing). */
typedef struct {
  PetscBool  on;
  Expression spacing;                /* function of x, y, z; n = 0: not given [dx] */
  PetscReal  growth;                 /* per distance from walls and bodies; 0: not given [-] */
  PetscReal  least, most;            /* bounds of the spacing [m] */
  PetscReal  growth_most;            /* largest growth from a particle to the next [-] */
  PetscReal  even[2 * ISPH_MAX_DIM]; /* spacing on a side in 3D; 0: it differs there [m] */
} Grading;

/* A frame of reference that turns about an axis along z. Fixed particles, bodies and velocities are
   in its axes; places, velocities and forces that options and files have are in the laboratory. */
typedef struct {
  Expression rate;      /* w, function of t [rad/s] */
  PetscReal  centre[2]; /* of the axis [m] */
  PetscReal  t, angle;  /* the last time asked for, and the angle then [s], [rad] */
  PetscReal *sum;       /* angles at the starts of panels of the integral of w [rad] */
  PetscInt   panels;    /* number of these */
} TurningFrame;

#define SCENE_SOLUTION 7 /* largest number of numbers of an exact solution */

struct Scene {
  const CaseRow   *problem;
  const MotionRow *motion;  /* NULL: no convection */
  TurningFrame    *frame;   /* NULL: that of the laboratory */
  unsigned         physics; /* bits of Physics, after -with and -without */
  unsigned         without; /* bits of -without */

  PetscInt         dim;                 /* 2 or 3 */
  PetscInt         n;                   /* particles along the reference length */
  PetscReal        dx;                  /* reference spacing L/n: the unit "dx" [m] */
  PetscReal        lo[ISPH_MAX_DIM];    /* corners of the box [m] */
  PetscReal        hi[ISPH_MAX_DIM];    /* */
  PetscInt         cells[ISPH_MAX_DIM]; /* particles along each side of the box */
  PetscReal        spacing_wall;        /* at walls; 0 or 1: uniform [dx] */
  LatticeMap       map[ISPH_MAX_DIM];   /* of the lattice along each axis */
  Grading          grading;             /* of particles that are not on a lattice */
  PetscReal        motion_volume;       /* of graded particles that have the flow's velocity: the
                                           mean of V^2 over that of V [m^dim] */
  PetscReal        length;              /* reference length L [m] */
  PetscReal        speed;               /* reference speed U [m/s] */
  PetscReal        rho;                 /* density [kg/m^3] */
  PetscReal        tension;             /* surface tension sigma; 0: none [N/m] */
  PetscReal        outside;             /* pressure outside free surfaces [Pa] */
  PetscReal        level;               /* solves have pressures less this one [Pa] */
  PetscReal        nu; /* kinematic viscosity; if it varies, for Reynolds numbers only [m^2/s] */
  PetscReal        nu_low, nu_high; /* bounds of viscosity in the fluid; nu if uniform [m^2/s] */
  PetscReal        body_force[ISPH_MAX_DIM]; /* body force per unit mass [m/s^2] */
  PetscBool        unsteady_walls;           /* wall velocities depend on time */
  PetscReal        motion_end; /* last time of motions from files; 0: there are none [s] */
  PetscReal        surplus;    /* part of the flow through inflows that enters and must not [-] */
  const Table     *functions;  /* of FunctionRow, for expressions; NULL: none */
  ExpressionScope *scope;      /* of the expressions below; NULL: all are numbers */
  Expression       velocity;   /* typed: at the start, function of place [m/s] */
  Expression       exact;      /* typed: exact u, v[, w][, p], functions of place, t [m/s], [Pa] */
  Expression       force;      /* typed: replaces body_force, function of place, t [m/s^2] */
  /* sides of the box, 2 axis + (0 low, 1 high), then bodies, 2 dim + k */
  Boundary    *boundary;
  PetscInt     n_bodies, boundary_capacity;
  Pose        *pose;                  /* of each body; NULL: all stay as typed */
  SurfacePart  part[SCENE_MAX_PARTS]; /* of the surface of the domain */
  PetscInt     n_parts;
  BodyStore    store;  /* memory of shapes */
  ScalarGiven *scalar; /* that the fluid carries; NULL: none */
  PetscInt     n_scalars;
  Expression   nu_field;                 /* typed: outside the regions, function of place [m^2/s] */
  Body         region[SCENE_MAX_FLUIDS]; /* of fluids 1, 2, ...; later regions cover earlier ones */
  PetscReal    region_nu[SCENE_MAX_FLUIDS]; /* their viscosities mu/rho, see SceneMixes() [m^2/s] */
  PetscReal    region_density[SCENE_MAX_FLUIDS]; /* their densities over rho [-] */
  Expression   tension_field; /* of the free surface; not set: it is `tension` [N/m] */
  PetscReal    region_tension[SCENE_MAX_FLUIDS]; /* of their surfaces [N/m] */
  PetscInt     n_regions;
  Body         filled[SCENE_MAX_FILLED]; /* regions that the fluid fills at the start */
  PetscInt     n_filled;                 /* 0: the fluid fills the box */
  Rheology     rheology;
  PetscReal    jitter;         /* largest random displacement at the start [dx] */
  PetscInt     seed;           /* of the jitter, of the first shift, of random fields */
  PetscReal    solid_fraction; /* of an array of bodies [-] */
  /* numbers of an exact solution that do not depend on place and time; the case computes them in
     its Setup */
  PetscComplex solution[SCENE_SOLUTION];
  PetscReal    margin; /* of a patch test: omitted at each side [dx] */
  Regime      *regime; /* of defaults; callers add the facts of their options */
};

/* SceneMixes - Returns true if fluids differ in density, or their interfaces have a tension; not
   collective. The viscosity of a particle is then mu/rho with the density rho of the fluid outside
   the regions, so that rho times it is the dynamic viscosity mu in each fluid. */
static inline PetscBool SceneMixes(const Scene *scene)
{
  for (PetscInt k = 0; k < scene->n_regions; k++)
    if (scene->region_density[k] != 1.0 || scene->region_tension[k] > 0.0) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* SceneFluidDensity - Returns the density of a fluid over that of fluid 0 [-]; not collective */
static inline PetscReal SceneFluidDensity(const Scene *scene, PetscInt fluid)
{
  return fluid ? scene->region_density[fluid - 1] : 1.0;
}

#define INTERFACE_REACH 4.0 /* largest distance from interfaces that particles carry [dx_i] */

/* Points on the interfaces of two fluids at the start, with normals out of the region. */
typedef struct {
  PetscInt   n, *region; /* points, and the region on whose border each is */
  PetscReal *x, *normal; /* dim values of each [m] */
} InterfacePoints;

extern const OptionTable SceneOptions, SpacingOptions, TypedOptions, BodyOptions, FreeBodyOptions,
    BoundaryOptions, OpeningOptions, RheologyOptions, FrameOptions;

PetscErrorCode     SceneReadTyped(Scene *scene);
PetscErrorCode     SceneReadBodies(PetscBool boxed, Scene *scene);
const SurfacePart *ScenePart(const Scene *scene, const PetscReal x[]);
PetscInt           SceneFluids(const Scene *scene);
PetscErrorCode     SceneCheckMixture(const Scene *scene);
PetscReal          SceneShare(const Scene *scene, const PetscReal x[], PetscInt *other);
PetscInt           SceneFluidAt(const Scene *scene, const PetscReal x[]);
PetscErrorCode     InterfacePointsCreate(const Scene *scene, InterfacePoints *points);
PetscErrorCode     InterfacePointsDestroy(InterfacePoints *points);
PetscReal SceneInterface(const Scene *scene, const InterfacePoints *points, const PetscReal x[],
                         PetscReal most, PetscReal normal[]);
PetscReal SceneViscosityAt(const Scene *scene, const PetscReal x[]);
PetscReal SceneFluidViscosity(const Scene *scene, PetscInt fluid, const PetscReal x[]);
PetscErrorCode SceneCheckFluids(const Scene *scene);
PetscErrorCode SceneCheckFilled(const Scene *scene);
PetscErrorCode SceneCheckBodies(const Scene *scene);
PetscErrorCode SceneCheckMoved(const Scene *scene, PetscReal t, PetscReal depth);
PetscReal      SceneNarrowestGap(const Scene *scene, PetscInt between[2], PetscReal x[]);
PetscErrorCode SceneCheckInflow(Scene *scene, PetscReal t);
PetscErrorCode SceneCheckVelocities(Scene *scene, PetscReal t);
void           SceneDropFullRegions(Scene *scene);
PetscErrorCode SceneReadOpenings(Scene *scene);
PetscBool      SceneHasOpenings(const Scene *scene);
PetscBool      BoundaryIsOpen(const Scene *scene, PetscInt side, const PetscReal x[]);
PetscBool      BoundaryLetsOut(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[]);
PetscReal      BoundaryOpenPart(const Scene *scene, PetscInt side, const PetscReal x[]);
void           BoundaryIntoOpening(const Scene *scene, PetscInt side, PetscReal x[]);
PetscInt       SideSamples(const Scene *scene, PetscInt side);
PetscReal      SideSample(const Scene *scene, PetscInt side, PetscInt k, PetscReal x[]);
PetscReal      SideEntering(PetscInt side, const PetscReal u[]);
PetscReal InflowPressureSlope(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[]);
PetscErrorCode SceneCreate(const OptionRow *cases, const Table *functions, Scene **scene);
PetscErrorCode SceneFreeShapes(Scene *scene);
PetscErrorCode SceneDestroy(Scene **scene);
const char    *ScenePlaceText(const Scene *scene, const PetscReal x[], char text[PLACE_TEXT]);
PetscBool      SceneHas(const Scene *scene, Physics what);
PetscReal      SceneReynolds(const Scene *scene);
PetscBool      SceneIsAsPosed(const Scene *scene);
PetscBool      SceneMoves(const Scene *scene);
PetscBool      SceneKeepsMomentum(const Scene *scene);
PetscBool      SceneIsDrivenInTime(const Scene *scene);
void           SceneWallName(const Scene *scene, PetscInt side, char name[]);
PetscErrorCode SceneReadSpacing(Scene *scene);
PetscBool      SceneIsGraded(const Scene *scene);
PetscBool      SceneIsMapped(const Scene *scene);
PetscBool      SceneMovesGraded(const Scene *scene);
PetscReal      SceneMotionFactor(const Scene *scene, const PetscReal x[]);
PetscReal      GradingSpacing(const Scene *scene, const PetscReal x[]);
PetscErrorCode GradingSample(Scene *scene);
PetscBool      GradingHasRows(const Scene *scene, PetscInt side);
void           LatticeSetMap(Scene *scene, PetscInt axis);
PetscReal      LatticeGrowth(const Scene *scene);
PetscReal      LatticeMotionEdge(const Scene *scene, PetscInt axis);
PetscErrorCode SceneNameConstants(Scene *scene);
PetscReal      SceneLatticePlace(const Scene *scene, PetscInt axis, PetscReal place);
PetscReal      SceneFromUniform(const Scene *scene, PetscInt axis, PetscReal y, PetscReal *slope);
PetscReal      SceneToUniform(const Scene *scene, PetscInt axis, PetscReal x);
PetscReal      SceneGrowth(const Scene *scene);
PetscInt       SceneCellsAlong(const Scene *scene, PetscInt axis);
PetscErrorCode SceneCountCells(PetscInt n, const PetscInt count[], PetscInt *cells);
PetscReal      SceneCellSide(const Scene *scene, PetscInt axis); /* mean edge, about dx [m] */
void           SceneEdges(const Scene *scene, const PetscReal x[], PetscReal edge[]);
void           SceneStretch(const Scene *scene, const PetscReal x[], PetscReal stretch[]);
PetscReal      SceneSpacing(const Scene *scene, const PetscReal x[]); /* prescribed at x [m] */
PetscReal      SceneCoarsest(const Scene *scene);  /* largest spacing anywhere [m] */
PetscReal      SceneFinest(const Scene *scene);    /* smallest spacing anywhere [m] */
PetscReal      SceneTolerance(const Scene *scene); /* reference length of tolerances [m] */
PetscReal      SceneVolume(const Scene *scene);    /* a cell of the lattice of spacing dx [m^dim] */
PetscReal      SceneVolumeAt(const Scene    *scene,
                             const PetscReal x[]); /* of a particle created at x [m^dim] */
void           SceneSetSide(Scene *scene, PetscInt side, const BoundaryRow *kind);
void           SceneSetAxis(Scene *scene, PetscInt axis, const BoundaryRow *kind);
void           SceneSetSides(Scene *scene, const BoundaryRow *kind);
Boundary      *SceneAddBody(Scene *scene);
PetscInt       SceneBodySide(const Scene *scene, PetscInt k);
PetscInt       SceneBoundaries(const Scene *scene);
const Body    *SceneBody(const Scene *scene, PetscInt k);
const Body    *BoundaryBody(const Scene *scene, PetscInt side);
PetscBool      BoundaryIs(const Scene *scene, PetscInt side, unsigned properties);
Equation       BoundaryEquation(const Scene *scene, PetscInt side, FitQuantity quantity);
Equation       BoundaryVelocityEquation(const Scene *scene, PetscInt side, PetscInt c);
PetscBool      SceneIsPeriodic(const Scene *scene, PetscInt axis);
PetscBool      SceneHasBoundary(const Scene *scene, unsigned properties);
void           BodyGivenMotion(const Scene *scene, PetscInt side, PetscReal t, PetscReal u[],
                               PetscReal spin[]);
void           BodyGivenPose(const Scene *scene, PetscInt side, PetscReal t, Pose *pose);
void BodyMotion(const Scene *scene, PetscInt side, PetscReal t, PetscReal u[], PetscReal spin[]);
const BoundaryRow *SceneSlipKind(const Scene *scene);
const BoundaryRow *SceneFitKind(const Scene *scene);
PetscBool          SceneIsClosedBox(const Scene *scene);
PetscBool          ScenePressureFloats(const Scene *scene);
void      SceneWallVelocity(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[],
                            PetscReal u[]);
void      SceneSetLevel(Scene *scene);
PetscReal SceneWallPressure(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[],
                            const PetscReal normal[]);
PetscReal SceneWallSpeedBound(const Scene *scene, PetscInt side, const PetscReal x[],
                              const PetscReal normal[], const PetscReal u[]);
PetscReal SceneDecayRate(const Scene *scene);
PetscReal SceneDrivingPeriod(const Scene *scene, PetscReal t, PetscReal window, PetscReal least);
PetscErrorCode SceneReadFreedom(Scene *scene, PetscInt k, Boundary *boundary);
PetscErrorCode SceneReadMotionFile(Scene *scene, PetscInt k, Boundary *boundary);
PetscBool      SceneHasFreeBodies(const Scene *scene);
PetscErrorCode SceneReadRheology(Scene *scene);
PetscBool      SceneIsNewtonian(const Scene *scene);
PetscErrorCode SceneTypeRheology(Scene *scene);
FluidPlace     RheologyAt(const Scene *scene, PetscReal *const x[], PetscInt k);
PetscReal      RheologyViscosity(const Rheology *rheology, const FluidPlace *at, PetscReal rate);
PetscReal      RheologyRate(const Rheology *rheology, PetscReal stress);
PetscReal      RheologySlope(const Rheology *rheology, const FluidPlace *at, PetscReal rate);
PetscBool      SceneViscosityVaries(const Scene *scene);
PetscReal      SceneViscosity(const Scene *scene, const PetscReal x[]);
PetscErrorCode SceneBoundViscosity(Scene *scene);
PetscErrorCode SceneBoundGivenViscosity(PetscInt n, const PetscReal nu[], Scene *scene);
void           SceneBodyForce(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal f[]);
PetscErrorCode SceneReadFrame(Scene *scene);
PetscReal      SceneFrameRate(const Scene *scene, PetscReal t);
PetscReal      SceneFrameAngle(const Scene *scene, PetscReal t);
void SceneFrameVelocity(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal w[]);
void ScenePassing(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal v[]);
void SceneIntoBox(const Scene *scene, PetscReal x[]);
void SceneIntoFrame(const Scene *scene, PetscReal t, PetscReal v[]);
void SceneOutOfFrame(const Scene *scene, PetscReal t, PetscReal v[]);
void ScenePlaceIntoFrame(const Scene *scene, PetscReal t, PetscReal x[]);
void ScenePlaceOutOfFrame(const Scene *scene, PetscReal t, PetscReal x[]);
const PetscReal *SceneLaboratoryPlace(const Scene *scene, PetscReal t, const PetscReal x[],
                                      PetscReal y[ISPH_MAX_DIM]);
PetscErrorCode   ShapeRead(Scene *scene, const OptionRow *pattern, PetscInt k, PetscInt place,
                           Body *body, PetscBool *given);
PetscErrorCode   ShapeReadPlane(Scene *scene, const OptionRow *row, Body *body, PetscBool *given);
PetscErrorCode   ShapeCheckNumbers(const OptionRow *pattern, PetscInt n, PetscInt most);
const char      *BodySet(Scene *scene, const ShapeRow *shape, PetscInt n, const PetscReal number[],
                         Body *body);
void             BodyCircle(Scene *scene, PetscReal x, PetscReal y, PetscReal r, Body *body);
void             BodyBall(Scene *scene, const PetscReal centre[], PetscReal r, Body *body);
void             BodyBox(Scene *scene, const PetscReal lo[], const PetscReal hi[], Body *body);
const char      *BodyPolygon(Scene *scene, PetscInt corners, const PetscReal x[], Body *body);
const ShapeRow  *BodyOutline(const Scene *scene, const Body *body);
void             BodyArm(const Scene *scene, const Body *body, const PetscReal x[],
                         PetscReal arm[ISPH_MAX_DIM]);
PetscReal        BodyDistance(const Scene *scene, const Body *body, const PetscReal x[],
                              PetscReal normal[]);
PetscReal        BodyDistanceWithin(const Scene *scene, const Body *body, const PetscReal x[],
                                    PetscReal most, PetscReal normal[]);
PetscReal        BodySpacing(const Scene *scene, const Body *body);
PetscReal        SceneDistanceTo(const Scene *scene, unsigned properties, const PetscReal x[],
                                 PetscInt *side);
PetscReal        SceneFluidDistance(const Scene *scene, const PetscReal x[], PetscInt *side);
PetscReal        SceneDistance(const Scene *scene, const PetscReal x[], PetscInt *nearest,
                               PetscReal normal[]);
PetscReal        SceneSideDistance(const Scene *scene, PetscInt side, const PetscReal x[]);
Body            *SceneAddFilled(Scene *scene);
void             SceneFillUpTo(Scene *scene, unsigned sides);
PetscReal        SceneFilledDistance(const Scene *scene, PetscInt region, const PetscReal x[]);
PetscBool        SceneHasFreeSurface(const Scene *scene);
void             SceneWallPlanes(const Scene *scene, const PetscReal x[], PetscReal reach,
                                 WallPlane planes[WALL_PLANES], PetscInt *count);
PetscBool SceneBuries(const Scene *scene, PetscInt other, PetscInt boundary, const PetscReal x[]);
PetscBool SceneIsBuried(const Scene *scene, PetscInt boundary, const PetscReal x[]);
void      SceneSizes(const Scene *scene, const PetscReal x[], PetscReal *dx, PetscReal stretch[],
                     PetscReal *volume);
void      SceneKeepOffWalls(const Scene *scene, PetscReal t, PetscReal least, PetscReal x[]);

#endif
