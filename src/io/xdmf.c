/* XDMF 3: a text file that describes the HDF5 files to ParaView as a time series of point clouds.
   Each particle is a vertex of the list that vtkgroup.c writes. Vectors have three columns, as VTK
   requires. */
#include "snapshot.h"

#define XDMF_DOUBLE "NumberType=\"Float\" Precision=\"8\""
#define XDMF_INT32  "NumberType=\"Int\" Precision=\"4\""
#define XDMF_INT64  "NumberType=\"Int\" Precision=\"8\""

/* Writes a name with the entities of XML for its marks. */
static void XmlName(const char name[], size_t length, char text[])
{
  static const char *const entities[] = {"&&amp;", "<&lt;", ">&gt;", "\"&quot;"};
  size_t                   n          = 0;

  for (; *name && n + 8 < length; name++) {
    const char *entity = NULL;

    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(entities); k++)
      if (*name == entities[k][0]) entity = entities[k] + 1;
    if (entity) n += (size_t)snprintf(text + n, length - n, "%s", entity);
    else text[n++] = *name;
  }
  text[n] = '\0';
}

/* Writes a data item, which refers to a data set in the file of a snapshot. */
static void XdmfItem(FILE *f, const char indent[], const char file[], const char set[],
                     const char type[], PetscInt N, PetscInt columns)
{
  fprintf(f, "%s<DataItem Format=\"HDF\" %s Dimensions=\"%" PetscInt_FMT, indent, type, N);
  if (columns) fprintf(f, " %" PetscInt_FMT, columns);
  fprintf(f, "\">%s:/%s</DataItem>\n", file, set);
}

/* Writes a field of particles. */
static void XdmfAttribute(FILE *f, const char file[], const Flow *flow, const SnapshotField *field,
                          PetscInt N)
{
  const PetscBool vector = SnapshotColumns(flow, field) > 0;
  const char     *type   = field->shape == FIELD_LABEL ? XDMF_INT32
                           : field->shape == FIELD_ID  ? XDMF_INT64
                                                       : XDMF_DOUBLE;
  char            set[64];

  (void)snprintf(set, sizeof(set), "%s%s", vector ? "VTKHDF/PointData/" : "", field->name);
  fprintf(f, "        <Attribute Name=\"%s\" AttributeType=\"%s\" Center=\"Node\">\n", field->name,
          vector ? "Vector" : "Scalar");
  XdmfItem(f, "          ", file, set, type, N, vector ? 3 : 0);
  fprintf(f, "        </Attribute>\n");
}

/* Writes the grid of a snapshot; file names, in which marks are entities, are relative to the
   index. */
static void XdmfGrid(FILE *f, const char name[], const Flow *flow, const Snapshot *snapshot)
{
  const PetscInt N = snapshot->N, dim = flow->particles->dim;
  char           file[2 * PETSC_MAX_PATH_LEN];
  PetscInt       k = 0;
  SnapshotField  field;

  (void)SnapshotNext(flow, &k, &field);
  (void)snprintf(file, sizeof(file), "%s_%04d.h5", name, (int)snapshot->number);
  fprintf(f, "      <Grid Name=\"%s_%04d\" GridType=\"Uniform\">\n", name, (int)snapshot->number);
  fprintf(f, "        <Time Value=\"%.17g\"/>\n", (double)snapshot->t);
  fprintf(f, "        <Topology TopologyType=\"Polyvertex\" NodesPerElement=\"1\" ");
  fprintf(f, "NumberOfElements=\"%" PetscInt_FMT "\">\n", N);
  XdmfItem(f, "          ", file, "VTKHDF/Connectivity", XDMF_INT64, N, 0);
  fprintf(f, "        </Topology>\n");
  fprintf(f, "        <Geometry GeometryType=\"%s\">\n", dim == 2 ? "XY" : "XYZ");
  XdmfItem(f, "          ", file, field.name, XDMF_DOUBLE, N, dim);
  fprintf(f, "        </Geometry>\n");
  while (SnapshotNext(flow, &k, &field)) XdmfAttribute(f, file, flow, &field, N);
  fprintf(f, "      </Grid>\n");
}

/* XdmfWrite - Writes the index base.xdmf under another name and renames it, so that it is complete
   at any time. Not collective: called by the first rank. Input: base - path of the snapshots
   without _0000.h5; flow - the flow, with the fields of the snapshots; n - number of snapshots;
   snapshots - complete snapshots on disk. Output: good - true if the file has been written. */
PetscErrorCode XdmfWrite(const char base[], const Flow *flow, PetscInt n,
                         const Snapshot snapshots[], PetscBool *good)
{
  char  path[PETSC_MAX_PATH_LEN], part[PETSC_MAX_PATH_LEN], text[PETSC_MAX_PATH_LEN - 32];
  char *name;
  FILE *f;
  int   status;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s.xdmf", base));
  PetscCall(PetscSNPrintf(part, sizeof(part), "%s.xdmf.part", base));
  PetscCall(PetscStrrchr(base, '/', &name)); /* the whole of base if it has no slash */
  XmlName(name, sizeof(text), text);
  *good = PETSC_FALSE;
  f     = FileOpen(part, "w");
  if (!f) PetscFunctionReturn(PETSC_SUCCESS);
  fprintf(f, "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n  <Domain>\n");
  fprintf(f, "    <Grid Name=\"%s\" GridType=\"Collection\" CollectionType=\"Temporal\">\n", text);
  for (PetscInt k = 0; k < n; k++) XdmfGrid(f, text, flow, &snapshots[k]);
  fprintf(f, "    </Grid>\n  </Domain>\n</Xdmf>\n");
  status = ferror(f);
  if (fclose(f) || status || !FileReplace(part, path)) PetscFunctionReturn(PETSC_SUCCESS);
  *good = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}
