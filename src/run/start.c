/* Start of a run with the user's particles: a file gives their positions and, if it has them, their
   velocities and viscosities. */
#include "impl.h"
#include "io/hdf5file.h"

#define START_CLOSEST 0.01 /* least distance of two particles, for fits to be meaningful [dx] */
#define VOLUME_ERROR  0.01 /* of the particles of a file in a full box, relative [-] */
#define FILLED_MOST   1.5  /* factor in the number of particles of a file in filled regions [-] */
#define VOLUME_ERROR_BODIES                                                                        \
  0.05 /* the same with bodies, about which lattices have parts of cells */

static const OptionRow options[] = {
    OPTION(FILE, "-particles", "HDF5 file of the fluid particles at the start, such as a snapshot",
           NULL, "a lattice", .file = FILE_READ, .where = "flows"),
};
const OptionTable StartOptions = OPTIONS("Start", options);

/* Faults of a particle of the file. */
enum { PLACE_NOT_FINITE, PLACE_OUTSIDE, PLACE_IN_BODY, PLACE_NO_VISCOSITY, PLACE_FAULTS };

/* Reads this rank's share of a data set; NULL if it is absent. */
static PetscErrorCode ReadShare(Hdf5File *file, const char name[], PetscInt columns, hid_t given,
                                size_t size, void **rows)
{
  PetscInt  N, width;
  PetscBool there;

  PetscFunctionBegin;
  *rows = NULL;
  PetscCall(Hdf5Has(file, name, &there));
  if (!there) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Hdf5CountRows(file, name, &N, &width));
  if (N != file->N || width != columns) file->failed = PETSC_TRUE;
  PetscCall(PetscMalloc((size_t)(file->own * PetscMax(columns, 1) + 1) * size, rows));
  if (!file->failed && N) PetscCall(Hdf5ReadRows(file, name, columns, given, *rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads this rank's share of the fluid particles, and the row of each in the file; skips the walls
   of a snapshot. */
static PetscErrorCode ReadParticles(PetscInt dim, Hdf5File *file, FluidStart *start,
                                    PetscInt *columns, PetscInt **row)
{
  PetscInt last;
  int     *type;

  PetscFunctionBegin;
  *row = NULL;
  PetscCall(Hdf5CountRows(file, "position", &file->N, columns));
  if (*columns != dim) PetscFunctionReturn(PETSC_SUCCESS);
  ParticlesShare(PETSC_COMM_WORLD, file->N, &file->start, &last);
  file->own = last - file->start;
  PetscCall(
      ReadShare(file, "position", dim, H5T_NATIVE_DOUBLE, sizeof(PetscReal), (void **)&start->x));
  PetscCall(
      ReadShare(file, "velocity", dim, H5T_NATIVE_DOUBLE, sizeof(PetscReal), (void **)&start->u));
  PetscCall(
      ReadShare(file, "viscosity", 0, H5T_NATIVE_DOUBLE, sizeof(PetscReal), (void **)&start->nu));
  PetscCall(ReadShare(file, "type", 0, H5T_NATIVE_INT, sizeof(int), (void **)&type));
  PetscCall(PetscMalloc1(file->own + 1, row));
  for (PetscInt k = 0; k < file->own; k++) {
    (*row)[start->n] = file->start + k;
    if (type && type[k]) continue;
    for (PetscInt a = 0; a < dim; a++) {
      start->x[start->n * dim + a] = start->x[k * dim + a];
      if (start->u) start->u[start->n * dim + a] = start->u[k * dim + a];
    }
    if (start->nu) start->nu[start->n] = start->nu[k];
    start->n++;
  }
  PetscCall(PetscFree(type));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Wraps a particle into a periodic box; returns its fault, PLACE_FAULTS if it has none. */
static PetscInt PlaceFault(const Scene *scene, const FluidStart *start, PetscInt i)
{
  PetscReal       *x = &start->x[i * scene->dim];
  const PetscReal *u = start->u ? &start->u[i * scene->dim] : NULL;
  PetscInt         side;

  for (PetscInt a = 0; a < scene->dim; a++) {
    const PetscReal lo = scene->lo[a], period = scene->hi[a] - lo;

    if (PetscIsInfOrNanReal(x[a]) || (u && PetscIsInfOrNanReal(u[a]))) return PLACE_NOT_FINITE;
    if (SceneIsPeriodic(scene, a)) x[a] -= period * PetscFloorReal((x[a] - lo) / period);
  }
  if (SceneFluidDistance(scene, x, &side) <= 0.0)
    return BoundaryBody(scene, side) ? PLACE_IN_BODY : PLACE_OUTSIDE;
  return start->nu && !(start->nu[i] > 0.0) ? PLACE_NO_VISCOSITY : PLACE_FAULTS;
}

/* Ends the run if a particle has a fault; the message names the first row with a fault.
   Collective. */
static PetscErrorCode CheckPlaces(const Scene *scene, const char path[], const FluidStart *start,
                                  const PetscInt row[])
{
  const char *const faults[PLACE_FAULTS] = {"is not finite", "is not inside the box",
                                            "is inside a body", "has no positive viscosity"};
  PetscInt          first[2]             = {PETSC_INT_MAX, PLACE_FAULTS}, found;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < start->n && first[1] == PLACE_FAULTS; i++) {
    first[1] = PlaceFault(scene, start, i);
    if (first[1] < PLACE_FAULTS) first[0] = row[i];
  }
  PetscCallMPI(MPI_Allreduce(&first[0], &found, 1, MPIU_INT, MPI_MIN, PETSC_COMM_WORLD));
  if (first[0] != found) first[1] = PLACE_FAULTS;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &first[1], 1, MPIU_INT, MPI_MIN, PETSC_COMM_WORLD));
  UserCheck(first[1] == PLACE_FAULTS, "-particles %s: the particle in row %" PetscInt_FMT " %s",
            path, found, faults[first[1]]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  StartRead - Reads the fluid particles at the start from a file. Collective on PETSC_COMM_WORLD.
  Output: start - this rank's share; N = 0 for a start on the lattice; freed by StartFree(); path -
  path of the file, empty without a file. Input/Output: scene - its bounds on the viscosity are set
  to those of the file.

  Options Database Key:
  . -particles file.h5 - data set `position` [m] and, if present, `velocity` [m/s], `viscosity`
                       [m^2/s] for varying viscosity, and `type` (0: fluid, others are skipped), as
                       in a snapshot. The walls of the case do not change.

  Errors: an unreadable file, a file without fluid, or a particle outside the fluid ends the run
*/
PetscErrorCode StartRead(Scene *scene, FluidStart *start, char path[])
{
  Hdf5File  file;
  PetscInt  columns, *row;
  PetscBool good, given_nu;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(start, sizeof(*start)));
  PetscCall(OptionGetFile(&options[0], path));
  if (!path[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(OptionsRefuseTogether("-particles", "-jitter", "it displaces a lattice"));
  PetscCall(Hdf5FileOpen(PETSC_COMM_WORLD, path, HDF5_READ, &file));
  PetscCheck(file.file >= 0, PETSC_COMM_WORLD, PETSC_ERR_FILE_OPEN,
             "-particles %s: is absent, no HDF5 file, or a truncated one", path);
  PetscCall(ReadParticles(scene->dim, &file, start, &columns, &row));
  given_nu = start->nu ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(Hdf5FileClose(&file, &good));
  UserCheck(columns == scene->dim,
            "-particles %s: it needs a data set 'position' of N rows and %" PetscInt_FMT " columns",
            path, scene->dim);
  PetscCheck(good, PETSC_COMM_WORLD, PETSC_ERR_FILE_UNEXPECTED,
             "-particles %s: 'velocity', 'viscosity' and 'type' must have the rows of 'position', "
             "or be absent",
             path);
  PetscCall(CheckPlaces(scene, path, start, row));
  PetscCall(PetscFree(row));
  PetscCallMPI(MPI_Exscan(&start->n, &start->first, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
  PetscCallMPI(MPI_Allreduce(&start->n, &start->N, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
  UserCheck(start->N > 0, "-particles %s: there is no fluid in it", path);
  UserCheck(!given_nu || SceneViscosityVaries(scene),
            "-particles %s: it has a data set 'viscosity', which this run does not use; add "
            "-viscosity_field, whose value fluid that enters has, or remove the data set",
            path);
  if (SceneViscosityVaries(scene) && SceneIsNewtonian(scene))
    PetscCall(SceneBoundGivenViscosity(start->nu ? start->n : 0, start->nu, scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StartFree - Frees the data of StartRead(); not collective */
PetscErrorCode StartFree(FluidStart *start)
{
  PetscFunctionBegin;
  PetscCall(FreeAll(&start->x, &start->u, &start->nu));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StartCheck - Prints the number and the closest distance of the user's particles; ends the run if
   two particles nearly coincide. Collective on PETSC_COMM_WORLD. Every particle has the volume of a
   lattice cell, so that in a full box of equal cells their number must be that of a lattice within
   VOLUME_ERROR; beside bodies lattices differ by more. Regions that are filled share their volume
   among the particles, whose number must be that of a lattice within a factor FILLED_MOST. */
PetscErrorCode StartCheck(const Scene *scene, const char path[], const Particles *p, Neighbors *nb)
{
  const PetscReal most = scene->n_bodies ? VOLUME_ERROR_BODIES : VOLUME_ERROR;
  const PetscReal lattice =
      scene->n_filled ? p->weight * p->cell_volume / PetscPowRealInt(scene->dx, (int)scene->dim)
                      : (PetscReal)p->N_lattice;
  const PetscReal share   = (PetscReal)p->N_fluid / PetscMax(lattice, 1.0);
  PetscReal       closest = PetscSqr(nb->radius / nb->spacing);

  PetscFunctionBegin;
  if (!path[0]) PetscFunctionReturn(PETSC_SUCCESS);
  UserCheck(SceneIsGraded(scene) || PetscAbsReal(share - 1.0) <= most ||
                (scene->n_filled && share >= 1.0 / FILLED_MOST && share <= FILLED_MOST),
            "-particles %s: its %" PetscInt_FMT
            " particles have %.3g times the volume of the fluid, for which dx = %.4g needs "
            "%.0f; give all particles, or the -n of their spacing",
            path, p->N_fluid, (double)share, (double)scene->dx, (double)lattice);
  PetscCall(NeighborsUpdate(p, 0.0, nb));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    for (PetscInt k = nb->row[i]; k < nb->row[i + 1]; k++) {
      PetscReal square = 0.0;

      for (PetscInt a = 0; a < p->dim; a++) square += PetscSqr(p->x[a][nb->col[k]] - p->x[a][i]);
      closest = PetscMin(closest, square / PetscSqr(p->dx[i]));
    }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &closest, 1, MPIU_REAL, MPIU_MIN, p->comm));
  closest = PetscSqrtReal(closest);
  UserCheck(closest >= START_CLOSEST,
            "-particles %s: two particles are %.2g dx apart; at least %.2g dx is allowed", path,
            (double)closest, START_CLOSEST);
  PetscCall(PetscPrintf(PETSC_COMM_WORLD,
                        "particles   %s: %" PetscInt_FMT
                        " fluid particles (a lattice has %" PetscInt_FMT
                        "), closest distance %.2g dx\n",
                        path, p->N_fluid, p->N_lattice, (double)closest));
  PetscFunctionReturn(PETSC_SUCCESS);
}
