/* Functions of time through given values, as positions of a body from a file: a cubic between two
   values, with slopes that make it continuous and monotone where the values are, so that a body at
   rest stays at rest until its first row that moves. */
#include "isph/options.h"

/* Returns a slope limited to twice the least of two differences of the same sign; 0 if the signs
   differ. */
static PetscReal Limited(PetscReal slope, PetscReal before, PetscReal after)
{
  const PetscReal most = 2.0 * PetscMin(PetscAbsReal(before), PetscAbsReal(after));

  if (before * after <= 0.0 || slope * before <= 0.0) return 0.0;
  return slope > 0.0 ? PetscMin(slope, most) : PetscMax(slope, -most);
}

/*
  TimeCurveSet - Computes the slopes of a curve of n >= 2 values

    s_k = (d_k-1 h_k + d_k h_k-1)/(h_k-1 + h_k),   d_k = (y_k+1 - y_k)/h_k,   h_k = t_k+1 - t_k,

  the slope of the parabola through three values, at an end through the last three. It is at most 2
  min(|d_k-1|, |d_k|), and 0 where d changes its sign or is 0. The curve then has no extremum
  between two values, dy/dt is continuous, and the error is of order h^3 where y is monotone, of
  order h^2 at extrema. Input: t, y; slope - n places. Returns: NULL, or a fault of the times.
  Reference: M. Steffen, Astron. Astrophys. 239 (1990) 443, with his limit of monotone cubics
*/
const char *TimeCurveSet(TimeCurve *curve)
{
  const PetscReal *t = curve->t, *y = curve->y;
  const PetscInt   n = curve->n;

  for (PetscInt k = 0; k + 1 < n; k++)
    if (!(t[k + 1] > t[k])) return "its times must ascend";
  for (PetscInt k = 0; k < n; k++) {
    const PetscInt  j = PetscMax(1, PetscMin(k, n - 2)); /* in the middle of the three values */
    const PetscReal h = t[j] - t[j - 1], d = (y[j] - y[j - 1]) / h;
    const PetscReal h_next = n > 2 ? t[j + 1] - t[j] : h,
                    d_next = n > 2 ? (y[j + 1] - y[j]) / h_next : d;
    const PetscReal bend   = (d_next - d) / (h + h_next);

    if (k == j) curve->slope[k] = Limited(d + bend * h, d, d_next);
    else if (k < j) curve->slope[k] = Limited(d - bend * h, d, d);
    else curve->slope[k] = Limited(d_next + bend * h_next, d_next, d_next);
    if (PetscIsInfOrNanReal(curve->slope[k])) return "its times are too near to each other";
  }
  return NULL;
}

/*
  TimeCurveValue - Returns the value of a curve at time t; beyond its ends that of the last cubic.
  With x = (t - t_k)/h_k between t_k and t_k+1

    y = y_k + x h_k s_k + x^2 [3 D - h_k (2 s_k + s_k+1)] + x^3 [h_k (s_k + s_k+1) - 2 D],
    D = y_k+1 - y_k
*/
PetscReal TimeCurveValue(const TimeCurve *curve, PetscReal t)
{
  PetscInt  low = 0, high = curve->n - 1;
  PetscReal h, x, D, a, b;

  while (high - low > 1) {
    const PetscInt middle = (low + high) / 2;

    if (t < curve->t[middle]) high = middle;
    else low = middle;
  }
  h = curve->t[high] - curve->t[low];
  x = (t - curve->t[low]) / h;
  D = curve->y[high] - curve->y[low];
  a = h * curve->slope[low];
  b = h * curve->slope[high];
  return curve->y[low] + x * (a + x * (3.0 * D - 2.0 * a - b + x * (a + b - 2.0 * D)));
}
