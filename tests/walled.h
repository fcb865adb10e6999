/*
  Clouds with walls for each combination of a wall treatment, a Laplacian and a gradient, for tests
  of fields that must be exact beside walls.
*/
#ifndef WALLED_H
#define WALLED_H

#include "cloud.h"

#define WALLED_JITTER 0.2 /* [dx] */

typedef struct {
  const WallRow      *wall;
  PetscBool           surface; /* -wall_surface */
  const LaplacianRow *laplacian;
  const GradientRow  *gradient;
} WalledForms;
typedef void (*WalledCheck)(const WalledForms *forms, const char *where, Cloud *cloud);

const WallRow     *WalledWall(PetscInt k);     /* row k of the table of wall treatments */
const GradientRow *WalledGradient(PetscInt k); /* row k of the table of gradients */
PetscBool          WalledBlind(unsigned properties);
PetscBool          WalledMeets(const WallRow *wall, PetscBool full_support);

void WalledForOne(const WalledForms *forms, const CloudBox *box, WalledCheck check);
void WalledForAll(PetscBool closed, WalledCheck check);
void WalledAssert(const char *what, const char *where, const Cloud *cloud, Vec y,
                  const Quadratic *expected, PetscInt power, PetscReal tolerance);
void WalledSetVelocity(Cloud *cloud, const Quadratic u[]);

#endif
