/*
  XDMF 3: a small text file that tells ParaView what the HDF5 files hold, as a collection in time of
  point clouds. Vectors have three components there, so those of plane flows get a zero.
*/
#include "xdmf.h"

/* One data item: a data set of the snapshot's file. */
static void XdmfItem(FILE *f, const char indent[], const char file[], const char set[],
                     const char type[], PetscInt N, PetscInt columns)
{
  fprintf(f, "%s<DataItem Format=\"HDF\" %s Dimensions=\"%" PetscInt_FMT, indent, type, N);
  if (columns) fprintf(f, " %" PetscInt_FMT, columns);
  fprintf(f, "\">%s:/%s</DataItem>\n", file, set);
}

/* Component c of a vector of two, as a slab of the data set. */
static void XdmfComponent(FILE *f, const char file[], const char set[], PetscInt N, PetscInt c)
{
  fprintf(f, "            <DataItem ItemType=\"HyperSlab\" Dimensions=\"%" PetscInt_FMT " 1\">\n",
          N);
  fprintf(f, "              <DataItem Format=\"XML\" Dimensions=\"3 2\">0 %" PetscInt_FMT, c);
  fprintf(f, " 1 1 %" PetscInt_FMT " 1</DataItem>\n", N);
  XdmfItem(f, "              ", file, set, "NumberType=\"Float\" Precision=\"8\"", N, 2);
  fprintf(f, "            </DataItem>\n");
}

/* A vector; in 2D (u, v, 0). */
static void XdmfVector(FILE *f, const char file[], const char set[], PetscInt dim, PetscInt N)
{
  fprintf(f, "        <Attribute Name=\"%s\" AttributeType=\"Vector\" Center=\"Node\">\n", set);
  if (dim == 3) {
    XdmfItem(f, "          ", file, set, "NumberType=\"Float\" Precision=\"8\"", N, 3);
  } else {
    fprintf(f, "          <DataItem ItemType=\"Function\" Dimensions=\"%" PetscInt_FMT " 3\" ", N);
    fprintf(f, "Function=\"JOIN($0, $1, 0 * $1)\">\n");
    XdmfComponent(f, file, set, N, 0);
    XdmfComponent(f, file, set, N, 1);
    fprintf(f, "          </DataItem>\n");
  }
  fprintf(f, "        </Attribute>\n");
}

static void XdmfScalar(FILE *f, const char file[], const char set[], const char type[], PetscInt N)
{
  fprintf(f, "        <Attribute Name=\"%s\" AttributeType=\"Scalar\" Center=\"Node\">\n", set);
  XdmfItem(f, "          ", file, set, type, N, 0);
  fprintf(f, "        </Attribute>\n");
}

/* The grid of one snapshot; file names are relative to the index. */
static void XdmfGrid(FILE *f, const char name[], PetscInt dim, PetscBool pressure,
                     const Snapshot *snapshot)
{
  const PetscInt N = snapshot->N;
  char           file[PETSC_MAX_PATH_LEN];

  (void)snprintf(file, sizeof(file), "%s_%04d.h5", name, (int)snapshot->number);
  fprintf(f, "      <Grid Name=\"%s_%04d\" GridType=\"Uniform\">\n", name, (int)snapshot->number);
  fprintf(f, "        <Time Value=\"%.17g\"/>\n", (double)snapshot->t);
  fprintf(f, "        <Topology TopologyType=\"Polyvertex\" NodesPerElement=\"1\" ");
  fprintf(f, "NumberOfElements=\"%" PetscInt_FMT "\"/>\n", N);
  fprintf(f, "        <Geometry GeometryType=\"%s\">\n", dim == 2 ? "XY" : "XYZ");
  XdmfItem(f, "          ", file, "position", "NumberType=\"Float\" Precision=\"8\"", N, dim);
  fprintf(f, "        </Geometry>\n");
  XdmfVector(f, file, "velocity", dim, N);
  if (pressure) XdmfScalar(f, file, "pressure", "NumberType=\"Float\" Precision=\"8\"", N);
  XdmfScalar(f, file, "type", "NumberType=\"Int\" Precision=\"4\"", N);
  XdmfScalar(f, file, "id", "NumberType=\"Int\" Precision=\"8\"", N);
  fprintf(f, "      </Grid>\n");
}

/*
  XdmfWrite - Writes base.xdmf, first under another name so that it is complete at any time

  Not collective: called by the first rank.

  Input Parameters:
+ base      - path of the snapshots without _0000.h5
. dim       - 2 or 3
. pressure  - whether the snapshots hold pressures
. n         - how many
- snapshots - those complete on disk

  Output Parameter:
. good - whether the file could be written
*/
PetscErrorCode XdmfWrite(const char base[], PetscInt dim, PetscBool pressure, PetscInt n,
                         const Snapshot snapshots[], PetscBool *good)
{
  char  path[PETSC_MAX_PATH_LEN], part[PETSC_MAX_PATH_LEN];
  char *name;
  FILE *f;
  int   status;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s.xdmf", base));
  PetscCall(PetscSNPrintf(part, sizeof(part), "%s.xdmf.part", base));
  PetscCall(PetscStrrchr(base, '/', &name)); /* all of base where it has no slash */
  *good = PETSC_FALSE;
  f     = fopen(part, "w");
  if (!f) PetscFunctionReturn(PETSC_SUCCESS);
  fprintf(f, "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n  <Domain>\n");
  fprintf(f, "    <Grid Name=\"%s\" GridType=\"Collection\" CollectionType=\"Temporal\">\n", name);
  for (PetscInt k = 0; k < n; k++) XdmfGrid(f, name, dim, pressure, &snapshots[k]);
  fprintf(f, "    </Grid>\n  </Domain>\n</Xdmf>\n");
  status = ferror(f);
  if (fclose(f) || status || rename(part, path)) PetscFunctionReturn(PETSC_SUCCESS);
  *good = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}
