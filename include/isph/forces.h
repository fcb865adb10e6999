/* Forces of the fluid on boundaries at the present state: values at points, facets of surfaces,
   tractions on them, and the momentum that fluid and boundary exchange. */
#ifndef ISPH_FORCES_H
#define ISPH_FORCES_H

#include "isph/flow.h"

/* probe.c */
PetscErrorCode ProbePoints(const Flow *flow, PetscInt n, const PetscReal x[], PetscReal u[],
                           PetscReal p[]);
PetscErrorCode ProbeViscosity(const Flow *flow, PetscInt n, const PetscReal x[], PetscReal nu[]);
PetscErrorCode ProbeDensity(const Flow *flow, PetscInt n, const PetscReal x[], PetscReal rho[]);
PetscErrorCode ProbeMotion(const Flow *flow, PetscInt n, const PetscReal x[], PetscReal gradient[],
                           PetscReal rate[], PetscReal pressure[]);
PetscErrorCode ProbeDry(const Flow *flow, PetscInt n, const PetscReal x[], PetscBool dry[]);
PetscBool      ProbeInBody(const Scene *scene, const PetscReal x[]);

/* Facets of a wall or a section, see facets.c. */
typedef struct {
  PetscInt   n, dim;
  PetscReal *x, *normal; /* middles and unit normals, dim coordinates each [m]; [-] */
  PetscReal *area;       /* [m^(dim-1)] */
  PetscReal  whole;      /* area of a piece of a section; 0: facets are squares [m^(dim-1)] */
  PetscReal  edge[2][ISPH_MAX_DIM]; /* its edges [m] */
} Facets;
PetscErrorCode FacetsOfWall(const Scene *scene, PetscInt side, Facets *facets);
PetscErrorCode FacetsOfBody(const Scene *scene, PetscInt side, PetscInt pieces, Facets *facets);
PetscErrorCode FacetsOfSection(const Scene *scene, const PetscReal corner[], Facets *facets);
PetscErrorCode FacetsKeepWet(const Flow *flow, Facets *facets);
PetscErrorCode FacetsFlux(const Flow *flow, const Facets *facets, PetscReal *flux, PetscReal *size);
PetscErrorCode FacetsFree(Facets *facets);
void           FacetsCopy(PetscInt k, PetscInt to, Facets *facets);

/* tractions.c */
PetscErrorCode FacetLoads(const Flow *flow, PetscInt side, const Facets *facets, PetscReal **f,
                          PetscReal **p);
PetscErrorCode WallLoads(const Flow *flow, PetscInt side, Facets *facets, PetscReal **f,
                         PetscReal **p);
PetscReal      StrainRate(PetscInt dim, const PetscReal gradient[]);
void      AddTorque(PetscInt dim, const PetscReal c[], const PetscReal x[], const PetscReal f[],
                    PetscReal T[]);
PetscReal FacetHeight(const Scene *scene, PetscInt side, const PetscReal x[]);
PetscErrorCode PointViscosity(const Flow *flow, PetscInt n, const PetscReal x[],
                              const PetscReal rate[], PetscReal nu[]);

/* reactions.c */
PetscErrorCode CellForces(const Flow *flow, PetscReal **force);

/* The force on a boundary by the momentum of the fluid beside it. */
typedef struct Reaction Reaction;
PetscErrorCode          ReactionCreate(const Flow *flow, PetscInt side, Reaction **reaction);
PetscErrorCode          ReactionForce(const Flow *flow, PetscBool next, Reaction *reaction,
                                      PetscReal force[]);
PetscErrorCode          ReactionDestroy(Reaction **reaction);

/* The ways in which forces are measured, see forces.c; the last is the part of both that the
   computed flow has not. */
enum { FORCE_MOMENTUM, FORCE_TRACTION, FORCE_LUBRICATION, FORCE_WAYS };
PetscErrorCode WallForce(const Flow *flow, PetscInt side,
                         PetscReal force[FORCE_WAYS][2 * ISPH_MAX_DIM]);
void           ForceParts(const Scene *scene, PetscReal force[FORCE_WAYS][2 * ISPH_MAX_DIM],
                          PetscReal part[FORCE_WAYS]);

#endif
