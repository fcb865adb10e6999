/* The fluid beside a boundary: points of quadrature where the weight w of forces.c is not zero. */
#ifndef ISPH_FORCES_LAYER_H
#define ISPH_FORCES_LAYER_H

#include "isph/forces.h"

typedef struct {
  const Scene *scene;
  PetscInt     side, n, capacity;
  PetscReal    unit;                  /* spacing at the boundary, largest along its normal [m] */
  PetscReal   *x, *volume, *gradient; /* [m], [m^dim], of w [1/m] */
} Layer;
PetscErrorCode LayerSet(const Scene *scene, PetscInt side, const Facets *facets, Layer *layer);
PetscReal      LayerWeight(const Layer *layer, const PetscReal x[]);
PetscErrorCode LayerFree(Layer *layer);

/* lubrication.c */
PetscErrorCode LubricationAdd(const Flow *flow, PetscInt side, const Facets *facets,
                              const Facets *fine, const PetscReal centre[], PetscReal F[],
                              PetscReal T[]);

#endif
