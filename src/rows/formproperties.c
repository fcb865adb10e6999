/* Declared properties of forms, and the weights of the chosen Laplacian, with or without correction
   of the kernel, and for a varying viscosity. */
#include "assembly.h"
#include "rows.h"

const char *const FormPropertyNames[FORM_PROPERTY_COUNT] = {
    "null_constants",     "symmetric",
    "exact_linear",       "exact_quadratic",
    "full_support",       "safe_implicit",
    "varying_viscosity",  "couples_components",
    "conserves_momentum", "conserves_angular_momentum",
    "dissipates"};

/* FormDescribe - Appends the names of properties to a text, such as "null_constants, symmetric" */
PetscErrorCode FormDescribe(unsigned properties, char text[], size_t length)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < FORM_PROPERTY_COUNT; k++) {
    if (properties & (1u << k)) AppendWord(text, length, FormPropertyNames[k]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* LaplacianIs - Returns true if the chosen Laplacian has a property. A Laplacian with a correction
   of the kernel, or with particles of several sizes, is never symmetric: correction and kernel
   differ from particle to particle. It has none of the properties that follow from symmetry
   either. */
PetscBool LaplacianIs(const LaplacianForm *form, FormProperty property)
{
  unsigned properties = form->row->properties;

  if (form->correction || form->graded)
    properties &= ~(unsigned)(FORM_SYMMETRIC | FORM_MOMENTUM | FORM_ANGULAR | FORM_DISSIPATES);
  return (properties & (unsigned)property) ? PETSC_TRUE : PETSC_FALSE;
}

/* LaplacianWidth - Returns the number of weights for each neighbour in a row: dim^2 if the form
   couples velocity components, otherwise 1 */
PetscInt LaplacianWidth(const LaplacianForm *form, PetscInt dim)
{
  return form->row && LaplacianIs(form, FORM_COUPLES) ? dim * dim : 1;
}

/* ComposedTrace - Returns the factor t of the trace in the stress g + g^T - t tr(g) I. The stress
   of Fang et al. has no trace in dim dimensions, t = 2/dim; that of Basa et al. none in three, t =
   2/3. Reference: J. Fang, A. Parriaux, M. Rentschler, C. Ancey, Appl. Numer. Math. 59 (2009), Eqs
   (5), (6); M. Basa, N. Quinlan, M. Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009), Eq. (4). */
PetscReal ComposedTrace(const ComposedForm *form, PetscInt dim)
{
  return form->planar ? 2.0 / dim : 2.0 / 3.0;
}

/* LaplacianDilatation - Returns the factor c of a form that approximates lap u + (c - 1) grad div
   u. The rotational pressure update subtracts c rho nu div u*, u* the predicted velocity:
   theory.md, (projection:update) and (projection:rotational). */
PetscReal LaplacianDilatation(const LaplacianForm *form, PetscInt dim)
{
  if (form->row->weak) return 2.0;
  return 1.0 + form->row->grad_div;
}

/* LaplacianWeights - Computes the row of the chosen Laplacian. Output: w - w[k] multiplies f_k -
   f_i [m^-2]; for wall neighbours and for st->own see LaplacianRow. Notes: forms that couple
   components take a correction as a vector from KernelGradients(), the others its component along
   the pair. */
PetscErrorCode LaplacianWeights(const LaplacianForm *form, Stencil *st, PetscReal w[])
{
  PetscReal *const dW = st->dW, *const ddW = st->ddW;
  const PetscBool couples = LaplacianIs(form, FORM_COUPLES);
  const PetscInt  entries = LaplacianWidth(form, st->dim);

  PetscFunctionBegin;
  st->correction = form->correction ? form->correction->bit : 0;
  for (PetscInt e = 0; e < entries; e++) st->own[e] = 0.0;
  if (form->correction && !couples) {
    form->correction->Kernel(st, st->corrected[0], st->corrected[1]);
    st->dW  = st->corrected[0];
    st->ddW = st->corrected[1];
  }
  for (PetscInt k = 0; form->factor && k < st->n; k++) {
    const PetscReal own = form->factor[st->i];

    st->factor[k] =
        st->wall[k] || form->factor[st->j[k]] == 0.0 ? own : 0.5 * (own + form->factor[st->j[k]]);
  }
  PetscCall(form->row->Row(st, w));
  for (PetscInt e = 0; form->scale != 0.0 && e < st->n * entries; e++) w[e] *= form->scale;
  st->dW  = dW;
  st->ddW = ddW;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* LaplacianFactors - Computes the factors of a form at all particles, if the form has factors.
   Collective on the particles' communicator. Input/Output: form - its factors; those of wall
   particles are not set. */
PetscErrorCode LaplacianFactors(const Scene *scene, const Particles *p, const Neighbors *nb,
                                const Operators *ops, LaplacianForm *form)
{
  Stencil *st = ops->work->stencil;

  PetscFunctionBegin;
  if (!form->row || !form->row->Factor) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree(form->factor));
  PetscCall(PetscCalloc1(ParticlesAll(p), &form->factor));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscCall(GatherStencil(scene, p, nb, ops, i, st));
    form->factor[i] = form->row->Factor(st);
  }
  PetscCall(ParticlesHaloField(p, form->factor));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OperatorsCorrection - Returns the name of the kernel correction in the run's Laplacians, or
   "none" */
const char *OperatorsCorrection(const Operators *ops)
{
  if (ops->forms.visc.correction) return ops->forms.visc.correction->name;
  if (ops->forms.ppe.correction) return ops->forms.ppe.correction->name;
  return TableGet(&CorrectionTable, 0)->name;
}

/*
  WeighByViscosity - Multiplies the weights of a Laplacian by the mean viscosities of pairs over
  scene->nu; a wall neighbour has the viscosity of particle i

    (div(nu grad u))_i = sum_j w_ij nu_ij (u_j - u_i),   nu_ij = 2 nu_i nu_j/(nu_i + nu_j)

  Reason: the row is the Laplacian of g(x) = m(x) (u(x) - u_i), m(x) the mean of nu_i and nu(x). At
  x_i the mean has the value nu_i and the gradient grad nu/2, so lap g = nu lap u + grad nu.grad u
  to the order of the form. If an interface lies half way between i and j, nu_ij (u_j - u_i) is the
  exact flux times the distance, for any jump of nu. See theory.md, (viscosity:scalar) and
  (viscosity:means). Reference: P. W. Cleary, J. J. Monaghan, J. Comput. Phys. 148 (1999) 227-264
*/
void WeighByViscosity(const Scene *scene, const Particles *p, const Stencil *st, PetscReal w[])
{
  const PetscReal own = p->nu[st->i];

  for (PetscInt k = 0; k < st->n; k++)
    w[k] *= (st->wall[k] ? own : PairViscosity(own, p->nu[st->j[k]])) / scene->nu;
}
