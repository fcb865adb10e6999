/* Smoothing kernels. A table row gives the shape w(q), q = r/h, and the factors that normalise the
   integral of the kernel to 1 in 1, 2 and 3 dimensions. A new kernel needs a shape function and a
   table row. */
#include "isph/fits.h"

/* Computes the cubic B-spline with support 2h, w = 1 - 3/2 q^2 + 3/4 q^3 for q < 1, else (2-q)^3/4,
   and its derivatives w' and w''. */
static ISPH_WIDE void Shape_CubicSpline(PetscInt n, PetscReal w[], PetscReal dw[], PetscReal ddw[])
{
#pragma omp simd
  for (PetscInt k = 0; k < n; k++) {
    const PetscReal q = w[k], s = 2.0 - q;

    w[k]   = q < 1.0 ? 1.0 - 1.5 * q * q + 0.75 * q * q * q : 0.25 * s * s * s;
    dw[k]  = q < 1.0 ? -3.0 * q + 2.25 * q * q : -0.75 * s * s;
    ddw[k] = q < 1.0 ? -3.0 + 4.5 * q : 1.5 * s;
  }
}

/* Computes the quintic B-spline with support 3h, w = (3-q)^5 - 6 (2-q)^5 + 15 (1-q)^5, and its
   derivatives; a term counts only while its base is positive. */
static ISPH_WIDE void Shape_QuinticSpline(PetscInt n, PetscReal w[], PetscReal dw[],
                                          PetscReal ddw[])
{
  const PetscReal knot[3] = {3.0, 2.0, 1.0}, weight[3] = {1.0, -6.0, 15.0};

#pragma omp simd
  for (PetscInt k = 0; k < n; k++) {
    const PetscReal q = w[k];

    w[k] = dw[k] = ddw[k] = 0.0;
    for (PetscInt t = 0; t < 3; t++) {
      const PetscReal s = PetscMax(knot[t] - q, 0.0), s3 = s * s * s;

      w[k] += weight[t] * s3 * s * s;
      dw[k] -= weight[t] * 5.0 * s3 * s;
      ddw[k] += weight[t] * 20.0 * s3;
    }
  }
}

/* Computes the Wendland C2 kernel with support 2h, w = (1 - q/2)^4 (1 + 2q), and derivatives. */
static ISPH_WIDE void Shape_WendlandC2(PetscInt n, PetscReal w[], PetscReal dw[], PetscReal ddw[])
{
#pragma omp simd
  for (PetscInt k = 0; k < n; k++) {
    const PetscReal q = w[k], s = 1.0 - 0.5 * q, s2 = s * s;

    w[k]   = s2 * s2 * (1.0 + 2.0 * q);
    dw[k]  = -5.0 * q * s2 * s;
    ddw[k] = s2 * (7.5 * q - 5.0 * s);
  }
}

/* Computes the Wendland C4 kernel with support 2h, w = (1 - q/2)^6 (1 + 3q + 35/12 q^2), and
   derivatives. */
static ISPH_WIDE void Shape_WendlandC4(PetscInt n, PetscReal w[], PetscReal dw[], PetscReal ddw[])
{
#pragma omp simd
  for (PetscInt k = 0; k < n; k++) {
    const PetscReal q = w[k], s = 1.0 - 0.5 * q, s2 = s * s, s4 = s2 * s2;

    w[k]   = s4 * s2 * (1.0 + 3.0 * q + 35.0 / 12.0 * q * q);
    dw[k]  = -14.0 / 3.0 * q * (1.0 + 2.5 * q) * s4 * s;
    ddw[k] = -14.0 / 3.0 * s4 * ((1.0 + 5.0 * q) * s - 2.5 * q * (1.0 + 2.5 * q));
  }
}

/*
  KernelEvaluateAll - Computes W, dW/dr and d2W/dr2 at n distances r within the support

    W(r) = sigma_d/h^d w(r/h)

  with the shape w and the factor sigma_d of the kernel's row, d = dim. Input: dim - 1, 2 or 3; h -
  smoothing length [m]; r - distances less than the radius of the support [m]. Output: W - [m^-dim];
  dW - dW/dr [m^-(dim+1)]; ddW - d2W/dr2 [m^-(dim+2)].
*/
ISPH_WIDE void KernelEvaluateAll(const KernelRow *kernel, PetscInt dim, PetscReal h, PetscInt n,
                                 const PetscReal r[], PetscReal W[], PetscReal dW[],
                                 PetscReal ddW[])
{
  const PetscReal over  = 1.0 / h;
  PetscReal       scale = kernel->sigma[dim - 1];

  for (PetscInt a = 0; a < dim; a++) scale *= over;
#pragma omp simd
  for (PetscInt k = 0; k < n; k++) W[k] = r[k] * over;
  kernel->Shape(n, W, dW, ddW);
#pragma omp simd
  for (PetscInt k = 0; k < n; k++) {
    W[k] *= scale;
    dW[k] *= scale * over;
    ddW[k] *= scale * over * over;
  }
}

/* KernelEvaluate - Computes W, dW/dr and d2W/dr2 at distance r, as KernelEvaluateAll(), and zeros
   beyond the support */
void KernelEvaluate(const KernelRow *kernel, PetscInt dim, PetscReal h, PetscReal r, PetscReal w[3])
{
  w[0] = w[1] = w[2] = 0.0;
  if (r < kernel->support * h) KernelEvaluateAll(kernel, dim, h, 1, &r, &w[0], &w[1], &w[2]);
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
