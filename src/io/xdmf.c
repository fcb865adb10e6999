/*
  XDMF 3: a text file that describes the HDF5 files to ParaView as a time series of point clouds.
  Each particle is a vertex. Ids are the numbers from 0 to N - 1 and therefore serve as the list of
  vertices, which ParaView's XDMF 3 reader requires.
*/
#include "xdmf.h"

#define XDMF_DOUBLE "NumberType=\"Float\" Precision=\"8\""
#define XDMF_INT32  "NumberType=\"Int\" Precision=\"4\""
#define XDMF_INT64  "NumberType=\"Int\" Precision=\"8\""

/* Writes a data item: a data set in the file of a snapshot. */
static void XdmfItem(FILE *f, const char indent[], const char file[], const char set[],
                     const char type[], PetscInt N, PetscInt columns)
{
  fprintf(f, "%s<DataItem Format=\"HDF\" %s Dimensions=\"%" PetscInt_FMT, indent, type, N);
  if (columns) fprintf(f, " %" PetscInt_FMT, columns);
  fprintf(f, "\">%s:/%s</DataItem>\n", file, set);
}

/* Writes a field of particles; type: ParaView's type of the field. */
static void XdmfAttribute(FILE *f, const char file[], const char set[], const char type[],
                          const char number[], PetscInt N, PetscInt columns)
{
  fprintf(f, "        <Attribute Name=\"%s\" AttributeType=\"%s\" Center=\"Node\">\n", set, type);
  XdmfItem(f, "          ", file, set, number, N, columns);
  fprintf(f, "        </Attribute>\n");
}

/* Writes the grid of a snapshot; file names are relative to the index. */
static void XdmfGrid(FILE *f, const char name[], const Particles *p, const Snapshot *snapshot)
{
  const PetscInt N = snapshot->N;
  char           file[PETSC_MAX_PATH_LEN];

  (void)snprintf(file, sizeof(file), "%s_%04d.h5", name, (int)snapshot->number);
  fprintf(f, "      <Grid Name=\"%s_%04d\" GridType=\"Uniform\">\n", name, (int)snapshot->number);
  fprintf(f, "        <Time Value=\"%.17g\"/>\n", (double)snapshot->t);
  fprintf(f, "        <Topology TopologyType=\"Polyvertex\" NodesPerElement=\"1\" ");
  fprintf(f, "NumberOfElements=\"%" PetscInt_FMT "\">\n", N);
  XdmfItem(f, "          ", file, "id", XDMF_INT64, N, 0);
  fprintf(f, "        </Topology>\n");
  fprintf(f, "        <Geometry GeometryType=\"%s\">\n", p->dim == 2 ? "XY" : "XYZ");
  XdmfItem(f, "          ", file, "position", XDMF_DOUBLE, N, p->dim);
  fprintf(f, "        </Geometry>\n");
  XdmfAttribute(f, file, "velocity", "Vector", XDMF_DOUBLE, N, p->dim);
  if (p->p) XdmfAttribute(f, file, "pressure", "Scalar", XDMF_DOUBLE, N, 0);
  if (p->nu) XdmfAttribute(f, file, "viscosity", "Scalar", XDMF_DOUBLE, N, 0);
  XdmfAttribute(f, file, "type", "Scalar", XDMF_INT32, N, 0);
  XdmfAttribute(f, file, "id", "Scalar", XDMF_INT64, N, 0);
  fprintf(f, "      </Grid>\n");
}

/*
  XdmfWrite - Writes base.xdmf, under another name first, so that it is complete at any time

  Not collective: called by the first rank.

  Input Parameters:
+ base      - path of the snapshots without _0000.h5
. p         - particles with the fields of the snapshots
. n         - number of snapshots
- snapshots - complete snapshots on disk

  Output Parameter:
. good - flag: the file has been written
*/
PetscErrorCode XdmfWrite(const char base[], const Particles *p, PetscInt n,
                         const Snapshot snapshots[], PetscBool *good)
{
  char  path[PETSC_MAX_PATH_LEN], part[PETSC_MAX_PATH_LEN];
  char *name;
  FILE *f;
  int   status;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s.xdmf", base));
  PetscCall(PetscSNPrintf(part, sizeof(part), "%s.xdmf.part", base));
  PetscCall(PetscStrrchr(base, '/', &name)); /* the whole of base if it has no slash */
  *good = PETSC_FALSE;
  f     = fopen(part, "w");
  if (!f) PetscFunctionReturn(PETSC_SUCCESS);
  fprintf(f, "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n  <Domain>\n");
  fprintf(f, "    <Grid Name=\"%s\" GridType=\"Collection\" CollectionType=\"Temporal\">\n", name);
  for (PetscInt k = 0; k < n; k++) XdmfGrid(f, name, p, &snapshots[k]);
  fprintf(f, "    </Grid>\n  </Domain>\n</Xdmf>\n");
  status = ferror(f);
  if (fclose(f) || status || rename(part, path)) PetscFunctionReturn(PETSC_SUCCESS);
  *good = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}
