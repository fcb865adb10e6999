/*
  Smoothing kernels. A table row gives the shape w(q), q = r/h, and the factors that normalise the
  integral of the kernel to 1 in 1, 2 and 3 dimensions. A new kernel needs a shape function and a
  table row.
*/
#include "isph/operators.h"

/* Computes the cubic B-spline with support 2h, w = 1 - 3/2 q^2 + 3/4 q^3 for q < 1, else (2-q)^3/4,
   and its derivatives w' and w''. */
static void Shape_CubicSpline(PetscReal q, PetscReal w[3])
{
  const PetscReal s = 2.0 - q;

  if (q < 1.0) {
    w[0] = 1.0 - 1.5 * q * q + 0.75 * q * q * q;
    w[1] = -3.0 * q + 2.25 * q * q;
    w[2] = -3.0 + 4.5 * q;
  } else {
    w[0] = 0.25 * s * s * s;
    w[1] = -0.75 * s * s;
    w[2] = 1.5 * s;
  }
}

/* Computes the quintic B-spline with support 3h, w = (3-q)^5 - 6 (2-q)^5 + 15 (1-q)^5, and its
   derivatives; a term counts only while its base is positive. */
static void Shape_QuinticSpline(PetscReal q, PetscReal w[3])
{
  const PetscReal knot[3] = {3.0, 2.0, 1.0}, weight[3] = {1.0, -6.0, 15.0};

  w[0] = w[1] = w[2] = 0.0;
  for (PetscInt k = 0; k < 3; k++) {
    const PetscReal s = knot[k] - q, s3 = s * s * s;

    if (s <= 0.0) break;
    w[0] += weight[k] * s3 * s * s;
    w[1] -= weight[k] * 5.0 * s3 * s;
    w[2] += weight[k] * 20.0 * s3;
  }
}

/* Computes the Wendland C2 kernel with support 2h, w = (1 - q/2)^4 (1 + 2q), and derivatives. */
static void Shape_WendlandC2(PetscReal q, PetscReal w[3])
{
  const PetscReal s = 1.0 - 0.5 * q, s2 = s * s;

  w[0] = s2 * s2 * (1.0 + 2.0 * q);
  w[1] = -5.0 * q * s2 * s;
  w[2] = s2 * (7.5 * q - 5.0 * s);
}

/* Computes the Wendland C4 kernel with support 2h, w = (1 - q/2)^6 (1 + 3q + 35/12 q^2), and
   derivatives. */
static void Shape_WendlandC4(PetscReal q, PetscReal w[3])
{
  const PetscReal s = 1.0 - 0.5 * q, s2 = s * s, s4 = s2 * s2;

  w[0] = s4 * s2 * (1.0 + 3.0 * q + 35.0 / 12.0 * q * q);
  w[1] = -14.0 / 3.0 * q * (1.0 + 2.5 * q) * s4 * s;
  w[2] = -14.0 / 3.0 * s4 * ((1.0 + 5.0 * q) * s - 2.5 * q * (1.0 + 2.5 * q));
}

/*
  KernelEvaluate - Computes W, dW/dr and d2W/dr2 at distance r

    W(r) = sigma_d/h^d w(r/h)

  with the shape w and the factor sigma_d of the kernel's row, d = dim

  Not collective.

  Input Parameters:
+ dim - 1, 2 or 3
. h   - smoothing length [m]
- r   - distance [m]; beyond the support W and its derivatives are zero

  Output Parameter:
. w - W [m^-dim], dW/dr [m^-(dim+1)], d2W/dr2 [m^-(dim+2)]
*/
void KernelEvaluate(const KernelRow *kernel, PetscInt dim, PetscReal h, PetscReal r, PetscReal w[3])
{
  PetscReal scale = kernel->sigma[dim - 1];

  w[0] = w[1] = w[2] = 0.0;
  if (r >= kernel->support * h) return;
  for (PetscInt a = 0; a < dim; a++) scale /= h;
  kernel->Shape(r / h, w);
  w[0] *= scale;
  w[1] *= scale / h;
  w[2] *= scale / (h * h);
}

static const KernelRow kernels[] = {
    {"cubic_spline",
     "cubic B-spline, support 2h",
     "Monaghan & Lattanzio, Astron. Astrophys. 149 (1985)",
     2.0,
     {2.0 / 3.0, 10.0 / (7.0 * PETSC_PI), 1.0 / PETSC_PI},
     Shape_CubicSpline},
    {"quintic_spline",
     "quintic B-spline, support 3h",
     "Morris, Fox & Zhu, J. Comput. Phys. 136 (1997)",
     3.0,
     {1.0 / 120.0, 7.0 / (478.0 * PETSC_PI), 1.0 / (120.0 * PETSC_PI)},
     Shape_QuinticSpline},
    {"wendland_c2",
     "Wendland C2, support 2h",
     "Wendland, Adv. Comput. Math. 4 (1995)",
     2.0,
     {3.0 / 4.0, 7.0 / (4.0 * PETSC_PI), 21.0 / (16.0 * PETSC_PI)},
     Shape_WendlandC2},
    {"wendland_c4",
     "Wendland C4, support 2h",
     "Wendland, Adv. Comput. Math. 4 (1995)",
     2.0,
     {27.0 / 32.0, 9.0 / (4.0 * PETSC_PI), 495.0 / (256.0 * PETSC_PI)},
     Shape_WendlandC4},
};
const Table KernelTable = TABLE("Kernels", kernels);
